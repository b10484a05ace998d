/* Walking over pairs, for everything that is not the force itself. */
#include "model/private.h"

static void measure(const dl_model *model, const double *x, const double *delta, size_t i, size_t j,
                    dl_pair *pair) {
    size_t n = model->particles;
    const double *coupling = model->priv->coupling;
    *pair = (dl_pair){.i = i, .j = j, .coupling = coupling ? coupling[i] * coupling[j] : 1};
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        double d = x[c * n + i] - x[c * n + j];
        pair->d[c] = d;
        pair->s += d * d;
        if (delta) {
            double change = delta[c * n + i] - delta[c * n + j], end = d + change;
            pair->change[c] = change;
            pair->s1 += end * end;
            pair->ds += change * (d + end);
        }
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
    for (size_t i = 0; i < model->moving; i++) {
        size_t begin = rows.neighbour ? (size_t)rows.start[i] : i + 1;
        size_t end = rows.neighbour ? (size_t)rows.start[i + 1] : model->particles;
        for (size_t k = begin; k < end; k++) {
            dl_pair pair;
            measure(model, x, delta, i, rows.neighbour ? (size_t)rows.neighbour[k] : k, &pair);
            visit(model, &pair, context);
        }
    }
    return DL_OK;
}
