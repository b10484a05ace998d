/* Pairs whose distance is near a breakpoint where their force jumps: those of a shell about it that
 * is wider than a step needs, so that it serves many steps (crossings.c). */
#ifndef DL_MODEL_NEAR_JUMPS_H
#define DL_MODEL_NEAR_JUMPS_H

#include "model/private.h"

/* Where the force of a law jumps, and by how much. */
typedef struct dl_jumps {
    int count;
    double r[dl_law_pieces], size[dl_law_pieces];
} dl_jumps;

typedef struct dl_near_pairs dl_near_pairs;

/* To be freed, also where it fails. */
dl_status dl_near_pairs_create(const dl_model *model, dl_near_pairs **near, dl_error *error);
void dl_near_pairs_free(dl_near_pairs *near);

const dl_jumps *dl_near_jumps(const dl_near_pairs *near, const dl_law *law);

/* Calls `visit` as dl_model_visit_pairs does, for all pairs that may cross a jump in a step of
 * length h from x to about x + delta, give or take twice what the jumps themselves may do; and for
 * few others. x, delta over all particles. */
dl_status dl_near_pairs_visit(dl_model *model, dl_near_pairs *near, const double *x,
                              const double *delta, double h, dl_pair_visitor *visit, void *context,
                              dl_error *error);

#endif
