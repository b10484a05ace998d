/* A run of a paper's set: made, kept, found again, gone on with.
 *
 * FOLDER/NAME.h5 is its trajectory, FOLDER/NAME.json says what it is of and how it ended. A run of
 * several segments leaves NAME.part001.h5 ... and the last as NAME.h5: each starts from the last
 * frame of the one before, its velocities at the same time as its positions, so that leap-frog goes
 * on but for roundoff, not bit by bit. */
#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "driftlab/run.h"
#include "driftlab/version.h"
#include "io/replace_file.h"
#include "study/paper_plan.h"
#include "study/plan.h"

static const char long_message[] = "a long run: it is made with --long";

typedef struct making {
    const dl_paper_case *cased;
    const dl_paper_options *options;
    dl_paper_progress *progress;
    dl_paper_run_row *row;
    dl_scene *scene; /* of the segment that is made */
    const dl_method_row *method;
    void *method_options;
    double sample, segment;
    double began;
    char *key;
    size_t number; /* of the segment */
    char *path;    /* of its trajectory */
    dl_trajectory *trajectory;
} making;

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

bool dl_paper_is_wanted(const dl_paper_case *cased, const dl_paper_options *options) {
    return options->long_runs || !cased->is_long;
}

/* --- files ------------------------------------------------------------------------------------ */

char *dl_paper_trajectory(const char *folder, const dl_paper_run_row *row, size_t segment) {
    return segment + 1 < row->segments
               ? dl_text("%s/%s.part%03zu.h5", folder, row->name, segment + 1)
               : dl_text("%s/%s.h5", folder, row->name);
}

static char *record_path(const making *m) {
    return dl_text("%s/%s.json", m->options->folder, m->cased->name);
}

/* --- the record ------------------------------------------------------------------------------- */

static dl_status write_record(const making *m, dl_error *error) {
    const dl_paper_run_row *row = m->row;
    json_t *record =
        json_pack("{s:s, s:s, s:s, s:I, s:f, s:f, s:f, s:f, s:f, s:I, s:I}", "key", m->key,
                  "status", dl_status_name(row->status), "message", row->message, "segments_done",
                  (json_int_t)row->segments_done, "reached", row->reached, "step", row->step,
                  "energy_error", isfinite(row->energy_error) ? row->energy_error : -1,
                  "energy_scale", isfinite(row->energy_scale) ? row->energy_scale : -1,
                  "cpu_seconds", row->cpu_seconds, "steps", (json_int_t)row->steps,
                  "nonlinear_iterations", (json_int_t)row->nonlinear_iterations);
    char *text = record ? json_dumps(record, JSON_INDENT(2) | JSON_REAL_PRECISION(17)) : NULL;
    char *path = record_path(m);
    const dl_status status = text && path ? dl_replace_file(path, text, strlen(text), error)
                                          : dl_fail_memory(error, "the record of a run");
    json_decref(record);
    free(text);
    free(path);
    return status;
}

static double real_of(const json_t *record, const char *name) {
    const double value = json_number_value(json_object_get(record, name));
    return value < 0 ? NAN : value;
}

/* Sets the row from a record of the same run; false where there is none. */
static bool read_record(const making *m) {
    dl_paper_run_row *row = m->row;
    char *path = record_path(m);
    json_t *record = path ? json_load_file(path, 0, NULL) : NULL;
    free(path);
    const char *key = json_string_value(json_object_get(record, "key"));
    const char *status = json_string_value(json_object_get(record, "status"));
    const char *message = json_string_value(json_object_get(record, "message"));
    const bool same = key && status && message && strcmp(key, m->key) == 0;
    if (same) {
        row->status = dl_status_from_name(status);
        snprintf(row->message, sizeof row->message, "%s", message);
        row->segments_done = (size_t)json_integer_value(json_object_get(record, "segments_done"));
        row->reached = real_of(record, "reached");
        row->step = real_of(record, "step");
        row->energy_error = real_of(record, "energy_error");
        row->energy_scale = real_of(record, "energy_scale");
        row->cpu_seconds = real_of(record, "cpu_seconds");
        row->steps = (unsigned long)json_integer_value(json_object_get(record, "steps"));
        row->nonlinear_iterations =
            (unsigned long)json_integer_value(json_object_get(record, "nonlinear_iterations"));
    }
    json_decref(record);
    return same;
}

static void forget(dl_paper_run_row *row) {
    row->status = DL_OK;
    row->message[0] = '\0';
    row->segments_done = 0;
    row->reached = row->cpu_seconds = 0;
    row->energy_error = row->energy_scale = NAN;
    row->steps = row->nonlinear_iterations = 0;
}

/* A file that is damaged is none. */
static bool is_readable(const char *path, const dl_scene *scene) {
    dl_frames *frames = NULL;
    double *y_all = malloc(2 * (size_t)scene->dimension * scene->particles * sizeof *y_all);
    bool readable = y_all && dl_file_is_hdf5(path) && !dl_frames_open(path, &frames, NULL) &&
                    frames->particles == scene->particles;
    readable = readable && !dl_frames_read(frames, 0, scene->dimension, y_all, NULL) &&
               !dl_frames_read(frames, frames->count - 1, scene->dimension, y_all, NULL);
    dl_frames_close(frames);
    free(y_all);
    return readable;
}

static bool has_files(const making *m) {
    bool all = true;
    for (size_t k = 0; k < m->row->segments_done && all; k++) {
        char *path = dl_paper_trajectory(m->options->folder, m->row, k);
        all = path && is_readable(path, m->scene);
        free(path);
    }
    return all;
}

static bool is_finished(const dl_paper_run_row *row) {
    return row->status != DL_OK || row->segments_done == row->segments;
}

/* --- set-up ----------------------------------------------------------------------------------- */

/* The scene file as it stands in the folder of runs, so that what it starts from is found there. */
static dl_status copy_scene(const making *m, char **copy, dl_error *error) {
    const char *path = m->cased->path;
    FILE *in = fopen(path, "rb");
    char text[65536];
    if (!in)
        return dl_fail(error, DL_INPUT, "%s: %s", path, strerror(errno));
    const size_t size = fread(text, 1, sizeof text, in);
    const bool whole = feof(in) && !ferror(in);
    fclose(in);
    if (!whole)
        return dl_fail(error, DL_INPUT, "%s: found no readable file of at most 64 KiB", path);
    *copy = dl_text("%s/%s.yaml", m->options->folder, m->cased->name);
    return *copy ? dl_replace_file(*copy, text, size, error) : dl_fail_memory(error, "a scene");
}

static dl_status read_scene(making *m, dl_error *error) {
    char *copy = NULL;
    dl_status status = m->cased->chained ? copy_scene(m, &copy, error) : DL_OK;
    if (!status)
        status = dl_scene_read(copy ? copy : m->cased->path, &m->scene, error);
    free(copy);
    return status;
}

static dl_status prepare_method(making *m, dl_error *error) {
    dl_status status = dl_method_find(m->cased->method, &m->method, error);
    if (!status)
        status = dl_method_options_create(m->method, m->scene, &m->method_options, error);
    for (size_t i = 0; i < m->cased->settings && !status; i++)
        status = dl_method_options_set(m->method, m->method_options, m->cased->key[i],
                                       m->cased->value[i], error);
    if (!status)
        dl_method_options_format(m->method, m->method_options, m->row->options,
                                 sizeof m->row->options);
    return status;
}

/* Segments must be whole multiples of what is scheduled within them. */
static dl_status prepare_segments(making *m, dl_error *error) {
    const dl_paper_case *cased = m->cased;
    dl_paper_run_row *row = m->row;
    row->end = cased->end > 0 ? cased->end : m->scene->end;
    m->sample = cased->sample > 0 ? cased->sample : m->scene->sample;
    m->segment = cased->segment > 0 ? cased->segment : row->end;
    row->segments = dl_whole_steps(row->end, m->segment);
    if (!row->segments)
        return dl_fail(error, DL_INPUT,
                       "segment: found %.10g, expected a whole part of the end %.10g", m->segment,
                       row->end);
    const double period = m->scene->radiation.present ? m->scene->radiation.period : 0;
    if (row->segments > 1 && ((m->sample > 0 && !dl_whole_steps(m->segment, m->sample)) ||
                              (period > 0 && !dl_whole_steps(m->segment, period))))
        return dl_fail(error, DL_INPUT,
                       "segment: found %.10g, expected a multiple of the sample interval and of "
                       "the radiation's period",
                       m->segment);
    return DL_OK;
}

/* Of a set that is not made yet. */
dl_status dl_paper_check(const dl_paper_case *cased, const char **key, dl_error *error) {
    dl_paper_run_row row = {.name = cased->name};
    making m = {.cased = cased, .row = &row};
    *key = "scene";
    if (cased->chained)
        return access(cased->path, R_OK) == 0
                   ? DL_OK
                   : dl_fail(error, DL_INPUT, "%s: %s", cased->path, strerror(errno));
    dl_status status = dl_scene_read(cased->path, &m.scene, error);
    if (!status) {
        *key = "set";
        status = prepare_method(&m, error);
    }
    if (!status) {
        *key = "segment";
        status = prepare_segments(&m, error);
    }
    if (m.method)
        dl_method_options_free(m.method, m.method_options);
    dl_scene_free(m.scene);
    return status;
}

static dl_status make_key(making *m, dl_error *error) {
    m->key = dl_text("driftlab %s, scene %s#%016llx, %s %s, end %.17g sample %.17g segment %.17g",
                     dl_version(), m->scene->name, (unsigned long long)dl_scene_hash(m->scene),
                     m->method->name, m->row->options, m->row->end, m->sample, m->segment);
    return m->key ? DL_OK : dl_fail_memory(error, "a run");
}

/* --- one segment ------------------------------------------------------------------------------ */

static dl_status write_frame(void *context, const dl_sample *sample, dl_error *error) {
    making *m = context;
    if (!m->trajectory) {
        const dl_status status = dl_trajectory_create(m->path, m->scene, m->method->name,
                                                      m->row->options, &m->trajectory, error);
        if (status)
            return status;
    }
    return dl_trajectory_append(m->trajectory, sample, error);
}

static void tell(void *context, double fraction, double seconds) {
    making *m = context;
    (void)seconds;
    if (!m->options->on_progress)
        return;
    m->progress->fraction = ((double)m->number + fraction) / (double)m->row->segments;
    m->progress->seconds = now() - m->began;
    m->options->on_progress(m->options->context, m->progress);
}

/* The scene as the segment before left it. */
static dl_status go_on(making *m, dl_error *error) {
    char *path = dl_paper_trajectory(m->options->folder, m->row, m->number - 1);
    double *y_all = NULL, time;
    dl_scene *restarted = NULL;
    dl_status status = path ? dl_trajectory_read_last(path, m->scene, &y_all, &time, error)
                            : dl_fail_memory(error, "a run");
    if (!status)
        status = dl_scene_restart(m->scene, y_all, &restarted, error);
    free(y_all);
    free(path);
    if (status)
        return status;
    dl_scene_free(m->scene);
    m->scene = restarted;
    return DL_OK;
}

static void add_summary(making *m, const dl_run_summary *summary) {
    dl_paper_run_row *row = m->row;
    row->status = summary->status;
    snprintf(row->message, sizeof row->message, "%s", summary->message);
    row->reached = (double)m->number * m->segment + summary->t_end_reached;
    row->step = summary->step;
    row->steps += summary->steps;
    row->nonlinear_iterations += summary->nonlinear_iterations;
    row->cpu_seconds += summary->cpu_seconds;
    if (!(row->energy_error >= summary->energy_error_max))
        row->energy_error = summary->energy_error_max;
    if (m->number == 0)
        row->energy_scale = summary->energy_scale;
    row->segments_done = m->number + 1;
}

/* A run that was interrupted or cannot be kept leaves its record as it was. */
static dl_status make_segment(making *m, dl_error *error) {
    dl_run_options how;
    dl_run_summary summary;
    dl_run_options_default(&how);
    how.end = m->segment;
    how.sample = m->sample;
    how.interrupt = m->options->interrupt;
    how.on_sample = write_frame;
    how.context = m;
    how.on_progress = tell;
    how.progress_context = m;
    free(m->path);
    m->path = dl_paper_trajectory(m->options->folder, m->row, m->number);
    if (!m->path)
        return dl_fail_memory(error, "a run");
    dl_status status = dl_run(m->scene, m->method, m->method_options, &how, &summary, NULL, error);
    const bool keep = !status && summary.status != DL_INTERRUPTED && summary.status != DL_IO;
    if (m->trajectory) {
        dl_error reason = {""};
        const dl_status closed = dl_trajectory_close(m->trajectory, &reason);
        m->trajectory = NULL;
        if (closed && keep)
            return dl_fail(error, closed, "%s", reason.message);
    }
    if (status)
        return status;
    if (!keep)
        return dl_fail(error, summary.status, "%s: %s", m->cased->name, summary.message);
    add_summary(m, &summary);
    return write_record(m, error);
}

static dl_status make_segments(making *m, dl_error *error) {
    dl_status status = DL_OK;
    m->began = now();
    for (m->number = m->row->segments_done; !status && !is_finished(m->row); m->number++) {
        tell(m, 0, 0);
        if (m->number > 0)
            status = go_on(m, error);
        if (!status)
            status = make_segment(m, error);
    }
    return status;
}

/* --- the whole -------------------------------------------------------------------------------- */

static dl_status find_or_make(making *m, dl_error *error) {
    dl_paper_run_row *row = m->row;
    if (!read_record(m) || !has_files(m))
        forget(row);
    else if (is_finished(row)) {
        row->fate = DL_RUN_KEPT;
        return DL_OK;
    }
    if (!dl_paper_is_wanted(m->cased, m->options)) {
        snprintf(row->message, sizeof row->message, "%s", long_message);
        return DL_OK;
    }
    const dl_status status = make_segments(m, error);
    if (!status)
        row->fate = DL_RUN_FINISHED;
    return status;
}

static bool stops_the_set(dl_status status) {
    return status == DL_INTERRUPTED || status == DL_IO || status == DL_MEMORY;
}

dl_status dl_paper_make(const dl_paper *paper, size_t number, const dl_paper_options *options,
                        dl_paper_progress *progress, dl_paper_run_row *row, dl_error *error) {
    const dl_paper_case *cased = &paper->cased[number];
    making m = {.cased = cased, .options = options, .progress = progress, .row = row};
    dl_error reason = {""};
    *row = (dl_paper_run_row){.name = cased->name,
                              .scene = cased->scene,
                              .method = cased->method,
                              .note = cased->note,
                              .is_long = cased->is_long,
                              .fate = DL_RUN_MISSING};
    forget(row);
    progress->run = cased->name;
    dl_status status = read_scene(&m, &reason);
    if (!status)
        status = prepare_method(&m, &reason);
    if (!status)
        status = prepare_segments(&m, &reason);
    if (!status)
        status = make_key(&m, &reason);
    if (!status)
        status = find_or_make(&m, &reason);
    if (m.method)
        dl_method_options_free(m.method, m.method_options);
    dl_scene_free(m.scene);
    free(m.key);
    free(m.path);
    if (stops_the_set(status))
        return dl_fail(error, status, "%s", reason.message);
    /* What a long run starts from may itself be missing: that it is long is the reason. */
    if (status && !dl_paper_is_wanted(cased, options)) {
        snprintf(row->message, sizeof row->message, "%s", long_message);
    } else if (status) {
        row->status = status;
        snprintf(row->message, sizeof row->message, "%s", reason.message);
    }
    return DL_OK;
}
