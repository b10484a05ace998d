/* driftlab explain: what a scene's model contains, what the energy-conserving scheme would do with
 * it, and what leaving out what it lacks saves. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/json.h"
#include "cli/outcome.h"
#include "cli/settings.h"
#include "driftlab/explain.h"
#include "driftlab/leave_outs.h"
#include "driftlab/method.h"

typedef struct explain_values {
    double seconds;
    long repeats;
    bool cost, json;
} explain_values;

static const dl_parameter explain_options[] = {
    {.name = "cost",
     .kind = DL_FLAG,
     .offset = offsetof(explain_values, cost),
     .fallback = "false",
     .doc = "measure what leaving out saves: time of a leap-frog step and memory"},
    {.name = "repeats",
     .kind = DL_INTEGER,
     .offset = offsetof(explain_values, repeats),
     .unit = "N",
     .minimum = 1,
     .maximum = DL_MOST_COST_REPEATS,
     .fallback = "9",
     .doc = "of --cost"},
    {.name = "seconds",
     .kind = DL_REAL,
     .offset = offsetof(explain_values, seconds),
     .unit = "S",
     .minimum = 0,
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "0.01",
     .doc = "of --cost: CPU seconds of one measurement of the scene's own model"},
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(explain_values, json),
     .fallback = "false",
     .doc = "of --cost: print one JSON object instead of a table"},
};

/* The solver that `conserving` chooses at the scene's step, or why it cannot run there. */
static dl_status explain_choice(const dl_scene *scene, dl_model *model, FILE *out,
                                dl_error *error) {
    const dl_method_row *row;
    void *options = NULL;
    dl_method *method = NULL;
    char choice[DL_MESSAGE_SIZE] = "";
    double *const y = malloc((2 * model->unknowns + 1) * sizeof *y);
    if (!y)
        return dl_fail_memory(error, "the scene's state");
    dl_model_initial_state(model, y);
    dl_status status = dl_method_find("conserving", &row, error);
    status = status ? status : dl_method_options_create(row, scene, &options, error);
    status = status ? status : dl_method_create(row, model, options, y, &method, error);
    if (!status)
        dl_method_describe(method, choice, sizeof choice);
    if (status == DL_INPUT) {
        snprintf(choice, sizeof choice, "not here: %s", error->message);
        status = DL_OK;
    }
    if (*choice)
        fprintf(out, "  %-10s %s\n", "conserving", choice);
    dl_method_destroy(method);
    if (options)
        dl_method_options_free(row, options);
    free(y);
    return status;
}

/* --- what it saves ---------------------------------------------------------------------------- */

static void print_costs(const dl_scene *scene, const dl_leave_outs *costs, FILE *out) {
    fprintf(out,
            "%s: %zu particles, kernel %s; leap-frog, %zu repeats\n\n"
            "| added, changing nothing | us a step | times its own | from | to | kB | differs |\n"
            "|---|---|---|---|---|---|---|\n",
            scene->name, costs->particles, costs->kernel, costs->repeats);
    for (size_t k = 0; k < costs->rows; k++) {
        const dl_leave_out_row *row = &costs->row[k];
        char memory[24] = "-";
        if (isfinite(row->bytes))
            snprintf(memory, sizeof memory, "%.1f", row->bytes / 1000);
        fprintf(out, "| %s | %.3g | %.3g | %.3g | %.3g | %s | %.1e |\n", row->what,
                row->seconds * 1e6, row->ratio, row->ratio_low, row->ratio_high, memory,
                row->difference);
    }
    fprintf(
        out,
        "\nkB: model and method. differs: of positions after %zu steps, in parts of the scene's "
        "extent.\n",
        costs->checked);
}

static json_t *costs_json(const dl_scene *scene, const dl_leave_outs *costs) {
    json_t *rows = json_array();
    for (size_t k = 0; rows && k < costs->rows; k++) {
        const dl_leave_out_row *row = &costs->row[k];
        json_array_append_new(
            rows,
            json_pack("{s:s, s:o, s:o, s:o, s:o, s:o, s:o}", "added", row->what, "seconds_per_step",
                      cli_json_real(row->seconds), "ratio", cli_json_real(row->ratio), "ratio_low",
                      cli_json_real(row->ratio_low), "ratio_high", cli_json_real(row->ratio_high),
                      "bytes", cli_json_real(row->bytes), "position_difference",
                      cli_json_real(row->difference)));
    }
    return json_pack("{s:s, s:I, s:s, s:s, s:I, s:I, s:o}", "scene", scene->name, "particles",
                     (json_int_t)costs->particles, "kernel", costs->kernel, "method", "leapfrog",
                     "repeats", (json_int_t)costs->repeats, "checked_steps",
                     (json_int_t)costs->checked, "rows", rows);
}

static dl_status explain_costs(const dl_scene *scene, const explain_values *values, FILE *out,
                               dl_error *error) {
    dl_leave_outs costs;
    const dl_status status =
        dl_leave_outs_measure(scene, (size_t)values->repeats, values->seconds, &costs, error);
    if (status)
        return status;
    if (values->json)
        return cli_json_print(costs_json(scene, &costs), out, error);
    print_costs(scene, &costs, out);
    return DL_OK;
}

static dl_status explain_model(const dl_scene *scene, FILE *out, dl_error *error) {
    dl_model *model = NULL;
    dl_status status = dl_model_create(scene, &model, error);
    if (!status) {
        dl_explain(model, out);
        status = explain_choice(scene, model, out, error);
    }
    dl_model_free(model);
    return status;
}

/* An option that would not be used is refused. */
static dl_status check_options(const cli_input *input, dl_error *error) {
    static const char *const of_cost[] = {"repeats", "seconds", "json"};
    const explain_values *values = input->values;
    for (size_t k = 0; k < sizeof of_cost / sizeof *of_cost && !values->cost; k++)
        if (cli_input_gives(&cli_command_explain, input, of_cost[k]))
            return dl_fail(error, DL_INPUT, "--%s: found without --cost, where it is used",
                           of_cost[k]);
    return DL_OK;
}

static cli_exit explain(const cli_input *input) {
    const explain_values *values = input->values;
    dl_scene *scene = NULL;
    dl_error error = {""};
    dl_status status = check_options(input, &error);
    if (!status)
        status = cli_read_scene(input, input->word[0], &scene, &error);
    if (!status)
        status = values->cost ? explain_costs(scene, values, stdout, &error)
                              : explain_model(scene, stdout, &error);
    dl_scene_free(scene);
    return cli_finish(status, &error);
}

const cli_command cli_command_explain = {
    .name = "explain",
    .arguments = "SCENE",
    .summary = "what a scene's model contains, what it leaves out, which kernel and why",
    .details =
        "--cost runs the scene's own model and, taking turns with it, models of the same physics\n"
        "that have one more thing each, with values that change nothing: walls at infinity,\n"
        "couplings of 1, a gravity of 1e-200, two species with one law ... The last rows have\n"
        "everything at once. Times are CPU times of whole leap-frog steps, ratios those within a\n"
        "repeat: median, lowest, highest. Memory is that of model and method on the heap.\n"
        "Positions differ by roundoff, and by more only where crossings are located and walls\n"
        "mirror: leap-frog then holds velocities at whole steps, and the walls turn those round.\n",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .options = CLI_TABLE(explain_options),
    .values_size = sizeof(explain_values),
    .run = explain,
};
