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

/* With one option set to a number, and one more, "table=zonneveld-4", or none: "". */
static outcome run_lively(const char *method, const char *also, const char *key, double value) {
    dl_scene *const scene = scene_of_text(lively_box);
    const dl_method_row *const row = method_of(method);
    const size_t length = strcspn(also, "=");
    outcome came = {.increment = NAN};
    wandering w = {0};
    dl_error error = {""};
    char setting[64], name[32];
    dl_run_options how = run_options(0, 0);
    how.on_sample = add_increment;
    how.context = &w;
    snprintf(setting, sizeof setting, "%s=%.17g", key, value);
    snprintf(name, sizeof name, "%.*s", (int)length, also);
    void *const options = options_of(row, scene, setting);
    if (*also && dl_method_options_set(row, options, name, also + length + 1, &error))
        fail_msg("%s", error.message);
    if (dl_run(scene, row, options, &how, &came.summary, NULL, &error))
        fail_msg("%s with %s: %s", method, setting, error.message);
    if (came.summary.status)
        fail_msg("%s with %s: %s", method, setting, came.summary.message);
    dl_method_options_free(row, options);
    dl_scene_free(scene);
    came.increment = exp(w.logarithms / (double)w.count);
    return came;
}

typedef struct expectation {
    const char *method, *also;
    double low, high; /* of the fitted exponent */
    double largest;   /* error in the last run, of the energy's scale */
} expectation;

/* How the energy's error falls with three values of an option. */
static void check_exponent(const expectation *row, const char *key, const double value[3]) {
    double error[3];
    outcome run = {0};
    for (int i = 0; i < 3; i++) {
        run = run_lively(row->method, row->also, key, value[i]);
        error[i] = run.increment;
        assert_true(run.summary.wall_hits > 3000);
        assert_true(fabs(run.summary.ledger) > 0.1);
    }
    const double order = fitted_order(value, error, 3);
    const double largest = run.summary.energy_error_max / run.summary.energy_scale;
    print_message("%s %s: %lu hits, %.0f jumps, energy error a unit of time %.2e %.2e %.2e, as %s "
                  "to the %.2f; in all %.2e of the scale\n",
                  row->method, row->also, run.summary.wall_hits, lively_end / lively_period,
                  error[0], error[1], error[2], key, order, largest);
    if (!(order > row->low && order < row->high) || !(largest < row->largest))
        fail_msg("%s %s: exponent %g, error %g of the scale", row->method, row->also, order,
                 largest);
}

static void energy_keeps_its_order_through_hits_and_radiation(void **state) {
    (void)state;
    static const struct {
        expectation row;
        double step;
    } rows[] = {
        {{"leapfrog", "", 1.85, 2.15, 1e-4}, 1.0 / 48},
        {{"composition-4-suzuki", "", 3.7, 4.5, 1e-8}, 1.0 / 32},
        {{"composition-6-kahan-li", "", 5.6, 6.4, 1e-12}, 1.0 / 32},
        {{"gsl-rk4", "", 3.8, 4.2, 1e-9}, 1.0 / 32},
        {{"arkode-erk", "table=bogacki-shampine-3", 2.7, 3.4, 5e-5}, 1.0 / 32},
        {{"arkode-erk", "table=dormand-prince-5", 4.5, 5.4, 2e-10}, 1.0 / 32},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double h = rows[k].step;
        check_exponent(&rows[k].row, "step", (const double[]){h / 2, h / 3, h / 4});
    }
}

/* Methods that control the error of a step: their energy's error is in proportion to what is
 * allowed in one. The largest is after thousands of restarts. */
static void energy_follows_the_tolerance_through_hits_and_radiation(void **state) {
    (void)state;
    static const expectation rows[] = {
        {"arkode-erk", "atol=1e-13", 0.8, 1.2, 5e-8},
        {"gsl-rk8pd", "atol=1e-13", 0.8, 1.2, 5e-9},
        {"cvode-adams", "atol=1e-13", 0.8, 1.2, 2e-6},
        {"cvode-bdf-klu", "atol=1e-13", 0.8, 1.2, 1e-5},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        check_exponent(&rows[k], "rtol", (const double[]){1e-5, 1e-7, 1e-9});
}

static void the_conserving_scheme_conserves_through_hits_and_radiation(void **state) {
    (void)state;
    static const char *const names[] = {"conserving-fixed-point", "conserving-newton-dense"};
    for (size_t k = 0; k < 2; k++) {
        const dl_run_summary s = run_lively(names[k], "", "step", 1.0 / 32).summary;
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
    const double near = strcmp(row->name, "gsl-msbdf") == 0 ? 3e-4 : 1e-4; /* to its tolerance */
    if (!(fabs(rise - 1) < near) || !(fabs(speed - 1) < 1e-4))
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
        /* there is one force alone; and order 1 is as wrong as the time step */
        if (!(dl_method_row_at(k)->flags & DL_SPLITS_FORCE) && dl_method_row_at(k)->order != 1)
            lift_at_once(scene, dl_method_row_at(k));
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(energy_keeps_its_order_through_hits_and_radiation),
        cmocka_unit_test(energy_follows_the_tolerance_through_hits_and_radiation),
        cmocka_unit_test(the_conserving_scheme_conserves_through_hits_and_radiation),
        cmocka_unit_test(what_is_pulled_away_is_released_at_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
