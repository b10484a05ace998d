/* driftlab study: every case of a study, the table, the answer, the report. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <unistd.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/paths.h"
#include "cli/terminal.h"
#include "driftlab/ranks.h"
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

static void format_progress(const dl_study_progress *progress, char *line, size_t size) {
    char left[32] = "";
    if (!isnan(progress->remaining))
        cli_format_seconds(progress->remaining, left, sizeof left);
    snprintf(line, size, "%zu/%zu  %s%s  %.90s", progress->done, progress->total, left,
             left[0] ? " left" : "", progress->current);
}

static void show_progress(void *context, const dl_study_progress *progress) {
    (void)context;
    char line[160];
    format_progress(progress, line, sizeof line);
    cli_show_progress(line);
}

/* Under mpiexec standard error is a pipe, whoever reads at its other end: whole lines, after 2 s
 * and then ever more seldom. */
static void tell_progress(void *context, const dl_study_progress *progress) {
    double *next = context;
    char line[160];
    if (progress->seconds < *next || !*progress->current)
        return;
    *next = 1.1 * progress->seconds + 2;
    format_progress(progress, line, sizeof line);
    fprintf(stderr, "%s\n", line);
}

static void tell_note(void *context, const char *text) {
    (void)context;
    cli_complain(text);
}

static dl_status run_study(const dl_study *study, const char *results_path,
                           const study_values *values, const char *line, dl_ranks *ranks,
                           dl_results **results, dl_error *error) {
    const bool progress = cli_shows_progress() && !ranks;
    double next = 2;
    const dl_study_options how = {.results = results_path,
                                  .command = line,
                                  .force = values->force,
                                  .processes = (size_t)values->jobs,
                                  .interrupt = cli_catch_signals(),
                                  .ranks = ranks,
                                  .on_note = tell_note,
                                  .on_progress = progress ? show_progress
                                                 : ranks  ? tell_progress
                                                          : NULL,
                                  .context = &next};
    const dl_status status = dl_study_run(study, &how, results, error);
    if (progress)
        cli_show_progress(NULL);
    return status;
}

/* Reads, runs, prints: what one process does, or the first of several. */
static dl_status lead(const cli_input *input, dl_ranks *ranks, dl_error *error) {
    const study_values *values = input->values;
    dl_study *study = NULL;
    dl_results *results = NULL;
    char *beside = cli_beside(input->word[0], "results.h5");
    const char *path = values->out ? values->out : beside;
    dl_status status =
        path ? dl_study_read(input->word[0], &study, error) : dl_fail_memory(error, "a file name");
    if (!status)
        status = run_study(study, path, values, input->line, ranks, &results, error);
    if (!status) {
        dl_results_print(results, stdout);
        printf("results: %s\n", path);
    }
    if (!status && values->report) {
        status = dl_report_write(results, values->report, error);
        if (!status)
            printf("report: %s\n", values->report);
    }
    dl_results_free(results);
    dl_study_free(study);
    free(beside);
    return status;
}

static dl_status serve(const cli_input *input, dl_ranks *ranks, dl_error *error) {
    dl_study *study = NULL;
    dl_error why = {""};
    dl_study_read(input->word[0], &study, &why);
    const dl_status status = dl_ranks_serve(ranks, study, why.message, error);
    dl_study_free(study);
    return status;
}

#ifdef DL_RANKS
/* Beside the program where it is built, at a fixed way from it where it is installed. */
static char *find_helper(void) {
    char *helper = cli_beside_program("driftlab-ranks");
    if (helper && access(helper, X_OK) == 0)
        return helper;
    free(helper);
    return cli_beside_program(DL_RANKS);
}
#endif

static dl_status join(dl_ranks **ranks, dl_error *error) {
#ifdef DL_RANKS
    char *helper = find_helper();
    const dl_status status =
        helper ? dl_ranks_join(helper, ranks, error) : dl_fail_memory(error, "a file name");
    free(helper);
    return status;
#else
    (void)ranks;
    return dl_fail(error, DL_INPUT,
                   "found mpiexec, expected -j N: this driftlab was built without MPI");
#endif
}

static cli_exit study_command(const cli_input *input) {
    dl_error error = {""};
    dl_ranks *ranks = NULL;
    dl_status status = dl_ranks_started() > 1 ? join(&ranks, &error) : DL_OK;
    if (!status)
        status = !ranks || dl_ranks_is_first(ranks) ? lead(input, ranks, &error)
                                                    : serve(input, ranks, &error);
    dl_ranks_leave(ranks);
    return cli_finish(status, &error);
}

const cli_command cli_command_study = {
    .name = "study",
    .arguments = "STUDY",
    .summary = "run what is missing of a study and print its table and answer",
    .details =
        "Every case runs in a process of its own and is kept as soon as it is finished: a\n"
        "study that was stopped goes on where it was when it is run again. Under Open MPI,\n"
        "mpiexec -n 8 driftlab study STUDY, eight processes on any machines share the cases.\n",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .values_size = sizeof(study_values),
    .run = study_command,
};
