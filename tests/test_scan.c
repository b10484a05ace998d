/* Scans of steps whose stability is known: limits, windows, what is not known. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "study/scan.h"

/* Stable up to the end of the first stretch and within the others. */
typedef struct known {
    size_t stretches;
    double from[4], to[4];
    double unknown_above; /* steps above are not known; INFINITY: all are */
    double grid;          /* possible steps are its whole fractions; 0: all are */
    size_t tries;
} known;

static dl_status judge(void *context, dl_scan_point *point, dl_error *error) {
    known *const k = context;
    k->tries++;
    point->word = "";
    point->stable = point->step > k->unknown_above ? 0 : -1;
    for (size_t s = 0; s < k->stretches; s++)
        if (point->step >= k->from[s] && point->step <= k->to[s])
            point->stable = 1;
    return k->tries < 1000 ? DL_OK : dl_fail(error, DL_ERROR, "it does not end");
}

static double possible(const void *context, double step) {
    const known *const k = context;
    return k->grid / ceil(k->grid / step * (1 - 1e-12));
}

static dl_scan scan_of(known *k, double smallest, double largest) {
    dl_scan scan = {.judge = judge,
                    .possible = k->grid > 0 ? possible : NULL,
                    .context = k,
                    .smallest = smallest,
                    .largest = largest,
                    .per_decade = 20,
                    .width = 1e-4};
    dl_error error = {""};
    if (dl_scan_run(&scan, &error))
        fail_msg("%s", error.message);
    for (size_t i = 1; i < scan.count; i++)
        assert_true(scan.point[i].step > scan.point[i - 1].step);
    return scan;
}

static void assert_near(double value, double expected) {
    if (!(fabs(value / expected - 1) < 2e-4))
        fail_msg("%.9g, expected %.9g", value, expected);
}

static void a_limit_is_found(void **state) {
    (void)state;
    known k = {.stretches = 1, .from = {0}, .to = {0.1234}, .unknown_above = INFINITY};
    dl_scan scan = scan_of(&k, 1e-3, 1);
    const dl_scan_result found = dl_scan_read(&scan);
    assert_true(found.limit <= 0.1234 && found.broken > 0.1234);
    assert_near(found.limit, 0.1234);
    assert_near(found.broken, 0.1234);
    assert_true(found.top == found.limit && found.windows == 0 && found.unknown == 0);
    dl_scan_release(&scan);
}

static void windows_are_seen(void **state) {
    (void)state;
    known k = {
        .stretches = 3, .from = {0, 0.03, 0.4}, .to = {0.02, 0.2, 0.5}, .unknown_above = INFINITY};
    dl_scan scan = scan_of(&k, 1e-3, 1);
    const dl_scan_result found = dl_scan_read(&scan);
    assert_near(found.limit, 0.02);
    assert_near(found.top, 0.5);
    assert_near(found.beyond, 0.5);
    assert_int_equal(found.windows, 2);
    dl_scan_release(&scan);
}

static void ends_of_the_range(void **state) {
    (void)state;
    known always = {.stretches = 1, .from = {0}, .to = {10}, .unknown_above = INFINITY};
    known never = {.stretches = 0, .unknown_above = INFINITY};
    dl_scan scan = scan_of(&always, 1e-3, 1);
    dl_scan_result found = dl_scan_read(&scan);
    assert_true(found.limit == 1 && found.top == 1 && isnan(found.broken) && isnan(found.beyond));
    dl_scan_release(&scan);
    scan = scan_of(&never, 1e-3, 1);
    found = dl_scan_read(&scan);
    assert_true(isnan(found.limit) && isnan(found.top) && found.broken == 1e-3);
    dl_scan_release(&scan);
}

/* What ran out of time is neither. */
static void what_is_not_known_decides_nothing(void **state) {
    (void)state;
    known k = {.stretches = 1, .from = {0}, .to = {0.1}, .unknown_above = 0.1};
    dl_scan scan = scan_of(&k, 1e-3, 1);
    const dl_scan_result found = dl_scan_read(&scan);
    assert_true(found.limit == found.top && found.limit <= 0.1 && isnan(found.broken));
    assert_true(found.unknown > 10);
    dl_scan_release(&scan);
}

static void steps_are_the_possible_ones(void **state) {
    (void)state;
    known k = {.stretches = 1, .from = {0}, .to = {0.03}, .unknown_above = INFINITY, .grid = 0.1};
    dl_scan scan = scan_of(&k, 0.004, 10);
    const dl_scan_result found = dl_scan_read(&scan);
    for (size_t i = 0; i < scan.count; i++) {
        const double parts = 0.1 / scan.point[i].step;
        assert_true(fabs(parts - round(parts)) < 1e-9);
    }
    assert_near(found.limit, 0.025);
    assert_near(found.broken, 0.1 / 3);
    dl_scan_release(&scan);
}

static void one_step_is_one_try(void **state) {
    (void)state;
    known k = {.stretches = 1, .from = {0}, .to = {10}, .unknown_above = INFINITY};
    dl_scan scan = scan_of(&k, 0.5, 0.5);
    assert_int_equal(scan.count, 1);
    assert_int_equal(k.tries, 1);
    dl_scan_release(&scan);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_limit_is_found),
        cmocka_unit_test(windows_are_seen),
        cmocka_unit_test(ends_of_the_range),
        cmocka_unit_test(what_is_not_known_decides_nothing),
        cmocka_unit_test(steps_are_the_possible_ones),
        cmocka_unit_test(one_step_is_one_try),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
