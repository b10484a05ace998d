/* ARKODE's multirate infinitesimal methods (SUNDIALS MRIStep): the slow part of the force by a
 * table for long steps, and between its stages the fast part by an explicit Runge-Kutta method,
 *
 *     y' = (v, a_fast) + (0, a_slow),
 *
 * at steps of a given part of the long one or as its tolerances allow.
 *
 * A table that is implicit in the slow part needs no Jacobian: a slow stage changes velocities
 * alone, by forces at positions that it leaves as they are (second_iterate.h). */
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_mristep.h>
#include <stdlib.h>

#include "methods/arkode.h"
#include "methods/arkode_erk.h"
#include "methods/second_iterate.h"
#include "methods/sundials_tables.h"

typedef struct mri_options {
    dl_arkode_options common; /* but for the step: not options */
    int table, fast_table;
    long substeps;
    double fast_rtol, fast_atol;
} mri_options;

typedef struct inner_integrator {
    void *memory; /* of ARKStep */
    MRIStepInnerStepper stepper;
} inner_integrator;

static const char *const words[] = {
#define WORD(word, id) word,
    DL_MRI_TABLES(WORD) NULL,
#undef WORD
};

static const ARKODE_MRITableID ids[] = {
#define ID(word, id) id,
    DL_MRI_TABLES(ID)
#undef ID
};

static MRIStepCoupling load_table(const dl_method *method) {
    return MRIStepCoupling_LoadTable(ids[((const mri_options *)method->options)->table]);
}

static bool describe(const char *const *of_words, size_t index, dl_method_table *found) {
    if (of_words != words)
        return dl_erk_describe(of_words, index, found);
    MRIStepCoupling table = MRIStepCoupling_LoadTable(ids[index]);
    if (!table)
        return false;
    *found = (dl_method_table){.order = table->q, .stages = table->stages};
    MRIStepCoupling_Free(table);
    return true;
}

/* --- the fast part -----------------------------------------------------------------------------
 */

static int set_fast_step(const dl_method *method) {
    const mri_options *const chosen = method->options;
    const inner_integrator *const inner = ((const dl_arkode *)method->data)->inner;
    return chosen->substeps > 0 ? dl_arkstep_calls.set_fixed_step(
                                      inner->memory, method->step / (double)chosen->substeps)
                                : ARK_SUCCESS;
}

static int set_up_inner(const dl_method *method) {
    const mri_options *const chosen = method->options;
    dl_arkode *const data = method->data;
    inner_integrator *const inner = data->inner;
    const dl_arkode_calls *const calls = &dl_arkstep_calls;
    const ARKODE_ERKTableID id = dl_erk_ids[chosen->fast_table];
    ARKodeButcherTable table = ARKodeButcherTable_LoadERK(id);
    dl_arkode fast = {.calls = calls, .memory = inner->memory};
    int flag = table ? dl_sundials_listen_arkode(&data->implicit.sundials, calls, inner->memory)
                     : ARK_MEM_FAIL;
    if (!flag)
        flag = calls->set_user_data(inner->memory, data);
    if (!flag)
        flag = calls->set_tolerances(inner->memory, chosen->fast_rtol, chosen->fast_atol);
    if (!flag)
        flag = ARKStepSetTableNum(inner->memory, ARKODE_DIRK_NONE, id);
    if (!flag)
        flag = calls->set_interpolant_degree(inner->memory, 1);
    if (!flag)
        flag = calls->set_most_steps(inner->memory, -1);
    if (!flag)
        flag = dl_arkode_mend_last_stage(&fast, table, NULL);
    if (!flag)
        flag = set_fast_step(method);
    ARKodeButcherTable_Free(table);
    return flag;
}

static void destroy_inner(dl_arkode *data) {
    inner_integrator *const inner = data->inner;
    if (!inner)
        return;
    if (inner->stepper)
        MRIStepInnerStepper_Free(&inner->stepper);
    if (inner->memory)
        dl_arkstep_calls.free(&inner->memory);
    free(inner);
}

/* --- the slow part -----------------------------------------------------------------------------
 */

static bool is_implicit(const dl_method *method) {
    MRIStepCoupling table = load_table(method);
    const bool implicit = table && table->G;
    MRIStepCoupling_Free(table);
    return implicit;
}

static void *create(dl_method *method) {
    dl_arkode *const data = method->data;
    SUNContext context = data->implicit.sundials.context;
    inner_integrator *const inner = data->inner = calloc(1, sizeof *inner);
    if (!inner)
        return NULL;
    inner->memory = ARKStepCreate(dl_arkode_rhs_fast, NULL, 0, data->state, context);
    if (!inner->memory || dl_arkstep_calls.as_inner_stepper(inner->memory, &inner->stepper))
        return NULL;
    const bool implicit = is_implicit(method);
    return MRIStepCreate(implicit ? NULL : dl_arkode_rhs_slow, implicit ? dl_arkode_rhs_slow : NULL,
                         0, data->state, inner->stepper, context);
}

static int set_up_implicit(dl_arkode *data) {
    const dl_implicit_calls *const calls = &data->calls->implicit;
    data->implicit.nonlinear =
        dl_second_iterate_create(data->state, data->implicit.sundials.context);
    return data->implicit.nonlinear
               ? calls->set_nonlinear_solver(data->memory, data->implicit.nonlinear)
               : ARK_MEM_FAIL;
}

static dl_status check_fast_estimate(const dl_method *method, dl_error *error) {
    const mri_options *const chosen = method->options;
    if (chosen->substeps > 0)
        return DL_OK;
    ARKodeButcherTable table = ARKodeButcherTable_LoadERK(dl_erk_ids[chosen->fast_table]);
    const bool estimates = !table || table->p > 0;
    ARKodeButcherTable_Free(table);
    return estimates ? DL_OK
                     : dl_fail(error, DL_INPUT,
                               "method %s: found substeps=0 with a fast_table that has no error "
                               "estimate to choose steps by, expected a number of substeps",
                               method->row->name);
}

static dl_status set_up(dl_method *method, dl_error *error) {
    dl_arkode *const data = method->data;
    const dl_status status = check_fast_estimate(method, error);
    if (status)
        return status;
    MRIStepCoupling table = load_table(method);
    int flag = table ? MRIStepSetCoupling(data->memory, table) : ARK_MEM_FAIL;
    if (!flag)
        flag = set_up_inner(method);
    if (!flag && table->G)
        flag = set_up_implicit(data);
    MRIStepCoupling_Free(table);
    return flag ? dl_arkode_fail(data, flag, "MRIStep", error) : DL_OK;
}

/* --- row ---------------------------------------------------------------------------------------
 */

static const dl_parameter options[] = {
    DL_OPTION_FIXED_STEP(dl_arkode_options),
    DL_OPTION_TABLE(mri_options, words, "gark-erk45a-4", "coefficients for the slow part"),
    {
        .name = "fast_table",
        .kind = DL_WORD,
        .offset = offsetof(mri_options, fast_table),
        .unit = "",
        .words = dl_erk_words,
        .fallback = "dormand-prince-5",
        .doc = "Runge-Kutta coefficients for the fast part",
    },
    {
        .name = "substeps",
        .kind = DL_INTEGER,
        .offset = offsetof(mri_options, substeps),
        .unit = "",
        .minimum = 0,
        .maximum = 1000000,
        .fallback = "10",
        .doc = "fast steps as long as this part of a slow one; 0: chosen by fast_rtol and "
               "fast_atol",
    },
    {
        .name = "fast_rtol",
        .kind = DL_REAL,
        .offset = offsetof(mri_options, fast_rtol),
        .unit = "",
        .minimum = 0,
        .maximum = 0.1,
        .fallback = "1e-6",
        .when = "substeps=0",
        .doc = "error allowed in a fast step: fast_rtol |y| + fast_atol",
    },
    {
        .name = "fast_atol",
        .kind = DL_REAL,
        .offset = offsetof(mri_options, fast_atol),
        .unit = "length and length/time",
        .minimum = 0,
        .maximum = INFINITY,
        .above_minimum = true,
        .fallback = "1e-10",
        .when = "substeps=0",
        .doc = "absolute part of it",
    },
};

static const dl_arkode_kind kind = {
    .calls = &dl_mristep_calls,
    .splits = true,
    .create = create,
    .set_up = set_up,
    .change_step = set_fast_step,
    .destroy = destroy_inner,
};

const dl_method_row dl_method_arkode_mri = {
    .name = "arkode-mri",
    .family = "ARKODE",
    .doc = "multirate: the scene's slow forces by long steps, its fast ones by short steps between "
           "them (SUNDIALS ARKODE)",
    .table = describe,
    .flags = DL_FIXED_STEP | DL_SPLITS_FORCE,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(mri_options),
    .variant = &kind,
    .ops = &dl_arkode_ops,
};
