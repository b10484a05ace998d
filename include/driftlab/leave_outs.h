/* What leaving out saves: a scene's own model beside models of the same physics that have one more
 * thing each, and beside the general one, that has all of them.
 *
 * What is added is neutral: a second piece of the law with the formula of the first, walls at
 * infinity, couplings of 1 ... (study/leave_outs.c). A step is one of leap-frog at the scene's
 * step, nothing observed. */
#ifndef DRIFTLAB_LEAVE_OUTS_H
#define DRIFTLAB_LEAVE_OUTS_H

#include <stddef.h>
#include "driftlab/explain.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

enum { DL_MOST_LEAVE_OUTS = DL_LEFT_OUTS + 4 };

typedef struct dl_leave_out_row {
    const char *what; /* has been added */
    double seconds;   /* CPU, a step; the median of the repeats */
    double ratio;     /* to the scene's own in the same repeat: median, lowest, highest */
    double ratio_low, ratio_high;
    double bytes;      /* of model and method, on the heap; NaN where that cannot be told */
    double difference; /* of positions from the scene's own after `checked` steps, largest, as a
                        * part of the scene's extent: roundoff */
} dl_leave_out_row;

typedef struct dl_leave_outs {
    char kernel[32]; /* of the scene's own model; "none" */
    size_t particles, repeats, checked;
    size_t rows;
    dl_leave_out_row row[DL_MOST_LEAVE_OUTS]; /* the first: the scene's own model, with nothing
                                               * added; the last: everything */
} dl_leave_outs;

/* Repeats, at most DL_MOST_COST_REPEATS, take turns: each measures every model for about `seconds`,
 * or for its least number of steps. */
enum { DL_MOST_COST_REPEATS = 51 };
dl_status dl_leave_outs_measure(const dl_scene *scene, size_t repeats, double seconds,
                                dl_leave_outs *result, dl_error *error);

#endif
