/* Settings of kinds that try many fixed steps: from where to where, in which unit, and for how
 * long. */
#ifndef DL_STUDY_STEP_RANGE_H
#define DL_STUDY_STEP_RANGE_H

#include <float.h>
#include <stddef.h>
#include "driftlab/parameter.h"

typedef enum dl_step_unit { DL_OF_FREQUENCY, DL_OF_STEP, DL_OF_TIME } dl_step_unit;

extern const char *const dl_step_units[];

typedef struct dl_step_range {
    double smallest, largest;
    int unit;
    long points;  /* a decade */
    long least;   /* steps of a run */
    double bound; /* on the energy error */
} dl_step_range;

#define DL_STEP_RANGE_ROW(type, name_, kind_, member, fallback_, doc_)                             \
    .name = name_, .kind = kind_, .offset = offsetof(type, range.member), .unit = "",              \
    .fallback = fallback_, .doc = doc_

/* Rows of a table for a structure `type` with a member `range`, with those defaults. */
#define DL_STEP_RANGE_ROWS(type, smallest_, largest_, unit_, points_, least_)                      \
    {DL_STEP_RANGE_ROW(type, "smallest", DL_REAL, smallest, smallest_,                             \
                       "smallest fixed step, in the `unit`"),                                      \
     .maximum = DBL_MAX, .above_minimum = true},                                                   \
        {DL_STEP_RANGE_ROW(type, "largest", DL_REAL, largest, largest_,                            \
                           "largest fixed step, in the `unit`"),                                   \
         .maximum = DBL_MAX, .above_minimum = true},                                               \
        {DL_STEP_RANGE_ROW(type, "unit", DL_WORD, unit, unit_,                                     \
                           "frequency: 2/omega of the fastest motion at the start (where there "   \
                           "is none, the step); step: the case's, or the scene's; time: the "      \
                           "scene's own"),                                                         \
         .words = dl_step_units},                                                                  \
        {DL_STEP_RANGE_ROW(type, "points", DL_INTEGER, points, points_, "fixed steps a decade"),   \
         .minimum = 1, .maximum = 1000},                                                           \
        {DL_STEP_RANGE_ROW(type, "least", DL_INTEGER, least, least_,                               \
                           "steps that a run of fixed steps has at least, past the study's end "   \
                           "where these are too large"),                                           \
         .minimum = 1, .maximum = 1e9},                                                            \
    {                                                                                              \
        DL_STEP_RANGE_ROW(type, "bound", DL_REAL, bound, "0.1",                                    \
                          "largest energy error of a run that holds, in units of the energy "      \
                          "scale"),                                                                \
            .maximum = DBL_MAX, .above_minimum = true                                              \
    }

/* DL_INPUT where the smallest is larger than the largest. */
dl_status dl_step_range_check(const dl_step_range *range, dl_error *error);

/* The unit as a time; `step` is the case's, `omega` of the fastest motion at the start. */
double dl_step_range_unit(const dl_step_range *range, double step, double omega);

#endif
