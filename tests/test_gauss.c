/* Gauss collocation: what is particular to its iteration; the rest of its contract is that of every
 * row (test_methods.c, test_method_accuracy.c, test_symplectic.c). */
#include "contract.h"

static const char *const names[] = {"gauss-4", "gauss-6"};
enum { rows = 2 };

static const dl_method_row *row_of(int k) {
    const dl_method_row *row = NULL;
    assert_int_equal(dl_method_find(names[k], &row, NULL), DL_OK);
    return row;
}

static double energy_error(rig *r, double start) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(r->model, rig_state(r), &energy, NULL), DL_OK);
    return fabs(energy.total / start - 1);
}

static double energy_of(rig *r) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(r->model, rig_state(r), &energy, NULL), DL_OK);
    return energy.total;
}

/* A circular orbit, at steps that leave nothing else of the energy error. */
static void roundoff_does_not_drift(void **state) {
    (void)state;
    static const char *const options[rows] = {"step=0.01", "step=0.1"};
    for (int k = 0; k < rows; k++) {
        rig r = rig_open(row_of(k), fixture_kepler(0), options[k]);
        const double start = energy_of(&r);
        double most = 0;
        for (int i = 0; i < 60000; i++) {
            rig_step(&r, INFINITY);
            most = fmax(most, energy_error(&r, start));
        }
        dl_method_stats stats;
        dl_method_stats_get(r.method, &stats);
        print_message("%s: energy error %.2e, %lu steps above the tolerance\n", names[k], most,
                      stats.inexact);
        assert_true(most < 2e-14);
        rig_close(&r);
    }
}

static unsigned long iterations_of(const dl_method_row *row, const char *options, int steps,
                                   double *error) {
    rig r = rig_open(row, fixture_kepler(0), options);
    const double start = energy_of(&r);
    rig_steps(&r, steps);
    *error = energy_error(&r, start);
    dl_method_stats stats;
    dl_method_stats_get(r.method, &stats);
    assert_int_equal(r.model->counts.force,
                     stats.nonlinear_iterations * (unsigned long)row->stages + 1);
    rig_close(&r);
    return stats.nonlinear_iterations;
}

static void tolerance_is_what_iterations_reach(void **state) {
    (void)state;
    for (int k = 0; k < rows; k++) {
        double exact, loose;
        const unsigned long all = iterations_of(row_of(k), "step=0.1", 500, &exact);
        const unsigned long few = iterations_of(row_of(k), "step=0.1 tolerance=1e-5", 500, &loose);
        print_message("%s: %lu iterations for %.1e, %lu for %.1e\n", names[k], all, exact, few,
                      loose);
        assert_true(few >= 1000 && 3 * few < 2 * all && all < 500 * 8);
        assert_true(exact < 1e-12 && loose > 1e3 * exact);
    }
}

/* Earlier steps tell where the stages are: after a jump there are more iterations. */
static void earlier_steps_save_iterations(void **state) {
    (void)state;
    for (int k = 0; k < rows; k++) {
        unsigned long iterations[2];
        for (int jumps = 0; jumps < 2; jumps++) {
            rig r = rig_open(row_of(k), fixture_kepler(0.3), "step=0.1");
            for (int i = 0; i < 100; i++) {
                rig_step(&r, INFINITY);
                if (jumps)
                    rig_jumped(&r);
            }
            dl_method_stats stats;
            dl_method_stats_get(r.method, &stats);
            iterations[jumps] = stats.nonlinear_iterations;
            rig_close(&r);
        }
        print_message("%s: %lu iterations, %lu with jumps\n", names[k], iterations[0],
                      iterations[1]);
        assert_true(iterations[0] + 50 <= iterations[1]);
    }
}

static void failures_say_how_far_it_came(void **state) {
    (void)state;
    static const char *const options[] = {"step=2", "step=0.2 iterations=2"};
    for (int k = 0; k < rows; k++)
        for (int o = 0; o < 2; o++) {
            rig r = rig_open(row_of(k), fixture_kepler(0.6), options[o]);
            double before[8];
            memcpy(before, rig_state(&r), sizeof before);
            dl_error error = {""};
            assert_int_equal(dl_method_advance(r.method, INFINITY, &error), DL_NONLINEAR_FAILURE);
            assert_non_null(strstr(error.message, names[k]));
            assert_non_null(strstr(error.message, "displacement"));
            assert_memory_equal(r.method->y, before, sizeof before);
            rig_close(&r);
        }
}

/* Two particles that cross a hard cutoff slowly: its force would push them out again from every
 * place inside, so that no place solves the equations. */
static void jumps_without_a_solution_are_passed(void **state) {
    (void)state;
    for (int k = 0; k < rows; k++) {
        unsigned long inexact = 0;
        for (int lag = 0; lag < 20; lag++) {
            dl_scene *const scene = fixture_scene("slow-crossing", 2, 2);
            const double x = 0.13 + 2.5e-6 * lag;
            fixture_law(scene, 0.25, 25, 2, 50, 4);
            fixture_place(scene, 0, (double[3]){-x, 0}, (double[3]){0.5, 0});
            fixture_place(scene, 1, (double[3]){x, 0}, (double[3]){-0.5, 0});
            rig r = rig_open(row_of(k), scene, "step=1e-4");
            rig_steps(&r, 300);
            assert_true(rig_state(&r)[1] - r.y[0] > 0.25 && r.y[5] > r.y[4]);
            dl_method_stats stats;
            dl_method_stats_get(r.method, &stats);
            inexact += stats.inexact;
            rig_close(&r);
        }
        print_message("%s: %lu steps in 20 crossings had no solution\n", names[k], inexact);
        assert_true(inexact > 0 && inexact < 60);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(roundoff_does_not_drift),
        cmocka_unit_test(tolerance_is_what_iterations_reach),
        cmocka_unit_test(earlier_steps_save_iterations),
        cmocka_unit_test(failures_say_how_far_it_came),
        cmocka_unit_test(jumps_without_a_solution_are_passed),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
