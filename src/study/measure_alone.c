/* One unit of a study without a study file: a study of one scene and one case, made by hand. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "study/kind.h"
#include "study/variants.h"

/* CPU seconds of one run that nothing limits. */
static const double no_limit = 1e9;

static dl_status find_kind(const char *name, dl_study *study, dl_error *error) {
    char shown[80], known[256] = "";
    for (int k = 0; dl_study_kinds[k]; k++) {
        const dl_study_kind *kind = dl_study_kind_rows[k];
        if (kind->measure) {
            strncat(known, *known ? ", " : "", sizeof known - strlen(known) - 1);
            strncat(known, dl_study_kinds[k], sizeof known - strlen(known) - 1);
        }
        if (strcmp(dl_study_kinds[k], name) != 0)
            continue;
        if (!kind->measure)
            return dl_fail(error, DL_INPUT,
                           "kind: found %s, expected a kind that asks about one method alone "
                           "(driftlab run integrates one case, driftlab study compares them)",
                           name);
        study->kind = kind;
        study->settings.kind = k;
        return DL_OK;
    }
    dl_quote(name, shown, sizeof shown);
    const char *closest = dl_closest_word(dl_study_kinds, name);
    if (closest)
        return dl_fail(error, DL_INPUT, "kind: found %s; did you mean \"%s\"?", shown, closest);
    return dl_fail(error, DL_INPUT, "kind: found %s, expected one of %s", shown, known);
}

static dl_status add_scene(const dl_measure_request *request, dl_study *study, dl_error *error) {
    dl_study_scene *on = study->scene = calloc(1, sizeof *study->scene);
    if (!on)
        return dl_fail_memory(error, "a scene");
    study->scenes = 1; /* from here on freed with the study */
    on->path = dl_text("%s", request->scene);
    on->lets = dl_let_arguments(request->lets, request->let);
    if (!on->path || !on->lets)
        return dl_fail_memory(error, "a scene");
    const dl_status status =
        dl_scene_read_let(request->scene, request->lets, request->let, &on->scene, error);
    if (status != DL_OK)
        return status;
    on->hash = dl_scene_hash(on->scene);
    on->end = request->end > 0 ? request->end : on->scene->end;
    on->sample =
        request->sample > 0 ? request->sample : on->end / (double)dl_study_samples_of(study->kind);
    on->sample_chosen = !(request->sample > 0);
    const double samples = on->end / on->sample;
    if (samples > DL_MOST_SAMPLES)
        return dl_fail(error, DL_INPUT,
                       "sample: found %.15g, expected at least %.6g, which makes %.0f samples up "
                       "to %.15g",
                       on->sample, on->end / DL_MOST_SAMPLES, (double)DL_MOST_SAMPLES, on->end);
    study->settings.samples = lround(samples);
    return DL_OK;
}

static dl_status unknown_setting(const dl_study *study, const dl_method_row *row, const char *key,
                                 dl_error *error) {
    const dl_parameter_table tables[] = {row->options, study->kind->settings};
    const char *kind = dl_study_kinds[study->settings.kind], *closest = NULL;
    char shown[80];
    dl_quote(key, shown, sizeof shown);
    for (size_t t = 0; t < sizeof tables / sizeof *tables && !closest; t++)
        closest = dl_parameter_closest(tables[t], key);
    if (closest)
        return dl_fail(error, DL_INPUT,
                       "neither method %s nor kind %s has a setting %s; did you mean \"%s\"?",
                       row->name, kind, shown, closest);
    return dl_fail(error, DL_INPUT,
                   "neither method %s nor kind %s has a setting %s (driftlab help method %s, "
                   "driftlab help study)",
                   row->name, kind, shown, row->name);
}

/* The kind's settings among those of the request; of the others *keys and *values, [*count]. */
static dl_status take_settings(const dl_measure_request *request, const dl_method_row *row,
                               dl_study *study, const char **keys, const char **values,
                               size_t *count, dl_error *error) {
    const dl_study_kind *kind = study->kind;
    study->kind_settings = calloc(1, kind->settings_size + 1);
    study->kind_changes = dl_text("%s", "");
    if (!study->kind_settings || !study->kind_changes)
        return dl_fail_memory(error, "a kind's settings");
    dl_status status = dl_parameter_defaults(kind->settings, study->kind_settings, error);
    for (size_t i = 0; i < request->settings && status == DL_OK && study->kind_changes; i++) {
        const char *key = request->key[i], *value = request->value[i];
        const dl_parameter *own = dl_parameter_find(kind->settings, key);
        if (!own && !dl_parameter_find(row->options, key))
            return unknown_setting(study, row, key, error);
        if (!own) {
            keys[*count] = key;
            values[(*count)++] = value;
            continue;
        }
        status = dl_parameter_set(own, study->kind_settings, value, error);
        char *longer = dl_text("%s --set %s=%s", study->kind_changes, key, value);
        free(study->kind_changes);
        study->kind_changes = longer;
    }
    if (status == DL_OK)
        study->kind_text = dl_study_settings_text(kind, study->kind_settings);
    return status != DL_OK || (study->kind_text && study->kind_changes)
               ? status
               : dl_fail_memory(error, "a kind's settings");
}

static dl_status add_case(const dl_measure_request *request, dl_study *study, dl_error *error) {
    const dl_method_row *row = NULL;
    const size_t room = request->settings + 1;
    const char **keys = calloc(2 * room, sizeof *keys), **values = keys + room;
    int *no_lines = calloc(room, sizeof *no_lines);
    size_t count = 0;
    dl_study_case *cased = study->cased = calloc(1, sizeof *study->cased);
    dl_status status =
        keys && no_lines && cased ? DL_OK : dl_fail_memory(error, "a kind's settings");
    if (status == DL_OK)
        status = dl_method_find(request->method, &row, error);
    if (status == DL_OK)
        status = take_settings(request, row, study, keys, values, &count, error);
    if (status == DL_OK)
        status = dl_study_prepare(study, &study->scene[0], row, count, keys, values, no_lines,
                                  &cased->run, error);
    free(keys);
    free(no_lines);
    if (status != DL_OK)
        return status;
    study->cases = 1;
    cased->key = dl_study_case_key(study, cased);
    cased->command = dl_study_case_command(study, cased);
    return cased->key && cased->command ? DL_OK : dl_fail_memory(error, "a case");
}

static dl_status make_study(const dl_measure_request *request, dl_study *study, dl_error *error) {
    study->run = dl_run;
    dl_status status = find_kind(request->kind, study, error);
    if (status == DL_OK)
        status = dl_parameter_defaults(dl_study_limits_table, &study->limits, error);
    study->limits.seconds = request->seconds > 0 ? request->seconds : no_limit;
    if (status == DL_OK)
        status = add_scene(request, study, error);
    return status == DL_OK ? add_case(request, study, error) : status;
}

dl_status dl_study_measure_alone(const dl_measure_request *request, dl_finding *finding,
                                 dl_error *error) {
    const dl_watch watch = {.interrupt = request->interrupt};
    dl_study *study = calloc(1, sizeof *study);
    *finding = (dl_finding){0};
    if (!study)
        return dl_fail_memory(error, "a study");
    dl_status status = make_study(request, study, error);
    if (status == DL_OK)
        status = dl_study_measure_unit(study, &study->cased[0], &watch, request->on_progress,
                                       request->context, finding, error);
    dl_study_free(study);
    return status;
}
