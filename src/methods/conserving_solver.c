#include "methods/conserving_solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

/* Residuals within this part of the displacement that no longer fall are roundoff. */
static const double roundoff = 1e-11;
/* Larger ones, up to this, are accepted where they cost no energy: a pair that crosses a hard
 * cutoff slowly feels a force that changes fully within a small part of its way, and roundoff grows
 * by as much. */
static const double stiff_residual = 1e-4;
/* Energy that such a step may cost, as a part of its kinetic energy and work. */
static const double stiff_energy = 1e-13;

/* A trial displacement this many times the step's is nonsense that would cost a neighbour list of
 * everything. */
static const double longest_trial = 100;

/* Evaluations without progress after which a fixed-point iteration is given up. */
enum { patience = 12 };

/* --- the system --------------------------------------------------------------------------------
 */

/* What a callback answers there: recoverable, a line search tries a shorter step. */
enum { trial_is_nonsense = 1 };

/* image = h v + (h^2/2) a(q, q + delta), the fixed-point map. Sets the residual, its distance from
 * delta; returns what KINSOL is to be told. */
static int apply_map(dl_conserving_solver *solver, const double *delta, double *image,
                     double *residual) {
    const dl_conserving_step *const step = &solver->step;
    for (size_t i = 0; i < step->n; i++)
        if (!(fabs(delta[i]) <= longest_trial * step->size))
            return trial_is_nonsense;
    dl_error error;
    const dl_status status =
        dl_model_discrete_acceleration(solver->sundials.model, step->q, delta, step->a, &error);
    double largest = 0;
    for (size_t i = 0; i < step->n && !status; i++) {
        const double to = step->h * step->v[i] + step->h * step->h / 2 * step->a[i];
        largest = fmax(largest, fabs(to - delta[i]));
        image[i] = to;
    }
    *residual = solver->last = largest;
    solver->since_best = largest < solver->best ? 0 : solver->since_best + 1;
    solver->best = fmin(solver->best, largest);
    return dl_sundials_answer(&solver->sundials, status, &error);
}

/* Whether the residual has come down to roundoff and stays there. */
static bool is_at_roundoff(const dl_conserving_solver *solver, double residual) {
    return solver->since_best >= 2 && residual <= roundoff * solver->step.size;
}

static int fixed_point_map(N_Vector u, N_Vector image, void *user_data) {
    dl_conserving_solver *const solver = user_data;
    double residual;
    const int answer =
        apply_map(solver, N_VGetArrayPointer(u), N_VGetArrayPointer(image), &residual);
    if (answer) {
        /* KINSOL's fixed point goes on after a positive answer */
        solver->stalled = solver->sundials.model_status == DL_OK;
        return -1;
    }
    if (is_at_roundoff(solver, residual)) /* KINSOL stops where the map leaves u as it is */
        N_VScale(1, u, image);
    else
        solver->stalled = solver->since_best > patience;
    return solver->stalled ? -1 : 0;
}

static int newton_residual(N_Vector u, N_Vector f, void *user_data) {
    dl_conserving_solver *const solver = user_data;
    const double *const delta = N_VGetArrayPointer(u);
    double *const to = N_VGetArrayPointer(f), residual;
    const int answer = apply_map(solver, delta, to, &residual);
    if (answer)
        return answer;
    const bool done = is_at_roundoff(solver, residual);
    for (size_t i = 0; i < solver->step.n; i++)
        to[i] = done ? 0 : delta[i] - to[i];
    return 0;
}

static int discrete_jacobian(dl_conserving_solver *solver, const double *delta,
                             const dl_sparsity **sparsity) {
    dl_error error;
    dl_status status =
        dl_model_sparsity(solver->sundials.model, solver->step.q, delta, sparsity, &error);
    if (!status && (*sparsity)->nonzeros > solver->values_capacity) {
        free(solver->values);
        solver->values = malloc((*sparsity)->nonzeros * sizeof *solver->values);
        solver->values_capacity = solver->values ? (*sparsity)->nonzeros : 0;
        if (!solver->values)
            status = dl_fail_memory(&error, "the discrete Jacobian");
    }
    if (!status)
        status = dl_model_discrete_jacobian(solver->sundials.model, solver->step.q, delta,
                                            solver->values, &error);
    return dl_sundials_answer(&solver->sundials, status, &error);
}

/* J = I - (h^2/2) d a / d delta. */
static int dense_jacobian(N_Vector u, N_Vector f, SUNMatrix matrix, void *user_data, N_Vector w1,
                          N_Vector w2) {
    (void)f;
    (void)w1;
    (void)w2;
    dl_conserving_solver *const solver = user_data;
    const dl_sparsity *pattern;
    const int answer = discrete_jacobian(solver, N_VGetArrayPointer(u), &pattern);
    if (answer)
        return answer;
    const double factor = solver->step.h * solver->step.h / 2;
    SUNMatZero(matrix);
    for (size_t c = 0; c < pattern->columns; c++) {
        double *const column = SUNDenseMatrix_Column(matrix, (sunindextype)c);
        for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++)
            column[pattern->row[k]] = -factor * solver->values[k];
        column[c] += 1;
    }
    solver->factorisations++;
    return 0;
}

/* KINSOL clears the pattern with the values, so it is written each time; the symbolic analysis is
 * done again only where it has changed. */
static int write_sparse(dl_conserving_solver *solver, const dl_sparsity *pattern,
                        SUNMatrix matrix) {
    const sunindextype nonzeros = (sunindextype)pattern->nonzeros;
    if (nonzeros > SM_NNZ_S(matrix) && SUNSparseMatrix_Reallocate(matrix, nonzeros))
        return -1;
    for (size_t c = 0; c <= pattern->columns; c++)
        SM_INDEXPTRS_S(matrix)[c] = pattern->column_start[c];
    for (size_t k = 0; k < pattern->nonzeros; k++)
        SM_INDEXVALS_S(matrix)[k] = pattern->row[k];
    if (solver->pattern == pattern->generation)
        return 0;
    solver->pattern = pattern->generation;
    return SUNLinSol_KLUReInit(solver->linear, matrix, nonzeros, SUNKLU_REINIT_PARTIAL);
}

static int sparse_jacobian(N_Vector u, N_Vector f, SUNMatrix matrix, void *user_data, N_Vector w1,
                           N_Vector w2) {
    (void)f;
    (void)w1;
    (void)w2;
    dl_conserving_solver *const solver = user_data;
    const dl_sparsity *pattern;
    const int answer = discrete_jacobian(solver, N_VGetArrayPointer(u), &pattern);
    if (answer || write_sparse(solver, pattern, matrix))
        return answer ? answer : -1;
    const double factor = solver->step.h * solver->step.h / 2;
    for (size_t c = 0; c < pattern->columns; c++)
        for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++)
            SM_DATA_S(matrix)
    [k] = -factor * solver->values[k] + (pattern->row[k] == (long)c ? 1 : 0);
    solver->factorisations++;
    return 0;
}

/* --- a solution --------------------------------------------------------------------------------
 */

static dl_status fail_to_converge(const dl_conserving_solver *solver, long iterations,
                                  dl_error *error) {
    return dl_fail(error, DL_NONLINEAR_FAILURE,
                   "the step's system did not converge in %ld iterations: residual %.3g of the "
                   "displacement",
                   iterations, solver->best / solver->step.size);
}

/* Takes delta as it is, with the mean acceleration that leads to it: it then costs the work that
 * this acceleration and the one felt differ by. */
static bool costs_no_energy(const dl_conserving_solver *solver) {
    const dl_conserving_step *const step = &solver->step;
    const dl_model *const model = solver->sundials.model;
    const double felt = dl_model_work(model, step->a, step->delta);
    for (size_t i = 0; i < step->n; i++)
        step->a[i] = 2 * (step->delta[i] - step->h * step->v[i]) / (step->h * step->h);
    const double cost = fabs(dl_model_work(model, step->a, step->delta) - felt);
    return cost <= stiff_energy * (dl_model_work(model, step->v, step->v) + fabs(felt));
}

/* KINSOL has stopped at delta without success. */
static bool is_good_enough(dl_conserving_solver *solver) {
    const dl_conserving_step *const step = &solver->step;
    double residual;
    return solver->best <= stiff_residual * step->size &&
           !apply_map(solver, step->delta, N_VGetArrayPointer(solver->image), &residual) &&
           (residual <= roundoff * step->size ||
            (residual <= stiff_residual * step->size && costs_no_energy(solver)));
}

static int call_kinsol(dl_conserving_solver *solver, int strategy, long *iterations) {
    solver->best = INFINITY;
    solver->since_best = 0;
    solver->stalled = false;
    dl_sundials_begin(&solver->sundials);
    const int flag = KINSol(solver->kinsol, solver->delta, strategy, solver->scale, solver->scale);
    long more = 0;
    KINGetNumNonlinSolvIters(solver->kinsol, &more);
    *iterations += more;
    return flag;
}

static bool gave_up(int flag) {
    return flag == KIN_STEP_LT_STPTOL || flag == KIN_MAXITER_REACHED ||
           flag == KIN_LINESEARCH_NONCONV || flag == KIN_LINESEARCH_BCFAIL ||
           flag == KIN_MXNEWT_5X_EXCEEDED;
}

static bool succeeded(int flag) {
    return flag == KIN_SUCCESS || flag == KIN_INITIAL_GUESS_OK;
}

/* KINSOL's fixed point takes a short step for a small residual; with Anderson's acceleration it can
 * be far from one, where the residuals it combines depend on one another. */
static bool has_converged(const dl_conserving_solver *solver) {
    return solver->last <= fmax(roundoff, 10 * solver->tolerance) * solver->step.size;
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
    const bool newton = solver->kind != DL_FIXED_POINT;
    long iterations = 0;
    N_VConst(1 / solver->step.size, solver->scale);
    int flag = call_kinsol(solver, newton ? KIN_LINESEARCH : KIN_FP, &iterations);
    bool good = gave_up(flag) && is_good_enough(solver);
    if (newton && gave_up(flag) && !good) {
        /* the line search may stop at a kink that full steps pass */
        flag = call_kinsol(solver, KIN_NONE, &iterations);
        good = gave_up(flag) && is_good_enough(solver);
    }
    solver->iterations += (unsigned long)iterations;
    if (good || (succeeded(flag) && has_converged(solver)))
        return DL_OK;
    if (gave_up(flag) || succeeded(flag) || solver->stalled)
        return fail_to_converge(solver, iterations, error);
    return dl_sundials_fail(&solver->sundials, meanings, flag, "KINSol", error);
}

/* --- life --------------------------------------------------------------------------------------
 */

static bool attach_linear_solver(dl_conserving_solver *solver) {
    const sunindextype n = (sunindextype)solver->step.n;
    SUNContext context = solver->sundials.context;
    const bool dense = solver->kind == DL_NEWTON_DENSE;
    solver->matrix =
        dense ? SUNDenseMatrix(n, n, context) : SUNSparseMatrix(n, n, n, CSC_MAT, context);
    if (!solver->matrix)
        return false;
    solver->linear = dense ? SUNLinSol_Dense(solver->delta, solver->matrix, context)
                           : SUNLinSol_KLU(solver->delta, solver->matrix, context);
    return solver->linear && !KINSetLinearSolver(solver->kinsol, solver->linear, solver->matrix) &&
           !KINSetJacFn(solver->kinsol, dense ? dense_jacobian : sparse_jacobian) &&
           !KINSetMaxSetupCalls(solver->kinsol, 1) &&
           !KINSetMaxNewtonStep(solver->kinsol, 10 * sqrt((double)n));
}

static bool create_kinsol(dl_conserving_solver *solver, double tolerance, long iterations,
                          long depth) {
    const bool fixed_point = solver->kind == DL_FIXED_POINT;
    solver->kinsol = KINCreate(solver->sundials.context);
    if (!solver->kinsol || dl_sundials_listen_kinsol(&solver->sundials, solver->kinsol) ||
        KINSetUserData(solver->kinsol, solver) || KINSetNumMaxIters(solver->kinsol, iterations) ||
        (fixed_point && depth > 0 && KINSetMAA(solver->kinsol, depth)) ||
        KINInit(solver->kinsol, fixed_point ? fixed_point_map : newton_residual, solver->delta))
        return false;
    /* KINSOL takes 0 as "its own default" */
    const double least = 1e-300;
    if (KINSetFuncNormTol(solver->kinsol, fmax(tolerance, least)) ||
        KINSetScaledStepTol(solver->kinsol, least))
        return false;
    return fixed_point || attach_linear_solver(solver);
}

dl_status dl_conserving_solver_create(dl_conserving_solver *solver, dl_model *model,
                                      dl_solver_kind kind, const dl_conserving_step *step,
                                      double tolerance, long iterations, long depth,
                                      dl_error *error) {
    memset(solver, 0, sizeof *solver);
    solver->kind = kind;
    solver->tolerance = tolerance;
    solver->step = *step;
    const dl_status status = dl_sundials_create(&solver->sundials, model, error);
    if (status)
        return status;
    solver->delta = dl_sundials_vector(&solver->sundials, step->delta, step->n);
    solver->scale = N_VNew_Serial((sunindextype)step->n, solver->sundials.context);
    solver->image = N_VNew_Serial((sunindextype)step->n, solver->sundials.context);
    if (!solver->delta || !solver->scale || !solver->image)
        return dl_fail_memory(error, "the conserving scheme's vectors");
    if (!create_kinsol(solver, tolerance, iterations, depth))
        return solver->sundials.message[0]
                   ? dl_fail(error, DL_ERROR, "KINSOL could not be set up: %s",
                             solver->sundials.message)
                   : dl_fail_memory(error, kind == DL_NEWTON_DENSE ? "a dense Jacobian"
                                                                   : "KINSOL and its matrix");
    return DL_OK;
}

void dl_conserving_solver_free(dl_conserving_solver *solver) {
    if (solver->kinsol)
        KINFree(&solver->kinsol);
    if (solver->linear)
        SUNLinSolFree(solver->linear);
    if (solver->matrix)
        SUNMatDestroy(solver->matrix);
    N_Vector *const vectors[] = {&solver->delta, &solver->scale, &solver->image};
    for (size_t k = 0; k < sizeof vectors / sizeof *vectors; k++)
        if (*vectors[k])
            N_VDestroy(*vectors[k]);
    free(solver->values);
    dl_sundials_destroy(&solver->sundials);
}
