/* References: trajectories certainly better than what is measured against them.
 *
 * The scene is integrated in extended precision by Taylor series of high order, events included
 * (reference/extended.h), once more with a looser tolerance and once more by another method,
 * Gauss-Legendre collocation. Twice the largest distance between these so far is the reference's
 * own error at a time. Two neighbouring trajectories give the growth of small displacements, and
 * with it the largest Lyapunov exponent.
 *
 * Horizon: from when on errors of trajectories in double precision mean nothing, because a rounding
 * error at the start, or the reference's own error were it one of double precision, has grown to 1
 * % of the distance between neighbouring particles. */
#ifndef DRIFTLAB_REFERENCE_H
#define DRIFTLAB_REFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "driftlab/results.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

/* An error that is shown is at least this many times the reference's own. */
#define DL_REFERENCE_MARGIN 100

typedef enum dl_precision {
    DL_PRECISION_AUTO, /* long double, or quad where that is not enough for `wanted` and errors at
                        * the end mean something */
    DL_PRECISION_LONG_DOUBLE,
    DL_PRECISION_QUAD, /* __float128 */
} dl_precision;

typedef struct dl_reference_request {
    dl_precision precision;
    double end;                     /* time; > 0 */
    size_t intervals;               /* between samples; > 0 */
    double wanted;                  /* auto: own error at the end that is good enough; 0: any is */
    double seconds;                 /* CPU time of each of the trajectories; > 0 */
    long memory;                    /* MiB of address space; > 0 */
    const volatile int *interrupt;  /* may be NULL */
    void (*on_tick)(void *context); /* about five times a second; may be NULL */
    void *context;
    /* [2 * dimension * particles] each, or both NULL: the state at the end, high + low, as
     * dl_reference has its positions. */
    double *final_high, *final_low;
} dl_reference_request;

/* Fills *made but for its key, digest and description's scene; the caller frees it with
 * dl_reference_release. The work is done in a process of its own. DL_TIMEOUT, DL_INTERRUPTED,
 * DL_UNSTABLE or DL_STEP_FAILURE where a trajectory does not come to its end: nothing is to be
 * freed then. Where only quad precision was out of reach, its `note` says so and the reference is
 * the one in long double. */
dl_status dl_reference_compute(const dl_scene *scene, const dl_reference_request *request,
                               dl_reference *made, dl_error *error);

/* Whether quad precision would take longer than `seconds`, from what long double took; if so `text`
 * says it. */
bool dl_reference_quad_is_too_slow(const dl_reference *in_long_double, double seconds, char *text,
                                   size_t size);

/* RMS over the particles that move of the distance of `position` [dimension * particles] from the
 * reference at a sample; *largest (may be NULL) is the largest distance. */
double dl_reference_distance(const dl_scene *scene, const dl_reference *reference, size_t sample,
                             const double *position, double *largest);

/* The same of two sets of positions. */
double dl_position_distance(const dl_scene *scene, const double *a, const double *b,
                            double *largest);

/* Whether a sample is past the horizon. */
bool dl_reference_is_past(const dl_reference *reference, size_t sample);

/* Whether an error at that sample is one: not too small for the reference, not past the horizon. */
bool dl_reference_shows(const dl_reference *reference, size_t sample, double error);

/* Whether a small displacement grows exponentially for all that is seen: in the second half by more
 * than in proportion to t^2, by which regular motion can part as well. */
bool dl_reference_grows(const dl_reference *reference);

/* Precision, own error, growth, exponent and horizon, one a line, each after `indent`. */
void dl_reference_print(const dl_reference *reference, const char *indent, FILE *out);

#endif
