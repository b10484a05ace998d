#include "cli/summary.h"

#include <math.h>
#include <stddef.h>

#include "cli/json.h"

typedef enum kind { REAL, COUNT, SIZE } kind;

typedef struct field {
    const char *name;
    const char *label; /* in the table; NULL: not there */
    kind kind;
    size_t offset;
} field;

#define FIELD(kind_, member, label_)                                                               \
    { #member, label_, kind_, offsetof(dl_run_summary, member) }

static const field fields[] = {
    FIELD(REAL, t_end_reached, "time reached"),
    FIELD(REAL, step, "step"),
    FIELD(COUNT, steps, "steps"),
    FIELD(COUNT, rejected_steps, "rejected steps"),
    FIELD(COUNT, force_evaluations, "force evaluations"),
    FIELD(COUNT, jacobian_evaluations, "Jacobian evaluations"),
    FIELD(COUNT, jacobian_vector_products, "Jacobian-vector products"),
    FIELD(COUNT, nonlinear_iterations, "nonlinear iterations"),
    FIELD(COUNT, linear_iterations, "linear iterations"),
    FIELD(COUNT, factorisations, "factorisations"),
    FIELD(COUNT, inexact_steps, "steps above tolerance"),
    FIELD(COUNT, rescued_steps, "steps rescued"),
    FIELD(COUNT, neighbour_list_builds, "neighbour lists built"),
    FIELD(COUNT, wall_hits, "wall hits"),
    FIELD(COUNT, contacts, "contacts begun"),
    FIELD(COUNT, releases, "contacts ended"),
    FIELD(COUNT, crossings, "crossings located"),
    FIELD(REAL, cpu_seconds, "CPU seconds"),
    FIELD(REAL, energy_initial, "energy at the start"),
    FIELD(REAL, energy_final, "energy at the end"),
    FIELD(REAL, energy_scale, "energy scale"),
    FIELD(REAL, energy_error_max, "energy error, largest"),
    FIELD(REAL, energy_error_final, "energy error at the end"),
    FIELD(REAL, ledger, "energy that jumps took"),
    FIELD(REAL, momentum_error_max, "momentum error, largest"),
    FIELD(REAL, angular_momentum_error_max, "angular momentum error"),
    FIELD(REAL, momentum_scale, NULL),
    FIELD(REAL, angular_momentum_scale, NULL),
    FIELD(REAL, kinetic_energy_per_particle, "kinetic energy/particle"),
    FIELD(REAL, force_error_stated, "force error, stated"),
    FIELD(REAL, force_error_max, "force error, largest"),
    FIELD(REAL, force_error_mean, "force error, mean"),
    FIELD(SIZE, samples, NULL),
};

static const size_t field_count = sizeof fields / sizeof *fields;

static double real_of(const dl_run_summary *summary, const field *row) {
    return *(const double *)(const void *)((const char *)summary + row->offset);
}

static unsigned long count_of(const dl_run_summary *summary, const field *row) {
    const void *at = (const char *)summary + row->offset;
    return row->kind == SIZE ? (unsigned long)*(const size_t *)at : *(const unsigned long *)at;
}

void cli_summary_table(const dl_scene *scene, const dl_method_row *row, const char *options,
                       const dl_run_summary *summary, FILE *out) {
    fprintf(out, "%s with %s %s\n", scene->name, row->name, options);
    fprintf(out, "  %-26s %s\n", "status", dl_status_name(summary->status));
    if (*summary->choice)
        fprintf(out, "  %-26s %s\n", "solver", summary->choice);
    for (size_t i = 0; i < field_count; i++) {
        const field *shown = &fields[i];
        if (!shown->label)
            continue;
        /* What a method does not do and what does not apply is left out. */
        if (shown->kind == REAL && !isnan(real_of(summary, shown)))
            fprintf(out, "  %-26s %.10g\n", shown->label, real_of(summary, shown));
        else if (shown->kind != REAL && count_of(summary, shown))
            fprintf(out, "  %-26s %lu\n", shown->label, count_of(summary, shown));
    }
}

static json_t *options_object(const dl_method_row *row, const void *options) {
    json_t *object = json_object();
    for (size_t i = 0; i < row->options.count; i++)
        json_object_set_new(object, row->options.rows[i].name,
                            cli_json_value(&row->options.rows[i], options));
    return object;
}

dl_status cli_summary_json(const dl_scene *scene, const dl_method_row *row, const void *options,
                           const dl_run_summary *summary, FILE *out, dl_error *error) {
    json_t *root = json_object();
    json_object_set_new(root, "scene", json_string(scene->name));
    json_object_set_new(root, "method", json_string(row->name));
    json_object_set_new(root, "options", options_object(row, options));
    json_object_set_new(root, "status", json_string(dl_status_name(summary->status)));
    json_object_set_new(root, "message", json_string(summary->message));
    json_object_set_new(root, "choice", json_string(summary->choice));
    for (size_t i = 0; i < field_count; i++) {
        const field *shown = &fields[i];
        json_object_set_new(root, shown->name,
                            shown->kind == REAL
                                ? cli_json_real(real_of(summary, shown))
                                : json_integer((json_int_t)count_of(summary, shown)));
    }
    return cli_json_print(root, out, error);
}
