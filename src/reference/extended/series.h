/* Coefficients of truncated power series, one after the other: the n-th of the result from those up
 * to the n-th of the factors. */
#ifndef DL_REFERENCE_SERIES_H
#define DL_REFERENCE_SERIES_H

#include "reference/extended/real.h"

static inline real series_product(const real *a, const real *b, int n) {
    real sum = 0;
    for (int k = 0; k <= n; k++)
        sum += a[k] * b[n - k];
    return sum;
}

static inline real series_square(const real *a, int n) {
    real sum = 0;
    for (int k = 0; k < (n + 1) / 2; k++)
        sum += a[k] * a[n - k];
    return n % 2 ? 2 * sum : 2 * sum + a[n / 2] * a[n / 2];
}

/* Of u = constant * s^power, n > 0, from s u' = power s' u. */
static inline real series_power(const real *s, const real *u, real power, int n) {
    real sum = 0, factor = -n;
    for (int k = 1; k <= n; k++) {
        factor += power + 1;
        sum += factor * s[k] * u[n - k];
    }
    return sum / (n * s[0]);
}

#endif
