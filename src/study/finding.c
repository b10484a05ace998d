#include "study/finding.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "io/results_schema.h"
#include "study/plan.h"

static const dl_record *record(void) {
    return &dl_results_records[DL_RECORD_FINDINGS];
}

dl_status dl_finding_create(dl_finding *finding, dl_error *error) {
    *finding = (dl_finding){.cpu_seconds = NAN};
    for (size_t i = 0; i < record()->field_count; i++) {
        const dl_field *field = &record()->fields[i];
        if (dl_field_is_text(field->kind) &&
            !(*(char **)dl_field_at(field, finding) = dl_text("%s", "")))
            return dl_fail_memory(error, "a finding");
    }
    return DL_OK;
}

/* Puts `made` in the place of *text; NULL: no memory. */
static dl_status replace(char **text, char *made, dl_error *error) {
    if (!made)
        return dl_fail_memory(error, "a finding");
    free(*text);
    *text = made;
    return DL_OK;
}

static dl_status add_line(char **text, size_t lines, const char *line, dl_error *error) {
    return replace(text, dl_text("%s%s%s", *text, lines ? "\n" : "", line), error);
}

static dl_status grow(double **values, size_t count, size_t more, const double *added,
                      dl_error *error) {
    double *grown = realloc(*values, (count + more + 1) * sizeof *grown);
    if (!grown)
        return dl_fail_memory(error, "a finding");
    *values = grown;
    for (size_t i = 0; i < more; i++)
        grown[count + i] = added[i];
    return DL_OK;
}

dl_status dl_finding_add(dl_finding *finding, const char *name, double value, double low,
                         double high, dl_error *error) {
    const double values[] = {value, low, high};
    dl_status status = grow(&finding->quantity, 3 * finding->quantities, 3, values, error);
    if (status == DL_OK)
        status = add_line(&finding->quantity_names, finding->quantities, name, error);
    if (status == DL_OK)
        finding->quantities++;
    return status;
}

dl_status dl_finding_set_columns(dl_finding *finding, const char *names, dl_error *error) {
    finding->columns = 1;
    for (const char *at = names; *at; at++)
        finding->columns += *at == '\n';
    return replace(&finding->column_names, dl_text("%s", names), error);
}

dl_status dl_finding_add_row(dl_finding *finding, const double *values, const char *word,
                             dl_error *error) {
    const size_t columns = finding->columns;
    dl_status status = grow(&finding->table, finding->rows * columns, columns, values, error);
    if (status == DL_OK)
        status = add_line(&finding->row_words, finding->rows, word, error);
    if (status == DL_OK)
        finding->rows++;
    return status;
}

dl_status dl_finding_judge(dl_finding *finding, dl_error *error, const char *verdict,
                           const char *reason, ...) {
    char text[2 * DL_MESSAGE_SIZE];
    va_list arguments;
    va_start(arguments, reason);
    vsnprintf(text, sizeof text, reason, arguments);
    va_end(arguments);
    dl_status status = replace(&finding->verdict, dl_text("%s", verdict), error);
    return status == DL_OK ? replace(&finding->reason, dl_text("%s", text), error) : status;
}

/* The option of that name in "step=0.01 rtol=1e-06 ..."; NULL: none. */
static const char *find_option(const char *options, const char *name) {
    const size_t length = strlen(name);
    for (const char *at = options; at; at = strchr(at, ' '), at = at ? at + 1 : NULL)
        if (strncmp(at, name, length) == 0 && at[length] == '=')
            return at;
    return NULL;
}

void dl_options_fineness(const char *options, char *text, size_t size) {
    const char *at = find_option(options, "step");
    if (!at || strncmp(at, "step=0 ", strlen("step=0 ")) == 0)
        at = find_option(options, "rtol");
    snprintf(text, size, "%.*s", at ? (int)strcspn(at, " ") : 0, at ? at : "");
}

void dl_finding_fineness(const dl_finding *finding, char *text, size_t size) {
    dl_options_fineness(finding->options, text, size);
}

dl_status dl_finding_pack(const dl_finding *finding, void **bytes, size_t *size, dl_error *error) {
    return dl_record_pack(record(), finding, bytes, size, error);
}

dl_status dl_finding_unpack(const void *bytes, size_t size, dl_finding *finding, dl_error *error) {
    return dl_record_unpack(record(), bytes, size, finding, error);
}
