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

/* The same, of long arrays in short steps: in lanes, which a compiler takes as vectors. NaN where a
 * component is not finite. `b` may be NULL: zeros. */
enum { dl_norm_lanes = 4 };

static inline double dl_largest_in_lanes(const double *a, const double *b, size_t n) {
    double most[dl_norm_lanes] = {0}, check[dl_norm_lanes] = {0};
    size_t i = 0;
    for (; i + dl_norm_lanes <= n; i += dl_norm_lanes)
        for (size_t k = 0; k < dl_norm_lanes; k++) {
            const double d = b ? a[i + k] - b[i + k] : a[i + k], size = fabs(d);
            most[k] = size > most[k] ? size : most[k];
            check[k] += d * 0.0;
        }
    for (; i < n; i++) {
        const double d = b ? a[i] - b[i] : a[i], size = fabs(d);
        most[0] = size > most[0] ? size : most[0];
        check[0] += d * 0.0;
    }
    const double low = most[0] > most[1] ? most[0] : most[1];
    const double high = most[2] > most[3] ? most[2] : most[3];
    return (low > high ? low : high) + (check[0] + check[1] + check[2] + check[3]);
}

#endif
