/* The pair law and the force kernels. */
#include <math.h>
#include <quadmath.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <cmocka.h>

#include "driftlab/model.h"
#include "fixture_scenes.h"
#include "force/law.h"
#include "force/vector_ops.h"

static const dl_pair_law fluid = {1, {{.until = 0.25, .terms = 2, .term = {{-25, 2}, {50, 4}}}}};
static const dl_pair_law swirl = {2,
                                  {{.until = 2.3, .terms = 2, .term = {{5, 6}, {-5, 4}}},
                                   {.until = INFINITY, .terms = 1, .term = {{-1e-3, 2}}}}};
static const dl_pair_law stream = {1,
                                   {{.until = INFINITY, .terms = 2, .term = {{-6, 7}, {9, 10}}}}};
static const dl_pair_law uneven = {3,
                                   {{.until = 0.9, .terms = 2, .term = {{3, 5.5}, {-2, 1}}},
                                    {.until = 1.4, .terms = 1, .term = {{-1, 2.25}}},
                                    {.until = 2, .terms = 1, .term = {{0.5, 1.5}}}}};
static const dl_pair_law *const laws[] = {&fluid, &swirl, &stream, &uneven};

enum { law_count = sizeof laws / sizeof *laws };

/* --- an independent law in 128 bits ------------------------------------------------------------
 */

static __float128 antiderivative(const dl_piece *piece, __float128 r) {
    __float128 sum = 0;
    for (int s = 0; s < piece->terms; s++) {
        const __float128 c = piece->term[s].coefficient, p = piece->term[s].power;
        sum += p == 1 ? -c * logq(r) : c / (p - 1) * powq(r, 1 - p);
    }
    return sum;
}

/* V by integrating outwards piece after piece, from r to the last breakpoint or to infinity. */
static __float128 potential(const dl_pair_law *law, __float128 r) {
    __float128 sum = 0;
    for (int k = 0; k < law->pieces; k++) {
        const dl_piece *const piece = &law->piece[k];
        const __float128 begin = k ? law->piece[k - 1].until : 0, end = piece->until;
        if (r >= end)
            continue;
        sum += antiderivative(piece, r > begin ? r : begin);
        if (isfinite(piece->until))
            sum -= antiderivative(piece, end);
    }
    return sum;
}

static void potential_is_the_continuous_one(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(laws[k], &law);
        const double from = laws[k] == &fluid ? 0.1 : 0.6;
        for (double r = from; r < 4; r *= 1.01) {
            const double expected = (double)potential(laws[k], (__float128)r);
            assert_true(fabs(dl_law_potential(&law, r * r) - expected) <=
                        1e-13 * (1 + fabs(expected)));
        }
    }
}

static void force_is_minus_the_slope_of_the_potential(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(laws[k], &law);
        for (double r = laws[k] == &fluid ? 0.1 : 0.6; r < 4; r *= 1.013) {
            const __float128 h = 1e-12Q;
            const double slope = (double)((potential(laws[k], (__float128)r + h) -
                                           potential(laws[k], (__float128)r - h)) /
                                          (2 * h));
            const double force = dl_law_force_over_r(&law, r * r) * r;
            assert_true(fabs(force + slope) <= 1e-11 * (1 + fabs(slope)));
        }
    }
}

static void force_jumps_at_the_breakpoint_and_belongs_to_the_inner_piece(void **state) {
    (void)state;
    dl_law law;
    dl_law_prepare(&fluid, &law);
    /* PAPERS: at r0 = 0.25 the force jumps from 12400 to 0 */
    assert_true(fabs(dl_law_force_over_r(&law, 0.0625) * 0.25 - 12400) < 1e-9);
    assert_true(dl_law_force_over_r(&law, 0.0625000001) == 0);
}

/* --- the discrete gradient ----------------------------------------------------------------------
 */

static double discrete_in_128_bits(const dl_pair_law *law, double r0, __float128 r1) {
    const __float128 s0 = (__float128)r0 * r0, s1 = r1 * r1;
    return (double)(-(potential(law, r1) - potential(law, (__float128)r0)) / (s1 - s0));
}

static void discrete_gradient_keeps_its_digits(void **state) {
    (void)state;
    static const double ratios[] = {1e-14, 1e-11, 1e-8, 1e-5, 1e-3, 0.03, 0.2, 0.7, 2.5};
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(laws[k], &law);
        for (double r0 = laws[k] == &fluid ? 0.1 : 0.6; r0 < 3; r0 *= 1.17)
            for (size_t m = 0; m < 2 * sizeof ratios / sizeof *ratios; m++) {
                const double x = ratios[m / 2];
                const double s0 = r0 * r0, factor = m % 2 ? 1 / (1 + x) : 1 + x;
                const double ds = s0 * (factor * factor - 1), s1 = s0 + ds;
                const double r = sqrt(s0);
                const double got = dl_law_discrete(&law, s0, s1, ds, NULL);
                const double expected =
                    discrete_in_128_bits(laws[k], r, sqrtq((__float128)r * r + ds));
                const double size = fabs(dl_law_force_over_r(&law, fmin(s0, s1))) + 1e-3;
                assert_true(fabs(got - expected) <= 4e-14 * size);
            }
    }
}

static void discrete_gradient_tends_to_the_force(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(laws[k], &law);
        for (double r = laws[k] == &fluid ? 0.11 : 0.65; r < 3; r *= 1.1) {
            const double s = r * r, force = dl_law_force_over_r(&law, s);
            /* F = G (d0 + d1) = 2 G d */
            assert_true(fabs(2 * dl_law_discrete(&law, s, s, 0, NULL) - force) <=
                        1e-13 * (1e-3 + fabs(force)));
        }
    }
}

static void discrete_slope_is_the_derivative(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(laws[k], &law);
        for (double r0 = laws[k] == &fluid ? 0.11 : 0.65; r0 < 2.2; r0 *= 1.09)
            for (double ratio = 0.8; ratio < 1.3; ratio += 0.07) {
                double slope;
                const double s0 = r0 * r0, s1 = s0 * ratio, h = 1e-6 * s1;
                if (dl_law_piece(&law, s1 - h) != dl_law_piece(&law, s1 + h))
                    continue;
                dl_law_discrete(&law, s0, s1, s1 - s0, &slope);
                const double up = dl_law_discrete(&law, s0, s1 + h, s1 + h - s0, NULL);
                const double down = dl_law_discrete(&law, s0, s1 - h, s1 - h - s0, NULL);
                const double expected = (up - down) / (2 * h);
                const double size = fabs(dl_law_force_over_r(&law, fmin(s0, s1))) / s1;
                assert_true(fabs(slope - expected) <= 1e-7 * (size + fabs(expected)) + 1e-8);
            }
    }
}

/* --- kernels against the reference --------------------------------------------------------------
 */

typedef dl_scene *scene_maker(void);

static dl_scene *stream_scene(void) {
    return fixture_stream(50);
}

static dl_scene *kepler_scene(void) {
    return fixture_kepler(0.6);
}

/* The swirl's law, two pieces, masses unlike, 40 particles. */
static dl_scene *swirl_scene(void) {
    dl_scene *scene = fixture_scene("fixture-swirl", 2, 41);
    scene->law = swirl;
    for (size_t i = 0; i < 41; i++) {
        const double x = (double)(i % 7) + 0.1 * fixture_noise((unsigned)(4 * i));
        const double y = 0.9 * (double)(i / 7) + 0.1 * fixture_noise((unsigned)(4 * i + 1));
        fixture_place(scene, i, (double[3]){x, y}, (double[3]){-y, x});
        scene->inertia[i] = scene->coupling[i] = 1000 * (1 + (double)(i % 5));
    }
    return scene;
}

/* Real powers with several breakpoints and an end, in three dimensions. */
static dl_scene *uneven_scene(void) {
    dl_scene *scene = fixture_cluster();
    scene->law = uneven;
    scene->coupling[3] = 2.5;
    scene->pinned[4] = true;
    for (int c = 0; c < 3; c++)
        scene->velocity[(size_t)c * 13 + 4] = 0;
    return scene;
}

static scene_maker *const makers[] = {stream_scene,       kepler_scene,        swirl_scene,
                                      uneven_scene,       fixture_cluster,     fixture_box,
                                      fixture_oscillator, fixture_pinned_chain};

enum { maker_count = sizeof makers / sizeof *makers };

typedef struct evaluation {
    double *a, *discrete; /* [unknowns] */
    size_t unknowns;
} evaluation;

/* Accelerations and discrete accelerations at a displaced state. */
static evaluation evaluate(dl_scene *scene, dl_kernel_choice kernel, double spread) {
    scene->kernel = kernel;
    dl_model *model;
    dl_error error;
    assert_int_equal(dl_model_create(scene, &model, &error), DL_OK);
    const size_t n = model->unknowns;
    evaluation out = {malloc(n * sizeof(double)), malloc(n * sizeof(double)), n};
    double *const y = malloc(2 * n * sizeof *y), *const delta = malloc(n * sizeof *delta);
    dl_model_initial_state(model, y);
    for (size_t i = 0; i < n; i++)
        delta[i] = spread * fixture_noise((unsigned)i);
    assert_int_equal(dl_model_acceleration(model, y, out.a, &error), DL_OK);
    assert_int_equal(dl_model_discrete_acceleration(model, y, delta, out.discrete, &error), DL_OK);
    free(y);
    free(delta);
    dl_model_free(model);
    return out;
}

static double largest(const double *x, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

static void assert_equal_to_roundoff(const double *x, const double *y, size_t n) {
    const double size = largest(y, n);
    for (size_t i = 0; i < n; i++)
        assert_true(fabs(x[i] - y[i]) <= 3e-14 * size);
}

static void every_kernel_equals_the_reference(void **state) {
    (void)state;
    static const char *const sets[] = {"plain", "avx2", "avx512"};
    int compared = 0;
    for (int m = 0; m < maker_count; m++) {
        dl_scene *const scene = makers[m]();
        const double spread = scene->law.piece[0].until < 1 ? 0.05 : 0.3;
        evaluation reference = evaluate(scene, DL_KERNEL_REFERENCE, spread);
        for (int set = 0; set < 3; set++) {
            if (!dl_vector_force(sets[set]))
                continue;
            for (int choice = DL_KERNEL_ALL_PAIRS; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++) {
                if (choice == DL_KERNEL_NEIGHBOUR_LIST &&
                    isinf(scene->law.piece[scene->law.pieces - 1].until))
                    continue;
                evaluation other = evaluate(scene, (dl_kernel_choice)choice, spread);
                assert_equal_to_roundoff(other.a, reference.a, other.unknowns);
                assert_equal_to_roundoff(other.discrete, reference.discrete, other.unknowns);
                free(other.a);
                free(other.discrete);
                compared++;
            }
        }
        dl_vector_force(NULL);
        free(reference.a);
        free(reference.discrete);
        dl_scene_free(scene);
    }
    assert_true(compared >= maker_count);
}

/* Where the list is used, a state may jump anywhere between two calls. */
static void neighbour_list_follows_any_motion(void **state) {
    (void)state;
    dl_scene *const scene = fixture_box(), *const plain = fixture_box();
    scene->kernel = DL_KERNEL_NEIGHBOUR_LIST;
    plain->kernel = DL_KERNEL_REFERENCE;
    dl_model *listed, *reference;
    assert_int_equal(dl_model_create(scene, &listed, NULL), DL_OK);
    assert_int_equal(dl_model_create(plain, &reference, NULL), DL_OK);
    const size_t n = listed->unknowns;
    double y[2 * 48], a[48], b[48];
    assert_int_equal(n, 48);
    dl_model_initial_state(listed, y);
    for (unsigned step = 0; step < 300; step++) {
        /* creeping, walking, jumping */
        const double stride = step % 50 == 49 ? 0.4 : step % 10 == 9 ? 0.06 : 0.004;
        for (size_t i = 0; i < n; i++)
            y[i] += stride * fixture_noise(step * 97 + (unsigned)i);
        assert_int_equal(dl_model_acceleration(listed, y, a, NULL), DL_OK);
        assert_int_equal(dl_model_acceleration(reference, y, b, NULL), DL_OK);
        assert_equal_to_roundoff(a, b, n);
    }
    /* it was reused, and it was rebuilt */
    assert_true(dl_model_list_builds(listed) > 5);
    assert_true(dl_model_list_builds(listed) < 150);
    dl_model_free(listed);
    dl_model_free(reference);
    dl_scene_free(scene);
    dl_scene_free(plain);
}

static void coincidence_and_nan_are_reported(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++)
        for (int what = 0; what < 2; what++) {
            dl_scene *const scene = fixture_box();
            scene->kernel = (dl_kernel_choice)choice;
            dl_model *model;
            assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
            double y[96], a[48];
            dl_error error = {""};
            dl_model_initial_state(model, y);
            assert_int_equal(dl_model_acceleration(model, y, a, &error), DL_OK);
            y[5] = what ? NAN : y[9];
            y[24 + 5] = y[24 + 9];
            assert_int_equal(dl_model_acceleration(model, y, a, &error), DL_UNSTABLE);
            assert_non_null(strstr(error.message, "5"));
            assert_non_null(strstr(error.message, "finite"));
            dl_model_free(model);
            dl_scene_free(scene);
        }
}

static void a_list_without_a_cutoff_is_refused(void **state) {
    (void)state;
    dl_scene *const scene = fixture_stream(50);
    scene->kernel = DL_KERNEL_NEIGHBOUR_LIST;
    dl_model *model;
    dl_error error = {""};
    assert_int_equal(dl_model_create(scene, &model, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "cutoff"));
    assert_null(model);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(potential_is_the_continuous_one),
        cmocka_unit_test(force_is_minus_the_slope_of_the_potential),
        cmocka_unit_test(force_jumps_at_the_breakpoint_and_belongs_to_the_inner_piece),
        cmocka_unit_test(discrete_gradient_keeps_its_digits),
        cmocka_unit_test(discrete_gradient_tends_to_the_force),
        cmocka_unit_test(discrete_slope_is_the_derivative),
        cmocka_unit_test(every_kernel_equals_the_reference),
        cmocka_unit_test(neighbour_list_follows_any_motion),
        cmocka_unit_test(coincidence_and_nan_are_reported),
        cmocka_unit_test(a_list_without_a_cutoff_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
