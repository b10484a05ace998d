/* The readable kernel: a double loop over pairs that calls the law. Every other one is tested
 * against it.
 *
 *     F_i = sum_j coupling_i coupling_j (F(r)/r) (r_i - r_j)          TR323 (3.5)-(3.7) */
#include <string.h>
#include "force/kernel.h"

static dl_status create(dl_kernel *kernel, dl_error *error) {
    (void)kernel;
    (void)error;
    return DL_OK;
}

static void destroy(dl_kernel *kernel) {
    (void)kernel;
}

static double coupling_of(const dl_pair_problem *p, size_t i, size_t j) {
    return p->coupling ? p->coupling[i] * p->coupling[j] : 1;
}

static dl_status force(dl_kernel *kernel, const double *x, double *f, dl_error *error) {
    (void)error;
    const dl_pair_problem *p = &kernel->problem;
    size_t n = p->particles;
    memset(f, 0, (size_t)p->dimension * n * sizeof *f);
    for (size_t i = 0; i < p->moving; i++)
        for (size_t j = i + 1; j < n; j++) {
            double d[3], s = 0;
            for (int c = 0; c < p->dimension; c++) {
                d[c] = x[(size_t)c * n + i] - x[(size_t)c * n + j];
                s += d[c] * d[c];
            }
            double over_r = coupling_of(p, i, j) * dl_law_force_over_r(p->law, s);
            for (int c = 0; c < p->dimension; c++) {
                f[(size_t)c * n + i] += over_r * d[c];
                f[(size_t)c * n + j] -= over_r * d[c];
            }
        }
    return DL_OK;
}

static dl_status discrete(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error) {
    (void)error;
    const dl_pair_problem *p = &kernel->problem;
    size_t n = p->particles;
    memset(f, 0, (size_t)p->dimension * n * sizeof *f);
    for (size_t i = 0; i < p->moving; i++)
        for (size_t j = i + 1; j < n; j++) {
            double sum[3], s0 = 0, s1 = 0, ds = 0; /* sum = d0 + d1 */
            for (int c = 0; c < p->dimension; c++) {
                size_t k = (size_t)c * n;
                double d0 = x[k + i] - x[k + j], change = delta[k + i] - delta[k + j];
                double d1 = d0 + change;
                sum[c] = d0 + d1;
                s0 += d0 * d0;
                s1 += d1 * d1;
                ds += change * sum[c];
            }
            double g = coupling_of(p, i, j) * dl_law_discrete(p->law, s0, s1, ds, NULL);
            for (int c = 0; c < p->dimension; c++) {
                f[(size_t)c * n + i] += g * sum[c];
                f[(size_t)c * n + j] -= g * sum[c];
            }
        }
    return DL_OK;
}

static dl_status rows(dl_kernel *kernel, const double *x, const double *delta, dl_pair_rows *out,
                      dl_error *error) {
    (void)kernel;
    (void)x;
    (void)delta;
    (void)error;
    *out = (dl_pair_rows){NULL, NULL, 1};
    return DL_OK;
}

const dl_kernel_ops dl_kernel_reference = {
    .name = "reference",
    .doc = "plain double loop over all pairs, for comparison",
    .create = create,
    .force = force,
    .discrete = discrete,
    .rows = rows,
    .destroy = destroy,
};
