#include "model/private.h"

void dl_model_momentum(const dl_model *model, const double *y, double linear[3],
                       double angular[3]) {
    size_t n = model->moving;
    const double *v = y + model->unknowns;
    long double p[3] = {0, 0, 0}, l[3] = {0, 0, 0};
    for (size_t k = 0; k < n; k++) {
        long double m = model->priv->inertia[k], x[3] = {0, 0, 0}, w[3] = {0, 0, 0};
        for (size_t c = 0; c < (size_t)model->dimension; c++) {
            x[c] = y[c * n + k];
            w[c] = m * v[c * n + k];
            p[c] += w[c];
        }
        l[0] += x[1] * w[2] - x[2] * w[1];
        l[1] += x[2] * w[0] - x[0] * w[2];
        l[2] += x[0] * w[1] - x[1] * w[0];
    }
    for (int c = 0; c < 3; c++) {
        linear[c] = (double)p[c];
        angular[c] = (double)l[c];
    }
}

double dl_model_inertia(const dl_model *model) {
    double sum = 0;
    for (size_t k = 0; k < model->moving; k++)
        sum += model->priv->inertia[k];
    return sum;
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
    return !model->has_pins && !model->has_gravity;
}

bool dl_model_is_galilean_invariant(const dl_model *model) {
    return !model->has_pins && !model->has_walls;
}
