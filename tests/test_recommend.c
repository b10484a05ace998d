/* driftlab recommend: what it recommends is run here, against what is known of the scene. */
#include "fixture_program.h"

#include <sys/wait.h>
#include <time.h>
#include <unistd.h>
#include "driftlab/recommend.h"
#include "driftlab/reference.h"
#include "study/kepler.h"
#include "study/recommend.h"

#define KEPLER DL_STUDIES "/kepler/kepler.yaml"

/* A member by its way: "recommended.measured.error". */
static const json_t *member(const json_t *root, const char *way) {
    char name[64];
    for (const char *at = way; *at && root;) {
        const size_t length = strcspn(at, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        root = json_object_get(root, name);
        at += length + (at[length] == '.');
    }
    if (!root)
        fail_msg("there is no %s", way);
    return root;
}

static double real_of(const json_t *root, const char *way) {
    const json_t *value = member(root, way);
    if (!json_is_number(value))
        fail_msg("%s is no number", way);
    return json_number_value(value);
}

static const char *text_of(const json_t *root, const char *way) {
    const json_t *value = member(root, way);
    if (!json_is_string(value))
        fail_msg("%s is no string", way);
    return json_string_value(value);
}

static void expect_near(double value, double wanted, double relative) {
    if (!(fabs(value - wanted) <= relative * fabs(wanted)))
        fail_msg("found %.17g, expected %.17g", value, wanted);
}

/* --- positions ---------------------------------------------------------------------------------
 */

/* RMS position error at `end` against Kepler's solution. */
static double kepler_error(const char *method, const char *setting, double end) {
    dl_scene *scene = read_scene(KEPLER);
    const dl_method_row *row = method_of(method);
    void *options = options_of(row, scene, setting);
    dl_run_options how;
    dl_run_summary summary;
    dl_error error = {""};
    double y[8], exact[4], low[4];
    dl_run_options_default(&how);
    how.end = end;
    how.sample = end;
    assert_int_equal(dl_run(scene, row, options, &how, &summary, y, &error), DL_OK);
    assert_int_equal(summary.status, DL_OK);
    assert_int_equal(dl_kepler_position(scene, end, exact, low, &error), DL_OK);
    const double distance = dl_position_distance(scene, y, exact, NULL);
    dl_method_options_free(row, options);
    dl_scene_free(scene);
    return distance;
}

static void recommended_step_reaches_the_error(void **state) {
    (void)state;
    json_t *root = object_of("recommend " KEPLER " --error 1e-6 --t-end 20 --json --methods "
                             "composition-4-suzuki,rkn-6-blanes-moan-14,leapfrog",
                             0);
    const char *method = text_of(root, "recommended.method");
    const double end = real_of(root, "measured_to");
    expect_near(real_of(root, "end"), 20, 0);
    expect_near(end, 20, 0);
    assert_string_equal(method, "rkn-6-blanes-moan-14"); /* a tenth of the others' forces */
    const double error = kepler_error(method, text_of(root, "recommended.measured.setting"), end);
    const double coarse = kepler_error(method, text_of(root, "recommended.coarser.setting"), end);
    const double fine = kepler_error(method, text_of(root, "recommended.finer.setting"), end);
    assert_true(error <= 1e-6 && error > 1e-7);
    assert_true(coarse > 1e-6);
    assert_true(fine < error);
    expect_near(real_of(root, "recommended.measured.error"), error, 1e-3);
    expect_near(real_of(root, "recommended.coarser.error"), coarse, 1e-3);
    /* The next one coarser was near. */
    assert_true(real_of(root, "recommended.measured.steps") <
                2 * real_of(root, "recommended.coarser.steps"));
    const json_t *others = member(root, "runners_up");
    double before = 1;
    for (size_t i = 0; i < json_array_size(others); i++) {
        const json_t *other = json_array_get(others, i);
        assert_true(real_of(other, "times_the_cheapest") >= before);
        assert_true(real_of(other, "measured.error") <= 1e-6);
        before = real_of(other, "times_the_cheapest");
    }
    assert_int_equal(json_array_size(others) + json_array_size(member(root, "left_out")), 2);
    json_decref(root);
}

/* Of one method, whose counts and errors repeat. */
static void text_says_what_json_says(void **state) {
    (void)state;
    const char *arguments = "recommend " KEPLER " --error 1e-5 --t-end 10 --methods "
                            "rkn-4-blanes-moan";
    char words[400];
    snprintf(words, sizeof words, "%s --json", arguments);
    json_t *root = object_of(words, 0);
    const outcome *o = driftlab(arguments);
    assert_int_equal(o->exit, 0);
    snprintf(words, sizeof words, "recommended: rkn-4-blanes-moan with %s\n",
             text_of(root, "recommended.measured.setting"));
    assert_non_null(strstr(o->out, words));
    snprintf(words, sizeof words, "error %.2e, which does not reach it",
             real_of(root, "recommended.coarser.error"));
    assert_non_null(strstr(o->out, words));
    snprintf(words, sizeof words, " %.0f forces, %.0f steps",
             real_of(root, "recommended.measured.force_evaluations"),
             real_of(root, "recommended.measured.steps"));
    assert_non_null(strstr(o->out, words));
    assert_non_null(strstr(o->out, text_of(root, "recommended.command")));
    json_decref(root);
}

/* Three bodies of masses 3, 4, 5 from rest: after t = 60 rounding is all. */
static void horizon_shortens_the_run(void **state) {
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/burrau.yaml", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("name: burrau\n"
          "dimension: 2\n"
          "particles:\n"
          "  - {at: [1, 3], velocity: [0, 0], mass: 3}\n"
          "  - {at: [-2, -1], velocity: [0, 0], mass: 4}\n"
          "  - {at: [1, -1], velocity: [0, 0], mass: 5}\n"
          "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\n"
          "time: {step: 0.001, end: 80}\n",
          file);
    fclose(file);
    json_t *root = object_of("recommend burrau.yaml --error 1e-6 --json --methods gsl-rk8pd", 0);
    const double horizon = real_of(root, "horizon");
    assert_true(horizon > 0 && horizon <= 80);
    assert_true(real_of(root, "measured_to") < horizon);
    assert_non_null(strstr(text_of(root, "error_of_measured_run_only"), "horizon"));
    assert_true(json_is_null(member(root, "recommended.expected.error")));
    assert_true(real_of(root, "recommended.measured.error") <= 1e-6);
    expect_near(real_of(root, "recommended.expected.force_evaluations"),
                real_of(root, "recommended.measured.force_evaluations") * 80 /
                    real_of(root, "measured_to"),
                1e-9);
    json_decref(root);
}

/* --- energy ------------------------------------------------------------------------------------
 */

/* What `driftlab run` says of the energy with the command recommended. */
static double energy_error(const char *command) {
    char arguments[2000];
    assert_int_equal(strncmp(command, "driftlab ", strlen("driftlab ")), 0);
    snprintf(arguments, sizeof arguments, "%s --json", command + strlen("driftlab "));
    json_t *root = object_of(arguments, 0);
    const double error = real_of(root, "energy_error_max") / real_of(root, "energy_scale");
    json_decref(root);
    return error;
}

static void energy_error_is_reached(void **state) {
    (void)state;
    json_t *root = object_of("recommend " KEPLER " --error 1e-6 --in energy --json --methods "
                             "rkn-4-blanes-moan,conserving-relaxed",
                             0);
    const double error = energy_error(text_of(root, "recommended.command"));
    assert_string_equal(text_of(root, "recommended.method"), "rkn-4-blanes-moan");
    assert_true(error <= 1e-6);
    expect_near(real_of(root, "recommended.measured.error"), error, 1e-6);
    assert_true(real_of(root, "recommended.coarser.error") > 1e-6);
    assert_true(json_is_null(member(root, "reference_error")));
    /* Conserving energy at any step, with no longer one than the scene's. Without KINSOL, whose 7.5
     * formats a message at every iteration and so takes ten times as long. */
    const json_t *other = json_array_get(member(root, "runners_up"), 0);
    assert_string_equal(text_of(other, "method"), "conserving-relaxed");
    dl_scene *scene = read_scene(KEPLER);
    assert_true(real_of(other, "options.step") <= scene->step * (1 + 1e-9));
    dl_scene_free(scene);
    json_decref(root);
}

/* The error of a method that is not symplectic is taken to grow with time. */
static void short_run_is_asked_for_less(void **state) {
    (void)state;
    json_t *root = object_of("recommend " KEPLER " --error 1e-4 --in energy --t-end 62831853 "
                             "--seconds 1 --json --methods gsl-rk8pd,rkn-4-blanes-moan",
                             0);
    const double times = real_of(root, "end") / real_of(root, "measured_to");
    assert_true(times > 10);
    const json_t *found = member(root, "recommended"), *others = member(root, "runners_up");
    for (size_t i = 0; i <= json_array_size(others); i++) {
        const json_t *one = i == 0 ? found : json_array_get(others, i - 1);
        const bool grows = strcmp(text_of(one, "method"), "gsl-rk8pd") == 0;
        const double growth = grows ? times : 1;
        expect_near(real_of(one, "asked"), 1e-4 / growth, 1e-9);
        assert_true(real_of(one, "measured.error") <= real_of(one, "asked"));
        expect_near(real_of(one, "expected.error") / real_of(one, "measured.error"), growth, 1e-9);
        expect_near(real_of(one, "expected.cpu_seconds") / real_of(one, "measured.cpu_seconds"),
                    times, 1e-9);
    }
    json_decref(root);
}

/* Where a force jumps, an error may be small by chance: a finer run must have it too. */
static void answer_is_confirmed(void **state) {
    (void)state;
    static const char *const errors[] = {"1e-4", "1e-5", "1e-6"};
    for (size_t i = 0; i < sizeof errors / sizeof *errors; i++) {
        char arguments[400];
        snprintf(arguments, sizeof arguments,
                 "recommend " DL_STUDIES "/swirl/swirl.yaml --t-end 0.005 --in energy --json "
                 "--methods rkn-4-blanes-moan --error %s",
                 errors[i]);
        json_t *root = object_of(arguments, 0);
        const double error = real_of(root, "asked_error");
        assert_true(real_of(root, "recommended.measured.error") <= error);
        assert_true(real_of(root, "recommended.finer.error") <= error);
        assert_true(real_of(root, "recommended.finer.steps") >=
                    1.5 * real_of(root, "recommended.measured.steps"));
        json_decref(root);
    }
}

/* What is measured must not be shortened because others use the machine: time that passes is
 * nothing, time that this process or a child of its works is all. */
static void only_work_counts_as_time(void **state) {
    (void)state;
    const struct timespec pause = {.tv_nsec = 300000000};
    const double before = dl_recommend_clock();
    nanosleep(&pause, NULL);
    const double rested = dl_recommend_clock();
    assert_true(rested - before < 0.15);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        while (clock() < CLOCKS_PER_SEC / 5)
            continue;
        _exit(0);
    }
    assert_int_equal(waitpid(child, NULL, 0), child);
    assert_true(dl_recommend_clock() - rested > 0.1);
}

/* --- no answer ---------------------------------------------------------------------------------
 */

static void impossible_error_is_told(void **state) {
    (void)state;
    json_t *root = object_of("recommend " KEPLER " --error 1e-30 --json --methods "
                             "rkn-6-blanes-moan-14,gsl-rk8pd",
                             1);
    assert_true(json_is_null(member(root, "recommended")));
    const json_t *left = member(root, "left_out");
    assert_int_equal(json_array_size(left), 2);
    for (size_t i = 0; i < 2; i++) {
        const json_t *one = json_array_get(left, i);
        assert_true(strlen(text_of(one, "reason")) > 10);
        assert_true(real_of(one, "nearest.error") < 1e-12);
    }
    json_decref(root);
    const outcome *o = driftlab("recommend " KEPLER " --error 1e-30 --in energy --methods "
                                "rkn-6-blanes-moan-14");
    assert_int_equal(o->exit, 1);
    assert_non_null(strstr(o->err, "no method reached an error of 1e-30 in energy on kepler"));
    assert_non_null(strstr(o->err, "nearest"));
}

static void bad_input_is_refused(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *words;
    } bad[] = {
        {"", "expected SCENE"},
        {KEPLER, "--error: found none"},
        {KEPLER " --error 0", "--error"},
        {KEPLER " --error 1e-6 --in momentum", "position"},
        {KEPLER " --error 1e-6 --seconds 0", "--seconds"},
        {KEPLER " --error 1e-6 --methods leapfrg", "did you mean \"leapfrog\""},
        {KEPLER " --error 1e-6 --methods leapfrog,,gauss-4", "empty name"},
        {KEPLER " --error 1e-6 --methods leapfrog,leapfrog", "twice"},
        {KEPLER " --error 1e-6 --let speed=3", "speed"},
        {"nothing.yaml --error 1e-6", "nothing.yaml"},
        {"bad.yaml --error 1e-6", "bad.yaml:2: "},
    };
    char path[128];
    snprintf(path, sizeof path, "%s/bad.yaml", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("name: bad\ndimensoin: 2\n", file);
    fclose(file);
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        char arguments[400];
        snprintf(arguments, sizeof arguments, "recommend %s", bad[i].arguments);
        const outcome *o = driftlab(arguments);
        if (o->exit != 2 || o->out[0] || !strstr(o->err, bad[i].words))
            fail_msg("driftlab %s: exit %d: %s%s", arguments, o->exit, o->out, o->err);
    }
}

/* In the foreground: else timeout signals the program and its group, and a second SIGINT kills. */
static void interrupt_ends_it(void **state) {
    (void)state;
    const outcome *o = driftlab_after("timeout --foreground --preserve-status -s INT 1",
                                      "recommend " DL_STUDIES "/swirl/swirl.yaml --error 1e-9");
    assert_int_equal(o->exit, 130);
    assert_string_equal(o->out, "");
    assert_non_null(strstr(o->err, "interrupted"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(recommended_step_reaches_the_error),
        cmocka_unit_test(text_says_what_json_says),
        cmocka_unit_test(horizon_shortens_the_run),
        cmocka_unit_test(energy_error_is_reached),
        cmocka_unit_test(short_run_is_asked_for_less),
        cmocka_unit_test(answer_is_confirmed),
        cmocka_unit_test(only_work_counts_as_time),
        cmocka_unit_test(impossible_error_is_told),
        cmocka_unit_test(bad_input_is_refused),
        cmocka_unit_test(interrupt_ends_it),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
