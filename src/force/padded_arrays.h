/* One padded array a component, and the scratch of the row loops: what the vector loops work on. */
#ifndef DL_FORCE_PADDED_ARRAYS_H
#define DL_FORCE_PADDED_ARRAYS_H

#include "force/kernel.h"

typedef struct dl_padded_arrays {
    size_t stride;    /* particles + pad, a whole number of cache lines */
    double *x, *f;    /* [dimension * stride] */
    double *delta;    /* [dimension * stride], allocated by the first discrete force */
    double *buffer;   /* scratch */
    size_t *order;    /* [particles]: which particle each entry is; NULL: as they come */
    double *coupling; /* in that order, padded; NULL: the problem's own */
} dl_padded_arrays;

/* Where species differ, `order` has the moving particles species by species, then the pinned. */
dl_status dl_padded_create(const dl_pair_problem *problem, dl_padded_arrays *arrays,
                           dl_error *error);
void dl_padded_destroy(dl_padded_arrays *arrays);

/* Copies x (and delta where not NULL) in, clears f, and points `pairs` at the arrays and the first
 * law. */
dl_status dl_padded_load(dl_kernel *kernel, dl_padded_arrays *arrays, const double *x,
                         const double *delta, dl_pair_arrays *pairs, dl_error *error);
/* f, block x|y|[z] of dimension * particles in the caller's order. */
void dl_padded_unload(const dl_kernel *kernel, const dl_padded_arrays *arrays, double *f);

#endif
