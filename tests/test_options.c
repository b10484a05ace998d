/* No option of any method is ignored: it is refused where the others leave it unused, and makes a
 * difference everywhere else. */
#include "contract.h"

enum { length = 6 * 13, text_size = 512 };

/* What a run of a few steps leaves behind. */
typedef struct run {
    double y[length];
    dl_method_stats stats;
    dl_counts counts;
    dl_status status;
} run;

/* Of steps as a scene would have them, and of long ones that few iterations do not solve; so many
 * that predictors have their past. */
static const double scene_steps[] = {0.01, 0.2};
static const char few_iterations[] = "iterations=2";
enum { runs = sizeof scene_steps / sizeof *scene_steps, steps = 13 };

typedef struct outcome {
    run of[runs];
} outcome;

/* The cluster that collapses by a method; `text`: options, all of which it has. */
static dl_status try_run(const dl_method_row *row, const char *text, int k, run *found,
                         dl_error *error) {
    dl_scene *scene = fixture_cluster();
    scene->step = scene_steps[k];
    if (row->flags & DL_SPLITS_FORCE)
        fixture_split(scene);
    dl_model *model = NULL;
    dl_method *method = NULL;
    void *options = NULL;
    assert_int_equal(dl_model_create(scene, &model, error), DL_OK);
    dl_model_initial_state(model, found->y);
    assert_int_equal(dl_method_options_create(row, scene, &options, error), DL_OK);
    if (k > 0 && has_option(row, "iterations"))
        set_options(row, options, few_iterations);
    set_options(row, options, text);
    const dl_status status = dl_method_create(row, model, options, found->y, &method, error);
    for (int step = 0; !status && step < steps && !found->status; step++)
        found->status = dl_method_advance(method, 10, error);
    if (!status) {
        dl_method_stats_get(method, &found->stats);
        found->counts = model->counts;
        assert_int_equal(dl_method_state(method, found->y, NULL), DL_OK);
    }
    dl_method_destroy(method);
    dl_method_options_free(row, options);
    dl_model_free(model);
    dl_scene_free(scene);
    return status;
}

static dl_status try_out(const dl_method_row *row, const char *text, outcome *found,
                         dl_error *error) {
    memset(found, 0, sizeof *found);
    dl_status status = DL_OK;
    for (int k = 0; k < runs && !status; k++)
        status = try_run(row, text, k, &found->of[k], error);
    return status;
}

/* To the last bit. */
static bool is_same(const outcome *a, const outcome *b) {
    for (int k = 0; k < runs; k++) {
        const run *const one = &a->of[k], *const other = &b->of[k];
        if (one->status != other->status ||
            memcmp(&one->stats, &other->stats, sizeof one->stats) != 0 ||
            memcmp(&one->counts, &other->counts, sizeof one->counts) != 0 ||
            largest_difference(one->y, other->y, length) > 0)
            return false;
    }
    return true;
}

/* --- values ------------------------------------------------------------------------------------
 */

/* The k-th value to try of an option, "" where there are no more. */
static void value_at(const dl_parameter *option, int k, char value[64]) {
    static const double factors[] = {1e-3, 0.5, 2, 1e3, 1e6}, others[] = {0, 0.01, 0.02};
    const double usual = option->fallback ? strtod(option->fallback, NULL) : 0.01;
    value[0] = '\0';
    if (option->kind == DL_WORD) {
        int words = 0;
        while (words < k && option->words[words])
            words++;
        snprintf(value, 64, "%s", option->words[words] ? option->words[words] : "");
    } else if (option->kind == DL_FLAG && k < 2) {
        snprintf(value, 64, "%s", k ? "true" : "false");
    } else if (option->kind == DL_INTEGER && k < 3) {
        const double tried = k == 0 ? option->minimum : usual + (k == 1 ? 1 : 3);
        snprintf(value, 64, "%.0f", fmin(tried, option->maximum));
    } else if (option->kind == DL_REAL && k < (usual > 0 ? 5 : 3)) {
        const double tried = usual > 0 ? usual * factors[k] : others[k];
        snprintf(value, 64, "%.17g", fmin(tried, option->maximum));
    }
}

/* `option`'s cause at the first value that has it used, and the cause's own before it. */
static void write_causes(const dl_method_row *row, const dl_parameter *option, char *text) {
    const dl_parameter *const cause = dl_parameter_cause(row->options, option);
    if (!cause)
        return;
    write_causes(row, cause, text);
    const size_t used = strlen(text);
    snprintf(text + used, text_size - used, "%.*s ", (int)strcspn(option->when, "|"), option->when);
}

/* --- unused ------------------------------------------------------------------------------------
 */

static bool is_wanted(const char *when, const char *value) {
    const size_t size = strlen(value);
    for (const char *at = strchr(when, '='); at; at = strchr(at + 1, '|'))
        if (strncmp(at + 1, value, size) == 0 && (at[1 + size] == '|' || at[1 + size] == '\0'))
            return true;
    return false;
}

static int check_refusals(const dl_method_row *row, const dl_parameter *option) {
    const dl_parameter *const cause = dl_parameter_cause(row->options, option);
    int refusals = 0;
    char value[64], other[64];
    value_at(option, 0, value);
    for (int k = 0; value_at(cause, k, other), other[0]; k++) {
        if (is_wanted(option->when, other))
            continue;
        char text[text_size] = "";
        write_causes(row, cause, text);
        const size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s=%s %s=%s", cause->name, other, option->name,
                 value);
        outcome found;
        dl_error error = {""};
        if (try_out(row, text, &found, &error) != DL_INPUT)
            fail_msg("%s %s: taken", row->name, text);
        if (!strstr(error.message, row->name) || !strstr(error.message, option->name) ||
            !strstr(error.message, option->when))
            fail_msg("%s %s: \"%s\"", row->name, text, error.message);
        refusals++;
    }
    return refusals;
}

static void unused_options_are_refused(void **state) {
    (void)state;
    int refusals = 0;
    FOR_EACH_ROW(row) {
        for (size_t i = 0; i < row->options.count; i++)
            if (dl_parameter_cause(row->options, &row->options.rows[i]))
                refusals += check_refusals(row, &row->options.rows[i]);
    }
    print_message("%d refusals\n", refusals);
    assert_true(refusals > 50);
}

/* --- used --------------------------------------------------------------------------------------
 */

/* Coefficients differ in one number at least, if only in the error estimate. */
static bool chooses_a_table(const dl_parameter *option) {
    const size_t size = strlen(option->name);
    return size >= 5 && strcmp(option->name + size - 5, "table") == 0;
}

/* Some value of an option makes a difference to another, beside `others`; `all`: every one does to
 * every other. */
static void check_use(const dl_method_row *row, const dl_parameter *option, const char *others,
                      bool all) {
    enum { most_values = 40 };
    outcome *const found = calloc(most_values, sizeof *found);
    assert_non_null(found);
    int values = 0, differences = 0;
    char value[64];
    for (int k = 0; k < most_values && (all || !differences); k++) {
        char text[text_size];
        value_at(option, k, value);
        if (!value[0])
            break;
        snprintf(text, sizeof text, "%s%s=%s", others, option->name, value);
        dl_error error = {""};
        const dl_status status = try_out(row, text, &found[values], &error);
        if (status == DL_INPUT) /* does not go together with the others, and says so */
            continue;
        if (status)
            fail_msg("%s %s: %s", row->name, text, error.message);
        for (int before = 0; before < values; before++) {
            const bool same = is_same(&found[before], &found[values]);
            differences += !same;
            if (same && all)
                fail_msg("%s %s: as with another value", row->name, text);
        }
        values++;
    }
    if (differences == 0)
        fail_msg("%s %s: %s makes no difference", row->name, others, option->name);
    free(found);
}

/* Whether the method works otherwise with another value: it chooses its step, or others depend on
 * it. */
static bool is_switch(const dl_method_row *row, const dl_parameter *option) {
    bool found = strcmp(option->name, "step") == 0 && option->fallback;
    for (size_t i = 0; i < row->options.count; i++)
        found |= dl_parameter_cause(row->options, &row->options.rows[i]) == option;
    return found;
}

/* Beside every value of `beside`. */
static void check_use_beside(const dl_method_row *row, const dl_parameter *option,
                             const dl_parameter *beside) {
    char value[64];
    for (int k = 0; value_at(beside, k, value), value[0]; k++) {
        const bool is_cause = dl_parameter_cause(row->options, option) == beside;
        if (is_cause && !is_wanted(option->when, value))
            continue;
        char text[text_size] = "";
        if (!is_cause)
            write_causes(row, option, text);
        const size_t used = strlen(text);
        snprintf(text + used, sizeof text - used, "%s=%s ", beside->name, value);
        check_use(row, option, text, false);
    }
}

static void used_options_make_a_difference(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        for (size_t i = 0; i < row->options.count; i++) {
            const dl_parameter *const option = &row->options.rows[i];
            char text[text_size] = "";
            write_causes(row, option, text);
            check_use(row, option, text, chooses_a_table(option));
            for (size_t k = 0; k < row->options.count; k++)
                if (k != i && is_switch(row, &row->options.rows[k]))
                    check_use_beside(row, option, &row->options.rows[k]);
        }
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(unused_options_are_refused),
        cmocka_unit_test(used_options_make_a_difference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
