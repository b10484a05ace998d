/* Which pairs of cells see each other by expansions, and which pairs of particles are left. */
#ifndef DL_FORCE_TREE_WALK_H
#define DL_FORCE_TREE_WALK_H

#include "force/expansion.h"
#include "force/tree.h"

/* What a stated error asks of two cells for an expansion of each order: that the sum of their radii
 * is no more than this part of the distance of their centres. Ascending. */
typedef struct dl_opening {
    double ratio[dl_expansion_orders + 1];
} dl_opening;

/* Highest order that is worth its cost for a relative force error. */
int dl_opening_order(int dimension, double error);

/* For a piece of the law, orders 1 ... order. The pair force's expansion by its distance has a
 * remainder of at most
 *
 *     (1 + t)^p  sum over m >= order of  (p)(p+1)...(p+m-1)/m!  t^m
 *
 * of the force itself, t the ratio and p the steepest power: the series of (1 - t)^-p. That is
 * where both particles are in the worst corner of their cells; measured over all pairs of cells the
 * force's error is less by a factor of some hundreds, of which tree_walk.c uses a part. */
void dl_opening_find(const dl_law *law, int piece, int order, double error, dl_opening *opening);

/* A pair of cells that see each other by an expansion. */
typedef struct dl_far_cells {
    int a, b, piece, order;
} dl_far_cells;

typedef struct dl_tree_walk {
    const dl_tree *tree;
    const dl_law *law;
    const dl_opening *opening; /* [pieces of the law] */
    int order;
    /* Pairs of a particle of the first with one of the second; with the same cell twice, pairs
     * within. `a` comes before `b` in the tree's order. */
    void (*near)(void *context, const dl_cell *a, const dl_cell *b);
    void (*far)(void *context, const dl_far_cells *cells);
    void *context;
} dl_tree_walk;

/* Every pair of a particle of cell a with one of cell b (or both of a = b), once, near or far; but
 * those of which the law's end says that they do not act. */
void dl_tree_walk_cells(const dl_tree_walk *walk, int a, int b);

#endif
