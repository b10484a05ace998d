/* The parts of a recommendation: which methods, and the search for one method's step. */
#ifndef DL_STUDY_RECOMMEND_H
#define DL_STUDY_RECOMMEND_H

#include "driftlab/recommend.h"
#include "study/measure.h"

/* Times the cheapest's cost from which on a method is given up. */
#define DL_RECOMMEND_HOPELESS 25

/* --- recommend_methods.c ---------------------------------------------------------------------- */

/* Fills *made's methods, freshly allocated, from names with commas between; NULL: the choice. */
dl_status dl_recommend_methods(const char *names, dl_recommendation *made, dl_error *error);

/* --- recommend_search.c ----------------------------------------------------------------------- */

/* What is searched: a step, or a tolerance out of 1, 5, 2, 1 ... 10^-k. */
typedef struct dl_recommend_dial {
    const char *key; /* NULL: the method has neither */
    bool tolerance;
    double order; /* of the error in it */
} dl_recommend_dial;

dl_recommend_dial dl_recommend_dial_of(const dl_method_row *row);

/* A shortened run, for all methods. */
typedef struct dl_recommend_run {
    dl_study *study; /* of one scene; end, samples, limits and repeats are set for each case */
    const dl_reference *reference; /* NULL where the error is one of energy */
    const char *in;
    double end;
    size_t parts;        /* equal ones of it that whole steps must fill */
    double atol;         /* in units of rtol */
    double scale;        /* of errors: theirs times the machine's epsilon is roundoff */
    double deadline;     /* dl_recommend_clock */
    size_t methods_left; /* to be searched before then, this one included; > 0 */
    double cheapest;     /* CPU seconds of the cheapest that has reached the error; or INFINITY */
    const dl_watch *watch;
    char *current; /* [200]: what is under way */
} dl_recommend_run;

/* CPU seconds of this process and the children that it has waited for: what else the machine does
 * changes nothing. */
double dl_recommend_clock(void);

/* Sets point, neighbours and reached, or the reason. `target` is set; `start` is the step or
 * tolerance to begin with. *ended: the deadline came before an answer. DL_INTERRUPTED, DL_MEMORY,
 * DL_IO. */
dl_status dl_recommend_search(dl_recommend_run *run, dl_recommended *method, double start,
                              bool *ended, dl_error *error);

/* The step or tolerance of a point. */
double dl_recommend_value(const dl_recommend_point *point);

/* Its point again, `repeats` times for the time. */
dl_status dl_recommend_time(dl_recommend_run *run, dl_recommended *method, long repeats,
                            dl_error *error);

/* The line that runs its point to `end`. */
dl_status dl_recommend_command(dl_recommend_run *run, dl_recommended *method, double end,
                               dl_error *error);

#endif
