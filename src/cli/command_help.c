/* driftlab help: scenes, studies, methods and commands. */
#include <stdio.h>
#include <string.h>

#include "cli/command.h"
#include "cli/help.h"
#include "cli/outcome.h"
#include "cli/terminal.h"
#include "driftlab/paper.h"
#include "driftlab/scene.h"
#include "driftlab/study.h"

typedef struct topic {
    const char *name;
    void (*print)(FILE *out);
} topic;

static const topic topics[] = {
    {"scene", dl_scene_help}, {"study", dl_study_help}, {"paper", dl_paper_help}};
static const size_t topic_count = sizeof topics / sizeof *topics;

static cli_exit help_method(const char *name) {
    const dl_method_row *row = NULL;
    dl_error error = {""};
    const dl_status status = name ? dl_method_find(name, &row, &error)
                                  : dl_fail(&error, DL_INPUT,
                                            "help method: found no name, expected a method's "
                                            "(driftlab list methods)");
    if (!status)
        cli_help_method(row, stdout);
    return cli_finish(status, &error);
}

static cli_exit unknown_topic(const char *name) {
    const char *names[32];
    size_t count = 0;
    dl_error error;
    for (size_t i = 0; i < topic_count; i++)
        names[count++] = topics[i].name;
    names[count++] = "method";
    for (const cli_command *const *command = cli_commands; *command; command++)
        names[count++] = (*command)->name;
    names[count] = NULL;
    const char *closest = dl_closest_word(names, name);
    dl_fail(&error, DL_INPUT,
            closest ? "help: found \"%s\", expected scene, study, method NAME or a command; did "
                      "you mean \"%s\"?"
                    : "help: found \"%s\", expected scene, study, method NAME or a command",
            name, closest);
    cli_complain(error.message);
    return CLI_BAD_INPUT;
}

static cli_exit help(const cli_input *input) {
    const char *name = input->word[0];
    if (!name) {
        cli_help_program(stdout);
        return CLI_OK;
    }
    if (strcmp(name, "method") == 0)
        return help_method(input->word[1]);
    /* `study` is both a topic and a command: the command's options are in its --help. */
    for (size_t i = 0; i < topic_count; i++)
        if (strcmp(topics[i].name, name) == 0) {
            topics[i].print(stdout);
            return CLI_OK;
        }
    const cli_command *command = cli_command_find(name);
    if (!command)
        return unknown_topic(name);
    cli_help_command(command, stdout);
    return CLI_OK;
}

const cli_command cli_command_help = {
    .name = "help",
    .arguments = "[TOPIC]",
    .summary = "scene | study | method NAME | a command: every key and option",
    .least_words = 0,
    .most_words = 2,
    .run = help,
};
