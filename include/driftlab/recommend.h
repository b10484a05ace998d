/* Which method reaches an error on a scene at the least cost, and with which step or tolerance:
 * measured on a run that is shortened as far as a limit on time asks for.
 *
 * Lengths. The first runs go over at most 64 of the scene's steps; later ones over the longest of
 * 1, 1/4, 1/16 ... of the whole that, by what the shorter ones have taken, stays within the limit.
 * Errors of positions are never measured past the horizon (reference.h). A method that costs more
 * than 25 times the cheapest is given up, unless that is next to nothing.
 *
 * Search. For each method the step (or tolerance) is changed by the order of its error until one
 * that reaches the asked error and one that does not are within a quarter (tolerances: neighbours
 * of 1, 2, 5, 10 ...), and until a finer one reaches it too. What is recommended was run.
 *
 * From a shortened run to the whole. The cost is proportional to the time. The energy error is
 * taken to stay where a method is symplectic or conserves energy, and to grow as t elsewhere; that
 * of positions to grow as t, elsewhere as t^2; and the error asked of the shortened run is so much
 * smaller. Where the whole run is past the horizon, or for positions more than 64 times as long,
 * or no method reached that smaller error, the one asked for is that of the shortened run, and
 * nothing is said of the whole's. */
#ifndef DRIFTLAB_RECOMMEND_H
#define DRIFTLAB_RECOMMEND_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/method.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

/* Costs nearer to each other than this factor are a tie. */
#define DL_RECOMMEND_TIE 1.2

typedef struct dl_recommend_request {
    const char *scene; /* file */
    size_t lets;
    const dl_let *let; /* [lets]: numbers of the scene */
    double error;      /* > 0 */
    const char *in;    /* "position": RMS over the particles at the end, a length; "energy": the
                        * largest, in units of its scale, ledger included */
    double end;        /* of the whole run; 0: the scene's */
    double seconds;    /* of CPU time, for all of it: what else the machine does shortens nothing */
    const char *methods;           /* names with commas between; NULL: a choice of strong ones */
    const volatile int *interrupt; /* may be NULL */
    void (*on_progress)(void *context, const char *text); /* about five times a second; or NULL */
    void *context;
} dl_recommend_request;

/* A method with one step or tolerance on the shortened run. */
typedef struct dl_recommend_point {
    char setting[96]; /* "step=0.01", "rtol=1e-07 atol=1e-11"; "": none */
    double error;     /* with the reference's own; NaN where the run does not count */
    double cpu_seconds;
    unsigned long force_evaluations, steps;
    char note[256]; /* why it does not count; "": it does */
} dl_recommend_point;

typedef struct dl_recommended {
    const dl_method_row *row;
    char variant[64]; /* an option that is fixed, "table=fehlberg-8"; "": none */
    bool reached;
    dl_recommend_point point; /* that reached it at the least cost; else that came nearest */
    dl_recommend_point coarser, finer; /* its neighbours among what was run; setting "": none */
    double target;                     /* error asked of the shortened run */
    double growth;                     /* exponent of the error in time, 0, 1 or 2 */
    double full_error, full_cpu_seconds, full_force_evaluations; /* expected of the whole run; the
                                                                  * error is NaN past the horizon */
    char command[4096]; /* line that makes the whole run; where it reached */
    char reason[512];   /* why it is left out; "" where it reached */
} dl_recommended;

typedef struct dl_recommendation {
    char scene[128], in[16];
    double error, end;
    double measured_to;     /* end of the shortened run */
    char shortened[512];    /* why it is, "" where it is the whole */
    double length;          /* mean distance of nearest neighbours; 0: not known */
    double reference_error; /* own, at the shortened run's end; NaN without a reference */
    double horizon;         /* from when on positions mean nothing; 0: not before measured_to */
    const char *part_only;  /* why the error asked for is the shortened run's only; NULL: it is
                             * not */
    size_t reached;         /* methods */
    size_t methods;
    dl_recommended *method; /* [methods]: the cheapest first, then those that did not reach it, the
                             * nearest first */
} dl_recommendation;

/* DL_OK, also where nothing reached the error (`reached` is 0). DL_INPUT for what is refused;
 * DL_INTERRUPTED, DL_MEMORY, DL_IO; the status of a reference that could not be made. Free with
 * dl_recommendation_release. */
dl_status dl_recommend(const dl_recommend_request *request, dl_recommendation *made,
                       dl_error *error);
void dl_recommendation_release(dl_recommendation *made);

#endif
