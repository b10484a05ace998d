/* ARKODE's diagonally implicit Runge-Kutta methods, and its additive ones that take the fast part
 * of the force implicitly and the slow part explicitly (SUNDIALS ARKStep):
 *
 *     y' = f_implicit + f_explicit,   f_implicit = (v, a_fast),   f_explicit = (0, a_slow)
 */
#include <arkode/arkode_arkstep.h>

#include "methods/arkode.h"
#include "methods/sundials_tables.h"

typedef struct dirk_options {
    dl_arkode_options common;
    int table;
    dl_implicit_options implicit;
} dirk_options;

typedef struct pair_of_tables {
    ARKODE_DIRKTableID of_implicit;
    ARKODE_ERKTableID of_explicit;
} pair_of_tables;

static const char *const dirk_words[] = {
#define WORD(word, id) word,
    DL_DIRK_TABLES(WORD) NULL,
#undef WORD
};

static const pair_of_tables dirk_tables[] = {
#define IDS(word, id) {id, ARKODE_ERK_NONE},
    DL_DIRK_TABLES(IDS)
#undef IDS
};

static const char *const imex_words[] = {
#define WORD(word, id, explicit_id) word,
    DL_IMEX_TABLES(WORD) NULL,
#undef WORD
};

static const pair_of_tables imex_tables[] = {
#define IDS(word, id, explicit_id) {id, explicit_id},
    DL_IMEX_TABLES(IDS)
#undef IDS
};

static bool describe_dirk(const char *const *of_words, size_t index, dl_method_table *found) {
    return of_words == dirk_words &&
           dl_arkode_describe(ARKodeButcherTable_LoadDIRK(dirk_tables[index].of_implicit), found);
}

/* Both tables of a pair have as many stages. */
static bool describe_imex(const char *const *of_words, size_t index, dl_method_table *found) {
    return of_words == imex_words &&
           dl_arkode_describe(ARKodeButcherTable_LoadDIRK(imex_tables[index].of_implicit), found);
}

static void *create_dirk(dl_method *method) {
    const dl_arkode *const data = method->data;
    return ARKStepCreate(NULL, dl_sundials_rhs, 0, data->state, data->implicit.sundials.context);
}

static void *create_imex(dl_method *method) {
    dl_arkode *const data = method->data;
    data->implicit.fast_alone = true;
    return ARKStepCreate(dl_arkode_rhs_slow, dl_arkode_rhs_fast, 0, data->state,
                         data->implicit.sundials.context);
}

/* Of Newton's method, or of a fixed point, where no shorter step can be tried; ARKODE's 3 are for
 * steps that it chooses. */
enum { most_iterations = 50 };

static dl_status set_up(dl_method *method, const pair_of_tables *tables, dl_error *error) {
    dl_arkode *const data = method->data;
    const dirk_options *const chosen = method->options;
    const pair_of_tables ids = tables[chosen->table];
    ARKodeButcherTable of_implicit = ARKodeButcherTable_LoadDIRK(ids.of_implicit);
    ARKodeButcherTable of_explicit = NULL;
    if (ids.of_explicit != ARKODE_ERK_NONE)
        of_explicit = ARKodeButcherTable_LoadERK(ids.of_explicit);
    if (!of_implicit || (ids.of_explicit != ARKODE_ERK_NONE && !of_explicit))
        return dl_fail_memory(error, "a Butcher table");
    const dl_status status = dl_arkode_check_estimate(method, of_implicit, error);
    int flag = ARKStepSetTableNum(data->memory, ids.of_implicit, ids.of_explicit);
    if (!flag)
        flag = dl_arkode_mend_last_stage(data, of_explicit, of_implicit);
    if (!flag)
        flag = dl_implicit_attach(&data->implicit, &data->calls->implicit, data->memory,
                                  data->state, &chosen->implicit);
    if (!flag && method->step > 0)
        flag = data->calls->implicit.set_most_iterations(data->memory, most_iterations);
    ARKodeButcherTable_Free(of_implicit);
    ARKodeButcherTable_Free(of_explicit);
    return !status && flag ? dl_arkode_fail(data, flag, "ARKStep", error) : status;
}

static dl_status set_up_dirk(dl_method *method, dl_error *error) {
    return set_up(method, dirk_tables, error);
}

static dl_status set_up_imex(dl_method *method, dl_error *error) {
    return set_up(method, imex_tables, error);
}

#define OPTIONS_WITH_TABLE(words, text, doc)                                                       \
    DL_OPTION_STEP_OR_ADAPTIVE(dl_arkode_options),                                                 \
        DL_OPTIONS_TOLERANCES_OF_STAGES(dl_arkode_options),                                        \
        DL_OPTION_TABLE(dirk_options, words, text, doc), DL_OPTION_SOLVER(dirk_options, "klu"),    \
        DL_OPTION_ANDERSON(dirk_options), DL_OPTIONS_KRYLOV(dirk_options)

static const dl_parameter options_of_dirk[] = {
    OPTIONS_WITH_TABLE(dirk_words, "esdirk437-4", "Runge-Kutta coefficients")};
static const dl_parameter options_of_imex[] = {
    OPTIONS_WITH_TABLE(imex_words, "ark437-4", "pair of Runge-Kutta coefficients")};

static const dl_arkode_kind dirk = {
    .calls = &dl_arkstep_calls,
    .create = create_dirk,
    .set_up = set_up_dirk,
};

static const dl_arkode_kind imex = {
    .calls = &dl_arkstep_calls,
    .splits = true,
    .create = create_imex,
    .set_up = set_up_imex,
};

const dl_method_row dl_method_arkode_dirk = {
    .name = "arkode-dirk",
    .family = "ARKODE",
    .doc = "diagonally implicit Runge-Kutta by a chosen table, fixed or adaptive step (SUNDIALS "
           "ARKODE)",
    .table = describe_dirk,
    .flags = DL_IMPLICIT | DL_ADAPTIVE | DL_FIXED_STEP | DL_NEEDS_JACOBIAN,
    .options = DL_OPTIONS_TABLE(options_of_dirk),
    .options_size = sizeof(dirk_options),
    .variant = &dirk,
    .ops = &dl_arkode_ops,
};

const dl_method_row dl_method_arkode_imex = {
    .name = "arkode-imex",
    .family = "ARKODE",
    .doc = "additive Runge-Kutta: the scene's fast forces implicit, its slow ones explicit "
           "(SUNDIALS ARKODE)",
    .table = describe_imex,
    .flags = DL_IMPLICIT | DL_ADAPTIVE | DL_FIXED_STEP | DL_NEEDS_JACOBIAN | DL_SPLITS_FORCE,
    .options = DL_OPTIONS_TABLE(options_of_imex),
    .options_size = sizeof(dirk_options),
    .variant = &imex,
    .ops = &dl_arkode_ops,
};
