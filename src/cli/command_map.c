/* driftlab map: which steps are stable over a number of a study's scenes, as a picture. */
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/paths.h"
#include "driftlab/map.h"

typedef struct map_values {
    char *over, *method, *out;
} map_values;

static const dl_parameter options[] = {
    {.name = "over",
     .kind = DL_TEXT,
     .offset = offsetof(map_values, over),
     .unit = "NAME",
     .doc = "the number in the scenes' `let` that the columns differ in, required"},
    {.name = "method",
     .kind = DL_TEXT,
     .offset = offsetof(map_values, method),
     .unit = "METHOD",
     .doc = "the method (default: the only one there is)"},
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(map_values, out),
     .unit = "FILE",
     .doc = "NAME.svg or NAME.png (default: map.svg beside the results)"},
};

static cli_exit map(const cli_input *input) {
    const map_values *values = input->values;
    const dl_map asked = {
        .over = values->over, .method = values->method, .lets = input->lets, .let = input->let};
    dl_results *results = NULL;
    dl_error error = {""};
    char *beside = cli_beside(input->word[0], "map.svg");
    const char *out = values->out ? values->out : beside;
    dl_status status = out ? DL_OK : dl_fail_memory(&error, "a file name");
    if (!status && !asked.over)
        status =
            dl_fail(&error, DL_INPUT, "--over: found none, expected a number in the scenes' `let`");
    if (!status)
        status = dl_results_read(input->word[0], &results, &error);
    if (!status)
        status = dl_map_write(results, &asked, out, &error);
    if (!status)
        printf("map: %s\n", out);
    dl_results_free(results);
    free(beside);
    return cli_finish(status, &error);
}

const cli_command cli_command_map = {
    .name = "map",
    .arguments = "RESULTS.h5",
    .summary = "draw which steps are stable over a number of a study's scenes (SVG, PNG)",
    .details = "For the results of a study of kind stability whose `let` lists several numbers: a\n"
               "column for each, in it every step that was tried.\n",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .options = CLI_TABLE(options),
    .values_size = sizeof(map_values),
    .run = map,
};
