/* The study file: its tables, its reader and its help. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "study/kepler.h"
#include "study/kind.h"
#include "study/variants.h"

const char *const dl_study_measures[] = {"position", "energy", NULL};

#define AT(type, field) .offset = offsetof(type, field)
#define TABLE(rows_of)                                                                             \
    { .rows = rows_of, .count = sizeof rows_of / sizeof *rows_of }

static const dl_parameter setting_rows[] = {
    {.name = "name",
     .kind = DL_TEXT,
     AT(dl_study_settings, name),
     .unit = "",
     .fallback = NULL,
     .doc = "name of the study; a results file belongs to one study"},
    {.name = "title",
     .kind = DL_TEXT,
     AT(dl_study_settings, title),
     .unit = "",
     .fallback = "",
     .doc = "heading of the report"},
    {.name = "kind",
     .kind = DL_WORD,
     AT(dl_study_settings, kind),
     .unit = "",
     .words = dl_study_kinds,
     .fallback = "work-precision",
     .doc = "what is asked (see below)"},
    {.name = "question",
     .kind = DL_TEXT,
     AT(dl_study_settings, question),
     .unit = "",
     .fallback = "",
     .doc = "the question in words, for the report"},
    {.name = "scene",
     .kind = DL_TEXT,
     AT(dl_study_settings, scene),
     .unit = "",
     .fallback = "",
     .doc = "scene file, relative to the study's folder"},
    {.name = "end",
     .kind = DL_REAL,
     AT(dl_study_settings, end),
     .unit = "time",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "0",
     .doc = "end of every run; 0: the scene's own"},
    {.name = "samples",
     .kind = DL_INTEGER,
     AT(dl_study_settings, samples),
     .unit = "",
     .minimum = 0,
     .maximum = DL_MOST_SAMPLES,
     .fallback = "0",
     .doc = "equal intervals between samples, which fixed steps must divide; 0: 20, or as many as "
            "the kind says below"},
    {.name = "error",
     .kind = DL_REAL,
     AT(dl_study_settings, asked_error),
     .unit = "length or 1",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "0",
     .doc = "error asked for: RMS position at the end, or energy in units of its scale; > 0"},
    {.name = "in",
     .kind = DL_WORD,
     AT(dl_study_settings, asked_in),
     .unit = "",
     .words = dl_study_measures,
     .fallback = "position",
     .doc = "what `error` is an error of"},
    {.name = "repeats",
     .kind = DL_INTEGER,
     AT(dl_study_settings, repeats),
     .unit = "",
     .minimum = 1,
     .maximum = 1000,
     .fallback = "3",
     .doc = "runs of each case for its CPU time (minimum and median); only the first is observed"},
};

static const dl_parameter limit_rows[] = {
    {.name = "seconds",
     .kind = DL_REAL,
     AT(dl_study_limits, seconds),
     .unit = "CPU s",
     .minimum = 0,
     .maximum = 1e7,
     .above_minimum = true,
     .fallback = "60",
     .doc = "of one run; a case that takes longer is stopped and stays so until --force"},
    {.name = "memory",
     .kind = DL_INTEGER,
     AT(dl_study_limits, memory),
     .unit = "MiB",
     .minimum = 64,
     .maximum = 1 << 24,
     .fallback = "4096",
     .doc = "address space of a case's process"},
};

/* "none" and, one further on, the precisions. */
static const char *const extended_words[] = {"none", "auto", "long-double", "quad", NULL};
const char *const *const dl_precision_words = extended_words + 1;

typedef struct reference_settings {
    char *method, *exact;
    int extended;
    double seconds;
} reference_settings;

static const dl_parameter reference_rows[] = {
    {.name = "method",
     .kind = DL_TEXT,
     AT(reference_settings, method),
     .unit = "",
     .fallback = "",
     .doc = "method of the reference run"},
    {.name = "exact",
     .kind = DL_TEXT,
     AT(reference_settings, exact),
     .unit = "",
     .fallback = "",
     .doc = "kepler: two bodies that attract by c/r^2, solved analytically; instead of method"},
    {.name = "extended",
     .kind = DL_WORD,
     AT(reference_settings, extended),
     .unit = "",
     .words = extended_words,
     .fallback = "none",
     .doc = "extended precision with an error of its own that is measured; auto: long double, and "
            "quad where a case needs it; instead of method"},
    {.name = "seconds",
     .kind = DL_REAL,
     AT(reference_settings, seconds),
     .unit = "CPU s",
     .minimum = 0,
     .maximum = 1e7,
     .above_minimum = true,
     .fallback = "300",
     .doc = "limit of each of the reference's runs"},
};

static const char *const setting_others[] = {"scenes", "let",  "limits", "reference",
                                             "cases",  "with", NULL};
static const char *const reference_others[] = {"set", "check", NULL};
static const char *const check_keys[] = {"method", "set", NULL};
static const dl_parameter_table settings_table = TABLE(setting_rows);
const dl_parameter_table dl_study_limits_table = TABLE(limit_rows);
static const dl_parameter_table reference_table = TABLE(reference_rows);

/* --- help ---------------------------------------------------------------------------------- */

static void print_table(FILE *out, const char *indent, dl_parameter_table table) {
    for (size_t i = 0; i < table.count; i++) {
        const dl_parameter *row = &table.rows[i];
        char range[256];
        dl_parameter_range(row, range, sizeof range);
        fprintf(out, "%s%-10s %s\n", indent, row->name, row->doc);
        fprintf(out, "%s%-10s %s%s%s; %s%s\n", indent, "", range, *row->unit ? ", in " : "",
                row->unit, row->fallback ? "default " : "required",
                !row->fallback ? "" : (*row->fallback ? row->fallback : "none"));
    }
}

void dl_study_help(FILE *out) {
    fputs("A study file (YAML) asks one kind of question of every case on every scene.\n\n"
          "keys:\n",
          out);
    print_table(out, "  ", settings_table);
    fputs("  scenes     list of scene files, instead of `scene`\n"
          "  let        mapping of names in the scenes' `let` to a number or a list of numbers: "
          "each\n"
          "             scene once for every combination\n"
          "\nlimits:      of every case's process\n",
          out);
    print_table(out, "  ", dl_study_limits_table);
    fputs(
        "\nreference:   what position errors are measured against; may be left out where `in` is\n"
        "             energy\n",
        out);
    print_table(out, "  ", reference_table);
    fputs("  set        mapping of the method's options to values\n"
          "  check      mapping with method and set: a second run, whose distance from the first\n"
          "             is the reference's own error; required beside method\n"
          "\ncases:       list of mappings, each with\n"
          "  method     name of a method (driftlab list methods), or all, all-fixed-step,\n"
          "             all-adaptive: every one, every one with a fixed step, every one that can\n"
          "             choose its steps, as far as it has the options named; but none that\n"
          "             splits the force\n"
          "  OPTION     a value or a list of values of any of its options; an entry stands for\n"
          "             every combination\n",
          out);
    for (size_t k = 0; dl_study_kinds[k]; k++) {
        const dl_study_kind *kind = dl_study_kind_rows[k];
        fprintf(out, "\nkind %s: %s\n", dl_study_kinds[k], kind->doc);
        if (!kind->measure)
            fputs("  the only one with `error`, `in`, `repeats` and `reference`\n", out);
        if (kind->chooses_step)
            fputs("  chooses the steps of its runs itself: cases have no `step`\n", out);
        if (kind->samples)
            fprintf(out, "  %ld samples where the study does not say\n", kind->samples);
        if (kind->settings.count)
            fputs("with:\n", out);
        print_table(out, "  ", kind->settings);
    }
}

/* --- scenes -------------------------------------------------------------------------------- */

static char *beside(const char *study_path, const char *path) {
    const char *slash = strrchr(study_path, '/');
    if (*path == '/' || !slash)
        return dl_text("%s", path);
    return dl_text("%.*s/%s", (int)(slash - study_path), study_path, path);
}

/* `let` [lets]: what the study sets in it. */
static dl_status add_scene(dl_study *study, const dl_yaml *yaml, const dl_yaml_node *node,
                           size_t lets, const dl_let *let, dl_error *error) {
    if (dl_yaml_kind_of(node) != DL_YAML_SCALAR || !*dl_yaml_text(node))
        return dl_yaml_fail(yaml, node, "scene", "the name of a scene file", error);
    dl_study_scene *on = &study->scene[study->scenes];
    study->scenes++; /* from here on freed with the study */
    on->path = beside(study->path, dl_yaml_text(node));
    on->lets = dl_let_arguments(lets, let);
    if (!on->path || !on->lets)
        return dl_fail_memory(error, "a scene");
    dl_error reason;
    dl_status status = dl_scene_read_let(on->path, lets, let, &on->scene, &reason);
    if (status != DL_OK)
        return dl_fail(error, status, "%s:%d: %.900s", study->path, dl_yaml_line(node),
                       reason.message);
    on->hash = dl_scene_hash(on->scene);
    on->end = study->settings.end > 0 ? study->settings.end : on->scene->end;
    on->sample = on->end / (double)study->settings.samples;
    on->sample_chosen = study->samples_chosen;
    for (size_t i = 0; i + 1 < study->scenes; i++)
        if (strcmp(study->scene[i].scene->name, on->scene->name) == 0)
            return dl_yaml_fail(yaml, node, "scene", "scenes of different names", error);
    return DL_OK;
}

static dl_status read_scenes(dl_study *study, const dl_yaml *yaml, dl_error *error) {
    const dl_yaml_node *root = dl_yaml_root(yaml), *one = dl_yaml_get(root, "scene");
    const dl_yaml_node *several = dl_yaml_get(root, "scenes");
    if (!one == !several)
        return dl_yaml_fail(yaml, several, "scene", "either `scene` or `scenes`", error);
    if (several && (dl_yaml_kind_of(several) != DL_YAML_LIST || dl_yaml_length(several) == 0))
        return dl_yaml_fail(yaml, several, "scenes", "a list of scene files", error);
    dl_variants variants;
    dl_let let[dl_most_let_lists];
    dl_status status = dl_variants_read(yaml, dl_yaml_get(root, "let"), &variants, error);
    if (status != DL_OK)
        return status;
    size_t count = several ? dl_yaml_length(several) : 1;
    study->scene = calloc(count * variants.count, sizeof *study->scene);
    if (!study->scene)
        return dl_fail_memory(error, "scenes");
    for (size_t i = 0; i < count * variants.count && status == DL_OK; i++) {
        const dl_yaml_node *node = several ? dl_yaml_item(several, i / variants.count) : one;
        dl_variants_at(&variants, i % variants.count, let);
        status = add_scene(study, yaml, node, variants.names, let, error);
    }
    return status;
}

/* --- reference ----------------------------------------------------------------------------- */

enum { most_settings = 64 };

/* `method` and `set` of a mapping, on one scene. */
static dl_status read_run(const dl_study *study, const dl_study_scene *on, const dl_yaml *yaml,
                          const dl_yaml_node *map, dl_study_run_of *run, dl_error *error) {
    const dl_method_row *row;
    dl_status status = dl_study_find_method(yaml, map, &row, error);
    if (status != DL_OK)
        return status;
    const char *key[most_settings], *value[most_settings];
    int line[most_settings + 1] = {dl_yaml_line(map)};
    const dl_yaml_node *set = dl_yaml_get(map, "set");
    if (set && (dl_yaml_kind_of(set) != DL_YAML_MAP || dl_yaml_length(set) > most_settings))
        return dl_yaml_fail(yaml, set, "set", "a mapping of options to values", error);
    size_t count = set ? dl_yaml_length(set) : 0;
    for (size_t i = 0; i < count; i++) {
        const dl_yaml_node *item = dl_yaml_item(set, i);
        if (dl_yaml_kind_of(item) != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, item, dl_yaml_key(set, i), "one value", error);
        key[i] = dl_yaml_key(set, i);
        value[i] = dl_yaml_text(item);
        line[i + 1] = dl_yaml_line(item);
    }
    return dl_study_prepare(study, on, row, count, key, value, line, run, error);
}

static dl_status read_reference_runs(dl_study *study, dl_study_scene *on, const dl_yaml *yaml,
                                     const dl_yaml_node *map, dl_error *error) {
    const dl_yaml_node *check = dl_yaml_get(map, "check");
    if (!check)
        return dl_yaml_fail(yaml, map, "check",
                            "a second run that measures the reference's own error", error);
    dl_status status =
        dl_yaml_read_table(yaml, check, (dl_parameter_table){NULL, 0}, check_keys, NULL, error);
    if (status == DL_OK)
        status = read_run(study, on, yaml, map, &on->reference, error);
    if (status == DL_OK)
        status = read_run(study, on, yaml, check, &on->check, error);
    if (status == DL_OK && on->reference.row == on->check.row &&
        strcmp(on->reference.text, on->check.text) == 0)
        status = dl_yaml_fail(yaml, check, "check",
                              "another method or other options than the reference's", error);
    if (status != DL_OK)
        return status;
    on->reference_text = dl_text("%s %s; own error by %s %s", on->reference.row->name,
                                 on->reference.text, on->check.row->name, on->check.text);
    return on->reference_text ? DL_OK : dl_fail_memory(error, "a reference");
}

static dl_status read_exact(const dl_study *study, dl_study_scene *on, const dl_yaml_node *map,
                            dl_error *error) {
    dl_error reason;
    dl_status status = dl_kepler_check(on->scene, &reason);
    if (status != DL_OK)
        return dl_fail(error, status, "%s:%d: exact: %.900s", study->path, dl_yaml_line(map),
                       reason.message);
    on->reference_text = dl_text("%s", "exact two-body motion (Kepler's equation)");
    return on->reference_text ? DL_OK : dl_fail_memory(error, "a reference");
}

/* method or exact, and which of them. */
static dl_status reference_kind(dl_study *study, const dl_yaml *yaml, const dl_yaml_node *map,
                                dl_error *error) {
    reference_settings settings = {0};
    dl_status status =
        dl_yaml_read_table(yaml, map, reference_table, reference_others, &settings, error);
    if (status == DL_OK) {
        bool exact = *settings.exact, runs = *settings.method, extended = settings.extended > 0;
        study->reference = exact      ? DL_REFERENCE_EXACT
                           : extended ? DL_REFERENCE_EXTENDED
                                      : DL_REFERENCE_RUNS;
        study->precision = (dl_precision)(settings.extended - extended);
        study->reference_seconds = settings.seconds;
        if (exact + runs + extended != 1)
            status = dl_yaml_fail(yaml, map, "reference", "either `method`, `exact` or `extended`",
                                  error);
        else if (exact && strcmp(settings.exact, "kepler") != 0)
            status = dl_yaml_fail(yaml, dl_yaml_get(map, "exact"), "exact", "kepler", error);
        else if (!runs && (dl_yaml_get(map, "set") || dl_yaml_get(map, "check")))
            status =
                dl_yaml_fail(yaml, map, "reference", "no `set` or `check` without `method`", error);
    }
    dl_parameter_release(reference_table, &settings);
    return status;
}

static dl_status read_reference(dl_study *study, const dl_yaml *yaml, dl_error *error) {
    const dl_yaml_node *map = dl_yaml_get(dl_yaml_root(yaml), "reference");
    const bool energy = strcmp(dl_study_measures[study->settings.asked_in], "energy") == 0;
    if (!map && (energy || study->kind->measure))
        return DL_OK;
    if (!map)
        return dl_yaml_fail(yaml, NULL, "reference", "what position errors are measured against",
                            error);
    dl_status status = reference_kind(study, yaml, map, error);
    for (size_t s = 0; s < study->scenes && status == DL_OK; s++) {
        dl_study_scene *on = &study->scene[s];
        status = study->reference == DL_REFERENCE_EXACT ? read_exact(study, on, map, error)
                 : study->reference == DL_REFERENCE_RUNS
                     ? read_reference_runs(study, on, yaml, map, error)
                     : DL_OK;
        if (status == DL_OK && !(on->reference_key = dl_study_reference_key(study, on)))
            status = dl_fail_memory(error, "a reference");
    }
    return status;
}

/* --- the whole ----------------------------------------------------------------------------- */

static dl_status read_limits(dl_study *study, const dl_yaml *yaml, dl_error *error) {
    const dl_yaml_node *map = dl_yaml_get(dl_yaml_root(yaml), "limits");
    return map ? dl_yaml_read_table(yaml, map, dl_study_limits_table, NULL, &study->limits, error)
               : dl_parameter_defaults(dl_study_limits_table, &study->limits, error);
}

/* Keys that only a work-precision study has. */
static dl_status check_keys_of_kind(const dl_study *study, const dl_yaml *yaml, dl_error *error) {
    static const char *const of_precision[] = {"error", "in", "repeats", "reference", NULL};
    const dl_yaml_node *root = dl_yaml_root(yaml);
    char expected[128];
    if (!study->kind->measure)
        return study->settings.asked_error > 0
                   ? DL_OK
                   : dl_yaml_missing(yaml, root, "error", "the error that is asked for", error);
    snprintf(expected, sizeof expected, "no such key in a study of kind %s",
             dl_study_kinds[study->settings.kind]);
    for (const char *const *key = of_precision; *key; key++)
        if (dl_yaml_get(root, *key))
            return dl_yaml_fail(yaml, dl_yaml_get(root, *key), *key, expected, error);
    return DL_OK;
}

/* "refine=6 bound=0.1": the kind's settings, for what identifies a finding. */
char *dl_study_settings_text(const dl_study_kind *kind, const void *settings) {
    char *text = dl_text("%s", "");
    for (size_t i = 0; i < kind->settings.count && text; i++) {
        char value[1024];
        dl_parameter_format(&kind->settings.rows[i], settings, value, sizeof value);
        char *longer = dl_text("%s%s%s=%s", text, i ? " " : "", kind->settings.rows[i].name, value);
        free(text);
        text = longer;
    }
    return text;
}

/* What the file sets of them, as the command line would. */
static char *settings_changes(const dl_yaml_node *with) {
    char *text = dl_text("%s", "");
    for (size_t i = 0; with && i < dl_yaml_length(with) && text; i++) {
        char *longer = dl_text("%s --set %s=%s", text, dl_yaml_key(with, i),
                               dl_yaml_text(dl_yaml_item(with, i)));
        free(text);
        text = longer;
    }
    return text;
}

long dl_study_samples_of(const dl_study_kind *kind) {
    return kind->samples ? kind->samples : 20;
}

static dl_status read_kind(dl_study *study, const dl_yaml *yaml, dl_error *error) {
    const dl_study_kind *kind = study->kind = dl_study_kind_rows[study->settings.kind];
    const dl_yaml_node *with = dl_yaml_get(dl_yaml_root(yaml), "with");
    study->samples_chosen = study->settings.samples == 0;
    if (study->samples_chosen)
        study->settings.samples = dl_study_samples_of(kind);
    dl_status status = check_keys_of_kind(study, yaml, error);
    if (status != DL_OK)
        return status;
    if (with && (dl_yaml_kind_of(with) != DL_YAML_MAP || !kind->settings.count))
        return dl_yaml_fail(yaml, with, "with",
                            kind->settings.count ? "a mapping of the kind's settings"
                                                 : "nothing: this kind has no settings",
                            error);
    study->kind_settings = calloc(1, kind->settings_size + 1);
    if (!study->kind_settings)
        return dl_fail_memory(error, "a study");
    status = with
                 ? dl_yaml_read_table(yaml, with, kind->settings, NULL, study->kind_settings, error)
                 : dl_parameter_defaults(kind->settings, study->kind_settings, error);
    if (status != DL_OK)
        return status;
    study->kind_text = dl_study_settings_text(kind, study->kind_settings);
    study->kind_changes = settings_changes(with);
    return study->kind_text && study->kind_changes ? DL_OK : dl_fail_memory(error, "a study");
}

static dl_status read_all(dl_study *study, const dl_yaml *yaml, dl_error *error) {
    const dl_yaml_node *root = dl_yaml_root(yaml);
    dl_status status =
        dl_yaml_read_table(yaml, root, settings_table, setting_others, &study->settings, error);
    if (status == DL_OK)
        status = read_kind(study, yaml, error);
    if (status == DL_OK)
        status = read_limits(study, yaml, error);
    if (status == DL_OK)
        status = read_scenes(study, yaml, error);
    if (status == DL_OK)
        status = read_reference(study, yaml, error);
    if (status == DL_OK)
        status = dl_study_read_cases(study, yaml, dl_yaml_get(root, "cases"), error);
    return status;
}

dl_status dl_study_read(const char *path, dl_study **study, dl_error *error) {
    *study = NULL;
    dl_yaml *yaml = NULL;
    dl_status status = dl_yaml_read(path, &yaml, error);
    if (status != DL_OK)
        return status;
    dl_study *made = calloc(1, sizeof *made);
    if (!made || !(made->path = dl_text("%s", path))) {
        status = dl_fail_memory(error, "a study");
    } else {
        made->run = dl_run;
        status = read_all(made, yaml, error);
    }
    dl_yaml_free(yaml);
    if (status != DL_OK)
        dl_study_free(made);
    else
        *study = made;
    return status;
}

static void release_scene(dl_study_scene *on) {
    dl_study_run_of_release(&on->reference);
    dl_study_run_of_release(&on->check);
    dl_scene_free(on->scene);
    free(on->path);
    free(on->lets);
    free(on->reference_key);
    free(on->reference_text);
}

void dl_study_free(dl_study *study) {
    if (!study)
        return;
    for (size_t i = 0; i < study->cases; i++) {
        dl_study_run_of_release(&study->cased[i].run);
        free(study->cased[i].key);
        free(study->cased[i].command);
    }
    free(study->cased);
    for (size_t i = 0; i < study->scenes; i++)
        release_scene(&study->scene[i]);
    free(study->scene);
    if (study->kind_settings)
        dl_parameter_release(study->kind->settings, study->kind_settings);
    free(study->kind_settings);
    free(study->kind_text);
    free(study->kind_changes);
    dl_parameter_release(settings_table, &study->settings);
    free(study->path);
    free(study);
}

const char *dl_study_name(const dl_study *study) {
    return study->settings.name;
}

size_t dl_study_cases(const dl_study *study) {
    return study->cases;
}
