/* The words after a command's name, read by the command's table. */
#ifndef DL_CLI_ARGUMENTS_H
#define DL_CLI_ARGUMENTS_H

#include "cli/command.h"

/* Whether --help stands among the words. */
bool cli_wants_help(int count, char *const *words);

/* Fills `input` (values are allocated; free with cli_input_release, also on failure). DL_INPUT
 * names the option or word, what was found and what was expected. */
dl_status cli_input_read(const cli_command *command, int count, char **words, cli_input *input,
                         dl_error *error);
void cli_input_release(const cli_command *command, cli_input *input);

#endif
