/* Quantities of a run as a whole. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "study/paper_quantity.h"

dl_status dl_measure_steps(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                           dl_error *error) {
    (void)claim, (void)error;
    *value = (double)state->run->steps;
    return DL_OK;
}

dl_status dl_measure_end(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                         dl_error *error) {
    (void)claim, (void)error;
    *value = state->run->end;
    return DL_OK;
}

dl_status dl_measure_reached(const dl_paper_claim *claim, const dl_paper_state *state,
                             double *value, dl_error *error) {
    (void)claim, (void)error;
    *value = state->run->reached;
    return DL_OK;
}

dl_status dl_quantity_check_ended(const dl_paper_state *state, dl_error *error) {
    const dl_paper_run_row *run = state->run;
    return run->status == DL_OK ? DL_OK
                                : dl_fail(error, DL_INPUT, "the run ended at t = %.6g (%s): %.800s",
                                          run->reached, dl_status_name(run->status), run->message);
}

dl_status dl_measure_iterations(const dl_paper_claim *claim, const dl_paper_state *state,
                                double *value, dl_error *error) {
    (void)claim;
    if (!state->run->steps)
        return dl_fail(error, DL_INPUT, "the run made no step");
    *value = (double)state->run->nonlinear_iterations / (double)state->run->steps;
    return DL_OK;
}

dl_status dl_measure_energy_error(const dl_paper_claim *claim, const dl_paper_state *state,
                                  double *value, dl_error *error) {
    (void)claim;
    *value = state->run->energy_error / state->run->energy_scale;
    return dl_quantity_check_ended(state, error);
}

/* Reads every frame of the segment into a state of its own. */
typedef dl_status frame_function(const dl_paper_claim *claim, const dl_scene *scene, double time,
                                 const double *y_all, double *value, dl_error *error);

static dl_status over_frames(const dl_paper_claim *claim, const dl_paper_state *state,
                             frame_function *use, double *value, dl_error *error) {
    const dl_scene *scene = state->scene;
    double *y_all = malloc(2 * (size_t)scene->dimension * scene->particles * sizeof *y_all);
    dl_status status = y_all ? DL_OK : dl_fail_memory(error, "a state of every particle");
    for (size_t k = 0; k < state->frames->count && !status; k++) {
        status = dl_frames_read(state->frames, k, scene->dimension, y_all, error);
        if (!status)
            status = use(claim, scene, state->frames->time[k], y_all, value, error);
    }
    free(y_all);
    return status;
}

static dl_status keep_largest_vx(const dl_paper_claim *claim, const dl_scene *scene, double time,
                                 const double *y_all, double *value, dl_error *error) {
    double vx = 0;
    (void)time;
    const dl_status status =
        dl_component_of(claim, scene, y_all, (size_t)scene->dimension, &vx, error);
    *value = fmax(*value, vx);
    return status;
}

dl_status dl_measure_largest_vx(const dl_paper_claim *claim, const dl_paper_state *state,
                                double *value, dl_error *error) {
    *value = -INFINITY;
    const dl_status status = dl_quantity_check_ended(state, error);
    return status ? status : over_frames(claim, state, keep_largest_vx, value, error);
}

/* Steps in which the system turns once, from the claim's step on: its angular velocity is
 * integrated over the frames; where they end before, the rest is at the mean rate until then. */
dl_status dl_measure_revolution(const dl_paper_claim *claim, const dl_paper_state *state,
                                double *value, dl_error *error) {
    static const double turn = 6.283185307179586;
    const dl_scene *scene = state->scene;
    const dl_frames *frames = state->frames;
    size_t k = state->number;
    double *y_all = malloc(2 * (size_t)scene->dimension * scene->particles * sizeof *y_all);
    double before = 0, angle = 0;
    (void)claim;
    if (!y_all)
        return dl_fail_memory(error, "a state of every particle");
    dl_status status = dl_paper_rotation(scene, state->y_all, &before, error);
    while (k + 1 < frames->count && angle < turn && !status) {
        double after = 0;
        status = dl_frames_read(state->frames, ++k, scene->dimension, y_all, error);
        if (!status)
            status = dl_paper_rotation(scene, y_all, &after, error);
        angle += 0.5 * (before + after) * (frames->time[k] - frames->time[k - 1]);
        before = after;
    }
    free(y_all);
    if (status)
        return status;
    const double elapsed = frames->time[k] - frames->time[state->number];
    if (!(angle > 0))
        return dl_fail(error, DL_INPUT, "the system does not turn counterclockwise");
    const double time = angle < turn ? elapsed * turn / angle : elapsed - (angle - turn) / before;
    *value = time / state->run->step;
    return DL_OK;
}

dl_status dl_measure_rotation(const dl_paper_claim *claim, const dl_paper_state *state,
                              double *value, dl_error *error) {
    (void)claim;
    return dl_paper_rotation(state->scene, state->y_all, value, error);
}

/* Particles in the heaviest group. */
static dl_status count_system(const dl_scene *scene, const double *y_all, bool *inside,
                              size_t *count, dl_error *error) {
    const dl_status status = dl_observe_system(scene, y_all, dl_escape_link(scene), inside, error);
    *count = 0;
    for (size_t i = 0; i < scene->particles; i++)
        *count += inside[i];
    return status;
}

dl_status dl_measure_subdivision(const dl_paper_claim *claim, const dl_paper_state *state,
                                 double *value, dl_error *error) {
    const dl_scene *scene = state->scene;
    const dl_frames *frames = state->frames;
    double *y_all = malloc(2 * (size_t)scene->dimension * scene->particles * sizeof *y_all);
    bool *inside = calloc(scene->particles, sizeof *inside);
    dl_status status = y_all && inside ? DL_OK : dl_fail_memory(error, "groups of particles");
    size_t k = 0, count = scene->particles;
    (void)claim;
    for (; k < frames->count && !status && 3 * count >= 2 * scene->particles; k++) {
        status = dl_frames_read(state->frames, k, scene->dimension, y_all, error);
        if (!status)
            status = count_system(scene, y_all, inside, &count, error);
    }
    free(inside);
    free(y_all);
    if (status)
        return status;
    if (3 * count >= 2 * scene->particles)
        return dl_fail(error, DL_INPUT, "it does not subdivide by step %ld",
                       frames->step[frames->count - 1]);
    *value = (double)frames->step[k - 1];
    return DL_OK;
}
