/* Solid, liquid or gas, frame after frame: Table IV of TR299 on the temperature of its program. */
#ifndef DL_REPORT_STATE_WATCH_H
#define DL_REPORT_STATE_WATCH_H

#include "driftlab/observe.h"

typedef struct dl_state_watch {
    const dl_scene *scene;
    dl_thermometer *thermometer;
    dl_state_threshold *threshold; /* [particles] */
    double *temperature;           /* [particles] */
} dl_state_watch;

/* DL_INPUT where there is no threshold for a mass. On failure there is nothing to free. */
dl_status dl_state_watch_create(const dl_scene *scene, dl_state_watch *watch, dl_error *error);
/* Adds a frame, later than those before; state [particles]. A pinned particle is solid. */
dl_status dl_state_watch_add(dl_state_watch *watch, double time, const double *y_all,
                             dl_state *state, dl_error *error);
void dl_state_watch_free(dl_state_watch *watch);

#endif
