/* GSL's driver, called as its manual shows, beside the methods that step by it. The steppers
 * without a Jacobian: those with one factorise dense matrices, beside which nothing else counts. */
#include <stdlib.h>
#include <string.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "bench/alone.h"
#include "bench/runs.h"
#include "observe/stopwatch.h"

static const struct {
    const char *method;
    const gsl_odeiv2_step_type *const *type;
} steppers[] = {
    {"gsl-rk2", &gsl_odeiv2_step_rk2},     {"gsl-rk4", &gsl_odeiv2_step_rk4},
    {"gsl-rkf45", &gsl_odeiv2_step_rkf45}, {"gsl-rkck", &gsl_odeiv2_step_rkck},
    {"gsl-rk8pd", &gsl_odeiv2_step_rk8pd}, {"gsl-msadams", &gsl_odeiv2_step_msadams},
};

typedef struct by_hand {
    dl_model *model;
    gsl_odeiv2_system system;
    gsl_odeiv2_driver *driver;
    double *y; /* [2 unknowns] */
    double first_step;
} by_hand;

static int rhs(double t, const double y[], double ydot[], void *model) {
    (void)t;
    return dl_model_rhs(model, y, ydot, NULL) ? GSL_EBADFUNC : GSL_SUCCESS;
}

/* Tolerances and first step: those that the methods have where nothing is said. */
static dl_status create(by_hand *hand, const dl_scene *scene, const gsl_odeiv2_step_type *type,
                        dl_error *error) {
    const dl_status status = dl_model_create(scene, &hand->model, error);
    if (status)
        return status;
    const size_t length = 2 * hand->model->unknowns;
    gsl_set_error_handler_off();
    hand->first_step = scene->step / 100;
    hand->system = (gsl_odeiv2_system){.function = rhs, .dimension = length, .params = hand->model};
    hand->y = malloc(length * sizeof *hand->y);
    hand->driver =
        gsl_odeiv2_driver_alloc_y_new(&hand->system, type, hand->first_step, 1e-10, 1e-6);
    return hand->y && hand->driver ? DL_OK : dl_fail_memory(error, "GSL's driver");
}

static void release(by_hand *hand) {
    if (hand->driver)
        gsl_odeiv2_driver_free(hand->driver);
    free(hand->y);
    dl_model_free(hand->model);
}

/* As many runs to the same end as ours; *nanoseconds: of one of our steps. */
static dl_status measure(by_hand *hand, const dl_bench_runs *ours, double *nanoseconds,
                         dl_error *error) {
    double seconds = 0;
    for (size_t k = 0; k < ours->runs; k++) {
        double t = 0;
        dl_model_initial_state(hand->model, hand->y);
        hand->model->counts.force = 0;
        gsl_odeiv2_driver_reset_hstart(hand->driver, hand->first_step);
        const double began = dl_cpu_clock();
        const int flag = gsl_odeiv2_driver_apply(hand->driver, &t, ours->end, hand->y);
        seconds += dl_cpu_clock() - began;
        if (flag != GSL_SUCCESS)
            return dl_fail(error, DL_STEP_FAILURE, "GSL's driver: %s", gsl_strerror(flag));
    }
    *nanoseconds = seconds * 1e9 / (double)(ours->runs * ours->summary.steps);
    return DL_OK;
}

static dl_status compare(by_hand *hand, dl_bench_runs *ours, size_t repeats, dl_bench_peer *row,
                         dl_error *error) {
    dl_bench_times mine = {.count = 0}, theirs = {.count = 0};
    dl_status status = DL_OK;
    for (size_t k = 0; k < repeats && !status; k++) {
        double time = 0;
        status = dl_bench_runs_measure(ours, &time, error);
        dl_bench_add(&mine, time);
        if (!status)
            status = measure(hand, ours, &time, error);
        dl_bench_add(&theirs, time);
    }
    if (status)
        return status;
    row->ours = dl_bench_spread_of(&mine).minimum;
    row->theirs = dl_bench_spread_of(&theirs).minimum;
    row->ratio = dl_bench_ratio(&theirs, &mine);
    row->our_evaluations = ours->summary.force_evaluations;
    row->their_evaluations = hand->model->counts.force;
    return DL_OK;
}

typedef struct question {
    size_t stepper;
    const dl_scene *scene;
    const dl_bench_effort *effort;
} question;

static dl_status answer(const void *what, void *answered, dl_error *error) {
    const question *const asked = what;
    const size_t k = asked->stepper;
    const dl_scene *const scene = asked->scene;
    const dl_method_row *method = NULL;
    dl_bench_runs ours;
    by_hand hand = {.model = NULL};
    dl_bench_peer *const row = answered;
    *row = (dl_bench_peer){.method = steppers[k].method, .scene = scene->name};
    dl_status status = dl_method_find(steppers[k].method, &method, error);
    if (!status)
        status = dl_bench_runs_create(method, scene, asked->effort->seconds, &ours, error);
    if (status)
        return status;
    status = create(&hand, scene, *steppers[k].type, error);
    if (!status)
        status = compare(&hand, &ours, asked->effort->repeats, row, error);
    release(&hand);
    dl_bench_runs_release(&ours);
    return status;
}

dl_status dl_bench_measure_gsl(const dl_bench_scenes *scenes, const dl_bench_effort *effort,
                               dl_bench_peer rows[DL_BENCH_MOST_ROWS], size_t *count,
                               dl_error *error) {
    const dl_scene *const on[] = {&scenes->pair, scenes->stream};
    dl_status status = DL_OK;
    *count = 0;
    for (size_t s = 0; s < sizeof on / sizeof *on; s++)
        for (size_t k = 0; k < sizeof steppers / sizeof *steppers && !status; k++) {
            const question asked = {k, on[s], effort};
            status = dl_bench_alone(answer, &asked, &rows[(*count)++], sizeof *rows, error);
        }
    return status;
}
