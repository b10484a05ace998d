/* What a claim may be computed as. */
#include "study/paper_quantity.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"

/* --- registry --------------------------------------------------------------------------------- */

/* What cannot be computed has its row, with the reason. */
static dl_status measure_none(const dl_paper_claim *claim, const dl_paper_state *state,
                              double *value, dl_error *error) {
    (void)state, (void)value;
    return dl_fail(error, DL_INPUT, "%s", claim->reason);
}

static const dl_quantity quantities[] = {
    {"none", "nothing: its `reason` says why", DL_NEEDS_NOTHING, measure_none},
    {"refused", "1 where the scene's file is refused, 0 where it is a scene", DL_NEEDS_FILE,
     dl_measure_refused},
    {"particles", "number of particles", DL_NEEDS_STATE, dl_measure_particles},
    {"mass", "of all particles", DL_NEEDS_STATE, dl_measure_mass},
    {"mass-count", "particles whose mass is `row`", DL_NEEDS_STATE, dl_measure_mass_count},
    {"particle-mass", "of `particle`", DL_NEEDS_STATE, dl_measure_particle_mass},
    {"x", "coordinate of `particle`", DL_NEEDS_STATE, dl_measure_x},
    {"y", "coordinate of `particle`", DL_NEEDS_STATE, dl_measure_y},
    {"vx", "velocity of `particle`", DL_NEEDS_STATE, dl_measure_vx},
    {"vy", "velocity of `particle`", DL_NEEDS_STATE, dl_measure_vy},
    {"rest-distance", "at which the formula of the pair force is zero", DL_NEEDS_STATE,
     dl_measure_rest_distance},
    {"rotation-rows", "particles that obey TR299 (3.1) with `rate`, `perturbation` to `residual`",
     DL_NEEDS_STATE, dl_measure_rotation_rows},
    {"dark-loss",
     "percent of its kinetic energy that radiation takes on the dark side in `span` steps",
     DL_NEEDS_STATE, dl_measure_dark_loss},
    {"temperature", "of `particle`: TR299 (3.6) in its program's unit, over the 500 steps before",
     DL_NEEDS_STATE, dl_measure_temperature},
    {"gas-speed", "smallest speed that frees the first particle, TR299 Table IV (v-gas)",
     DL_NEEDS_STATE, dl_measure_gas_speed},
    {"liquid-speed", "smallest speed that exchanges the bonds, TR299 Table IV (v-liquid)",
     DL_NEEDS_STATE, dl_measure_liquid_speed},
    {"rotation", "angular velocity of the heaviest group of particles, about its own centre",
     DL_NEEDS_STATE, dl_measure_rotation},
    {"layer-least",
     "least distance of the mean heights of neighbouring layers, each of the next "
     "`span` particles from below",
     DL_NEEDS_STATE, dl_measure_layer_least},
    {"layer-most", "the same, the largest", DL_NEEDS_STATE, dl_measure_layer_most},
    {"separation-ratio", "separation.nearest_3 over rest-distance", DL_NEEDS_STATE,
     dl_measure_separation_ratio},
    {"density-trend",
     "rank correlation (Kendall's tau) of density and height in ten layers from the floor to where "
     "95 % are below, means over the frames from the one looked at on",
     DL_NEEDS_STATE, dl_measure_density_trend},
    {"density-middle", "of the same layers, the fourth to the seventh: (largest - least)/mean",
     DL_NEEDS_STATE, dl_measure_density_middle},
    {"pressure-misfit",
     "by how much p = a + b depth misses the pressure, over the miss of ln p = a + b depth, in "
     "bins of `bin` (0: 0.2) below the surface, means over frames as before",
     DL_NEEDS_STATE, dl_measure_pressure_misfit},
    {"reached", "time that the run came to", DL_NEEDS_RUN, dl_measure_reached},
    {"end", "time at which the run was to end", DL_NEEDS_RUN, dl_measure_end},
    {"steps", "steps that the run made", DL_NEEDS_RUN, dl_measure_steps},
    {"iterations", "nonlinear iterations a step", DL_NEEDS_RUN, dl_measure_iterations},
    {"energy-error", "largest error of the energy in units of its scale, jumps being booked",
     DL_NEEDS_RUN, dl_measure_energy_error},
    {"largest-vx", "of `particle`, over all frames", DL_NEEDS_RUN, dl_measure_largest_vx},
    {"revolution", "steps in which the system turns once, from `step` on", DL_NEEDS_RUN,
     dl_measure_revolution},
    {"subdivision",
     "first step at which less than two thirds of the particles are in the heaviest group",
     DL_NEEDS_RUN, dl_measure_subdivision},
};

size_t dl_quantity_count(void) {
    return sizeof quantities / sizeof *quantities;
}

const dl_quantity *dl_quantity_at(size_t index) {
    return &quantities[index];
}

/* --- columns of observables ------------------------------------------------------------------- */

static dl_status find_column(const char *name, size_t *observable, size_t *column,
                             dl_error *error) {
    char head[64];
    const char *point = strchr(name, '.');
    const size_t length = point ? (size_t)(point - name) : 0;
    if (!point || length >= sizeof head)
        return dl_fail(error, DL_INPUT,
                       "computed: found \"%.80s\", expected OBSERVABLE.COLUMN or a quantity "
                       "(driftlab help paper)",
                       name);
    memcpy(head, name, length);
    head[length] = '\0';
    dl_error reason = {""};
    if (dl_observable_find(head, observable, &reason))
        return dl_fail(error, DL_INPUT, "computed: %.900s", reason.message);
    const char *const *const columns = dl_observable_at(*observable)->column;
    for (*column = 0; columns[*column]; ++*column)
        if (strcmp(columns[*column], point + 1) == 0)
            return DL_OK;
    const char *closest = dl_closest_word(columns, point + 1);
    return dl_fail(error, DL_INPUT, "computed: found \"%.80s\", expected a column of %s%s%s%s",
                   name, head, closest ? "; did you mean \"" : "", closest ? closest : "",
                   closest ? "\"?" : "");
}

dl_status dl_quantity_find(const char *name, size_t *index, dl_error *error) {
    const char *names[sizeof quantities / sizeof *quantities + 1] = {NULL};
    for (*index = 0; *index < dl_quantity_count(); ++*index) {
        names[*index] = quantities[*index].name;
        if (strcmp(name, names[*index]) == 0)
            return DL_OK;
    }
    size_t observable, column;
    const char *closest = strchr(name, '.') ? NULL : dl_closest_word(names, name);
    return closest ? dl_fail(error, DL_INPUT, "computed: found \"%.80s\"; did you mean \"%s\"?",
                             name, closest)
                   : find_column(name, &observable, &column, error);
}

dl_status dl_quantity_find_curve(const char *name, size_t *index, dl_error *error) {
    size_t observable, column;
    dl_status status = dl_quantity_find(name, index, error);
    if (status)
        return status;
    if (*index < dl_quantity_count())
        return quantities[*index].needs == DL_NEEDS_STATE
                   ? DL_OK
                   : dl_fail(error, DL_INPUT, "found \"%s\", expected a quantity of a state", name);
    if ((status = find_column(name, &observable, &column, error)))
        return status;
    return dl_observable_at(observable)->rows == DL_ROWS_SYSTEM
               ? DL_OK
               : dl_fail(error, DL_INPUT, "found \"%s\", expected an observable of a single row",
                         name);
}

/* Temperatures remember the frames before; after ten windows nothing is left of them. */
static const double windows_remembered = 10;

static dl_status warm(const dl_paper_state *state, dl_observation *observation, dl_error *error) {
    const dl_scene *scene = state->scene;
    if (!state->frames)
        return DL_OK;
    const double *time = state->frames->time;
    const double since =
        time[state->number] - windows_remembered * DL_TEMPERATURE_STEPS * scene->step;
    double *y_all = malloc(2 * (size_t)scene->dimension * scene->particles * sizeof *y_all);
    dl_status status = y_all ? DL_OK : dl_fail_memory(error, "a state of every particle");
    for (size_t k = 0; k < state->number && !status; k++) {
        if (time[k] < since)
            continue;
        status = dl_frames_read(state->frames, k, scene->dimension, y_all, error);
        if (!status)
            status = dl_observation_warm(observation, time[k], y_all, error);
    }
    free(y_all);
    return status;
}

static dl_status pick(const dl_paper_claim *claim, const dl_observation *observation, size_t column,
                      double *value, dl_error *error) {
    dl_observed observed;
    dl_observation_get(observation, 0, &observed);
    const double near =
        1e-6 *
        (observed.rows > 1 && observed.label ? fabs(observed.label[1] - observed.label[0]) : 1);
    if (claim->total) {
        *value = 0;
        for (size_t row = 0; row < observed.rows; row++)
            *value += observed.present[row * observed.columns + column];
        return isfinite(*value) ? DL_OK : dl_fail(error, DL_INPUT, "it is not defined here");
    }
    for (size_t row = 0; row < observed.rows; row++)
        if (!observed.label || !isfinite(claim->row) ||
            fabs(observed.label[row] - claim->row) <= near) {
            *value = observed.present[row * observed.columns + column];
            return isfinite(*value) ? DL_OK : dl_fail(error, DL_INPUT, "it is not defined here");
        }
    return dl_fail(error, DL_INPUT, "row: found %.6g, which the table of %s does not have",
                   claim->row, observed.observable->name);
}

/* Of the claim's observable alone, for so many frames from the state on. */
static dl_status open_observation(const dl_paper_claim *claim, const dl_paper_state *state,
                                  size_t frames, dl_observation **observation, size_t *column,
                                  dl_error *error) {
    size_t observable;
    double lowest, highest;
    dl_observe_options how;
    dl_status status = find_column(claim->computed, &observable, column, error);
    if (status)
        return status;
    bool *wanted = calloc(dl_observable_count(), sizeof *wanted);
    if (!wanted)
        return dl_fail_memory(error, "an observation");
    wanted[observable] = true;
    dl_observe_options_default(&how);
    how.bin = claim->bin;
    dl_observe_heights(state->scene, state->y_all, &lowest, &highest);
    status = dl_observation_create(state->scene, &how, wanted, frames, lowest, highest, observation,
                                   error);
    free(wanted);
    return status;
}

static dl_status observe_now(const dl_paper_claim *claim, const dl_paper_state *state,
                             dl_observation *observation, size_t column, double *value,
                             dl_error *error) {
    const double time = state->frames ? state->frames->time[state->number] : 0;
    const dl_status status = dl_observation_add(observation, time, state->y_all, error);
    return status ? status : pick(claim, observation, column, value, error);
}

static dl_status observe(const dl_paper_claim *claim, const dl_paper_state *state, double *value,
                         dl_error *error) {
    dl_observation *observation = NULL;
    size_t column = 0;
    dl_status status = open_observation(claim, state, 1, &observation, &column, error);
    if (!status)
        status = warm(state, observation, error);
    if (!status)
        status = observe_now(claim, state, observation, column, value, error);
    dl_observation_free(observation);
    return status;
}

dl_status dl_quantity_measure_frames(const dl_paper_claim *claim, dl_paper_state *state,
                                     double *value, dl_error *error) {
    const dl_quantity *const quantity =
        claim->quantity < dl_quantity_count() ? &quantities[claim->quantity] : NULL;
    const size_t count = state->frames->count;
    dl_observation *observation = NULL;
    size_t column = 0;
    dl_status status =
        quantity ? DL_OK : open_observation(claim, state, count, &observation, &column, error);
    for (size_t k = 0; k < count && !status; k++) {
        state->number = k;
        status = dl_frames_read(state->frames, k, state->scene->dimension, state->y_all, error);
        if (!status)
            status = quantity ? quantity->measure(claim, state, &value[k], error)
                              : observe_now(claim, state, observation, column, &value[k], error);
    }
    dl_observation_free(observation);
    return status;
}

/* The state that a failed run leaves is not the one that the paper speaks of. */
static bool is_at_end(const dl_paper_source *source) {
    return source->step < 0 && !isfinite(source->time);
}

static dl_status measure_once(const dl_paper_claim *claim, const dl_paper_run_row *runs,
                              const char *folder, double *value, dl_error *error) {
    const dl_quantity *const quantity =
        claim->quantity < dl_quantity_count() ? &quantities[claim->quantity] : NULL;
    dl_paper_state state = {0};
    if (quantity && (quantity->needs == DL_NEEDS_FILE || quantity->needs == DL_NEEDS_NOTHING))
        return quantity->measure(claim, &state, value, error);
    dl_status status = dl_paper_state_open(&claim->source, runs, folder, &state, error);
    if (status)
        return status;
    if (state.run && is_at_end(&claim->source) && !(quantity && quantity->needs == DL_NEEDS_RUN))
        status = dl_quantity_check_ended(&state, error);
    if (!status)
        status = quantity ? quantity->measure(claim, &state, value, error)
                          : observe(claim, &state, value, error);
    dl_paper_state_close(&state);
    return status;
}

dl_status dl_quantity_measure(const dl_paper_claim *claim, const dl_paper_run_row *runs,
                              const char *folder, double *value, dl_error *error) {
    dl_paper_claim before = *claim;
    double first = 0;
    dl_status status = DL_OK;
    before.source.step = claim->since;
    before.source.time = INFINITY;
    if (claim->since >= 0)
        status = measure_once(&before, runs, folder, &first, error);
    if (!status)
        status = measure_once(claim, runs, folder, value, error);
    if (!status)
        *value -= first;
    return status;
}
