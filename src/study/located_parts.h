/* The parts of located events (study/located.h) and what they share. */
#ifndef DL_STUDY_LOCATED_PARTS_H
#define DL_STUDY_LOCATED_PARTS_H

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>

#include "model/contact.h"
#include "study/crossings.h"
#include "study/located.h"
#include "study/path.h"

/* A pause: nothing happens, but the method's own states left the step's paths, and it starts anew.
 */
typedef enum dl_event_kind { DL_NO_EVENT, DL_PAUSE, DL_HIT, DL_CROSSING } dl_event_kind;

typedef struct dl_event {
    dl_event_kind kind;
    double t;
    size_t which;   /* coordinate of a hit; watched pair of a crossing */
    dl_side side;   /* wall; end of the pair's range */
    double copy[3]; /* of the pair, in a periodic box: what is taken off its separation */
} dl_event;

struct dl_located {
    dl_method *method;
    dl_model *model;
    dl_observer *observer;
    dl_stopwatch *watch;
    dl_contacts contacts;
    dl_crossings crossings; /* all 0 where none are located */
    double step;            /* the scale of times: the fixed step, or else the scene's */
    unsigned long grid;
    double t0, *y0;  /* state at the start of the step, [2 n] */
    double *a0, *a1; /* accelerations, as if nothing were held, at the step's ends, [n] */
    bool a0_is_current;
    double *a_before;     /* the same at the start of the step before */
    double h_before;      /* length of that step; 0: an event has ended it, or a0 was not known */
    double *derivatives;  /* [(dl_dense_degree + 1) * n]: of the coordinates, from a dense output */
    double *scratch;      /* [2 n] */
    signed char *touched; /* [n]: the dl_side at which an event has found the coordinate */
    double window;        /* start of the time step in which `events` are counted */
    double halfway;       /* when half as many as are allowed had been counted */
    unsigned long events;
    unsigned long pauses;      /* in a row, without an event between */
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

/* *event becomes `found`, at the part `exit` of the step, where that comes before it. */
static inline void dl_located_take_if_earlier(const dl_located *located, double exit,
                                              dl_event found, dl_event *event) {
    const double end = located->method->t;
    found.t = exit < 1 ? located->t0 + exit * (end - located->t0) : end;
    if (exit <= 1 && (event->kind == DL_NO_EVENT || found.t < event->t))
        *event = found;
}

/* The derivatives of the dense output at the end of the step, and its degree; nothing where the
 * method has none. */
dl_status dl_located_take_derivatives(dl_located *located, int *degree, dl_error *error);

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

/* Nearer than this it is on its wall at the method's state, where it has that rate: roundoff, and
 * what t resolves. */
static inline double dl_located_slack(const dl_located *located, size_t u, dl_side side,
                                      double rate) {
    return dl_located_roundoff(located, u, side) +
           fabs(rate) *
               fmax(dl_located_resolution(located->method->t), DBL_EPSILON * located->step);
}

static inline double dl_located_distance(const dl_model *model, const double *q, size_t u,
                                         dl_side side) {
    return dl_wall_away(side, q[u] - dl_wall_place(model, u, side));
}

/* Whether a coordinate may have been beyond a wall in a step of length h. */
bool dl_located_any_is_near(const dl_located *located, double h);

/* The earliest hit of the step from t0 to the method's t, in the place of *event where it comes
 * before that; a0 and a1 are current. `degree` is that of the derivatives. */
void dl_located_find_hit(dl_located *located, int degree, dl_event *event);

/* Goes to the hit, whose time is improved by Newton's method, kept within a bracket, until the
 * method's own state is on the wall, to roundoff or to what t resolves. The state at the method's t
 * is the one that is known to come after. Where the method's states do not reach the wall, or jump
 * over it, the hit becomes a pause, at a time at which the coordinate is inside. */
dl_status dl_located_go_to_hit(dl_located *located, dl_event *hit, dl_error *error);

/* Whether a coordinate is beyond a wall at the method's state, by more than roundoff: it has hit
 * the wall before, which becomes *event. */
bool dl_located_has_hit_before(const dl_located *located, dl_event *event);

/* --- located_crossings.c ------------------------------------------------------------------------
 */

/* The state was set or changed: all pairs are looked at. */
dl_status dl_located_watch_anew(dl_located *located, dl_error *error);

/* After a step: whatever may have crossed in it is watched. */
dl_status dl_located_watch_step(dl_located *located, dl_error *error);

/* Whether any watched pair may have crossed in the step: those are marked. */
bool dl_located_any_may_cross(dl_located *located);

/* The earliest crossing of the step, as dl_located_find_hit; without dense output a0 and a1 are
 * current. */
void dl_located_find_crossing(dl_located *located, int degree, dl_event *event);

/* Goes to the crossing and improves its time until the pair is on the breakpoint. */
dl_status dl_located_go_to_crossing(dl_located *located, dl_event *crossing, dl_error *error);

/* As dl_located_has_hit_before, for pairs. */
bool dl_located_has_crossed_before(const dl_located *located, dl_event *event);

/* The locks of the pair, and of every other that crosses there too, are turned over. */
dl_status dl_located_cross(dl_located *located, const dl_event *crossing, dl_error *error);

/* --- located_collision.c ------------------------------------------------------------------------
 */

/* Whether a coordinate is on a wall, or beyond, and not on its way in. */
bool dl_located_any_touches(const dl_located *located);

/* Every coordinate on or beyond a wall bounces or comes to rest, booked; what the booking costs is
 * not timed. `target` is the hit that was gone to, if there was one. */
dl_status dl_located_collide(dl_located *located, const dl_event *target, dl_error *error);

/* --- located_release.c --------------------------------------------------------------------------
 */

/* Goes to where a contact ends, if one does at or before `end`: of the hit, or of the step. a0 and
 * a1 are current at t0 and there. */
dl_status dl_located_find_release(dl_located *located, double end, bool *released, dl_error *error);

/* Lets go of every contact that presses no more; a1 is the acceleration at the method's state. */
dl_status dl_located_release(dl_located *located, dl_error *error);

#endif
