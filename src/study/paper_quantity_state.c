/* Quantities of a scene's file and of a state. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "force/law.h"
#include "study/paper_quantity.h"

dl_status dl_measure_refused(const dl_paper_claim *claim, const dl_paper_state *state,
                             double *value, dl_error *error) {
    dl_scene *scene = NULL;
    dl_error reason = {""};
    (void)state;
    const dl_status status = dl_scene_read(claim->source.path, &scene, &reason);
    dl_scene_free(scene);
    if (status && status != DL_INPUT)
        return dl_fail(error, status, "%s", reason.message);
    *value = status == DL_INPUT;
    /* Why it was refused is worth a place in the report. */
    if (status)
        dl_fail(error, DL_OK, "%s", reason.message);
    return DL_OK;
}

dl_status dl_measure_particles(const dl_paper_claim *claim, const dl_paper_state *state,
                               double *value, dl_error *error) {
    (void)claim, (void)error;
    *value = (double)state->scene->particles;
    return DL_OK;
}

dl_status dl_measure_mass(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                          dl_error *error) {
    (void)claim, (void)error;
    *value = 0;
    for (size_t i = 0; i < state->scene->particles; i++)
        *value += state->scene->inertia[i];
    return DL_OK;
}

dl_status dl_measure_mass_count(const dl_paper_claim *claim, const dl_paper_state *state,
                                double *value, dl_error *error) {
    (void)error;
    *value = 0;
    for (size_t i = 0; i < state->scene->particles; i++)
        *value += state->scene->inertia[i] == claim->row;
    return DL_OK;
}

dl_status dl_measure_particle_mass(const dl_paper_claim *claim, const dl_paper_state *state,
                                   double *value, dl_error *error) {
    if (claim->particle > (long)state->scene->particles)
        return dl_fail(error, DL_INPUT, "particle: found %ld, expected at most %zu",
                       claim->particle, state->scene->particles);
    *value = state->scene->inertia[claim->particle - 1];
    return DL_OK;
}

dl_status dl_component_of(const dl_paper_claim *claim, const dl_scene *scene, const double *y_all,
                          size_t block, double *value, dl_error *error) {
    const size_t n = scene->particles;
    if (claim->particle > (long)n)
        return dl_fail(error, DL_INPUT, "particle: found %ld, expected at most %zu",
                       claim->particle, n);
    *value = y_all[block * n + (size_t)claim->particle - 1];
    return DL_OK;
}

dl_status dl_measure_x(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                       dl_error *error) {
    return dl_component_of(claim, state->scene, state->y_all, 0, value, error);
}

dl_status dl_measure_y(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                       dl_error *error) {
    return dl_component_of(claim, state->scene, state->y_all, 1, value, error);
}

dl_status dl_measure_vx(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                        dl_error *error) {
    return dl_component_of(claim, state->scene, state->y_all, (size_t)state->scene->dimension,
                           value, error);
}

dl_status dl_measure_vy(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                        dl_error *error) {
    return dl_component_of(claim, state->scene, state->y_all, (size_t)state->scene->dimension + 1,
                           value, error);
}

/* Where the first piece's force changes its sign, from repulsion to attraction. */
dl_status dl_measure_rest_distance(const dl_paper_claim *claim, const dl_paper_state *state,
                                   double *value, dl_error *error) {
    dl_law law;
    double near = 1e-6, far = 1e6;
    (void)claim;
    /* The law's own pieces end before it may: the distance is that of the formula. */
    dl_pair_law formula = state->scene->law;
    formula.pieces = formula.pieces > 0;
    formula.piece[0].until = INFINITY;
    formula.piece[0].end = DL_END_HARD;
    dl_law_prepare(&formula, &law);
    if (!formula.pieces || !(dl_law_force_over_r(&law, near * near) > 0) ||
        !(dl_law_force_over_r(&law, far * far) < 0))
        return dl_fail(error, DL_INPUT,
                       "the pair force does not turn from repulsion to attraction");
    while (far - near > 1e-14 * far) {
        const double middle = sqrt(near * far);
        if (!(middle > near && middle < far))
            break;
        *(dl_law_force_over_r(&law, middle * middle) > 0 ? &near : &far) = middle;
    }
    *value = near;
    return DL_OK;
}

/* TR299 (3.1): v_x = -rate y + s m/2000 perturbation and v_y = rate x + s' m/2000 perturbation for
 * signs s, s'; the printed rule's quadrants are those of a counterclockwise rotation. */
dl_status dl_measure_rotation_rows(const dl_paper_claim *claim, const dl_paper_state *state,
                                   double *value, dl_error *error) {
    static const double reference_mass = 2000;
    const dl_scene *scene = state->scene;
    const size_t n = scene->particles;
    const double *y = state->y_all;
    if (scene->dimension != 2)
        return dl_fail(error, DL_INPUT, "a rotation (3.1) needs a scene in 2 dimensions");
    *value = 0;
    for (size_t i = 0; i < n; i++) {
        const double kick = scene->inertia[i] / reference_mass * claim->perturbation;
        const double x_miss = fabs(fabs(y[2 * n + i] + claim->rate * y[n + i]) - kick);
        const double y_miss = fabs(fabs(y[3 * n + i] - claim->rate * y[i]) - kick);
        *value += fmax(x_miss, y_miss) <= claim->residual;
    }
    return DL_OK;
}

/* Kinetic energy that a particle on the dark side loses in `span` steps, in percent. */
dl_status dl_measure_dark_loss(const dl_paper_claim *claim, const dl_paper_state *state,
                               double *value, dl_error *error) {
    const dl_radiation *radiation = &state->scene->radiation;
    if (!radiation->present)
        return dl_fail(error, DL_INPUT, "the scene does not radiate");
    const double times = (double)claim->span * state->scene->step / radiation->period;
    *value = 100 * (1 - pow(radiation->factor_below, 2 * times));
    return DL_OK;
}

/* Mean of (3.4) over the 500 steps before, in the unit of TR299's program, which is Table IV's. */
dl_status dl_measure_temperature(const dl_paper_claim *claim, const dl_paper_state *state,
                                 double *value, dl_error *error) {
    const dl_scene *scene = state->scene;
    const size_t n = scene->particles, last = state->frames ? state->number : 0;
    dl_thermometer *thermometer = NULL;
    if (claim->particle > (long)n)
        return dl_fail(error, DL_INPUT, "particle: found %ld, expected at most %zu",
                       claim->particle, n);
    double *y_all = malloc(2 * (size_t)scene->dimension * n * sizeof *y_all);
    double *temperature = malloc(n * sizeof *temperature);
    dl_status status = y_all && temperature
                           ? dl_thermometer_create(scene, &dl_temperature_published,
                                                   DL_TEMPERATURE_STEPS, &thermometer, error)
                           : dl_fail_memory(error, "temperatures");
    for (size_t k = 0; k <= last && state->frames && !status; k++) {
        status = dl_frames_read(state->frames, k, scene->dimension, y_all, error);
        if (!status)
            status = dl_thermometer_add(thermometer, state->frames->time[k], y_all, error);
    }
    if (!status && !state->frames)
        status = dl_thermometer_add(thermometer, 0, state->y_all, error);
    if (!status) {
        dl_thermometer_read(thermometer, temperature);
        *value = temperature[claim->particle - 1] * dl_temperature_published.unit /
                 dl_temperature_program.unit;
    }
    dl_thermometer_free(thermometer);
    free(temperature);
    free(y_all);
    return status;
}

dl_status dl_measure_gas_speed(const dl_paper_claim *claim, const dl_paper_state *state,
                               double *value, dl_error *error) {
    (void)claim;
    return dl_paper_gas_speed(state->scene, value, error);
}

dl_status dl_measure_liquid_speed(const dl_paper_claim *claim, const dl_paper_state *state,
                                  double *value, dl_error *error) {
    (void)claim;
    return dl_paper_liquid_speed(state->scene, value, error);
}
