/* Half neighbour lists from a grid of cells. */
#ifndef DL_FORCE_CELLS_H
#define DL_FORCE_CELLS_H

#include <stddef.h>
#include "driftlab/status.h"

typedef struct dl_cells {
    int *cell_start;      /* [cells + 1] */
    int *member;          /* [particles]: particles, cell by cell */
    int *cell_of;         /* [particles] */
    size_t cell_capacity; /* of cell_start */
} dl_cells;

typedef struct dl_list {
    int *start;      /* [moving + 1] */
    int *neighbour;  /* [start[moving]] */
    size_t capacity; /* of neighbour */
} dl_list;

/* Rebuilds the rows i < moving: every j > i with |x_i - x_j| <= reach. x is a block x|y|[z].
 * DL_UNSTABLE, naming the first row, where a position is not finite. */
dl_status dl_cells_build(dl_cells *cells, dl_list *list, const double *x, int dimension,
                         size_t particles, size_t moving, double reach, dl_error *error);
void dl_cells_release(dl_cells *cells, dl_list *list);

#endif
