/* Method, model and scene together, for tests that hold every row of the registry to the same
 * contract. */
#ifndef CONTRACT_H
#define CONTRACT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/method.h"
#include "fixture_scenes.h"

typedef struct rig {
    dl_scene *scene;
    dl_model *model;
    const dl_method_row *row;
    void *options;
    dl_method *method;
    size_t length; /* of the state: 2 unknowns */
    double *y;     /* [length]: where rig_state puts it */
} rig;

/* "key=value key=value" into options; fails the test where one is refused. */
FIXTURE void set_options(const dl_method_row *row, void *options, const char *text) {
    char copy[512];
    snprintf(copy, sizeof copy, "%s", text);
    char *rest = NULL;
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
        char *const value = strchr(word, '=');
        assert_non_null(value);
        *value = '\0';
        dl_error error = {""};
        if (dl_method_options_set(row, options, word, value + 1, &error))
            fail_msg("%s: %s", row->name, error.message);
    }
}

/* Opens a rig over `scene`, which it takes over. y0 NULL: the scene's initial state. */
FIXTURE rig rig_open_at(const dl_method_row *row, dl_scene *scene, const char *options,
                        const double *y0) {
    rig r = {.scene = scene, .row = row};
    dl_error error = {""};
    if (row->flags & DL_SPLITS_FORCE)
        fixture_split(scene);
    if (dl_model_create(scene, &r.model, &error))
        fail_msg("model: %s", error.message);
    r.length = 2 * r.model->unknowns;
    r.y = malloc(r.length * sizeof *r.y);
    assert_non_null(r.y);
    if (y0)
        memcpy(r.y, y0, r.length * sizeof *r.y);
    else
        dl_model_initial_state(r.model, r.y);
    if (dl_method_options_create(row, scene, &r.options, &error))
        fail_msg("%s: %s", row->name, error.message);
    set_options(row, r.options, options);
    if (dl_method_create(row, r.model, r.options, r.y, &r.method, &error))
        fail_msg("%s: %s", row->name, error.message);
    return r;
}

FIXTURE rig rig_open(const dl_method_row *row, dl_scene *scene, const char *options) {
    return rig_open_at(row, scene, options, NULL);
}

FIXTURE void rig_close(rig *r) {
    dl_method_destroy(r->method);
    dl_method_options_free(r->row, r->options);
    dl_model_free(r->model);
    dl_scene_free(r->scene);
    free(r->y);
}

FIXTURE void rig_step(rig *r, double t_stop) {
    dl_error error = {""};
    if (dl_method_advance(r->method, t_stop, &error))
        fail_msg("%s at t = %g: %s", r->row->name, r->method->t, error.message);
}

FIXTURE void rig_steps(rig *r, int steps) {
    for (int i = 0; i < steps; i++)
        rig_step(r, INFINITY);
}

/* To `time`: whole steps of a fixed step, stops there otherwise. */
FIXTURE void rig_run(rig *r, double time) {
    if (r->method->step > 0)
        rig_steps(r, (int)lround((time - r->method->t) / r->method->step));
    else
        while (r->method->t < time)
            rig_step(r, time);
}

FIXTURE void rig_jumped(rig *r) {
    dl_error error = {""};
    if (dl_method_jumped(r->method, &error))
        fail_msg("%s: %s", r->row->name, error.message);
}

FIXTURE const double *rig_state(rig *r) {
    dl_error error = {""};
    if (dl_method_state(r->method, r->y, &error))
        fail_msg("%s: %s", r->row->name, error.message);
    return r->y;
}

FIXTURE double largest_difference(const double *a, const double *b, size_t length) {
    double largest = 0;
    for (size_t i = 0; i < length; i++)
        largest = fmax(largest, fabs(a[i] - b[i]));
    return largest;
}

FIXTURE bool has_option(const dl_method_row *row, const char *name) {
    return dl_parameter_find(row->options, name) != NULL;
}

/* The tolerances of a row that chooses its step. */
FIXTURE const char *tolerance_options(const dl_method_row *row, char text[64], double rtol,
                                      double atol) {
    const int length = snprintf(text, 64, "rtol=%g", rtol);
    if (has_option(row, "atol"))
        snprintf(text + length, 64 - (size_t)length, " atol=%g", atol);
    return text;
}

/* What errors of rtol in each step amount to: rtol^(p/(p+1)) with order p, felt where that is low.
 */
FIXTURE double error_of(const dl_method_row *row, double rtol) {
    return row->order == 1 || row->order == 2 ? pow(rtol, row->order / (row->order + 1.0)) : rtol;
}

/* Options under which every row follows the fixtures closely: a short step, or tight tolerances
 * where the method chooses its step; less tight where they would need too many steps. */
FIXTURE const char *close_options(const dl_method_row *row, char text[64], double step,
                                  double rtol) {
    static const double least[] = {0, 1e-4, 1e-7}; /* by order */
    if (row->flags & DL_ADAPTIVE && row->order <= 2)
        rtol = fmax(rtol, least[row->order]);
    if (row->flags & DL_ADAPTIVE)
        return tolerance_options(row, text, rtol, rtol / 100);
    snprintf(text, 64, "step=%.17g", step);
    return text;
}

/* How near close_options come, for those rows; `error` for all others. */
FIXTURE double near(const dl_method_row *row, double error) {
    static const double least[] = {0, 3e-2, 1e-4};
    return row->flags & DL_ADAPTIVE && row->order <= 2 ? fmax(error, least[row->order]) : error;
}

/* Of a row whose tolerances are those of its equations, too: so tight that these are solved. */
FIXTURE const char *solved_options(const dl_method_row *row) {
    const dl_parameter *const rtol = dl_parameter_find(row->options, "rtol");
    return rtol && !rtol->when ? "rtol=1e-12 atol=1e-14" : "";
}

/* Fitted slope of log(error) over log(step). */
FIXTURE double fitted_order(const double *step, const double *error, size_t points) {
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < points; i++) {
        mean_x += log(step[i]) / (double)points;
        mean_y += log(error[i]) / (double)points;
    }
    for (size_t i = 0; i < points; i++) {
        const double x = log(step[i]) - mean_x;
        xx += x * x;
        xy += x * (log(error[i]) - mean_y);
    }
    return xy / xx;
}

/* Every row of the registry, one after the other. */
#define FOR_EACH_ROW(row)                                                                          \
    for (size_t row##_index = 0; row##_index < dl_method_count(); row##_index++)                   \
        for (const dl_method_row *row = dl_method_row_at(row##_index); row; row = NULL)

/* But those that split the force, for scenes of which all is one part. */
#define FOR_EACH_UNSPLIT_ROW(row)                                                                  \
    FOR_EACH_ROW(row)                                                                              \
    if (!(row->flags & DL_SPLITS_FORCE))

/* Nor the average of a force along the way, which ends its parts at the breakpoints itself, nor
 * what is of order 1, for which following closely takes for ever. */
#define FOR_EACH_LOCATING_ROW(row)                                                                 \
    FOR_EACH_UNSPLIT_ROW(row)                                                                      \
    if (row->order != 1 && strcmp(row->name, "conserving-average-vector-field") != 0)

#endif
