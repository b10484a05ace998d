/* What a jump changes: walls and radiation leave most of a state as it was. */
#include <stdlib.h>
#include "model/private.h"

static dl_status reserve(dl_model *model, dl_error *error) {
    struct dl_model_private *priv = model->priv;
    if (!priv->jump)
        priv->jump = calloc(model->unknowns, sizeof *priv->jump);
    if (!priv->jump_force)
        priv->jump_force =
            calloc((size_t)model->dimension * model->particles, sizeof *priv->jump_force);
    return priv->jump && priv->jump_force ? DL_OK : dl_fail_memory(error, "the change of a state");
}

/* Returns whether any particle has moved. */
static bool find_jump(const dl_model *model, const double *q0, const double *q1, double *jump) {
    bool any = false;
    for (size_t u = 0; u < model->unknowns; u++) {
        jump[u] = q1[u] - q0[u];
        any |= jump[u] != 0;
    }
    return any;
}

static double kinetic_change(const dl_model *model, const double *v0, const double *v1) {
    const size_t n = model->moving;
    long double sum = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < n; k++) {
            const long double from = v0[c * n + k], to = v1[c * n + k];
            if (to != from)
                sum += model->priv->inertia[k] * (to - from) * (to + from);
        }
    return (double)(sum / 2);
}

static double gravity_change(const dl_model *model, const double *jump) {
    const size_t n = model->moving;
    const struct dl_model_private *priv = model->priv;
    long double sum = 0;
    for (size_t c = 0; model->has_gravity && c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < n; k++)
            if (jump[c * n + k] != 0)
                sum -= (long double)priv->inertia[k] *
                       (priv->gravity_mask ? priv->gravity_mask[k] : 1) * model->scene->gravity[c] *
                       jump[c * n + k];
    return (double)sum;
}

/* By a kernel that has potentials and no discrete force: what is then measured as energy. */
static dl_status potential_change(dl_model *model, const double *q0, const double *q1,
                                  double *change, dl_error *error) {
    const dl_kernel_ops *const ops = model->kernel->ops;
    long double before = 0, after = 0, moduli;
    dl_status status =
        ops->potential(model->kernel, dl_model_places(model, q0), &before, &moduli, error);
    status =
        status ? status
               : ops->potential(model->kernel, dl_model_places(model, q1), &after, &moduli, error);
    *change = (double)(after - before);
    return status;
}

/* Minus the work of the discrete force, by the kernel's own loops: V(s1) - V(s0) of every pair
 * without the cancellation of potentials. What has not moved does no work. */
static dl_status pair_change(dl_model *model, const double *q0, const double *jump, double *change,
                             dl_error *error) {
    const size_t n = model->moving;
    double *const f = model->priv->jump_force;
    long double work = 0;
    const dl_status status = model->kernel->ops->discrete(model->kernel, dl_model_places(model, q0),
                                                          dl_model_shifts(model, jump), f, error);
    for (size_t c = 0; c < (size_t)model->dimension && !status; c++)
        for (size_t k = 0; k < n; k++)
            if (jump[c * n + k] != 0)
                work += (long double)f[c * model->particles + k] * jump[c * n + k];
    *change = (double)-work;
    return status;
}

dl_status dl_model_energy_change(dl_model *model, const double *y0, const double *y1,
                                 dl_energy *change, dl_error *error) {
    const size_t n = model->unknowns;
    dl_status status = reserve(model, error);
    if (status)
        return status;
    double *const jump = model->priv->jump;
    *change = (dl_energy){.kinetic = kinetic_change(model, y0 + n, y1 + n)};
    if (find_jump(model, y0, y1, jump)) {
        if (model->kernel && model->kernel->ops->potential)
            status = potential_change(model, y0, y1, &change->pair, error);
        else if (model->kernel)
            status = pair_change(model, y0, jump, &change->pair, error);
        change->gravity = gravity_change(model, jump);
    }
    change->total = change->kinetic + change->pair + change->gravity;
    return status;
}
