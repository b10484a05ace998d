/* What the rows of the conserving family (conserving_rows.c) are made of. */
#ifndef DL_METHODS_CONSERVING_H
#define DL_METHODS_CONSERVING_H

#include <stdbool.h>

#include "driftlab/method.h"
#include "methods/conserving_solver.h"

typedef struct dl_conserving_options {
    double step, tolerance;
    long iterations, depth;
    int predictor; /* dl_predictor_kind */
    int solver;    /* index of dl_solver_names behind "auto" */
    bool rescue;
} dl_conserving_options;

/* A row's kind. */
typedef struct dl_conserving_variant {
    dl_mean mean;
    bool by_option;        /* the solver is an option's */
    dl_solver_kind solver; /* the row's, where it is not */
    int stages;            /* steps composed */
    const double *weight;  /* [stages]: their lengths as parts of the step */
} dl_conserving_variant;

extern const dl_method_ops dl_conserving_ops;

#endif
