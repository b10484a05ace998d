/* driftlab run: one scene, one method, one summary. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/settings.h"
#include "cli/summary.h"
#include "cli/terminal.h"
#include "driftlab/run.h"
#include "driftlab/trajectory.h"

typedef struct run_values {
    char *method, *dt, *rtol, *start, *out;
    double t_end, sample, time_limit, energy_bound;
    bool json, no_ledger;
} run_values;

static const dl_parameter options[] = {
    CLI_OPTION_METHOD(run_values),
    CLI_OPTION_DT(run_values),
    CLI_OPTION_RTOL(run_values),
    CLI_OPTION_T_END(run_values),
    CLI_OPTION_POSITIVE(run_values, "sample", sample, "X",
                        "time between samples (default: the scene's, or at most 50 samples)"),
    {.name = "start",
     .kind = DL_TEXT,
     .offset = offsetof(run_values, start),
     .unit = "FILE.h5",
     .doc = "start from the last frame of this H5MD trajectory"},
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(run_values, out),
     .unit = "FILE.h5",
     .doc = "write an H5MD trajectory"},
    CLI_OPTION_TIME_LIMIT(run_values, "stop after S seconds of CPU time (default: none)"),
    CLI_OPTION_POSITIVE(run_values, "energy-bound", energy_bound, "X",
                        "energy error, in units of its scale, from which on a run is unstable "
                        "(default: 100)"),
    {.name = "no-ledger",
     .kind = DL_FLAG,
     .offset = offsetof(run_values, no_ledger),
     .fallback = "false",
     .doc = "do not book what walls and radiation take: faster where hits are many, no errors"},
    CLI_OPTION_JSON(run_values),
};

typedef struct job {
    dl_scene *scene;
    const dl_method_row *row;
    void *options;
    char options_text[1024];
    const char *out; /* NULL: no trajectory */
    dl_trajectory *trajectory;
} job;

static dl_status apply_setting(job *work, const cli_setting *setting, dl_error *error) {
    dl_error reason = {""};
    const dl_status status =
        dl_method_options_set(work->row, work->options, setting->key, setting->value, &reason);
    return status ? dl_fail(error, status, "%s: %s", setting->flag, reason.message) : DL_OK;
}

static dl_status prepare_method(job *work, const cli_input *input, dl_error *error) {
    const run_values *values = input->values;
    cli_setting settings[CLI_MAX_SETTINGS];
    size_t count = 0;
    dl_status status = cli_settings_method(values->method, error);
    if (!status)
        status = dl_method_find(values->method, &work->row, error);
    if (!status)
        status = dl_method_options_create(work->row, work->scene, &work->options, error);
    if (!status)
        status = cli_settings_read(input, values->dt, values->rtol, settings, &count, error);
    for (size_t i = 0; !status && i < count; i++)
        status = apply_setting(work, &settings[i], error);
    if (!status)
        dl_method_options_format(work->row, work->options, work->options_text,
                                 sizeof work->options_text);
    return status;
}

/* The scene from where the trajectory in `path` ended. */
static dl_status start_from(job *work, const char *path, dl_error *error) {
    double *y_all = NULL, time = 0;
    dl_scene *restarted = NULL;
    dl_status status = dl_trajectory_read_last(path, work->scene, &y_all, &time, error);
    if (!status)
        status = dl_scene_restart(work->scene, y_all, &restarted, error);
    free(y_all);
    if (status)
        return status;
    dl_scene_free(work->scene);
    work->scene = restarted;
    return DL_OK;
}

/* The trajectory is created with its first frame: a run that is refused leaves no file. */
static dl_status write_frame(void *context, const dl_sample *sample, dl_error *error) {
    job *work = context;
    if (!work->trajectory) {
        const dl_status status = dl_trajectory_create(work->out, work->scene, work->row->name,
                                                      work->options_text, &work->trajectory, error);
        if (status)
            return status;
    }
    return dl_trajectory_append(work->trajectory, sample, error);
}

static void show_progress(void *context, double fraction, double seconds) {
    (void)context;
    static double shown = -1;
    char left[32], line[80];
    if (seconds - shown < 0.2 || fraction <= 0)
        return;
    shown = seconds;
    cli_format_seconds(seconds * (1 - fraction) / fraction, left, sizeof left);
    snprintf(line, sizeof line, "%3.0f %%, %s left", 100 * fraction, left);
    cli_show_progress(line);
}

/* Where a method chooses its steps, and mirrors act at their ends, what is hit is a matter of
 * chance. */
static void warn_of_mirrors(const job *work) {
    const dl_parameter *const step = dl_parameter_find(work->row->options, "step");
    const bool fixed =
        step && *(const double *)(const void *)((const char *)work->options + step->offset) > 0;
    if (work->scene->walls.present && work->scene->walls.rule == DL_MIRROR && !fixed)
        cli_complain(
            "warning: walls by the rule mirror act at the ends of steps, which this method "
            "chooses: the hits depend on them, and many short steps may be taken; the rule "
            "located does neither");
}

static dl_status integrate(job *work, const run_values *values, dl_run_summary *summary,
                           dl_error *error) {
    dl_run_options how;
    dl_run_options_default(&how);
    how.end = values->t_end;
    how.sample = values->sample;
    how.time_limit = values->time_limit;
    how.ledger = !values->no_ledger;
    if (values->energy_bound > 0)
        how.energy_bound = values->energy_bound;
    how.interrupt = cli_catch_signals();
    if (work->out) {
        how.on_sample = write_frame;
        how.context = work;
    }
    const bool progress = cli_shows_progress();
    if (progress)
        how.on_progress = show_progress;
    warn_of_mirrors(work);
    dl_status status = dl_run(work->scene, work->row, work->options, &how, summary, NULL, error);
    if (status == DL_INPUT && values->t_end > 0)
        cli_name_option("end: ", "--t-end: ", error);
    if (status == DL_INPUT && values->sample > 0)
        cli_name_option("sample: ", "--sample: ", error);
    if (status == DL_INPUT)
        cli_name_option("step: ", values->dt ? "--dt: step: " : "--set: step: ", error);
    if (progress)
        cli_show_progress(NULL);
    if (work->trajectory) {
        dl_error reason = {""};
        const dl_status closed = dl_trajectory_close(work->trajectory, &reason);
        work->trajectory = NULL;
        if (closed && !status && !summary->status) {
            summary->status = closed;
            memcpy(summary->message, reason.message, sizeof summary->message);
        }
    }
    return status;
}

static cli_exit run(const cli_input *input) {
    const run_values *values = input->values;
    job work = {.out = values->out};
    dl_run_summary summary;
    dl_error error = {""};
    dl_status status = cli_read_scene(input, input->word[0], &work.scene, &error);
    if (!status)
        status = prepare_method(&work, input, &error);
    if (!status && values->start)
        status = start_from(&work, values->start, &error);
    if (!status)
        status = integrate(&work, values, &summary, &error);
    /* A trajectory that could not even be begun leaves nothing to tell. */
    const bool refused = summary.status == DL_IO || summary.status == DL_INPUT;
    const bool ran = !status && (!refused || summary.steps);
    if (ran) {
        if (values->json)
            status = cli_summary_json(work.scene, work.row, work.options, &summary, stdout, &error);
        else
            cli_summary_table(work.scene, work.row, work.options_text, &summary, stdout);
    }
    if (!status && summary.status)
        status = dl_fail(&error, summary.status, "%s", summary.message);
    if (work.row)
        dl_method_options_free(work.row, work.options);
    dl_scene_free(work.scene);
    return cli_finish(status, &error);
}

static const cli_repeated set = {"set", "KEY=VALUE", "an option of the method", true};

const cli_command cli_command_run = {
    .name = "run",
    .arguments = "SCENE",
    .summary = "integrate a scene with one method",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .repeated = &set,
    .options = CLI_TABLE(options),
    .values_size = sizeof(run_values),
    .run = run,
};
