/* Why a step by the force in the middle may have no solution.
 *
 * The implicit midpoint rule's displacement is delta = h v + (h^2/2) a(q + delta/2). For the
 * separation m of a pair in the middle of the step, all else being given, that is
 *
 *     m = b + (G/2) F(|m|) m/|m|,   G = (h^2/2)(1/inertia_i + 1/inertia_j),
 *
 * b the middle without the pair's own force: |m| - (G/2) F(|m|) = |b|. Where F jumps down by J at
 * the breakpoint R, from inside to outside, the left side jumps up by G J/2, and no m belongs to a
 * |b| in between: with the force of either side the middle is on the other,
 *
 *     |b| + (G/2) F(R+) <= R < |b| + (G/2) F(R-).
 *
 * Pairs that part or meet slowly there have such steps, however short h is: their approach to R
 * changes by h |v| from step to step, and the gap is as wide as h^2. */
#ifndef DL_MODEL_MIDDLE_GAP_H
#define DL_MODEL_MIDDLE_GAP_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/model.h"

typedef struct dl_middle_gap {
    size_t i, j;            /* in the scene's order, i < j */
    double breakpoint;      /* R */
    double inside, outside; /* |m| with the force inside of R, > R, and outside, <= R */
} dl_middle_gap;

/* Looks for such a pair in the step of length h from q, v [unknowns], about the displacement delta
 * [unknowns], which is iterated on, with a [unknowns] to work in. False: none was found. */
bool dl_model_middle_gap(dl_model *model, const double *q, const double *v, double h, double *delta,
                         double *a, dl_middle_gap *gap);

#endif
