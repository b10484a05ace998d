/* Crossings of breakpoints that are located, against exact solutions, for every method. */
#include "contract.h"
#include "fixture_bounce.h"
#include "fixture_derivatives.h"
#include "fixture_periodic.h"
#include "fixture_runs.h"
#include "fixture_scenes.h"

#include "driftlab/explain.h"
#include "driftlab/model.h"
#include "force/vector_ops.h"
#include "model/locks.h"
#include "study/crossings.h"
#include "study/located.h"
#include "study/measure.h"
#include "study/path.h"

/* TR323's force, which jumps from 12400 to 0, and the same shifted. */
static const dl_pair_law hard = {
    1,
    {{.until = 0.25, .terms = 2, .term = {{-25, 2}, {50, 4}}}},
};

static dl_pair_law law_with(dl_piece_end end, bool located) {
    dl_pair_law law = hard;
    law.piece[0].end = end;
    law.piece[0].located = located;
    return law;
}

static dl_pair_law located_law(void) {
    return law_with(DL_END_HARD, true);
}

/* --- runs --------------------------------------------------------------------------------------
 */

static bool chooses_its_step(const dl_method_row *row) {
    return (row->flags & DL_ADAPTIVE) != 0;
}

/* With which every method follows a bounce closely. */
static const char *closely(const dl_method_row *row, char text[96], double end) {
    if (strcmp(row->name, "arkode-erk") == 0)
        snprintf(text, 96, "rtol=1e-13 atol=1e-14 table=fehlberg-8");
    else if (strcmp(row->name, "arkode-sprk") == 0)
        snprintf(text, 96, "step=%.17g table=suzuki-umeno-8", end / 1024);
    else if (!has_option(row, "atol") && chooses_its_step(row))
        snprintf(text, 96, "rtol=1e-9");
    else if (chooses_its_step(row))
        snprintf(text, 96, "rtol=%s atol=1e-14",
                 row->order == 2                      ? "1e-9"
                 : row->order == 4 || row->order == 5 ? "1e-12"
                                                      : "1e-13");
    else
        snprintf(text, 96, "step=%.17g", end / (row->order <= 3 ? 2048 : 1024));
    return text;
}

/* What is left of the position's error then. */
static double close_error(const dl_method_row *row) {
    static const double of_order[] = {2e-12, 0, 1e-5, 1e-6, 2e-8, 1e-10};
    if (strcmp(row->family, "CVODE") == 0 || strncmp(row->name, "gsl-ms", 6) == 0)
        return strcmp(row->name, "gsl-msbdf") == 0 ? 1e-7 : 1e-8; /* restarted at order 1 */
    if (chooses_its_step(row) && row->order > 2)
        return row->order == 4 || row->order == 5 ? 1e-10 : 2e-12;
    return row->order <= 5 ? of_order[row->order] : 2e-12;
}

static finished run_settings(const dl_scene *scene, const dl_method_row *row, const char *settings,
                             const dl_run_options *how) {
    finished run = {.length = 2 * (size_t)scene->dimension * scene->particles};
    dl_error error = {""};
    void *options = options_of(row, scene, "");
    set_options(row, options, settings);
    run.y = calloc(run.length, sizeof *run.y);
    assert_non_null(run.y);
    if (dl_run(scene, row, options, how, &run.summary, run.y, &error))
        fail_msg("%s on %s: %s", row->name, scene->name, error.message);
    dl_method_options_free(row, options);
    return run;
}

/* To the scene's end; a failure fails the test. */
static finished follow(const dl_scene *scene, const dl_method_row *row, const char *settings) {
    const dl_run_options how = run_options(0, scene->end);
    finished run = run_settings(scene, row, settings, &how);
    if (run.summary.status)
        fail_msg("%s %s on %s: %s", row->name, settings, scene->name, run.summary.message);
    return run;
}

static finished follow_closely(const dl_scene *scene, const dl_method_row *row) {
    char text[96];
    return follow(scene, row, closely(row, text, scene->end));
}

static void assert_near(const dl_method_row *row, const char *what, double found, double expected,
                        double near) {
    if (!(fabs(found - expected) <= near))
        fail_msg("%s: %s is %.17g, off by %g", row->name, what, found, found - expected);
}

/* --- one pair ----------------------------------------------------------------------------------
 */

static void every_method_is_exact_on_a_bounce(void **state) {
    (void)state;
    const double from = 0.61, speed = 26.3;
    const dl_pair_law law = located_law();
    const double expected = fixture_bounce_exact(&law, from, speed);
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *const scene = fixture_bounce(&law, from, speed);
        finished run = follow_closely(scene, row);
        print_message("%-28s %6lu forces, off by %.1e, energy by %.1e\n", row->name,
                      run.summary.force_evaluations, run.y[1] - expected,
                      run.summary.energy_error_max);
        assert_near(row, "the distance", run.y[1], expected, close_error(row));
        assert_int_equal(run.summary.crossings, 2);
        assert_true(run.summary.ledger == 0);
        free(run.y);
        dl_scene_free(scene);
    }
}

/* Root mean square over bounces that meet the cutoff at different parts of a step. */
static double bounce_error(const char *method, const dl_pair_law *law, int steps,
                           const char *more) {
    enum { phases = 16 };
    double sum = 0;
    char settings[96];
    snprintf(settings, sizeof settings, "step=%.17g%s", bounce_time / steps, more);
    for (int phase = 0; phase < phases; phase++) {
        const double from = 0.6 + 0.05 * fmod(0.618034 * phase, 1);
        const double speed = 25 + 3 * fmod(0.754878 * phase, 1);
        dl_scene *const scene = fixture_bounce(law, from, speed);
        finished run = follow(scene, method_of(method), settings);
        const double error = run.y[1] - fixture_bounce_exact(law, from, speed);
        sum += error * error;
        free(run.y);
        dl_scene_free(scene);
    }
    return sqrt(sum / phases);
}

static double bounce_order(const char *method, const char *more, const dl_pair_law *law,
                           int steps) {
    enum { points = 4 };
    double step[points], error[points];
    for (int i = 0; i < points; i++) {
        const int count = (int)lround(steps * pow(1.5, i));
        step[i] = bounce_time / count;
        error[i] = bounce_error(method, law, count, more);
    }
    const double order = fitted_order(step, error, points);
    print_message("%s%s, end %d, %s: errors %.1e ... %.1e, order %.2f\n", method, more,
                  (int)law->piece[0].end, law->piece[0].located ? "located" : "stepped over",
                  error[0], error[points - 1], order);
    return order;
}

static void order_is_the_methods_own(void **state) {
    (void)state;
    static const struct {
        const char *method, *more;
        int steps; /* in which the bounce is taken first */
        double order, stepped_over;
    } rows[] = {
        {"leapfrog", "", 200, 2, 1},
        {"composition-4-suzuki", "", 200, 4, 1},
        {"composition-6-kahan-li", "", 100, 6, 1},
        {"composition-8-kahan-li", "", 50, 8, 1},
        {"conserving-newton-dense", "", 200, 2, 2}, /* the mean force over a jump does its work */
        {"gsl-rk4", "", 200, 4, 1},
        {"arkode-erk", "", 200, 5, 1},
        {"arkode-erk", " table=fehlberg-8", 60, 8, 1},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (int run = 0; run < 3; run++) {
            const dl_pair_law law =
                law_with(run == 1 ? DL_END_SHIFTED_FORCE : DL_END_HARD, run < 2);
            const double order = bounce_order(rows[k].method, rows[k].more, &law, rows[k].steps);
            const double expected = run < 2 ? rows[k].order : rows[k].stepped_over;
            if (!(order > expected - 0.35 && order < expected + (run == 0 ? 1.2 : 0.8)))
                fail_msg("%s: order %g, expected %g", rows[k].method, order, expected);
        }
}

/* Adaptive methods no longer pay for the jump; and what looks like free flight to an error estimate
 * is none, although CVODE's first steps would be past the whole bounce. */
static void tight_tolerances_are_cheap(void **state) {
    (void)state;
    static const char *const rows[][2] = {{"gsl-rk8pd", ""},
                                          {"gsl-rkf45", ""},
                                          {"arkode-erk", " table=verner-6"},
                                          {"cvode-adams", ""}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        unsigned long forces[2];
        double x[2];
        for (int located = 0; located <= 1; located++) {
            const dl_pair_law law = law_with(DL_END_HARD, located);
            dl_scene *const scene = fixture_bounce(&law, 0.61, 26.3);
            char settings[96];
            snprintf(settings, sizeof settings, "rtol=1e-12 atol=1e-12%s", rows[k][1]);
            finished run = follow(scene, method_of(rows[k][0]), settings);
            forces[located] = run.summary.force_evaluations;
            x[located] = run.y[1];
            free(run.y);
            dl_scene_free(scene);
        }
        print_message("%s: %lu forces to x = %.3f, located %lu to %.3f\n", rows[k][0], forces[0],
                      x[0], forces[1], x[1]);
        assert_true(x[0] < -0.7 || forces[1] < forces[0] * 2 / 3);
        assert_true(x[1] > 1.1);
    }
}

/* Where nothing happens for long, steps become longer than any that pairs are watched for. */
static void steps_from_afar_are_seen(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    const double from = 5, speed = 26.3, end = 0.4;
    const double expected = fixture_bounce_exact(&law, from, speed) + speed * (end - bounce_time);
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *const scene = fixture_bounce(&law, from, speed);
        scene->end = end;
        scene->step = 1e-5;
        const dl_run_options how = run_options(0, end);
        finished run = chooses_its_step(row) ? follow_closely(scene, row)
                                             : run_settings(scene, row, "step=0.1", &how);
        /* a stage of so long a step may be deep within the core, and whither it is thrown is open
         */
        assert_true(run.summary.crossings > 0);
        if (chooses_its_step(row) || strcmp(row->name, "leapfrog") == 0)
            assert_int_equal(run.summary.crossings, 2);
        if (chooses_its_step(row))
            assert_near(row, "the distance", run.y[1], expected, 10 * close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
}

/* --- grazing -----------------------------------------------------------------------------------
 */

/* A flight past the pinned particle at that part of the cutoff. */
static dl_scene *graze(double part) {
    const dl_pair_law law = located_law();
    dl_scene *const scene = fixture_bounce(&law, 0, 0);
    fixture_place(scene, 1, (double[3]){0.613, part * 0.25}, (double[3]){-25, 0});
    return scene;
}

static void grazing_pairs_pass_or_turn_back(void **state) {
    (void)state;
    static const double beyond[] = {1 + 1e-12, 1 + 1e-6, 1.01};
    static const double within[] = {1 - 1e-9, 1 - 1e-6, 1 - 1e-3, 0.9};
    FOR_EACH_LOCATING_ROW(row) {
        for (size_t k = 0; k < sizeof beyond / sizeof *beyond; k++) {
            dl_scene *const scene = graze(beyond[k]);
            finished run = follow_closely(scene, row);
            assert_int_equal(run.summary.crossings, 0);
            assert_near(row, "x", run.y[1], 0.613 - 25 * bounce_time, close_error(row));
            assert_near(row, "y", run.y[3], beyond[k] * 0.25, 1e-12);
            free(run.y);
            dl_scene_free(scene);
        }
        for (size_t k = 0; k < sizeof within / sizeof *within; k++) {
            dl_scene *const scene = graze(within[k]);
            finished run = follow_closely(scene, row);
            finished reference = follow(scene, method_of("gsl-rk8pd"), "rtol=1e-13 atol=1e-14");
            assert_int_equal(run.summary.crossings, 2);
            assert_near(row, "x", run.y[1], reference.y[1], close_error(row));
            assert_near(row, "y", run.y[3], reference.y[3], 4 * close_error(row));
            assert_true(run.summary.angular_momentum_error_max < 1e-9 ||
                        isnan(run.summary.angular_momentum_error_max));
            free(reference.y);
            free(run.y);
            dl_scene_free(scene);
        }
    }
}

/* In and out again within one step, which sees nothing of it at its ends. */
static void dips_between_steps_are_crossings(void **state) {
    (void)state;
    static const char *const names[] = {"leapfrog", "composition-6-kahan-li", "gsl-rk4",
                                        "conserving-newton-dense"};
    const char *const settings[] = {"step=0.0125", "step=0.025"};
    for (size_t m = 0; m < sizeof names / sizeof *names; m++)
        for (size_t k = 0; k < 2; k++) {
            dl_scene *const scene = graze(1 - 1e-5);
            finished run = follow(scene, method_of(names[m]), settings[k]);
            finished reference = follow(scene, method_of("gsl-rk8pd"), "rtol=1e-13 atol=1e-14");
            assert_int_equal(run.summary.crossings, 2);
            assert_near(method_of(names[m]), "y", run.y[3], reference.y[3], 1e-6);
            free(reference.y);
            free(run.y);
            dl_scene_free(scene);
        }
}

/* --- several events ----------------------------------------------------------------------------
 */

/* Bounces far from one another, each on a pinned particle of its own; the i-th begins at from[i].
 */
static dl_scene *bounces(const dl_pair_law *law, size_t count, const double *from, double speed) {
    dl_scene *scene = fixture_scene("bounces", 2, 2 * count);
    scene->law = *law;
    scene->end = bounce_time;
    for (size_t i = 0; i < count; i++) {
        fixture_place(scene, 2 * i, (double[3]){0, 3 * (double)i}, (double[3]){0});
        fixture_place(scene, 2 * i + 1, (double[3]){from[i], 3 * (double)i}, (double[3]){-speed});
        scene->pinned[2 * i] = true;
    }
    return scene;
}

/* Far apart in a step, close together in it, and at the same time. */
static void pairs_cross_in_the_same_step(void **state) {
    (void)state;
    static const double from[] = {0.61, 0.63, 0.63 + 1e-9, 0.645, 0.645, 0.61 + 1e-13};
    enum { count = sizeof from / sizeof *from };
    const dl_pair_law law = located_law();
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *const scene = bounces(&law, count, from, 26.3);
        finished run = follow_closely(scene, row);
        assert_int_equal(run.summary.crossings, 2 * count);
        for (size_t i = 0; i < count; i++)
            assert_near(row, "a distance", run.y[2 * i + 1],
                        fixture_bounce_exact(&law, from[i], 26.3), 2 * close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
    /* a step that all of them come in, and one that all are in */
    static const char *const steps[] = {"step=0.005", "step=0.01"};
    for (size_t k = 0; k < 2; k++) {
        dl_scene *const scene = bounces(&law, count, from, 26.3);
        finished run = follow(scene, method_of("composition-8-kahan-li"), steps[k]);
        assert_int_equal(run.summary.crossings, 2 * count);
        for (size_t i = 0; i < count; i++)
            assert_near(method_of("composition-8-kahan-li"), "a distance", run.y[2 * i + 1],
                        fixture_bounce_exact(&law, from[i], 26.3), k ? 1e-2 : 1e-4);
        free(run.y);
        dl_scene_free(scene);
    }
}

/* Pairs that cross at one time cost no more steps than one of them. */
static void pairs_cross_at_the_same_time(void **state) {
    (void)state;
    static const double from[] = {0.61, 0.61, 0.61, 0.61};
    const dl_pair_law law = located_law();
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *const one = bounces(&law, 1, from, 26.3), *const all =
                                                                bounces(&law, 4, from, 26.3);
        finished alone = follow_closely(one, row), together = follow_closely(all, row);
        assert_int_equal(together.summary.crossings, 8);
        if (row->flags & DL_FIXED_STEP && !chooses_its_step(row)) {
            assert_int_equal(together.summary.steps, alone.summary.steps);
            assert_true(together.summary.rejected_steps <= alone.summary.rejected_steps + 4);
        }
        free(alone.y);
        free(together.y);
        dl_scene_free(one);
        dl_scene_free(all);
    }
}

/* One leaves the cutoff in a step so long that the path by which this is found is wrong by more
 * than the time to another's crossing, before or after it. */
static void the_first_of_close_crossings_is_the_first(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    const dl_method_row *const row = method_of("composition-8-kahan-li");
    const double speed = 26.3,
                 leaves = (0.61 - 0.25) / speed + 2 * fixture_time_inside(&law, speed);
    dl_scene *const one = bounces(&law, 1, (double[]){0.61}, speed);
    finished alone = follow(one, row, "step=0.005");
    dl_scene_free(one);
    double farthest = 0;
    for (int k = -20; k <= 20; k++) {
        const double from[] = {0.61, 0.25 + speed * (leaves + 2e-6 * k)};
        dl_scene *const two = bounces(&law, 2, from, speed);
        finished run = follow(two, row, "step=0.005");
        assert_int_equal(run.summary.crossings, 4);
        farthest = fmax(farthest, fabs(run.y[1] - alone.y[1]));
        free(run.y);
        dl_scene_free(two);
    }
    assert_near(row, "one that is alone", alone.y[1], fixture_bounce_exact(&law, 0.61, speed),
                1e-4);
    assert_true(farthest < 1e-5); /* another's crossing cuts its steps elsewhere */
    free(alone.y);
}

/* One bounces on the pinned particle and then on the wall at x = 1; others fly to a wall on the way
 * of that, at the time of its crossings among others. */
static void walls_are_hit_between_crossings(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    const double from = 0.61, speed = 26.3, inside = 2 * fixture_time_inside(&law, speed);
    const double enters = (from - 0.25) / speed, leaves = enters + inside;
    const double hit[] = {enters, leaves, enters + 1e-7, leaves - 1e-6, 0.3 * leaves};
    enum { others = sizeof hit / sizeof *hit, n = 2 + others };
    for (int mirror = 0; mirror <= 1; mirror++)
        FOR_EACH_LOCATING_ROW(row) {
            dl_scene *scene = fixture_scene("crossings-and-walls", 2, n);
            scene->law = law;
            scene->end = bounce_time;
            scene->pinned[0] = true;
            fixture_place(scene, 1, (double[3]){from}, (double[3]){-speed});
            for (size_t i = 0; i < others; i++)
                fixture_place(scene, 2 + i, (double[3]){1 - 10 * hit[i], 2 + (double)i},
                              (double[3]){10});
            scene->walls = (dl_walls){.present = true,
                                      .low = {-INFINITY, -INFINITY, -INFINITY},
                                      .high = {1, INFINITY, INFINITY},
                                      .rule = mirror ? DL_MIRROR : DL_LOCATED};
            finished run = follow_closely(scene, row);
            const double near = close_error(row);
            /* a mirror hit at a crossing's own time may find the pair a roundoff before it, again
             */
            assert_true(run.summary.crossings == 2 || (mirror && run.summary.crossings == 3));
            assert_int_equal(run.summary.wall_hits, 1 + others);
            assert_near(row, "the distance", run.y[1], 2 - fixture_bounce_exact(&law, from, speed),
                        near);
            for (size_t i = 0; i < others; i++)
                assert_near(row, "another's place", run.y[2 + i], 1 - 10 * (bounce_time - hit[i]),
                            near);
            free(run.y);
            dl_scene_free(scene);
        }
}

/* A bounce at x > 0, y = 1 from `from`, and a particle that hits the floor at that time. */
static dl_scene *bounce_and_hit(const dl_pair_law *law, double from, double speed, double hit) {
    dl_scene *const scene = bounces(law, 2, (double[]){0, 0}, 0);
    fixture_place(scene, 0, (double[3]){0, 1}, (double[3]){0});
    fixture_place(scene, 1, (double[3]){from, 1}, (double[3]){-speed});
    fixture_place(scene, 2, (double[3]){9, 9}, (double[3]){0});
    fixture_place(scene, 3, (double[3]){0, 0.25 + 10 * hit}, (double[3]){0, -10});
    scene->walls = (dl_walls){.present = true,
                              .low = {-INFINITY, 0.25, -INFINITY},
                              .high = {INFINITY, INFINITY, INFINITY},
                              .rule = DL_LOCATED};
    return scene;
}

/* A hit between the time at which a crossing seems to be and that at which it is, and the other
 * way round. */
static void the_first_of_close_events_is_the_first(void **state) {
    (void)state;
    static const double from[] = {0.61, 0.63, 0.65, 0.67, 0.69, 0.71};
    const dl_pair_law law = located_law();
    const dl_method_row *const row = method_of("composition-8-kahan-li");
    const double speed = 26.3, inside = 2 * fixture_time_inside(&law, speed);
    for (size_t phase = 0; phase < sizeof from / sizeof *from; phase++)
        for (int k = -20; k <= 20; k++) {
            const double hit = (from[phase] - 0.25) / speed + inside + 2e-6 * k;
            dl_scene *const scene = bounce_and_hit(&law, from[phase], speed, hit);
            finished run = follow(scene, row, "step=0.005");
            assert_int_equal(run.summary.crossings, 2);
            assert_int_equal(run.summary.wall_hits, 1);
            assert_near(row, "what hit the wall", run.y[7], 0.25 + 10 * (bounce_time - hit), 1e-12);
            assert_near(row, "the distance", run.y[1],
                        fixture_bounce_exact(&law, from[phase], speed), 2e-4);
            free(run.y);
            dl_scene_free(scene);
        }
}

/* A mirror's image may be on another side of a breakpoint, without a crossing. */
static void images_are_where_they_are(void **state) {
    (void)state;
    FOR_EACH_LOCATING_ROW(row)
    if (!chooses_its_step(row)) {
        dl_pair_law law = located_law();
        law.piece[0].term[0].coefficient = law.piece[0].term[1].coefficient = 1e-12;
        dl_scene *scene = fixture_bounce(&law, 0.2, -1);
        scene->position[3] = 0.1; /* out at x = 0.229, at x = 0.4 where the step ends */
        scene->walls = (dl_walls){.present = true,
                                  .low = {-INFINITY, -INFINITY, -INFINITY},
                                  .high = {0.3, INFINITY, INFINITY},
                                  .rule = DL_MIRROR};
        scene->end = 0.4;
        finished run = follow(scene, row, "step=0.2");
        assert_int_equal(run.summary.wall_hits, 1);
        assert_int_equal(run.summary.crossings, 1);
        assert_near(row, "x", run.y[1], 0, 1e-8);
        free(run.y);
        dl_scene_free(scene);
    }
}

/* --- other scenes ------------------------------------------------------------------------------
 */

/* Aslant through three dimensions, both moving, of unlike inertias and couplings: the relative
 * motion is that of a bounce with the law times coupling/reduced mass. */
static void pairs_move_in_three_dimensions(void **state) {
    (void)state;
    const double from = 0.61, speed = 26.3, inertia[2] = {3, 1.5}, coupling[2] = {2, 0.75};
    const double way[3] = {2.0 / 7, -3.0 / 7, 6.0 / 7}, drift[3] = {5, 3, -2};
    const double reduced = inertia[0] * inertia[1] / (inertia[0] + inertia[1]);
    const dl_pair_law law = located_law();
    dl_pair_law scaled = law;
    for (int t = 0; t < 2; t++)
        scaled.piece[0].term[t].coefficient *= coupling[0] * coupling[1] / reduced;
    const double expected = fixture_bounce_exact(&scaled, from, speed);
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *scene = fixture_scene("aslant", 3, 2);
        scene->law = law;
        scene->end = bounce_time;
        for (size_t i = 0; i < 2; i++) {
            double at[3], velocity[3];
            const double share = (i ? 1 : -1) * reduced / inertia[i];
            for (int c = 0; c < 3; c++) {
                at[c] = 0.3 + share * from * way[c];
                velocity[c] = drift[c] - share * speed * way[c];
            }
            scene->inertia[i] = inertia[i];
            scene->coupling[i] = coupling[i];
            fixture_place(scene, i, at, velocity);
        }
        finished run = follow_closely(scene, row);
        double along = 0;
        for (size_t c = 0; c < 3; c++)
            along += (run.y[2 * c + 1] - run.y[2 * c]) * way[c];
        assert_int_equal(run.summary.crossings, 2);
        assert_near(row, "the distance", along, expected, 4 * close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
}

/* A pin and two kinds of movers, with laws that differ; the movers do not act on one another. */
static void species_have_breakpoints_of_their_own(void **state) {
    (void)state;
    static const char text[] =
        "name: kinds\n"
        "dimension: 2\n"
        "particles:\n"
        "  - {at: [0, 0], pinned: true, species: post}\n"
        "  - {at: [0.61, 0], velocity: [-26.3, 0], species: one}\n"
        "  - {at: [0, 0.63], velocity: [0, -26.3], species: two}\n"
        "pair_laws:\n"
        "  - {between: [post, one], pieces: [{until: 0.25, located: true, terms: [{coefficient: "
        "-25, power: 2}, {coefficient: 50, power: 4}]}]}\n"
        "  - {between: [post, two], pieces: [{until: 0.375, located: true, terms: [{coefficient: "
        "60, power: 1.5}]}]}\n"
        "  - {between: [one, two], pieces: none}\n"
        "  - {between: [post, post], pieces: none}\n"
        "  - {between: [one, one], pieces: none}\n"
        "  - {between: [two, two], pieces: none}\n"
        "time: {step: 0.001, end: 0.05}\n";
    const dl_pair_law one = located_law();
    const dl_pair_law two = {1, {{.until = 0.375, .terms = 1, .term = {{60, 1.5}}}}};
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *const scene = scene_of_text(text);
        finished run = follow_closely(scene, row);
        assert_int_equal(run.summary.crossings, 4);
        assert_near(row, "one", run.y[1], fixture_bounce_exact(&one, 0.61, 26.3), close_error(row));
        assert_near(row, "two", run.y[5], fixture_bounce_exact(&two, 0.63, 26.3), close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
}

/* The nearest copy of the pinned one is across the boundary. */
static void copies_cross(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *scene = fixture_bounce(&law, 0.61, 26.3);
        scene->periods.present = true;
        scene->periods.length[0] = 3;
        scene->position[1] = 0.61 - 3;
        finished run = follow_closely(scene, row);
        assert_int_equal(run.summary.crossings, 2);
        assert_near(row, "the distance", run.y[1] + 3, fixture_bounce_exact(&law, 0.61, 26.3),
                    close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
}

/* A period of twice the cutoff: who leaves one copy of the pinned particle enters the next at the
 * same moment. After the time from turn to turn the particle is where it was, seen from the other
 * copy. */
static void a_cutoff_of_half_a_period(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    const double speed = 26.3, half = 2 * fixture_time_inside(&law, speed);
    dl_law prepared;
    dl_law_prepare(&law, &prepared);
    const double turn = fixture_turning_point(&prepared, speed * speed / 2, 0.25);
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *scene = fixture_bounce(&law, turn, 0);
        scene->periods.present = true;
        scene->periods.length[0] = 0.5;
        scene->step = half / 16;
        scene->end = 3 * half;
        finished run = follow_closely(scene, row);
        assert_int_equal(run.summary.crossings, 6);
        assert_near(row, "the place", run.y[1], 0.5 - turn, 10 * close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
}

/* Three breakpoints, one behind the other, that a step of the whole way out is past; each of the
 * two inner ones crossed twice by who turns between them. */
static void a_step_may_pass_several_breakpoints(void **state) {
    (void)state;
    const dl_pair_law law = {3,
                             {{.until = 0.5, .terms = 1, .term = {{3, 2}}, .located = true},
                              {.until = 0.7, .terms = 1, .term = {{-1, 1}}, .located = true},
                              {.until = 1, .terms = 1, .term = {{0.5, 3}}, .located = true}}};
    dl_law prepared;
    dl_law_prepare(&law, &prepared);
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *scene = fixture_scene("steps", 2, 2);
        scene->law = law;
        scene->end = 1;
        scene->pinned[0] = true;
        fixture_place(scene, 1, (double[3]){1.25}, (double[3]){-3});
        finished run = follow_closely(scene, row);
        assert_int_equal(run.summary.crossings, 6);
        assert_near(row, "the speed", run.y[5], 3, 10 * close_error(row));
        free(run.y);
        dl_scene_free(scene);
    }
    /* out from within the first, in a few steps */
    static const char *const names[] = {"leapfrog", "composition-8-kahan-li", "gsl-rk8pd",
                                        "conserving-newton-klu"};
    const double energy = 0.125 + dl_law_potential(&prepared, 0.45 * 0.45);
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        dl_scene *scene = fixture_bounce(&law, 0.45, -0.5);
        scene->end = 1;
        finished coarse = follow(scene, method_of(names[k]), "step=0.25");
        assert_int_equal(coarse.summary.crossings, 3);
        assert_near(method_of(names[k]), "the energy", coarse.y[5] * coarse.y[5] / 2, energy,
                    0.1 * energy);
        free(coarse.y);
        dl_scene_free(scene);
    }
}

/* Begun on the breakpoint: inwards, outwards, at rest. */
static void a_pair_may_begin_on_its_breakpoint(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    const double speed = 26.3, inside = 2 * fixture_time_inside(&law, speed);
    const double expected[] = {0.25 + speed * (bounce_time - inside), 0.25 + speed * bounce_time,
                               0.25};
    const double velocity[] = {-speed, speed, 0};
    FOR_EACH_LOCATING_ROW(row)
    for (size_t k = 0; k < 3; k++)
        for (int above = -1; above <= 1; above++) {
            dl_scene *scene = fixture_bounce(&law, 0.25 + above * 0x1p-54, -velocity[k]);
            finished run = follow_closely(scene, row);
            if (k < 2)
                assert_near(row, "the distance", run.y[1], expected[k], close_error(row));
            else /* the least push out, or none */
                assert_true(run.y[1] >= 0.25 - 1e-12 && run.y[1] < 0.25 + 1e-6);
            assert_true(run.summary.energy_error_max < 1e-4);
            free(run.y);
            dl_scene_free(scene);
        }
}

/* Pushed out within the breakpoint and in beyond it, a pair at rest on it cannot leave, and crosses
 * for ever: a failure that says so. One that is not at rest oscillates. */
static void a_pair_on_an_edge_is_a_failure(void **state) {
    (void)state;
    const dl_pair_law law = {2,
                             {{.until = 1, .terms = 1, .term = {{2, 2}}, .located = true},
                              {.until = 3, .terms = 1, .term = {{-1, 1}}}}};
    dl_scene *scene = fixture_bounce(&law, 1, 0);
    scene->step = 0.01;
    const dl_run_options how = run_options(0, 0);
    finished run = run_settings(scene, method_of("composition-4-suzuki"), "", &how);
    assert_int_equal(run.summary.status, DL_STEP_FAILURE);
    assert_non_null(strstr(run.summary.message, "0 and 1 are stuck on the breakpoint 1 "));
    free(run.y);
    fixture_place(scene, 1, (double[3]){1}, (double[3]){1e-3});
    finished swings = follow(scene, method_of("gsl-rk8pd"), "rtol=1e-12 atol=1e-14");
    assert_true(swings.summary.crossings > 10);
    assert_true(fabs(swings.y[1] - 1) < 1e-6 && swings.summary.energy_error_max < 1e-14);
    free(swings.y);
    dl_scene_free(scene);
}

/* Radiation while one pair is within the cutoff, at the moment at which another enters it. */
static void radiation_finds_pairs_where_they_are(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    const double speed = 32, enters = 1.0 / 64;
    const double from[2] = {0.25 + speed * enters, 0.25 + speed * (enters - 1e-3)};
    FOR_EACH_LOCATING_ROW(row) {
        dl_scene *scene = bounces(&law, 2, from, speed);
        scene->step = 1.0 / 1024;
        scene->end = 3 * enters;
        scene->radiation = (dl_radiation){.present = true,
                                          .period = enters,
                                          .beyond = 1,
                                          .factor_above = 0.5,
                                          .factor_below = 0.75,
                                          .frame = DL_FRAME_LAB};
        finished reference = follow(scene, method_of("gsl-rk8pd"), "rtol=1e-13 atol=1e-14");
        char settings[96];
        const char *const text = chooses_its_step(row) ? closely(row, settings, scene->end)
                                 : row->order == 2     ? "step=1.52587890625e-05"
                                                       : "step=3.0517578125e-05";
        finished run = follow(scene, row, text);
        assert_int_equal(run.summary.crossings, 4);
        assert_near(row, "one place", run.y[1], reference.y[1], 10 * close_error(row));
        assert_near(row, "the other", run.y[3], reference.y[3], 10 * close_error(row));
        assert_true(run.summary.ledger > 100);
        assert_true(run.summary.energy_error_max < 1e-6 * run.summary.energy_scale);
        free(run.y);
        free(reference.y);
        dl_scene_free(scene);
    }
}

/* --- fluids ------------------------------------------------------------------------------------
 */

/* TR323's fluid in the small, pressed together, between located walls. */
static void methods_agree_on_a_fluid(void **state) {
    (void)state;
    dl_scene *const scene = fixture_box();
    scene->law.piece[0].located = true;
    scene->walls.rule = DL_LOCATED;
    scene->walls.rest = 1e-9;
    scene->end = 0.006;
    for (size_t i = 0; i < 48; i++)
        scene->position[i] *= 0.8;
    finished reference = follow(scene, method_of("gsl-rk8pd"), "rtol=1e-13 atol=1e-14");
    assert_true(reference.summary.crossings > 50 && reference.summary.wall_hits > 20);
    FOR_EACH_LOCATING_ROW(row) {
        finished run = follow_closely(scene, row);
        const double off = largest_difference(run.y, reference.y, 48);
        const double energy = run.summary.energy_error_max / run.summary.energy_scale;
        print_message("%-28s off by %.1e, energy by %.1e\n", row->name, off, energy);
        assert_int_equal(run.summary.crossings, reference.summary.crossings);
        if (!(off <= 10 * close_error(row)))
            fail_msg("%s: positions are off by %g", row->name, off);
        assert_true(energy < (row->flags & DL_CONSERVES_ENERGY ? 1e-14 : close_error(row)));
        free(run.y);
    }
    free(reference.y);
    dl_scene_free(scene);
}

static void observation_changes_nothing(void **state) {
    (void)state;
    dl_scene *const scene = fixture_box();
    scene->law.piece[0].located = true;
    scene->end = 0.01;
    static const char *const names[] = {"leapfrog", "composition-4-suzuki",
                                        "conserving-fixed-point", "gsl-rk8pd", "cvode-adams"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        dl_run_options plain = run_options(0, scene->end), seen = run_options(0, scene->end);
        plain.observe = false;
        finished without = run_settings(scene, method_of(names[k]), "", &plain);
        finished with = run_settings(scene, method_of(names[k]), "", &seen);
        assert_int_equal(with.summary.status, DL_OK);
        assert_memory_equal(without.y, with.y, with.length * sizeof *with.y);
        assert_int_equal(without.summary.force_evaluations, with.summary.force_evaluations);
        assert_int_equal(without.summary.crossings, with.summary.crossings);
        free(without.y);
        free(with.y);
    }
    dl_scene_free(scene);
}

/* A study refuses what has taken other steps than its own; crossings cut some in two. */
static void cut_steps_make_up_the_time(void **state) {
    (void)state;
    const dl_pair_law law = located_law();
    dl_scene *const scene = fixture_bounce(&law, 0.61, 26.3);
    finished run = follow(scene, method_of("composition-4-suzuki"), "step=0.001");
    assert_int_equal(run.summary.steps, 52);
    dl_case judged = {.summary = run.summary};
    char reason[200];
    dl_study_judge_run(&judged, scene->end, 1, reason, sizeof reason);
    assert_string_equal(reason, "");
    judged.summary.crossings = 0;
    dl_study_judge_run(&judged, scene->end, 1, reason, sizeof reason);
    assert_non_null(strstr(reason, "52 steps of 0.001 do not make up"));
    judged.summary.crossings = 2;
    judged.summary.steps = 49;
    dl_study_judge_run(&judged, scene->end, 1, reason, sizeof reason);
    assert_non_null(strstr(reason, "49 steps of 0.001 do not make up"));
    free(run.y);
    dl_scene_free(scene);
}

/* --- locked pairs ------------------------------------------------------------------------------
 */

/* Pieces of either side go on beyond the breakpoint, those between stay what they are. */
static void ranges_go_on_beyond_their_ends(void **state) {
    (void)state;
    const dl_pair_law law = {3,
                             {{.until = 0.5, .terms = 1, .term = {{3, 2}}, .located = true},
                              {.until = 0.7, .terms = 1, .term = {{-1, 1}}},
                              {.until = 1, .terms = 1, .term = {{0.5, 3}}, .located = true}}};
    dl_law prepared;
    dl_law_prepare(&law, &prepared);
    dl_lock lock = {.i = 0};
    dl_lock_to(&lock, &prepared, 2);
    assert_true(lock.range.first == 1 && lock.range.last == 2);
    for (int k = 0; k < 109; k++) {
        const double r = 0.3 + 0.0101 * k, s = r * r, s1 = s * 1.3;
        const double force = r <= 0.7 ? -1 / r : 0.5 / (r * r * r);
        assert_true(fabs(dl_law_force_over_r_within(&prepared, lock.range, s) * r - force) < 1e-14);
        const double next = 1.0001 * r, last = r / 1.0001;
        if ((last <= 0.7) == (next <= 0.7)) {
            const double slope_of_it =
                (dl_law_force_over_r_within(&prepared, lock.range, next * next) -
                 dl_law_force_over_r_within(&prepared, lock.range, last * last)) /
                (next - last) / r;
            const double slope_there = dl_law_force_slope_within(&prepared, lock.range, s);
            assert_true(fabs(slope_of_it - slope_there) < 1e-6 * fabs(slope_there));
        }
        /* the work of those forces: log r up to 0.7, 1/(4 r^2) from there */
        const double r1 = sqrt(s1), middle = fmin(fmax(0.7, r), r1);
        const double work = -log(fmax(r, fmin(r1, 0.7)) / r) +
                            (middle < r1 ? 0.25 / (middle * middle) - 0.25 / s1 : 0);
        const double g = dl_law_discrete_within(&prepared, lock.range, s, s1, s1 - s, NULL);
        assert_true(fabs(g * (s1 - s) - work) < 1e-13);
    }
    dl_lock_to(&lock, &prepared, 0);
    assert_true(lock.range.first == 0 && lock.range.last == 0);
    dl_lock_to(&lock, &prepared, 3);
    assert_true(lock.range.first == 3 && lock.range.last == 3);
    assert_true(dl_law_force_over_r_within(&prepared, lock.range, 0.01) == 0);
}

/* On a breakpoint, where kernels differ by how they round a distance. */
static void check_edge(dl_model *model, unsigned trial) {
    const size_t n = model->moving, dimension = (size_t)model->dimension;
    double q[15], a[15], way[3] = {0}, length = 0;
    for (size_t u = 0; u < model->unknowns; u++)
        q[u] = 100 + 10 * (double)(u % n); /* out of reach of one another */
    for (size_t c = 0; c < dimension; c++) {
        way[c] = fixture_noise(3 * trial + (unsigned)c);
        length += way[c] * way[c];
    }
    for (size_t c = 0; c < dimension; c++) {
        q[c * n + 1] = fixture_noise(1000 + 2 * trial + (unsigned)c);
        q[c * n + 3] = q[c * n + 1] + 0.25 * way[c] / sqrt(length) * (1 + 0x1p-52 * (trial % 5));
        if (model->has_periods && c < 2)
            q[c * n + 3] += 2 * (double)(trial % 3);
        q[c * n] = 0.5 + q[c * n + 1];
        q[c * n + 2] = 1 + q[c * n + 1];
        q[c * n + 4] = -0.5 + q[c * n + 1];
    }
    for (int piece = 0; piece <= 1; piece++) {
        dl_lock lock = {.i = 1, .j = 3};
        dl_law prepared;
        dl_law_prepare(&model->scene->law, &prepared);
        dl_lock_to(&lock, &prepared, piece);
        for (size_t c = 0; c < dimension; c++) {
            double d[3] = {0};
            d[c] = q[c * n + 1] - q[c * n + 3];
            double copy[3];
            dl_nearest_copy(model, d, copy);
            lock.copy[c] = copy[c];
        }
        const dl_locks locks = {&lock, 1, 1};
        model->locks = &locks;
        assert_int_equal(dl_model_acceleration(model, q, a, NULL), DL_OK);
        model->locks = NULL;
        double pushed = 0;
        for (size_t c = 0; c < dimension; c++)
            pushed += a[c * n + 3] * a[c * n + 3];
        const double coupling = model->scene->coupling[1] * model->scene->coupling[3];
        const double expected = piece ? 0 : 12400 * coupling;
        if (!(fabs(sqrt(pushed) - expected) < 1e-8))
            fail_msg("trial %u: pushed by %g, expected %g", trial, sqrt(pushed), expected);
    }
}

static void locks_hold_whatever_kernels_round(void **state) {
    (void)state;
    static const char *const sets[] = {"plain", "avx2", "avx512"};
    static const dl_kernel_choice kernels[] = {DL_KERNEL_REFERENCE, DL_KERNEL_ALL_PAIRS,
                                               DL_KERNEL_NEIGHBOUR_LIST};
    for (int set = 0; set < 3; set++)
        for (size_t k = 0; k < 3 && dl_vector_force(sets[set]); k++)
            for (unsigned form = 0; form < 8; form++) {
                dl_scene *scene = fixture_scene("edge", form & 1 ? 3 : 2, 5);
                scene->law = located_law();
                scene->kernel = kernels[k];
                if (form & 2)
                    fixture_periods(scene, 3, 2);
                for (size_t i = 0; i < 5 && form & 4; i++)
                    scene->coupling[i] = 1 + 0.25 * (double)i;
                dl_model *model = NULL;
                assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
                for (unsigned trial = 0; trial < 200; trial++)
                    check_edge(model, trial);
                dl_model_free(model);
                dl_scene_free(scene);
            }
    dl_vector_force(NULL);
}

enum { most_locks = 60 };

/* Pairs within 0.1 of the cutoff, each locked to the other side of it. */
static size_t lock_across(const dl_model *model, const dl_law *law, const double *q,
                          dl_lock *lock) {
    size_t count = 0;
    for (size_t i = 0; i < model->moving; i++)
        for (size_t j = i + 1; j < model->moving; j++) {
            const double r = hypot(q[i] - q[j], q[24 + i] - q[24 + j]);
            if (fabs(r - 0.25) > 0.1 || count == most_locks)
                continue;
            lock[count] = (dl_lock){.i = i, .j = j};
            dl_lock_to(&lock[count++], law, r < 0.25);
        }
    return count;
}

/* Pairs that are locked within the cutoff but lie beyond it are in no list of the kernel's. */
static void jacobians_know_of_locks(void **state) {
    (void)state;
    static const dl_kernel_choice kernels[] = {DL_KERNEL_ALL_PAIRS, DL_KERNEL_NEIGHBOUR_LIST};
    for (size_t k = 0; k < 2; k++)
        for (int heavy = 0; heavy <= 1; heavy++) {
            dl_scene *scene = fixture_box();
            scene->law = located_law();
            scene->kernel = kernels[k];
            scene->skin = 1e-3;
            for (size_t i = 0; i < box_unknowns; i++)
                scene->position[i] *= 0.9;
            for (size_t i = 0; i < 24; i++)
                scene->inertia[i] = heavy ? 1 + 0.1 * (double)i : 1;
            dl_model *model = NULL;
            assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
            double y[2 * box_unknowns], delta[box_unknowns], a[box_unknowns], b[box_unknowns];
            dl_model_initial_state(model, y);
            for (unsigned i = 0; i < box_unknowns; i++)
                delta[i] = 0.01 * fixture_noise(i + 100);
            dl_law law;
            dl_lock lock[most_locks];
            dl_law_prepare(&scene->law, &law);
            const dl_locks locks = {lock, lock_across(model, &law, y, lock), 1};
            assert_true(locks.count > 10);
            const dl_sparsity *pattern;
            assert_int_equal(dl_model_sparsity(model, y, NULL, &pattern, NULL), DL_OK);
            const size_t without = pattern->nonzeros;
            fixture_accelerate(model, y, NULL, y, 0, a);
            model->locks = &locks;
            assert_int_equal(dl_model_sparsity(model, y, NULL, &pattern, NULL), DL_OK);
            assert_true(k == 0 ? pattern->nonzeros == without : pattern->nonzeros > without);
            fixture_accelerate(model, y, NULL, y, 0, b);
            assert_true(largest_difference(a, b, box_unknowns) > 1e3);
            fixture_check_jacobian(model, y, NULL);
            fixture_check_jacobian(model, y, delta);
            /* the discrete acceleration of a short step is the acceleration */
            for (unsigned i = 0; i < box_unknowns; i++)
                delta[i] = 1e-9 * fixture_noise(i + 100);
            fixture_accelerate(model, y, delta, y, 0, a);
            assert_true(largest_difference(a, b, box_unknowns) < 1e-3);
            model->locks = NULL;
            dl_model_free(model);
            dl_scene_free(scene);
        }
}

static void squares_of_paths_are_paths(void **state) {
    (void)state;
    /* (t - 1)^5 + 2 t^2 and exp(-t) over [0, 0.5] */
    dl_path sum = {.degree = 0, .b = {-0.25}}, first, second;
    dl_path_hermite(&first, 0.5, (dl_path_end){-1, 5, -16},
                    (dl_path_end){-1.0 / 32 + 0.5, 5.0 / 16 + 2, -20.0 / 8 + 4});
    dl_path_add_square(&sum, &first);
    for (int k = 0; k <= 16; k++) {
        const double t = k / 32.0, d = pow(t - 1, 5) + 2 * t * t;
        assert_true(fabs(dl_path_value(&sum, 2 * t) - (d * d - 0.25)) < 1e-14);
    }
    double derivative[13];
    for (int k = 0; k <= 12; k++)
        derivative[k] = (k % 2 ? -1 : 1) * exp(-0.5);
    dl_path_taylor(&second, 0.5, 12, derivative, (dl_path_end){1, -1, NAN});
    sum = (dl_path){.degree = 0, .b = {0}};
    dl_path_add_square(&sum, &second);
    dl_path_add_square(&sum, &second);
    dl_path part = sum;
    dl_path_cut(&part, 0.375);
    assert_true(part.b[0] == sum.b[0]);
    for (int k = 0; k <= 16; k++)
        assert_true(fabs(dl_path_value(&part, k / 16.0) - dl_path_value(&sum, 0.375 * k / 16)) <
                    1e-14);
    assert_int_equal(sum.degree, 24);
    for (int k = 0; k <= 16; k++)
        assert_true(fabs(dl_path_value(&sum, k / 16.0) - 2 * exp(-k / 16.0)) < 1e-13);
}

/* --- scenes ------------------------------------------------------------------------------------
 */

#define HEAD      "name: ends\ndimension: 2\nparticles:\n  - {at: [0, 0]}\n  - {at: [1, 0]}\npair_law:\n"
#define LAW_TERMS "terms: [{coefficient: 2, power: 3}]}\n"
#define TAIL      "time: {step: 0.01, end: 1}\n"

static void scenes_ask_for_it(void **state) {
    (void)state;
    dl_scene *const scene = scene_of_text(
        HEAD "  - {until: 1, located: true, " LAW_TERMS
             "  - {until: 2, end: shifted-force, located: "
             "true, " LAW_TERMS "  - {until: 3, end: taper, width: 0.5, " LAW_TERMS TAIL);
    assert_true(scene->law.piece[0].located && scene->law.piece[1].located &&
                !scene->law.piece[2].located);
    dl_model *model = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    assert_true(model->locates_crossings && !model->locates_hits);
    char *text = NULL;
    size_t size;
    FILE *const out = open_memstream(&text, &size);
    dl_explain(model, out);
    fclose(out);
    static const char *const fragments[] = {"0 < r <= 1, end: hard, located",
                                            "1 < r <= 2, end: shifted force, located",
                                            "2.5 < r <= 3, end: taper\n", "crossings  located"};
    for (size_t k = 0; k < sizeof fragments / sizeof *fragments; k++)
        if (!strstr(text, fragments[k]))
            fail_msg("\"%s\" lacks \"%s\"", text, fragments[k]);
    free(text);
    dl_model_free(model);
    dl_scene_free(scene);
    dl_scene *const plain = scene_of_text(HEAD "  - {until: 1, " LAW_TERMS TAIL);
    assert_int_equal(dl_model_create(plain, &model, NULL), DL_OK);
    assert_false(model->locates_crossings);
    finished run = follow(plain, method_of("leapfrog"), "");
    assert_int_equal(run.summary.crossings, 0);
    free(run.y);
    dl_model_free(model);
    dl_scene_free(plain);
}

static void what_cannot_be_located_is_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *fragment[3];
    } rows[] = {
        {HEAD "  - {located: true, " LAW_TERMS TAIL, {":7: located", "\"true\"", "never ends"}},
        {HEAD "  - {until: 1, end: taper, width: 0.5, located: true, " LAW_TERMS TAIL,
         {":7: located", "\"true\"", "a taper is smooth"}},
        {HEAD "  - {until: 1, located: perhaps, " LAW_TERMS TAIL,
         {":7: located", "\"perhaps\"", "true"}},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        char path[] = "/tmp/driftlab-crossings-XXXXXX";
        const int descriptor = mkstemp(path);
        assert_int_equal(write(descriptor, rows[k].text, strlen(rows[k].text)),
                         (ssize_t)strlen(rows[k].text));
        close(descriptor);
        dl_scene *scene;
        dl_error error = {""};
        assert_int_equal(dl_scene_read(path, &scene, &error), DL_INPUT);
        unlink(path);
        for (int i = 0; i < 3; i++)
            if (!strstr(error.message, rows[k].fragment[i]))
                fail_msg("\"%s\" lacks \"%s\"", error.message, rows[k].fragment[i]);
    }
}

static bool run_prints(const char *scene, const char *expected) {
    char command[512], line[256];
    bool found = false;
    snprintf(command, sizeof command,
             DL_PROGRAM " run " DL_STUDIES "/breakpoints/%s --method gsl-rk8pd --rtol 1e-10",
             scene);
    FILE *const out = popen(command, "r");
    assert_non_null(out);
    while (fgets(line, sizeof line, out))
        found |= strstr(line, expected) != NULL;
    assert_int_equal(pclose(out), 0);
    return found;
}

/* Four bounces. */
static void runs_tell_how_many(void **state) {
    (void)state;
    assert_true(run_prints("pair-located.yaml", "crossings located          8\n"));
    assert_false(run_prints("pair-hard.yaml", "crossings"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_method_is_exact_on_a_bounce),
        cmocka_unit_test(order_is_the_methods_own),
        cmocka_unit_test(tight_tolerances_are_cheap),
        cmocka_unit_test(steps_from_afar_are_seen),
        cmocka_unit_test(grazing_pairs_pass_or_turn_back),
        cmocka_unit_test(dips_between_steps_are_crossings),
        cmocka_unit_test(pairs_cross_in_the_same_step),
        cmocka_unit_test(pairs_cross_at_the_same_time),
        cmocka_unit_test(the_first_of_close_crossings_is_the_first),
        cmocka_unit_test(walls_are_hit_between_crossings),
        cmocka_unit_test(the_first_of_close_events_is_the_first),
        cmocka_unit_test(images_are_where_they_are),
        cmocka_unit_test(pairs_move_in_three_dimensions),
        cmocka_unit_test(species_have_breakpoints_of_their_own),
        cmocka_unit_test(copies_cross),
        cmocka_unit_test(a_cutoff_of_half_a_period),
        cmocka_unit_test(a_step_may_pass_several_breakpoints),
        cmocka_unit_test(a_pair_may_begin_on_its_breakpoint),
        cmocka_unit_test(a_pair_on_an_edge_is_a_failure),
        cmocka_unit_test(radiation_finds_pairs_where_they_are),
        cmocka_unit_test(methods_agree_on_a_fluid),
        cmocka_unit_test(observation_changes_nothing),
        cmocka_unit_test(cut_steps_make_up_the_time),
        cmocka_unit_test(ranges_go_on_beyond_their_ends),
        cmocka_unit_test(locks_hold_whatever_kernels_round),
        cmocka_unit_test(jacobians_know_of_locks),
        cmocka_unit_test(squares_of_paths_are_paths),
        cmocka_unit_test(scenes_ask_for_it),
        cmocka_unit_test(what_cannot_be_located_is_refused),
        cmocka_unit_test(runs_tell_how_many),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
