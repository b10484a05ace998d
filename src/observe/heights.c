/* Along the height: bins, density, depth. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"

static const double most_bins = 1e6;

size_t dl_height_axis(const dl_scene *scene) {
    size_t axis = 1;
    for (size_t c = 0; c < (size_t)scene->dimension; c++)
        if (scene->gravity[c] != 0)
            axis = c;
    return axis;
}

dl_status dl_bins_create(const dl_scene *scene, double width, double lowest, double highest,
                         dl_bins *bins, dl_error *error) {
    if (!(width > 0 && isfinite(width)) || !isfinite(lowest) || !isfinite(highest))
        return dl_fail(error, DL_INPUT,
                       "bin: found %.15g for heights from %.15g to %.15g, expected "
                       "a finite width > 0",
                       width, lowest, highest);
    const double wall = scene->walls.present ? scene->walls.low[dl_height_axis(scene)] : -INFINITY;
    const double base = isfinite(wall) ? wall : 0;
    double first = floor((lowest - base) / width);
    if (isfinite(wall))
        first = fmin(first, 0);
    const double count = floor((highest - base) / width) - first + 1;
    if (!(count <= most_bins))
        return dl_fail(error, DL_INPUT,
                       "bin: found a width of %.15g for heights from %.15g to %.15g, expected one "
                       "with at most %.0f bins",
                       width, lowest, highest, most_bins);
    *bins = (dl_bins){base + first * width, width, (size_t)fmax(count, 1)};
    return DL_OK;
}

void dl_observe_heights(const dl_scene *scene, const double *y_all, double *lowest,
                        double *highest) {
    const double *height = y_all + dl_height_axis(scene) * scene->particles;
    *lowest = INFINITY;
    *highest = -INFINITY;
    for (size_t i = 0; i < scene->particles; i++)
        if (!scene->pinned[i]) {
            *lowest = fmin(*lowest, height[i]);
            *highest = fmax(*highest, height[i]);
        }
}

void dl_observe_density(const dl_scene *scene, const double *y_all, const dl_bins *bins,
                        double *particles, double *mass) {
    const double *height = y_all + dl_height_axis(scene) * scene->particles;
    for (size_t k = 0; k < bins->count; k++) {
        if (particles)
            particles[k] = 0;
        if (mass)
            mass[k] = 0;
    }
    for (size_t i = 0; i < scene->particles; i++) {
        const double k = floor((height[i] - bins->low) / bins->width);
        if (scene->pinned[i] || !(k >= 0 && k < (double)bins->count))
            continue;
        if (particles)
            particles[(size_t)k]++;
        if (mass)
            mass[(size_t)k] += scene->inertia[i];
    }
}

double dl_across(const dl_scene *scene) {
    const size_t axis = dl_height_axis(scene);
    double product = 1;
    for (size_t c = 0; c < (size_t)scene->dimension; c++) {
        if (c == axis)
            continue;
        const double period = scene->periods.length[c];
        const double width =
            scene->walls.present ? scene->walls.high[c] - scene->walls.low[c] : INFINITY;
        product *= period > 0 ? period : width;
    }
    return isfinite(product) ? product : NAN;
}

/* --- depth ------------------------------------------------------------------------------------ */

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

dl_status dl_observe_depth(const dl_scene *scene, const double *y_all, double floor_height,
                           dl_depth *depth, dl_error *error) {
    const double *height = y_all + dl_height_axis(scene) * scene->particles;
    double *sorted = malloc(scene->particles * sizeof *sorted);
    if (!sorted)
        return dl_fail_memory(error, "the heights of a state");
    size_t count = 0;
    double sum = 0;
    for (size_t i = 0; i < scene->particles; i++)
        if (!scene->pinned[i]) {
            sorted[count++] = height[i] - floor_height;
            sum += height[i] - floor_height;
        }
    qsort(sorted, count, sizeof *sorted, ascending);
    const size_t most = (size_t)ceil(0.95 * (double)count);
    *depth = (dl_depth){2 * sum / (double)count, sorted[most - 1], sorted[count - 1]};
    free(sorted);
    return DL_OK;
}
