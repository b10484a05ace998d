/* The pair law in extended precision, piece by piece: what force/law.h is in double precision. A
 * piece is evaluated by its own formula wherever it is asked for, also beyond its ends: a step
 * keeps to the pieces it began with, and ends where a pair leaves its own. */
#ifndef DL_REFERENCE_LAW_H
#define DL_REFERENCE_LAW_H

#include "driftlab/scene.h"
#include "reference/extended/real.h"

/* coefficient r^(-power); `whole` is the power where that is a whole number, or else -1. */
typedef struct law_term {
    real coefficient, power;
    int whole;
} law_term;

typedef struct law_sum {
    int terms;
    law_term term[DL_MAX_TERMS + 1]; /* with that of a shift, of power 0 */
} law_sum;

/* F = A, or in a taper S A + (1 - S) B with S = v^3 (10 - 15 v + 6 v^2), v = (until - r)/width. */
typedef struct law_piece {
    real begin, until;
    bool ends; /* false: `until` is infinite */
    bool tapers;
    real width;
    law_sum own, next; /* A, B */
} law_piece;

enum { law_pieces = 2 * DL_MAX_PIECES };

typedef struct law {
    int pieces;
    law_piece piece[law_pieces];
} law;

#define law_prepare      DL_TYPED(dl_extended_law_prepare)
#define law_piece_at     DL_TYPED(dl_extended_law_piece_at)
#define law_term_over_r  DL_TYPED(dl_extended_law_term_over_r)
#define law_force_over_r DL_TYPED(dl_extended_law_force_over_r)

void law_prepare(const dl_pair_law *source, law *made);

/* The piece that r lies in, its upper end included; made->pieces beyond the last. */
int law_piece_at(const law *of, real r);

/* coefficient r^(-power - 1), `inverse` = 1/r. */
real law_term_over_r(const law_term *term, real r, real inverse);

/* F(r)/r by that piece's formula. */
real law_force_over_r(const law_piece *piece, real r_squared);

#endif
