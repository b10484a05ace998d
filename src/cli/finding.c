#include "cli/finding.h"

#include <math.h>
#include <string.h>

#include "cli/json.h"
#include "cli/settings.h"
#include "cli/terminal.h"

static void show_progress(void *context, const char *text) {
    (void)context;
    cli_show_progress(text);
}

dl_status cli_measure(const cli_input *input, const cli_measurement *asked, dl_finding *finding,
                      dl_error *error) {
    cli_setting settings[CLI_MAX_SETTINGS];
    const char *key[CLI_MAX_SETTINGS], *value[CLI_MAX_SETTINGS];
    size_t count = 0;
    dl_status status = cli_settings_method(asked->method, error);
    if (!status)
        status = cli_settings_read(input, asked->dt, asked->rtol, settings, &count, error);
    if (status)
        return status;
    for (size_t i = 0; i < count; i++) {
        key[i] = settings[i].key;
        value[i] = settings[i].value;
    }
    const bool progress = cli_shows_progress();
    const dl_measure_request request = {.kind = asked->kind,
                                        .scene = asked->scene,
                                        .method = asked->method,
                                        .settings = count,
                                        .key = key,
                                        .value = value,
                                        .lets = input->lets,
                                        .let = input->let,
                                        .end = asked->end,
                                        .sample = asked->sample,
                                        .seconds = asked->seconds,
                                        .interrupt = cli_catch_signals(),
                                        .on_progress = progress ? show_progress : NULL};
    status = dl_study_measure_alone(&request, finding, error);
    if (status == DL_INPUT && asked->sample > 0)
        cli_name_option("sample: ", "--sample: ", error);
    if (progress)
        cli_show_progress(NULL);
    return status;
}

/* --- lines of names ---------------------------------------------------------------------------
 */

/* A line of a text of lines; goes on to the next. */
static const char *next_line(const char **text, int *length) {
    const char *line = *text;
    *length = (int)strcspn(line, "\n");
    *text = line + *length + (line[*length] == '\n');
    return line;
}

/* "NAME [UNIT]": the lengths of both; unit NULL where there is none. */
static const char *unit_of(const char *line, int length, int *name_length, int *unit_length) {
    *name_length = length;
    *unit_length = 0;
    if (length < 3 || line[length - 1] != ']')
        return NULL;
    for (int at = length - 2; at > 0; at--)
        if (line[at] == '[' && line[at - 1] == ' ') {
            *name_length = at - 1;
            *unit_length = length - at - 2;
            return line + at + 1;
        }
    return NULL;
}

/* --- text -------------------------------------------------------------------------------------
 */

void cli_finding_summary(const dl_finding *finding, FILE *out) {
    fprintf(out, "%s\n", finding->scene);
    dl_finding_print(finding, out);
}

void cli_finding_table(const dl_finding *finding, FILE *out) {
    enum { least_width = 12 };
    if (finding->rows == 0)
        return;
    const char *names = finding->column_names, *words = finding->row_words;
    for (size_t c = 0; c < finding->columns; c++) {
        int length;
        const char *name = next_line(&names, &length);
        fprintf(out, "  %*.*s", least_width, length, name);
    }
    fputc('\n', out);
    for (size_t r = 0; r < finding->rows; r++) {
        names = finding->column_names;
        for (size_t c = 0; c < finding->columns; c++) {
            const double value = finding->table[r * finding->columns + c];
            int length;
            char text[32] = "-";
            next_line(&names, &length);
            if (isfinite(value))
                snprintf(text, sizeof text, "%.6g", value);
            fprintf(out, "  %*s", length > least_width ? length : least_width, text);
        }
        int length;
        const char *word = next_line(&words, &length);
        fprintf(out, "%s%.*s\n", length ? "  " : "", length, word);
    }
}

/* --- JSON -------------------------------------------------------------------------------------
 */

static json_t *named(const char *line, int length) {
    int name_length, unit_length;
    const char *unit = unit_of(line, length, &name_length, &unit_length);
    json_t *object = json_object();
    json_object_set_new(object, "name", json_stringn(line, (size_t)name_length));
    json_object_set_new(object, "unit", json_stringn(unit ? unit : "", (size_t)unit_length));
    return object;
}

static json_t *quantities(const dl_finding *finding) {
    json_t *all = json_array();
    const char *names = finding->quantity_names;
    for (size_t i = 0; i < finding->quantities; i++) {
        const double *value = finding->quantity + 3 * i;
        int length;
        const char *line = next_line(&names, &length);
        json_t *one = named(line, length);
        json_object_set_new(one, "value", cli_json_real(value[0]));
        json_object_set_new(one, "low", cli_json_real(value[1]));
        json_object_set_new(one, "high", cli_json_real(value[2]));
        json_array_append_new(all, one);
    }
    return all;
}

static json_t *columns(const dl_finding *finding) {
    json_t *all = json_array();
    const char *names = finding->column_names;
    for (size_t c = 0; c < finding->columns; c++) {
        int length;
        const char *line = next_line(&names, &length);
        json_array_append_new(all, named(line, length));
    }
    return all;
}

static json_t *rows(const dl_finding *finding) {
    json_t *all = json_array();
    for (size_t r = 0; r < finding->rows; r++) {
        json_t *row = json_array();
        for (size_t c = 0; c < finding->columns; c++)
            json_array_append_new(row, cli_json_real(finding->table[r * finding->columns + c]));
        json_array_append_new(all, row);
    }
    return all;
}

static json_t *words(const dl_finding *finding) {
    json_t *all = json_array();
    const char *text = finding->row_words;
    for (size_t r = 0; r < finding->rows; r++) {
        int length;
        const char *word = next_line(&text, &length);
        json_array_append_new(all, json_stringn(word, (size_t)length));
    }
    return all;
}

dl_status cli_finding_json(const dl_finding *finding, FILE *out, dl_error *error) {
    json_t *root =
        json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:s}", "scene", finding->scene, "method",
                  finding->method, "options", finding->options, "command", finding->command,
                  "status", dl_status_name(finding->status), "message", finding->message, "verdict",
                  finding->verdict, "reason", finding->reason);
    json_object_set_new(root, "cpu_seconds", cli_json_real(finding->cpu_seconds));
    json_object_set_new(root, "quantities", quantities(finding));
    json_object_set_new(root, "columns", columns(finding));
    json_object_set_new(root, "rows", rows(finding));
    json_object_set_new(root, "words", words(finding));
    return cli_json_print(root, out, error);
}
