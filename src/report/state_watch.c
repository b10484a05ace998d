#include "report/state_watch.h"

#include <math.h>
#include <stdlib.h>

static const size_t averaged = 500; /* steps: TR299's M */

static dl_status find_thresholds(dl_state_watch *watch, dl_error *error) {
    const dl_scene *const scene = watch->scene;
    dl_status status = DL_OK;
    for (size_t i = 0; i < scene->particles && !status; i++) {
        if (scene->pinned[i])
            watch->threshold[i] = (dl_state_threshold){.liquid = INFINITY, .gas = INFINITY};
        else
            status = dl_state_threshold_at(&dl_tr299_table4, scene->inertia[i],
                                           &watch->threshold[i], error);
    }
    return status;
}

dl_status dl_state_watch_create(const dl_scene *scene, dl_state_watch *watch, dl_error *error) {
    *watch = (dl_state_watch){.scene = scene};
    watch->threshold = calloc(scene->particles, sizeof *watch->threshold);
    watch->temperature = calloc(scene->particles, sizeof *watch->temperature);
    dl_status status = watch->threshold && watch->temperature
                           ? find_thresholds(watch, error)
                           : dl_fail_memory(error, "states of particles");
    if (!status)
        status = dl_thermometer_create(scene, &dl_temperature_program, averaged,
                                       &watch->thermometer, error);
    if (status)
        dl_state_watch_free(watch);
    return status;
}

dl_status dl_state_watch_add(dl_state_watch *watch, double time, const double *y_all,
                             dl_state *state, dl_error *error) {
    const dl_status status = dl_thermometer_add(watch->thermometer, time, y_all, error);
    if (status)
        return status;
    dl_thermometer_read(watch->thermometer, watch->temperature);
    for (size_t i = 0; i < watch->scene->particles; i++)
        state[i] = dl_observe_state(&watch->threshold[i], watch->temperature[i]);
    return DL_OK;
}

void dl_state_watch_free(dl_state_watch *watch) {
    dl_thermometer_free(watch->thermometer);
    free(watch->threshold);
    free(watch->temperature);
    *watch = (dl_state_watch){0};
}
