/* Jacobians of a model of fixture_box against differences of its accelerations. */
#ifndef FIXTURE_DERIVATIVES_H
#define FIXTURE_DERIVATIVES_H

#include "contract.h"

enum { box_unknowns = 48 };

/* J u of the force's Jacobian, or where delta is not NULL of the discrete force's. */
FIXTURE void fixture_multiply(dl_model *model, const double *q, const double *delta,
                              const double *u, double *product) {
    const dl_sparsity *pattern;
    assert_int_equal(dl_model_sparsity(model, q, delta, &pattern, NULL), DL_OK);
    double *const values = malloc(pattern->nonzeros * sizeof *values);
    assert_int_equal(delta ? dl_model_discrete_jacobian(model, q, delta, values, NULL)
                           : dl_model_jacobian(model, q, values, NULL),
                     DL_OK);
    memset(product, 0, box_unknowns * sizeof *product);
    for (size_t c = 0; c < box_unknowns; c++)
        for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++) {
            assert_true(k == pattern->column_start[c] || pattern->row[k] > pattern->row[k - 1]);
            product[pattern->row[k]] += values[k] * u[c];
        }
    free(values);
}

/* a(q + h u), or the discrete acceleration from q to q + delta + h u. */
FIXTURE void fixture_accelerate(dl_model *model, const double *q, const double *delta,
                                const double *u, double h, double *a) {
    double at[box_unknowns], to[box_unknowns];
    for (size_t i = 0; i < box_unknowns; i++) {
        at[i] = q[i] + (delta ? 0 : h * u[i]);
        to[i] = delta ? delta[i] + h * u[i] : 0;
    }
    assert_int_equal(delta ? dl_model_discrete_acceleration(model, at, to, a, NULL)
                           : dl_model_acceleration(model, at, a, NULL),
                     DL_OK);
}

/* The matrix, and without delta the product with a vector. */
FIXTURE void fixture_check_jacobian(dl_model *model, const double *q, const double *delta) {
    double u[box_unknowns], product[box_unknowns], up[box_unknowns], down[box_unknowns];
    const double h = 1e-7;
    for (unsigned i = 0; i < box_unknowns; i++)
        u[i] = fixture_noise(i + 200);
    fixture_accelerate(model, q, delta, u, h, up);
    fixture_accelerate(model, q, delta, u, -h, down);
    for (int form = 0; form < (delta ? 1 : 2); form++) {
        if (form == 0)
            fixture_multiply(model, q, delta, u, product);
        else
            assert_int_equal(dl_model_jacobian_vector(model, q, u, product, NULL), DL_OK);
        double largest = 0;
        for (size_t i = 0; i < box_unknowns; i++)
            largest = fmax(largest, fabs(product[i]));
        assert_true(largest > 1e4);
        for (size_t i = 0; i < box_unknowns; i++)
            assert_true(fabs(product[i] - (up[i] - down[i]) / (2 * h)) <= 1e-6 * largest);
    }
}

#endif
