/* The tree kernel: its stated error on particles of every kind, its cost, and what holds exactly
 * whatever the error. */
#include "contract.h"

#include "driftlab/explain.h"
#include "driftlab/run.h"
#include "fixture_periodic.h"
#include "model/private.h"

/* --- particles ----------------------------------------------------------------------------------
 */

typedef enum spread { UNIFORM, CLUSTERED, FAR_APART, COLUMNS, SPREADS } spread;

/* A closed formula, with no pattern that cells could see: in [0, 1). */
static double scattered(size_t i, int axis) {
    static const double step[] = {0.7548776662466927, 0.5698402909980532, 0.3819660112501051};
    const double x = 0.5 + step[axis] * (double)(i + 1) + 0.13 * sin(3.7 * (double)i + axis);
    return x - floor(x);
}

static void place(dl_scene *scene, size_t i, size_t from, spread how) {
    const double length = pow((double)scene->particles, 1.0 / scene->dimension);
    const double still[3] = {0, 0, 0};
    double x[3] = {0};
    for (int c = 0; c < scene->dimension; c++)
        x[c] = length * scattered(from, c);
    if (how == CLUSTERED) {
        const double r = pow(scattered(from + 77, 0), 3);
        for (int c = 0; c < scene->dimension; c++)
            x[c] = length * r * (scattered(from, c) - 0.5);
    }
    if (how == FAR_APART && from % 2)
        x[0] += 1000 * length;
    if (how == COLUMNS)
        x[0] = floor(x[0] / length * 4);
    fixture_place(scene, i, x, still);
    scene->coupling[i] = 0.5 + scattered(from + 5, 0);
}

static dl_scene *scene_of(int dimension, size_t particles, spread how, double power) {
    dl_scene *const scene = fixture_scene("tree", dimension, particles);
    for (size_t i = 0; i < particles; i++)
        place(scene, i, i, how);
    scene->law.pieces = 1;
    scene->law.piece[0] =
        (dl_piece){.until = INFINITY, .terms = 1, .term = {{.coefficient = -1, .power = power}}};
    scene->kernel = DL_KERNEL_TREE;
    return scene;
}

static const dl_pair_law swirl = {2,
                                  {{.until = 2.3, .terms = 2, .term = {{5, 6}, {-5, 4}}},
                                   {.until = INFINITY, .terms = 1, .term = {{-1e-3, 2}}}}};
static const dl_pair_law tapered = {
    2,
    {{.until = 3, .terms = 1, .term = {{1, 2}}, .end = DL_END_TAPER, .width = 1},
     {.until = INFINITY, .terms = 2, .term = {{-1, 1}, {0.5, 2.5}}}}};
static const dl_pair_law shifted = {
    1, {{.until = 40, .terms = 1, .term = {{-1, 2}}, .end = DL_END_SHIFTED_FORCE}}};

static dl_model *model_of(const dl_scene *scene) {
    dl_model *model;
    dl_error error = {""};
    if (dl_model_create(scene, &model, &error))
        fail_msg("%s", error.message);
    return model;
}

static double *forces_of(dl_model *model, const double *x) {
    dl_error error = {""};
    double *const f = malloc((size_t)model->dimension * model->particles * sizeof *f);
    assert_non_null(f);
    assert_int_equal(model->kernel->ops->force(model->kernel, x, f, &error), DL_OK);
    return f;
}

/* --- the error ----------------------------------------------------------------------------------
 */

/* Sums of this file's own, over every `stride`th particle. */
static void measure(const dl_scene *scene, size_t stride, double *largest, double *mean) {
    dl_model *const model = model_of(scene);
    double *const f = forces_of(model, scene->position);
    const size_t n = scene->particles;
    size_t count = 0;
    *largest = *mean = 0;
    for (size_t i = 0; i < n; i += stride, count++) {
        double sum[3] = {0}, moduli = 0, square = 0;
        for (size_t j = 0; j < n; j++) {
            double d[3] = {0}, s = 0;
            for (int c = 0; c < scene->dimension; c++) {
                const double *const row = scene->position + (size_t)c * n;
                d[c] = row[i] - row[j];
                s += d[c] * d[c];
            }
            if (i == j)
                continue;
            const double over_r =
                scene->coupling[i] * scene->coupling[j] * dl_law_force_over_r(model->priv->law, s);
            for (int c = 0; c < scene->dimension; c++)
                sum[c] += over_r * d[c];
            moduli += fabs(over_r) * sqrt(s);
        }
        for (int c = 0; c < scene->dimension; c++)
            square += pow(f[(size_t)c * n + i] - sum[c], 2);
        *largest = fmax(*largest, sqrt(square) / moduli);
        *mean += sqrt(square) / moduli;
    }
    *mean /= (double)count;
    free(f);
    dl_model_free(model);
}

static void error_is_as_stated(void **state) {
    (void)state;
    static const double powers[] = {2, 1, 2.5};
    static const double errors[] = {1e-2, 1e-4, 1e-6};
    for (int dimension = 2; dimension <= 3; dimension++)
        for (spread how = UNIFORM; how < SPREADS; how++)
            for (size_t p = 0; p < 3; p++) {
                dl_scene *const scene = scene_of(dimension, 2000, how, powers[p]);
                for (size_t e = 0; e < 3; e++) {
                    double largest, mean;
                    scene->tree_error = errors[e];
                    measure(scene, 67, &largest, &mean);
                    if (!(largest <= errors[e]))
                        fail_msg("%d-D, spread %d, power %g: %g, stated %g", dimension, (int)how,
                                 powers[p], largest, errors[e]);
                }
                dl_scene_free(scene);
            }
}

/* Laws with pieces: cells that a breakpoint passes between, or whose pairs lie in a taper, or that
 * are beyond the end. */
static void error_is_as_stated_for_laws_with_pieces(void **state) {
    (void)state;
    static const dl_pair_law *const laws[] = {&swirl, &tapered, &shifted};
    for (size_t k = 0; k < 3; k++)
        for (int dimension = 2; dimension <= 3; dimension++) {
            dl_scene *const scene = scene_of(dimension, 3000, UNIFORM, 2);
            double largest, mean;
            scene->law = *laws[k];
            scene->tree_error = 1e-5;
            measure(scene, 67, &largest, &mean);
            assert_true(largest <= 1e-5);
            dl_scene_free(scene);
        }
}

static void error_falls_as_asked(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        dl_scene *const scene = scene_of(dimension, 4000, UNIFORM, 2);
        double before = 1, largest, mean;
        for (int digits = 2; digits <= (dimension == 2 ? 8 : 5); digits++) {
            const double error = pow(10, -digits);
            scene->tree_error = error;
            measure(scene, 41, &largest, &mean);
            assert_true(mean > 0 && mean < before / 3);
            assert_true(mean > 1e-5 * error); /* no more work than was asked for */
            before = mean;
        }
        dl_scene_free(scene);
    }
}

/* What the program tells is what this file finds. */
static void error_is_measured_as_it_is(void **state) {
    (void)state;
    dl_scene *const scene = scene_of(2, 1280, CLUSTERED, 2);
    dl_force_error told;
    dl_error error = {""};
    double largest, mean;
    scene->tree_error = 1e-3;
    measure(scene, 10, &largest, &mean);
    dl_model *model = model_of(scene);
    assert_int_equal(dl_model_force_error(model, scene->position, &told, &error), DL_OK);
    assert_true(told.stated == 1e-3 && told.sampled == 128);
    assert_true(fabs(told.largest - largest) <= 1e-9 * largest);
    assert_true(fabs(told.mean - mean) <= 1e-9 * mean && mean > 0);
    dl_model_free(model);
    scene->kernel = DL_KERNEL_ALL_PAIRS;
    model = model_of(scene);
    assert_int_equal(dl_model_force_error(model, scene->position, &told, &error), DL_OK);
    assert_true(isnan(told.stated) && isnan(told.largest));
    dl_model_free(model);
    dl_scene_free(scene);
}

/* --- the cost -----------------------------------------------------------------------------------
 */

/* Pairs of particles, a pair of cells as some hundred of them; log of it against log N. */
static double cost_exponent(int dimension, spread how, double error, int count) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (int k = 0; k < count; k++) {
        dl_scene *const scene = scene_of(dimension, (size_t)2000 << k, how, 2);
        scene->tree_error = error;
        dl_model *const model = model_of(scene);
        free(forces_of(model, scene->position));
        const double x = log((double)scene->particles);
        const double y =
            log((double)model->kernel->near_pairs + 300 * (double)model->kernel->far_pairs);
        sx += x;
        sy += y;
        sxx += x * x;
        sxy += x * y;
        dl_model_free(model);
        dl_scene_free(scene);
    }
    return (count * sxy - sx * sy) / (count * sxx - sx * sx);
}

/* In three dimensions the near cells of a cell, some hundreds, still reach the edge of the scene:
 * the cost is on its way from that of all pairs. */
static void cost_grows_like_the_particles(void **state) {
    (void)state;
    const double flat = cost_exponent(2, UNIFORM, 1e-6, 5),
                 dense = cost_exponent(2, CLUSTERED, 1e-6, 5);
    const double solid = cost_exponent(3, UNIFORM, 1e-3, 3);
    if (!(flat < 1.3 && dense < 1.3 && solid < 1.7))
        fail_msg("exponents %g, %g, %g", flat, dense, solid);
    assert_true(flat > 0.8 && dense > 0.8 && solid > 0.8);
}

/* --- what holds exactly -------------------------------------------------------------------------
 */

static double moduli_of(const double *f, size_t count) {
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += fabs(f[k]);
    return sum;
}

static void forces_add_up_to_nothing(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        dl_scene *const scene = scene_of(dimension, 3000, CLUSTERED, 2);
        scene->tree_error = 1e-2;
        dl_model *const model = model_of(scene);
        double *const f = forces_of(model, scene->position);
        assert_true(model->kernel->far_pairs > 100);
        for (int c = 0; c < dimension; c++) {
            const double *const row = f + (size_t)c * 3000;
            double sum = 0;
            for (size_t i = 0; i < 3000; i++)
                sum += row[i];
            assert_true(fabs(sum) <= 1e-13 * moduli_of(row, 3000));
        }
        free(f);
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

static void order_of_particles_does_not_matter(void **state) {
    (void)state;
    const size_t n = 3000;
    dl_scene *const scene = scene_of(3, n, UNIFORM, 2), *const turned = scene_of(3, n, UNIFORM, 2);
    for (size_t i = 0; i < n; i++)
        place(turned, i, (i * 1361 + 5) % n, UNIFORM);
    scene->tree_error = turned->tree_error = 1e-3;
    dl_model *const model = model_of(scene), *const other = model_of(turned);
    double *const f = forces_of(model, scene->position), *const g =
                                                             forces_of(other, turned->position);
    for (int c = 0; c < 3; c++)
        for (size_t i = 0; i < n; i++)
            assert_true(fabs(g[(size_t)c * n + i] - f[(size_t)c * n + (i * 1361 + 5) % n]) <=
                        1e-13 * moduli_of(f, n));
    free(f);
    free(g);
    dl_model_free(model);
    dl_model_free(other);
    dl_scene_free(scene);
    dl_scene_free(turned);
}

/* A force depends on the positions alone: not on what was evaluated before. */
static void forces_have_the_same_bits_again(void **state) {
    (void)state;
    const size_t n = 2500;
    dl_scene *const scene = scene_of(2, n, UNIFORM, 2);
    dl_model *const model = model_of(scene), *const fresh = model_of(scene);
    double *const x = malloc(2 * n * sizeof *x);
    assert_non_null(x);
    for (size_t k = 0; k < 2 * n; k++)
        x[k] = 3 * scene->position[k] + sin((double)k);
    free(forces_of(model, x));
    double *const f = forces_of(model, scene->position), *const g =
                                                             forces_of(fresh, scene->position);
    assert_memory_equal(f, g, 2 * n * sizeof *f);
    free(f);
    free(g);
    free(x);
    dl_model_free(model);
    dl_model_free(fresh);
    dl_scene_free(scene);
}

static void instruction_sets_agree(void **state) {
    (void)state;
    const size_t n = 2500;
    dl_scene *const scene = scene_of(3, n, CLUSTERED, 2.5);
    scene->tree_error = 1e-3;
    dl_vector_force("plain");
    dl_model *const plain = model_of(scene);
    dl_vector_force(NULL);
    dl_model *const best = model_of(scene);
    double *const f = forces_of(plain, scene->position), *const g =
                                                             forces_of(best, scene->position);
    for (size_t k = 0; k < 3 * n; k++)
        assert_true(fabs(f[k] - g[k]) <= 1e-13 * moduli_of(f, 3 * n));
    free(f);
    free(g);
    dl_model_free(plain);
    dl_model_free(best);
    dl_scene_free(scene);
}

static long double potential_of(dl_model *model, const double *x) {
    long double sum, moduli;
    dl_error error = {""};
    assert_int_equal(model->kernel->ops->potential(model->kernel, x, &sum, &moduli, &error), DL_OK);
    assert_true(moduli >= fabsl(sum));
    return sum;
}

/* However large the stated error, forces are the gradient of the potential that is summed. */
static void forces_are_the_gradient_of_the_potential(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++) {
        const size_t n = 4000, block = (size_t)dimension * n;
        dl_scene *const scene = scene_of(dimension, n, UNIFORM, 1.5);
        scene->tree_error = 0.1;
        dl_model *const model = model_of(scene);
        double *const f = forces_of(model, scene->position);
        double *const x = malloc(2 * block * sizeof *x), work = 0;
        assert_non_null(x);
        const double h = 1e-6;
        for (size_t k = 0; k < block; k++) {
            const double u = sin(1.7 * (double)k);
            x[k] = scene->position[k] + h * u;
            x[block + k] = scene->position[k] - h * u;
            work += f[k] * u;
        }
        assert_true(model->kernel->far_pairs > 100);
        const double slope =
            (double)((potential_of(model, x) - potential_of(model, x + block)) / (2 * h));
        assert_true(fabs(slope + work) <= 1e-6 * fabs(work));
        free(x);
        free(f);
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

static void potential_is_that_of_all_pairs(void **state) {
    (void)state;
    static const dl_pair_law *const laws[] = {&swirl, &tapered, &shifted};
    for (size_t k = 0; k < 3; k++) {
        dl_scene *const scene = scene_of(2, 2000, UNIFORM, 2);
        dl_energy tree, pairs;
        double scale_tree, scale;
        dl_error error = {""};
        scene->law = *laws[k];
        dl_model *const model = model_of(scene);
        scene->kernel = DL_KERNEL_ALL_PAIRS;
        dl_model *const exact = model_of(scene);
        double *const y = calloc(2 * model->unknowns, sizeof *y);
        dl_model_initial_state(model, y);
        assert_int_equal(dl_model_energy(model, y, &tree, &error), DL_OK);
        assert_int_equal(dl_model_energy(exact, y, &pairs, &error), DL_OK);
        assert_int_equal(dl_model_energy_scale(model, y, &scale_tree, &error), DL_OK);
        assert_int_equal(dl_model_energy_scale(exact, y, &scale, &error), DL_OK);
        assert_true(fabs(tree.pair - pairs.pair) <= 1e-6 * scale);
        assert_true(fabs(scale_tree - scale) <= 0.05 * scale);
        free(y);
        dl_model_free(model);
        dl_model_free(exact);
        dl_scene_free(scene);
    }
}

/* --- scenes of every kind -----------------------------------------------------------------------
 */

static void pinned_particles_and_species_have_their_forces(void **state) {
    (void)state;
    const size_t n = 2000;
    dl_scene *const scene = scene_of(2, n, UNIFORM, 2);
    static const char *const names[] = {"heavy", "light"};
    scene->species = 2;
    scene->species_name = calloc(2, sizeof *scene->species_name);
    scene->species_law = calloc(4, sizeof *scene->species_law);
    scene->species_of = calloc(n, sizeof *scene->species_of);
    for (size_t k = 0; k < 2; k++)
        scene->species_name[k] = fixture_text(names[k]);
    scene->species_law[0] = scene->law;
    scene->species_law[1] = scene->species_law[2] = swirl;
    scene->law.pieces = 0; /* none among the light ones */
    for (size_t i = 0; i < n; i++) {
        scene->species_of[i] = (int)(i % 3 % 2);
        scene->pinned[i] = i % 7 == 0;
    }
    dl_model *const model = model_of(scene);
    scene->kernel = DL_KERNEL_REFERENCE;
    dl_model *const exact = model_of(scene);
    double *const y = calloc(2 * model->unknowns, sizeof *y);
    double *const a = calloc(model->unknowns, sizeof *a), *const b =
                                                              calloc(model->unknowns, sizeof *b);
    dl_energy tree, pairs;
    dl_error error = {""};
    dl_model_initial_state(model, y);
    assert_int_equal(dl_model_acceleration(model, y, a, &error), DL_OK);
    assert_int_equal(dl_model_acceleration(exact, y, b, &error), DL_OK);
    assert_true(model->kernel->far_pairs > 100);
    for (size_t u = 0; u < model->unknowns; u++)
        assert_true(fabs(a[u] - b[u]) <= 1e-5 * moduli_of(b, model->unknowns) / (double)n);
    assert_int_equal(dl_model_energy(model, y, &tree, &error), DL_OK);
    assert_int_equal(dl_model_energy(exact, y, &pairs, &error), DL_OK);
    assert_true(fabs(tree.pair - pairs.pair) <= 1e-6 * fabs(pairs.pair));
    free(y);
    free(a);
    free(b);
    dl_model_free(model);
    dl_model_free(exact);
    dl_scene_free(scene);
}

static void expect_unstable(dl_scene *scene, const char *text) {
    dl_error error = {""};
    dl_model *const model = model_of(scene);
    double *const a = calloc(model->unknowns, sizeof *a), *const y = calloc(2 * model->unknowns,
                                                                            sizeof *y);
    dl_model_initial_state(model, y);
    assert_int_equal(dl_model_acceleration(model, y, a, &error), DL_UNSTABLE);
    if (!strstr(error.message, text))
        fail_msg("%s", error.message);
    free(a);
    free(y);
    dl_model_free(model);
}

static void what_is_not_finite_is_told(void **state) {
    (void)state;
    dl_scene *const scene = scene_of(2, 500, UNIFORM, 2);
    scene->position[123] = NAN;
    expect_unstable(scene, "position of particle 123");
    for (size_t i = 0; i < 200; i++) { /* more than a leaf holds, at one place */
        scene->position[i] = 3;
        scene->position[500 + i] = 4;
    }
    expect_unstable(scene, "coincide");
    dl_scene_free(scene);
}

/* --- runs ---------------------------------------------------------------------------------------
 */

static void run(dl_scene *scene, dl_run_summary *summary) {
    const dl_method_row *row;
    void *options;
    dl_run_options how;
    dl_error error = {""};
    dl_run_options_default(&how);
    assert_int_equal(dl_method_find("leapfrog", &row, &error), DL_OK);
    assert_int_equal(dl_method_options_create(row, scene, &options, &error), DL_OK);
    if (dl_run(scene, row, options, &how, summary, NULL, &error))
        fail_msg("%s", error.message);
    assert_int_equal(summary->status, DL_OK);
    dl_method_options_free(row, options);
}

/* A lattice that repels itself: no close encounters, so that leap-frog's own error is small. */
static dl_scene *lattice(size_t side) {
    dl_scene *const scene = scene_of(2, side * side, UNIFORM, 2);
    for (size_t i = 0; i < side * side; i++) {
        const double at[3] = {(double)(i % side), floor((double)i / (double)side), 0};
        const double v[3] = {0.3 * sin(0.9 * (double)i), 0.3 * cos(1.3 * (double)i), 0};
        fixture_place(scene, i, at, v);
    }
    scene->law.piece[0].term[0].coefficient = 1;
    scene->step = 0.01;
    scene->end = 0.2;
    scene->sample = 0.04;
    return scene;
}

static void energy_of_leap_frog_is_kept(void **state) {
    (void)state;
    dl_scene *const scene = lattice(40);
    dl_run_summary tree, half, pairs;
    run(scene, &tree);
    scene->step /= 2;
    run(scene, &half);
    scene->step *= 2;
    scene->kernel = DL_KERNEL_ALL_PAIRS;
    run(scene, &pairs);
    assert_true(tree.force_error_stated == 1e-6 && tree.force_error_max <= 1e-6);
    assert_true(tree.force_error_mean > 0 && tree.force_error_mean <= tree.force_error_max);
    assert_true(isnan(pairs.force_error_stated));
    const double ratio = tree.energy_error_max / half.energy_error_max;
    assert_true(ratio > 3.5 && ratio < 4.5);
    assert_true(fabs(tree.energy_error_max - pairs.energy_error_max) <= 1e-7 * tree.energy_scale);
    assert_true(tree.momentum_error_max <= 1e-13 * tree.momentum_scale * 40);
    dl_scene_free(scene);
}

/* What walls take is booked with the potentials that are measured. */
static void ledger_of_walls_is_kept(void **state) {
    (void)state;
    dl_scene *const scene = lattice(30);
    dl_run_summary summary;
    scene->walls.present = true;
    scene->walls.damping = 0.4;
    for (int c = 0; c < 2; c++) {
        scene->walls.low[c] = -0.01;
        scene->walls.high[c] = 29.01;
    }
    run(scene, &summary);
    assert_true(summary.wall_hits > 20 && summary.ledger > 1);
    assert_true(summary.energy_error_max <= 1e-3 * summary.ledger);
    dl_scene_free(scene);
}

/* --- the choice ---------------------------------------------------------------------------------
 */

static void tree_is_chosen_beyond_ten_thousand(void **state) {
    (void)state;
    for (size_t n = 10000; n <= 10001; n++) {
        dl_scene *const scene = scene_of(2, n, UNIFORM, 2);
        scene->kernel = DL_KERNEL_AUTO;
        dl_model *model = model_of(scene);
        assert_string_equal(model->kernel->ops->name, n == 10000 ? "all-pairs" : "tree");
        dl_model_free(model);
        scene->law.piece[0].until = 3;
        model = model_of(scene);
        assert_string_equal(model->kernel->ops->name, "neighbour-list");
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

static void expect_refused(const dl_scene *scene, const char *text) {
    dl_model *model;
    dl_error error = {""};
    assert_int_equal(dl_model_create(scene, &model, &error), DL_INPUT);
    if (!strstr(error.message, "found tree") || !strstr(error.message, text))
        fail_msg("%s", error.message);
}

static void what_it_cannot_do_is_refused(void **state) {
    (void)state;
    dl_scene *const scene = scene_of(2, 100, UNIFORM, 2);
    dl_error error = {""};
    dl_model *model = model_of(scene);
    assert_int_equal(dl_model_set_mean(model, DL_MEAN_MIDPOINT, &error), DL_OK);
    assert_int_equal(dl_model_set_mean(model, DL_MEAN_QUOTIENT, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "all-pairs"));
    dl_model_free(model);
    scene->law = shifted;
    scene->law.piece[0].located = true;
    expect_refused(scene, "located");
    scene->law.piece[0].located = false;
    scene->law.piece[0].until = 4;
    scene->periods = (dl_periods){.present = true, .length = {10, 10, 0}};
    expect_refused(scene, "periodic");
    dl_scene_free(scene);
}

static void explain_tells_error_and_cost(void **state) {
    (void)state;
    dl_scene *const scene = scene_of(2, 1000, UNIFORM, 2);
    dl_model *const model = model_of(scene);
    char text[4096] = "";
    FILE *const out = fmemopen(text, sizeof text, "w");
    assert_non_null(out);
    dl_explain(model, out);
    fclose(out);
    assert_non_null(strstr(text, "tree, because the scene asks for it"));
    assert_non_null(strstr(text, "stated 1e-06; measured "));
    assert_non_null(strstr(text, "of cells for each particle"));
    dl_model_free(model);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(error_is_as_stated),
        cmocka_unit_test(error_is_as_stated_for_laws_with_pieces),
        cmocka_unit_test(error_falls_as_asked),
        cmocka_unit_test(error_is_measured_as_it_is),
        cmocka_unit_test(cost_grows_like_the_particles),
        cmocka_unit_test(forces_add_up_to_nothing),
        cmocka_unit_test(order_of_particles_does_not_matter),
        cmocka_unit_test(forces_have_the_same_bits_again),
        cmocka_unit_test(instruction_sets_agree),
        cmocka_unit_test(forces_are_the_gradient_of_the_potential),
        cmocka_unit_test(potential_is_that_of_all_pairs),
        cmocka_unit_test(pinned_particles_and_species_have_their_forces),
        cmocka_unit_test(what_is_not_finite_is_told),
        cmocka_unit_test(energy_of_leap_frog_is_kept),
        cmocka_unit_test(ledger_of_walls_is_kept),
        cmocka_unit_test(tree_is_chosen_beyond_ten_thousand),
        cmocka_unit_test(what_it_cannot_do_is_refused),
        cmocka_unit_test(explain_tells_error_and_cost),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
