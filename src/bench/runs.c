#include "bench/runs.h"

#include <math.h>
#include <stdlib.h>

#include "observe/stopwatch.h"

/* --- runs --------------------------------------------------------------------------------------
 */

static dl_status run_once(dl_bench_runs *runs, dl_error *error) {
    dl_run_options how;
    dl_run_options_default(&how);
    how.observe = false;
    how.end = how.sample = runs->end;
    const dl_status status =
        dl_run(runs->scene, runs->row, runs->options, &how, &runs->summary, NULL, error);
    if (status || !runs->summary.status)
        return status;
    return dl_fail(error, runs->summary.status, "%s on %s: %s", runs->row->name, runs->scene->name,
                   runs->summary.message);
}

dl_status dl_bench_runs_measure(dl_bench_runs *runs, double *nanoseconds, dl_error *error) {
    double seconds = 0;
    dl_status status = DL_OK;
    for (size_t k = 0; k < runs->runs && !status; k++) {
        status = run_once(runs, error);
        seconds += runs->summary.cpu_seconds;
    }
    *nanoseconds = seconds * 1e9 / (double)(runs->runs * runs->summary.steps);
    return status;
}

/* Longer runs first, then more of them. A method that chooses its steps begins with a part of the
 * scene's: it may take thousands in one. */
static dl_status calibrate(dl_bench_runs *runs, double wanted, dl_error *error) {
    const dl_scene *const scene = runs->scene;
    const double most = (double)dl_whole_steps(scene->end, scene->step) * scene->step;
    runs->end = runs->row->flags & DL_ADAPTIVE ? scene->step / 64 : scene->step;
    for (;;) {
        const dl_status status = run_once(runs, error);
        if (status)
            return status;
        if (runs->summary.cpu_seconds >= wanted / 2 || runs->end >= most)
            break;
        runs->end = fmin(2 * runs->end, most);
    }
    runs->runs = (size_t)fmax(1, wanted / fmax(runs->summary.cpu_seconds, 1e-7));
    return DL_OK;
}

dl_status dl_bench_runs_create(const dl_method_row *row, const dl_scene *scene, double seconds,
                               dl_bench_runs *runs, dl_error *error) {
    *runs = (dl_bench_runs){.scene = scene, .row = row};
    dl_status status = dl_method_options_create(row, scene, &runs->options, error);
    if (!status)
        status = calibrate(runs, seconds, error);
    if (status)
        dl_bench_runs_release(runs);
    return status;
}

void dl_bench_runs_release(dl_bench_runs *runs) {
    if (runs->options)
        dl_method_options_free(runs->row, runs->options);
    runs->options = NULL;
}

/* --- forces ------------------------------------------------------------------------------------
 */

static dl_status evaluate(const dl_bench_forces *f, dl_error *error) {
    switch (f->which) {
    case DL_BENCH_DISCRETE:
        return dl_model_discrete_acceleration(f->model, f->q, f->delta, f->a, error);
    case DL_BENCH_FAST:
        return dl_model_part_acceleration(f->model, DL_PART_FAST, f->q, f->a, error);
    case DL_BENCH_SLOW:
        return dl_model_part_acceleration(f->model, DL_PART_SLOW, f->q, f->a, error);
    default:
        return dl_model_acceleration(f->model, f->q, f->a, error);
    }
}

dl_status dl_bench_forces_measure(dl_bench_forces *forces, double *nanoseconds, dl_error *error) {
    dl_status status = DL_OK;
    const double began = dl_cpu_clock();
    for (size_t k = 0; k < forces->calls && !status; k++)
        status = evaluate(forces, error);
    *nanoseconds = (dl_cpu_clock() - began) * 1e9 / (double)forces->calls;
    return status;
}

dl_status dl_bench_forces_create(dl_model *model, dl_bench_force which, double seconds,
                                 dl_bench_forces *forces, dl_error *error) {
    const size_t n = model->unknowns;
    *forces = (dl_bench_forces){.model = model, .which = which, .calls = 1};
    forces->q = malloc(2 * n * sizeof *forces->q);
    forces->delta = malloc(n * sizeof *forces->delta);
    forces->a = malloc(n * sizeof *forces->a); /* aligned as a method's own is */
    if (!forces->q || !forces->delta || !forces->a) {
        dl_bench_forces_release(forces);
        return dl_fail_memory(error, "a force to be timed");
    }
    dl_model_initial_state(model, forces->q);
    for (size_t u = 0; u < n; u++)
        forces->delta[u] = model->scene->step * forces->q[n + u];
    double nanoseconds = 0;
    dl_status status = dl_bench_forces_measure(forces, &nanoseconds, error);
    while (!status && nanoseconds * (double)forces->calls < seconds * 1e9) {
        forces->calls *= 2;
        status = dl_bench_forces_measure(forces, &nanoseconds, error);
    }
    if (status)
        dl_bench_forces_release(forces);
    return status;
}

void dl_bench_forces_release(dl_bench_forces *forces) {
    free(forces->q);
    free(forces->delta);
    free(forces->a);
    forces->q = forces->delta = forces->a = NULL;
}
