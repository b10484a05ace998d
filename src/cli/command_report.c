/* driftlab report: the page, from results alone. */
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/paths.h"
#include "driftlab/report.h"

typedef struct report_values {
    char *out, *title;
} report_values;

static const dl_parameter options[] = {
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(report_values, out),
     .unit = "PAGE.html",
     .doc = "the page to write (default: report.html beside the first results)"},
    {.name = "title",
     .kind = DL_TEXT,
     .offset = offsetof(report_values, title),
     .unit = "TEXT",
     .doc = "the page's title (default: the study's, or the scenes' names)"},
};

/* A message about several studies does not know their files. */
static dl_status read_all(const cli_input *input, dl_results *results[CLI_MAX_WORDS],
                          dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < input->words && status == DL_OK; i++)
        status = dl_results_read(input->word[i], &results[i], error);
    return status;
}

static dl_status write_page(const cli_input *input, dl_results *results[CLI_MAX_WORDS],
                            dl_error *error) {
    const report_values *values = input->values;
    char *beside = cli_beside(input->word[0], "report.html");
    const char *page = values->out ? values->out : beside;
    const dl_report made = {.results = (const dl_results *const *)results,
                            .studies = input->words,
                            .title = values->title,
                            .trajectory = (const char *const *)input->repeated,
                            .trajectories = input->repeats};
    const dl_status status =
        page ? dl_report_write_page(&made, page, error) : dl_fail_memory(error, "the page's name");
    if (!status)
        printf("report: %s\n", page);
    free(beside);
    return status;
}

static void print_answer(const cli_input *input, dl_results *results[CLI_MAX_WORDS]) {
    char answer[4 * DL_MESSAGE_SIZE];
    dl_results_answer_all((const dl_results *const *)results, input->words, answer, sizeof answer);
    printf("%s\n", answer);
}

static cli_exit report(const cli_input *input) {
    dl_results *results[CLI_MAX_WORDS] = {NULL};
    dl_error error = {""};
    dl_status status = read_all(input, results, &error);
    if (!status)
        status = write_page(input, results, &error);
    if (!status && input->words > 1)
        print_answer(input, results);
    for (size_t i = 0; i < input->words; i++)
        dl_results_free(results[i]);
    return cli_finish(status, &error);
}

static const cli_repeated trajectory = {
    "trajectory", "RUN.h5", "a trajectory of driftlab run --out, to be played in the page", false};

const cli_command cli_command_report = {
    .name = "report",
    .arguments = "RESULTS.h5 ...",
    .summary = "write the report of a study's results, or of several studies', as one HTML page",
    .details =
        "Several studies of one kind, each on other scenes, make one page: the answer over all\n"
        "scenes, methods by scenes, then every scene.\n",
    .least_words = 1,
    .most_words = CLI_MAX_WORDS,
    .options = CLI_TABLE(options),
    .repeated = &trajectory,
    .values_size = sizeof(report_values),
    .run = report,
};
