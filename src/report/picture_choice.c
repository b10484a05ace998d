/* What a picture takes from observation: who is solid, liquid or gas, and who has escaped. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/picture.h"
#include "report/picture_view.h"
#include "report/state_watch.h"

dl_status dl_picture_states_now(const dl_scene *scene, const double *y_all, dl_state *state,
                                dl_error *error) {
    dl_state_watch watch;
    dl_status status = dl_state_watch_create(scene, &watch, error);
    if (status)
        return status;
    status = dl_state_watch_add(&watch, 0, y_all, state, error);
    dl_state_watch_free(&watch);
    return status;
}

dl_status dl_picture_states(const dl_scene *scene, dl_frames *frames, size_t number,
                            dl_state *state, dl_error *error) {
    dl_state_watch watch;
    dl_status status = dl_state_watch_create(scene, &watch, error);
    if (status)
        return status;
    const size_t length = 2 * (size_t)scene->dimension * scene->particles;
    double *const y_all = malloc(length * sizeof *y_all);
    if (!y_all)
        status = dl_fail_memory(error, "a frame of a trajectory");
    for (size_t k = 0; k <= number && !status; k++) {
        status = dl_frames_read(frames, k, scene->dimension, y_all, error);
        /* Of two frames at one time (before and after a jump) the first counts. */
        if (!status && (k == 0 || frames->time[k] > frames->time[k - 1]))
            status = dl_state_watch_add(&watch, frames->time[k], y_all, state, error);
    }
    free(y_all);
    dl_state_watch_free(&watch);
    return status;
}

dl_status dl_picture_window_of_system(const dl_picture *picture, dl_picture_window *window,
                                      dl_error *error) {
    const dl_scene *const scene = picture->scene;
    dl_escape_rule rule = {.link = dl_escape_link(scene)};
    bool *const kept = calloc(scene->particles, sizeof *kept);
    dl_model *model = NULL;
    dl_escape escape;
    dl_status status =
        kept ? dl_model_create(scene, &model, error) : dl_fail_memory(error, "a picture");
    if (!status)
        status = dl_observe_escape(model, picture->y_all, &rule, kept, &escape, error);
    for (size_t i = 0; i < scene->particles && !status; i++)
        kept[i] = !kept[i];
    if (!status)
        *window = dl_window_of(picture, kept, 0);
    dl_model_free(model);
    free(kept);
    return status;
}

dl_status dl_picture_window_of_body(const dl_picture *picture, dl_picture_window *window,
                                    dl_error *error) {
    const dl_scene *const scene = picture->scene;
    const double link = dl_escape_link(scene);
    if (!isfinite(link))
        return dl_fail(error, DL_INPUT,
                       "window: found a pair law whose first piece never ends, expected one that "
                       "holds a body together");
    bool *const kept = calloc(scene->particles, sizeof *kept);
    dl_status status = kept ? DL_OK : dl_fail_memory(error, "a picture");
    if (!status)
        status = dl_observe_system(scene, picture->y_all, link, kept, error);
    if (!status)
        *window = dl_window_of(picture, kept, link);
    free(kept);
    return status;
}
