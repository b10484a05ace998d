/* Pair laws by species: sums by hand in every kernel, derivatives, work, methods, scene files. */
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

static dl_pair_law one_piece(double until, double c1, double p1, double c2, double p2) {
    return (dl_pair_law){.pieces = 1,
                         .piece = {{.until = until, .terms = 2, .term = {{c1, p1}, {c2, p2}}}}};
}

static void set_law(dl_scene *scene, size_t a, size_t b, dl_pair_law law) {
    scene->species_law[a * scene->species + b] = law;
    scene->species_law[b * scene->species + a] = law;
}

/* `species` in turn through the particles, all pairs by the scene's law until set_law. */
static void add_species(dl_scene *scene, size_t species) {
    static const char *const names[] = {"argon", "krypton", "ghost"};
    scene->species = species;
    scene->species_name = calloc(species, sizeof *scene->species_name);
    scene->species_law = calloc(species * species, sizeof *scene->species_law);
    scene->species_of = calloc(scene->particles, sizeof *scene->species_of);
    for (size_t k = 0; k < species; k++)
        scene->species_name[k] = fixture_text(names[k]);
    for (size_t k = 0; k < species * species; k++)
        scene->species_law[k] = scene->law;
    for (size_t i = 0; i < scene->particles; i++)
        scene->species_of[i] = (int)(i * i % 7 % species);
    scene->law.pieces = 0;
}

/* Three species, one pair of them without a force, cutoffs and powers unlike, couplings, pins. */
static dl_scene *mixture(int dimension, size_t side, unsigned axes) {
    dl_scene *const scene = fixture_liquid(dimension, side, axes);
    add_species(scene, 3);
    set_law(scene, 0, 1, one_piece(1.2, -3, 4, 4, 9));
    set_law(scene, 1, 1, one_piece(1.6, 2, 2.5, -1.5, 1.25));
    set_law(scene, 2, 2, one_piece(0.9, -1, 3, 5, 6));
    set_law(scene, 0, 2, (dl_pair_law){0});
    for (size_t i = 0; i < scene->particles; i++) {
        scene->coupling[i] = 1 + 0.25 * (double)(i % 4);
        scene->pinned[i] = i % 11 == 5;
    }
    return scene;
}

/* Without a cutoff, and without periods. */
static dl_scene *open_mixture(int dimension, size_t side, unsigned axes) {
    dl_scene *const scene = mixture(dimension, side, axes);
    scene->periods = (dl_periods){0};
    set_law(scene, 0, 0, one_piece(INFINITY, -3, 4, 4, 9));
    return scene;
}

typedef struct sums {
    double *force; /* [dimension * particles], in the scene's order */
    double energy;
} sums;

static void add_copy(const dl_scene *scene, size_t i, size_t j, const double d[3], double r,
                     void *context) {
    sums *const out = context;
    const dl_pair_law *const law = fixture_law_of(scene, i, j);
    const double product = scene->coupling[i] * scene->coupling[j];
    if (scene->pinned[i] && scene->pinned[j])
        return;
    for (size_t c = 0; c < (size_t)scene->dimension; c++) {
        const double f = product * fixture_force(law, r) / r * d[c];
        out->force[c * scene->particles + i] += f;
        out->force[c * scene->particles + j] -= f;
    }
    out->energy += product * fixture_potential(law, r);
}

/* Accelerations of all particles in the scene's order, 0 for pinned ones, and the pair energy. */
static sums evaluate(dl_scene *scene, dl_kernel_choice kernel, double *discrete) {
    dl_model *model;
    dl_error error = {""};
    dl_energy energy;
    scene->kernel = kernel;
    if (dl_model_create(scene, &model, &error) != DL_OK)
        fail_msg("%s", error.message);
    const size_t n = model->unknowns, block = (size_t)scene->dimension * scene->particles;
    double *const y = calloc(2 * n, sizeof *y), *const all = calloc(2 * block, sizeof *all);
    double *const delta = calloc(n, sizeof *delta);
    dl_model_initial_state(model, y);
    for (size_t i = 0; i < n; i++)
        delta[i] = 0.2 * fixture_noise((unsigned)i);
    assert_int_equal(dl_model_energy(model, y, &energy, NULL), DL_OK);
    assert_int_equal(dl_model_discrete_acceleration(model, y, delta, discrete, NULL), DL_OK);
    assert_int_equal(dl_model_acceleration(model, y, y + n, NULL), DL_OK);
    dl_model_expand(model, y, all); /* accelerations in the velocities' place */
    memmove(all, all + block, block * sizeof *all);
    free(y);
    free(delta);
    dl_model_free(model);
    return (sums){all, energy.pair};
}

static double largest(const double *x, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(x[i]));
    return most;
}

static void assert_near(const double *x, const double *y, size_t n, double tolerance) {
    const double size = largest(y, n);
    assert_true(size > 0);
    for (size_t i = 0; i < n; i++)
        if (!(fabs(x[i] - y[i]) <= tolerance * size))
            fail_msg("component %zu: %.17g and %.17g", i, x[i], y[i]);
}

typedef dl_scene *mixture_maker(int dimension, size_t side, unsigned axes);

/* Each kernel and instruction set against the sums by hand, and their discrete forces among
 * themselves. */
static void compare(mixture_maker *make, int dimension, size_t side, unsigned axes) {
    static const char *const sets[] = {"plain", "avx2", "avx512"};
    dl_scene *const scene = make(dimension, side, axes);
    const size_t block = (size_t)dimension * scene->particles;
    sums expected = {calloc(block, sizeof(double)), 0};
    double *const first = calloc(block, sizeof *first), *const discrete =
                                                            calloc(block, sizeof *first);
    fixture_visit_copies(scene, scene->position, add_copy, &expected);
    for (size_t k = 0; k < block; k++)
        if (scene->pinned[k % scene->particles])
            expected.force[k] = 0;
    for (int set = 0; set < 3; set++) {
        if (!dl_vector_force(sets[set]))
            continue;
        for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++) {
            if (choice == DL_KERNEL_NEIGHBOUR_LIST && make == open_mixture)
                continue;
            const bool is_first = set == 0 && choice == DL_KERNEL_REFERENCE;
            const sums got = evaluate(scene, (dl_kernel_choice)choice, is_first ? first : discrete);
            assert_near(got.force, expected.force, block, 1e-13);
            assert_true(fabs(got.energy - expected.energy) <= 1e-12 * fabs(expected.energy));
            if (!is_first)
                assert_near(discrete, first, block, 3e-14);
            free(got.force);
        }
    }
    dl_vector_force(NULL);
    free(expected.force);
    free(first);
    free(discrete);
    dl_scene_free(scene);
}

static void mixture_is_the_sum_of_its_pairs(void **state) {
    (void)state;
    for (size_t side = 4; side <= 9; side += 5)
        for (unsigned axes = 0; axes < 4; axes++)
            compare(mixture, 2, side, axes);
    for (unsigned axes = 0; axes < 8; axes += 7)
        compare(mixture, 3, 5, axes);
    compare(open_mixture, 2, 7, 0);
    compare(open_mixture, 3, 4, 0);
}

/* The same law for every pair: what a scene of one law gives. */
static void equal_laws_reduce_to_one(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++)
        for (unsigned axes = 0; axes < 4; axes += 3) {
            dl_scene *const one = fixture_liquid(2, 7, axes), *const many =
                                                                  fixture_liquid(2, 7, axes);
            double d1[98], d2[98];
            add_species(many, 3);
            const sums a = evaluate(one, (dl_kernel_choice)choice, d1);
            const sums b = evaluate(many, (dl_kernel_choice)choice, d2);
            assert_near(b.force, a.force, 98, 1e-13);
            assert_near(d2, d1, 98, 1e-13);
            assert_true(fabs(a.energy - b.energy) <= 1e-13 * fabs(a.energy));
            free(a.force);
            free(b.force);
            dl_scene_free(one);
            dl_scene_free(many);
        }
}

/* Jacobian, its product, the discrete Jacobian, against differences; the discrete work. */
static void check_derivative(dl_model *model, const double *q, double *at, bool discrete) {
    const size_t n = model->unknowns;
    const double h = 1e-6, *const delta = discrete ? at : NULL;
    const dl_sparsity *pattern;
    double *const up = calloc(n, sizeof *up), *const down = calloc(n, sizeof *down);
    assert_int_equal(dl_model_sparsity(model, q, delta, &pattern, NULL), DL_OK);
    double *const values = calloc(pattern->nonzeros, sizeof *values);
    if (discrete)
        assert_int_equal(dl_model_discrete_jacobian(model, q, delta, values, NULL), DL_OK);
    else
        assert_int_equal(dl_model_jacobian(model, q, values, NULL), DL_OK);
    const double size = largest(values, pattern->nonzeros);
    for (size_t c = 0; c < n; c++) {
        const double middle = at[c];
        for (int sign = -1; sign <= 1; sign += 2) {
            double *const out = sign > 0 ? up : down;
            at[c] = middle + sign * h;
            if (discrete)
                assert_int_equal(dl_model_discrete_acceleration(model, q, at, out, NULL), DL_OK);
            else
                assert_int_equal(dl_model_acceleration(model, at, out, NULL), DL_OK);
        }
        at[c] = middle;
        for (size_t r = 0; r < n; r++)
            up[r] = (up[r] - down[r]) / (2 * h);
        for (long k = pattern->column_start[c]; k < pattern->column_start[c + 1]; k++)
            up[pattern->row[k]] -= values[k];
        assert_true(largest(up, n) <= 1e-6 * size);
    }
    free(values);
    free(up);
    free(down);
}

static void derivatives_are_those_of_the_species(void **state) {
    (void)state;
    for (int choice = DL_KERNEL_REFERENCE; choice <= DL_KERNEL_NEIGHBOUR_LIST; choice++) {
        dl_scene *const scene = mixture(2, 6, 3);
        dl_model *model;
        for (size_t k = 0; k < 9; k++) {
            scene->species_law[k].piece[0].end = DL_END_TAPER;
            scene->species_law[k].piece[0].width = 0.3;
        }
        scene->kernel = (dl_kernel_choice)choice;
        assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
        const size_t n = model->unknowns;
        double *const y = calloc(2 * n, sizeof *y), *const delta = calloc(n, sizeof *delta);
        dl_model_initial_state(model, y);
        for (size_t i = 0; i < n; i++)
            delta[i] = 0.2 * fixture_noise((unsigned)i);
        check_derivative(model, y, y, false);
        check_derivative(model, y, delta, true);
        free(y);
        free(delta);
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

static void conserving_scheme_conserves_the_mixtures_energy(void **state) {
    (void)state;
    for (unsigned axes = 0; axes < 4; axes += 3) {
        dl_scene *const scene = mixture(2, 7, axes);
        set_law(scene, 2, 2, (dl_pair_law){0});
        const dl_method_row *row;
        void *options;
        dl_run_options run_options;
        dl_run_summary summary;
        dl_error error = {""};
        scene->step = 0.002;
        scene->end = 0.4;
        assert_int_equal(dl_method_find("conserving-newton-klu", &row, NULL), DL_OK);
        assert_int_equal(dl_method_options_create(row, scene, &options, NULL), DL_OK);
        dl_run_options_default(&run_options);
        if (dl_run(scene, row, options, &run_options, &summary, NULL, &error) != DL_OK ||
            summary.status != DL_OK)
            fail_msg("%s %s", error.message, summary.message);
        assert_true(summary.energy_error_max <= 1e-12 * summary.energy_scale);
        dl_method_options_free(row, options);
        dl_scene_free(scene);
    }
}

static void a_list_needs_every_law_to_end(void **state) {
    (void)state;
    dl_scene *const scene = open_mixture(2, 9, 0);
    dl_model *model;
    dl_error error = {""};
    scene->kernel = DL_KERNEL_NEIGHBOUR_LIST;
    assert_int_equal(dl_model_create(scene, &model, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "cutoff"));
    scene->kernel = DL_KERNEL_AUTO;
    assert_int_equal(dl_model_create(scene, &model, &error), DL_OK);
    dl_model_free(model);
    dl_scene_free(scene);
}

static void explain_names_every_pair(void **state) {
    (void)state;
    static const char *const expected[] = {"argon: ",
                                           "krypton: ",
                                           "argon with argon",
                                           "argon with krypton",
                                           "krypton with ghost",
                                           "argon with ghost: no force",
                                           "for 0 < r <= 1.2",
                                           "one for each law"};
    dl_scene *const scene = mixture(2, 9, 3);
    dl_model *model;
    char text[8000] = "";
    FILE *const out = tmpfile();
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    dl_explain(model, out);
    rewind(out);
    text[fread(text, 1, sizeof text - 1, out)] = '\0';
    fclose(out);
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
        if (!strstr(text, expected[k]))
            fail_msg("\"%s\" is not in:\n%s", expected[k], text);
    dl_model_free(model);
    dl_scene_free(scene);
}

static void a_restart_keeps_the_species(void **state) {
    (void)state;
    dl_scene *const scene = mixture(2, 4, 3), *copy;
    double *const y = calloc(4 * scene->particles, sizeof *y);
    double d1[32], d2[32];
    memcpy(y, scene->position, 2 * scene->particles * sizeof *y);
    assert_int_equal(dl_scene_restart(scene, y, &copy, NULL), DL_OK);
    const sums a = evaluate(scene, DL_KERNEL_REFERENCE, d1), b = evaluate(copy, DL_KERNEL_AUTO, d2);
    assert_near(b.force, a.force, 32, 1e-13);
    assert_string_equal(copy->species_name[1], "krypton");
    free(a.force);
    free(b.force);
    free(y);
    dl_scene_free(copy);
    dl_scene_free(scene);
}

/* --- scene files -------------------------------------------------------------------------------
 */

static void path_of(const char *ending, char *path, size_t size) {
    snprintf(path, size, "test_species.%ld.%s", (long)getpid(), ending);
}

static void write_text(const char *path, const char *text) {
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

static dl_status read_text(const char *text, dl_scene **scene, dl_error *error) {
    char path[80];
    path_of("yaml", path, sizeof path);
    write_text(path, text);
    const dl_status status = dl_scene_read(path, scene, error);
    remove(path);
    return status;
}

#define HEAD "name: a\ndimension: 2\ntime: {step: 0.1, end: 1}\n"
#define PAIR "particles: [{at: [1, 1], species: A}, {at: [2, 2], species: B}]\n"
#define AA   "  - {between: [A, A], pieces: [{until: 2, terms: [{coefficient: 1, power: 2}]}]}\n"
#define AB   "  - {between: [B, A], pieces: [{until: 3, terms: [{coefficient: 5, power: 4}]}]}\n"
#define BB   "  - {between: [B, B], pieces: none}\n"
#define LAWS "pair_laws:\n" AA AB BB

static void scene_files_give_laws_by_species(void **state) {
    (void)state;
    char data[80], text[800];
    dl_scene *scene;
    dl_error error = {""};
    path_of("csv", data, sizeof data);
    write_text(data, "x,y,species\n5,5,B\n6,6,A\n");
    snprintf(text, sizeof text,
             HEAD LAWS "particles:\n  - {at: [1, 1], species: A}\n  - {file: %s}\n"
                       "  - {at: [2, 2], species: B, coupling: 3}\n",
             data);
    if (read_text(text, &scene, &error) != DL_OK)
        fail_msg("%s", error.message);
    static const int species[] = {0, 1, 0, 1};
    assert_int_equal(scene->species, 2);
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(scene->species_of[i], species[i]);
    assert_string_equal(scene->species_name[0], "A");
    assert_string_equal(scene->species_name[1], "B");
    assert_true(scene->species_law[0].piece[0].until == 2);
    assert_true(scene->species_law[1].piece[0].term[0].coefficient == 5);
    assert_true(scene->species_law[2].piece[0].term[0].coefficient == 5);
    assert_int_equal(scene->species_law[3].pieces, 0);
    assert_true(scene->coupling[3] == 3);
    dl_scene_free(scene);
    write_text(data, "x,y\n5,5\n6,6\n"); /* the species of the item that names the file */
    snprintf(text, sizeof text, HEAD LAWS "particles:\n  - {file: %s, species: B}\n", data);
    if (read_text(text, &scene, &error) != DL_OK)
        fail_msg("%s", error.message);
    assert_int_equal(scene->species_of[0], 1);
    assert_int_equal(scene->species_of[1], 1);
    dl_scene_free(scene);
    remove(data);
}

static void bad_species_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } cases[] = {
        {HEAD PAIR "pair_laws:\n" AA BB,
         ":6: pair_laws: found no law between A and B, expected one (pieces: none for no force)"},
        {HEAD PAIR "pair_laws:\n" AA AB, "found no law between B and B"},
        {HEAD LAWS "particles: [{at: [1, 1], species: a}]\n",
         ":8: species: found \"a\", expected one of A, B; did you mean \"A\"?"},
        {HEAD LAWS "particles: [{at: [1, 1], species: Xenon}]\n",
         ":8: species: found \"Xenon\", expected one of A, B"},
        {HEAD LAWS "particles: [{at: [1, 1]}]\n",
         ":8: species: found nothing, expected one of A, B"},
        {HEAD PAIR, ":4: species: found \"A\", expected none: the scene has no pair_laws"},
        {HEAD PAIR LAWS AB, ":9: between: found a second law between B and A, expected one"},
        {HEAD PAIR LAWS "pair_law: []\n", "expected either pair_law or pair_laws"},
        {HEAD PAIR "pair_laws:\n  - {between: [A], pieces: none}\n",
         ":6: between: found a list of 1, expected a list of two species"},
        {HEAD PAIR "pair_laws:\n  - {between: [A, A]}\n", "pieces: found nothing, expected a list"},
        {HEAD PAIR "pair_laws:\n  - {between: [A, A], pieces: []}\n",
         "expected a list of pieces, or none for no force"},
        {HEAD PAIR "pair_laws:\n  - {betwen: [A, A], pieces: none}\n", "did you mean \"between\"?"},
        {HEAD PAIR "pair_laws: none\n", ":5: pair_laws: found"},
        {HEAD PAIR LAWS "periodic: {x: [0, 5.9]}\n", "expected at least 6, twice the longest"},
        {HEAD PAIR LAWS AA, "found a second law between A and A"},
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

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mixture_is_the_sum_of_its_pairs),
        cmocka_unit_test(equal_laws_reduce_to_one),
        cmocka_unit_test(derivatives_are_those_of_the_species),
        cmocka_unit_test(conserving_scheme_conserves_the_mixtures_energy),
        cmocka_unit_test(a_list_needs_every_law_to_end),
        cmocka_unit_test(explain_names_every_pair),
        cmocka_unit_test(a_restart_keeps_the_species),
        cmocka_unit_test(scene_files_give_laws_by_species),
        cmocka_unit_test(bad_species_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
