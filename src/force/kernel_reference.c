/* The readable kernel: a double loop over pairs that calls the law. Every other one is tested
 * against it.
 *
 *     F_i = sum_j coupling_i coupling_j (F(r)/r) (r_i - r_j)          TR323 (3.5)-(3.7)
 *
 * with the law of the pair's species. */
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

/* d = r_i - r_j, of the nearest copies where the box is periodic; returns its square. */
static double separation(const dl_pair_problem *p, const double *x, size_t i, size_t j,
                         double d[3]) {
    double s = 0;
    for (int c = 0; c < p->dimension; c++) {
        const double *row = x + (size_t)c * p->particles;
        d[c] = row[i] - row[j];
        if (p->box)
            d[c] -= dl_box_shift(p->box, c, d[c]);
        s += d[c] * d[c];
    }
    return s;
}

static void force_of_pair(const dl_pair_problem *p, const double *x, size_t i, size_t j,
                          double f[3]) {
    double d[3], s = separation(p, x, i, j, d);
    const dl_law *law = &p->law[dl_pair_law_index(p, i, j)];
    double over_r = coupling_of(p, i, j) * dl_law_force_over_r(law, s);
    for (int c = 0; c < p->dimension; c++)
        f[c] = over_r * d[c];
}

/* One copy of a pair on its way from d0 to d0 + change. */
static void add_discrete(const dl_pair_problem *p, size_t i, size_t j, const double d0[3],
                         const double change[3], double f[3]) {
    double sum[3], s0 = 0, s1 = 0, ds = 0; /* sum = d0 + d1 */
    for (int c = 0; c < p->dimension; c++) {
        double d1 = d0[c] + change[c];
        sum[c] = d0[c] + d1;
        s0 += d0[c] * d0[c];
        s1 += d1 * d1;
        ds += change[c] * sum[c];
    }
    const dl_law *law = &p->law[dl_pair_law_index(p, i, j)];
    double g = coupling_of(p, i, j) * dl_law_discrete(law, s0, s1, ds, NULL);
    for (int c = 0; c < p->dimension; c++)
        f[c] += g * sum[c];
}

/* The potential of a periodic pair is the sum over its copies, and so is the discrete force: only
 * the copy nearest at the start and the copy nearest at the end can be within reach at either, so
 * that these two give the work exactly however long the step is. */
static void discrete_of_pair(const dl_pair_problem *p, const double *x, const double *delta,
                             size_t i, size_t j, double f[3]) {
    double d[3], change[3];
    separation(p, x, i, j, d);
    for (int c = 0; c < p->dimension; c++) {
        const double *row = delta + (size_t)c * p->particles;
        change[c] = row[i] - row[j];
        f[c] = 0;
    }
    add_discrete(p, i, j, d, change, f);
    if (p->box && dl_box_nearest_changes(p->box, p->dimension, d, change))
        add_discrete(p, i, j, d, change, f);
}

static void pair(dl_kernel *kernel, const double *x, const double *delta, size_t i, size_t j,
                 double *f) {
    if (delta)
        discrete_of_pair(&kernel->problem, x, delta, i, j, f);
    else
        force_of_pair(&kernel->problem, x, i, j, f);
}

static void sum_pairs(dl_kernel *kernel, const double *x, const double *delta, double *f) {
    const dl_pair_problem *p = &kernel->problem;
    memset(f, 0, (size_t)p->dimension * p->particles * sizeof *f);
    for (size_t i = 0; i < p->moving; i++)
        for (size_t j = i + 1; j < p->particles; j++) {
            double on_i[3];
            pair(kernel, x, delta, i, j, on_i);
            for (size_t c = 0; c < (size_t)p->dimension; c++) {
                f[c * p->particles + i] += on_i[c];
                f[c * p->particles + j] -= on_i[c];
            }
        }
}

static dl_status force(dl_kernel *kernel, const double *x, double *f, dl_error *error) {
    (void)error;
    sum_pairs(kernel, x, NULL, f);
    return DL_OK;
}

static dl_status discrete(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error) {
    (void)error;
    sum_pairs(kernel, x, delta, f);
    return DL_OK;
}

const dl_kernel_ops dl_kernel_reference = {
    .name = "reference",
    .doc = "plain double loop over all pairs, for comparison",
    .create = create,
    .force = force,
    .discrete = discrete,
    .pair = pair,
    .rows = dl_kernel_rows_of_all,
    .destroy = destroy,
};
