/* Radiation as a jump of velocities, TR299 (3.14).
 *
 *     light side, y_i >= ybar:  v_i -> factor_above v_i
 *     dark side,  y_i <  ybar:  v_i -> factor_below v_i
 *
 * for outer particles alone. In the frame `lab` v_i is the velocity itself, as published: a system
 * that flies past loses momentum to it. In the frame `centre` it is the velocity relative to that
 * of the mass centre. (xbar, ybar) is the centre of the particles that move, weighted with their
 * inertias.
 *
 * A particle is outer where it is farther than `beyond` from the centre. With `boundary` it is
 * outer where it belongs to the boundary as seen from outside, the idea of TR299's section 5:
 * where the sector (in three dimensions the cone) about its own outward direction r_i - rbar, of
 * full angle `opening` and radius `reach`, holds no other particle. In a lattice of triangles every
 * direction is within 30 degrees of a neighbour, so that an opening of 60 leaves out all but the
 * rim. A particle at the centre itself has no outward direction and is not outer.
 *
 * Leap-frog's v_i are those of half a step before, as in TR299's program, so that its trajectory
 * depends on the step in first order, by (1 - factor) (h/2) a at each jump; energies do not,
 * because the ledger books the jump between states at one time. */
#include <math.h>
#include "model/private.h"

typedef struct centre {
    double at[3], velocity[3];
} centre;

static centre mass_centre(const dl_model *model, const double *q, const double *v) {
    const size_t n = model->moving;
    centre mean = {{0}, {0}};
    double mass = 0;
    for (size_t k = 0; k < n; k++)
        mass += model->priv->inertia[k];
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        for (size_t k = 0; k < n; k++) {
            mean.at[c] += model->priv->inertia[k] * q[c * n + k];
            mean.velocity[c] += model->priv->inertia[k] * v[c * n + k];
        }
        mean.at[c] /= mass;
        mean.velocity[c] /= mass;
    }
    return mean;
}

/* The vector from `from` to particle k of the block `places` [dimension * count]; its square. */
static double separation(const dl_model *model, const double *places, size_t count, size_t k,
                         const double from[3], double d[3]) {
    double square = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        d[c] = places[c * count + k] - from[c];
        square += d[c] * d[c];
    }
    return square;
}

static bool is_on_boundary(const dl_model *model, const double *places, size_t k,
                           const double at[3]) {
    const dl_radiation *radiation = &model->scene->radiation;
    const double pi = 3.14159265358979323846, tiny = 1e-12;
    const double least_cosine = cos(radiation->opening * pi / 360) - tiny;
    const double reach2 = radiation->reach * radiation->reach;
    double outward[3] = {0}, d[3] = {0}, place[3] = {0};
    const double r = sqrt(separation(model, places, model->particles, k, at, outward));
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        place[c] = places[c * model->particles + k];
    for (size_t j = 0; r > 0 && j < model->particles; j++) {
        const double square = separation(model, places, model->particles, j, place, d);
        if (j == k || square > reach2)
            continue;
        const double along = d[0] * outward[0] + d[1] * outward[1] + d[2] * outward[2];
        if (along >= least_cosine * r * sqrt(square))
            return false;
    }
    return r > 0;
}

static bool is_outer(const dl_model *model, const double *places, size_t k, const double at[3]) {
    const dl_radiation *radiation = &model->scene->radiation;
    double d[3];
    if (radiation->boundary)
        return is_on_boundary(model, places, k, at);
    return separation(model, places, model->particles, k, at, d) >
           radiation->beyond * radiation->beyond;
}

size_t dl_model_radiate(dl_model *model, const double *q, double *v) {
    const dl_radiation *radiation = &model->scene->radiation;
    const double *places = dl_model_places(model, q); /* moving particles come first */
    const centre mean = mass_centre(model, q, v);
    const size_t n = model->moving;
    const bool relative = radiation->frame == DL_FRAME_CENTRE;
    size_t count = 0;
    for (size_t k = 0; k < n; k++) {
        if (!is_outer(model, places, k, mean.at))
            continue;
        const bool light = q[n + k] >= mean.at[1];
        const double factor = light ? radiation->factor_above : radiation->factor_below;
        for (size_t c = 0; c < (size_t)model->dimension; c++) {
            const double base = relative ? mean.velocity[c] : 0;
            v[c * n + k] = base + factor * (v[c * n + k] - base);
        }
        count++;
    }
    return count;
}
