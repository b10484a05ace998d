/* The energy-conserving arithmetic of TR171, (2.1)-(2.4), and its relatives: over a step of length
 * h
 *
 *     (v1 + v0)/2 = (q1 - q0)/h,      v1 - v0 = h a(q0, q1)
 *
 * with a mean acceleration a(q0, q1). TR171's is a discrete gradient of the potential, so that K +
 * V is the same after every step whatever h is, if the system for q1 is solved; others are in
 * model/discrete.c. A symmetric composition of such steps conserves what they do. */
#include "methods/conserving.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "methods/conserving_choice.h"
#include "methods/conserving_predictor.h"
#include "methods/conserving_solver.h"
#include "methods/conserving_state.h"
#include "methods/norms.h"
#include "methods/registry.h"
#include "model/middle_gap.h"

typedef struct conserving {
    dl_conserving_choice choice;
    dl_conserving_state state;
    dl_predictor predictor;
    dl_conserving_solver solver;
    dl_conserving_solver *rescue; /* made when it is first needed; NULL before */
    double *displacement;         /* the unknown, [n] */
    double *a;                    /* mean acceleration at the displacement, [n] */
    bool centre_rests;            /* in the state's frame, whatever happens */
    unsigned long steps, rescued;
} conserving;

static const dl_conserving_variant *variant_of(const dl_method *method) {
    return method->row->variant;
}

/* --- a step ------------------------------------------------------------------------------------
 */

static double largest(const double *values, size_t n) {
    return dl_largest_in_lanes(values, NULL, n);
}

/* Where the iteration begins. */
typedef enum start { FROM_PAST, FROM_START } start;

static dl_status predict(dl_method *method, double h, start from, dl_error *error) {
    conserving *const data = method->data;
    if (from == FROM_PAST && dl_predictor_guess(&data->predictor, h, data->a))
        return DL_OK;
    return dl_model_acceleration(method->model, data->state.q, data->a, error);
}

/* First guess of the displacement from the mean acceleration in data->a. */
static dl_status guess(const dl_method *method, double h, dl_conserving_solver *solver,
                       dl_error *error) {
    const conserving *const data = method->data;
    for (size_t i = 0; i < method->n; i++)
        data->displacement[i] = h * data->state.v[i] + h * h / 2 * data->a[i];
    const double size =
        fmax(largest(data->displacement, method->n), h * h / 2 * largest(data->a, method->n));
    if (!isfinite(size))
        return dl_fail(error, DL_UNSTABLE, "the step's displacement is not finite");
    solver->step.size = size > 0 ? size : 1;
    /* what is at rest moves by less than its coordinates' last digit */
    solver->step.floor = 4 * DBL_EPSILON * largest(data->state.q, method->n);
    solver->step.h = h;
    return dl_model_crossings_begin(method->model, data->state.q, data->displacement, h, error);
}

/* A first guess that was far too long (two particles begin deep in each other's repulsion) has made
 * residuals look small: solves again, measured by the displacement found, until that is right. */
static dl_status sharpen(const dl_method *method, dl_conserving_solver *solver, dl_error *error) {
    enum { most_times = 8 };
    static const double far_too_long = 1e3;
    const conserving *const data = method->data;
    dl_status status = DL_OK;
    for (int times = 0; times < most_times && !status; times++) {
        const double size = largest(data->displacement, method->n);
        if (!(size > solver->step.floor && size * far_too_long < solver->step.size))
            break;
        solver->step.size = size;
        status = dl_conserving_solve(solver, error);
    }
    return status;
}

static dl_status attempt(dl_method *method, double h, dl_conserving_solver *solver, start from,
                         dl_error *error) {
    dl_status status = predict(method, h, from, error);
    status = status ? status : guess(method, h, solver, error);
    status = status ? status : dl_conserving_solve(solver, error);
    return status ? status : sharpen(method, solver, error);
}

static dl_status create_rescue(dl_method *method, dl_error *error) {
    conserving *const data = method->data;
    data->rescue = calloc(1, sizeof *data->rescue);
    if (!data->rescue)
        return dl_fail_memory(error, "the conserving scheme's rescue");
    return dl_conserving_solver_create(data->rescue, method->model, &data->choice.rescue,
                                       &data->solver.step, error);
}

/* With the other solver. */
static dl_status rescue(dl_method *method, double h, start from, dl_error *error) {
    conserving *const data = method->data;
    dl_status status = data->rescue ? DL_OK : create_rescue(method, error);
    status = status ? status : attempt(method, h, data->rescue, from, error);
    data->rescued += status == DL_OK;
    return status;
}

/* Of a step by the force in the middle, where that is why: says so in the place of what the solver
 * has said. */
static dl_status explain(dl_method *method, double h, dl_error *error) {
    conserving *const data = method->data;
    dl_middle_gap gap;
    if (variant_of(method)->mean != DL_MEAN_MIDPOINT ||
        !dl_model_middle_gap(method->model, data->state.q, data->state.v, h, data->displacement,
                             data->a, &gap))
        return DL_NONLINEAR_FAILURE;
    return dl_fail(
        error, DL_NONLINEAR_FAILURE,
        "%s: the step from t = %.10g has no solution, for the force in its middle jumps: in the "
        "middle particles %zu and %zu would be %.10g apart with their force inside the breakpoint "
        "at %g, and %.10g with that beyond it. Expected end: shifted-force or taper at the "
        "breakpoint, or located: true, or a method that has the mean over the jump, as conserving",
        method->row->name, method->t, gap.i, gap.j, gap.inside, gap.breakpoint, gap.outside);
}

static dl_status solve(dl_method *method, double h, dl_error *error) {
    conserving *const data = method->data;
    dl_status status = attempt(method, h, &data->solver, FROM_PAST, error);
    if (status == DL_NONLINEAR_FAILURE && data->choice.has_rescue)
        status = rescue(method, h, FROM_PAST, error);
    if (status == DL_NONLINEAR_FAILURE)
        status = attempt(method, h, &data->solver, FROM_START, error);
    if (status == DL_NONLINEAR_FAILURE && data->choice.has_rescue)
        status = rescue(method, h, FROM_START, error);
    return status == DL_NONLINEAR_FAILURE ? explain(method, h, error) : status;
}

static dl_status conserving_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    conserving *const data = method->data;
    const dl_conserving_variant *const variant = variant_of(method);
    if (variant->stages > 1)
        dl_conserving_state_keep(&data->state);
    for (int stage = 0; stage < variant->stages; stage++) {
        const double h = variant->weight[stage] * method->step;
        const dl_status status = solve(method, h, error);
        if (status) {
            if (stage > 0) {
                dl_conserving_state_go_back(&data->state);
                dl_predictor_jumped(&data->predictor);
            }
            return status;
        }
        if (data->centre_rests)
            dl_model_rest_centre(method->model, data->a);
        dl_conserving_state_step(&data->state, h, data->a);
        dl_predictor_add(&data->predictor, h, data->a);
    }
    data->steps++;
    dl_method_count_step(method);
    dl_conserving_state_show(&data->state, method);
    return DL_OK;
}

/* --- life --------------------------------------------------------------------------------------
 */

static dl_status conserving_jumped(dl_method *method, dl_error *error) {
    (void)error;
    conserving *const data = method->data;
    dl_conserving_state_take(&data->state, method);
    dl_predictor_jumped(&data->predictor);
    return DL_OK;
}

static dl_status create_arrays(dl_method *method, dl_error *error) {
    conserving *const data = method->data;
    const dl_conserving_options *const options = method->options;
    data->displacement = calloc(method->n + 1, sizeof(double));
    data->a = calloc(method->n + 1, sizeof(double));
    if (!data->displacement || !data->a)
        return dl_fail_memory(error, "the conserving scheme's step");
    const dl_status status = dl_conserving_state_create(&data->state, method->n, error);
    return status ? status
                  : dl_predictor_create(&data->predictor, (dl_predictor_kind)options->predictor,
                                        method->n, error);
}

static dl_status conserving_create(dl_method *method, dl_error *error) {
    conserving *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "the conserving scheme");
    const dl_conserving_options *const options = method->options;
    method->step = options->step;
    dl_status status = create_arrays(method, error);
    status = status ? status : dl_model_set_mean(method->model, variant_of(method)->mean, error);
    if (status)
        return status;
    dl_conserving_state_take(&data->state, method);
    data->centre_rests =
        dl_model_is_galilean_invariant(method->model) && !method->model->has_gravity;
    status = dl_conserving_choose(method, &data->state, &data->choice, error);
    if (status)
        return status;
    const dl_conserving_step step = {
        .n = method->n,
        .h = options->step,
        .q = data->state.q,
        .v = data->state.v,
        .delta = data->displacement,
        .a = data->a,
    };
    return dl_conserving_solver_create(&data->solver, method->model, &data->choice.solver, &step,
                                       error);
}

static void add_stats(const dl_conserving_solver *solver, dl_method_stats *stats) {
    stats->nonlinear_iterations += solver->counts.iterations;
    stats->linear_iterations += solver->counts.linear_iterations;
    stats->factorisations += solver->counts.factorisations;
    stats->inexact += solver->counts.inexact;
}

static void conserving_stats(const dl_method *method, dl_method_stats *stats) {
    const conserving *const data = method->data;
    stats->steps = data->steps;
    stats->rescued = data->rescued;
    add_stats(&data->solver, stats);
    if (data->rescue)
        add_stats(data->rescue, stats);
}

static void conserving_describe(const dl_method *method, char *text, size_t size) {
    const conserving *const data = method->data;
    snprintf(text, size, "%s", data->choice.reason);
}

static void conserving_own_frame(const dl_method *method, double *y, double velocity[3]) {
    const conserving *const data = method->data;
    memcpy(y, data->state.q, method->n * sizeof *y);
    memcpy(y + method->n, data->state.v, method->n * sizeof *y);
    memcpy(velocity, data->state.frame, sizeof data->state.frame);
}

static void conserving_destroy(dl_method *method) {
    conserving *const data = method->data;
    if (!data)
        return;
    dl_conserving_solver_free(&data->solver);
    if (data->rescue)
        dl_conserving_solver_free(data->rescue);
    dl_conserving_state_free(&data->state);
    dl_predictor_free(&data->predictor);
    free(data->rescue);
    free(data->displacement);
    free(data->a);
    free(data);
}

const dl_method_ops dl_conserving_ops = {
    .create = conserving_create,
    .advance = conserving_advance,
    .jumped = conserving_jumped,
    .own_frame = conserving_own_frame,
    .describe = conserving_describe,
    .stats = conserving_stats,
    .destroy = conserving_destroy,
};
