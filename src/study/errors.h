/* The kinds of error that a work-precision study measures: one table, one row a kind. */
#ifndef DL_STUDY_ERRORS_H
#define DL_STUDY_ERRORS_H

#include <stdbool.h>
#include "driftlab/results.h"

typedef struct dl_error_row {
    const char *name;                   /* see dl_case_error */
    bool needs_reference;               /* a case's `refused` speaks of it */
    double (*of)(const dl_case *cased); /* NaN: none */
    const char *missing;                /* why there is none */
} dl_error_row;

enum { DL_ERROR_ROWS = 6 };
extern const dl_error_row dl_error_rows[DL_ERROR_ROWS];

/* The row of that name; "position" where there is none. */
const dl_error_row *dl_error_row_of(const char *name);

#endif
