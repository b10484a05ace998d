/* Results files: what is written is read, bit by bit; a bad file is refused; a write that fails
 * leaves the file of before. And the cheapest case. */
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>
#include "driftlab/results.h"
#include "source_hash.h"

static char folder[] = "/tmp/driftlab-results-XXXXXX";
static char path[128];

static char *copy(const char *text) {
    char *made = strdup(text);
    assert_non_null(made);
    return made;
}

static double *series(size_t count, double first) {
    double *made = malloc(count * sizeof *made + 1);
    assert_non_null(made);
    for (size_t i = 0; i < count; i++)
        made[i] = first / (double)(i + 3);
    return made;
}

/* Reals that do not survive a detour over decimal text or single precision. */
static dl_run_summary odd_summary(void) {
    return (dl_run_summary){
        .status = DL_NONLINEAR_FAILURE,
        .message = "did not converge: \"r\" = 3e-5\tµ",
        .t_end_reached = 0x1.fffffffffffffp-3,
        .step = 5e-324,
        .steps = 4294967311UL,
        .rejected_steps = 1,
        .force_evaluations = 2,
        .jacobian_evaluations = 3,
        .jacobian_vector_products = 4,
        .nonlinear_iterations = 5,
        .linear_iterations = 6,
        .factorisations = 7,
        .neighbour_list_builds = 8,
        .wall_hits = 9,
        .cpu_seconds = 1.0 / 3,
        .energy_initial = -0.0,
        .energy_final = INFINITY,
        .energy_scale = 2,
        .energy_error_max = 1e-300,
        .energy_error_final = -INFINITY,
        .ledger = M_PI,
        .momentum_error_max = NAN,
        .angular_momentum_error_max = 11,
        .momentum_scale = 12,
        .angular_momentum_scale = 13,
        .kinetic_energy_per_particle = 14,
        .samples = 15,
    };
}

static dl_case make_case(const char *scene, const char *method, double error, double seconds,
                         size_t samples) {
    dl_case made = {
        .key = copy(scene),
        .scene = copy(scene),
        .method = copy(method),
        .family = copy("family"),
        .options = copy("step=0.01"),
        .command = copy("driftlab run ..."),
        .summary = odd_summary(),
        .repeats = 3,
        .cpu_median = 2 * seconds,
        .position_error = error,
        .position_error_max = NAN,
        .position_error_ever = 3 * error,
        .samples = samples,
        .sample_time = series(samples, 1),
        .sample_energy_error = series(samples, 2),
        .sample_position_error = series(samples, 3),
        .sample_momentum_error = series(samples, 4), /* angular: not conserved */
        .refused = copy(""),
        .invalid = copy("no steps"),
    };
    made.summary.cpu_seconds = seconds;
    return made;
}

static dl_results *make_results(void) {
    dl_results *made;
    char *long_text = malloc(200001); /* longer than an attribute may be */
    assert_non_null(long_text);
    memset(long_text, 'x', 200000);
    long_text[200000] = '\0';
    assert_int_equal(dl_results_create(&made, NULL), DL_OK);
    free(made->study);
    made->study = copy("a study");
    free(made->asked_in);
    made->asked_in = copy("position");
    made->asked_error = 0.1;
    assert_int_equal(dl_results_add_fact(made, "compiler", "", NULL), DL_OK);
    assert_int_equal(dl_results_add_fact(made, "processor", "a \"b\" — c", NULL), DL_OK);
    const dl_scene_record scene = {copy("s"), copy("source"), copy(""), long_text};
    assert_int_equal(dl_results_add_scene(made, &scene, NULL), DL_OK);
    const dl_reference reference = {.key = copy("k"),
                                    .scene = copy("s"),
                                    .description = copy("words"),
                                    .error = 1e-17,
                                    .samples = 2,
                                    .particles = 5,
                                    .dimension = 3,
                                    .time = series(2, 5),
                                    .sample_error = series(2, NAN),
                                    .position = series(30, 7)};
    assert_int_equal(dl_results_add_reference(made, &reference, NULL), DL_OK);
    for (size_t i = 0; i < 12; i++) {
        const dl_case cased = make_case("s", i % 2 ? "leapfrog" : "gsl", 0.1 / 3, (double)i, i);
        assert_int_equal(dl_results_add_case(made, &cased, NULL), DL_OK);
    }
    return made;
}

static void assert_same_bits(const void *a, const void *b, size_t size) {
    assert_memory_equal(a, b, size);
}

static void assert_same_case(const dl_case *a, const dl_case *b) {
    assert_string_equal(a->key, b->key);
    assert_string_equal(a->scene, b->scene);
    assert_string_equal(a->method, b->method);
    assert_string_equal(a->family, b->family);
    assert_string_equal(a->options, b->options);
    assert_string_equal(a->command, b->command);
    assert_string_equal(a->refused, b->refused);
    assert_string_equal(a->invalid, b->invalid);
    assert_int_equal(a->summary.status, b->summary.status);
    assert_string_equal(a->summary.message, b->summary.message);
    /* everything behind the message is a number without padding between */
    const size_t numbers = offsetof(dl_run_summary, t_end_reached);
    assert_same_bits((const char *)&a->summary + numbers, (const char *)&b->summary + numbers,
                     sizeof a->summary - numbers);
    assert_int_equal(a->repeats, b->repeats);
    assert_same_bits(&a->cpu_median, &b->cpu_median, 4 * sizeof(double));
    assert_int_equal(a->samples, b->samples);
    assert_same_bits(a->sample_time, b->sample_time, a->samples * sizeof(double));
    assert_same_bits(a->sample_energy_error, b->sample_energy_error, a->samples * sizeof(double));
    assert_same_bits(a->sample_position_error, b->sample_position_error,
                     a->samples * sizeof(double));
    assert_same_bits(a->sample_momentum_error, b->sample_momentum_error,
                     a->samples * sizeof(double));
    assert_null(a->sample_angular_momentum_error);
    assert_null(b->sample_angular_momentum_error);
}

static void round_trip_keeps_every_bit(void **state) {
    (void)state;
    dl_results *written = make_results(), *read = NULL;
    dl_error error = {""};
    assert_int_equal(dl_results_write(written, path, &error), DL_OK);
    assert_int_equal(dl_results_read(path, &read, &error), DL_OK);
    assert_string_equal(read->study, "a study");
    assert_string_equal(read->title, "");
    assert_true(read->asked_error == 0.1);
    assert_int_equal(read->facts, 2);
    assert_string_equal(dl_results_fact(read, "processor"), "a \"b\" — c");
    assert_string_equal(dl_results_fact(read, "compiler"), "");
    assert_null(dl_results_fact(read, "nothing"));
    assert_int_equal(read->scenes, 1);
    assert_string_equal(read->scene[0].text, written->scene[0].text);
    const dl_reference *was = &written->reference[0], *is = dl_results_reference(read, "s");
    assert_non_null(is);
    assert_int_equal(is->dimension, 3);
    assert_int_equal(is->particles, 5);
    assert_same_bits(is->time, was->time, 2 * sizeof(double));
    assert_same_bits(is->sample_error, was->sample_error, 2 * sizeof(double));
    assert_same_bits(is->position, was->position, 30 * sizeof(double));
    assert_int_equal(read->cases, written->cases);
    for (size_t i = 0; i < read->cases; i++)
        assert_same_case(&read->cased[i], &written->cased[i]);
    dl_results_free(read);
    dl_results_free(written);
}

static void facts_are_set_once(void **state) {
    (void)state;
    dl_results *made;
    assert_int_equal(dl_results_create(&made, NULL), DL_OK);
    assert_int_equal(dl_results_add_fact(made, "date", "then", NULL), DL_OK);
    assert_int_equal(dl_results_add_fact(made, "date", "now", NULL), DL_OK);
    assert_int_equal(made->facts, 1);
    assert_string_equal(dl_results_fact(made, "date"), "now");
    dl_results_free(made);
}

static void write_bytes(const void *data, size_t size) {
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(data, 1, size, out), size);
    assert_int_equal(fclose(out), 0);
}

static void assert_refused(dl_status status, const char *part) {
    dl_results *read = (dl_results *)&status;
    dl_error error = {""};
    assert_int_equal(dl_results_read(path, &read, &error), status);
    assert_null(read);
    assert_non_null(strstr(error.message, path));
    if (!strstr(error.message, part))
        fail_msg("\"%s\" lacks \"%s\"", error.message, part);
}

static void bad_files_are_refused(void **state) {
    (void)state;
    unlink(path);
    assert_refused(DL_IO, "No such file");
    write_bytes("name: study\n", 12);
    assert_refused(DL_INPUT, "no HDF5 file");
    write_bytes("", 0);
    assert_refused(DL_INPUT, "no HDF5 file");
    dl_results *made = make_results();
    assert_int_equal(dl_results_write(made, path, NULL), DL_OK);
    assert_int_equal(truncate(path, 20000), 0);
    assert_refused(DL_INPUT, "truncated");
    dl_results_free(made);
}

static void set_integer(const char *name, int value) {
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    hid_t attribute = H5Aopen(file, name, H5P_DEFAULT);
    assert_true(attribute >= 0);
    assert_true(H5Awrite(attribute, H5T_NATIVE_INT, &value) >= 0);
    H5Aclose(attribute);
    H5Fclose(file);
}

static void no_results_are_refused(void **state) {
    (void)state;
    hid_t file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    assert_true(file >= 0);
    H5Fclose(file);
    assert_refused(DL_INPUT, "results file of driftlab study");
}

/* A file that a program of another format wrote: without an attribute or a dataset that is there
 * now, or of a version that is yet to come. The message tells both programs and what to do. */
static void files_of_other_programs_are_told_apart(void **state) {
    (void)state;
    static const char *const always[] = {"by driftlab 0.0.9 (source 0123abcd)",
                                         "as of this driftlab ", "read it with the program that",
                                         "--out NEW.h5"};
    static const struct {
        int version;
        const char *attribute, *dataset; /* what it lacks */
        const char *found;
    } other[] = {
        {7, NULL, NULL, "of format version 7, by"},
        {0, NULL, NULL, "of format version 0, by"},
        {1, "steps", NULL, "of format version 1, by"},
        {1, "steps", NULL, "which has no cases/0002/steps; expected format version 2, as"},
        {2, NULL, "cases/0003/sample_time", "which has no cases/0003/sample_time; expected"},
        {1, NULL, "references", "which has no references; expected"},
    };
    dl_results *made = make_results();
    assert_int_equal(dl_results_add_fact(made, "driftlab", "0.0.9", NULL), DL_OK);
    assert_int_equal(dl_results_add_fact(made, "source", "0123abcd", NULL), DL_OK);
    for (size_t i = 0; i < sizeof other / sizeof *other; i++) {
        assert_int_equal(dl_results_write(made, path, NULL), DL_OK);
        set_integer("version", other[i].version);
        hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
        if (other[i].attribute)
            assert_true(H5Adelete_by_name(file, "cases/0002", other[i].attribute, H5P_DEFAULT) >=
                        0);
        if (other[i].dataset)
            assert_true(H5Ldelete(file, other[i].dataset, H5P_DEFAULT) >= 0);
        H5Fclose(file);
        assert_refused(DL_INPUT, other[i].found);
        for (size_t k = 0; k < sizeof always / sizeof *always; k++)
            assert_refused(DL_INPUT, always[k]);
    }
    dl_results_free(made);
}

/* This program writes whole files: what one of its own lacks has been lost. */
static void files_of_this_program_are_whole_or_damaged(void **state) {
    (void)state;
    dl_results *made = make_results();
    assert_int_equal(dl_results_add_fact(made, "source", DL_SOURCE_HASH, NULL), DL_OK);
    assert_int_equal(dl_results_write(made, path, NULL), DL_OK);
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    assert_true(H5Ldelete(file, "cases/0003/sample_time", H5P_DEFAULT) >= 0);
    H5Fclose(file);
    assert_refused(DL_INPUT, "damaged: found no cases/0003/sample_time");
    dl_results_free(made);
}

/* What was added since is read as if there were none of it. */
static void files_of_version_1_are_read(void **state) {
    (void)state;
    dl_results *made = make_results(), *read = NULL;
    dl_error error = {""};
    assert_int_equal(dl_results_write(made, path, NULL), DL_OK);
    set_integer("version", 1);
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    for (unsigned i = 0; i < 12; i++) {
        char at[64];
        snprintf(at, sizeof at, "cases/%04u", i);
        assert_true(H5Adelete_by_name(file, at, "crossings", H5P_DEFAULT) >= 0);
        snprintf(at, sizeof at, "cases/%04u/sample_momentum_error", i);
        assert_true(H5Ldelete(file, at, H5P_DEFAULT) >= 0);
    }
    H5Fclose(file);
    if (dl_results_read(path, &read, &error) != DL_OK)
        fail_msg("%s", error.message);
    assert_int_equal(read->cases, made->cases);
    assert_null(read->cased[3].sample_momentum_error);
    assert_int_equal(read->cased[3].summary.crossings, 0);
    assert_int_equal(read->cased[3].summary.steps, made->cased[3].summary.steps);
    dl_results_free(read);
    dl_results_free(made);
}

/* A file that may not grow stands for a full disk. */
static void failed_write_keeps_old_file(void **state) {
    (void)state;
    dl_results *made = make_results(), *read = NULL;
    dl_error error = {""};
    struct rlimit usual;
    char temporary[160];
    assert_int_equal(dl_results_write(made, path, NULL), DL_OK);
    free(made->study);
    made->study = copy("another");
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &usual), 0);
    const struct rlimit small = {.rlim_cur = 4096, .rlim_max = usual.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    const dl_status status = dl_results_write(made, path, &error);
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &usual), 0);
    assert_int_equal(status, DL_IO);
    assert_non_null(strstr(error.message, path));
    assert_int_equal(dl_results_read(path, &read, &error), DL_OK);
    assert_string_equal(read->study, "a study");
    snprintf(temporary, sizeof temporary, "%s.tmp", path);
    assert_int_not_equal(access(temporary, F_OK), 0);
    assert_int_equal(dl_results_write(made, "/nowhere/at/all.h5", &error), DL_IO);
    dl_results_free(read);
    dl_results_free(made);
}

static dl_results *work_precision(void) {
    static const struct {
        const char *method;
        double position, energy, seconds;
        dl_status status;
        const char *refused, *invalid;
    } point[] = {
        {"leapfrog", 1e-3, 1e-2, 1, DL_OK, "", ""},
        {"yoshida", 1e-7, 1e-6, 3, DL_OK, "", ""},
        {"suzuki", 1e-8, 1e-7, 2, DL_OK, "", ""},
        {"crashed", 1e-9, 1e-9, 0.1, DL_ERROR, "the run failed", ""},
        {"fine", 1e-12, 1e-12, 1.5, DL_OK, "below the reference's own error", ""},
        {"unmeasured", NAN, NAN, 0.1, DL_OK, "", ""},
        {"pretender", 1e-12, 1e-12, 0.01, DL_OK, "", "the sampling chose its steps"},
    };
    dl_results *made = make_results();
    for (size_t i = 0; i < sizeof point / sizeof *point; i++) {
        dl_case cased = make_case("t", point[i].method, point[i].position, point[i].seconds, 0);
        cased.summary.status = point[i].status;
        cased.summary.energy_error_max = 2 * point[i].energy; /* the scale is 2 */
        free(cased.refused);
        cased.refused = copy(point[i].refused);
        free(cased.invalid);
        cased.invalid = copy(point[i].invalid);
        assert_int_equal(dl_results_add_case(made, &cased, NULL), DL_OK);
    }
    const dl_reference reference = {.key = copy(""),
                                    .scene = copy("t"),
                                    .description = copy(""),
                                    .error = 1e-10,
                                    .time = series(0, 0),
                                    .sample_error = series(0, 0),
                                    .position = series(0, 0)};
    assert_int_equal(dl_results_add_reference(made, &reference, NULL), DL_OK);
    return made;
}

static void assert_cheapest(const dl_results *results, const char *in, double error,
                            const char *method) {
    const dl_case *found = dl_results_cheapest(results, "t", in, error);
    if (!method)
        assert_null(found);
    else
        assert_string_equal(found ? found->method : "none", method);
}

static void cheapest_is_the_cheapest_that_counts(void **state) {
    (void)state;
    dl_results *results = work_precision();
    assert_cheapest(results, "position", 1e-2, "leapfrog");
    /* what a reference of error 1e-10 cannot resolve still is below 1e-6, but not known below
     * 1e-11 */
    assert_cheapest(results, "position", 1e-6, "fine");
    assert_cheapest(results, "position", 1e-11, NULL);
    assert_cheapest(results, "energy", 1e-7, "fine");
    assert_cheapest(results, "energy", 1e-13, NULL);
    assert_null(dl_results_cheapest(results, "no such scene", "energy", 1));
    dl_results_free(results);
}

static void answer_says_what_was_reached(void **state) {
    (void)state;
    dl_results *results = work_precision();
    char text[DL_MESSAGE_SIZE];
    results->asked_error = 1e-2;
    dl_results_answer(results, "t", text, sizeof text);
    assert_string_equal(text, "cheapest for a position error of 0.01 on t: leapfrog with step=0.01 "
                              "(1 CPU s, 2 force evaluations; its error: 0.001)");
    results->asked_error = 1e-14;
    dl_results_answer(results, "t", text, sizeof text);
    assert_non_null(strstr(text, "nothing reached a position error of 1e-14 on t; the closest was "
                                 "fine with step=0.01 (1e-10)"));
    dl_results_answer(results, "s", text, sizeof text);
    assert_non_null(strstr(text, "nothing reached"));
    assert_non_null(strstr(text, "no case ran to its end"));
    dl_results_free(results);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(round_trip_keeps_every_bit),
        cmocka_unit_test(facts_are_set_once),
        cmocka_unit_test(bad_files_are_refused),
        cmocka_unit_test(no_results_are_refused),
        cmocka_unit_test(files_of_other_programs_are_told_apart),
        cmocka_unit_test(files_of_this_program_are_whole_or_damaged),
        cmocka_unit_test(files_of_version_1_are_read),
        cmocka_unit_test(failed_write_keeps_old_file),
        cmocka_unit_test(cheapest_is_the_cheapest_that_counts),
        cmocka_unit_test(answer_says_what_was_reached),
    };
    if (!mkdtemp(folder))
        return EXIT_FAILURE;
    snprintf(path, sizeof path, "%s/results.h5", folder);
    int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(path);
    rmdir(folder);
    return failed;
}
