/* driftlab explain: what a scene's model contains, and what the energy-conserving scheme would do
 * with it. */
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "driftlab/explain.h"
#include "driftlab/method.h"

/* The solver that `conserving` chooses at the scene's step. */
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
    if (*choice)
        fprintf(out, "  %-10s %s\n", "conserving", choice);
    dl_method_destroy(method);
    if (options)
        dl_method_options_free(row, options);
    free(y);
    return status;
}

static cli_exit explain(const cli_input *input) {
    dl_scene *scene = NULL;
    dl_model *model = NULL;
    dl_error error = {""};
    dl_status status = cli_read_scene(input, input->word[0], &scene, &error);
    if (!status)
        status = dl_model_create(scene, &model, &error);
    if (!status) {
        dl_explain(model, stdout);
        status = explain_choice(scene, model, stdout, &error);
    }
    dl_model_free(model);
    dl_scene_free(scene);
    return cli_finish(status, &error);
}

const cli_command cli_command_explain = {
    .name = "explain",
    .arguments = "SCENE",
    .summary = "what a scene's model contains, what it leaves out, which kernel and why",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .run = explain,
};
