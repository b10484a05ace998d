#include "cli/observed.h"

#include <math.h>
#include <string.h>

#include "cli/json.h"

enum { name_width = 20, cell_width = 26 };

/* --- table ------------------------------------------------------------------------------------ */

/* "mean +- error"; what is not there is a dash. */
static void write_value(double mean, double error, char *text, size_t size) {
    if (!isfinite(mean))
        snprintf(text, size, "-");
    else if (isfinite(error))
        snprintf(text, size, "%.6g +- %.2g", mean, error);
    else
        snprintf(text, size, "%.6g", mean);
}

static void write_label(const dl_observed *o, size_t row, double width, char *text, size_t size) {
    if (o->observable->rows == DL_ROWS_BINS)
        snprintf(text, size, "%.6g - %.6g", o->label[row], o->label[row] + width);
    else
        snprintf(text, size, "%.6g", o->label[row]);
}

static void print_system(const dl_observed *o, FILE *out) {
    char value[64];
    for (size_t k = 0; k < o->columns; k++) {
        write_value(o->mean[k], o->error[k], value, sizeof value);
        fprintf(out, "  %-*s %s\n", name_width, o->observable->column[k], value);
    }
}

static void print_rows(const dl_observed *o, double width, FILE *out) {
    char text[64];
    fprintf(out, "  %-*s", name_width, o->observable->rows == DL_ROWS_BINS ? "height" : "mass");
    for (size_t k = 0; k < o->columns; k++)
        fprintf(out, k + 1 < o->columns ? " %-*s" : " %.*s", k + 1 < o->columns ? cell_width : 64,
                o->observable->column[k]);
    fputc('\n', out);
    for (size_t row = 0; row < o->rows; row++) {
        write_label(o, row, width, text, sizeof text);
        fprintf(out, "  %-*s", name_width, text);
        for (size_t k = 0; k < o->columns; k++) {
            const size_t at = row * o->columns + k;
            write_value(o->mean[at], o->error[at], text, sizeof text);
            fprintf(out, k + 1 < o->columns ? " %-*s" : " %.*s",
                    k + 1 < o->columns ? cell_width : 64, text);
        }
        fputc('\n', out);
    }
}

/* Counted from 1, as a scene's `remove` does. */
static void print_escaped(const cli_observed *observed, FILE *out) {
    const bool *const escaped = dl_observation_escaped(observed->observation);
    const char *before = "";
    fprintf(out, "  %-*s ", name_width, "rows");
    for (size_t i = 0; i < observed->scene->particles; i++)
        if (escaped[i]) {
            fprintf(out, "%s%zu", before, i + 1);
            before = ", ";
        }
    fprintf(out, "%s\n", *before ? observed->frames > 1 ? " (of the last frame)" : "" : "none");
}

/* Whose energy, motion, temperatures and states are told. */
static void print_over(const cli_observed *observed, FILE *out) {
    const bool *const system = dl_observation_system(observed->observation);
    const dl_scene *const scene = observed->scene;
    size_t moving = 0, inside = 0;
    for (size_t i = 0; system && i < scene->particles; i++) {
        moving += !scene->pinned[i];
        inside += !scene->pinned[i] && system[i];
    }
    if (system)
        fprintf(out,
                "over the system alone, the heaviest group: %zu of %zu particles in the last "
                "frame\n",
                inside, moving);
}

void cli_observed_table(const cli_observed *observed, FILE *out) {
    fprintf(out, "%s, %s: ", observed->file, observed->scene->name);
    if (observed->frames > 1)
        fprintf(out, "means and standard errors of %zu frames, t = %.10g to %.10g\n",
                observed->frames, observed->from, observed->to);
    else
        fprintf(out, "one frame, t = %.10g\n", observed->to);
    print_over(observed, out);
    for (size_t i = 0; i < dl_observation_count(observed->observation); i++) {
        dl_observed o;
        dl_observation_get(observed->observation, i, &o);
        fprintf(out, "%s: %s", o.observable->name, o.observable->doc);
        if (strcmp(o.observable->name, "temperature") == 0)
            fprintf(out, ", %s: kinetic energy / %g", observed->temperature->name,
                    observed->temperature->unit);
        fputc('\n', out);
        if (o.label)
            print_rows(&o, dl_observation_bin(observed->observation), out);
        else
            print_system(&o, out);
        if (strcmp(o.observable->name, "escaped") == 0)
            print_escaped(observed, out);
    }
}

/* --- JSON ------------------------------------------------------------------------------------- */

static json_t *row_json(const dl_observed *o, size_t row, double width) {
    json_t *object = json_object();
    if (o->observable->rows == DL_ROWS_BINS)
        json_object_set_new(object, "height",
                            json_pack("[f, f]", o->label[row], o->label[row] + width));
    else if (o->label)
        json_object_set_new(object, "mass", json_real(o->label[row]));
    for (size_t k = 0; k < o->columns; k++) {
        const size_t at = row * o->columns + k;
        json_t *value = json_object();
        json_object_set_new(value, "mean", cli_json_real(o->mean[at]));
        json_object_set_new(value, "error", cli_json_real(o->error[at]));
        json_object_set_new(object, o->observable->column[k], value);
    }
    return object;
}

json_t *cli_observed_head(const cli_observed *observed) {
    json_t *root = json_object();
    const bool all = !dl_observation_system(observed->observation);
    json_object_set_new(root, "file", json_string(observed->file));
    json_object_set_new(root, "scene", json_string(observed->scene->name));
    json_object_set_new(root, "over", json_string(all ? "all" : "system"));
    json_object_set_new(root, "frames", json_integer((json_int_t)observed->frames));
    json_object_set_new(root, "from", cli_json_real(observed->from));
    json_object_set_new(root, "to", cli_json_real(observed->to));
    json_object_set_new(root, "temperature_rule", json_string(observed->temperature->name));
    json_object_set_new(root, "temperature_unit", json_real(observed->temperature->unit));
    return root;
}

json_t *cli_observed_escaped(const cli_observed *observed) {
    const bool *const escaped = dl_observation_escaped(observed->observation);
    json_t *const rows = escaped ? json_array() : NULL;
    for (size_t i = 0; rows && i < observed->scene->particles; i++)
        if (escaped[i])
            json_array_append_new(rows, json_integer((json_int_t)i + 1));
    return rows;
}

dl_status cli_observed_json(const cli_observed *observed, FILE *out, dl_error *error) {
    json_t *root = cli_observed_head(observed), *all = json_object();
    const double width = dl_observation_bin(observed->observation);
    for (size_t i = 0; i < dl_observation_count(observed->observation); i++) {
        dl_observed o;
        dl_observation_get(observed->observation, i, &o);
        json_t *rows = json_array();
        for (size_t row = 0; row < o.rows; row++)
            json_array_append_new(rows, row_json(&o, row, width));
        if (strcmp(o.observable->name, "escaped") == 0)
            json_object_set_new(json_array_get(rows, 0), "rows", cli_observed_escaped(observed));
        json_object_set_new(all, o.observable->name, rows);
    }
    json_object_set_new(root, "observables", all);
    return cli_json_print(root, out, error);
}
