/* Settled states: transients are found and left out, what is not settled is told so, and means with
 * their intervals are those that are known. */
#include "fixture_kinds.h"
#include "fixture_scenes.h"

#include "observe/series.h"

enum { trials = 400, length = 1000 };

static bool holds(dl_interval interval, double truth) {
    return interval.low <= truth && truth <= interval.high;
}

/* --- series ------------------------------------------------------------------------------------
 */

static void means_are_covered_at_the_right_rate(void **state) {
    (void)state;
    static const double memories[] = {0, 0.5, 0.9};
    noise source = {11};
    double value[length];
    for (size_t m = 0; m < sizeof memories / sizeof *memories; m++) {
        int covered = 0, told = 0;
        double correlation = 0;
        for (int t = 0; t < trials; t++) {
            double time;
            noise_series(&source, memories[m], length, value);
            const dl_interval mean = dl_series_mean(value, length, &time);
            told += !isnan(mean.low);
            covered += holds(mean, 0);
            correlation += time / trials;
        }
        const double rate = (double)covered / told, memory = memories[m];
        if (!(rate > 0.91 && rate < 0.985))
            fail_msg("memory %g: %g of the intervals hold the mean", memory, rate);
        /* 1/2 + sum of memory^k */
        const double exact = 0.5 + memory / (1 - memory);
        assert_true(fabs(correlation - exact) < 0.15 * exact);
    }
}

static bool passes(const double *value, size_t first) {
    dl_error error = {""};
    return first <= length / 2 &&
           fabs(dl_series_change(value + first, length - first, &error)) <= DL_SETTLED_BOUND;
}

/* What is left of a series that decays to its mean has the mean; the whole has not. */
static void transients_are_left_out(void **state) {
    (void)state;
    noise source = {12};
    double value[length];
    int covered = 0, with_transient = 0, settled = 0;
    double cut = 0;
    for (int t = 0; t < trials; t++) {
        noise_series(&source, 0.5, length, value);
        for (size_t k = 0; k < length; k++)
            value[k] += 7 + 20 * exp(-(double)k / 30);
        const size_t first = dl_series_truncation(value, length);
        covered += holds(dl_series_mean(value + first, length - first, NULL), 7);
        with_transient += holds(dl_series_mean(value, length, NULL), 7);
        settled += passes(value, first);
        cut += (double)first / trials;
    }
    assert_true(cut > 60 && cut < 250); /* 20 exp(-2) = 2.7, 20 exp(-8) = 0.007 */
    assert_true(covered > 0.88 * trials);
    assert_true(with_transient < 0.5 * trials);
    assert_true(settled > 0.95 * trials);
}

/* Series that have settled pass; those that still change do not. */
static void the_test_has_teeth(void **state) {
    (void)state;
    noise source = {13};
    double value[length];
    int alarms = 0, trends = 0, steps = 0;
    for (int t = 0; t < trials; t++) {
        noise_series(&source, 0.8, length, value);
        alarms += !passes(value, dl_series_truncation(value, length));
        for (size_t k = 0; k < length; k++)
            value[k] += 3 * (double)k / length;
        trends += !passes(value, dl_series_truncation(value, length));
        noise_series(&source, 0.8, length, value);
        for (size_t k = 700; k < length; k++)
            value[k] += 3;
        steps += !passes(value, dl_series_truncation(value, length));
    }
    if (alarms > 0.03 * trials || trends < 0.85 * trials || steps < 0.95 * trials)
        fail_msg("of %d: settled and not told so %d; trends told %d, steps %d", trials, alarms,
                 trends, steps);
}

/* --- states that are known ---------------------------------------------------------------------
 */

static asked equilibrium_of(const dl_scene *scene, const char *method, const char *option) {
    return (asked){.kind = &dl_study_kind_equilibrium,
                   .scene = scene,
                   .row = method_of(method),
                   .option = option};
}

/* Two particles on a spring, at rest at its end: F = r^-5 - r^-2 has F(1) = 0, F'(1) = -3, and the
 * reduced mass is 2/3. */
static const double stretch = 1e-3, omega_squared = 4.5;

static dl_scene *spring(void) {
    dl_scene *scene = fixture_scene("spring", 2, 2);
    fixture_law(scene, INFINITY, 1, 2, 1, 5);
    scene->inertia[1] = 2;
    fixture_place(scene, 1, (double[3]){1 + stretch}, (double[3]){0});
    scene->end = 400;
    return scene;
}

/* Leap-frog's oscillation of frequency omega has the mean kinetic energy of the exact one times
 * 1 - (h omega)^2 / 4: v_k = -A omega sqrt(1 - (h omega)^2/4) sin k theta. A step of that size
 * shows what a step does, exactly. */
static void a_spring_has_the_kinetic_energy_that_its_step_gives(void **state) {
    (void)state;
    dl_scene *scene = spring();
    static const char *const steps[] = {"step=0.4", "step=0.2", "step=0.02"};
    static const double step[] = {0.4, 0.2, 0.02};
    const double exact = 2.0 / 3 * omega_squared * stretch * stretch / 4 / 2; /* a particle */
    for (size_t i = 0; i < 3; i++) {
        asked what = equilibrium_of(scene, "leapfrog", steps[i]);
        what.sample = 0.4;
        dl_finding found = measure(&what);
        expect_verdict(&found, "settled", "the transient is over after");
        const double *kinetic = quantity(&found, "kinetic energy per particle");
        const double expected = exact * (1 - step[i] * step[i] * omega_squared / 4);
        if (!(fabs(kinetic[0] - expected) < 0.005 * exact))
            fail_msg("step %g: kinetic energy %g, expected %g", step[i], kinetic[0], expected);
        assert_true(kinetic[1] < kinetic[0] && kinetic[0] < kinetic[2]);
        assert_true(fabs(quantity(&found, "mean separation")[0] - 1) < 1e-4);
        assert_null(dl_finding_quantity(&found, "depth of 95 %")); /* it has no weight, no floor */
        dl_finding_release(&found);
    }
    dl_scene_free(scene);
}

static dl_finding measure_spring(const dl_scene *scene, const char *setting) {
    asked what = equilibrium_of(scene, "leapfrog", "step=0.02");
    what.sample = 0.4;
    what.setting = setting;
    dl_finding found = measure(&what);
    expect_verdict(&found, "settled", "");
    return found;
}

/* A spring that flies at 50 has the kinetic energy of one that rests, relative to its centre, and
 * is settled as well; as it is, it has the centre's with it. */
static void a_flight_of_the_whole_is_no_heat(void **state) {
    (void)state;
    dl_scene *scene = spring();
    dl_finding rests = measure_spring(scene, "frame=lab");
    for (size_t k = 0; k < 2; k++)
        scene->velocity[k] += 50;
    dl_finding flies = measure_spring(scene, "frame=centre"), whole = measure_spring(scene, "");
    const double expected = quantity(&rests, "kinetic energy per particle")[0];
    const double found = quantity(&flies, "kinetic energy per particle")[0];
    if (!(fabs(found - expected) < 1e-6 * expected))
        fail_msg("kinetic energy %g in flight, %g at rest", found, expected);
    assert_true(fabs(quantity(&whole, "kinetic energy per particle")[0] - 1875) < 1e-3);
    dl_finding_release(&rests);
    dl_finding_release(&flies);
    dl_finding_release(&whole);
    dl_scene_free(scene);
}

enum { gas_particles = 100 };

/* Particles that fly through one another in a box of height 1, whose walls take nothing. */
static dl_scene *ideal_gas(void) {
    dl_scene *scene = fixture_scene("gas", 2, gas_particles);
    for (size_t i = 0; i < gas_particles; i++) {
        const unsigned k = 4 * (unsigned)i;
        fixture_place(scene, i,
                      (double[3]){0.5 + 0.5 * fixture_noise(k), 0.5 + 0.5 * fixture_noise(k + 1)},
                      (double[3]){fixture_noise(k + 2), fixture_noise(k + 3)});
    }
    scene->walls.present = true;
    scene->walls.low[0] = scene->walls.low[1] = 0;
    scene->walls.high[0] = scene->walls.high[1] = 1;
    scene->end = 500;
    return scene;
}

static void an_ideal_gas_is_of_one_density(void **state) {
    (void)state;
    dl_scene *scene = ideal_gas();
    double kinetic = 0;
    for (size_t k = 0; k < (size_t)2 * gas_particles; k++)
        kinetic += scene->velocity[k] * scene->velocity[k] / 2 / gas_particles;
    asked what = equilibrium_of(scene, "leapfrog", "step=0.05");
    what.setting = "bin=0.25";
    what.sample = 0.5;
    dl_finding found = measure(&what);
    expect_verdict(&found, "settled", "");
    const double *value = quantity(&found, "kinetic energy per particle");
    assert_true(fabs(value[0] - kinetic) < 1e-12 * kinetic && value[2] - value[1] < 1e-12);
    static const char *const bins[] = {"particles from 0 to 0.25", "particles from 0.25 to 0.5",
                                       "particles from 0.5 to 0.75", "particles from 0.75 to 1"};
    for (size_t b = 0; b < 4; b++) {
        value = quantity(&found, bins[b]);
        assert_true(value[2] - value[1] < 1);
        if (!(fabs(value[0] - 25) < value[2] - value[1]))
            fail_msg("%s: %g (%g to %g), expected 25", bins[b], value[0], value[1], value[2]);
    }
    assert_true(quantity(&found, "particles above 1")[0] < 1e-12);
    value = quantity(&found, "depth, twice the mean height");
    assert_true(fabs(value[0] - 1) < 0.02);
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* TR323's fluid loses its kinetic energy at a quarter of the report's step, for most of this run.
 */
static void a_fluid_that_cools_has_not_settled(void **state) {
    (void)state;
    dl_scene *scene = read_scene(DL_STUDIES "/drop/settled.yaml");
    asked what = equilibrium_of(scene, "leapfrog", "step=2.5e-5");
    what.end = 0.5;
    dl_finding found = measure(&what);
    expect_verdict(&found, "not settled", "");
    assert_true(found.rows > 200 && found.columns == 5);
    assert_true(found.table[1] > 20); /* the first kinetic energy */
    assert_true(found.table[(found.rows - 1) * found.columns + 1] < 15);
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* --- several runs ------------------------------------------------------------------------------
 */

/* Noise about a mean that a start, displaced or not, chooses: `apart` times the displacement. */
static double apart;
static double trend; /* of the mean over the run */
static noise fluid;

static dl_status fluctuating_run(const dl_scene *scene, const dl_method_row *row,
                                 const void *options, const dl_run_options *how,
                                 dl_run_summary *summary, double *y, dl_error *error) {
    static double value[2 * length];
    const size_t samples = (size_t)lround(how->end / how->sample);
    (void)row;
    (void)options;
    (void)y;
    assert_true(samples < (size_t)2 * length);
    assert_false(how->ledger);
    noise_series(&fluid, 0.5, samples, value);
    dl_run_summary_clear(summary);
    for (size_t k = 0; k < samples; k++) {
        const double y_all[8] = {scene->position[0], scene->position[1], scene->position[2],
                                 scene->position[3]};
        dl_sample sample = {.index = k, .time = (double)k * how->sample, .y_all = y_all};
        sample.energy.kinetic =
            2 * (30 + value[k] + apart * scene->position[0] + trend * (double)k / (double)samples);
        const dl_status status = how->on_sample(how->context, &sample, error);
        if (status)
            return status;
    }
    return DL_OK;
}

static dl_finding measure_runs(double how_far_apart, const char *setting) {
    dl_scene *scene = fixture_scene("two", 2, 2);
    fixture_place(scene, 1, (double[3]){1}, (double[3]){0});
    asked what = equilibrium_of(scene, "leapfrog", "step=0.001");
    what.setting = setting;
    what.run = fluctuating_run;
    apart = how_far_apart;
    dl_finding found = measure(&what);
    dl_scene_free(scene);
    return found;
}

static void runs_of_one_state_are_one_mean(void **state) {
    (void)state;
    fluid = (noise){21};
    dl_finding one = measure_runs(0, "runs=1"), four = measure_runs(0, "runs=4");
    expect_verdict(&one, "settled", "");
    expect_verdict(&four, "settled", "");
    const double *single = quantity(&one, "kinetic energy per particle");
    const double *mean = quantity(&four, "kinetic energy per particle");
    assert_true(fabs(mean[0] - 30) < mean[2] - mean[1]);
    assert_true(mean[2] - mean[1] < 0.7 * (single[2] - single[1]));
    assert_null(dl_finding_quantity(&one, "kinetic energy per particle, run 1"));
    quantity(&four, "kinetic energy per particle, run 4");
    assert_int_equal(four.columns, one.columns + 3);
    dl_finding_release(&one);
    dl_finding_release(&four);
}

/* Starts a millionth apart end in states of kinetic energies of the order of 1 apart. */
static void runs_of_several_states_are_told(void **state) {
    (void)state;
    fluid = (noise){22};
    dl_finding found = measure_runs(1e6, "runs=4");
    expect_verdict(&found, "several states", "not to the same kinetic energy");
    const double *mean = quantity(&found, "kinetic energy per particle");
    const double *first = quantity(&found, "kinetic energy per particle, run 1");
    assert_true(mean[2] - mean[1] > 3 * (first[2] - first[1]));
    dl_finding_release(&found);
}

static void runs_that_change_slowly_have_not_settled(void **state) {
    (void)state;
    fluid = (noise){23};
    trend = 1;
    dl_finding found = measure_runs(0, "runs=1");
    trend = 0;
    expect_verdict(&found, "not settled",
                   "after the transient the kinetic energy per particle still changes");
    dl_finding_release(&found);
}

/* A thousandth of ten steps is no time between samples: it is a step. One that was asked for is
 * not rounded. */
static void samples_that_nobody_asked_for_are_whole_steps(void **state) {
    (void)state;
    dl_scene *scene = ideal_gas();
    asked what = equilibrium_of(scene, "leapfrog", "step=0.05");
    what.end = 0.5;
    dl_finding finding = measure(&what);
    assert_int_equal(finding.rows, 11);
    dl_finding_release(&finding);
    what.sample = 0.5 / 1000;
    dl_error error = {""};
    assert_int_equal(refusal(&what, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "sample: found 0.0005, expected a whole number"));
    dl_scene_free(scene);
}

static void what_cannot_be_measured_is_refused(void **state) {
    (void)state;
    dl_scene *scene = ideal_gas();
    static const struct {
        const char *option, *setting, *words;
    } bad[] = {{"step=0.3", "", "a whole number of steps"},
               {"step=0.05", "bin=0.01", "expected at most"}};
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        asked what = equilibrium_of(scene, "leapfrog", bad[i].option);
        what.setting = bad[i].setting;
        dl_error error = {""};
        assert_int_equal(refusal(&what, &error), DL_INPUT);
        if (!strstr(error.message, bad[i].words))
            fail_msg("%s", error.message);
    }
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(means_are_covered_at_the_right_rate),
        cmocka_unit_test(transients_are_left_out),
        cmocka_unit_test(the_test_has_teeth),
        cmocka_unit_test(a_spring_has_the_kinetic_energy_that_its_step_gives),
        cmocka_unit_test(a_flight_of_the_whole_is_no_heat),
        cmocka_unit_test(an_ideal_gas_is_of_one_density),
        cmocka_unit_test(a_fluid_that_cools_has_not_settled),
        cmocka_unit_test(runs_of_one_state_are_one_mean),
        cmocka_unit_test(runs_of_several_states_are_told),
        cmocka_unit_test(runs_that_change_slowly_have_not_settled),
        cmocka_unit_test(samples_that_nobody_asked_for_are_whole_steps),
        cmocka_unit_test(what_cannot_be_measured_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
