/* A trajectory in extended precision, from event to event.
 *
 * A step keeps every pair to the piece of its law that it began in, so that it is analytic however
 * the law jumps, and every resting contact. What ends it before its time is an event: a pair leaves
 * its piece, a particle hits a wall, a contact lets go. The step tells where everything goes as
 * polynomials of tau = (t - t0)/h; the first event is a root of one of these, the state there is
 * the method's own, and the next step begins behind it. */
#ifndef DL_REFERENCE_WALK_H
#define DL_REFERENCE_WALK_H

#include "driftlab/status.h"
#include "reference/extended.h"
#include "reference/extended/model.h"

typedef struct walk walk;

/* Two methods that have nothing in common but the model. */
typedef struct stepper {
    dl_status (*create)(walk *w, dl_error *error);
    /* A step of its own choice from w->q, w->v, no longer than `limit`: sets w->h, w->degree and
     * w->rate; w->q and w->v stay. */
    dl_status (*attempt)(walk *w, real limit, dl_error *error);
    /* The state at t0 + span within that step, into q and v. */
    dl_status (*state)(walk *w, real span, real *q, real *v, dl_error *error);
    void (*destroy)(walk *w);
} stepper;

struct walk {
    model model;
    pairs pairs;
    const stepper *method;
    void *data; /* the method's */
    real tolerance, stride;
    real t, *q, *v; /* [unknowns] */
    /* Resting contacts, as model/contact.h has them. */
    signed char *side;    /* [unknowns]: -1, 1: rests on the low, high wall of its axis */
    bool *pressed;        /* [unknowns]: the contact has pressed, or lasted a step */
    bool *slides;         /* [unknowns]: it has, and nothing pressed it: holds normally alone */
    signed char *touched; /* [unknowns]: scratch */
    bool *held;           /* [unknowns]: out of the dynamics */
    /* The step, or the last one. */
    bool goes_on; /* the next one continues the motion of the last */
    real h;
    int degree;
    real *
        rate; /* [(walk_degree + 1) * unknowns]: accelerations, of tau^k, as if nothing were held */
    real *path;        /* [(walk_degree + 3) * unknowns]: coordinates, of tau^k */
    real *reach;       /* [particles]: how far it goes at most */
    real *load;        /* [unknowns]: sums of the moduli of what makes up the accelerations */
    real *a, *q1, *v1; /* [unknowns]: scratch */
    /* Steps are no longer than a few times what lies between events. */
    real gap;
    real window; /* start of the time step in which `events` are counted */
    unsigned long events;
    dl_extended_counts counts;
    size_t jumps; /* radiation that has happened */
    dl_extended_limits limits;
};

enum { walk_degree = 44 };

typedef enum event_kind { EVENT_NONE, EVENT_BREAKPOINT, EVENT_WALL, EVENT_RELEASE } event_kind;

typedef struct event {
    event_kind kind;
    real tau;    /* where it is */
    real latest; /* from where on it has certainly been */
    size_t pair;
    int piece, image[3]; /* of the pair, behind it */
    size_t coordinate;
    int side;
    bool idle; /* the contact ends because nothing presses */
} event;

#define stepper_taylor     DL_TYPED(dl_extended_taylor)
#define stepper_gauss      DL_TYPED(dl_extended_gauss)
#define polynomial_exit    DL_TYPED(dl_extended_polynomial_exit)
#define polynomial_value   DL_TYPED(dl_extended_polynomial_value)
#define walk_make_path     DL_TYPED(dl_extended_make_path)
#define walk_scales        DL_TYPED(dl_extended_scales)
#define walk_find_event    DL_TYPED(dl_extended_find_event)
#define walk_event_value   DL_TYPED(dl_extended_event_value)
#define walk_meet_walls    DL_TYPED(dl_extended_meet_walls)
#define walk_collide       DL_TYPED(dl_extended_collide)
#define walk_let_go        DL_TYPED(dl_extended_let_go)
#define walk_let_slide     DL_TYPED(dl_extended_let_slide)
#define walk_contacts_last DL_TYPED(dl_extended_contacts_last)
#define walk_update_held   DL_TYPED(dl_extended_update_held)
#define walk_radiate       DL_TYPED(dl_extended_radiate)

extern const stepper stepper_taylor, stepper_gauss;

/* Polynomials c_0 + c_1 tau + ... of that degree. *latest is the first tau in [0, 1] from which on
 * it is below -tolerance, 2 where there is none; returned is the root of the polynomial itself
 * beside it. */
real polynomial_exit(const real *c, int degree, real tolerance, real *latest);
real polynomial_value(const real *c, int degree, real tau);

enum { polynomial_degree = 2 * (walk_degree + 2) };

/* w->path and w->reach from q, v and w->rate. */
void walk_make_path(walk *w);

/* What errors of a step are measured by: how far the particles are from their mean place, and how
 * fast they are relative to their mean velocity. `acceleration` is the largest. */
void walk_scales(const walk *w, real acceleration, real *length, real *speed);

/* The first event of the step; EVENT_NONE where there is none. */
event walk_find_event(walk *w);

/* What is 0 at the event, positive before it, in the state q, v; *slope is its time derivative,
 * *roundoff that of its value. */
real walk_event_value(walk *w, const event *what, const real *q, const real *v, real *slope,
                      real *roundoff);

/* Walls: where a coordinate is, what a hit does, model/contact.h and study/located.h. `target` is
 * the hit that was gone to; NULL: the state came otherwise. */
void walk_collide(walk *w, const event *target, bool at_once);
/* The state was set from outside: held coordinates that move are let go, touching ones collide. */
void walk_meet_walls(walk *w);
void walk_let_go(walk *w, size_t coordinate);
/* What nothing presses any more slides along its wall by `located`; a `mirror` lets it go. */
void walk_let_slide(walk *w, size_t coordinate);
/* All contacts have lasted a step. */
void walk_contacts_last(walk *w);
/* What is held, from `side`. */
void walk_update_held(walk *w);

/* The scheduled jump, model/radiation.c. */
void walk_radiate(walk *w);

#endif
