/* ARKODE's explicit Runge-Kutta methods (SUNDIALS ERKStep), at a fixed or an adaptive step.
 *
 * Two habits of ARKODE are worked around (seen in 6.4.1). A step that ends at the stop time is
 * returned interpolated: with the linear interpolant that is the step's own value. And a table
 * whose last stage lies at the end of the step is taken for first-same-as-last even where it is
 * not, which costs it its order: a step postprocessor, even an empty one, makes ARKODE evaluate the
 * right-hand side anew. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <arkode/arkode_erkstep.h>

#include "methods/options.h"
#include "methods/registry.h"
#include "methods/sundials.h"

static const char *const table_words[] = {
    "heun-euler-2",     "bogacki-shampine-3", "zonneveld-4", "cash-karp-5", "fehlberg-5",
    "dormand-prince-5", "verner-6",           "fehlberg-8",  NULL,
};

static const ARKODE_ERKTableID table_ids[] = {
    ARKODE_HEUN_EULER_2_1_2, ARKODE_BOGACKI_SHAMPINE_4_2_3, ARKODE_ZONNEVELD_5_3_4,
    ARKODE_CASH_KARP_6_4_5,  ARKODE_FEHLBERG_6_4_5,         ARKODE_DORMAND_PRINCE_7_4_5,
    ARKODE_VERNER_8_5_6,     ARKODE_FEHLBERG_13_7_8,
};

typedef struct erk_options {
    double step, rtol, atol;
    int table;
} erk_options;

static const dl_parameter options[] = {
    DL_OPTION_STEP_OR_ADAPTIVE(erk_options),
    DL_OPTION_RTOL(erk_options),
    DL_OPTION_ATOL(erk_options),
    {
        .name = "table",
        .kind = DL_WORD,
        .offset = offsetof(erk_options, table),
        .unit = "",
        .words = table_words,
        .fallback = "dormand-prince-5",
        .doc = "Runge-Kutta coefficients; the number is the order",
    },
};

static const dl_sundials_meaning meanings[] = {
    {ARK_TOO_MUCH_ACC, DL_STEP_FAILURE, false}, {ARK_ERR_FAILURE, DL_STEP_FAILURE, false},
    {ARK_TOO_CLOSE, DL_STEP_FAILURE, false},    {ARK_CONV_FAILURE, DL_STEP_FAILURE, true},
    {ARK_RHSFUNC_FAIL, DL_ERROR, true},         {ARK_FIRST_RHSFUNC_ERR, DL_ERROR, true},
    {ARK_REPTD_RHSFUNC_ERR, DL_ERROR, true},    {ARK_UNREC_RHSFUNC_ERR, DL_ERROR, true},
    {ARK_MEM_FAIL, DL_MEMORY, false},           {0, DL_ERROR, false},
};

/* Shorter steps tried where a stage has no finite acceleration: ARKODE itself gives up at once. */
enum { most_retries = 20 };

typedef struct erk {
    dl_sundials sundials; /* first: it is what the right-hand side gets */
    void *memory;
    double *work;      /* [2 unknowns]: where ARKODE writes, also when it fails */
    N_Vector y, state; /* over work and over method->y */
    bool stale;        /* ARKODE's state is not method->y */
    double fixed_step; /* that ARKODE has been told */
} erk;

static int leave_alone(sunrealtype t, N_Vector y, void *user_data) {
    (void)t;
    (void)y;
    (void)user_data;
    return 0;
}

/* Whether ARKODE would take the last stage for the next step's first although it is not. */
static bool last_stage_misleads(void *memory) {
    ARKodeButcherTable table = NULL;
    if (ERKStepGetCurrentButcherTable(memory, &table) != ARK_SUCCESS || !table)
        return true;
    const int last = table->stages - 1;
    double difference = 0;
    for (int j = 0; j <= last; j++)
        difference += fabs(table->b[j] - table->A[last][j]);
    return difference > 1e-12 && fabs(table->c[last] - 1) < 1e-12;
}

static int set_up(erk *data, const erk_options *chosen) {
    void *const memory = data->memory;
    int flag = dl_sundials_listen_erk(&data->sundials, memory);
    if (!flag)
        flag = ERKStepSetUserData(memory, data);
    if (!flag)
        flag = ERKStepSStolerances(memory, chosen->rtol, chosen->atol);
    if (!flag)
        flag = ERKStepSetTableNum(memory, table_ids[chosen->table]);
    if (!flag)
        flag = ERKStepSetInterpolantDegree(memory, 1);
    if (!flag && chosen->step > 0)
        flag = ERKStepSetFixedStep(memory, data->fixed_step = chosen->step);
    if (!flag && last_stage_misleads(memory))
        flag = ERKStepSetPostprocessStepFn(memory, leave_alone);
    return flag;
}

static dl_status erk_create(dl_method *method, dl_error *error) {
    const erk_options *const chosen = method->options;
    method->step = chosen->step;
    dl_status status = dl_method_refuse_unused_tolerances(method, chosen->step, error);
    if (status)
        return status;
    erk *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "ARKODE");
    status = dl_sundials_create(&data->sundials, method->model, error);
    if (status)
        return status;
    const size_t length = 2 * method->n;
    data->work = malloc(length * sizeof *data->work);
    data->y = dl_sundials_vector(&data->sundials, data->work, length);
    data->state = dl_sundials_vector(&data->sundials, method->y, length);
    if (data->work && data->y && data->state)
        data->memory = ERKStepCreate(dl_sundials_rhs, 0, data->state, data->sundials.context);
    if (!data->memory)
        return dl_fail_memory(error, "ARKODE");
    const int flag = set_up(data, chosen);
    return flag ? dl_sundials_fail(&data->sundials, meanings, flag, "ERKStep", error) : DL_OK;
}

/* One call of ARKODE from method->t, method->y. */
static int attempt(const dl_method *method, double t_stop, double *t) {
    erk *const data = method->data;
    int flag = ARK_SUCCESS;
    if (data->stale)
        flag = ERKStepReset(data->memory, method->t, data->state);
    if (flag == ARK_SUCCESS && method->step != data->fixed_step)
        flag = ERKStepSetFixedStep(data->memory, data->fixed_step = method->step);
    if (flag == ARK_SUCCESS && !(method->step > 0))
        flag = ERKStepSetStopTime(data->memory, t_stop);
    data->stale = false;
    if (flag == ARK_SUCCESS)
        flag = ERKStepEvolve(data->memory, method->step > 0 ? method->t + method->step : t_stop,
                             data->y, t, ARK_ONE_STEP);
    return flag;
}

/* Goes back to method->y with a quarter of the step that failed; false where there is none. */
static bool shorten(const dl_method *method) {
    erk *const data = method->data;
    double step = 0;
    if (method->step > 0 || data->sundials.model_status != DL_UNSTABLE ||
        ERKStepGetCurrentStep(data->memory, &step) != ARK_SUCCESS || !(step > 0) ||
        method->t + step / 4 <= method->t)
        return false;
    return ERKStepReset(data->memory, method->t, data->state) == ARK_SUCCESS &&
           ERKStepSetInitStep(data->memory, step / 4) == ARK_SUCCESS;
}

static dl_status erk_advance(dl_method *method, double t_stop, dl_error *error) {
    erk *const data = method->data;
    double t = method->t;
    dl_sundials_begin(&data->sundials);
    int flag = attempt(method, t_stop, &t);
    for (int retry = 0; flag < 0 && retry < most_retries && shorten(method); retry++) {
        dl_sundials_begin(&data->sundials);
        flag = attempt(method, t_stop, &t);
    }
    if (flag < 0) {
        data->stale = true;
        return dl_sundials_fail(&data->sundials, meanings, flag, "ERKStepEvolve", error);
    }
    memcpy(method->y, data->work, 2 * method->n * sizeof *method->y);
    method->t = t;
    if (method->step > 0)
        dl_method_count_step(method);
    return DL_OK;
}

static dl_status erk_jumped(dl_method *method, dl_error *error) {
    (void)error;
    ((erk *)method->data)->stale = true;
    return DL_OK;
}

static void erk_stats(const dl_method *method, dl_method_stats *stats) {
    const erk *const data = method->data;
    long steps = 0, attempts = 0;
    ERKStepGetNumSteps(data->memory, &steps);
    ERKStepGetNumStepAttempts(data->memory, &attempts);
    stats->steps = (unsigned long)steps;
    stats->rejected = (unsigned long)(attempts - steps);
}

static void erk_destroy(dl_method *method) {
    erk *const data = method->data;
    if (!data)
        return;
    if (data->memory)
        ERKStepFree(&data->memory);
    N_VDestroy(data->y);
    N_VDestroy(data->state);
    dl_sundials_destroy(&data->sundials);
    free(data->work);
    free(data);
}

static const dl_method_ops ops = {
    .create = erk_create,
    .advance = erk_advance,
    .jumped = erk_jumped,
    .stats = erk_stats,
    .destroy = erk_destroy,
};

const dl_method_row dl_method_arkode_erk = {
    .name = "arkode-erk",
    .family = "ARKODE",
    .doc = "explicit Runge-Kutta by a chosen table, fixed or adaptive step (SUNDIALS ARKODE)",
    .order = 0,
    .flags = DL_ADAPTIVE | DL_FIXED_STEP,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(erk_options),
    .ops = &ops,
};
