/* Trajectories in extended precision: against exact solutions, each other, and the double time
 * loop. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <gsl/gsl_eigen.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_integration.h>
#include <math.h>
#include <quadmath.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/model.h"
#include "fixture_runs.h"
#include "fixture_scenes.h"
#include "reference/trajectory.h"
#include "study/kepler.h"

/* --- walks ------------------------------------------------------------------------------------ */

typedef struct walked {
    size_t length; /* 2 * dimension * particles */
    double *high, *low;
    dl_extended_counts counts;
} walked;

static walked walk_to(const dl_scene *scene, const dl_extended_ops *ops, dl_extended_method method,
                      double t) {
    walked made = {.length = 2 * (size_t)scene->dimension * scene->particles};
    const dl_extended_setup setup = {.method = method, .tolerance = 1};
    dl_extended_walk *walk = NULL;
    dl_error error = {""};
    made.high = calloc(made.length, sizeof *made.high);
    made.low = calloc(made.length, sizeof *made.low);
    assert_true(made.high && made.low);
    if (ops->create(scene, &setup, &walk, &error) || ops->advance(walk, t, &error))
        fail_msg("%s: %s", scene->name, error.message);
    ops->state(walk, made.high, made.low);
    made.counts = ops->counts(walk);
    ops->destroy(walk);
    return made;
}

static void release(walked *made) {
    free(made->high);
    free(made->low);
}

static double apart(const walked *a, const walked *b) {
    double most = 0;
    for (size_t k = 0; k < a->length / 2; k++)
        most = fmax(most, fabs((a->high[k] - b->high[k]) + (a->low[k] - b->low[k])));
    return most;
}

static __float128 number(const walked *of, size_t k) {
    return (__float128)of->high[k] + of->low[k];
}

/* --- two methods, two precisions -------------------------------------------------------------- */

static dl_scene *real_powers(void) {
    dl_scene *scene = fixture_oscillator();
    scene->law.piece[0].term[0].power = 2.3;
    scene->law.piece[0].term[1].power = 5.7;
    return scene;
}

/* A pair that comes in and goes out through the ends of its law's two pieces. */
static dl_scene *with_ends(dl_piece_end first, dl_piece_end second) {
    dl_scene *scene = fixture_oscillator();
    dl_pair_law *law = &scene->law;
    law->piece[0].until = 1.07;
    law->piece[1] = law->piece[0];
    law->piece[1].term[0].power = 3;
    law->piece[1].until = 1.6;
    law->piece[0].end = first;
    law->piece[1].end = second;
    law->piece[0].width = first == DL_END_TAPER ? 0.2 : 0;
    law->piece[1].width = second == DL_END_TAPER ? 0.3 : 0;
    law->pieces = 2;
    fixture_place(scene, 0, (double[3]){-0.7, 0.1}, (double[3]){0.9, 0});
    fixture_place(scene, 1, (double[3]){0.4, 0.1}, (double[3]){-0.6, 0.3});
    return scene;
}

static dl_scene *hard_ends(void) {
    return with_ends(DL_END_HARD, DL_END_HARD);
}
static dl_scene *shifted_ends(void) {
    return with_ends(DL_END_SHIFTED_FORCE, DL_END_SHIFTED_FORCE);
}
static dl_scene *tapered_ends(void) {
    return with_ends(DL_END_TAPER, DL_END_TAPER);
}
static dl_scene *mixed_ends(void) {
    return with_ends(DL_END_TAPER, DL_END_SHIFTED_FORCE);
}

/* Six of a kind that repels and two that attract, in a box that repeats itself. */
static dl_scene *periodic_mixture(void) {
    return scene_of_text(
        "name: mixture\ndimension: 3\n"
        "particles:\n"
        "  - {at: [0.3, 0.4, 0.5], velocity: [3, 1, -2], mass: 1, species: light}\n"
        "  - {at: [2.1, 0.2, 1.9], velocity: [-3, 2, 1], mass: 1, species: light}\n"
        "  - {at: [1.2, 2.3, 0.1], velocity: [2, -3, 2], mass: 2, species: heavy}\n"
        "  - {at: [2.4, 1.6, 2.2], velocity: [-2, 1, -3], mass: 3, inertia: 2, species: heavy}\n"
        "pair_laws:\n"
        "  - between: [light, light]\n"
        "    pieces: [{until: 1.3, terms: [{coefficient: 1, power: 3}]}]\n"
        "  - between: [light, heavy]\n"
        "    pieces: [{until: 1.2, end: shifted-force, terms: [{coefficient: -1, power: 1.5}]}]\n"
        "  - between: [heavy, heavy]\n"
        "    pieces: [{until: 1.25, end: taper, width: 0.4, terms: [{coefficient: 1, power: 2}]}]\n"
        "periodic: {x: [0, 2.6], y: [0, 2.6], z: [0, 2.6]}\n"
        "time: {step: 0.001, end: 1}\n");
}

static const struct {
    const char *name;
    dl_scene *(*make)(void);
    double end;
    bool crosses;
} scenes[] = {
    {"real powers", real_powers, 2, false},
    {"cluster", fixture_cluster, 0.1, false},
    {"pinned chain", fixture_pinned_chain, 0.5, false},
    {"hard ends", hard_ends, 4, true},
    {"shifted ends", shifted_ends, 4, true},
    {"tapered ends", tapered_ends, 4, true},
    {"mixed ends", mixed_ends, 4, true},
    {"periodic mixture", periodic_mixture, 1, true},
};

/* Taylor series and collocation have no formula in common, and neither has a long double with a
 * quad. */
static void methods_and_precisions_agree(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        dl_scene *scene = scenes[i].make();
        const double end = scenes[i].end;
        walked best = walk_to(scene, &dl_extended_quad, DL_TAYLOR, end);
        walked other = walk_to(scene, &dl_extended_quad, DL_GAUSS, end);
        walked plain = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, end);
        walked last = walk_to(scene, &dl_extended_long_double, DL_GAUSS, end);
        if (!(apart(&best, &other) < 2e-30 && apart(&best, &plain) < 1e-16 &&
              apart(&best, &last) < 1e-16))
            fail_msg("%s: quad %.2g, long double %.2g and %.2g", scenes[i].name,
                     apart(&best, &other), apart(&best, &plain), apart(&best, &last));
        if ((best.counts.crossings > 0) != scenes[i].crosses)
            fail_msg("%s: %lu crossings", scenes[i].name, best.counts.crossings);
        assert_int_equal(best.counts.crossings, last.counts.crossings);
        release(&best);
        release(&other);
        release(&plain);
        release(&last);
        dl_scene_free(scene);
    }
}

/* The model is the same: what the double time loop tends to with a tight tolerance. */
static void double_precision_tends_to_it(void **state) {
    (void)state;
    for (size_t i = 0; i < sizeof scenes / sizeof *scenes; i++) {
        dl_scene *scene = scenes[i].make();
        const dl_run_options how = run_options(scenes[i].end, 0);
        const dl_method_row *row = method_of("gsl-rk8pd");
        void *options = options_of(row, scene, "rtol=1e-12");
        double *y = calloc(2 * (size_t)scene->dimension * scene->particles, sizeof *y);
        dl_run_summary summary;
        assert_non_null(y);
        assert_int_equal(dl_method_options_set(row, options, "atol", "1e-12", NULL), DL_OK);
        assert_int_equal(dl_run(scene, row, options, &how, &summary, y, NULL), DL_OK);
        walked best = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, scenes[i].end);
        double most = 0;
        for (size_t k = 0; k < best.length / 2; k++)
            most = fmax(most, fabs(best.high[k] - y[k]));
        if (!(most < 1e-8))
            fail_msg("%s: %.2g", scenes[i].name, most);
        release(&best);
        free(y);
        dl_method_options_free(row, options);
        dl_scene_free(scene);
    }
}

/* --- Kepler ----------------------------------------------------------------------------------- */

static double off_kepler(const dl_scene *scene, const walked *of, double t) {
    double high[4], low[4], most = 0;
    assert_int_equal(dl_kepler_position(scene, t, high, low, NULL), DL_OK);
    for (size_t k = 0; k < 4; k++)
        most = fmax(most, fabs((of->high[k] - high[k]) + (of->low[k] - low[k])));
    return most;
}

static void ellipses_are_exact(void **state) {
    (void)state;
    static const struct {
        double eccentricity, quad, plain;
    } orbits[] = {
        {0, 1e-29, 1e-15}, {0.6, 1e-29, 2e-15}, {0.9, 2e-29, 2e-14}, {0.99, 1e-27, 1e-13}};
    const double t = 100; /* 16 orbits */
    for (size_t i = 0; i < sizeof orbits / sizeof *orbits; i++) {
        dl_scene *scene = fixture_kepler(orbits[i].eccentricity);
        walked quad = walk_to(scene, &dl_extended_quad, DL_TAYLOR, t);
        walked plain = walk_to(scene, &dl_extended_long_double, DL_GAUSS, t);
        if (!(off_kepler(scene, &quad, t) < orbits[i].quad &&
              off_kepler(scene, &plain, t) < orbits[i].plain))
            fail_msg("eccentricity %g: quad %.2g, long double %.2g", orbits[i].eccentricity,
                     off_kepler(scene, &quad, t), off_kepler(scene, &plain, t));
        release(&quad);
        release(&plain);
        dl_scene_free(scene);
    }
}

/* The exact solution is: after a thousand orbits of eccentricity 0.99 the bodies are back, but for
 * what the double next to the thousandth period misses it by: d(t) = d(0) + w(0) s + ... */
static void exact_motion_returns_after_a_thousand_orbits(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0.99);
    const __float128 r = (__float128)scene->position[1] - scene->position[0];
    const __float128 w = (__float128)scene->velocity[3] - scene->velocity[2];
    const __float128 mass = (__float128)0.75 + 0.25, axis = 1 / (2 / r - w * w / mass);
    const __float128 period = 2 * M_PIq * axis * sqrtq(axis / mass);
    const double t = (double)(1000 * period);
    const __float128 late = t - 1000 * period; /* some 1e-13 */
    double high[4], low[4];
    assert_int_equal(dl_kepler_position(scene, t, high, low, NULL), DL_OK);
    const __float128 x = ((__float128)high[1] + low[1]) - ((__float128)high[0] + low[0]);
    const __float128 y = ((__float128)high[3] + low[3]) - ((__float128)high[2] + low[2]);
    const __float128 pull = mass / (r * r);
    assert_true(fabsq(x - (r - pull * late * late / 2)) < 1e-26);
    assert_true(fabsq(y - w * late * (1 - pull / r * late * late / 6)) < 1e-26);
    dl_scene_free(scene);
}

/* --- an oscillator ---------------------------------------------------------------------------- */

static const double mu_oscillator = 2.0 / 3; /* inertias 1 and 2 */

/* V of -6/r^7 + 9/r^10 (TR171's stream): -1/r^6 + 1/r^9. */
static double potential(double r) {
    return -pow(r, -6) + pow(r, -9);
}

static double outer_turn(double energy) {
    double low = 1.15, high = 10;
    for (int i = 0; i < 200; i++) {
        const double middle = (low + high) / 2;
        *(potential(middle) < energy ? &low : &high) = middle;
    }
    return low;
}

/* With r = (a + b)/2 - (b - a)/2 cos(phi) the root singularities of 1/v at the turns are gone. */
static double slowness(double phi, void *context) {
    const double *turn = context;
    const double a = turn[0], b = turn[1], r = (a + b) / 2 - (b - a) / 2 * cos(phi);
    const double kinetic = potential(a) - potential(r);
    const double speed = sqrt(2 * kinetic / mu_oscillator);
    return (b - a) / 2 * sin(phi) / speed;
}

static void oscillator_has_the_period_of_its_quadrature(void **state) {
    (void)state;
    const double start = 1.05; /* at rest, within the well: the least distance is 1.05 */
    double turn[2] = {start, outer_turn(potential(start))}, half, error_of_half;
    gsl_integration_workspace *space = gsl_integration_workspace_alloc(1000);
    const gsl_function integrand = {.function = slowness, .params = turn};
    gsl_set_error_handler_off();
    assert_non_null(space);
    assert_int_equal(gsl_integration_qags(&integrand, 0, 3.14159265358979323846, 0, 1e-12, 1000,
                                          space, &half, &error_of_half),
                     GSL_SUCCESS);
    gsl_integration_workspace_free(space);
    dl_scene *scene = fixture_scene("oscillator", 2, 2);
    fixture_law(scene, INFINITY, 6, 7, 9, 10);
    scene->inertia[1] = 2;
    fixture_place(scene, 1, (double[3]){start, 0}, (double[3]){0, 0});
    /* at a turn the distance is not sensitive to the time, the velocity is: v = a dt */
    walked turned = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, 10 * half);
    const double speed = turned.high[5] - turned.high[4];
    const double force = -6 * pow(start, -7) + 9 * pow(start, -10);
    assert_true(fabs(turned.high[1] - turned.high[0] - start) < 1e-15);
    assert_true(fabs(speed / (force / mu_oscillator)) < 1e-10 * 10 * half);
    release(&turned);
    dl_scene_free(scene);
}

/* --- a crystal in the harmonic limit ---------------------------------------------------------- */

/* The outward force on a corner of a hexagon with a particle in its middle, all at distance a. */
static double corner_force(double a) {
    /* middle, two next to it, two beyond these, opposite: with their components outward */
    static const double root = 1.7320508075688772935;
    const double distance[4] = {1, 1, root, 2}, share[4] = {1, 1, root, 1};
    double sum = 0;
    for (int k = 0; k < 4; k++) {
        const double r = a * distance[k];
        sum += share[k] * (-6 * pow(r, -7) + 9 * pow(r, -10));
    }
    return sum;
}

static double hexagon_spacing(void) {
    double low = 1, high = 1.3;
    for (int i = 0; i < 200; i++) {
        const double middle = (low + high) / 2;
        *(corner_force(middle) > 0 ? &low : &high) = middle;
    }
    return low;
}

static dl_scene *hexagon(void) {
    dl_scene *scene = fixture_scene("hexagon", 2, 7);
    const double a = hexagon_spacing();
    fixture_law(scene, INFINITY, 6, 7, 9, 10);
    for (size_t i = 1; i < 7; i++) {
        const double angle = 3.14159265358979323846 / 3 * (double)i;
        fixture_place(scene, i, (double[3]){a * cos(angle), a * sin(angle)}, (double[3]){0, 0});
    }
    return scene;
}

/* -d a / d q of the double model, which for equal masses is symmetric. */
static gsl_matrix *stiffness(const dl_scene *scene) {
    dl_model *model = NULL;
    const dl_sparsity *pattern = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    double *y = calloc(2 * model->unknowns, sizeof *y);
    gsl_matrix *made = gsl_matrix_calloc(model->unknowns, model->unknowns);
    assert_true(y && made);
    dl_model_initial_state(model, y);
    assert_int_equal(dl_model_sparsity(model, y, NULL, &pattern, NULL), DL_OK);
    double *values = calloc(pattern->nonzeros, sizeof *values);
    assert_non_null(values);
    assert_int_equal(dl_model_jacobian(model, y, values, NULL), DL_OK);
    for (size_t column = 0; column < pattern->columns; column++)
        for (long k = pattern->column_start[column]; k < pattern->column_start[column + 1]; k++)
            gsl_matrix_set(made, (size_t)pattern->row[k], column, -values[k]);
    free(values);
    free(y);
    dl_model_free(model);
    return made;
}

/* How far the motion begun along a mode is from that mode's cosine, after half a dozen turns. */
static double off_mode(double amplitude, const gsl_vector *mode, double frequency) {
    dl_scene *scene = hexagon();
    const size_t n = mode->size;
    const double t = 40 / frequency;
    double most = 0;
    for (size_t u = 0; u < n; u++)
        scene->position[u] += amplitude * gsl_vector_get(mode, u);
    walked end = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, t);
    dl_scene *still = hexagon();
    for (size_t u = 0; u < n; u++) {
        const double expected = amplitude * gsl_vector_get(mode, u) * cos(frequency * t);
        most = fmax(most, fabs(end.high[u] - still->position[u] - expected));
    }
    release(&end);
    dl_scene_free(scene);
    dl_scene_free(still);
    return most / amplitude;
}

static void crystal_swings_in_its_normal_modes(void **state) {
    (void)state;
    dl_scene *scene = hexagon();
    gsl_matrix *matrix = stiffness(scene);
    const size_t n = matrix->size1;
    gsl_matrix *modes = gsl_matrix_alloc(n, n);
    gsl_vector *squares = gsl_vector_alloc(n);
    gsl_eigen_symmv_workspace *space = gsl_eigen_symmv_alloc(n);
    assert_true(modes && squares && space);
    assert_int_equal(gsl_eigen_symmv(matrix, squares, modes, space), GSL_SUCCESS);
    gsl_eigen_symmv_sort(squares, modes, GSL_EIGEN_SORT_VAL_ASC);
    for (size_t k = 0; k < 3; k++) /* two translations, a rotation */
        assert_true(fabs(gsl_vector_get(squares, k)) < 1e-10);
    for (size_t k = 3; k < n; k++) {
        const double frequency = sqrt(gsl_vector_get(squares, k));
        const gsl_vector_view mode = gsl_matrix_column(modes, k);
        const double coarse = off_mode(4e-5, &mode.vector, frequency);
        const double fine = off_mode(1e-5, &mode.vector, frequency);
        /* what is left over is of the second order in the amplitude, or of the third by symmetry */
        if (!(frequency > 1 && fine < 1e-2 && fine < coarse / 3))
            fail_msg("mode %zu: frequency %g, off by %.2g and %.2g", k, frequency, coarse, fine);
    }
    gsl_eigen_symmv_free(space);
    gsl_vector_free(squares);
    gsl_matrix_free(modes);
    gsl_matrix_free(matrix);
    dl_scene_free(scene);
}

/* --- walls ------------------------------------------------------------------------------------ */

static dl_scene *ball(double damping, dl_wall_rule rule) {
    dl_scene *scene = fixture_scene("ball", 2, 1);
    fixture_place(scene, 0, (double[3]){0.25, 1}, (double[3]){0.75, 0});
    scene->feels_gravity[0] = true;
    scene->gravity[1] = -8;
    scene->walls.present = true;
    scene->walls.low[0] = scene->walls.low[1] = 0;
    scene->walls.high[0] = 1;
    scene->walls.damping = damping;
    scene->walls.rule = rule;
    scene->walls.rest = 1e-9;
    scene->step = 1.0 / 1024;
    return scene;
}

/* Falls in 1/2, bounces in 1: at t = 20.125 it has fallen for 1/8 from the 20th top. */
static void ball_bounces_for_ever(void **state) {
    (void)state;
    dl_scene *scene = ball(0, DL_LOCATED);
    const double t = 20.125;
    for (int quad = 0; quad <= 1; quad++)
        for (int method = 0; method <= 1; method++) {
            walked end = walk_to(scene, quad ? &dl_extended_quad : &dl_extended_long_double,
                                 method ? DL_GAUSS : DL_TAYLOR, t);
            /* x unfolded: 0.25 + 0.75 t = 15.34375, the 15th interval is gone through backwards */
            const double accuracy = quad ? 1e-30 : 1e-15;
            const __float128 x = number(&end, 0), y = number(&end, 1);
            const __float128 s = (__float128)0.125, high = 1 - 4 * s * s;
            assert_true(fabsq(x - (16 - (__float128)15.34375)) < accuracy);
            if (!(fabsq(y - high) < accuracy))
                fail_msg("quad %d method %d: y = %.20g, off by %.2g", quad, method, (double)y,
                         (double)(y - high));
            assert_int_equal(end.counts.hits, 20 + 15);
            assert_int_equal(end.counts.contacts, 0);
            release(&end);
        }
    dl_scene_free(scene);
}

/* With k = 1 - d flights last k, k^2 ... and end at 1/2 + k/(1 - k); x goes on by 0.75 k k, 0.75
 * k^2 k^2 ... until then. */
static void ball_comes_to_rest_where_the_bounces_accumulate(void **state) {
    (void)state;
    dl_scene *scene = ball(0.5, DL_LOCATED);
    scene->walls.high[0] = INFINITY;
    walked end = walk_to(scene, &dl_extended_quad, DL_TAYLOR, 3);
    walked other = walk_to(scene, &dl_extended_long_double, DL_GAUSS, 3);
    const __float128 expected = (__float128)0.25 + (__float128)0.75 / 2 + (__float128)0.75 / 3;
    /* what the bounces that are left out would have added: 0.75 (1e-12)^2 */
    assert_true(fabsq(number(&end, 0) - expected) < 1e-23);
    assert_true(number(&end, 1) == 0 && number(&end, 2) == 0 && number(&end, 3) == 0);
    assert_int_equal(end.counts.contacts, 1);
    assert_int_equal(other.counts.hits, end.counts.hits);
    assert_true(apart(&end, &other) < 1e-17);
    release(&end);
    release(&other);
    dl_scene_free(scene);
}

/* A wall rule that acts after a step tends to the located one as steps become short, at first
 * order: mean over many lengths of the last step before a hit. */
static void mirrors_tend_to_the_located_rule(void **state) {
    (void)state;
    const double end = 1.25;
    double slope = 0;
    double mean[2] = {0, 0};
    for (int k = 0; k < 2; k++)
        for (int phase = 0; phase < 16; phase++) {
            dl_scene *scene = ball(0.5, DL_MIRROR);
            scene->walls.high[0] = INFINITY;
            scene->position[1] = 1 + phase / 64.0;
            walked best = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, end);
            const dl_run_options how = run_options(end, 0);
            finished run = run_with(scene, method_of("leapfrog"),
                                    k ? "step=0.000030517578125" : "step=0.0009765625", &how);
            mean[k] += fabs(run.y[1] - best.high[1]) / 16;
            free(run.y);
            release(&best);
            dl_scene_free(scene);
        }
    slope = log2(mean[0] / mean[1]) / 5;
    if (!(slope > 0.75 && slope < 1.25))
        fail_msg("errors %.2g and %.2g: order %.2f", mean[0], mean[1], slope);
}

/* A particle pressed to a side wall by another is held there, with damping against gravity too;
 * when the other is out of reach it falls. */
static void walls_let_fall_what_nothing_presses(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("held", 2, 2);
    fixture_law(scene, 0.5, 0, 1, 1, 2);
    fixture_place(scene, 0, (double[3]){1, 1}, (double[3]){0, 0});
    fixture_place(scene, 1, (double[3]){0.75, 1}, (double[3]){-1, 0});
    scene->feels_gravity[0] = true;
    scene->gravity[1] = -1;
    scene->walls.present = true;
    scene->walls.high[0] = 1;
    scene->walls.damping = 0.9;
    scene->walls.rest = 1e-9;
    for (int rule = DL_MIRROR; rule <= DL_LOCATED; rule++) {
        scene->walls.rule = (dl_wall_rule)rule;
        walked end = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, 1);
        assert_int_equal(end.counts.contacts, 1);
        assert_int_equal(end.counts.releases, 1);
        assert_true(end.high[2] < 1);
        release(&end);
    }
    dl_scene_free(scene);
}

/* One that slides along its wall bounces on the cutoff of a body that goes along, twice: as seen
 * from the body it keeps its energy, though it is pressed to the wall again. */
static void what_slides_along_a_wall_loses_nothing(void **state) {
    (void)state;
    dl_scene *const scene = scene_of_text(
        "name: slides\ndimension: 2\nparticles:\n"
        "  - {at: [0, 0]}\n"
        "  - {at: [0.5, 0], velocity: [1, 0], inertia: 1.0e18, coupling: 1, gravity: false}\n"
        "  - {at: [0.3, -1.5], velocity: [0, -0.125], inertia: 1.0e18, coupling: 1, gravity: "
        "false}\n"
        "pair_law: [{until: 1, terms: [{coefficient: 3, power: 2}]}]\n"
        "gravity: [0, -2]\nwalls: {x: [0, none], damping: 0.5, rule: located}\n"
        "time: {step: 0.03, end: 6}\n");
    const double begins = 2 * (1.5 + 0.5 * 0.125) + 0.125 * 0.125 / 2;
    for (int method = DL_TAYLOR; method <= DL_GAUSS; method++) {
        walked end = walk_to(scene, &dl_extended_long_double, (dl_extended_method)method, 6);
        const double rises = end.high[3] - end.high[5], rate = end.high[9] + 0.125;
        const double r = hypot(0.3, rises), potential = r < 1 ? 3 / r - 3 : 0;
        assert_int_equal(end.counts.crossings, 5);
        assert_int_equal(end.counts.contacts, 1);
        assert_int_equal(end.counts.releases, 1);
        assert_true(end.high[0] == 0 && end.high[6] == 0);
        assert_true(fabs(rate * rate / 2 + 2 * rises + potential - begins) < 1e-13);
        release(&end);
    }
    dl_scene_free(scene);
}

/* A particle on a sticking floor is lifted by another that comes near: at the time at which the
 * attraction is the gravity. */
static void contact_is_released_when_the_press_turns(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("lifted", 2, 2);
    fixture_law(scene, INFINITY, 1, 2, 0, 1);
    fixture_place(scene, 0, (double[3]){0, 0}, (double[3]){0, 0});
    fixture_place(scene, 1, (double[3]){0.25, 3}, (double[3]){0, -1});
    scene->feels_gravity[0] = true;
    scene->gravity[1] = -0.5;
    scene->walls.present = true;
    scene->walls.low[1] = 0;
    scene->walls.damping = 0.5;
    scene->walls.rest = 1e-9;
    scene->walls.rule = DL_LOCATED;
    const double end = 2;
    walked best = walk_to(scene, &dl_extended_quad, DL_TAYLOR, end);
    walked other = walk_to(scene, &dl_extended_quad, DL_GAUSS, end);
    const dl_run_options how = run_options(end, 0.25);
    finished run = run_with(scene, method_of("gsl-rk8pd"), "rtol=1e-13", &how);
    assert_int_equal(best.counts.contacts, 1);
    assert_int_equal(best.counts.releases, 1);
    assert_true(best.high[2] > 0.01);
    assert_true(apart(&best, &other) < 1e-28);
    assert_int_equal(run.summary.releases, 1);
    assert_true(fabs(run.y[0] - best.high[0]) + fabs(run.y[2] - best.high[2]) < 1e-9);
    free(run.y);
    release(&best);
    release(&other);
    dl_scene_free(scene);
}

/* A particle that rests on a wall is pressed there by one that hits the same wall: at the hit the
 * press is 0, and does not turn. */
static void press_that_only_vanishes_releases_nothing(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("touched", 2, 2);
    fixture_law(scene, INFINITY, 0, 1, 1, 2);
    fixture_place(scene, 0, (double[3]){0, 1}, (double[3]){0, 0});
    fixture_place(scene, 1, (double[3]){0.1, 0.7}, (double[3]){-3, 0.1});
    scene->walls.present = true;
    scene->walls.low[0] = 0;
    scene->walls.damping = 0.9;
    scene->walls.rest = 1e-9;
    scene->walls.rule = DL_LOCATED;
    for (int quad = 0; quad <= 1; quad++)
        for (int method = DL_TAYLOR; method <= DL_GAUSS; method++) {
            walked end = walk_to(scene, quad ? &dl_extended_quad : &dl_extended_long_double,
                                 (dl_extended_method)method, 0.25);
            assert_int_equal(end.counts.hits, 1);
            assert_int_equal(end.counts.contacts, 1);
            assert_int_equal(end.counts.releases, 0);
            assert_true(end.high[0] == 0 && end.high[2] == 1 && end.low[2] == 0);
            release(&end);
        }
    dl_scene_free(scene);
}

/* The box of falling particles, hard cutoff, sticking walls and all. */
static void box_agrees_with_itself_and_the_double_loop(void **state) {
    (void)state;
    dl_scene *scene = fixture_box();
    scene->walls.rule = DL_LOCATED;
    scene->walls.rest = 1e-9;
    const double end = 0.02;
    walked taylor = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, end);
    walked gauss = walk_to(scene, &dl_extended_long_double, DL_GAUSS, end);
    const dl_run_options how = run_options(end, 0);
    finished run = run_with(scene, method_of("gsl-rk8pd"), "rtol=1e-12", &how);
    double most = 0;
    for (size_t k = 0; k < taylor.length / 2; k++)
        most = fmax(most, fabs(run.y[k] - taylor.high[k]));
    if (!(apart(&taylor, &gauss) < 1e-14 && most < 1e-6))
        fail_msg("apart %.2g, from double %.2g", apart(&taylor, &gauss), most);
    assert_true(taylor.counts.hits > 10 && taylor.counts.crossings > 20);
    assert_int_equal(taylor.counts.hits, gauss.counts.hits);
    assert_int_equal(taylor.counts.crossings, gauss.counts.crossings);
    free(run.y);
    release(&taylor);
    release(&gauss);
    dl_scene_free(scene);
}

/* --- radiation -------------------------------------------------------------------------------- */

static void radiation_is_at_its_times(void **state) {
    (void)state;
    dl_scene *scene = fixture_cluster();
    scene->radiation = (dl_radiation){.present = true,
                                      .period = 0.01,
                                      .beyond = 0.7,
                                      .factor_above = 0.8,
                                      .factor_below = 1.1,
                                      .frame = DL_FRAME_CENTRE};
    walked taylor = walk_to(scene, &dl_extended_quad, DL_TAYLOR, 0.035);
    walked gauss = walk_to(scene, &dl_extended_long_double, DL_GAUSS, 0.035);
    const dl_run_options how = run_options(0.035, 0);
    finished run = run_with(scene, method_of("gsl-rk8pd"), "rtol=1e-13", &how);
    double most = 0;
    for (size_t k = 0; k < taylor.length / 2; k++)
        most = fmax(most, fabs(run.y[k] - taylor.high[k]));
    assert_true(apart(&taylor, &gauss) < 1e-17);
    assert_true(most < 1e-9);
    scene->radiation.present = false;
    walked without = walk_to(scene, &dl_extended_long_double, DL_TAYLOR, 0.035);
    assert_true(apart(&taylor, &without) > 1e-4);
    free(run.y);
    release(&taylor);
    release(&gauss);
    release(&without);
    dl_scene_free(scene);
}

/* --- growth ----------------------------------------------------------------------------------- */

/* At rest between two pinned bodies that attract by 1/r^2 from a distance of 1, a = 4 x along them:
 * a displacement grows as exp(2 t). On a floor below, where it rests, it does not grow at all. */
static void displacements_grow_as_they_must(void **state) {
    (void)state;
    const dl_extended_limits limits = {.seconds = 20};
    double growth[65];
    dl_scene *scene = fixture_scene("saddle", 2, 3);
    fixture_law(scene, INFINITY, 1, 2, 0, 1);
    for (size_t i = 0; i < 3; i++)
        fixture_place(scene, i, (double[3]){(double)i, 0}, (double[3]){0, 0});
    scene->pinned[0] = scene->pinned[2] = true;
    assert_int_equal(dl_extended_growth(scene, &limits, 1, 8, 64, growth, NULL), DL_OK);
    assert_true(fabs(growth[64] - growth[32] - 2 * 4) < 1e-4);
    dl_scene_free(scene);
    scene = ball(0.5, DL_LOCATED);
    scene->position[1] = scene->velocity[0] = 0;
    assert_int_equal(dl_extended_growth(scene, &limits, 1, 8, 64, growth, NULL), DL_OK);
    assert_true(fabs(growth[64] - growth[1]) < 1e-6);
    dl_scene_free(scene);
}

/* --- what cannot go on ------------------------------------------------------------------------ */

static void collisions_and_limits_are_told(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("head-on", 2, 2);
    fixture_law(scene, INFINITY, 1, 2, 0, 1);
    fixture_place(scene, 1, (double[3]){1, 0}, (double[3]){0, 0});
    const dl_extended_ops *const both[] = {&dl_extended_long_double, &dl_extended_quad};
    for (size_t k = 0; k < 2; k++)
        for (int method = DL_TAYLOR; method <= DL_GAUSS; method++) {
            dl_extended_setup setup = {
                .method = (dl_extended_method)method, .tolerance = 1, .limits = {.seconds = 20}};
            dl_extended_walk *walk = NULL;
            dl_error error = {""};
            volatile int stop = 1;
            assert_int_equal(both[k]->create(scene, &setup, &walk, NULL), DL_OK);
            const dl_status status = both[k]->advance(walk, 2, &error);
            assert_true(status == DL_STEP_FAILURE || status == DL_UNSTABLE);
            assert_non_null(strstr(error.message, "t = 0.785"));
            both[k]->destroy(walk);
            setup.limits.interrupt = &stop;
            assert_int_equal(both[k]->create(scene, &setup, &walk, NULL), DL_OK);
            assert_int_equal(both[k]->advance(walk, 0.5, &error), DL_INTERRUPTED);
            both[k]->destroy(walk);
        }
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(methods_and_precisions_agree),
        cmocka_unit_test(double_precision_tends_to_it),
        cmocka_unit_test(ellipses_are_exact),
        cmocka_unit_test(exact_motion_returns_after_a_thousand_orbits),
        cmocka_unit_test(oscillator_has_the_period_of_its_quadrature),
        cmocka_unit_test(crystal_swings_in_its_normal_modes),
        cmocka_unit_test(ball_bounces_for_ever),
        cmocka_unit_test(ball_comes_to_rest_where_the_bounces_accumulate),
        cmocka_unit_test(mirrors_tend_to_the_located_rule),
        cmocka_unit_test(walls_let_fall_what_nothing_presses),
        cmocka_unit_test(what_slides_along_a_wall_loses_nothing),
        cmocka_unit_test(contact_is_released_when_the_press_turns),
        cmocka_unit_test(press_that_only_vanishes_releases_nothing),
        cmocka_unit_test(box_agrees_with_itself_and_the_double_loop),
        cmocka_unit_test(radiation_is_at_its_times),
        cmocka_unit_test(displacements_grow_as_they_must),
        cmocka_unit_test(collisions_and_limits_are_told),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
