/* Initial states by rule, and scenes that start from another run. */
#include "fixture_folder.h"
#include "fixture_runs.h"

#include <glob.h>

#include "core/random_stream.h"
#include "driftlab/trajectory.h"

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not within %g of %.17g", value, tolerance, expected);
}

/* --- scenes from their particles -------------------------------------------------------------- */

static const char frame_2d[] = "name: t\ndimension: 2\nseed: 7\ntime: {step: 0.01, end: 0.1}\n";
static const char frame_3d[] = "name: t\ndimension: 3\nseed: 7\ntime: {step: 0.01, end: 0.1}\n";

static dl_scene *scene_with(const char *frame, const char *rest) {
    char text[4096];
    snprintf(text, sizeof text, "%s%s\n", frame, rest);
    return scene_of_text(text);
}

/* A scene of one item. */
static dl_scene *scene_of(const char *frame, const char *item) {
    char rest[2048];
    snprintf(rest, sizeof rest, "particles:\n  - {%s}", item);
    return scene_with(frame, rest);
}

static void assert_refused(const char *frame, const char *rest, const char *const words[4]) {
    char path[128], text[4096];
    snprintf(path, sizeof path, "%s/refused.yaml", folder);
    snprintf(text, sizeof text, "%s%s\n", frame, rest);
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (dl_scene_read(path, &scene, &error) != DL_INPUT)
        fail_msg("not refused: %s", rest);
    assert_null(scene);
    for (size_t i = 0; i < 4 && words[i]; i++)
        if (!strstr(error.message, words[i]))
            fail_msg("\"%s\" lacks \"%s\"", error.message, words[i]);
    assert_non_null(strstr(error.message, "refused.yaml:"));
    unlink(path);
}

static double component(const double *values, const dl_scene *s, size_t i, size_t axis) {
    return axis < (size_t)s->dimension ? values[axis * s->particles + i] : 0;
}

static double distance(const dl_scene *s, size_t i, size_t j) {
    double square = 0;
    for (size_t axis = 0; axis < 3; axis++) {
        const double d = component(s->position, s, i, axis) - component(s->position, s, j, axis);
        square += d * d;
    }
    return sqrt(square);
}

static double nearest_distance(const dl_scene *s) {
    double nearest = INFINITY;
    for (size_t i = 0; i < s->particles; i++)
        for (size_t j = 0; j < i; j++)
            nearest = fmin(nearest, distance(s, i, j));
    return nearest;
}

/* The most neighbours at `spacing` that a particle has. */
static int most_neighbours(const dl_scene *s, double spacing) {
    int most = 0;
    for (size_t i = 0; i < s->particles; i++) {
        int neighbours = 0;
        for (size_t j = 0; j < s->particles; j++)
            neighbours += j != i && fabs(distance(s, i, j) - spacing) < 1e-9;
        most = neighbours > most ? neighbours : most;
    }
    return most;
}

/* --- lattices --------------------------------------------------------------------------------- */

/* Rows whose counts differ by an odd or an even number, and in both directions. */
static void rows_are_a_hexagonal_lattice(void **state) {
    (void)state;
    dl_scene *const s = scene_of(frame_2d, "lattice: {kind: hexagonal, spacing: 0.5, "
                                           "rows: [4, 5, 5, 2, 8, 8, 7], origin: [3, -1]}");
    assert_int_equal(s->particles, 39);
    assert_true(s->position[0] == 3 && s->position[39] == -1);
    for (size_t i = 0; i < s->particles; i++) {
        const double row = (component(s->position, s, i, 1) + 1) / (0.5 * sqrt(0.75));
        const double half = (component(s->position, s, i, 0) - 3) / 0.25;
        assert_near(row, nearbyint(row), 1e-12);
        assert_near(half, nearbyint(half), 1e-12);
        assert_int_equal(((long)nearbyint(half) - (long)nearbyint(row)) % 2, 0);
    }
    assert_near(nearest_distance(s), 0.5, 1e-12);
    assert_int_equal(most_neighbours(s, 0.5), 6);
    /* centred to half a spacing */
    double sum[7] = {0};
    const int count[7] = {4, 5, 5, 2, 8, 8, 7};
    for (size_t i = 0, row = 0, seen = 0; i < 39; i++) {
        sum[row] += component(s->position, s, i, 0);
        if (++seen == (size_t)count[row]) {
            assert_near(sum[row] / count[row], 3.75, 0.26);
            seen = 0;
            row++;
        }
    }
    dl_scene_free(s);
}

static void lattices_have_their_neighbours(void **state) {
    (void)state;
    static const struct {
        const char *frame, *item;
        size_t particles;
        int neighbours;
    } lattices[] = {
        {frame_2d, "lattice: {kind: hexagonal, spacing: 1.25, count: [6, 5]}", 30, 6},
        {frame_2d, "lattice: {kind: square, spacing: 1.25, count: [4, 7]}", 28, 4},
        {frame_3d, "lattice: {kind: simple-cubic, spacing: 1.25, count: [3, 4, 5]}", 60, 6},
        {frame_3d, "lattice: {kind: face-centred-cubic, spacing: 1.25, count: [3, 3, 2]}", 72, 12},
        {frame_2d, "lattice: {kind: hexagonal, spacing: 1.25, radius: 3.75}", 37, 6},
        {frame_2d, "lattice: {kind: square, spacing: 1.25, radius: 2.5, angle: 20}", 13, 4},
        {frame_3d, "lattice: {kind: simple-cubic, spacing: 1.25, radius: 1.25}", 7, 6},
        {frame_3d, "lattice: {kind: face-centred-cubic, spacing: 1.25, radius: 1.25}", 13, 12},
    };
    for (size_t k = 0; k < sizeof lattices / sizeof *lattices; k++) {
        dl_scene *const s = scene_of(lattices[k].frame, lattices[k].item);
        assert_int_equal(s->particles, lattices[k].particles);
        assert_near(nearest_distance(s), 1.25, 1e-12);
        assert_int_equal(most_neighbours(s, 1.25), lattices[k].neighbours);
        dl_scene_free(s);
    }
}

static void an_angle_turns_the_lattice_about_its_origin(void **state) {
    (void)state;
    dl_scene *const s = scene_of(
        frame_2d, "lattice: {kind: square, spacing: 2, count: [2, 2], origin: [1, 1], angle: 30}");
    const double c = sqrt(0.75), x[4] = {1, 1 + 2 * c, 1 - 1, 1 + 2 * c - 1},
                 y[4] = {1, 1 + 1, 1 + 2 * c, 1 + 1 + 2 * c};
    for (size_t i = 0; i < 4; i++) {
        assert_near(s->position[i], x[i], 1e-14);
        assert_near(s->position[4 + i], y[i], 1e-14);
    }
    dl_scene_free(s);
}

/* The sites of TR299's Table I, which is printed with about 0.01 of noise. */
static void swirl_by_rule_has_the_sites_of_the_table(void **state) {
    (void)state;
    dl_scene *const rule = read_scene(DL_STUDIES "/swirl/by-rule.yaml");
    dl_scene *const table = read_scene(DL_STUDIES "/swirl/swirl.yaml");
    assert_int_equal(rule->particles, 239);
    for (size_t i = 0; i < 239; i++) {
        double nearest = INFINITY;
        for (size_t j = 0; j < 239; j++)
            nearest = fmin(nearest, hypot(rule->position[i] - table->position[j],
                                          rule->position[239 + i] - table->position[239 + j]));
        assert_true(nearest < 0.03);
    }
    dl_scene_free(rule);
    dl_scene_free(table);
}

static void streams_by_rule_are_those_of_the_table(void **state) {
    (void)state;
    dl_scene *const rule = read_scene(DL_STUDIES "/stream/stream-v50-rule.yaml");
    dl_scene *const table = read_scene(DL_STUDIES "/stream/stream.yaml");
    assert_int_equal(rule->particles, 34);
    for (size_t i = 0; i < 34; i++) {
        const size_t mirrored = i < 11 ? i + 23 : i < 23 ? i : i - 23; /* rows from below */
        assert_near(rule->position[i], table->position[mirrored], 1e-14);
        assert_near(rule->position[34 + i], table->position[34 + mirrored], 1e-14);
    }
    dl_scene_free(rule);
    dl_scene_free(table);
}

/* --- random positions ------------------------------------------------------------------------- */

#define CROWD "random: {count: %d, in: [[-1, 4], [2, 6]], minimum_distance: 0.4}, seed: %d"

static dl_scene *crowd(const char *before, int count, int seed) {
    char rest[512];
    snprintf(rest, sizeof rest, "particles:\n%s  - {" CROWD "}", before, count, seed);
    return scene_with(frame_2d, rest);
}

static void random_particles_keep_their_distance(void **state) {
    (void)state;
    dl_scene *const s = crowd("  - {at: [1, 4]}\n  - {at: [2, 5]}\n", 60, 3);
    assert_int_equal(s->particles, 62);
    for (size_t i = 2; i < 62; i++) {
        assert_true(s->position[i] >= -1 && s->position[i] < 4);
        assert_true(s->position[62 + i] >= 2 && s->position[62 + i] < 6);
    }
    const double nearest = nearest_distance(s);
    assert_true(nearest >= 0.4 && nearest < 0.5);
    dl_scene_free(s);
}

/* 60 of the same seed are the first 60 of 70, to the bit, whatever stands before. */
static void random_particles_do_not_depend_on_others(void **state) {
    (void)state;
    dl_scene *const s = crowd("", 60, 3), *const again = crowd("", 60, 3);
    dl_scene *const more = crowd("", 70, 3), *const after = crowd("  - {at: [9, 9]}\n", 60, 3);
    dl_scene *const other = crowd("", 60, 4);
    assert_memory_equal(s->position, again->position, 120 * sizeof(double));
    for (size_t axis = 0; axis < 2; axis++) {
        assert_memory_equal(s->position + 60 * axis, more->position + 70 * axis,
                            60 * sizeof(double));
        assert_memory_equal(s->position + 60 * axis, after->position + 61 * axis + 1,
                            60 * sizeof(double));
    }
    for (size_t i = 0; i < 60; i++)
        assert_true(s->position[i] != other->position[i]);
    dl_scene *const all[] = {s, again, more, after, other};
    for (size_t k = 0; k < 5; k++)
        dl_scene_free(all[k]);
}

/* Without a seed of its own an item has the scene's and its place. */
static void items_have_streams_of_their_own(void **state) {
    (void)state;
    static const char box[] = "{random: {count: 5, in: [[0, 1], [0, 1]]}, speed: 2}";
    char rest[512];
    snprintf(rest, sizeof rest, "particles:\n  - %s\n  - %s", box, box);
    dl_scene *const s = scene_with(frame_2d, rest);
    assert_int_equal(s->particles, 10);
    for (size_t i = 0; i < 5; i++) {
        assert_true(s->position[i] != s->position[5 + i]);
        assert_true(s->velocity[i] != s->velocity[5 + i]);
    }
    dl_scene_free(s);
}

static void every_use_has_numbers_of_its_own(void **state) {
    (void)state;
    dl_scene *const s = scene_of(frame_2d, "random: {count: 9, in: [[-1, 1], [-1, 1]]}, "
                                           "velocity: [1, 0], perturb: {relative: 1}");
    for (size_t i = 0; i < 9; i++)
        assert_true(fabs(s->velocity[i] - 1 - s->position[i]) > 1e-6);
    dl_scene_free(s);
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* As many streams as particles: none is another's, so that no two coordinates agree. Without a
 * minimum distance nobody asks for the others, or this took minutes. */
static void many_particles_are_all_different(void **state) {
    (void)state;
    const size_t n = 300000;
    dl_scene *const s = scene_of(frame_2d, "random: {count: 300000, in: [[0, 1], [0, 1]]}");
    assert_int_equal(s->particles, n);
    double mean = 0;
    qsort(s->position, n, sizeof(double), ascending);
    for (size_t i = 0; i < n; i++) {
        mean += s->position[i] / (double)n;
        assert_true(i == 0 || s->position[i] > s->position[i - 1]);
    }
    assert_near(mean, 0.5, 5 / sqrt(12 * (double)n));
    dl_scene_free(s);
}

/* The generator and the mixing are part of what a scene means: these numbers stay. */
static void random_numbers_are_these(void **state) {
    (void)state;
    dl_scene *const s = scene_of(frame_2d, "random: {count: 2, in: [[0, 1], [0, 1]]}, seed: 1");
    const double expected[4] = {0.5327449687027439, 0.6686449416097346, 0.3592471758825688,
                                0.1386919091692036};
    assert_memory_equal(s->position, expected, sizeof expected);
    dl_scene_free(s);
}

typedef struct draw {
    int dimension;
    size_t before, count; /* particles of other items, of this one */
    double low[3], high[3], period[3], distance;
} draw;

static bool allows(const draw *d, const dl_scene *s, size_t placed, const double at[3]) {
    for (size_t j = 0; j < placed; j++) {
        double sum = 0;
        for (size_t c = 0; c < (size_t)d->dimension; c++) {
            const double apart = at[c] - s->position[c * s->particles + j];
            const double near = d->period[c] > 0 ? remainder(apart, d->period[c]) : apart;
            sum += near * near;
        }
        if (sum < d->distance * d->distance)
            return false;
    }
    return true;
}

/* What the scene has is what is drawn where each place is compared with all before, to the bit. */
static void compare_with_all_pairs(const draw *d, const char *around) {
    char rest[1024], in[128] = "";
    for (size_t c = 0, used = 0; c < (size_t)d->dimension; c++)
        used += (size_t)snprintf(in + used, sizeof in - used, "%s[%.17g, %.17g]", c ? ", " : "",
                                 d->low[c], d->high[c]);
    snprintf(rest, sizeof rest,
             "%s  - {random: {count: %zu, in: [%s], minimum_distance: %.17g}, seed: 5}", around,
             d->count, in, d->distance);
    dl_scene *const s = scene_with(d->dimension == 2 ? frame_2d : frame_3d, rest);
    assert_int_equal(s->particles, d->before + d->count);
    dl_random *random = NULL;
    assert_int_equal(dl_random_create(5, 0, &random, NULL), DL_OK);
    size_t drawn = 0;
    for (size_t i = 0; i < d->count; i++) {
        double at[3] = {0};
        dl_random_begin(random, i, DL_RANDOM_POSITION);
        do {
            drawn++;
            for (int c = 0; c < d->dimension; c++)
                at[c] = dl_random_uniform(random, d->low[c], d->high[c]);
        } while (!allows(d, s, d->before + i, at));
        for (size_t c = 0; c < (size_t)d->dimension; c++)
            if (s->position[c * s->particles + d->before + i] != at[c])
                fail_msg("particle %zu, axis %zu: %.17g, expected %.17g", i, c,
                         s->position[c * s->particles + d->before + i], at[c]);
    }
    assert_true(drawn > d->count + d->count / 4); /* some were too near */
    dl_random_free(random);
    dl_scene_free(s);
}

static void places_are_those_of_comparing_all_pairs(void **state) {
    (void)state;
    static const char boxed[] = "pair_law: [{until: 0.05, terms: [{coefficient: 1, power: 2}]}]\n"
                                "periodic: {x: [0, 3]}\n"
                                "particles:\n  - {at: [2.99, 0.5]}\n  - {at: [0.01, 40]}\n";
    static const char narrow[] = "pair_law: [{until: 0.5, terms: [{coefficient: 1, power: 2}]}]\n"
                                 "periodic: {x: [0, 1], y: [0, 9]}\nparticles:\n";
    compare_with_all_pairs(&(draw){2, 0, 900, {-10, 3}, {-7, 8}, {0}, 0.09}, "particles:\n");
    compare_with_all_pairs(&(draw){2, 2, 600, {0, -2}, {3, 2}, {3}, 0.1}, boxed);
    compare_with_all_pairs(&(draw){2, 0, 10, {0, 0}, {1, 9}, {1, 9}, 0.7}, narrow);
    compare_with_all_pairs(&(draw){3, 1, 700, {0, 0, -1}, {1, 1, 1}, {0}, 0.1},
                           "particles:\n  - {at: [0.5, 0.5, 1.0e15]}\n");
}

static void distances_go_through_a_periodic_box(void **state) {
    (void)state;
    dl_scene *const s =
        scene_with(frame_2d, "pair_law: [{until: 0.5, terms: [{coefficient: 1, power: 2}]}]\n"
                             "periodic: {x: [0, 3], y: [0, 3]}\n"
                             "particles:\n  - {random: {count: 30, in: [[0, 3], [0, 3]], "
                             "minimum_distance: 0.35}}");
    double nearest = INFINITY;
    for (size_t i = 0; i < 30; i++)
        for (size_t j = 0; j < i; j++) {
            const double x = fabs(s->position[i] - s->position[j]),
                         y = fabs(s->position[30 + i] - s->position[30 + j]);
            nearest = fmin(nearest, hypot(fmin(x, 3 - x), fmin(y, 3 - y)));
        }
    assert_true(nearest >= 0.35 && nearest < 0.45);
    dl_scene_free(s);
}

/* --- motion ----------------------------------------------------------------------------------- */

#define SITES "lattice: {kind: hexagonal, spacing: 1, radius: 3}, "
#define RING  SITES "mass: 4000, "

static void rotation_turns_counterclockwise(void **state) {
    (void)state;
    dl_scene *const s = scene_of(frame_2d, RING "rotation: {rate: 4}");
    for (size_t i = 0; i < 37; i++) {
        assert_near(s->velocity[i], -4 * s->position[37 + i], 1e-14);
        assert_near(s->velocity[37 + i], 4 * s->position[i], 1e-14);
    }
    dl_scene_free(s);
}

/* TR299 (3.1): each component is off by exactly + or - epsilon m/2000, both signs about as often.
 */
static void rotation_is_perturbed_by_mass(void **state) {
    (void)state;
    dl_scene *const s =
        scene_of(frame_2d, RING
                 "rotation: {rate: 4, perturbation: 10, reference_mass: 2000, about: [0.5, 1]}");
    int plus = 0, equal = 0;
    for (size_t i = 0; i < 37; i++) {
        const double x = s->velocity[i] + 4 * (s->position[37 + i] - 1),
                     y = s->velocity[37 + i] - 4 * (s->position[i] - 0.5);
        assert_near(fabs(x), 20, 1e-12);
        assert_near(fabs(y), 20, 1e-12);
        plus += (x > 0) + (y > 0);
        equal += (x > 0) == (y > 0);
    }
    assert_true(plus > 20 && plus < 54);
    assert_true(equal > 6 && equal < 31);
    dl_scene_free(s);
}

static void swirl_by_rule_obeys_the_signs_of_the_quadrants(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/swirl/by-rule.yaml");
    for (size_t i = 0; i < 239; i++) {
        const double x = s->position[i], y = s->position[239 + i];
        const double size = s->inertia[i] / 2000 * 10;
        const double turn_x = y > 0 ? -fabs(4 * y) : fabs(4 * y);
        const double turn_y = x > 0 ? fabs(4 * x) : -fabs(4 * x);
        assert_near(fabs(s->velocity[i] - turn_x), size, 1e-10);
        assert_near(fabs(s->velocity[239 + i] - turn_y), size, 1e-10);
    }
    dl_scene_free(s);
}

/* TR171: |e| <= 1 % of V, the maximum attains it, and the numbers are the same for all V. */
static void streams_are_perturbed_in_proportion(void **state) {
    (void)state;
    static const double speed[3] = {50, 300, 1000};
    double first[68];
    for (size_t k = 0; k < 3; k++) {
        char path[256];
        snprintf(path, sizeof path, DL_STUDIES "/stream/stream-v%.0f-rule.yaml", speed[k]);
        dl_scene *const s = read_scene(path);
        double largest = 0, smallest = INFINITY;
        for (size_t c = 0; c < 68; c++) {
            const double e = (s->velocity[c] - (c < 34 ? speed[k] : 0)) / speed[k];
            largest = fmax(largest, fabs(e));
            smallest = fmin(smallest, fabs(e));
            if (k == 0)
                first[c] = e;
            assert_near(e, first[c], 1e-15);
        }
        assert_near(largest, 0.01, 1e-15);
        assert_true(smallest < 1e-3);
        dl_scene_free(s);
    }
}

static void perturbation_need_not_be_normalised(void **state) {
    (void)state;
    dl_scene *const s = scene_of(frame_2d, RING "velocity: [0, 10], perturb: {relative: 0.5}");
    double largest = 0;
    for (size_t c = 0; c < 74; c++)
        largest = fmax(largest, fabs(s->velocity[c] - (c < 37 ? 0 : 10)));
    assert_true(largest < 5 && largest > 4);
    dl_scene_free(s);
}

#define CUBE "lattice: {kind: simple-cubic, spacing: 1, count: [10, 10, 10]}, mass: 2, "

static void speeds_and_temperatures(void **state) {
    (void)state;
    dl_scene *const s = scene_of(frame_3d, CUBE "speed: 3");
    double mean[3] = {0};
    for (size_t i = 0; i < 1000; i++) {
        double square = 0;
        for (size_t axis = 0; axis < 3; axis++) {
            const double v = component(s->velocity, s, i, axis);
            square += v * v;
            mean[axis] += v / 1000;
        }
        assert_near(sqrt(square), 3, 1e-13);
    }
    for (size_t axis = 0; axis < 3; axis++)
        assert_true(mean[axis] != 0 && fabs(mean[axis]) < 4 * 3 / sqrt(3000));
    dl_scene_free(s);

    /* 3000 components of variance T/m = 0.75: the sum of squares to 4 standard deviations */
    dl_scene *const warm = scene_of(frame_3d, CUBE "temperature: 1.5, drift: false");
    double squares = 0;
    for (size_t axis = 0; axis < 3; axis++) {
        double sum = 0;
        for (size_t i = 0; i < 1000; i++) {
            const double v = component(warm->velocity, warm, i, axis);
            sum += v;
            squares += v * v;
        }
        assert_near(sum, 0, 1e-11);
    }
    assert_near(squares / 3000, 0.75, 4 * 0.75 * sqrt(2.0 / 3000));
    dl_scene_free(warm);
}

/* --- masses ----------------------------------------------------------------------------------- */

static size_t count_mass(const dl_scene *s, double mass) {
    size_t count = 0;
    for (size_t i = 0; i < s->particles; i++)
        count += s->inertia[i] == mass;
    return count;
}

static void masses_are_dealt_out(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/swirl/by-rule.yaml");
    static const double mass[5] = {10000, 8000, 6000, 4000, 2000};
    static const size_t count[5] = {2, 4, 12, 26, 195};
    for (size_t k = 0; k < 5; k++)
        assert_int_equal(count_mass(s, mass[k]), count[k]);
    assert_memory_equal(s->inertia, s->coupling, 239 * sizeof(double));
    size_t in_the_first_half = 0;
    for (size_t i = 0; i < 120; i++)
        in_the_first_half += s->inertia[i] > 2000;
    assert_true(in_the_first_half > 8 && in_the_first_half < 36);
    dl_scene_free(s);
}

/* Example 3: 26 particles of Table I have another mass; no heavy one is left near the rim. */
static void exchange_brings_the_heavy_inwards(void **state) {
    (void)state;
    dl_scene *const table = read_scene(DL_STUDIES "/swirl/swirl.yaml");
    dl_scene *const s = read_scene(DL_STUDIES "/swirl/example3.yaml");
    assert_memory_equal(s->position, table->position, 478 * sizeof(double));
    assert_memory_equal(s->velocity, table->velocity, 478 * sizeof(double));
    size_t changed = 0;
    double heavy = 0, heavy_before = 0, outward = 0;
    for (size_t i = 0; i < 239; i++) {
        const double r = hypot(s->position[i], s->position[239 + i]);
        changed += s->inertia[i] != table->inertia[i];
        if (s->inertia[i] > 2000)
            heavy = fmax(heavy, r);
        if (table->inertia[i] > 2000)
            heavy_before = fmax(heavy_before, r);
        if (s->inertia[i] > table->inertia[i])
            outward = fmax(outward, r);
    }
    assert_int_equal(changed, 26);
    assert_true(heavy_before > 8.1 && heavy < 6.2 && outward < 2.1);
    for (double mass = 2000; mass <= 10000; mass += 2000)
        assert_int_equal(count_mass(s, mass), count_mass(table, mass));
    assert_memory_equal(s->inertia, s->coupling, 239 * sizeof(double));
    dl_scene_free(table);
    dl_scene_free(s);
}

static void earth_is_example_3_with_lighter_masses(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/swirl/earth.yaml");
    dl_scene *const example = read_scene(DL_STUDIES "/swirl/example3.yaml");
    assert_memory_equal(s->position, example->position, 478 * sizeof(double));
    assert_memory_equal(s->velocity, example->velocity, 478 * sizeof(double));
    for (size_t i = 0; i < 239; i++)
        assert_true(s->inertia[i] == 1500 + example->inertia[i] / 4);
    dl_scene_free(s);
    dl_scene_free(example);
}

/* --- refusals --------------------------------------------------------------------------------- */

static void rules_that_cannot_be_carried_out(void **state) {
    (void)state;
    static const struct {
        const char *frame, *item, *words[4];
    } refused[] = {
        {frame_2d,
         "at: [0, 0], lattice: {kind: square, spacing: 1, count: [2, 2]}",
         {":6:", "lattice", "one of at, file, lattice and random"}},
        {frame_2d, "velocity: [0, 0]", {":6:", "at: found nothing", "a lattice or random"}},
        {frame_2d,
         "file: t.csv, lattice: {kind: square, spacing: 1, count: [2, 2]}",
         {":6:", "lattice", "none beside a file"}},
        {frame_2d, "lattice: {kind: square, spacing: 1}", {":6:", "one of rows, count and radius"}},
        {frame_2d,
         "lattice: {kind: square, spacing: 1, count: [2, 2], radius: 3}",
         {":6:", "one of rows, count and radius"}},
        {frame_2d,
         "lattice: {kind: square, spacing: 1, rows: [2, 2]}",
         {":6:", "rows", "only a hexagonal lattice"}},
        {frame_2d,
         "lattice: {kind: hexagonal, spacing: 1, rows: [2, 0]}",
         {":6:", "rows", "\"0\"", ">= 1"}},
        {frame_2d,
         "lattice: {kind: hexagonal, spacing: 1, count: [2]}",
         {":6:", "count", "2 whole numbers"}},
        {frame_2d,
         "lattice: {kind: simple-cubic, spacing: 1, count: [2, 2, 2]}",
         {":6:", "kind", "in two dimensions"}},
        {frame_3d,
         "lattice: {kind: hexagonal, spacing: 1, count: [2, 2]}",
         {":6:", "kind", "in three dimensions"}},
        {frame_3d,
         "lattice: {kind: simple-cubic, spacing: 1, radius: 1, angle: 10}",
         {":6:", "angle", "none in three dimensions"}},
        {frame_2d,
         "lattice: {kind: hexagonall, spacing: 1, count: [2, 2]}",
         {":6:", "did you mean \"hexagonal\"?"}},
        {frame_2d,
         "lattice: {kind: square, spacing: 1, count: [2000, 2000]}",
         {":6:", "more than 1000000"}},
        {frame_2d,
         "lattice: {kind: square, spacing: 1, radius: 1e9}",
         {":6:", "radius", "at most 1000000 particles"}},
        {frame_2d,
         "lattice: {kind: square, spacing: 1e-7, radius: 1}",
         {":6:", "radius: found 1", "at a spacing of 1e-07"}},
        {frame_3d,
         "lattice: {kind: face-centred-cubic, spacing: 1e-4, radius: 1}",
         {":6:", "radius", "at most 1000000 particles"}},
        {frame_2d, "random: {count: 5}", {":6:", "in: found nothing", "[[x0, x1], [y0, y1]]"}},
        {frame_2d, "random: {count: 5, in: [[0, 1]]}", {":6:", "in", "[[x0, x1], [y0, y1]]"}},
        {frame_2d, "random: {count: 5, in: [[0, 1], [2, 2]]}", {":6:", "[2, 2]", "low < high"}},
        {frame_2d, "random: {count: 0, in: [[0, 1], [0, 1]]}", {":6:", "count", "\"0\""}},
        {frame_2d,
         "random: {count: 50, in: [[0, 1], [0, 1]], minimum_distance: 0.3, tries: 200}",
         {":6:", "of 50 in 200 tries", "minimum_distance below 0.3"}},
        {frame_2d, "random: {count: 5, in: [[0, 1], [0, 1]]}, speed: -1", {":6:", "speed", ">= 0"}},
        {frame_2d,
         "random: {count: 5, in: [[0, 1], [0, 1]]}, pinned: true, speed: 1",
         {":6:", "velocity", "pinned"}},
        {frame_2d, RING "perturb: {relative: 0.1}", {":6:", "perturb", "a velocity other than 0"}},
        {frame_2d, RING "rotation: {perturbation: 1}", {":6:", "rate", "nothing"}},
        {frame_2d, SITES "masses: [[1, 2], [2, 3]]", {":6:", "add up to 5", "expected 37"}},
        {frame_2d, SITES "masses: [[1, 36.5], [2, 0.5]]", {":6:", "masses", "whole number"}},
        {frame_2d, SITES "masses: [[0, 37]]", {":6:", "masses", "mass > 0"}},
        {frame_2d, RING "masses: [[1, 37]]", {":6:", "masses", "none beside a mass"}},
        {frame_2d,
         SITES "inertia: 2, coupling: 3, masses: [[1, 37]]",
         {":6:", "masses", "inertia and coupling"}},
        {frame_2d, RING "exchange: {pairs: 1}", {":6:", "pairs", "at most 0"}},
        {frame_2d,
         SITES "masses: [[1, 20], [2, 17]], exchange: {pairs: 17}",
         {":6:", "pairs", "found 17, expected at most"}},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        char rest[1024];
        snprintf(rest, sizeof rest, "particles:\n  - {%s}", refused[i].item);
        assert_refused(refused[i].frame, rest, refused[i].words);
    }
}

/* --- another run ------------------------------------------------------------------------------ */

static void path_of(const char *name, char path[160]) {
    snprintf(path, 160, "%s/%s", folder, name);
}

static dl_status append(void *context, const dl_sample *sample, dl_error *error) {
    return dl_trajectory_append(context, sample, error);
}

/* Runs `scene` by leap-frog, two steps a sample, to folder/name; gives the last state. */
static finished run_to_file(const dl_scene *scene, const char *name, size_t steps) {
    char path[160];
    path_of(name, path);
    dl_error error = {""};
    dl_trajectory *trajectory = NULL;
    if (dl_trajectory_create(path, scene, "leapfrog", "", &trajectory, &error))
        fail_msg("%s", error.message);
    dl_run_options how = run_options((double)steps * scene->step, 2 * scene->step);
    how.on_sample = append;
    how.context = trajectory;
    finished run = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(run.summary.status, DL_OK);
    assert_int_equal(dl_trajectory_close(trajectory, &error), DL_OK);
    return run;
}

static dl_scene *scene_in_folder(const char *name, const char *text) {
    char path[160];
    path_of(name, path);
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
    return read_scene(path);
}

static const char mixed[] = "name: mixed\ndimension: 2\n"
                            "particles:\n"
                            "  - {at: [0, 0], velocity: [1, 2], inertia: 2, coupling: 3}\n"
                            "  - {at: [5, 1], velocity: [0, 7], mass: 4, gravity: false}\n"
                            "  - {at: [9, 8], mass: 5, pinned: true}\n"
                            "  - {at: [3, 6], velocity: [4, -1], mass: 6}\n"
                            "  - {at: [6, 4], velocity: [-3, 0], mass: 7}\n"
                            "pair_law: [{terms: [{coefficient: 1, power: 2}]}]\n"
                            "gravity: [0, -1]\n"
                            "time: {step: 0.01, end: 0.1}\n";

/* Which particles of `mixed` a scene has that starts from it. */
static dl_scene *start_scene(const char *start, const char *particles) {
    char text[1024];
    snprintf(text, sizeof text,
             "name: next\ndimension: 2\nstart: {from: mixed.h5%s}\n%s"
             "pair_law: [{terms: [{coefficient: 1, power: 2}]}]\n"
             "time: {step: 0.01, end: 0.1}\n",
             start, particles);
    return scene_in_folder("next.yaml", text);
}

static void assert_is(const dl_scene *s, size_t i, const dl_scene *from, const double *y,
                      size_t k) {
    const size_t n = from->particles;
    for (size_t axis = 0; axis < 2; axis++) {
        assert_true(component(s->position, s, i, axis) == y[axis * n + k]);
        assert_true(component(s->velocity, s, i, axis) == y[(2 + axis) * n + k]);
    }
    assert_true(s->inertia[i] == from->inertia[k] && s->coupling[i] == from->coupling[k]);
    assert_int_equal(s->pinned[i], from->pinned[k]);
    assert_int_equal(s->feels_gravity[i], from->feels_gravity[k]);
}

static void a_scene_starts_where_another_ended(void **state) {
    (void)state;
    dl_scene *const from = scene_of_text(mixed);
    finished run = run_to_file(from, "mixed.h5", 10);
    dl_scene *const s =
        start_scene("", "particles:\n  - {at: [20, 20], velocity: [1, 0], mass: 9}\n");
    assert_int_equal(s->particles, 6);
    for (size_t i = 0; i < 5; i++)
        assert_is(s, i, from, run.y, i);
    assert_non_null(s->start);
    assert_non_null(strstr(s->start, "mixed.h5")); /* explain names it */
    assert_null(from->start);
    assert_true(s->position[5] == 20 && s->velocity[5] == 1 && s->inertia[5] == 9);
    dl_scene_free(s);

    /* frame 0 is the start itself */
    dl_scene *const again = start_scene(", frame: 0", "");
    assert_int_equal(again->particles, 5);
    assert_memory_equal(again->position, from->position, 10 * sizeof(double));
    assert_memory_equal(again->velocity, from->velocity, 10 * sizeof(double));
    dl_scene_free(again);
    dl_scene_free(from);
    free(run.y);
}

/* A run that no pair law acts in keeps what a later one needs. */
static void couplings_outlive_a_run_without_a_law(void **state) {
    (void)state;
    dl_scene *const from =
        scene_of_text("name: free\ndimension: 2\n"
                      "particles: [{at: [0, 0], velocity: [1, 0], inertia: 2, coupling: 5}]\n"
                      "time: {step: 0.01, end: 0.1}\n");
    finished run = run_to_file(from, "mixed.h5", 10);
    dl_scene *const s = start_scene("", "");
    assert_true(s->inertia[0] == 2 && s->coupling[0] == 5);
    dl_scene_free(s);
    dl_scene_free(from);
    free(run.y);
}

static void particles_are_taken_away(void **state) {
    (void)state;
    dl_scene *const from = scene_of_text(mixed);
    finished run = run_to_file(from, "mixed.h5", 10);
    static const struct {
        const char *remove;
        size_t left, which[5];
    } removed[] = {
        {", remove: {rows: [1, 4]}", 3, {1, 2, 4}},
        {", remove: {above: 5}", 3, {0, 1, 4}},
        {", remove: {highest: 2}", 3, {0, 1, 4}},
        {", remove: {fastest: 1}", 4, {0, 2, 3, 4}},
        {", remove: {fastest: 2}", 3, {0, 2, 4}},
        {", remove: {above: 7, highest: 1}", 3, {0, 1, 4}},
        {", remove: {rows: [2], fastest: 1}", 3, {0, 2, 4}},
        {", remove: {highest: 0}", 5, {0, 1, 2, 3, 4}},
    };
    for (size_t k = 0; k < sizeof removed / sizeof *removed; k++) {
        dl_scene *const s = start_scene(removed[k].remove, "");
        assert_int_equal(s->particles, removed[k].left);
        for (size_t i = 0; i < s->particles; i++)
            assert_is(s, i, from, run.y, removed[k].which[i]);
        dl_scene_free(s);
    }
    dl_scene_free(from);
    free(run.y);
}

static void starts_that_are_refused(void **state) {
    (void)state;
    dl_scene *const from = scene_of_text(mixed);
    finished run = run_to_file(from, "mixed.h5", 10);
    static const struct {
        const char *start, *words[4];
    } refused[] = {
        {"{from: none.h5}", {":5:", "from", "none.h5", "cannot be read"}},
        {"{from: none.h5, made_by: driftlab run x --out none.h5}",
         {":5:", "cannot be read", "it is made by: driftlab run x --out none.h5"}},
        {"{from: refused.yaml, made_by: driftlab run x}", {":5:", "no HDF5 file"}},
        {"{from: mixed.h5, frame: 6}", {":5:", "no frame 6", "0 to 5"}},
        {"{from: mixed.h5, frame: -1}", {":5:", "frame", "last or a whole number"}},
        {"{from: mixed.h5, frame: first}", {":5:", "frame", "last or a whole number"}},
        {"{from: mixed.h5, remove: {rows: [6]}}", {":5:", "rows", "\"6\"", "<= 5"}},
        {"{from: mixed.h5, remove: {highest: 6}}", {":5:", "highest", "at most 5"}},
        {"{from: mixed.h5, remove: {highest: 3, fastest: 3}}", {":5:", "fastest", "at most 2"}},
        {"{from: mixed.h5, remove: {highest: 5}}", {":5:", "start", "a particle that is left"}},
        {"{from: mixed.h5, remove: {abov: 5}}", {":5:", "did you mean \"above\"?"}},
        {"{frame: last}", {":5:", "from", "nothing"}},
    };
    for (size_t i = 0; i < sizeof refused / sizeof *refused; i++) {
        char rest[512];
        snprintf(rest, sizeof rest, "start: %s", refused[i].start);
        assert_refused(frame_2d, rest, refused[i].words);
    }
    dl_scene_free(from);
    free(run.y);
}

static void species_come_along(void **state) {
    (void)state;
    static const char laws[] = "pair_laws:\n"
                               "  - {between: [oil, oil], pieces: none}\n"
                               "  - {between: [oil, water], pieces: none}\n"
                               "  - {between: [water, water], pieces: none}\n"
                               "time: {step: 0.01, end: 0.1}\n";
    char text[1024];
    snprintf(text, sizeof text,
             "name: two\ndimension: 2\nparticles:\n"
             "  - {at: [0, 0], species: water}\n  - {at: [1, 0], species: oil}\n%s",
             laws);
    dl_scene *const from = scene_of_text(text);
    finished run = run_to_file(from, "two.h5", 2);
    snprintf(text, sizeof text, "name: next\ndimension: 2\nstart: {from: two.h5}\n%s", laws);
    dl_scene *const s = scene_in_folder("next.yaml", text);
    assert_int_equal(s->particles, 2);
    for (size_t i = 0; i < 2; i++)
        assert_string_equal(s->species_name[s->species_of[i]],
                            from->species_name[from->species_of[i]]);
    dl_scene_free(s);
    dl_scene_free(from);
    free(run.y);
}

static dl_scene *settling_scene(const char *name) {
    char source[256], copy[160], command[512];
    snprintf(source, sizeof source, DL_STUDIES "/settling/%s", name);
    path_of(name, copy);
    snprintf(command, sizeof command, "cp %s %s", source, copy);
    assert_int_equal(system(command), 0);
    return read_scene(copy);
}

/* As many are higher than the highest of `s` as it has fewer. */
static void assert_highest_removed(const dl_scene *s, const finished *before, size_t particles) {
    double top = 0;
    size_t higher = 0;
    for (size_t i = 0; i < s->particles; i++)
        top = fmax(top, component(s->position, s, i, 1));
    for (size_t i = 0; i < particles; i++)
        higher += before->y[particles + i] > top;
    assert_int_equal(higher, particles - s->particles);
}

/* TR323: 300, 280, 278; here a few steps each. */
static void settling_goes_from_300_to_278(void **state) {
    (void)state;
    static const struct {
        const char *scene, *run;
        size_t particles;
    } stage[3] = {{"random300.yaml", "random300.h5", 300},
                  {"remove20.yaml", "remove20.h5", 280},
                  {"remove2.yaml", "remove2.h5", 278}};
    finished before = {.y = NULL};
    for (size_t k = 0; k < 3; k++) {
        dl_scene *const s = settling_scene(stage[k].scene);
        const size_t n = s->particles;
        assert_int_equal(n, stage[k].particles);
        assert_true(s->step == 1e-4);
        if (k == 0)
            assert_true(nearest_distance(s) >= 0.2);
        else
            assert_highest_removed(s, &before, stage[k - 1].particles);
        free(before.y);
        before = run_to_file(s, stage[k].run, 20);
        assert_true(before.summary.energy_error_max < 1e-2 * before.summary.energy_scale);
        dl_scene_free(s);
    }
    free(before.y);
}

/* --- the papers' scenes ----------------------------------------------------------------------- */

static dl_status keep_height(void *context, const dl_sample *sample, dl_error *error) {
    (void)error;
    double *const height = context;
    height[sample->index] = sample->y_all[10]; /* y of P1 of ten */
    return DL_OK;
}

/* TR171, Figure 3.10: P1 at y = -0.05244 at t25, which the program's reading reaches at step 24 and
 * then keeps to 2e-5; as printed P1 bounces. */
static void penetration_is_the_published_one(void **state) {
    (void)state;
    static const struct {
        const char *scene;
        size_t step;
        double y, tolerance;
    } published[] = {
        {"penetration-program-p9", 24, -0.05244, 5e-6},
        {"penetration-program-p8", 24, -0.05244, 5e-6},
        {"penetration-program-p9", 25, -0.05242, 5e-6},
        {"penetration-printed-p9", 25, 0.2376, 5e-5},
        {"penetration-printed-p8", 25, 0.2376, 5e-5},
    };
    for (size_t k = 0; k < sizeof published / sizeof *published; k++) {
        char path[256];
        double height[26] = {0};
        snprintf(path, sizeof path, DL_STUDIES "/wall/%s.yaml", published[k].scene);
        dl_scene *const s = read_scene(path);
        assert_int_equal(s->particles, 10);
        dl_run_options how = run_options(25e-5, 1e-5);
        how.on_sample = keep_height;
        how.context = height;
        finished run = run_with(s, method_of("conserving-newton-dense"), "", &how);
        assert_int_equal(run.summary.status, DL_OK);
        assert_true(run.summary.energy_error_max < 1e-12 * run.summary.energy_scale);
        assert_near(height[published[k].step], published[k].y, published[k].tolerance);
        free(run.y);
        dl_scene_free(s);
    }
}

static void walls_are_at_equilibrium(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/wall/graze-printed-p8.yaml");
    assert_int_equal(s->particles, 9);
    const double spacing = cbrt(9e-5 / 6e-2);
    for (size_t i = 2; i < 9; i++)
        assert_near(s->position[i] - s->position[i - 1], spacing, 1e-15);
    for (size_t i = 0; i < 9; i++) {
        assert_int_equal(s->pinned[i], i == 1 || i == 7); /* P2 and P8 */
        assert_int_equal(s->feels_gravity[i], i == 0);
    }
    dl_scene_free(s);
}

static void run_a_little(const char *path) {
    dl_scene *const s = read_scene(path);
    dl_run_options how = run_options(5 * s->step, 5 * s->step);
    how.energy_bound = 1e3; /* at V = 1000 leap-frog loses more than the scale at once */
    assert_true(s->source[0] != '\0');
    finished run = run_with(s, method_of("leapfrog"), "", &how);
    if (run.summary.status)
        fail_msg("%s: %s", path, run.summary.message);
    free(run.y);
    dl_scene_free(s);
}

/* Every scene of these folders reads and takes its first steps; those that start from a run say
 * which one they lack. */
static void every_scene_of_the_papers_runs(void **state) {
    (void)state;
    static const struct {
        const char *pattern;
        size_t least;
    } scenes[] = {
        {"/stream/stream-*.yaml", 3}, {"/wall/*.yaml", 8},         {"/swirl/e*.yaml", 4},
        {"/swirl/by-rule.yaml", 1},   {"/swirl/slow.yaml", 1},     {"/drop/drop?.yaml", 3},
        {"/swirl/states/*.yaml", 10}, {"/fluids/fluid*.yaml", 18}, {"/depth/*.yaml", 2}};
    for (size_t k = 0; k < sizeof scenes / sizeof *scenes; k++) {
        char pattern[256];
        glob_t found;
        snprintf(pattern, sizeof pattern, DL_STUDIES "%s", scenes[k].pattern);
        assert_int_equal(glob(pattern, 0, NULL, &found), 0);
        assert_true(found.gl_pathc >= scenes[k].least);
        for (size_t i = 0; i < found.gl_pathc; i++)
            run_a_little(found.gl_pathv[i]);
        globfree(&found);
    }
}

static void fluids_are_those_of_table_ii(void **state) {
    (void)state;
    static const int particles[16] = {300, 267, 267, 267, 300, 582, 300, 267,
                                      267, 300, 300, 300, 247, 300, 300, 300};
    static const double cutoff[16] = {INFINITY, INFINITY, INFINITY, INFINITY, INFINITY, INFINITY,
                                      INFINITY, INFINITY, INFINITY, 2,        1.5,      1.5,
                                      2,        2,        2,        1.5};
    for (size_t k = 0; k < 16; k++) {
        char path[256];
        snprintf(path, sizeof path, DL_STUDIES "/fluids/fluid%02zu.yaml", k + 1);
        dl_scene *const s = read_scene(path);
        assert_int_equal(s->particles, particles[k]);
        assert_true(s->inertia[0] == 2.5);
        assert_true(s->law.piece[0].until == cutoff[k]);
        assert_true(s->walls.high[0] == (k == 5 || k == 12 || k == 14 ? 10 : 6));
        dl_scene_free(s);
    }
    /* the mean kinetic energies of Table II */
    static const struct {
        const char *file;
        double energy, tolerance;
    } settled[2] = {{"04-table", 0.69, 0.005}, {"10-table", 47.20, 0.005}};
    for (size_t k = 0; k < 2; k++) {
        char path[256];
        double sum = 0;
        snprintf(path, sizeof path, DL_STUDIES "/fluids/fluid%s.yaml", settled[k].file);
        dl_scene *const s = read_scene(path);
        for (size_t c = 0; c < 2 * s->particles; c++)
            sum += 0.5 * 2.5 * s->velocity[c] * s->velocity[c];
        assert_near(sum / (double)s->particles, settled[k].energy, settled[k].tolerance);
        dl_scene_free(s);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rows_are_a_hexagonal_lattice),
        cmocka_unit_test(lattices_have_their_neighbours),
        cmocka_unit_test(an_angle_turns_the_lattice_about_its_origin),
        cmocka_unit_test(swirl_by_rule_has_the_sites_of_the_table),
        cmocka_unit_test(streams_by_rule_are_those_of_the_table),
        cmocka_unit_test(random_particles_keep_their_distance),
        cmocka_unit_test(random_particles_do_not_depend_on_others),
        cmocka_unit_test(items_have_streams_of_their_own),
        cmocka_unit_test(every_use_has_numbers_of_its_own),
        cmocka_unit_test(many_particles_are_all_different),
        cmocka_unit_test(random_numbers_are_these),
        cmocka_unit_test(places_are_those_of_comparing_all_pairs),
        cmocka_unit_test(distances_go_through_a_periodic_box),
        cmocka_unit_test(rotation_turns_counterclockwise),
        cmocka_unit_test(rotation_is_perturbed_by_mass),
        cmocka_unit_test(swirl_by_rule_obeys_the_signs_of_the_quadrants),
        cmocka_unit_test(streams_are_perturbed_in_proportion),
        cmocka_unit_test(perturbation_need_not_be_normalised),
        cmocka_unit_test(speeds_and_temperatures),
        cmocka_unit_test(masses_are_dealt_out),
        cmocka_unit_test(exchange_brings_the_heavy_inwards),
        cmocka_unit_test(earth_is_example_3_with_lighter_masses),
        cmocka_unit_test(rules_that_cannot_be_carried_out),
        cmocka_unit_test(a_scene_starts_where_another_ended),
        cmocka_unit_test(couplings_outlive_a_run_without_a_law),
        cmocka_unit_test(particles_are_taken_away),
        cmocka_unit_test(starts_that_are_refused),
        cmocka_unit_test(species_come_along),
        cmocka_unit_test(settling_goes_from_300_to_278),
        cmocka_unit_test(penetration_is_the_published_one),
        cmocka_unit_test(walls_are_at_equilibrium),
        cmocka_unit_test(every_scene_of_the_papers_runs),
        cmocka_unit_test(fluids_are_those_of_table_ii),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
