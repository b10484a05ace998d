/* Events within steps, for every method: hits of walls by the rule `located`, contacts that end,
 * and pairs that cross a breakpoint of their law that is `located`. Of several the earliest comes
 * first.
 *
 * Hits. After each step the way of every coordinate near a wall is looked at as a polynomial: the
 * method's own dense output where it has one, the quintic Hermite polynomial through q, v, a of the
 * step's ends otherwise. The first time at which one leaves is found to roundoff, however often it
 * comes back within the step. The state there is the dense output's; a method without one goes back
 * to the step's start and takes a step of its own that ends at the hit, whose time is improved
 * until that state is on the wall: to roundoff, or to what t resolves. There the coordinate is put
 * exactly on the wall, the velocity is reset as in the rule `mirror` (normal component times
 * -(1 - d), the others times 1 - d), which the ledger books, and the method starts anew; a fixed
 * step is completed by a shorter one, so that grid and sample times stay.
 *
 * A step that is too long for its forces has states at times within it that follow no such path.
 * What counts is those states: a coordinate that they do not take to the wall does not hit it,
 * none is ever left beyond it, and the ledger books nothing but what hits do to velocities. Where
 * no state on the wall can be found the method starts anew from the last one before it.
 *
 * Resting contact. Under a force that presses to the wall, flights last 2 v/|a| and shrink by 1 - d
 * from bounce to bounce: they accumulate in finite time. A flight shorter than `rest` time steps,
 * or than what t and the coordinate resolve, is the last: the particle rests (model/contact.h says
 * what is held), its energy is booked. How many hits come before is therefore the
 * method's: what decides is the velocity that it has at the hit, under the acceleration there,
 * against `rest` times its step (the scene's where it chooses its steps). A ball dropped from 1 on
 * a floor with d = 0.9 makes 11 with a step of 0.01 and 13 with one of 1e-4; multistep methods,
 * which start each flight anew at order 1 and follow those smaller than atol to atol alone, make 8
 * to 11, the more the smaller atol is.
 *
 * What rests is released at the time at which the net normal force
 * turns away from the wall, or ends (what pressed has gone beyond its cutoff), found in steps of
 * the method's own; a force that turns away and back within a step is looked for where the steps'
 * ends show a dip. With d = 0 bounces do not shrink and only what is not resolved rests. A particle
 * that begins on a wall without normal velocity, pressed to it, rests from the start.
 *
 * Crossings. Pairs near such a breakpoint are locked to the side that they are on
 * (study/crossings.h), so that the step that crosses it, by which the crossing is found, is as
 * smooth as others; the square of the distance, from the same polynomials, is the path. There the
 * lock is turned over and the method starts anew, once again to roundoff: the state is on the
 * breakpoint, the pair on the new side of it. Nothing jumps but the acceleration, and the ledger
 * books nothing. A pair that grazes a breakpoint and turns back within a step crosses it twice.
 *
 * What rests has no part in the error control of methods that choose their steps: while anything
 * does, these are no longer than the scene's step. */
#ifndef DL_STUDY_LOCATED_H
#define DL_STUDY_LOCATED_H

#include "driftlab/method.h"
#include "observe/observer.h"
#include "observe/stopwatch.h"

typedef struct dl_located dl_located;

typedef struct dl_located_counts {
    unsigned long hits, contacts, releases, crossings;
    unsigned long discarded; /* steps that were taken and thrown away */
} dl_located_counts;

/* `observer` (NULL: nothing is booked) and `watch`, which does not run while it books, outlive it.
 */
dl_status dl_located_create(dl_method *method, dl_observer *observer, dl_stopwatch *watch,
                            dl_located **located, dl_error *error);
void dl_located_free(dl_located *located);

/* The state was set, or changed, by something else (it is the initial one; radiation or a mirror
 * was): particles on a wall hit it, rest on it or leave it, and pairs are on the side of their
 * breakpoints where they are. */
dl_status dl_located_restart(dl_located *located, dl_error *error);

/* One step of the method's own: a fixed one to the next time of the grid; otherwise one that ends
 * at t_stop at the latest, or at the first event in it. DL_STEP_FAILURE where events never end. */
dl_status dl_located_step(dl_located *located, double t_stop, dl_error *error);

dl_located_counts dl_located_counts_get(const dl_located *located);

#endif
