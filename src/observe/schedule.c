#include "observe/schedule.h"

#include <math.h>

#include "driftlab/scene.h"

static const size_t chosen_intervals = 50;

static size_t divide_up(size_t dividend, size_t divisor) {
    return (dividend + divisor - 1) / divisor;
}

static dl_status whole_steps(const char *key, double time, double step, size_t *steps,
                             dl_error *error) {
    *steps = dl_whole_steps(time, step);
    if (*steps)
        return DL_OK;
    const double nearest = fmax(1.0, round(time / step)) * step;
    return dl_fail(error, DL_INPUT,
                   "%s: found %.15g, expected a whole number of steps of %.15g (the nearest is "
                   "%.15g)",
                   key, time, step, nearest);
}

static dl_status positive(const char *key, double time, dl_error *error) {
    if (time > 0 && isfinite(time))
        return DL_OK;
    return dl_fail(error, DL_INPUT, "%s: found %.15g, expected a time > 0", key, time);
}

static dl_status schedule_fixed(double step, dl_schedule *schedule, dl_error *error) {
    dl_status status = whole_steps("end", schedule->end, step, &schedule->steps, error);
    if (status)
        return status;
    if (schedule->interval > 0) {
        status = whole_steps("sample", schedule->interval, step, &schedule->steps_between, error);
        if (status)
            return status;
    } else {
        schedule->steps_between = divide_up(schedule->steps, chosen_intervals);
        schedule->interval = (double)schedule->steps_between * step;
    }
    schedule->samples = divide_up(schedule->steps, schedule->steps_between);
    return DL_OK;
}

static void schedule_adaptive(dl_schedule *schedule) {
    if (!(schedule->interval > 0))
        schedule->interval = schedule->end / (double)chosen_intervals;
    /* An end that is a whole number of intervals but for roundoff is one. */
    const double intervals = schedule->end / schedule->interval;
    schedule->samples = (size_t)fmax(1.0, ceil(intervals * (1 - 1e-9)));
}

dl_status dl_schedule_create(double end, double interval, double step, dl_schedule *schedule,
                             dl_error *error) {
    *schedule = (dl_schedule){.end = end, .interval = interval};
    dl_status status = positive("end", end, error);
    if (!status && interval != 0)
        status = positive("sample", interval, error);
    if (status)
        return status;
    if (step > 0)
        return schedule_fixed(step, schedule, error);
    schedule_adaptive(schedule);
    return DL_OK;
}

double dl_schedule_time(const dl_schedule *schedule, size_t sample) {
    return sample >= schedule->samples ? schedule->end : (double)sample * schedule->interval;
}

size_t dl_schedule_step(const dl_schedule *schedule, size_t sample) {
    return sample >= schedule->samples ? schedule->steps : sample * schedule->steps_between;
}
