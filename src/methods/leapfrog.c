/* The leap-frog of the papers (TR299 (2.1)-(2.3), TR323 (3.1)-(3.3)), in the order of TR323's
 * program: force, velocities, positions; walls afterwards, on half-step velocities.
 *
 *     v_{1/2}   = v_0 + (h/2) a_0
 *     v_{k+1/2} = v_{k-1/2} + h a_k
 *     x_{k+1}   = x_k + h v_{k+1/2}
 *
 * After the first step the velocities in y are half a step behind the positions; the velocity at
 * t_k is the mean of its half-step neighbours, v_k = v_{k-1/2} + (h/2) a_k.
 *
 * Where nothing acts a step is its drift alone, and where gravity alone does there is nothing to
 * evaluate.
 *
 * Where hits or crossings are located a step may be of any length and begin or end at one. There y
 * holds v_k: a step begins and ends with half a kick, and the positions are the same but for
 * roundoff. */
#include <stdlib.h>
#include <string.h>

#include "methods/motion.h"
#include "methods/options.h"
#include "methods/registry.h"

typedef struct leapfrog_options {
    double step;
} leapfrog_options;

static const dl_parameter options[] = {DL_OPTION_FIXED_STEP(leapfrog_options)};

typedef struct leapfrog {
    double *a;        /* [unknowns]; NULL: there is nothing to evaluate */
    double *next;     /* [2 unknowns]: a synchronous step's end, so that a failure leaves y alone */
    bool synchronous; /* y holds the velocities at its own time */
    bool a_is_current; /* and a the acceleration at y */
    unsigned long steps;
} leapfrog;

static dl_status leapfrog_create(dl_method *method, dl_error *error) {
    method->step = ((const leapfrog_options *)method->options)->step;
    leapfrog *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "leap-frog");
    const dl_model *const model = method->model;
    if (!model->has_force || model->is_uniform)
        return DL_OK;
    data->synchronous = model->locates_hits || model->locates_crossings;
    data->a = malloc(method->n * sizeof *data->a);
    if (data->synchronous)
        data->next = malloc(2 * method->n * sizeof *data->next);
    return data->a && (data->next || !data->synchronous)
               ? DL_OK
               : dl_fail_memory(error, "leap-frog's accelerations");
}

static dl_status advance_synchronous(dl_method *method, dl_error *error) {
    leapfrog *const data = method->data;
    const size_t n = method->n;
    const double h = method->step;
    double *const v = data->next + n;
    dl_status status = DL_OK;
    if (!data->a_is_current)
        status = dl_model_acceleration(method->model, method->y, data->a, error);
    if (status)
        return status;
    data->a_is_current = false;
    memcpy(data->next, method->y, 2 * n * sizeof *data->next);
    dl_kick_and_drift(n, h / 2, h, data->a, data->next, v);
    status = dl_model_acceleration(method->model, data->next, data->a, error);
    if (status)
        return status;
    dl_kick_and_drift(n, h / 2, 0, data->a, data->next, v);
    memcpy(method->y, data->next, 2 * n * sizeof *data->next);
    data->a_is_current = true;
    data->steps++;
    dl_method_count_step(method);
    return DL_OK;
}

static dl_status leapfrog_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    leapfrog *const data = method->data;
    if (data->synchronous)
        return advance_synchronous(method, error);
    const double h = method->step, kick = data->steps ? h : h / 2;
    double *const q = method->y, *const v = method->y + method->n;
    if (data->a) {
        const dl_status status = dl_model_acceleration(method->model, q, data->a, error);
        if (status)
            return status;
        dl_kick_and_drift(method->n, kick, h, data->a, q, v);
    } else if (method->model->is_uniform)
        dl_fall(method->model, kick, h, q, v);
    else
        dl_drift(method->n, h, q, v);
    data->steps++;
    dl_method_count_step(method);
    return DL_OK;
}

static dl_status leapfrog_state(dl_method *method, double *y_out, dl_error *error) {
    leapfrog *const data = method->data;
    const size_t n = method->n;
    memcpy(y_out, method->y, 2 * n * sizeof *y_out);
    if (data->steps == 0 || data->synchronous || !method->model->has_force)
        return DL_OK;
    if (method->model->is_uniform) {
        dl_fall(method->model, method->step / 2, 0, y_out, y_out + n);
        return DL_OK;
    }
    const dl_counts counts = method->model->counts;
    const dl_status status = dl_model_acceleration(method->model, method->y, data->a, error);
    method->model->counts = counts;
    for (size_t i = 0; i < n && !status; i++)
        y_out[n + i] += method->step / 2 * data->a[i];
    return status;
}

/* A mirror's reflection acts on the half-step velocities and the method goes on with them. */
static dl_status leapfrog_jumped(dl_method *method, dl_error *error) {
    (void)error;
    ((leapfrog *)method->data)->a_is_current = false;
    return DL_OK;
}

static void leapfrog_stats(const dl_method *method, dl_method_stats *stats) {
    stats->steps = ((const leapfrog *)method->data)->steps;
}

static void leapfrog_destroy(dl_method *method) {
    leapfrog *const data = method->data;
    if (data) {
        free(data->a);
        free(data->next);
    }
    free(data);
}

static const dl_method_ops ops = {
    .create = leapfrog_create,
    .advance = leapfrog_advance,
    .state = leapfrog_state,
    .jumped = leapfrog_jumped,
    .stats = leapfrog_stats,
    .destroy = leapfrog_destroy,
};

const dl_method_row dl_method_leapfrog = {
    .name = "leapfrog",
    .family = "leap-frog",
    .doc = "the papers' leap-frog with half-step start (TR299 (2.1)-(2.3), TR323 (3.1)-(3.3))",
    .order = 2,
    .stages = 1,
    .forces = 1,
    .flags = DL_SYMPLECTIC | DL_TIME_SYMMETRIC | DL_CONSERVES_MOMENTUM | DL_FIXED_STEP,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(leapfrog_options),
    .ops = &ops,
};
