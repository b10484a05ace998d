#include "model/middle_gap.h"

#include <math.h>

#include "model/near_jumps.h"
#include "model/private.h"

/* Plain iterations, after which all but the pairs in a gap have come near their middles. */
enum { most_iterations = 20 };

typedef struct search {
    double half_square;  /* h^2/2 */
    const double *delta; /* that the image has been made from */
    dl_middle_gap gap;
    bool found;
} search;

/* Displacement of the pair's coordinate c for a unit force along it. */
static double gain_of(const dl_model *model, const dl_pair *pair, size_t c, double half_square) {
    const double *const inverse = model->priv->inverse_inertia;
    const size_t of[2] = {pair->i, pair->j};
    double gain = 0;
    for (int k = 0; k < 2; k++)
        if (of[k] < model->moving && !(model->held && model->held[c * model->moving + of[k]]))
            gain += half_square * (inverse ? inverse[of[k]] : 1);
    return gain;
}

/* The pair's middle without its own force, and half of its gain along it. */
typedef struct rest_of_pair {
    double b, half_gain;
} rest_of_pair;

/* pair->change is the image's. */
static rest_of_pair without_own_force(const dl_model *model, const dl_pair *pair,
                                      const search *context) {
    const size_t n = model->moving, dimension = (size_t)model->dimension;
    double at[3], gain[3], b[3], s = 0, square = 0, along = 0;
    for (size_t c = 0; c < dimension; c++) {
        const double *const delta = context->delta + c * n;
        at[c] = pair->d[c] + (delta[pair->i] - (pair->j < n ? delta[pair->j] : 0)) / 2;
        s += at[c] * at[c];
    }
    const double over_r = pair->coupling * dl_law_force_over_r(pair->law, s);
    for (size_t c = 0; c < dimension; c++) {
        gain[c] = gain_of(model, pair, c, context->half_square);
        b[c] = pair->d[c] + (pair->change[c] - gain[c] * over_r * at[c]) / 2;
        square += b[c] * b[c];
        along += b[c] * gain[c] * b[c];
    }
    return (rest_of_pair){sqrt(square), along / square / 2};
}

static void look_at(const dl_model *model, const dl_pair *pair, void *context) {
    search *const of = context;
    const dl_law *const law = pair->law;
    const size_t i = model->priv->order[pair->i], j = model->priv->order[pair->j];
    const rest_of_pair rest = without_own_force(model, pair, of);
    for (int k = 0; k < law->pieces && !of->found; k++) {
        const double r = law->until[k];
        if (dl_law_jump(law, k) == 0)
            continue;
        const double reach = rest.half_gain * pair->coupling * r;
        const double inside = rest.b + reach * dl_law_force_over_r_in(law, k, r);
        const double outside = rest.b + reach * dl_law_force_over_r_in(law, k + 1, r);
        of->found = outside <= r && r < inside;
        if (of->found)
            of->gap = (dl_middle_gap){i < j ? i : j, i < j ? j : i, r, inside, outside};
    }
}

/* One iteration, and a look at the pairs near a jump. */
static bool look(dl_model *model, dl_near_pairs *near, const double *q, const double *v, double h,
                 double *delta, double *a, search *of) {
    const double *const x = dl_model_places(model, q);
    if (dl_model_discrete_acceleration(model, q, delta, a, NULL))
        return false;
    for (size_t u = 0; u < model->unknowns; u++)
        a[u] = h * v[u] + of->half_square * a[u];
    of->delta = delta;
    of->found = false;
    if (dl_near_pairs_visit(model, near, x, dl_model_shifts(model, a), h, look_at, of, NULL))
        return false;
    for (size_t u = 0; u < model->unknowns; u++)
        delta[u] = a[u];
    return true;
}

bool dl_model_middle_gap(dl_model *model, const double *q, const double *v, double h, double *delta,
                         double *a, dl_middle_gap *gap) {
    search of = {.half_square = h * h / 2};
    dl_near_pairs *near = NULL;
    bool found = false;
    if (model->locates_crossings || !dl_model_any_jumps(model)) /* locked: nothing jumps */
        return false;
    if (!dl_near_pairs_create(model, &near, NULL))
        for (int k = 0; k < most_iterations && look(model, near, q, v, h, delta, a, &of); k++)
            if (of.found) {
                *gap = of.gap;
                found = true;
            }
    dl_near_pairs_free(near);
    return found;
}
