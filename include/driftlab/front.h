/* What accuracy costs: the cases of a work-precision study that no other beats (the Pareto front)
 * and the cheapest for every accuracy. */
#ifndef DRIFTLAB_FRONT_H
#define DRIFTLAB_FRONT_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/results.h"

/* What a run spends: CPU seconds (the least of the repeats), force evaluations, accepted steps. */
typedef enum dl_cost { DL_COST_CPU, DL_COST_FORCES, DL_COST_STEPS, DL_COSTS } dl_cost;

double dl_case_cost(const dl_case *cased, dl_cost cost);

typedef struct dl_front_point {
    double cost, error;
    size_t index; /* the caller's own */
} dl_front_point;

/* Moves to the beginning those that none beats, from the cheapest to the most accurate, and returns
 * how many these are: of any other point that costs no more, the error is larger. Of points that
 * are equal in both it is the one of lowest index. A point whose cost or error is not a finite
 * number is not one. */
size_t dl_front_of(dl_front_point *point, size_t count);

/* The cheapest of a front whose error is at most `error`; NULL: none. */
const dl_front_point *dl_front_cheapest(const dl_front_point *front, size_t count, double error);

/* Decades to tell the cheapest for, as exponents of ten: from the error of the front's cheapest,
 * rounded up, to that of its most accurate, but not below 1e-16. False where the front is empty. */
bool dl_front_decades(const dl_front_point *front, size_t count, int *largest, int *smallest);

/* The front of a scene's cases with their dl_case_bound as error: what failed, is invalid or is
 * past the horizon is not in it. `front` has room for all cases; indices are those of
 * results->cased. */
size_t dl_results_front(const dl_results *results, const char *scene, const char *asked_in,
                        dl_cost cost, dl_front_point *front);

#endif
