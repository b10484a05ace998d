#include <float.h>
#include <limits.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "driftlab/parameter.h"

typedef struct record {
    double step, reach, free_real;
    long order;
    bool dense;
    int solver;
    char *label;
} record;

static const char *const solvers[] = {"fixed-point", "newton", "krylov", NULL};

static const dl_parameter rows[] = {
    {"step", DL_REAL, offsetof(record, step), "time", 0, 10, true, NULL, NULL, "the step", NULL},
    {"reach", DL_REAL, offsetof(record, reach), "length", 0, INFINITY, false, NULL, "none",
     "the reach", "dense=true"},
    {"free_real", DL_REAL, offsetof(record, free_real), "", -INFINITY, INFINITY, false, NULL, "0.5",
     "any number", "solver=krylov|newton"},
    {"order", DL_INTEGER, offsetof(record, order), "", -2, 8, false, NULL, "4", "the order",
     "reach=none"},
    {"dense", DL_FLAG, offsetof(record, dense), "", 0, 0, false, NULL, "true", "a flag",
     "elsewhere=1"},
    {"solver", DL_WORD, offsetof(record, solver), "", 0, 0, false, solvers, "newton", "a word",
     NULL},
    {"label", DL_TEXT, offsetof(record, label), "", 0, 0, false, NULL, "a label", "a text", NULL},
};

static const dl_parameter_table table = {rows, sizeof rows / sizeof *rows};

static const dl_parameter *row_of(const char *name) {
    const dl_parameter *const row = dl_parameter_find(table, name);
    assert_non_null(row);
    return row;
}

static void defaults_are_set(void **state) {
    (void)state;
    record r = {.step = 7};
    assert_int_equal(dl_parameter_defaults(table, &r, NULL), DL_OK);
    assert_true(r.step == 7); /* required: left alone */
    assert_true(r.reach == INFINITY && r.free_real == 0.5 && r.order == 4 && r.dense);
    assert_int_equal(r.solver, 1);
    assert_string_equal(r.label, "a label");
    dl_parameter_release(table, &r);
    assert_null(r.label);
}

typedef struct accepted {
    const char *name, *text, *formatted;
} accepted;

static void texts_are_read_and_written_back(void **state) {
    (void)state;
    static const accepted cases[] = {
        {"step", "0.01", "0.01"},
        {"step", "1e-4", "0.0001"},
        {"step", "10", "10"},
        {"step", ".5", "0.5"},
        {"step", "+2.", "2"},
        {"reach", "none", "none"},
        {"reach", "0", "0"},
        {"reach", "1e300", "1e+300"},
        {"free_real", "-1E3", "-1000"},
        {"free_real", "-1e-310", "-1e-310"},
        {"order", "-2", "-2"},
        {"order", "+8", "8"},
        {"dense", "false", "false"},
        {"dense", "true", "true"},
        {"solver", "krylov", "krylov"},
        {"label", "", ""},
        {"label", "x y", "x y"},
    };
    record r = {0};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const dl_parameter *const row = row_of(cases[i].name);
        char text[64];
        assert_int_equal(dl_parameter_set(row, &r, cases[i].text, NULL), DL_OK);
        assert_int_equal(dl_parameter_format(row, &r, text, sizeof text),
                         strlen(cases[i].formatted));
        assert_string_equal(text, cases[i].formatted);
    }
    dl_parameter_release(table, &r);
}

typedef struct refused {
    const char *name, *text, *expected;
} refused;

static void other_texts_are_refused(void **state) {
    (void)state;
    static const refused cases[] = {
        {"step", "0", "a number > 0, <= 10"},
        {"step", "-1", "a number > 0, <= 10"},
        {"step", "10.000000001", "a number > 0, <= 10"},
        {"step", "none", "a number > 0, <= 10"},
        {"step", "nan", "a number > 0, <= 10"},
        {"step", "inf", "a number > 0, <= 10"},
        {"step", "0x1p-1", "a number > 0, <= 10"},
        {"step", " 1", "a number > 0, <= 10"},
        {"step", "1 ", "a number > 0, <= 10"},
        {"step", "1e", "a number > 0, <= 10"},
        {"step", "1,5", "a number > 0, <= 10"},
        {"step", "", "a number > 0, <= 10"},
        {"step", "--1", "a number > 0, <= 10"},
        {"step", "1e-400", "a number > 0, <= 10"},
        {"reach", "inf", "a number >= 0, or none"},
        {"reach", "infinity", "a number >= 0, or none"},
        {"reach", "1e999", "a number >= 0, or none"},
        {"reach", "None", "a number >= 0, or none"},
        {"free_real", "-inf", "a number"},
        {"free_real", "nan", "a number"},
        {"order", "9", "a whole number >= -2, <= 8"},
        {"order", "4.0", "a whole number >= -2, <= 8"},
        {"order", "1e0", "a whole number >= -2, <= 8"},
        {"order", "99999999999999999999", "a whole number >= -2, <= 8"},
        {"order", "", "a whole number >= -2, <= 8"},
        {"dense", "yes", "true | false"},
        {"dense", "True", "true | false"},
        {"solver", "newtom", "fixed-point | newton | krylov; did you mean \"newton\"?"},
        {"solver", "Fixed point", "did you mean \"fixed-point\"?"},
        {"solver", "zzzzzz", "fixed-point | newton | krylov"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        record r, before;
        memset(&r, 0x5a, sizeof r);
        before = r;
        dl_error error;
        const dl_parameter *const row = row_of(cases[i].name);
        if (dl_parameter_set(row, &r, cases[i].text, &error) != DL_INPUT)
            fail_msg("%s = \"%s\" was taken", cases[i].name, cases[i].text);
        assert_memory_equal(&r, &before, sizeof r);
        char start[128];
        snprintf(start, sizeof start, "%s: found \"%s\", expected ", cases[i].name, cases[i].text);
        assert_int_equal(strncmp(error.message, start, strlen(start)), 0);
        if (!strstr(error.message, cases[i].expected))
            fail_msg("\"%s\" lacks \"%s\"", error.message, cases[i].expected);
    }
}

static void no_word_is_suggested_where_none_is_near(void **state) {
    (void)state;
    assert_null(dl_closest_word(solvers, "zzzzzz"));
    assert_null(dl_closest_word(solvers, ""));
    assert_null(dl_parameter_closest(table, "wavelength"));
}

static void closest_match(void **state) {
    (void)state;
    static const char *const words[] = {
        "leapfrog", "composition-6-yoshida", "composition-8-yoshida", "velocity", "pair_law", NULL};
    assert_string_equal(dl_closest_word(words, "leap-frog"), "leapfrog");
    assert_string_equal(dl_closest_word(words, "laepfrog"), "leapfrog");
    assert_string_equal(dl_closest_word(words, "LEAPFROG"), "leapfrog");
    assert_string_equal(dl_closest_word(words, "composition-8-yosida"), "composition-8-yoshida");
    assert_string_equal(dl_closest_word(words, "yoshida"), "composition-6-yoshida");
    assert_string_equal(dl_closest_word(words, "vel"), "velocity");
    assert_string_equal(dl_closest_word(words, "pair-law"), "pair_law");
    assert_string_equal(dl_parameter_closest(table, "stpe"), "step");
    char endless[400];
    memset(endless, 'x', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    assert_null(dl_closest_word(words, endless));
}

static void ranges_as_text(void **state) {
    (void)state;
    static const char *const expected[] = {"> 0, <= 10",   ">= 0, or none",
                                           "a number",     ">= -2, <= 8",
                                           "true | false", "fixed-point | newton | krylov",
                                           "text"};
    for (size_t i = 0; i < table.count; i++) {
        char text[64], cut[5];
        const int length = dl_parameter_range(&rows[i], text, sizeof text);
        assert_string_equal(text, expected[i]);
        assert_int_equal(length, strlen(expected[i]));
        assert_int_equal(dl_parameter_range(&rows[i], cut, sizeof cut), length);
        assert_int_equal(strncmp(cut, expected[i], 4), 0);
        assert_true(strlen(cut) <= 4);
    }
}

static uint64_t next_random(uint64_t *state) {
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state;
}

static void check_round_trip(double value) {
    char text[40];
    const int length = dl_format_real(value, text, sizeof text);
    assert_int_equal(length, strlen(text));
    const double back = strtod(text, NULL);
    assert_memory_equal(&back, &value, sizeof value);
}

/* Every bit pattern that is a finite number reads back; 15-digit decimals keep their digits. */
static void reals_read_back(void **state) {
    (void)state;
    uint64_t random = 88172645463325252u;
    for (int i = 0; i < 100000; i++) {
        const uint64_t bits = next_random(&random);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (isfinite(value))
            check_round_trip(value);
    }
    static const double special[] = {0, -0.0, DBL_MIN, DBL_MAX, -DBL_MAX, 5e-324, 0.1, 1.0 / 3};
    for (size_t i = 0; i < sizeof special / sizeof *special; i++)
        check_round_trip(special[i]);
    static const char *const shortest[] = {"0.1",   "200",   "5e-324", "6.28318530717959",
                                           "1e-10", "0.0823"};
    for (size_t i = 0; i < sizeof shortest / sizeof *shortest; i++) {
        char text[40];
        dl_format_real(strtod(shortest[i], NULL), text, sizeof text);
        assert_string_equal(text, shortest[i]);
    }
}

static void messages_stay_one_short_valid_line(void **state) {
    (void)state;
    char text[128];
    dl_quote("two\nlines\x7f", text, sizeof text);
    assert_string_equal(text, "\"two?lines?\"");
    dl_quote("\xce\x94t = 1\xe2\x80\xb3 \xf0\x9f\x99\x82", text, sizeof text);
    assert_string_equal(text, "\"\xce\x94t = 1\xe2\x80\xb3 \xf0\x9f\x99\x82\"");
    /* a lone continuation, an overlong form, a surrogate, a character cut off */
    dl_quote("\x80|\xc0\xaf|\xe0\x80\xaf|\xed\xa0\x80|\xe2\x82", text, sizeof text);
    assert_string_equal(text, "\"?|"
                              "??|"
                              "???|"
                              "???|"
                              "??\"");
    char endless[5000];
    memset(endless, 'a', sizeof endless - 1);
    endless[sizeof endless - 1] = '\0';
    assert_true(dl_quote(endless, text, sizeof text) < 80);
    assert_non_null(strstr(text, "...\""));
}

/* A value is used where what its `when` names has one of the values there, and is used itself. */
static void conditions_hold(void **state) {
    (void)state;
    record r = {.step = 1};
    assert_int_equal(dl_parameter_defaults(table, &r, NULL), DL_OK);
    for (size_t i = 0; i < table.count; i++)
        assert_true(dl_parameter_applies(table, &rows[i], &r));
    assert_null(dl_parameter_cause(table, row_of("step")));
    assert_null(dl_parameter_cause(table, row_of("dense"))); /* of something that is not there */
    assert_ptr_equal(dl_parameter_cause(table, row_of("reach")), row_of("dense"));
    r.solver = 0;
    assert_false(dl_parameter_applies(table, row_of("free_real"), &r));
    r.solver = 2;
    assert_true(dl_parameter_applies(table, row_of("free_real"), &r));
    assert_true(dl_parameter_applies(table, row_of("order"), &r));
    r.dense = false; /* the reach is not used now, nor what depends on it */
    assert_false(dl_parameter_applies(table, row_of("reach"), &r));
    assert_false(dl_parameter_applies(table, row_of("order"), &r));
    r.dense = true;
    r.reach = 2;
    assert_false(dl_parameter_applies(table, row_of("order"), &r));
    dl_parameter_release(table, &r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(defaults_are_set),
        cmocka_unit_test(texts_are_read_and_written_back),
        cmocka_unit_test(other_texts_are_refused),
        cmocka_unit_test(no_word_is_suggested_where_none_is_near),
        cmocka_unit_test(closest_match),
        cmocka_unit_test(ranges_as_text),
        cmocka_unit_test(reals_read_back),
        cmocka_unit_test(messages_stay_one_short_valid_line),
        cmocka_unit_test(conditions_hold),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
