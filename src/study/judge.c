/* Which points are not what they claim. */
#include <math.h>
#include <stdio.h>
#include "study/measure.h"

/* An error smaller than this many times the reference's own says nothing. */
static const double resolution = 3;

void dl_study_judge(const dl_case *measured, double end, long intervals,
                    const dl_reference *reference, char *reason, size_t size) {
    const dl_run_summary *run = &measured->summary;
    reason[0] = '\0';
    if (run->status != DL_OK)
        snprintf(reason, size, "the run failed (%s): %s", dl_status_name(run->status),
                 run->message);
    else if (!(fabs(run->t_end_reached - end) <= 1e-9 * end))
        snprintf(reason, size, "the run ended at t = %.6g of %.6g", run->t_end_reached, end);
    else if (run->step > 0 && !(fabs((double)run->steps * run->step - end) <= 1e-6 * end))
        snprintf(reason, size, "%lu steps of %.6g do not make up the time %.6g", run->steps,
                 run->step, end);
    else if (run->step == 0 && run->steps <= (unsigned long)intervals)
        snprintf(reason, size,
                 "no more steps (%lu) than samples: the sampling, not the tolerance, chose them",
                 run->steps);
    else if (reference && !isfinite(measured->position_error))
        snprintf(reason, size, "no position error at the end");
    else if (reference && measured->position_error < resolution * reference->error)
        snprintf(reason, size,
                 "the position error %.2g is below three times the reference's own error %.2g",
                 measured->position_error, reference->error);
}
