/* What the kind `scaling` finds over all its sizes: which bulk quantities of a body are those of
 * the largest number of particles, from which number on, and with which power of it the cost grows.
 *
 * Scenes of one name, whatever numbers are set in them ("stream(k=3,seed=1)"), are one body of
 * several sizes: a size is a number of particles, and the scenes of the same number are its
 * repeats. A method with the same options and the same step, or the same part of its scene's step,
 * is one comparison. */
#ifndef DRIFTLAB_SCALING_H
#define DRIFTLAB_SCALING_H

#include <stddef.h>
#include <stdio.h>
#include "driftlab/results.h"

enum { DL_MOST_SIZES = 32, DL_MOST_SCALED = 48, DL_SCALED_NAME = 128 };

/* A quantity by size: the mean of the repeats, and the root mean square, over the repeats, of what
 * they differ by from the mean at the largest size, as a part of that. At the largest size itself
 * that is the scatter of its repeats, 0 where there is one. */
typedef struct dl_scaled {
    char name[DL_SCALED_NAME]; /* "NAME [UNIT]" */
    double value[DL_MOST_SIZES], deviation[DL_MOST_SIZES];
    size_t from; /* the first size from which on no deviation is above the tolerance; `sizes`: not
                    even the repeats of the largest size agree */
} dl_scaled;

/* exponent of  cost = constant * particles^exponent  by least squares of the logarithms of the
 * sizes' means, with its 95 % interval (Student's t; NaN for two sizes). */
typedef struct dl_scaled_cost {
    char name[DL_SCALED_NAME];
    double value[DL_MOST_SIZES];
    double exponent, low, high;
} dl_scaled_cost;

enum { DL_SCALED_COSTS = 4 };

typedef struct dl_scaling {
    char body[DL_SCALED_NAME], method[DL_SCALED_NAME];
    const char *options, *largest; /* the results': options of the largest size's first finding,
                                      its step with them, and that finding's scene */
    double tolerance;
    size_t sizes; /* ascending */
    double particles[DL_MOST_SIZES];
    size_t repeats[DL_MOST_SIZES];
    size_t quantities;
    dl_scaled quantity[DL_MOST_SCALED];
    dl_scaled_cost cost[DL_SCALED_COSTS];
} dl_scaling;

/* How many comparisons there are; findings without a verdict of "measured" are left out. */
size_t dl_scalings_count(const dl_results *results);
/* The comparison `index`; `scaling` is the caller's. */
void dl_scaling_get(const dl_results *results, size_t index, dl_scaling *scaling);

/* Tables of quantities and costs by size, as text. */
void dl_scaling_print(const dl_scaling *scaling, FILE *out);

/* Slope of ln y against ln x, n >= 2 of each > 0; low and high NaN for n == 2, or where something
 * is not > 0. */
void dl_fit_power(const double *x, const double *y, size_t n, double *exponent, double *low,
                  double *high);

#endif
