/* References: their own error, growth and horizon; how a study makes, keeps, checks and improves
 * them; the command. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <hdf5.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "driftlab/reference.h"
#include "fixture_runs.h"
#include "fixture_scenes.h"
#include "study/kepler.h"
#include "study/measure.h"

static char folder[] = "/tmp/driftlab-reference-XXXXXX";
static char study_path[128], scene_path[128], results_path[128], output_path[128];

static void write_text(const char *path, const char *text) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fputs(text, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

static dl_reference compute(const dl_scene *scene, dl_precision precision, double wanted,
                            size_t intervals) {
    const dl_reference_request request = {.precision = precision,
                                          .end = scene->end,
                                          .intervals = intervals,
                                          .wanted = wanted,
                                          .seconds = 60,
                                          .memory = 4096};
    dl_reference made;
    dl_error error = {""};
    if (dl_reference_compute(scene, &request, &made, &error))
        fail_msg("%s: %s", scene->name, error.message);
    return made;
}

/* --- its own error ---------------------------------------------------------------------------- */

/* From the exact motion, at a sample. */
static double off_exact(const dl_scene *scene, const dl_reference *reference, size_t sample) {
    double high[4], low[4];
    assert_int_equal(dl_kepler_position(scene, reference->time[sample], high, low, NULL), DL_OK);
    const dl_reference exact = {.position = high, .position_low = low};
    double place[4], square = 0;
    for (size_t k = 0; k < 4; k++) {
        place[k] = reference->position[4 * sample + k];
        const double d = (place[k] - high[k]) + (reference->position_low[4 * sample + k] - low[k]);
        square += d * d;
    }
    assert_true(dl_reference_distance(scene, &exact, 0, place, NULL) < 1e-14);
    return sqrt(square / 2);
}

static void own_error_is_that_of_the_exact_motion(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0.9);
    scene->end = 40;
    for (int quad = 0; quad <= 1; quad++) {
        dl_reference made =
            compute(scene, quad ? DL_PRECISION_QUAD : DL_PRECISION_LONG_DOUBLE, 0, 8);
        const double limit = quad ? 1e-27 : 1e-13;
        assert_string_equal(made.precision, quad ? "quad" : "long double");
        assert_true(made.sample_error[0] == 0 && made.error == made.sample_error[8]);
        for (size_t i = 1; i < made.samples; i++) {
            const double off = off_exact(scene, &made, i);
            if (!(off < 3 * made.sample_error[i] && made.sample_error[i] < limit))
                fail_msg("%s, t = %g: off by %.2g, own error %.2g", made.precision, made.time[i],
                         off, made.sample_error[i]);
            assert_true(made.sample_error[i] >= made.sample_error[i - 1]);
        }
        dl_reference_release(&made);
    }
    dl_scene_free(scene);
}

static void precision_follows_what_is_wanted(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0.6);
    scene->end = 10;
    dl_reference plain = compute(scene, DL_PRECISION_AUTO, 1e-15, 2);
    dl_reference quad = compute(scene, DL_PRECISION_AUTO, 1e-20, 2);
    assert_string_equal(plain.precision, "long double");
    assert_string_equal(quad.precision, "quad");
    assert_true(plain.error < 1e-15 && quad.error < 1e-20);
    assert_string_equal(quad.note, "");
    dl_reference_release(&plain);
    dl_reference_release(&quad);
    dl_scene_free(scene);
}

/* Where quad precision would take too long, the one in long double stays and says so. */
static void limits_are_told(void **state) {
    (void)state;
    char text[DL_MESSAGE_SIZE];
    const dl_reference fast = {.seconds = 0.01}, slow = {.seconds = 10};
    assert_false(dl_reference_quad_is_too_slow(&fast, 60, text, sizeof text));
    assert_true(dl_reference_quad_is_too_slow(&slow, 60, text, sizeof text));
    assert_non_null(strstr(text, "6e+02 CPU seconds, the limit is 60"));
    dl_scene *scene = fixture_kepler(0.99);
    scene->end = 1e6;
    const dl_reference_request request = {.precision = DL_PRECISION_LONG_DOUBLE,
                                          .end = 1e6,
                                          .intervals = 1,
                                          .seconds = 0.05,
                                          .memory = 4096};
    dl_reference made;
    dl_error error = {""};
    assert_int_equal(dl_reference_compute(scene, &request, &made, &error), DL_TIMEOUT);
    assert_non_null(strstr(error.message, "Taylor series in long double: the limit of 0.05 CPU"));
    dl_scene_free(scene);
}

/* --- growth and horizon ----------------------------------------------------------------------- */

/* At rest between two pinned bodies that attract by 1/r^2 from a distance of 1: a = 4 x along them,
 * so that a displacement grows as exp(2 t). */
static dl_scene *saddle(double end) {
    dl_scene *scene = fixture_scene("saddle", 2, 3);
    fixture_law(scene, INFINITY, 1, 2, 0, 1);
    for (size_t i = 0; i < 3; i++)
        fixture_place(scene, i, (double[3]){(double)i, 0}, (double[3]){0, 0});
    scene->pinned[0] = scene->pinned[2] = true;
    scene->end = end;
    return scene;
}

static void exponent_is_that_of_the_saddle(void **state) {
    (void)state;
    dl_scene *scene = saddle(12);
    dl_reference made = compute(scene, DL_PRECISION_LONG_DOUBLE, 0, 6);
    assert_true(fabs(made.lyapunov - 2) < 1e-4 && made.lyapunov_error < 1e-4);
    assert_true(made.lyapunov_error > 0);
    assert_true(dl_reference_grows(&made));
    assert_true(made.growth[0] == 0);
    assert_true(fabs(made.growth[6] - made.growth[3] - 2 * 6) < 1e-3);
    assert_true(made.length == 1 && made.horizon == 0 && made.parted == 0);
    dl_reference_release(&made);
    dl_scene_free(scene);
}

static void regular_motion_has_no_horizon(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0.3);
    scene->end = 200;
    dl_reference made = compute(scene, DL_PRECISION_LONG_DOUBLE, 0, 4);
    assert_true(fabs(made.lyapunov) < 0.02); /* log(t)/t */
    assert_false(dl_reference_grows(&made));
    assert_true(made.horizon == 0);
    dl_reference_release(&made);
    dl_scene_free(scene);
}

/* Rounding, 1.1e-16, grows to 1 % when exp(2 t) does: from about 16 on. The reference does not lose
 * the body, which stays where it is by symmetry. */
static void horizon_is_where_rounding_has_grown(void **state) {
    (void)state;
    dl_scene *scene = saddle(24);
    dl_reference made = compute(scene, DL_PRECISION_LONG_DOUBLE, 0, 24);
    const double start = made.growth[3] - 2 * 3; /* what the direction has made of it */
    const double expected = (log(0.01 / 1.11e-16 / sqrt(0.5)) - start) / 2;
    assert_true(fabs(made.horizon - expected) < 1);
    for (size_t i = 0; i < made.samples; i++) {
        assert_int_equal(dl_reference_is_past(&made, i), made.time[i] >= made.horizon);
        assert_int_equal(dl_reference_shows(&made, i, 1), made.time[i] < made.horizon);
    }
    dl_reference_release(&made);
    dl_scene_free(scene);
}

/* Four particles that repel each other in a box, chaos with events: the references themselves part,
 * later in quad precision, and both tell the same exponent and nearly the same horizon. */
static void references_part(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(
        "name: box\ndimension: 2\nparticles:\n"
        "  - {at: [0, 0], velocity: [1, -0.5]}\n  - {at: [0.6, 0], velocity: [1, -0.5]}\n"
        "  - {at: [0.1, 0.5], velocity: [1, -0.5]}\n  - {at: [0.7, 0.55], velocity: [1, -0.5]}\n"
        "pair_law: [{terms: [{coefficient: 0.1, power: 3}]}]\n"
        "walls: {x: [0, 1], y: [0, 1], rule: located}\ntime: {step: 0.01, end: 24}\n");
    dl_reference plain = compute(scene, DL_PRECISION_LONG_DOUBLE, 0, 24);
    assert_true(plain.parted > 15 && plain.parted < 24);
    assert_true(plain.horizon > 10 && plain.horizon < plain.parted);
    assert_true(plain.lyapunov > 1.5 && plain.lyapunov < 2.5);
    scene->end = 20;
    dl_reference quad = compute(scene, DL_PRECISION_QUAD, 0, 20);
    assert_true(quad.parted == 0 && quad.error < 1e-14);
    assert_true(fabs(quad.horizon - plain.horizon) < 3);
    dl_reference_release(&plain);
    dl_reference_release(&quad);
    dl_scene_free(scene);
}

/* --- in a study ------------------------------------------------------------------------------- */

static const char scene_text[] = "name: pair\ndimension: 2\nparticles:\n"
                                 "  - {at: [-0.1, 0], velocity: [0, -0.5], mass: 0.75}\n"
                                 "  - {at: [0.3, 0], velocity: [0, 1.5], mass: 0.25}\n"
                                 "pair_law:\n  - {terms: [{coefficient: -1, power: 2}]}\n"
                                 "time: {step: 0.01, end: 2}\n";

#define STUDY(extended)                                                                            \
    "name: test\nscene: scene.yaml\nsamples: 4\nerror: 1e-4\nrepeats: 1\n"                         \
    "reference: {extended: " extended "}\ncases:\n  - {method: leapfrog, step: [0.01, 0.005]}\n"

static int clean(void **state) {
    (void)state;
    unlink(results_path);
    write_text(scene_path, scene_text);
    return 0;
}

static dl_study *read_study(const char *text) {
    dl_study *study = NULL;
    dl_error error = {""};
    write_text(study_path, text);
    if (dl_study_read(study_path, &study, &error))
        fail_msg("%s", error.message);
    return study;
}

static dl_results *run_study(const dl_study *study, bool force) {
    const dl_study_options options = {.results = results_path, .force = force};
    dl_results *results = NULL;
    dl_error error = {""};
    if (dl_study_run(study, &options, &results, &error))
        fail_msg("%s", error.message);
    return results;
}

/* Marks the stored reference so that one that was computed again can be told from it. */
static void mark(void) {
    dl_results *results = NULL;
    assert_int_equal(dl_results_read(results_path, &results, NULL), DL_OK);
    dl_reference *kept = &results->reference[0];
    kept->seconds = 12345;
    free(kept->digest);
    kept->digest = dl_reference_digest(kept);
    assert_int_equal(dl_results_write(results, results_path, NULL), DL_OK);
    dl_results_free(results);
}

static bool is_marked(const dl_results *results) {
    return results->reference[0].seconds == 12345;
}

static void reference_is_kept(void **state) {
    (void)state;
    dl_study *study = read_study(STUDY("long-double"));
    dl_results *results = run_study(study, false);
    assert_true(
        fabs(log2(results->cased[0].position_error / results->cased[1].position_error) - 2) < 0.1);
    dl_results_free(results);
    dl_study_free(study);
    mark();
    /* again, forced, and with another case */
    study = read_study(STUDY("long-double") "  - {method: leapfrog, step: 0.0025}\n");
    for (int force = 0; force <= 1; force++) {
        results = run_study(study, force == 1);
        assert_true(is_marked(results));
        assert_int_equal(results->cases, 3);
        dl_results_free(results);
    }
    dl_study_free(study);
    /* of another precision, or of another scene */
    study = read_study(STUDY("quad"));
    results = run_study(study, false);
    assert_false(is_marked(results));
    assert_string_equal(results->reference[0].precision, "quad");
    dl_results_free(results);
    dl_study_free(study);
}

/* One bit of one number of what was kept: it is computed anew. */
static void damaged_reference_is_not_trusted(void **state) {
    (void)state;
    dl_study *study = read_study(STUDY("long-double"));
    dl_results_free(run_study(study, false));
    dl_results *results = NULL;
    for (int what = 0; what < 4; what++) {
        mark();
        assert_int_equal(dl_results_read(results_path, &results, NULL), DL_OK);
        dl_reference *kept = &results->reference[0];
        double *const number[] = {&kept->position[7], &kept->position_low[3],
                                  &kept->sample_error[2], &kept->error};
        *number[what] = nextafter(*number[what], 1);
        assert_int_equal(dl_results_write(results, results_path, NULL), DL_OK);
        dl_results_free(results);
        results = run_study(study, false);
        assert_false(is_marked(results));
        dl_results_free(results);
    }
    dl_study_free(study);
}

/* Long double first; a case that it does not resolve brings quad precision, and is measured
 * against that. */
static void case_that_is_too_good_brings_quad_precision(void **state) {
    (void)state;
    dl_study *study = read_study(STUDY("auto"));
    dl_results *results = run_study(study, false);
    assert_string_equal(results->reference[0].precision, "long double");
    dl_results_free(results);
    dl_study_free(study);
    /* a result of before that is better than long double can tell */
    assert_int_equal(dl_results_read(results_path, &results, NULL), DL_OK);
    const double before = results->cased[1].position_error;
    results->cased[0].position_error = 50 * results->reference[0].error;
    results->cased[0].summary.steps = 7;
    assert_int_equal(dl_results_write(results, results_path, NULL), DL_OK);
    dl_results_free(results);
    study = read_study(STUDY("auto"));
    results = run_study(study, false);
    assert_string_equal(results->reference[0].precision, "quad");
    assert_true(results->reference[0].error < 1e-30);
    assert_int_equal(results->cases, 2);
    assert_int_equal(results->cased[0].summary.steps, 200); /* run again */
    assert_true(results->cased[1].position_error == before);
    for (size_t i = 0; i < 2; i++)
        assert_string_equal(results->cased[i].refused, "");
    dl_results_free(results);
    results = run_study(study, false); /* and kept */
    assert_string_equal(results->reference[0].precision, "quad");
    dl_results_free(results);
    dl_study_free(study);
}

static void errors_past_the_horizon_are_none(void **state) {
    (void)state;
    write_text(scene_path,
               "name: saddle\ndimension: 2\nparticles:\n"
               "  - {at: [0, 0], pinned: true}\n  - {at: [1, 0]}\n  - {at: [2, 0], pinned: true}\n"
               "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\ntime: {step: 0.01, end: 24}\n");
    dl_study *study = read_study(STUDY("long-double"));
    dl_results *results = run_study(study, false);
    assert_true(results->reference[0].horizon > 0);
    for (size_t i = 0; i < results->cases; i++)
        assert_non_null(strstr(results->cased[i].refused, "past the horizon"));
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    dl_results_print(results, out);
    assert_int_equal(fclose(out), 0);
    assert_non_null(strstr(text, "largest Lyapunov exponent: 2 "));
    assert_non_null(strstr(text, "horizon: t = 1"));
    assert_non_null(strstr(text, "   horizon! "));
    assert_non_null(strstr(text, "nothing reached"));
    free(text);
    dl_results_free(results);
    dl_study_free(study);
}

static void collision_is_told(void **state) {
    (void)state;
    write_text(scene_path, "name: crash\ndimension: 2\nparticles: [{at: [0, 0]}, {at: [1, 0]}]\n"
                           "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\n"
                           "time: {step: 0.01, end: 2}\n");
    dl_study *study = read_study(STUDY("auto"));
    const dl_study_options options = {.results = results_path};
    dl_results *results = NULL;
    dl_error error = {""};
    assert_int_not_equal(dl_study_run(study, &options, &results, &error), DL_OK);
    assert_non_null(strstr(error.message, "the reference of crash failed: Taylor series in long "
                                          "double: "));
    assert_non_null(strstr(error.message, "t = 0.785"));
    dl_results_free(results);
    dl_study_free(study);
}

/* A file of a program that knew no digest: readable, its reference computed anew. */
static void older_files_are_read(void **state) {
    (void)state;
    static const char *const later[] = {"digest",   "precision",      "note",   "seconds", "length",
                                        "lyapunov", "lyapunov_error", "parted", "horizon"};
    dl_study *study = read_study(STUDY("long-double"));
    dl_results_free(run_study(study, false));
    const hid_t file = H5Fopen(results_path, H5F_ACC_RDWR, H5P_DEFAULT);
    const hid_t group = H5Gopen2(file, "/references/0000", H5P_DEFAULT);
    for (size_t i = 0; i < sizeof later / sizeof *later; i++)
        assert_true(H5Adelete(group, later[i]) >= 0);
    assert_true(H5Ldelete(group, "growth", H5P_DEFAULT) >= 0);
    assert_true(H5Ldelete(group, "position_low", H5P_DEFAULT) >= 0);
    H5Gclose(group);
    H5Fclose(file);
    dl_results *results = NULL;
    dl_error error = {""};
    if (dl_results_read(results_path, &results, &error))
        fail_msg("%s", error.message);
    assert_string_equal(results->reference[0].precision, "");
    assert_true(results->reference[0].horizon == 0);
    dl_results_free(results);
    results = run_study(study, false);
    assert_string_equal(results->reference[0].precision, "long double");
    dl_results_free(results);
    dl_study_free(study);
}

/* --- the command ------------------------------------------------------------------------------ */

static int command(const char *arguments, char *output, size_t size) {
    char line[1024];
    snprintf(line, sizeof line, "%s reference %s > %s 2>&1", DL_PROGRAM, arguments, output_path);
    const int status = system(line);
    FILE *in = fopen(output_path, "r");
    assert_non_null(in);
    output[fread(output, 1, size - 1, in)] = '\0';
    fclose(in);
    unlink(output_path);
    return WEXITSTATUS(status);
}

static void command_compares_with_what_is_published(void **state) {
    (void)state;
    char output[8192];
    const char *published = DL_STUDIES "/published/";
    char arguments[512];
    snprintf(arguments, sizeof arguments,
             "%spleiades.yaml --samples 1 --precision long-double --published %sdata/pleiades.csv",
             published, published);
    assert_int_equal(command(arguments, output, sizeof output), 0);
    assert_non_null(strstr(output, "of 28 published numbers agree to the last digit"));
    assert_true(strtod(strstr(output, "largest difference") + 19, NULL) < 1e-14);
    snprintf(arguments, sizeof arguments,
             "%sdetest-c5.yaml --samples 1 --precision long-double --relative-to 1 --published "
             "%sdata/detest-c5.csv",
             published, published);
    assert_int_equal(command(arguments, output, sizeof output), 0);
    assert_non_null(strstr(output, "largest difference 9.7")); /* e-14 */
    snprintf(arguments, sizeof arguments,
             "%s/exact/oscillator.yaml --samples 1 --precision quad --published "
             "%s/exact/data/oscillator.csv",
             DL_STUDIES, DL_STUDIES);
    assert_int_equal(command(arguments, output, sizeof output), 0);
    assert_non_null(strstr(output, "8 of 8 published numbers agree to the last digit"));
    snprintf(arguments, sizeof arguments,
             "%s/exact/kepler-0.9.yaml --t-end 10 --samples 2 --precision quad --kepler --state",
             DL_STUDIES);
    assert_int_equal(command(arguments, output, sizeof output), 0);
    assert_non_null(strstr(output, "from exact"));
    assert_non_null(strstr(output, "e-3")); /* after one orbit and a half: 30 digits */
}

static void command_refuses_what_it_cannot_compare(void **state) {
    (void)state;
    static const struct {
        const char *text, *message;
    } bad[] = {
        {"particle,x,w\n1,2,3\n", ":1: found \"w\""},
        {"x,y\n1,2\n", ":1: found \"x\", expected a column"},
        {"particle,x\n3,2\n", ":2: found \"3\""},
        {"particle,x\n1,two\n", ":2: found \"two\", expected a number"},
        {"particle,x\n1\n", ":2: found \"1\", expected as many"},
        {"particle,x\n", "found no numbers"},
    };
    char output[4096], arguments[512];
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        write_text(study_path, bad[i].text);
        snprintf(arguments, sizeof arguments, "%s --t-end 0.1 --samples 1 --published %s",
                 scene_path, study_path);
        assert_int_equal(command(arguments, output, sizeof output), 2);
        if (!strstr(output, bad[i].message))
            fail_msg("\"%s\" lacks \"%s\"", output, bad[i].message);
    }
    snprintf(arguments, sizeof arguments, "%s --relative-to 1", scene_path);
    assert_int_equal(command(arguments, output, sizeof output), 2);
    snprintf(arguments, sizeof arguments, "%s/exact/ball.yaml --kepler", DL_STUDIES);
    assert_int_equal(command(arguments, output, sizeof output), 2);
    assert_non_null(strstr(output, "expected two"));
}

/* Scenes of the literature say themselves without a line of C. */
static void published_scenes_are_what_they_say(void **state) {
    (void)state;
    static const struct {
        const char *name;
        size_t particles;
        double energy, accuracy;
    } expected[] = {
        {"argon", 7, -1260.2 * 1.380658e-23, 0.05 * 1.380658e-23}, /* HLW, I.4 */
        {"figure-eight", 3, -1.287146, 1e-5},
        {"outer-solar-system", 6, NAN, 0},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        char path[512];
        snprintf(path, sizeof path, "%s/published/%s.yaml", DL_STUDIES, expected[i].name);
        dl_scene *scene = read_scene(path);
        dl_model *model = NULL;
        dl_energy energy;
        assert_int_equal(scene->particles, expected[i].particles);
        assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
        double *y = calloc(2 * model->unknowns, sizeof *y);
        assert_non_null(y);
        dl_model_initial_state(model, y);
        assert_int_equal(dl_model_energy(model, y, &energy, NULL), DL_OK);
        if (isfinite(expected[i].energy))
            assert_true(fabs(energy.total - expected[i].energy) < expected[i].accuracy);
        free(y);
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

int main(void) {
#define CLEAN(test) cmocka_unit_test_setup(test, clean)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(own_error_is_that_of_the_exact_motion),
        cmocka_unit_test(precision_follows_what_is_wanted),
        cmocka_unit_test(limits_are_told),
        cmocka_unit_test(exponent_is_that_of_the_saddle),
        cmocka_unit_test(regular_motion_has_no_horizon),
        cmocka_unit_test(horizon_is_where_rounding_has_grown),
        cmocka_unit_test(references_part),
        CLEAN(reference_is_kept),
        CLEAN(damaged_reference_is_not_trusted),
        CLEAN(case_that_is_too_good_brings_quad_precision),
        CLEAN(errors_past_the_horizon_are_none),
        CLEAN(collision_is_told),
        CLEAN(older_files_are_read),
        CLEAN(command_compares_with_what_is_published),
        CLEAN(command_refuses_what_it_cannot_compare),
        cmocka_unit_test(published_scenes_are_what_they_say),
    };
    if (!mkdtemp(folder))
        return EXIT_FAILURE;
    snprintf(study_path, sizeof study_path, "%s/study.yaml", folder);
    snprintf(scene_path, sizeof scene_path, "%s/scene.yaml", folder);
    snprintf(results_path, sizeof results_path, "%s/results.h5", folder);
    snprintf(output_path, sizeof output_path, "%s/output", folder);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(study_path);
    unlink(scene_path);
    unlink(results_path);
    rmdir(folder);
    return failed;
}
