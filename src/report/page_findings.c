#include "page_findings.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

/* An array under construction; `failed` once anything could not be added. */
typedef struct list {
    json_t *array;
    bool failed;
} list;

static list begin(void) {
    json_t *array = json_array();
    return (list){array, array == NULL};
}

static void append(list *to, json_t *value) {
    to->failed |= json_array_append_new(to->array, value) != 0;
}

/* NULL where something is missing. */
static json_t *finish(list *made) {
    if (!made->failed)
        return made->array;
    json_decref(made->array);
    return NULL;
}

static json_t *real(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

/* The next of the lines at *at, which moves behind it. */
static json_t *take_line(const char **at) {
    const size_t length = strcspn(*at, "\n");
    char *copy = strndup(*at, length);
    json_t *line = copy ? dl_page_text(copy) : NULL;
    free(copy);
    *at += length + ((*at)[length] == '\n');
    return line;
}

/* "NAME [UNIT]" of the next line into {name, unit, ...}. */
static json_t *take_name(const char **at) {
    const size_t length = strcspn(*at, "\n");
    const char *line = *at, *unit = NULL;
    for (size_t i = 0; i + 1 < length; i++)
        if (line[i] == ' ' && line[i + 1] == '[' && line[length - 1] == ']')
            unit = line + i + 2;
    json_t *name = unit ? json_pack("{s:s%,s:s%}", "name", line, (size_t)(unit - 2 - line), "unit",
                                    unit, (size_t)(line + length - 1 - unit))
                        : json_pack("{s:s%,s:s}", "name", line, length, "unit", "");
    *at += length + (line[length] == '\n');
    return name;
}

static json_t *quantities(const dl_finding *finding) {
    list made = begin();
    const char *names = finding->quantity_names;
    for (size_t i = 0; i < finding->quantities; i++) {
        const double *value = finding->quantity + 3 * i;
        json_t *quantity = take_name(&names);
        made.failed |= !quantity || json_object_set_new(quantity, "value", real(value[0])) ||
                       json_object_set_new(quantity, "low", real(value[1])) ||
                       json_object_set_new(quantity, "high", real(value[2]));
        append(&made, quantity);
    }
    return finish(&made);
}

static json_t *columns(const dl_finding *finding) {
    list made = begin();
    const char *names = finding->column_names;
    for (size_t i = 0; i < finding->columns; i++)
        append(&made, take_name(&names));
    return finish(&made);
}

static json_t *rows(const dl_finding *finding) {
    list made = begin();
    const char *words = finding->row_words;
    for (size_t i = 0; i < finding->rows; i++) {
        list values = begin();
        for (size_t k = 0; k < finding->columns; k++)
            append(&values, real(finding->table[i * finding->columns + k]));
        append(&made, json_pack("{s:o,s:o}", "word", take_line(&words), "values", finish(&values)));
    }
    return finish(&made);
}

static json_t *one_finding(const dl_finding *finding) {
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:s,s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "key",
                     dl_page_text(finding->key), "scene", dl_page_text(finding->scene), "method",
                     dl_page_text(finding->method), "family", dl_page_text(finding->family),
                     "options", dl_page_text(finding->options), "command",
                     dl_page_text(finding->command), "status", dl_status_name(finding->status),
                     "message", dl_page_text(finding->message), "verdict",
                     dl_page_text(finding->verdict), "reason", dl_page_text(finding->reason),
                     "cpu_seconds", real(finding->cpu_seconds), "quantities", quantities(finding),
                     "columns", columns(finding), "rows", rows(finding));
}

json_t *dl_page_findings(const dl_results *results) {
    list made = begin();
    for (size_t i = 0; i < results->findings; i++)
        append(&made, one_finding(&results->finding[i]));
    return finish(&made);
}
