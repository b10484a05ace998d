/* References: extended precision, or a tight run whose own error a second one measures, or the
 * exact solution. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "reference/horizon.h"
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
        .precision = dl_text("%s", study->reference == DL_REFERENCE_EXACT ? "exact" : ""),
        .note = dl_text("%s", ""),
        .samples = samples,
        .particles = scene->particles,
        .dimension = scene->dimension,
        .time = calloc(samples, sizeof(double)),
        .sample_error = calloc(samples, sizeof(double)),
        .growth = calloc(samples, sizeof(double)),
        .position = calloc(samples * (size_t)scene->dimension * scene->particles, sizeof(double)),
        .position_low =
            calloc(samples * (size_t)scene->dimension * scene->particles, sizeof(double)),
    };
    return reference->key && reference->scene && reference->description && reference->precision &&
                   reference->note && reference->time && reference->sample_error &&
                   reference->growth && reference->position && reference->position_low
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
            dl_reference_distance(work->on->scene, reference, i, position + i * work->stride, NULL);
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
                                    reference->position_low + i * stride, error);
    }
    return status;
}

/* A run of a method and its check, or the exact solution. */
static dl_status measure_in_double(const dl_study *study, const dl_study_scene *on,
                                   const dl_watch *watch, dl_reference *reference,
                                   dl_error *error) {
    dl_status status = allocate(study, on, reference, error);
    reference_work work = {
        .study = study,
        .on = on,
        .watch = watch,
        .reference = reference,
        .room = reference->samples + 1,
        .stride = (size_t)on->scene->dimension * on->scene->particles,
    };
    if (status == DL_OK)
        status = study->reference == DL_REFERENCE_EXACT ? solve_exactly(on, reference, error)
                                                        : run_reference(&work, error);
    if (status == DL_OK && study->reference == DL_REFERENCE_RUNS)
        status = dl_reference_length(on->scene, &reference->length, error);
    if (status == DL_OK)
        dl_reference_set_horizon(on->scene, reference, NULL, 1, DBL_EPSILON);
    else
        dl_reference_release(reference);
    return status;
}

static dl_status measure_extended(const dl_study *study, const dl_study_scene *on,
                                  const dl_watch *watch, dl_precision precision,
                                  dl_reference *reference, dl_error *error) {
    const bool asks_position = strcmp(dl_study_measures[study->settings.asked_in], "position") == 0;
    const dl_reference_request request = {
        .precision = precision,
        .end = on->end,
        .intervals = (size_t)study->settings.samples,
        .wanted = asks_position ? study->settings.asked_error / DL_REFERENCE_MARGIN : 0,
        .seconds = study->reference_seconds,
        .memory = study->limits.memory,
        .interrupt = watch->interrupt,
        .on_tick = watch->tick,
        .context = watch->context,
    };
    dl_status status = dl_reference_compute(on->scene, &request, reference, error);
    if (status != DL_OK)
        return status;
    reference->key = dl_text("%s", on->reference_key);
    reference->scene = dl_text("%s", on->scene->name);
    return reference->key && reference->scene ? DL_OK : dl_fail_memory(error, "a reference");
}

static dl_status seal(dl_reference *reference, dl_error *error) {
    free(reference->digest);
    reference->digest = dl_reference_digest(reference);
    return reference->digest ? DL_OK : dl_fail_memory(error, "a reference");
}

static dl_status measure(const dl_study *study, const dl_study_scene *on, const dl_watch *watch,
                         dl_precision precision, dl_reference *reference, dl_error *error) {
    dl_error why = {""};
    *reference = (dl_reference){0};
    dl_status status = study->reference == DL_REFERENCE_EXTENDED
                           ? measure_extended(study, on, watch, precision, reference, &why)
                           : measure_in_double(study, on, watch, reference, &why);
    if (status == DL_OK)
        status = seal(reference, &why);
    if (status == DL_OK)
        return DL_OK;
    dl_reference_release(reference);
    return dl_fail(error, status, "%s: the reference of %s failed: %.900s", study->path,
                   on->scene->name, why.message);
}

dl_status dl_study_measure_reference(const dl_study *study, const dl_study_scene *on,
                                     const dl_watch *watch, dl_reference *reference,
                                     dl_error *error) {
    return measure(study, on, watch, study->precision, reference, error);
}

dl_status dl_study_improve_reference(const dl_study *study, const dl_study_scene *on,
                                     const dl_watch *watch, dl_reference *reference, bool *improved,
                                     dl_error *error) {
    char text[DL_MESSAGE_SIZE];
    dl_error why = {""};
    dl_reference better;
    *improved = false;
    if (!dl_reference_quad_is_too_slow(reference, study->reference_seconds, text, sizeof text)) {
        const dl_status status = measure(study, on, watch, DL_PRECISION_QUAD, &better, &why);
        if (status == DL_OK) {
            dl_reference_release(reference);
            *reference = better;
            *improved = true;
            return DL_OK;
        }
        if (status == DL_INTERRUPTED || status == DL_MEMORY)
            return dl_fail(error, status, "%s", why.message);
        snprintf(text, sizeof text, "%.900s", why.message);
    }
    free(reference->note);
    reference->note = dl_text("%s", text);
    return reference->note ? seal(reference, error) : dl_fail_memory(error, "a reference");
}
