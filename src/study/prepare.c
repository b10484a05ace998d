/* A method with its options on a scene: checked as far as it can be without running it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "observe/schedule.h"
#include "study/jumps.h"
#include "study/kind.h"

void dl_study_run_of_release(dl_study_run_of *run) {
    if (run->options)
        dl_method_options_free(run->row, run->options);
    free(run->text);
    free(run->changes);
    *run = (dl_study_run_of){0};
}

dl_status dl_study_find_method(const dl_yaml *yaml, const dl_yaml_node *map,
                               const dl_method_row **row, dl_error *error) {
    if (dl_yaml_kind_of(map) != DL_YAML_MAP)
        return dl_yaml_fail(yaml, map, NULL, "a mapping with a method and its options", error);
    const dl_yaml_node *node = dl_yaml_get(map, "method");
    if (!node)
        return dl_yaml_fail(yaml, map, "method", "the name of a method", error);
    if (dl_yaml_kind_of(node) != DL_YAML_SCALAR)
        return dl_yaml_fail(yaml, node, "method", "the name of a method", error);
    dl_error reason;
    dl_status status = dl_method_find(dl_yaml_text(node), row, &reason);
    return status == DL_OK ? DL_OK
                           : dl_fail(error, status, "%s:%d: %.900s", dl_yaml_path(yaml),
                                     dl_yaml_line(node), reason.message);
}

dl_status dl_study_try_start(const dl_study_unit *unit, dl_error *error) {
    dl_model *model = NULL;
    dl_method *method = NULL;
    dl_schedule schedule;
    dl_jumps jumps;
    dl_status status = dl_model_create(unit->scene, &model, error);
    if (status != DL_OK)
        return status;
    double *y = malloc(2 * model->unknowns * sizeof *y + 1);
    if (!y) {
        status = dl_fail_memory(error, "a state");
    } else {
        dl_model_initial_state(model, y);
        status = dl_method_create(unit->row, model, unit->options, y, &method, error);
    }
    if (status == DL_OK) {
        const double end = unit->end == unit->scene->end ? 0 : unit->end; /* the scene's */
        status =
            dl_schedule_of_scene(unit->scene, end, unit->sample, method->step, &schedule, error);
        if (status == DL_OK)
            status = dl_jumps_create(unit->scene, method->step, &jumps, error);
    } else if (status != DL_INPUT && status != DL_MEMORY)
        status = DL_OK; /* not the study file's fault: the case will tell */
    if (method)
        dl_method_destroy(method);
    free(y);
    dl_model_free(model);
    return status;
}

/* Without " step=..." of a kind that chooses it. */
static void leave_out_step(char *text) {
    char *at = strncmp(text, "step=", 5) == 0 ? text : strstr(text, " step=");
    if (!at)
        return;
    const char *rest = at + 1 + strcspn(at + 1, " ");
    rest += at == text && *rest == ' ';
    memmove(at, rest, strlen(rest) + 1);
}

/* The options as a kind that chooses the step uses them: with a step. */
static dl_status options_with_step(const dl_study_run_of *run, const dl_scene *scene,
                                   void **options, dl_error *error) {
    char step[40];
    dl_status status = dl_method_options_copy(run->row, run->options, options, error);
    if (status != DL_OK || !dl_parameter_find(run->row->options, "step"))
        return status;
    dl_format_real(scene->step, step, sizeof step);
    status = dl_method_options_set(run->row, *options, "step", step, error);
    if (status == DL_OK)
        return DL_OK;
    dl_method_options_free(run->row, *options);
    *options = NULL;
    return status;
}

/* What is used without a step alone. */
static dl_status refuse_unused(const dl_study *study, const dl_study_run_of *run,
                               const void *with_step, size_t count, const char *const *key,
                               const char *const *value, dl_error *error) {
    const dl_parameter_table table = run->row->options;
    for (size_t i = 0; i < count; i++) {
        const dl_parameter *const option = dl_parameter_find(table, key[i]);
        if (option && dl_parameter_applies(table, option, run->options) &&
            !dl_parameter_applies(table, option, with_step))
            return dl_fail(error, DL_INPUT,
                           "%s: found %s, expected none: a study of kind %s keeps steps fixed, "
                           "where %s has no use",
                           key[i], value[i], dl_study_kinds[study->settings.kind], key[i]);
    }
    return DL_OK;
}

/* The text of every option that is used. */
static dl_status format_used(const dl_study *study, const dl_study_scene *on,
                             const dl_study_run_of *run, size_t count, const char *const *key,
                             const char *const *value, char *text, size_t size, dl_error *error) {
    if (!study->kind->chooses_step) {
        dl_method_options_format(run->row, run->options, text, size);
        return DL_OK;
    }
    void *with_step = NULL;
    dl_status status = options_with_step(run, on->scene, &with_step, error);
    if (status != DL_OK)
        return status;
    status = refuse_unused(study, run, with_step, count, key, value, error);
    dl_method_options_format(run->row, with_step, text, size);
    leave_out_step(text);
    dl_method_options_free(run->row, with_step);
    return status;
}

static dl_status describe(const dl_study *study, const dl_study_scene *on, dl_study_run_of *run,
                          size_t count, const char *const *key, const char *const *value,
                          dl_error *error) {
    char text[4096];
    const dl_status status =
        format_used(study, on, run, count, key, value, text, sizeof text, error);
    if (status != DL_OK)
        return status;
    run->text = dl_text("%s", text);
    run->changes = dl_text("%s", "");
    for (size_t i = 0; i < count && run->changes; i++) {
        char *longer = dl_text("%s --set %s=%s", run->changes, key[i], value[i]);
        free(run->changes);
        run->changes = longer;
    }
    return run->text && run->changes ? DL_OK : dl_fail_memory(error, "a case");
}

static dl_status check_unit(const dl_study *study, const dl_study_scene *on,
                            const dl_study_run_of *run, dl_error *error) {
    const dl_study_unit unit = {.scene = on->scene,
                                .row = run->row,
                                .options = run->options,
                                .end = on->end,
                                .sample = on->sample,
                                .sample_chosen = on->sample_chosen,
                                .seconds = study->limits.seconds,
                                .settings = study->kind_settings,
                                .run = study->run};
    if (!study->kind->measure)
        return dl_study_try_start(&unit, error);
    return study->kind->check ? study->kind->check(&unit, error) : DL_OK;
}

dl_status dl_study_prepare(const dl_study *study, const dl_study_scene *on,
                           const dl_method_row *row, size_t count, const char *const *key,
                           const char *const *value, const int *line, dl_study_run_of *run,
                           dl_error *error) {
    dl_error reason = {""};
    int at = line[0];
    *run = (dl_study_run_of){.row = row};
    dl_status status = dl_method_options_create(row, on->scene, &run->options, &reason);
    for (size_t i = 0; i < count && status == DL_OK; i++) {
        at = line[i + 1];
        status = dl_method_options_set(row, run->options, key[i], value[i], &reason);
        if (status == DL_OK && study->kind->chooses_step && strcmp(key[i], "step") == 0)
            status = dl_fail(&reason, DL_INPUT,
                             "step: found %s, expected no step: a study of kind %s chooses it",
                             value[i], dl_study_kinds[study->settings.kind]);
    }
    if (status == DL_OK) {
        at = line[0];
        status = describe(study, on, run, count, key, value, &reason);
    }
    if (status == DL_OK)
        status = check_unit(study, on, run, &reason);
    if (status == DL_OK)
        return DL_OK;
    char place[DL_MESSAGE_SIZE] = "";
    if (at > 0)
        snprintf(place, sizeof place, "%s:%d: ", study->path, at);
    status = dl_fail(error, status, "%s%s on %s%s%s: %.800s", place, row->name, on->scene->name,
                     run->changes && *run->changes ? " with" : "", run->changes ? run->changes : "",
                     reason.message);
    dl_study_run_of_release(run);
    return status;
}
