/* The Pareto front and the cheapest for an accuracy, on points whose answer is plain to see. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driftlab/front.h"
#include "driftlab/study.h"
#include "fixture_report.h"
#include "study/plan.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

static void assert_front(const dl_front_point *front, size_t count, const size_t *index,
                         size_t expected) {
    assert_int_equal(count, expected);
    for (size_t i = 0; i < expected; i++)
        assert_int_equal(front[i].index, index[i]);
}

static void nothing_beats_what_is_on_the_front(void **state) {
    (void)state;
    dl_front_point point[] = {
        {5, 1e-6, 0},          {1, 1e-2, 1},   {3, 1e-4, 2},
        {4, 1e-3, 3}, /* dearer and worse than 2 */
        {3, 1e-3, 4}, /* as dear and worse */
        {6, 1e-6, 5}, /* dearer, no better than 0 */
        {3, 1e-4, 6}, /* 2 again */
        {0.5, INFINITY, 7},    {NAN, 1e-9, 8}, {2, NAN, 9},
        {INFINITY, 1e-12, 10}, {9, 0, 11}, /* an error of exactly 0 is one */
    };
    const size_t expected[] = {1, 2, 0, 11};
    const size_t count = dl_front_of(point, COUNT(point));
    assert_front(point, count, expected, COUNT(expected));

    int largest, smallest;
    assert_true(dl_front_decades(point, count, &largest, &smallest));
    assert_int_equal(largest, -2);
    assert_int_equal(smallest, -16); /* not minus infinity */
    assert_true(dl_front_decades(point, 3, &largest, &smallest));
    assert_int_equal(smallest, -6);

    assert_int_equal(dl_front_cheapest(point, count, 1e-1)->index, 1);
    assert_int_equal(dl_front_cheapest(point, count, 5e-3)->index, 2);
    assert_int_equal(dl_front_cheapest(point, count, 1e-4)->index, 2);
    assert_int_equal(dl_front_cheapest(point, count, 9e-5)->index, 0);
    assert_int_equal(dl_front_cheapest(point, count, 0)->index, 11);
    assert_null(dl_front_cheapest(point, 3, 1e-7));
}

static void a_front_of_nothing_is_empty(void **state) {
    (void)state;
    dl_front_point point[] = {{1, NAN, 0}, {NAN, 1, 1}};
    int largest, smallest;
    assert_int_equal(dl_front_of(point, 0), 0);
    assert_int_equal(dl_front_of(point, COUNT(point)), 0);
    assert_false(dl_front_decades(point, 0, &largest, &smallest));
    assert_null(dl_front_cheapest(point, 0, 1));
}

static bool beats(const dl_front_point *a, const dl_front_point *b) {
    return a->cost <= b->cost && a->error <= b->error && (a->cost < b->cost || a->error < b->error);
}

/* Against the definition, on points with many ties. */
static void the_front_is_that_of_the_definition(void **state) {
    (void)state;
    enum { points = 200 };
    dl_front_point all[points], front[points];
    unsigned seed = 7;
    for (size_t i = 0; i < points; i++) {
        seed = seed * 1103515245U + 12345U;
        all[i] = front[i] =
            (dl_front_point){(double)(seed >> 16 & 31), (double)(seed >> 21 & 31), i};
    }
    const size_t count = dl_front_of(front, points);
    size_t unbeaten = 0;
    for (size_t i = 0; i < points; i++) {
        bool beaten = false;
        for (size_t k = 0; k < points && !beaten; k++)
            beaten = beats(&all[k], &all[i]) ||
                     (k < i && all[k].cost == all[i].cost && all[k].error == all[i].error);
        unbeaten += !beaten;
        size_t found = 0;
        for (size_t k = 0; k < count; k++)
            found += front[k].index == i;
        assert_int_equal(found, !beaten);
    }
    assert_int_equal(unbeaten, count);
}

static void set(dl_case *cased, double seconds, unsigned long forces, double position) {
    cased->summary.cpu_seconds = seconds;
    cased->summary.force_evaluations = forces;
    cased->position_error = position;
}

static dl_case *add(dl_results *results, const char *scene) {
    fixture_add(results, fixture_case(scene, &fixture_methods[0], "step", 0.01, 0));
    return &results->cased[results->cases - 1];
}

/* What failed, is invalid, or is past the horizon counts nowhere; a cost decides its own front. */
static void only_cases_that_count_are_on_a_front(void **state) {
    (void)state;
    dl_results *results = fixture_results("fronts", 1e-6, "position");
    set(add(results, "a"), 1, 900, 1e-3);
    set(add(results, "a"), 2, 100, 1e-3); /* dearer, with fewer forces */
    set(add(results, "b"), 1e-3, 1, 1e-9);
    dl_case *failed = add(results, "a"), *invalid, *past;
    set(failed, 0.1, 10, 1e-9);
    failed->summary.status = DL_UNSTABLE;
    invalid = add(results, "a");
    set(invalid, 0.1, 10, 1e-9);
    free(invalid->invalid);
    invalid->invalid = strdup("the sampling chose its steps");
    past = add(results, "a");
    set(past, 0.1, 10, 1e-9);
    fixture_refuse(past, "past the horizon");
    past->summary.t_end_reached = 2;
    const dl_reference reference = {.key = strdup(""),
                                    .scene = strdup("a"),
                                    .description = strdup(""),
                                    .error = 1e-20,
                                    .horizon = 1.5};
    assert_int_equal(dl_results_add_reference(results, &reference, NULL), DL_OK);

    dl_front_point front[8] = {{0}};
    const size_t by_cpu[] = {0}, by_forces[] = {1};
    size_t count = dl_results_front(results, "a", "position", DL_COST_CPU, front);
    assert_front(front, count, by_cpu, 1);
    count = dl_results_front(results, "a", "position", DL_COST_FORCES, front);
    assert_front(front, count, by_forces, 1);
    results->reference[0].horizon = 0; /* refused for another reason: then it is a small error */
    const size_t with_small[] = {5};
    count = dl_results_front(results, "a", "position", DL_COST_CPU, front);
    assert_front(front, count, with_small, 1);
    dl_results_free(results);
}

static void errors_have_names(void **state) {
    (void)state;
    dl_results *results = fixture_results("errors", 1e-6, "position");
    dl_case *cased = add(results, "a");
    cased->position_error = 1;
    cased->position_error_max = 2;
    cased->position_error_ever = 3;
    cased->summary.energy_error_max = 4 * cased->summary.energy_scale;
    cased->summary.momentum_error_max = 5 * cased->summary.momentum_scale;
    cased->summary.angular_momentum_error_max = 6;
    cased->summary.angular_momentum_scale = 0;
    assert_true(dl_case_error(cased, "position") == 1);
    assert_true(dl_case_error(cased, "position-worst") == 2);
    assert_true(dl_case_error(cased, "position-ever") == 3);
    assert_true(dl_case_error(cased, "energy") == 4);
    assert_true(dl_case_error(cased, "momentum") == 5);
    assert_true(isnan(dl_case_error(cased, "angular-momentum")));
    dl_results_free(results);
}

/* --- the method comparison ----------------------------------------------------------------- */

/* Different in more than step and tolerance. */
static bool same_row(const dl_study_case *a, const dl_study_case *b) {
    const char *x = strstr(a->run.text, "table="), *y = strstr(b->run.text, "table=");
    return a->run.row == b->run.row && (!x == !y) && (!x || strcspn(x, " ") == strcspn(y, " ")) &&
           (!x || strncmp(x, y, strcspn(x, " ")) == 0);
}

static void the_comparison_has_its_rows(void **state) {
    (void)state;
    static const char *const names[] = {"stream", "drop", "swirl", "penetration"};
    for (size_t s = 0; s < COUNT(names); s++) {
        char path[256];
        dl_study *study = NULL;
        dl_error error = {""};
        snprintf(path, sizeof path, "%s/comparison/%s.yaml", DL_STUDIES, names[s]);
        if (dl_study_read(path, &study, &error) != DL_OK)
            fail_msg("%s", error.message);
        size_t rows = 0;
        for (size_t i = 0; i < study->cases; i++) {
            size_t before = 0, alike = 0;
            for (size_t k = 0; k < study->cases; k++) {
                const bool same = same_row(&study->cased[k], &study->cased[i]);
                alike += same;
                before += same && k < i;
            }
            assert_in_range(alike, 3, 5); /* a sweep */
            rows += before == 0;
        }
        assert_true(rows >= 25);
        dl_study_free(study);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nothing_beats_what_is_on_the_front),
        cmocka_unit_test(a_front_of_nothing_is_empty),
        cmocka_unit_test(the_front_is_that_of_the_definition),
        cmocka_unit_test(only_cases_that_count_are_on_a_front),
        cmocka_unit_test(errors_have_names),
        cmocka_unit_test(the_comparison_has_its_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
