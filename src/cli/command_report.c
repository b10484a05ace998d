/* driftlab report: the page, from results alone. */
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/paths.h"
#include "driftlab/report.h"

typedef struct report_values {
    char *out;
} report_values;

static const dl_parameter options[] = {
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(report_values, out),
     .unit = "PAGE.html",
     .doc = "the page to write (default: report.html beside the results)"},
};

static cli_exit report(const cli_input *input) {
    const report_values *values = input->values;
    dl_results *results = NULL;
    dl_error error = {""};
    char *beside = cli_beside(input->word[0], "report.html");
    const char *page = values->out ? values->out : beside;
    dl_status status = page ? dl_results_read(input->word[0], &results, &error)
                            : dl_fail_memory(&error, "a file name");
    if (!status)
        status = dl_report_write_with_players(results, (const char *const *)input->repeated,
                                              input->repeats, page, &error);
    if (!status)
        printf("report: %s\n", page);
    dl_results_free(results);
    free(beside);
    return cli_finish(status, &error);
}

static const cli_repeated trajectory = {
    "trajectory", "RUN.h5", "a trajectory of driftlab run --out, to be played in the page", false};

const cli_command cli_command_report = {
    .name = "report",
    .arguments = "RESULTS.h5",
    .summary = "write the report of a study's results as one HTML page",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .repeated = &trajectory,
    .values_size = sizeof(report_values),
    .run = report,
};
