#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/arguments.h"
#include "cli/help.h"
#include "cli/outcome.h"
#include "cli/terminal.h"
#include "driftlab/version.h"

const cli_command *const cli_commands[] = {
    &cli_command_run,
    &cli_command_study,
    &cli_command_measure,
    &cli_command_check,
    &cli_command_recommend,
    &cli_command_report,
    &cli_command_observe,
    &cli_command_picture,
    &cli_command_paper,
    &cli_command_compare,
    &cli_command_map,
    &cli_command_explain,
    &cli_command_reference,
    &cli_command_bench,
    &cli_command_list,
    &cli_command_help,
    NULL,
};

const cli_command *cli_command_find(const char *name) {
    for (const cli_command *const *command = cli_commands; *command; command++)
        if (strcmp((*command)->name, name) == 0)
            return *command;
    return NULL;
}

static void print_versions(void) {
    dl_component components[DL_MAX_COMPONENTS];
    const size_t count = dl_components(components);
    printf("driftlab %s\n", dl_version());
    for (size_t i = 0; i < count; i++)
        printf("  %-9s %s\n", components[i].name, components[i].version);
}

static cli_exit complain_of_command(const char *name) {
    const char *names[32];
    size_t count = 0;
    for (const cli_command *const *command = cli_commands; *command; command++)
        names[count++] = (*command)->name;
    names[count] = NULL;
    const char *closest = dl_closest_word(names, name);
    dl_error error;
    dl_fail(&error, DL_INPUT,
            closest ? "unknown command \"%s\"; did you mean \"%s\"?"
                    : "unknown command \"%s\" (driftlab --help lists them)",
            name, closest);
    cli_complain(error.message);
    return CLI_BAD_INPUT;
}

static char *joined(int count, char **words) {
    size_t room = 1;
    for (int i = 0; i < count; i++)
        room += strlen(words[i]) + 1;
    char *line = malloc(room), *to = line;
    for (int i = 0; line && i < count; i++)
        to += sprintf(to, i ? " %s" : "%s", words[i]);
    return line;
}

static cli_exit run_command(const cli_command *command, int count, char **words) {
    if (cli_wants_help(count - 2, words + 2)) {
        cli_help_command(command, stdout);
        return CLI_OK;
    }
    cli_input input = {0};
    dl_error error = {""};
    char *line = joined(count, words);
    input.line = line ? line : "";
    const dl_status status = cli_input_read(command, count - 2, words + 2, &input, &error);
    const cli_exit outcome = status ? cli_finish(status, &error) : command->run(&input);
    cli_input_release(command, &input);
    free(line);
    return outcome;
}

static cli_exit dispatch(int count, char **words) {
    if (count < 2) {
        cli_help_program(stderr);
        return CLI_BAD_INPUT;
    }
    if (strcmp(words[1], "--version") == 0) {
        print_versions();
        return CLI_OK;
    }
    if (strcmp(words[1], "--help") == 0 || strcmp(words[1], "-h") == 0) {
        cli_help_program(stdout);
        return CLI_OK;
    }
    if (count > 2 && strcmp(words[count - 1], "--version") == 0) {
        print_versions();
        return CLI_OK;
    }
    const cli_command *command = cli_command_find(words[1]);
    return command ? run_command(command, count, words) : complain_of_command(words[1]);
}

int main(int count, char **words) {
    /* A limit on file size is then a failing write, with a message, like a full disk. */
    signal(SIGXFSZ, SIG_IGN);
    cli_end_on_signals();
    const cli_exit outcome = dispatch(count, words);
    if (fflush(stdout) || ferror(stdout)) {
        cli_complain("standard output cannot be written");
        return outcome == CLI_OK ? CLI_IO : (int)outcome;
    }
    return (int)outcome;
}
