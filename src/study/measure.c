#include "study/measure.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "study/child.h"

/* --- in the child -------------------------------------------------------------------------- */

typedef enum part { OBSERVED, TIMED } part;

/* What is kept of every sample. */
typedef enum series { TIME, ENERGY, POSITION, MOMENTUM, ANGULAR_MOMENTUM, SERIES } series;

/* First message: this and the series, one after the other. Those that follow: this with the
 * summary of a timing run. */
typedef struct message {
    part part;
    dl_run_summary summary;
    double position_error, position_error_max, position_error_ever;
    size_t samples;
} message;

typedef struct case_work {
    const dl_study *study;
    const dl_study_case *cased;
    const dl_reference *reference;
    const dl_watch *watch;
    /* child */
    message found;
    double *series; /* [SERIES][room] */
    size_t room;
    /* parent */
    dl_case *measured;
    double *seconds; /* [repeats] */
    size_t timed;
} case_work;

static double *kept(const case_work *work, series of) {
    return work->series + (size_t)of * work->room;
}

static void compare_with_reference(case_work *work, const dl_sample *sample, size_t i) {
    const dl_reference *reference = work->reference;
    message *found = &work->found;
    kept(work, POSITION)[i] = found->position_error = found->position_error_max = NAN;
    if (!reference || i >= reference->samples ||
        fabs(reference->time[i] - sample->time) > 1e-9 * reference->time[reference->samples - 1])
        return;
    const dl_scene *scene = work->study->scene[work->cased->scene].scene;
    const double error =
        dl_reference_distance(scene, reference, i, sample->y_all, &found->position_error_max);
    kept(work, POSITION)[i] = found->position_error = error;
    if (!dl_reference_is_past(reference, i) &&
        !(error <= found->position_error_ever)) /* NaN at first: none yet */
        found->position_error_ever = error;
}

static dl_status keep_sample(void *context, const dl_sample *sample, dl_error *error) {
    case_work *work = context;
    const size_t i = work->found.samples;
    if (i == work->room)
        return dl_fail(error, DL_ERROR, "more samples than the %zu that were asked for",
                       work->room);
    kept(work, TIME)[i] = sample->time;
    kept(work, ENERGY)[i] = sample->energy_error;
    kept(work, MOMENTUM)[i] = sample->momentum_error;
    kept(work, ANGULAR_MOMENTUM)[i] = sample->angular_momentum_error;
    compare_with_reference(work, sample, i);
    work->found.samples = i + 1;
    return DL_OK;
}

static dl_status allocate_series(case_work *work, dl_error *error) {
    /* The start, the intervals, and the last state of a run that ends early. */
    work->room = (size_t)work->study->settings.samples + 2;
    work->series = malloc(SERIES * work->room * sizeof *work->series);
    return work->series ? DL_OK : dl_fail_memory(error, "samples");
}

static void send_observed(case_work *work, int pipe) {
    const size_t samples = work->found.samples, size = samples * sizeof(double);
    char *bytes = malloc(sizeof work->found + SERIES * size);
    if (!bytes) {
        work->found.samples = 0;
        dl_child_send(pipe, &work->found, sizeof work->found);
        return;
    }
    char *to = bytes;
    memcpy(to, &work->found, sizeof work->found);
    to += sizeof work->found;
    for (series k = 0; k < SERIES && samples > 0; k++, to += size)
        memcpy(to, kept(work, k), size);
    dl_child_send(pipe, bytes, sizeof work->found + SERIES * size);
    free(bytes);
}

/* A run that could not start tells why in its summary. */
static void run_once(const case_work *work, const dl_run_options *options,
                     dl_run_summary *summary) {
    const dl_study_run_of *run = &work->cased->run;
    const dl_scene *scene = work->study->scene[work->cased->scene].scene;
    dl_error error = {""};
    dl_status status =
        work->study->run(scene, run->row, run->options, options, summary, NULL, &error);
    if (status != DL_OK) {
        summary->status = status;
        memcpy(summary->message, error.message, sizeof summary->message);
    }
}

static dl_run_options options_of(const dl_study *study, const dl_study_scene *on) {
    dl_run_options options;
    dl_run_options_default(&options);
    options.end = on->end;
    options.sample = on->sample;
    options.time_limit = study->limits.seconds;
    return options;
}

static void work_on_case(void *context, int pipe) {
    case_work *work = context;
    dl_error error = {""};
    dl_run_options options = options_of(work->study, &work->study->scene[work->cased->scene]);
    options.on_sample = keep_sample;
    options.context = work;
    work->found = (message){.part = OBSERVED,
                            .position_error = NAN,
                            .position_error_max = NAN,
                            .position_error_ever = NAN};
    dl_status status = allocate_series(work, &error);
    if (status == DL_OK) {
        run_once(work, &options, &work->found.summary);
    } else {
        work->found.summary.status = status;
        memcpy(work->found.summary.message, error.message, sizeof error.message);
    }
    send_observed(work, pipe);
    free(work->series);
    options.observe = false;
    options.on_sample = NULL;
    message timed = {.part = TIMED, .summary = work->found.summary};
    for (long i = 1; i < work->study->settings.repeats && timed.summary.status == DL_OK; i++) {
        run_once(work, &options, &timed.summary);
        dl_child_send(pipe, &timed, sizeof timed);
    }
}

/* --- in the parent ------------------------------------------------------------------------- */

static double *copy_series(const char *bytes, size_t samples) {
    double *copy = malloc(samples * sizeof *copy + 1);
    if (copy)
        memcpy(copy, bytes, samples * sizeof *copy);
    return copy;
}

static bool is_known(const double *values, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!isnan(values[i]))
            return true;
    return false;
}

static dl_status receive_observed(dl_case *measured, const message *found, const char *bytes,
                                  dl_error *error) {
    const size_t samples = found->samples;
    const struct {
        series from;
        double **to;
        bool is_always;
    } table[] = {
        {TIME, &measured->sample_time, true},
        {ENERGY, &measured->sample_energy_error, true},
        {POSITION, &measured->sample_position_error, true},
        {MOMENTUM, &measured->sample_momentum_error, false},
        {ANGULAR_MOMENTUM, &measured->sample_angular_momentum_error, false},
    };
    measured->summary = found->summary;
    measured->position_error_ever = found->position_error_ever;
    if (found->summary.status == DL_OK) {
        measured->position_error = found->position_error;
        measured->position_error_max = found->position_error_max;
    }
    for (size_t k = 0; k < sizeof table / sizeof *table; k++) {
        double **to = table[k].to;
        *to = copy_series(bytes + (size_t)table[k].from * samples * sizeof **to, samples);
        if (!*to)
            return dl_fail_memory(error, "samples");
        if (!table[k].is_always && !is_known(*to, samples)) {
            free(*to);
            *to = NULL;
        }
    }
    measured->samples = samples;
    return DL_OK;
}

static dl_status receive(void *context, const void *data, size_t size, dl_error *error) {
    case_work *work = context;
    message found;
    if (size < sizeof found)
        return dl_fail(error, DL_ERROR, "a case's process sent too little");
    memcpy(&found, data, sizeof found);
    dl_status status = DL_OK;
    if (found.part == OBSERVED)
        status = receive_observed(work->measured, &found, (const char *)data + sizeof found, error);
    if (status == DL_OK && found.summary.status == DL_OK &&
        work->timed < (size_t)work->study->settings.repeats)
        work->seconds[work->timed++] = found.summary.cpu_seconds;
    return status;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void set_times(dl_case *measured, double *seconds, size_t timed) {
    measured->repeats = (unsigned)timed;
    measured->cpu_median = measured->summary.cpu_seconds;
    if (timed == 0)
        return;
    qsort(seconds, timed, sizeof *seconds, ascending);
    measured->summary.cpu_seconds = seconds[0];
    measured->cpu_median =
        timed % 2 ? seconds[timed / 2] : (seconds[timed / 2 - 1] + seconds[timed / 2]) / 2;
}

/* The child has ended, however it did. A limit that only a repeat for the time has met leaves the
 * observed run as it is. */
static dl_status conclude(case_work *work, dl_status ended, const char *why, dl_error *error) {
    dl_case *measured = work->measured;
    const bool observed = measured->sample_time != NULL;
    if (ended == DL_OK && !observed) {
        ended = DL_ERROR;
        why = "its process ended without a result";
    }
    if (ended == DL_INTERRUPTED || ended == DL_IO || ended == DL_MEMORY)
        return dl_fail(error, ended, "%s", why);
    if (ended != DL_OK && !(ended == DL_TIMEOUT && observed)) {
        measured->summary.status = ended;
        snprintf(measured->summary.message, sizeof measured->summary.message, "%s", why);
        measured->position_error = measured->position_error_max = NAN;
    }
    return DL_OK;
}

static dl_status identify(const dl_study *study, const dl_study_case *cased, dl_case *measured,
                          dl_error *error) {
    *measured = (dl_case){
        .key = dl_text("%s", cased->key),
        .scene = dl_text("%s", study->scene[cased->scene].scene->name),
        .method = dl_text("%s", cased->run.row->name),
        .family = dl_text("%s", cased->run.row->family),
        .options = dl_text("%s", cased->run.text),
        .command = dl_text("%s", cased->command),
        .position_error = NAN,
        .position_error_max = NAN,
        .position_error_ever = NAN,
        .cpu_median = NAN,
    };
    dl_run_summary_clear(&measured->summary);
    measured->summary.cpu_seconds = NAN;
    return measured->key && measured->scene && measured->method && measured->family &&
                   measured->options && measured->command
               ? DL_OK
               : dl_fail_memory(error, "a case");
}

static void tick(void *context) {
    const case_work *work = context;
    if (work->watch->tick)
        work->watch->tick(work->watch->context);
}

static dl_status run_case(case_work *work, dl_error *error) {
    const dl_study *study = work->study;
    const long repeats = study->settings.repeats;
    work->seconds = malloc((size_t)repeats * sizeof *work->seconds);
    if (!work->seconds)
        return dl_fail_memory(error, "times");
    const dl_child_work child = {
        .work = work_on_case,
        .receive = receive,
        .tick = tick,
        .context = work,
        .seconds = study->limits.seconds,
        .memory = study->limits.memory,
        .interrupt = work->watch->interrupt,
    };
    dl_error why = {""};
    dl_status ended = dl_child_run(&child, &why);
    dl_status status = conclude(work, ended, why.message, error);
    set_times(work->measured, work->seconds, work->timed);
    free(work->seconds);
    return status;
}

dl_status dl_study_measure_case(const dl_study *study, const dl_study_case *cased,
                                const dl_reference *reference, const dl_watch *watch,
                                dl_case *measured, dl_error *error) {
    case_work work = {.study = study,
                      .cased = cased,
                      .reference = reference,
                      .watch = watch,
                      .measured = measured};
    char reason[DL_MESSAGE_SIZE + 64];
    dl_status status = identify(study, cased, measured, error);
    if (status == DL_OK)
        status = run_case(&work, error);
    if (status == DL_OK) {
        dl_study_judge_run(measured, study->scene[cased->scene].end, study->settings.samples,
                           reason, sizeof reason);
        measured->invalid = dl_text("%s", reason);
        dl_study_judge_position(measured, reference, reason, sizeof reason);
        measured->refused = dl_text("%s", reason);
        if (!measured->refused || !measured->invalid)
            status = dl_fail_memory(error, "a case");
    }
    if (status != DL_OK)
        dl_case_release(measured);
    return status;
}
