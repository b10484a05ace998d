/* Parts that are measured in one process and kept in another. The message: a status, then the
 * part's bytes or the text of the failure. */
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "study/child.h"
#include "study/parts.h"

enum { head_size = sizeof(double) }; /* keeps what follows aligned */

void dl_part_measure_and_send(const dl_study *study, const dl_results *results, size_t part,
                              const dl_watch *watch, int pipe) {
    dl_study_part measured;
    dl_error why = {""};
    void *bytes = NULL;
    size_t size = 0;
    dl_status status = dl_part_measure(study, results, part, watch, NULL, NULL, &measured, &why);
    if (status == DL_OK) {
        status = dl_part_pack(study, &measured, &bytes, &size, &why);
        dl_part_release(study, &measured);
    }
    const size_t length = status == DL_OK ? size : sizeof why.message;
    char *message = calloc(head_size + length, 1);
    if (!message)
        _exit(EXIT_FAILURE); /* the other process sees to the part */
    memcpy(message, &status, sizeof status);
    memcpy(message + head_size, status == DL_OK ? bytes : why.message, length);
    dl_child_send(pipe, message, head_size + length);
    free(message);
    free(bytes);
}

dl_status dl_part_receive(const dl_study *study, const void *data, size_t size,
                          dl_study_part *measured, dl_error *error) {
    dl_status status;
    const char *rest = (const char *)data + head_size;
    if (size < head_size)
        return dl_fail(error, DL_ERROR, "what another process sent is damaged");
    memcpy(&status, data, sizeof status);
    if (status != DL_OK)
        return dl_fail(error, status, "%.*s", (int)(size - head_size), rest);
    return dl_part_unpack(study, rest, size - head_size, measured, error);
}
