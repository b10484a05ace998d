/* Near pairs by the loops of all pairs, far ones by the expansions of cells about cells.
 *
 * The error is chosen (tree_walk.h); cost grows like the number of particles. Forces of two cells
 * on each other are opposite to roundoff, so that linear momentum stays; they are the gradient of
 * the potential that the energy is summed from, as long as no particle leaves its cell. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "force/padded_arrays.h"
#include "force/pair_alone.h"
#include "force/tree_walk.h"

/* Particles in a cell that are not divided further. */
enum { LEAF_FLAT = 96, LEAF_SOLID = 128 };

typedef struct tree_data {
    dl_padded_arrays arrays; /* in the tree's order */
    dl_expansion form;
    dl_opening *opening; /* [species * species * dl_law_pieces] */
    dl_tree tree;
    size_t groups, moving_groups; /* species that move, then species that are pinned */
    size_t *start, *member;       /* of the groups, tree.h */
    int *species;                 /* [groups] */
    size_t capacity;              /* cells that there are terms for */
    double *moment, *local;       /* [cells * terms] */
} tree_data;

/* --- making it -------------------------------------------------------------------------------- */

static dl_status check(const dl_pair_problem *p, dl_error *error) {
    if (p->box)
        return dl_fail(error, DL_INPUT,
                       "kernel: found tree, expected another one: the scene is periodic");
    for (size_t k = 0; k < p->species * p->species; k++)
        for (int piece = 0; piece < p->law[k].pieces; piece++)
            if (p->law[k].located[piece])
                return dl_fail(error, DL_INPUT,
                               "kernel: found tree, expected another one: crossings of the pair "
                               "law's breakpoints are located");
    return DL_OK;
}

static dl_status find_groups(const dl_pair_problem *p, tree_data *data, dl_error *error) {
    data->start = calloc(2 * p->species + 1, sizeof *data->start);
    data->species = calloc(2 * p->species, sizeof *data->species);
    data->member = malloc((p->particles + 1) * sizeof *data->member);
    if (!data->start || !data->species || !data->member)
        return dl_fail_memory(error, "the tree kernel");
    size_t next = 0;
    for (int pinned = 0; pinned <= 1; pinned++)
        for (int species = 0; species < (int)p->species; species++) {
            const size_t begin = next;
            for (size_t i = pinned ? p->moving : 0; i < (pinned ? p->particles : p->moving); i++)
                if (!p->species_of || p->species_of[i] == species)
                    data->member[next++] = i;
            if (next == begin)
                continue;
            data->species[data->groups++] = species;
            data->start[data->groups] = next;
            data->moving_groups += !pinned;
        }
    return DL_OK;
}

static dl_status create_arrays(const dl_pair_problem *p, tree_data *data, dl_error *error) {
    dl_pair_problem plain = *p;
    plain.species_of = NULL;
    plain.species = 1;
    const dl_status status = dl_padded_create(&plain, &data->arrays, error);
    if (status)
        return status;
    data->arrays.order = calloc(p->particles + 1, sizeof *data->arrays.order);
    if (p->coupling)
        data->arrays.coupling = calloc(data->arrays.stride, sizeof *data->arrays.coupling);
    return data->arrays.order && (!p->coupling || data->arrays.coupling)
               ? DL_OK
               : dl_fail_memory(error, "the tree kernel");
}

static dl_status find_openings(const dl_pair_problem *p, tree_data *data, dl_error *error) {
    const size_t laws = p->species * p->species;
    const int order = dl_opening_order(p->dimension, p->tree_error);
    dl_expansion_prepare(p->dimension, order, &data->form);
    data->opening = calloc(laws * dl_law_pieces, sizeof *data->opening);
    if (!data->opening)
        return dl_fail_memory(error, "the tree kernel");
    for (size_t k = 0; k < laws; k++)
        for (int piece = 0; piece < p->law[k].pieces; piece++)
            dl_opening_find(&p->law[k], piece, order, p->tree_error,
                            &data->opening[k * dl_law_pieces + (size_t)piece]);
    return DL_OK;
}

static dl_status create(dl_kernel *kernel, dl_error *error) {
    const dl_pair_problem *const p = &kernel->problem;
    dl_status status = check(p, error);
    if (status)
        return status;
    tree_data *const data = kernel->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "the tree kernel");
    kernel->stated_error = p->tree_error;
    status = find_groups(p, data, error);
    status = status ? status : create_arrays(p, data, error);
    status = status ? status : find_openings(p, data, error);
    if (status)
        return status;
    return dl_tree_create(p->dimension, p->particles, p->dimension == 2 ? LEAF_FLAT : LEAF_SOLID,
                          &data->tree, error);
}

static void destroy(dl_kernel *kernel) {
    tree_data *const data = kernel->data;
    if (!data)
        return;
    dl_padded_destroy(&data->arrays);
    dl_tree_release(&data->tree);
    free(data->opening);
    free(data->start);
    free(data->member);
    free(data->species);
    free(data->moment);
    free(data->local);
    free(data);
}

/* --- up and down ------------------------------------------------------------------------------ */

/* The particles of a cell in the arrays. */
static dl_cell_particles particles_of(const dl_pair_arrays *pairs, const dl_cell *cell) {
    dl_cell_particles its = {.count = cell->end - cell->begin,
                             .weight = pairs->coupling ? pairs->coupling + cell->begin : NULL};
    for (int c = 0; c < pairs->dimension; c++) {
        its.x[c] = pairs->x[c] + cell->begin;
        its.f[c] = pairs->f[c] + cell->begin;
    }
    return its;
}

/* The child's place in units of the parent's side. */
static void offset_of(const dl_cell *parent, const dl_cell *child, double offset[3]) {
    for (int c = 0; c < 3; c++)
        offset[c] = (child->centre[c] - parent->centre[c]) / parent->side;
}

static double *terms_of(const tree_data *data, double *all, size_t cell) {
    return all + cell * (size_t)data->form.terms;
}

static dl_status reserve_terms(tree_data *data, dl_error *error) {
    if (data->tree.cells <= data->capacity)
        return DL_OK;
    const size_t capacity = data->tree.cells + data->tree.cells / 4;
    free(data->moment);
    free(data->local);
    data->capacity = 0;
    data->moment = malloc(capacity * (size_t)data->form.terms * sizeof *data->moment);
    data->local = malloc(capacity * (size_t)data->form.terms * sizeof *data->local);
    if (!data->moment || !data->local)
        return dl_fail_memory(error, "the tree's expansions");
    data->capacity = capacity;
    return DL_OK;
}

static void find_moments(const dl_kernel *kernel, const dl_pair_arrays *pairs) {
    const tree_data *const data = kernel->data;
    const dl_cell *const cell = data->tree.cell;
    for (size_t k = data->tree.cells; k-- > 0;) {
        double *const moment = terms_of(data, data->moment, k), offset[3];
        if (cell[k].children == 0) {
            const dl_cell_particles its = particles_of(pairs, &cell[k]);
            kernel->vector->expansions->moments(&data->form, &its, cell[k].centre, cell[k].side,
                                                moment);
            continue;
        }
        memset(moment, 0, (size_t)data->form.terms * sizeof *moment);
        for (int n = cell[k].child; n < cell[k].child + cell[k].children; n++) {
            offset_of(&cell[k], &cell[n], offset);
            dl_expansion_raise(&data->form, offset, terms_of(data, data->moment, (size_t)n),
                               moment);
        }
    }
}

static void find_forces(const dl_kernel *kernel, const dl_pair_arrays *pairs) {
    const tree_data *const data = kernel->data;
    const dl_cell *const cell = data->tree.cell;
    for (size_t k = 0; k < data->tree.cells; k++) {
        const double *const local = terms_of(data, data->local, k);
        double offset[3];
        if (cell[k].children == 0) {
            const dl_cell_particles its = particles_of(pairs, &cell[k]);
            kernel->vector->expansions->forces(&data->form, &its, cell[k].centre, cell[k].side,
                                               local);
        }
        for (int n = cell[k].child; n < cell[k].child + cell[k].children; n++) {
            offset_of(&cell[k], &cell[n], offset);
            dl_expansion_lower(&data->form, offset, local, terms_of(data, data->local, (size_t)n));
        }
    }
}

/* --- across ----------------------------------------------------------------------------------- */

/* What a walk over one pair of groups adds to. */
typedef struct sums {
    dl_kernel *kernel;
    dl_pair_arrays pairs;
    bool energies; /* not forces */
    dl_far_batch batch[dl_law_pieces][dl_expansion_orders + 1];
    long double potential, moduli; /* of near pairs; moduli of far ones by their
                                    * cells' centres: a scale */
} sums;

static void add_near_forces(void *context, const dl_cell *a, const dl_cell *b) {
    sums *const all = context;
    const size_t of_a = a->end - a->begin, of_b = b->end - b->begin;
    all->kernel->near_pairs += a == b ? of_a * (of_a - 1) / 2 : of_a * of_b;
    all->kernel->vector->block(&all->pairs, &(dl_pair_block){a->begin, a->end, b->begin, b->end});
}

static void add_near_potential(void *context, const dl_cell *a, const dl_cell *b) {
    sums *const all = context;
    const dl_pair_arrays *const p = &all->pairs;
    for (size_t i = a->begin; i < a->end; i++)
        for (size_t j = a == b ? i + 1 : b->begin; j < b->end; j++) {
            double s = 0;
            for (int c = 0; c < p->dimension; c++)
                s += (p->x[c][i] - p->x[c][j]) * (p->x[c][i] - p->x[c][j]);
            const double coupling = p->coupling ? p->coupling[i] * p->coupling[j] : 1;
            const double v = coupling * dl_law_potential(p->law, s);
            all->potential += v;
            all->moduli += fabs(v);
        }
}

static void flush(const sums *all, dl_far_batch *batch) {
    const tree_data *const data = all->kernel->data;
    if (batch->count > 0)
        all->kernel->vector->expansions->far(&data->form, batch, data->moment, data->local);
    batch->count = 0;
}

static void add_far(void *context, const dl_far_cells *cells) {
    sums *const all = context;
    const tree_data *const data = all->kernel->data;
    const dl_cell *const a = &data->tree.cell[cells->a], *const b = &data->tree.cell[cells->b];
    dl_far_batch *const batch = &all->batch[cells->piece][cells->order];
    const int k = batch->count++;
    double s = 0;
    batch->law = all->pairs.law;
    batch->piece = cells->piece;
    batch->order = cells->order;
    batch->cell[0][k] = cells->a;
    batch->cell[1][k] = cells->b;
    batch->side[0][k] = a->side;
    batch->side[1][k] = b->side;
    for (int c = 0; c < all->pairs.dimension; c++) {
        batch->d[c][k] = b->centre[c] - a->centre[c];
        s += batch->d[c][k] * batch->d[c][k];
    }
    const double weight = terms_of(data, data->moment, (size_t)cells->a)[0] *
                          terms_of(data, data->moment, (size_t)cells->b)[0];
    if (all->energies)
        all->moduli += fabs(weight * dl_law_potential(batch->law, s));
    all->kernel->far_pairs++;
    if (batch->count == dl_far_pairs)
        flush(all, batch);
}

static void walk_groups(sums *all) {
    const tree_data *const data = all->kernel->data;
    const dl_pair_problem *const p = &all->kernel->problem;
    dl_tree_walk walk = {
        .tree = &data->tree,
        .order = data->form.order,
        .near = all->energies ? add_near_potential : add_near_forces,
        .far = add_far,
        .context = all,
    };
    for (size_t a = 0; a < data->moving_groups; a++)
        for (size_t b = a; b < data->groups; b++) {
            const size_t law = (size_t)data->species[a] * p->species + (size_t)data->species[b];
            walk.law = all->pairs.law = &p->law[law];
            walk.opening = data->opening + law * dl_law_pieces;
            all->pairs.loops = all->kernel->loops[law];
            if (walk.law->pieces > 0)
                dl_tree_walk_cells(&walk, (int)a, (int)b);
            for (int piece = 0; piece < walk.law->pieces; piece++)
                for (int order = 1; order <= data->form.order; order++)
                    flush(all, &all->batch[piece][order]);
        }
}

/* --- the sums --------------------------------------------------------------------------------- */

/* Cells, particles in their order, moments, and what all make at all. Without anything where the
 * positions are not finite. */
static dl_status sum_over(dl_kernel *kernel, const double *x, sums *all, bool *finite,
                          dl_error *error) {
    tree_data *const data = kernel->data;
    const dl_pair_problem *const p = &kernel->problem;
    dl_status status =
        dl_tree_build(&data->tree, x, data->groups, data->start, data->member, finite, error);
    status = status ? status : reserve_terms(data, error);
    if (status || !*finite)
        return status;
    for (size_t k = 0; k < p->particles; k++)
        data->arrays.order[k] = data->tree.point[k].particle;
    for (size_t k = 0; p->coupling && k < p->particles; k++)
        data->arrays.coupling[k] = p->coupling[data->arrays.order[k]];
    status = dl_padded_load(kernel, &data->arrays, x, NULL, &all->pairs, error);
    if (status)
        return status;
    all->kernel = kernel;
    find_moments(kernel, &all->pairs);
    memset(data->local, 0, data->tree.cells * (size_t)data->form.terms * sizeof *data->local);
    walk_groups(all);
    return DL_OK;
}

static dl_status create_sums(bool energies, sums **all, dl_error *error) {
    *all = calloc(1, sizeof **all);
    if (!*all)
        return dl_fail_memory(error, "the tree kernel");
    (*all)->energies = energies;
    return DL_OK;
}

static dl_status force(dl_kernel *kernel, const double *x, double *f, dl_error *error) {
    const tree_data *const data = kernel->data;
    bool finite = true;
    sums *all;
    dl_status status = create_sums(false, &all, error);
    status = status ? status : sum_over(kernel, x, all, &finite, error);
    if (!status && finite) {
        find_forces(kernel, &all->pairs);
        dl_padded_unload(kernel, &data->arrays, f);
    }
    for (size_t k = 0; !finite && k < (size_t)data->tree.dimension * data->tree.particles; k++)
        f[k] = NAN; /* the model tells of which particle */
    free(all);
    return status;
}

/* The far part is half the sum over all cells of L_b M_b, where local terms have not been handed
 * down: every pair of cells is in it twice. */
static dl_status potential(dl_kernel *kernel, const double *x, long double *sum,
                           long double *moduli, dl_error *error) {
    const tree_data *const data = kernel->data;
    bool finite = true;
    sums *all;
    dl_status status = create_sums(true, &all, error);
    status = status ? status : sum_over(kernel, x, all, &finite, error);
    long double far = 0;
    for (size_t k = 0; !status && finite && k < data->tree.cells; k++) {
        const double *const moment = terms_of(data, data->moment, k);
        const double *const local = terms_of(data, data->local, k);
        for (int n = 0; n < data->form.terms; n++)
            far += (long double)moment[n] * local[n];
    }
    if (!status) {
        *sum = finite ? all->potential + far / 2 : (long double)NAN;
        *moduli = finite ? fmaxl(all->moduli, fabsl(*sum)) : (long double)NAN;
    }
    free(all);
    return status;
}

static dl_status discrete(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error) {
    (void)kernel;
    (void)x;
    (void)delta;
    (void)f;
    return dl_fail(error, DL_INPUT,
                   "kernel: found tree, expected all-pairs: a discrete force is a sum over pairs");
}

static void pair(dl_kernel *kernel, const double *x, const double *delta, size_t i, size_t j,
                 double *f) {
    const tree_data *const data = kernel->data;
    dl_pair_alone alone;
    dl_pair_alone_load(kernel, x, delta, i, j, data->arrays.buffer, &alone);
    kernel->vector->block(&alone.arrays, &(dl_pair_block){0, 1, 1, 2});
    for (int c = 0; c < kernel->problem.dimension; c++)
        f[c] = alone.f[c][0];
}

const dl_kernel_ops dl_kernel_tree = {
    .name = "tree",
    .doc = "near pairs as all-pairs, far ones by multipole expansions to a stated force error; "
           "linear in the number of particles",
    .create = create,
    .force = force,
    .potential = potential,
    .discrete = discrete,
    .pair = pair,
    .rows = dl_kernel_rows_of_all,
    .destroy = destroy,
};
