/* Periodic boxes: forces of the nearest copies in every kernel, energies, Jacobians, the discrete
 * gradient across the boundary, methods, scene files and trajectories. */
#include <hdf5.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>
#include <cmocka.h>

#include "driftlab/explain.h"
#include "driftlab/run.h"
#include "driftlab/trajectory.h"
#include "fixture_periodic.h"
#include "force/vector_ops.h"

/* A scene, its model and its initial state. */
typedef struct subject {
    dl_scene *scene;
    dl_model *model;
    size_t n;
    double *y, *delta;
} subject;

static subject open_subject(dl_scene *scene, dl_kernel_choice kernel) {
    subject s = {.scene = scene};
    dl_error error = {""};
    scene->kernel = kernel;
    if (dl_model_create(scene, &s.model, &error) != DL_OK)
        fail_msg("%s", error.message);
    s.n = s.model->unknowns;
    s.y = calloc(2 * s.n, sizeof *s.y);
    s.delta = calloc(s.n, sizeof *s.delta);
    dl_model_initial_state(s.model, s.y);
    for (size_t i = 0; i < s.n; i++)
        s.delta[i] = 0.2 * fixture_noise((unsigned)i + 7);
    return s;
}

static void close_subject(subject *s) {
    free(s->y);
    free(s->delta);
    dl_model_free(s->model);
    dl_scene_free(s->scene);
}

static double period_of(const subject *s, size_t unknown) {
    return s->scene->periods.length[unknown / s->model->moving];
}

static double pair_energy(subject *s, const double *q) {
    double *const y = calloc(2 * s->n, sizeof *y);
    dl_energy energy;
    memcpy(y, q, s->n * sizeof *y);
    assert_int_equal(dl_model_energy(s->model, y, &energy, NULL), DL_OK);
    free(y);
    return energy.pair;
}

static double largest(const double *x, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

static void assert_near(const double *x, const double *y, size_t n, double tolerance) {
    const double size = largest(y, n);
    for (size_t i = 0; i < n; i++)
        if (!(fabs(x[i] - y[i]) <= tolerance * size))
            fail_msg("component %zu: %.17g and %.17g", i, x[i], y[i]);
}

static double *accelerations(subject *s, const double *q) {
    double *const a = calloc(s->n, sizeof *a);
    assert_int_equal(dl_model_acceleration(s->model, q, a, NULL), DL_OK);
    return a;
}

/* Long steps in which every fifth component goes by a period, one way or the other, so that nearest
 * copies change and pairs meet on the other side, without coming too near one another. */
static void take_long_steps(subject *s) {
    for (size_t i = 0; i < s->n; i += 5)
        s->delta[i] += period_of(s, i) * (i % 10 ? -1 : 1);
}

/* --- forces ------------------------------------------------------------------------------------
 */

typedef struct sums {
    double *force, energy;
} sums;

static void add_copy(const dl_scene *scene, size_t i, size_t j, const double d[3], double r,
                     void *context) {
    sums *const out = context;
    const double f = fixture_force(&scene->law, r) / r;
    for (size_t c = 0; c < (size_t)scene->dimension; c++) {
        out->force[c * scene->particles + i] += f * d[c];
        out->force[c * scene->particles + j] -= f * d[c];
    }
    out->energy += fixture_potential(&scene->law, r);
}

static void reference_is_the_sum_over_all_copies(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (unsigned axes = 1; axes < 1U << dimension; axes++)
            for (size_t side = 3; side <= 5; side++) {
                subject s =
                    open_subject(fixture_liquid(dimension, side, axes), DL_KERNEL_REFERENCE);
                sums expected = {calloc(s.n, sizeof(double)), 0};
                fixture_visit_copies(s.scene, s.scene->position, add_copy, &expected);
                double *const a = accelerations(&s, s.y);
                assert_near(a, expected.force, s.n, 1e-13);
                const double v = pair_energy(&s, s.y);
                assert_true(fabs(v - expected.energy) <= 1e-12 * fabs(expected.energy));
                free(a);
                free(expected.force);
                close_subject(&s);
            }
}

/* Another arrangement than the lattice: moved, over many periods for some. */
static void scatter_over_periods(subject *s) {
    for (size_t i = 0; i < s->n; i++)
        s->y[i] += 0.1 * fixture_noise((unsigned)i + 1000) + period_of(s, i) * (double)(i % 5) -
                   2 * period_of(s, i);
}

typedef struct answer {
    double *a, *discrete;
} answer;

static answer evaluate(dl_scene *scene, dl_kernel_choice kernel) {
    subject s = open_subject(scene, kernel);
    answer out = {calloc(s.n, sizeof(double)), calloc(s.n, sizeof(double))};
    scatter_over_periods(&s);
    take_long_steps(&s);
    dl_error error = {""};
    if (dl_model_acceleration(s.model, s.y, out.a, &error) != DL_OK ||
        dl_model_discrete_acceleration(s.model, s.y, s.delta, out.discrete, &error) != DL_OK)
        fail_msg("%s", error.message);
    close_subject(&s);
    return out;
}

static dl_scene *compared_liquid(int dimension, size_t side, unsigned axes, int variant) {
    dl_scene *const scene = fixture_liquid(dimension, side, axes);
    if (variant) { /* couplings, a pin, powers that no specialised loop has */
        for (size_t i = 0; i < scene->particles; i++)
            scene->coupling[i] = 1 + 0.5 * (double)(i % 3);
        fixture_law(scene, 1.5, 2, 3.5, 2, 6.25);
        scene->pinned[3] = true;
    }
    return scene;
}

static void compare_kernels(int dimension, size_t side, unsigned axes, int variant) {
    static const char *const sets[] = {"plain", "avx2", "avx512"};
    dl_scene *const scene = compared_liquid(dimension, side, axes, variant);
    const size_t moving = scene->particles - (variant ? 1 : 0), n = (size_t)dimension * moving;
    dl_scene_free(scene);
    const answer expected =
        evaluate(compared_liquid(dimension, side, axes, variant), DL_KERNEL_REFERENCE);
    for (int set = 0; set < 3; set++) {
        if (!dl_vector_force(sets[set]))
            continue;
        for (int choice = DL_KERNEL_ALL_PAIRS; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++) {
            const answer got =
                evaluate(compared_liquid(dimension, side, axes, variant), (dl_kernel_choice)choice);
            assert_near(got.a, expected.a, n, 3e-14);
            assert_near(got.discrete, expected.discrete, n, 3e-14);
            free(got.a);
            free(got.discrete);
        }
    }
    dl_vector_force(NULL);
    free(expected.a);
    free(expected.discrete);
}

/* Sides 3 to 9: one, two, three and four cells a period. */
static void every_kernel_equals_the_reference(void **state) {
    (void)state;
    static const size_t sides[2][5] = {{3, 4, 6, 9, 17}, {3, 4, 6, 8, 0}};
    for (int dimension = 2; dimension <= 3; dimension++)
        for (unsigned axes = 1; axes < 1U << dimension; axes++)
            for (int size = 0; size < 5 && sides[dimension - 2][size]; size++)
                for (int variant = 0; variant < 2; variant++)
                    if (dimension == 2 || size < 3 || (axes == 7) != (variant == 1))
                        compare_kernels(dimension, sides[dimension - 2][size], axes, variant);
}

static void shifting_everything_changes_nothing(void **state) {
    (void)state;
    static const double shifts[][3] = {{0.3, -0.7, 2.2}, {5.5, 1.1, -3.3}, {-17.25, 100.5, 0.01}};
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++)
        for (int dimension = 2; dimension <= 3; dimension++) {
            subject s = open_subject(fixture_liquid(dimension, 5, dimension == 2 ? 3 : 7),
                                     (dl_kernel_choice)choice);
            double *const before = accelerations(&s, s.y);
            const double energy = pair_energy(&s, s.y);
            for (size_t k = 0; k < sizeof shifts / sizeof *shifts; k++) {
                double *const q = calloc(s.n, sizeof *q);
                for (size_t i = 0; i < s.n; i++)
                    q[i] = s.y[i] + shifts[k][i / s.model->moving];
                double *const after = accelerations(&s, q);
                assert_near(after, before, s.n, 2e-12); /* positions of 100 have lost digits */
                assert_true(fabs(pair_energy(&s, q) - energy) <= 1e-11 * fabs(energy));
                free(q);
                free(after);
            }
            free(before);
            close_subject(&s);
        }
}

static void moving_a_particle_by_periods_changes_nothing(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++)
        for (unsigned axes = 1; axes < 8; axes++) {
            subject s = open_subject(fixture_liquid(3, 4, axes), (dl_kernel_choice)choice);
            double *const before = accelerations(&s, s.y);
            for (size_t i = 0; i < s.n; i += 3)
                s.y[i] += period_of(&s, i) * (double)((int)(i % 7) - 3);
            double *const after = accelerations(&s, s.y);
            assert_near(after, before, s.n, 1e-12);
            free(before);
            free(after);
            close_subject(&s);
        }
}

/* Particles run through many periods, creeping, walking and jumping. */
static void neighbour_list_follows_any_motion(void **state) {
    (void)state;
    for (size_t side = 3; side <= 7; side += 2) {
        subject listed = open_subject(fixture_liquid(2, side, 3), DL_KERNEL_NEIGHBOUR_LIST);
        subject plain = open_subject(fixture_liquid(2, side, 3), DL_KERNEL_REFERENCE);
        for (unsigned step = 0; step < 200; step++) {
            const double stride = step % 50 == 49 ? 20 : step % 10 == 9 ? 0.3 : 0.02;
            for (size_t i = 0; i < listed.n; i++)
                listed.y[i] += stride * (1 + 0.2 * fixture_noise(step * 97 + (unsigned)i));
            double *const a = accelerations(&listed, listed.y);
            double *const b = accelerations(&plain, listed.y);
            assert_near(a, b, listed.n, 3e-14);
            free(a);
            free(b);
        }
        assert_true(dl_model_list_builds(listed.model) > 5);
        assert_true(dl_model_list_builds(listed.model) < 120);
        close_subject(&listed);
        close_subject(&plain);
    }
}

static void runaways_do_not_break_the_list(void **state) {
    (void)state;
    subject s = open_subject(fixture_liquid(2, 5, 1), DL_KERNEL_NEIGHBOUR_LIST);
    double *const a = calloc(s.n, sizeof *a);
    s.y[0] = 1e300;
    s.y[s.model->moving + 1] = -1e300;
    assert_int_equal(dl_model_acceleration(s.model, s.y, a, NULL), DL_OK);
    s.y[2] = NAN;
    assert_int_equal(dl_model_acceleration(s.model, s.y, a, NULL), DL_UNSTABLE);
    free(a);
    close_subject(&s);
}

/* --- energy and derivatives --------------------------------------------------------------------
 */

static void force_is_minus_the_gradient(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++) {
        subject s = open_subject(fixture_liquid(3, 4, 5), (dl_kernel_choice)choice);
        double *const a = accelerations(&s, s.y);
        const double size = largest(a, s.n), h = 1e-5;
        for (size_t i = 0; i < s.n; i++) {
            const double q = s.y[i];
            s.y[i] = q + h;
            const double up = pair_energy(&s, s.y);
            s.y[i] = q - h;
            const double down = pair_energy(&s, s.y);
            s.y[i] = q;
            assert_true(fabs(a[i] + (up - down) / (2 * h)) <= 1e-7 * size);
        }
        free(a);
        close_subject(&s);
    }
}

/* Where no pair is so near a breakpoint that a difference would step over it. */
typedef dl_status field(subject *s, const double *at, double *value);

static dl_status field_of_force(subject *s, const double *at, double *value) {
    return dl_model_acceleration(s->model, at, value, NULL);
}

static dl_status field_of_discrete(subject *s, const double *at, double *value) {
    return dl_model_discrete_acceleration(s->model, s->y, at, value, NULL);
}

static void compare_with_differences(subject *s, field *of, double *at, const double *values,
                                     const dl_sparsity *pattern) {
    double *const up = calloc(s->n, sizeof *up), *const down = calloc(s->n, sizeof *down);
    double *const column = calloc(s->n, sizeof *column);
    const double h = 1e-6, size = largest(values, pattern->nonzeros);
    for (size_t c = 0; c < s->n; c++) {
        const double middle = at[c];
        at[c] = middle + h;
        assert_int_equal(of(s, at, up), DL_OK);
        at[c] = middle - h;
        assert_int_equal(of(s, at, down), DL_OK);
        at[c] = middle;
        memset(column, 0, s->n * sizeof *column);
        for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++)
            column[pattern->row[k]] = values[k];
        for (size_t r = 0; r < s->n; r++)
            if (!(fabs(column[r] - (up[r] - down[r]) / (2 * h)) <= 1e-6 * size))
                fail_msg("(%zu, %zu): %.10g and %.10g", r, c, column[r],
                         (up[r] - down[r]) / (2 * h));
    }
    free(up);
    free(down);
    free(column);
}

/* Force and potential go to zero smoothly enough at the cutoff for differences to be taken. */
static dl_scene *smooth_liquid(int dimension, size_t side, unsigned axes) {
    dl_scene *const scene = fixture_liquid(dimension, side, axes);
    scene->law.piece[0].end = DL_END_TAPER;
    scene->law.piece[0].width = 0.4;
    return scene;
}

static void jacobian_is_the_derivative(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++)
        for (int dimension = 2; dimension <= 3; dimension++) {
            subject s = open_subject(smooth_liquid(dimension, 4, dimension == 2 ? 2 : 7),
                                     (dl_kernel_choice)choice);
            const dl_sparsity *pattern;
            assert_int_equal(dl_model_sparsity(s.model, s.y, NULL, &pattern, NULL), DL_OK);
            double *const values = calloc(pattern->nonzeros, sizeof *values);
            assert_int_equal(dl_model_jacobian(s.model, s.y, values, NULL), DL_OK);
            compare_with_differences(&s, field_of_force, s.y, values, pattern);
            double *const product = calloc(s.n, sizeof *product);
            double *const expected = calloc(s.n, sizeof *expected);
            assert_int_equal(dl_model_jacobian_vector(s.model, s.y, s.delta, product, NULL), DL_OK);
            for (size_t c = 0; c < s.n; c++)
                for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++)
                    expected[pattern->row[k]] += values[k] * s.delta[c];
            assert_near(product, expected, s.n, 1e-13);
            free(values);
            free(product);
            free(expected);
            close_subject(&s);
        }
}

static void discrete_jacobian_is_the_derivative(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++) {
        subject s = open_subject(smooth_liquid(2, 5, 3), (dl_kernel_choice)choice);
        take_long_steps(&s);
        const dl_sparsity *pattern;
        assert_int_equal(dl_model_sparsity(s.model, s.y, s.delta, &pattern, NULL), DL_OK);
        double *const values = calloc(pattern->nonzeros, sizeof *values);
        assert_int_equal(dl_model_discrete_jacobian(s.model, s.y, s.delta, values, NULL), DL_OK);
        compare_with_differences(&s, field_of_discrete, s.delta, values, pattern);
        free(values);
        close_subject(&s);
    }
}

/* --- the discrete gradient ---------------------------------------------------------------------
 */

/* Pairs whose nearest copy changes during the step to one that is within reach. */
static size_t meetings_on_the_other_side(const subject *s) {
    size_t n = s->model->moving, count = 0;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++) {
            bool changes = false;
            double r2 = 0;
            for (size_t c = 0; c < (size_t)s->scene->dimension; c++) {
                const double length = s->scene->periods.length[c];
                double d = s->y[c * n + i] - s->y[c * n + j];
                d = length > 0 ? remainder(d, length) : d;
                double end = d + s->delta[c * n + i] - s->delta[c * n + j];
                double nearest = length > 0 ? remainder(end, length) : end;
                changes |= fabs(nearest - end) > 1e-9;
                r2 += nearest * nearest;
            }
            count += changes && r2 < 1.5 * 1.5;
        }
    return count;
}

static void discrete_work_is_exact_across_the_boundary(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++)
        for (int dimension = 2; dimension <= 3; dimension++)
            for (unsigned axes = 1; axes < 1U << dimension; axes++)
                for (int long_steps = 0; long_steps < 2; long_steps++) {
                    subject s =
                        open_subject(fixture_liquid(dimension, 5, axes), (dl_kernel_choice)choice);
                    if (long_steps)
                        take_long_steps(&s);
                    double *const a = calloc(s.n, sizeof *a), *const q = calloc(s.n, sizeof *q);
                    assert_true(!long_steps || meetings_on_the_other_side(&s) > 0);
                    for (size_t i = 0; i < s.n; i++)
                        q[i] = s.y[i] + s.delta[i];
                    assert_int_equal(dl_model_discrete_acceleration(s.model, s.y, s.delta, a, NULL),
                                     DL_OK);
                    const double v0 = pair_energy(&s, s.y), v1 = pair_energy(&s, q);
                    const double work = dl_model_work(s.model, a, s.delta);
                    double size = fabs(v0) + fabs(v1);
                    for (size_t i = 0; i < s.n; i++)
                        size += fabs(a[i] * s.delta[i]);
                    if (!(fabs(work + v1 - v0) <= 1e-13 * size))
                        fail_msg("work %.17g, drop of the potential %.17g", work, v0 - v1);
                    free(a);
                    free(q);
                    close_subject(&s);
                }
}

/* --- methods -----------------------------------------------------------------------------------
 */

static dl_run_summary run(dl_scene *scene, const char *method, double step, double end) {
    const dl_method_row *row;
    void *options;
    char text[40];
    dl_run_options run_options;
    dl_run_summary summary;
    dl_error error = {""};
    assert_int_equal(dl_method_find(method, &row, NULL), DL_OK);
    scene->step = step;
    scene->end = end;
    assert_int_equal(dl_method_options_create(row, scene, &options, NULL), DL_OK);
    snprintf(text, sizeof text, "%.17g", step);
    assert_int_equal(dl_method_options_set(row, options, "step", text, NULL), DL_OK);
    dl_run_options_default(&run_options);
    if (dl_run(scene, row, options, &run_options, &summary, NULL, &error) != DL_OK)
        fail_msg("%s", error.message);
    if (summary.status != DL_OK)
        fail_msg("%s: %s", method, summary.message);
    dl_method_options_free(row, options);
    return summary;
}

/* The hard cutoff is no obstacle: pairs cross it, and the boundary, in every step. */
static void conserving_scheme_conserves_energy(void **state) {
    (void)state;
    static const char *const methods[] = {"conserving-fixed-point", "conserving-newton-klu"};
    for (size_t m = 0; m < 2; m++)
        for (int dimension = 2; dimension <= 3; dimension++) {
            dl_scene *const scene =
                fixture_liquid(dimension, dimension == 2 ? 6 : 4, dimension == 2 ? 3 : 7);
            const dl_run_summary summary = run(scene, methods[m], 0.005, 1);
            assert_true(summary.energy_error_max <= 1e-12 * summary.energy_scale);
            assert_true(summary.momentum_error_max <= 1e-12 * summary.momentum_scale);
            dl_scene_free(scene);
        }
}

static void leapfrog_conserves_momentum(void **state) {
    (void)state;
    dl_scene *const scene = smooth_liquid(2, 9, 3);
    const dl_run_summary summary = run(scene, "leapfrog", 0.002, 2);
    assert_true(summary.momentum_error_max <= 1e-12 * summary.momentum_scale);
    assert_true(summary.energy_error_max <= 1e-3 * summary.energy_scale);
    assert_true(summary.energy_error_max > 1e-9 * summary.energy_scale);
    dl_scene_free(scene);
}

static void symmetries_are_the_boxes(void **state) {
    (void)state;
    subject s = open_subject(fixture_liquid(2, 4, 1), DL_KERNEL_AUTO);
    assert_true(dl_model_conserves_linear_momentum(s.model));
    assert_false(dl_model_conserves_angular_momentum(s.model));
    assert_true(dl_model_is_galilean_invariant(s.model));
    char text[4000] = "";
    FILE *const out = tmpfile();
    dl_explain(s.model, out);
    rewind(out);
    text[fread(text, 1, sizeof text - 1, out)] = '\0';
    fclose(out);
    assert_non_null(strstr(text, "x by 4.4"));
    assert_null(strstr(text, "y by"));
    assert_null(strstr(text, "angular momentum"));
    close_subject(&s);
}

/* --- scene files -------------------------------------------------------------------------------
 */

static void scene_path(char *path, size_t size) {
    snprintf(path, size, "test_periodic.%ld.yaml", (long)getpid());
}

static dl_status read_text(const char *text, dl_scene **scene, dl_error *error) {
    char path[80];
    scene_path(path, sizeof path);
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    const dl_status status = dl_scene_read(path, scene, error);
    remove(path);
    return status;
}

#define HEAD "name: a\ndimension: 2\ntime: {step: 0.1, end: 1}\n"
#define PAIR "particles: [{at: [1, 1]}, {at: [2, 2]}]\n"
#define LAW  "pair_law: [{until: 2.5, terms: [{coefficient: 1, power: 2}]}]\n"

static void what_does_not_go_with_a_period_is_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {HEAD PAIR LAW "periodic: {x: [0, 4]}\n",
         ":6: x: found a period of 4, expected at least 5, twice the longest cutoff 2.5"},
        {HEAD PAIR LAW "periodic: {y: [0, 4.999]}\n", ":6: y: found a period of 4.999, expected"},
        {HEAD PAIR LAW "walls: {x: [0, none]}\nperiodic: {x: [0, 9]}\n",
         ":7: x: found a period, expected no period along an axis that has walls"},
        {HEAD PAIR LAW "gravity: [0, -1]\nperiodic: {y: [0, 9]}\n",
         ":7: y: found a period, expected no period along an axis that gravity acts along"},
        {HEAD PAIR "pair_law: [{terms: [{coefficient: 1, power: 2}]}]\nperiodic: {y: [0, 9]}\n",
         ":6: y: found a period, expected no period where a pair law never ends"},
        {HEAD PAIR LAW "periodic: {z: [0, 9]}\n", ":6: z: found a list of 2"},
        {HEAD PAIR LAW "periodic: {x: [9, 0]}\n", ":6: x: found [9, 0], expected low < high"},
        {HEAD PAIR LAW "periodic: {x: [0, none]}\n", "expected a number"},
        {HEAD PAIR LAW "periodic: {w: [0, 9]}\n", "found the key \"w\", expected one of x, y, z"},
        {HEAD PAIR LAW "periodic: 5\n", ":6: periodic: found"},
        /* copies to rounding only */
        {HEAD "particles: [{at: [0.7, 1]}, {at: [16.3, 1]}]\n" LAW "periodic: {x: [0.1, 5.3]}\n",
         "where the particle of"},
        {HEAD "particles: [{at: [0.1, 1]}, {at: [9.2, 1]}]\n" LAW "periodic: {x: [0.1, 9.2]}\n",
         "where the particle of"},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        dl_scene *scene;
        dl_error error = {""};
        assert_int_equal(read_text(cases[k].text, &scene, &error), DL_INPUT);
        assert_null(scene);
        if (!strstr(error.message, cases[k].message))
            fail_msg("\"%s\" is not in: %s", cases[k].message, error.message);
    }
}

static void positions_are_moved_into_the_period(void **state) {
    (void)state;
    dl_scene *scene;
    dl_error error = {""};
    if (read_text(HEAD "particles: [{at: [1.25, 1]}, {at: [-0.25, 33]}, {at: [25.5, -8]}]\n" LAW
                       "periodic: {x: [0, 5]}\n",
                  &scene, &error) != DL_OK)
        fail_msg("%s", error.message);
    static const double expected[] = {1.25, 4.75, 0.5, 1, 33, -8};
    for (size_t i = 0; i < 6; i++)
        assert_true(scene->position[i] == expected[i]);
    assert_true(scene->periods.length[0] == 5 && scene->periods.length[1] == 0);
    dl_scene_free(scene);
}

/* A wall across the box, gravity across it, and nothing but free flight along it. */
static void walls_and_gravity_across_are_allowed(void **state) {
    (void)state;
    dl_scene *scene;
    dl_error error = {""};
    if (read_text(HEAD PAIR LAW "gravity: [0, -1]\nwalls: {y: [0, none]}\nperiodic: {x: [0, 5]}\n",
                  &scene, &error) != DL_OK)
        fail_msg("%s", error.message);
    dl_scene_free(scene);
    if (read_text(HEAD PAIR "periodic: {x: [0, 5], y: [0, 1.5]}\n", &scene, &error) != DL_OK)
        fail_msg("%s", error.message);
    dl_scene_free(scene);
}

/* --- trajectories ------------------------------------------------------------------------------
 */

static void read_box(const char *path, char boundary[3][16], double edges[9]) {
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t box = H5Gopen2(file, "/particles/all/box", H5P_DEFAULT);
    const hid_t attribute = H5Aopen(box, "boundary", H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute), data = H5Dopen2(box, "edges/value", H5P_DEFAULT);
    const size_t length = H5Tget_size(type);
    char texts[64] = "";
    assert_true(length <= 16);
    assert_true(H5Aread(attribute, type, texts) >= 0);
    for (size_t c = 0; c < 3; c++) {
        memset(boundary[c], 0, 16);
        memcpy(boundary[c], texts + c * length, length);
    }
    const hsize_t one[3] = {1, 3, 3}, start[3] = {0, 0, 0};
    const hid_t memory = H5Screate_simple(3, one, NULL), space = H5Dget_space(data);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, NULL, one, NULL);
    assert_true(H5Dread(data, H5T_NATIVE_DOUBLE, memory, space, H5P_DEFAULT, edges) >= 0);
    H5Sclose(memory);
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    H5Dclose(data);
    H5Gclose(box);
    H5Fclose(file);
}

static void trajectories_tell_the_box(void **state) {
    (void)state;
    char path[80], boundary[3][16];
    double edges[9];
    snprintf(path, sizeof path, "test_periodic.%ld.h5", (long)getpid());
    dl_scene *const scene = fixture_liquid(2, 4, 1);
    dl_trajectory *trajectory;
    double *const y = calloc(4 * scene->particles, sizeof *y);
    memcpy(y, scene->position, 2 * scene->particles * sizeof *y);
    assert_int_equal(dl_trajectory_create(path, scene, "none", "", &trajectory, NULL), DL_OK);
    const dl_sample sample = {.y_all = y};
    assert_int_equal(dl_trajectory_append(trajectory, &sample, NULL), DL_OK);
    assert_int_equal(dl_trajectory_close(trajectory, NULL), DL_OK);
    read_box(path, boundary, edges);
    assert_string_equal(boundary[0], "periodic");
    assert_string_equal(boundary[1], "none");
    assert_string_equal(boundary[2], "none");
    assert_true(edges[0] == scene->periods.length[0]);
    assert_true(edges[4] > 3 && edges[4] < 3.6 && edges[1] == 0 && edges[3] == 0);
    remove(path);
    free(y);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reference_is_the_sum_over_all_copies),
        cmocka_unit_test(every_kernel_equals_the_reference),
        cmocka_unit_test(shifting_everything_changes_nothing),
        cmocka_unit_test(moving_a_particle_by_periods_changes_nothing),
        cmocka_unit_test(neighbour_list_follows_any_motion),
        cmocka_unit_test(runaways_do_not_break_the_list),
        cmocka_unit_test(force_is_minus_the_gradient),
        cmocka_unit_test(jacobian_is_the_derivative),
        cmocka_unit_test(discrete_jacobian_is_the_derivative),
        cmocka_unit_test(discrete_work_is_exact_across_the_boundary),
        cmocka_unit_test(conserving_scheme_conserves_energy),
        cmocka_unit_test(leapfrog_conserves_momentum),
        cmocka_unit_test(symmetries_are_the_boxes),
        cmocka_unit_test(what_does_not_go_with_a_period_is_refused),
        cmocka_unit_test(positions_are_moved_into_the_period),
        cmocka_unit_test(walls_and_gravity_across_are_allowed),
        cmocka_unit_test(trajectories_tell_the_box),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
