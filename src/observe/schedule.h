/* When a run is sampled: at its start, at every whole number of intervals and at its end.
 *
 * Where the method keeps a fixed step, the end and every interval are whole numbers of steps, so
 * that sampling never changes a step; only the last interval may be shorter than the others. */
#ifndef DL_OBSERVE_SCHEDULE_H
#define DL_OBSERVE_SCHEDULE_H

#include <stddef.h>
#include "driftlab/scene.h"
#include "driftlab/status.h"

typedef struct dl_schedule {
    double end, interval;
    size_t samples;       /* without the one at the start */
    size_t steps;         /* of the fixed step up to the end; 0: the method chooses its steps */
    size_t steps_between; /* of the fixed step from one sample to the next */
} dl_schedule;

/* A time that a run was given, or that its scene says. */
typedef struct dl_run_time {
    const char *key; /* "end" */
    double value;
    const char *file; /* of the scene that says it, and the line there; NULL: it was given */
    int line;
} dl_run_time;

/* Steps in `time`. DL_INPUT where they are not a whole number, or more than DL_MOST_STEPS, blames
 * the time where it was given, and the step, by the key "step", where the scene says the time. */
dl_status dl_schedule_whole_steps(const dl_run_time *time, double step, size_t *steps,
                                  dl_error *error);

/* `step` 0: the method chooses its own. `interval` 0: chosen, at most 50 intervals. DL_INPUT where
 * end or interval is not positive or not a whole number of steps, or there are more steps or
 * samples than DL_MOST_STEPS. */
dl_status dl_schedule_create(double end, double interval, double step, dl_schedule *schedule,
                             dl_error *error);

/* The same, where `end` or `interval` 0 is the scene's. */
dl_status dl_schedule_of_scene(const dl_scene *scene, double end, double interval, double step,
                               dl_schedule *schedule, dl_error *error);

/* Time of sample 0 ... samples: the same bits for every method that is given the same end and
 * interval. */
double dl_schedule_time(const dl_schedule *schedule, size_t sample);

/* Fixed steps done at that sample. */
size_t dl_schedule_step(const dl_schedule *schedule, size_t sample);

#endif
