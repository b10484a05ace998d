/* driftlab bench: what it measures is there and is a number; nothing here depends on how fast the
 * machine is. */
#include "fixture_program.h"

static double number(const json_t *row, const char *key) {
    const json_t *const value = json_object_get(row, key);
    if (!json_is_number(value))
        fail_msg("%s is no number", key);
    return json_number_value(value);
}

static double minimum(const json_t *row, const char *key) {
    return number(json_object_get(row, key), "minimum");
}

static const char *text(const json_t *row, const char *key) {
    const json_t *const value = json_object_get(row, key);
    assert_true(json_is_string(value));
    return json_string_value(value);
}

/* Of a method on so many particles; NULL: there is no such row. */
static const json_t *row_of(const json_t *rows, const char *method, int particles) {
    for (size_t k = 0; k < json_array_size(rows); k++) {
        const json_t *const row = json_array_get(rows, k);
        if (strcmp(text(row, "method"), method) == 0 && (int)number(row, "particles") == particles)
            return row;
    }
    return NULL;
}

static void check_overhead(const json_t *rows, const dl_method_row *method, int particles) {
    const json_t *const row = row_of(rows, method->name, particles);
    if (!row)
        fail_msg("%s on %d particles is missing", method->name, particles);
    const double step = number(row, "step_ns"), forces = number(row, "forces_ns"),
                 overhead = number(row, "overhead_ns");
    assert_true(step > 0 && forces > 0);
    assert_true(fabs(step - forces - overhead) <= 1e-9 * step);
    number(row, "overhead_share");
    number(row, "overhead_ns_per_force");
    /* A fixed step's forces, but for a first one. */
    const double each = number(row, "forces_per_step");
    if (method->forces > 0 && !(method->flags & DL_ADAPTIVE))
        assert_true(each >= method->forces && each <= method->forces + 1);
    else
        assert_true(each > 0);
}

static void the_measurements(void **state) {
    (void)state;
    json_t *const all = object_of("bench --quick --json --studies " DL_STUDIES, 0);
    const json_t *const overheads = json_object_get(all, "overhead");
    assert_int_equal(json_array_size(overheads), 2 * dl_method_count());
    for (size_t k = 0; k < dl_method_count(); k++) {
        check_overhead(overheads, dl_method_row_at(k), 2);
        check_overhead(overheads, dl_method_row_at(k), 34);
    }
    assert_true(json_is_boolean(
        json_object_get(row_of(overheads, "composition-2-verlet", 2), "target_met")));
    const json_t *const speeds = json_object_get(all, "speed");
    bool per_step = false, per_pair = false, per_iteration = false;
    for (size_t k = 0; k < json_array_size(speeds); k++) {
        const json_t *const row = json_array_get(speeds, k);
        assert_true(minimum(row, "time") > 0);
        per_step |= strcmp(text(row, "unit"), "ns/particle-step") == 0;
        per_pair |= strcmp(text(row, "unit"), "ns/ordered pair") == 0;
        per_iteration |= strcmp(text(row, "unit"), "ns/nonlinear iteration") == 0;
    }
    assert_true(per_step && per_pair && per_iteration);
    json_decref(all);
}

static void peers_and_starts(void **state) {
    (void)state;
    json_t *const all = object_of("bench --quick --json --studies " DL_STUDIES, 0);
    const json_t *const peers = json_object_get(all, "gsl"), *const starts =
                                                                 json_object_get(all, "start");
    assert_int_equal(json_array_size(peers), 12);
    for (size_t k = 0; k < json_array_size(peers); k++) {
        const json_t *const row = json_array_get(peers, k);
        assert_true(minimum(row, "ratio") > 0);
        /* The same steps: as many forces. */
        assert_true(number(row, "forces") == number(row, "peer_forces"));
    }
    assert_int_equal(json_array_size(starts), 3);
    for (size_t k = 0; k < json_array_size(starts); k++) {
        const json_t *const row = json_array_get(starts, k);
        assert_true(minimum(row, "cpu_seconds") > 0 && minimum(row, "wall_seconds") > 0);
    }
    text(json_object_get(all, "facts"), "processor");
    json_decref(all);
}

static void the_page(void **state) {
    (void)state;
    const outcome *const o = driftlab("bench --quick --studies " DL_STUDIES);
    assert_int_equal(o->exit, 0);
    static const char *const expected[] = {
        "- processor: ",          "ns/particle-step",        "ns/ordered pair",
        "ns/nonlinear iteration", "| leapfrog | pair | 2 |", "| arkode-mri | stream-v50 | 34 |",
        "| gsl-rk8pd | pair |",   "| swirl | 239 |"};
    for (size_t k = 0; k < sizeof expected / sizeof *expected; k++)
        if (!strstr(o->out, expected[k]))
            fail_msg("\"%s\" is missing", expected[k]);
}

static void what_is_refused(void **state) {
    (void)state;
    assert_non_null(strstr(driftlab("bench --help")->out, "usage: driftlab bench [OPTION"));
    static const char *const bad[] = {"bench --fast", "bench stream", "bench --studies nowhere"};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        const outcome *const o = driftlab(bad[k]);
        assert_int_equal(o->exit, 2);
        assert_string_equal(o->out, "");
        assert_true(strlen(o->err) > 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_measurements),
        cmocka_unit_test(peers_and_starts),
        cmocka_unit_test(the_page),
        cmocka_unit_test(what_is_refused),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
