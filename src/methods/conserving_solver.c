#include "methods/conserving_solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "methods/conserving_parts.h"

const char *const dl_solver_names[] = {
    [DL_ITERATION] = "iteration",
    [DL_FIXED_POINT] = "fixed-point",
    [DL_PICARD] = "picard",
    [DL_NEWTON_DENSE] = "newton-dense",
    [DL_NEWTON_KLU] = "newton-klu",
    [DL_NEWTON_KRYLOV] = "newton-krylov",
    NULL,
};

/* Iterations in which a factorisation of an earlier step is good enough to be kept for the next. */
enum { quick = 5 };
/* Iterations that one factorisation serves where Newton's method has to have its own: 1, and where
 * it is kept: all of an attempt. */
enum { always = 1, never = 1000000 };

/* Fixed-point iterations on the guess for Newton's method where pairs cross a jump. */
enum { improvements = 3 };

/* --- one call of KINSOL -------------------------------------------------------------------------
 */

typedef struct attempt {
    int flag;
    long iterations;
} attempt;

static bool gave_up(int flag) {
    return flag == KIN_STEP_LT_STPTOL || flag == KIN_MAXITER_REACHED ||
           flag == KIN_LINESEARCH_NONCONV || flag == KIN_LINESEARCH_BCFAIL ||
           flag == KIN_MXNEWT_5X_EXCEEDED;
}

static bool succeeded(int flag) {
    return flag == KIN_SUCCESS || flag == KIN_INITIAL_GUESS_OK;
}

static void count(dl_conserving_solver *solver, attempt *made) {
    long linear = 0;
    KINGetNumNonlinSolvIters(solver->kinsol, &made->iterations);
    solver->counts.iterations += (unsigned long)made->iterations;
    if (solver->settings.kind == DL_NEWTON_KRYLOV) {
        KINGetNumLinIters(solver->kinsol, &linear);
        solver->counts.linear_iterations += (unsigned long)linear;
    }
}

/* From the guess, or (`goes_on`) from where the last attempt ended. */
static attempt call_kinsol(dl_conserving_solver *solver, int strategy, bool goes_on) {
    attempt made = {0, 0};
    if (dl_sundials_has_failed(&solver->sundials)) { /* no other attempt can mend that */
        made.flag = KIN_SYSFUNC_FAIL;
        return made;
    }
    dl_conserving_begin(solver);
    if (!goes_on)
        N_VScale(1, solver->guess, solver->delta);
    made.flag = KINSol(solver->kinsol, solver->delta, strategy, solver->scale, solver->scale);
    count(solver, &made);
    return made;
}

/* Whether the displacement KINSOL has stopped at is as good as roundoff allows. KINSOL's fixed
 * point takes a short step for a small residual; with Anderson's acceleration it can be far from
 * one, where the residuals it combines depend on one another. */
static bool has_converged(dl_conserving_solver *solver, int flag) {
    const double limit = fmax(dl_conserving_roundoff(&solver->step),
                              10 * solver->settings.tolerance * solver->step.size);
    if (!succeeded(flag) && !(gave_up(flag) && solver->best <= limit))
        return false;
    if (solver->last > limit) {
        dl_conserving_begin(solver);
        if (dl_conserving_map(solver->delta, solver->spare, solver))
            return false;
    }
    return solver->last <= limit;
}

/* --- strategies ---------------------------------------------------------------------------------
 */

/* Whether the factorisation is likely to do for the next step, too. */
static bool serves_on(const dl_conserving_solver *solver, const attempt *made) {
    return solver->is_factorised && succeeded(made->flag) && made->iterations <= quick &&
           !dl_model_crossings_any(solver->sundials.model);
}

/* With the factorisation that an earlier step has left, as long as it does; else Newton's method
 * with a line search, which may stop at a kink that full steps pass. */
static attempt call_newton(dl_conserving_solver *solver) {
    attempt made;
    if (solver->factorisation_serves) {
        KINSetNoInitSetup(solver->kinsol, SUNTRUE);
        KINSetMaxSetupCalls(solver->kinsol, never);
        made = call_kinsol(solver, KIN_NONE, false);
        if (has_converged(solver, made.flag)) {
            solver->factorisation_serves = serves_on(solver, &made);
            return made;
        }
    }
    KINSetNoInitSetup(solver->kinsol, SUNFALSE);
    KINSetMaxSetupCalls(solver->kinsol, always);
    made = call_kinsol(solver, KIN_LINESEARCH, false);
    if (gave_up(made.flag) && !has_converged(solver, made.flag))
        made = call_kinsol(solver, KIN_NONE, true);
    solver->factorisation_serves = serves_on(solver, &made);
    return made;
}

/* The Jacobian at the guess, or that of an earlier step as long as it does. */
static attempt call_picard(dl_conserving_solver *solver) {
    solver->is_frozen = solver->factorisation_serves;
    const attempt made = call_kinsol(solver, KIN_PICARD, false);
    solver->factorisation_serves = serves_on(solver, &made);
    return made;
}

/* Newton's linearisation does not hold across a jump of the force: pairs that cross one are first
 * brought to the side where they will be. */
static void improve_guess(dl_conserving_solver *solver) {
    for (int k = 0; k < improvements && dl_model_crossings_any(solver->sundials.model); k++) {
        if (dl_conserving_map(solver->guess, solver->spare, solver))
            return;
        N_VScale(1, solver->spare, solver->guess);
    }
}

static attempt call_solver(dl_conserving_solver *solver) {
    switch (solver->settings.kind) {
    case DL_FIXED_POINT:
        return call_kinsol(solver, KIN_FP, false);
    case DL_PICARD:
        improve_guess(solver);
        return call_picard(solver);
    default:
        improve_guess(solver);
        return call_newton(solver);
    }
}

/* --- a solution --------------------------------------------------------------------------------
 */

static dl_status fail_to_converge(const dl_conserving_solver *solver, const attempt *made,
                                  dl_error *error) {
    return dl_fail(error, DL_NONLINEAR_FAILURE,
                   "the step's system did not converge in %ld iterations of %s: residual %.3g of "
                   "the displacement",
                   made->iterations, dl_solver_names[solver->settings.kind],
                   solver->best / solver->step.size);
}

dl_status dl_conserving_solve(dl_conserving_solver *solver, dl_error *error) {
    static const dl_sundials_meaning meanings[] = {
        {KIN_LSETUP_FAIL, DL_NONLINEAR_FAILURE, true},
        {KIN_LSOLVE_FAIL, DL_NONLINEAR_FAILURE, true},
        {KIN_LINSOLV_NO_RECOVERY, DL_NONLINEAR_FAILURE, true},
        {KIN_SYSFUNC_FAIL, DL_NONLINEAR_FAILURE, true},
        {KIN_FIRST_SYSFUNC_ERR, DL_NONLINEAR_FAILURE, true},
        {KIN_REPTD_SYSFUNC_ERR, DL_NONLINEAR_FAILURE, true},
        {0, DL_OK, false},
    };
    if (solver->settings.kind == DL_ITERATION)
        return dl_conserving_iterate(solver, error);
    N_VConst(1 / solver->step.size, solver->scale);
    N_VScale(1, solver->delta, solver->guess);
    dl_conserving_begin(solver);
    const attempt made = call_solver(solver);
    if (has_converged(solver, made.flag)) {
        solver->counts.inexact += solver->last > solver->settings.tolerance * solver->step.size;
        return DL_OK;
    }
    solver->factorisation_serves = false;
    const bool may_retry = !dl_sundials_has_failed(&solver->sundials);
    if (may_retry && (gave_up(made.flag) || succeeded(made.flag) || solver->stalled))
        return fail_to_converge(solver, &made, error);
    return dl_sundials_fail(&solver->sundials, meanings, made.flag, "KINSol", error);
}

/* --- life --------------------------------------------------------------------------------------
 */

static bool create_kinsol(dl_conserving_solver *solver) {
    const dl_conserving_settings *const settings = &solver->settings;
    static int (*const functions[])(N_Vector, N_Vector, void *) = {
        [DL_FIXED_POINT] = dl_conserving_map,        [DL_PICARD] = dl_conserving_picard,
        [DL_NEWTON_DENSE] = dl_conserving_residual,  [DL_NEWTON_KLU] = dl_conserving_residual,
        [DL_NEWTON_KRYLOV] = dl_conserving_residual,
    };
    const bool accelerated = settings->kind == DL_FIXED_POINT || settings->kind == DL_PICARD;
    /* residuals that there are before the last iteration: KINSOL 7.5 trips over a depth beyond */
    const long most = accelerated ? settings->iterations - 1 : 0;
    const long depth = settings->depth < most ? settings->depth : most;
    solver->kinsol = KINCreate(solver->sundials.context);
    if (!solver->kinsol || dl_sundials_listen_kinsol(&solver->sundials, solver->kinsol) ||
        KINSetUserData(solver->kinsol, solver) ||
        KINSetNumMaxIters(solver->kinsol, settings->iterations) ||
        (depth > 0 && KINSetMAA(solver->kinsol, depth)) ||
        KINInit(solver->kinsol, functions[settings->kind], solver->delta))
        return false;
    /* KINSOL takes 0 as "its own default" */
    const double least = 1e-300, longest = 10 * sqrt((double)solver->step.n);
    return !KINSetFuncNormTol(solver->kinsol, fmax(settings->tolerance, least)) &&
           !KINSetScaledStepTol(solver->kinsol, least) &&
           !KINSetMaxNewtonStep(solver->kinsol, longest) &&
           !(settings->kind == DL_PICARD && KINSetMaxSetupCalls(solver->kinsol, never)) &&
           dl_conserving_attach(solver);
}

dl_status dl_conserving_solver_create(dl_conserving_solver *solver, dl_model *model,
                                      const dl_conserving_settings *settings,
                                      const dl_conserving_step *step, dl_error *error) {
    memset(solver, 0, sizeof *solver);
    solver->settings = *settings;
    solver->step = *step;
    const dl_status status = dl_sundials_create(&solver->sundials, model, error);
    if (status)
        return status;
    if (settings->kind == DL_ITERATION) {
        solver->jumps = dl_model_any_jumps(model);
        solver->image = malloc((step->n + 1) * sizeof *solver->image);
        return solver->image ? DL_OK : dl_fail_memory(error, "the conserving scheme's iteration");
    }
    const sunindextype n = (sunindextype)step->n;
    solver->delta = dl_sundials_vector(&solver->sundials, step->delta, step->n);
    solver->scale = N_VNew_Serial(n, solver->sundials.context);
    solver->guess = N_VNew_Serial(n, solver->sundials.context);
    solver->spare = N_VNew_Serial(n, solver->sundials.context);
    if (!solver->delta || !solver->scale || !solver->guess || !solver->spare)
        return dl_fail_memory(error, "the conserving scheme's vectors");
    if (!create_kinsol(solver))
        return solver->sundials.message[0]
                   ? dl_fail(error, DL_ERROR, "KINSOL could not be set up: %s",
                             solver->sundials.message)
                   : dl_fail_memory(error, settings->kind == DL_NEWTON_DENSE
                                               ? "a dense Jacobian"
                                               : "KINSOL and its matrix");
    return DL_OK;
}

void dl_conserving_solver_free(dl_conserving_solver *solver) {
    if (solver->kinsol)
        KINFree(&solver->kinsol);
    dl_conserving_detach(solver);
    N_Vector *const vectors[] = {&solver->delta, &solver->scale, &solver->guess, &solver->spare};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        if (*vectors[k])
            N_VDestroy(*vectors[k]);
    free(solver->image);
    dl_sundials_destroy(&solver->sundials);
}
