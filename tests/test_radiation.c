/* Radiation: who is outer, what is multiplied, when, for every method, and that it is booked. */
#include "fixture_runs.h"

#include "driftlab/explain.h"
#include "fixture_scenes.h"

static dl_model *model_of(const dl_scene *scene) {
    dl_model *model = NULL;
    dl_error error = {""};
    if (dl_model_create(scene, &model, &error))
        fail_msg("%s", error.message);
    return model;
}

static dl_radiation radiation_of(double period, double beyond, double above, double below,
                                 dl_radiation_frame frame) {
    return (dl_radiation){.present = true,
                          .period = period,
                          .beyond = beyond,
                          .reach = INFINITY,
                          .opening = 60,
                          .factor_above = above,
                          .factor_below = below,
                          .frame = frame};
}

/* --- reading ---------------------------------------------------------------------------------- */

static const char head[] = "name: radiating\n"
                           "dimension: 2\n"
                           "particles:\n"
                           "  - {at: [0, 9], velocity: [1, 0]}\n"
                           "  - {at: [0, -9], velocity: [1, 0]}\n"
                           "time: {step: 1.0e-4, end: 1, sample: 0.1}\n";

static dl_status read_radiating(const char *line, dl_scene **scene, dl_error *error) {
    char path[] = "/tmp/driftlab-radiation-XXXXXX";
    const int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    FILE *file = fdopen(descriptor, "w");
    assert_non_null(file);
    fprintf(file, "%s%s\n", head, line);
    fclose(file);
    const dl_status status = dl_scene_read(path, scene, error);
    unlink(path);
    return status;
}

static dl_radiation accepted(const char *line) {
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (read_radiating(line, &scene, &error))
        fail_msg("%s", error.message);
    const dl_radiation radiation = scene->radiation;
    dl_scene_free(scene);
    return radiation;
}

static void reads_radiation(void **state) {
    (void)state;
    const dl_radiation published =
        accepted("radiation: {period: 5.0e-3, beyond: 7, factor_above: 1.001, factor_below: "
                 "0.9955, frame: lab}");
    assert_true(published.present && !published.boundary);
    assert_true(published.period == 5e-3 && published.beyond == 7);
    assert_true(published.factor_above == 1.001 && published.factor_below == 0.9955);
    assert_int_equal(published.frame, DL_FRAME_LAB);
    const dl_radiation boundary =
        accepted("radiation: {period: 0.1, beyond: boundary, reach: 3, frame: centre}");
    assert_true(boundary.present && boundary.boundary);
    assert_true(boundary.reach == 3 && boundary.opening == 60);
    assert_true(boundary.factor_above == 1 && boundary.factor_below == 1);
    assert_int_equal(boundary.frame, DL_FRAME_CENTRE);
    assert_false(accepted("").present);
}

static void refuses_bad_radiation(void **state) {
    (void)state;
    static const struct {
        const char *line, *message;
    } bad[] = {
        {"radiation: {period: 5.05e-3, beyond: 7, factor_below: 0.9}",
         ":7: period: found \"5.05e-3\", expected a whole number of steps of 0.0001"},
        {"radiation: {beyond: 7}", ":7: period: found nothing"},
        {"radiation: {period: 5.0e-3}",
         ":7: beyond: found nothing, expected a length >= 0, or boundary"},
        {"radiation: {period: 5.0e-3, beyond: bounday}", ":7: beyond: found \"bounday\""},
        {"radiation: {period: 5.0e-3, beyond: -7}", ":7: beyond: found \"-7\""},
        {"radiation: {period: 5.0e-3, beyond: [7]}", ":7: beyond: "},
        {"radiation: {period: 5.0e-3, beyond: 7, factor_above: -1}", ":7: factor_above: "},
        {"radiation: {period: 5.0e-3, beyond: 7, frame: center}", "did you mean \"centre\""},
        {"radiation: {period: 5.0e-3, beyond: boundary, opening: 200}", ":7: opening: "},
        {"radiation: {period: 5.0e-3, beyond: 7, reach: 3}",
         ":7: reach: found \"3\", expected none: only beyond: boundary has one"},
        {"radiation: {period: 5.0e-3, beyond: 7, opening: 50}", ":7: opening: found \"50\""},
        {"radiation: {perod: 5.0e-3, beyond: 7}", "did you mean \"period\""},
        {"radiation: 7", ":7: radiation: "},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        dl_scene *scene = NULL;
        dl_error error = {""};
        assert_int_equal(read_radiating(bad[i].line, &scene, &error), DL_INPUT);
        assert_null(scene);
        if (!strstr(error.message, bad[i].message))
            fail_msg("%s: %s", bad[i].line, error.message);
    }
}

static void explain_tells_who_and_how(void **state) {
    (void)state;
    static const struct {
        const char *line, *words[2];
    } rows[] = {
        {"radiation: {period: 5.0e-3, beyond: boundary, opening: 50, reach: 3}",
         {"particles on the boundary", "outward within 50 degrees and a distance of 3\n"}},
        {"radiation: {period: 5.0e-3, beyond: boundary}", {"60 degrees and however far\n"}},
        {"walls: {y: [-50, none], rule: located, damping: 0.5, rest: 1e-6, zero_vx_below: 1e-10}",
         {"shorter than 1e-06 of the time step", "|vx| below 1e-10 becomes 0"}},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        dl_scene *scene = NULL;
        dl_error error = {""};
        if (read_radiating(rows[k].line, &scene, &error))
            fail_msg("%s", error.message);
        dl_model *const model = model_of(scene);
        char *text = NULL;
        size_t size = 0;
        FILE *const out = open_memstream(&text, &size);
        assert_non_null(out);
        dl_explain(model, out);
        fclose(out);
        for (size_t i = 0; i < 2 && rows[k].words[i]; i++)
            if (!strstr(text, rows[k].words[i]))
                fail_msg("\"%s\" lacks \"%s\"", text, rows[k].words[i]);
        free(text);
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

/* --- who and what ----------------------------------------------------------------------------- */

/* Masses 1, 1, 2, 4; the mass centre is (1, 2) and moves with (10, -20). Distances from it: 7 (not
 * outer), 8 above, 4 below, and one at the height of the centre. */
static dl_scene *four(void) {
    dl_scene *scene = fixture_scene("four", 2, 4);
    static const double mass[4] = {1, 1, 2, 4};
    static const double at[4][3] = {{8, 2}, {1, 10}, {1, -2}, {-0.75, 2}};
    static const double velocity[4][3] = {{20, 0}, {12, -20}, {0, -40}, {12, -15}};
    for (size_t i = 0; i < 4; i++) {
        scene->inertia[i] = mass[i];
        fixture_place(scene, i, at[i], velocity[i]);
    }
    return scene;
}

static void radiate_four(double beyond, dl_radiation_frame frame, size_t outer, double v[8]) {
    dl_scene *scene = four();
    scene->radiation = radiation_of(0.01, beyond, 2, 0.5, frame);
    dl_model *model = model_of(scene);
    double y[16];
    assert_int_equal(model->unknowns, 8);
    dl_model_initial_state(model, y);
    assert_int_equal(dl_model_radiate(model, y, y + 8), outer);
    memcpy(v, y + 8, 8 * sizeof *v);
    dl_model_free(model);
    dl_scene_free(scene);
}

static void assert_velocities(const double v[8], const double expected[8]) {
    for (size_t k = 0; k < 8; k++)
        if (fabs(v[k] - expected[k]) > 1e-13)
            fail_msg("component %zu: %.17g, expected %.17g", k, v[k], expected[k]);
}

static void lab_frame_multiplies_the_velocity(void **state) {
    (void)state;
    double v[8];
    radiate_four(3, DL_FRAME_LAB, 3, v);
    assert_velocities(v, (double[8]){40, 24, 0, 12, 0, -40, -20, -15});
    radiate_four(7, DL_FRAME_LAB, 1, v); /* a particle at 7 is not farther than 7 */
    assert_velocities(v, (double[8]){20, 24, 0, 12, 0, -40, -40, -15});
}

static void centre_frame_multiplies_what_is_relative(void **state) {
    (void)state;
    double v[8];
    radiate_four(3, DL_FRAME_CENTRE, 3, v); /* mean velocity (10, -20) */
    assert_velocities(v, (double[8]){30, 14, 5, 12, 20, -20, -30, -15});
}

/* A hexagon of triangles with `rings` rings about (2, -1), and perhaps a particle far away. */
static dl_scene *hexagon(int rings, bool escaped) {
    const size_t count = (size_t)(3 * rings * (rings + 1) + 1);
    dl_scene *scene = fixture_scene("hexagon", 2, count + escaped);
    size_t next = 0;
    for (int a = -rings; a <= rings; a++)
        for (int b = -rings; b <= rings; b++)
            if (abs(a + b) <= rings)
                fixture_place(scene, next++, (double[3]){2 + a + 0.5 * b, -1 + sqrt(0.75) * b},
                              (double[3]){1, 1});
    assert_int_equal(next, count);
    if (escaped) { /* so light that the centre stays where it is */
        fixture_place(scene, count, (double[3]){102, -1}, (double[3]){1, 1});
        scene->inertia[count] = 1e-9;
    }
    return scene;
}

static size_t boundary_of(dl_scene *scene, double reach) {
    scene->radiation = radiation_of(0.01, 0, 2, 2, DL_FRAME_LAB);
    scene->radiation.boundary = true;
    scene->radiation.reach = reach;
    dl_model *model = model_of(scene);
    double *y = malloc(2 * model->unknowns * sizeof *y);
    assert_non_null(y);
    dl_model_initial_state(model, y);
    const size_t outer = dl_model_radiate(model, y, y + model->unknowns);
    /* Those are the ones of the outermost ring. */
    for (size_t i = 0; i < model->moving && scene->inertia[i] == 1; i++) {
        const double x = y[i] - 2, b = (y[model->moving + i] + 1) / sqrt(0.75), a = x - 0.5 * b;
        const double ring = fmax(fmax(fabs(a), fabs(b)), fabs(a + b));
        if (reach < 50)
            assert_true((y[model->unknowns + i] == 2) == (ring > 2.9));
    }
    free(y);
    dl_model_free(model);
    dl_scene_free(scene);
    return outer;
}

static void boundary_is_what_is_seen_from_outside(void **state) {
    (void)state;
    assert_int_equal(boundary_of(hexagon(3, false), 1.5), 18);
    assert_int_equal(boundary_of(hexagon(3, false), INFINITY), 18);
    /* One far out hides part of the rim, unless the reach ends before it. */
    assert_int_equal(boundary_of(hexagon(3, true), 10), 19);
    assert_in_range(boundary_of(hexagon(3, true), INFINITY), 13, 17);
}

/* --- when ------------------------------------------------------------------------------------- */

/* Two free particles, light and dark side: velocity v f^k after k periods, exactly. */
static dl_scene *free_pair(void) {
    dl_scene *scene = fixture_scene("free-pair", 2, 2);
    fixture_place(scene, 0, (double[3]){0, 50}, (double[3]){3, 0.5});
    fixture_place(scene, 1, (double[3]){0, -50}, (double[3]){-2, 0.25});
    scene->radiation = radiation_of(0.05, 7, 1.001, 0.9955, DL_FRAME_LAB);
    scene->step = 0.01;
    scene->end = 1;
    return scene;
}

static void check_times(const dl_method_row *row) {
    static const double factor[2] = {1.001, 0.9955}, velocity[2] = {3, -2};
    dl_scene *scene = free_pair();
    const dl_run_options how = run_options(1, 0.13); /* samples between the jumps, too */
    finished run = run_with(scene, row, "", &how);
    if (run.summary.status)
        fail_msg("%s: %s", row->name, run.summary.message);
    for (size_t i = 0; i < 2; i++) {
        double x = 0, v = velocity[i];
        for (int k = 0; k < 20; k++, v *= factor[i])
            x += 0.05 * v;
        if (fabs(run.y[i] - x) > 1e-11 || fabs(run.y[4 + i] - v) > 1e-12)
            fail_msg("%s: x = %.17g, v = %.17g, expected %.17g, %.17g", row->name, run.y[i],
                     run.y[4 + i], x, v);
    }
    assert_true(fabs(run.summary.energy_error_max) < 1e-10);
    assert_true(run.summary.ledger > 0.1);
    assert_true(run.summary.momentum_error_max < 1e-10);
    free(run.y);
    dl_scene_free(scene);
}

static void jumps_at_exact_times_for_every_method(void **state) {
    (void)state;
    for (size_t i = 0; i < dl_method_count(); i++) /* there is no force to split */
        if (!(dl_method_row_at(i)->flags & DL_SPLITS_FORCE))
            check_times(dl_method_row_at(i));
}

typedef struct seen {
    size_t count;
    double velocity[16];
} seen;

static dl_status see(void *context, const dl_sample *sample, dl_error *error) {
    (void)error;
    seen *s = context;
    assert_in_range(s->count, 0, 15);
    s->velocity[s->count++] = sample->y_all[4];
    return DL_OK;
}

/* None at the start; at a sample's time the sample comes after the jump; so at the end. */
static void jump_comes_before_the_sample(void **state) {
    (void)state;
    static const char *const methods[] = {"leapfrog", "cvode-adams"};
    for (size_t m = 0; m < 2; m++) {
        dl_scene *scene = free_pair();
        scene->radiation.factor_above = 2;
        seen s = {0};
        dl_run_options how = run_options(0.15, 0.025);
        scene->step = 0.005;
        how.on_sample = see;
        how.context = &s;
        finished run = run_with(scene, method_of(methods[m]), "", &how);
        static const double expected[7] = {3, 3, 6, 6, 12, 12, 24};
        assert_int_equal(s.count, 7);
        for (size_t k = 0; k < 7; k++)
            assert_true(fabs(s.velocity[k] - expected[k]) < 1e-12);
        free(run.y);
        dl_scene_free(scene);
    }
}

static void refuses_a_period_of_parts_of_steps(void **state) {
    (void)state;
    dl_scene *scene = free_pair();
    const dl_method_row *row = method_of("leapfrog");
    void *options = options_of(row, scene, "step=0.02");
    const dl_run_options how = run_options(1, 0);
    dl_run_summary summary;
    dl_error error = {""};
    assert_int_equal(dl_run(scene, row, options, &how, &summary, NULL, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "step: found 0.02, expected one that divides the scene's "
                                          "period of radiation ("));
    dl_method_options_free(row, options);
    dl_scene_free(scene);
}

/* --- booked ----------------------------------------------------------------------------------- */

/* The cluster, whose rim loses and gains much of its velocity every 0.02. */
static dl_scene *radiating_cluster(dl_radiation_frame frame) {
    dl_scene *scene = fixture_cluster();
    scene->radiation = radiation_of(0.02, 0.5, 1.2, 0.85, frame);
    return scene;
}

static dl_run_summary cluster_run(const char *method, const char *setting, dl_radiation_frame frame,
                                  double *y) {
    dl_scene *scene = radiating_cluster(frame);
    dl_run_options how = run_options(0.2, 0.02);
    finished run = run_with(scene, method_of(method), setting, &how);
    if (run.summary.status)
        fail_msg("%s: %s", method, run.summary.message);
    memcpy(y, run.y, 78 * sizeof *y);
    free(run.y);
    dl_scene_free(scene);
    return run.summary;
}

static double largest(const double *a, const double *b, size_t count) {
    double most = 0;
    for (size_t k = 0; k < count; k++)
        most = fmax(most, fabs(a[k] - b[k]));
    return most;
}

static double cluster_energy_error(const char *method, int steps) {
    char setting[40];
    double y[78];
    snprintf(setting, sizeof setting, "step=%.17g", 0.2 / steps);
    return cluster_run(method, setting, DL_FRAME_CENTRE, y).energy_error_max;
}

/* E + ledger - E(0) falls with the method's order through the jumps. */
static void energy_error_has_the_order_of_the_method(void **state) {
    (void)state;
    static const struct {
        const char *method;
        int order, steps;
    } cases[] = {
        {"leapfrog", 2, 100}, {"composition-4-yoshida", 4, 100}, {"composition-6-kahan-li", 6, 20}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const double coarse = cluster_energy_error(cases[i].method, cases[i].steps);
        const double fine = cluster_energy_error(cases[i].method, 2 * cases[i].steps);
        const double order = log2(coarse / fine);
        if (fabs(order - cases[i].order) > 0.5)
            fail_msg("%s: %g, %g: order %.3g", cases[i].method, coarse, fine, order);
    }
}

/* Tight methods agree with one another on energies, ledger and states, in both frames; without
 * booking the energy would be off by the ledger. */
static void methods_agree_through_the_jumps(void **state) {
    (void)state;
    static const struct {
        const char *method, *setting;
        double energy, ledger, place;
    } cases[] = {{"conserving-fixed-point", "step=2.5e-4", 1e-12, 1e-4, 1e-5},
                 {"arkode-erk", "rtol=1e-12", 2e-9, 1e-9, 1e-9},
                 {"cvode-adams", "rtol=1e-12", 1e-7, 1e-7, 1e-7},
                 {"gsl-rk8pd", "rtol=1e-12", 1e-9, 1e-9, 1e-9},
                 {"leapfrog", "step=1e-4", 1e-3, 2e-3, 1e-3}};
    for (int frame = 0; frame <= 1; frame++) {
        double reference[78], y[78];
        const dl_run_summary exact = cluster_run("composition-8-kahan-li", "step=1e-3",
                                                 (dl_radiation_frame)frame, reference);
        assert_true(exact.energy_error_max < 1e-11);
        assert_true(fabs(exact.ledger) > 0.02);
        for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
            const dl_run_summary s =
                cluster_run(cases[i].method, cases[i].setting, (dl_radiation_frame)frame, y);
            const double off = largest(y, reference, 39), ledger = fabs(s.ledger - exact.ledger);
            if (s.energy_error_max > cases[i].energy || ledger > cases[i].ledger ||
                off > cases[i].place || s.momentum_error_max > 1e-9)
                fail_msg("%s: energy error %g, ledger off by %g of %g, positions by %g, momentum "
                         "error %g",
                         cases[i].method, s.energy_error_max, ledger, exact.ledger, off,
                         s.momentum_error_max);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(reads_radiation),
        cmocka_unit_test(refuses_bad_radiation),
        cmocka_unit_test(explain_tells_who_and_how),
        cmocka_unit_test(lab_frame_multiplies_the_velocity),
        cmocka_unit_test(centre_frame_multiplies_what_is_relative),
        cmocka_unit_test(boundary_is_what_is_seen_from_outside),
        cmocka_unit_test(jumps_at_exact_times_for_every_method),
        cmocka_unit_test(jump_comes_before_the_sample),
        cmocka_unit_test(refuses_a_period_of_parts_of_steps),
        cmocka_unit_test(energy_error_has_the_order_of_the_method),
        cmocka_unit_test(methods_agree_through_the_jumps),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
