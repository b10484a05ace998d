/* A tree of cells over the particles of each group: squares or cubes, halved along every axis
 * until few particles are left in each.
 *
 * The cells' grid is that of powers of two about the whole scene, so that it stands still while
 * particles move; the tree depends on positions alone, not on their order or on what was before. */
#ifndef DL_FORCE_TREE_H
#define DL_FORCE_TREE_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

typedef struct dl_cell {
    size_t begin, end; /* its particles in the tree's order */
    int child;         /* the first of its children, which follow one another; 0: it has none */
    int children, depth;
    double centre[3], side;
    double radius; /* of the particles about the centre */
} dl_cell;

typedef struct dl_tree_point {
    double x[3];
    size_t particle;
} dl_tree_point;

typedef struct dl_tree {
    int dimension;
    size_t leaf; /* particles that are not divided further */
    size_t particles;
    dl_tree_point *point, *scratch; /* [particles], in the tree's order */
    size_t cells, capacity;
    dl_cell *cell; /* parents before their children */
} dl_tree;

dl_status dl_tree_create(int dimension, size_t particles, size_t leaf, dl_tree *tree,
                         dl_error *error);
void dl_tree_release(dl_tree *tree);

/* Divides anew: group g has particles member[start[g]] ... member[start[g + 1] - 1], and becomes
 * cell g with all below it. x is a block of dimension * particles; *finite tells whether all of it
 * is, without which there is no tree. */
dl_status dl_tree_build(dl_tree *tree, const double *x, size_t groups, const size_t *start,
                        const size_t *member, bool *finite, dl_error *error);

#endif
