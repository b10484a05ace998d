/* Studies: reading and expanding them, running what is missing whatever happened before, and cases
 * that hang, crash or fail. Every study here is written to a folder of the test's own. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>
#include "io/lock.h"
#include "study/child.h"
#include "study/kepler.h"
#include "study/measure.h"

static char folder[] = "/tmp/driftlab-study-XXXXXX";
static char study_path[128], scene_path[128], results_path[128];

static void write_text(const char *path, const char *text) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fputs(text, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

/* Two bodies on an ellipse of period 2 pi; `mass` of the second. */
static void write_scene(const char *mass) {
    char text[512];
    snprintf(text, sizeof text,
             "name: pair\ndimension: 2\nparticles:\n"
             "  - {at: [-0.1, 0], velocity: [0, -0.5], mass: 0.75}\n"
             "  - {at: [0.3, 0], velocity: [0, 1.5], mass: %s}\n"
             "pair_law:\n  - {terms: [{coefficient: -1, power: 2}]}\n"
             "time: {step: 0.01, end: 2}\n",
             mass);
    write_text(scene_path, text);
}

static const char exact_study[] = "name: test\n"
                                  "scene: scene.yaml\n"
                                  "samples: 4\n"
                                  "error: 1e-4\n"
                                  "repeats: 2\n"
                                  "limits: {seconds: 5}\n"
                                  "reference: {exact: kepler}\n"
                                  "cases:\n"
                                  "  - {method: leapfrog, step: [0.01, 0.005]}\n"
                                  "  - {method: gsl-rk8pd, rtol: [1e-8, 1e-13], atol: 1e-13}\n";

static dl_study *read_study(const char *text) {
    dl_study *study = NULL;
    dl_error error = {""};
    write_text(study_path, text);
    if (dl_study_read(study_path, &study, &error) != DL_OK)
        fail_msg("%s", error.message);
    return study;
}

static dl_results *run_study(const dl_study *study, bool force) {
    const dl_study_options options = {.results = results_path, .force = force};
    dl_results *results = NULL;
    dl_error error = {""};
    if (dl_study_run(study, &options, &results, &error) != DL_OK)
        fail_msg("%s", error.message);
    return results;
}

static int clean(void **state) {
    (void)state;
    unlink(results_path);
    write_scene("0.25");
    return 0;
}

/* --- reading ------------------------------------------------------------------------------- */

static void lists_expand_in_order(void **state) {
    (void)state;
    dl_study *study = read_study("name: test\nscene: scene.yaml\nerror: 1\nin: energy\ncases:\n"
                                 "  - {method: leapfrog, step: 0.02}\n"
                                 "  - {method: arkode-erk, table: [verner-6, fehlberg-8],\n"
                                 "     rtol: [1e-6, 1e-7]}\n");
    static const char *const expected[] = {
        "step=0.02",
        "step=0 rtol=1e-06 atol=1e-10 table=verner-6",
        "step=0 rtol=1e-07 atol=1e-10 table=verner-6",
        "step=0 rtol=1e-06 atol=1e-10 table=fehlberg-8",
        "step=0 rtol=1e-07 atol=1e-10 table=fehlberg-8",
    };
    assert_int_equal(dl_study_cases(study), 5);
    for (size_t i = 0; i < 5; i++) {
        assert_string_equal(study->cased[i].run.text, expected[i]);
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(study->cased[i].key, study->cased[j].key);
    }
    assert_non_null(strstr(study->cased[1].command,
                           "scene.yaml --method arkode-erk --set "
                           "table=verner-6 --set rtol=1e-6 --t-end 2 --sample 0.1"));
    dl_study_free(study);
}

#define HEAD      "name: test\nscene: scene.yaml\nerror: 1\nin: energy\n"
#define POSITIONS "name: test\nscene: scene.yaml\nerror: 1\n"
#define CASE      "cases:\n  - {method: leapfrog}\n"

static void bad_studies_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *line, *part;
    } bad[] = {
        {HEAD, "", "cases"},
        {HEAD "cases: []\n", ":5: ", "cases"},
        {HEAD "cases:\n  - {method: leapfrogg}\n", ":6: ", "did you mean \"leapfrog\""},
        {HEAD "cases:\n  - {step: 1}\n", ":6: ", "method"},
        {HEAD "cases:\n  - {method: leapfrog, stpe: 0.1}\n", ":6: ", "did you mean \"step\""},
        {HEAD "cases:\n  - {method: leapfrog, step: []}\n", ":6: ", "a value or a list of values"},
        {HEAD "cases:\n  - {method: leapfrog, step: [0.1, [1]]}\n", ":6: ", "a value or a list"},
        {HEAD "cases:\n  - method: leapfrog\n    step:\n      - 0.1\n      - zero\n",
         ":9: ", "\"zero\""},
        {HEAD "cases:\n  - {method: leapfrog}\n  - {method: leapfrog, step: 0.03}\n",
         ":7: ", "a whole number of steps"},
        {HEAD "samples: 7\ncases:\n  - {method: leapfrog, step: 0.01}\n", ":7: ", "sample"},
        {HEAD CASE "  - {method: leapfrog, step: 0.01}\n", ":7: ", "first on line 6"},
        {HEAD CASE "sampels: 3\n", ":7: ", "did you mean \"samples\""},
        {HEAD CASE "limits: {seconds: 0}\n", ":7: ", "seconds"},
        {HEAD CASE "end: -1\n", ":7: ", "end"},
        {"scene: scene.yaml\nerror: 1\nin: energy\n" CASE, ":1: ", "name"},
        {"name: test\nscene: scene.yaml\nin: energy\n" CASE, ":1: ", "error"},
        {"name: test\nerror: 1\nin: energy\n" CASE, "", "either `scene` or `scenes`"},
        {"name: test\nscene: none.yaml\nerror: 1\nin: energy\n" CASE, ":2: ", "none.yaml"},
        {"name: test\nscenes: [scene.yaml, scene.yaml]\nerror: 1\nin: energy\n" CASE,
         ":2: ", "different names"},
        {POSITIONS CASE, "", "reference"},
        {POSITIONS "reference: {exact: keppler}\n" CASE, ":4: ", "kepler"},
        {POSITIONS "reference: {method: gsl-rk8pd}\n" CASE, ":4: ", "check"},
        {POSITIONS "reference: {method: gsl-rk8pd, exact: kepler}\n" CASE, ":4: ", "either"},
        {POSITIONS "reference: {method: gsl-rk8pd, check: {method: gsl-rk8pd}}\n" CASE,
         ":4: ", "another method or other options"},
        {POSITIONS "reference:\n  method: gsl-rk8pd\n  set: {rtoll: 1}\n"
                   "  check: {method: leapfrog}\n" CASE,
         ":6: ", "did you mean \"rtol\""},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        dl_study *study = (dl_study *)&bad;
        dl_error error = {""};
        char place[160];
        write_text(study_path, bad[i].text);
        const dl_status status = dl_study_read(study_path, &study, &error);
        snprintf(place, sizeof place, "%s%s", study_path, bad[i].line);
        if (status != DL_INPUT || study || !strstr(error.message, place) ||
            !strstr(error.message, bad[i].part))
            fail_msg("study %zu: status %s, message \"%s\", expected \"%s\" and \"%s\"", i,
                     dl_status_name(status), error.message, place, bad[i].part);
    }
}

static void help_names_every_key(void **state) {
    (void)state;
    static const char *const key[] = {"name",   "title",     "kind",  "question", "scene",
                                      "scenes", "end",       "error", "samples",  "in",
                                      "limits", "reference", "exact", "check",    "cases",
                                      "memory", "seconds",   "set",   "repeats",  "method"};
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    dl_study_help(out);
    assert_int_equal(fclose(out), 0);
    for (size_t i = 0; i < sizeof key / sizeof *key; i++)
        if (!strstr(text, key[i]))
            fail_msg("help lacks %s", key[i]);
    free(text);
}

/* RMS distance of two bodies from where they are to be. */
static double distance(const dl_scene *scene, const double *y, const double *expected) {
    double place[6];
    memcpy(place, expected, 2 * (size_t)scene->dimension * sizeof *place);
    return dl_reference_distance(scene, &(dl_reference){.position = place}, 0, y, NULL);
}

/* --- errors -------------------------------------------------------------------------------- */

static void errors_are_those_of_the_methods(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    dl_results *results = run_study(study, false);
    assert_int_equal(results->cases, 4);
    const dl_case *coarse = &results->cased[0], *fine = &results->cased[1];
    for (size_t i = 0; i < 4; i++) {
        assert_string_equal(results->cased[i].key, study->cased[i].key);
        assert_int_equal(results->cased[i].summary.status, DL_OK);
        assert_string_equal(results->cased[i].refused, "");
        assert_int_equal(results->cased[i].samples, 5);
        assert_int_equal(results->cased[i].repeats, 2);
        assert_true(results->cased[i].summary.cpu_seconds <= results->cased[i].cpu_median);
    }
    /* leap-frog is of order 2; the tight run agrees with the exact solution */
    assert_true(fabs(log2(coarse->position_error / fine->position_error) - 2) < 0.1);
    assert_true(results->cased[3].position_error < 2e-12);
    assert_true(results->cased[3].position_error > 0);
    assert_true(coarse->position_error_max >= coarse->position_error);
    assert_true(coarse->sample_position_error[0] < 1e-15);
    assert_true(coarse->sample_position_error[4] == coarse->position_error);
    assert_true(coarse->sample_time[4] == 2);
    assert_non_null(dl_results_fact(results, "compiler"));
    assert_non_null(dl_results_fact(results, "processor"));
    assert_non_null(dl_results_fact(results, "SUNDIALS"));
    assert_non_null(strstr(results->scene[0].text, "name: pair"));
    assert_true(strlen(results->scene[0].explain) > 0);
    dl_results_free(results);
    dl_study_free(study);
}

static double largest(const double *values, size_t count) {
    double found = 0;
    for (size_t i = 0; i < count; i++)
        found = fmax(found, values[i]);
    return found;
}

/* Momenta are kept over time where the scene conserves them: gravity takes the angular one, a pin
 * both. */
static void momenta_are_kept_as_far_as_they_are_conserved(void **state) {
    (void)state;
    static const struct {
        const char *more; /* of the scene */
        bool linear, angular;
    } scene[] = {
        {"{at: [0.3, 0], velocity: [0, 1.5], mass: 0.25}\n", true, true},
        {"{at: [0.3, 0], velocity: [0, 1.5], mass: 0.25}\ngravity: [0, -1]\n", true, false},
        {"{at: [0.3, 0], mass: 0.25, pinned: true}\n", false, false},
    };
    for (size_t k = 0; k < sizeof scene / sizeof *scene; k++) {
        char text[512];
        snprintf(text, sizeof text,
                 "name: pair\ndimension: 2\ntime: {step: 0.01, end: 2}\n"
                 "pair_law:\n  - {terms: [{coefficient: -1, power: 2}]}\nparticles:\n"
                 "  - {at: [-0.1, 0], velocity: [0, -0.5], mass: 0.75}\n  - %s",
                 scene[k].more);
        write_text(scene_path, text);
        dl_study *study = read_study("name: test\nscene: scene.yaml\nerror: 1\nin: energy\n"
                                     "samples: 4\ncases:\n  - {method: gsl-rk4}\n");
        dl_results *results = run_study(study, true);
        const dl_case *one = &results->cased[0];
        const dl_run_summary *run = &one->summary;
        assert_int_equal(run->status, DL_OK);
        assert_int_equal(one->samples, 5);
        assert_int_equal(one->sample_momentum_error != NULL, scene[k].linear);
        assert_int_equal(one->sample_angular_momentum_error != NULL, scene[k].angular);
        if (scene[k].linear)
            assert_true(largest(one->sample_momentum_error, 5) == run->momentum_error_max);
        if (scene[k].angular) {
            assert_true(run->angular_momentum_error_max > 0); /* not symplectic */
            assert_true(largest(one->sample_angular_momentum_error, 5) ==
                        run->angular_momentum_error_max);
        }
        dl_results_free(results);
        dl_study_free(study);
        unlink(results_path);
    }
}

static const char measured_study[] =
    "name: test\nscene: scene.yaml\nsamples: 4\nerror: 1e-4\nrepeats: 1\n"
    "reference:\n  method: gsl-rk8pd\n  set: {rtol: 1e-13, atol: 1e-13}\n"
    "  check: {method: composition-4-suzuki, set: {step: 0.01}}\n"
    "cases:\n  - {method: leapfrog, step: [0.01, 0.001]}\n"
    "  - {method: composition-8-kahan-li, step: 0.01}\n";

/* The reference's own error is its distance from the check, and what is smaller is marked. */
static void reference_measures_its_own_error(void **state) {
    (void)state;
    dl_study *study = read_study(measured_study);
    dl_results *results = run_study(study, false);
    double exact[4], check[8] = {0};
    const dl_reference *reference = dl_results_reference(results, "pair");
    assert_non_null(reference);
    assert_int_equal(reference->samples, 5);
    const dl_scene *scene = study->scene[0].scene;
    assert_int_equal(dl_kepler_position(scene, 2, exact, NULL, NULL), DL_OK);
    assert_true(distance(scene, exact, reference->position + 16) < 1e-11);
    dl_run_options options;
    dl_run_summary summary;
    dl_run_options_default(&options);
    assert_int_equal(dl_run(scene, study->scene[0].check.row, study->scene[0].check.options,
                            &options, &summary, check, NULL),
                     DL_OK);
    assert_true(reference->error == distance(scene, check, reference->position + 16));
    assert_true(reference->sample_error[0] == 0);
    assert_true(reference->sample_error[4] == reference->error);
    assert_string_equal(results->cased[0].refused, "");
    assert_non_null(strstr(results->cased[2].refused, "below a hundred times the reference's own"));
    assert_true(isfinite(results->cased[2].position_error));
    dl_results_free(results);
    dl_study_free(study);
}

/* Any masses, couplings, direction and drift, in three dimensions, through several periods. */
static void exact_motion_is_the_motion(void **state) {
    (void)state;
    static const char text[] = "name: tilted\ndimension: 3\nparticles:\n"
                               "  - {at: [1, 2, 3], velocity: [0.1, -0.2, 0.4], mass: 2, "
                               "inertia: 3}\n"
                               "  - {at: [1.4, 2.9, 2.5], velocity: [1.0, -0.5, 0.9], mass: 1.5, "
                               "inertia: 0.7}\n"
                               "pair_law:\n  - {terms: [{coefficient: -0.4, power: 2}]}\n"
                               "time: {step: 0.01, end: 20}\n";
    dl_scene *scene = NULL;
    dl_error error = {""};
    void *tolerance = NULL;
    const dl_method_row *row;
    dl_run_options options;
    dl_run_summary summary;
    double y[12], exact[6];
    write_text(scene_path, text);
    if (dl_scene_read(scene_path, &scene, &error) || dl_kepler_check(scene, &error))
        fail_msg("%s", error.message);
    assert_int_equal(dl_method_find("gsl-rk8pd", &row, NULL), DL_OK);
    assert_int_equal(dl_method_options_create(row, scene, &tolerance, NULL), DL_OK);
    assert_int_equal(dl_method_options_set(row, tolerance, "rtol", "1e-14", NULL), DL_OK);
    assert_int_equal(dl_method_options_set(row, tolerance, "atol", "1e-14", NULL), DL_OK);
    dl_run_options_default(&options);
    for (int i = 1; i <= 8; i++) {
        options.end = 2.5 * i;
        assert_int_equal(dl_run(scene, row, tolerance, &options, &summary, y, NULL), DL_OK);
        assert_int_equal(summary.status, DL_OK);
        assert_int_equal(dl_kepler_position(scene, options.end, exact, NULL, NULL), DL_OK);
        const double error_here = distance(scene, y, exact);
        if (!(error_here < 1e-11))
            fail_msg("at t = %g the distance is %g", options.end, error_here);
    }
    dl_method_options_free(row, tolerance);
    dl_scene_free(scene);
}

static void other_motions_are_no_kepler(void **state) {
    (void)state;
    static const struct {
        const char *text, *part;
    } bad[] = {
        {"particles: [{at: [0, 0], mass: 1}, {at: [1, 0], mass: 1}, {at: [2, 0], mass: 1}]\n"
         "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\n",
         "two"},
        {"particles: [{at: [0, 0], mass: 1}, {at: [1, 0], mass: 1}]\n"
         "pair_law: [{terms: [{coefficient: -1, power: 3}]}]\n",
         "pair law"},
        {"particles: [{at: [0, 0], mass: 1}, {at: [1, 0], mass: 1}]\n"
         "pair_law: [{until: 5, terms: [{coefficient: -1, power: 2}]}]\n",
         "pair law"},
        {"particles: [{at: [0, 0], mass: 1}, {at: [1, 0], mass: 1}]\ngravity: [0, -1]\n"
         "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\n",
         "gravity"},
        {"particles: [{at: [0, 0], mass: 1}, {at: [1, 0], velocity: [0, 5], mass: 1}]\n"
         "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\n",
         "bound"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char text[512];
        dl_study *study = NULL;
        dl_error error = {""};
        snprintf(text, sizeof text, "name: other\ndimension: 2\n%stime: {step: 0.01, end: 2}\n",
                 bad[i].text);
        write_text(scene_path, text);
        write_text(study_path, exact_study);
        assert_int_equal(dl_study_read(study_path, &study, &error), DL_INPUT);
        if (!strstr(error.message, bad[i].part) || !strstr(error.message, "exact"))
            fail_msg("scene %zu: \"%s\" lacks \"%s\"", i, error.message, bad[i].part);
    }
}

/* The first reason there is. */
static void judge(const dl_case *measured, const dl_reference *reference,
                  char reason[DL_MESSAGE_SIZE]) {
    dl_study_judge_run(measured, 2, 20, reason, DL_MESSAGE_SIZE);
    if (!*reason)
        dl_study_judge_position(measured, reference, reason, DL_MESSAGE_SIZE);
}

static void points_are_judged(void **state) {
    (void)state;
    const dl_reference reference = {.error = 1e-3};
    const dl_case good = {.position_error = 1,
                          .summary = {.t_end_reached = 2, .step = 0.01, .steps = 200}};
    char reason[DL_MESSAGE_SIZE];
    judge(&good, &reference, reason);
    assert_string_equal(reason, "");
    dl_case bad = good;
    bad.summary.steps = 100; /* as if the option had not been used */
    judge(&bad, &reference, reason);
    assert_non_null(strstr(reason, "100 steps of 0.01"));
    bad.summary.step = 0;
    bad.summary.steps = 59; /* fewer than three an interval */
    judge(&bad, &reference, reason);
    assert_non_null(strstr(reason, "the sampling, not the tolerance"));
    bad.summary.steps = 60;
    judge(&bad, &reference, reason);
    assert_string_equal(reason, "");
    bad = good;
    bad.summary.t_end_reached = 1;
    judge(&bad, &reference, reason);
    assert_non_null(strstr(reason, "ended at t = 1"));
    bad = good;
    bad.position_error = 0.099;
    judge(&bad, &reference, reason);
    assert_non_null(strstr(reason, "below a hundred times"));
    const dl_reference blind = {.error = 1e-9, .horizon = 1.5};
    judge(&good, &blind, reason);
    assert_non_null(strstr(reason, "past the horizon, t = 1.5"));
    judge(&bad, NULL, reason);
    assert_string_equal(reason, "");
}

/* --- stopping and going on ----------------------------------------------------------------- */

static dl_status refuse_to_run(const dl_scene *scene, const dl_method_row *row, const void *options,
                               const dl_run_options *run_options, dl_run_summary *summary,
                               double *y_final, dl_error *error) {
    (void)scene, (void)row, (void)options, (void)run_options, (void)y_final;
    memset(summary, 0, sizeof *summary);
    return dl_fail(error, DL_ERROR, "ran although it was not to");
}

static void assert_all_ok(const dl_study *study, const dl_results *results) {
    assert_int_equal(results->cases, study->cases);
    for (size_t i = 0; i < study->cases; i++) {
        assert_string_equal(results->cased[i].key, study->cased[i].key);
        if (results->cased[i].summary.status != DL_OK)
            fail_msg("case %zu: %s", i, results->cased[i].summary.message);
    }
}

static void finished_cases_are_kept(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    dl_results_free(run_study(study, false));
    study->run = refuse_to_run;
    dl_results *results = run_study(study, false);
    assert_all_ok(study, results);
    dl_results_free(results);
    results = run_study(study, true); /* forced, it does run */
    assert_int_equal(results->cased[0].summary.status, DL_ERROR);
    assert_non_null(strstr(results->cased[0].summary.message, "not to"));
    dl_results_free(results);
    dl_study_free(study);
}

static void only_what_is_missing_runs(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    dl_results_free(run_study(study, false));
    dl_study_free(study);
    char longer[1024];
    snprintf(longer, sizeof longer, "%s%s", exact_study,
             "  - {method: composition-4-suzuki, step: 0.01}\n");
    study = read_study(longer);
    study->run = refuse_to_run;
    dl_results *results = run_study(study, false);
    assert_int_equal(results->cases, 5);
    for (size_t i = 0; i < 5; i++)
        assert_int_equal(results->cased[i].summary.status, i < 4 ? DL_OK : DL_ERROR);
    dl_results_free(results);
    dl_study_free(study);
}

static void changed_scene_runs_again(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    dl_results_free(run_study(study, false));
    dl_study_free(study);
    write_scene("0.26");
    study = read_study(exact_study);
    study->run = refuse_to_run;
    dl_results *results = run_study(study, false);
    assert_int_equal(results->cases, 4);
    assert_int_equal(results->references, 1);
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(results->cased[i].summary.status, DL_ERROR);
    dl_results_free(results);
    dl_study_free(study);
}

/* Data files are content too: each part of a scene is in its hash. */
static void hash_covers_the_whole_scene(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    dl_scene *scene = study->scene[0].scene;
    double *const number[] = {&scene->position[3], &scene->velocity[0], &scene->inertia[1],
                              &scene->coupling[0]};
    bool *const flag[] = {&scene->pinned[1], &scene->feels_gravity[0]};
    const uint64_t hash = dl_scene_hash(scene);
    assert_true(hash == study->scene[0].hash);
    for (size_t i = 0; i < sizeof number / sizeof *number; i++) {
        const double was = *number[i];
        *number[i] = nextafter(was, INFINITY);
        assert_true(dl_scene_hash(scene) != hash);
        *number[i] = was;
    }
    for (size_t i = 0; i < sizeof flag / sizeof *flag; i++) {
        *flag[i] = !*flag[i];
        assert_true(dl_scene_hash(scene) != hash);
        *flag[i] = !*flag[i];
    }
    scene->text[0] = '#';
    assert_true(dl_scene_hash(scene) != hash);
    scene->text[0] = 'n';
    assert_true(dl_scene_hash(scene) == hash);
    dl_study_free(study);
}

static void results_of_another_study_are_left_alone(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    dl_results *results = run_study(study, false);
    const dl_study_options options = {.results = results_path};
    dl_error error = {""};
    dl_results *none = results;
    free(study->settings.name);
    study->settings.name = strdup("other");
    assert_int_equal(dl_study_run(study, &options, &none, &error), DL_INPUT);
    assert_null(none);
    assert_non_null(strstr(error.message, "\"test\""));
    assert_non_null(strstr(error.message, "\"other\""));
    free(study->settings.name);
    study->settings.name = strdup("test");
    /* times of another machine are not comparable */
    assert_int_equal(dl_results_add_fact(results, "processor", "abacus", NULL), DL_OK);
    assert_int_equal(dl_results_write(results, results_path, NULL), DL_OK);
    assert_int_equal(dl_study_run(study, &options, &none, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "abacus"));
    dl_results_free(run_study(study, true));
    dl_results_free(results);
    dl_study_free(study);
}

typedef struct stop_after {
    size_t done;
    volatile int interrupt;
    bool kill;
} stop_after;

static void stop(void *context, const dl_study_progress *progress) {
    stop_after *after = context;
    assert_int_equal(progress->total, 5);
    if (progress->done < after->done)
        return;
    if (after->kill)
        raise(SIGKILL);
    after->interrupt = 1;
}

static void killed_study_goes_on(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    for (size_t done = 0; done < 5; done += 2) {
        unlink(results_path);
        pid_t child = fork();
        if (child == 0) {
            stop_after after = {.done = done, .kill = true};
            const dl_study_options options = {
                .results = results_path, .on_progress = stop, .context = &after};
            dl_results *results;
            dl_study_run(study, &options, &results, NULL);
            _exit(EXIT_SUCCESS);
        }
        int ended = 0;
        assert_int_equal(waitpid(child, &ended, 0), child);
        assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
        dl_results *left = NULL, *results;
        dl_error error = {""};
        if (dl_results_read(results_path, &left, &error) != DL_OK)
            fail_msg("%s", error.message);
        assert_int_equal(left->references + left->cases, done);
        results = run_study(study, false);
        assert_all_ok(study, results);
        for (size_t i = 0; i < left->cases; i++) /* these were not run again */
            assert_true(results->cased[i].summary.cpu_seconds ==
                        left->cased[i].summary.cpu_seconds);
        dl_results_free(left);
        dl_results_free(results);
    }
    dl_study_free(study);
}

static void interrupted_study_goes_on(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    stop_after after = {.done = 2};
    const dl_study_options options = {.results = results_path,
                                      .on_progress = stop,
                                      .context = &after,
                                      .interrupt = &after.interrupt};
    dl_results *results = NULL, *left = NULL;
    dl_error error = {""};
    assert_int_equal(dl_study_run(study, &options, &results, &error), DL_INTERRUPTED);
    assert_non_null(strstr(error.message, "1 of 4 cases are kept"));
    assert_non_null(strstr(error.message, results_path));
    dl_results_free(results);
    assert_int_equal(dl_results_read(results_path, &left, NULL), DL_OK);
    assert_int_equal(left->cases, 1);
    dl_results_free(left);
    results = run_study(study, false);
    assert_all_ok(study, results);
    dl_results_free(results);
    dl_study_free(study);
}

/* --- cases that misbehave ------------------------------------------------------------------ */

static dl_status misbehave(const dl_scene *scene, const dl_method_row *row, const void *options,
                           const dl_run_options *run_options, dl_run_summary *summary,
                           double *y_final, dl_error *error) {
    if (strcmp(row->name, "leapfrog") == 0)
        for (volatile unsigned long i = 0;; i++)
            ; /* hangs, deaf to its own time limit */
    if (strcmp(row->name, "cvode-adams") == 0)
        abort();
    if (strcmp(row->name, "gsl-rkf45") == 0)
        _exit(3);
    if (strcmp(row->name, "gsl-msadams") == 0 && !run_options->observe)
        abort(); /* only in a repeat */
    return dl_run(scene, row, options, run_options, summary, y_final, error);
}

static void bad_cases_do_not_sink_a_study(void **state) {
    (void)state;
    dl_study *study =
        read_study("name: test\nscene: scene.yaml\nsamples: 4\nerror: 1e-4\nrepeats: 2\n"
                   "limits: {seconds: 0.1}\nreference: {exact: kepler}\ncases:\n"
                   "  - {method: leapfrog}\n  - {method: cvode-adams}\n"
                   "  - {method: gsl-rkf45}\n  - {method: gsl-msadams}\n"
                   "  - {method: composition-4-suzuki, step: 0.01}\n");
    static const struct {
        dl_status status;
        const char *part;
    } expected[] = {
        {DL_TIMEOUT, "0.1 CPU seconds"}, {DL_ERROR, "SIGABRT"}, {DL_ERROR, "exit status 3"},
        {DL_ERROR, "SIGABRT"},           {DL_OK, ""},
    };
    study->run = misbehave;
    dl_results *results = run_study(study, false);
    assert_int_equal(results->cases, 5);
    for (size_t i = 0; i < 5; i++) {
        const dl_case *cased = &results->cased[i];
        assert_int_equal(cased->summary.status, expected[i].status);
        assert_non_null(strstr(cased->summary.message, expected[i].part));
        assert_int_equal(*cased->refused != '\0', expected[i].status != DL_OK);
        assert_int_equal(isfinite(cased->position_error), expected[i].status == DL_OK);
    }
    char text[DL_MESSAGE_SIZE];
    dl_results_answer(results, "pair", text, sizeof text);
    assert_non_null(strstr(text, "composition-4-suzuki"));
    dl_results_free(results);
    dl_study_free(study);
}

/* A run that is slow but not deaf is stopped by its own limit and tells how far it came. */
static void slow_case_tells_how_far_it_came(void **state) {
    (void)state;
    dl_study *study = read_study("name: test\nscene: scene.yaml\nsamples: 4\nerror: 1e-4\n"
                                 "limits: {seconds: 0.2}\nreference: {exact: kepler}\ncases:\n"
                                 "  - {method: leapfrog, step: 1e-8}\n");
    dl_results *results = run_study(study, false);
    const dl_run_summary *run = &results->cased[0].summary;
    assert_int_equal(run->status, DL_TIMEOUT);
    assert_true(run->t_end_reached > 0 && run->t_end_reached < 2);
    assert_non_null(strstr(results->cased[0].refused, "timeout"));
    dl_results_free(results);
    dl_study_free(study);
}

#ifndef DL_SANITIZED
static void take_memory(void *context, int pipe) {
    (void)context;
    const bool refused = malloc((size_t)512 << 20) == NULL;
    dl_child_send(pipe, &refused, sizeof refused);
}

static dl_status receive_flag(void *context, const void *data, size_t size, dl_error *error) {
    (void)error;
    assert_int_equal(size, sizeof(bool));
    memcpy(context, data, size);
    return DL_OK;
}

static void memory_is_limited(void **state) {
    (void)state;
    bool refused = false;
    dl_child_work work = {.work = take_memory,
                          .receive = receive_flag,
                          .context = &refused,
                          .seconds = 5,
                          .memory = 256};
    assert_int_equal(dl_child_run(&work, NULL), DL_OK);
    assert_true(refused);
    work.memory = 4096;
    assert_int_equal(dl_child_run(&work, NULL), DL_OK);
    assert_false(refused);
}
#endif

static void failing_reference_stops_the_study(void **state) {
    (void)state;
    dl_study *study = read_study(measured_study);
    const dl_study_options options = {.results = results_path};
    dl_results *results = NULL;
    dl_error error = {""};
    study->run = refuse_to_run;
    assert_int_equal(dl_study_run(study, &options, &results, &error), DL_ERROR);
    assert_non_null(strstr(error.message, "the reference of pair failed: gsl-rk8pd"));
    assert_non_null(strstr(error.message, "not to"));
    assert_int_equal(results->references, 0);
    dl_results_free(results);
    dl_study_free(study);
}

static void unwritable_results_are_told_before_anything_runs(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    const dl_study_options options = {.results = "/nowhere/results.h5"};
    dl_results *results = NULL;
    dl_error error = {""};
    assert_int_equal(dl_study_run(study, &options, &results, &error), DL_IO);
    assert_non_null(strstr(error.message, "/nowhere/results.h5"));
    assert_null(results);
    dl_study_free(study);
}

/* flock acts between open files, also of one process. */
static void two_studies_do_not_write_one_file(void **state) {
    (void)state;
    dl_study *study = read_study(exact_study);
    char path[512];
    snprintf(path, sizeof path, "%s.locked", results_path);
    const dl_study_options options = {.results = path};
    dl_results *results = NULL;
    dl_error error = {""};
    dl_lock lock;
    assert_int_equal(dl_lock_take(&lock, path, &error), DL_OK);
    assert_int_equal(dl_study_run(study, &options, &results, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "another driftlab is writing"));
    assert_null(results);
    dl_lock_release(&lock);
    assert_int_equal(dl_study_run(study, &options, &results, &error), DL_OK);
    unlink(path);
    dl_results_free(results);
    dl_study_free(study);
}

static void studies_that_come_with_it_are_valid(void **state) {
    (void)state;
    static const char *const name[] = {"quickstart", "kepler", "stream", "drop", "swirl"};
    for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
        char path[512];
        dl_study *study = NULL;
        dl_error error = {""};
        snprintf(path, sizeof path, "%s/%s/study.yaml", DL_STUDIES, name[i]);
        if (dl_study_read(path, &study, &error) != DL_OK)
            fail_msg("%s", error.message);
        assert_string_equal(dl_study_name(study), name[i]);
        assert_true(dl_study_cases(study) > 20);
        dl_study_free(study);
    }
}

int main(void) {
#define CLEAN(test) cmocka_unit_test_setup(test, clean)
    const struct CMUnitTest tests[] = {
        CLEAN(lists_expand_in_order),
        CLEAN(bad_studies_are_refused),
        CLEAN(help_names_every_key),
        CLEAN(errors_are_those_of_the_methods),
        CLEAN(momenta_are_kept_as_far_as_they_are_conserved),
        CLEAN(reference_measures_its_own_error),
        CLEAN(exact_motion_is_the_motion),
        CLEAN(other_motions_are_no_kepler),
        CLEAN(points_are_judged),
        CLEAN(finished_cases_are_kept),
        CLEAN(only_what_is_missing_runs),
        CLEAN(changed_scene_runs_again),
        CLEAN(hash_covers_the_whole_scene),
        CLEAN(results_of_another_study_are_left_alone),
        CLEAN(killed_study_goes_on),
        CLEAN(interrupted_study_goes_on),
        CLEAN(bad_cases_do_not_sink_a_study),
        CLEAN(slow_case_tells_how_far_it_came),
#ifndef DL_SANITIZED
        CLEAN(memory_is_limited),
#endif
        CLEAN(failing_reference_stops_the_study),
        CLEAN(two_studies_do_not_write_one_file),
        CLEAN(unwritable_results_are_told_before_anything_runs),
        CLEAN(studies_that_come_with_it_are_valid),
    };
    if (!mkdtemp(folder))
        return EXIT_FAILURE;
    snprintf(study_path, sizeof study_path, "%s/study.yaml", folder);
    snprintf(scene_path, sizeof scene_path, "%s/scene.yaml", folder);
    snprintf(results_path, sizeof results_path, "%s/results.h5", folder);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(study_path);
    unlink(scene_path);
    unlink(results_path);
    rmdir(folder);
    return failed;
}
