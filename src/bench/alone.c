#include "bench/alone.h"

#include <string.h>

#include "study/child.h"

/* A measurement takes a few seconds at the most; one that hangs is ended. */
static const double most_seconds = 60;

typedef struct message {
    dl_status status;
    dl_error error;
    max_align_t result[DL_BENCH_MOST_RESULT / sizeof(max_align_t)];
} message;

typedef struct measurement {
    dl_bench_work *work;
    const void *what;
    message found;
} measurement;

static void work_alone(void *context, int pipe) {
    measurement *const one = context;
    one->found.status = one->work(one->what, one->found.result, &one->found.error);
    dl_child_send(pipe, &one->found, sizeof one->found);
}

static dl_status receive(void *context, const void *data, size_t size, dl_error *error) {
    message *const found = &((measurement *)context)->found;
    if (size != sizeof *found)
        return dl_fail(error, DL_ERROR, "a measurement's answer has %zu bytes, expected %zu", size,
                       sizeof *found);
    memcpy(found, data, size);
    return DL_OK;
}

dl_status dl_bench_alone(dl_bench_work *work, const void *what, void *result, size_t size,
                         dl_error *error) {
    measurement one = {.work = work, .what = what, .found = {.status = DL_ERROR}};
    const dl_child_work child = {
        .work = work_alone, .receive = receive, .context = &one, .seconds = most_seconds};
    const dl_status status = dl_child_run(&child, error);
    if (status)
        return status;
    if (one.found.status)
        return dl_fail(error, one.found.status, "%s", one.found.error.message);
    memcpy(result, one.found.result, size);
    return DL_OK;
}
