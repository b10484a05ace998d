/* Quantities of a settled fluid, TR323, sections III and IV. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "study/paper_quantity.h"

static int compare_reals(const void *a, const void *b) {
    const double p = *(const double *)a, q = *(const double *)b;
    return (p > q) - (p < q);
}

/* Least and largest distance of the mean heights of neighbouring layers: the particles from the
 * lowest up, so many to a layer, those that fill no layer left out. */
static dl_status measure_layers(const dl_paper_claim *claim, const dl_paper_state *state,
                                double *least, double *most, dl_error *error) {
    const size_t n = state->scene->particles, each = (size_t)claim->span;
    const size_t layers = each ? n / each : 0;
    if (layers < 2)
        return dl_fail(error, DL_INPUT, "span: found %ld, expected 1 to %zu, for two layers",
                       claim->span, n / 2);
    double *height = malloc(n * sizeof *height);
    if (!height)
        return dl_fail_memory(error, "heights");
    for (size_t i = 0; i < n; i++)
        height[i] = state->y_all[n + i];
    qsort(height, n, sizeof *height, compare_reals);
    double below = 0;
    *least = INFINITY;
    *most = 0;
    for (size_t k = 0; k < layers; k++) {
        double mean = 0;
        for (size_t i = 0; i < each; i++)
            mean += height[k * each + i] / (double)each;
        if (k > 0) {
            *least = fmin(*least, mean - below);
            *most = fmax(*most, mean - below);
        }
        below = mean;
    }
    free(height);
    return DL_OK;
}

dl_status dl_measure_layer_least(const dl_paper_claim *claim, const dl_paper_state *state,
                                 double *value, dl_error *error) {
    double most;
    return measure_layers(claim, state, value, &most, error);
}

dl_status dl_measure_layer_most(const dl_paper_claim *claim, const dl_paper_state *state,
                                double *value, dl_error *error) {
    double least;
    return measure_layers(claim, state, &least, value, error);
}

dl_status dl_measure_separation_ratio(const dl_paper_claim *claim, const dl_paper_state *state,
                                      double *value, dl_error *error) {
    double rest, separation;
    dl_status status = dl_measure_rest_distance(claim, state, &rest, error);
    if (!status)
        status = dl_observe_separation(state->scene, state->y_all, 3, &separation, error);
    if (!status)
        *value = separation / rest;
    return status;
}
