#include "cli/help.h"

#include <string.h>

const cli_flag_word cli_flag_words[] = {
    {DL_FIXED_STEP, "fixed step"},
    {DL_ADAPTIVE, "adaptive"},
    {DL_IMPLICIT, "implicit"},
    {DL_SYMPLECTIC, "symplectic"},
    {DL_TIME_SYMMETRIC, "time-symmetric"},
    {DL_CONSERVES_ENERGY, "conserves energy"},
    {DL_CONSERVES_MOMENTUM, "conserves momenta"},
    {DL_NEEDS_JACOBIAN, "needs a Jacobian"},
    {DL_RESTARTS_EXACTLY, "restarts exactly"},
    {DL_SPLITS_FORCE, "splits the force"},
    {0, NULL},
};

void cli_help_program(FILE *out) {
    fputs("driftlab: which integrator, at which step, costs how much for which error?\n\n"
          "usage: driftlab COMMAND ...\n\n",
          out);
    for (const cli_command *const *command = cli_commands; *command; command++)
        fprintf(out, "  %-9s %-24s %s\n", (*command)->name, (*command)->arguments,
                (*command)->summary);
    fputs("\n"
          "  driftlab COMMAND --help    options of a command\n"
          "  driftlab --version         versions of the program and its libraries\n\n"
          "exit status: 0 ok; 1 the run failed; 2 bad input, nothing written; 3 reading or\n"
          "writing failed; 130 interrupted\n",
          out);
}

static void print_option(const dl_parameter *row, FILE *out) {
    char form[64];
    snprintf(form, sizeof form, "--%s %s", row->name, row->kind == DL_FLAG ? "" : row->unit);
    fprintf(out, "  %-24s %s", form, row->doc);
    if (row->fallback && row->kind != DL_FLAG)
        fprintf(out, " (default %s)", row->fallback);
    fputc('\n', out);
}

void cli_help_command(const cli_command *command, FILE *out) {
    const cli_repeated *const repeated[] = {command->repeated,
                                            command->takes_let ? &cli_let : NULL};
    char form[64];
    const bool options = command->options.count || repeated[0] || repeated[1];
    fprintf(out, "usage: driftlab %s%s%s%s\n\n%s\n", command->name, *command->arguments ? " " : "",
            command->arguments, options ? " [OPTION ...]" : "", command->summary);
    if (command->details)
        fprintf(out, "\n%s", command->details);
    if (options)
        fputs("\noptions\n", out);
    for (size_t i = 0; i < command->options.count; i++)
        print_option(&command->options.rows[i], out);
    for (size_t i = 0; i < sizeof repeated / sizeof *repeated; i++) {
        if (!repeated[i])
            continue;
        snprintf(form, sizeof form, "--%s %s", repeated[i]->name, repeated[i]->unit);
        fprintf(out, "  %-24s %s; may be repeated\n", form, repeated[i]->doc);
    }
}

static void print_step(const dl_method_row *row, FILE *out) {
    dl_method_table shown = {.order = row->order, .stages = row->stages};
    const bool by_table = dl_method_default_table(row, &shown);
    if (shown.order)
        fprintf(out, "order %d", shown.order);
    else
        fputs("order varies", out);
    if (shown.stages)
        fprintf(out, ", %d stage%s", shown.stages, shown.stages == 1 ? "" : "s");
    if (by_table)
        fputs(" with the default table", out);
    if (row->made_of)
        fprintf(out, ", %s", row->made_of);
    if (row->forces)
        fprintf(out, ", %d force%s a step", row->forces, row->forces == 1 ? "" : "s");
}

/* Under an option whose words are tables of coefficients: the stages of each. */
static void print_tables(const dl_method_row *row, const dl_parameter *option, FILE *out) {
    dl_method_table table;
    if (!row->table || option->kind != DL_WORD || !row->table(option->words, 0, &table))
        return;
    fprintf(out, "    %-16s stages:", "");
    for (size_t k = 0; option->words[k]; k++)
        if (row->table(option->words, k, &table))
            fprintf(out, "%s %s %d", k ? "," : "", option->words[k], table.stages);
    fputc('\n', out);
}

void cli_help_method(const dl_method_row *row, FILE *out) {
    fprintf(out, "%s  (%s, ", row->name, row->family);
    print_step(row, out);
    fprintf(out, ")\n    %s\n    ", row->doc);
    const char *separator = "";
    for (const cli_flag_word *flag = cli_flag_words; flag->flag; flag++)
        if (row->flags & flag->flag) {
            fprintf(out, "%s%s", separator, flag->words);
            separator = ", ";
        }
    fputc('\n', out);
    for (size_t i = 0; i < row->options.count; i++) {
        const dl_parameter *option = &row->options.rows[i];
        char range[1024];
        dl_parameter_range(option, range, sizeof range);
        fprintf(out, "    %-16s %-18s default %-12s %s", option->name, range,
                option->fallback ? option->fallback : "the scene's", option->doc);
        if (option->unit[0])
            fprintf(out, " [%s]", option->unit);
        if (dl_parameter_cause(row->options, option))
            fprintf(out, " (with %s)", option->when);
        fputc('\n', out);
        print_tables(row, option, out);
    }
}
