#include "force/tree_walk.h"

#include <math.h>

/* How much more than the error of a particle's force the bound on that of its worst pair is: cells
 * are not full of particles in their corners, and errors of many cells partly cancel; less so the
 * slower the force falls and the lower the orders are. An estimate: measured over uniform
 * particles, columns, pairs of clusters and one whose middle is the corner of four cells, in two
 * and three dimensions, errors are at most three quarters of what is stated with it
 * (tests/test_tree.c). */
static double bound_over_error(double power, double error) {
    const double steep = fmin(fmax(power - 1, 0), 1);
    return 20 * pow(5, steep) * fmin(1, sqrt(1e-4 / error));
}

/* Fewer pairs of particles than this are summed faster than two cells' expansions. */
enum { FEW_PAIRS = 256 };

int dl_opening_order(int dimension, double error) {
    const double digits = fmax(0, -log10(error));
    const int order = (dimension == 2 ? 8 : 6) + (int)digits;
    const int highest = dimension == 2 ? dl_expansion_orders : dl_expansion_orders_solid;
    return order < highest ? order : highest;
}

/* --- the opening ------------------------------------------------------------------------------ */

static double remainder_of(double p, int order, double t) {
    double term = 1, sum = 0;
    for (int m = 0; m < 10000; m++) {
        if (m >= order)
            sum += term;
        if (m >= order && term < 1e-3 * sum * (1 - t))
            break;
        term *= (p + m) / (m + 1) * t;
    }
    return pow(1 + t, p) * sum;
}

static double ratio_for(double p, int order, double bound) {
    double low = 0, high = 0.9;
    for (int k = 0; k < 50; k++) {
        const double middle = (low + high) / 2;
        if (remainder_of(p, order, middle) <= bound)
            low = middle;
        else
            high = middle;
    }
    return low;
}

void dl_opening_find(const dl_law *law, int piece, int order, double error, dl_opening *opening) {
    double steepest = 1;
    for (int s = 0; s < law->terms[piece]; s++)
        steepest = fmax(steepest, fabs(law->power[piece][s]));
    opening->ratio[0] = 0;
    for (int k = 1; k <= order; k++)
        opening->ratio[k] = ratio_for(steepest, k, bound_over_error(steepest, error) * error);
}

/* --- the walk --------------------------------------------------------------------------------- */

static double square(double x) {
    return x * x;
}

/* More than roundoff moves a distance by. */
static const double margin = 1e-12;

typedef enum sight { SIGHT_NONE, SIGHT_FAR, SIGHT_NEAR } sight;

/* How two cells see each other, as they are. */
static sight look(const dl_tree_walk *walk, const dl_cell *a, const dl_cell *b,
                  dl_far_cells *cells) {
    const dl_law *const law = walk->law;
    double s = 0;
    for (int c = 0; c < walk->tree->dimension; c++)
        s += square(b->centre[c] - a->centre[c]);
    const double r = sqrt(s), radii = a->radius + b->radius;
    const double nearest = (r - radii) * (1 - margin), farthest = (r + radii) * (1 + margin);
    if (nearest <= 0)
        return SIGHT_NEAR;
    const int piece = dl_law_piece(law, square(nearest));
    if (piece == law->pieces)
        return SIGHT_NONE;
    if (law->width[piece] > 0 || dl_law_piece(law, square(farthest)) != piece)
        return SIGHT_NEAR;
    const double *const ratio = walk->opening[piece].ratio;
    int order = 1;
    while (order <= walk->order && radii > ratio[order] * r)
        order++;
    cells->piece = piece;
    cells->order = order;
    return order <= walk->order ? SIGHT_FAR : SIGHT_NEAR;
}

static void see_near(const dl_tree_walk *walk, const dl_cell *a, const dl_cell *b) {
    if (a->begin <= b->begin)
        walk->near(walk->context, a, b);
    else
        walk->near(walk->context, b, a);
}

static void walk_within(const dl_tree_walk *walk, int index) {
    const dl_cell *const cell = &walk->tree->cell[index];
    if (cell->children == 0) {
        walk->near(walk->context, cell, cell);
        return;
    }
    for (int i = 0; i < cell->children; i++)
        for (int j = i; j < cell->children; j++)
            dl_tree_walk_cells(walk, cell->child + i, cell->child + j);
}

void dl_tree_walk_cells(const dl_tree_walk *walk, int a, int b) {
    const dl_cell *const first = &walk->tree->cell[a], *const second = &walk->tree->cell[b];
    dl_far_cells cells = {.a = a, .b = b};
    const size_t pairs = (first->end - first->begin) * (second->end - second->begin);
    if (a == b) {
        walk_within(walk, a);
        return;
    }
    const sight seen = look(walk, first, second, &cells);
    if (seen == SIGHT_NONE || pairs == 0)
        return;
    if (pairs <= FEW_PAIRS || (seen == SIGHT_NEAR && !first->children && !second->children))
        see_near(walk, first, second);
    else if (seen == SIGHT_FAR)
        walk->far(walk->context, &cells);
    else if (second->children == 0 || (first->children > 0 && first->radius >= second->radius))
        for (int k = 0; k < first->children; k++)
            dl_tree_walk_cells(walk, first->child + k, b);
    else
        for (int k = 0; k < second->children; k++)
            dl_tree_walk_cells(walk, a, second->child + k);
}
