/* Products with the derivative of the mean acceleration by delta, without a matrix: the blocks of
 * the pairs that act are kept, and a product is one walk over them.
 *
 *     out_i = (1/inertia_i) sum_j B_ij (u_i - u_j)
 *
 * Gonzalez' mean a(m) + c e, c = N/D with e the relative part of delta (discrete.c), D = e.e (in
 * the metric of the kinetic energy) and N = V(q0) - V(q1) - a(m).delta, adds  c u' + e (g.u),  u'
 * the relative part of u,
 *
 *     D g = a(q1) - a(m) - J(m) delta/2 - 2 c e,
 *
 * since the derivative of V(q0) - V(q1) is the acceleration at the end. (J is symmetric, but for
 * pairs that pass a jump; these have nearly no part in N.) */
#include <stdlib.h>
#include <string.h>
#include "model/private.h"

struct dl_product {
    dl_block_of *block_of; /* of the walk under way */
    size_t pairs, capacity;
    size_t *pair;  /* [2 * capacity]: i, j */
    double *block; /* [capacity * dimension * dimension] */
    bool out_of_memory;
    double c;             /* of Gonzalez' correction; 0 for other means */
    double *e, *gradient; /* [unknowns]: of his alone; NULL */
    double *middle;       /* [unknowns]: of his alone: a(m); NULL */
    double *scratch;      /* [unknowns] */
};

void dl_product_free(struct dl_product *product) {
    if (!product)
        return;
    free(product->pair);
    free(product->block);
    free(product->e);
    free(product->middle);
    free(product->gradient);
    free(product->scratch);
    free(product);
}

/* --- the pairs' blocks --------------------------------------------------------------------------
 */

static bool reserve(const dl_model *model, struct dl_product *product) {
    if (product->pairs < product->capacity)
        return true;
    const size_t each = (size_t)model->dimension * (size_t)model->dimension;
    const size_t room = product->capacity ? 2 * product->capacity : 4 * model->moving + 16;
    size_t *const pair = realloc(product->pair, 2 * room * sizeof *pair);
    if (pair)
        product->pair = pair;
    double *const block = realloc(product->block, room * each * sizeof *block);
    if (block)
        product->block = block;
    if (!pair || !block)
        return false;
    product->capacity = room;
    return true;
}

static void keep_pair(const dl_model *model, const dl_pair *pair, void *context) {
    struct dl_product *const product = context;
    const size_t dimension = (size_t)model->dimension;
    const int pieces = pair->law->pieces;
    const bool near = dl_law_piece_within(pair->law, pair->range, pair->s) < pieces;
    const bool ends_near =
        pair->s1 > 0 && dl_law_piece_within(pair->law, pair->range, pair->s1) < pieces;
    if (!near && !ends_near)
        return;
    if (product->out_of_memory || !reserve(model, product)) {
        product->out_of_memory = true;
        return;
    }
    double block[3][3];
    product->block_of(model, pair, block);
    double *const to = product->block + product->pairs * dimension * dimension;
    for (size_t r = 0; r < dimension; r++)
        for (size_t c = 0; c < dimension; c++)
            to[r * dimension + c] = block[r][c];
    product->pair[2 * product->pairs] = pair->i;
    product->pair[2 * product->pairs + 1] = pair->j;
    product->pairs++;
}

static dl_status keep_pairs(dl_model *model, const double *q, const double *delta,
                            dl_error *error) {
    struct dl_product *const product = model->priv->product;
    product->pairs = 0;
    product->out_of_memory = false;
    const dl_mean_walk walk = dl_model_mean_walk(model, q, delta);
    product->block_of = walk.block_of;
    const dl_status status =
        dl_model_visit_pairs(model, walk.x, walk.delta, keep_pair, product, error);
    if (status == DL_OK && model->locks)
        dl_model_visit_locks(model, walk.x, walk.delta, keep_pair, product);
    return !status && product->out_of_memory ? dl_fail_memory(error, "the pairs of a product")
                                             : status;
}

/* --- products -----------------------------------------------------------------------------------
 */

/* out += the pairs' forces. */
static void add_pairs(const dl_model *model, const double *u, double *out) {
    const struct dl_product *const product = model->priv->product;
    const size_t n = model->moving, dimension = (size_t)model->dimension;
    for (size_t k = 0; k < product->pairs; k++) {
        const size_t i = product->pair[2 * k], j = product->pair[2 * k + 1];
        const double *const block = product->block + k * dimension * dimension;
        double change[3];
        for (size_t c = 0; c < dimension; c++)
            change[c] = u[c * n + i] - (j < n ? u[c * n + j] : 0);
        for (size_t r = 0; r < dimension; r++) {
            double force = 0;
            for (size_t c = 0; c < dimension; c++)
                force += block[r * dimension + c] * change[c];
            out[r * n + i] += force;
            if (j < n)
                out[r * n + j] -= force;
        }
    }
}

static void multiply(const dl_model *model, const double *u, double *out) {
    const double *const inverse = model->priv->inverse_inertia;
    memset(out, 0, model->unknowns * sizeof *out);
    add_pairs(model, u, out);
    for (size_t c = 0; inverse && c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++)
            out[c * model->moving + k] *= inverse[k];
}

void dl_model_discrete_product(dl_model *model, const double *u, double *out) {
    const struct dl_product *const product = model->priv->product;
    model->counts.jacobian_vector++;
    multiply(model, u, out);
    if (product->e) {
        const double along = dl_model_work(model, product->gradient, u);
        dl_model_relative(model, u, product->scratch);
        for (size_t k = 0; k < model->unknowns; k++)
            out[k] += product->c * product->scratch[k] + along * product->e[k];
    }
    for (size_t k = 0; model->held && k < model->unknowns; k++)
        if (model->held[k])
            out[k] = 0;
}

void dl_model_discrete_diagonal(const dl_model *model, double *block) {
    const struct dl_product *const product = model->priv->product;
    const double *const inverse = model->priv->inverse_inertia;
    const size_t n = model->moving, dimension = (size_t)model->dimension;
    const size_t each = dimension * dimension;
    memset(block, 0, n * each * sizeof *block);
    for (size_t k = 0; k < product->pairs; k++)
        for (size_t side = 0; side < 2; side++) {
            const size_t i = product->pair[2 * k + side];
            for (size_t e = 0; i < n && e < each; e++)
                block[i * each + e] += product->block[k * each + e] * (inverse ? inverse[i] : 1);
        }
    for (size_t u = 0; model->held && u < model->unknowns; u++)
        if (model->held[u])
            memset(block + u % n * each + u / n * dimension, 0, dimension * sizeof *block);
}

/* --- Gonzalez' correction -----------------------------------------------------------------------
 */

static dl_status prepare_correction(dl_model *model, const double *q, const double *delta,
                                    dl_error *error) {
    struct dl_product *const product = model->priv->product;
    double *const g = product->gradient, *const e = product->e;
    double *const middle = product->middle, *const turned = product->scratch;
    dl_status status = dl_model_gonzalez(model, q, delta, middle, &product->c, e, error);
    for (size_t k = 0; k < model->unknowns; k++)
        turned[k] = q[k] + delta[k];
    status = status ? status : dl_model_accelerate(model, turned, g, error);
    if (status)
        return status;
    multiply(model, delta, turned);
    status = dl_model_gonzalez_asymmetry(model, q, delta, g, error);
    if (status)
        return status;
    const double square = dl_model_work(model, e, e);
    for (size_t k = 0; k < model->unknowns; k++)
        g[k] = square > 0 ? (g[k] - middle[k] - turned[k] - 2 * product->c * e[k]) / square : 0;
    return DL_OK;
}

static dl_status create(dl_model *model, dl_error *error) {
    struct dl_product *const made = model->priv->product = calloc(1, sizeof *made);
    const size_t size = (model->unknowns + 1) * sizeof(double);
    if (made && model->mean == DL_MEAN_GONZALEZ) {
        made->e = malloc(size);
        made->middle = malloc(size);
        made->gradient = malloc(size);
        made->scratch = malloc(size);
    }
    const bool whole = made && (model->mean != DL_MEAN_GONZALEZ ||
                                (made->e && made->middle && made->gradient && made->scratch));
    return whole ? DL_OK : dl_fail_memory(error, "a product with a derivative");
}

dl_status dl_model_discrete_product_prepare(dl_model *model, const double *q, const double *delta,
                                            dl_error *error) {
    dl_status status = model->priv->product ? DL_OK : create(model, error);
    status = status ? status : keep_pairs(model, q, delta, error);
    if (status || model->mean != DL_MEAN_GONZALEZ)
        return status;
    return prepare_correction(model, q, delta, error);
}

void dl_model_discrete_product_forget(dl_model *model) {
    dl_product_free(model->priv->product);
    model->priv->product = NULL;
}
