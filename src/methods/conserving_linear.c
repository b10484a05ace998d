/* Linear systems with  J = I - (h^2/2) d a / d delta,  a the mean acceleration. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>

#include "methods/conserving_parts.h"

/* Vectors that GMRES keeps before it restarts. */
enum { krylov_vectors = 20 };

/* --- matrices -----------------------------------------------------------------------------------
 */

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
    solver->is_factorised = true;
    solver->counts.factorisations++;
    return 0;
}

/* KINSOL clears the pattern with the values, so it is written each time; the symbolic analysis is
 * done again only where it has changed. */
static int write_sparse(dl_conserving_solver *solver, const dl_sparsity *pattern,
                        SUNMatrix matrix) {
    const sunindextype nonzeros = (sunindextype)pattern->nonzeros;
    if (nonzeros > SM_NNZ_S(matrix) && SUNSparseMatrix_Reallocate(matrix, nonzeros))
        return -1;
    memcpy(SM_INDEXPTRS_S(matrix), pattern->column_start,
           (pattern->columns + 1) * sizeof *pattern->column_start);
    memcpy(SM_INDEXVALS_S(matrix), pattern->row, pattern->nonzeros * sizeof *pattern->row);
    if (solver->pattern == pattern->generation)
        return 0;
    solver->pattern = pattern->generation;
    return SUNLinSol_KLUReInit(solver->linear, matrix, nonzeros, SUNKLU_REINIT_PARTIAL);
}

/* In place of a factorisation: KINSOL's Picard iteration would have a new one each time. */
static int keep_factorisation(SUNLinearSolver linear, SUNMatrix matrix) {
    (void)linear;
    (void)matrix;
    return 0;
}

static int sparse_jacobian(N_Vector u, N_Vector f, SUNMatrix matrix, void *user_data, N_Vector w1,
                           N_Vector w2) {
    (void)f;
    (void)w1;
    (void)w2;
    dl_conserving_solver *const solver = user_data;
    const dl_sparsity *pattern;
    solver->linear->ops->setup = solver->is_frozen ? keep_factorisation : solver->factorise;
    if (solver->is_frozen)
        return 0;
    solver->is_frozen = solver->settings.kind == DL_PICARD;
    const int answer = discrete_jacobian(solver, N_VGetArrayPointer(u), &pattern);
    if (answer || write_sparse(solver, pattern, matrix))
        return answer ? answer : -1;
    const double factor = solver->step.h * solver->step.h / 2;
    double *const data = SM_DATA_S(matrix);
    for (size_t c = 0; c < pattern->columns; c++)
        for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++)
            data[k] = -factor * solver->values[k] + (pattern->row[k] == (long)c ? 1 : 0);
    solver->is_factorised = true;
    solver->counts.factorisations++;
    return 0;
}

/* --- products and their preconditioner ----------------------------------------------------------
 */

static int prepare(dl_conserving_solver *solver, N_Vector u) {
    dl_error error;
    const dl_status status = dl_model_discrete_product_prepare(
        solver->sundials.model, solver->step.q, N_VGetArrayPointer(u), &error);
    return dl_sundials_answer(&solver->sundials, status, &error);
}

/* With the derivative that set_preconditioner has prepared: at this iterate, or an earlier one. */
static int multiply(N_Vector v, N_Vector product, N_Vector u, sunbooleantype *is_new,
                    void *user_data) {
    (void)u;
    (void)is_new;
    dl_conserving_solver *const solver = user_data;
    const double factor = solver->step.h * solver->step.h / 2;
    const double *const from = N_VGetArrayPointer(v);
    double *const to = N_VGetArrayPointer(product);
    dl_model_discrete_product(solver->sundials.model, from, to);
    for (size_t i = 0; i < solver->step.n; i++)
        to[i] = from[i] - factor * to[i];
    return 0;
}

/* a = a^-1 by Gauss-Jordan elimination with rows exchanged; false where it is singular. */
static bool invert(size_t size, double a[3][3]) {
    size_t exchanged[3];
    for (size_t k = 0; k < size; k++) {
        size_t pivot = k;
        for (size_t r = k + 1; r < size; r++)
            pivot = fabs(a[r][k]) > fabs(a[pivot][k]) ? r : pivot;
        exchanged[k] = pivot;
        if (!(fabs(a[pivot][k]) > 0))
            return false;
        for (size_t c = 0; c < size; c++) {
            const double swap = a[k][c];
            a[k][c] = a[pivot][c];
            a[pivot][c] = swap;
        }
        const double inverse = 1 / a[k][k];
        a[k][k] = 1;
        for (size_t c = 0; c < size; c++)
            a[k][c] *= inverse;
        for (size_t r = 0; r < size; r++) {
            const double factor = r == k ? 0 : a[r][k];
            if (r == k)
                continue;
            a[r][k] = 0;
            for (size_t c = 0; c < size; c++)
                a[r][c] -= factor * a[k][c];
        }
    }
    for (size_t k = size; k-- > 0;)
        for (size_t r = 0; r < size; r++) {
            const double swap = a[r][k];
            a[r][k] = a[r][exchanged[k]];
            a[r][exchanged[k]] = swap;
        }
    return true;
}

/* The particles' own blocks of J, inverted; a singular one is left out. */
static int set_preconditioner(N_Vector u, N_Vector u_scale, N_Vector f, N_Vector f_scale,
                              void *user_data) {
    (void)u_scale;
    (void)f;
    (void)f_scale;
    dl_conserving_solver *const solver = user_data;
    const dl_model *const model = solver->sundials.model;
    const size_t size = (size_t)model->dimension;
    const double factor = solver->step.h * solver->step.h / 2;
    const int answer = prepare(solver, u);
    if (answer)
        return answer;
    solver->is_factorised = true;
    dl_model_discrete_diagonal(model, solver->block);
    for (size_t k = 0; k < model->moving; k++) {
        double *const block = solver->block + k * size * size, a[3][3] = {{0}};
        for (size_t e = 0; e < size * size; e++)
            a[e / size][e % size] = (e / size == e % size) - factor * block[e];
        const bool regular = invert(size, a);
        for (size_t e = 0; e < size * size; e++)
            block[e] = regular ? a[e / size][e % size] : (double)(e / size == e % size);
    }
    return 0;
}

static int apply_preconditioner(N_Vector u, N_Vector u_scale, N_Vector f, N_Vector f_scale,
                                N_Vector v, void *user_data) {
    (void)u;
    (void)u_scale;
    (void)f;
    (void)f_scale;
    const dl_conserving_solver *const solver = user_data;
    const size_t n = solver->sundials.model->moving;
    const size_t size = (size_t)solver->sundials.model->dimension;
    double *const x = N_VGetArrayPointer(v);
    for (size_t k = 0; k < n; k++) {
        const double *const block = solver->block + k * size * size;
        double from[3];
        for (size_t c = 0; c < size; c++)
            from[c] = x[c * n + k];
        for (size_t r = 0; r < size; r++) {
            double sum = 0;
            for (size_t c = 0; c < size; c++)
                sum += block[r * size + c] * from[c];
            x[r * n + k] = sum;
        }
    }
    return 0;
}

/* --- life ---------------------------------------------------------------------------------------
 */

/* KINSOL initialises its linear solver in every call, and KLU would analyse the pattern again. */
static int keep_analysis(SUNLinearSolver linear) {
    (void)linear;
    return 0;
}

static bool attach_matrix(dl_conserving_solver *solver) {
    const sunindextype n = (sunindextype)solver->step.n;
    SUNContext context = solver->sundials.context;
    const bool dense = solver->settings.kind == DL_NEWTON_DENSE;
    solver->matrix =
        dense ? SUNDenseMatrix(n, n, context) : SUNSparseMatrix(n, n, n, CSC_MAT, context);
    if (!solver->matrix)
        return false;
    solver->linear = dense ? SUNLinSol_Dense(solver->delta, solver->matrix, context)
                           : SUNLinSol_KLU(solver->delta, solver->matrix, context);
    if (!solver->linear)
        return false;
    if (!dense)
        solver->linear->ops->initialize = keep_analysis;
    solver->factorise = solver->linear->ops->setup;
    return !KINSetLinearSolver(solver->kinsol, solver->linear, solver->matrix) &&
           !KINSetJacFn(solver->kinsol, dense ? dense_jacobian : sparse_jacobian);
}

static bool attach_krylov(dl_conserving_solver *solver) {
    const dl_model *const model = solver->sundials.model;
    const size_t each = (size_t)model->dimension * (size_t)model->dimension;
    solver->block = malloc((model->moving * each + 1) * sizeof *solver->block);
    solver->linear =
        SUNLinSol_SPGMR(solver->delta, SUN_PREC_RIGHT, krylov_vectors, solver->sundials.context);
    return solver->block && solver->linear &&
           !KINSetLinearSolver(solver->kinsol, solver->linear, NULL) &&
           !KINSetJacTimesVecFn(solver->kinsol, multiply) &&
           !KINSetPreconditioner(solver->kinsol, set_preconditioner, apply_preconditioner);
}

bool dl_conserving_attach(dl_conserving_solver *solver) {
    if (solver->settings.kind == DL_FIXED_POINT)
        return true;
    return solver->settings.kind == DL_NEWTON_KRYLOV ? attach_krylov(solver)
                                                     : attach_matrix(solver);
}

void dl_conserving_detach(dl_conserving_solver *solver) {
    if (solver->linear)
        SUNLinSolFree(solver->linear);
    if (solver->matrix)
        SUNMatDestroy(solver->matrix);
    free(solver->values);
    free(solver->block);
}
