/* Preconditioners for the systems of an implicit step of q'' = a(q),
 *
 *     (I - gamma J) (z_q, z_v) = (r_q, r_v),   J = [0 I; A 0],   A = d a / d q,
 *
 * which without the velocities are
 *
 *     (I - gamma^2 A) z_q = r_q + gamma r_v,   z_v = r_v + gamma A z_q.
 *
 *     none      I
 *     blocks    A's blocks on the diagonal: a particle's own
 *     klu       all of A, factorised by KLU and kept while the integrator finds it good enough
 */
#ifndef DL_METHODS_PRECONDITIONER_H
#define DL_METHODS_PRECONDITIONER_H

#include "methods/sundials.h"

typedef enum dl_preconditioner_kind {
    DL_PRECONDITIONER_NONE,
    DL_PRECONDITIONER_BLOCKS,
    DL_PRECONDITIONER_KLU,
} dl_preconditioner_kind;

extern const char *const dl_preconditioner_words[];

typedef struct dl_preconditioner {
    dl_preconditioner_kind kind;
    size_t n;             /* unknowns */
    int dimension;        /* of space: of a block */
    double *block;        /* [n * dimension]: of A, by particle, row and column */
    double *inverse;      /* the same of (I - gamma^2 A)'s */
    SUNMatrix a, reduced; /* klu: A and I - gamma^2 A */
    SUNLinearSolver linear;
    N_Vector right, left; /* [n] over right_data and left_data */
    double *right_data, *left_data;
    unsigned long pattern;        /* generation of the sparsity that KLU analysed */
    unsigned long factorisations; /* by KLU */
} dl_preconditioner;

dl_status dl_preconditioner_create(dl_preconditioner *preconditioner, dl_preconditioner_kind kind,
                                   const dl_sundials *sundials, dl_error *error);
void dl_preconditioner_free(dl_preconditioner *preconditioner);

/* A at q from `pattern` and `values`. */
dl_status dl_preconditioner_set(dl_preconditioner *preconditioner, const dl_sundials *sundials,
                                const dl_sparsity *pattern, const double *values, dl_error *error);
/* For this gamma. DL_NONLINEAR_FAILURE where I - gamma^2 A is singular. */
dl_status dl_preconditioner_factorise(dl_preconditioner *preconditioner, double gamma,
                                      dl_error *error);
/* z = P^-1 r; both [2 n]. */
dl_status dl_preconditioner_solve(dl_preconditioner *preconditioner, double gamma, const double *r,
                                  double *z, dl_error *error);

#endif
