/* Every method converges to the exact solution as fast as it says it does. */
#include "contract.h"

static const double kepler_eccentricity = 0.3, kepler_end = 2;

/* fixture_kepler's state at time t: x0 x1 y0 y1 vx0 vx1 vy0 vy1. */
static void kepler_exact(double t, double y[8]) {
    const double e = kepler_eccentricity, b = sqrt(1 - e * e);
    double anomaly = t;
    for (int i = 0; i < 50; i++)
        anomaly -= (anomaly - e * sin(anomaly) - t) / (1 - e * cos(anomaly));
    const double rate = 1 / (1 - e * cos(anomaly));
    const double relative[4] = {cos(anomaly) - e, b * sin(anomaly), -sin(anomaly) * rate,
                                b * cos(anomaly) * rate};
    for (int k = 0; k < 4; k++) {
        y[2 * k] = -0.25 * relative[k];
        y[2 * k + 1] = 0.75 * relative[k];
    }
}

static double kepler_error(const dl_method_row *row, const char *options) {
    rig r = rig_open(row, fixture_kepler(kepler_eccentricity), options);
    rig_run(&r, kepler_end);
    double exact[8];
    kepler_exact(r.method->t, exact);
    const double error = largest_difference(rig_state(&r), exact, 8);
    rig_close(&r);
    return error;
}

/* --- fixed steps -------------------------------------------------------------------------------
 */

static const double cluster_end = 0.5;

static rig cluster_after(const dl_method_row *row, int steps, const char *more_options) {
    char options[128];
    snprintf(options, sizeof options, "step=%.17g %s", cluster_end / steps, more_options);
    rig r = rig_open(row, fixture_cluster(), options);
    rig_steps(&r, steps);
    rig_state(&r);
    return r;
}

static rig cluster_reference(void) {
    const dl_method_row *row;
    assert_int_equal(dl_method_find("composition-8-kahan-li", &row, NULL), DL_OK);
    return cluster_after(row, 1000, "");
}

enum { points = 4 };

/* The step shrinks until the error comes near roundoff, so that each error is about a quarter of
 * the one before; the last of them give the order, clear of the first omitted terms. */
static double found_order(const dl_method_row *row, int order, const char *more_options,
                          const rig *reference) {
    const bool solved = *solved_options(row); /* equations leave errors of their own */
    const double largest = order > 1 ? 1e-3 : 0.1, smallest = solved      ? 5e-10
                                                              : order < 8 ? 5e-12
                                                                          : 4e-13;
    double step[points], error[points];
    int found_points = 0, steps = 0;
    for (double finer = solved ? 32 : 8; finer <= 2048; finer *= pow(2, fmin(1, 2.0 / order))) {
        if ((int)lround(finer) == steps)
            continue;
        steps = (int)lround(finer);
        rig r = cluster_after(row, steps, more_options);
        const double now = largest_difference(r.y, reference->y, r.length);
        rig_close(&r);
        if (now < smallest)
            break;
        step[found_points % points] = cluster_end / steps;
        error[found_points % points] = now;
        found_points += now < largest;
    }
    assert_true(found_points >= points);
    const double found = fitted_order(step, error, points);
    print_message("%-34s %-24s order %.3f\n", row->name, more_options, found);
    return found;
}

static void check_order(const dl_method_row *row, int order, const char *more_options,
                        const rig *reference) {
    const double found = found_order(row, order, more_options, reference);
    if (!(fabs(found - order) <= 0.25))
        fail_msg("%s %s: order %g, expected %d", row->name, more_options, found, order);
}

/* Methods of still higher order have a test of their own: steps at which the terms they omit first
 * are alone leave nothing of their errors here. */
static const int highest_order = 10;

static void converges_with_its_order(void **state) {
    (void)state;
    int rows = 0;
    rig reference = cluster_reference();
    FOR_EACH_ROW(row) {
        if (row->order > 0 && row->order <= highest_order && (row->flags & DL_FIXED_STEP)) {
            check_order(row, row->order, solved_options(row), &reference);
            rows++;
        }
    }
    rig_close(&reference);
    assert_true(rows >= 10);
}

/* Tables of SUNDIALS 6.7 and later whose errors of the first order omitted are near roundoff where
 * those of the next still show. */
static bool first_terms_are_small(const char *word) {
    static const char *const words[] = {"verner-9-stages-6", "verner-9", "tsitouras-5"};
    for (size_t k = 0; k < sizeof words / sizeof *words; k++)
        if (strcmp(word, words[k]) == 0)
            return true;
    return false;
}

/* Every table of coefficients has the order that its name ends in. */
static void check_tables(const dl_method_row *row, const rig *reference, int least) {
    const dl_parameter *const table = dl_parameter_find(row->options, "table");
    int tables = 0;
    for (; table->words[tables]; tables++) {
        const char *const word = table->words[tables];
        char option[96];
        snprintf(option, sizeof option, "table=%s %s%s", word, solved_options(row),
                 has_option(row, "substeps") ? "substeps=3" : "");
        const int order = atoi(strrchr(word, '-') + 1);
        if (first_terms_are_small(word)) {
            const double found = found_order(row, order, option, reference);
            assert_true(found > order - 0.4 && found < order + 1.25);
        } else {
            check_order(row, order, option, reference);
        }
    }
    assert_true(tables >= least);
}

static void tables_have_their_order(void **state) {
    (void)state;
    rig reference = cluster_reference();
    FOR_EACH_ROW(row) {
        if (has_option(row, "table") && row->flags & DL_FIXED_STEP)
            check_tables(row, &reference, row->flags & DL_SPLITS_FORCE ? 5 : 12);
    }
    rig_close(&reference);
}

/* --- tolerances --------------------------------------------------------------------------------
 */

/* What is left of an error that can fall no further. */
static const double roundoff_error = 1e-13;

/* A hundredth of the tolerance makes a smaller error each time, a millionth one ten thousand times
 * smaller, and the error in tolerances stays within bounds. */
static void check_tolerance(const dl_method_row *row, const char *more_options) {
    double before = INFINITY, first = 0;
    for (double rtol = 1e-4; rtol > 1e-11; rtol /= 100) {
        char options[128], tolerances[64];
        tolerance_options(row, tolerances, rtol, rtol / 100);
        snprintf(options, sizeof options, "%s %s", tolerances, more_options);
        const double error = kepler_error(row, options);
        print_message("%-28s %-24s rtol %.0e error %.2e\n", row->name, more_options, rtol, error);
        if (error > 500 * error_of(row, rtol) || (error > before / 3 && error > roundoff_error))
            fail_msg("%s: error %g at rtol %g (before: %g)", row->name, error, rtol, before);
        first = first > 0 ? first : error;
        before = error;
    }
    assert_true(before < first * fmax(1e-4, pow(error_of(row, 1e-6), 0.8)) ||
                before < roundoff_error);
}

static void error_follows_the_tolerance(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_ROW(row) {
        if (row->flags & DL_ADAPTIVE) {
            check_tolerance(row, "");
            rows++;
        }
    }
    assert_true(rows >= 7);
}

static void runge_kutta_tables_follow_the_tolerance(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("arkode-erk", &row, NULL), DL_OK);
    check_tolerance(row, "table=bogacki-shampine-3");
    check_tolerance(row, "table=verner-6");
    check_tolerance(row, "table=cash-karp-5");
}

/* Without a stop every step is the method's own; a stop is hit exactly and with a value of its
 * own, so that energy is as good there as elsewhere. */
static void check_stops(const dl_method_row *row) {
    char options[64];
    rig r = rig_open(row, fixture_kepler(kepler_eccentricity),
                     tolerance_options(row, options, 1e-8, 1e-10));
    for (int k = 1; k <= 20; k++) {
        const double stop = kepler_end * k / 20;
        while (r.method->t < stop) {
            const double before = r.method->t;
            rig_step(&r, stop);
            assert_true(r.method->t > before && r.method->t <= stop);
        }
        double exact[8];
        kepler_exact(stop, exact);
        const double error = largest_difference(rig_state(&r), exact, 8);
        if (error > 500 * error_of(row, 1e-8))
            fail_msg("%s: error %g at the stop t = %g", row->name, error, stop);
    }
    rig_close(&r);
}

static void stops_are_hit_exactly(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (row->flags & DL_ADAPTIVE)
            check_stops(row);
    }
}

static void fixed_steps_end_at_whole_multiples(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_FIXED_STEP))
            continue;
        rig r = rig_open(row, fixture_kepler(kepler_eccentricity), "step=0.001");
        for (int k = 1; k <= 50; k++) {
            rig_step(&r, 0.0123); /* a fixed step takes no notice of a stop */
            assert_true(r.method->t == k * 0.001);
        }
        rig_close(&r);
    }
}

/* Every row against the composition of order 8 on scenes with pins and in three dimensions. */
static void check_agreement(dl_scene *(*make)(void), double end, double step, double allowed) {
    const dl_method_row *best;
    assert_int_equal(dl_method_find("composition-8-kahan-li", &best, NULL), DL_OK);
    char options[64];
    snprintf(options, sizeof options, "step=%.17g", end / 100);
    rig reference = rig_open(best, make(), options);
    rig_run(&reference, end);
    FOR_EACH_ROW(row) {
        rig r = rig_open(row, make(), close_options(row, options, step, 1e-9));
        rig_run(&r, end);
        const double difference = largest_difference(rig_state(&r), reference.method->y, r.length);
        if (!(difference <= near(row, allowed)))
            fail_msg("%s: differs by %g on %s", row->name, difference, r.scene->name);
        rig_close(&r);
    }
    rig_close(&reference);
}

static void methods_agree(void **state) {
    (void)state;
    check_agreement(fixture_cluster, 0.2, 0.0002, 1e-5);
    check_agreement(fixture_pinned_chain, 0.5, 0.0005, 1e-5);
    check_agreement(fixture_oscillator, 0.5, 0.0005, 1e-5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(converges_with_its_order),
        cmocka_unit_test(tables_have_their_order),
        cmocka_unit_test(error_follows_the_tolerance),
        cmocka_unit_test(runge_kutta_tables_follow_the_tolerance),
        cmocka_unit_test(stops_are_hit_exactly),
        cmocka_unit_test(fixed_steps_end_at_whole_multiples),
        cmocka_unit_test(methods_agree),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
