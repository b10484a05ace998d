/* Half neighbour lists from a grid of cells. */
#ifndef DL_FORCE_CELLS_H
#define DL_FORCE_CELLS_H

#include <stddef.h>
#include "driftlab/status.h"
#include "force/box.h"

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

/* Rebuilds the rows i < moving: every j > i with |x_i - x_j| <= reach, of the nearest copies where
 * box is not NULL. x is a block x|y|[z]. A pair that is beyond reach now comes within a shorter one
 * only after its particles have moved by the difference, whatever the copies: distances between
 * nearest copies obey the triangle inequality. So the reach may be longer than half a period.
 * DL_UNSTABLE, naming the first row, where a position is not finite. */
dl_status dl_cells_build(dl_cells *cells, dl_list *list, const double *x, int dimension,
                         size_t particles, size_t moving, double reach, const dl_box *box,
                         dl_error *error);
/* Sorts the particles by cell (`member`). The same failure. */
dl_status dl_cells_fill(dl_cells *cells, const double *x, int dimension, size_t particles,
                        double reach, const dl_box *box, dl_error *error);
void dl_cells_release(dl_cells *cells, dl_list *list);

#endif
