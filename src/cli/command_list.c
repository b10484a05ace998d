/* driftlab list: what there is to choose from. */
#include <stdio.h>
#include <string.h>

#include "cli/command.h"
#include "cli/help.h"
#include "cli/json.h"
#include "cli/outcome.h"
#include "driftlab/method.h"
#include "driftlab/observe.h"
#include "force/kernel.h"

typedef struct list_values {
    bool json;
} list_values;

static const dl_parameter options[] = {
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(list_values, json),
     .fallback = "false",
     .doc = "print one JSON array"},
};

/* --- methods -------------------------------------------------------------------------------- */

static void print_methods(FILE *out) {
    for (size_t i = 0; i < dl_method_count(); i++) {
        if (i)
            fputc('\n', out);
        cli_help_method(dl_method_row_at(i), out);
    }
}

/* Of the words of an option that are tables of coefficients; NULL where they are not. */
static json_t *tables_json(const dl_method_row *row, const dl_parameter *option) {
    dl_method_table table;
    if (!row->table || option->kind != DL_WORD || !row->table(option->words, 0, &table))
        return NULL;
    json_t *const list = json_array();
    for (size_t k = 0; option->words[k]; k++)
        if (row->table(option->words, k, &table))
            json_array_append_new(list, json_pack("{s:s, s:i, s:i}", "name", option->words[k],
                                                  "order", table.order, "stages", table.stages));
    return list;
}

static json_t *option_json(const dl_method_row *row, const dl_parameter *option) {
    char range[1024];
    dl_parameter_range(option, range, sizeof range);
    const char *const when = dl_parameter_cause(row->options, option) ? option->when : NULL;
    return json_pack("{s:s, s:s, s:s?, s:s, s:s, s:s?, s:o*}", "name", option->name, "range", range,
                     "default", option->fallback, "unit", option->unit, "doc", option->doc, "when",
                     when, "tables", tables_json(row, option));
}

static json_t *method_json(const dl_method_row *row) {
    json_t *properties = json_array(), *choices = json_array();
    dl_method_table step = {.order = row->order, .stages = row->stages};
    dl_method_default_table(row, &step);
    for (const cli_flag_word *flag = cli_flag_words; flag->flag; flag++)
        if (row->flags & flag->flag)
            json_array_append_new(properties, json_string(flag->words));
    for (size_t i = 0; i < row->options.count; i++)
        json_array_append_new(choices, option_json(row, &row->options.rows[i]));
    return json_pack("{s:s, s:s, s:s, s:i, s:i, s:s?, s:i, s:o, s:o}", "name", row->name, "family",
                     row->family, "doc", row->doc, "order", step.order, "stages", step.stages,
                     "made_of", row->made_of, "forces", row->forces, "properties", properties,
                     "options", choices);
}

static json_t *methods_json(void) {
    json_t *list = json_array();
    for (size_t i = 0; i < dl_method_count(); i++)
        json_array_append_new(list, method_json(dl_method_row_at(i)));
    return list;
}

/* --- names with a line each ----------------------------------------------------------------- */

typedef struct named {
    const char *name, *doc;
} named;

static json_t *named_json(const named *list, size_t count) {
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        json_array_append_new(array,
                              json_pack("{s:s, s:s}", "name", list[i].name, "doc", list[i].doc));
    return array;
}

static void print_named(const named *list, size_t count, FILE *out) {
    for (size_t i = 0; i < count; i++)
        fprintf(out, "%-18s %s\n", list[i].name, list[i].doc);
}

static size_t kernels(named *list) {
    static const dl_kernel_ops *const ops[] = {&dl_kernel_reference, &dl_kernel_all_pairs,
                                               &dl_kernel_neighbour_list, &dl_kernel_tree};
    const size_t count = sizeof ops / sizeof *ops;
    for (size_t i = 0; i < count; i++)
        list[i] = (named){ops[i]->name, ops[i]->doc};
    return count;
}

static void print_kernels(FILE *out) {
    named list[8] = {{NULL, NULL}};
    const size_t count = kernels(list);
    print_named(list, count, out);
}

static json_t *kernels_json(void) {
    named list[8] = {{NULL, NULL}};
    const size_t count = kernels(list);
    return named_json(list, count);
}

static size_t statuses(named *list) {
    static const char *const docs[] = {
        [DL_OK] = "the run reached its end",
        [DL_UNSTABLE] = "force, state or energy are no longer finite or bounded",
        [DL_NONLINEAR_FAILURE] = "an implicit step's equations were not solved",
        [DL_STEP_FAILURE] = "the method could not take a step",
        [DL_TIMEOUT] = "the limit on time was reached",
        [DL_INTERRUPTED] = "stopped by SIGINT or SIGTERM",
        [DL_INPUT] = "a file, option or value was refused",
        [DL_IO] = "reading or writing failed",
        [DL_MEMORY] = "an allocation failed",
        [DL_ERROR] = "anything else",
    };
    const size_t count = sizeof docs / sizeof *docs;
    for (size_t i = 0; i < count; i++)
        list[i] = (named){dl_status_name((dl_status)i), docs[i]};
    return count;
}

static void print_statuses(FILE *out) {
    named list[16] = {{NULL, NULL}};
    const size_t count = statuses(list);
    print_named(list, count, out);
}

static json_t *statuses_json(void) {
    named list[16] = {{NULL, NULL}};
    const size_t count = statuses(list);
    return named_json(list, count);
}

static size_t observables(named *list) {
    const size_t count = dl_observable_count();
    for (size_t i = 0; i < count; i++)
        list[i] = (named){dl_observable_at(i)->name, dl_observable_at(i)->doc};
    return count;
}

static void print_observables(FILE *out) {
    named list[16] = {{NULL, NULL}};
    const size_t count = observables(list);
    print_named(list, count, out);
}

static json_t *observables_json(void) {
    named list[16] = {{NULL, NULL}};
    const size_t count = observables(list);
    return named_json(list, count);
}

/* --- the command ---------------------------------------------------------------------------- */

static const struct {
    const char *name;
    void (*print)(FILE *out);
    json_t *(*json)(void);
} lists[] = {
    {"methods", print_methods, methods_json},
    {"kernels", print_kernels, kernels_json},
    {"statuses", print_statuses, statuses_json},
    {"observables", print_observables, observables_json},
};

static cli_exit list_command(const cli_input *input) {
    static const char *const names[] = {"methods", "kernels", "statuses", "observables", NULL};
    const list_values *values = input->values;
    const char *name = input->word[0];
    dl_error error = {""};
    for (size_t i = 0; i < sizeof lists / sizeof *lists; i++) {
        if (strcmp(lists[i].name, name) != 0)
            continue;
        if (values->json)
            return cli_finish(cli_json_print(lists[i].json(), stdout, &error), &error);
        lists[i].print(stdout);
        return CLI_OK;
    }
    const char *closest = dl_closest_word(names, name);
    dl_fail(&error, DL_INPUT,
            closest ? "list: found \"%s\", expected methods, kernels, statuses or observables; did "
                      "you mean "
                      "\"%s\"?"
                    : "list: found \"%s\", expected methods, kernels, statuses or observables",
            name, closest);
    return cli_finish(DL_INPUT, &error);
}

const cli_command cli_command_list = {
    .name = "list",
    .arguments = "WHAT",
    .summary =
        "methods | kernels | statuses | observables: what there is, with properties and options",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .values_size = sizeof(list_values),
    .run = list_command,
};
