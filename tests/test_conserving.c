/* TR171's scheme: what it promises whatever the step is. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "driftlab/method.h"
#include "driftlab/run.h"
#include "driftlab/scene.h"
#include "fixture_scenes.h"

static const char *const conserving[] = {"conserving-fixed-point", "conserving-newton-dense",
                                         "conserving-newton-klu"};

static dl_scene *stream(void) {
    dl_scene *scene;
    dl_error error = {""};
    if (dl_scene_read(DL_STUDIES "/stream/stream.yaml", &scene, &error) != DL_OK)
        fail_msg("%s", error.message);
    return scene;
}

/* Runs and returns the final state, [4 * particles], owned by the caller. */
static double *run_with(const dl_scene *scene, const char *name, const char *step, double end,
                        const char *option, const char *value, dl_run_summary *summary) {
    const dl_method_row *row;
    void *options;
    dl_error error = {""};
    dl_run_options run_options;
    dl_run_options_default(&run_options);
    run_options.end = end;
    double *y = calloc(2 * (size_t)scene->dimension * scene->particles, sizeof *y);
    assert_int_equal(dl_method_find(name, &row, &error), DL_OK);
    assert_int_equal(dl_method_options_create(row, scene, &options, &error), DL_OK);
    assert_int_equal(dl_method_options_set(row, options, "step", step, &error), DL_OK);
    if (option)
        assert_int_equal(dl_method_options_set(row, options, option, value, &error), DL_OK);
    if (dl_run(scene, row, options, &run_options, summary, y, &error) != DL_OK)
        fail_msg("%s", error.message);
    dl_method_options_free(row, options);
    return y;
}

static double *run(const dl_scene *scene, const char *name, const char *step, double end,
                   dl_run_summary *summary) {
    return run_with(scene, name, step, end, NULL, NULL, summary);
}

static void conserves_over_ten_thousand_steps(void **state) {
    (void)state;
    dl_scene *const scene = stream();
    for (int m = 0; m < 3; m++) {
        dl_run_summary summary;
        /* the three differ in cost alone; the Newton ones run a tenth as far */
        const double end = m == 0 ? 200 : 20;
        free(run(scene, conserving[m], "0.02", end, &summary));
        assert_int_equal(summary.status, DL_OK);
        assert_int_equal(summary.steps, (int)lround(end / 0.02));
        assert_true(summary.energy_error_max <= 1e-12 * summary.energy_scale);
        assert_true(summary.momentum_error_max <= 1e-12 * summary.momentum_scale);
        assert_true(summary.angular_momentum_error_max <= 1e-12 * summary.angular_momentum_scale);
    }
    dl_scene_free(scene);
}

/* Leap-frog does not: the check above is worth something. */
static void leapfrog_does_not_conserve_energy_there(void **state) {
    (void)state;
    dl_scene *const scene = stream();
    dl_run_summary summary;
    free(run(scene, "leapfrog", "0.02", 20, &summary));
    assert_true(summary.energy_error_max > 1e-6 * summary.energy_scale);
    dl_scene_free(scene);
}

static double distance(const double *a, const double *b, size_t count) {
    double sum = 0;
    for (size_t i = 0; i < count; i++)
        sum += (a[i] - b[i]) * (a[i] - b[i]);
    return sqrt(sum / (double)count);
}

static void positions_converge_with_order_two(void **state) {
    (void)state;
    static const char *const steps[] = {"0.02", "0.01", "0.005", "0.0025"};
    dl_scene *const scene = stream();
    dl_run_summary summary;
    double *const exact = run(scene, "composition-8-kahan-li", "0.002", 1, &summary);
    for (int m = 0; m < 3; m++) {
        /* least squares of log2(error) over halvings */
        double sum_x = 0, sum_y = 0, sum_xx = 0, sum_xy = 0;
        for (int k = 0; k < 4; k++) {
            double *const y = run(scene, conserving[m], steps[k], 1, &summary);
            const double error = log2(distance(y, exact, 2 * scene->particles));
            free(y);
            sum_x += k;
            sum_y += error;
            sum_xx += k * k;
            sum_xy += k * error;
        }
        const double slope = (4 * sum_xy - sum_x * sum_y) / (4 * sum_xx - sum_x * sum_x);
        assert_true(fabs(-slope - 2) <= 0.1);
    }
    free(exact);
    dl_scene_free(scene);
}

static void the_solvers_agree(void **state) {
    (void)state;
    dl_scene *const scene = stream();
    dl_run_summary summary;
    double *const first = run(scene, conserving[0], "0.02", 1, &summary);
    for (int m = 1; m < 3; m++) {
        double *const other = run(scene, conserving[m], "0.02", 1, &summary);
        assert_true(distance(first, other, 4 * scene->particles) <= 1e-11);
        assert_true(summary.jacobian_evaluations > 0);
        free(other);
    }
    free(first);
    dl_scene_free(scene);
}

/* A hard cutoff, pins, unlike inertia and coupling, three dimensions. */
static void conserves_where_the_scene_is_harder(void **state) {
    (void)state;
    static const struct {
        dl_scene *(*maker)(void);
        const char *step;
    } rows[] = {{fixture_pinned_chain, "0.05"}, {fixture_cluster, "0.01"}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int m = 0; m < 3; m++) {
            dl_scene *const scene = rows[k].maker();
            dl_run_summary summary;
            free(run(scene, conserving[m], rows[k].step, 0, &summary));
            assert_int_equal(summary.status, DL_OK);
            assert_true(summary.energy_error_max <= 1e-13 * summary.energy_scale);
            dl_scene_free(scene);
        }
}

/* Walls damp and mirror; what they take is in the ledger and nothing else is missing. */
static void the_ledger_closes_through_walls_and_cutoff(void **state) {
    (void)state;
    for (int m = 0; m < 3; m++) {
        dl_scene *const scene = fixture_box();
        dl_run_summary summary;
        scene->kernel = DL_KERNEL_NEIGHBOUR_LIST; /* the Jacobian's pattern changes with the list */
        scene->skin = 0.02;
        free(run(scene, conserving[m], "1e-4", 0, &summary));
        assert_true(summary.neighbour_list_builds > 20);
        assert_int_equal(summary.status, DL_OK);
        assert_true(summary.wall_hits > 10);
        assert_true(summary.ledger > 0.01 * summary.energy_scale);
        assert_true(summary.energy_error_max <= 1e-12 * summary.energy_scale);
        dl_scene_free(scene);
    }
}

/* A step past what the iteration can do is a result with a message, not a crash; Newton's method
 * solves it, and then the energy is conserved there too. */
static void where_the_fixed_point_fails_newton_rescues(void **state) {
    (void)state;
    dl_scene *const scene = stream();
    dl_run_summary summary;
    scene->sample = 0;
    free(run_with(scene, conserving[0], "0.5", 10, "rescue", "false", &summary));
    assert_int_equal(summary.status, DL_NONLINEAR_FAILURE);
    assert_non_null(strstr(summary.message, "converge"));
    assert_true(summary.t_end_reached < 10);
    free(run_with(scene, conserving[0], "0.5", 10, "rescue", "true", &summary));
    assert_int_equal(summary.status, DL_OK);
    assert_true(summary.rescued_steps > 0);
    assert_true(summary.energy_error_max <= 1e-12 * summary.energy_scale);
    dl_scene_free(scene);
}

/* A pair at rest on a line: residuals that Anderson's acceleration combines depend on one another.
 * No such step may pass as solved. */
static void no_depth_of_acceleration_passes_a_wrong_step(void **state) {
    (void)state;
    static const char *const depths[] = {"0", "1", "2", "3", "5"};
    for (size_t k = 0; k < sizeof depths / sizeof *depths; k++) {
        dl_scene *const scene = fixture_oscillator();
        scene->law.piece[0].term[1].power = 4;
        for (int i = 0; i < 4; i++)
            scene->velocity[i] = 0;
        scene->position[2] = scene->position[3] = 0;
        dl_run_summary summary;
        free(run_with(scene, conserving[0], "0.01", 1, "depth", depths[k], &summary));
        assert_int_equal(summary.status, DL_OK);
        assert_true(summary.energy_error_max <= 1e-14 * summary.energy_scale);
        dl_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(conserves_over_ten_thousand_steps),
        cmocka_unit_test(leapfrog_does_not_conserve_energy_there),
        cmocka_unit_test(positions_converge_with_order_two),
        cmocka_unit_test(the_solvers_agree),
        cmocka_unit_test(conserves_where_the_scene_is_harder),
        cmocka_unit_test(the_ledger_closes_through_walls_and_cutoff),
        cmocka_unit_test(no_depth_of_acceleration_passes_a_wrong_step),
        cmocka_unit_test(where_the_fixed_point_fails_newton_rescues),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
