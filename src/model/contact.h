/* Walls with the rule `located`: what a hit does to a velocity, and resting contacts.
 *
 * A contact is a coordinate that rests on a wall. With damping > 0 the whole particle rests: it is
 * where infinitely many hits accumulate, each of which multiplies every velocity component by
 * 1 - damping. Without damping nothing is lost along the wall and only the normal coordinate is
 * held. What is held is out of the dynamics (model->held).
 *
 * Rest lasts while something presses. What nothing presses any more, and nothing pulls away, slides
 * from then on, whatever presses it later: it has normal velocity 0, so that it hits nothing, and
 * only a hit takes from a velocity. It leaves as what rests does, when it is pulled away. */
#ifndef DL_MODEL_CONTACT_H
#define DL_MODEL_CONTACT_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/model.h"

typedef enum dl_side { DL_LOW_WALL = -1, DL_NO_WALL = 0, DL_HIGH_WALL = 1 } dl_side;

/* Of coordinate u (as in q): where the wall is on that side, -INFINITY or INFINITY for none. */
double dl_wall_place(const dl_model *model, size_t u, dl_side side);

/* Component of a vector along coordinate u's axis, positive away from the wall. */
static inline double dl_wall_away(dl_side side, double component) {
    return side == DL_LOW_WALL ? component : -component;
}

/* A hit at a wall across `axis`: all of particle k's velocity components lose, the normal one turns
 * round. v [unknowns]. */
void dl_wall_rebound(const dl_model *model, double *v, size_t k, size_t axis);

typedef struct dl_contacts {
    dl_model *model;
    signed char *side; /* [unknowns]: the dl_side that the coordinate rests on */
    bool *held;        /* [unknowns]: what model->held points to while there are contacts */
    bool *pressed;     /* [unknowns]: the contact has pressed, or lasted a step */
    bool *idle;        /* [unknowns]: it has, and nothing presses it: dl_contacts_find_idle */
    bool *slides;      /* [unknowns]: it has been idle: holds the normal coordinate alone */
    size_t count;
} dl_contacts;

dl_status dl_contacts_create(dl_contacts *contacts, dl_model *model, dl_error *error);
void dl_contacts_free(dl_contacts *contacts);

/* Coordinate u comes to rest: what is held from now on gets velocity 0. `pressed`: it is pressed to
 * the wall already, not only from the next moment on. */
void dl_contacts_add(dl_contacts *contacts, size_t u, dl_side side, bool pressed, double *v);
void dl_contacts_release(dl_contacts *contacts, size_t u);

/* Coordinate u, which is in contact, lets the particle slide along its wall. */
void dl_contacts_let_slide(dl_contacts *contacts, size_t u);

/* Whether coordinate u is held. */
bool dl_contacts_hold(const dl_contacts *contacts, size_t u);

/* All contacts have lasted a step. */
void dl_contacts_last(dl_contacts *contacts);

/* Contacts that have pressed, and that nothing at all presses in the state y at the end of a step,
 * with its accelerations a, hold along the wall no more: what pressed has gone beyond its cutoff,
 * or has come to rest on the same wall, and the particle must not hang on a wall that it would fall
 * along.
 * What is about to press again (it bounces on the same wall) does not count. rate [unknowns]:
 * scratch. */
dl_status dl_contacts_find_idle(dl_contacts *contacts, const double *y, const double *a,
                                double *rate, dl_error *error);

/* The acceleration that presses coordinate u, which is in contact, to its wall; a [unknowns] is
 * that of all particles as if none were held. Negative where the rest ends: away from the wall, or
 * the least negative number for 0 where it is idle. */
double dl_contacts_press(const dl_contacts *contacts, size_t u, const double *a);

/* The least of them; INFINITY without contacts. */
double dl_contacts_least_press(const dl_contacts *contacts, const double *a);

/* a(q) as if nothing were held. Counted. */
dl_status dl_contacts_acceleration(const dl_contacts *contacts, const double *q, double *a,
                                   dl_error *error);

#endif
