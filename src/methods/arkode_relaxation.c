/* ARKODE's explicit Runge-Kutta methods with relaxation (since SUNDIALS 6.6; Ketcheson 2019,
 * doi:10.1137/19M1263662): a step is taken the part gamma of its way at which the energy is that
 * of its start,
 *
 *     y_1 = y_0 + gamma h sum b_i f_i,   t_1 = t_0 + gamma h,   E(y_1) = E(y_0),
 *
 * with gamma - 1 of the order h^(p-1). Steps are of ARKODE's own choice, for gamma makes another
 * step of any. */
#include "methods/arkode.h"

#if DL_SUNDIALS_AT_LEAST(6, 6)

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "methods/arkode_erk.h"
#include "methods/sundials_tables.h"

static const char *const words[] = {
#define WORD(word, id) word,
    DL_RELAXATION_TABLES(WORD) NULL,
#undef WORD
};

static const ARKODE_ERKTableID ids[] = {
#define ID(word, id) id,
    DL_RELAXATION_TABLES(ID)
#undef ID
};

static bool describe(const char *const *of_words, size_t index, dl_method_table *found) {
    return of_words == words && dl_arkode_describe(ARKodeButcherTable_LoadERK(ids[index]), found);
}

static const dl_parameter options[] = {
    DL_OPTION_RTOL(dl_arkode_options),
    DL_OPTION_ATOL(dl_arkode_options),
    DL_OPTION_TABLE(dl_erk_options, words, "cash-karp-5",
                    "Runge-Kutta coefficients with no negative weight"),
};

typedef struct relaxation {
    const dl_method *method;
    double scale;     /* of the energy */
    double last_step; /* that no stop has cut short; 0: none yet */
    int lost;         /* steps in a row that moved no more than the last digits of t */
    double *delta;    /* [unknowns] each: of positions, a mean acceleration, ... */
    double *mean;
    double *change, *sum; /* ... of velocities, and what is added to them */
} relaxation;

/* --- the energy --------------------------------------------------------------------------------
 * Since the start of the step, in parts of its scale: ARKODE's tolerances for it are absolute. It
 * is the work of the mean force over the way, by which pairs that are locked to one side of a
 * breakpoint (model/locks.h) have the potential of that side, as they have its force; and it has no
 * more roundoff than the states. */

/* Of positions; whether there is any. */
static bool find_change(const relaxation *own, const double *y) {
    const dl_method *const method = own->method;
    const double *const v0 = method->y + method->n, *const v1 = y + method->n;
    bool any = false;
    for (size_t u = 0; u < method->n; u++) {
        own->delta[u] = y[u] - method->y[u];
        own->change[u] = v1[u] - v0[u];
        own->sum[u] = v1[u] + v0[u];
        any |= own->delta[u] != 0;
    }
    return any;
}

static int energy_of(N_Vector y, sunrealtype *energy, void *user_data) {
    dl_arkode *const data = user_data;
    dl_sundials *const sundials = &data->implicit.sundials;
    const relaxation *const own = data->inner;
    dl_model *const model = sundials->model;
    dl_error error = {""};
    dl_status status = DL_OK;
    double work = 0;
    if (find_change(own, N_VGetArrayPointer(y))) {
        status =
            dl_model_discrete_acceleration(model, own->method->y, own->delta, own->mean, &error);
        work = dl_model_work(model, own->mean, own->delta);
    }
    *energy = (dl_model_work(model, own->change, own->sum) / 2 - work) / own->scale;
    return dl_sundials_answer(sundials, status, &error);
}

/* What the last digits of a state change in its energy: nothing less can be asked for. */
static int ask_for(const dl_arkode *data, const double *y, const double *gradient, size_t length) {
    double square = 0;
    for (size_t i = 0; i < length; i++)
        square += y[i] * gradient[i] * y[i] * gradient[i];
    return data->calls->set_relaxation_tolerance(data->memory,
                                                 DBL_EPSILON * fmax(10, sqrt(square)));
}

static int gradient_of(N_Vector y, N_Vector gradient, void *user_data) {
    dl_arkode *const data = user_data;
    dl_sundials *const sundials = &data->implicit.sundials;
    const relaxation *const own = data->inner;
    dl_error error = {""};
    const double *const state = N_VGetArrayPointer(y);
    const dl_status status =
        dl_model_energy_gradient(sundials->model, state, N_VGetArrayPointer(gradient), &error);
    N_VScale(1 / own->scale, gradient, gradient);
    const int flag = dl_sundials_answer(sundials, status, &error);
    return flag ? flag : ask_for(data, state, N_VGetArrayPointer(gradient), 2 * own->method->n);
}

static relaxation *relaxation_create(const dl_method *method) {
    relaxation *const own = calloc(1, sizeof *own);
    if (!own)
        return NULL;
    own->method = method;
    own->delta = calloc(4 * method->n, sizeof *own->delta);
    own->mean = own->delta + method->n;
    own->change = own->mean + method->n;
    own->sum = own->change + method->n;
    return own;
}

/* Of one step. No part of a step over a jump of the force has the energy of its start, however
 * short it is, until what the jump changes is lost in roundoff: each attempt takes a quarter of the
 * step before, and ARKODE's own 10 do not come down to there. */
enum { most_attempts = 40 };

static dl_status set_up(dl_method *method, dl_error *error) {
    dl_arkode *const data = method->data;
    const ARKODE_ERKTableID id = ids[((const dl_erk_options *)method->options)->table];
    dl_status status = dl_erk_set_table(method, id, error);
    relaxation *const own = data->inner = relaxation_create(method);
    if (!status && (!own || !own->delta))
        status = dl_fail_memory(error, "ARKODE");
    if (!status)
        status = dl_model_energy_scale(method->model, method->y, &own->scale, error);
    if (status)
        return status;
    int flag = data->calls->set_relaxation(data->memory, energy_of, gradient_of);
    if (!flag)
        flag = data->calls->set_most_relaxations(data->memory, most_attempts);
    return flag ? dl_arkode_fail(data, flag, "ARKODE's relaxation", error) : DL_OK;
}

/* --- the step to a stop ------------------------------------------------------------------------
 * What is left, relaxed, ends a little before or behind: taken again, as much longer or shorter,
 * until it ends there. Where none does, as where a stage of it meets a jump of the force, a half of
 * it is taken, or a quarter ..., from which ARKODE goes on. */

enum { most_landings = 8, most_halvings = 60 };
static const double near_the_stop = 0.01; /* of the step */

static bool has_landed(double t_stop, double t) {
    return fabs(t_stop - t) <= 4 * DBL_EPSILON * fabs(t_stop);
}

static int take(const dl_method *method, double step, double t_stop, double *t) {
    dl_arkode *const data = method->data;
    const dl_arkode_calls *const calls = data->calls;
    int flag = calls->reset(data->memory, method->t, data->state);
    if (!flag)
        flag = calls->set_fixed_step(data->memory, step);
    if (!flag) /* out of the way */
        flag = calls->set_stop_time(data->memory, t_stop + step);
    if (!flag)
        flag = calls->evolve(data->memory, method->t + step, data->y, t, ARK_ONE_STEP);
    data->discarded += flag >= 0; /* the one before */
    return flag;
}

/* Ends at t_stop, or not. */
static int take_all(const dl_method *method, double t_stop, double *t) {
    const double left = t_stop - method->t;
    double step = left;
    int flag = ARK_SUCCESS;
    for (int k = 0; flag >= 0 && k < most_landings && !has_landed(t_stop, *t); k++) {
        step *= left / (*t - method->t);
        flag = take(method, step, t_stop, t);
    }
    if (flag >= 0 && has_landed(t_stop, *t))
        *t = t_stop;
    return flag;
}

static int take_part(const dl_method *method, double t_stop, double *t) {
    dl_arkode *const data = method->data;
    double step = t_stop - method->t;
    int flag = ARK_RELAX_FAIL;
    for (int k = 0; flag < 0 && k < most_halvings; k++) {
        if (dl_sundials_has_failed(&data->implicit.sundials))
            return flag;
        step /= 2;
        flag = take(method, step, t_stop, t);
    }
    return flag;
}

/* Steps of the last digits of t: so many in a row would go on without end. */
enum { most_lost = 100 };

static int give_up(const dl_method *method) {
    dl_sundials *const sundials = &((dl_arkode *)method->data)->implicit.sundials;
    snprintf(sundials->message, sizeof sundials->message,
             "relaxed steps became too short to move t = %.17g", method->t);
    return ARK_TOO_CLOSE;
}

static int land(const dl_method *method, double t_stop, double *t) {
    dl_arkode *const data = method->data;
    const dl_arkode_calls *const calls = data->calls;
    relaxation *const own = data->inner;
    const double step = *t - method->t;
    if (*t < t_stop - near_the_stop * step) {
        own->last_step = step;
        own->lost = step > 4 * DBL_EPSILON * *t ? 0 : own->lost + 1;
        return own->lost < most_lost ? ARK_SUCCESS : give_up(method);
    }
    int flag = take_all(method, t_stop, t);
    if (flag < 0 || *t != t_stop)
        flag = take_part(method, t_stop, t);
    data->stale = true; /* for a step of ARKODE's own choice again */
    const int reset = calls->set_fixed_step(data->memory, 0);
    if (flag >= 0)
        flag = reset;
    return flag < 0 ? flag : calls->set_first_step(data->memory, own->last_step);
}

static void destroy(dl_arkode *data) {
    relaxation *const own = data->inner;
    if (own)
        free(own->delta);
    free(own);
}

/* --- row ---------------------------------------------------------------------------------------
 */

static const dl_arkode_kind kind = {
    .calls = &dl_erkstep_calls,
    .create = dl_erk_create,
    .set_up = set_up,
    .land = land,
    .destroy = destroy,
};

const dl_method_row dl_method_arkode_erk_relaxation = {
    .name = "arkode-erk-relaxation",
    .family = "ARKODE",
    .doc = "explicit Runge-Kutta by a chosen table, relaxed to keep the energy, adaptive step "
           "(SUNDIALS ARKODE)",
    .table = describe,
    .flags = DL_ADAPTIVE | DL_CONSERVES_ENERGY,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(dl_erk_options),
    .variant = &kind,
    .ops = &dl_arkode_ops,
};

#endif
