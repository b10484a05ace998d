/* Walls by the rule `located` in steps that are too long for the scene: the energy may go wrong,
 * but no wall of a scene whose walls take nothing has taken any, and no particle is beyond one. */
#include "contract.h"
#include "fixture_runs.h"
#include "fixture_scenes.h"

static const char soft[] =
    "name: soft\n"
    "dimension: 2\n"
    "particles: [{at: [1, 0.5], velocity: [0.3, 10]}, {at: [2, 0.6], velocity: [-3, -1]}]\n"
    "pair_law: [{until: 1, end: taper, width: 0.2, terms: [{coefficient: 1, power: 6}]}]\n"
    "walls: {x: [0, 4], y: [0, 1], rule: located, damping: 0}\n"
    "time: {step: 0.01, end: 10}\n";

static const char stiff[] =
    "name: stiff\n"
    "dimension: 2\n"
    "particles: [{at: [1, 0.5], velocity: [0.3, 100]}, {at: [2, 0.6], velocity: [-30, -1]}]\n"
    "pair_law: [{until: 1, terms: [{coefficient: 1, power: 12}]}]\n"
    "walls: {x: [0, 4], y: [0, 1], rule: located, damping: 0}\n"
    "time: {step: 1, end: 1}\n";

static const char *const steps[] = {"step=0.1", "step=0.05", "step=0.02"};

/* Every sample is within the walls, to roundoff. */
static dl_status check_sample(void *context, const dl_sample *sample, dl_error *error) {
    const char *const setting = context;
    static const double high[2] = {4, 1};
    (void)error;
    for (size_t u = 0; u < 4; u++)
        if (!(sample->y_all[u] >= -1e-14 && sample->y_all[u] <= high[u / 2] * (1 + 1e-14)))
            fail_msg("%s: coordinate %zu is %.17g at t = %g", setting, u, sample->y_all[u],
                     sample->time);
    return DL_OK;
}

/* What the walls have taken is roundoff of all the energy that there was. */
static dl_run_summary check_ledger(const dl_scene *scene, const char *method, const char *setting) {
    char name[80];
    snprintf(name, sizeof name, "%s with %s", method, setting);
    dl_run_options how = run_options(0, 0);
    how.on_sample = check_sample;
    how.context = name;
    finished run = run_with(scene, method_of(method), setting, &how);
    const dl_run_summary s = run.summary;
    free(run.y);
    print_message("%-40s %-18s %5lu hits, energy %.6g, ledger %.2e\n", name,
                  dl_status_name(s.status), s.wall_hits, s.energy_final, s.ledger);
    const double scale = fmax(s.energy_scale, fabs(s.energy_final));
    if (!(fabs(s.ledger) <= 1e-9 * scale))
        fail_msg("%s on %s: ledger %g of %g", name, scene->name, s.ledger, scale);
    return s;
}

static void elastic_walls_take_nothing(void **state) {
    (void)state;
    static const char *const methods[] = {"leapfrog", "composition-4-suzuki",
                                          "composition-8-kahan-li", "gsl-rk4"};
    dl_scene *const scene = scene_of_text(soft);
    for (size_t m = 0; m < sizeof methods / sizeof *methods; m++)
        for (size_t k = 0; k < 3; k++)
            assert_true(check_ledger(scene, methods[m], steps[k]).wall_hits > 50);
    dl_scene_free(scene);
}

static void what_conserves_energy_conserves_it(void **state) {
    (void)state;
    static const char *const methods[] = {"conserving-fixed-point", "conserving-newton-dense"};
    dl_scene *const scene = scene_of_text(soft);
    for (size_t m = 0; m < 2; m++)
        for (size_t k = 0; k < 3; k++) {
            const dl_run_summary s = check_ledger(scene, methods[m], steps[k]);
            assert_true(s.wall_hits > 50);
            assert_true(s.status == DL_OK || s.status == DL_NONLINEAR_FAILURE);
            if (!(fabs(s.energy_final - s.energy_initial) <= 1e-11 * s.energy_initial))
                fail_msg("%s with %s: energy %.17g, expected %.17g", methods[m], steps[k],
                         s.energy_final, s.energy_initial);
        }
    dl_scene_free(scene);
}

/* Under a force that blows all up. */
static void a_stiff_pair_does_not_change_that(void **state) {
    (void)state;
    static const struct {
        const char *method, *setting;
    } rows[] = {
        {"conserving-newton-dense", "step=0.1"},
        {"conserving-newton-dense", "step=0.05"},
        {"conserving-newton-dense", "step=0.02"},
        {"composition-4-suzuki", "step=0.1"},
        {"leapfrog", "step=0.05"},
        {"leapfrog", "step=0.02"},
        {"gsl-rk4", "step=0.1"},
        {"gsl-rk4", "step=0.05"},
    };
    dl_scene *const scene = scene_of_text(stiff);
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const dl_run_summary s = check_ledger(scene, rows[k].method, rows[k].setting);
        assert_true(s.wall_hits > 20);
        if (strncmp(rows[k].method, "conserving", 10) == 0)
            assert_true(fabs(s.energy_final - s.energy_initial) <= 1e-11 * s.energy_initial);
        else
            assert_int_equal(s.status, DL_UNSTABLE);
    }
    dl_scene_free(scene);
}

/* --- why a run ends ----------------------------------------------------------------------------
 */

/* A particle that crosses the box 50000 times along either axis in a step is no blow-up, nor does
 * it come to rest. */
static void the_message_tells_a_fast_particle(void **state) {
    (void)state;
    static const char fast[] = "name: fast\n"
                               "dimension: 2\n"
                               "particles: [{at: [1, 1], velocity: [1e7, 1.1e7]}]\n"
                               "walls: {x: [0, 2], y: [0, 2], rule: located}\n"
                               "time: {step: 0.01, end: 1}\n";
    dl_scene *const scene = scene_of_text(fast);
    dl_run_options how = run_options(0, 0);
    how.observe = false;
    finished run = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(run.summary.status, DL_STEP_FAILURE);
    assert_non_null(strstr(run.summary.message, "from wall to wall"));
    assert_null(strstr(run.summary.message, "accumulate"));
    free(run.y);
    dl_scene_free(scene);
}

static void a_blow_up_between_samples_is_one(void **state) {
    (void)state;
    static const char edge[] =
        "name: edge\n"
        "dimension: 2\n"
        "particles: [{at: [1, 0.5], velocity: [0.3, 100]}, {at: [2, 0.6], velocity: [-30, -1]}]\n"
        "pair_law: [{until: 1, located: true, terms: [{coefficient: 1, power: 12}]}]\n"
        "walls: {x: [0, 4], y: [0, 1], rule: located, damping: 0}\n"
        "time: {step: 1, end: 10}\n";
    dl_scene *const scene = scene_of_text(edge);
    const dl_run_options how = run_options(0, 0);
    finished run = run_with(scene, method_of("composition-4-suzuki"), "step=0.05", &how);
    assert_int_equal(run.summary.status, DL_UNSTABLE);
    assert_non_null(strstr(run.summary.message, "times the energy scale"));
    assert_null(strstr(run.summary.message, "accumulate"));
    free(run.y);
    dl_scene_free(scene);
}

/* Bounces that nothing ends but roundoff end for every method that is as near as that. */
static void without_a_last_flight_roundoff_ends_them(void **state) {
    (void)state;
    static const char dropped[] =
        "name: dropped\n"
        "dimension: 2\n"
        "gravity: [0, -10]\n"
        "particles:\n"
        "  - {at: [1, 0.5], velocity: [0.3, 0]}\n"
        "  - {at: [3, 0], velocity: [0, -1]}\n"
        "  - {at: [0, 0], velocity: [-1, -1]}\n"
        "walls: {x: [0, 4], y: [0, none], rule: located, damping: 0.5, rest: 0}\n"
        "time: {step: 0.01, end: 2}\n";
    dl_scene *const scene = scene_of_text(dropped);
    const dl_run_options how = run_options(0, 0);
    FOR_EACH_UNSPLIT_ROW(row)
    if (strcmp(row->name, "conserving-relaxed") != 0) {
        finished run = run_with(scene, row, "", &how);
        if (run.summary.status || run.summary.contacts < 3 || run.summary.wall_hits > 500)
            fail_msg("%s: %lu hits, %lu contacts: %s", row->name, run.summary.wall_hits,
                     run.summary.contacts, run.summary.message);
        assert_true(run.y[3] == 0 && run.y[4] == 0 && run.y[5] == 0);
        free(run.y);
    }
    dl_scene_free(scene);
}

/* --- states without an energy ------------------------------------------------------------------
 */

static void refused(const char *text, const char *expected) {
    dl_scene *const scene = scene_of_text(text);
    const dl_run_options how = run_options(0, 0);
    const dl_method_row *const row = method_of("leapfrog");
    void *const options = options_of(row, scene, "");
    dl_run_summary summary;
    dl_error error = {""};
    assert_int_equal(dl_run(scene, row, options, &how, &summary, NULL, &error), DL_INPUT);
    assert_non_null(strstr(error.message, scene->file));
    if (!strstr(error.message, expected))
        fail_msg("found \"%s\", expected \"%s\"", error.message, expected);
    assert_true(isnan(summary.energy_scale));
    dl_method_options_free(row, options);
    dl_scene_free(scene);
}

static void energies_beyond_numbers_are_bad_input(void **state) {
    (void)state;
    refused("name: a\ndimension: 2\n"
            "particles: [{at: [1, 1]}, {at: [2, 1], velocity: [0, 1e200]}]\n"
            "time: {step: 0.1, end: 1}\n",
            "particle 1: found position 1 and velocity 1e+200 along y");
    refused("name: a\ndimension: 2\n"
            "particles: [{at: [1e308, 1]}, {at: [-1e308, 1]}]\n"
            "time: {step: 0.1, end: 1}\n",
            "particle 0: found position 1e+308");
    refused("name: a\ndimension: 2\n"
            "particles: [{at: [3, 0]}, {at: [0, 0]}, {at: [1e-7, 0]}]\n"
            "pair_law: [{until: 1, terms: [{coefficient: 1, power: 64}]}]\n"
            "time: {step: 0.1, end: 1}\n",
            "particles 1 and 2: found distance 1e-07");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elastic_walls_take_nothing),
        cmocka_unit_test(what_conserves_energy_conserves_it),
        cmocka_unit_test(a_stiff_pair_does_not_change_that),
        cmocka_unit_test(the_message_tells_a_fast_particle),
        cmocka_unit_test(a_blow_up_between_samples_is_one),
        cmocka_unit_test(without_a_last_flight_roundoff_ends_them),
        cmocka_unit_test(energies_beyond_numbers_are_bad_input),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
