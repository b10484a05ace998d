/* The number type of the extended integrator. Every file of this folder is compiled once a type,
 * with DL_REAL its name; a name that files share stands in their headers as a macro for the name of
 * one type. */
#ifndef DL_REFERENCE_REAL_H
#define DL_REFERENCE_REAL_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#if defined(DL_REAL_quad)

#include "core/quad.h"
typedef __float128 real;
#define REAL_NAME         "quad"
#define REAL_EPSILON      ((real)0x1p-112)
#define REAL_FUNCTION(of) of##q

#elif defined(DL_REAL_long_double)

typedef long double real;
#define REAL_NAME         "long double"
#define REAL_EPSILON      ((real)0x1p-63)
#define REAL_FUNCTION(of) of##l

#endif

#define DL_PASTE2(a, b) a##_##b
#define DL_PASTE(a, b)  DL_PASTE2(a, b)
#define DL_TYPED(name)  DL_PASTE(name, DL_REAL)

static inline real real_sqrt(real x) {
    return REAL_FUNCTION(sqrt)(x);
}

static inline real real_pow(real x, real power) {
    return REAL_FUNCTION(pow)(x, power);
}

static inline real real_cos(real x) {
    return REAL_FUNCTION(cos)(x);
}

/* To the nearest whole number, ties to even ones. */
static inline real real_round(real x) {
    return REAL_FUNCTION(rint)(x);
}

static inline bool real_is_finite(real x) {
    return x - x == 0;
}

static inline real real_abs(real x) {
    return x < 0 ? -x : x;
}

static inline real real_min(real a, real b) {
    return a < b ? a : b;
}

static inline real real_max(real a, real b) {
    return a > b ? a : b;
}

#endif
