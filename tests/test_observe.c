/* Observables against states made by hand, the papers' tables, and the command that prints them. */
#include "fixture_folder.h"
#include "fixture_runs.h"

#include "fixture_scenes.h"

#include <jansson.h>
#include <sys/wait.h>

#include "driftlab/observe.h"
#include "driftlab/trajectory.h"

#define SETTLED DL_STUDIES "/drop/settled.yaml"

static double *state_of(const dl_scene *scene) {
    const size_t block = (size_t)scene->dimension * scene->particles;
    double *y_all = malloc(2 * block * sizeof *y_all);
    assert_non_null(y_all);
    memcpy(y_all, scene->position, block * sizeof *y_all);
    memcpy(y_all + block, scene->velocity, block * sizeof *y_all);
    return y_all;
}

static dl_model *model_of(const dl_scene *scene) {
    dl_model *model = NULL;
    dl_error error = {""};
    if (dl_model_create(scene, &model, &error))
        fail_msg("%s", error.message);
    return model;
}

static void assert_near(double found, double expected, double tolerance) {
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("found %.17g, expected %.17g", found, expected);
}

/* --- motion and temperature ------------------------------------------------------------------- */

/* Ten particles of several masses that turn rigidly at `rate` about their mass centre, which moves
 * with (3, -7); in three dimensions none moves along z but with the whole. */
static dl_scene *turning(int dimension, double rate) {
    dl_scene *scene = fixture_scene("turning", dimension, 10);
    const double drift[3] = {3, -7, 11};
    double centre[3] = {0}, mass = 0;
    for (unsigned i = 0; i < 10; i++) {
        scene->inertia[i] = 1 + i % 4;
        const double at[3] = {5 + fixture_noise(3 * i), fixture_noise(3 * i + 1) - 2,
                              fixture_noise(3 * i + 2)};
        fixture_place(scene, i, at, drift);
        mass += scene->inertia[i];
        for (int c = 0; c < 2; c++)
            centre[c] += scene->inertia[i] * at[c];
    }
    for (size_t i = 0; i < 10; i++) {
        const double x = scene->position[i] - centre[0] / mass;
        const double y = scene->position[10 + i] - centre[1] / mass;
        scene->velocity[i] -= rate * y;
        scene->velocity[10 + i] += rate * x;
    }
    return scene;
}

static void rigid_motion_has_no_temperature(void **state) {
    (void)state;
    static const double rates[] = {0, 4, -2.5};
    for (int dimension = 2; dimension <= 3; dimension++)
        for (size_t k = 0; k < 3; k++) {
            dl_scene *scene = turning(dimension, rates[k]);
            double *y_all = state_of(scene), heat[10];
            dl_motion motion;
            dl_observe_motion(scene, y_all, &motion);
            assert_near(motion.mass, 23, 0);
            assert_near(motion.velocity[0], 3, 1e-13);
            assert_near(motion.velocity[1], -7, 1e-13);
            assert_near(motion.angular_velocity, rates[k], 1e-12);
            assert_near(motion.rigid_rotation, rates[k], 1e-12);
            dl_observe_heat(scene, y_all, heat);
            for (size_t i = 0; i < 10; i++)
                assert_near(heat[i], 0, 1e-22);
            free(y_all);
            dl_scene_free(scene);
        }
}

/* Two of mass 2 at (1, 0) and (-1, 0): the first with velocity (3, 5), the second (-3, 1). Relative
 * to (0, 3): (3, 2) and (-3, -2); angular velocity 2; what is left is (3, 0) and (-3, 0). A third
 * one of mass 4 sits at the centre with (0, 3): it has no angle and no heat. */
/* In a periodic box there is no centre to turn about: what is not the drift is heat, and it does
 * not matter by which copy a particle is counted. */
static void a_periodic_box_does_not_turn(void **state) {
    (void)state;
    dl_scene *scene = turning(2, 4);
    scene->periods.present = true;
    for (size_t c = 0; c < 2; c++) {
        scene->periods.low[c] = -10;
        scene->periods.length[c] = 20;
    }
    double *y_all = state_of(scene), heat[10], moved[10];
    dl_motion motion;
    dl_observe_motion(scene, y_all, &motion);
    assert_near(motion.angular_velocity, 0, 0);
    assert_near(motion.rigid_rotation, 0, 0);
    dl_observe_heat(scene, y_all, heat);
    for (size_t i = 0; i < 10; i++) {
        const double vx = y_all[20 + i] - 3, vy = y_all[30 + i] + 7;
        assert_near(heat[i], scene->inertia[i] / 2 * (vx * vx + vy * vy), 1e-10);
    }
    y_all[4] += 20;
    dl_observe_heat(scene, y_all, moved);
    for (size_t i = 0; i < 10; i++)
        assert_near(moved[i], heat[i], 1e-10);
    dl_observe_options how;
    dl_observe_options_default(&how);
    bool *wanted = calloc(dl_observable_count(), sizeof *wanted);
    size_t index;
    dl_observation *observation = NULL;
    dl_error error = {""};
    assert_non_null(wanted);
    assert_int_equal(dl_observable_find("motion", &index, NULL), DL_OK);
    wanted[index] = true;
    assert_int_equal(dl_observation_create(scene, &how, wanted, 1, -2, 2, &observation, &error),
                     DL_INPUT);
    assert_non_null(strstr(error.message, "motion: found a periodic box"));
    free(wanted);
    free(y_all);
    dl_scene_free(scene);
}

static void temperature_of_a_known_mixture(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("mixture", 2, 3);
    scene->inertia[0] = scene->inertia[1] = 2;
    scene->inertia[2] = 4;
    fixture_place(scene, 0, (double[3]){1, 0}, (double[3]){3, 5});
    fixture_place(scene, 1, (double[3]){-1, 0}, (double[3]){-3, 1});
    fixture_place(scene, 2, (double[3]){0, 0}, (double[3]){0, 3});
    double *y_all = state_of(scene), heat[3], radius[3], normal[3], tangential[3];
    dl_motion motion;
    dl_observe_motion(scene, y_all, &motion);
    assert_near(motion.velocity[1], 3, 1e-15);
    assert_near(motion.angular_velocity, 2, 1e-15);
    dl_observe_polar(scene, y_all, &motion, radius, normal, tangential);
    assert_near(radius[0], 1, 0);
    assert_near(normal[0], 3, 1e-15);
    assert_near(normal[1], 3, 1e-15);
    assert_near(tangential[0], 2, 1e-15);
    assert_near(tangential[1], 2, 1e-15);
    dl_observe_heat(scene, y_all, heat);
    assert_near(heat[0], 9, 1e-14);
    assert_near(heat[1], 9, 1e-14);
    assert_near(heat[2], 0, 1e-14);
    scene->pinned[2] = true; /* no part of the system */
    dl_observe_motion(scene, y_all, &motion);
    assert_near(motion.mass, 4, 0);
    free(y_all);
    dl_scene_free(scene);
}

/* Two particles that fly apart with `speed` each: T' = m v^2 / 2 = v^2 / 2. */
static void spread(const dl_scene *scene, double speed, double *y_all) {
    memcpy(y_all, scene->position, 4 * sizeof *y_all);
    y_all[4] = speed;
    y_all[5] = -speed;
    y_all[6] = y_all[7] = 0;
}

static double temperature_after(const dl_temperature_rule *rule, size_t steps, size_t frames,
                                size_t every) {
    dl_scene *scene = fixture_scene("spread", 2, 2);
    fixture_place(scene, 0, (double[3]){1, 0}, (double[3]){0});
    fixture_place(scene, 1, (double[3]){-1, 0}, (double[3]){0});
    scene->step = 0.01;
    dl_thermometer *thermometer = NULL;
    double y_all[8], temperature[2];
    assert_int_equal(dl_thermometer_create(scene, rule, steps, &thermometer, NULL), DL_OK);
    for (size_t k = 0; k < frames; k += every) {
        spread(scene, (double)k, y_all);
        assert_int_equal(dl_thermometer_add(thermometer, 0.01 * (double)k, y_all, NULL), DL_OK);
    }
    assert_int_equal(dl_thermometer_add(thermometer, 0, y_all, NULL), DL_INPUT);
    dl_thermometer_read(thermometer, temperature);
    assert_near(temperature[0], temperature[1], 0);
    dl_thermometer_free(thermometer);
    dl_scene_free(scene);
    return temperature[0];
}

static void temperatures_are_averages(void **state) {
    (void)state;
    /* Frames 30 ... 49 of the window of 20 steps; all of them where the window is longer. */
    double sum = 0, all = 0, program = 0;
    for (int k = 0; k < 50; k++) {
        const double heat = 0.5 * k * k;
        sum += k >= 30 ? heat : 0;
        all += heat;
        program = k ? (19 * program + heat / 1e3) / 20 : heat / 1e3;
    }
    assert_near(temperature_after(&dl_temperature_published, 20, 50, 1), sum / 20 / 1e4, 1e-14);
    assert_near(temperature_after(&dl_temperature_published, 500, 50, 1), all / 50 / 1e4, 1e-14);
    assert_near(temperature_after(&dl_temperature_program, 20, 50, 1), program, 1e-14);
    /* Every seventh step: frames 35, 42, 49; and the past forgotten as fast. */
    const double seventh[] = {35, 42, 49};
    double mean = 0, recursive = 0;
    for (int k = 0; k < 3; k++)
        mean += 0.5 * seventh[k] * seventh[k] / 3 / 1e4;
    for (int k = 7; k < 50; k += 7)
        recursive += (0.5 * k * k / 1e3 - recursive) * (1 - pow(0.95, 7));
    assert_near(temperature_after(&dl_temperature_published, 20, 50, 7), mean, 1e-14);
    assert_near(temperature_after(&dl_temperature_program, 20, 50, 7), recursive, 1e-14);
    dl_thermometer *none;
    dl_scene *scene = fixture_scene("none", 2, 1);
    assert_int_equal(dl_thermometer_create(scene, &dl_temperature_program, 0, &none, NULL),
                     DL_INPUT);
    dl_scene_free(scene);
}

static void states_by_table_4(void **state) {
    (void)state;
    dl_state_threshold at;
    assert_int_equal(dl_state_threshold_at(&dl_tr299_table4, 2000, &at, NULL), DL_OK);
    assert_near(at.v_liquid, 50, 0);
    assert_near(at.v_gas, 80, 0);
    assert_int_equal(dl_observe_state(&at, 709.9), DL_SOLID);
    assert_int_equal(dl_observe_state(&at, 710), DL_LIQUID);
    assert_int_equal(dl_observe_state(&at, 2129.9), DL_LIQUID);
    assert_int_equal(dl_observe_state(&at, 2130), DL_GAS);
    assert_int_equal(dl_state_threshold_at(&dl_tr299_table4, 10000, &at, NULL), DL_OK);
    assert_near(at.gas, 30200, 0);
    assert_int_equal(dl_state_threshold_at(&dl_tr299_table4, 3500, &at, NULL), DL_OK);
    assert_near(at.liquid, 710 + 0.75 * (1160 - 710), 1e-10);
    assert_near(at.gas, 2130 + 0.75 * (5300 - 2130), 1e-10);
    dl_error error = {""};
    assert_int_equal(dl_state_threshold_at(&dl_tr299_table4, 1999, &at, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "mass 1999, expected masses from 2000 to 10000"));
    assert_int_equal(dl_state_threshold_at(&dl_tr299_table4, 10001, &at, NULL), DL_INPUT);
}

/* --- escape ----------------------------------------------------------------------------------- */

/* A triangle that stays, a pair 5 away from its mass centre that moves with `speed` along x, and
 * gravity between all: F = -1/r^2, linked within 1.5. */
static dl_escape escape_at(double speed, double beyond, bool escaped[5]) {
    dl_scene *scene = fixture_scene("escape", 2, 5);
    scene->law.pieces = 1;
    scene->law.piece[0].until = INFINITY;
    scene->law.piece[0].terms = 1;
    scene->law.piece[0].term[0] = (dl_term){.coefficient = -1, .power = 2};
    static const double at[5][3] = {{-1, 0}, {0.5, 0.7}, {0.5, -0.7}, {5, 0.5}, {5, -0.5}};
    for (size_t i = 0; i < 5; i++)
        fixture_place(scene, i, at[i], (double[3]){i < 3 ? 0 : speed, 0});
    double *y_all = state_of(scene);
    dl_model *model = model_of(scene);
    dl_escape result;
    const dl_escape_rule rule = {1.8, beyond};
    assert_true(isinf(dl_escape_link(scene)));
    assert_int_equal(dl_observe_escape(model, y_all, &rule, escaped, &result, NULL), DL_OK);
    const dl_escape_rule endless = {INFINITY, 0};
    assert_int_equal(dl_observe_escape(model, y_all, &endless, NULL, &result, NULL), DL_INPUT);
    assert_int_equal(dl_observe_escape(model, y_all, &rule, NULL, &result, NULL), DL_OK);
    dl_model_free(model);
    free(y_all);
    dl_scene_free(scene);
    return result;
}

static void escape_needs_energy_and_direction(void **state) {
    (void)state;
    /* mu = 6/5, potential = -(2/|(6, 0.5)| + 4 terms of |(4.5, 0.2 or 1.2)|) */
    const double potential = -2 / hypot(6, 0.5) - 2 / hypot(4.5, 0.2) - 2 / hypot(4.5, 1.2);
    const double threshold = sqrt(-2 * potential / 1.2);
    bool escaped[5];
    dl_escape e = escape_at(1.001 * threshold, 0, escaped);
    assert_int_equal(e.particles, 2);
    assert_int_equal(e.groups, 2);
    assert_int_equal(e.system, 3);
    assert_true(!escaped[0] && !escaped[1] && !escaped[2] && escaped[3] && escaped[4]);
    assert_int_equal(escape_at(0.999 * threshold, 0, escaped).particles, 0);
    assert_false(escaped[4]);
    assert_int_equal(escape_at(-2 * threshold, 0, escaped).particles, 0); /* inward */
    assert_int_equal(escape_at(2 * threshold, 4.9, escaped).particles, 2);
    assert_int_equal(escape_at(2 * threshold, 5.1, escaped).particles, 0);
}

/* A pinned particle beside a moving one, another pinned one alone: one moving particle, its group.
 */
static void escape_counts_what_moves(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("pins", 2, 3);
    for (size_t i = 0; i < 3; i++)
        fixture_place(scene, i, (double[3]){i == 2 ? 9 : (double)i, 0}, (double[3]){0});
    scene->pinned[1] = scene->pinned[2] = true;
    double *y_all = state_of(scene);
    dl_model *model = model_of(scene);
    dl_escape result;
    const dl_escape_rule rule = {1.8, 0};
    assert_int_equal(dl_observe_escape(model, y_all, &rule, NULL, &result, NULL), DL_OK);
    assert_int_equal(result.system, 1);
    assert_int_equal(result.groups, 1);
    assert_int_equal(result.particles, 0);
    dl_model_free(model);
    free(y_all);
    dl_scene_free(scene);
}

/* --- heights ---------------------------------------------------------------------------------- */

static void density_of_the_settled_fluid_is_table_1(void **state) {
    (void)state;
    static const double table1[] = {40, 40, 40, 40, 39, 40};
    dl_scene *scene = read_scene(SETTLED);
    double *y_all = state_of(scene), lowest, highest, particles[16], mass[16], total = 0;
    dl_bins bins;
    dl_observe_heights(scene, y_all, &lowest, &highest);
    assert_near(highest, 1.549, 1e-12);
    assert_int_equal(dl_bins_create(scene, 0.2, lowest, highest, &bins, NULL), DL_OK);
    assert_near(bins.low, 0, 0);
    assert_int_equal(bins.count, 8);
    dl_observe_density(scene, y_all, &bins, particles, mass);
    for (size_t k = 0; k < 6; k++)
        assert_near(particles[k], table1[k], 0);
    for (size_t k = 0; k < 8; k++) {
        total += particles[k];
        assert_near(mass[k], particles[k], 1e-12);
    }
    assert_near(total, 278, 0);
    assert_near(dl_across(scene), 10, 0);
    free(y_all);
    dl_scene_free(scene);
}

static void bins_begin_where_they_should(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("open", 2, 1);
    dl_bins bins;
    assert_int_equal(dl_bins_create(scene, 0.5, -1.2, 2, &bins, NULL), DL_OK);
    assert_near(bins.low, -1.5, 0);
    assert_int_equal(bins.count, 8); /* the last is [2, 2.5) */
    assert_true(isnan(dl_across(scene)));
    scene->walls.present = true;
    scene->walls.low[1] = 0.25;
    assert_int_equal(dl_bins_create(scene, 0.5, 3.3, 4, &bins, NULL), DL_OK);
    assert_near(bins.low, 0.25, 0);
    assert_int_equal(bins.count, 8);
    assert_int_equal(dl_bins_create(scene, 1e-7, 3.3, 4, &bins, NULL), DL_INPUT);
    assert_int_equal(dl_bins_create(scene, 0, 3.3, 4, &bins, NULL), DL_INPUT);
    assert_int_equal(dl_bins_create(scene, 0.5, 3.3, INFINITY, &bins, NULL), DL_INPUT);
    dl_scene_free(scene);
}

static void depth_of_a_uniform_column(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("column", 2, 100);
    for (size_t i = 0; i < 100; i++)
        fixture_place(scene, i, (double[3]){0, 2 + 0.01 * ((double)i + 0.5)}, (double[3]){0});
    double *y_all = state_of(scene);
    dl_depth depth;
    assert_int_equal(dl_observe_depth(scene, y_all, 2, &depth, NULL), DL_OK);
    assert_near(depth.uniform, 1, 1e-12);
    assert_near(depth.most, 0.945, 1e-12);
    assert_near(depth.highest, 0.995, 1e-12);
    free(y_all);
    dl_scene_free(scene);
}

/* --- pressure --------------------------------------------------------------------------------- */

enum { column = 6 };

/* Distance at which the pair (masses a and b) repels with `force`: 1/r^3 within 0.4. */
static double distance_of(double force, double a, double b) {
    return cbrt(a * b / force);
}

/* Two columns, mirror images, on pinned feet: each particle rests on the one below. Only neighbours
 * in a column are within reach. */
static dl_scene *stack(void) {
    dl_scene *scene = fixture_scene("stack", 2, 2 * column);
    scene->law.pieces = 1;
    scene->law.piece[0].until = 0.4;
    scene->law.piece[0].terms = 1;
    scene->law.piece[0].term[0] = (dl_term){.coefficient = 1, .power = 3};
    scene->gravity[1] = -20;
    double mass[column], above = 0, height[column] = {0.1};
    for (size_t i = 0; i < column; i++)
        above += mass[i] = 1 + 0.125 * (double)(i % 3);
    for (size_t i = 1; i < column; i++) {
        above -= mass[i - 1];
        height[i] = height[i - 1] + distance_of(20 * above, mass[i - 1], mass[i]);
        assert_true(height[i] - height[i - 1] < 0.4);
        assert_true(i < 2 || height[i] - height[i - 2] > 0.4);
    }
    for (size_t i = 0; i < 2 * column; i++) {
        fixture_place(scene, i, (double[3]){i < column ? 1 : 2, height[i % column]},
                      (double[3]){0});
        scene->inertia[i] = scene->coupling[i] = mass[i % column];
        scene->pinned[i] = i % column == 0;
        scene->feels_gravity[i] = true;
    }
    scene->walls.present = true;
    scene->walls.low[0] = 0;
    scene->walls.high[0] = 4;
    scene->walls.low[1] = 0;
    return scene;
}

static void pressure_of_a_column_is_the_weight_above(void **state) {
    (void)state;
    dl_scene *scene = stack();
    double *y_all = state_of(scene), a[4 * column];
    dl_model *model = model_of(scene);
    double y[8 * column];
    dl_model_initial_state(model, y);
    assert_int_equal(dl_model_acceleration(model, y, a, NULL), DL_OK);
    for (size_t k = 0; k < model->unknowns; k++)
        assert_near(a[k], 0, 1e-11); /* it is in equilibrium */
    dl_bins bins;
    assert_int_equal(dl_bins_create(scene, 0.03, 0, 1.9, &bins, NULL), DL_OK);
    double interaction[100], kinetic[100], weight[100];
    assert_true(bins.count <= 100);
    assert_int_equal(dl_observe_pressure(model, y_all, &bins, dl_across(scene), interaction,
                                         kinetic, weight, NULL),
                     DL_OK);
    size_t inside = 0;
    for (size_t k = 0; k < bins.count; k++) {
        const double level = bins.low + ((double)k + 0.5) * bins.width;
        double expected = 0;
        for (size_t i = 0; i < 2 * column; i++)
            expected += !scene->pinned[i] && scene->position[2 * column + i] >= level
                            ? 20 * scene->inertia[i] / 4
                            : 0;
        assert_near(weight[k], expected, 1e-12);
        if (level < 0.1) /* below the feet, which a pin holds up, not a force */
            assert_near(interaction[k], 0, 0);
        else
            assert_near(interaction[k], expected, 1e-11);
        assert_near(kinetic[k], 0, 0);
        inside += level > 0.1 && expected > 0;
    }
    assert_true(inside > 30);
    dl_model_free(model);
    free(y_all);
    dl_scene_free(scene);
}

static void moving_particles_carry_pressure(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("gas", 2, 2);
    fixture_place(scene, 0, (double[3]){0, 0.25}, (double[3]){9, 3});
    fixture_place(scene, 1, (double[3]){0, 1.75}, (double[3]){9, -2});
    scene->inertia[1] = 5;
    double *y_all = state_of(scene), interaction[4], kinetic[4], weight[4];
    dl_model *model = model_of(scene);
    const dl_bins bins = {0, 0.5, 4};
    assert_int_equal(
        dl_observe_pressure(model, y_all, &bins, 2, interaction, kinetic, weight, NULL), DL_OK);
    assert_near(kinetic[0], 9 / (2 * 0.5), 1e-14);
    assert_near(kinetic[3], 5 * 4 / (2 * 0.5), 1e-14);
    assert_near(kinetic[1] + kinetic[2] + weight[0] + interaction[0], 0, 0);
    dl_error error = {""};
    assert_int_equal(
        dl_observe_pressure(model, y_all, &bins, NAN, interaction, kinetic, weight, &error),
        DL_INPUT);
    dl_model_free(model);
    free(y_all);
    dl_scene_free(scene);
}

/* --- separation ------------------------------------------------------------------------------- */

static double separation_of(const dl_scene *scene, size_t nearest) {
    double *y_all = state_of(scene), mean;
    assert_int_equal(dl_observe_separation(scene, y_all, nearest, &mean, NULL), DL_OK);
    free(y_all);
    return mean;
}

static void separation_of_known_places(void **state) {
    (void)state;
    dl_scene *square = fixture_scene("square", 2, 4);
    for (size_t i = 0; i < 4; i++)
        fixture_place(square, i, (double[3]){2 * (double)(i % 2), 2 * (double)(i / 2)},
                      (double[3]){0});
    assert_near(separation_of(square, 1), 2, 1e-15);
    assert_near(separation_of(square, 3), (4 + sqrt(8)) / 3, 1e-14);
    assert_near(separation_of(square, 9), (4 + sqrt(8)) / 3, 1e-14);
    square->periods.present = true; /* the copies are 1 apart along x */
    square->periods.length[0] = 3;
    assert_near(separation_of(square, 1), 1, 1e-15);
    dl_scene_free(square);
    dl_scene *one = fixture_scene("one", 2, 1);
    assert_true(isnan(separation_of(one, 1)));
    dl_scene_free(one);
    dl_scene *settled = read_scene(SETTLED);
    assert_near(separation_of(settled, 3), 0.2556, 5e-5); /* TR323: 0.255 */
    dl_scene_free(settled);
}

/* The mean over all pairs' distances, sorted. */
static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double separation_by_all_pairs(const dl_scene *scene, size_t nearest) {
    const size_t n = scene->particles;
    double *distance = malloc(n * sizeof *distance), sum = 0;
    assert_non_null(distance);
    for (size_t i = 0; i < n; i++) {
        for (size_t j = 0; j < n; j++) {
            double square = 0;
            for (size_t c = 0; c < (size_t)scene->dimension; c++) {
                const double length = scene->periods.length[c];
                double d = scene->position[c * n + i] - scene->position[c * n + j];
                d -= length > 0 ? length * nearbyint(d / length) : 0;
                square += d * d;
            }
            distance[j] = j == i ? INFINITY : sqrt(square);
        }
        qsort(distance, n, sizeof *distance, ascending);
        for (size_t k = 0; k < nearest; k++)
            sum += distance[k] / (double)nearest / (double)n;
    }
    free(distance);
    return sum;
}

/* Clusters, columns of equal coordinates, copies: what is left out for being far along one axis is
 * never among the nearest. */
static void separation_is_that_of_all_pairs(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int periods = 0; periods <= dimension; periods++)
            for (size_t n = 7; n <= 301; n *= 43) {
                dl_scene *scene = fixture_scene("cloud", dimension, n);
                uint64_t word = 12345;
                for (size_t i = 0; i < n; i++) {
                    double at[3];
                    for (int c = 0; c < 3; c++) {
                        word = word * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
                        at[c] = (double)(word >> 40) / 0x1p24 * (i % 3 ? 1 : 10) - 3;
                    }
                    at[1] *= 3;
                    if (i % 4 == 0)
                        at[0] = at[1] = 0.5;
                    fixture_place(scene, i, at, (double[3]){0});
                }
                scene->periods.present = periods > 0;
                for (int c = 0; c < periods; c++)
                    scene->periods.length[c] = c == 1 ? 12 : 4;
                for (size_t nearest = 1; nearest <= 6; nearest += 5)
                    assert_near(separation_of(scene, nearest),
                                separation_by_all_pairs(scene, nearest), 1e-12);
                dl_scene_free(scene);
            }
}

/* --- averages --------------------------------------------------------------------------------- */

static void means_and_errors_over_frames(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("spread", 2, 2);
    fixture_place(scene, 0, (double[3]){1, 0}, (double[3]){0});
    fixture_place(scene, 1, (double[3]){-1, 0}, (double[3]){0});
    dl_observe_options how;
    dl_observe_options_default(&how);
    bool *wanted = calloc(dl_observable_count(), sizeof *wanted);
    assert_non_null(wanted);
    size_t index;
    assert_int_equal(dl_observable_find("energy", &index, NULL), DL_OK);
    wanted[index] = true;
    dl_observation *o = NULL;
    assert_int_equal(dl_observation_create(scene, &how, wanted, 40, 0, 0, &o, NULL), DL_OK);
    double y_all[8];
    /* Ten batches of 4 with kinetic energies b^2, b = 0 ... 9. */
    for (size_t k = 0; k < 40; k++) {
        spread(scene, (double)(k / 4), y_all);
        assert_int_equal(dl_observation_add(o, 0.1 * (double)k, y_all, NULL), DL_OK);
    }
    assert_int_equal(dl_observation_add(o, 9, y_all, NULL), DL_ERROR);
    double mean = 28.5, square = 0;
    for (int b = 0; b < 10; b++)
        square += (b * b - mean) * (b * b - mean);
    dl_observed seen;
    assert_int_equal(dl_observation_count(o), 1);
    dl_observation_get(o, 0, &seen);
    assert_null(seen.label);
    assert_near(seen.mean[0], mean / 2, 1e-13);
    assert_near(seen.mean[1], mean, 1e-13);
    assert_near(seen.error[1], sqrt(square / 90), 1e-12);
    dl_observation_free(o);
    wanted[index] = false;
    assert_int_equal(dl_observable_find("pressure", &index, NULL), DL_OK);
    wanted[index] = true;
    dl_error error = {""};
    assert_int_equal(dl_observation_create(scene, &how, wanted, 1, 0, 0, &o, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "pressure: found a scene that is open at its sides"));
    assert_null(o);
    assert_int_equal(dl_observable_find("presure", &index, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "did you mean \"pressure\""));
    free(wanted);
    dl_scene_free(scene);
}

/* --- the command ------------------------------------------------------------------------------ */

static int run_program(const char *arguments, char *out, size_t size) {
    char command[1000];
    snprintf(command, sizeof command, "cd %s && %s %s >.out 2>&1", folder, DL_PROGRAM, arguments);
    const int status = system(command);
    assert_true(WIFEXITED(status));
    snprintf(command, sizeof command, "%s/.out", folder);
    FILE *file = fopen(command, "r");
    assert_non_null(file);
    out[fread(out, 1, size - 1, file)] = '\0';
    fclose(file);
    return WEXITSTATUS(status);
}

static json_t *observe_json(const char *arguments) {
    static char out[100000];
    char line[500];
    snprintf(line, sizeof line, "observe %s --json", arguments);
    if (run_program(line, out, sizeof out))
        fail_msg("%s: %s", line, out);
    json_error_t where;
    json_t *root = json_loads(out, 0, &where);
    if (!root)
        fail_msg("%s: %s", line, where.text);
    return root;
}

static double mean_of(const json_t *root, const char *observable, size_t row, const char *column_) {
    const json_t *rows = json_object_get(json_object_get(root, "observables"), observable);
    const json_t *mean =
        json_object_get(json_object_get(json_array_get(rows, row), column_), "mean");
    if (!json_is_number(mean))
        fail_msg("%s[%zu].%s: no mean", observable, row, column_);
    return json_number_value(mean);
}

static void command_prints_table_1(void **state) {
    (void)state;
    static const double table1[] = {40, 40, 40, 40, 39, 40};
    json_t *root = observe_json(SETTLED " --bin 0.2");
    for (size_t k = 0; k < 6; k++)
        assert_near(mean_of(root, "density", k, "particles"), table1[k], 0);
    assert_near(mean_of(root, "energy", 0, "kinetic_per_particle"), 20.4671, 5e-5);
    json_decref(root);
    char out[20000];
    assert_int_equal(run_program("observe " SETTLED " --what density,energy", out, sizeof out), 0);
    assert_non_null(strstr(out, "kinetic_per_particle 20.4671\n"));
    assert_non_null(strstr(out, "  0.8 - 1              39 "));
    assert_null(strstr(out, "nan"));
}

/* Bins begin below the floor where a particle is below it: the depth is from the floor still. */
static void depth_is_above_the_floor(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("column", 2, 2);
    scene->walls.present = true;
    scene->walls.low[1] = 2;
    fixture_place(scene, 0, (double[3]){0, 1.9}, (double[3]){0});
    fixture_place(scene, 1, (double[3]){0, 4}, (double[3]){0});
    double *y_all = state_of(scene);
    dl_observe_options how;
    dl_observe_options_default(&how);
    how.bin = 1;
    bool *wanted = calloc(dl_observable_count(), sizeof *wanted);
    size_t index;
    assert_non_null(wanted);
    assert_int_equal(dl_observable_find("depth", &index, NULL), DL_OK);
    wanted[index] = true;
    dl_observation *observation;
    dl_error error = {""};
    assert_int_equal(dl_observation_create(scene, &how, wanted, 1, 1.9, 4, &observation, &error),
                     DL_OK);
    assert_int_equal(dl_observation_add(observation, 0, y_all, &error), DL_OK);
    dl_observed depth;
    dl_observation_get(observation, 0, &depth);
    assert_near(depth.mean[0], 1.9, 1e-12); /* twice the mean of -0.1 and 2 */
    assert_near(depth.mean[2], 2, 1e-12);
    dl_observation_free(observation);
    free(wanted);
    free(y_all);
    dl_scene_free(scene);
}

/* The trajectory alone tells its scene; frames, --from and --last. */
static void command_observes_a_trajectory(void **state) {
    (void)state;
    char out[20000];
    const char *run = "run " SETTLED " --method leapfrog --t-end 0.01 --sample 0.001 --out t.h5";
    assert_int_equal(run_program(run, out, sizeof out), 0);
    json_t *all = observe_json("t.h5 --bin 0.2"), *late = observe_json("t.h5 --from 0.0045");
    json_t *last = observe_json("t.h5 --last --what energy,motion");
    json_t *same = observe_json("t.h5 --from 0.0045 --scene " SETTLED);
    assert_int_equal(json_integer_value(json_object_get(all, "frames")), 11);
    assert_int_equal(json_integer_value(json_object_get(late, "frames")), 6);
    assert_int_equal(json_integer_value(json_object_get(last, "frames")), 1);
    assert_true(
        json_equal(json_object_get(late, "observables"), json_object_get(same, "observables")));
    double total = 0;
    const json_t *density = json_object_get(json_object_get(all, "observables"), "density");
    for (size_t k = 0; k < json_array_size(density); k++)
        total += mean_of(all, "density", k, "particles");
    assert_near(total, 278, 1e-9);
    assert_true(json_is_real(
        json_object_get(json_object_get(json_array_get(density, 0), "particles"), "error")));
    json_decref(all);
    json_decref(late);
    json_decref(last);
    json_decref(same);
}

/* --- chosen frames, series, the system alone ---------------------------------------------------
 * A cluster that turns and drifts, and the first particle of 7, which leaves it. */

static void write_comet(void) {
    char path[128];
    snprintf(path, sizeof path, "%s/comet.yaml", folder);
    FILE *const file = fopen(path, "w");
    assert_non_null(file);
    fputs("name: comet\ndimension: 2\nparticles:\n"
          "  - {at: [3.2, 0], velocity: [9, 0], mass: 2000}\n",
          file);
    for (int k = 0; k < 6; k++) { /* turns at 0.5 */
        const double angle = k * acos(-1) / 3, x = cos(angle), y = sin(angle);
        fprintf(file, "  - {at: [%.15g, %.15g], velocity: [%.15g, %.15g], mass: %d}\n", x, y,
                1 - 0.5 * y, 0.5 * x, k % 2 ? 2000 : 4000);
    }
    fputs("pair_law: [{until: 2, terms: [{coefficient: 1.0e-12, power: 2}]}]\n"
          "time: {step: 0.01, end: 0.5, sample: 0.05}\n",
          file);
    fclose(file);
}

static void command_chooses_frames(void **state) {
    (void)state;
    char out[20000];
    write_comet();
    assert_int_equal(run_program("run comet.yaml --method leapfrog --out c.h5", out, sizeof out),
                     0);
    json_t *by_time = observe_json("c.h5 --time 0.2 --what motion");
    json_t *by_step = observe_json("c.h5 --step 20 --what motion");
    json_t *range = observe_json("c.h5 --from 0.2 --to 0.35 --what motion");
    assert_true(json_equal(json_object_get(by_time, "observables"),
                           json_object_get(by_step, "observables")));
    assert_near(json_number_value(json_object_get(by_step, "from")), 0.2, 1e-12);
    assert_int_equal(json_integer_value(json_object_get(by_step, "frames")), 1);
    assert_int_equal(json_integer_value(json_object_get(range, "frames")), 4);
    const double v = mean_of(by_time, "motion", 0, "velocity_x");
    assert_near(mean_of(range, "motion", 0, "centre_x"),
                mean_of(by_time, "motion", 0, "centre_x") + 0.075 * v, 1e-9);
    json_decref(by_time);
    json_decref(by_step);
    json_decref(range);
}

static double of_entry(const json_t *entry, const char *observable, size_t row, const char *name) {
    const json_t *value =
        json_object_get(json_array_get(json_object_get(entry, observable), row), name);
    assert_true(json_is_number(value));
    return json_number_value(value);
}

/* Every entry is what the frame alone is; CSV has the same numbers. */
static void a_series_is_frame_by_frame(void **state) {
    (void)state;
    char out[20000], arguments[128], expected[80];
    write_comet();
    assert_int_equal(run_program("run comet.yaml --method leapfrog --out c.h5", out, sizeof out),
                     0);
    json_t *root = observe_json("c.h5 --from 0.1 --every 2 --what motion,escaped,states");
    const json_t *series = json_object_get(root, "series");
    assert_int_equal(json_array_size(series), 5);
    assert_int_equal(run_program("observe c.h5 --from 0.1 --every 2 --what motion,escaped,states",
                                 out, sizeof out),
                     0);
    char *line = strtok(out, "\n");
    assert_non_null(strstr(line, "time,step,motion.centre_x,"));
    assert_non_null(strstr(line, "states.gas[4000]"));
    assert_non_null(strstr(line, ",escaped.rows"));
    for (size_t k = 0; k < 5; k++) {
        const json_t *entry = json_array_get(series, k);
        const long step = (long)json_integer_value(json_object_get(entry, "step"));
        assert_int_equal(step, 10 + 10 * (long)k);
        snprintf(arguments, sizeof arguments, "c.h5 --step %ld --what motion,escaped,states", step);
        json_t *alone = observe_json(arguments);
        assert_true(of_entry(entry, "motion", 0, "centre_x") ==
                    mean_of(alone, "motion", 0, "centre_x"));
        assert_true(of_entry(entry, "states", 1, "solid") == mean_of(alone, "states", 1, "solid"));
        json_decref(alone);
        line = strtok(NULL, "\n");
        snprintf(expected, sizeof expected, "%.17g,%ld,%.17g,",
                 json_number_value(json_object_get(entry, "time")), step,
                 of_entry(entry, "motion", 0, "centre_x"));
        if (!line || strncmp(line, expected, strlen(expected)) != 0)
            fail_msg("line %zu: %s, expected %s...", k, line ? line : "nothing", expected);
        assert_string_equal(strrchr(line, ','), ",1"); /* the first has escaped */
    }
    assert_null(strtok(NULL, "\n"));
    json_decref(root);
}

/* A mean over steps that has few frames of them is another number: it is said, and printed. */
static void few_frames_make_no_temperature(void **state) {
    (void)state;
    static const struct {
        const char *arguments;
        bool warned;
    } cases[] = {
        {"c.h5 --last --what states --window 49", true}, /* frames are 5 steps apart */
        {"c.h5 --last --what states --window 50", false},
        {"c.h5 --last --what temperature --window 10", true},
        {"c.h5 --last --what motion --window 10", false},
        {"c.h5 --time 0 --what states --window 10", false}, /* it has no past */
        {"comet.yaml --what states --window 10", false},
    };
    char out[20000], line[160];
    write_comet();
    assert_int_equal(run_program("run comet.yaml --method leapfrog --out c.h5", out, sizeof out),
                     0);
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        snprintf(line, sizeof line, "observe %s", cases[k].arguments);
        assert_int_equal(run_program(line, out, sizeof out), 0);
        const bool warned = strstr(out, "warning: temperatures and states are means over");
        if (warned != cases[k].warned)
            fail_msg("%s: %s", line, out);
    }
    assert_non_null(strstr(out, "states"));
}

static void what_has_escaped_is_named(void **state) {
    (void)state;
    char out[4000];
    write_comet();
    json_t *root = observe_json("comet.yaml --what escaped");
    const json_t *rows = json_object_get(
        json_array_get(json_object_get(json_object_get(root, "observables"), "escaped"), 0),
        "rows");
    assert_int_equal(json_array_size(rows), 1);
    assert_int_equal(json_integer_value(json_array_get(rows, 0)), 1);
    json_decref(root);
    assert_int_equal(run_program("observe comet.yaml --what escaped", out, sizeof out), 0);
    assert_non_null(strstr(out, "  rows                 1\n"));
    assert_int_equal(run_program("observe comet.yaml --what escaped --beyond 4", out, sizeof out),
                     0);
    assert_non_null(strstr(out, "  rows                 none\n"));
}

/* The six that are left move with 1, turn at 0.5, and are cold; all seven do not. */
static void the_system_alone_is_what_is_left(void **state) {
    (void)state;
    char out[4000];
    write_comet();
    const char *const what = "comet.yaml --what energy,motion,temperature,states --over %s";
    char arguments[128];
    snprintf(arguments, sizeof arguments, what, "all");
    json_t *all = observe_json(arguments);
    snprintf(arguments, sizeof arguments, what, "system");
    json_t *left = observe_json(arguments);
    assert_string_equal(json_string_value(json_object_get(all, "over")), "all");
    assert_string_equal(json_string_value(json_object_get(left, "over")), "system");
    assert_near(mean_of(left, "motion", 0, "velocity_x"), 1, 1e-12);
    assert_near(mean_of(left, "motion", 0, "rigid_rotation"), 0.5, 1e-12);
    assert_near(mean_of(left, "temperature", 0, "instantaneous"), 0, 1e-9);
    assert_near(mean_of(left, "temperature", 1, "particles"), 3, 0);
    assert_near(mean_of(left, "states", 1, "solid"), 3, 0);
    assert_near(mean_of(all, "temperature", 1, "particles"), 4, 0);
    assert_true(mean_of(all, "motion", 0, "velocity_x") > 1.5);
    assert_true(mean_of(all, "temperature", 0, "instantaneous") > 0.01);
    assert_near(mean_of(all, "energy", 0, "kinetic") - mean_of(left, "energy", 0, "kinetic"),
                1000 * 81.0, 1e-6);
    json_decref(all);
    json_decref(left);
    assert_int_equal(run_program("observe comet.yaml --over system --what motion", out, sizeof out),
                     0);
    assert_non_null(strstr(out, "the system alone, the heaviest group: 6 of 7 particles"));
}

static void command_refuses(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *message;
    } bad[] = {
        {"observe " SETTLED " --what densty", "did you mean \"density\""},
        {"observe " SETTLED " --what states", "found a particle of mass 1, expected masses"},
        {"observe " SETTLED " --what escaped", "escaped: found walls"},
        {"observe " SETTLED " --from 1", "--from: found 1"},
        {"observe none.h5", "none.h5: "},
        {"observe " SETTLED " --scene " SETTLED, "--scene: found "},
        {"observe " SETTLED " --last --from 0", "--last, --from: found both"},
        {"observe " SETTLED " --what ''", "--what: found no name at the end"},
        {"observe " SETTLED " --what energy,", "--what: found no name at the end"},
        {"observe " SETTLED " --what ,energy", "--what: found no name before a comma"},
        {"observe " SETTLED " --temperature kelvin", "--temperature: "},
        {"observe " SETTLED " --to -1", "--to: found -1"},
        {"observe " SETTLED " --step 3", "--step: found the scene"},
        {"observe " SETTLED " --time 0 --every 2", "--time, --every: found both"},
        {"observe " SETTLED " --every 0", "--every: "},
        {"observe " SETTLED " --over system --what energy", "the system alone: found walls"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char out[4000];
        assert_int_equal(run_program(bad[i].arguments, out, sizeof out), 2);
        if (!strstr(out, bad[i].message))
            fail_msg("%s: %s", bad[i].arguments, out);
    }
}

static void trajectory_holds_its_scene(void **state) {
    (void)state;
    char out[4000], path[128];
    const char *run = "run " DL_STUDIES "/swirl/swirl.yaml --method leapfrog --t-end 0.001 --out "
                      "s.h5";
    assert_int_equal(run_program(run, out, sizeof out), 0);
    snprintf(path, sizeof path, "%s/s.h5", folder);
    dl_scene *scene = read_scene(DL_STUDIES "/swirl/swirl.yaml"), *held = NULL;
    dl_error error = {""};
    if (dl_scene_read_trajectory(path, &held, &error))
        fail_msg("%s", error.message);
    assert_int_equal(held->particles, scene->particles);
    assert_string_equal(held->text, scene->text);
    assert_memory_equal(held->position, scene->position, 478 * sizeof(double));
    assert_memory_equal(held->velocity, scene->velocity, 478 * sizeof(double));
    assert_memory_equal(held->inertia, scene->inertia, 239 * sizeof(double));
    assert_memory_equal(held->coupling, scene->coupling, 239 * sizeof(double));
    assert_memory_equal(&held->law, &scene->law, sizeof held->law);
    dl_scene_free(held);
    dl_scene_free(scene);
    snprintf(out, sizeof out, "%s/none.h5", folder);
    assert_int_equal(dl_scene_read_trajectory(out, &held, &error), DL_INPUT);
    assert_null(held);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rigid_motion_has_no_temperature),
        cmocka_unit_test(a_periodic_box_does_not_turn),
        cmocka_unit_test(temperature_of_a_known_mixture),
        cmocka_unit_test(temperatures_are_averages),
        cmocka_unit_test(states_by_table_4),
        cmocka_unit_test(escape_needs_energy_and_direction),
        cmocka_unit_test(density_of_the_settled_fluid_is_table_1),
        cmocka_unit_test(bins_begin_where_they_should),
        cmocka_unit_test(depth_of_a_uniform_column),
        cmocka_unit_test(pressure_of_a_column_is_the_weight_above),
        cmocka_unit_test(moving_particles_carry_pressure),
        cmocka_unit_test(separation_of_known_places),
        cmocka_unit_test(separation_is_that_of_all_pairs),
        cmocka_unit_test(means_and_errors_over_frames),
        cmocka_unit_test(command_prints_table_1),
        cmocka_unit_test(depth_is_above_the_floor),
        cmocka_unit_test(escape_counts_what_moves),
        cmocka_unit_test(command_observes_a_trajectory),
        cmocka_unit_test(command_chooses_frames),
        cmocka_unit_test(a_series_is_frame_by_frame),
        cmocka_unit_test(few_frames_make_no_temperature),
        cmocka_unit_test(what_has_escaped_is_named),
        cmocka_unit_test(the_system_alone_is_what_is_left),
        cmocka_unit_test(command_refuses),
        cmocka_unit_test(trajectory_holds_its_scene),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
