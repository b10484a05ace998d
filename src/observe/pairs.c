#include "observe/pairs.h"

#include <math.h>
#include <stdlib.h>

#include "model/private.h"

double dl_observe_separation_of(const dl_scene *scene, const double *y_all, size_t i, size_t j,
                                double d[3]) {
    double square = 0;
    for (size_t c = 0; c < (size_t)scene->dimension; c++) {
        const double *x = y_all + c * scene->particles;
        const double length = scene->periods.length[c];
        d[c] = x[i] - x[j];
        if (length > 0)
            d[c] -= length * nearbyint(d[c] / length);
        square += d[c] * d[c];
    }
    return square;
}

typedef struct walk {
    dl_observed_pair_visitor *visit;
    void *context;
} walk;

static void pass_on(const dl_model *model, const dl_pair *pair, void *context) {
    const walk *w = context;
    const size_t *row = model->priv->order;
    const dl_observed_pair observed = {
        .i = row[pair->i],
        .j = row[pair->j],
        .d = {pair->d[0], pair->d[1], pair->d[2]},
        .force_over_r = pair->coupling * dl_law_force_over_r(pair->law, pair->s),
        .potential = pair->coupling * dl_law_potential(pair->law, pair->s),
    };
    w->visit(&observed, w->context);
}

dl_status dl_observe_pairs(dl_model *model, const double *y_all, dl_observed_pair_visitor *visit,
                           void *context, dl_error *error) {
    const size_t n = model->particles, components = (size_t)model->dimension;
    double *x = malloc(components * n * sizeof *x);
    if (!x)
        return dl_fail_memory(error, "the pairs of a state");
    for (size_t c = 0; c < components; c++)
        for (size_t k = 0; k < n; k++)
            x[c * n + k] = y_all[c * n + model->priv->order[k]];
    walk w = {visit, context};
    const dl_status status = dl_model_visit_pairs(model, x, NULL, pass_on, &w, error);
    free(x);
    return status;
}
