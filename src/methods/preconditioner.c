#include "methods/preconditioner.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunmatrix/sunmatrix_sparse.h>

const char *const dl_preconditioner_words[] = {
    [DL_PRECONDITIONER_NONE] = "none",
    [DL_PRECONDITIONER_BLOCKS] = "blocks",
    [DL_PRECONDITIONER_KLU] = "klu",
    NULL,
};

/* --- blocks ------------------------------------------------------------------------------------
 * Entry (r, c) of particle i's block stands at (i * dimension + r) * dimension + c. */

static void set_blocks(dl_preconditioner *p, const dl_sparsity *pattern, const double *values) {
    const size_t dimension = (size_t)p->dimension, particles = p->n / dimension;
    for (size_t column = 0; column < p->n; column++) {
        const size_t i = column % particles, c = column / particles;
        for (long k = pattern->column_start[column]; k < pattern->column_start[column + 1]; k++) {
            const size_t row = (size_t)pattern->row[k];
            if (row % particles == i)
                p->block[(i * dimension + row / particles) * dimension + c] = values[k];
        }
    }
}

/* The inverse of a matrix of 2 or 3 rows, by its adjugate; false where it is singular. */
static bool invert(int rows, const double *m, double *inverse) {
    if (rows == 2) {
        const double determinant = m[0] * m[3] - m[1] * m[2];
        const double of[] = {m[3], -m[1], -m[2], m[0]};
        for (int k = 0; k < 4; k++)
            inverse[k] = of[k] / determinant;
        return isnormal(determinant);
    }
    double determinant = 0;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            inverse[3 * c + r] = m[3 * r1 + c1] * m[3 * r2 + c2] - m[3 * r1 + c2] * m[3 * r2 + c1];
        }
    for (size_t c = 0; c < 3; c++)
        determinant += m[c] * inverse[3 * c];
    for (int k = 0; k < 9; k++)
        inverse[k] /= determinant;
    return isnormal(determinant);
}

static dl_status factorise_blocks(dl_preconditioner *p, double gamma, dl_error *error) {
    const int dimension = p->dimension, each = dimension * dimension;
    const size_t particles = p->n / (size_t)dimension;
    for (size_t i = 0; i < particles; i++) {
        const double *const block = p->block + i * (size_t)each;
        double reduced[9];
        for (int k = 0; k < each; k++)
            reduced[k] = (k % (dimension + 1) == 0 ? 1 : 0) - gamma * gamma * block[k];
        if (!invert(dimension, reduced, p->inverse + i * (size_t)each))
            return dl_fail(error, DL_NONLINEAR_FAILURE,
                           "a block of the preconditioner is singular");
    }
    return DL_OK;
}

/* out = blocks in. */
static void multiply_blocks(const dl_preconditioner *p, const double *blocks, const double *in,
                            double *out) {
    const size_t dimension = (size_t)p->dimension, particles = p->n / dimension;
    for (size_t r = 0; r < dimension; r++)
        for (size_t i = 0; i < particles; i++) {
            double sum = 0;
            for (size_t c = 0; c < dimension; c++)
                sum += blocks[(i * dimension + r) * dimension + c] * in[c * particles + i];
            out[r * particles + i] = sum;
        }
}

/* --- KLU ---------------------------------------------------------------------------------------
 */

static dl_status fail_matrix(dl_error *error) {
    return dl_fail_memory(error, "the preconditioner's matrix");
}

static dl_status create_matrices(dl_preconditioner *p, SUNContext context, sunindextype nonzeros,
                                 dl_error *error) {
    const sunindextype n = (sunindextype)p->n;
    p->a = SUNSparseMatrix(n, n, nonzeros, CSC_MAT, context);
    p->reduced = SUNSparseMatrix(n, n, nonzeros, CSC_MAT, context);
    if (p->a && p->reduced && p->left && p->right)
        p->linear = SUNLinSol_KLU(p->left, p->reduced, context);
    return p->linear && !SUNLinSolInitialize(p->linear) ? DL_OK : fail_matrix(error);
}

static dl_status set_matrix(dl_preconditioner *p, const dl_sundials *sundials,
                            const dl_sparsity *pattern, const double *values, dl_error *error) {
    const sunindextype nonzeros = (sunindextype)pattern->nonzeros;
    dl_status status = p->a ? DL_OK : create_matrices(p, sundials->context, nonzeros, error);
    if (status)
        return status;
    if (nonzeros > SUNSparseMatrix_NNZ(p->a) && SUNSparseMatrix_Reallocate(p->a, nonzeros))
        return fail_matrix(error);
    if (nonzeros > SUNSparseMatrix_NNZ(p->reduced) &&
        SUNSparseMatrix_Reallocate(p->reduced, nonzeros))
        return fail_matrix(error);
    if (pattern->generation != p->pattern &&
        SUNLinSol_KLUReInit(p->linear, p->reduced, nonzeros, SUNKLU_REINIT_PARTIAL))
        return fail_matrix(error);
    p->pattern = pattern->generation;
    for (size_t column = 0; column <= p->n; column++)
        SUNSparseMatrix_IndexPointers(p->a)[column] = pattern->column_start[column];
    for (size_t k = 0; k < pattern->nonzeros; k++)
        SUNSparseMatrix_IndexValues(p->a)[k] = pattern->row[k];
    memcpy(SUNSparseMatrix_Data(p->a), values, pattern->nonzeros * sizeof *values);
    return DL_OK;
}

static dl_status factorise_matrix(dl_preconditioner *p, double gamma, dl_error *error) {
    if (SUNMatCopy(p->a, p->reduced) || SUNMatScaleAddI(-gamma * gamma, p->reduced))
        return fail_matrix(error);
    p->factorisations++;
    return SUNLinSolSetup(p->linear, p->reduced)
               ? dl_fail(error, DL_NONLINEAR_FAILURE, "the preconditioner is singular")
               : DL_OK;
}

static dl_status solve_matrix(dl_preconditioner *p, double *z, dl_error *error) {
    if (SUNLinSolSolve(p->linear, p->reduced, p->left, p->right, 0))
        return dl_fail(error, DL_NONLINEAR_FAILURE, "the preconditioner's system was not solved");
    memcpy(z, p->left_data, p->n * sizeof *z);
    return DL_OK;
}

/* --- all ---------------------------------------------------------------------------------------
 */

dl_status dl_preconditioner_create(dl_preconditioner *p, dl_preconditioner_kind kind,
                                   const dl_sundials *sundials, dl_error *error) {
    const size_t n = sundials->model->unknowns, dimension = (size_t)sundials->model->dimension;
    *p = (dl_preconditioner){.kind = kind, .n = n, .dimension = (int)dimension};
    if (kind == DL_PRECONDITIONER_NONE)
        return DL_OK;
    p->right_data = malloc(n * sizeof *p->right_data);
    if (kind == DL_PRECONDITIONER_BLOCKS) {
        p->block = malloc(n * dimension * sizeof *p->block);
        p->inverse = malloc(n * dimension * sizeof *p->inverse);
        return p->right_data && p->block && p->inverse
                   ? DL_OK
                   : dl_fail_memory(error, "the preconditioner's blocks");
    }
    p->left_data = malloc(n * sizeof *p->left_data);
    if (!p->right_data || !p->left_data)
        return fail_matrix(error);
    p->right = dl_sundials_vector(sundials, p->right_data, n);
    p->left = dl_sundials_vector(sundials, p->left_data, n);
    return p->right && p->left ? DL_OK : fail_matrix(error);
}

void dl_preconditioner_free(dl_preconditioner *p) {
    if (p->linear)
        SUNLinSolFree(p->linear);
    if (p->a)
        SUNMatDestroy(p->a);
    if (p->reduced)
        SUNMatDestroy(p->reduced);
    if (p->right)
        N_VDestroy(p->right);
    if (p->left)
        N_VDestroy(p->left);
    free(p->right_data);
    free(p->left_data);
    free(p->block);
    free(p->inverse);
}

dl_status dl_preconditioner_set(dl_preconditioner *p, const dl_sundials *sundials,
                                const dl_sparsity *pattern, const double *values, dl_error *error) {
    if (p->kind == DL_PRECONDITIONER_KLU)
        return set_matrix(p, sundials, pattern, values, error);
    set_blocks(p, pattern, values);
    return DL_OK;
}

dl_status dl_preconditioner_factorise(dl_preconditioner *p, double gamma, dl_error *error) {
    return p->kind == DL_PRECONDITIONER_KLU ? factorise_matrix(p, gamma, error)
                                            : factorise_blocks(p, gamma, error);
}

/* z_v from z_q: with all of A it is (z_q - r_q)/gamma, without a product. */
dl_status dl_preconditioner_solve(dl_preconditioner *p, double gamma, const double *r, double *z,
                                  dl_error *error) {
    const size_t n = p->n;
    const double *const r_q = r, *const r_v = r + n;
    double *const z_q = z, *const z_v = z + n;
    for (size_t k = 0; k < n; k++)
        p->right_data[k] = r_q[k] + gamma * r_v[k];
    if (p->kind == DL_PRECONDITIONER_KLU) {
        const dl_status status = solve_matrix(p, z_q, error);
        for (size_t k = 0; k < n; k++)
            z_v[k] = (z_q[k] - r_q[k]) / gamma;
        return status;
    }
    multiply_blocks(p, p->inverse, p->right_data, z_q);
    multiply_blocks(p, p->block, z_q, z_v);
    for (size_t k = 0; k < n; k++)
        z_v[k] = r_v[k] + gamma * z_v[k];
    return DL_OK;
}
