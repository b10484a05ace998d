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

static const dl_parameter options[] = {
    DL_OPTION_RTOL(dl_arkode_options),
    DL_OPTION_ATOL(dl_arkode_options),
    DL_OPTION_TABLE(dl_erk_options, words, "cash-karp-5",
                    "Runge-Kutta coefficients with no negative weight"),
};

typedef struct relaxation {
    double scale;     /* of the energy */
    double last_step; /* that no stop has cut short; 0: none yet */
} relaxation;

/* --- the energy --------------------------------------------------------------------------------
 * In parts of its scale: ARKODE's tolerances for it are absolute. */

static int energy_of(N_Vector y, sunrealtype *energy, void *user_data) {
    dl_arkode *const data = user_data;
    dl_sundials *const sundials = &data->implicit.sundials;
    dl_energy found = {0};
    dl_error error = {""};
    const dl_status status =
        dl_model_energy(sundials->model, N_VGetArrayPointer(y), &found, &error);
    *energy = found.total / ((const relaxation *)data->inner)->scale;
    return dl_sundials_answer(sundials, status, &error);
}

static int gradient_of(N_Vector y, N_Vector gradient, void *user_data) {
    dl_arkode *const data = user_data;
    dl_sundials *const sundials = &data->implicit.sundials;
    dl_error error = {""};
    const dl_status status = dl_model_energy_gradient(sundials->model, N_VGetArrayPointer(y),
                                                      N_VGetArrayPointer(gradient), &error);
    N_VScale(1 / ((const relaxation *)data->inner)->scale, gradient, gradient);
    return dl_sundials_answer(sundials, status, &error);
}

static dl_status set_up(dl_method *method, dl_error *error) {
    dl_arkode *const data = method->data;
    const ARKODE_ERKTableID id = ids[((const dl_erk_options *)method->options)->table];
    dl_status status = dl_erk_set_table(method, id, error);
    relaxation *const own = data->inner = calloc(1, sizeof *own);
    if (!status && !own)
        status = dl_fail_memory(error, "ARKODE");
    if (!status)
        status = dl_model_energy_scale(method->model, method->y, &own->scale, error);
    if (status)
        return status;
    const int flag = data->calls->set_relaxation(data->memory, energy_of, gradient_of);
    return flag ? dl_arkode_fail(data, flag, "ARKODE's relaxation", error) : DL_OK;
}

/* --- the step to a stop ------------------------------------------------------------------------
 * What is left, relaxed, ends a little before or behind: taken again, as much longer or shorter,
 * until it ends there. */

enum { most_landings = 8 };
static const double near_the_stop = 0.01; /* of the step */

static bool has_landed(double t_stop, double t) {
    return fabs(t_stop - t) <= 4 * DBL_EPSILON * fabs(t_stop);
}

static int try_landing(const dl_method *method, double step, double t_stop, double *t) {
    dl_arkode *const data = method->data;
    const dl_arkode_calls *const calls = data->calls;
    int flag = calls->reset(data->memory, method->t, data->state);
    if (!flag)
        flag = calls->set_fixed_step(data->memory, step);
    if (!flag) /* out of the way */
        flag = calls->set_stop_time(data->memory, t_stop + step);
    data->discarded++;
    return flag ? flag : calls->evolve(data->memory, method->t + step, data->y, t, ARK_ONE_STEP);
}

static int land(const dl_method *method, double t_stop, double *t) {
    dl_arkode *const data = method->data;
    const dl_arkode_calls *const calls = data->calls;
    relaxation *const own = data->inner;
    const double left = t_stop - method->t;
    double step = *t - method->t;
    int flag = ARK_SUCCESS;
    if (*t < t_stop - near_the_stop * step) {
        own->last_step = step;
        return flag;
    }
    step = left;
    for (int k = 0; !flag && k < most_landings && !has_landed(t_stop, *t); k++) {
        step *= left / (*t - method->t);
        flag = try_landing(method, step, t_stop, t);
    }
    data->stale = true; /* for a step of ARKODE's own choice again */
    if (flag < 0)
        return flag;
    if (!has_landed(t_stop, *t))
        return ARK_TOO_CLOSE;
    *t = t_stop;
    flag = calls->set_fixed_step(data->memory, 0);
    return flag ? flag : calls->set_first_step(data->memory, own->last_step);
}

static void destroy(dl_arkode *data) {
    free(data->inner);
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
    .order = 0,
    .flags = DL_ADAPTIVE | DL_CONSERVES_ENERGY,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(dl_erk_options),
    .variant = &kind,
    .ops = &dl_arkode_ops,
};

#endif
