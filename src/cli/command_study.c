/* driftlab study: every case of a study, the table, the answer, the report. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/paths.h"
#include "cli/terminal.h"
#include "driftlab/report.h"
#include "driftlab/study.h"

typedef struct study_values {
    char *out, *report;
    bool force;
    long jobs;
} study_values;

static const dl_parameter options[] = {
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(study_values, out),
     .unit = "FILE.h5",
     .doc = "results file (default: results.h5 beside the study)"},
    {.name = "report",
     .kind = DL_TEXT,
     .offset = offsetof(study_values, report),
     .unit = "PAGE.html",
     .doc = "write the report too"},
    {.name = "force",
     .kind = DL_FLAG,
     .offset = offsetof(study_values, force),
     .fallback = "false",
     .doc = "run every case again, finished ones too"},
    {.name = "jobs",
     .kind = DL_INTEGER,
     .offset = offsetof(study_values, jobs),
     .unit = "N",
     .minimum = 1,
     .maximum = 1024,
     .fallback = "1",
     .doc = "cases side by side, each kept to a processor of its own; also -j N"},
};

static void show_progress(void *context, const dl_study_progress *progress) {
    (void)context;
    char left[32] = "", line[160];
    if (!isnan(progress->remaining))
        cli_format_seconds(progress->remaining, left, sizeof left);
    snprintf(line, sizeof line, "%zu/%zu  %s%s  %.90s", progress->done, progress->total, left,
             left[0] ? " left" : "", progress->current);
    cli_show_progress(line);
}

static dl_status run_study(const dl_study *study, const char *results_path,
                           const study_values *values, const char *line, dl_results **results,
                           dl_error *error) {
    const bool progress = cli_shows_progress();
    const dl_study_options how = {.results = results_path,
                                  .command = line,
                                  .force = values->force,
                                  .processes = (size_t)values->jobs,
                                  .interrupt = cli_catch_signals(),
                                  .on_progress = progress ? show_progress : NULL};
    const dl_status status = dl_study_run(study, &how, results, error);
    if (progress)
        cli_show_progress(NULL);
    return status;
}

static cli_exit study_command(const cli_input *input) {
    const study_values *values = input->values;
    dl_study *study = NULL;
    dl_results *results = NULL;
    dl_error error = {""};
    char *beside = cli_beside(input->word[0], "results.h5");
    const char *path = values->out ? values->out : beside;
    dl_status status = path ? dl_study_read(input->word[0], &study, &error)
                            : dl_fail_memory(&error, "a file name");
    if (!status)
        status = run_study(study, path, values, input->line, &results, &error);
    if (!status) {
        dl_results_print(results, stdout);
        printf("results: %s\n", path);
    }
    if (!status && values->report) {
        status = dl_report_write(results, values->report, &error);
        if (!status)
            printf("report: %s\n", values->report);
    }
    dl_results_free(results);
    dl_study_free(study);
    free(beside);
    return cli_finish(status, &error);
}

const cli_command cli_command_study = {
    .name = "study",
    .arguments = "STUDY",
    .summary = "run what is missing of a study and print its table and answer",
    .details = "Every case runs in a process of its own and is kept as soon as it is finished: a\n"
               "study that was stopped goes on where it was when it is run again.\n",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .values_size = sizeof(study_values),
    .run = study_command,
};
