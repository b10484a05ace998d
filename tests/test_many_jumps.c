/* Thousands of located hits and hundreds of radiation jumps in one run, and a contact that ends
 * where it begins. */
#include "contract.h"
#include "fixture_runs.h"

#include "driftlab/model.h"
#include "study/located.h"

static const double lively_end = 600, lively_period = 0.25;

/* Three balls go up and down between floor and ceiling, each between two pinned ones that repel it,
 * as they do one another. Walls take a little of every velocity and radiation gives back as much,
 * so that it goes on for ever, with the same energy whatever the step. */
static const char lively_box[] =
    "name: lively-box\n"
    "dimension: 2\n"
    "particles:\n"
    "  - {at: [0, 0.52], pinned: true}\n"
    "  - {at: [1.5, 0.47], pinned: true}\n"
    "  - {at: [3, 0.5], pinned: true}\n"
    "  - {at: [4.5, 0.54], pinned: true}\n"
    "  - {at: [0.8, 0.3], velocity: [0.1, 2]}\n"
    "  - {at: [2.25, 0.45], velocity: [-0.1, 2.1], mass: 1.25}\n"
    "  - {at: [3.7, 0.6], velocity: [0.1, 2.2], mass: 1.5}\n"
    "pair_law: [{terms: [{coefficient: 0.3, power: 2}]}]\n"
    "walls: {y: [0, 1], damping: 5.0e-4, rule: located}\n"
    "radiation: {period: 0.25, beyond: 0.05, factor_above: 1.0004, factor_below: 1.0001}\n"
    "time: {step: 0.015625, end: 600, sample: 1}\n";

/* By how much the error of the energy changes from one sample to the next, the geometric mean: in a
 * run of many hits a mean over many numbers, where the error itself is one sum of them. */
typedef struct wandering {
    double last, logarithms;
    size_t count;
} wandering;

static dl_status add_increment(void *context, const dl_sample *sample, dl_error *error) {
    wandering *const w = context;
    (void)error;
    if (sample->index > 0 && sample->energy_error != w->last) {
        w->logarithms += log(fabs(sample->energy_error - w->last));
        w->count++;
    }
    w->last = sample->energy_error;
    return DL_OK;
}

typedef struct outcome {
    dl_run_summary summary;
    double increment; /* geometric mean, between samples */
} outcome;

static outcome run_lively(const char *method, double step) {
    dl_scene *const scene = scene_of_text(lively_box);
    char setting[40];
    wandering w = {0};
    snprintf(setting, sizeof setting, "step=%.17g", step);
    dl_run_options how = run_options(0, 0);
    how.on_sample = add_increment;
    how.context = &w;
    finished run = run_with(scene, method_of(method), setting, &how);
    if (run.summary.status)
        fail_msg("%s with %s: %s", method, setting, run.summary.message);
    free(run.y);
    dl_scene_free(scene);
    return (outcome){run.summary, exp(w.logarithms / (double)w.count)};
}

static void energy_keeps_its_order_through_hits_and_radiation(void **state) {
    (void)state;
    static const struct {
        const char *method;
        double step, low, high; /* of the fitted order */
        double largest;         /* error with the shortest step, of the energy's scale */
    } rows[] = {
        {"leapfrog", 1.0 / 48, 1.85, 2.15, 1e-4},
        {"composition-4-suzuki", 1.0 / 32, 3.7, 4.5, 1e-8},
        {"composition-6-kahan-li", 1.0 / 32, 5.6, 6.4, 1e-12},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        double step[3], error[3];
        outcome run = {0};
        for (int i = 0; i < 3; i++) {
            step[i] = rows[k].step / (i + 2);
            run = run_lively(rows[k].method, step[i]);
            error[i] = run.increment;
            assert_true(run.summary.wall_hits > 3000);
        }
        const double order = fitted_order(step, error, 3);
        const double largest = run.summary.energy_error_max / run.summary.energy_scale;
        print_message("%s: %lu hits, %.0f jumps, energy error a unit of time %.2e %.2e %.2e, order "
                      "%.2f; in all %.2e of the scale\n",
                      rows[k].method, run.summary.wall_hits, lively_end / lively_period, error[0],
                      error[1], error[2], order, largest);
        if (!(order > rows[k].low && order < rows[k].high) || !(largest < rows[k].largest))
            fail_msg("%s: order %g, error %g of the scale", rows[k].method, order, largest);
    }
}

static void the_conserving_scheme_conserves_through_hits_and_radiation(void **state) {
    (void)state;
    static const char *const names[] = {"conserving-fixed-point", "conserving-newton-dense"};
    for (size_t k = 0; k < 2; k++) {
        const dl_run_summary s = run_lively(names[k], 1.0 / 32).summary;
        print_message("%s: %lu hits, ledger %g, energy error %.2e of the scale\n", names[k],
                      s.wall_hits, s.ledger, s.energy_error_max / s.energy_scale);
        assert_true(s.wall_hits > 3000 && fabs(s.ledger) > 0.1);
        assert_true(s.energy_error_max <= 1e-13 * s.energy_scale);
    }
}

/* --- a contact that ends where it begins -------------------------------------------------------
 */

/* A ball rests on the floor; a body that attracts it is put above it, from outside. */
static const char magnet[] = "name: magnet\n"
                             "dimension: 2\n"
                             "particles:\n"
                             "  - {at: [0, 0]}\n"
                             "  - {at: [-3, 1], inertia: 1.0e18, coupling: 1, gravity: false}\n"
                             "pair_law: [{terms: [{coefficient: -12, power: 2}]}]\n"
                             "gravity: [0, -9.81]\n"
                             "walls: {y: [0, none], damping: 0.5, rule: located}\n"
                             "time: {step: 0.001953125, end: 1}\n";

static void step_to(dl_located *located, const dl_method *method, double end) {
    while (method->t < end * (1 - 1e-12))
        assert_int_equal(dl_located_step(located, end, NULL), DL_OK);
}

static void lift_at_once(const dl_scene *scene, const dl_method_row *row) {
    void *const options = options_of(row, scene, "");
    dl_model *model = NULL;
    dl_method *method = NULL;
    dl_located *located = NULL;
    dl_stopwatch watch = {0};
    double y[8];
    const double h = scene->step, lift = 12 - 9.81;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    dl_model_initial_state(model, y);
    assert_int_equal(dl_method_create(row, model, options, y, &method, NULL), DL_OK);
    assert_int_equal(dl_located_create(method, NULL, &watch, &located, NULL), DL_OK);
    assert_int_equal(dl_located_restart(located, NULL), DL_OK);
    step_to(located, method, 4 * h);
    assert_int_equal(dl_located_counts_get(located).contacts, 1);
    assert_true(method->y[0] == 0 && method->y[2] == 0);
    method->y[1] = 0; /* the body's x */
    assert_int_equal(dl_method_jumped(method, NULL), DL_OK);
    assert_int_equal(dl_located_restart(located, NULL), DL_OK);
    step_to(located, method, 5 * h);
    assert_int_equal(dl_located_counts_get(located).releases, 1);
    assert_int_equal(dl_located_counts_get(located).hits, 0);
    const double rise = method->y[2] / (lift * h * h / 2), speed = method->y[6] / (lift * h);
    if (!(fabs(rise - 1) < 1e-4) || !(fabs(speed - 1) < 1e-4))
        fail_msg("%s: rises by %.9g, with %.9g of what a release at once gives", row->name, rise,
                 speed);
    dl_located_free(located);
    dl_method_destroy(method);
    dl_model_free(model);
    dl_method_options_free(row, options);
}

static void what_is_pulled_away_is_released_at_once(void **state) {
    (void)state;
    dl_scene *const scene = scene_of_text(magnet);
    for (size_t k = 0; k < dl_method_count(); k++)
        lift_at_once(scene, dl_method_row_at(k));
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_keeps_its_order_through_hits_and_radiation),
        cmocka_unit_test(the_conserving_scheme_conserves_through_hits_and_radiation),
        cmocka_unit_test(what_is_pulled_away_is_released_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
