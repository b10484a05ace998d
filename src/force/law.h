/* The pair law made ready for evaluation: radial pieces, each a sum of powers.
 *
 *     F(r) = sum_s c_s r^(-p_s)                       force, positive where it repels
 *     V(r) = sum_s c_s r^(1-p_s)/(p_s-1) + constant   (p = 1: -c log r), F = -V'
 *
 * The constant of each piece makes V continuous and zero at the last breakpoint, or at infinity
 * where the last piece never ends, so that the exact flow conserves K + V even where F jumps. All
 * quantities are for coupling 1; a pair's are coupling_i coupling_j times these. */
#ifndef DL_FORCE_LAW_H
#define DL_FORCE_LAW_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/scene.h"

typedef struct dl_law {
    int pieces;
    bool cut;                       /* the last piece ends */
    bool integer;                   /* every power is a whole number >= 2 */
    double until[DL_MAX_PIECES];    /* r; INFINITY for the last where it never ends */
    double until2[DL_MAX_PIECES];   /* r^2 */
    double constant[DL_MAX_PIECES]; /* of V */
    int terms[DL_MAX_PIECES];
    double coefficient[DL_MAX_PIECES][DL_MAX_TERMS];
    double power[DL_MAX_PIECES][DL_MAX_TERMS];    /* ascending */
    int whole_power[DL_MAX_PIECES][DL_MAX_TERMS]; /* the same where `integer` */
} dl_law;

void dl_law_prepare(const dl_pair_law *source, dl_law *law);

/* Piece that r lies in, its upper end included; law->pieces beyond a cutoff. */
int dl_law_piece(const dl_law *law, double r_squared);

/* F(r)/r. */
double dl_law_force_over_r(const dl_law *law, double r_squared);
/* (1/r) d(F/r)/dr, so that the pair's force has the Jacobian  (F/r) I + this * d d^T. */
double dl_law_force_slope(const dl_law *law, double r_squared);
double dl_law_potential(const dl_law *law, double r_squared);

/* The discrete gradient of V between two distances, TR171 (2.4):
 *     G = -(V(r1) - V(r0)) / (s1 - s0),   s = r^2,
 * with which the pair's discrete force on i is G (d0 + d1). `ds` is s1 - s0, formed without
 * cancellation. Whole powers use the paper's sums, others
 *     (r1^-k - r0^-k)/(s1 - s0) = -rho^(-k-2) sinh(k u/2)/sinh(u),  u = log(r1/r0), rho^2 = r0 r1;
 * a path across breakpoints is the sum of its parts. *slope (NULL: not wanted) is dG/ds1. */
double dl_law_discrete(const dl_law *law, double s0, double s1, double ds, double *slope);

#endif
