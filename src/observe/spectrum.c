#include "observe/spectrum.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>

#include "core/random_stream.h"
#include "model/private.h"

/* With fewer unknowns all eigenvalues cost less than the iteration (measured: 3 ms at 100). */
static const size_t few_unknowns = 100;

static dl_status not_finite(dl_error *error) {
    return dl_fail(error, DL_UNSTABLE,
                   "the force's derivatives are not finite: particles coincide "
                   "or have blown up");
}

static bool is_held(const dl_model *model, size_t u) {
    return model->held && model->held[u];
}

/* Square root of the inertia of an unknown. */
static double root_inertia(const dl_model *model, size_t u) {
    return sqrt(model->priv->inertia[u % model->moving]);
}

/* --- all of them ------------------------------------------------------------------------------ */

/* K, full, from the sparse values of d a / d q. */
static void fill_matrix(const dl_model *model, const dl_sparsity *pattern, const double *values,
                        double *matrix) {
    const size_t n = model->unknowns;
    for (size_t column = 0; column < n; column++) {
        const double below = root_inertia(model, column);
        for (long k = pattern->column_start[column]; k < pattern->column_start[column + 1]; k++) {
            const size_t row = (size_t)pattern->row[k];
            matrix[row * n + column] =
                is_held(model, column) ? 0 : -values[k] * root_inertia(model, row) / below;
        }
    }
}

static dl_status full_matrix(dl_model *model, const double *q, double **matrix, dl_error *error) {
    const size_t n = model->unknowns;
    const dl_sparsity *pattern;
    dl_status status = dl_model_sparsity(model, q, NULL, &pattern, error);
    if (status)
        return status;
    double *const values = malloc((pattern->nonzeros + 1) * sizeof *values);
    *matrix = calloc(n * n, sizeof **matrix);
    status = values && *matrix ? dl_model_jacobian(model, q, values, error)
                               : dl_fail_memory(error, "a Hessian");
    if (!status)
        fill_matrix(model, pattern, values, *matrix);
    for (size_t k = 0; !status && k < n * n; k++)
        if (!isfinite((*matrix)[k]))
            status = not_finite(error);
    free(values);
    return status;
}

static int ascending(const void *left, const void *right) {
    const double a = *(const double *)left, b = *(const double *)right;
    return (a > b) - (a < b);
}

/* Destroys the matrix. */
static dl_status eigenvalues(double *matrix, size_t n, double *value, dl_error *error) {
    gsl_set_error_handler_off(); /* GSL's default is to abort */
    gsl_eigen_symm_workspace *const work = gsl_eigen_symm_alloc(n);
    if (!work)
        return dl_fail_memory(error, "eigenvalues");
    gsl_matrix_view a = gsl_matrix_view_array(matrix, n, n);
    gsl_vector_view to = gsl_vector_view_array(value, n);
    const int code = gsl_eigen_symm(&a.matrix, &to.vector, work);
    gsl_eigen_symm_free(work);
    if (code)
        return dl_fail(error, DL_ERROR, "eigenvalues: %s", gsl_strerror(code));
    qsort(value, n, sizeof *value, ascending);
    return DL_OK;
}

dl_status dl_spectrum_all(dl_model *model, const double *q, double *value, dl_error *error) {
    double *matrix = NULL;
    dl_status status = full_matrix(model, q, &matrix, error);
    if (!status)
        status = eigenvalues(matrix, model->unknowns, value, error);
    free(matrix);
    return status;
}

static dl_status ends_of_all(dl_model *model, const double *q, dl_spectrum *spectrum,
                             dl_error *error) {
    const size_t n = model->unknowns;
    double *const value = malloc(n * sizeof *value);
    const dl_status status =
        value ? dl_spectrum_all(model, q, value, error) : dl_fail_memory(error, "eigenvalues");
    if (!status)
        *spectrum = (dl_spectrum){.smallest = value[0], .largest = value[n - 1]};
    free(value);
    return status;
}

/* --- Lanczos ---------------------------------------------------------------------------------- */

/* Bounds on the residuals of the two Ritz vectors, in units of the larger modulus. The values' own
 * errors are their squares over the distance of the next eigenvalue. The lower end, among the slow
 * motions, is the harder and matters less. */
static const double largest_residual = 1e-6, smallest_residual = 1e-5;

enum { most_vectors = 600, between_checks = 8 };

typedef struct lanczos {
    dl_model *model;
    const double *q;
    size_t n, most, done;
    double *vector;       /* [most + 1][n], orthonormal */
    double *alpha, *beta; /* [most]: the tridiagonal matrix; beta[k] couples k and k + 1 */
    double *work;         /* [2 n] */
    double *small;        /* [2 most^2]: the tridiagonal matrix, its eigenvectors */
    double *value;        /* [most] */
    dl_spectrum spectrum; /* of the tridiagonal matrix */
} lanczos;

static dl_status allocate(lanczos *l, dl_error *error) {
    const size_t n = l->n, most = l->most;
    l->vector = calloc((most + 1) * n, sizeof *l->vector);
    l->alpha = calloc(2 * most, sizeof *l->alpha);
    l->work = calloc(2 * n, sizeof *l->work);
    l->small = malloc(2 * most * most * sizeof *l->small);
    l->value = calloc(most, sizeof *l->value);
    if (!l->vector || !l->alpha || !l->work || !l->small || !l->value)
        return dl_fail_memory(error, "Lanczos' iteration");
    l->beta = l->alpha + most;
    return DL_OK;
}

static void release(lanczos *l) {
    free(l->vector);
    free(l->alpha);
    free(l->work);
    free(l->small);
    free(l->value);
}

static double product(const double *a, const double *b, size_t n) {
    double sum = 0;
    for (size_t u = 0; u < n; u++)
        sum += a[u] * b[u];
    return sum;
}

static void normalise(double *a, size_t n) {
    const double length = sqrt(product(a, a, n));
    for (size_t u = 0; u < n; u++)
        a[u] /= length;
}

/* out = K v. */
static dl_status apply(lanczos *l, const double *v, double *out, dl_error *error) {
    double *const u = l->work;
    for (size_t k = 0; k < l->n; k++)
        u[k] = v[k] / root_inertia(l->model, k);
    const dl_status status = dl_model_jacobian_vector(l->model, l->q, u, out, error);
    for (size_t k = 0; k < l->n; k++)
        out[k] *= -root_inertia(l->model, k);
    return status;
}

static dl_status start(lanczos *l, dl_error *error) {
    dl_random *random = NULL;
    const dl_status status = dl_random_create(1, 0, &random, error);
    if (status)
        return status;
    dl_random_begin(random, 0, DL_RANDOM_POSITION);
    for (size_t u = 0; u < l->n; u++)
        l->vector[u] = is_held(l->model, u) ? 0 : dl_random_normal(random);
    dl_random_free(random);
    normalise(l->vector, l->n);
    return DL_OK;
}

/* One more vector; twice orthogonalised against all before, which leaves roundoff. */
static dl_status extend(lanczos *l, dl_error *error) {
    const size_t n = l->n, k = l->done;
    double *const next = l->vector + (k + 1) * n;
    const dl_status status = apply(l, l->vector + k * n, next, error);
    if (status)
        return status;
    l->alpha[k] = product(next, l->vector + k * n, n);
    if (!isfinite(l->alpha[k]))
        return not_finite(error);
    for (int pass = 0; pass < 2; pass++)
        for (size_t j = 0; j <= k; j++) {
            const double *const v = l->vector + j * n;
            const double part = product(next, v, n);
            for (size_t u = 0; u < n; u++)
                next[u] -= part * v[u];
        }
    l->beta[k] = sqrt(product(next, next, n));
    l->done++;
    return DL_OK;
}

/* Eigenvalues of the tridiagonal matrix; the residual of each end is |beta| times the last
 * component of its eigenvector. */
static dl_status solve_small(lanczos *l, double residual[2], dl_error *error) {
    const size_t m = l->done;
    gsl_set_error_handler_off();
    gsl_eigen_symmv_workspace *const work = gsl_eigen_symmv_alloc(m);
    if (!work)
        return dl_fail_memory(error, "Lanczos' iteration");
    memset(l->small, 0, m * m * sizeof *l->small);
    for (size_t k = 0; k < m; k++) {
        l->small[k * m + k] = l->alpha[k];
        if (k + 1 < m)
            l->small[k * m + k + 1] = l->small[(k + 1) * m + k] = l->beta[k];
    }
    gsl_matrix_view a = gsl_matrix_view_array(l->small, m, m);
    gsl_matrix_view vectors = gsl_matrix_view_array(l->small + m * m, m, m);
    gsl_vector_view values = gsl_vector_view_array(l->value, m);
    const int code = gsl_eigen_symmv(&a.matrix, &values.vector, &vectors.matrix, work);
    gsl_eigen_symmv_free(work);
    if (code)
        return dl_fail(error, DL_ERROR, "eigenvalues: %s", gsl_strerror(code));
    size_t low = 0, high = 0;
    for (size_t k = 1; k < m; k++) {
        low = l->value[k] < l->value[low] ? k : low;
        high = l->value[k] > l->value[high] ? k : high;
    }
    const double *const last = l->small + m * m + (m - 1) * m;
    l->spectrum = (dl_spectrum){.smallest = l->value[low], .largest = l->value[high]};
    residual[0] = fabs(l->beta[m - 1] * last[low]);
    residual[1] = fabs(l->beta[m - 1] * last[high]);
    return DL_OK;
}

/* Whether the vectors span all there is, or a space that K does not leave. */
static bool exhausted(const lanczos *l, double scale) {
    return l->done == l->n || l->beta[l->done - 1] <= 100 * DBL_EPSILON * scale;
}

static dl_status check(lanczos *l, bool *converged, dl_error *error) {
    double residual[2] = {0, 0};
    const dl_status status = solve_small(l, residual, error);
    const double scale = fmax(fabs(l->spectrum.smallest), fabs(l->spectrum.largest));
    *converged =
        residual[0] <= smallest_residual * scale && residual[1] <= largest_residual * scale;
    return status;
}

static dl_status iterate(lanczos *l, dl_error *error) {
    double scale = 0; /* of the tridiagonal matrix */
    bool converged = false;
    while (!converged && l->done < l->most) {
        dl_status status = extend(l, error);
        if (status)
            return status;
        scale = fmax(scale, fmax(fabs(l->alpha[l->done - 1]), l->beta[l->done - 1]));
        const bool last = exhausted(l, scale);
        if (last || l->done % between_checks == 0)
            status = check(l, &converged, error);
        if (status || last)
            return status;
        normalise(l->vector + l->done * l->n, l->n);
    }
    return converged ? DL_OK
                     : dl_fail(error, DL_ERROR,
                               "Lanczos' iteration has not converged in %zu vectors", l->most);
}

dl_status dl_spectrum_lanczos(dl_model *model, const double *q, dl_spectrum *spectrum,
                              dl_error *error) {
    lanczos l = {.model = model, .q = q, .n = model->unknowns};
    l.most = l.n < most_vectors ? l.n : most_vectors;
    dl_status status = allocate(&l, error);
    if (!status)
        status = start(&l, error);
    if (!status)
        status = iterate(&l, error);
    if (!status)
        *spectrum = l.spectrum;
    release(&l);
    return status;
}

dl_status dl_spectrum_ends(dl_model *model, const double *q, dl_spectrum *spectrum,
                           dl_error *error) {
    *spectrum = (dl_spectrum){0};
    if (!model->kernel)
        return DL_OK;
    return model->unknowns <= few_unknowns ? ends_of_all(model, q, spectrum, error)
                                           : dl_spectrum_lanczos(model, q, spectrum, error);
}
