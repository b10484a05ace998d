/* Largest components: what methods measure changes and sizes by. */
#ifndef DL_METHODS_NORMS_H
#define DL_METHODS_NORMS_H

#include <math.h>
#include <stddef.h>

static inline double dl_largest(const double *values, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(values[i]));
    return most;
}

static inline double dl_largest_difference(const double *a, const double *b, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(a[i] - b[i]));
    return most;
}

#endif
