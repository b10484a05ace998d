#include "force/tree.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Deeper cells would be too small for their place: particles that coincide stay together. */
enum { DEEPEST = 40 };

dl_status dl_tree_create(int dimension, size_t particles, size_t leaf, dl_tree *tree,
                         dl_error *error) {
    *tree = (dl_tree){.dimension = dimension, .leaf = leaf, .particles = particles};
    tree->point = malloc((particles + 1) * sizeof *tree->point);
    tree->scratch = malloc((particles + 1) * sizeof *tree->scratch);
    return tree->point && tree->scratch ? DL_OK : dl_fail_memory(error, "a tree of particles");
}

void dl_tree_release(dl_tree *tree) {
    free(tree->point);
    free(tree->scratch);
    free(tree->cell);
}

/* --- cells ------------------------------------------------------------------------------------ */

static dl_status reserve(dl_tree *tree, size_t need, dl_error *error) {
    if (need <= tree->capacity)
        return DL_OK;
    const size_t capacity = need + need / 2 + 64;
    dl_cell *const cell = realloc(tree->cell, capacity * sizeof *cell);
    if (!cell)
        return dl_fail_memory(error, "a tree of particles");
    tree->cell = cell;
    tree->capacity = capacity;
    return DL_OK;
}

static double radius_of(const dl_tree *tree, const dl_cell *cell) {
    double largest = 0;
    for (size_t k = cell->begin; k < cell->end; k++) {
        double s = 0;
        for (int c = 0; c < tree->dimension; c++) {
            const double d = tree->point[k].x[c] - cell->centre[c];
            s += d * d;
        }
        largest = fmax(largest, s);
    }
    return sqrt(largest);
}

static unsigned octant_of(const dl_tree *tree, const dl_cell *cell, const dl_tree_point *point) {
    unsigned octant = 0;
    for (int c = 0; c < tree->dimension && c < 3; c++)
        octant |= (point->x[c] >= cell->centre[c] ? 1U : 0U) << c;
    return octant;
}

/* Sorts the cell's points by octant; end[o] is where octant o ends. */
static void sort_points(dl_tree *tree, const dl_cell *cell, size_t end[8]) {
    size_t count[8] = {0}, at = cell->begin;
    for (size_t k = cell->begin; k < cell->end; k++)
        count[octant_of(tree, cell, &tree->point[k])]++;
    for (int o = 0; o < 8; o++) {
        end[o] = at;
        at += count[o];
    }
    for (size_t k = cell->begin; k < cell->end; k++)
        tree->scratch[end[octant_of(tree, cell, &tree->point[k])]++] = tree->point[k];
    memcpy(tree->point + cell->begin, tree->scratch + cell->begin,
           (cell->end - cell->begin) * sizeof *tree->point);
}

static dl_status divide(dl_tree *tree, size_t index, dl_error *error) {
    const dl_cell parent = tree->cell[index];
    size_t end[8];
    if (parent.end - parent.begin <= tree->leaf || parent.depth >= DEEPEST)
        return DL_OK;
    const dl_status status = reserve(tree, tree->cells + 8, error);
    if (status)
        return status;
    sort_points(tree, &parent, end);
    tree->cell[index].child = (int)tree->cells;
    for (unsigned o = 0; o < 8; o++) {
        dl_cell cell = {.begin = o ? end[o - 1] : parent.begin,
                        .end = end[o],
                        .depth = parent.depth + 1,
                        .side = parent.side / 2};
        if (cell.begin == cell.end)
            continue;
        for (int c = 0; c < tree->dimension; c++)
            cell.centre[c] = parent.centre[c] + (o >> c & 1U ? 0.25 : -0.25) * parent.side;
        cell.radius = radius_of(tree, &cell);
        tree->cell[tree->cells++] = cell;
        tree->cell[index].children++;
    }
    return DL_OK;
}

/* --- the whole -------------------------------------------------------------------------------- */

/* The cell of all: its side a power of two, its place a multiple of a sixteenth of that. Returns
 * whether the positions are finite. */
static bool find_whole(const dl_tree *tree, const double *x, dl_cell *whole) {
    double low[3] = {0}, extent = 0;
    for (int c = 0; c < tree->dimension; c++) {
        const double *const row = x + (size_t)c * tree->particles;
        double high = low[c] = row[0], sum = 0;
        for (size_t k = 0; k < tree->particles; k++) {
            low[c] = fmin(low[c], row[k]);
            high = fmax(high, row[k]);
            sum += row[k] * 0.0;
        }
        if (sum != 0 || !isfinite(high - low[c]))
            return false;
        extent = fmax(extent, high - low[c]);
    }
    int exponent = 0;
    frexp(extent > 0 ? extent * (1 + 1.0 / 15) : 1, &exponent);
    whole->side = ldexp(1, exponent);
    for (int c = 0; c < tree->dimension; c++)
        whole->centre[c] = (floor(low[c] / whole->side * 16) / 16 + 0.5) * whole->side;
    return isfinite(whole->side * whole->side);
}

dl_status dl_tree_build(dl_tree *tree, const double *x, size_t groups, const size_t *start,
                        const size_t *member, bool *finite, dl_error *error) {
    dl_cell whole = {.child = 0};
    tree->cells = 0;
    *finite = find_whole(tree, x, &whole);
    dl_status status = reserve(tree, groups, error);
    if (status || !*finite)
        return status;
    for (size_t k = 0; k < tree->particles; k++) {
        tree->point[k].particle = member[k];
        for (int c = 0; c < tree->dimension; c++)
            tree->point[k].x[c] = x[(size_t)c * tree->particles + member[k]];
    }
    for (size_t g = 0; g < groups; g++) {
        dl_cell *const root = &tree->cell[tree->cells++];
        *root = whole;
        root->begin = start[g];
        root->end = start[g + 1];
        root->radius = radius_of(tree, root);
    }
    for (size_t k = 0; k < tree->cells && !status; k++)
        status = divide(tree, k, error);
    return status;
}
