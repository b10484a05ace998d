/* What GSL's implicit steppers promise beyond the contract of every row: the order of the
 * extrapolation, and steps that only Newton's method with the right Jacobian can take. */
#include "contract.h"

static const dl_method_row *row_of(const char *name) {
    const dl_method_row *row = NULL;
    dl_error error = {""};
    if (dl_method_find(name, &row, &error))
        fail_msg("%s", error.message);
    return row;
}

/* --- order -------------------------------------------------------------------------------------
 */

static rig cluster_after(const char *name, int steps) {
    char options[64];
    snprintf(options, sizeof options, "step=%.17g", 0.5 / steps);
    rig r = rig_open(row_of(name), fixture_cluster(), options);
    rig_steps(&r, steps);
    return r;
}

/* Its errors are above roundoff with few steps alone. */
static void extrapolation_has_its_order(void **state) {
    (void)state;
    enum { points = 3, fewest = 3 };
    double step[points], error[points];
    rig exact = cluster_after("composition-8-kahan-li", 2000);
    for (int k = 0; k < points; k++) {
        rig r = cluster_after("gsl-bsimp", fewest + k);
        step[k] = r.method->step;
        error[k] = largest_difference(r.method->y, exact.method->y, r.length);
        rig_close(&r);
    }
    rig_close(&exact);
    const int order = row_of("gsl-bsimp")->order;
    const double found = fitted_order(step, error, points);
    print_message("order %.2f, errors %.1e ... %.1e\n", found, error[0], error[points - 1]);
    assert_int_equal(order, 14);
    assert_true(fabs(found - order) < 0.75);
}

/* --- stiffness ---------------------------------------------------------------------------------
 */

/* Flies the stiff crystal until `end`; its particles are where they belong. */
static unsigned long steps_of_flight(const char *name, const char *options, double end) {
    rig r = rig_open(row_of(name), fixture_stiff_crystal(1e5, 1e-4), options);
    double start[4 * 36], off = 0;
    memcpy(start, rig_state(&r), sizeof start);
    rig_run(&r, end);
    rig_state(&r);
    for (size_t i = 0; i < 72; i++)
        off = fmax(off, fabs(r.y[i] - start[i] - (i < 36 ? end : 0)));
    dl_method_stats stats;
    dl_method_stats_get(r.method, &stats);
    print_message("%-12s %-26s %4lu steps, off by %.1e\n", name, options, stats.steps, off);
    assert_true(off < 0.01);
    rig_close(&r);
    return stats.steps;
}

/* Some hundred periods of the fastest vibration. */
static void newton_takes_long_steps(void **state) {
    (void)state;
    static const char *const names[] = {"gsl-rk1imp", "gsl-rk2imp", "gsl-rk4imp"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        assert_int_equal(steps_of_flight(names[k], "step=0.05 rtol=1e-3 atol=1e-2", 2), 40);
    assert_true(steps_of_flight("gsl-msbdf", "rtol=1e-3 atol=1e-2", 2) < 50);
}

/* It follows the vibrations, by steps at which the same extrapolation without a Jacobian runs away
 * at once. */
static void extrapolation_has_its_jacobian(void **state) {
    (void)state;
    assert_int_equal(steps_of_flight("gsl-bsimp", "step=0.01", 0.3), 30);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(extrapolation_has_its_order),
        cmocka_unit_test(newton_takes_long_steps),
        cmocka_unit_test(extrapolation_has_its_jacobian),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
