/* What a method costs beyond its forces. */
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "bench/alone.h"
#include "bench/runs.h"

/* A model's accelerations, with a count before them. They have no context of their own, so that
 * there is one of these: what is counted is one method at a time. Means that evaluate a force
 * inside are one call. */
static struct {
    int depth;
    double calls[DL_BENCH_FORCES];
    dl_status (*acceleration)(dl_model *, const double *, double *, dl_error *);
    dl_status (*discrete)(dl_model *, const double *, const double *, double *, dl_error *);
    dl_status (*part)(dl_model *, dl_part, const double *, double *, dl_error *);
} counted;

static void enter(dl_bench_force which) {
    counted.calls[which] += counted.depth++ == 0;
}

static dl_status count_whole(dl_model *model, const double *q, double *a, dl_error *error) {
    enter(DL_BENCH_WHOLE);
    const dl_status status = counted.acceleration(model, q, a, error);
    counted.depth--;
    return status;
}

static dl_status count_discrete(dl_model *model, const double *q, const double *delta, double *a,
                                dl_error *error) {
    enter(DL_BENCH_DISCRETE);
    const dl_status status = counted.discrete(model, q, delta, a, error);
    counted.depth--;
    return status;
}

static dl_status count_part(dl_model *model, dl_part part, const double *q, double *a,
                            dl_error *error) {
    enter(part == DL_PART_FAST ? DL_BENCH_FAST : DL_BENCH_SLOW);
    const dl_status status = counted.part(model, part, q, a, error);
    counted.depth--;
    return status;
}

static void begin_counting(dl_model *model) {
    for (int k = 0; k < DL_BENCH_FORCES; k++)
        counted.calls[k] = 0;
    counted.depth = 0;
    counted.acceleration = model->acceleration;
    counted.discrete = model->discrete_acceleration;
    counted.part = model->part_acceleration;
    model->acceleration = count_whole;
    model->discrete_acceleration = count_discrete;
    model->part_acceleration = count_part;
}

static void end_counting(dl_model *model) {
    model->acceleration = counted.acceleration;
    model->discrete_acceleration = counted.discrete;
    model->part_acceleration = counted.part;
}

/* A method at work on a model of its own. */
typedef struct work {
    dl_bench_runs runs;
    dl_model *model;
    dl_method *method;
    double calls[DL_BENCH_FORCES]; /* a step */
    size_t tries;
    dl_model *tried[DL_BENCH_FORCES * DL_BENCH_MOST_REPEATS]; /* whose forces have been timed */
} work;

/* Steps as those of a run, without its time loop. */
static dl_status count_forces(work *on, dl_error *error) {
    const unsigned long steps = on->runs.summary.steps;
    const double end = on->runs.end;
    dl_status status = DL_OK;
    begin_counting(on->model);
    for (unsigned long k = 0; k < steps && !status; k++)
        status = dl_method_advance(on->method, end, error);
    end_counting(on->model);
    for (int k = 0; k < DL_BENCH_FORCES; k++)
        on->calls[k] = counted.calls[k] / (double)steps;
    return status;
}

static dl_status create(work *on, const dl_method_row *row, const dl_scene *scene, double seconds,
                        dl_error *error) {
    dl_status status = dl_bench_runs_create(row, scene, seconds, &on->runs, error);
    if (!status)
        status = dl_model_create(scene, &on->model, error);
    double *const y = status ? NULL : malloc(2 * on->model->unknowns * sizeof *y);
    if (!status && !y)
        status = dl_fail_memory(error, "a benchmark's state");
    if (!status) {
        dl_model_initial_state(on->model, y);
        status = dl_method_create(row, on->model, on->runs.options, y, &on->method, error);
    }
    free(y);
    return status ? status : count_forces(on, error);
}

static void release(work *on) {
    for (size_t k = 0; k < on->tries; k++)
        dl_model_free(on->tried[k]);
    dl_method_destroy(on->method);
    dl_model_free(on->model);
    dl_bench_runs_release(&on->runs);
}

/* On a model of its own, which is kept, so that each repeat's lies elsewhere: where a kernel's
 * arrays lie alone makes a tenth. */
static dl_status measure_force(work *on, dl_bench_force which, double seconds, double *least,
                               dl_error *error) {
    dl_bench_forces forces = {.q = NULL};
    double time = INFINITY;
    dl_model **const model = &on->tried[on->tries];
    dl_status status = dl_model_create(on->runs.scene, model, error);
    if (status)
        return status;
    on->tries++;
    status = dl_model_set_mean(*model, on->model->mean, error);
    if (!status && (which == DL_BENCH_FAST || which == DL_BENCH_SLOW))
        status = dl_model_split(*model, error);
    if (!status)
        status = dl_bench_forces_create(*model, which, seconds, &forces, error);
    if (!status)
        status = dl_bench_forces_measure(&forces, &time, error);
    dl_bench_forces_release(&forces);
    *least = fmin(*least, time);
    return status;
}

/* One repeat: the step, then each of its forces. */
static dl_status measure(work *on, double seconds, dl_bench_overhead *result,
                         double least[DL_BENCH_FORCES], dl_error *error) {
    double time = INFINITY;
    dl_status status = dl_bench_runs_measure(&on->runs, &time, error);
    result->step = fmin(result->step, time);
    for (int k = 0; k < DL_BENCH_FORCES && !status; k++)
        if (on->calls[k] > 0)
            status = measure_force(on, (dl_bench_force)k, seconds, &least[k], error);
    return status;
}

typedef struct question {
    const dl_method_row *row;
    const dl_scene *scene;
    const dl_bench_effort *effort;
} question;

static dl_status answer(const void *what, void *answered, dl_error *error) {
    const question *const asked = what;
    const dl_bench_effort *const effort = asked->effort;
    dl_bench_overhead *const result = answered;
    work on = {.model = NULL};
    double least[DL_BENCH_FORCES];
    *result = (dl_bench_overhead){.row = asked->row,
                                  .scene = asked->scene->name,
                                  .particles = asked->scene->particles,
                                  .step = INFINITY};
    dl_status status = create(&on, asked->row, asked->scene, effort->seconds, error);
    for (int k = 0; k < DL_BENCH_FORCES; k++)
        least[k] = INFINITY;
    for (size_t k = 0; k < effort->repeats && !status; k++)
        status = measure(&on, effort->seconds, result, least, error);
    for (int k = 0; k < DL_BENCH_FORCES && !status; k++)
        if (on.calls[k] > 0) {
            result->forces += on.calls[k];
            result->force += on.calls[k] * least[k];
        }
    release(&on);
    return status;
}

dl_status dl_bench_measure_overhead(const dl_method_row *row, const dl_scene *scene,
                                    const dl_bench_effort *effort, dl_bench_overhead *result,
                                    dl_error *error) {
    const question asked = {row, scene, effort};
    return dl_bench_alone(answer, &asked, result, sizeof *result, error);
}
