/* driftlab explain: what a scene's model contains. */
#include <stdio.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "driftlab/explain.h"

static cli_exit explain(const cli_input *input) {
    dl_scene *scene = NULL;
    dl_model *model = NULL;
    dl_error error = {""};
    dl_status status = dl_scene_read(input->word[0], &scene, &error);
    if (!status)
        status = dl_model_create(scene, &model, &error);
    if (!status)
        dl_explain(model, stdout);
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
    .run = explain,
};
