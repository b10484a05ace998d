/* driftlab compare: two results files side by side. */
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"
#include "cli/json.h"
#include "cli/outcome.h"
#include "driftlab/compare.h"

typedef struct compare_values {
    bool json;
} compare_values;

static const dl_parameter options[] = {
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(compare_values, json),
     .fallback = "false",
     .doc = "print one JSON object instead of tables"},
};

/* --- text ---------------------------------------------------------------------------------- */

/* What is said of the two but in one of them only, or otherwise. */
static void print_facts(const dl_comparison *both) {
    for (size_t i = 0; i < both->a->facts; i++) {
        const dl_fact *fact = &both->a->fact[i];
        const char *other = dl_results_fact(both->b, fact->name);
        if (!other || strcmp(other, fact->value) != 0)
            printf("  %-12s A: %s\n  %-12s B: %s\n", fact->name, fact->value, "",
                   other ? other : "-");
    }
    for (size_t i = 0; i < both->b->facts; i++)
        if (!dl_results_fact(both->a, both->b->fact[i].name))
            printf("  %-12s A: -\n  %-12s B: %s\n", both->b->fact[i].name, "",
                   both->b->fact[i].value);
}

static void print_number(double value, int width) {
    if (isfinite(value))
        printf(" %*.3g", width, value);
    else
        printf(" %*s", width, "-");
}

static void print_case_pair(const dl_case_pair *pair) {
    const dl_case *a = pair->a, *b = pair->b;
    print_number(a->summary.cpu_seconds, 9);
    print_number(b->summary.cpu_seconds, 9);
    print_number(b->summary.cpu_seconds / a->summary.cpu_seconds, 6);
    printf(" %9lu %9lu", a->summary.force_evaluations, b->summary.force_evaluations);
    print_number(a->position_error, 9);
    print_number(b->position_error, 9);
    print_number(dl_case_error(a, "energy"), 9);
    print_number(dl_case_error(b, "energy"), 9);
    printf(" %s %s: %s %s%s\n", pair->same ? "=" : "*", a->scene, a->method, a->options,
           pair->same_key ? "" : "  (another scene or reference of that name)");
    if (a->summary.status != b->summary.status)
        printf("    A: %s %s\n    B: %s %s\n", dl_status_name(a->summary.status),
               a->summary.message, dl_status_name(b->summary.status), b->summary.message);
}

static void print_cases(const dl_comparison *both) {
    if (both->pairs == 0)
        return;
    printf("\n %9s %9s %6s %9s %9s %9s %9s %9s %9s\n", "CPU s A", "B", "B/A", "forces A", "B",
           "positn. A", "B", "energy A", "B");
    for (size_t i = 0; i < both->pairs; i++)
        print_case_pair(&both->pair[i]);
}

static const char *verdict_of(const dl_finding *finding) {
    return finding->status == DL_OK ? finding->verdict : dl_status_name(finding->status);
}

/* Quantities of a that b has otherwise. */
static void print_quantities(const dl_finding *a, const dl_finding *b) {
    const char *line = a->quantity_names;
    for (size_t i = 0; i < a->quantities; i++) {
        char name[128];
        const int length = (int)strcspn(line, "\n");
        snprintf(name, sizeof name, "%.*s", length, line);
        char *unit = strstr(name, " [");
        if (unit)
            *unit = '\0';
        const double *other = dl_finding_quantity(b, name), value = a->quantity[3 * i];
        if (!other || !(other[0] == value || (isnan(other[0]) && isnan(value))))
            printf("    %s: A %.6g, B %.6g\n", name, value, other ? other[0] : NAN);
        line += length + (line[length] == '\n');
    }
}

static void print_findings(const dl_comparison *both) {
    for (size_t i = 0; i < both->finding_pairs; i++) {
        const dl_finding_pair *pair = &both->finding_pair[i];
        printf("%s %s: %s %s  A: %s  B: %s%s\n", pair->same ? "=" : "*", pair->a->scene,
               pair->a->method, pair->a->options, verdict_of(pair->a), verdict_of(pair->b),
               pair->same_key ? "" : "  (another scene of that name)");
        print_quantities(pair->a, pair->b);
    }
}

static void print_alone(const dl_comparison *both, const dl_results *in, const char *name) {
    for (size_t i = 0; i < in->cases; i++)
        if (!dl_comparison_has_case(both, &in->cased[i]))
            printf("only in %s: %s: %s %s\n", name, in->cased[i].scene, in->cased[i].method,
                   in->cased[i].options);
    for (size_t i = 0; i < in->findings; i++)
        if (!dl_comparison_has_finding(both, &in->finding[i]))
            printf("only in %s: %s: %s %s\n", name, in->finding[i].scene, in->finding[i].method,
                   in->finding[i].options);
}

static void print_text(const dl_comparison *both, const char *path_a, const char *path_b) {
    printf("A: %s (%s)\nB: %s (%s)\n", path_a, both->a->study, path_b, both->b->study);
    print_facts(both);
    print_cases(both);
    print_findings(both);
    print_alone(both, both->a, "A");
    print_alone(both, both->b, "B");
    const size_t pairs = both->pairs + both->finding_pairs;
    printf("%zu in both, %zu of them alike in every count, error and verdict (=; * where not); %zu "
           "only in A, %zu only in B\n",
           pairs, both->same, both->only_a, both->only_b);
    if (isfinite(both->ratio_median))
        printf("CPU seconds, B/A: median %.3g (%.3g to %.3g)\n", both->ratio_median,
               both->ratio_least, both->ratio_most);
    if (both->ranked)
        printf("order by CPU seconds, among cases of a scene that differ by more than a fifth in "
               "A: %zu of %zu pairs the other way round in B\n",
               both->swapped, both->ranked);
}

/* --- JSON ---------------------------------------------------------------------------------- */

static json_t *json_case(const dl_case *cased) {
    return json_pack("{s:s,s:o,s:I,s:I,s:o,s:o}", "status", dl_status_name(cased->summary.status),
                     "cpu_seconds", cli_json_real(cased->summary.cpu_seconds), "force_evaluations",
                     (json_int_t)cased->summary.force_evaluations, "steps",
                     (json_int_t)cased->summary.steps, "position_error",
                     cli_json_real(cased->position_error), "energy_error",
                     cli_json_real(dl_case_error(cased, "energy")));
}

static json_t *json_pairs(const dl_comparison *both) {
    json_t *list = json_array();
    for (size_t i = 0; i < both->pairs; i++) {
        const dl_case_pair *pair = &both->pair[i];
        json_array_append_new(list,
                              json_pack("{s:s,s:s,s:s,s:b,s:b,s:o,s:o}", "scene", pair->a->scene,
                                        "method", pair->a->method, "options", pair->a->options,
                                        "same_key", pair->same_key, "same", pair->same, "a",
                                        json_case(pair->a), "b", json_case(pair->b)));
    }
    for (size_t i = 0; i < both->finding_pairs; i++) {
        const dl_finding_pair *pair = &both->finding_pair[i];
        json_array_append_new(list,
                              json_pack("{s:s,s:s,s:s,s:b,s:b,s:s,s:s}", "scene", pair->a->scene,
                                        "method", pair->a->method, "options", pair->a->options,
                                        "same_key", pair->same_key, "same", pair->same, "a",
                                        verdict_of(pair->a), "b", verdict_of(pair->b)));
    }
    return list;
}

static dl_status print_json(const dl_comparison *both, const char *path_a, const char *path_b,
                            dl_error *error) {
    json_t *root =
        json_pack("{s:s,s:s,s:o,s:I,s:I,s:I,s:o,s:o,s:o,s:I,s:I}", "a", path_a, "b", path_b,
                  "pairs", json_pairs(both), "same", (json_int_t)both->same, "only_a",
                  (json_int_t)both->only_a, "only_b", (json_int_t)both->only_b, "ratio_median",
                  cli_json_real(both->ratio_median), "ratio_least",
                  cli_json_real(both->ratio_least), "ratio_most", cli_json_real(both->ratio_most),
                  "ranked", (json_int_t)both->ranked, "swapped", (json_int_t)both->swapped);
    return cli_json_print(root, stdout, error);
}

static cli_exit compare(const cli_input *input) {
    const compare_values *values = input->values;
    dl_results *a = NULL, *b = NULL;
    dl_comparison both = {.pairs = 0};
    dl_error error = {""};
    dl_status status = dl_results_read(input->word[0], &a, &error);
    if (!status)
        status = dl_results_read(input->word[1], &b, &error);
    if (!status)
        status = dl_compare(a, b, &both, &error);
    if (!status && values->json)
        status = print_json(&both, input->word[0], input->word[1], &error);
    else if (!status)
        print_text(&both, input->word[0], input->word[1]);
    dl_comparison_release(&both);
    dl_results_free(a);
    dl_results_free(b);
    return cli_finish(status, &error);
}

const cli_command cli_command_compare = {
    .name = "compare",
    .arguments = "A.h5 B.h5",
    .summary = "set the results of two studies side by side",
    .details =
        "Two versions of the program, two machines, or the same twice: what agrees in every\n"
        "bit, how the times compare, and whether the order of the methods is the same.\n",
    .least_words = 2,
    .most_words = 2,
    .options = CLI_TABLE(options),
    .values_size = sizeof(compare_values),
    .run = compare,
};
