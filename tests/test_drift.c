/* Drift told from fluctuation: the statistics on series that are known, then methods whose energy
 * is known to stay, to drift or to be wrong; `driftlab check` and `driftlab measure`. */
#include "fixture_folder.h"
#include "fixture_kinds.h"
#include "fixture_scenes.h"

#include <jansson.h>
#include <sys/wait.h>

#include "driftlab/results.h"
#include "methods/registry.h"
#include "observe/series.h"

#define KEPLER DL_STUDIES "/kepler/kepler.yaml"

/* --- series ------------------------------------------------------------------------------------
 */

enum { trials = 400, length = 1000 };

static bool holds(dl_interval interval, double truth) {
    return interval.low <= truth && truth <= interval.high;
}

/* The interval that takes samples for independent, whatever they are. */
static bool naive_holds(const double *value, double slope) {
    dl_line line;
    dl_error error = {""};
    assert_int_equal(dl_series_line(value, length, &line, NULL, &error), DL_OK);
    const double n = length, half = 1.96 * line.rms / sqrt(n * (n * n - 1) / 12);
    return fabs(line.slope.value - slope) <= half;
}

static void slopes_are_covered_at_the_right_rate(void **state) {
    (void)state;
    static const double memories[] = {0, 0.5, 0.9};
    static const double slope = 2e-3;
    noise source = {1};
    double value[length];
    for (size_t m = 0; m < sizeof memories / sizeof *memories; m++) {
        int covered = 0, told = 0, naive = 0;
        double rms = 0;
        for (int t = 0; t < trials; t++) {
            dl_line line;
            dl_error error = {""};
            noise_series(&source, memories[m], length, value);
            for (size_t k = 0; k < length; k++)
                value[k] += 5 + slope * (double)k;
            assert_int_equal(dl_series_line(value, length, &line, NULL, &error), DL_OK);
            told += line.batches > 0;
            covered += line.batches > 0 && holds(line.slope, slope);
            naive += naive_holds(value, slope);
            rms += line.rms / trials;
        }
        assert_true(told > 0.85 * trials);
        const double rate = (double)covered / told;
        if (!(rate > 0.91 && rate < 0.985))
            fail_msg("memory %g: %g of the intervals hold the slope", memories[m], rate);
        assert_true(fabs(rms - 1) < 0.08);
        if (memories[m] > 0.8)
            assert_true(naive < 0.6 * trials); /* what the batches are for */
    }
}

/* A walk has no other memory than the whole run, but its steps have none. */
static void a_walk_drifts_by_the_mean_of_its_steps(void **state) {
    (void)state;
    noise source = {2};
    double value[length];
    int covered = 0, told = 0;
    double growth = 0, bounded = 0;
    for (int t = 0; t < trials; t++) {
        dl_line line;
        dl_error error = {""};
        double at = 0;
        noise_series(&source, 0.5, length, value);
        bounded += dl_series_growth(value, length) / trials;
        for (size_t k = 0; k < length; k++)
            value[k] = at += 0.1 + noise_normal(&source);
        growth += dl_series_growth(value, length) / trials;
        assert_int_equal(dl_series_line(value, length, &line, NULL, &error), DL_OK);
        if (line.batches > 0)
            continue;
        told++;
        covered += holds(line.slope, 0.1);
    }
    assert_true(fabs(bounded) < 0.05 && fabs(growth - 0.5) < 0.1);
    assert_true(told > 0.9 * trials);
    assert_true(covered > 0.92 * told && covered < 0.98 * told);
}

/* Fluctuation 3 h^2 and slope 0.01 h^3, with noise that the levels share and noise of their own. */
static void orders_are_fitted(void **state) {
    (void)state;
    static const double size[3] = {0.4, 0.2, 0.1};
    static double value[3][length], shared[length], own[length];
    const double *values[3] = {value[0], value[1], value[2]};
    noise source = {3};
    int fluctuations = 0, slopes = 0;
    for (int t = 0; t < trials; t++) {
        dl_orders orders;
        dl_error error = {""};
        noise_series(&source, 0.5, length, shared);
        for (size_t l = 0; l < 3; l++) {
            noise_series(&source, 0.5, length, own);
            for (size_t k = 0; k < length; k++)
                value[l][k] = size[l] * size[l] * (0.8 * shared[k] + 0.6 * own[k]) +
                              0.2 * pow(size[l], 3) * (double)k;
        }
        assert_int_equal(dl_series_orders(3, values, size, length, &orders, &error), DL_OK);
        assert_true(fabs(orders.fluctuation.value - 2) < 0.15);
        assert_true(fabs(orders.slope.value - 3) < 0.15);
        fluctuations += holds(orders.fluctuation, 2);
        slopes += holds(orders.slope, 3);
    }
    assert_true(fluctuations > 0.91 * trials && fluctuations < 0.985 * trials);
    assert_true(slopes > 0.91 * trials && slopes < 0.985 * trials);
}

static void too_few_samples_have_no_interval(void **state) {
    (void)state;
    noise source = {4};
    double value[40];
    dl_line line;
    dl_error error = {""};
    noise_series(&source, 0.95, 40, value);
    assert_int_equal(dl_series_line(value, 40, &line, NULL, &error), DL_OK);
    assert_true(line.batches == 0);
    assert_true(isnan(dl_series_mean(value, 40, NULL).low));
    assert_true(isnan(dl_series_correlation(value, 3)));
}

/* --- methods -----------------------------------------------------------------------------------
 */

static asked drift_of(const dl_scene *scene, const char *method, const char *option) {
    return (asked){
        .kind = &dl_study_kind_drift, .scene = scene, .row = method_of(method), .option = option};
}

static void a_symplectic_method_passes(void **state) {
    (void)state;
    static const struct {
        const char *method, *step;
        double order;
    } passing[] = {{"leapfrog", "step=0.0031415926535897931", 2},
                   {"composition-4-suzuki", "step=0.0314159265358979", 4},
                   {"composition-6-yoshida", "step=0.0314159265358979", 6}};
    dl_scene *scene = read_scene(KEPLER);
    for (size_t i = 0; i < sizeof passing / sizeof *passing; i++) {
        const asked what = drift_of(scene, passing[i].method, passing[i].step);
        dl_finding found = measure(&what);
        expect_verdict(&found, "pass", "within its fluctuation");
        expect_verdict(&found, "pass", "run back from t = 62.8");
        const double *order = quantity(&found, "order of the fluctuation");
        assert_true(fabs(order[0] - passing[i].order) < 0.05 * passing[i].order);
        assert_true(order[1] <= order[0] && order[0] <= order[2]);
        const double *drift = quantity(&found, "energy drift");
        assert_true(drift[1] < 0 && drift[2] > 0);
        assert_true(found.rows > 200 && found.rows <= 300 && found.columns == 4);
        dl_finding_release(&found);
    }
    dl_scene_free(scene);
}

/* The Runge-Kutta method of order 4 loses energy for ever, by h^5 a unit of time. */
static void a_runge_kutta_method_drifts(void **state) {
    (void)state;
    dl_scene *scene = read_scene(KEPLER);
    asked what = drift_of(scene, "gsl-rk4", "step=0.0314159265358979");
    dl_finding found = measure(&what);
    expect_verdict(&found, "fail", "the energy drifts by -");
    const double *order = quantity(&found, "order of the drift");
    assert_true(fabs(order[0] - 5) < 0.25 && order[1] > 4.5 && order[2] < 5.5);
    assert_true(quantity(&found, "energy drift")[2] < 0);
    assert_true(quantity(&found, "reversal distance")[0] >
                100 * quantity(&found, "reversal roundoff")[0]);
    const double drift = fabs(quantity(&found, "energy drift over the run")[1]);
    dl_finding_release(&found);
    /* who allows that much gets it */
    char allow[64];
    snprintf(allow, sizeof allow, "allow=%g", 2 * drift);
    what.setting = allow;
    found = measure(&what);
    expect_verdict(&found, "pass", "within the change allowed");
    dl_finding_release(&found);
    dl_scene_free(scene);
}

static void an_exact_method_is_held_to_roundoff(void **state) {
    (void)state;
    dl_scene *scene = read_scene(KEPLER);
    const asked strict = drift_of(scene, "conserving-fixed-point", "step=0.0314159265358979");
    dl_finding found = measure(&strict);
    expect_verdict(&found, "pass", "energy kept to");
    assert_true(quantity(&found, "energy error")[0] < 1e-13);
    dl_finding_release(&found);
    /* with its solver stopped early, it is held to what that says */
    const asked loose =
        drift_of(scene, "conserving-fixed-point", "step=0.0314159265358979 tolerance=1e-6");
    found = measure(&loose);
    expect_verdict(&found, "pass", "energy kept to");
    assert_true(quantity(&found, "energy error")[0] > 1e-13);
    dl_finding_release(&found);
    dl_scene_free(scene);
}

static void roundoff_and_short_runs_are_not_measurable(void **state) {
    (void)state;
    dl_scene *scene = read_scene(KEPLER);
    asked what = drift_of(scene, "composition-8-kahan-li", "step=0.00628318530717959");
    what.setting = "levels=1";
    dl_finding found = measure(&what);
    expect_verdict(&found, "not measurable", "no more than roundoff");
    dl_finding_release(&found);
    what = drift_of(scene, "leapfrog", "step=0.0628318530717959");
    what.end = 0.628318530717959;
    found = measure(&what);
    expect_verdict(&found, "not measurable", "samples are too few");
    dl_finding_release(&found);
    /* much of an orbit and not yet one: whether the error comes back is not known */
    what = drift_of(scene, "leapfrog", "step=0.00628318530717959");
    what.end = 4.71238898038469;
    found = measure(&what);
    expect_verdict(&found, "not measurable", "");
    dl_finding_release(&found);
    dl_scene_free(scene);
}

static void a_tolerance_stands_for_the_step(void **state) {
    (void)state;
    dl_scene *scene = read_scene(KEPLER);
    asked what = drift_of(scene, "gsl-rkf45", "rtol=1e-6");
    dl_finding found = measure(&what);
    expect_verdict(&found, "fail", "the energy drifts");
    const double *power = quantity(&found, "power of the fluctuation");
    assert_true(power[0] > 0.5 && power[0] < 1.5);
    assert_null(dl_finding_quantity(&found, "order of the fluctuation"));
    assert_null(dl_finding_quantity(&found, "reversal distance"));
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* --- broken methods ----------------------------------------------------------------------------
 */

typedef struct broken_options {
    double step;
} broken_options;

static const dl_parameter broken_rows[] = {{.name = "step",
                                            .kind = DL_REAL,
                                            .offset = offsetof(broken_options, step),
                                            .unit = "time",
                                            .maximum = INFINITY,
                                            .above_minimum = true}};

typedef struct broken {
    double first_kick, second_kick; /* parts of h a: 1/2 each in velocity Verlet */
    double push;                    /* velocity that every step gives one particle */
} broken;

static dl_status broken_create(dl_method *method, dl_error *error) {
    method->step = ((const broken_options *)method->options)->step;
    method->data = calloc(method->n, sizeof(double));
    return method->data ? DL_OK : dl_fail_memory(error, "a method");
}

static dl_status kick(dl_method *method, double part, dl_error *error) {
    double *a = method->data;
    const dl_status status = dl_model_acceleration(method->model, method->y, a, error);
    for (size_t k = 0; k < method->n && !status; k++)
        method->y[method->n + k] += part * method->step * a[k];
    return status;
}

static dl_status broken_advance(dl_method *method, double t_stop, dl_error *error) {
    const broken *how = method->row->variant;
    (void)t_stop;
    dl_status status = kick(method, how->first_kick, error);
    for (size_t k = 0; k < method->n; k++)
        method->y[k] += method->step * method->y[method->n + k];
    if (!status)
        status = kick(method, how->second_kick, error);
    method->y[method->n] += how->push;
    dl_method_count_step(method);
    return status;
}

static dl_status broken_jumped(dl_method *method, dl_error *error) {
    (void)method;
    (void)error;
    return DL_OK;
}

static void broken_stats(const dl_method *method, dl_method_stats *stats) {
    stats->steps = method->since;
}

static void broken_destroy(dl_method *method) {
    free(method->data);
}

static const dl_method_ops broken_ops = {.create = broken_create,
                                         .advance = broken_advance,
                                         .jumped = broken_jumped,
                                         .stats = broken_stats,
                                         .destroy = broken_destroy};

/* Claims to be velocity Verlet, with those coefficients. */
static dl_finding measure_broken(const dl_scene *scene, const broken *how, unsigned flags) {
    const dl_method_row row = {.name = "broken",
                               .family = "test",
                               .doc = "",
                               .order = 2,
                               .flags = DL_FIXED_STEP | flags,
                               .options = {broken_rows, 1},
                               .options_size = sizeof(broken_options),
                               .variant = how,
                               .ops = &broken_ops};
    const asked what = {.kind = &dl_study_kind_drift,
                        .scene = scene,
                        .row = &row,
                        .option = "step=0.00628318530717959"};
    return measure(&what);
}

static void broken_methods_fail(void **state) {
    (void)state;
    dl_scene *scene = read_scene(KEPLER);
    static const broken sound = {0.5, 0.5, 0}, heavy = {0.501, 0.501, 0}, late = {1, 0, 0},
                        pushed = {0.5, 0.5, 1e-9};
    dl_finding found =
        measure_broken(scene, &sound, DL_SYMPLECTIC | DL_TIME_SYMMETRIC | DL_CONSERVES_MOMENTUM);
    expect_verdict(&found, "pass", "of order 2.0");
    dl_finding_release(&found);
    /* a force of 1.002 times what it should be: the error does not go with the step */
    found = measure_broken(scene, &heavy, DL_SYMPLECTIC);
    expect_verdict(&found, "fail", "not 2");
    assert_true(quantity(&found, "order of the fluctuation")[2] < 0.5);
    dl_finding_release(&found);
    /* the symplectic Euler method: of order 1, and not time-symmetric */
    found = measure_broken(scene, &late, DL_SYMPLECTIC);
    expect_verdict(&found, "fail", "not 2");
    assert_true(fabs(quantity(&found, "order of the fluctuation")[0] - 1) < 0.1);
    dl_finding_release(&found);
    found = measure_broken(scene, &late, DL_SYMPLECTIC | DL_TIME_SYMMETRIC);
    expect_verdict(&found, "fail", "though it is to be time-symmetric");
    dl_finding_release(&found);
    found = measure_broken(scene, &pushed, DL_SYMPLECTIC | DL_CONSERVES_MOMENTUM);
    expect_verdict(&found, "fail", "momentum, which the method is to conserve, is off");
    dl_finding_release(&found);
    found = measure_broken(scene, &sound, DL_CONSERVES_ENERGY);
    expect_verdict(&found, "fail", "energy, which the method is to conserve, is off");
    dl_finding_release(&found);
    dl_scene_free(scene);
}

static dl_status unstable_run(const dl_scene *scene, const dl_method_row *row, const void *options,
                              const dl_run_options *how, dl_run_summary *summary, double *y,
                              dl_error *error) {
    dl_run_options short_of_time = *how;
    short_of_time.energy_bound = 1e-9;
    return dl_run(scene, row, options, &short_of_time, summary, y, error);
}

static dl_status slow_run(const dl_scene *scene, const dl_method_row *row, const void *options,
                          const dl_run_options *how, dl_run_summary *summary, double *y,
                          dl_error *error) {
    const dl_status status = dl_run(scene, row, options, how, summary, y, error);
    if (!status)
        summary->status = DL_TIMEOUT;
    return status;
}

static void runs_that_end_early_are_findings(void **state) {
    (void)state;
    dl_scene *scene = read_scene(KEPLER);
    asked what = drift_of(scene, "leapfrog", "");
    what.run = unstable_run;
    dl_finding found = measure(&what);
    expect_verdict(&found, "fail", " of 62.8 (unstable)");
    dl_finding_release(&found);
    what.run = slow_run;
    found = measure(&what);
    expect_verdict(&found, "not measurable", " of 62.8 (timeout)");
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* TR323's fluid: walls that take energy, and a force that jumps, which heats at any step. */
static void what_walls_take_is_booked(void **state) {
    (void)state;
    dl_scene *scene = read_scene(DL_STUDIES "/drop/settled.yaml");
    asked what = drift_of(scene, "leapfrog", "");
    what.setting = "levels=1";
    dl_finding found = measure(&what);
    expect_verdict(&found, "fail", "the energy drifts by 0.");
    expect_verdict(&found, "fail", "not run back: walls are hit");
    assert_true(quantity(&found, "energy drift")[1] > 0.1);
    assert_null(dl_finding_quantity(&found, "angular momentum drift"));
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* A chaotic motion hides a reversal that is too long behind roundoff: it is made shorter. */
static void reversal_is_as_long_as_roundoff_lets_it(void **state) {
    (void)state;
    dl_scene *scene = fixture_stream(50);
    asked what = drift_of(scene, "leapfrog", "step=0.02");
    what.end = 81.92;
    what.setting = "levels=1";
    dl_finding found = measure(&what);
    const double time = quantity(&found, "reversal after")[0];
    assert_true(time > 1 && time < 81.92);
    assert_true(quantity(&found, "reversal distance")[0] <=
                quantity(&found, "reversal roundoff")[0]);
    dl_finding_release(&found);
    what.setting = "levels=1 reversal=1.28";
    found = measure(&what);
    assert_true(fabs(quantity(&found, "reversal after")[0] - 1.28) < 1e-12);
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* --- the kinds ---------------------------------------------------------------------------------
 */

/* --set KEY=VALUE names a setting of the method or of the kind: never both. */
static void settings_of_kinds_are_no_options_of_methods(void **state) {
    (void)state;
    for (size_t k = 0; dl_study_kinds[k]; k++) {
        const dl_parameter_table settings = dl_study_kind_rows[k]->settings;
        for (size_t s = 0; s < settings.count; s++)
            for (size_t m = 0; m < dl_method_count(); m++)
                if (dl_parameter_find(dl_method_row_at(m)->options, settings.rows[s].name))
                    fail_msg("%s: setting %s is an option of %s too", dl_study_kinds[k],
                             settings.rows[s].name, dl_method_row_at(m)->name);
    }
}

static void studies_that_come_with_it_are_valid(void **state) {
    (void)state;
    static const char *const names[] = {
        "drift/stream",          "drift/swirl",         "drift/drop",
        "equilibrium/steps",     "equilibrium/cutoffs", "equilibrium/walls",
        "equilibrium/conserving"};
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        char path[512];
        dl_study *study = NULL;
        dl_error error = {""};
        snprintf(path, sizeof path, "%s/%s.yaml", DL_STUDIES, names[i]);
        if (dl_study_read(path, &study, &error) != DL_OK)
            fail_msg("%s", error.message);
        assert_true(dl_study_cases(study) >= 2);
        dl_study_free(study);
    }
}

/* --- the program -------------------------------------------------------------------------------
 */

static char said[200000], complained[4000];

static void read_back(const char *name, char *text, size_t size) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = '\0';
    fclose(file);
}

/* Exit status of `driftlab ARGUMENTS`, run where the studies are. */
static int driftlab(const char *arguments) {
    char command[2000];
    snprintf(command, sizeof command, "cd %s && %s %s >%s/out 2>%s/err", DL_STUDIES, DL_PROGRAM,
             arguments, folder, folder);
    const int status = system(command);
    assert_true(WIFEXITED(status));
    read_back("out", said, sizeof said);
    read_back("err", complained, sizeof complained);
    return WEXITSTATUS(status);
}

static void check_exits_as_documented(void **state) {
    (void)state;
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog"), 0);
    assert_non_null(strstr(said, "pass: kepler with leapfrog"));
    assert_int_equal(driftlab("check kepler/kepler.yaml --method gsl-rk4 --dt 0.0314159265358979"),
                     1);
    assert_non_null(strstr(said, "fail: kepler with gsl-rk4"));
    assert_int_equal(complained[0], '\0');
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog --t-end "
                              "0.06283185307179586"),
                     1);
    assert_non_null(strstr(said, "not measurable: kepler"));
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog --t-end "
                              "0.12566370614359172"),
                     1);
    assert_non_null(strstr(said, "of 21 samples, too few to tell how it grows"));
    assert_null(strstr(said, "nan"));
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog --dt 0.01"), 2);
    assert_non_null(strstr(complained, "a whole number of steps"));
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog --set levles=1"), 2);
    assert_non_null(strstr(complained, "did you mean \"levels\""));
    assert_int_equal(driftlab("check kepler/kepler.yaml --dt 0.01"), 2);
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog --set step=1 --dt 1"), 2);
    assert_non_null(strstr(complained, "which --dt sets already"));
    assert_int_equal(driftlab("check --help"), 0);
    assert_non_null(strstr(said, "exit status: 0 pass; 1 fail, or not measurable"));
}

static void check_tells_programs(void **state) {
    (void)state;
    json_error_t where;
    assert_int_equal(driftlab("check kepler/kepler.yaml --method leapfrog --json"), 0);
    json_t *root = json_loads(said, 0, &where);
    assert_non_null(root);
    assert_string_equal(json_string_value(json_object_get(root, "verdict")), "pass");
    const json_t *quantities = json_object_get(root, "quantities");
    const json_t *scale = json_array_get(quantities, 0);
    assert_string_equal(json_string_value(json_object_get(scale, "name")), "energy scale");
    assert_string_equal(json_string_value(json_object_get(scale, "unit")), "energy");
    assert_true(json_real_value(json_object_get(scale, "value")) == 0.84375);
    assert_int_equal(json_array_size(json_object_get(root, "columns")), 4);
    assert_true(json_array_size(json_object_get(root, "rows")) > 200);
    json_decref(root);
}

static void measure_refuses_what_it_cannot(void **state) {
    (void)state;
    assert_int_equal(driftlab("measure work-precision kepler/kepler.yaml --method leapfrog"), 2);
    assert_non_null(strstr(complained, "driftlab run integrates one case"));
    assert_int_equal(driftlab("measure drfit kepler/kepler.yaml --method leapfrog"), 2);
    assert_non_null(strstr(complained, "did you mean \"drift\""));
    assert_int_equal(driftlab("measure nothing kepler/kepler.yaml --method leapfrog"), 2);
    assert_non_null(strstr(complained, "expected one of "));
    assert_int_equal(driftlab("measure drift none.yaml --method leapfrog"), 2);
    assert_int_equal(driftlab("measure drift kepler/kepler.yaml --method gsl-rkf45 --rtol 0"), 2);
    assert_int_equal(driftlab("measure drift kepler/kepler.yaml --method gsl-rkf45 --set rtol=0"),
                     2);
    assert_non_null(strstr(complained, "to be made smaller"));
}

/* A unit's command, as a study keeps it, finds what the study found. */
static void a_units_command_repeats_it(void **state) {
    (void)state;
    static const char study[] = "name: drifting\nkind: drift\nscene: " KEPLER "\nsamples: 500\n"
                                "with: {levels: 2, slack: 0.2}\n"
                                "cases:\n  - {method: leapfrog, step: [0.0125663706143592]}\n"
                                "  - {method: gsl-rkf45, rtol: 1.0e-5}\n";
    char path[128], arguments[256];
    snprintf(path, sizeof path, "%s/study.yaml", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(study, file);
    fclose(file);
    snprintf(arguments, sizeof arguments, "study %s", path);
    assert_int_equal(driftlab(arguments), 0);
    assert_non_null(strstr(said, "on kepler the energy stays with 1 of 2 (leapfrog step=0.0125"));
    snprintf(path, sizeof path, "%s/results.h5", folder);
    dl_results *results = NULL;
    dl_error error = {""};
    assert_int_equal(dl_results_read(path, &results, &error), DL_OK);
    assert_int_equal(results->findings, 2);
    for (size_t i = 0; i < results->findings; i++) {
        const dl_finding *finding = &results->finding[i];
        assert_memory_equal(finding->command, "driftlab measure drift ", 23);
        assert_int_equal(driftlab(finding->command + strlen("driftlab ")), 0);
        assert_non_null(strstr(said, finding->reason));
    }
    dl_results_free(results);
}

static void measure_is_interrupted(void **state) {
    (void)state;
    char command[1000];
    snprintf(command, sizeof command,
             "timeout --foreground -s INT 1 %s measure drift %s --method leapfrog --set "
             "step=6.283185307179586e-7 >%s/out 2>%s/err",
             DL_PROGRAM, KEPLER, folder, folder);
    const int status = system(command);
    assert_true(WIFEXITED(status));
    read_back("err", complained, sizeof complained);
    /* timeout tells 124, whatever the program's own status */
    assert_int_equal(WEXITSTATUS(status), 124);
    assert_non_null(strstr(complained, "interrupted"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slopes_are_covered_at_the_right_rate),
        cmocka_unit_test(a_walk_drifts_by_the_mean_of_its_steps),
        cmocka_unit_test(orders_are_fitted),
        cmocka_unit_test(too_few_samples_have_no_interval),
        cmocka_unit_test(a_symplectic_method_passes),
        cmocka_unit_test(a_runge_kutta_method_drifts),
        cmocka_unit_test(an_exact_method_is_held_to_roundoff),
        cmocka_unit_test(roundoff_and_short_runs_are_not_measurable),
        cmocka_unit_test(a_tolerance_stands_for_the_step),
        cmocka_unit_test(broken_methods_fail),
        cmocka_unit_test(runs_that_end_early_are_findings),
        cmocka_unit_test(what_walls_take_is_booked),
        cmocka_unit_test(reversal_is_as_long_as_roundoff_lets_it),
        cmocka_unit_test(settings_of_kinds_are_no_options_of_methods),
        cmocka_unit_test(studies_that_come_with_it_are_valid),
        cmocka_unit_test(check_exits_as_documented),
        cmocka_unit_test(check_tells_programs),
        cmocka_unit_test(measure_refuses_what_it_cannot),
        cmocka_unit_test(a_units_command_repeats_it),
        cmocka_unit_test(measure_is_interrupted),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
