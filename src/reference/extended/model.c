#include "reference/extended/model.h"

#include <stdlib.h>
#include <string.h>

/* --- the model -------------------------------------------------------------------------------- */

static void order_particles(model *made) {
    size_t next = 0;
    for (int pinned = 0; pinned <= 1; pinned++) {
        for (size_t i = 0; i < made->particles; i++)
            if (made->scene->pinned[i] == (pinned == 1))
                made->order[next++] = i;
        if (!pinned)
            made->moving = next;
    }
    made->unknowns = made->dimension * made->moving;
}

static void fill_particles(model *made) {
    const dl_scene *scene = made->scene;
    const size_t n = made->moving, still = made->particles - n;
    for (size_t k = 0; k < n; k++)
        made->inertia[k] = scene->inertia[made->order[k]];
    for (size_t c = 0; c < made->dimension; c++) {
        for (size_t k = 0; k < n; k++)
            made->gravity[c * n + k] = scene->feels_gravity[made->order[k]] ? scene->gravity[c] : 0;
        for (size_t k = 0; k < still; k++)
            made->pinned[c * still + k] = scene->position[c * made->particles + made->order[n + k]];
        made->period[c] = scene->periods.present ? scene->periods.length[c] : 0;
    }
}

static dl_status fill_laws(model *made, dl_error *error) {
    const dl_scene *scene = made->scene;
    made->species = scene->species > 0 ? scene->species : 1;
    const size_t laws = made->species * made->species;
    made->law = calloc(laws, sizeof *made->law);
    if (!made->law)
        return dl_fail_memory(error, "the reference's pair laws");
    for (size_t k = 0; k < laws; k++)
        law_prepare(scene->species > 0 ? &scene->species_law[k] : &scene->law, &made->law[k]);
    return DL_OK;
}

dl_status model_create(const dl_scene *scene, model *made, dl_error *error) {
    *made = (model){.scene = scene,
                    .dimension = (size_t)scene->dimension,
                    .particles = scene->particles,
                    .is_periodic = scene->periods.present};
    made->order = calloc(made->particles, sizeof *made->order);
    if (!made->order)
        return dl_fail_memory(error, "a reference");
    order_particles(made);
    made->inertia = calloc(made->moving + 1, sizeof *made->inertia);
    made->gravity = calloc(made->unknowns + 1, sizeof *made->gravity);
    made->pinned =
        calloc(made->dimension * (made->particles - made->moving) + 1, sizeof *made->pinned);
    if (!made->inertia || !made->gravity || !made->pinned)
        return dl_fail_memory(error, "a reference");
    fill_particles(made);
    return fill_laws(made, error);
}

void model_free(model *made) {
    free(made->order);
    free(made->inertia);
    free(made->gravity);
    free(made->pinned);
    free(made->law);
    *made = (model){.scene = NULL};
}

void model_state(const model *of, real *q, real *v) {
    const dl_scene *scene = of->scene;
    for (size_t c = 0; c < of->dimension; c++)
        for (size_t k = 0; k < of->moving; k++) {
            q[c * of->moving + k] = scene->position[c * of->particles + of->order[k]];
            v[c * of->moving + k] = scene->velocity[c * of->particles + of->order[k]];
        }
}

/* --- pairs ------------------------------------------------------------------------------------ */

static const law *law_between(const model *of, size_t i, size_t j) {
    const int *species = of->scene->species_of;
    if (of->species == 1)
        return of->law;
    return &of->law[(size_t)species[of->order[i]] * of->species + (size_t)species[of->order[j]]];
}

static size_t list_pairs(const model *of, pair *list) {
    const double *coupling = of->scene->coupling;
    size_t count = 0;
    for (size_t i = 0; i < of->moving; i++)
        for (size_t j = i + 1; j < of->particles; j++) {
            const law *between = law_between(of, i, j);
            const real product = (real)coupling[of->order[i]] * coupling[of->order[j]];
            if (between->pieces == 0 || product == 0)
                continue;
            if (list)
                list[count] = (pair){.i = i, .j = j, .law = between, .coupling = product};
            count++;
        }
    return count;
}

dl_status pairs_create(const model *of, pairs *all, dl_error *error) {
    *all = (pairs){.count = list_pairs(of, NULL)};
    all->pair = calloc(all->count + 1, sizeof *all->pair);
    all->active_one = calloc(all->count + 1, sizeof *all->active_one);
    if (!all->pair || !all->active_one)
        return dl_fail_memory(error, "the reference's pairs");
    list_pairs(of, all->pair);
    return DL_OK;
}

void pairs_free(pairs *all) {
    free(all->pair);
    free(all->active_one);
    *all = (pairs){.count = 0};
}

static void take_nearest_image(const model *of, pair *p, const real *q) {
    for (size_t c = 0; of->is_periodic && c < of->dimension; c++) {
        p->image[c] = 0;
        if (of->period[c] > 0)
            p->image[c] = (int)real_round(pair_separation(of, p, q, c) / of->period[c]);
    }
}

void pairs_assign(const model *of, pairs *all, const real *q) {
    for (size_t k = 0; k < all->count; k++) {
        pair *p = &all->pair[k];
        real square = 0;
        take_nearest_image(of, p, q);
        for (size_t c = 0; c < of->dimension; c++) {
            const real d = pair_separation(of, p, q, c);
            square += d * d;
        }
        p->piece = law_piece_at(p->law, real_sqrt(square));
    }
    pairs_find_active(all);
}

void pairs_find_active(pairs *all) {
    all->active = 0;
    for (size_t k = 0; k < all->count; k++)
        if (all->pair[k].piece < all->pair[k].law->pieces)
            all->active_one[all->active++] = k;
}

/* --- forces ----------------------------------------------------------------------------------- */

/* The force on i, coupling and all; its components are those of d times this. */
static real force_over_r(const model *of, const pair *p, const real *q, real d[3]) {
    real square = 0;
    for (size_t c = 0; c < of->dimension; c++) {
        d[c] = pair_separation(of, p, q, c);
        square += d[c] * d[c];
    }
    return p->coupling * law_force_over_r(&p->law->piece[p->piece], square);
}

void model_acceleration(const model *of, const pairs *all, const real *q, real *a) {
    const size_t n = of->moving;
    memset(a, 0, of->unknowns * sizeof *a);
    for (size_t k = 0; k < all->active; k++) {
        const pair *p = &all->pair[all->active_one[k]];
        real d[3];
        const real over_r = force_over_r(of, p, q, d);
        for (size_t c = 0; c < of->dimension; c++) {
            a[c * n + p->i] += over_r * d[c];
            if (p->j < n)
                a[c * n + p->j] -= over_r * d[c];
        }
    }
    for (size_t u = 0; u < of->unknowns; u++)
        a[u] = a[u] / of->inertia[u % n] + of->gravity[u];
}

void model_load(const model *of, const pairs *all, const real *q, real *load) {
    const size_t n = of->moving;
    memset(load, 0, of->unknowns * sizeof *load);
    for (size_t k = 0; k < all->active; k++) {
        const pair *p = &all->pair[all->active_one[k]];
        real d[3], square = 0;
        const real over_r = real_abs(force_over_r(of, p, q, d));
        for (size_t c = 0; c < of->dimension; c++)
            square += d[c] * d[c];
        for (size_t c = 0; c < of->dimension; c++) {
            load[c * n + p->i] += over_r * real_sqrt(square);
            if (p->j < n)
                load[c * n + p->j] += over_r * real_sqrt(square);
        }
    }
    for (size_t u = 0; u < of->unknowns; u++)
        load[u] = load[u] / of->inertia[u % n] + real_abs(of->gravity[u]);
}
