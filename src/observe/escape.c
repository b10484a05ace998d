/* Which groups of particles have left the system for good. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "observe/pairs.h"

/* A group is known by its root, the first of its particles. */
typedef struct group {
    double mass, at[3], velocity[3]; /* sums, then means */
    double potential;                /* with the system */
    size_t particles;
    bool escaped;
} group;

typedef struct groups {
    const dl_scene *scene;
    const double *y_all;
    size_t *root;  /* [particles] */
    group *of;     /* [particles], those of roots in use */
    size_t system; /* root of the system */
} groups;

static double first_end(const dl_pair_law *law) {
    return law->pieces > 0 ? law->piece[0].until : 0;
}

double dl_escape_link(const dl_scene *scene) {
    double farthest = first_end(&scene->law);
    for (size_t k = 0; k < scene->species * scene->species; k++)
        farthest = fmax(farthest, first_end(&scene->species_law[k]));
    return farthest > 0 ? farthest : INFINITY;
}

/* --- groups ----------------------------------------------------------------------------------- */

static size_t find_root(size_t *root, size_t i) {
    while (root[i] != i)
        i = root[i] = root[root[i]];
    return i;
}

static void connect(groups *g, double link) {
    const size_t n = g->scene->particles;
    double d[3];
    for (size_t i = 0; i < n; i++)
        g->root[i] = i;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++) {
            if (!(dl_observe_separation_of(g->scene, g->y_all, i, j, d) < link * link))
                continue;
            const size_t a = find_root(g->root, i), b = find_root(g->root, j);
            g->root[a > b ? a : b] = a > b ? b : a;
        }
    for (size_t i = 0; i < n; i++)
        g->root[i] = find_root(g->root, i);
}

static void sum_up(groups *g) {
    const size_t n = g->scene->particles, components = (size_t)g->scene->dimension;
    for (size_t i = 0; i < n; i++) {
        group *const of = &g->of[g->root[i]];
        const double mass = g->scene->inertia[i];
        of->mass += mass;
        of->particles += !g->scene->pinned[i];
        for (size_t c = 0; c < components; c++) {
            of->at[c] += mass * g->y_all[c * n + i];
            of->velocity[c] += mass * g->y_all[(components + c) * n + i];
        }
    }
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; g->root[i] == i && c < components; c++) {
            g->of[i].at[c] /= g->of[i].mass;
            g->of[i].velocity[c] /= g->of[i].mass;
        }
    g->system = 0;
    for (size_t i = 0; i < n; i++)
        if (g->of[i].mass > g->of[g->system].mass)
            g->system = i;
}

static dl_status find_groups(groups *g, double link, dl_error *error) {
    const size_t n = g->scene->particles;
    g->root = malloc(n * sizeof *g->root);
    g->of = calloc(n, sizeof *g->of);
    if (!g->root || !g->of)
        return dl_fail_memory(error, "groups of particles");
    connect(g, link);
    sum_up(g);
    return DL_OK;
}

static void release(groups *g) {
    free(g->root);
    free(g->of);
}

dl_status dl_observe_system(const dl_scene *scene, const double *y_all, double link, bool *system,
                            dl_error *error) {
    groups g = {.scene = scene, .y_all = y_all};
    const dl_status status = find_groups(&g, link, error);
    for (size_t i = 0; i < scene->particles && !status; i++)
        system[i] = g.root[i] == g.system;
    release(&g);
    return status;
}

/* --- escape ----------------------------------------------------------------------------------- */

static void add_potential(const dl_observed_pair *pair, void *context) {
    groups *const g = context;
    const size_t a = g->root[pair->i], b = g->root[pair->j];
    if (a != b && (a == g->system || b == g->system))
        g->of[a == g->system ? b : a].potential += pair->potential;
}

static bool leaves(const group *other, const group *system, double beyond) {
    double distance = 0, speed = 0, outward = 0;
    for (size_t c = 0; c < 3; c++) {
        const double r = other->at[c] - system->at[c];
        const double v = other->velocity[c] - system->velocity[c];
        distance += r * r;
        speed += v * v;
        outward += r * v;
    }
    const double reduced = other->mass * system->mass / (other->mass + system->mass);
    return reduced * speed / 2 + other->potential > 0 && outward > 0 && distance > beyond * beyond;
}

static void count(groups *g, double beyond, bool *escaped, dl_escape *result) {
    const size_t n = g->scene->particles;
    *result = (dl_escape){.system = g->of[g->system].particles};
    for (size_t i = 0; i < n; i++)
        if (g->root[i] == i) {
            result->groups += g->of[i].particles > 0;
            g->of[i].escaped = i != g->system && leaves(&g->of[i], &g->of[g->system], beyond);
        }
    for (size_t i = 0; i < n; i++) {
        const bool gone = !g->scene->pinned[i] && g->of[g->root[i]].escaped;
        result->particles += gone;
        if (escaped)
            escaped[i] = gone;
    }
}

dl_status dl_observe_escape(dl_model *model, const double *y_all, const dl_escape_rule *rule,
                            bool *escaped, dl_escape *result, dl_error *error) {
    if (!(rule->link > 0 && isfinite(rule->link)) || !(rule->beyond >= 0))
        return dl_fail(error, DL_INPUT,
                       "escape: found link %.15g, beyond %.15g, expected a finite link > 0 and "
                       "beyond >= 0",
                       rule->link, rule->beyond);
    groups g = {.scene = model->scene, .y_all = y_all};
    dl_status status = find_groups(&g, rule->link, error);
    if (!status)
        status = dl_observe_pairs(model, y_all, add_potential, &g, error);
    if (!status)
        count(&g, rule->beyond, escaped, result);
    release(&g);
    return status;
}
