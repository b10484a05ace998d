/* Eigenvalues of the mass-weighted Hessian: against what is known exactly, and Lanczos' ends
 * against GSL's whole spectrum. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/trajectory.h"
#include "fixture_scenes.h"
#include "observe/spectrum.h"

typedef struct posed {
    dl_scene *scene;
    dl_model *model;
    double *y, *value;
} posed;

static posed pose(dl_scene *scene) {
    posed p = {.scene = scene};
    dl_error error = {""};
    if (dl_model_create(scene, &p.model, &error))
        fail_msg("%s", error.message);
    p.y = calloc(2 * p.model->unknowns, sizeof *p.y);
    p.value = calloc(p.model->unknowns, sizeof *p.value);
    assert_true(p.y && p.value);
    dl_model_initial_state(p.model, p.y);
    return p;
}

static void release(posed *p) {
    dl_model_free(p->model);
    dl_scene_free(p->scene);
    free(p->y);
    free(p->value);
}

/* Two bodies of masses 1 and 2 with F(r) = c1 c2 (r^-5 - r^-2): stretching has
 * omega^2 = -F'(r) (1/m1 + 1/m2), turning -F(r)/r (1/m1 + 1/m2), moving as a whole 0. */
static void a_pair_has_the_known_frequencies(void **state) {
    (void)state;
    posed p = pose(fixture_oscillator());
    const double r = 1.1, inverse = 1.5, coupling = p.scene->coupling[0] * p.scene->coupling[1];
    const double stretch = coupling * inverse * (5 * pow(r, -6) - 2 * pow(r, -3));
    const double turn = -coupling * inverse * (pow(r, -5) - pow(r, -2)) / r;
    assert_int_equal(dl_spectrum_all(p.model, p.y, p.value, NULL), DL_OK);
    const double low = fmin(stretch, turn), high = fmax(stretch, turn);
    assert_true(low > 0);
    assert_true(fabs(p.value[0]) < 1e-14 && fabs(p.value[1]) < 1e-14);
    assert_true(fabs(p.value[2] - low) < 1e-13 && fabs(p.value[3] - high) < 1e-13);
    release(&p);
}

/* Two bodies that attract as 1/r^2: apart along their line the motion is unstable, -2/r^3. */
static void an_unstable_direction_is_negative(void **state) {
    (void)state;
    posed p = pose(fixture_kepler(0.5));
    const double cube = 0.125;
    dl_spectrum ends;
    assert_int_equal(dl_spectrum_ends(p.model, p.y, &ends, NULL), DL_OK);
    assert_true(fabs(ends.smallest + 2 / cube) < 1e-12);
    assert_true(fabs(ends.largest - 1 / cube) < 1e-12);
    release(&p);
}

static void both_ways_agree(void **state) {
    (void)state;
    dl_scene *const scenes[] = {fixture_oscillator(), fixture_stream(50), fixture_cluster(),
                                fixture_pinned_chain(), fixture_box()};
    for (size_t s = 0; s < sizeof scenes / sizeof *scenes; s++) {
        posed p = pose(scenes[s]);
        dl_spectrum ends;
        dl_error error = {""};
        if (dl_spectrum_all(p.model, p.y, p.value, &error) ||
            dl_spectrum_lanczos(p.model, p.y, &ends, &error))
            fail_msg("%s: %s", p.scene->name, error.message);
        const double low = p.value[0], high = p.value[p.model->unknowns - 1];
        const double scale = fmax(fabs(low), fabs(high));
        if (!(fabs(ends.smallest - low) <= 1e-9 * scale) ||
            !(fabs(ends.largest - high) <= 1e-9 * scale))
            fail_msg("%s: Lanczos %.15g to %.15g, all %.15g to %.15g", p.scene->name, ends.smallest,
                     ends.largest, low, high);
        release(&p);
    }
}

/* As a study asks for it: 278 particles with a neighbour list, then 239 without. */
static void large_scenes_agree(void **state) {
    (void)state;
    static const char *const file[] = {DL_STUDIES "/drop/settled.yaml",
                                       DL_STUDIES "/swirl/swirl.yaml"};
    for (size_t s = 0; s < 2; s++) {
        dl_scene *scene = NULL;
        dl_error error = {""};
        if (dl_scene_read(file[s], &scene, &error))
            fail_msg("%s", error.message);
        posed p = pose(scene);
        dl_spectrum ends;
        assert_int_equal(dl_spectrum_all(p.model, p.y, p.value, NULL), DL_OK);
        assert_int_equal(dl_spectrum_ends(p.model, p.y, &ends, NULL), DL_OK);
        const size_t last = p.model->unknowns - 1;
        assert_true(p.model->counts.jacobian_vector > 0);
        assert_true(fabs(ends.largest / p.value[last] - 1) < 1e-8);
        assert_true(fabs(ends.smallest - p.value[0]) < 1e-7 * p.value[last]);
        release(&p);
    }
}

/* What does not move has no frequency; what is not finite is no number. */
static void nothing_and_not_finite(void **state) {
    (void)state;
    dl_scene *free_flight = fixture_scene("free", 2, 3);
    for (size_t i = 0; i < 3; i++)
        fixture_place(free_flight, i, (double[3]){(double)i}, (double[3]){1, 2});
    posed p = pose(free_flight);
    dl_spectrum ends;
    dl_error error = {""};
    assert_int_equal(dl_spectrum_ends(p.model, p.y, &ends, NULL), DL_OK);
    assert_true(ends.smallest == 0 && ends.largest == 0);
    release(&p);
    p = pose(fixture_stream(1));
    p.y[1] = p.y[0];
    p.y[1 + p.model->moving] = p.y[p.model->moving];
    assert_int_equal(dl_spectrum_ends(p.model, p.y, &ends, &error), DL_UNSTABLE);
    assert_non_null(strstr(error.message, "not finite"));
    assert_int_equal(dl_spectrum_lanczos(p.model, p.y, &ends, &error), DL_UNSTABLE);
    release(&p);
}

/* What rests on a wall takes no part. */
static void held_coordinates_take_no_part(void **state) {
    (void)state;
    posed p = pose(fixture_stream(0));
    const size_t n = p.model->unknowns;
    bool *held = calloc(n, sizeof *held);
    assert_non_null(held);
    for (size_t u = 0; u < n; u += 3)
        held[u] = true;
    dl_spectrum ends, whole;
    assert_int_equal(dl_spectrum_ends(p.model, p.y, &whole, NULL), DL_OK);
    p.model->held = held;
    assert_int_equal(dl_spectrum_all(p.model, p.y, p.value, NULL), DL_OK);
    assert_int_equal(dl_spectrum_lanczos(p.model, p.y, &ends, NULL), DL_OK);
    assert_true(fabs(ends.largest - p.value[n - 1]) < 1e-9 * ends.largest);
    assert_true(ends.largest < whole.largest);
    p.model->held = NULL;
    free(held);
    release(&p);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_pair_has_the_known_frequencies),
        cmocka_unit_test(an_unstable_direction_is_negative),
        cmocka_unit_test(both_ways_agree),
        cmocka_unit_test(large_scenes_agree),
        cmocka_unit_test(nothing_and_not_finite),
        cmocka_unit_test(held_coordinates_take_no_part),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
