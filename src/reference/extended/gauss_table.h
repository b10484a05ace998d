/* Gauss-Legendre collocation for q'' = a(q) with s stages, on [0, 1].
 *
 * The acceleration is the polynomial through its values at the zeros c_i of Legendre's polynomial,
 *     a(tau) = sum_m alpha_m P_m(2 tau - 1),   alpha_m = (2 m + 1) sum_i b_i P_m(2 c_i - 1) a_i,
 * and the coordinates are its double integral: at the stages with the matrix A, at the end with the
 * weights b_i (1 - c_i), where they are of order 2 s. */
#ifndef DL_REFERENCE_GAUSS_TABLE_H
#define DL_REFERENCE_GAUSS_TABLE_H

#include "driftlab/status.h"
#include "reference/extended/real.h"

typedef struct gauss_table {
    int stages;
    real *node, *weight; /* [stages] */
    real *place;         /* A, [stages][stages] */
    real *legendre;      /* [stages][stages]: alpha_m from the a_i */
    real *power;         /* [stages][stages]: coefficients of tau^k from the a_i */
} gauss_table;

#define gauss_table_create DL_TYPED(dl_extended_gauss_table_create)
#define gauss_table_free   DL_TYPED(dl_extended_gauss_table_free)

enum { gauss_most_stages = 24 };

dl_status gauss_table_create(int stages, gauss_table *table, dl_error *error);
void gauss_table_free(gauss_table *table);

#endif
