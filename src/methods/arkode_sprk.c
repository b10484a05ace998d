/* ARKODE's symplectic partitioned Runge-Kutta methods (SUNDIALS SPRKStep, since 6.6):
 *
 *     v' = a(q),   q' = v
 */
#include "methods/arkode.h"

#if DL_SUNDIALS_AT_LEAST(6, 6)

#include <arkode/arkode_sprkstep.h>
#include <string.h>

#include "methods/sundials_tables.h"

typedef struct sprk_options {
    dl_arkode_options common; /* but for the step: not options */
    int table;
    bool compensated;
} sprk_options;

static const char *const words[] = {
#define WORD(word, id) word,
    DL_SPRK_TABLES(WORD) NULL,
#undef WORD
};

static const char *const names[] = {
#define NAME(word, id) #id,
    DL_SPRK_TABLES(NAME)
#undef NAME
};

static bool describe(const char *const *of_words, size_t index, dl_method_table *found) {
    ARKodeSPRKTable table = of_words == words ? ARKodeSPRKTable_LoadByName(names[index]) : NULL;
    if (!table)
        return false;
    *found = (dl_method_table){.order = table->q, .stages = table->stages};
    ARKodeSPRKTable_Free(table);
    return true;
}

static int rate_of_velocities(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data) {
    (void)t;
    dl_sundials *const sundials = user_data;
    double *const rate = N_VGetArrayPointer(ydot);
    const size_t n = sundials->model->unknowns;
    dl_error error;
    memset(rate, 0, n * sizeof *rate);
    const dl_status status =
        dl_model_acceleration(sundials->model, N_VGetArrayPointer(y), rate + n, &error);
    return dl_sundials_answer(sundials, status, &error);
}

static int rate_of_positions(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data) {
    (void)t;
    const size_t n = ((const dl_sundials *)user_data)->model->unknowns;
    double *const rate = N_VGetArrayPointer(ydot);
    memcpy(rate, N_VGetArrayPointer(y) + n, n * sizeof *rate);
    memset(rate + n, 0, n * sizeof *rate);
    return 0;
}

static void *create(dl_method *method) {
    const dl_arkode *const data = method->data;
    return SPRKStepCreate(rate_of_velocities, rate_of_positions, 0, data->state,
                          data->implicit.sundials.context);
}

static dl_status set_up(dl_method *method, dl_error *error) {
    dl_arkode *const data = method->data;
    const sprk_options *const chosen = method->options;
    int flag = SPRKStepSetMethodName(data->memory, names[chosen->table]);
    if (!flag)
        flag = data->calls->set_compensated(data->memory, 1);
    /* Switched off, not left off: before 7.3 a reset clears a vector that only the sums make. */
    if (!flag && !chosen->compensated)
        flag = data->calls->set_compensated(data->memory, 0);
    return flag ? dl_arkode_fail(data, flag, "SPRKStep", error) : DL_OK;
}

static const dl_parameter options[] = {
    DL_OPTION_FIXED_STEP(dl_arkode_options),
    DL_OPTION_TABLE(sprk_options, words, "mclachlan-4", "symplectic coefficients"),
    {
        .name = "compensated",
        .kind = DL_FLAG,
        .offset = offsetof(sprk_options, compensated),
        .unit = "",
        .fallback = "false",
        .doc = "compensated summation of the state",
    },
};

static const dl_arkode_kind kind = {
    .calls = &dl_sprkstep_calls,
    .create = create,
    .set_up = set_up,
};

const dl_method_row dl_method_arkode_sprk = {
    .name = "arkode-sprk",
    .family = "ARKODE",
    .doc = "symplectic partitioned Runge-Kutta by a chosen table (SUNDIALS ARKODE)",
    .table = describe,
    .flags = DL_SYMPLECTIC | DL_CONSERVES_MOMENTUM | DL_FIXED_STEP,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(sprk_options),
    .variant = &kind,
    .ops = &dl_arkode_ops,
};

#endif
