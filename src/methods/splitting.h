/* Splittings: one step is a product of flows that are known exactly, kicks v += b h a(q) and drifts
 * q += a h v, by turns. Every method of that kind is a table here and one row of the registry
 * (splitting_tables.c); one loop runs them all (composition.c). */
#ifndef DL_METHODS_SPLITTING_H
#define DL_METHODS_SPLITTING_H

#include <stdbool.h>
#include "driftlab/method.h"

typedef enum dl_splitting_form {
    DL_OF_VERLET,  /* weights w_j of Verlet steps S_{w_j h}: kick h/2, drift h, kick h/2 */
    DL_FROM_KICK,  /* kick, drift, kick ... */
    DL_FROM_DRIFT, /* drift, kick, drift ... */
} dl_splitting_form;

enum {
    dl_most_drifts = 35,
    dl_most_coefficients = 18, /* as written in a table */
};

typedef struct dl_splitting_table {
    dl_splitting_form form;
    int count;      /* of coefficients in a step, those left out by symmetry too */
    bool symmetric; /* only the first (count + 1)/2 are written */
    double coefficient[dl_most_coefficients];
} dl_splitting_table;

/* A step in the order in which it is done: kick[0], drift[0], kick[1], ... drift[drifts - 1],
 * kick[drifts]. In parts of the step; the first and the last kick may be 0. */
typedef struct dl_splitting {
    int drifts;
    double kick[dl_most_drifts + 1], drift[dl_most_drifts];
} dl_splitting;

void dl_splitting_expand(const dl_splitting_table *table, dl_splitting *splitting);

typedef struct dl_splitting_options {
    double step;
    bool compensated;
} dl_splitting_options;

extern const dl_parameter dl_splitting_parameters[2];
extern const dl_method_ops dl_splitting_ops;

#endif
