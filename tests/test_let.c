/* Numbers by name: what they stand for, other numbers in their place, and what then is another
 * scene. */
#include "fixture_runs.h"

#include "driftlab/trajectory.h"
#include "study/plan.h"

static const char text[] = "# \xc3\xbc: characters of two bytes stand before what is replaced\n"
                           "name: fall\n"
                           "source: \"costs $5\"\n"
                           "dimension: 2\n"
                           "let: {speed: 50, half: 0.5*$speed, n: 3, a: 1.5e1}\n"
                           "particles:\n"
                           "  - lattice: {kind: hexagonal, spacing: 1, count: [$n, 2*$n]}\n"
                           "    velocity: [$speed, -$half]\n"
                           "    mass: $a / $n\n"
                           "pair_law:\n"
                           "  - {terms: [{coefficient: -2*$half/5, power: $n}]}\n"
                           "time: {step: 0.01, end: 1}\n";

static char path[] = "/tmp/driftlab-let-XXXXXX";

static int write_scene(void **state) {
    (void)state;
    FILE *out = fopen(path, "w");
    return !out || fputs(text, out) < 0 || fclose(out);
}

static dl_scene *read_with(size_t count, const dl_let *let) {
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (dl_scene_read_let(path, count, let, &scene, &error))
        fail_msg("%s", error.message);
    return scene;
}

static void names_stand_for_numbers(void **state) {
    (void)state;
    dl_scene *scene = read_with(0, NULL);
    assert_string_equal(scene->name, "fall");
    assert_string_equal(scene->source, "costs $5");
    assert_int_equal(scene->particles, 18);
    assert_true(scene->velocity[0] == 50 && scene->velocity[18] == -25);
    assert_true(scene->inertia[7] == 5);
    assert_true(scene->law.piece[0].term[0].coefficient == -10);
    assert_true(scene->law.piece[0].term[0].power == 3);
    assert_int_equal(scene->lets, 4);
    assert_string_equal(scene->let[1].name, "half");
    assert_true(scene->let[1].value == 25 && scene->let[3].value == 15);
    dl_scene_free(scene);
}

static void other_numbers_are_another_scene(void **state) {
    (void)state;
    dl_scene *const as_it_is = read_with(0, NULL);
    dl_scene *const other = read_with(2, (dl_let[]){{"n", "2"}, {"speed", "1e2"}});
    assert_string_equal(other->name, "fall(n=2,speed=1e2)");
    assert_int_equal(other->particles, 8);
    assert_true(other->velocity[0] == 100 && other->velocity[8] == -50);
    assert_true(other->law.piece[0].term[0].power == 2);
    assert_true(other->let[0].value == 100 && other->let[1].value == 50);
    assert_true(dl_scene_hash(other) != dl_scene_hash(as_it_is));
    assert_non_null(strstr(other->text, "{speed: 1e2, half: 0.5*$speed, n: 2, a: 1.5e1}"));
    assert_non_null(strstr(other->text, "\xc3\xbc: characters"));
    dl_scene_free(as_it_is);
    dl_scene_free(other);
}

/* An exponent changes nothing of the particles: the hash must go by the text. */
static void a_law_alone_is_another_scene(void **state) {
    (void)state;
    static const char law[] = "name: law\ndimension: 2\nlet: {power: 2}\n"
                              "particles: [{at: [0, 0]}, {at: [1, 0]}]\n"
                              "pair_law: [{terms: [{coefficient: -1, power: $power}]}]\n"
                              "time: {step: 0.1, end: 1}\n";
    uint64_t hash[2];
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(law, out);
    fclose(out);
    for (int k = 0; k < 2; k++) {
        dl_scene *scene = read_with(1, &(dl_let){"power", k ? "3" : "2"});
        hash[k] = dl_scene_hash(scene);
        dl_scene_free(scene);
    }
    assert_true(hash[0] != hash[1]);
}

/* A trajectory holds the text it was run from. */
static void a_trajectory_remembers_its_numbers(void **state) {
    (void)state;
    char file[] = "/tmp/driftlab-let-h5-XXXXXX";
    const int descriptor = mkstemp(file);
    assert_true(descriptor >= 0);
    close(descriptor);
    dl_scene *const scene = read_with(1, &(dl_let){"n", "2"});
    double *y_all = calloc(4 * scene->particles, sizeof *y_all);
    assert_non_null(y_all);
    memcpy(y_all, scene->position, 2 * scene->particles * sizeof *y_all);
    const dl_sample sample = {.y_all = y_all};
    dl_trajectory *trajectory;
    dl_scene *again = scene;
    dl_error error = {""};
    if (dl_trajectory_create(file, scene, "leapfrog", "", &trajectory, &error) ||
        dl_trajectory_append(trajectory, &sample, &error) ||
        dl_trajectory_close(trajectory, &error) || dl_scene_read_trajectory(file, &again, &error))
        fail_msg("%s", error.message);
    assert_string_equal(again->name, "fall(n=2)");
    assert_true(again->law.piece[0].term[0].power == 2);
    assert_int_equal(again->lets, 4);
    dl_scene_free(again);
    dl_scene_free(scene);
    free(y_all);
    unlink(file);
}

static void what_cannot_be_set_is_refused(void **state) {
    (void)state;
    static const struct {
        dl_let let[2];
        size_t count;
        const char *part;
    } bad[] = {
        {{{"speeed", "1"}}, 1, "did you mean \"speed\"?"},
        {{{"mass", "1"}}, 1, "one of speed, half, n, a"},
        {{{"speed", "fast"}}, 1, "\"fast\", expected a number"},
        {{{"speed", ""}}, 1, "expected a number"},
        {{{"speed", "1"}, {"speed", "2"}}, 2, "set twice"},
        {{{"n", "-1"}}, 1, ":11: power"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        dl_scene *scene = NULL;
        dl_error error = {""};
        assert_int_equal(dl_scene_read_let(path, bad[i].count, bad[i].let, &scene, &error),
                         DL_INPUT);
        assert_null(scene);
        if (!strstr(error.message, bad[i].part) || !strstr(error.message, path))
            fail_msg("case %zu: \"%s\" lacks \"%s\"", i, error.message, bad[i].part);
    }
}

/* Aliases of aliases are many values, but few nodes. */
static void aliases_are_walked_once(void **state) {
    (void)state;
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs("name: bomb\ndimension: 2\nlet: {a: 1}\nb0: &b0 [$a, $a]\n", out);
    for (int k = 1; k < 60; k++)
        fprintf(out, "b%d: &b%d [*b%d, *b%d]\n", k, k, k - 1, k - 1);
    fclose(out);
    dl_scene *scene = NULL;
    dl_error error = {""};
    assert_int_equal(dl_scene_read(path, &scene, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "\"b0\""));
}

/* --- studies ---------------------------------------------------------------------------------- */

static dl_status read_study(const char *lets, dl_study **study, dl_error *error) {
    char file[] = "/tmp/driftlab-let-study-XXXXXX";
    const int descriptor = mkstemp(file);
    assert_true(descriptor >= 0);
    FILE *out = fdopen(descriptor, "w");
    assert_non_null(out);
    fprintf(out,
            "name: variants\nscene: %s\nerror: 1\nin: energy\nend: 1\n%s"
            "cases:\n  - {method: leapfrog, step: [0.01, 0.05]}\n",
            path, lets);
    fclose(out);
    const dl_status status = dl_study_read(file, study, error);
    unlink(file);
    return status;
}

static void a_study_multiplies_its_scenes(void **state) {
    (void)state;
    dl_study *study = NULL;
    dl_error error = {""};
    if (read_study("let: {speed: [50, 100, 300], n: [2, 3]}\n", &study, &error))
        fail_msg("%s", error.message);
    assert_int_equal(study->scenes, 6);
    assert_int_equal(study->cases, 12);
    assert_string_equal(study->scene[0].scene->name, "fall(speed=50,n=2)");
    assert_string_equal(study->scene[1].scene->name, "fall(speed=50,n=3)");
    assert_string_equal(study->scene[5].scene->name, "fall(speed=300,n=3)");
    assert_non_null(strstr(study->cased[11].command, " --let speed=300 --let n=3 --method"));
    for (size_t i = 0; i < study->cases; i++)
        for (size_t j = 0; j < i; j++)
            assert_string_not_equal(study->cased[i].key, study->cased[j].key);
    dl_study_free(study);
}

static void bad_variants_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *lets, *part;
    } bad[] = {
        {"let: [1]\n", ":6: let"},
        {"let: {}\n", ":6: let"},
        {"let: {speed: []}\n", "a number or a list of numbers"},
        {"let: {speed: [1, [2]]}\n", "a number or a list of numbers"},
        {"let: {sped: [1]}\n", "did you mean \"speed\"?"},
        {"let: {speed: [1, fast]}\n", "\"fast\""},
        {"let: {speed: [1, 1]}\n", "different names"},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        dl_study *study = NULL;
        dl_error error = {""};
        assert_int_equal(read_study(bad[i].lets, &study, &error), DL_INPUT);
        assert_null(study);
        if (!strstr(error.message, bad[i].part))
            fail_msg("case %zu: \"%s\" lacks \"%s\"", i, error.message, bad[i].part);
    }
}

int main(void) {
#define WRITTEN(test) cmocka_unit_test_setup(test, write_scene)
    const struct CMUnitTest tests[] = {
        WRITTEN(names_stand_for_numbers),       WRITTEN(other_numbers_are_another_scene),
        WRITTEN(a_law_alone_is_another_scene),  WRITTEN(a_trajectory_remembers_its_numbers),
        WRITTEN(what_cannot_be_set_is_refused), WRITTEN(aliases_are_walked_once),
        WRITTEN(a_study_multiplies_its_scenes), WRITTEN(bad_variants_are_refused),
    };
    const int descriptor = mkstemp(path);
    if (descriptor < 0)
        return EXIT_FAILURE;
    close(descriptor);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(path);
    return failed;
}
