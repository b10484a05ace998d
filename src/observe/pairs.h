/* Distances and pair forces of a state, particles by their rows in the scene. */
#ifndef DL_OBSERVE_PAIRS_H
#define DL_OBSERVE_PAIRS_H

#include <stddef.h>
#include "driftlab/model.h"

/* r_i - r_j, to the nearest copy in a periodic box; returns its square. */
double dl_observe_separation_of(const dl_scene *scene, const double *y_all, size_t i, size_t j,
                                double d[3]);

typedef struct dl_observed_pair {
    size_t i, j;
    double d[3];         /* r_i - r_j */
    double force_over_r; /* force on i is this times d */
    double potential;
} dl_observed_pair;

typedef void dl_observed_pair_visitor(const dl_observed_pair *pair, void *context);

/* Every pair that acts, once; pairs of two pinned particles are left out. */
dl_status dl_observe_pairs(dl_model *model, const double *y_all, dl_observed_pair_visitor *visit,
                           void *context, dl_error *error);

#endif
