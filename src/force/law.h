/* The pair law made ready for evaluation: radial pieces, each a sum of powers.
 *
 *     F(r) = sum_s c_s r^(-p_s)                       force, positive where it repels
 *     V(r) = sum_s c_s r^(1-p_s)/(p_s-1) + constant   (p = 1: -c log r), F = -V'
 *
 * The constant of each piece makes V continuous and zero at the last breakpoint, or at infinity
 * where the last piece never ends, so that the exact flow conserves K + V even where F jumps. All
 * quantities are for coupling 1; a pair's are coupling_i coupling_j times these.
 *
 * A scene's piece whose end is shifted has a constant force, power 0, among its terms. One that is
 * tapered becomes two: what comes before the taper, and a blend F = S A + (1 - S) B of its own sum
 * A and that of the next piece B (0 beyond the last), law_taper.h. */
#ifndef DL_FORCE_LAW_H
#define DL_FORCE_LAW_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/scene.h"

enum {
    dl_law_pieces = 2 * DL_MAX_PIECES,   /* each with its taper */
    dl_law_terms = 2 * DL_MAX_TERMS + 1, /* a blend's own, the next piece's and its shift */
};

typedef struct dl_law {
    int pieces;
    bool cut;                        /* the last piece ends */
    bool integer;                    /* every power is a whole number >= 2, or a shift's 0 */
    dl_piece_end end[dl_law_pieces]; /* of the scene's piece, for a blend and what precedes it */
    bool located[dl_law_pieces];     /* crossings of `until` are located */
    double until[dl_law_pieces];     /* r; INFINITY for the last where it never ends */
    double until2[dl_law_pieces];    /* r^2 */
    double constant[dl_law_pieces];  /* of V; for a blend V(until) */
    double width[dl_law_pieces];     /* of the blend; 0: the piece is a sum of powers */
    double panel[dl_law_pieces];     /* of a blend, law_taper.h */
    int terms[dl_law_pieces];        /* of the sum, or of A */
    int next_terms[dl_law_pieces];   /* of B; they stand behind the `terms` of A */
    double coefficient[dl_law_pieces][dl_law_terms];
    double power[dl_law_pieces][dl_law_terms];    /* ascending in each sum */
    int whole_power[dl_law_pieces][dl_law_terms]; /* the same where `integer` */
} dl_law;

void dl_law_prepare(const dl_pair_law *source, dl_law *law);

/* Piece that r lies in, its upper end included; law->pieces beyond a cutoff. */
int dl_law_piece(const dl_law *law, double r_squared);

/* Pieces first ... last, law->pieces (no force) among them, of which the outer two go on beyond
 * their breakpoints: the law of a pair on its way through one. */
typedef struct dl_law_range {
    int first, last;
} dl_law_range;

static inline dl_law_range dl_law_all(const dl_law *law) {
    return (dl_law_range){0, law->pieces};
}

/* That of them by which r goes. */
int dl_law_piece_within(const dl_law *law, dl_law_range range, double r_squared);

/* sum_s c_s r^(-p_s - more) over `terms` terms of a piece from `first` on. */
double dl_law_sum(const dl_law *law, int piece, int first, int terms, double r, int more);
/* sum_s -(p_s + 1) c_s r^(-p_s - 3): (1/r) d(F/r)/dr of a sum. */
double dl_law_sum_slope(const dl_law *law, int piece, int first, int terms, double r);

/* F(r)/r, and the same of a piece's own formula (0 beyond the last piece). */
double dl_law_force_over_r(const dl_law *law, double r_squared);
double dl_law_force_over_r_within(const dl_law *law, dl_law_range range, double r_squared);
double dl_law_force_over_r_in(const dl_law *law, int piece, double r);
/* By how much F jumps at the end of a piece, from inside to outside; 0 where that is roundoff. */
double dl_law_jump(const dl_law *law, int piece);
/* (1/r) d(F/r)/dr, so that the pair's force has the Jacobian  (F/r) I + this * d d^T. */
double dl_law_force_slope(const dl_law *law, double r_squared);
double dl_law_force_slope_within(const dl_law *law, dl_law_range range, double r_squared);
double dl_law_potential(const dl_law *law, double r_squared);

/* The discrete gradient of V between two distances, TR171 (2.4):
 *     G = -(V(r1) - V(r0)) / (s1 - s0),   s = r^2,
 * with which the pair's discrete force on i is G (d0 + d1). `ds` is s1 - s0, formed without
 * cancellation. Whole powers use the paper's sums, others
 *     (r1^-k - r0^-k)/(s1 - s0) = -rho^(-k-2) sinh(k u/2)/sinh(u),  u = log(r1/r0), rho^2 = r0 r1,
 * blends the mean of their force, law_taper.h; a path across breakpoints is the sum of its parts.
 * *slope (NULL: not wanted) is dG/ds1. */
double dl_law_discrete(const dl_law *law, double s0, double s1, double ds, double *slope);
double dl_law_discrete_within(const dl_law *law, dl_law_range range, double s0, double s1,
                              double ds, double *slope);

/* The average of the pair's force along the straight way from d to d + change,
 *     f = integral over x from 0 to 1 of (F(r)/r)(d + x change),
 * into force [dimension], and its derivative by `change` into block (NULL: not wanted). By Gauss's
 * rule of dl_gauss_points points on parts of the way: they end at the breakpoints, and are so short
 * beside the distance that the rule is exact to roundoff (law_taper.h). */
void dl_law_average(const dl_law *law, int dimension, const double *d, const double *change,
                    double *force, double (*block)[3]);

#endif
