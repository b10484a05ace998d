/* Properties of the force kernels, for every instruction set that runs here: what is renumbered or
 * moved has the same forces, a pair's force has the bits that it has among others, and what the
 * loops compute with is as exact as it is said to be. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <cmocka.h>

#include "driftlab/model.h"
#include "fixture_scenes.h"
#include "force/law.h"
#include "force/vector_ops.h"
#include "model/private.h"

static const char *const sets[] = {"plain", "avx2", "avx512"};

enum { set_count = 3 };

/* --- what the loops compute with ---------------------------------------------------------------
 */

static double root_error(const dl_vector_ops *ops, double s) {
    double root;
    ops->inverse_sqrt(&s, &root, 1);
    const long double exact = 1 / sqrtl((long double)s);
    return (double)fabsl(((long double)root - exact) / exact);
}

/* Over every exponent that a double has, denormal ones too. */
static void inverse_square_roots_keep_their_digits(void **state) {
    (void)state;
    for (int set = 0; set < set_count; set++) {
        if (!dl_vector_force(sets[set]))
            continue;
        double worst = 0;
        for (int exponent = -1074; exponent <= 1023; exponent++)
            for (unsigned k = 0; k < 64; k++) {
                const double mantissa =
                    k ? 1 + fabs(fixture_noise(k * 4099 + (unsigned)exponent)) : 1;
                worst = fmax(worst, root_error(dl_vector_best(), ldexp(mantissa, exponent)));
            }
        worst = fmax(worst, root_error(dl_vector_best(), 1.7976931348623157e308));
        assert_true(worst <= 1e-15);
    }
    dl_vector_force(NULL);
}

static const dl_pair_law real_law = {2,
                                     {{.until = 0.9, .terms = 2, .term = {{3, 5.5}, {-2, 1.3}}},
                                      {.until = 2, .terms = 1, .term = {{-1, 2.25}}}}};

static void assert_force_of_law(const dl_pair_law *source) {
    double s[64 + DL_VECTOR_PAD], f[64 + DL_VECTOR_PAD];
    dl_law law;
    dl_law_prepare(source, &law);
    for (int set = 0; set < set_count; set++) {
        if (!dl_vector_force(sets[set]))
            continue;
        for (int round = 0; round < 40; round++) {
            for (int k = 0; k < 64 + DL_VECTOR_PAD; k++)
                s[k] = exp2(-12 + 0.3 * round + 0.01 * k);
            s[17] = law.until2[0];
            dl_vector_best()->loops_for(&law)->force(&law, s, f, 64);
            for (int k = 0; k < 64; k++) {
                const double exact = dl_law_force_over_r(&law, s[k]);
                assert_true(fabs(f[k] - exact) <= 1e-13 * fabs(exact));
            }
        }
    }
    dl_vector_force(NULL);
}

static void real_powers_have_the_law_s_force(void **state) {
    (void)state;
    dl_pair_law tapered = real_law;
    tapered.piece[1].end = DL_END_TAPER;
    tapered.piece[1].width = 0.5;
    assert_force_of_law(&real_law);
    assert_force_of_law(&tapered);
}

/* --- the same forces by other numbers and in other places --------------------------------------
 */

enum { count = 131 };

/* Particle k of a warm lattice of spacing 0.23 or so stands in row order[k] of the scene. */
static dl_scene *lattice(const size_t order[count], const double shift[2], bool periodic) {
    dl_scene *scene = fixture_scene("kernels", 2, count);
    scene->law = (dl_pair_law){1, {{.until = 0.25, .terms = 2, .term = {{-25, 2}, {50, 4}}}}};
    for (size_t k = 0; k < count; k++)
        for (size_t c = 0; c < 2; c++) {
            const double place = 0.23 * (double)(c ? k / 13 : k % 13);
            scene->position[c * count + order[k]] =
                shift[c] + place + 0.03 * fixture_noise((unsigned)(2 * k + c));
            scene->coupling[order[k]] = 1 + 0.5 * (double)(k % 3);
        }
    scene->periods.present = periodic;
    for (int c = 0; c < 2 && periodic; c++)
        scene->periods.length[c] = c ? 0.23 * 11 : 0.23 * 13;
    return scene;
}

static void accelerate(dl_scene *scene, dl_kernel_choice kernel, double *a) {
    dl_model *model;
    scene->kernel = kernel;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    assert_int_equal(dl_model_acceleration(model, scene->position, a, NULL), DL_OK);
    dl_model_free(model);
}

static void assert_close(const double *a, const double *b, const size_t *order, double tolerance) {
    double size = 0;
    for (size_t k = 0; k < 2 * count; k++)
        size = fmax(size, fabs(a[k]));
    assert_true(size > 0);
    for (size_t c = 0; c < 2; c++)
        for (size_t k = 0; k < count; k++)
            assert_true(fabs(a[c * count + k] - b[c * count + order[k]]) <= tolerance * size);
}

static void numbers_and_places_change_nothing(void **state) {
    (void)state;
    size_t same[count], mixed[count];
    const double here[2] = {0, 0}, there[2] = {-3.5, 17.25};
    double a[2 * count], b[2 * count];
    for (size_t k = 0; k < count; k++) {
        same[k] = k;
        mixed[k] = k * 47 % count;
    }
    for (int set = 0; set < set_count; set++)
        for (int kernel = DL_KERNEL_REFERENCE; kernel <= DL_KERNEL_NEIGHBOUR_LIST; kernel++)
            for (int periodic = 0; periodic < 2; periodic++) {
                if (!dl_vector_force(sets[set]))
                    continue;
                dl_scene *plain = lattice(same, here, periodic);
                dl_scene *renumbered = lattice(mixed, here, periodic);
                dl_scene *moved = lattice(same, there, periodic);
                accelerate(plain, (dl_kernel_choice)kernel, a);
                accelerate(renumbered, (dl_kernel_choice)kernel, b);
                assert_close(a, b, mixed, 1e-13);
                accelerate(moved, (dl_kernel_choice)kernel, b);
                assert_close(a, b, same, 1e-11); /* the places have lost digits */
                dl_scene_free(plain);
                dl_scene_free(renumbered);
                dl_scene_free(moved);
            }
    dl_vector_force(NULL);
}

/* --- a pair alone and among others -------------------------------------------------------------
 */

/* All but two have no coupling: they are in the same loops and add nothing. */
static void assert_pair_has_its_bits(dl_scene *scene, dl_kernel_choice choice, size_t i, size_t j) {
    double a[2 * count], alone[3];
    dl_model *model;
    memset(scene->coupling, 0, count * sizeof *scene->coupling);
    scene->coupling[i] = 3;
    scene->coupling[j] = 1.25;
    scene->kernel = choice;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    assert_int_equal(dl_model_acceleration(model, scene->position, a, NULL), DL_OK);
    model->kernel->ops->pair(model->kernel, scene->position, NULL, i, j, alone);
    for (size_t c = 0; c < 2; c++) {
        assert_true(a[c * count + i] == alone[c]);
        assert_true(a[c * count + j] == -alone[c]);
    }
    dl_model_free(model);
}

static void a_pair_has_its_bits_among_others(void **state) {
    (void)state;
    size_t same[count];
    const double here[2] = {0, 0};
    for (size_t k = 0; k < count; k++)
        same[k] = k;
    for (int set = 0; set < set_count; set++)
        for (int kernel = DL_KERNEL_ALL_PAIRS; kernel <= DL_KERNEL_NEIGHBOUR_LIST; kernel++)
            for (int periodic = 0; periodic < 2; periodic++) {
                if (!dl_vector_force(sets[set]))
                    continue;
                dl_scene *scene = lattice(same, here, periodic);
                for (size_t i = 0; i + 13 < count; i += 5) {
                    assert_pair_has_its_bits(scene, (dl_kernel_choice)kernel, i, i + 1);
                    assert_pair_has_its_bits(scene, (dl_kernel_choice)kernel, i, i + 13);
                }
                dl_scene_free(scene);
            }
    dl_vector_force(NULL);
}

/* --- many particles in no order ----------------------------------------------------------------
 */

/* Rows of the list in the particles' own numbers: what visits them counts each pair once. */
static double energy_of(dl_model *model, const double *y) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(model, y, &energy, NULL), DL_OK);
    return energy.pair;
}

/* A lattice that is numbered by leaps has the forces of the one that is numbered row by row: the
 * first is put in order inside the kernel. */
static void scattered_particles_have_the_same_forces(void **state) {
    (void)state;
    enum { side = 150, many = side * side };
    double *y[2], *a[2], *mean[2], energy[2], size = 0;
    for (int mixed = 0; mixed < 2; mixed++) {
        dl_scene *scene = fixture_scene("many", 2, many);
        dl_model *model;
        scene->law = (dl_pair_law){1, {{.until = 0.25, .terms = 2, .term = {{-25, 2}, {50, 4}}}}};
        y[mixed] = calloc(6 * many, sizeof(double));
        a[mixed] = calloc(2 * many, sizeof(double));
        mean[mixed] = calloc(2 * many, sizeof(double));
        for (size_t k = 0; k < many; k++) {
            const size_t at = mixed ? k * 10007 % many : k;
            scene->coupling[at] = 1 + 0.25 * (double)(k % 2);
            for (size_t c = 0; c < 2; c++) {
                const double place = 0.23 * (double)(c ? k / side : k % side);
                const double noise = fixture_noise((unsigned)(2 * k + c));
                y[mixed][c * many + at] = place + 0.03 * noise;
                y[mixed][(4 + c) * many + at] = 0.1 * noise;
            }
        }
        scene->kernel = DL_KERNEL_NEIGHBOUR_LIST;
        assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
        energy[mixed] = energy_of(model, y[mixed]);
        assert_int_equal(dl_model_acceleration(model, y[mixed], a[mixed], NULL), DL_OK);
        assert_int_equal(
            dl_model_discrete_acceleration(model, y[mixed], y[mixed] + 4 * many, mean[mixed], NULL),
            DL_OK);
        dl_model_free(model);
        dl_scene_free(scene);
    }
    assert_true(fabs(energy[1] - energy[0]) <= 1e-12 * fabs(energy[0]));
    for (size_t k = 0; k < 2 * many; k++)
        size = fmax(size, fmax(fabs(a[0][k]), fabs(mean[0][k])));
    for (size_t c = 0; c < 2; c++)
        for (size_t k = 0; k < many; k++) {
            const size_t from = c * many + k, to = c * many + k * 10007 % many;
            assert_true(fabs(a[0][from] - a[1][to]) <= 1e-13 * size);
            assert_true(fabs(mean[0][from] - mean[1][to]) <= 1e-12 * size);
        }
    for (int mixed = 0; mixed < 2; mixed++) {
        free(y[mixed]);
        free(a[mixed]);
        free(mean[mixed]);
    }
}

/* --- long rows ---------------------------------------------------------------------------------
 */

/* Everything in one cell: a row of the list is longer than what is looked at in one go. */
static void rows_may_be_of_any_length(void **state) {
    (void)state;
    enum { many = 700 };
    static double a[2 * many], b[2 * many];
    dl_scene *scene = fixture_scene("crowd", 2, many);
    scene->law = (dl_pair_law){1, {{.until = 0.25, .terms = 1, .term = {{1, 2}}}}};
    for (unsigned k = 0; k < 2 * many; k++)
        scene->position[k] = 0.1 * fixture_noise(k);
    scene->position[5] = 40; /* rows without an entry */
    scene->position[many - 1] = -40;
    for (int set = 0; set < set_count; set++) {
        if (!dl_vector_force(sets[set]))
            continue;
        double size = 0;
        accelerate(scene, DL_KERNEL_REFERENCE, a);
        accelerate(scene, DL_KERNEL_NEIGHBOUR_LIST, b);
        for (size_t k = 0; k < 2 * many; k++)
            size = fmax(size, fabs(a[k]));
        for (size_t k = 0; k < 2 * many; k++)
            assert_true(fabs(a[k] - b[k]) <= 1e-12 * size);
    }
    dl_vector_force(NULL);
    dl_scene_free(scene);
}

/* --- walls -------------------------------------------------------------------------------------
 */

static void hits_are_found_wherever_they_are(void **state) {
    (void)state;
    size_t same[count];
    const double here[2] = {0, 0};
    for (size_t k = 0; k < count; k++)
        same[k] = k;
    for (int set = 0; set < set_count; set++)
        for (size_t k = 0; k < count; k++) {
            if (!dl_vector_force(sets[set]))
                continue;
            dl_scene *scene = lattice(same, here, false);
            dl_model *model;
            double y[4 * count], before[4 * count];
            scene->walls.present = true;
            scene->walls.low[1] = -1;
            scene->walls.high[0] = 5;
            scene->walls.damping = 0.5;
            assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
            dl_model_initial_state(model, y);
            y[2 * count + k] = 2;
            y[k] = 5.5;
            y[count + (k + 70) % count] = -1.25;
            memcpy(before, y, sizeof y);
            assert_true(dl_model_outside(model, y));
            assert_int_equal(dl_model_mirror(model, y, y + 2 * count), 2);
            assert_false(dl_model_outside(model, y));
            assert_true(y[k] == 4.5 && y[2 * count + k] == -1);
            assert_true(y[count + (k + 70) % count] == -0.75);
            for (size_t i = 0; i < 2 * count; i++)
                assert_true(y[i] == before[i] || i == k || i == count + (k + 70) % count);
            dl_model_free(model);
            dl_scene_free(scene);
        }
    dl_vector_force(NULL);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(inverse_square_roots_keep_their_digits),
        cmocka_unit_test(real_powers_have_the_law_s_force),
        cmocka_unit_test(numbers_and_places_change_nothing),
        cmocka_unit_test(a_pair_has_its_bits_among_others),
        cmocka_unit_test(scattered_particles_have_the_same_forces),
        cmocka_unit_test(rows_may_be_of_any_length),
        cmocka_unit_test(hits_are_found_wherever_they_are),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
