#include "methods/implicit.h"

#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunlinsol/sunlinsol_spbcgs.h>
#include <sunlinsol/sunlinsol_spfgmr.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunlinsol/sunlinsol_sptfqmr.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunmatrix/sunmatrix_sparse.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

const char *const dl_implicit_solver_words[] = {
    [DL_IMPLICIT_FIXED_POINT] = "fixed-point",
    [DL_IMPLICIT_DENSE] = "dense",
    [DL_IMPLICIT_KLU] = "klu",
    [DL_IMPLICIT_KRYLOV] = "krylov",
    NULL,
};

/* What the callbacks see is fixed when the solver is attached. */
static dl_model *jacobian_model(const dl_implicit *implicit) {
    dl_model *const model = implicit->sundials.model;
    return implicit->fast_alone ? dl_model_part(model, DL_PART_FAST) : model;
}

/* A at q: pattern and values. */
static dl_status evaluate(dl_implicit *implicit, const double *q, const dl_sparsity **pattern,
                          dl_error *error) {
    dl_model *const model = jacobian_model(implicit);
    const dl_status status = dl_model_sparsity(model, q, NULL, pattern, error);
    if (status)
        return status;
    const size_t needed = (*pattern)->nonzeros;
    if (needed > implicit->values_size) {
        double *const grown = realloc(implicit->values, needed * sizeof *grown);
        if (!grown)
            return dl_fail_memory(error, "the Jacobian");
        implicit->values = grown;
        implicit->values_size = needed;
    }
    return dl_model_jacobian(model, q, implicit->values, error);
}

/* --- fixed point -------------------------------------------------------------------------------
 */

/* CVODE's and ARKODE's limit; what is accelerated with m residuals takes m iterations to have them.
 */
enum { usual_iterations = 3 };

static int attach_fixed_point(dl_implicit *implicit, void *memory, N_Vector state,
                              const dl_implicit_options *options) {
    implicit->nonlinear =
        SUNNonlinSol_FixedPoint(state, (int)options->anderson, implicit->sundials.context);
    if (!implicit->nonlinear)
        return ARK_MEM_FAIL;
    const int flag = implicit->calls->set_nonlinear_solver(memory, implicit->nonlinear);
    const int most = usual_iterations + (int)options->anderson;
    return flag ? flag : implicit->calls->set_most_iterations(memory, most);
}

/* --- Newton with a matrix ----------------------------------------------------------------------
 */

static int attach_matrix(dl_implicit *implicit, void *memory, ARKLsJacFn jacobian) {
    implicit->factorises = true;
    if (!implicit->linear)
        return ARK_MEM_FAIL;
    const int flag = implicit->calls->set_linear_solver(memory, implicit->linear, implicit->matrix);
    return flag ? flag : implicit->calls->set_jacobian(memory, jacobian);
}

static int dense_jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix matrix,
                          void *user_data, N_Vector work1, N_Vector work2, N_Vector work3) {
    (void)t, (void)ydot, (void)work1, (void)work2, (void)work3;
    dl_implicit *const implicit = user_data;
    const dl_sparsity *a = NULL;
    dl_error error = {""};
    const dl_status status = evaluate(implicit, N_VGetArrayPointer(y), &a, &error);
    if (!status) {
        SUNMatZero(matrix);
        const sunindextype n = (sunindextype)a->columns;
        for (sunindextype column = 0; column < n; column++) {
            sunrealtype *const of_position = SUNDenseMatrix_Column(matrix, column);
            for (long k = a->column_start[column]; k < a->column_start[column + 1]; k++)
                of_position[n + a->row[k]] = implicit->values[k];
            SUNDenseMatrix_Column(matrix, n + column)[column] = 1;
        }
    }
    return dl_sundials_answer(&implicit->sundials, status, &error);
}

static int attach_dense(dl_implicit *implicit, void *memory, N_Vector state,
                        const dl_implicit_options *options) {
    (void)options;
    const sunindextype size = N_VGetLength(state);
    implicit->matrix = SUNDenseMatrix(size, size, implicit->sundials.context);
    if (implicit->matrix)
        implicit->linear = SUNLinSol_Dense(state, implicit->matrix, implicit->sundials.context);
    return attach_matrix(implicit, memory, dense_jacobian);
}

/* J in compressed columns. The diagonal is stored although it is zero: I - gamma J then has the
 * pattern of J. */
static size_t jacobian_nonzeros(const dl_sparsity *a) {
    return a->nonzeros + 3 * a->columns;
}

static void fill_sparse(SUNMatrix jacobian, const dl_sparsity *a, const double *values) {
    sunindextype *const start = SUNSparseMatrix_IndexPointers(jacobian);
    sunindextype *const row = SUNSparseMatrix_IndexValues(jacobian);
    sunrealtype *const entry = SUNSparseMatrix_Data(jacobian);
    const sunindextype n = (sunindextype)a->columns;
    sunindextype k = 0;
    for (sunindextype column = 0; column < n; column++) {
        start[column] = k;
        row[k] = column;
        entry[k++] = 0;
        for (long i = a->column_start[column]; i < a->column_start[column + 1]; i++, k++) {
            row[k] = n + a->row[i];
            entry[k] = values[i];
        }
    }
    for (sunindextype column = 0; column < n; column++) {
        start[n + column] = k;
        row[k] = column;
        entry[k++] = 1;
        row[k] = n + column;
        entry[k++] = 0;
    }
    start[2 * n] = k;
}

/* Room for the pattern in the matrix, and a fresh analysis where the pattern is a new one. */
static int adopt_pattern(dl_implicit *implicit, SUNMatrix matrix, const dl_sparsity *a) {
    const sunindextype needed = (sunindextype)jacobian_nonzeros(a);
    if (needed > SUNSparseMatrix_NNZ(matrix) && SUNSparseMatrix_Reallocate(matrix, needed))
        return -1;
    if (a->generation == implicit->pattern)
        return 0;
    implicit->pattern = a->generation;
    return SUNLinSol_KLUReInit(implicit->linear, matrix, needed, SUNKLU_REINIT_PARTIAL);
}

/* The pattern is adopted last: where A fails, the integrator goes on with the J it has saved. */
static int sparse_jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix matrix,
                           void *user_data, N_Vector work1, N_Vector work2, N_Vector work3) {
    (void)t, (void)ydot, (void)work1, (void)work2, (void)work3;
    dl_implicit *const implicit = user_data;
    const dl_sparsity *a = NULL;
    dl_error error = {""};
    dl_status status = evaluate(implicit, N_VGetArrayPointer(y), &a, &error);
    if (!status && adopt_pattern(implicit, matrix, a))
        status = dl_fail_memory(&error, "the Jacobian");
    if (!status)
        fill_sparse(matrix, a, implicit->values);
    return dl_sundials_answer(&implicit->sundials, status, &error);
}

static int attach_klu(dl_implicit *implicit, void *memory, N_Vector state,
                      const dl_implicit_options *options) {
    (void)options;
    const dl_sparsity *a = NULL;
    dl_error error = {""};
    const dl_status status =
        dl_model_sparsity(jacobian_model(implicit), N_VGetArrayPointer(state), NULL, &a, &error);
    if (status) {
        dl_sundials_answer(&implicit->sundials, status, &error);
        return ARK_LINIT_FAIL;
    }
    const sunindextype size = N_VGetLength(state);
    implicit->pattern = a->generation;
    implicit->matrix = SUNSparseMatrix(size, size, (sunindextype)jacobian_nonzeros(a), CSC_MAT,
                                       implicit->sundials.context);
    if (implicit->matrix)
        implicit->linear = SUNLinSol_KLU(state, implicit->matrix, implicit->sundials.context);
    return attach_matrix(implicit, memory, sparse_jacobian);
}

/* --- Newton with a Krylov method ---------------------------------------------------------------
 */

static int jacobian_times(N_Vector u, N_Vector product, sunrealtype t, N_Vector y, N_Vector ydot,
                          void *user_data, N_Vector work) {
    (void)t, (void)ydot, (void)work;
    dl_implicit *const implicit = user_data;
    dl_model *const model = jacobian_model(implicit);
    const size_t n = model->unknowns;
    const double *const in = N_VGetArrayPointer(u);
    double *const out = N_VGetArrayPointer(product);
    memcpy(out, in + n, n * sizeof *out);
    dl_error error = {""};
    const dl_status status =
        dl_model_jacobian_vector(model, N_VGetArrayPointer(y), in, out + n, &error);
    return dl_sundials_answer(&implicit->sundials, status, &error);
}

static int set_up_preconditioner(sunrealtype t, N_Vector y, N_Vector ydot, sunbooleantype reuse,
                                 sunbooleantype *fresh, sunrealtype gamma, void *user_data) {
    (void)t, (void)ydot;
    dl_implicit *const implicit = user_data;
    dl_preconditioner *const preconditioner = &implicit->preconditioner;
    dl_error error = {""};
    *fresh = !reuse;
    if (!reuse) {
        const dl_sparsity *a = NULL;
        dl_status status = evaluate(implicit, N_VGetArrayPointer(y), &a, &error);
        if (!status)
            status = dl_preconditioner_set(preconditioner, &implicit->sundials, a, implicit->values,
                                           &error);
        if (status)
            return dl_sundials_answer(&implicit->sundials, status, &error);
    }
    /* singular: another step may not be */
    return dl_preconditioner_factorise(preconditioner, gamma, &error) ? 1 : 0;
}

static int solve_preconditioner(sunrealtype t, N_Vector y, N_Vector ydot, N_Vector r, N_Vector z,
                                sunrealtype gamma, sunrealtype delta, int side, void *user_data) {
    (void)t, (void)y, (void)ydot, (void)delta, (void)side;
    dl_implicit *const implicit = user_data;
    return dl_preconditioner_solve(&implicit->preconditioner, gamma, N_VGetArrayPointer(r),
                                   N_VGetArrayPointer(z), NULL)
               ? 1
               : 0;
}

static const struct {
    SUNLinearSolver (*create)(N_Vector y, int side, int most, SUNContext context);
    int side; /* on which it takes a preconditioner */
} krylov_methods[] = {
    {SUNLinSol_SPGMR, SUN_PREC_LEFT},
    {SUNLinSol_SPFGMR, SUN_PREC_RIGHT},
    {SUNLinSol_SPBCGS, SUN_PREC_LEFT},
    {SUNLinSol_SPTFQMR, SUN_PREC_LEFT},
};

const char *const dl_krylov_words[] = {"gmres", "fgmres", "bicgstab", "tfqmr", NULL};

static int attach_krylov(dl_implicit *implicit, void *memory, N_Vector state,
                         const dl_implicit_options *options) {
    const bool preconditioned = options->preconditioner != DL_PRECONDITIONER_NONE;
    const int side = preconditioned ? krylov_methods[options->krylov].side : SUN_PREC_NONE;
    dl_error error = {""};
    if (dl_preconditioner_create(&implicit->preconditioner,
                                 (dl_preconditioner_kind)options->preconditioner,
                                 &implicit->sundials, &error))
        return ARK_MEM_FAIL;
    implicit->linear = krylov_methods[options->krylov].create(
        state, side, (int)options->krylov_dimension, implicit->sundials.context);
    if (!implicit->linear)
        return ARK_MEM_FAIL;
    int flag = implicit->calls->set_linear_solver(memory, implicit->linear, NULL);
    if (!flag)
        flag = implicit->calls->set_jacobian_times(memory, NULL, jacobian_times);
    if (!flag && preconditioned)
        flag = implicit->calls->set_preconditioner(memory, set_up_preconditioner,
                                                   solve_preconditioner);
    return flag;
}

/* --- Newton with a diagonal --------------------------------------------------------------------
 */

static int attach_diagonal(dl_implicit *implicit, void *memory, N_Vector state,
                           const dl_implicit_options *options) {
    (void)state, (void)options;
    return implicit->calls->use_diagonal(memory) ? ARK_MEM_FAIL : ARK_SUCCESS;
}

/* --- all ---------------------------------------------------------------------------------------
 */

static int (*const attach[])(dl_implicit *implicit, void *memory, N_Vector state,
                             const dl_implicit_options *options) = {
    [DL_IMPLICIT_FIXED_POINT] = attach_fixed_point,
    [DL_IMPLICIT_DENSE] = attach_dense,
    [DL_IMPLICIT_KLU] = attach_klu,
    [DL_IMPLICIT_KRYLOV] = attach_krylov,
    [DL_IMPLICIT_DIAGONAL] = attach_diagonal,
};

int dl_implicit_attach(dl_implicit *implicit, const dl_implicit_calls *calls, void *memory,
                       N_Vector state, const dl_implicit_options *options) {
    implicit->calls = calls;
    return attach[options->solver](implicit, memory, state, options);
}

static unsigned long count(int (*get)(void *memory, long *value), void *memory) {
    long value = 0;
    return get(memory, &value) ? 0 : (unsigned long)value;
}

void dl_implicit_add_stats(const dl_implicit *implicit, void *memory, dl_method_stats *stats) {
    stats->nonlinear_iterations += count(implicit->calls->nonlinear_iterations, memory);
    if (implicit->linear)
        stats->linear_iterations += count(implicit->calls->linear_iterations, memory);
    if (implicit->factorises)
        stats->factorisations += count(implicit->calls->set_ups, memory);
    stats->factorisations += implicit->preconditioner.factorisations;
}

void dl_implicit_free(dl_implicit *implicit) {
    if (implicit->nonlinear)
        SUNNonlinSolFree(implicit->nonlinear);
    if (implicit->linear)
        SUNLinSolFree(implicit->linear);
    if (implicit->matrix)
        SUNMatDestroy(implicit->matrix);
    dl_preconditioner_free(&implicit->preconditioner);
    free(implicit->values);
}
