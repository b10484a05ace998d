/* Powers by squaring. */
#ifndef DL_FORCE_WHOLE_POWER_H
#define DL_FORCE_WHOLE_POWER_H

/* x^n, n >= 0. */
static inline double dl_whole_power(double x, int n) {
    double result = n & 1 ? x : 1;
    for (n >>= 1; n > 0; n >>= 1) {
        x *= x;
        if (n & 1)
            result *= x;
    }
    return result;
}

#endif
