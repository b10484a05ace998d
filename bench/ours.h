/* What is timed: leap-frog runs and force evaluations, by CPU time. */
#ifndef BENCH_OURS_H
#define BENCH_OURS_H

#include <math.h>
#include <stdlib.h>
#include "driftlab/run.h"
#include "force/kernel.h"
#include "observe/stopwatch.h"

/* A method of fixed step for `steps` steps from the scene's initial state, nothing observed.
 * summary->cpu_seconds: of the integration alone. y_final [4 * particles] or NULL. */
static dl_status ours_run(const dl_scene *scene, const char *method, size_t steps,
                          dl_run_summary *summary, double *y_final, dl_error *error) {
    const dl_method_row *row = NULL;
    void *options = NULL;
    dl_run_options run;
    dl_run_options_default(&run);
    run.observe = false;
    run.end = run.sample = (double)steps * scene->step;
    dl_status status = dl_method_find(method, &row, error);
    if (!status)
        status = dl_method_options_create(row, scene, &options, error);
    if (!status)
        status = dl_run(scene, row, options, &run, summary, y_final, error);
    if (row)
        dl_method_options_free(row, options);
    if (!status && summary->status)
        status = dl_fail(error, summary->status, "%s", summary->message);
    return status;
}

/* A model at the scene's initial state whose force is evaluated again and again. */
typedef struct ours_force {
    dl_model *model;
    double *q, *a; /* q: 2 * unknowns, the whole state */
    size_t calls;  /* a measurement */
} ours_force;

static void ours_force_release(ours_force *force) {
    dl_model_free(force->model);
    free(force->q);
    free(force->a);
    *force = (ours_force){NULL, NULL, NULL, 0};
}

static dl_status ours_force_create(const dl_scene *scene, ours_force *force, dl_error *error) {
    *force = (ours_force){.calls = 1};
    dl_status status = dl_model_create(scene, &force->model, error);
    if (status)
        return status;
    force->q = malloc(2 * force->model->unknowns * sizeof *force->q);
    force->a = malloc(force->model->unknowns * sizeof *force->a);
    if (!force->q || !force->a) {
        ours_force_release(force);
        return dl_fail_memory(error, "a force benchmark");
    }
    dl_model_initial_state(force->model, force->q);
    return DL_OK;
}

/* Seconds of one evaluation. */
static dl_status ours_force_measure(const ours_force *force, double *seconds, dl_error *error) {
    dl_status status = DL_OK;
    const double began = dl_cpu_clock();
    for (size_t k = 0; k < force->calls && !status; k++)
        status = dl_model_acceleration(force->model, force->q, force->a, error);
    *seconds = (dl_cpu_clock() - began) / (double)force->calls;
    return status;
}

/* Chooses the number of calls so that a measurement takes `wanted` seconds; warms up by it. */
__attribute__((unused)) static dl_status ours_force_calibrate(ours_force *force, double wanted,
                                                              dl_error *error) {
    double seconds = 0;
    dl_status status = DL_OK;
    while (!status && seconds * (double)force->calls < wanted) {
        if (seconds > 0)
            force->calls *= 2;
        status = ours_force_measure(force, &seconds, error);
    }
    return status;
}

/* Kinetic energy per particle of a state in scene order, 2-D. */
__attribute__((unused)) static double ours_kinetic(const dl_scene *scene, const double *y_all) {
    const size_t n = scene->particles;
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += scene->inertia[i] / 2 *
               (y_all[2 * n + i] * y_all[2 * n + i] + y_all[3 * n + i] * y_all[3 * n + i]);
    return sum / (double)n;
}

#endif
