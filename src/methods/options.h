/* Options that several method families share: one meaning, one wording. */
#ifndef DL_METHODS_OPTIONS_H
#define DL_METHODS_OPTIONS_H

#include <math.h>
#include <stddef.h>
#include "driftlab/method.h"

#define DL_OPTIONS_TABLE(array)                                                                    \
    { .rows = (array), .count = sizeof(array) / sizeof *(array) }

/* For methods that take no other: the scene's step where it is not given. */
#define DL_OPTION_FIXED_STEP(type)                                                                 \
    {                                                                                              \
        .name = "step", .kind = DL_REAL, .offset = offsetof(type, step), .unit = "time",           \
        .minimum = 0, .maximum = INFINITY, .above_minimum = true, .fallback = NULL,                \
        .doc = "time step"                                                                         \
    }

#define DL_OPTION_STEP_OR_ADAPTIVE(type)                                                           \
    {                                                                                              \
        .name = "step", .kind = DL_REAL, .offset = offsetof(type, step), .unit = "time",           \
        .minimum = 0, .maximum = INFINITY, .fallback = "0",                                        \
        .doc = "fixed time step; 0: chosen by rtol and atol"                                       \
    }

/* What rtol and atol bound: the method's estimate e of the error of one step, component by
 * component against  rtol |y| + atol.  SUNDIALS bounds the root mean square of the ratios over all
 * components, GSL the largest of them (by 1.1). */
#define DL_OPTION_RTOL(type)                                                                       \
    {                                                                                              \
        .name = "rtol", .kind = DL_REAL, .offset = offsetof(type, rtol), .unit = "", .minimum = 0, \
        .maximum = 0.1, .fallback = "1e-6", .when = "step=0",                                      \
        .doc = "error allowed in a step: rtol |y| + atol, for every position and velocity"         \
    }

#define DL_OPTION_ATOL(type)                                                                       \
    {                                                                                              \
        .name = "atol", .kind = DL_REAL, .offset = offsetof(type, atol),                           \
        .unit = "length and length/time", .minimum = 0, .maximum = INFINITY,                       \
        .above_minimum = true, .fallback = "1e-10", .when = "step=0",                              \
        .doc = "absolute part of the error allowed in a step (see rtol)"                           \
    }

/* Of implicit methods that solve their equations to a part of the error allowed, whatever the step.
 */
#define DL_OPTIONS_TOLERANCES_OF_STAGES(type)                                                      \
    {                                                                                              \
        .name = "rtol",                                                                            \
        .kind = DL_REAL,                                                                           \
        .offset = offsetof(type, rtol),                                                            \
        .unit = "",                                                                                \
        .minimum = 0,                                                                              \
        .maximum = 0.1,                                                                            \
        .fallback = "1e-6",                                                                        \
        .doc = "error allowed in a step: rtol |y| + atol, for every position and velocity; its "   \
               "equations are solved to a part of it, with a fixed step too",                      \
    },                                                                                             \
    {                                                                                              \
        .name = "atol", .kind = DL_REAL, .offset = offsetof(type, atol),                           \
        .unit = "length and length/time", .minimum = 0, .maximum = INFINITY,                       \
        .above_minimum = true, .fallback = "1e-10",                                                \
        .doc = "absolute part of the error allowed in a step (see rtol)"                           \
    }

#endif
