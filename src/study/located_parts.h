/* The parts of located walls (study/located.h) and what they share. */
#ifndef DL_STUDY_LOCATED_PARTS_H
#define DL_STUDY_LOCATED_PARTS_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "model/contact.h"
#include "study/located.h"
#include "study/path.h"

typedef struct dl_hit {
    bool found;
    double t;
    size_t u; /* coordinate */
    dl_side side;
} dl_hit;

struct dl_located {
    dl_method *method;
    dl_model *model;
    dl_observer *observer;
    dl_stopwatch *watch;
    dl_contacts contacts;
    double step; /* the scale of times: the fixed step, or else the scene's */
    unsigned long grid;
    double t0, *y0;  /* state at the start of the step, [2 n] */
    double *a0, *a1; /* accelerations, as if nothing were held, at the step's ends, [n] */
    bool a0_is_current;
    double *a_before;     /* the same at the start of the step before */
    double h_before;      /* length of that step; 0: an event has ended it, or a0 was not known */
    double *derivatives;  /* [(dl_path_degree + 1) * n]: of the coordinates, from a dense output */
    double *scratch;      /* [2 n] */
    signed char *touched; /* [n]: the dl_side at which an event has found the coordinate */
    double window;        /* start of the time step in which `events` are counted */
    unsigned long events;
    unsigned long since_start; /* steps since t0 */
    dl_located_counts counts;
};

/* --- located.c ----------------------------------------------------------------------------------
 */

/* What the representation of t can tell apart, with room for the solvers' own arithmetic. */
static inline double dl_located_resolution(double t) {
    return 8 * DBL_EPSILON * fabs(t);
}

/* The method's own state at a time within the step, into its t and y. */
dl_status dl_located_state_at(dl_located *located, double t, dl_error *error);

/* --- located_hits.c -----------------------------------------------------------------------------
 */

static const dl_side dl_located_sides[2] = {DL_HIGH_WALL,
                                            DL_LOW_WALL}; /* in the order of `mirror` */

/* Of a coordinate near its wall, with room for the arithmetic of paths. */
static inline double dl_located_roundoff(const dl_located *located, size_t u, dl_side side) {
    return 8 * DBL_EPSILON *
           (fabs(dl_wall_place(located->model, u, side)) + fabs(located->y0[u]) +
            fabs(located->method->y[u]));
}

static inline double dl_located_distance(const dl_model *model, const double *q, size_t u,
                                         dl_side side) {
    return dl_wall_away(side, q[u] - dl_wall_place(model, u, side));
}

/* Whether a coordinate may have been beyond a wall in a step of length h. */
bool dl_located_any_is_near(const dl_located *located, double h);

/* The earliest hit of the step from t0 to the method's t; a0 and a1 are current. */
dl_status dl_located_find_hit(dl_located *located, dl_hit *hit, dl_error *error);

/* Goes to the hit, and improves its time by Newton's method until the method's own state is on the
 * wall, or gets no nearer: a grazing one, whose time is not determined better. */
dl_status dl_located_go_to_hit(dl_located *located, dl_hit *hit, dl_error *error);

/* --- located_collision.c ------------------------------------------------------------------------
 */

/* Whether a coordinate is on a wall, or beyond, and not on its way in. */
bool dl_located_any_touches(const dl_located *located);

/* Every coordinate on or beyond a wall bounces or comes to rest, booked; what the booking costs is
 * not timed. `target` is the hit that was gone to, if it was found. */
dl_status dl_located_collide(dl_located *located, const dl_hit *target, dl_error *error);

/* --- located_release.c --------------------------------------------------------------------------
 */

/* Goes to where a contact ends, if one does at or before `end`: of the hit, or of the step. a0 and
 * a1 are current at t0 and there. */
dl_status dl_located_find_release(dl_located *located, double end, bool *released, dl_error *error);

/* Lets go of every contact that presses no more; a1 is the acceleration at the method's state. */
dl_status dl_located_release(dl_located *located, dl_error *error);

#endif
