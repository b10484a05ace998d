/* Velocities by rule, each added to what is there. */
#include <math.h>
#include "scene/initial.h"

static dl_particle *particle_of(const dl_initial *initial, size_t i) {
    return &initial->particles->particle[initial->first + i];
}

static size_t count_of(const dl_initial *initial) {
    return initial->particles->count - initial->first;
}

static dl_status add_velocity(dl_initial *initial, double velocity[3], dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(initial->node, "velocity");
    if (!node)
        return DL_OK;
    const int dimension = initial->particles->dimension;
    const dl_status status =
        dl_yaml_reals(initial->yaml, node, "velocity", (size_t)dimension, NAN, velocity, error);
    for (size_t i = 0; i < count_of(initial) && !status; i++)
        for (int axis = 0; axis < dimension; axis++)
            particle_of(initial, i)->velocity[axis] += velocity[axis];
    return status;
}

/* TR299 (3.1): the sign of the first term is that of -rate y and of rate x in every quadrant. */
static dl_status add_rotation(dl_initial *initial, dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(initial->node, "rotation");
    if (!node)
        return DL_OK;
    dl_rotation_values values = {0};
    double about[2] = {0};
    dl_status status =
        dl_scene_read_section(initial->yaml, node, &dl_section_rotation, &values, error);
    const dl_yaml_node *const centre = status ? NULL : dl_yaml_get(node, "about");
    if (centre)
        status = dl_yaml_reals(initial->yaml, centre, "about", 2, NAN, about, error);
    for (size_t i = 0; i < count_of(initial) && !status; i++) {
        dl_particle *const particle = particle_of(initial, i);
        const double size = particle->inertia / values.reference_mass * values.perturbation;
        dl_random_begin(initial->random, i, DL_RANDOM_ROTATION);
        particle->velocity[0] += -values.rate * (particle->position[1] - about[1]) +
                                 size * dl_random_sign(initial->random);
        particle->velocity[1] += values.rate * (particle->position[0] - about[0]) +
                                 size * dl_random_sign(initial->random);
    }
    return status;
}

/* --- perturbation ----------------------------------------------------------------------------- */

/* Numbers in [-1, 1) of particle i, the same whatever the velocity. */
static void draw(const dl_initial *initial, size_t i, double number[3]) {
    dl_random_begin(initial->random, i, DL_RANDOM_PERTURBATION);
    for (int axis = 0; axis < initial->particles->dimension; axis++)
        number[axis] = dl_random_uniform(initial->random, -1, 1);
}

static double largest_drawn(const dl_initial *initial) {
    double largest = 0;
    for (size_t i = 0; i < count_of(initial); i++) {
        double number[3] = {0};
        draw(initial, i, number);
        for (int axis = 0; axis < 3; axis++)
            largest = fmax(largest, fabs(number[axis]));
    }
    return largest;
}

static dl_status add_perturbation(dl_initial *initial, const double velocity[3], dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(initial->node, "perturb");
    if (!node)
        return DL_OK;
    dl_perturb_values values = {0};
    const dl_status status =
        dl_scene_read_section(initial->yaml, node, &dl_section_perturb, &values, error);
    if (status)
        return status;
    const double speed =
        sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]);
    if (speed == 0)
        return dl_yaml_fail(initial->yaml, node, "perturb",
                            "a velocity other than 0 beside it, which it is relative to", error);
    const double largest = values.normalise ? largest_drawn(initial) : 1;
    const double size = values.relative * speed;
    for (size_t i = 0; i < count_of(initial); i++) {
        double number[3];
        draw(initial, i, number);
        for (int axis = 0; axis < initial->particles->dimension; axis++)
            particle_of(initial, i)->velocity[axis] += size * (number[axis] / largest);
    }
    return DL_OK;
}

/* --- random motion ---------------------------------------------------------------------------- */

/* A speed in a random direction, and components of variance temperature/inertia. */
static void draw_motion(const dl_initial *initial, size_t i, double velocity[3]) {
    const int dimension = initial->particles->dimension;
    dl_random_begin(initial->random, i, DL_RANDOM_MOTION);
    dl_random_direction(initial->random, dimension, velocity);
    const double spread = sqrt(initial->item->temperature / particle_of(initial, i)->inertia);
    for (int axis = 0; axis < dimension; axis++)
        velocity[axis] = initial->item->speed * velocity[axis] +
                         (spread > 0 ? spread * dl_random_normal(initial->random) : 0);
}

static void add_random_motion(dl_initial *initial) {
    const int dimension = initial->particles->dimension;
    double mean[3] = {0}, inertia = 0;
    if (initial->item->speed == 0 && initial->item->temperature == 0)
        return;
    for (size_t i = 0; i < count_of(initial); i++) {
        dl_particle *const particle = particle_of(initial, i);
        double velocity[3];
        draw_motion(initial, i, velocity);
        inertia += particle->inertia;
        for (int axis = 0; axis < dimension; axis++) {
            particle->velocity[axis] += velocity[axis];
            mean[axis] += particle->inertia * velocity[axis];
        }
    }
    for (size_t i = 0; i < count_of(initial) && !initial->item->drift; i++)
        for (int axis = 0; axis < dimension; axis++)
            particle_of(initial, i)->velocity[axis] -= mean[axis] / inertia;
}

dl_status dl_initial_set_motion(dl_initial *initial, dl_error *error) {
    double velocity[3] = {0};
    dl_status status = add_velocity(initial, velocity, error);
    if (!status)
        status = add_rotation(initial, error);
    if (!status)
        status = add_perturbation(initial, velocity, error);
    if (!status)
        add_random_motion(initial);
    return status;
}
