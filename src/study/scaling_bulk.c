/* The bulk of a body of particles. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "observe/pairs.h"
#include "study/scaling.h"

enum { nearest = 6 }; /* others: the sites around one of the hexagonal lattice */

/* --- moments ---------------------------------------------------------------------------------- */

/* Per mass, about the mass centre and its velocity. */
typedef struct moments {
    dl_motion motion;
    double spread[3], flux[3]; /* mean squares of positions and velocities along the axes */
} moments;

static void find_moments(const dl_scene *scene, const double *y_all, moments *of) {
    const size_t n = scene->particles, components = (size_t)scene->dimension;
    *of = (moments){0};
    dl_observe_motion(scene, y_all, &of->motion);
    for (size_t c = 0; c < components; c++)
        for (size_t i = 0; i < n; i++) {
            const double part = scene->pinned[i] ? 0 : scene->inertia[i] / of->motion.mass;
            const double x = y_all[c * n + i] - of->motion.centre[c];
            const double v = y_all[(components + c) * n + i] - of->motion.velocity[c];
            of->spread[c] += part * x * x;
            of->flux[c] += part * v * v;
        }
}

static double extent_of(double spread) {
    return sqrt(12 * spread);
}

static double sum_of(const double vector[3]) {
    return vector[0] + vector[1] + vector[2];
}

static double length_of(const double vector[3]) {
    return sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
}

/* --- names ------------------------------------------------------------------------------------ */

static char *next_name(dl_bulk *bulk) {
    return bulk->name[bulk->quantities++];
}

static void name_all(dl_bulk *bulk) {
    const int dimension = bulk->scene->dimension;
    if (bulk->travels)
        snprintf(next_name(bulk), DL_SCALED_NAME, "speed of the mass centre [length/time]");
    snprintf(next_name(bulk), DL_SCALED_NAME, "kinetic energy per mass [energy/mass]");
    snprintf(next_name(bulk), DL_SCALED_NAME, "pair energy per mass [energy/mass]");
    for (int c = 0; c < dimension; c++)
        snprintf(next_name(bulk), DL_SCALED_NAME, "momentum flux along %c per mass [energy/mass]",
                 "xyz"[c]);
    for (int c = 0; c < dimension; c++)
        snprintf(next_name(bulk), DL_SCALED_NAME, "extent along %c [length]", "xyz"[c]);
    snprintf(next_name(bulk), DL_SCALED_NAME, "density in the middle [mass/%s]",
             dimension == 2 ? "area" : "volume");
    snprintf(next_name(bulk), DL_SCALED_NAME, "mean separation [of the start's]");
    for (size_t k = 0; k < bulk->bins; k++)
        snprintf(next_name(bulk), DL_SCALED_NAME, "density along x, slice %zu of %zu [mass/length]",
                 k + 1, bulk->bins);
}

/* --- the start -------------------------------------------------------------------------------- */

/* A speed of the mass centre that the particles' own motion about it would give by chance, about
 * their speed over the root of their number, has no limit but 0. */
static const double least_part_of_speed = 0.1;

static dl_status look_at_start(dl_bulk *bulk, const double *y_all, dl_error *error) {
    moments of;
    find_moments(bulk->scene, y_all, &of);
    for (int c = 0; c < 3; c++)
        bulk->extent[c] = extent_of(of.spread[c]);
    const double own = sum_of(of.flux), whole = length_of(of.motion.velocity);
    bulk->travels = whole > 0 && whole * whole >= least_part_of_speed * least_part_of_speed * own;
    return dl_observe_separation(bulk->scene, y_all, nearest, &bulk->separation, error);
}

dl_status dl_bulk_create(const dl_scene *scene, size_t bins, dl_bulk *bulk, dl_error *error) {
    const size_t length = (size_t)scene->dimension * scene->particles;
    size_t moving = 0;
    *bulk = (dl_bulk){.scene = scene, .bins = bins};
    for (size_t i = 0; i < scene->particles; i++)
        moving += !scene->pinned[i];
    if (moving < 2)
        return dl_fail(error, DL_INPUT,
                       "particles: found %zu that move, expected at least two, a body", moving);
    double *y_all = malloc(2 * length * sizeof *y_all);
    if (!y_all)
        return dl_fail_memory(error, "a state");
    memcpy(y_all, scene->position, length * sizeof *y_all);
    memcpy(y_all + length, scene->velocity, length * sizeof *y_all);
    dl_status status = look_at_start(bulk, y_all, error);
    free(y_all);
    name_all(bulk);
    return status == DL_OK ? dl_model_create(scene, &bulk->model, error) : status;
}

void dl_bulk_free(dl_bulk *bulk) {
    dl_model_free(bulk->model);
    *bulk = (dl_bulk){0};
}

/* --- a state ---------------------------------------------------------------------------------- */

/* Mass within a quarter of the initial extents from the centre, along every axis, by what that box
 * measures. */
static double density_in_the_middle(const dl_bulk *bulk, const double *y_all, const moments *of) {
    const dl_scene *scene = bulk->scene;
    const size_t n = scene->particles, components = (size_t)scene->dimension;
    double mass = 0, measure = 1;
    for (size_t c = 0; c < components; c++)
        measure *= bulk->extent[c] / 2;
    for (size_t i = 0; i < n; i++) {
        bool inside = !scene->pinned[i];
        for (size_t c = 0; c < components && inside; c++)
            inside =
                fabs(y_all[c * n + i] - of->motion.centre[c]) <= bulk->extent[c] / 4 * (1 + 1e-12);
        mass += inside ? scene->inertia[i] : 0;
    }
    return measure > 0 ? mass / measure : NAN;
}

/* Mass in equal slices of the initial extent along x, centred on the mass centre, by their width.
 */
static void profile(const dl_bulk *bulk, const double *y_all, const moments *of, double *slice) {
    const dl_scene *scene = bulk->scene;
    const double width = bulk->extent[0] / (double)bulk->bins;
    const double low = of->motion.centre[0] - bulk->extent[0] / 2;
    for (size_t k = 0; k < bulk->bins; k++)
        slice[k] = 0;
    for (size_t i = 0; i < scene->particles; i++) {
        const double at = (y_all[i] - low) / width;
        if (!scene->pinned[i] && at >= 0 && at < (double)bulk->bins)
            slice[(size_t)at] += scene->inertia[i] / width;
    }
}

static void count_pair(const dl_observed_pair *pair, void *context) {
    (void)pair;
    *(double *)context += 1;
}

dl_status dl_bulk_observe(const dl_bulk *bulk, const double *y_all, double pair_energy,
                          double *value, double *pairs, dl_error *error) {
    const size_t components = (size_t)bulk->scene->dimension;
    moments of;
    double separation;
    find_moments(bulk->scene, y_all, &of);
    *pairs = 0;
    dl_status status = dl_observe_pairs(bulk->model, y_all, count_pair, pairs, error);
    if (status == DL_OK)
        status = dl_observe_separation(bulk->scene, y_all, nearest, &separation, error);
    if (status != DL_OK)
        return status;
    if (bulk->travels)
        *value++ = length_of(of.motion.velocity);
    *value++ = sum_of(of.flux) / 2;
    *value++ = pair_energy / of.motion.mass;
    for (size_t c = 0; c < components; c++)
        *value++ = of.flux[c];
    for (size_t c = 0; c < components; c++)
        *value++ = extent_of(of.spread[c]);
    *value++ = density_in_the_middle(bulk, y_all, &of);
    *value++ = separation / bulk->separation;
    profile(bulk, y_all, &of, value);
    return DL_OK;
}
