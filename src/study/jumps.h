/* Scheduled jumps of a run: radiation, at whole numbers of its period after the start.
 *
 * They happen at exact times for every method: with a fixed step the period is a whole number of
 * steps; a method that chooses its steps is stopped there. A jump at the time of a sample, or of
 * the end, comes before it. */
#ifndef DL_STUDY_JUMPS_H
#define DL_STUDY_JUMPS_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/method.h"
#include "observe/observer.h"
#include "observe/stopwatch.h"

typedef struct dl_jumps {
    double period;        /* 0: there are none */
    size_t steps_between; /* of the fixed step; 0: the method chooses its steps */
    size_t done;
} dl_jumps;

/* `step` 0: the method chooses its own. DL_INPUT where the period is no whole number of steps. */
dl_status dl_jumps_create(const dl_scene *scene, double step, dl_jumps *jumps, dl_error *error);

/* Whether the next jump comes after `steps` fixed steps, or before; if so *at is its step. */
bool dl_jumps_due_at_step(const dl_jumps *jumps, size_t steps, size_t *at);

/* The same for times. A jump that is at `time` but for roundoff is at `time`. */
bool dl_jumps_due_at_time(const dl_jumps *jumps, double time, double *at);

/* The next jump happens now: the method's velocities change, the method is told, the observer (may
 * be NULL) books the difference, which is not timed. */
dl_status dl_jumps_make(dl_jumps *jumps, dl_method *method, dl_observer *observer,
                        dl_stopwatch *watch, dl_error *error);

#endif
