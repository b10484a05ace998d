/* A box that repeats itself along some of the axes. Positions are never wrapped: a separation is
 * taken to the nearest of a particle's copies (minimum image),
 *
 *     d - L round(d / L),
 *
 * so that a state stays continuous for multistep methods and for the neighbour list's displacement
 * test. With every cutoff <= L/2 at most one copy of a pair is within reach, and the nearest copy
 * along each axis is the nearest of all. */
#ifndef DL_FORCE_BOX_H
#define DL_FORCE_BOX_H

#include <math.h>
#include <stdbool.h>

typedef struct dl_box {
    double length[3];  /* 0 along an axis without a period */
    double inverse[3]; /* 1 / length, 0 along an axis without a period */
} dl_box;

/* What the nearest copy of a separation lies away from d along axis c: a whole number of periods
 * to be subtracted. */
static inline double dl_box_shift(const dl_box *box, int c, double d) {
    return box->length[c] * nearbyint(d * box->inverse[c]);
}

/* Whether another copy than that at d is the nearest one after `change`; d becomes its start. */
static inline bool dl_box_nearest_changes(const dl_box *box, int dimension, double d[3],
                                          const double change[3]) {
    bool changes = false;
    for (int c = 0; c < dimension; c++) {
        double shift = dl_box_shift(box, c, d[c] + change[c]);
        changes |= shift != 0;
        d[c] -= shift;
    }
    return changes;
}

#endif
