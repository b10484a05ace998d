/* One pair as particles 0 and 1 of a scene of its own, for the vector loops: their force of it has
 * the bits that it has among all others. */
#ifndef DL_FORCE_PAIR_ALONE_H
#define DL_FORCE_PAIR_ALONE_H

#include "force/kernel.h"

typedef struct dl_pair_alone {
    double x[3][2 + DL_VECTOR_PAD], delta[3][2 + DL_VECTOR_PAD], f[3][2 + DL_VECTOR_PAD];
    double coupling[2 + DL_VECTOR_PAD];
    dl_pair_arrays arrays; /* over these */
} dl_pair_alone;

/* x and delta (NULL: no step) are blocks of all particles, `buffer` the scratch of the kernel's
 * loops. */
void dl_pair_alone_load(const dl_kernel *kernel, const double *x, const double *delta, size_t i,
                        size_t j, double *buffer, dl_pair_alone *alone);

#endif
