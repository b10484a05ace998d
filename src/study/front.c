#include "driftlab/front.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

double dl_case_cost(const dl_case *cased, dl_cost cost) {
    const dl_run_summary *run = &cased->summary;
    const double costs[DL_COSTS] = {
        [DL_COST_CPU] = run->cpu_seconds,
        [DL_COST_FORCES] = (double)run->force_evaluations,
        [DL_COST_STEPS] = (double)run->steps,
    };
    return costs[cost];
}

static int by_cost_then_error(const void *left, const void *right) {
    const dl_front_point *a = left, *b = right;
    if (a->cost != b->cost)
        return a->cost < b->cost ? -1 : 1;
    if (a->error != b->error)
        return a->error < b->error ? -1 : 1;
    return (a->index > b->index) - (a->index < b->index);
}

size_t dl_front_of(dl_front_point *point, size_t count) {
    size_t finite = 0, kept = 0;
    for (size_t i = 0; i < count; i++)
        if (isfinite(point[i].cost) && isfinite(point[i].error))
            point[finite++] = point[i];
    if (finite == 0)
        return 0;
    qsort(point, finite, sizeof *point, by_cost_then_error);
    for (size_t i = 0; i < finite; i++)
        if (kept == 0 || point[i].error < point[kept - 1].error)
            point[kept++] = point[i];
    return kept;
}

const dl_front_point *dl_front_cheapest(const dl_front_point *front, size_t count, double error) {
    for (size_t i = 0; i < count; i++)
        if (front[i].error <= error)
            return &front[i];
    return NULL;
}

/* Exponent of the nearest power of ten that is not smaller. */
static int decade(double error) {
    static const int least = -16; /* the last digit of a double */
    return error > pow(10, least) ? (int)ceil(log10(error)) : least;
}

bool dl_front_decades(const dl_front_point *front, size_t count, int *largest, int *smallest) {
    if (count == 0)
        return false;
    *largest = decade(front[0].error);
    *smallest = decade(front[count - 1].error);
    return true;
}

size_t dl_results_front(const dl_results *results, const char *scene, const char *asked_in,
                        dl_cost cost, dl_front_point *front) {
    const dl_reference *reference = dl_results_reference(results, scene);
    size_t count = 0;
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *cased = &results->cased[i];
        if (strcmp(cased->scene, scene) == 0)
            front[count++] = (dl_front_point){dl_case_cost(cased, cost),
                                              dl_case_bound(cased, asked_in, reference), i};
    }
    return dl_front_of(front, count);
}
