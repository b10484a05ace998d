/* When a run is sampled: at its start, at every whole number of intervals and at its end.
 *
 * Where the method keeps a fixed step, the end and every interval are whole numbers of steps, so
 * that sampling never changes a step; only the last interval may be shorter than the others. */
#ifndef DL_OBSERVE_SCHEDULE_H
#define DL_OBSERVE_SCHEDULE_H

#include <stddef.h>
#include "driftlab/status.h"

typedef struct dl_schedule {
    double end, interval;
    size_t samples;       /* without the one at the start */
    size_t steps;         /* of the fixed step up to the end; 0: the method chooses its steps */
    size_t steps_between; /* of the fixed step from one sample to the next */
} dl_schedule;

/* `step` 0: the method chooses its own. `interval` 0: chosen, at most 50 intervals. DL_INPUT where
 * end or interval is not positive or not a whole number of steps. */
dl_status dl_schedule_create(double end, double interval, double step, dl_schedule *schedule,
                             dl_error *error);

/* Time of sample 0 ... samples: the same bits for every method that is given the same end and
 * interval. */
double dl_schedule_time(const dl_schedule *schedule, size_t sample);

/* Fixed steps done at that sample. */
size_t dl_schedule_step(const dl_schedule *schedule, size_t sample);

#endif
