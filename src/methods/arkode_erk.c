/* ARKODE's explicit Runge-Kutta methods (SUNDIALS ERKStep). */
#include <arkode/arkode_erkstep.h>

#include "methods/arkode.h"
#include "methods/arkode_erk.h"
#include "methods/sundials_tables.h"

#define WORD(word, id) word,
const char *const dl_erk_words[] = {DL_ERK_TABLES(WORD) NULL};
#undef WORD

#define ID(word, id) id,
const ARKODE_ERKTableID dl_erk_ids[] = {DL_ERK_TABLES(ID)};
#undef ID

static const dl_parameter options[] = {
    DL_OPTION_STEP_OR_ADAPTIVE(dl_arkode_options),
    DL_OPTION_RTOL(dl_arkode_options),
    DL_OPTION_ATOL(dl_arkode_options),
    DL_OPTION_TABLE(dl_erk_options, dl_erk_words, "dormand-prince-5", "Runge-Kutta coefficients"),
};

bool dl_erk_describe(const char *const *of_words, size_t index, dl_method_table *found) {
    return of_words == dl_erk_words &&
           dl_arkode_describe(ARKodeButcherTable_LoadERK(dl_erk_ids[index]), found);
}

void *dl_erk_create(dl_method *method) {
    const dl_arkode *const data = method->data;
    return ERKStepCreate(dl_sundials_rhs, 0, data->state, data->implicit.sundials.context);
}

dl_status dl_erk_set_table(dl_method *method, ARKODE_ERKTableID id, dl_error *error) {
    dl_arkode *const data = method->data;
    ARKodeButcherTable table = ARKodeButcherTable_LoadERK(id);
    if (!table)
        return dl_fail_memory(error, "a Butcher table");
    const dl_status status = dl_arkode_check_estimate(method, table, error);
    int flag = ERKStepSetTableNum(data->memory, id);
    if (!flag)
        flag = dl_arkode_mend_last_stage(data, table, NULL);
    ARKodeButcherTable_Free(table);
    return !status && flag ? dl_arkode_fail(data, flag, "ERKStep", error) : status;
}

static dl_status set_up(dl_method *method, dl_error *error) {
    return dl_erk_set_table(method, dl_erk_ids[((const dl_erk_options *)method->options)->table],
                            error);
}

static const dl_arkode_kind kind = {
    .calls = &dl_erkstep_calls,
    .create = dl_erk_create,
    .set_up = set_up,
};

const dl_method_row dl_method_arkode_erk = {
    .name = "arkode-erk",
    .family = "ARKODE",
    .doc = "explicit Runge-Kutta by a chosen table, fixed or adaptive step (SUNDIALS ARKODE)",
    .table = dl_erk_describe,
    .flags = DL_ADAPTIVE | DL_FIXED_STEP,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(dl_erk_options),
    .variant = &kind,
    .ops = &dl_arkode_ops,
};
