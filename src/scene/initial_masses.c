/* Masses dealt out at random, and heavy particles brought in from the rim. */
#include <math.h>
#include <stdlib.h>
#include "scene/initial.h"

/* A particle and what it is ranked by; equal ones keep the order of the scene. */
typedef struct ranked {
    double value;
    size_t particle;
} ranked;

static int compare(const void *a, const void *b) {
    const ranked *const p = a, *const q = b;
    if (p->value != q->value)
        return p->value < q->value ? -1 : 1;
    return (p->particle > q->particle) - (p->particle < q->particle);
}

/* --- masses ----------------------------------------------------------------------------------- */

typedef struct share {
    double mass, count;
} share;

static dl_status read_share(const dl_initial *initial, const dl_yaml_node *node, share *read,
                            dl_error *error) {
    double pair[2];
    const dl_status status = dl_yaml_reals(initial->yaml, node, "masses", 2, NAN, pair, error);
    if (status)
        return status;
    if (!(pair[0] > 0) || !(pair[1] >= 1) || pair[1] != floor(pair[1]))
        return dl_yaml_fail(initial->yaml, node, "masses",
                            "[mass, count] with a mass > 0 and a whole number >= 1", error);
    *read = (share){pair[0], pair[1]};
    return DL_OK;
}

static dl_status read_shares(const dl_initial *initial, const dl_yaml_node *node, share *shares,
                             dl_error *error) {
    const size_t particles = initial->particles->count - initial->first;
    double sum = 0;
    for (size_t i = 0; i < dl_yaml_length(node); i++) {
        const dl_status status = read_share(initial, dl_yaml_item(node, i), &shares[i], error);
        if (status)
            return status;
        sum += shares[i].count;
    }
    if (sum != (double)particles)
        return dl_fail(error, DL_INPUT,
                       "%s:%d: masses: found counts that add up to %.0f, expected %zu, the "
                       "particles of the item",
                       dl_yaml_path(initial->yaml), dl_yaml_line(node), sum, particles);
    return DL_OK;
}

static void set_mass(const dl_initial *initial, dl_particle *particle, double mass) {
    if (isinf(initial->item->attributes.inertia))
        particle->inertia = mass;
    if (isinf(initial->item->attributes.coupling))
        particle->coupling = mass;
}

/* The particles in an order drawn at random: each draws a number, and they are sorted by it. */
static dl_status deal_out(dl_initial *initial, const share *shares, dl_error *error) {
    const size_t count = initial->particles->count - initial->first;
    ranked *const order = calloc(count, sizeof *order);
    if (!order)
        return dl_fail_memory(error, "masses");
    for (size_t i = 0; i < count; i++) {
        dl_random_begin(initial->random, i, DL_RANDOM_MASS);
        order[i] = (ranked){dl_random_uniform(initial->random, 0, 1), initial->first + i};
    }
    qsort(order, count, sizeof *order, compare);
    size_t end = (size_t)shares->count; /* of the share under way */
    for (size_t i = 0; i < count; i++) {
        if (i == end)
            end += (size_t)(++shares)->count;
        set_mass(initial, &initial->particles->particle[order[i].particle], shares->mass);
    }
    free(order);
    return DL_OK;
}

static dl_status set_random_masses(dl_initial *initial, const dl_yaml_node *node, dl_error *error) {
    if (initial->item->file[0])
        return dl_yaml_fail(initial->yaml, node, "masses",
                            "none beside a file, whose columns give them", error);
    if (dl_yaml_get(initial->node, "mass"))
        return dl_yaml_fail(initial->yaml, node, "masses", "none beside a mass", error);
    if (isfinite(initial->item->attributes.inertia) && isfinite(initial->item->attributes.coupling))
        return dl_yaml_fail(initial->yaml, node, "masses",
                            "none beside inertia and coupling, which leave it nothing to give",
                            error);
    if (dl_yaml_kind_of(node) != DL_YAML_LIST || dl_yaml_length(node) == 0)
        return dl_yaml_fail(initial->yaml, node, "masses", "[[mass, count], ...]", error);
    share *const shares = calloc(dl_yaml_length(node), sizeof *shares);
    if (!shares)
        return dl_fail_memory(error, "masses");
    dl_status status = read_shares(initial, node, shares, error);
    if (!status)
        status = deal_out(initial, shares, error);
    free(shares);
    return status;
}

/* --- exchange --------------------------------------------------------------------------------- */

static double distance(const dl_particle *particle, const double about[3]) {
    const double x = particle->position[0] - about[0], y = particle->position[1] - about[1],
                 z = particle->position[2] - about[2];
    return sqrt(x * x + y * y + z * z);
}

static void swap(double *a, double *b) {
    const double kept = *a;
    *a = *b;
    *b = kept;
}

/* The item's lightest, nearest first, and the others, farthest first. */
typedef struct sides {
    size_t light, heavy;
    ranked *lightest, *heavier;
} sides;

static void fill_sides(const dl_initial *initial, const double about[3], sides *s) {
    const dl_particle *const particle = initial->particles->particle;
    double least = INFINITY;
    for (size_t i = initial->first; i < initial->particles->count; i++)
        least = fmin(least, particle[i].inertia);
    for (size_t i = initial->first; i < initial->particles->count; i++) {
        const double r = distance(&particle[i], about);
        if (particle[i].inertia > least)
            s->heavier[s->heavy++] = (ranked){-r, i};
        else
            s->lightest[s->light++] = (ranked){r, i};
    }
    qsort(s->lightest, s->light, sizeof *s->lightest, compare);
    qsort(s->heavier, s->heavy, sizeof *s->heavier, compare);
}

/* Exchanges that bring a heavier particle inwards. */
static size_t useful_pairs(const sides *s) {
    size_t pairs = 0;
    while (pairs < s->light && pairs < s->heavy &&
           s->lightest[pairs].value < -s->heavier[pairs].value)
        pairs++;
    return pairs;
}

static dl_status exchange_pairs(dl_initial *initial, const dl_yaml_node *node, long wanted,
                                const sides *s, dl_error *error) {
    const size_t useful = useful_pairs(s), pairs = (size_t)wanted;
    if (pairs > useful)
        return dl_fail(error, DL_INPUT,
                       "%s:%d: pairs: found %zu, expected at most %zu: no other exchange brings a "
                       "heavier particle inwards",
                       dl_yaml_path(initial->yaml), dl_yaml_line(node), pairs, useful);
    for (size_t i = 0; i < pairs; i++) {
        dl_particle *const in = &initial->particles->particle[s->lightest[i].particle];
        dl_particle *const out = &initial->particles->particle[s->heavier[i].particle];
        swap(&in->inertia, &out->inertia);
        swap(&in->coupling, &out->coupling);
    }
    return DL_OK;
}

static dl_status exchange_masses(dl_initial *initial, const dl_yaml_node *node, dl_error *error) {
    const size_t count = initial->particles->count - initial->first;
    dl_exchange_values values = {0};
    double about[3] = {0};
    dl_status status =
        dl_scene_read_section(initial->yaml, node, &dl_section_exchange, &values, error);
    const dl_yaml_node *const centre = status ? NULL : dl_yaml_get(node, "about");
    if (centre)
        status = dl_yaml_reals(initial->yaml, centre, "about",
                               (size_t)initial->particles->dimension, NAN, about, error);
    if (status)
        return status;
    sides s = {.lightest = calloc(count, sizeof(ranked)), .heavier = calloc(count, sizeof(ranked))};
    if (s.lightest && s.heavier) {
        fill_sides(initial, about, &s);
        status = exchange_pairs(initial, node, values.pairs, &s, error);
    } else {
        status = dl_fail_memory(error, "exchange");
    }
    free(s.lightest);
    free(s.heavier);
    return status;
}

dl_status dl_initial_set_masses(dl_initial *initial, dl_error *error) {
    const dl_yaml_node *const masses = dl_yaml_get(initial->node, "masses");
    const dl_yaml_node *const exchange = dl_yaml_get(initial->node, "exchange");
    dl_status status = masses ? set_random_masses(initial, masses, error) : DL_OK;
    if (!status && exchange)
        status = exchange_masses(initial, exchange, error);
    return status;
}
