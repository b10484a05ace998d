#include <math.h>
#include "model/private.h"

/* Where angular momentum is taken about: the centre of mass, at rest, where the scene is
 * Galilean-invariant. About the origin a stream that has gone far would show the roundoff of its
 * own motion. */
static void angular_frame(const dl_model *model, const double *y, long double place[3],
                          long double velocity[3]) {
    size_t n = model->moving;
    double inertia = dl_model_inertia(model);
    for (size_t c = 0; c < 3; c++)
        place[c] = velocity[c] = 0;
    if (!dl_model_is_galilean_invariant(model) || !(inertia > 0))
        return;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        for (size_t k = 0; k < n; k++) {
            place[c] += (long double)model->priv->inertia[k] * y[c * n + k];
            velocity[c] += (long double)model->priv->inertia[k] * y[model->unknowns + c * n + k];
        }
        place[c] /= inertia;
        velocity[c] /= inertia;
    }
}

/* Momentum and angular momentum of one particle. */
static void terms(const dl_model *model, const double *y, size_t k, const long double place[3],
                  const long double velocity[3], long double p[3], long double l[3]) {
    const double *v = y + model->unknowns;
    long double m = model->priv->inertia[k], x[3] = {0, 0, 0}, w[3] = {0, 0, 0};
    p[0] = p[1] = p[2] = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        size_t i = c * model->moving + k;
        x[c] = y[i] - place[c];
        w[c] = m * (v[i] - velocity[c]);
        p[c] = m * v[i];
    }
    l[0] = x[1] * w[2] - x[2] * w[1];
    l[1] = x[2] * w[0] - x[0] * w[2];
    l[2] = x[0] * w[1] - x[1] * w[0];
}

void dl_model_momentum(const dl_model *model, const double *y, double linear[3],
                       double angular[3]) {
    long double sum_p[3] = {0, 0, 0}, sum_l[3] = {0, 0, 0}, place[3], velocity[3];
    angular_frame(model, y, place, velocity);
    for (size_t k = 0; k < model->moving; k++) {
        long double p[3], l[3];
        terms(model, y, k, place, velocity, p, l);
        for (int c = 0; c < 3; c++) {
            sum_p[c] += p[c];
            sum_l[c] += l[c];
        }
    }
    for (int c = 0; c < 3; c++) {
        linear[c] = (double)sum_p[c];
        angular[c] = (double)sum_l[c];
    }
}

static bool differs(const dl_model *model, const double *y0, const double *y1, size_t k) {
    bool differ = false;
    for (size_t i = k; i < 2 * model->unknowns; i += model->moving)
        differ |= y0[i] != y1[i];
    return differ;
}

static void linear_change(const dl_model *model, const double *y0, const double *y1,
                          double linear[3]) {
    const double *v0 = y0 + model->unknowns, *v1 = y1 + model->unknowns;
    for (size_t c = 0; c < 3; c++) {
        long double sum = 0;
        for (size_t k = 0; c < (size_t)model->dimension && k < model->moving; k++) {
            const long double from = v0[c * model->moving + k], to = v1[c * model->moving + k];
            if (to != from)
                sum += model->priv->inertia[k] * (to - from);
        }
        linear[c] = (double)sum;
    }
}

/* About a mass centre that does not move between y0 and y1 the frame's velocity drops out. */
static void angular_change(const dl_model *model, const double *y0, const double *y1,
                           double angular[3]) {
    static const long double at_rest[3] = {0, 0, 0};
    long double sum[3] = {0, 0, 0}, place[3], velocity[3];
    angular_frame(model, y0, place, velocity);
    for (size_t k = 0; k < model->moving; k++) {
        long double p[3], from[3], to[3];
        if (!differs(model, y0, y1, k))
            continue;
        terms(model, y0, k, place, at_rest, p, from);
        terms(model, y1, k, place, at_rest, p, to);
        for (int c = 0; c < 3; c++)
            sum[c] += to[c] - from[c];
    }
    for (int c = 0; c < 3; c++)
        angular[c] = (double)sum[c];
}

void dl_model_momentum_change(const dl_model *model, const double *y0, const double *y1,
                              double linear[3], double *angular) {
    linear_change(model, y0, y1, linear);
    if (angular)
        angular_change(model, y0, y1, angular);
}

static long double modulus(const long double v[3]) {
    return hypotl(hypotl(v[0], v[1]), v[2]);
}

void dl_model_momentum_scales(const dl_model *model, const double *y, double *linear,
                              double *angular) {
    long double sum_p = 0, sum_l = 0, place[3], velocity[3];
    angular_frame(model, y, place, velocity);
    for (size_t k = 0; k < model->moving; k++) {
        long double p[3], l[3];
        terms(model, y, k, place, velocity, p, l);
        sum_p += modulus(p);
        sum_l += modulus(l);
    }
    *linear = (double)sum_p;
    *angular = (double)sum_l;
}

double dl_model_inertia(const dl_model *model) {
    double sum = 0;
    for (size_t k = 0; k < model->moving; k++)
        sum += model->priv->inertia[k];
    return sum;
}

void dl_model_rest_centre(const dl_model *model, double *a) {
    const size_t n = model->moving;
    const double *const inertia = model->priv->inertia;
    for (size_t c = 0; c < (size_t)model->dimension && n > 0; c++) {
        long double sum = 0, mass = 0;
        for (size_t k = 0; k < n; k++) {
            sum += (long double)inertia[k] * a[c * n + k];
            mass += inertia[k];
        }
        const double centre = (double)(sum / mass);
        for (size_t k = 0; k < n; k++)
            a[c * n + k] -= centre;
    }
}

double dl_model_work(const dl_model *model, const double *a, const double *b) {
    long double sum = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++) {
            size_t i = c * model->moving + k;
            sum += (long double)model->priv->inertia[k] * a[i] * b[i];
        }
    return (double)sum;
}

void dl_model_gravity_force(const dl_model *model, double force[3]) {
    double mass = 0;
    for (size_t k = 0; model->has_gravity && k < model->moving; k++)
        mass += model->priv->inertia[k] *
                (model->priv->gravity_mask ? model->priv->gravity_mask[k] : 1);
    for (int c = 0; c < 3; c++)
        force[c] = mass * model->scene->gravity[c];
}

bool dl_model_conserves_linear_momentum(const dl_model *model) {
    return !model->has_pins;
}

bool dl_model_conserves_angular_momentum(const dl_model *model) {
    return !model->has_pins && !model->has_gravity && !model->has_periods;
}

bool dl_model_is_galilean_invariant(const dl_model *model) {
    return !model->has_pins && !model->has_walls;
}
