/* The pairs that are watched for crossing a breakpoint whose crossings are located: those within a
 * margin of one, by a list that holds until a particle may have moved half of it. Each is locked to
 * the side that it is on (model/locks.h), so that a step can go past the crossing smoothly, and is
 * so until the crossing's event turns the lock over: whatever roundoff makes of its distance there,
 * the pair is on the new side from then on. A pair that leaves the margin is let go. */
#ifndef DL_STUDY_CROSSINGS_H
#define DL_STUDY_CROSSINGS_H

#include <stdbool.h>
#include <stddef.h>
#include "force/cells.h"
#include "model/contact.h"
#include "model/locks.h"

/* The ends of a lock's range are told apart like walls: DL_LOW_WALL is the nearer, DL_HIGH_WALL the
 * farther one. */
typedef struct dl_watched {
    dl_side came; /* end through which the pair came last; DL_NO_WALL: it was there when found */
    bool is_near; /* it may have crossed in that step */
    int returns;  /* at once through the end that it came through, in a row */
    double since; /* time at which it came */
} dl_watched;

typedef struct dl_watch_list {
    dl_lock *lock;
    dl_watched *watched;
    size_t count, capacity;
} dl_watch_list;

typedef struct dl_crossings {
    dl_model *model;
    dl_locks locks; /* what model->locks points to: those of `now` */
    dl_watch_list now, before;
    double nearest, farthest; /* breakpoints that are located */
    double margin;
    double *origin; /* [unknowns]: q where the list was built */
    dl_cells cells;
    dl_list list;
} dl_crossings;

/* Nothing is watched yet. Free also where this fails. */
dl_status dl_crossings_create(dl_crossings *crossings, dl_model *model, dl_error *error);
void dl_crossings_free(dl_crossings *crossings);

/* Builds the list at q. Pairs that were watched stay locked as they were; `anew`, because q was
 * changed from outside: only those on a breakpoint, to roundoff, do. */
dl_status dl_crossings_watch(dl_crossings *crossings, const double *q, double margin, bool anew,
                             dl_error *error);

/* Margin that a list built at `origin` needs for a step of length h between the states y0 and y1
 * [2 * unknowns]: twice the longest way of a particle from there. */
double dl_crossings_margin(const dl_crossings *crossings, const double *origin, const double *y0,
                           const double *y1, double h);

/* --- one pair -----------------------------------------------------------------------------------
 * Separation and its rate, r_i - r_j and v_i - v_j, at a state y. */

typedef struct dl_separation {
    double d[3], rate[3];
} dl_separation;

/* Of the copies at their place; take off what dl_nearest_copy says, or the lock. */
dl_separation dl_separation_at(const dl_model *model, const dl_lock *lock, const double *y);
/* What the nearest copy lies away from d; 0 where the scene is not periodic. */
void dl_nearest_copy(const dl_model *model, const double d[3], double copy[3]);

/* What can be told apart of the square of its distance. */
double dl_separation_roundoff(const dl_model *model, const dl_lock *lock, const double *y);

/* The pair has gone through that end of its range, as that copy: it is locked to what is there. */
void dl_crossings_pass(dl_crossings *crossings, size_t which, dl_side side, const double copy[3]);

#endif
