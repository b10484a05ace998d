/* A unit of a study in its child process. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "observe/stopwatch.h"
#include "study/child.h"
#include "study/kind.h"

/* First byte of a message; what follows is a packed finding, or a text. The other seven keep
 * doubles aligned. */
typedef enum message_kind { FINDING = 'f', PROGRESS = 'p' } message_kind;
enum { head_size = 8 };

typedef struct unit_work {
    const dl_study *study;
    const dl_study_case *cased;
    const dl_watch *watch;
    void (*heard)(void *context, const char *text);
    void *heard_context;
    int pipe; /* child */
    bool received;
    dl_finding *finding;
} unit_work;

static void send(int pipe, message_kind kind, const void *data, size_t size) {
    char *message = calloc(head_size + size, 1);
    if (!message)
        return; /* the parent misses it and says so */
    message[0] = (char)kind;
    memcpy(message + head_size, data, size);
    dl_child_send(pipe, message, head_size + size);
    free(message);
}

static void tell(void *context, const char *text) {
    send(((const unit_work *)context)->pipe, PROGRESS, text, strlen(text) + 1);
}

/* The scene's numbers by name, as quantities "$NAME": what a map over scenes is drawn by. */
static dl_status add_numbers(const dl_scene *scene, dl_finding *finding, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < scene->lets && status == DL_OK; i++) {
        char name[sizeof scene->let[i].name + 1];
        snprintf(name, sizeof name, "$%s", scene->let[i].name);
        status = dl_finding_add(finding, name, scene->let[i].value, NAN, NAN, error);
    }
    return status;
}

static void work_on_unit(void *context, int pipe) {
    unit_work *work = context;
    const dl_study *study = work->study;
    const dl_study_scene *on = &study->scene[work->cased->scene];
    const dl_study_unit unit = {.scene = on->scene,
                                .row = work->cased->run.row,
                                .options = work->cased->run.options,
                                .end = on->end,
                                .sample = on->sample,
                                .sample_chosen = on->sample_chosen,
                                .seconds = study->limits.seconds,
                                .settings = study->kind_settings,
                                .run = study->run,
                                .progress = tell,
                                .context = work};
    dl_error error = {""};
    dl_finding finding;
    void *bytes = NULL;
    size_t size = 0;
    work->pipe = pipe;
    const double began = dl_cpu_clock();
    dl_status status = dl_finding_create(&finding, &error);
    if (status == DL_OK) {
        finding.status = study->kind->measure(&unit, &finding, &error);
        if (finding.status == DL_OK)
            finding.status = add_numbers(on->scene, &finding, &error);
        memcpy(finding.message, error.message, sizeof finding.message);
        finding.cpu_seconds = dl_cpu_clock() - began;
        status = dl_finding_pack(&finding, &bytes, &size, &error);
    }
    if (status == DL_OK)
        send(pipe, FINDING, bytes, size);
    free(bytes);
    dl_finding_release(&finding);
}

static dl_status receive(void *context, const void *data, size_t size, dl_error *error) {
    unit_work *work = context;
    const char *message = data;
    if (size > head_size && message[0] == PROGRESS) {
        if (work->heard)
            work->heard(work->heard_context, message + head_size);
        return DL_OK;
    }
    if (size <= head_size || work->received)
        return dl_fail(error, DL_ERROR, "a unit's process sent what is not expected");
    work->received = true;
    return dl_finding_unpack(message + head_size, size - head_size, work->finding, error);
}

static void tick(void *context) {
    const unit_work *work = context;
    if (work->watch->tick)
        work->watch->tick(work->watch->context);
}

static dl_status set(char **text, const char *value, dl_error *error) {
    free(*text);
    return (*text = dl_text("%s", value)) ? DL_OK : dl_fail_memory(error, "a finding");
}

static dl_status identify(const unit_work *work, dl_error *error) {
    const dl_study_case *cased = work->cased;
    dl_finding *finding = work->finding;
    dl_status status = set(&finding->key, cased->key, error);
    if (status == DL_OK)
        status = set(&finding->scene, work->study->scene[cased->scene].scene->name, error);
    if (status == DL_OK)
        status = set(&finding->method, cased->run.row->name, error);
    if (status == DL_OK)
        status = set(&finding->family, cased->run.row->family, error);
    if (status == DL_OK)
        status = set(&finding->options, cased->run.text, error);
    return status == DL_OK ? set(&finding->command, cased->command, error) : status;
}

/* Without a finding, one that says why. */
static dl_status conclude(unit_work *work, dl_status ended, const char *why, dl_error *error) {
    if (ended == DL_INTERRUPTED || ended == DL_IO || ended == DL_MEMORY)
        return dl_fail(error, ended, "%s", why);
    if (work->received && ended == DL_OK)
        return DL_OK;
    dl_finding_release(work->finding);
    const dl_status status = dl_finding_create(work->finding, error);
    work->finding->status = ended == DL_OK ? DL_ERROR : ended;
    snprintf(work->finding->message, sizeof work->finding->message, "%s",
             ended == DL_OK ? "its process ended without a result" : why);
    return status;
}

dl_status dl_study_measure_unit(const dl_study *study, const dl_study_case *cased,
                                const dl_watch *watch, void (*heard)(void *context, const char *),
                                void *heard_context, dl_finding *finding, dl_error *error) {
    unit_work work = {.study = study,
                      .cased = cased,
                      .watch = watch,
                      .heard = heard,
                      .heard_context = heard_context,
                      .finding = finding};
    const dl_child_work child = {.work = work_on_unit,
                                 .receive = receive,
                                 .tick = tick,
                                 .context = &work,
                                 .seconds = study->limits.seconds,
                                 .memory = study->limits.memory,
                                 .interrupt = watch->interrupt};
    dl_error why = {""};
    *finding = (dl_finding){0};
    const dl_status ended = dl_child_run(&child, &why);
    dl_status status = conclude(&work, ended, why.message, error);
    if (status == DL_OK)
        status = identify(&work, error);
    if (status != DL_OK)
        dl_finding_release(finding);
    return status;
}
