#include "model/locks.h"

#include "model/private.h"

/* More than kernels differ by in a squared distance, shifts by whole periods included. */
static const double rounding = 1e-10;

static int piece_below(const dl_law *law, int piece) {
    while (piece > 0 && !law->located[piece - 1])
        piece--;
    return piece;
}

static int piece_above(const dl_law *law, int piece) {
    while (piece < law->pieces && !law->located[piece])
        piece++;
    return piece;
}

void dl_lock_to(dl_lock *lock, const dl_law *law, int piece) {
    lock->law = law;
    lock->range = (dl_law_range){piece_below(law, piece), piece_above(law, piece)};
    lock->above = dl_lock_low(lock) * (1 + rounding);
    lock->below = dl_lock_high(lock) * (1 - rounding);
    /* within a cutoff, which is no longer than half a period, the copy meant cannot change */
    lock->keeps_copy = lock->range.last < law->pieces;
}

static void add(const dl_model *model, const dl_pair *pair, const double change[3], double *a) {
    const double *inverse = model->priv->inverse_inertia;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        double *const to = a + c * model->moving;
        to[pair->i] += inverse ? inverse[pair->i] * change[c] : change[c];
        if (pair->j < model->moving)
            to[pair->j] -= inverse ? inverse[pair->j] * change[c] : change[c];
    }
}

void dl_locks_add_acceleration(dl_model *model, const double *q, double *a) {
    const double *x = dl_model_places(model, q);
    for (size_t k = 0; k < model->locks->count; k++) {
        const dl_lock *lock = &model->locks->lock[k];
        if (dl_model_lock_agrees(model, lock, x))
            continue;
        const dl_pair pair = dl_model_locked_pair(model, lock, x, NULL);
        double change[3];
        model->kernel->ops->pair(model->kernel, x, NULL, pair.i, pair.j, change);
        const double locked =
            pair.coupling * dl_law_force_over_r_within(pair.law, pair.range, pair.s);
        for (int c = 0; c < model->dimension; c++)
            change[c] = locked * pair.d[c] - change[c];
        add(model, &pair, change, a);
    }
}

/* What a pair that is locked has, copy by copy. */
static void add_discrete(const dl_model *model, const dl_pair *pair, void *context) {
    const double g = pair->coupling * dl_law_discrete_within(pair->law, pair->range, pair->s,
                                                             pair->s1, pair->ds, NULL);
    double change[3];
    for (int c = 0; c < model->dimension; c++)
        change[c] = g * (2 * pair->d[c] + pair->change[c]);
    add(model, pair, change, context);
}

void dl_locks_add_discrete(dl_model *model, const double *q, const double *delta, double *a) {
    const double *x = dl_model_places(model, q), *shifts = dl_model_shifts(model, delta);
    for (size_t k = 0; k < model->locks->count; k++) {
        const dl_lock *lock = &model->locks->lock[k];
        const dl_pair pair = dl_model_locked_pair(model, lock, x, shifts);
        if (dl_model_lock_agrees_over_step(model, lock, &pair))
            continue;
        double change[3];
        model->kernel->ops->pair(model->kernel, x, shifts, pair.i, pair.j, change);
        for (int c = 0; c < model->dimension; c++)
            change[c] = -change[c];
        add(model, &pair, change, a);
        dl_model_visit_lock(model, lock, x, shifts, add_discrete, a);
    }
}
