/* A neighbour list taken apart by species, so that each part has one law. */
#ifndef DL_FORCE_LIST_PARTS_H
#define DL_FORCE_LIST_PARTS_H

#include "force/cells.h"
#include "force/kernel.h"

typedef struct dl_list_parts {
    size_t count;  /* species * species; 0 where one law holds for all pairs */
    dl_list *part; /* [count], at dl_pair_law_index with the smaller species first */
} dl_list_parts;

dl_status dl_list_parts_create(const dl_pair_problem *problem, dl_list_parts *parts,
                               dl_error *error);
void dl_list_parts_release(dl_list_parts *parts);

/* Fills the parts from the whole list. */
dl_status dl_list_parts_fill(const dl_pair_problem *problem, const dl_list *whole,
                             dl_list_parts *parts, dl_error *error);

#endif
