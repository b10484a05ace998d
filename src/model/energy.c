/* Total energy with the continuous potential (force/law.h). Sums are in long double: what is
 * measured is the integrator's error, often at the last digits. */
#include <math.h>
#include "model/private.h"

typedef struct pair_sum {
    long double sum, moduli;
} pair_sum;

static void add_pair(const dl_model *model, const dl_pair *pair, void *context) {
    (void)model;
    pair_sum *sums = context;
    double v = pair->coupling * dl_law_potential(pair->law, pair->s);
    sums->sum += v;
    sums->moduli += fabs(v);
}

static dl_status pair_potential(dl_model *model, const double *y, pair_sum *sums, dl_error *error) {
    const double *const x = dl_model_places(model, y);
    *sums = (pair_sum){0, 0};
    if (model->kernel && model->kernel->ops->potential)
        return model->kernel->ops->potential(model->kernel, x, &sums->sum, &sums->moduli, error);
    return dl_model_visit_pairs(model, x, NULL, add_pair, sums, error);
}

static pair_sum gravity_potential(const dl_model *model, const double *y) {
    pair_sum sums = {0, 0};
    for (size_t k = 0; model->has_gravity && k < model->moving; k++) {
        double felt = model->priv->gravity_mask ? model->priv->gravity_mask[k] : 1;
        long double v = 0;
        for (size_t c = 0; c < (size_t)model->dimension; c++)
            v -= (long double)model->scene->gravity[c] * y[c * model->moving + k];
        v *= felt * model->priv->inertia[k];
        sums.sum += v;
        sums.moduli += fabsl(v);
    }
    return sums;
}

static double kinetic(const dl_model *model, const double *y, const double drift[3]) {
    const double *v = y + model->unknowns;
    long double sum = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++) {
            long double speed = (long double)v[c * model->moving + k] - drift[c];
            sum += model->priv->inertia[k] * speed * speed;
        }
    return (double)(sum / 2);
}

dl_status dl_model_energy(dl_model *model, const double *y, dl_energy *energy, dl_error *error) {
    static const double at_rest[3] = {0, 0, 0};
    pair_sum pairs, gravity = gravity_potential(model, y);
    dl_status status = pair_potential(model, y, &pairs, error);
    if (status != DL_OK)
        return status;
    energy->kinetic = kinetic(model, y, at_rest);
    energy->pair = (double)pairs.sum;
    energy->gravity = (double)gravity.sum;
    energy->total = (double)(energy->kinetic + pairs.sum + gravity.sum);
    return DL_OK;
}

dl_status dl_model_energy_gradient(dl_model *model, const double *y, double *gradient,
                                   dl_error *error) {
    const double *v = y + model->unknowns;
    dl_status status = dl_model_acceleration(model, y, gradient, error);
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++) {
            size_t i = c * model->moving + k;
            gradient[i] *= -model->priv->inertia[k];
            gradient[model->unknowns + i] = model->priv->inertia[k] * v[i];
        }
    return status;
}

/* Velocity of the centre of mass; 0 where another frame would not do. */
static void frame_velocity(const dl_model *model, const double *y, double drift[3]) {
    double angular[3], mass = dl_model_inertia(model);
    dl_model_momentum(model, y, drift, angular);
    for (int c = 0; c < 3; c++)
        drift[c] = dl_model_is_galilean_invariant(model) && mass > 0 ? drift[c] / mass : 0;
}

dl_status dl_model_energy_scale(dl_model *model, const double *y, double *scale, dl_error *error) {
    double drift[3];
    pair_sum pairs, gravity = gravity_potential(model, y);
    dl_status status = pair_potential(model, y, &pairs, error);
    if (status != DL_OK)
        return status;
    frame_velocity(model, y, drift);
    double sum = (double)(kinetic(model, y, drift) + pairs.moduli + gravity.moduli);
    *scale = sum > 0 ? sum : 1;
    return DL_OK;
}
