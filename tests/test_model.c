/* The model: accelerations, energies, Jacobians, the discrete gradient, momenta, walls. */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <cmocka.h>

#include "driftlab/explain.h"
#include "driftlab/model.h"
#include "fixture_scenes.h"

/* A scene, its model and its initial state. */
typedef struct subject {
    dl_scene *scene;
    dl_model *model;
    size_t n;
    double *y, *delta;
} subject;

static dl_scene *stream_scene(void) {
    return fixture_stream(50);
}

static dl_scene *kepler_scene(void) {
    return fixture_kepler(0.6);
}

static dl_scene *listed_box(void) {
    dl_scene *scene = fixture_box();
    scene->kernel = DL_KERNEL_NEIGHBOUR_LIST;
    return scene;
}

/* Two pieces of real powers, an end, couplings unlike, a pin, three dimensions. */
static dl_scene *uneven_scene(void) {
    dl_scene *scene = fixture_cluster();
    scene->law = (dl_pair_law){2,
                               {{.until = 1.3, .terms = 2, .term = {{3, 5.5}, {-2, 1}}},
                                {.until = 1.9, .terms = 1, .term = {{-1, 2.25}}}}};
    scene->coupling[3] = 2.5;
    scene->pinned[4] = true;
    for (int c = 0; c < 3; c++)
        scene->velocity[(size_t)c * 13 + 4] = 0;
    scene->gravity[2] = -1;
    scene->feels_gravity[2] = scene->feels_gravity[12] = true;
    return scene;
}

typedef dl_scene *scene_maker(void);

static scene_maker *const makers[] = {stream_scene,         kepler_scene,      listed_box,
                                      fixture_box,          uneven_scene,      fixture_cluster,
                                      fixture_pinned_chain, fixture_oscillator};

enum { maker_count = sizeof makers / sizeof *makers };

static subject open_subject(dl_scene *scene) {
    subject s = {.scene = scene};
    dl_error error = {""};
    if (dl_model_create(scene, &s.model, &error) != DL_OK)
        fail_msg("%s", error.message);
    s.n = s.model->unknowns;
    s.y = calloc(2 * s.n, sizeof *s.y);
    s.delta = calloc(s.n, sizeof *s.delta);
    dl_model_initial_state(s.model, s.y);
    const double spread = scene->law.piece[0].until < 1 ? 0.05 : 0.2;
    for (size_t i = 0; i < s.n; i++)
        s.delta[i] = spread * fixture_noise((unsigned)i);
    return s;
}

static void close_subject(subject *s) {
    free(s->y);
    free(s->delta);
    dl_model_free(s->model);
    dl_scene_free(s->scene);
}

static double potential(subject *s) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(s->model, s->y, &energy, NULL), DL_OK);
    return energy.pair + energy.gravity;
}

static double inertia_of(const subject *s, size_t unknown) {
    /* moving particles keep the scene's order */
    size_t moving = unknown % s->model->moving;
    for (size_t i = 0; i < s->scene->particles; i++)
        if (!s->scene->pinned[i] && moving-- == 0)
            return s->scene->inertia[i];
    return 0;
}

static double largest(const double *x, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

/* Central difference with one Richardson step: error of fourth order. */
static double potential_slope(subject *s, size_t i, double h) {
    const double q = s->y[i];
    double difference[2];
    for (int k = 0; k < 2; k++, h /= 2) {
        s->y[i] = q + h;
        const double up = potential(s);
        s->y[i] = q - h;
        difference[k] = (up - potential(s)) / (2 * h);
    }
    s->y[i] = q;
    return (4 * difference[1] - difference[0]) / 3;
}

static void force_is_minus_the_gradient_of_the_energy(void **state) {
    (void)state;
    for (int m = 0; m < maker_count; m++) {
        subject s = open_subject(makers[m]());
        double *const a = malloc(s.n * sizeof *a);
        assert_int_equal(dl_model_acceleration(s.model, s.y, a, NULL), DL_OK);
        const double size = largest(a, s.n);
        for (size_t i = 0; i < s.n; i++) {
            const double expected = -potential_slope(&s, i, 2e-4) / inertia_of(&s, i);
            assert_true(fabs(a[i] - expected) <= 2e-8 * size);
        }
        free(a);
        close_subject(&s);
    }
}

static void jacobian_is_the_derivative_of_the_acceleration(void **state) {
    (void)state;
    for (int m = 0; m < maker_count; m++) {
        subject s = open_subject(makers[m]());
        const size_t n = s.n;
        const dl_sparsity *pattern;
        assert_int_equal(dl_model_sparsity(s.model, s.y, NULL, &pattern, NULL), DL_OK);
        double *const values = malloc(pattern->nonzeros * sizeof *values);
        double *const column = malloc(n * sizeof *column), *const up = malloc(n * sizeof *up);
        double *const down = malloc(n * sizeof *down), *const u = calloc(n, sizeof *u);
        double *const product = malloc(n * sizeof *product);
        assert_int_equal(dl_model_jacobian(s.model, s.y, values, NULL), DL_OK);
        const double size = largest(values, pattern->nonzeros), h = 1e-6;
        for (size_t j = 0; j < n; j++) {
            memset(column, 0, n * sizeof *column);
            for (long k = pattern->column_start[j]; k < pattern->column_start[j + 1]; k++) {
                assert_true(k == pattern->column_start[j] || pattern->row[k] > pattern->row[k - 1]);
                column[pattern->row[k]] = values[k];
            }
            const double q = s.y[j];
            s.y[j] = q + h;
            assert_int_equal(dl_model_acceleration(s.model, s.y, up, NULL), DL_OK);
            s.y[j] = q - h;
            assert_int_equal(dl_model_acceleration(s.model, s.y, down, NULL), DL_OK);
            s.y[j] = q;
            u[j] = 1;
            assert_int_equal(dl_model_jacobian_vector(s.model, s.y, u, product, NULL), DL_OK);
            u[j] = 0;
            for (size_t i = 0; i < n; i++) {
                assert_true(fabs(column[i] - (up[i] - down[i]) / (2 * h)) <= 1e-7 * size);
                assert_true(fabs(column[i] - product[i]) <= 1e-14 * size);
            }
        }
        free(values);
        free(column);
        free(up);
        free(down);
        free(u);
        free(product);
        close_subject(&s);
    }
}

/* sum m a . delta = -(V1 - V0), whatever delta is and whatever breakpoints it crosses. */
static void discrete_work_is_the_change_of_potential(void **state) {
    (void)state;
    for (int m = 0; m < maker_count; m++) {
        subject s = open_subject(makers[m]());
        double *const a = malloc(s.n * sizeof *a);
        double scale;
        assert_int_equal(dl_model_energy_scale(s.model, s.y, &scale, NULL), DL_OK);
        for (int shrink = 0; shrink < 7; shrink++) {
            for (size_t i = 0; i < s.n && shrink > 0; i++)
                s.delta[i] /= 10;
            assert_int_equal(dl_model_discrete_acceleration(s.model, s.y, s.delta, a, NULL), DL_OK);
            long double work = 0;
            for (size_t i = 0; i < s.n; i++)
                work += inertia_of(&s, i) * a[i] * s.delta[i];
            const double before = potential(&s);
            for (size_t i = 0; i < s.n; i++)
                s.y[i] += s.delta[i];
            const double after = potential(&s);
            for (size_t i = 0; i < s.n; i++)
                s.y[i] -= s.delta[i];
            assert_true(fabs((double)work + after - before) <= 1e-12 * (scale + fabs(after)));
        }
        free(a);
        close_subject(&s);
    }
}

static void discrete_forces_cancel(void **state) {
    (void)state;
    scene_maker *const free_ones[] = {stream_scene, fixture_cluster, kepler_scene};
    for (int m = 0; m < 3; m++) {
        subject s = open_subject(free_ones[m]());
        double *const a = malloc(s.n * sizeof *a);
        assert_int_equal(dl_model_discrete_acceleration(s.model, s.y, s.delta, a, NULL), DL_OK);
        double force[3] = {0}, torque = 0;
        const size_t moving = s.model->moving;
        for (size_t k = 0; k < moving; k++) {
            double f[3] = {0}, middle[3] = {0};
            for (size_t c = 0; c < (size_t)s.model->dimension; c++) {
                f[c] = inertia_of(&s, k) * a[c * moving + k];
                middle[c] = s.y[c * moving + k] + s.delta[c * moving + k] / 2;
                force[c] += f[c];
            }
            torque += middle[0] * f[1] - middle[1] * f[0];
        }
        const double size = largest(a, s.n);
        assert_true(largest(force, 3) <= 1e-13 * size * (double)moving);
        assert_true(fabs(torque) <= 1e-12 * size * (double)moving);
        free(a);
        close_subject(&s);
    }
}

static void discrete_jacobian_is_the_derivative(void **state) {
    (void)state;
    for (int m = 0; m < maker_count; m++) {
        subject s = open_subject(makers[m]());
        const size_t n = s.n;
        const dl_sparsity *pattern;
        assert_int_equal(dl_model_sparsity(s.model, s.y, s.delta, &pattern, NULL), DL_OK);
        double *const values = malloc(pattern->nonzeros * sizeof *values);
        double *const column = malloc(n * sizeof *column), *const up = malloc(n * sizeof *up);
        double *const down = malloc(n * sizeof *down);
        assert_int_equal(dl_model_discrete_jacobian(s.model, s.y, s.delta, values, NULL), DL_OK);
        const double size = largest(values, pattern->nonzeros), h = 1e-7;
        for (size_t j = 0; j < n; j++) {
            memset(column, 0, n * sizeof *column);
            for (long k = pattern->column_start[j]; k < pattern->column_start[j + 1]; k++)
                column[pattern->row[k]] = values[k];
            const double d = s.delta[j];
            s.delta[j] = d + h;
            assert_int_equal(dl_model_discrete_acceleration(s.model, s.y, s.delta, up, NULL),
                             DL_OK);
            s.delta[j] = d - h;
            assert_int_equal(dl_model_discrete_acceleration(s.model, s.y, s.delta, down, NULL),
                             DL_OK);
            s.delta[j] = d;
            for (size_t i = 0; i < n; i++)
                assert_true(fabs(column[i] - (up[i] - down[i]) / (2 * h)) <= 2e-6 * size);
        }
        free(values);
        free(column);
        free(up);
        free(down);
        close_subject(&s);
    }
}

/* The flow looks the same elsewhere and under other names. */
static void translation_and_permutation_change_nothing(void **state) {
    (void)state;
    subject s = open_subject(fixture_cluster());
    double a[39], b[39];
    assert_int_equal(s.n, 39);
    assert_int_equal(dl_model_acceleration(s.model, s.y, a, NULL), DL_OK);
    double moved[39];
    for (size_t i = 0; i < 39; i++)
        moved[i] = s.y[i] + 0.5 * (double)(i / 13 + 1);
    assert_int_equal(dl_model_acceleration(s.model, moved, b, NULL), DL_OK);
    for (size_t i = 0; i < 39; i++)
        assert_true(fabs(a[i] - b[i]) <= 1e-12 * largest(a, 39));
    /* particles 1 and 5 have the same inertia and coupling */
    for (size_t c = 0; c < 3; c++) {
        moved[13 * c + 1] = s.y[13 * c + 5];
        moved[13 * c + 5] = s.y[13 * c + 1];
        for (size_t k = 0; k < 13; k++)
            if (k != 1 && k != 5)
                moved[13 * c + k] = s.y[13 * c + k];
    }
    assert_int_equal(dl_model_acceleration(s.model, moved, b, NULL), DL_OK);
    for (size_t c = 0; c < 3; c++) {
        assert_true(fabs(a[13 * c + 1] - b[13 * c + 5]) <= 1e-13 * largest(a, 39));
        assert_true(fabs(a[13 * c + 5] - b[13 * c + 1]) <= 1e-13 * largest(a, 39));
    }
    close_subject(&s);
}

static void coupling_acts_and_inertia_resists(void **state) {
    (void)state;
    subject s = open_subject(fixture_oscillator());
    double a[4], b[4];
    assert_int_equal(dl_model_acceleration(s.model, s.y, a, NULL), DL_OK);
    close_subject(&s);
    dl_scene *const scene = fixture_oscillator();
    scene->coupling[0] = 3;
    scene->inertia[1] *= 5;
    s = open_subject(scene);
    assert_int_equal(dl_model_acceleration(s.model, s.y, b, NULL), DL_OK);
    assert_true(fabs(b[0] - 3 * a[0]) <= 1e-14 * fabs(b[0]));
    assert_true(fabs(b[1] - 3 * a[1] / 5) <= 1e-14 * fabs(b[1]));
    close_subject(&s);
}

static void pinned_particles_act_but_are_no_unknowns(void **state) {
    (void)state;
    subject s = open_subject(fixture_pinned_chain());
    assert_int_equal(s.n, 10);
    double all[28];
    dl_model_expand(s.model, s.y, all);
    for (size_t i = 0; i < 14; i++)
        assert_true(all[i] == s.scene->position[i]);
    /* without the pinned ends the first free particle feels something else */
    double a[10], b[10];
    assert_int_equal(dl_model_acceleration(s.model, s.y, a, NULL), DL_OK);
    s.scene->position[0] -= 0.25;
    dl_model *moved;
    assert_int_equal(dl_model_create(s.scene, &moved, NULL), DL_OK);
    assert_int_equal(dl_model_acceleration(moved, s.y, b, NULL), DL_OK);
    assert_true(fabs(a[0] - b[0]) > 1e-3);
    assert_false(dl_model_conserves_linear_momentum(s.model));
    dl_model_free(moved);
    close_subject(&s);
}

static void mirror_follows_the_papers_order(void **state) {
    (void)state;
    dl_scene *const scene = fixture_scene("corner", 2, 3);
    scene->walls.present = true;
    scene->walls.low[0] = scene->walls.low[1] = 0;
    scene->walls.high[0] = 10;
    scene->walls.damping = 0.9;
    scene->walls.zero_vx_below = 1e-10;
    subject s = open_subject(scene);
    /* through the corner; exactly on the wall; a creeping one through the floor */
    double q[6] = {10.5, 10, 5, -0.25, 0, -1}, v[6] = {8, 1, 9e-11, -4, -1, -3};
    assert_true(dl_model_outside(s.model, q));
    assert_int_equal(dl_model_mirror(s.model, q, v), 3);
    const double there[6] = {9.5, 10, 5, 0.25, 0, 1};
    const double damped[6] = {-0.1 * 8 * 0.1, 1, 0, 0.4 * 0.1, -1, 0.3};
    for (int i = 0; i < 6; i++) {
        assert_true(fabs(q[i] - there[i]) <= 1e-15);
        assert_true(fabs(v[i] - damped[i]) <= 1e-15);
    }
    assert_false(dl_model_outside(s.model, q));
    close_subject(&s);
}

static void energy_scale_ignores_the_speed_of_the_whole(void **state) {
    (void)state;
    subject slow = open_subject(fixture_stream(50)), fast = open_subject(fixture_stream(50));
    for (size_t k = 0; k < fast.n / 2; k++)
        fast.y[fast.n + k] += 1e4;
    double at_rest, moving;
    assert_int_equal(dl_model_energy_scale(slow.model, slow.y, &at_rest, NULL), DL_OK);
    assert_int_equal(dl_model_energy_scale(fast.model, fast.y, &moving, NULL), DL_OK);
    assert_true(fabs(moving / at_rest - 1) <= 1e-9);
    close_subject(&slow);
    close_subject(&fast);
}

static void explain_tells_what_is_left_out(void **state) {
    (void)state;
    static const struct {
        scene_maker *maker;
        const char *present, *absent;
    } rows[] = {
        {listed_box, "neighbour-list", "z components"},
        {stream_scene, "all-pairs", "walls"},
        {fixture_pinned_chain, "2 pinned", "gravity"},
        {fixture_cluster, "3 dimensions", "cutoff"},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        subject s = open_subject(rows[k].maker());
        char *text = NULL;
        size_t size = 0;
        FILE *const out = open_memstream(&text, &size);
        dl_explain(s.model, out);
        fclose(out);
        const char *const left_out = strstr(text, "left out");
        assert_non_null(left_out);
        assert_non_null(strstr(text, rows[k].present));
        assert_null(strstr(left_out, rows[k].present));
        assert_non_null(strstr(left_out, rows[k].absent));
        free(text);
        close_subject(&s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(force_is_minus_the_gradient_of_the_energy),
        cmocka_unit_test(jacobian_is_the_derivative_of_the_acceleration),
        cmocka_unit_test(discrete_work_is_the_change_of_potential),
        cmocka_unit_test(discrete_forces_cancel),
        cmocka_unit_test(discrete_jacobian_is_the_derivative),
        cmocka_unit_test(translation_and_permutation_change_nothing),
        cmocka_unit_test(coupling_acts_and_inertia_resists),
        cmocka_unit_test(pinned_particles_act_but_are_no_unknowns),
        cmocka_unit_test(mirror_follows_the_papers_order),
        cmocka_unit_test(energy_scale_ignores_the_speed_of_the_whole),
        cmocka_unit_test(explain_tells_what_is_left_out),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
