/* Help texts, made from the tables that are used. */
#ifndef DL_CLI_HELP_H
#define DL_CLI_HELP_H

#include <stdio.h>
#include "cli/command.h"
#include "driftlab/method.h"

void cli_help_program(FILE *out);
void cli_help_command(const cli_command *command, FILE *out);
void cli_help_method(const dl_method_row *row, FILE *out);

typedef struct cli_flag_word {
    unsigned flag;
    const char *words;
} cli_flag_word;

/* What a method's flags say, in words; ends with flag 0. */
extern const cli_flag_word cli_flag_words[];

#endif
