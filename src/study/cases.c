/* `cases`: each entry names a method, or all of a group, and, for any of its options, a value or a
 * list of values; it stands for the Cartesian product, in the order of the file (the last list
 * varies fastest). */
#include <stdlib.h>
#include <string.h>
#include "study/plan.h"

enum { most_options = 64, most_cases = 100000 };

/* An entry while it is expanded. */
typedef struct entry {
    const dl_method_row *row;
    size_t options;
    const char *key[most_options];
    const dl_yaml_node *values[most_options];
    size_t chosen[most_options]; /* index in each list */
    int line;
} entry;

/* Words in the place of a method's name: every method with that flag that has the options named
 * with it. Those that split the force, which few scenes do, are named one by one. */
static const struct {
    const char *word;
    unsigned flag; /* 0: any */
} groups[] = {
    {"all", 0},
    {"all-fixed-step", DL_FIXED_STEP},
    {"all-adaptive", DL_ADAPTIVE},
};

enum { group_count = sizeof groups / sizeof *groups };

/* The group that an entry names, or group_count. */
static size_t group_of(const dl_yaml_node *map) {
    const dl_yaml_node *node =
        dl_yaml_kind_of(map) == DL_YAML_MAP ? dl_yaml_get(map, "method") : NULL;
    size_t group = 0;
    while (group < group_count && (!node || dl_yaml_kind_of(node) != DL_YAML_SCALAR ||
                                   strcmp(dl_yaml_text(node), groups[group].word) != 0))
        group++;
    return group;
}

static bool has_options(const dl_method_row *row, const dl_yaml_node *map) {
    for (size_t i = 0; i < dl_yaml_length(map); i++)
        if (strcmp(dl_yaml_key(map, i), "method") != 0 &&
            !dl_parameter_find(row->options, dl_yaml_key(map, i)))
            return false;
    return true;
}

static bool is_in(const dl_method_row *row, size_t group, const dl_yaml_node *map) {
    return (row->flags & groups[group].flag) == groups[group].flag &&
           !(row->flags & DL_SPLITS_FORCE) && has_options(row, map);
}

static size_t choices(const dl_yaml_node *values) {
    return dl_yaml_kind_of(values) == DL_YAML_LIST ? dl_yaml_length(values) : 1;
}

static const dl_yaml_node *choice(const dl_yaml_node *values, size_t i) {
    return dl_yaml_kind_of(values) == DL_YAML_LIST ? dl_yaml_item(values, i) : values;
}

static dl_status check_values(const dl_yaml *yaml, const char *key, const dl_yaml_node *values,
                              dl_error *error) {
    static const char expected[] = "a value or a list of values";
    if (dl_yaml_kind_of(values) == DL_YAML_MAP || choices(values) == 0)
        return dl_yaml_fail(yaml, values, key, expected, error);
    for (size_t i = 0; i < choices(values); i++)
        if (dl_yaml_kind_of(choice(values, i)) != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, choice(values, i), key, expected, error);
    return DL_OK;
}

/* `row` NULL: that of the method the entry names. */
static dl_status read_entry(const dl_yaml *yaml, const dl_yaml_node *map, const dl_method_row *row,
                            entry *read, dl_error *error) {
    *read = (entry){.line = dl_yaml_line(map), .row = row};
    dl_status status = row ? DL_OK : dl_study_find_method(yaml, map, &read->row, error);
    for (size_t i = 0; status == DL_OK && i < dl_yaml_length(map); i++) {
        const char *key = dl_yaml_key(map, i);
        if (strcmp(key, "method") == 0)
            continue;
        if (read->options == most_options)
            return dl_yaml_fail(yaml, map, read->row->name, "fewer options", error);
        status = check_values(yaml, key, dl_yaml_item(map, i), error);
        read->key[read->options] = key;
        read->values[read->options++] = dl_yaml_item(map, i);
    }
    return status;
}

/* The next combination; false after the last. */
static bool advance_choice(entry *read) {
    for (size_t i = read->options; i-- > 0;) {
        if (++read->chosen[i] < choices(read->values[i]))
            return true;
        read->chosen[i] = 0;
    }
    return false;
}

static dl_status check_new(const dl_study *study, const dl_study_case *added, dl_error *error) {
    for (size_t i = 0; i < study->cases; i++)
        if (strcmp(study->cased[i].key, added->key) == 0)
            return dl_fail(error, DL_INPUT,
                           "%s:%d: cases: found %s %s a second time, expected each case once "
                           "(first on line %d)",
                           study->path, added->line, added->run.row->name, added->run.text,
                           study->cased[i].line);
    return DL_OK;
}

static void release_case(dl_study_case *cased) {
    dl_study_run_of_release(&cased->run);
    free(cased->key);
    free(cased->command);
}

static dl_status append_case(dl_study *study, const dl_study_case *added, dl_error *error) {
    if (study->cases == most_cases)
        return dl_fail(error, DL_INPUT, "%s:%d: cases: found more than %d cases, expected fewer",
                       study->path, added->line, most_cases);
    dl_study_case *grown = realloc(study->cased, (study->cases + 1) * sizeof *grown);
    if (!grown)
        return dl_fail_memory(error, "cases");
    study->cased = grown;
    grown[study->cases++] = *added;
    return DL_OK;
}

/* The combination that is chosen now, on one scene. */
static dl_status add_case(dl_study *study, size_t scene, const entry *read, dl_error *error) {
    const char *value[most_options];
    int line[most_options + 1];
    line[0] = read->line;
    for (size_t i = 0; i < read->options; i++) {
        const dl_yaml_node *node = choice(read->values[i], read->chosen[i]);
        value[i] = dl_yaml_text(node);
        line[i + 1] = dl_yaml_line(node);
    }
    dl_study_case added = {.scene = scene, .line = read->line};
    dl_status status = dl_study_prepare(study, &study->scene[scene], read->row, read->options,
                                        read->key, value, line, &added.run, error);
    if (status == DL_OK) {
        added.key = dl_study_case_key(study, &added);
        added.command = dl_study_case_command(study, &added);
        status = added.key && added.command ? check_new(study, &added, error)
                                            : dl_fail_memory(error, "a case");
    }
    if (status == DL_OK)
        status = append_case(study, &added, error);
    if (status != DL_OK)
        release_case(&added);
    return status;
}

static dl_status expand(dl_study *study, size_t scene, entry *read, dl_error *error) {
    dl_status status;
    do
        status = add_case(study, scene, read, error);
    while (status == DL_OK && advance_choice(read));
    return status;
}

/* The entry's cases with one method. */
static dl_status add_entry(dl_study *study, const dl_yaml *yaml, size_t scene,
                           const dl_yaml_node *map, const dl_method_row *row, dl_error *error) {
    entry read;
    const dl_status status = read_entry(yaml, map, row, &read, error);
    return status == DL_OK ? expand(study, scene, &read, error) : status;
}

static dl_status add_entries(dl_study *study, const dl_yaml *yaml, size_t scene,
                             const dl_yaml_node *map, dl_error *error) {
    const size_t group = group_of(map);
    if (group == group_count)
        return add_entry(study, yaml, scene, map, NULL, error);
    dl_status status = DL_OK;
    const size_t before = study->cases;
    for (size_t k = 0; k < dl_method_count() && status == DL_OK; k++) {
        const dl_method_row *row = dl_method_row_at(k);
        if (is_in(row, group, map))
            status = add_entry(study, yaml, scene, map, row, error);
    }
    if (status == DL_OK && study->cases == before)
        return dl_yaml_fail(yaml, map, groups[group].word, "options that a method of the group has",
                            error);
    return status;
}

dl_status dl_study_read_cases(dl_study *study, const dl_yaml *yaml, const dl_yaml_node *cases,
                              dl_error *error) {
    if (!cases || dl_yaml_kind_of(cases) != DL_YAML_LIST || dl_yaml_length(cases) == 0)
        return dl_yaml_fail(yaml, cases, "cases", "a list of methods with their options", error);
    dl_status status = DL_OK;
    for (size_t s = 0; s < study->scenes; s++)
        for (size_t i = 0; i < dl_yaml_length(cases) && status == DL_OK; i++)
            status = add_entries(study, yaml, s, dl_yaml_item(cases, i), error);
    return status;
}
