/* Rows that only ever choose their own step have no step map of which order and defects could be
 * measured. What their runs show instead: the accuracy that a tolerance promises, and that what
 * their flags do not claim is not there. And for every row: a pair force that is no number. */
#include "contract.h"
#include "model/private.h"

/* Every row without a fixed step: CVODE's ten and GSL's two multistep methods, and ARKODE's
 * relaxation where SUNDIALS has it. */
#define FOR_EACH_STEPLESS_ROW(row)                                                                 \
    FOR_EACH_ROW(row)                                                                              \
    if (!(row->flags & DL_FIXED_STEP))

enum { fewest_rows = 12 };

static const dl_method_row *row_of(const char *name) {
    const dl_method_row *row = NULL;
    assert_int_equal(dl_method_find(name, &row, NULL), DL_OK);
    return row;
}

/* --- once round an orbit ------------------------------------------------------------------------
 */

enum { length = 8, half = length / 2, orbits = 9, points = 9 };

static const double period = 6.283185307179586477;

/* Of the fitted errors: steps and orders are chosen anew on each orbit and for each tolerance, so
 * that a single error tells little. */
static double eccentricity_of(int orbit) {
    return 0.2 + 0.025 * orbit;
}

static double tolerance_of(int point) {
    return pow(10, -5 - point / 2.0);
}

/* Where fixture_kepler begins. */
static void pericentre(double eccentricity, double y[length]) {
    dl_scene *const scene = fixture_kepler(eccentricity);
    dl_model *model = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    dl_model_initial_state(model, y);
    dl_model_free(model);
    dl_scene_free(scene);
}

/* From y for a period, into y. */
static void go_round(const dl_method_row *row, const char *options, double y[length]) {
    rig r = rig_open_at(row, fixture_kepler(0), options, y);
    rig_run(&r, period);
    memcpy(y, rig_state(&r), length * sizeof *y);
    rig_close(&r);
}

static void turn(double y[length]) {
    for (size_t i = half; i < length; i++)
        y[i] *= -1;
}

/* Errors after a period, which ends where it began, and after the way back from there. */
static void go_and_return(const dl_method_row *row, int orbit, int point, double *there,
                          double *back) {
    double start[length], y[length];
    char options[64];
    tolerance_options(row, options, tolerance_of(point), tolerance_of(point) / 100);
    pericentre(eccentricity_of(orbit), start);
    memcpy(y, start, sizeof y);
    go_round(row, options, y);
    *there = largest_difference(y, start, length);
    turn(y);
    go_round(row, options, y);
    turn(y);
    *back = largest_difference(y, start, length);
}

typedef struct mean_errors {
    double there, both; /* geometric means over the orbits: of the ways there, and of both ways */
    double back, least; /* of the ways back; the least of any way */
} mean_errors;

static mean_errors errors_at(const dl_method_row *row, int point) {
    mean_errors mean = {1, 1, 1, INFINITY};
    for (int orbit = 0; orbit < orbits; orbit++) {
        double there, back;
        go_and_return(row, orbit, point, &there, &back);
        mean.there *= pow(there, 1.0 / orbits);
        mean.back *= pow(back, 1.0 / orbits);
        mean.least = fmin(mean.least, fmin(there, back));
    }
    mean.both = sqrt(mean.there * mean.back);
    return mean;
}

/* Errors are nearly in proportion to the tolerance: as rtol^(k/(k+1)) for a method that keeps to
 * order k, which is 5 for BDF here and grows as the tolerance falls for Adams. Returning leaves an
 * error like that of the way there: nothing is undone, as all is by a time-symmetric method. */
static void errors_follow_the_tolerance_both_ways(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_STEPLESS_ROW(row) {
        assert_false(row->flags & DL_TIME_SYMMETRIC);
        double rtol[points], error[points], ratio = 1;
        for (int point = 0; point < points; point++) {
            const mean_errors mean = errors_at(row, point);
            rtol[point] = tolerance_of(point);
            error[point] = mean.both;
            ratio *= pow(mean.back / mean.there, 1.0 / points);
            if (!(mean.least > 1e-10 && mean.both > 5 * rtol[point] &&
                  mean.both < 5e3 * rtol[point]))
                fail_msg("%s: error %g at rtol %g, or %g where it is least", row->name, mean.both,
                         rtol[point], mean.least);
        }
        const double slope = fitted_order(rtol, error, points);
        print_message("%-24s slope %.3f, errors %.1e ... %.1e, back %.2f times those there\n",
                      row->name, slope, error[0], error[points - 1], ratio);
        const bool bdf = strstr(row->name, "bdf");
        if (!(slope > (bdf ? 0.75 : 0.65) && slope < (bdf ? 0.98 : 1.05)))
            fail_msg("%s: errors go as the tolerance to the %g", row->name, slope);
        if (!(ratio > 0.2 && ratio < 5))
            fail_msg("%s: errors of the way back are %g times those there", row->name, ratio);
        rows++;
    }
    assert_true(rows >= fewest_rows);
}

/* --- the area of a loop -------------------------------------------------------------------------
 */

enum { corners = 48 };

/* sum over coordinates of inertia times the integral of v dq round a closed curve through these
 * states, its derivative that of the trigonometric polynomial through them. */
static double action(double loop[corners][length]) {
    static const double inertia[2] = {0.75, 0.25};
    double sum = 0;
    for (int i = 0; i < corners; i++)
        for (int j = 0; j < corners; j++) {
            if (i == j)
                continue;
            const double weight = ((i - j) % 2 ? -0.5 : 0.5) / tan((i - j) * period / 2 / corners);
            for (size_t c = 0; c < half; c++)
                sum += weight * inertia[c % 2] * loop[i][half + c] * loop[j][c];
        }
    return sum * period / corners;
}

/* By how much a period changes that of a small loop at the pericentre, in parts of what it was. */
static double area_defect(const dl_method_row *row, const char *options) {
    const double radius = 0.005;
    double loop[corners][length];
    for (int k = 0; k < corners; k++) {
        pericentre(0.3, loop[k]);
        const double angle = k * period / corners;
        for (size_t c = 0; c < half; c++) {
            loop[k][c] += radius * cos(angle) * (c % 2 ? 1 : -1);
            loop[k][half + c] += radius * sin(angle) * (c % 2 ? 1 : -1);
        }
    }
    const double before = action(loop);
    for (int k = 0; k < corners; k++)
        go_round(row, options, loop[k]);
    return fabs(action(loop) / before - 1);
}

static double energy_defect(const dl_method_row *row, const char *options) {
    rig r = rig_open(row, fixture_kepler(0.3), options);
    dl_energy start, end;
    assert_int_equal(dl_model_energy(r.model, rig_state(&r), &start, NULL), DL_OK);
    rig_run(&r, period);
    assert_int_equal(dl_model_energy(r.model, rig_state(&r), &end, NULL), DL_OK);
    rig_close(&r);
    return fabs(end.total / start.total - 1);
}

/* The exact flow keeps both, and a symplectic method the action, however large its errors; a method
 * without a step map keeps neither, but for the energy where its row says so. */
static void area_and_energy_are_kept_as_claimed(void **state) {
    (void)state;
    const dl_method_row *const leapfrog = row_of("leapfrog");
    double start[length], y[length];
    pericentre(0.3, start);
    memcpy(y, start, sizeof y);
    go_round(leapfrog, "step=0.02", y);
    const double kept = area_defect(leapfrog, "step=0.02");
    print_message("%-24s area %.1e, error %.1e\n", leapfrog->name, kept,
                  largest_difference(y, start, length));
    assert_true(kept < 1e-11 && largest_difference(y, start, length) > 1e-4);
    int rows = 0;
    FOR_EACH_STEPLESS_ROW(row) {
        assert_false(row->flags & DL_SYMPLECTIC);
        const bool claimed = row->flags & DL_CONSERVES_ENERGY;
        char options[64];
        tolerance_options(row, options, 1e-4, 1e-6);
        const double area = area_defect(row, options), energy = energy_defect(row, options);
        print_message("%-24s area %.1e, energy %.1e\n", row->name, area, energy);
        if (!(area > 1e-4 && (claimed ? energy < 1e-12 : energy > 1e-5)))
            fail_msg("%s: area off by %g, energy by %g, and the flag says %s", row->name, area,
                     energy, claimed ? "it stays" : "it does not");
        rows++;
    }
    assert_true(rows >= fewest_rows);
}

/* --- momenta ------------------------------------------------------------------------------------
 */

/* A linear multistep method keeps what is linear in y and invariant, as the momentum is, wherever
 * it takes its steps. So does any iterate of a fixed-point iteration, and of Newton's method with a
 * Jacobian that is factorised; these leave the momentum with errors of theirs. */
static bool solver_keeps_linear(const dl_method_row *row) {
    return !strstr(row->name, "-krylov") && !strstr(row->name, "-diagonal");
}

/* Largest changes of the momenta of a free cluster, in parts of the particles' own. */
static void momentum_defects(const dl_method_row *row, double rtol, double *linear,
                             double *angular) {
    char options[64];
    double before[2][3], after[2][3], scale[2];
    rig r = rig_open(row, fixture_cluster(), tolerance_options(row, options, rtol, rtol / 100));
    dl_model_momentum(r.model, rig_state(&r), before[0], before[1]);
    dl_model_momentum_scales(r.model, r.y, &scale[0], &scale[1]);
    rig_run(&r, 0.5);
    dl_model_momentum(r.model, rig_state(&r), after[0], after[1]);
    rig_close(&r);
    *linear = largest_difference(before[0], after[0], 3) / scale[0];
    *angular = largest_difference(before[1], after[1], 3) / scale[1];
}

static void check_momenta(const dl_method_row *row, double rtol) {
    const bool claimed = row->flags & DL_CONSERVES_MOMENTUM;
    const double allowed = claimed || solver_keeps_linear(row) ? 1e-14 : 500 * rtol;
    double linear, angular;
    momentum_defects(row, rtol, &linear, &angular);
    print_message("%-24s rtol %.0e: linear %.1e, angular %.1e\n", row->name, rtol, linear, angular);
    if (!(linear < allowed))
        fail_msg("%s: linear momentum off by %g", row->name, linear);
    if (claimed ? !(angular < 1e-13) : !(angular > 1e-11))
        fail_msg("%s: angular momentum off by %g, and the flag says %s", row->name, angular,
                 claimed ? "it stays" : "it does not");
}

static void linear_momentum_alone_stays(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_STEPLESS_ROW(row) {
        check_momenta(row, 1e-3);
        check_momenta(row, 1e-5);
        check_momenta(row, 1e-7);
        rows++;
    }
    assert_true(rows >= fewest_rows);
}

/* --- a force that is no number ------------------------------------------------------------------
 */

/* The pair law of the model and of its parts gives NaN at every distance, or does no longer. */
static void poison_law(dl_model *model, double *kept, bool poison) {
    dl_law *const law = model->priv->law;
    if (poison)
        *kept = law->coefficient[0][0];
    law->coefficient[0][0] = poison ? NAN : *kept;
}

static struct {
    dl_status (*acceleration)(dl_model *model, const double *q, double *a, dl_error *error);
    dl_status (*discrete)(dl_model *model, const double *q, const double *delta, double *a,
                          dl_error *error);
    dl_status (*part)(dl_model *model, dl_part part, const double *q, double *a, dl_error *error);
    double kept[3];   /* coefficients, of the whole and of the parts */
    int calls_before; /* of a force, until one that meets the poisoned law; -1: none does */
    bool met;
} planted;

static void poison(dl_model *model, bool on) {
    poison_law(model, &planted.kept[0], on);
    for (int part = 0; part < 2; part++)
        if (model->priv->part[part])
            poison_law(model->priv->part[part], &planted.kept[1 + part], on);
}

/* Whether this call of a force is the one. */
static bool is_due(void) {
    if (planted.calls_before < 0 || planted.calls_before-- > 0)
        return false;
    planted.met = true;
    return true;
}

static bool poison_if_due(dl_model *model) {
    const bool due = is_due();
    if (due)
        poison(model, true);
    return due;
}

static void cure(dl_model *model, bool due) {
    if (due)
        poison(model, false);
}

static dl_status once_acceleration(dl_model *model, const double *q, double *a, dl_error *error) {
    const bool due = poison_if_due(model);
    const dl_status status = planted.acceleration(model, q, a, error);
    cure(model, due);
    return status;
}

static dl_status once_discrete(dl_model *model, const double *q, const double *delta, double *a,
                               dl_error *error) {
    const bool due = poison_if_due(model);
    const dl_status status = planted.discrete(model, q, delta, a, error);
    cure(model, due);
    return status;
}

static dl_status once_part(dl_model *model, dl_part part, const double *q, double *a,
                           dl_error *error) {
    const bool due = poison_if_due(model);
    const dl_status status = planted.part(model, part, q, a, error);
    cure(model, due);
    return status;
}

/* One force is no number, after so many that are. */
static void plant_once(rig *r, int calls_before) {
    dl_model *const model = r->model;
    planted.acceleration = model->acceleration;
    planted.discrete = model->discrete_acceleration;
    planted.part = model->part_acceleration;
    planted.calls_before = calls_before;
    planted.met = false;
    model->acceleration = once_acceleration;
    model->discrete_acceleration = once_discrete;
    model->part_acceleration = once_part;
}

static rig cluster_under_way(const dl_method_row *row, int steps) {
    char options[64];
    rig r = rig_open(row, fixture_cluster(), close_options(row, options, 0.0005, 1e-9));
    for (int i = 0; i < steps; i++)
        rig_step(&r, 0.05);
    return r;
}

/* Looks at the method's y: a leap-frog's state at whole steps takes a force. */
static void assert_finite(const rig *r) {
    for (size_t i = 0; i < r->length; i++)
        if (!isfinite(r->method->y[i]))
            fail_msg("%s: component %zu of the state is no number", r->row->name, i);
}

/* A step that finds another way, or ends saying why and leaves the state as it was. Returns whether
 * it did that. */
static bool check_step(rig *r) {
    double before[6 * 13];
    memcpy(before, r->method->y, sizeof before);
    const double t = r->method->t;
    dl_error error = {""};
    const dl_status status = dl_method_advance(r->method, 0.05, &error);
    assert_finite(r);
    if (!status) {
        assert_true(r->method->t > t);
        return false;
    }
    if (status != DL_UNSTABLE || !strstr(error.message, "is not finite"))
        fail_msg("%s: status %s, \"%s\"", r->row->name, dl_status_name(status), error.message);
    assert_true(r->method->t == t);
    assert_memory_equal(r->method->y, before, sizeof before);
    return true;
}

static void forces_that_stay_nan_end_the_run(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        for (int steps = 0; steps <= 4; steps += 4) {
            rig r = cluster_under_way(row, steps);
            poison(r.model, true);
            for (int k = 0; k < 2; k++)
                if (!check_step(&r))
                    fail_msg("%s: a step under no force", row->name);
            poison(r.model, false);
            rig_step(&r, 0.05);
            assert_finite(&r);
            rig_close(&r);
        }
    }
}

/* Where an undisturbed run is. */
static void undisturbed(const dl_method_row *row, double time, double y[6 * 13]) {
    rig r = cluster_under_way(row, 0);
    rig_run(&r, time);
    memcpy(y, rig_state(&r), r.length * sizeof *y);
    rig_close(&r);
}

static void one_nan_is_reported_or_gone_round(void **state) {
    (void)state;
    static const int calls[] = {0, 1, 2, 3, 5, 8, 13};
    const double end = 0.05;
    FOR_EACH_ROW(row) {
        double expected[6 * 13];
        int met = 0;
        undisturbed(row, end, expected);
        for (size_t k = 0; k < sizeof calls / sizeof *calls; k++) {
            rig r = cluster_under_way(row, 3);
            plant_once(&r, calls[k]);
            const bool failed = check_step(&r);
            if (failed && !planted.met)
                fail_msg("%s: fails without a cause", row->name);
            met += planted.met;
            planted.calls_before = -1;
            rig_run(&r, end);
            assert_finite(&r);
            const double difference = largest_difference(rig_state(&r), expected, r.length);
            if (!(difference < near(row, 1e-6)))
                fail_msg("%s: off by %g after a force that was no number", row->name, difference);
            rig_close(&r);
        }
        assert_true(met > 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_follow_the_tolerance_both_ways),
        cmocka_unit_test(area_and_energy_are_kept_as_claimed),
        cmocka_unit_test(linear_momentum_alone_stays),
        cmocka_unit_test(forces_that_stay_nan_end_the_run),
        cmocka_unit_test(one_nan_is_reported_or_gone_round),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
