/* Two results files side by side. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <string.h>
#include "driftlab/compare.h"
#include "fixture_report.h"

static void the_same_file_agrees_with_itself(void **state) {
    (void)state;
    dl_results *a = fixture_study();
    dl_comparison both;
    assert_int_equal(dl_compare(a, a, &both, NULL), DL_OK);
    assert_int_equal(both.pairs, a->cases);
    assert_int_equal(both.same, a->cases);
    assert_int_equal(both.only_a + both.only_b, 0);
    assert_true(both.ratio_least == 1 && both.ratio_median == 1 && both.ratio_most == 1);
    assert_true(both.ranked > 100);
    assert_int_equal(both.swapped, 0);
    for (size_t i = 0; i < both.pairs; i++) {
        assert_ptr_equal(both.pair[i].a, both.pair[i].b);
        assert_true(both.pair[i].same_key && both.pair[i].same);
    }
    dl_comparison_release(&both);
    dl_results_free(a);
}

static void what_differs_is_told(void **state) {
    (void)state;
    dl_results *a = fixture_study(), *b = fixture_study();
    const size_t cases = a->cases;
    /* one more evaluation, an error in its last place, a failure */
    b->cased[7].summary.force_evaluations++;
    b->cased[8].position_error = nextafter(b->cased[8].position_error, 1);
    b->cased[9].summary.status = DL_TIMEOUT;
    /* both stopped for their time, at different places: nothing that the method has done */
    a->cased[10].summary.status = b->cased[10].summary.status = DL_TIMEOUT;
    b->cased[10].summary.steps++;
    /* all times the double but for one that becomes the slowest of all */
    for (size_t i = 0; i < cases; i++)
        b->cased[i].summary.cpu_seconds *= 2;
    b->cased[12].summary.cpu_seconds *= 1e9;
    dl_comparison both;
    assert_int_equal(dl_compare(a, b, &both, NULL), DL_OK);
    assert_int_equal(both.pairs, cases);
    assert_int_equal(both.same, cases - 3);
    for (size_t i = 0; i < cases; i++)
        assert_int_equal(both.pair[i].same, i < 7 || i > 9);
    assert_true(both.ratio_median == 2 && both.ratio_most > 1e9);
    size_t faster = 0;
    for (size_t i = 0; i < cases; i++)
        faster += i != 12 && i != 9 && a->cased[i].summary.status == DL_OK &&
                  strcmp(a->cased[i].scene, a->cased[12].scene) == 0 &&
                  a->cased[i].summary.cpu_seconds > 1.2 * a->cased[12].summary.cpu_seconds;
    assert_true(faster > 0);
    assert_int_equal(both.swapped, faster);
    dl_comparison_release(&both);
    dl_results_free(a);
    dl_results_free(b);
}

static void set_key(dl_case *cased, const char *key) {
    free(cased->key);
    cased->key = strdup(key);
}

static void scenes_that_changed_are_matched_and_named(void **state) {
    (void)state;
    dl_results *a = fixture_one(), *b = fixture_one(), *c = fixture_one();
    set_key(&a->cased[0], "alone#0123456789abcdef leapfrog step=0.01 end=1 samples=4 "
                          "reference=0123456789abcdef");
    set_key(&b->cased[0], "alone#fedcba9876543210 leapfrog step=0.01 end=1 samples=4 "
                          "reference=0123456789abcde0");
    set_key(&c->cased[0], "alone#0123456789abcdef leapfrog step=0.02 end=1 samples=4 "
                          "reference=0123456789abcdef");
    dl_comparison both;
    assert_int_equal(dl_compare(a, b, &both, NULL), DL_OK);
    assert_int_equal(both.pairs, 1);
    assert_false(both.pair[0].same_key);
    dl_comparison_release(&both);
    assert_int_equal(dl_compare(a, c, &both, NULL), DL_OK);
    assert_int_equal(both.pairs, 0);
    assert_int_equal(both.only_a, 1);
    assert_int_equal(both.only_b, 1);
    assert_false(dl_comparison_has_case(&both, &a->cased[0]));
    assert_true(isnan(both.ratio_median));
    dl_comparison_release(&both);
    dl_results_free(a);
    dl_results_free(b);
    dl_results_free(c);
}

static void add_finding(dl_results *results, const char *verdict, double value) {
    const dl_finding made = {.key = strdup("drift() alone#0123456789abcdef leapfrog"),
                             .scene = strdup("alone"),
                             .method = strdup("leapfrog"),
                             .family = strdup("leap-frog"),
                             .options = strdup("step=0.01"),
                             .command = strdup(""),
                             .verdict = strdup(verdict),
                             .reason = strdup(""),
                             .quantities = 1,
                             .quantity_names = strdup("slope [1/time]"),
                             .quantity = calloc(3, sizeof(double)),
                             .column_names = strdup(""),
                             .row_words = strdup("")};
    made.quantity[0] = value;
    assert_int_equal(dl_results_add_finding(results, &made, NULL), DL_OK);
}

static void failures_have_no_times(void **state) {
    (void)state;
    dl_results *failed = fixture_all_failed(), *many = fixture_many();
    dl_comparison both;
    assert_int_equal(dl_compare(failed, failed, &both, NULL), DL_OK);
    assert_int_equal(both.same, failed->cases);
    assert_true(isnan(both.ratio_median) && both.ranked == 0);
    dl_comparison_release(&both);
    assert_int_equal(dl_compare(failed, many, &both, NULL), DL_OK);
    assert_int_equal(both.only_a, failed->cases - both.pairs);
    assert_int_equal(both.only_b, many->cases - both.pairs);
    dl_comparison_release(&both);
    dl_results_free(failed);
    dl_results_free(many);
}

static void findings_are_compared_too(void **state) {
    (void)state;
    dl_results *a = fixture_empty(), *b = fixture_empty(), *c = fixture_empty();
    add_finding(a, "pass", 1e-9);
    add_finding(b, "pass", 1e-9);
    add_finding(c, "pass", 2e-9);
    assert_non_null(dl_finding_quantity(&a->finding[0], "slope"));
    assert_null(dl_finding_quantity(&a->finding[0], "slo"));
    dl_comparison both;
    assert_int_equal(dl_compare(a, b, &both, NULL), DL_OK);
    assert_int_equal(both.finding_pairs, 1);
    assert_int_equal(both.same, 1);
    dl_comparison_release(&both);
    assert_int_equal(dl_compare(a, c, &both, NULL), DL_OK);
    assert_int_equal(both.finding_pairs, 1);
    assert_int_equal(both.same, 0);
    dl_comparison_release(&both);
    dl_results_free(a);
    dl_results_free(b);
    dl_results_free(c);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_same_file_agrees_with_itself),
        cmocka_unit_test(what_differs_is_told),
        cmocka_unit_test(scenes_that_changed_are_matched_and_named),
        cmocka_unit_test(failures_have_no_times),
        cmocka_unit_test(findings_are_compared_too),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
