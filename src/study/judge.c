/* Which points are not what they claim. */
#include <math.h>
#include <stdio.h>
#include "driftlab/reference.h"
#include "study/measure.h"

/* An adaptive run stops at every sample. With fewer steps than this many an interval, it is the
 * sampling that chose a good part of them. */
static const unsigned long steps_between_samples = 3;

/* An event that is located, of which a hit may be one, cuts a step in two. */
static bool steps_make_up(const dl_run_summary *run, double end) {
    const double time = (double)run->steps * run->step;
    const unsigned long events = run->wall_hits + run->contacts + run->releases + run->crossings;
    return time >= end * (1 - 1e-6) && time <= end * (1 + 1e-6) + (double)events * run->step;
}

void dl_study_judge_run(const dl_case *measured, double end, long intervals, char *reason,
                        size_t size) {
    const dl_run_summary *run = &measured->summary;
    reason[0] = '\0';
    if (run->status != DL_OK)
        return;
    if (!(fabs(run->t_end_reached - end) <= 1e-9 * end))
        snprintf(reason, size, "the run ended at t = %.6g of %.6g", run->t_end_reached, end);
    else if (run->step > 0 && !steps_make_up(run, end))
        snprintf(reason, size, "%lu steps of %.6g do not make up the time %.6g", run->steps,
                 run->step, end);
    else if (run->step == 0 && run->steps < steps_between_samples * (unsigned long)intervals)
        snprintf(reason, size,
                 "%lu steps for %ld samples, at each of which it stops: the sampling, not the "
                 "tolerance, chose them",
                 run->steps, intervals);
}

void dl_study_judge_position(const dl_case *measured, const dl_reference *reference, char *reason,
                             size_t size) {
    const dl_run_summary *run = &measured->summary;
    reason[0] = '\0';
    if (run->status != DL_OK)
        snprintf(reason, size, "the run failed (%s): %s", dl_status_name(run->status),
                 run->message);
    else if (reference && !isfinite(measured->position_error))
        snprintf(reason, size, "no position error at the end");
    else if (reference && reference->horizon > 0 && reference->horizon <= run->t_end_reached)
        snprintf(reason, size,
                 "the end, t = %.6g, is past the horizon, t = %.4g: position errors there "
                 "mean nothing",
                 run->t_end_reached, reference->horizon);
    else if (reference && measured->position_error < DL_REFERENCE_MARGIN * reference->error)
        snprintf(reason, size,
                 "the position error %.2g is below a hundred times the reference's own error %.2g",
                 measured->position_error, reference->error);
}
