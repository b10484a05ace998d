/* driftlab recommend: the method that reaches an error at the least cost, and its step. */
#include <stdio.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/recommendation.h"
#include "cli/settings.h"
#include "cli/terminal.h"

static const char *const measures[] = {"position", "energy", NULL};

typedef struct recommend_values {
    double error, t_end, seconds;
    int in;
    char *methods;
    bool json;
} recommend_values;

static const dl_parameter options[] = {
    CLI_OPTION_POSITIVE(recommend_values, "error", error, "X",
                        "error that is to be reached, required"),
    {.name = "in",
     .kind = DL_WORD,
     .offset = offsetof(recommend_values, in),
     .unit = "WHAT",
     .words = measures,
     .fallback = "position",
     .doc = "position (RMS at the end, in the scene's unit of length) | energy (largest, in units "
            "of its scale)"},
    CLI_OPTION_T_END(recommend_values),
    {.name = "seconds",
     .kind = DL_REAL,
     .offset = offsetof(recommend_values, seconds),
     .unit = "S",
     .minimum = 0,
     .maximum = 1e7,
     .above_minimum = true,
     .fallback = "60",
     .doc = "CPU time that all of it may take: the run is shortened to keep to it"},
    {.name = "methods",
     .kind = DL_TEXT,
     .offset = offsetof(recommend_values, methods),
     .unit = "LIST",
     .doc = "methods to choose from, with commas between (default: strong ones of every family)"},
    CLI_OPTION_JSON(recommend_values),
};

static void show_progress(void *context, const char *text) {
    (void)context;
    cli_show_progress(text);
}

static dl_status find(const cli_input *input, dl_recommendation *found, dl_error *error) {
    const recommend_values *values = input->values;
    const bool progress = cli_shows_progress();
    const dl_recommend_request request = {.scene = input->word[0],
                                          .lets = input->lets,
                                          .let = input->let,
                                          .error = values->error,
                                          .in = measures[values->in],
                                          .end = values->t_end,
                                          .seconds = values->seconds,
                                          .methods = values->methods,
                                          .interrupt = cli_catch_signals(),
                                          .on_progress = progress ? show_progress : NULL};
    *found = (dl_recommendation){0};
    if (!(values->error > 0))
        return dl_fail(error, DL_INPUT, "--error: found none, expected the error to reach");
    const dl_status status = dl_recommend(&request, found, error);
    if (progress)
        cli_show_progress(NULL);
    return status;
}

static cli_exit recommend(const cli_input *input) {
    const recommend_values *values = input->values;
    dl_recommendation found;
    dl_error error = {""};
    dl_status status = find(input, &found, &error);
    const bool reached = found.reached > 0;
    if (!status && values->json)
        status = cli_recommendation_json(&found, stdout, &error);
    else if (!status)
        cli_recommendation_print(&found, stdout);
    if (!status && !reached) {
        cli_recommendation_why_not(&found, &error);
        status = DL_ERROR;
    }
    dl_recommendation_release(&found);
    return cli_finish(status, &error);
}

const cli_command cli_command_recommend = {
    .name = "recommend",
    .arguments = "SCENE",
    .summary = "the method, and its step or tolerance, that reaches an error at the least cost",
    .details =
        "Measures a choice of methods on the scene: at first over at most 64 of the scene's "
        "steps,\n"
        "then over the longest of 1, 1/4, 1/16 ... of the run that is expected to fit into\n"
        "--seconds. Of every method the step or tolerance is searched that just reaches the "
        "error;\n"
        "what is recommended was run, and so was a finer one that reaches it too. Errors of\n"
        "positions are against a reference in extended precision, never past the horizon. Methods\n"
        "that take more than 25 times the cheapest's time are given up.\n"
        "\n"
        "From a shortened run to the whole: cost is proportional to time; the error of energy\n"
        "stays where a method is symplectic or conserves energy and grows as t elsewhere, that of\n"
        "positions grows as t, elsewhere as t^2, and the shortened run is asked for so much less.\n"
        "\n"
        "exit status: 0 a method reached it; 1 none did, with the nearest; 2 bad input.\n",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .options = CLI_TABLE(options),
    .values_size = sizeof(recommend_values),
    .run = recommend,
};
