/* The stability limit h omega of a method at a fixed step, measured on the harmonic oscillator
 *
 *     q'' = -omega^2 q,   omega = 1, in two dimensions (one particle held by a spring to a pin),
 *
 * as a black box: at each step it runs, and the energy K + V of the second half of the steps is set
 * against that of the first. It is stable where the largest of the second is at most twice the
 * largest of the first, and the run did not fail.
 *
 * A method whose amplification factor exceeds 1 by e a step is seen from e = log(2)/steps on: one
 * that grows at every step, but slowly, has no limit here in the sense of theory. */
#ifndef DL_STUDY_OSCILLATOR_H
#define DL_STUDY_OSCILLATOR_H

#include "study/kind.h"

typedef struct dl_oscillator_limit {
    double stable,
        unstable;     /* h omega; stable NAN: none of the steps scanned, unstable NAN: none */
    const char *word; /* how it breaks; "" where it does not */
} dl_oscillator_limit;

/* Of the steps that are scanned. */
extern const double dl_oscillator_smallest, dl_oscillator_largest;

/* Of the unit's method with its options; both NAN where it does not take such a scene. */
dl_status dl_oscillator_measure(const dl_study_unit *unit, dl_oscillator_limit *limit,
                                dl_error *error);

#endif
