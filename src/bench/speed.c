/* Leap-frog, forces and the conserving scheme on the papers' scenes. */
#include <math.h>

#include "bench/runs.h"

typedef struct sheet {
    const dl_bench_effort *effort;
    dl_bench_speed *row;
    size_t count;
} sheet;

/* times: ns of what has so many units. */
static dl_bench_speed *add(sheet *on, const char *what, const dl_scene *scene, const char *unit,
                           dl_bench_times *times, double units) {
    for (size_t k = 0; k < times->count; k++)
        times->value[k] /= units;
    dl_bench_speed *const row = &on->row[on->count++];
    *row = (dl_bench_speed){.what = what,
                            .scene = scene->name,
                            .unit = unit,
                            .time = dl_bench_spread_of(times),
                            .step = NAN,
                            .iterations = NAN};
    return row;
}

static dl_status add_method(sheet *on, const char *method, const dl_scene *scene, dl_error *error) {
    const dl_method_row *row = NULL;
    dl_bench_runs runs;
    dl_bench_times times = {.count = 0};
    dl_status status = dl_method_find(method, &row, error);
    if (!status)
        status = dl_bench_runs_create(row, scene, on->effort->seconds, &runs, error);
    if (status)
        return status;
    for (size_t k = 0; k < on->effort->repeats && !status; k++) {
        double time = 0;
        status = dl_bench_runs_measure(&runs, &time, error);
        dl_bench_add(&times, time);
    }
    const double iterations =
        (double)runs.summary.nonlinear_iterations / (double)runs.summary.steps;
    const bool solves = row->flags & DL_IMPLICIT;
    if (!status) {
        dl_bench_speed *const added =
            add(on, method, scene, solves ? "ns/nonlinear iteration" : "ns/particle-step", &times,
                solves ? iterations : (double)scene->particles);
        added->step = added->time.minimum * (solves ? iterations : (double)scene->particles);
        added->iterations = solves ? iterations : NAN;
    }
    dl_bench_runs_release(&runs);
    return status;
}

static dl_status add_forces(sheet *on, const dl_scene *scene, dl_error *error) {
    const double n = (double)scene->particles;
    dl_model *model = NULL;
    dl_bench_forces forces = {.q = NULL};
    dl_bench_times times = {.count = 0};
    dl_status status = dl_model_create(scene, &model, error);
    if (!status)
        status = dl_bench_forces_create(model, DL_BENCH_WHOLE, on->effort->seconds, &forces, error);
    for (size_t k = 0; k < on->effort->repeats && !status; k++) {
        double time = 0;
        status = dl_bench_forces_measure(&forces, &time, error);
        dl_bench_add(&times, time);
    }
    if (!status)
        add(on, "forces", scene, "ns/ordered pair", &times, n * (n - 1));
    dl_bench_forces_release(&forces);
    dl_model_free(model);
    return status;
}

dl_status dl_bench_measure_speed(const dl_bench_scenes *scenes, const dl_bench_effort *effort,
                                 dl_bench_speed rows[DL_BENCH_MOST_ROWS], size_t *count,
                                 dl_error *error) {
    const struct {
        const char *method; /* NULL: forces alone */
        const dl_scene *scene;
    } cases[] = {
        {"leapfrog", scenes->fluid},
        {"leapfrog", scenes->swirl},
        {"leapfrog", scenes->stream},
        {NULL, scenes->swirl},
        {NULL, scenes->stream},
        {"conserving", scenes->stream},
        {"conserving-fixed-point", scenes->stream},
        {"conserving-newton-dense", scenes->stream},
        {"conserving-newton-klu", scenes->stream},
        {"conserving-newton-krylov", scenes->stream},
        {"conserving-fixed-point", scenes->swirl},
    };
    sheet on = {.effort = effort, .row = rows};
    dl_status status = DL_OK;
    for (size_t k = 0; k < sizeof cases / sizeof *cases && !status; k++)
        status = cases[k].method ? add_method(&on, cases[k].method, cases[k].scene, error)
                                 : add_forces(&on, cases[k].scene, error);
    *count = on.count;
    return status;
}
