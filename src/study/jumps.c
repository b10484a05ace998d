#include "study/jumps.h"

#include <math.h>

#include "observe/schedule.h"

dl_status dl_jumps_create(const dl_scene *scene, double step, dl_jumps *jumps, dl_error *error) {
    *jumps = (dl_jumps){.period = scene->radiation.present ? scene->radiation.period : 0};
    if (jumps->period == 0 || step == 0)
        return DL_OK;
    const dl_run_time period = {.key = "period of radiation",
                                .value = jumps->period,
                                .file = scene->file,
                                .line = scene->period_line};
    return dl_schedule_whole_steps(&period, step, &jumps->steps_between, error);
}

bool dl_jumps_due_at_step(const dl_jumps *jumps, size_t steps, size_t *at) {
    if (jumps->period == 0)
        return false;
    *at = (jumps->done + 1) * jumps->steps_between;
    return *at <= steps;
}

bool dl_jumps_due_at_time(const dl_jumps *jumps, double time, double *at) {
    const double roundoff = 1e-9 * jumps->period;
    if (jumps->period == 0)
        return false;
    *at = (double)(jumps->done + 1) * jumps->period;
    if (fabs(*at - time) <= roundoff)
        *at = time;
    return *at <= time;
}

static dl_status make(dl_jumps *jumps, dl_method *method, dl_error *error) {
    jumps->done++;
    return dl_model_radiate(method->model, method->y, method->y + method->n)
               ? dl_method_jumped(method, error)
               : DL_OK;
}

dl_status dl_jumps_make(dl_jumps *jumps, dl_method *method, dl_observer *observer,
                        dl_stopwatch *watch, dl_error *error) {
    dl_status status = DL_OK;
    if (observer)
        status = dl_observer_before_jump(observer, method, error);
    dl_stopwatch_start(watch);
    if (!status)
        status = make(jumps, method, error);
    dl_stopwatch_stop(watch);
    if (!status && observer)
        status = dl_observer_after_jump(observer, method, error);
    return status;
}
