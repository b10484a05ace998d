/* References: a tight run whose own error a second one measures, or the exact solution. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "study/child.h"
#include "study/kepler.h"
#include "study/measure.h"

typedef struct reference_work {
    const dl_study *study;
    const dl_study_scene *on;
    const dl_watch *watch;
    double *time;     /* [samples] */
    double *position; /* [samples][stride] of the run under way */
    size_t samples, room, stride;
    unsigned received;
    dl_reference *reference; /* parent */
} reference_work;

/* A message: how the run ended and, after it, times and positions. */
typedef struct message {
    dl_status status;
    dl_error error;
    size_t samples;
} message;

static dl_status keep_sample(void *context, const dl_sample *sample, dl_error *error) {
    reference_work *work = context;
    if (work->samples == work->room)
        return dl_fail(error, DL_ERROR, "more samples than the %zu that were asked for",
                       work->room);
    work->time[work->samples] = sample->time;
    memcpy(work->position + work->samples * work->stride, sample->y_all,
           work->stride * sizeof(double));
    work->samples++;
    return DL_OK;
}

/* The run's own message lies in *bytes, its samples behind it. */
static void run_and_send(reference_work *work, const dl_study_run_of *run, char *bytes, int pipe) {
    message *sent = (message *)(void *)bytes;
    dl_run_options options;
    dl_run_options_default(&options);
    options.end = work->on->end;
    options.sample = work->on->sample;
    options.time_limit = work->study->reference_seconds;
    options.on_sample = keep_sample;
    options.context = work;
    work->samples = 0;
    dl_run_summary summary;
    sent->status = work->study->run(work->on->scene, run->row, run->options, &options, &summary,
                                    NULL, &sent->error);
    if (sent->status == DL_OK && summary.status != DL_OK) {
        sent->status = summary.status;
        memcpy(sent->error.message, summary.message, sizeof summary.message);
    }
    sent->samples = work->samples;
    /* times come before positions; both arrays have room for more samples than there may be */
    memmove(work->time + work->samples, work->position,
            work->samples * work->stride * sizeof(double));
    dl_child_send(pipe, bytes, sizeof *sent + work->samples * (1 + work->stride) * sizeof(double));
}

static void work_on_reference(void *context, int pipe) {
    reference_work *work = context;
    const size_t doubles = work->room * (1 + work->stride);
    char *bytes = malloc(sizeof(message) + doubles * sizeof(double));
    if (!bytes)
        return;
    work->time = (double *)(void *)(bytes + sizeof(message));
    work->position = work->time + work->room;
    run_and_send(work, &work->on->reference, bytes, pipe);
    run_and_send(work, &work->on->check, bytes, pipe);
    free(bytes);
}

/* --- in the parent ------------------------------------------------------------------------- */

static dl_status allocate(const dl_study *study, const dl_study_scene *on, dl_reference *reference,
                          dl_error *error) {
    const dl_scene *scene = on->scene;
    const size_t samples = (size_t)study->settings.samples + 1;
    *reference = (dl_reference){
        .key = dl_text("%s", on->reference_key),
        .scene = dl_text("%s", scene->name),
        .description = dl_text("%s", on->reference_text),
        .samples = samples,
        .particles = scene->particles,
        .dimension = scene->dimension,
        .time = calloc(samples, sizeof(double)),
        .sample_error = calloc(samples, sizeof(double)),
        .position = calloc(samples * (size_t)scene->dimension * scene->particles, sizeof(double)),
    };
    return reference->key && reference->scene && reference->description && reference->time &&
                   reference->sample_error && reference->position
               ? DL_OK
               : dl_fail_memory(error, "a reference");
}

static dl_status receive(void *context, const void *data, size_t size, dl_error *error) {
    reference_work *work = context;
    dl_reference *reference = work->reference;
    const dl_study_run_of *run = work->received ? &work->on->check : &work->on->reference;
    message found;
    if (size < sizeof found)
        return dl_fail(error, DL_ERROR, "the reference's process sent too little");
    memcpy(&found, data, sizeof found);
    if (found.status == DL_OK && found.samples != reference->samples)
        found.status = dl_fail(&found.error, DL_ERROR, "%zu samples instead of %zu", found.samples,
                               reference->samples);
    if (found.status != DL_OK)
        return dl_fail(error, DL_ERROR, "%s %s: %s: %.700s", run->row->name, run->text,
                       dl_status_name(found.status), found.error.message);
    const double *time = (const double *)(const void *)((const char *)data + sizeof found);
    const double *position = time + found.samples;
    if (work->received++ == 0) {
        memcpy(reference->time, time, found.samples * sizeof *time);
        memcpy(reference->position, position, found.samples * work->stride * sizeof *position);
        return DL_OK;
    }
    for (size_t i = 0; i < found.samples; i++)
        reference->sample_error[i] =
            dl_position_distance(work->on->scene, reference->position + i * work->stride,
                                 position + i * work->stride, NULL);
    reference->error = reference->sample_error[found.samples - 1];
    return DL_OK;
}

static void tick(void *context) {
    const reference_work *work = context;
    if (work->watch->tick)
        work->watch->tick(work->watch->context);
}

static dl_status run_reference(reference_work *work, dl_error *error) {
    const dl_child_work child = {
        .work = work_on_reference,
        .receive = receive,
        .tick = tick,
        .context = work,
        .seconds = work->study->reference_seconds,
        .memory = work->study->limits.memory,
        .interrupt = work->watch->interrupt,
    };
    dl_status status = dl_child_run(&child, error);
    if (status == DL_OK && work->received != 2)
        status = dl_fail(error, DL_ERROR, "its process ended without a result");
    return status;
}

static dl_status solve_exactly(const dl_study_scene *on, dl_reference *reference, dl_error *error) {
    const size_t stride = (size_t)on->scene->dimension * 2;
    dl_status status = DL_OK;
    for (size_t i = 0; i < reference->samples && status == DL_OK; i++) {
        /* as dl_schedule_time has it */
        reference->time[i] = i + 1 == reference->samples ? on->end : (double)i * on->sample;
        status = dl_kepler_position(on->scene, reference->time[i], reference->position + i * stride,
                                    error);
    }
    return status;
}

dl_status dl_study_measure_reference(const dl_study *study, const dl_study_scene *on,
                                     const dl_watch *watch, dl_reference *reference,
                                     dl_error *error) {
    dl_error why = {""};
    dl_status status = allocate(study, on, reference, error);
    if (status != DL_OK) {
        dl_reference_release(reference);
        return status;
    }
    reference_work work = {
        .study = study,
        .on = on,
        .watch = watch,
        .reference = reference,
        .room = reference->samples + 1,
        .stride = (size_t)on->scene->dimension * on->scene->particles,
    };
    status = study->reference == DL_REFERENCE_EXACT ? solve_exactly(on, reference, &why)
                                                    : run_reference(&work, &why);
    if (status == DL_OK)
        return DL_OK;
    dl_reference_release(reference);
    return dl_fail(error, status, "%s: the reference of %s failed: %.900s", study->path,
                   on->scene->name, why.message);
}
