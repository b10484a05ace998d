#include "methods/arkode.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const dl_sundials_meaning meanings[] = {
    {ARK_TOO_MUCH_ACC, DL_STEP_FAILURE, false},
    {ARK_ERR_FAILURE, DL_STEP_FAILURE, false},
    {ARK_TOO_CLOSE, DL_STEP_FAILURE, false},
    {ARK_CONV_FAILURE, DL_NONLINEAR_FAILURE, true},
    {ARK_LINIT_FAIL, DL_NONLINEAR_FAILURE, true},
    {ARK_LSETUP_FAIL, DL_NONLINEAR_FAILURE, true},
    {ARK_LSOLVE_FAIL, DL_NONLINEAR_FAILURE, true},
    {ARK_NLS_SETUP_FAIL, DL_NONLINEAR_FAILURE, true},
    {ARK_NLS_OP_ERR, DL_NONLINEAR_FAILURE, true},
    {ARK_RHSFUNC_FAIL, DL_ERROR, true},
    {ARK_FIRST_RHSFUNC_ERR, DL_ERROR, true},
    {ARK_REPTD_RHSFUNC_ERR, DL_ERROR, true},
    {ARK_UNREC_RHSFUNC_ERR, DL_ERROR, true},
    {ARK_INNERSTEP_FAIL, DL_STEP_FAILURE, true},
#if DL_SUNDIALS_AT_LEAST(6, 6)
    {ARK_RELAX_FAIL, DL_STEP_FAILURE, true},
    {ARK_RELAX_FUNC_FAIL, DL_ERROR, true},
    {ARK_RELAX_JAC_FAIL, DL_ERROR, true},
#endif
    {ARK_MEM_FAIL, DL_MEMORY, false},
    {0, DL_ERROR, false},
};

/* Shorter steps tried where a stage has no finite acceleration: ARKODE itself gives up at once. */
enum { most_retries = 20 };

dl_status dl_arkode_fail(const dl_arkode *data, int flag, const char *function, dl_error *error) {
    return dl_sundials_fail(&data->implicit.sundials, meanings, flag, function, error);
}

/* --- tables ------------------------------------------------------------------------------------
 */

static int leave_alone(sunrealtype t, N_Vector y, void *user_data) {
    (void)t, (void)y, (void)user_data;
    return 0;
}

static bool last_stage_misleads(ARKodeButcherTable table) {
    if (!table)
        return false;
    const int last = table->stages - 1;
    double difference = 0;
    for (int j = 0; j <= last; j++)
        difference += fabs(table->b[j] - table->A[last][j]);
    return difference > 1e-12 && fabs(table->c[last] - 1) < 1e-12;
}

int dl_arkode_mend_last_stage(dl_arkode *data, ARKodeButcherTable explicit_part,
                              ARKodeButcherTable implicit_part) {
    return last_stage_misleads(explicit_part) || last_stage_misleads(implicit_part)
               ? data->calls->set_after_step(data->memory, leave_alone)
               : ARK_SUCCESS;
}

dl_status dl_arkode_check_estimate(const dl_method *method, ARKodeButcherTable table,
                                   dl_error *error) {
    if (method->step > 0 || table->p > 0)
        return DL_OK;
    return dl_fail(error, DL_INPUT,
                   "method %s: found step=0 with a table that has no error estimate to choose the "
                   "step by, expected a step",
                   method->row->name);
}

bool dl_arkode_describe(ARKodeButcherTable table, dl_method_table *found) {
    if (!table)
        return false;
    *found = (dl_method_table){.order = table->q, .stages = table->stages};
    ARKodeButcherTable_Free(table);
    return true;
}

/* --- parts of the force ------------------------------------------------------------------------
 */

static int rhs_of_part(dl_part part, N_Vector y, N_Vector ydot, dl_sundials *sundials) {
    const double *const state = N_VGetArrayPointer(y);
    double *const rate = N_VGetArrayPointer(ydot);
    const size_t n = sundials->model->unknowns;
    dl_error error;
    if (part == DL_PART_FAST)
        memcpy(rate, state + n, n * sizeof *rate);
    else
        memset(rate, 0, n * sizeof *rate);
    const dl_status status =
        dl_model_part_acceleration(sundials->model, part, state, rate + n, &error);
    return dl_sundials_answer(sundials, status, &error);
}

int dl_arkode_rhs_fast(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data) {
    (void)t;
    return rhs_of_part(DL_PART_FAST, y, ydot, user_data);
}

int dl_arkode_rhs_slow(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data) {
    (void)t;
    return rhs_of_part(DL_PART_SLOW, y, ydot, user_data);
}

static dl_status split(const dl_method *method, dl_error *error) {
    dl_error reason = {""};
    const dl_status status = dl_model_split(method->model, &reason);
    return status ? dl_fail(error, status, "method %s splits the force: %.900s", method->row->name,
                            reason.message)
                  : DL_OK;
}

/* --- life --------------------------------------------------------------------------------------
 */

/* Of a step, where the error test fails: as CVODE's (cvode.c), where ARKODE's own are 7. */
enum { most_attempts = 20 };

/* What every kind is told. */
static int set_up_stepper(const dl_method *method) {
    dl_arkode *const data = method->data;
    const dl_arkode_calls *const calls = data->calls;
    const dl_arkode_options *const chosen = method->options;
    int flag = dl_sundials_listen_arkode(&data->implicit.sundials, calls, data->memory);
    if (!flag)
        flag = calls->set_user_data(data->memory, data);
    if (!flag && chosen->atol > 0)
        flag = calls->set_tolerances(data->memory, chosen->rtol, chosen->atol);
    if (!flag)
        flag = calls->set_interpolant_degree(data->memory, 1);
    if (!flag && method->row->flags & DL_ADAPTIVE)
        flag = calls->set_most_attempts(data->memory, most_attempts);
    return flag;
}

static dl_status arkode_create(dl_method *method, dl_error *error) {
    const dl_arkode_kind *const kind = method->row->variant;
    const dl_arkode_options *const chosen = method->options;
    method->step = chosen->step;
    dl_arkode *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "ARKODE");
    data->calls = kind->calls;
    dl_sundials *const sundials = &data->implicit.sundials;
    dl_status status = kind->splits ? split(method, error) : DL_OK;
    if (!status)
        status = dl_sundials_create(sundials, method->model, error);
    if (status)
        return status;
    const size_t length = 2 * method->n;
    data->work = malloc(length * sizeof *data->work);
    data->y = dl_sundials_vector(sundials, data->work, length);
    data->state = dl_sundials_vector(sundials, method->y, length);
    if (data->work && data->y && data->state)
        data->memory = kind->create(method);
    if (!data->memory)
        return dl_fail_memory(error, "ARKODE");
    const int flag = set_up_stepper(method);
    return flag ? dl_arkode_fail(data, flag, "ARKODE", error) : kind->set_up(method, error);
}

static void arkode_destroy(dl_method *method) {
    const dl_arkode_kind *const kind = method->row->variant;
    dl_arkode *const data = method->data;
    if (!data)
        return;
    if (data->memory)
        data->calls->free(&data->memory);
    if (kind->destroy)
        kind->destroy(data);
    dl_implicit_free(&data->implicit);
    N_VDestroy(data->y);
    N_VDestroy(data->state);
    dl_sundials_destroy(&data->implicit.sundials);
    free(data->work);
    free(data);
}

/* --- steps -------------------------------------------------------------------------------------
 */

int dl_arkode_evolve(const dl_method *method, double t_stop, double *t) {
    const dl_arkode_kind *const kind = method->row->variant;
    dl_arkode *const data = method->data;
    const dl_arkode_calls *const calls = data->calls;
    const double step = method->step;
    int flag = ARK_SUCCESS;
    if (data->stale)
        flag = calls->reset(data->memory, method->t, data->state);
    if (!flag && step != data->fixed_step) {
        data->fixed_step = step;
        flag = calls->set_fixed_step(data->memory, step);
        if (!flag && kind->change_step)
            flag = kind->change_step(method);
    }
    if (!flag && !(step > 0))
        flag = calls->set_stop_time(data->memory, t_stop);
    data->stale = false;
    if (!flag)
        flag = calls->evolve(data->memory, step > 0 ? method->t + step : t_stop, data->y, t,
                             ARK_ONE_STEP);
    return flag;
}

/* Goes back to method->y with a quarter of the step that failed; false where there is none. */
static bool shorten(const dl_method *method) {
    dl_arkode *const data = method->data;
    double step = 0;
    if (method->step > 0 || data->implicit.sundials.model_status != DL_UNSTABLE ||
        data->calls->current_step(data->memory, &step) != ARK_SUCCESS || !(step > 0) ||
        method->t + step / 4 <= method->t)
        return false;
    return data->calls->reset(data->memory, method->t, data->state) == ARK_SUCCESS &&
           data->calls->set_first_step(data->memory, step / 4) == ARK_SUCCESS;
}

static dl_status arkode_advance(dl_method *method, double t_stop, dl_error *error) {
    const dl_arkode_kind *const kind = method->row->variant;
    dl_arkode *const data = method->data;
    double t = method->t;
    dl_sundials_begin(&data->implicit.sundials);
    int flag = dl_arkode_evolve(method, t_stop, &t);
    for (int retry = 0; flag < 0 && retry < most_retries && shorten(method); retry++) {
        dl_sundials_begin(&data->implicit.sundials);
        flag = dl_arkode_evolve(method, t_stop, &t);
    }
    if (flag >= 0 && kind->land)
        flag = kind->land(method, t_stop, &t);
    if (flag < 0) {
        data->stale = true;
        if (flag == ARK_ILL_INPUT && method->step == 0 && dl_sundials_too_near(method->t, t_stop))
            return dl_sundials_fail_near(method->row->name, method->t, t_stop, error);
        return dl_arkode_fail(data, flag, "ARKODE", error);
    }
    memcpy(method->y, data->work, 2 * method->n * sizeof *method->y);
    method->t = t;
    if (method->step > 0)
        dl_method_count_step(method);
    return DL_OK;
}

static dl_status arkode_jumped(dl_method *method, dl_error *error) {
    (void)error;
    ((dl_arkode *)method->data)->stale = true;
    return DL_OK;
}

static void arkode_stats(const dl_method *method, dl_method_stats *stats) {
    const dl_arkode *const data = method->data;
    long steps = 0, attempts = 0;
    data->calls->steps(data->memory, &steps);
    stats->steps = (unsigned long)steps - data->discarded;
    if (data->calls->attempts && !data->calls->attempts(data->memory, &attempts))
        stats->rejected = (unsigned long)(attempts - steps) + data->discarded;
    if (data->implicit.calls)
        dl_implicit_add_stats(&data->implicit, data->memory, stats);
}

const dl_method_ops dl_arkode_ops = {
    .create = arkode_create,
    .advance = arkode_advance,
    .jumped = arkode_jumped,
    .stats = arkode_stats,
    .destroy = arkode_destroy,
};
