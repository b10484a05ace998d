/* The report: one self-contained page that holds every case and runs nothing it was handed.
 *
 *     test_report           runs the tests
 *     test_report FOLDER    writes the fabricated studies there as NAME.html, with NAME.expect
 *                           (shell variables) for the browser's test */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <jansson.h>
#include <sys/stat.h>
#include <unistd.h>

#include "driftlab/front.h"
#include "driftlab/report.h"
#include "fixture_report.h"

static const struct {
    const char *name;
    dl_results *(*make)(void);
} studies[] = {
    {"study", fixture_study}, {"one", fixture_one},     {"failed", fixture_all_failed},
    {"many", fixture_many},   {"empty", fixture_empty},
};

#define STUDIES (sizeof studies / sizeof *studies)

static char *read_file(const char *path) {
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    rewind(file);
    char *content = calloc(size + 1, 1);
    if (content && fread(content, 1, size, file) != size)
        content[0] = '\0';
    fclose(file);
    return content;
}

static char folder[] = "/tmp/driftlab-report-XXXXXX";

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    return rmdir(folder);
}

static char *render(const dl_results *results) {
    char path[128];
    snprintf(path, sizeof path, "%s/report.html", folder);
    dl_error error = {{0}};
    if (dl_report_write(results, path, &error) != DL_OK)
        fail_msg("%s", error.message);
    char *page = read_file(path);
    unlink(path);
    assert_non_null(page);
    return page;
}

static size_t occurrences(const char *text, const char *what) {
    size_t found = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what))
        found++;
    return found;
}

/* The page's data block, parsed. */
static json_t *data_of(const char *page) {
    static const char open[] = "<script type=\"application/json\" id=\"results\">";
    const char *from = strstr(page, open);
    assert_non_null(from);
    from += strlen(open);
    const char *to = strstr(from, "</script>");
    assert_non_null(to);
    json_error_t why;
    json_t *data = json_loadb(from, (size_t)(to - from), 0, &why);
    if (!data)
        fail_msg("data block: %s", why.text);
    return data;
}

static const char *string_of(const json_t *object, const char *key) {
    const char *value = json_string_value(json_object_get(object, key));
    assert_non_null(value);
    return value;
}

static void every_case_is_in_the_data_with_its_figures(void **state) {
    (void)state;
    for (size_t s = 0; s < STUDIES; s++) {
        dl_results *results = studies[s].make();
        char *page = render(results);
        json_t *data = data_of(page), *cases = json_object_get(data, "cases");
        assert_int_equal(json_array_size(cases), results->cases);
        for (size_t i = 0; i < results->cases; i++) {
            const dl_case *cased = &results->cased[i];
            const json_t *one = json_array_get(cases, i);
            assert_string_equal(string_of(one, "key"), cased->key);
            assert_string_equal(string_of(one, "command"), cased->command);
            assert_string_equal(string_of(one, "message"), cased->summary.message);
            assert_string_equal(string_of(one, "status"), dl_status_name(cased->summary.status));
            assert_true(json_real_value(json_object_get(one, "cpu_seconds")) ==
                        cased->summary.cpu_seconds);
            assert_int_equal(json_integer_value(json_object_get(one, "force_evaluations")),
                             cased->summary.force_evaluations);
            if (isnan(cased->position_error))
                assert_true(json_is_null(json_object_get(one, "position_error")));
            else
                assert_true(json_real_value(json_object_get(one, "position_error")) ==
                            cased->position_error);
        }
        json_decref(data);
        free(page);
        dl_results_free(results);
    }
}

static void points_that_are_no_errors_carry_their_reason(void **state) {
    (void)state;
    dl_results *results = fixture_study();
    char *page = render(results);
    json_t *data = data_of(page);
    const struct {
        size_t index;
        const char *position, *energy; /* how the reason starts; "": drawn */
    } expected[] = {
        {0, "energy error 3.2e+07", "energy error 3.2e+07"}, /* failed, with a message */
        {1, "", ""},
        {25, "", "the error is exactly 0"},
        {30, "timeout", "timeout"}, /* failed without a message */
        {39, "error 3.0e-12 is below the reference", ""},
        {50, "there is no reference", ""},
    };
    for (size_t e = 0; e < sizeof expected / sizeof *expected; e++) {
        const json_t *one = json_array_get(json_object_get(data, "cases"), expected[e].index);
        const json_t *reasons = json_object_get(one, "not_drawn");
        const char *position = string_of(reasons, "position");
        const char *energy = string_of(reasons, "energy");
        assert_true(strncmp(position, expected[e].position, strlen(expected[e].position)) == 0);
        assert_true(strncmp(energy, expected[e].energy, strlen(expected[e].energy)) == 0);
        assert_int_equal(position[0] == '\0', expected[e].position[0] == '\0');
        assert_int_equal(energy[0] == '\0', expected[e].energy[0] == '\0');
    }
    json_decref(data);
    free(page);
    dl_results_free(results);
}

/* Past the horizon, and where the reference cannot tell, there is no position error over time. */
static void errors_over_time_end_at_the_horizon(void **state) {
    (void)state;
    dl_results *results = fixture_study();
    dl_reference *reference = &results->reference[0];
    const size_t last = reference->samples - 1;
    reference->horizon = reference->time[last / 2];
    reference->lyapunov = 3;
    reference->lyapunov_error = 0.5;
    reference->growth = calloc(reference->samples, sizeof *reference->growth);
    results->cased[1].sample_position_error[3] = 50 * reference->sample_error[3];
    results->cased[1].sample_position_error[4] = 150 * reference->sample_error[4];
    char *page = render(results);
    json_t *data = data_of(page);
    const json_t *told =
        json_object_get(json_array_get(json_object_get(data, "scenes"), 0), "reference");
    assert_true(json_real_value(json_object_get(told, "horizon")) == reference->horizon);
    assert_true(json_real_value(json_object_get(told, "lyapunov")) == 3);
    const json_t *shown = json_object_get(
        json_object_get(json_array_get(json_object_get(data, "cases"), 1), "samples"), "position");
    assert_true(json_is_null(json_array_get(shown, 3)));
    assert_false(json_is_null(json_array_get(shown, 4)));
    for (size_t i = last / 2; i <= last; i++)
        assert_true(json_is_null(json_array_get(shown, i)));
    json_decref(data);
    free(page);
    dl_results_free(results);
}

/* In units of their scale; nothing of what the scene does not conserve. */
static void momenta_over_time_are_those_that_are_conserved(void **state) {
    (void)state;
    dl_results *results = fixture_study();
    char *page = render(results);
    json_t *data = data_of(page);
    const json_t *samples =
        json_object_get(json_array_get(json_object_get(data, "cases"), 1), "samples");
    const json_t *shown = json_object_get(samples, "momentum");
    assert_int_equal(json_array_size(shown), FIXTURE_SAMPLES);
    assert_true(json_real_value(json_array_get(shown, FIXTURE_SAMPLES - 1)) == 1.7e-14 / 120);
    assert_null(json_object_get(samples, "angular-momentum"));
    json_decref(data);
    free(page);
    dl_results_free(results);
}

static void the_cheapest_case_is_the_one_that_the_results_name(void **state) {
    (void)state;
    for (size_t s = 0; s < STUDIES; s++) {
        dl_results *results = studies[s].make();
        char *page = render(results);
        json_t *data = data_of(page), *scenes = json_object_get(data, "scenes");
        assert_int_equal(json_array_size(scenes), results->scenes);
        for (size_t i = 0; i < results->scenes; i++) {
            const dl_case *best = results->asked_error > 0
                                      ? dl_results_cheapest(results, results->scene[i].name,
                                                            results->asked_in, results->asked_error)
                                      : NULL;
            const json_t *told = json_object_get(json_array_get(scenes, i), "cheapest");
            if (best)
                assert_ptr_equal(&results->cased[json_integer_value(told)], best);
            else
                assert_true(json_is_null(told));
        }
        json_decref(data);
        free(page);
        dl_results_free(results);
    }
}

/* Of every kind of error by every cost, and for each decade the cheapest. */
static void fronts_are_those_of_the_results(void **state) {
    (void)state;
    static const char *const errors[] = {"position", "energy", "momentum"};
    static const char *const costs[DL_COSTS] = {"cpu", "force", "steps"};
    dl_results *results = fixture_study();
    char *page = render(results);
    json_t *data = data_of(page);
    const json_t *scene = json_array_get(json_object_get(data, "scenes"), 0);
    dl_front_point *front = calloc(results->cases, sizeof *front);
    for (size_t e = 0; e < sizeof errors / sizeof *errors; e++) {
        const json_t *told = json_object_get(json_object_get(scene, "tradeoff"), errors[e]);
        const json_t *accuracies = json_object_get(told, "accuracies");
        assert_true(json_array_size(accuracies) > 0);
        for (int cost = 0; cost < DL_COSTS; cost++) {
            const json_t *corners = json_object_get(json_object_get(told, "front"), costs[cost]);
            const size_t count =
                dl_results_front(results, results->scene[0].name, errors[e], (dl_cost)cost, front);
            assert_int_equal(json_array_size(corners), count);
            for (size_t i = 0; i < count; i++)
                assert_int_equal(json_integer_value(json_array_get(corners, i)), front[i].index);
            for (size_t i = 0; i < json_array_size(accuracies); i++) {
                const json_t *row = json_array_get(accuracies, i);
                const dl_front_point *best =
                    dl_front_cheapest(front, count, json_real_value(json_object_get(row, "error")));
                assert_non_null(best);
                assert_int_equal(json_integer_value(json_object_get(row, costs[cost])),
                                 best->index);
            }
        }
    }
    free(front);
    json_decref(data);
    free(page);
    dl_results_free(results);
}

/* What the results say is text: it neither ends the data block nor becomes a tag. */
static void foreign_text_cannot_become_markup(void **state) {
    (void)state;
    dl_results *results = fixture_study();
    char *attacked = render(results);
    assert_non_null(strstr(attacked, "<title>Stream &amp; co: &lt;which&gt; method?</title>"));
    assert_null(strstr(attacked, "<which>"));
    json_t *data = data_of(attacked);
    assert_string_equal(string_of(json_array_get(json_object_get(data, "scenes"), 1), "name"),
                        results->scene[1].name);
    dl_results *plain = fixture_one();
    char *harmless = render(plain);
    assert_int_equal(occurrences(attacked, "<script"), occurrences(harmless, "<script"));
    assert_int_equal(occurrences(attacked, "</script"), occurrences(harmless, "</script"));
    assert_int_equal(occurrences(attacked, "<!--"), 0);
    json_decref(data);
    free(attacked);
    free(harmless);
    dl_results_free(results);
    dl_results_free(plain);
}

static void text_that_is_no_utf8_is_still_written(void **state) {
    (void)state;
    dl_results *results = fixture_one();
    dl_case *cased = &results->cased[0];
    /* A message that its buffer cut inside a character. */
    snprintf(cased->summary.message, sizeof cased->summary.message, "step \xce");
    char *page = render(results);
    json_t *data = data_of(page);
    const json_t *one = json_array_get(json_object_get(data, "cases"), 0);
    assert_string_equal(string_of(one, "message"), "step ?");
    json_decref(data);
    free(page);
    dl_results_free(results);
}

/* Nothing is fetched: no address in an attribute or a style, and a policy that forbids the rest. */
static void the_page_needs_nothing_but_itself(void **state) {
    (void)state;
    dl_results *results = fixture_study();
    char *page = render(results);
    static const char *const fetches[] = {
        " src=",   "href=\"http",           "href='http", "url(http", "url(\"http",
        "@import", "<link rel=\"stylesheet"};
    for (size_t i = 0; i < sizeof fetches / sizeof *fetches; i++)
        assert_int_equal(occurrences(page, fetches[i]), 0);
    assert_non_null(strstr(page, "default-src 'none'"));
    assert_non_null(strstr(page, "Chart.js v")); /* the library, with its licence's notice */
    assert_non_null(strstr(page, "MIT License"));
    assert_null(strstr(page, "{{"));
    free(page);
    dl_results_free(results);
}

static void long_runs_keep_their_worst_samples(void **state) {
    (void)state;
    enum { MANY = 12345, SPIKE = 7771 };
    dl_results *results = fixture_one();
    dl_case *cased = &results->cased[0];
    cased->samples = MANY;
    cased->sample_time = fixture_samples(MANY, fixture_time, 1);
    cased->sample_energy_error = fixture_samples(MANY, fixture_growth, 1e-3);
    cased->sample_position_error = fixture_samples(MANY, fixture_growth, 1);
    cased->sample_energy_error[SPIKE] = -100; /* twice the energy scale */
    char *page = render(results);
    json_t *data = data_of(page);
    const json_t *samples =
        json_object_get(json_array_get(json_object_get(data, "cases"), 0), "samples");
    const json_t *energy = json_object_get(samples, "energy");
    const json_t *time = json_object_get(samples, "time");
    assert_int_equal(json_integer_value(json_object_get(samples, "stride")), 25);
    assert_int_equal(json_array_size(energy), (MANY + 24) / 25);
    size_t at = SPIKE / 25;
    assert_true(json_real_value(json_array_get(energy, at)) == 2);
    assert_true(json_real_value(json_array_get(time, at)) == cased->sample_time[SPIKE]);
    json_decref(data);
    free(page);
    dl_results_free(results);
}

static size_t files_in_folder(void) {
    size_t files = 0;
    DIR *directory = opendir(folder);
    assert_non_null(directory);
    for (struct dirent *entry; (entry = readdir(directory));)
        files += entry->d_name[0] != '.';
    closedir(directory);
    return files;
}

/* A folder stands where the file should go: the rename fails after all was written. */
static void a_report_that_cannot_be_written_leaves_nothing(void **state) {
    (void)state;
    dl_results *results = fixture_one();
    char path[128];
    snprintf(path, sizeof path, "%s/taken", folder);
    assert_int_equal(mkdir(path, 0777), 0);
    dl_error error = {{0}};
    assert_int_equal(dl_report_write(results, path, &error), DL_IO);
    assert_non_null(strstr(error.message, path));
    assert_int_equal(files_in_folder(), 1);
    rmdir(path);

    snprintf(path, sizeof path, "%s/missing/report.html", folder);
    assert_int_equal(dl_report_write(results, path, &error), DL_IO);
    assert_non_null(strstr(error.message, path));
    dl_results_free(results);
}

/* --- pages for the browser's test ---------------------------------------------------------------
 */

static bool energy_is_drawn(const dl_case *cased) {
    return cased->summary.status == DL_OK && isfinite(cased->summary.energy_error_max) &&
           cased->summary.energy_error_max > 0;
}

static bool position_is_drawn(const dl_case *cased) {
    return cased->summary.status == DL_OK && !cased->refused[0] && isfinite(cased->position_error);
}

static int write_expectation(const dl_results *results, const char *path) {
    size_t drawn[2] = {0};
    const char *first = results->scenes ? results->scene[0].name : "";
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *cased = &results->cased[i];
        if (strcmp(cased->scene, first) != 0)
            continue;
        drawn[0] += position_is_drawn(cased);
        drawn[1] += energy_is_drawn(cased);
    }
    dl_front_point *front = calloc(results->cases + 1, sizeof *front);
    const size_t corners =
        front ? dl_results_front(results, first, "energy", DL_COST_CPU, front) : 0;
    FILE *out = front ? fopen(path, "w") : NULL;
    free(front);
    if (!out)
        return 1;
    fprintf(out, "cases=%zu scenes=%zu position=%zu energy=%zu front=%zu\n", results->cases,
            results->scenes, drawn[0], drawn[1], corners);
    return fclose(out);
}

static int write_pages(const char *where) {
    for (size_t s = 0; s < STUDIES; s++) {
        char path[4096];
        dl_error error = {{0}};
        dl_results *results = studies[s].make();
        snprintf(path, sizeof path, "%s/%s.html", where, studies[s].name);
        int failed = dl_report_write(results, path, &error) != DL_OK;
        snprintf(path, sizeof path, "%s/%s.expect", where, studies[s].name);
        failed = failed || write_expectation(results, path);
        dl_results_free(results);
        if (failed) {
            fprintf(stderr, "%s: %s\n", path, error.message);
            return 1;
        }
    }
    return 0;
}

int main(int argc, char **argv) {
    if (argc == 2)
        return write_pages(argv[1]);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_case_is_in_the_data_with_its_figures),
        cmocka_unit_test(points_that_are_no_errors_carry_their_reason),
        cmocka_unit_test(errors_over_time_end_at_the_horizon),
        cmocka_unit_test(momenta_over_time_are_those_that_are_conserved),
        cmocka_unit_test(the_cheapest_case_is_the_one_that_the_results_name),
        cmocka_unit_test(fronts_are_those_of_the_results),
        cmocka_unit_test(foreign_text_cannot_become_markup),
        cmocka_unit_test(text_that_is_no_utf8_is_still_written),
        cmocka_unit_test(the_page_needs_nothing_but_itself),
        cmocka_unit_test(long_runs_keep_their_worst_samples),
        cmocka_unit_test(a_report_that_cannot_be_written_leaves_nothing),
    };
    return cmocka_run_group_tests_name("report", tests, make_folder, remove_folder);
}
