/* Methods across scenes: ranks, ratios and two sentences, of one study or several; their one page.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <jansson.h>
#include <unistd.h>
#include "driftlab/across.h"
#include "driftlab/report.h"
#include "fixture_report.h"

static const fixture_method slow = {"slow", "family", 2, 1, 1e-3, 1, 1e-14};
static const fixture_method quick = {"quick", "family", 2, 1, 1e-5, 1, 1e-14};
static const fixture_method steady = {"steady", "family", 2, 1, 2e-5, 1, 1e-14};

static void add(dl_results *results, const char *scene, const fixture_method *method, double error,
                double seconds) {
    dl_case made = fixture_case(scene, method, "step", 0.01, 0);
    made.position_error = error;
    made.summary.cpu_seconds = seconds;
    fixture_add(results, made);
}

/* Two scenes: `quick` reaches 1e-6 on the first alone, and twice, `steady` on both. */
static dl_results *two_scenes(void) {
    dl_results *made = fixture_results("two", 1e-6, "position");
    fixture_scene(made, "a", 0);
    fixture_scene(made, "b", 0);
    add(made, "a", &quick, 1e-7, 2);
    add(made, "a", &quick, 9e-7, 1);
    add(made, "a", &steady, 1e-8, 3);
    add(made, "a", &slow, 1e-9, 50);
    add(made, "b", &quick, 1e-5, 1);
    add(made, "b", &steady, 1e-7, 4);
    add(made, "b", &slow, 1e-2, 80);
    return made;
}

/* Another study, which asks for something else of a scene of its own. */
static dl_results *third_scene(bool steady_reaches) {
    dl_results *made = fixture_results("third", 1e-3, "position");
    fixture_scene(made, "c", 0);
    add(made, "c", &quick, 1e-4, 10);
    add(made, "c", &steady, steady_reaches ? 1e-4 : 1e-2, 20);
    return made;
}

static void ranks_and_ratios_are_those_of_the_cheapest(void **state) {
    (void)state;
    dl_results *results = two_scenes();
    const dl_results *all[] = {results};
    dl_across across;
    assert_int_equal(dl_across_create(all, 1, &across, NULL), DL_OK);
    assert_int_equal(across.scenes, 2);
    assert_int_equal(across.rows, 3);
    const dl_across_row *first = &across.row[0], *second = &across.row[1], *last = &across.row[2];
    assert_string_equal(first->method, "steady");
    assert_int_equal(first->reached, 2);
    assert_true(first->worst == 3);
    assert_int_equal(first->cell[0].rank, 2);
    assert_int_equal(first->cell[1].rank, 1);
    assert_true(first->cell[1].ratio == 1);
    assert_string_equal(second->method, "quick");
    assert_ptr_equal(second->cell[0].best, &results->cased[1]);
    assert_int_equal(second->cell[0].rank, 1);
    assert_null(second->cell[1].best);
    assert_string_equal(last->method, "slow");
    assert_int_equal(last->cell[0].rank, 3);
    assert_true(last->worst == 50);
    dl_across_release(&across);
    dl_results_free(results);
}

static void assert_answer(const dl_results *const *all, size_t count, const char *expected) {
    char text[4 * DL_MESSAGE_SIZE];
    dl_results_answer_all(all, count, text, sizeof text);
    assert_string_equal(text, expected);
}

static void the_answer_is_two_sentences_over_all_scenes(void **state) {
    (void)state;
    dl_results *two = two_scenes(), *three = third_scene(true), *other = third_scene(false);
    const dl_results *all[] = {two, three}, *open[] = {two, other};
    assert_answer(all, 2,
                  "Cheapest for the error asked of each scene: quick step=0.01 on a (1 CPU s), "
                  "steady step=0.01 on b (4 CPU s), quick step=0.01 on c (10 CPU s). Best on all 3 "
                  "together is steady, which takes at most 3 times the cheapest's time.");
    assert_answer(open, 2,
                  "Cheapest for the error asked of each scene: quick step=0.01 on a (1 CPU s), "
                  "steady step=0.01 on b (4 CPU s), quick step=0.01 on c (10 CPU s). No method "
                  "reaches it on all 3; quick does on 2, in at most 1 times the cheapest's time.");
    two->asked_error = 1e-30;
    assert_answer(all, 1,
                  "Cheapest for the error asked of each scene: nothing on a, nothing on b. No "
                  "method reaches it on any scene.");
    dl_results_free(two);
    dl_results_free(three);
    dl_results_free(other);
}

static char page_path[] = "/tmp/driftlab-across-XXXXXX.html";

static json_t *data_of_page(void) {
    static const char begins[] = "<script type=\"application/json\" id=\"results\">";
    char *page = NULL;
    size_t size = 0;
    FILE *file = fopen(page_path, "r");
    assert_non_null(file);
    assert_true(getdelim(&page, &size, '\0', file) > 0);
    fclose(file);
    const char *at = strstr(page, begins);
    assert_non_null(at);
    json_t *data = json_loads(at + strlen(begins), JSON_DISABLE_EOF_CHECK, NULL);
    free(page);
    assert_non_null(data);
    return data;
}

static const char *method_of(const json_t *data, const json_t *index) {
    const json_t *one =
        json_array_get(json_object_get(data, "cases"), (size_t)json_integer_value(index));
    return json_string_value(json_object_get(one, "method"));
}

/* Cases of the second study stand behind those of the first: what points at them must know. */
static void one_page_holds_both_studies(void **state) {
    (void)state;
    dl_results *two = two_scenes(), *three = third_scene(true);
    const dl_results *all[] = {two, three};
    const dl_report report = {.results = all, .studies = 2};
    assert_int_equal(dl_report_write_page(&report, page_path, NULL), DL_OK);
    json_t *data = data_of_page(), *scenes = json_object_get(data, "scenes");
    assert_int_equal(json_array_size(json_object_get(data, "cases")), two->cases + three->cases);
    assert_int_equal(json_array_size(json_object_get(data, "studies")), 2);
    assert_int_equal(json_array_size(scenes), 3);
    const json_t *third = json_array_get(scenes, 2);
    assert_true(json_real_value(json_object_get(third, "asked_error")) == 1e-3);
    assert_string_equal(method_of(data, json_object_get(third, "cheapest")), "quick");
    assert_int_equal(json_integer_value(json_object_get(third, "cheapest")), (int)two->cases);
    const json_t *front = json_object_get(
        json_object_get(json_object_get(json_object_get(third, "tradeoff"), "position"), "front"),
        "cpu");
    assert_int_equal(json_integer_value(json_array_get(front, 0)), (int)two->cases);
    const json_t *best = json_array_get(json_object_get(data, "across"), 0);
    assert_string_equal(json_string_value(json_object_get(best, "method")), "steady");
    const json_t *cell = json_array_get(json_object_get(best, "cells"), 2);
    assert_string_equal(method_of(data, json_object_get(cell, "case")), "steady");
    assert_int_equal(json_integer_value(json_object_get(cell, "rank")), 2);
    json_decref(data);
    dl_results_free(two);
    dl_results_free(three);
}

static void studies_that_do_not_go_together_are_refused(void **state) {
    (void)state;
    dl_results *two = two_scenes(), *again = two_scenes(), *other = third_scene(true);
    const dl_results *same[] = {two, again}, *mixed[] = {two, other};
    dl_error error = {""};
    unlink(page_path);
    assert_int_equal(
        dl_report_write_page(&(dl_report){.results = same, .studies = 2}, page_path, &error),
        DL_INPUT);
    assert_non_null(strstr(error.message, "the scene a in two studies"));
    free(other->kind);
    other->kind = strdup("drift");
    assert_int_equal(
        dl_report_write_page(&(dl_report){.results = mixed, .studies = 2}, page_path, &error),
        DL_INPUT);
    assert_non_null(strstr(error.message, "two kinds"));
    assert_int_not_equal(access(page_path, F_OK), 0);
    dl_results_free(two);
    dl_results_free(again);
    dl_results_free(other);
}

static int make_name(void **state) {
    (void)state;
    const int file = mkstemps(page_path, (int)strlen(".html"));
    return file < 0 ? -1 : close(file);
}

static int remove_page(void **state) {
    (void)state;
    unlink(page_path);
    return 0;
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ranks_and_ratios_are_those_of_the_cheapest),
        cmocka_unit_test(the_answer_is_two_sentences_over_all_scenes),
        cmocka_unit_test(one_page_holds_both_studies),
        cmocka_unit_test(studies_that_do_not_go_together_are_refused),
    };
    return cmocka_run_group_tests_name("across", tests, make_name, remove_page);
}
