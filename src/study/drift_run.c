/* Runs of the kind `drift`. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/scene.h"
#include "study/drift.h"
#include "study/telling.h"

double dl_drift_option(const dl_method_row *row, const void *options, const char *name) {
    const dl_parameter *option = dl_parameter_find(row->options, name);
    if (!option || option->kind != DL_REAL)
        return NAN;
    return *(const double *)(const void *)((const char *)options + option->offset);
}

static void set_option(const dl_method_row *row, void *options, const char *name, double value) {
    const dl_parameter *option = dl_parameter_find(row->options, name);
    if (option && option->kind == DL_REAL)
        *(double *)(void *)((char *)options + option->offset) = value;
}

dl_drift_knob dl_drift_knob_of(const dl_method_row *row, const void *options) {
    const double step = dl_drift_option(row, options, "step");
    if (step > 0)
        return (dl_drift_knob){.size = step};
    return (dl_drift_knob){.adaptive = true, .size = dl_drift_option(row, options, "rtol")};
}

double dl_drift_interval(const dl_study_unit *unit, const dl_drift_knob *knob) {
    if (knob->adaptive)
        return unit->sample;
    return fmax(1, floor(unit->sample / knob->size * (1 + 1e-9))) * knob->size;
}

dl_status dl_drift_widen_interval(const dl_study_unit *unit, double *interval, dl_error *error) {
    enum { steps_of_a_sample = 3 };
    dl_run_options how;
    dl_run_summary summary;
    dl_run_options_default(&how);
    how.end = how.sample = unit->end;
    how.time_limit = unit->seconds;
    how.observe = false;
    const dl_status status =
        unit->run(unit->scene, unit->row, unit->options, &how, &summary, NULL, error);
    if (status != DL_OK || summary.status != DL_OK)
        return status;
    const double samples = fmax(1, floor((double)summary.steps / steps_of_a_sample));
    *interval = fmax(*interval, unit->end / samples);
    return DL_OK;
}

/* --- one run -----------------------------------------------------------------------------------
 */

typedef struct recorder {
    dl_drift_run *run;
    double interval;
} recorder;

/* Samples off the grid - the end of a run of no whole number of intervals, the last state of one
 * that failed - are left out. */
static dl_status record(void *context, const dl_sample *sample, dl_error *error) {
    const recorder *to = context;
    dl_drift_run *run = to->run;
    const double due = (double)run->n * to->interval;
    if (fabs(sample->time - due) > 1e-6 * to->interval)
        return DL_OK;
    if (run->n == run->room)
        return dl_fail(error, DL_ERROR, "more samples than the %zu expected", run->room);
    run->time[run->n] = sample->time;
    run->energy[run->n] = sample->energy_error;
    run->momentum[run->n] = sample->momentum_error;
    run->angular[run->n] = sample->angular_momentum_error;
    run->n++;
    run->excess = fmax(run->excess, fabs(sample->energy.kinetic) + fabs(sample->energy.pair) +
                                        fabs(sample->energy.gravity));
    return DL_OK;
}

static dl_status make_room(dl_drift_run *run, double intervals, dl_error *error) {
    run->room = (size_t)ceil(intervals) + 2;
    run->time = calloc(run->room, 4 * sizeof *run->time);
    if (!run->time)
        return dl_fail_memory(error, "a series");
    run->energy = run->time + run->room;
    run->momentum = run->energy + run->room;
    run->angular = run->momentum + run->room;
    return DL_OK;
}

/* From absolute errors to parts of a scale; without one (all at rest) they do not apply. */
static void divide(double *error, size_t n, double scale) {
    for (size_t k = 0; k < n; k++)
        error[k] = scale > 0 ? error[k] / scale : NAN;
}

static size_t unknowns(const dl_scene *scene) {
    size_t moving = 0;
    for (size_t i = 0; i < scene->particles; i++)
        moving += !scene->pinned[i];
    return (size_t)scene->dimension * moving;
}

static void scale(const dl_scene *scene, dl_drift_run *run) {
    const dl_run_summary *summary = &run->summary;
    run->excess = hypot(1, run->excess / summary->energy_scale / sqrt((double)unknowns(scene)));
    divide(run->energy, run->n, summary->energy_scale);
    divide(run->momentum, run->n, summary->momentum_scale);
    divide(run->angular, run->n, summary->angular_momentum_scale);
}

/* Half the step, or a tenth of both tolerances, at every level. */
static void *finer_options(const dl_study_unit *unit, const dl_drift_knob *knob, int level) {
    void *options = NULL;
    if (dl_method_options_copy(unit->row, unit->options, &options, NULL))
        return NULL;
    if (knob->adaptive) {
        const double part = pow(10, -level);
        set_option(unit->row, options, "rtol", knob->size * part);
        set_option(unit->row, options, "atol", dl_drift_option(unit->row, options, "atol") * part);
    } else {
        set_option(unit->row, options, "step", ldexp(knob->size, -level));
    }
    return options;
}

static double size_at(const dl_drift_knob *knob, int level) {
    return knob->adaptive ? knob->size * pow(10, -level) : ldexp(knob->size, -level);
}

dl_status dl_drift_run_level(const dl_study_unit *unit, const dl_drift_knob *knob, double interval,
                             int level, dl_drift_run *run, dl_error *error) {
    *run = (dl_drift_run){.size = size_at(knob, level)};
    recorder to = {.run = run, .interval = interval};
    dl_telling telling = {.unit = unit};
    snprintf(telling.label, sizeof telling.label, "%s %.3g", knob->adaptive ? "rtol" : "step",
             run->size);
    dl_status status = make_room(run, unit->end / interval, error);
    void *options = finer_options(unit, knob, level);
    if (status == DL_OK && !options)
        status = dl_fail_memory(error, "a method's options");
    dl_run_options how;
    dl_run_options_default(&how);
    how.end = unit->end;
    how.sample = interval;
    how.time_limit = unit->seconds;
    how.on_sample = record;
    how.context = &to;
    dl_telling_set(&telling, &how);
    if (status == DL_OK)
        status = unit->run(unit->scene, unit->row, options, &how, &run->summary, NULL, error);
    free(options);
    if (status == DL_INPUT) {
        run->summary.status = status;
        memcpy(run->summary.message, error->message, sizeof run->summary.message);
        status = DL_OK;
    }
    if (status == DL_OK)
        scale(unit->scene, run);
    return status;
}

void dl_drift_run_release(dl_drift_run *run) {
    free(run->time);
    *run = (dl_drift_run){0};
}

/* --- roundoff ----------------------------------------------------------------------------------
 */

/* Of a few terms of a step, each off by half a digit. */
static const double rounding = 4 * DBL_EPSILON;

static double walk(const dl_drift_run *run) {
    return rounding * sqrt(1 + (double)run->summary.force_evaluations);
}

double dl_drift_roundoff(const dl_drift_run *run) {
    return run->excess * walk(run);
}

double dl_drift_momentum_roundoff(const dl_drift_run *run) {
    return sqrt(run->excess) * walk(run);
}

double dl_drift_solved_to(const dl_method_row *row, const void *options) {
    const double tolerance = dl_drift_option(row, options, "tolerance");
    return fmax(1, isnan(tolerance) ? 1 : tolerance / rounding);
}
