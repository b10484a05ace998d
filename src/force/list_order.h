/* An order of the particles in which neighbours in space are neighbours in memory, for a kernel
 * alone: states keep theirs. Moving particles stay before the pinned ones. */
#ifndef DL_FORCE_LIST_ORDER_H
#define DL_FORCE_LIST_ORDER_H

#include "force/cells.h"
#include "force/kernel.h"

typedef struct dl_list_order {
    int *particle;           /* [particles], of each place; NULL: as they come */
    double *x, *delta, *f;   /* [dimension * particles], by place */
    double *coupling;        /* [particles + pad]; NULL: all 1 */
    int *species_of;         /* [particles]; NULL: one law */
    dl_pair_problem problem; /* the kernel's, by place */
} dl_list_order;

/* Whether the list's partners are so far apart in memory that an order pays. */
bool dl_list_is_scattered(const dl_list *list, const dl_pair_problem *problem);

/* Orders by the cells of `reach` at x, and `problem` with it; allocates at the first call. */
dl_status dl_list_order_set(dl_list_order *order, const dl_pair_problem *problem, dl_cells *cells,
                            const double *x, double reach, dl_error *error);
void dl_list_order_release(dl_list_order *order);

/* from [dimension * particles] by place. */
void dl_list_order_gather(const dl_list_order *order, const double *from, double *to);
/* order->f in the particles' own order. */
void dl_list_order_scatter(const dl_list_order *order, double *f);

#endif
