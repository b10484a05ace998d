#include "methods/conserving_state.h"

#include <stdlib.h>
#include <string.h>

#include "methods/compensated.h"

dl_status dl_conserving_state_create(dl_conserving_state *state, size_t n, dl_error *error) {
    *state = (dl_conserving_state){.n = n};
    double **const halves[] = {&state->q, &state->v, &state->q_lost, &state->v_lost};
    for (size_t k = 0; k < sizeof halves / sizeof *halves; k++)
        *halves[k] = calloc(n + 1, sizeof(double));
    state->kept = calloc(4 * n + 1, sizeof(double));
    state->shown = calloc(2 * n + 1, sizeof(double));
    return state->q && state->v && state->q_lost && state->v_lost && state->kept && state->shown
               ? DL_OK
               : dl_fail_memory(error, "the conserving scheme's state");
}

void dl_conserving_state_free(dl_conserving_state *state) {
    double *const arrays[] = {state->q,      state->v,    state->q_lost,
                              state->v_lost, state->kept, state->shown};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
}

static void set_frame(dl_conserving_state *state, const dl_method *method) {
    const dl_model *const model = method->model;
    double momentum[3] = {0, 0, 0}, angular[3];
    if (dl_model_is_galilean_invariant(model))
        dl_model_momentum(model, method->y, momentum, angular);
    const double inertia = dl_model_inertia(model);
    for (size_t c = 0; c < 3; c++)
        state->frame[c] = inertia > 0 ? momentum[c] / inertia : 0;
    state->frame_start = method->t;
}

void dl_conserving_state_take(dl_conserving_state *state, const dl_method *method) {
    const size_t n = state->n, moving = method->model->moving;
    const double *const y = method->y;
    set_frame(state, method);
    for (size_t c = 0; c < (size_t)method->model->dimension; c++)
        for (size_t i = c * moving; i < (c + 1) * moving; i++) {
            const bool moves = state->frame[c] != 0;
            if (moves || y[i] != state->shown[i]) {
                state->q[i] = y[i];
                state->q_lost[i] = 0;
            }
            if (moves || y[n + i] != state->shown[n + i]) {
                state->v[i] = y[n + i] - state->frame[c];
                state->v_lost[i] = 0;
            }
        }
    memcpy(state->shown, y, 2 * n * sizeof *y);
}

void dl_conserving_state_show(dl_conserving_state *state, dl_method *method) {
    const size_t n = state->n, moving = method->model->moving;
    for (size_t c = 0; c < (size_t)method->model->dimension; c++) {
        const double shift = state->frame[c] * (method->t - state->frame_start);
        for (size_t i = c * moving; i < (c + 1) * moving; i++) {
            method->y[i] = state->q[i] + shift;
            method->y[n + i] = state->v[i] + state->frame[c];
        }
    }
    memcpy(state->shown, method->y, 2 * n * sizeof *state->shown);
}

void dl_conserving_state_step(dl_conserving_state *state, double h, const double *a) {
    for (size_t i = 0; i < state->n; i++) {
        const double way = h * state->v[i] + h * h / 2 * a[i];
        dl_compensated_add(&state->q[i], &state->q_lost[i], way);
        dl_compensated_add(&state->v[i], &state->v_lost[i], h * a[i]);
    }
}

void dl_conserving_state_keep(dl_conserving_state *state) {
    const double *const halves[] = {state->q, state->v, state->q_lost, state->v_lost};
    for (size_t k = 0; k < 4; k++)
        memcpy(state->kept + k * state->n, halves[k], state->n * sizeof *state->kept);
}

void dl_conserving_state_go_back(dl_conserving_state *state) {
    double *const halves[] = {state->q, state->v, state->q_lost, state->v_lost};
    for (size_t k = 0; k < 4; k++)
        memcpy(halves[k], state->kept + k * state->n, state->n * sizeof *state->kept);
}
