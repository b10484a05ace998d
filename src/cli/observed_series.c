/* Observables frame by frame. A column is OBSERVABLE.COLUMN, and where it has rows
 * OBSERVABLE.COLUMN[MASS], or the low end of the bin. */
#include <math.h>
#include <string.h>

#include "cli/json.h"
#include "cli/observed.h"

void cli_series_begin(cli_series *series, const cli_observed *observed, bool json, FILE *out) {
    *series = (cli_series){.observed = observed, .json = json, .out = out};
}

/* Calls for every value of the frame, in the order of the columns. */
typedef void value_function(cli_series *series, const dl_observed *o, size_t row, size_t column);

static void for_each_value(cli_series *series, value_function *use) {
    const dl_observation *const observation = series->observed->observation;
    for (size_t i = 0; i < dl_observation_count(observation); i++) {
        dl_observed o;
        dl_observation_get(observation, i, &o);
        for (size_t row = 0; row < o.rows; row++)
            for (size_t column = 0; column < o.columns; column++)
                use(series, &o, row, column);
    }
}

/* --- CSV -------------------------------------------------------------------------------------- */

static void print_name(cli_series *series, const dl_observed *o, size_t row, size_t column) {
    fprintf(series->out, ",%s.%s", o->observable->name, o->observable->column[column]);
    if (o->label)
        fprintf(series->out, "[%.10g]", o->label[row]);
}

/* What does not apply is left empty. */
static void print_value(cli_series *series, const dl_observed *o, size_t row, size_t column) {
    const double value = o->present[row * o->columns + column];
    fprintf(series->out, isfinite(value) ? ",%.17g" : ",", value);
}

static void print_escaped(const cli_series *series) {
    const bool *const escaped = dl_observation_escaped(series->observed->observation);
    const char *before = ",";
    for (size_t i = 0; escaped && i < series->observed->scene->particles; i++)
        if (escaped[i]) {
            fprintf(series->out, "%s%zu", before, i + 1);
            before = " ";
        }
    if (escaped && *before == ',')
        fputc(',', series->out);
}

static void add_line(cli_series *series, double time, long step) {
    FILE *const out = series->out;
    if (series->rows == 0) {
        fputs("time,step", out);
        for_each_value(series, print_name);
        fputs(dl_observation_escaped(series->observed->observation) ? ",escaped.rows\n" : "\n",
              out);
    }
    fprintf(out, "%.17g,", time);
    if (step >= 0)
        fprintf(out, "%ld", step);
    for_each_value(series, print_value);
    print_escaped(series);
    fputc('\n', out);
}

/* --- JSON ------------------------------------------------------------------------------------- */

static json_t *entry_row(const dl_observed *o, size_t row) {
    json_t *object = json_object();
    if (o->label)
        json_object_set_new(object, o->observable->rows == DL_ROWS_BINS ? "height" : "mass",
                            json_real(o->label[row]));
    for (size_t k = 0; k < o->columns; k++)
        json_object_set_new(object, o->observable->column[k],
                            cli_json_real(o->present[row * o->columns + k]));
    return object;
}

static void add_entry(cli_series *series, double time, long step) {
    json_t *entry = json_object();
    const dl_observation *const observation = series->observed->observation;
    json_object_set_new(entry, "time", cli_json_real(time));
    json_object_set_new(entry, "step", step >= 0 ? json_integer(step) : json_null());
    for (size_t i = 0; i < dl_observation_count(observation); i++) {
        dl_observed o;
        dl_observation_get(observation, i, &o);
        json_t *rows = json_array();
        for (size_t row = 0; row < o.rows; row++)
            json_array_append_new(rows, entry_row(&o, row));
        if (strcmp(o.observable->name, "escaped") == 0)
            json_object_set_new(json_array_get(rows, 0), "rows",
                                cli_observed_escaped(series->observed));
        json_object_set_new(entry, o.observable->name, rows);
    }
    if (!series->entries)
        series->entries = json_array();
    json_array_append_new(series->entries, entry);
}

/* ---------------------------------------------------------------------------------------------- */

dl_status cli_series_add(cli_series *series, double time, long step, dl_error *error) {
    if (series->json)
        add_entry(series, time, step);
    else
        add_line(series, time, step);
    series->rows++;
    return ferror(series->out) ? dl_fail(error, DL_IO, "standard output: writing failed") : DL_OK;
}

dl_status cli_series_end(cli_series *series, dl_status status, dl_error *error) {
    if (status || !series->json) {
        json_decref(series->entries);
        return status;
    }
    json_t *root = cli_observed_head(series->observed);
    json_object_set_new(root, "series", series->entries);
    return cli_json_print(root, series->out, error);
}
