#include "observe/schedule.h"

#include <math.h>

#include "driftlab/parameter.h"

static const size_t chosen_intervals = 50;

static size_t divide_up(size_t dividend, size_t divisor) {
    return (dividend + divisor - 1) / divisor;
}

/* --- times in steps ----------------------------------------------------------------------------
 */

static dl_run_time scene_end(const dl_scene *scene) {
    return (dl_run_time){.key = "end", .value = scene->end, scene->file, scene->end_line};
}

static dl_run_time scene_sample(const dl_scene *scene) {
    return (dl_run_time){.key = "sample", .value = scene->sample, scene->file, scene->sample_line};
}

/* The scene's own steps divide its times: the step that was given is at fault. */
static dl_status refuse_step(const dl_run_time *time, double step, dl_error *error) {
    char found[40], value[40];
    dl_format_real(step, found, sizeof found);
    dl_format_real(time->value, value, sizeof value);
    if (time->value / step > DL_MOST_STEPS)
        return dl_fail(error, DL_INPUT,
                       "step: found %s, expected at least %.6g: the scene's %s (%s:%d: %s) is more "
                       "than %.0f such steps",
                       found, time->value / DL_MOST_STEPS, time->key, time->file, time->line, value,
                       DL_MOST_STEPS);
    return dl_fail(error, DL_INPUT,
                   "step: found %s, expected one that divides the scene's %s (%s:%d: %s) into a "
                   "whole number of steps (the nearest is %.15g)",
                   found, time->key, time->file, time->line, value,
                   time->value / fmax(1.0, round(time->value / step)));
}

static dl_status refuse_time(const dl_run_time *time, double step, dl_error *error) {
    char found[40], each[40];
    const double ratio = time->value / step;
    dl_format_real(time->value, found, sizeof found);
    dl_format_real(step, each, sizeof each);
    if (ratio > DL_MOST_STEPS)
        return dl_fail(error, DL_INPUT, "%s: found %s, expected at most %.6g, %.0f steps of %s",
                       time->key, found, DL_MOST_STEPS * step, DL_MOST_STEPS, each);
    double nearest = fmax(1.0, round(ratio)) * step;
    if (isinf(nearest))
        nearest = floor(ratio) * step;
    return dl_fail(error, DL_INPUT,
                   "%s: found %s, expected a whole number of steps of %s (the nearest is %.15g)",
                   time->key, found, each, nearest);
}

dl_status dl_schedule_whole_steps(const dl_run_time *time, double step, size_t *steps,
                                  dl_error *error) {
    *steps = dl_whole_steps(time->value, step);
    if (*steps)
        return DL_OK;
    return time->file ? refuse_step(time, step, error) : refuse_time(time, step, error);
}

/* --- schedules ---------------------------------------------------------------------------------
 */

static dl_status positive(const dl_run_time *time, dl_error *error) {
    if (time->value > 0 && isfinite(time->value))
        return DL_OK;
    return dl_fail(error, DL_INPUT, "%s: found %.15g, expected a time > 0", time->key, time->value);
}

static dl_status schedule_fixed(const dl_run_time *end, const dl_run_time *interval, double step,
                                dl_schedule *schedule, dl_error *error) {
    dl_status status = dl_schedule_whole_steps(end, step, &schedule->steps, error);
    if (status)
        return status;
    if (interval->value > 0) {
        status = dl_schedule_whole_steps(interval, step, &schedule->steps_between, error);
        if (status)
            return status;
    } else {
        schedule->steps_between = divide_up(schedule->steps, chosen_intervals);
        schedule->interval = (double)schedule->steps_between * step;
    }
    schedule->samples = divide_up(schedule->steps, schedule->steps_between);
    return DL_OK;
}

/* More samples than can be counted: the interval's fault, or where that is the scene's, the end's.
 */
static dl_status refuse_samples(const dl_run_time *end, const dl_run_time *interval,
                                dl_error *error) {
    char ends[40], each[40];
    dl_format_real(end->value, ends, sizeof ends);
    dl_format_real(interval->value, each, sizeof each);
    if (interval->file)
        return dl_fail(error, DL_INPUT,
                       "%s: found %s, expected at most %.6g, %.0f of the scene's samples (%s:%d: "
                       "%s)",
                       end->key, ends, DL_MOST_STEPS * interval->value, DL_MOST_STEPS,
                       interval->file, interval->line, each);
    return dl_fail(error, DL_INPUT,
                   "%s: found %s, expected at least %.6g, which makes %.0f samples up to %s",
                   interval->key, each, end->value / DL_MOST_STEPS, DL_MOST_STEPS, ends);
}

static dl_status schedule_adaptive(const dl_run_time *end, const dl_run_time *interval,
                                   dl_schedule *schedule, dl_error *error) {
    if (!(interval->value > 0))
        schedule->interval = schedule->end / (double)chosen_intervals;
    const double intervals = ceil(schedule->end / schedule->interval);
    if (!(intervals <= DL_MOST_STEPS))
        return refuse_samples(end, interval, error);
    /* An end that is a whole number of intervals but for roundoff is one. */
    schedule->samples = dl_whole_steps(schedule->end, schedule->interval);
    if (schedule->samples == 0)
        schedule->samples = (size_t)fmax(1.0, intervals);
    return DL_OK;
}

static dl_status create(const dl_run_time *end, const dl_run_time *interval, double step,
                        dl_schedule *schedule, dl_error *error) {
    *schedule = (dl_schedule){.end = end->value, .interval = interval->value};
    dl_status status = positive(end, error);
    if (!status && interval->value != 0)
        status = positive(interval, error);
    if (status)
        return status;
    return step > 0 ? schedule_fixed(end, interval, step, schedule, error)
                    : schedule_adaptive(end, interval, schedule, error);
}

dl_status dl_schedule_create(double end, double interval, double step, dl_schedule *schedule,
                             dl_error *error) {
    const dl_run_time given_end = {.key = "end", .value = end};
    const dl_run_time given_interval = {.key = "sample", .value = interval};
    return create(&given_end, &given_interval, step, schedule, error);
}

dl_status dl_schedule_of_scene(const dl_scene *scene, double end, double interval, double step,
                               dl_schedule *schedule, dl_error *error) {
    const dl_run_time of_end =
        end != 0 ? (dl_run_time){.key = "end", .value = end} : scene_end(scene);
    const dl_run_time of_interval =
        interval != 0 ? (dl_run_time){.key = "sample", .value = interval} : scene_sample(scene);
    return create(&of_end, &of_interval, step, schedule, error);
}

double dl_schedule_time(const dl_schedule *schedule, size_t sample) {
    return sample >= schedule->samples ? schedule->end : (double)sample * schedule->interval;
}

size_t dl_schedule_step(const dl_schedule *schedule, size_t sample) {
    return sample >= schedule->samples ? schedule->steps : sample * schedule->steps_between;
}
