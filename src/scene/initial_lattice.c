/* Lattices: sites of a rectangular cell, repeated; or rows of a hexagonal lattice. */
#include <math.h>
#include <stdlib.h>
#include "scene/initial.h"

static const double sqrt2 = 1.4142135623730950488, sqrt3 = 1.7320508075688772935;

/* Rectangular cells with their sites, nearest neighbours at distance 1. */
typedef struct cell {
    int dimension;
    double edge[3];
    int sites;
    double site[4][3];
} cell;

static cell cell_of(int kind) {
    const double half = sqrt2 / 2;
    const cell cells[] = {
        [dl_lattice_hexagonal] = {2, {1, sqrt3, 0}, 2, {{0, 0, 0}, {0.5, sqrt3 / 2, 0}}},
        [dl_lattice_square] = {2, {1, 1, 0}, 1, {{0, 0, 0}}},
        [dl_lattice_simple] = {3, {1, 1, 1}, 1, {{0, 0, 0}}},
        [dl_lattice_face_centred] =
            {3,
             {sqrt2, sqrt2, sqrt2},
             4,
             {{0, 0, 0}, {half, half, 0}, {half, 0, half}, {0, half, half}}},
    };
    return cells[kind];
}

typedef struct lattice {
    dl_initial *initial;
    const dl_yaml_node *node;
    dl_lattice_values values;
    cell cell;
    double origin[3], cosine, sine;
} lattice;

/* A site at `offset`, in spacings, from the origin. */
static dl_status add_site(lattice *l, const double offset[3], dl_error *error) {
    const double x = l->values.spacing * offset[0], y = l->values.spacing * offset[1];
    const double position[3] = {l->origin[0] + l->cosine * x - l->sine * y,
                                l->origin[1] + l->sine * x + l->cosine * y,
                                l->origin[2] + l->values.spacing * offset[2]};
    return dl_initial_add(l->initial, position, error);
}

/* --- rows ------------------------------------------------------------------------------------- */

static bool odd(long number) {
    return number % 2 != 0;
}

/* Row k is shifted by half a spacing against the row before, so that in half spacings its first
 * site is even or odd by turns. Centred on the first row it begins at n0 - n; where that is of the
 * wrong kind, half a spacing farther right. */
static dl_status add_row(lattice *l, long row, long start, long count, dl_error *error) {
    dl_status status = DL_OK;
    if (odd(start) != odd(row))
        start++;
    for (long i = 0; i < count && !status; i++) {
        const double offset[3] = {0.5 * (double)(start + 2 * i), 0.5 * sqrt3 * (double)row, 0};
        status = add_site(l, offset, error);
    }
    return status;
}

static dl_status place_rows(lattice *l, const dl_yaml_node *rows, dl_error *error) {
    const dl_yaml *const yaml = l->initial->yaml;
    if (l->values.kind != dl_lattice_hexagonal)
        return dl_yaml_fail(yaml, rows, "rows", "none: only a hexagonal lattice has rows", error);
    size_t length;
    long *count;
    dl_status status =
        dl_initial_read_counts(yaml, rows, "rows", dl_most_placed, &length, &count, error);
    for (size_t row = 0; row < length && !status; row++)
        status = add_row(l, (long)row, count[0] - count[row], count[row], error);
    free(count);
    return status;
}

/* --- cells ------------------------------------------------------------------------------------ */

/* Cells low <= index < high along each axis; sites beyond `radius` (in spacings) are left out. */
typedef struct block {
    long low[3], high[3];
    double radius;
} block;

static dl_status add_site_within(lattice *l, const block *b, const long index[3], int site,
                                 dl_error *error) {
    double offset[3], square = 0;
    for (int axis = 0; axis < 3; axis++) {
        offset[axis] = (double)index[axis] * l->cell.edge[axis] + l->cell.site[site][axis];
        square += offset[axis] * offset[axis];
    }
    return sqrt(square) <= b->radius ? add_site(l, offset, error) : DL_OK;
}

/* Row by row: x varies fastest, the sites of a cell lie one above the other. */
static dl_status add_block(lattice *l, const block *b, dl_error *error) {
    dl_status status = DL_OK;
    long index[3];
    for (index[2] = b->low[2]; index[2] < b->high[2] && !status; index[2]++)
        for (index[1] = b->low[1]; index[1] < b->high[1] && !status; index[1]++)
            for (int site = 0; site < l->cell.sites && !status; site++)
                for (index[0] = b->low[0]; index[0] < b->high[0] && !status; index[0]++)
                    status = add_site_within(l, b, index, site, error);
    return status;
}

static dl_status place_count(lattice *l, const dl_yaml_node *node, dl_error *error) {
    const dl_yaml *const yaml = l->initial->yaml;
    size_t length = 0;
    long *count;
    dl_status status =
        dl_initial_read_counts(yaml, node, "count", dl_most_placed, &length, &count, error);
    if (!status && length != (size_t)l->cell.dimension)
        status =
            dl_yaml_fail(yaml, node, "count",
                         l->cell.dimension == 2 ? "2 whole numbers" : "3 whole numbers", error);
    if (!status && l->values.kind == dl_lattice_hexagonal) {
        for (long row = 0; row < count[1] && !status; row++)
            status = add_row(l, row, 0, count[0], error);
    } else if (!status) {
        block b = {.high = {count[0], count[1], length == 3 ? count[2] : 1}, .radius = INFINITY};
        status = add_block(l, &b, error);
    }
    free(count);
    return status;
}

/* Sites of a ball by its volume, which the count approaches as the radius grows. */
static double sites_within(const cell *c, double radius) {
    const double pi = 3.14159265358979323846;
    return c->dimension == 2
               ? c->sites * pi * pow(radius, 2) / (c->edge[0] * c->edge[1])
               : c->sites * 4 * pi / 3 * pow(radius, 3) / (c->edge[0] * c->edge[1] * c->edge[2]);
}

/* A site on the circle belongs to it, whatever the rounding of the radius as it is written. What
 * the estimate lets pass is few enough to be counted while it is placed. */
static dl_status place_ball(lattice *l, dl_error *error) {
    const double radius = l->values.radius / l->values.spacing * (1 + 1e-9);
    if (!(sites_within(&l->cell, radius) < 2.0 * dl_most_placed))
        return dl_fail(error, DL_INPUT,
                       "%s:%d: radius: found %g, expected one with at most %d particles within it "
                       "at a spacing of %g",
                       dl_yaml_path(l->initial->yaml), dl_yaml_line(dl_yaml_get(l->node, "radius")),
                       l->values.radius, dl_most_placed, l->values.spacing);
    block b = {.high = {1, 1, 1}, .radius = radius};
    for (int axis = 0; axis < l->cell.dimension; axis++) {
        const long reach = (long)(radius / l->cell.edge[axis]) + 1;
        b.low[axis] = -reach;
        b.high[axis] = reach + 1;
    }
    return add_block(l, &b, error);
}

/* --- the item --------------------------------------------------------------------------------- */

static dl_status read_lattice(lattice *l, dl_error *error) {
    dl_initial *const initial = l->initial;
    const int dimension = initial->particles->dimension;
    dl_status status =
        dl_scene_read_section(initial->yaml, l->node, &dl_section_lattice, &l->values, error);
    if (status)
        return status;
    l->cell = cell_of(l->values.kind);
    if (l->cell.dimension != dimension)
        return dl_yaml_fail(initial->yaml, dl_yaml_get(l->node, "kind"), "kind",
                            dimension == 2 ? "hexagonal or square in two dimensions"
                                           : "simple-cubic or face-centred-cubic in three "
                                             "dimensions",
                            error);
    if (dimension == 3 && l->values.angle != 0)
        return dl_yaml_fail(initial->yaml, dl_yaml_get(l->node, "angle"), "angle",
                            "none in three dimensions", error);
    const double radians = l->values.angle * 3.14159265358979323846 / 180;
    l->cosine = cos(radians);
    l->sine = sin(radians);
    const dl_yaml_node *const origin = dl_yaml_get(l->node, "origin");
    return origin ? dl_yaml_reals(initial->yaml, origin, "origin", (size_t)dimension, NAN,
                                  l->origin, error)
                  : DL_OK;
}

dl_status dl_initial_place_lattice(dl_initial *initial, dl_error *error) {
    lattice l = {.initial = initial, .node = dl_yaml_get(initial->node, "lattice")};
    const dl_status status = read_lattice(&l, error);
    if (status)
        return status;
    const dl_yaml_node *const rows = dl_yaml_get(l.node, "rows");
    const dl_yaml_node *const count = dl_yaml_get(l.node, "count");
    const bool ball = isfinite(l.values.radius);
    if ((rows != NULL) + (count != NULL) + ball != 1)
        return dl_yaml_fail(initial->yaml, l.node, "lattice", "one of rows, count and radius in it",
                            error);
    if (ball)
        return place_ball(&l, error);
    return rows ? place_rows(&l, rows, error) : place_count(&l, count, error);
}
