#include "cli/arguments.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

typedef struct reader {
    const cli_command *command;
    cli_input *input;
    int count, at;
    char **words;
} reader;

bool cli_wants_help(int count, char *const *words) {
    for (int i = 0; i < count && strcmp(words[i], "--") != 0; i++)
        if (strcmp(words[i], "--help") == 0 || strcmp(words[i], "-h") == 0)
            return true;
    return false;
}

static dl_status unknown_option(const cli_command *command, const char *name, dl_error *error) {
    const char *names[64];
    size_t count = 0;
    for (size_t i = 0; i < command->options.count; i++)
        names[count++] = command->options.rows[i].name;
    if (command->repeated)
        names[count++] = command->repeated->name;
    if (command->takes_let)
        names[count++] = cli_let.name;
    names[count++] = "help";
    names[count] = NULL;
    const char *closest = dl_closest_word(names, name);
    if (closest)
        return dl_fail(error, DL_INPUT,
                       "unknown option --%s of driftlab %s; did you mean \"--%s\"?", name,
                       command->name, closest);
    return dl_fail(error, DL_INPUT,
                   "unknown option --%s of driftlab %s (driftlab %s --help lists them)", name,
                   command->name, command->name);
}

/* The value of option `name`: after `=` or the next word. */
static dl_status option_value(reader *r, const char *name, const char *equals, const char **value,
                              dl_error *error) {
    if (equals) {
        *value = equals + 1;
        return DL_OK;
    }
    if (r->at + 1 >= r->count)
        return dl_fail(error, DL_INPUT, "--%s: found nothing after it, expected a value", name);
    *value = r->words[++r->at];
    return DL_OK;
}

/* A copy of the next value of an option that may be repeated. */
static dl_status repeated_value(reader *r, const cli_repeated *option, size_t count,
                                const char *equals, char **copy, dl_error *error) {
    const char *value = NULL;
    const dl_status status = option_value(r, option->name, equals, &value, error);
    if (status)
        return status;
    const char *sign = strchr(value, '=');
    if (option->assigns && (!sign || sign == value))
        return dl_fail(error, DL_INPUT, "--%s: found \"%s\", expected %s", option->name, value,
                       option->unit);
    if (count == CLI_MAX_REPEATED)
        return dl_fail(error, DL_INPUT, "--%s: found more than %d of them", option->name,
                       CLI_MAX_REPEATED);
    *copy = strdup(value);
    return *copy ? DL_OK : dl_fail_memory(error, "a command line");
}

static dl_status add_repeated(reader *r, const char *equals, dl_error *error) {
    cli_input *const input = r->input;
    char **const to = &input->repeated[input->repeats];
    const dl_status status =
        repeated_value(r, r->command->repeated, input->repeats, equals, to, error);
    input->repeats += !status;
    return status;
}

static dl_status add_let(reader *r, const char *equals, dl_error *error) {
    cli_input *const input = r->input;
    char *text;
    const dl_status status = repeated_value(r, &cli_let, input->lets, equals, &text, error);
    if (status)
        return status;
    char *const sign = strchr(text, '=');
    *sign = '\0';
    input->let[input->lets++] = (dl_let){.name = text, .value = sign + 1};
    return DL_OK;
}

static dl_status set_option(reader *r, const dl_parameter *row, const char *equals,
                            dl_error *error) {
    const char *value = "true";
    dl_status status = DL_OK;
    if (row->kind == DL_FLAG && equals)
        return dl_fail(error, DL_INPUT, "--%s: found \"%s\", expected no value", row->name, equals);
    if (row->kind != DL_FLAG)
        status = option_value(r, row->name, equals, &value, error);
    if (status)
        return status;
    dl_error reason = {""};
    status = dl_parameter_set(row, r->input->values, value, &reason);
    r->input->given[row - r->command->options.rows] = true;
    return status ? dl_fail(error, status, "--%s", reason.message) : DL_OK;
}

static dl_status read_option(reader *r, const char *text, dl_error *error) {
    char name[64];
    const char *equals = strchr(text, '=');
    const size_t length = equals ? (size_t)(equals - text) : strlen(text);
    if (length >= sizeof name)
        return dl_fail(error, DL_INPUT, "unknown option --%.60s...", text);
    memcpy(name, text, length);
    name[length] = '\0';
    if (r->command->repeated && strcmp(name, r->command->repeated->name) == 0)
        return add_repeated(r, equals, error);
    if (r->command->takes_let && strcmp(name, cli_let.name) == 0)
        return add_let(r, equals, error);
    const dl_parameter *row = dl_parameter_find(r->command->options, name);
    return row ? set_option(r, row, equals, error) : unknown_option(r->command, name, error);
}

/* "-j": the option that begins with that letter, where just one does. */
static dl_status read_letter(reader *r, char letter, dl_error *error) {
    const dl_parameter_table table = r->command->options;
    const dl_parameter *found = NULL;
    size_t matches = 0;
    for (size_t i = 0; i < table.count; i++)
        if (table.rows[i].name[0] == letter) {
            found = &table.rows[i];
            matches++;
        }
    if (matches == 1)
        return set_option(r, found, NULL, error);
    return dl_fail(error, DL_INPUT, "unknown option -%c; options of driftlab %s start with --",
                   letter, r->command->name);
}

static dl_status add_word(reader *r, const char *word, dl_error *error) {
    cli_input *input = r->input;
    if (input->words == r->command->most_words)
        return dl_fail(error, DL_INPUT, "%s: found \"%s\" after %s, expected nothing more",
                       r->command->name, word, r->command->arguments);
    input->word[input->words++] = word;
    return DL_OK;
}

dl_status cli_input_read(const cli_command *command, int count, char **words, cli_input *input,
                         dl_error *error) {
    reader r = {command, input, count, 0, words};
    bool options = true;
    input->values = calloc(1, command->values_size ? command->values_size : 1);
    if (!input->values)
        return dl_fail_memory(error, "a command line");
    dl_status status = dl_parameter_defaults(command->options, input->values, error);
    for (; !status && r.at < count; r.at++) {
        const char *word = words[r.at];
        if (options && strcmp(word, "--") == 0)
            options = false;
        else if (options && strncmp(word, "--", 2) == 0)
            status = read_option(&r, word + 2, error);
        else if (options && word[0] == '-' && word[1] && !word[2])
            status = read_letter(&r, word[1], error);
        else if (options && word[0] == '-' && word[1])
            status = dl_fail(error, DL_INPUT,
                             "unknown option %s; options of driftlab %s start "
                             "with --",
                             word, command->name);
        else
            status = add_word(&r, word, error);
    }
    if (!status && input->words < command->least_words)
        status = dl_fail(error, DL_INPUT, "%s: found nothing, expected %s (driftlab %s --help)",
                         command->name, command->arguments, command->name);
    return status;
}

bool cli_input_gives(const cli_command *command, const cli_input *input, const char *option) {
    return input->given[dl_parameter_find(command->options, option) - command->options.rows];
}

void cli_input_release(const cli_command *command, cli_input *input) {
    if (input->values)
        dl_parameter_release(command->options, input->values);
    free(input->values);
    for (size_t i = 0; i < input->repeats; i++)
        free(input->repeated[i]);
    for (size_t i = 0; i < input->lets; i++)
        free((char *)(uintptr_t)input->let[i].name);
}
