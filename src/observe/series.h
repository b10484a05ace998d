/* Statistics of a time series whose values, sampled at equal intervals, remember one another.
 *
 * Confidence comes from batch means: the series is cut into equal batches so much longer than its
 * memory that their means are independent, and Student's t does the rest (G. S. Fishman,
 * doi:10.1287/mnsc.24.5.510; the same idea in H. Flyvbjerg and H. G. Petersen,
 * doi:10.1063/1.457480). Intervals are at 95 %, two-sided; one that cannot be told, for want of
 * enough independent samples, is NAN to NAN. */
#ifndef DL_OBSERVE_SERIES_H
#define DL_OBSERVE_SERIES_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

/* Batches: between these numbers, each at least so many correlation times long. */
enum { DL_LEAST_BATCHES = 8, DL_MOST_BATCHES = 30, DL_BATCH_CORRELATION_TIMES = 10 };

typedef struct dl_interval {
    double value, low, high;
} dl_interval;

/* Integrated autocorrelation time in samples: 1/2 + sum of rho_k up to the first lag of at least
 * five such times (N. Madras and A. D. Sokal, doi:10.1007/BF01022990). 1/2 where samples do not
 * remember one another (or alternate), n where the whole series is one memory. NAN for n < 4. */
double dl_series_correlation(const double *value, size_t n);

/* Mean and its interval. *correlation (may be NULL) as above. */
dl_interval dl_series_mean(const double *value, size_t n, double *correlation);

/* The straight line  intercept + slope * k  (k: the sample, from 0) by least squares. Where the
 * residuals remember one another for too long (an error that adds up like a random walk has no
 * other memory than the whole run), the slope is the mean of the increments from sample to sample
 * instead, which do not. */
typedef struct dl_line {
    double intercept;
    dl_interval slope;  /* of one sample interval; its interval from batches' means */
    double rms;         /* of the residuals about the line, n - 2 degrees of freedom */
    double correlation; /* of the residuals, in samples */
    size_t batches;     /* of the residuals; 0: too few for them */
} dl_line;

/* n >= 3 values. residual [n] may be NULL. DL_MEMORY. */
dl_status dl_series_line(const double *value, size_t n, dl_line *line, double *residual,
                         dl_error *error);

/* Power of the length of time that the fluctuation about a line goes with, from an eighth of the
 * series to the whole: about 0 where it is bounded, 1/2 for a random walk, more for what has not
 * yet turned. NAN for n < 32. */
double dl_series_growth(const double *value, size_t n);

/* --- the same problem at several steps ---------------------------------------------------------
 */

enum { DL_MOST_LEVELS = 8 };

/* Series of the same times with steps (or tolerances) `size`, about lines of their own: slopes of
 * ln(fluctuation) and ln(|slope|) against ln(size) by least squares, whose intervals are those of
 * the jackknife that leaves out one batch of time from all series at once (B. Efron and C. Stein,
 * doi:10.1214/aos/1176345462): what the series have in common cancels. */
typedef struct dl_orders {
    dl_interval fluctuation; /* NAN where some series' residuals are too few for batches */
    dl_interval slope;       /* NAN where some series' slope may be 0 */
} dl_orders;

/* 2 to DL_MOST_LEVELS series of n >= 3 values, and their sizes. DL_MEMORY. */
dl_status dl_series_orders(size_t levels, const double *const *value, const double *size, size_t n,
                           dl_orders *orders, dl_error *error);

/* --- the transient -----------------------------------------------------------------------------
 */

/* How many samples to leave out at the start: the truncation for which the marginal standard error
 * of the mean of what is left is least, over batches of five (MSER-5: K. P. White,
 * doi:10.1177/003754979706900601; K. P. White, M. J. Cobb and S. C. Spratt, "A comparison of five
 * steady-state truncation heuristics for simulation", Winter Simulation Conference, 2000), the last
 * fifth of the series excepted, where the rule means nothing. */
size_t dl_series_truncation(const double *value, size_t n);

/* What a series still changes, in standard errors, from two tests of it of which the larger counts:
 *     Geweke's z, the difference of the means of the first tenth and of the last half over its
 *     standard error from the variance and the correlation time of the last half (J. Geweke,
 *     "Evaluating the accuracy of sampling-based approaches to the calculation of posterior
 *     moments", Bayesian Statistics 4, 1992);
 *     the slope of the line over its standard error, which sees slow changes that Geweke's does
 *     not.
 * NAN where there are too few samples to tell. */
double dl_series_change(const double *value, size_t n, dl_error *error);

/* Modulus that a series which does not change passes about once in a hundred times. */
#define DL_SETTLED_BOUND 3.5

#endif
