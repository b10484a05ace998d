/* Walking over pairs, for everything that is not the force itself. */
#include "model/private.h"

/* Completes a pair from its separation and, with a delta, the change of that. */
static inline void complete(dl_pair *pair, int dimension, bool with_delta) {
    pair->s = pair->s1 = pair->ds = 0;
    for (int c = 0; c < dimension; c++) {
        double d = pair->d[c];
        pair->s += d * d;
        if (with_delta) {
            double end = d + pair->change[c];
            pair->s1 += end * end;
            pair->ds += pair->change[c] * (d + end);
        }
    }
}

dl_pair dl_pair_middle(const dl_model *model, const dl_pair *pair) {
    dl_pair middle = *pair;
    for (int c = 0; c < model->dimension; c++) {
        middle.d[c] += pair->change[c] / 2;
        middle.change[c] = 0;
    }
    complete(&middle, model->dimension, false);
    return middle;
}

static inline dl_pair pair_of(const dl_model *model, size_t i, size_t j) {
    const dl_pair_problem *p = &model->priv->problem;
    dl_pair pair = {.i = i, .j = j, .law = &p->law[dl_pair_law_index(p, i, j)]};
    pair.range = dl_law_all(pair.law);
    pair.coupling = p->coupling ? p->coupling[i] * p->coupling[j] : 1;
    return pair;
}

static inline void visit_pair(const dl_model *model, const double *x, const double *delta,
                              const dl_box *box, size_t i, size_t j, dl_pair_visitor *visit,
                              void *context) {
    size_t n = model->particles;
    dl_pair pair = pair_of(model, i, j);
    for (int c = 0; c < model->dimension; c++) {
        size_t at = (size_t)c * n;
        pair.d[c] = x[at + i] - x[at + j];
        if (box)
            pair.d[c] -= dl_box_shift(box, c, pair.d[c]);
        if (delta)
            pair.change[c] = delta[at + i] - delta[at + j];
    }
    complete(&pair, model->dimension, delta);
    visit(model, &pair, context);
    if (box && delta && dl_box_nearest_changes(box, model->dimension, pair.d, pair.change)) {
        complete(&pair, model->dimension, true);
        visit(model, &pair, context);
    }
}

dl_status dl_model_visit_pairs(dl_model *model, const double *x, const double *delta,
                               dl_pair_visitor *visit, void *context, dl_error *error) {
    if (!model->kernel)
        return DL_OK;
    dl_pair_rows rows;
    dl_status status = model->kernel->ops->rows(model->kernel, x, delta, &rows, error);
    if (status != DL_OK)
        return status;
    const dl_box *box = model->priv->problem.box;
    for (size_t i = 0; i < model->moving; i++) {
        size_t begin = rows.neighbour ? (size_t)rows.start[i] : i + 1;
        size_t end = rows.neighbour ? (size_t)rows.start[i + 1] : model->particles;
        for (size_t k = begin; k < end; k++) {
            size_t j = rows.neighbour ? (size_t)rows.neighbour[k] : k;
            if (box)
                visit_pair(model, x, delta, box, i, j, visit, context);
            else
                visit_pair(model, x, delta, NULL, i, j, visit, context);
        }
    }
    return DL_OK;
}

void dl_model_visit_pair(const dl_model *model, const double *x, const double *delta, size_t i,
                         size_t j, dl_pair_visitor *visit, void *context) {
    visit_pair(model, x, delta, model->priv->problem.box, i, j, visit, context);
}

/* --- locked pairs ------------------------------------------------------------------------------*/

static inline double locked_separation(const dl_box *box, const dl_lock *lock, int c,
                                       const double *row) {
    double d = row[lock->i] - row[lock->j];
    if (box)
        d -= lock->keeps_copy ? lock->copy[c] : dl_box_shift(box, c, d);
    return d;
}

dl_pair dl_model_locked_pair(const dl_model *model, const dl_lock *lock, const double *x,
                             const double *delta) {
    dl_pair pair = pair_of(model, lock->i, lock->j);
    pair.range = lock->range;
    for (int c = 0; c < model->dimension; c++) {
        size_t at = (size_t)c * model->particles;
        pair.d[c] = locked_separation(model->priv->problem.box, lock, c, x + at);
        if (delta)
            pair.change[c] = delta[at + lock->i] - delta[at + lock->j];
    }
    complete(&pair, model->dimension, delta);
    return pair;
}

bool dl_model_lock_agrees(const dl_model *model, const dl_lock *lock, const double *x) {
    const dl_box *box = model->priv->problem.box;
    double s = 0;
    for (int c = 0; c < model->dimension; c++) {
        double d = locked_separation(box, lock, c, x + (size_t)c * model->particles);
        s += d * d;
    }
    return s > lock->above && s < lock->below;
}

bool dl_model_lock_agrees_over_step(const dl_model *model, const dl_lock *lock,
                                    const dl_pair *pair) {
    const dl_box *box = model->priv->problem.box;
    double d[3] = {pair->d[0], pair->d[1], pair->d[2]};
    return pair->s > lock->above && pair->s < lock->below && pair->s1 > lock->above &&
           pair->s1 < lock->below &&
           !(box && !lock->keeps_copy &&
             dl_box_nearest_changes(box, model->dimension, d, pair->change));
}

/* What is done with a pair in the place of `visit`. */
typedef struct detour {
    dl_law_range range;
    dl_pair_visitor *visit;
    void *context;
} detour;

static void visit_turned(const dl_model *model, const dl_pair *pair, void *context) {
    const detour *job = context;
    dl_pair opposite = *pair;
    opposite.coupling = -pair->coupling;
    job->visit(model, &opposite, job->context);
}

static void visit_locked(const dl_model *model, const dl_pair *pair, void *context) {
    const detour *job = context;
    dl_pair locked = *pair;
    locked.range = job->range;
    job->visit(model, &locked, job->context);
}

void dl_model_visit_lock(const dl_model *model, const dl_lock *lock, const double *x,
                         const double *delta, dl_pair_visitor *visit, void *context) {
    detour job = {lock->range, visit, context};
    if (lock->keeps_copy) {
        const dl_pair pair = dl_model_locked_pair(model, lock, x, delta);
        visit(model, &pair, context);
    } else {
        visit_pair(model, x, delta, model->priv->problem.box, lock->i, lock->j, visit_locked, &job);
    }
}

void dl_model_visit_locks(const dl_model *model, const double *x, const double *delta,
                          dl_pair_visitor *visit, void *context) {
    const dl_box *box = model->priv->problem.box;
    for (size_t k = 0; k < model->locks->count; k++) {
        const dl_lock *lock = &model->locks->lock[k];
        const dl_pair pair = dl_model_locked_pair(model, lock, x, delta);
        if (delta ? dl_model_lock_agrees_over_step(model, lock, &pair)
                  : dl_model_lock_agrees(model, lock, x))
            continue;
        detour job = {lock->range, visit, context};
        visit_pair(model, x, delta, box, lock->i, lock->j, visit_turned, &job);
        dl_model_visit_lock(model, lock, x, delta, visit, context);
    }
}
