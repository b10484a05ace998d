#include "methods/registry.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const dl_method_row *const rows[] = {
#define DL_METHOD_ADDRESS(symbol) &dl_method_##symbol,
    DL_METHODS(DL_METHOD_ADDRESS)
#undef DL_METHOD_ADDRESS
};

enum { row_count = sizeof rows / sizeof *rows };

/* --- look-up -----------------------------------------------------------------------------------
 */

size_t dl_method_count(void) {
    return row_count;
}

const dl_method_row *dl_method_row_at(size_t index) {
    return index < row_count ? rows[index] : NULL;
}

dl_status dl_method_find(const char *name, const dl_method_row **row, dl_error *error) {
    const char *names[row_count + 1] = {NULL};
    for (size_t i = 0; i < row_count; i++) {
        names[i] = rows[i]->name;
        if (strcmp(names[i], name) == 0) {
            *row = rows[i];
            return DL_OK;
        }
    }
    *row = NULL;
    char shown[80];
    dl_quote(name, shown, sizeof shown);
    const char *const closest = dl_closest_word(names, name);
    if (closest)
        return dl_fail(error, DL_INPUT, "no method is called %s; did you mean \"%s\"?", shown,
                       closest);
    return dl_fail(error, DL_INPUT, "no method is called %s (see: driftlab list methods)", shown);
}

static bool find_default_table(const dl_method_row *row, const dl_parameter *option,
                               dl_method_table *table) {
    if (option->kind != DL_WORD)
        return false;
    for (size_t k = 0; option->words[k]; k++)
        if (strcmp(option->words[k], option->fallback) == 0)
            return row->table(option->words, k, table);
    return false;
}

bool dl_method_default_table(const dl_method_row *row, dl_method_table *table) {
    bool found = false;
    for (size_t i = 0; i < row->options.count && row->table && !found; i++)
        found = find_default_table(row, &row->options.rows[i], table);
    return found;
}

/* --- options -----------------------------------------------------------------------------------
 */

/* "step" without a default of its own is the scene's. */
static void step_from_scene(const dl_method_row *row, const dl_scene *scene, void *options) {
    const dl_parameter *const step = dl_parameter_find(row->options, "step");
    if (step && !step->fallback)
        *(double *)(void *)((char *)options + step->offset) = scene->step;
}

/* Behind the structure: a flag an option, whether it has been set. */
static bool *given(const dl_method_row *row, const void *options) {
    return (bool *)((char *)options + row->options_size);
}

static size_t whole_size(const dl_method_row *row) {
    return row->options_size + row->options.count * sizeof(bool);
}

dl_status dl_method_options_create(const dl_method_row *row, const dl_scene *scene, void **options,
                                   dl_error *error) {
    *options = calloc(1, whole_size(row));
    if (!*options)
        return dl_fail_memory(error, "the options of a method");
    const dl_status status = dl_parameter_defaults(row->options, *options, error);
    if (status) {
        dl_method_options_free(row, *options);
        *options = NULL;
        return status;
    }
    step_from_scene(row, scene, *options);
    return DL_OK;
}

dl_status dl_method_options_set(const dl_method_row *row, void *options, const char *key,
                                const char *value, dl_error *error) {
    const dl_parameter *const parameter = dl_parameter_find(row->options, key);
    if (parameter) {
        const dl_status status = dl_parameter_set(parameter, options, value, error);
        given(row, options)[parameter - row->options.rows] |= !status;
        return status;
    }
    char shown[80];
    dl_quote(key, shown, sizeof shown);
    const char *const closest = dl_parameter_closest(row->options, key);
    if (closest)
        return dl_fail(error, DL_INPUT, "method %s has no option %s; did you mean \"%s\"?",
                       row->name, shown, closest);
    char known[256] = "";
    size_t used = 0;
    for (size_t i = 0; i < row->options.count && used < sizeof known; i++)
        used += (size_t)snprintf(known + used, sizeof known - used, "%s%s", i ? ", " : "",
                                 row->options.rows[i].name);
    return dl_fail(error, DL_INPUT, "method %s has no option %s; it has: %s", row->name, shown,
                   known);
}

void dl_method_options_format(const dl_method_row *row, const void *options, char *text,
                              size_t size) {
    size_t used = 0;
    if (size)
        text[0] = '\0';
    for (size_t i = 0; i < row->options.count && used < size; i++) {
        const dl_parameter *const option = &row->options.rows[i];
        char value[128];
        if (!dl_parameter_applies(row->options, option, options))
            continue;
        dl_parameter_format(option, options, value, sizeof value);
        used += (size_t)snprintf(text + used, size - used, "%s%s=%s", used ? " " : "", option->name,
                                 value);
    }
}

/* Numbers, flags and words are copied as they are: no method has an option that is a text. */
dl_status dl_method_options_copy(const dl_method_row *row, const void *options, void **copy,
                                 dl_error *error) {
    *copy = malloc(whole_size(row));
    if (!*copy)
        return dl_fail_memory(error, "the options of a method");
    memcpy(*copy, options, whole_size(row));
    return DL_OK;
}

void dl_method_options_free(const dl_method_row *row, void *options) {
    if (!options)
        return;
    dl_parameter_release(row->options, options);
    free(options);
}

/* --- methods at work ---------------------------------------------------------------------------
 */

/* What was set and is not used, would be ignored. */
static dl_status refuse_unused(const dl_method_row *row, const void *options, dl_error *error) {
    for (size_t i = 0; i < row->options.count; i++) {
        const dl_parameter *const option = &row->options.rows[i];
        if (!given(row, options)[i] || dl_parameter_applies(row->options, option, options))
            continue;
        const dl_parameter *const cause = dl_parameter_cause(row->options, option);
        char value[128];
        dl_parameter_format(cause, options, value, sizeof value);
        return dl_fail(error, DL_INPUT,
                       "method %s: found %s with %s=%s, expected it only with %s, where it is used",
                       row->name, option->name, cause->name, value, option->when);
    }
    return DL_OK;
}

dl_status dl_method_create(const dl_method_row *row, dl_model *model, const void *options,
                           const double *y0, dl_method **method, dl_error *error) {
    *method = NULL;
    dl_status status = refuse_unused(row, options, error);
    if (status)
        return status;
    dl_method *const created = calloc(1, sizeof *created);
    if (!created)
        return dl_fail_memory(error, "a method");
    created->row = row;
    created->model = model;
    created->n = model->unknowns;
    created->y = malloc(2 * created->n * sizeof *created->y);
    if (dl_method_options_copy(row, options, &created->options, NULL) || !created->y) {
        dl_method_destroy(created);
        return dl_fail_memory(error, "a method's state");
    }
    memcpy(created->y, y0, 2 * created->n * sizeof *y0);
    status = row->ops->create(created, error);
    if (status) {
        dl_method_destroy(created);
        return status;
    }
    *method = created;
    return DL_OK;
}

dl_status dl_method_advance(dl_method *method, double t_stop, dl_error *error) {
    return method->row->ops->advance(method, t_stop, error);
}

void dl_method_count_step(dl_method *method) {
    method->t = method->origin + (double)++method->since * method->step;
}

dl_status dl_method_step_to(dl_method *method, double t, dl_error *error) {
    const double step = method->step, origin = method->origin;
    const unsigned long since = method->since;
    method->step = t - method->t;
    method->origin = method->t;
    method->since = 0;
    const dl_status status = dl_method_advance(method, t, error);
    method->step = step;
    if (status) {
        method->origin = origin;
        method->since = since;
        return status;
    }
    method->t = t;
    return DL_OK;
}

void dl_method_return_to_grid(dl_method *method, unsigned long steps) {
    method->origin = 0;
    method->since = steps;
    method->t = (double)steps * method->step;
}

dl_status dl_method_state(dl_method *method, double *y_out, dl_error *error) {
    if (method->row->ops->state)
        return method->row->ops->state(method, y_out, error);
    memcpy(y_out, method->y, 2 * method->n * sizeof *y_out);
    return DL_OK;
}

dl_status dl_method_jumped(dl_method *method, dl_error *error) {
    return method->row->ops->jumped(method, error);
}

void dl_method_describe(const dl_method *method, char *text, size_t size) {
    snprintf(text, size, "%s", "");
    if (method->row->ops->describe)
        method->row->ops->describe(method, text, size);
}

void dl_method_stats_get(const dl_method *method, dl_method_stats *stats) {
    *stats = (dl_method_stats){0};
    method->row->ops->stats(method, stats);
}

void dl_method_destroy(dl_method *method) {
    if (!method)
        return;
    method->row->ops->destroy(method);
    free(method->options);
    free(method->y);
    free(method);
}
