/* Quantities by height, TR323, section IV and Table II: means over the frames from the claim's on,
 * those of its segment. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"
#include "study/paper_quantity.h"

/* --- means over frames ------------------------------------------------------------------------ */

static size_t frames_from(const dl_paper_state *state) {
    return state->frames ? state->frames->count - state->number : 1;
}

/* Frame `k` from the claim's on; `buffer` is used where there are frames. */
static dl_status frame_at(const dl_paper_state *state, size_t k, double *buffer,
                          const double **y_all, double *time, dl_error *error) {
    *y_all = state->frames ? buffer : state->y_all;
    *time = state->frames ? state->frames->time[state->number + k] : 0;
    return state->frames ? dl_frames_read(state->frames, state->number + k, state->scene->dimension,
                                          buffer, error)
                         : DL_OK;
}

static double *make_buffer(const dl_paper_state *state) {
    return malloc(2 * (size_t)state->scene->dimension * state->scene->particles * sizeof(double));
}

static dl_status find_heights(const dl_paper_state *state, double *buffer, double *lowest,
                              double *highest, dl_error *error) {
    dl_status status = DL_OK;
    *lowest = INFINITY;
    *highest = -INFINITY;
    for (size_t k = 0; k < frames_from(state) && !status; k++) {
        const double *y_all;
        double time, low, high;
        if ((status = frame_at(state, k, buffer, &y_all, &time, error)))
            break;
        dl_observe_heights(state->scene, y_all, &low, &high);
        *lowest = fmin(*lowest, low);
        *highest = fmax(*highest, high);
    }
    return status;
}

/* The observable `what` alone, over all those frames. */
static dl_status observe_frames(const dl_paper_state *state, const char *what, double bin,
                                double *buffer, dl_observation **observation, dl_error *error) {
    size_t index;
    double lowest, highest;
    dl_observe_options how;
    dl_status status = dl_observable_find(what, &index, error);
    if (!status)
        status = find_heights(state, buffer, &lowest, &highest, error);
    if (status)
        return status;
    bool *const wanted = calloc(dl_observable_count(), sizeof *wanted);
    if (!wanted)
        return dl_fail_memory(error, "an observation");
    wanted[index] = true;
    dl_observe_options_default(&how);
    how.bin = bin;
    status = dl_observation_create(state->scene, &how, wanted, frames_from(state), lowest, highest,
                                   observation, error);
    free(wanted);
    for (size_t k = 0; k < frames_from(state) && !status; k++) {
        const double *y_all;
        double time;
        status = frame_at(state, k, buffer, &y_all, &time, error);
        if (!status)
            status = dl_observation_add(*observation, time, y_all, error);
    }
    return status;
}

/* Column `column` of `what`, rows [*rows], owned by the caller. */
static dl_status mean_of(const dl_paper_state *state, const char *what, double bin, size_t column,
                         double **value, size_t *rows, dl_error *error) {
    dl_observation *observation = NULL;
    dl_observed observed;
    double *const buffer = make_buffer(state);
    dl_status status = buffer ? observe_frames(state, what, bin, buffer, &observation, error)
                              : dl_fail_memory(error, "a state of every particle");
    *value = NULL;
    if (!status) {
        dl_observation_get(observation, 0, &observed);
        *rows = observed.rows;
        *value = malloc(observed.rows * sizeof **value);
        status = *value ? DL_OK : dl_fail_memory(error, "an observation");
    }
    for (size_t k = 0; *value && k < *rows; k++)
        (*value)[k] = observed.mean[k * observed.columns + column];
    dl_observation_free(observation);
    free(buffer);
    return status;
}

/* Height below which 95 % of the particles are. */
static dl_status measure_surface(const dl_paper_state *state, double *surface, dl_error *error) {
    double *value;
    size_t rows;
    const dl_status status = mean_of(state, "depth", 0, 1, &value, &rows, error);
    if (!status)
        *surface = value[0];
    free(value);
    return status;
}

/* --- density, Table II ------------------------------------------------------------------------ */

enum { layers = 10 };

/* Of so many layers of one height, from the floor to the surface. */
static dl_status measure_densities(const dl_paper_state *state, double density[layers],
                                   dl_error *error) {
    double surface, *value = NULL;
    size_t rows = 0;
    dl_status status = measure_surface(state, &surface, error);
    if (!status)
        status = mean_of(state, "density", surface / layers, 2, &value, &rows, error);
    if (!status && rows < layers)
        status = dl_fail(error, DL_INPUT, "found %zu layers below the surface, expected %d", rows,
                         layers);
    if (!status)
        memcpy(density, value, layers * sizeof *density);
    free(value);
    return status;
}

/* Kendall's rank correlation: pairs of layers of which the higher one is the denser, less the other
 * pairs, over all pairs. */
dl_status dl_measure_density_trend(const dl_paper_claim *claim, const dl_paper_state *state,
                                   double *value, dl_error *error) {
    double density[layers];
    (void)claim;
    const dl_status status = measure_densities(state, density, error);
    if (status)
        return status;
    int balance = 0;
    for (int high = 1; high < layers; high++)
        for (int low = 0; low < high; low++)
            balance += (density[high] > density[low]) - (density[high] < density[low]);
    *value = 2.0 * balance / (layers * (layers - 1));
    return DL_OK;
}

/* Largest less smallest density of the fourth to the seventh layer, over their mean. */
dl_status dl_measure_density_middle(const dl_paper_claim *claim, const dl_paper_state *state,
                                    double *value, dl_error *error) {
    enum { first = 3, last = 6 };
    double density[layers], mean = 0, least = INFINITY, most = 0;
    (void)claim;
    const dl_status status = measure_densities(state, density, error);
    if (status)
        return status;
    for (int k = first; k <= last; k++) {
        mean += density[k] / (last - first + 1);
        least = fmin(least, density[k]);
        most = fmax(most, density[k]);
    }
    *value = (most - least) / mean;
    return DL_OK;
}

/* --- pressure, section IV --------------------------------------------------------------------- */

/* Least squares through (x, y): root mean square of fitted/p - 1, where p = y, or exp y. */
static double misfit(size_t count, const double *x, const double *y, bool exponential) {
    const double n = (double)count;
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0, sum = 0;
    for (size_t k = 0; k < count; k++) {
        mean_x += x[k] / n;
        mean_y += (exponential ? log(y[k]) : y[k]) / n;
    }
    for (size_t k = 0; k < count; k++) {
        const double at = exponential ? log(y[k]) : y[k];
        xx += (x[k] - mean_x) * (x[k] - mean_x);
        xy += (x[k] - mean_x) * (at - mean_y);
    }
    for (size_t k = 0; k < count; k++) {
        const double line = mean_y + xy / xx * (x[k] - mean_x);
        const double miss = (exponential ? exp(line) : line) / y[k] - 1;
        sum += miss * miss / n;
    }
    return sqrt(sum);
}

/* Points (depth, pressure) of the bins deeper than one of them, but for the lowest, where the floor
 * makes a layer; their number. */
static size_t choose_bins(double surface, double bin, size_t rows, const double *pressure,
                          double *depth, double *chosen) {
    size_t count = 0;
    for (size_t k = 1; k < rows; k++) {
        const double at = surface - ((double)k + 0.5) * bin;
        if (!(at > bin) || !(pressure[k] > 0))
            continue;
        depth[count] = at;
        chosen[count++] = pressure[k];
    }
    return count;
}

dl_status dl_measure_pressure_misfit(const dl_paper_claim *claim, const dl_paper_state *state,
                                     double *value, dl_error *error) {
    static const double usual_bin = 0.2; /* TR323's Table I */
    const double bin = claim->bin > 0 ? claim->bin : usual_bin;
    double surface, *pressure = NULL;
    size_t rows = 0;
    dl_status status = measure_surface(state, &surface, error);
    if (!status)
        status = mean_of(state, "pressure", bin, 2, &pressure, &rows, error);
    double *const depth = malloc((rows + 1) * sizeof *depth);
    double *const chosen = malloc((rows + 1) * sizeof *chosen);
    if (!status && (!depth || !chosen))
        status = dl_fail_memory(error, "pressures");
    if (!status) {
        const size_t count = choose_bins(surface, bin, rows, pressure, depth, chosen);
        if (count < 3)
            status = dl_fail(error, DL_INPUT,
                             "found %zu bins of width %.4g with a pressure below the surface, "
                             "expected 3 or more",
                             count, bin);
        else
            *value = misfit(count, depth, chosen, false) / misfit(count, depth, chosen, true);
    }
    free(depth);
    free(chosen);
    free(pressure);
    return status;
}
