/* Methods across the scenes of one or several work-precision studies: where each reaches what was
 * asked, and for how many times the CPU time of the scene's cheapest. */
#ifndef DRIFTLAB_ACROSS_H
#define DRIFTLAB_ACROSS_H

#include <stddef.h>
#include "driftlab/results.h"

typedef struct dl_across_cell {
    const dl_case *best; /* the method's cheapest case that reaches the scene's asked error; NULL:
                            none does */
    double ratio;        /* of its CPU time to that of the scene's cheapest; 1: it is that one */
    size_t rank;         /* 1: the cheapest */
} dl_across_cell;

typedef struct dl_across_row {
    const char *method;
    size_t reached;       /* scenes */
    double worst;         /* its largest ratio */
    dl_across_cell *cell; /* [scenes] */
} dl_across_row;

typedef struct dl_across_scene {
    const char *name;
    const dl_results *results; /* the study that asks */
} dl_across_scene;

/* Names and cases belong to the results. */
typedef struct dl_across {
    size_t scenes;
    dl_across_scene *scene;
    size_t rows;
    dl_across_row *row; /* from that which reaches most scenes at the least `worst` ratio on */
    dl_across_cell *cells;
} dl_across;

/* Of every scene of the studies, in their order. *across is to be released on failure, too. */
dl_status dl_across_create(const dl_results *const *results, size_t count, dl_across *across,
                           dl_error *error);
void dl_across_release(dl_across *across);

/* Two sentences: the cheapest on each scene, and the method that does best on all of them. */
void dl_across_answer(const dl_across *across, char *text, size_t size);

#endif
