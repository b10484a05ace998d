/* The energy-conserving arithmetic of TR171, (2.1)-(2.4): over a step of length h
 *
 *     (v1 + v0)/2 = (q1 - q0)/h,      v1 - v0 = h a(q0, q1)
 *
 * with the mean acceleration a(q0, q1) a discrete gradient of the potential, so that K + V is the
 * same after every step whatever h is, if the system for q1 is solved; likewise both momenta.
 *
 * Where the scene is Galilean-invariant the state is kept in a frame that moves with the centre of
 * mass: the velocities' last digits are then those of the internal motion, not of the stream. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "methods/conserving_solver.h"
#include "methods/options.h"
#include "methods/registry.h"

typedef struct conserving_options {
    double step, tolerance;
    long iterations, depth;
    bool rescue;
} conserving_options;

#define COMMON_OPTIONS                                                                             \
    DL_OPTION_FIXED_STEP(conserving_options),                                                      \
        {.name = "tolerance",                                                                      \
         .kind = DL_REAL,                                                                          \
         .offset = offsetof(conserving_options, tolerance),                                        \
         .unit = "",                                                                               \
         .minimum = 0,                                                                             \
         .maximum = 0.1,                                                                           \
         .fallback = "1e-15",                                                                      \
         .doc = "residual of a step's system allowed, as a part of its largest displacement; "     \
                "iteration also ends where roundoff lets the residual fall no further"},           \
    {                                                                                              \
        .name = "iterations", .kind = DL_INTEGER,                                                  \
        .offset = offsetof(conserving_options, iterations), .unit = "", .minimum = 1,              \
        .maximum = 100000, .fallback = "100",                                                      \
        .doc = "nonlinear iterations allowed in one attempt at a step"                             \
    }

static const dl_parameter fixed_point_options[] = {
    COMMON_OPTIONS,
    {
        .name = "depth",
        .kind = DL_INTEGER,
        .offset = offsetof(conserving_options, depth),
        .unit = "",
        .minimum = 0,
        .maximum = 20,
        .fallback = "1",
        .doc = "residuals that Anderson's acceleration combines; 0: plain fixed point",
    },
    {
        .name = "rescue",
        .kind = DL_FLAG,
        .offset = offsetof(conserving_options, rescue),
        .unit = "",
        .fallback = "true",
        .doc = "solve a step by Newton's method where the fixed point does not contract (a pair "
               "that crosses a hard cutoff slowly)",
    },
};

static const dl_parameter newton_options[] = {COMMON_OPTIONS};

typedef struct conserving {
    dl_conserving_solver solver;
    dl_conserving_solver *rescue; /* Newton's, made when it is first needed; NULL before */
    double *q, *v;                /* state in the moving frame, [n] each */
    double *displacement;         /* the unknown, [n] */
    double *a;                    /* mean acceleration at the displacement, [n] */
    double *past[2];    /* mean accelerations over the last step and the one before, [n] */
    double frame[3];    /* velocity of the frame */
    double frame_start; /* time at which the frame's origin was the scene's */
    unsigned long since_jump, steps;
} conserving;

/* --- a step ------------------------------------------------------------------------------------
 */

static double largest(const double *values, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(values[i]));
    return most;
}

/* Where the iteration begins: with the acceleration of the step's start, or on the line through the
 * mean accelerations of the last two steps. */
typedef enum predictor { FROM_START, FROM_PAST } predictor;

static dl_status predict(dl_method *method, predictor from, dl_error *error) {
    conserving *const data = method->data;
    if (from == FROM_START || data->since_jump == 0)
        return dl_model_acceleration(method->model, data->q, data->a, error);
    const double *const last = data->past[0], *const earlier = data->past[1];
    for (size_t i = 0; i < method->n; i++)
        data->a[i] = data->since_jump == 1 ? last[i] : 2 * last[i] - earlier[i];
    return DL_OK;
}

/* First guess of the displacement from the mean acceleration in data->a. */
static dl_status guess(const dl_method *method, dl_conserving_solver *solver, dl_error *error) {
    const conserving *const data = method->data;
    const double h = method->step;
    for (size_t i = 0; i < method->n; i++)
        data->displacement[i] = h * data->v[i] + h * h / 2 * data->a[i];
    const double size =
        fmax(largest(data->displacement, method->n), h * h / 2 * largest(data->a, method->n));
    if (!isfinite(size))
        return dl_fail(error, DL_UNSTABLE, "the step's displacement is not finite");
    solver->step.size = size > 0 ? size : 1;
    return DL_OK;
}

static dl_status attempt(dl_method *method, dl_conserving_solver *solver, predictor from,
                         dl_error *error) {
    solver->step.h = method->step;
    dl_status status = predict(method, from, error);
    status = status ? status : guess(method, solver, error);
    return status ? status : dl_conserving_solve(solver, error);
}

static dl_status create_rescue(dl_method *method, dl_error *error) {
    conserving *const data = method->data;
    const conserving_options *const options = method->options;
    data->rescue = calloc(1, sizeof *data->rescue);
    if (!data->rescue)
        return dl_fail_memory(error, "the conserving scheme's rescue");
    return dl_conserving_solver_create(data->rescue, method->model, DL_NEWTON_KLU,
                                       &data->solver.step, options->tolerance, options->iterations,
                                       0, error);
}

static dl_status solve(dl_method *method, dl_error *error) {
    conserving *const data = method->data;
    const conserving_options *const options = method->options;
    dl_conserving_solver *solver = &data->solver;
    dl_status status = attempt(method, solver, FROM_PAST, error);
    if (status == DL_NONLINEAR_FAILURE && options->rescue) {
        status = data->rescue ? DL_OK : create_rescue(method, error);
        if (status || !data->rescue)
            return status;
        solver = data->rescue;
        status = attempt(method, solver, FROM_PAST, error);
    }
    if (status == DL_NONLINEAR_FAILURE)
        status = attempt(method, solver, FROM_START, error);
    return status;
}

/* y in the scene's frame. */
static void publish(dl_method *method) {
    conserving *const data = method->data;
    const size_t moving = method->model->moving;
    for (size_t c = 0; c < (size_t)method->model->dimension; c++) {
        const double shift = data->frame[c] * (method->t - data->frame_start);
        for (size_t i = c * moving; i < (c + 1) * moving; i++) {
            method->y[i] = data->q[i] + shift;
            method->y[method->n + i] = data->v[i] + data->frame[c];
        }
    }
}

static dl_status conserving_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    conserving *const data = method->data;
    const double h = method->step;
    const dl_status status = solve(method, error);
    if (status)
        return status;
    double *const oldest = data->past[1];
    data->past[1] = data->past[0];
    data->past[0] = oldest;
    memcpy(oldest, data->a, method->n * sizeof *oldest);
    for (size_t i = 0; i < method->n; i++) {
        data->q[i] += h * data->v[i] + h * h / 2 * data->a[i];
        data->v[i] += h * data->a[i];
    }
    data->since_jump++;
    data->steps++;
    dl_method_count_step(method);
    publish(method);
    return DL_OK;
}

/* --- life --------------------------------------------------------------------------------------
 */

/* Takes the state over from y, into the frame of its centre of mass where the scene allows it. */
static dl_status conserving_jumped(dl_method *method, dl_error *error) {
    (void)error;
    conserving *const data = method->data;
    const dl_model *const model = method->model;
    double momentum[3] = {0, 0, 0}, angular[3];
    if (dl_model_is_galilean_invariant(model))
        dl_model_momentum(model, method->y, momentum, angular);
    const double inertia = dl_model_inertia(model);
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        data->frame[c] = inertia > 0 ? momentum[c] / inertia : 0;
        for (size_t i = c * model->moving; i < (c + 1) * model->moving; i++) {
            data->q[i] = method->y[i];
            data->v[i] = method->y[method->n + i] - data->frame[c];
        }
    }
    data->frame_start = method->t;
    data->since_jump = 0;
    return DL_OK;
}

static dl_status create_arrays(dl_method *method, dl_error *error) {
    conserving *const data = method->data;
    double **const arrays[] = {&data->q, &data->v,       &data->displacement,
                               &data->a, &data->past[0], &data->past[1]};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        *arrays[k] = calloc(method->n + 1, sizeof(double));
        if (!*arrays[k])
            return dl_fail_memory(error, "the conserving scheme's state");
    }
    return DL_OK;
}

static dl_status conserving_create(dl_method *method, dl_error *error) {
    conserving *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "the conserving scheme");
    const conserving_options *const options = method->options;
    method->step = options->step;
    dl_status status = create_arrays(method, error);
    if (status)
        return status;
    const dl_conserving_step step = {
        .n = method->n,
        .h = options->step,
        .q = data->q,
        .v = data->v,
        .delta = data->displacement,
        .a = data->a,
    };
    status = dl_conserving_solver_create(
        &data->solver, method->model, *(const dl_solver_kind *)method->row->variant, &step,
        options->tolerance, options->iterations, options->depth, error);
    return status ? status : conserving_jumped(method, error);
}

static void add_stats(const dl_conserving_solver *solver, dl_method_stats *stats) {
    stats->nonlinear_iterations += solver->iterations;
    stats->factorisations += solver->factorisations;
}

static void conserving_stats(const dl_method *method, dl_method_stats *stats) {
    const conserving *const data = method->data;
    stats->steps = data->steps;
    add_stats(&data->solver, stats);
    if (data->rescue)
        add_stats(data->rescue, stats);
}

static void conserving_destroy(dl_method *method) {
    conserving *const data = method->data;
    if (!data)
        return;
    dl_conserving_solver_free(&data->solver);
    if (data->rescue)
        dl_conserving_solver_free(data->rescue);
    double *const arrays[] = {data->q, data->v,       data->displacement,
                              data->a, data->past[0], data->past[1]};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
    free(data->rescue);
    free(data);
}

static const dl_method_ops ops = {
    .create = conserving_create,
    .advance = conserving_advance,
    .jumped = conserving_jumped,
    .stats = conserving_stats,
    .destroy = conserving_destroy,
};

#define CONSERVING_ROW(symbol, its_name, its_doc, its_solver, its_options, its_flags)              \
    const dl_method_row dl_method_##symbol = {                                                     \
        .name = its_name,                                                                          \
        .family = "conserving",                                                                    \
        .doc = its_doc,                                                                            \
        .order = 2,                                                                                \
        .flags = DL_TIME_SYMMETRIC | DL_CONSERVES_ENERGY | DL_CONSERVES_MOMENTUM | DL_IMPLICIT |   \
                 DL_FIXED_STEP | (its_flags),                                                      \
        .options = DL_OPTIONS_TABLE(its_options),                                                  \
        .options_size = sizeof(conserving_options),                                                \
        .variant = &(const dl_solver_kind){its_solver},                                            \
        .ops = &ops,                                                                               \
    }

CONSERVING_ROW(conserving_fixed_point, "conserving-fixed-point",
               "TR171's energy-conserving scheme, KINSOL's fixed point with Anderson acceleration",
               DL_FIXED_POINT, fixed_point_options, 0);
CONSERVING_ROW(conserving_newton_dense, "conserving-newton-dense",
               "TR171's energy-conserving scheme, KINSOL's Newton with a dense Jacobian",
               DL_NEWTON_DENSE, newton_options, DL_NEEDS_JACOBIAN);
CONSERVING_ROW(conserving_newton_klu, "conserving-newton-klu",
               "TR171's energy-conserving scheme, KINSOL's Newton with a sparse Jacobian (KLU)",
               DL_NEWTON_KLU, newton_options, DL_NEEDS_JACOBIAN);
