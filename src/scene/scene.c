#include "driftlab/scene.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/trajectory.h"
#include "scene/draft.h"

void dl_scene_free(dl_scene *scene) {
    if (!scene)
        return;
    free(scene->name);
    free(scene->source);
    free(scene->file);
    free(scene->text);
    free(scene->let);
    free(scene->start);
    free(scene->position);
    free(scene->velocity);
    free(scene->inertia);
    free(scene->coupling);
    free(scene->feels_gravity);
    free(scene->pinned);
    for (size_t k = 0; scene->species_name && k < scene->species; k++)
        free(scene->species_name[k]);
    free(scene->species_name);
    free(scene->species_law);
    free(scene->species_of);
    free(scene);
}

dl_status dl_scene_allocate(dl_scene *scene, dl_error *error) {
    const size_t n = scene->particles, components = (size_t)scene->dimension * n;
    scene->position = calloc(components, sizeof *scene->position);
    scene->velocity = calloc(components, sizeof *scene->velocity);
    scene->inertia = calloc(n, sizeof *scene->inertia);
    scene->coupling = calloc(n, sizeof *scene->coupling);
    scene->feels_gravity = calloc(n, sizeof *scene->feels_gravity);
    scene->pinned = calloc(n, sizeof *scene->pinned);
    scene->species_of = scene->species > 0 ? calloc(n, sizeof *scene->species_of) : NULL;
    const bool complete = scene->position && scene->velocity && scene->inertia && scene->coupling &&
                          scene->feels_gravity && scene->pinned &&
                          (scene->species == 0 || scene->species_of);
    return complete ? DL_OK : dl_fail_memory(error, "the particles of a scene");
}

size_t dl_whole_steps(double time, double step) {
    const double ratio = time / step, whole = nearbyint(ratio);
    const bool ok = whole >= 1 && whole <= DL_MOST_STEPS && fabs(ratio - whole) <= 1e-9 * whole;
    return ok ? (size_t)whole : 0;
}

/* --- restart ---------------------------------------------------------------------------------- */

static dl_status copy_texts(const dl_scene *from, dl_scene *to, dl_error *error) {
    to->name = strdup(from->name);
    to->source = strdup(from->source);
    to->file = strdup(from->file);
    to->text = strdup(from->text);
    to->let = malloc((from->lets + 1) * sizeof *to->let);
    if (to->let && from->lets > 0)
        memcpy(to->let, from->let, from->lets * sizeof *to->let);
    const bool complete = to->name && to->source && to->file && to->text && to->let;
    return complete ? DL_OK : dl_fail_memory(error, "a scene");
}

static void copy_particles(const dl_scene *from, dl_scene *to) {
    const size_t n = from->particles, components = (size_t)from->dimension * n;
    memcpy(to->position, from->position, components * sizeof *to->position);
    memcpy(to->velocity, from->velocity, components * sizeof *to->velocity);
    memcpy(to->inertia, from->inertia, n * sizeof *to->inertia);
    memcpy(to->coupling, from->coupling, n * sizeof *to->coupling);
    memcpy(to->feels_gravity, from->feels_gravity, n * sizeof *to->feels_gravity);
    memcpy(to->pinned, from->pinned, n * sizeof *to->pinned);
    if (from->species > 0 && to->species_of)
        memcpy(to->species_of, from->species_of, n * sizeof *to->species_of);
}

static dl_status copy_species(const dl_scene *from, dl_scene *to, dl_error *error) {
    const size_t n = from->species;
    to->species_name = NULL;
    to->species_law = NULL;
    if (n == 0)
        return DL_OK;
    to->species_name = calloc(n, sizeof *to->species_name);
    to->species_law = malloc(n * n * sizeof *to->species_law);
    bool complete = to->species_name && to->species_law;
    for (size_t k = 0; k < n && complete; k++) {
        to->species_name[k] = strdup(from->species_name[k]);
        complete = to->species_name[k];
    }
    if (!complete)
        return dl_fail_memory(error, "the species of a scene");
    memcpy(to->species_law, from->species_law, n * n * sizeof *to->species_law);
    return DL_OK;
}

static dl_status copy_scene(const dl_scene *from, dl_scene *to, dl_error *error) {
    *to = *from;
    to->name = to->source = to->file = to->text = to->start = NULL;
    to->let = NULL;
    to->position = to->velocity = to->inertia = to->coupling = NULL;
    to->feels_gravity = to->pinned = NULL;
    to->species_of = NULL;
    dl_status status = copy_species(from, to, error);
    if (!status)
        status = copy_texts(from, to, error);
    if (!status)
        status = dl_scene_allocate(to, error);
    if (!status)
        copy_particles(from, to);
    return status;
}

static dl_status place_particle(dl_scene *scene, const double *y_all, size_t particle,
                                dl_error *error) {
    const size_t components = (size_t)scene->dimension * scene->particles;
    for (size_t at = particle; at < components; at += scene->particles) {
        if (!isfinite(y_all[at]) || !isfinite(y_all[components + at]))
            return dl_fail(error, DL_INPUT,
                           "particle %zu of the initial state: found a number that is not finite, "
                           "expected a finite one",
                           particle + 1);
        scene->position[at] = y_all[at];
        scene->velocity[at] = y_all[components + at];
    }
    return DL_OK;
}

dl_status dl_scene_restart(const dl_scene *scene, const double *y_all, dl_scene **restarted,
                           dl_error *error) {
    *restarted = NULL;
    dl_scene *const copy = calloc(1, sizeof *copy);
    if (!copy)
        return dl_fail_memory(error, "a scene");
    dl_status status = copy_scene(scene, copy, error);
    for (size_t i = 0; i < scene->particles && !status; i++)
        if (!scene->pinned[i])
            status = place_particle(copy, y_all, i, error);
    if (status)
        dl_scene_free(copy);
    else
        *restarted = copy;
    return status;
}
