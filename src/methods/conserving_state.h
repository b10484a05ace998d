/* The state of a conserving method: places and velocities that lose nothing by being added to, in
 * the frame of the mass centre where the scene is Galilean-invariant, so that their last digits are
 * those of the internal motion and not of the stream. */
#ifndef DL_METHODS_CONSERVING_STATE_H
#define DL_METHODS_CONSERVING_STATE_H

#include "driftlab/method.h"

typedef struct dl_conserving_state {
    size_t n;
    double *q, *v;           /* [n] each, in the frame */
    double *q_lost, *v_lost; /* what their sums have rounded off (compensated.h) */
    double *kept;            /* [4 n]: all of these, to go back to */
    double *shown;           /* [2 n]: what the method's y was set to last */
    double frame[3];         /* velocity of the frame */
    double frame_start;      /* time at which the frame's origin was the scene's */
} dl_conserving_state;

dl_status dl_conserving_state_create(dl_conserving_state *state, size_t n, dl_error *error);
void dl_conserving_state_free(dl_conserving_state *state);

/* Takes over the method's y, which was changed from outside, or is new. Where the frame is the
 * scene's, components that are as they were shown keep what they had lost. */
void dl_conserving_state_take(dl_conserving_state *state, const dl_method *method);
/* Sets the method's y to the state at its t, in the scene's frame. */
void dl_conserving_state_show(dl_conserving_state *state, dl_method *method);

/* The step of length h with mean acceleration a: q += h v + (h^2/2) a, v += h a. */
void dl_conserving_state_step(dl_conserving_state *state, double h, const double *a);

void dl_conserving_state_keep(dl_conserving_state *state);
void dl_conserving_state_go_back(dl_conserving_state *state);

#endif
