/* The file of a paper. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/yaml.h"
#include "study/paper_quantity.h"
#include "study/plan.h"

static const char *const paper_others[] = {"runs", "claims", "pictures", "not_recoverable", NULL};
static const char *const run_others[] = {"set", NULL};

/* --- lists within entries --------------------------------------------------------------------- */

enum { most_keys = 32 };

/* Every key of the entry must be one of the table's. */
static dl_status check_keys(const dl_yaml *yaml, const dl_yaml_node *map, dl_parameter_table table,
                            dl_error *error) {
    const char *names[most_keys + 1] = {NULL};
    for (size_t i = 0; i < table.count; i++)
        names[i] = table.rows[i].name;
    const dl_parameter_table nothing = {NULL, 0};
    return dl_yaml_read_table(yaml, map, nothing, names, NULL, error);
}

/* How many the entry stands for. */
static dl_status count_choices(const dl_yaml *yaml, const dl_yaml_node *map, size_t *count,
                               dl_error *error) {
    bool listed = false;
    *count = 1;
    for (size_t i = 0; i < dl_yaml_length(map); i++) {
        const dl_yaml_node *value = dl_yaml_item(map, i);
        if (dl_yaml_kind_of(value) != DL_YAML_LIST)
            continue;
        const size_t length = dl_yaml_length(value);
        if (length == 0 || (listed && length != *count))
            return dl_yaml_fail(yaml, value, dl_yaml_key(map, i),
                                listed ? "a list as long as the others of this entry"
                                       : "a value or a list of values",
                                error);
        *count = length;
        listed = true;
    }
    return DL_OK;
}

/* The entry's `choice`-th meaning, into a zeroed object. */
static dl_status read_choice(const dl_yaml *yaml, const dl_yaml_node *map, dl_parameter_table table,
                             size_t choice, void *object, dl_error *error) {
    dl_status status = dl_parameter_defaults(table, object, error);
    for (size_t i = 0; i < table.count && !status; i++) {
        const dl_parameter *row = &table.rows[i];
        const dl_yaml_node *node = dl_yaml_get(map, row->name);
        dl_error reason = {""};
        if (!node && row->fallback)
            continue;
        if (!node)
            return dl_yaml_missing(yaml, map, row->name, row->doc, error);
        if (dl_yaml_kind_of(node) == DL_YAML_LIST)
            node = dl_yaml_item(node, choice);
        if (dl_yaml_kind_of(node) != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, node, row->name, "a value or a list of values", error);
        status = dl_parameter_set(row, object, dl_yaml_text(node), &reason);
        if (status)
            status = dl_fail(error, status, "%s:%d: %.900s", dl_yaml_path(yaml), dl_yaml_line(node),
                             reason.message);
    }
    return status;
}

/* --- sources ---------------------------------------------------------------------------------- */

static char *beside(const char *file, const char *path) {
    const char *slash = strrchr(file, '/');
    return *path == '/' || !slash ? dl_text("%s", path)
                                  : dl_text("%.*s/%s", (int)(slash - file), file, path);
}

static dl_status find_run(const dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                          dl_paper_source *source, dl_error *error) {
    const char *names[257] = {NULL};
    for (size_t i = 0; i < paper->cases; i++) {
        if (strcmp(paper->cased[i].name, source->run) == 0) {
            source->number = i;
            return DL_OK;
        }
        if (i < 256)
            names[i] = paper->cased[i].name;
    }
    const char *closest = dl_closest_word(names, source->run);
    char expected[160];
    snprintf(expected, sizeof expected, "the name of a run%s%.60s%s",
             closest ? "; did you mean \"" : "", closest ? closest : "", closest ? "\"?" : "");
    return dl_fail(error, DL_INPUT, "%s:%d: run: found \"%s\", expected %s", dl_yaml_path(yaml),
                   dl_yaml_line(dl_yaml_get(map, "run")), source->run, expected);
}

static dl_status read_source(const dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                             dl_paper_source *source, dl_error *error) {
    const bool scene = *source->scene, run = *source->run;
    if (scene == run)
        return dl_yaml_fail(yaml, map, "run", "either `scene` or `run`", error);
    if (source->step >= 0 && isfinite(source->time))
        return dl_yaml_fail(yaml, dl_yaml_get(map, "time"), "time", "either `step` or `time`",
                            error);
    if (run)
        return find_run(paper, yaml, map, source, error);
    if (source->step > 0 || (isfinite(source->time) && source->time > 0))
        return dl_yaml_fail(yaml, map, "step", "step 0 of a scene, or a run", error);
    source->path = beside(paper->path, source->scene);
    return source->path ? DL_OK : dl_fail_memory(error, "a paper");
}

static bool needs_file_alone(const dl_paper_claim *claim) {
    return claim->quantity < dl_quantity_count() &&
           dl_quantity_at(claim->quantity)->needs == DL_NEEDS_FILE;
}

/* Whether a claim or a picture before has read that scene. */
static bool has_been_read(const dl_paper *paper, const dl_paper_source *source) {
    for (size_t i = 0; i < paper->claims; i++) {
        const dl_paper_source *const other = &paper->claim[i].source;
        if (other != source && other->path && !needs_file_alone(&paper->claim[i]) &&
            strcmp(other->path, source->path) == 0)
            return true;
    }
    for (size_t i = 0; i < paper->pictures; i++) {
        const dl_paper_source *const other = &paper->picture[i].source;
        if (other != source && other->path && strcmp(other->path, source->path) == 0)
            return true;
    }
    return false;
}

/* The scene must be one; where its file alone is looked at, it must be there. */
static dl_status check_scene(const dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                             size_t choice, const dl_paper_source *source, bool file_alone,
                             dl_error *error) {
    dl_scene *scene = NULL;
    dl_error reason = {""};
    if (!source->path || (!file_alone && has_been_read(paper, source)))
        return DL_OK;
    dl_status status = DL_OK;
    if (file_alone && access(source->path, R_OK) != 0)
        status = dl_fail(&reason, DL_INPUT, "%s: %s", source->path, strerror(errno));
    else if (!file_alone)
        status = dl_scene_read(source->path, &scene, &reason);
    dl_scene_free(scene);
    const dl_yaml_node *node = dl_yaml_get(map, "scene");
    if (dl_yaml_kind_of(node) == DL_YAML_LIST)
        node = dl_yaml_item(node, choice);
    return status ? dl_fail(error, status, "%s:%d: scene: found \"%s\", expected a scene: %.700s",
                            dl_yaml_path(yaml), dl_yaml_line(node), source->scene, reason.message)
                  : DL_OK;
}

/* --- runs ------------------------------------------------------------------------------------- */

static dl_status read_settings(const dl_yaml *yaml, const dl_yaml_node *map, dl_paper_case *cased,
                               dl_error *error) {
    const dl_yaml_node *set = dl_yaml_get(map, "set");
    if (!set)
        return DL_OK;
    if (dl_yaml_kind_of(set) != DL_YAML_MAP || dl_yaml_length(set) > DL_PAPER_SETTINGS)
        return dl_yaml_fail(yaml, set, "set", "a mapping of options to values", error);
    for (size_t i = 0; i < dl_yaml_length(set); i++) {
        const dl_yaml_node *value = dl_yaml_item(set, i);
        if (dl_yaml_kind_of(value) != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, value, dl_yaml_key(set, i), "one value", error);
        cased->key[i] = dl_text("%s", dl_yaml_key(set, i));
        cased->value[i] = dl_text("%s", dl_yaml_text(value));
        cased->settings = i + 1;
        if (!cased->key[i] || !cased->value[i])
            return dl_fail_memory(error, "a paper");
    }
    return DL_OK;
}

/* Names of runs are names of files; options must be the method's. */
static dl_status check_run(const dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                           const dl_paper_case *cased, dl_error *error) {
    static const char letters[] = "abcdefghijklmnopqrstuvwxyz0123456789-";
    const dl_method_row *row = NULL;
    dl_error reason = {""};
    if (!*cased->name || strlen(cased->name) > 60 || cased->name[strspn(cased->name, letters)])
        return dl_yaml_fail(yaml, dl_yaml_get(map, "name"), "name",
                            "small letters, digits and hyphens", error);
    for (const dl_paper_case *other = paper->cased; other < cased; other++)
        if (strcmp(other->name, cased->name) == 0)
            return dl_yaml_fail(yaml, dl_yaml_get(map, "name"), "name", "another name for each run",
                                error);
    if (dl_method_find(cased->method, &row, &reason))
        return dl_fail(error, DL_INPUT, "%s:%d: method: %.900s", dl_yaml_path(yaml),
                       dl_yaml_line(dl_yaml_get(map, "method")), reason.message);
    for (size_t i = 0; i < cased->settings; i++)
        if (!dl_parameter_find(row->options, cased->key[i])) {
            const char *closest = dl_parameter_closest(row->options, cased->key[i]);
            return dl_fail(
                error, DL_INPUT, "%s:%d: set: found \"%s\", expected an option of %s%s%s%s",
                dl_yaml_path(yaml), dl_yaml_line(dl_yaml_item(dl_yaml_get(map, "set"), i)),
                cased->key[i], row->name, closest ? "; did you mean \"" : "",
                closest ? closest : "", closest ? "\"?" : "");
        }
    return DL_OK;
}

/* Each value by itself, where it stands. */
static dl_status check_settings(const dl_yaml *yaml, const dl_yaml_node *map,
                                const dl_paper_case *cased, dl_error *error) {
    const dl_method_row *row = NULL;
    dl_status status = dl_method_find(cased->method, &row, error);
    void *const object = status ? NULL : calloc(1, row->options_size + 1);
    if (!status && !object)
        status = dl_fail_memory(error, "a paper");
    for (size_t i = 0; i < cased->settings && !status; i++) {
        dl_error reason = {""};
        status = dl_parameter_set(dl_parameter_find(row->options, cased->key[i]), object,
                                  cased->value[i], &reason);
        if (status)
            status =
                dl_fail(error, status, "%s:%d: set: %.900s", dl_yaml_path(yaml),
                        dl_yaml_line(dl_yaml_item(dl_yaml_get(map, "set"), i)), reason.message);
    }
    if (object)
        dl_parameter_release(row->options, object);
    free(object);
    return status;
}

/* What would fail when the run is made fails now. */
static dl_status try_run(const dl_yaml *yaml, const dl_yaml_node *map, const dl_paper_case *cased,
                         dl_error *error) {
    const char *key;
    dl_error reason = {""};
    dl_status status = check_settings(yaml, map, cased, error);
    if (status || !(status = dl_paper_check(cased, &key, &reason)))
        return status;
    const dl_yaml_node *const node = dl_yaml_get(map, key);
    const int line = dl_yaml_line(node ? node : map);
    return strcmp(key, "scene") == 0
               ? dl_fail(error, status, "%s:%d: scene: found \"%s\", expected a scene: %.700s",
                         dl_yaml_path(yaml), line, cased->scene, reason.message)
               : dl_fail(error, status, "%s:%d: %s%.900s", dl_yaml_path(yaml), line,
                         strcmp(key, "set") == 0 ? "set: " : "", reason.message);
}

static dl_status read_run(dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                          dl_error *error) {
    dl_paper_case *cased = &paper->cased[paper->cases++];
    dl_status status = dl_yaml_read_table(yaml, map, dl_paper_run_table, run_others, cased, error);
    if (!status)
        status = read_settings(yaml, map, cased, error);
    if (!status)
        status = check_run(paper, yaml, map, cased, error);
    if (!status && !(cased->path = beside(paper->path, cased->scene)))
        status = dl_fail_memory(error, "a paper");
    return status ? status : try_run(yaml, map, cased, error);
}

/* --- claims and pictures ---------------------------------------------------------------------- */

static dl_status prepare_claim(const dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                               size_t choice, dl_paper_claim *claim, dl_error *error) {
    dl_error reason = {""};
    const char *key = "published";
    dl_status status = dl_paper_claim_prepare(claim, &reason);
    if (!status) {
        key = "computed";
        status = dl_quantity_find(claim->computed, &claim->quantity, &reason);
    }
    if (status)
        return dl_fail(error, status, "%s:%d: %.900s", dl_yaml_path(yaml),
                       dl_yaml_line(dl_yaml_get(map, key)), reason.message);
    if (dl_paper_has_no_number(claim))
        return *claim->source.scene || *claim->source.run
                   ? dl_yaml_fail(yaml, map, "computed", "none without a scene or a run", error)
                   : DL_OK;
    if ((status = read_source(paper, yaml, map, &claim->source, error)))
        return status;
    if (claim->since >= 0 && !*claim->source.run)
        return dl_yaml_fail(yaml, dl_yaml_get(map, "since"), "since", "a run beside it", error);
    const bool listed = claim->quantity < dl_quantity_count();
    const dl_quantity_needs needs =
        listed ? dl_quantity_at(claim->quantity)->needs : DL_NEEDS_STATE;
    if (needs == DL_NEEDS_RUN && !*claim->source.run)
        return dl_yaml_fail(yaml, dl_yaml_get(map, "scene"), "scene", "a run, for this quantity",
                            error);
    if (needs == DL_NEEDS_FILE && !*claim->source.scene)
        return dl_yaml_fail(yaml, dl_yaml_get(map, "run"), "run", "a scene, for this quantity",
                            error);
    return check_scene(paper, yaml, map, choice, &claim->source, needs == DL_NEEDS_FILE, error);
}

static dl_status read_claim(dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                            size_t choice, dl_error *error) {
    dl_paper_claim *claim = &paper->claim[paper->claims++];
    const dl_status status = read_choice(yaml, map, dl_paper_claim_table, choice, claim, error);
    return status ? status : prepare_claim(paper, yaml, map, choice, claim, error);
}

/* Fails with the first of these keys that the entry has. */
static dl_status refuse_keys(const dl_yaml *yaml, const dl_yaml_node *map, const char *const *names,
                             const char *expected, dl_error *error) {
    for (; *names; names++)
        if (dl_yaml_get(map, *names))
            return dl_yaml_fail(yaml, dl_yaml_get(map, *names), *names, expected, error);
    return DL_OK;
}

static dl_status prepare_curve(const dl_yaml *yaml, const dl_yaml_node *map,
                               dl_paper_picture *picture, dl_error *error) {
    static const char *const of_states[] = {"scene",  "step",       "time",       "colour",
                                            "window", "velocities", "equal_size", NULL};
    dl_error reason = {""};
    dl_status status =
        refuse_keys(yaml, map, of_states, "none beside `curve`, which is of a whole run", error);
    if (!status && dl_paper_curve_prepare(picture, &reason))
        status = dl_fail(error, DL_INPUT, "%s:%d: %.900s", dl_yaml_path(yaml),
                         dl_yaml_line(dl_yaml_get(map, "curve")), reason.message);
    return status;
}

static dl_status read_picture(dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                              size_t choice, dl_error *error) {
    static const char *const of_curves[] = {"axis", "particle", "published", NULL};
    static const char *const others[] = {
        "scene", "run",      "step",      "time",       "colour",     "window", "curve",
        "axis",  "particle", "published", "velocities", "equal_size", NULL};
    dl_paper_picture *picture = &paper->picture[paper->pictures++];
    dl_status status = read_choice(yaml, map, dl_paper_picture_table, choice, picture, error);
    if (status)
        return status;
    if (*picture->reason)
        return refuse_keys(yaml, map, others, "none beside `reason`: there is no picture", error);
    status = *picture->curve ? prepare_curve(yaml, map, picture, error)
                             : refuse_keys(yaml, map, of_curves, "`curve` beside it", error);
    if (!status)
        status = read_source(paper, yaml, map, &picture->source, error);
    return status ? status : check_scene(paper, yaml, map, choice, &picture->source, false, error);
}

typedef dl_status read_function(dl_paper *paper, const dl_yaml *yaml, const dl_yaml_node *map,
                                size_t choice, dl_error *error);

/* How many the entries of a list stand for, their keys checked. */
static dl_status count_entries(const dl_yaml *yaml, const char *key, dl_parameter_table table,
                               size_t *total, dl_error *error) {
    const dl_yaml_node *list = dl_yaml_get(dl_yaml_root(yaml), key);
    dl_status status = DL_OK;
    *total = 0;
    if (list && dl_yaml_kind_of(list) != DL_YAML_LIST)
        return dl_yaml_fail(yaml, list, key, "a list", error);
    for (size_t i = 0; list && i < dl_yaml_length(list) && !status; i++) {
        size_t choices = 0;
        status = check_keys(yaml, dl_yaml_item(list, i), table, error);
        if (!status)
            status = count_choices(yaml, dl_yaml_item(list, i), &choices, error);
        *total += choices;
    }
    return status;
}

static dl_status read_entries(dl_paper *paper, const dl_yaml *yaml, const char *key,
                              read_function *read, dl_error *error) {
    const dl_yaml_node *list = dl_yaml_get(dl_yaml_root(yaml), key);
    dl_status status = DL_OK;
    for (size_t i = 0; list && i < dl_yaml_length(list) && !status; i++) {
        const dl_yaml_node *map = dl_yaml_item(list, i);
        size_t choices;
        status = count_choices(yaml, map, &choices, error);
        for (size_t k = 0; !status && k < choices; k++)
            status = read(paper, yaml, map, k, error);
    }
    return status;
}

static dl_status read_claims(dl_paper *paper, const dl_yaml *yaml, dl_error *error) {
    size_t total;
    const dl_status status = count_entries(yaml, "claims", dl_paper_claim_table, &total, error);
    if (status)
        return status;
    paper->claim = calloc(total + 1, sizeof *paper->claim);
    return paper->claim ? read_entries(paper, yaml, "claims", read_claim, error)
                        : dl_fail_memory(error, "a paper");
}

static dl_status read_pictures(dl_paper *paper, const dl_yaml *yaml, dl_error *error) {
    size_t total;
    const dl_status status = count_entries(yaml, "pictures", dl_paper_picture_table, &total, error);
    if (status)
        return status;
    paper->picture = calloc(total + 1, sizeof *paper->picture);
    return paper->picture ? read_entries(paper, yaml, "pictures", read_picture, error)
                          : dl_fail_memory(error, "a paper");
}

static dl_status read_runs(dl_paper *paper, const dl_yaml *yaml, dl_error *error) {
    const dl_yaml_node *list = dl_yaml_get(dl_yaml_root(yaml), "runs");
    if (!list)
        return DL_OK;
    if (dl_yaml_kind_of(list) != DL_YAML_LIST)
        return dl_yaml_fail(yaml, list, "runs", "a list of runs", error);
    paper->cased = calloc(dl_yaml_length(list) + 1, sizeof *paper->cased);
    dl_status status = paper->cased ? DL_OK : dl_fail_memory(error, "a paper");
    for (size_t i = 0; i < dl_yaml_length(list) && !status; i++)
        status = read_run(paper, yaml, dl_yaml_item(list, i), error);
    return status;
}

static dl_status read_lost(dl_paper *paper, const dl_yaml *yaml, dl_error *error) {
    static const char key[] = "not_recoverable";
    const dl_yaml_node *list = dl_yaml_get(dl_yaml_root(yaml), key);
    if (!list)
        return DL_OK;
    if (dl_yaml_kind_of(list) != DL_YAML_LIST)
        return dl_yaml_fail(yaml, list, key, "a list of texts", error);
    paper->lost_text = calloc(dl_yaml_length(list) + 1, sizeof *paper->lost_text);
    if (!paper->lost_text)
        return dl_fail_memory(error, "a paper");
    for (size_t i = 0; i < dl_yaml_length(list); i++) {
        const dl_yaml_node *item = dl_yaml_item(list, i);
        if (dl_yaml_kind_of(item) != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, item, key, "a text", error);
        paper->lost_text[i] = dl_text("%s", dl_yaml_text(item));
        if (!paper->lost_text[i])
            return dl_fail_memory(error, "a paper");
        paper->lost = i + 1;
    }
    return DL_OK;
}

/* --- the whole -------------------------------------------------------------------------------- */

static dl_status read_all(dl_paper *paper, const dl_yaml *yaml, dl_error *error) {
    dl_status status =
        dl_yaml_read_table(yaml, dl_yaml_root(yaml), dl_paper_table, paper_others, paper, error);
    if (!status)
        status = read_runs(paper, yaml, error);
    if (!status)
        status = read_claims(paper, yaml, error);
    if (!status)
        status = read_pictures(paper, yaml, error);
    return status ? status : read_lost(paper, yaml, error);
}

dl_status dl_paper_read(const char *path, dl_paper **paper, dl_error *error) {
    dl_yaml *yaml = NULL;
    *paper = NULL;
    dl_status status = dl_yaml_read(path, &yaml, error);
    if (status)
        return status;
    dl_paper *made = calloc(1, sizeof *made);
    if (!made || !(made->path = dl_text("%s", path)))
        status = dl_fail_memory(error, "a paper");
    else
        status = read_all(made, yaml, error);
    dl_yaml_free(yaml);
    if (status)
        dl_paper_free(made);
    else
        *paper = made;
    return status;
}

static void release_run(dl_paper_case *cased) {
    for (size_t i = 0; i < DL_PAPER_SETTINGS; i++) {
        free(cased->key[i]);
        free(cased->value[i]);
    }
    free(cased->path);
    dl_parameter_release(dl_paper_run_table, cased);
}

void dl_paper_free(dl_paper *paper) {
    if (!paper)
        return;
    for (size_t i = 0; i < paper->cases; i++)
        release_run(&paper->cased[i]);
    for (size_t i = 0; i < paper->claims; i++) {
        free(paper->claim[i].source.path);
        dl_parameter_release(dl_paper_claim_table, &paper->claim[i]);
    }
    for (size_t i = 0; i < paper->pictures; i++) {
        free(paper->picture[i].source.path);
        dl_parameter_release(dl_paper_picture_table, &paper->picture[i]);
    }
    for (size_t i = 0; i < paper->lost; i++)
        free(paper->lost_text[i]);
    free(paper->lost_text);
    free(paper->cased);
    free(paper->claim);
    free(paper->picture);
    dl_parameter_release(dl_paper_table, paper);
    free(paper->path);
    free(paper);
}

const char *dl_paper_name(const dl_paper *paper) {
    return paper->name;
}
