/* Pressure by the method of planes. */
#include <math.h>
#include <string.h>

#include "driftlab/observe.h"
#include "observe/pairs.h"

typedef struct planes {
    const dl_bins *bins;
    const double *height; /* [particles] */
    size_t axis;
    double across;
    double *interaction;
} planes;

/* Levels are at low + (k + 1/2) width: how many of the bins have theirs at or below `height`. */
static size_t levels_below(const dl_bins *bins, double height) {
    const double count = floor((height - bins->low) / bins->width + 0.5);
    return count <= 0 ? 0 : (size_t)fmin(count, (double)bins->count);
}

static void add_force(const dl_observed_pair *pair, void *context) {
    const planes *p = context;
    const bool i_above = p->height[pair->i] > p->height[pair->j];
    const size_t above = i_above ? pair->i : pair->j, below = i_above ? pair->j : pair->i;
    const size_t first = levels_below(p->bins, p->height[below]);
    const size_t last = levels_below(p->bins, p->height[above]);
    const double up = (i_above ? 1 : -1) * pair->force_over_r * pair->d[p->axis] / p->across;
    for (size_t k = first; k < last; k++)
        p->interaction[k] += up;
}

static void add_motion(const dl_scene *scene, const double *y_all, const planes *p,
                       double *kinetic) {
    const size_t n = scene->particles;
    const double *up = y_all + ((size_t)scene->dimension + p->axis) * n;
    for (size_t i = 0; i < n; i++) {
        const double k = floor((p->height[i] - p->bins->low) / p->bins->width);
        if (!scene->pinned[i] && k >= 0 && k < (double)p->bins->count)
            kinetic[(size_t)k] += scene->inertia[i] * up[i] * up[i] / (p->across * p->bins->width);
    }
}

static void add_weight(const dl_scene *scene, const planes *p, double *weight) {
    for (size_t i = 0; i < scene->particles; i++) {
        if (scene->pinned[i] || !scene->feels_gravity[i])
            continue;
        const size_t below = levels_below(p->bins, p->height[i]);
        for (size_t k = 0; k < below; k++)
            weight[k] -= scene->inertia[i] * scene->gravity[p->axis] / p->across;
    }
}

dl_status dl_observe_pressure(dl_model *model, const double *y_all, const dl_bins *bins,
                              double across, double *interaction, double *kinetic, double *weight,
                              dl_error *error) {
    const dl_scene *scene = model->scene;
    const size_t axis = dl_height_axis(scene);
    if (!(across > 0 && isfinite(across)))
        return dl_fail(error, DL_INPUT,
                       "across: found %.15g, expected the length of a level plane, > 0", across);
    if (scene->periods.length[axis] > 0)
        return dl_fail(error, DL_INPUT,
                       "pressure: found a scene that is periodic along the height, "
                       "expected one with a bottom");
    memset(interaction, 0, bins->count * sizeof *interaction);
    memset(kinetic, 0, bins->count * sizeof *kinetic);
    memset(weight, 0, bins->count * sizeof *weight);
    planes p = {bins, y_all + axis * scene->particles, axis, across, interaction};
    add_motion(scene, y_all, &p, kinetic);
    add_weight(scene, &p, weight);
    return dl_observe_pairs(model, y_all, add_force, &p, error);
}
