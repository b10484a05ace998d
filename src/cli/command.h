/* Commands of the program: one row and one file each.
 *
 * What a command takes is a parameter table, as for scenes and methods: `--NAME VALUE` for every
 * row, `--NAME` alone for a DL_FLAG. A row's `unit` is the word that stands for the value in
 * `--help`. */
#ifndef DL_CLI_COMMAND_H
#define DL_CLI_COMMAND_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/parameter.h"
#include "driftlab/scene.h"

typedef enum cli_exit {
    CLI_OK = 0,
    CLI_FAILED = 1,    /* the run's status is not ok */
    CLI_BAD_INPUT = 2, /* nothing has been written */
    CLI_IO = 3,
    CLI_INTERRUPTED = 130, /* as a shell reports SIGINT */
} cli_exit;

#define CLI_MAX_WORDS    16
#define CLI_MAX_REPEATED 64
#define CLI_MAX_OPTIONS  32

/* What a command line said. */
typedef struct cli_input {
    void *values;                    /* the structure that the command's table describes */
    bool given[CLI_MAX_OPTIONS];     /* rows of the table that stand on the line */
    const char *word[CLI_MAX_WORDS]; /* arguments that are no options; NULL where not given */
    size_t words;
    char *repeated[CLI_MAX_REPEATED]; /* values of the option that may be repeated */
    size_t repeats;
    dl_let let[CLI_MAX_REPEATED]; /* of --let; the name's memory is the input's, the value lies in
                                     it */
    size_t lets;
    const char *line; /* the whole command line, for the metadata of results */
} cli_input;

/* An option that may be given again and again. */
typedef struct cli_repeated {
    const char *name, *unit, *doc;
    bool assigns; /* values have the form KEY=VALUE */
} cli_repeated;

typedef struct cli_command {
    const char *name;
    const char *arguments; /* "SCENE", after the name in the usage line */
    const char *summary;   /* one line */
    const char *details;   /* more for --help; may be NULL */
    size_t least_words, most_words;
    const cli_repeated *repeated; /* NULL: there is none */
    bool takes_let;               /* --let NAME=VALUE, for cli_read_scene */
    dl_parameter_table options;
    size_t values_size;
    cli_exit (*run)(const cli_input *input);
} cli_command;

extern const cli_command cli_command_run, cli_command_study, cli_command_report,
    cli_command_compare, cli_command_map, cli_command_explain, cli_command_observe,
    cli_command_paper, cli_command_picture, cli_command_reference, cli_command_measure,
    cli_command_check, cli_command_recommend, cli_command_bench, cli_command_list, cli_command_help;

/* All of them, NULL-terminated. */
extern const cli_command *const cli_commands[];

const cli_command *cli_command_find(const char *name);

/* Whether the option stands on the line, with its default or another value. */
bool cli_input_gives(const cli_command *command, const cli_input *input, const char *option);

/* The option --let of every command that takes it. */
extern const cli_repeated cli_let;

/* Reads a scene with the numbers that --let sets. */
dl_status cli_read_scene(const cli_input *input, const char *path, dl_scene **scene,
                         dl_error *error);
/* DL_INPUT where there is a --let: what `path` holds is no scene file. */
dl_status cli_refuse_let(const cli_input *input, const char *path, dl_error *error);

#define CLI_TABLE(array)                                                                           \
    { .rows = (array), .count = sizeof(array) / sizeof *(array) }

#endif
