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

static inline void visit_pair(const dl_model *model, const double *x, const double *delta,
                              const dl_box *box, size_t i, size_t j, dl_pair_visitor *visit,
                              void *context) {
    size_t n = model->particles;
    const dl_pair_problem *p = &model->priv->problem;
    dl_pair pair = {.i = i, .j = j, .law = &p->law[dl_pair_law_index(p, i, j)]};
    pair.coupling = p->coupling ? p->coupling[i] * p->coupling[j] : 1;
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
