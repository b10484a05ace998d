#include "observe/initial_energy.h"

#include <math.h>
#include <stdio.h>

#include "model/private.h"

static const char *file_of(const dl_model *model) {
    const dl_scene *const scene = model->scene;
    return scene->file ? scene->file : scene->name;
}

/* The first pair whose potential energy is not finite. */
typedef struct found_pair {
    bool found;
    size_t i, j;
    double distance;
} found_pair;

static void look_at_pair(const dl_model *model, const dl_pair *pair, void *context) {
    (void)model;
    found_pair *const first = context;
    if (first->found || isfinite(pair->coupling * dl_law_potential(pair->law, pair->s)))
        return;
    *first = (found_pair){true, pair->i, pair->j, sqrt(pair->s)};
}

/* Its own: what it moves at, or where it is. */
static bool is_finite(double inertia, double weight, double position, double velocity) {
    return isfinite(inertia * velocity * velocity) && isfinite(weight * position) &&
           isfinite(inertia * position * velocity) && isfinite(position * position);
}

static dl_status check_particles(const dl_model *model, const double *y, dl_error *error) {
    const dl_scene *const scene = model->scene;
    for (size_t u = 0; u < model->unknowns; u++) {
        const size_t i = model->priv->order[u % model->moving], axis = u / model->moving;
        const double weight =
            scene->feels_gravity[i] ? scene->inertia[i] * scene->gravity[axis] : 0;
        if (!is_finite(scene->inertia[i], weight, y[u], y[model->unknowns + u]))
            return dl_fail(error, DL_INPUT,
                           "%s: particle %zu: found position %.6g and velocity %.6g along %c, "
                           "expected ones whose energy and momentum are finite",
                           file_of(model), i, y[u], y[model->unknowns + u], "xyz"[axis]);
    }
    return DL_OK;
}

static dl_status blame_pair(dl_model *model, const double *y, dl_error *error) {
    found_pair first = {.found = false};
    const dl_status status =
        dl_model_visit_pairs(model, dl_model_places(model, y), NULL, look_at_pair, &first, error);
    if (status)
        return status;
    if (!first.found)
        return dl_fail(error, DL_INPUT,
                       "%s: found an initial state whose energy or momentum is not finite, "
                       "expected smaller velocities, distances or coefficients",
                       file_of(model));
    const size_t a = model->priv->order[first.i], b = model->priv->order[first.j];
    return dl_fail(error, DL_INPUT,
                   "%s: particles %zu and %zu: found distance %.6g, where the energy of their pair "
                   "law is not finite, expected another",
                   file_of(model), a < b ? a : b, a < b ? b : a, first.distance);
}

static double kinetic(const dl_model *model, const double *y) {
    double twice = 0;
    for (size_t u = 0; u < model->unknowns; u++)
        twice += model->priv->inertia[u % model->moving] * y[model->unknowns + u] *
                 y[model->unknowns + u];
    return twice / 2;
}

/* The scale has the moduli of all potential energies in it, so that no second sum over the pairs is
 * needed for the energy itself: it is at most the scale and the kinetic energy. */
dl_status dl_initial_energy_check(dl_model *model, const double *y, dl_error *error) {
    double scale, linear, angular;
    dl_status status = check_particles(model, y, error);
    if (!status)
        status = dl_model_energy_scale(model, y, &scale, error);
    if (status)
        return status;
    dl_model_momentum_scales(model, y, &linear, &angular);
    return isfinite(kinetic(model, y) + scale) && isfinite(linear) && isfinite(angular)
               ? DL_OK
               : blame_pair(model, y, error);
}
