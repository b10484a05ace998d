/* Runs what is missing of a study; the results file is complete after every case. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>
#include "driftlab/explain.h"
#include "io/lock.h"
#include "study/child.h"
#include "study/facts.h"
#include "study/lanes.h"
#include "study/parts.h"
#include "study/process.h"
#include "study/ranks.h"

typedef struct progress {
    const dl_study *study;
    const dl_study_options *options;
    dl_results *old;     /* what an earlier run has left, or NULL */
    dl_results *results; /* what the file is to hold */
    dl_study_progress told;
    double began;
    char *current;
} progress;

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void tell(void *context) {
    progress *run = context;
    if (!run->options->on_progress)
        return;
    const size_t done = run->told.done - run->told.kept, left = run->told.total - run->told.done;
    run->told.seconds = now() - run->began;
    run->told.remaining = done ? run->told.seconds / (double)done * (double)left : NAN;
    run->told.current = run->current ? run->current : "";
    run->options->on_progress(run->options->context, &run->told);
}

static void start_part(progress *run, char *label) {
    free(run->current);
    run->current = label; /* NULL, for want of memory, is told as "" */
    tell(run);
}

/* --- what is there ------------------------------------------------------------------------- */

static dl_status check_owner(const progress *run, dl_error *error) {
    const char *path = run->options->results, *name = run->study->settings.name;
    if (strcmp(run->old->study, name) != 0)
        return dl_fail(error, DL_INPUT,
                       "%s: found the results of study \"%s\", expected those of \"%s\" or another "
                       "name for the results file",
                       path, run->old->study, name);
    for (const char *const *fact = dl_facts_of_timing; *fact && !run->options->force; fact++) {
        const char *before = dl_results_fact(run->old, *fact);
        const char *here = dl_results_fact(run->results, *fact);
        if (before && here && strcmp(before, here) != 0)
            return dl_fail(error, DL_INPUT,
                           "%s: found times of another build or machine (%s: \"%.200s\"), expected "
                           "\"%.200s\"; run with --force to measure every case again",
                           path, *fact, before, here);
    }
    return DL_OK;
}

static dl_status read_old(progress *run, dl_error *error) {
    if (access(run->options->results, F_OK) != 0)
        return DL_OK;
    dl_status status = dl_results_read(run->options->results, &run->old, error);
    return status == DL_OK ? check_owner(run, error) : status;
}

/* Whether a reference of before is what its key says, bit by bit. */
static bool is_intact(const dl_reference *found, const char *key) {
    char *digest = found->key && strcmp(found->key, key) == 0 ? dl_reference_digest(found) : NULL;
    const bool intact = digest && found->digest && strcmp(found->digest, digest) == 0;
    free(digest);
    return intact;
}

/* With --force too, where nothing of it depends on the methods of this build. */
static bool keep_reference(progress *run, const char *key, dl_reference *kept) {
    if (!run->old || (run->options->force && run->study->reference == DL_REFERENCE_RUNS))
        return false;
    for (size_t i = 0; i < run->old->references; i++) {
        dl_reference *found = &run->old->reference[i];
        if (is_intact(found, key)) {
            *kept = *found;
            *found = (dl_reference){0};
            return true;
        }
    }
    return false;
}

/* --- what the file says besides ------------------------------------------------------------ */

static dl_status set_text(char **text, const char *value, dl_error *error) {
    char *copy = dl_text("%s", value);
    if (!copy)
        return dl_fail_memory(error, "results");
    free(*text);
    *text = copy;
    return DL_OK;
}

static dl_status set_head(const dl_study *study, dl_results *results, dl_error *error) {
    const dl_study_settings *settings = &study->settings;
    const char *title = *settings->title ? settings->title : settings->name;
    results->asked_error = settings->asked_error;
    dl_status status = set_text(&results->study, settings->name, error);
    if (status == DL_OK)
        status = set_text(&results->title, title, error);
    if (status == DL_OK)
        status = set_text(&results->kind, dl_study_kinds[settings->kind], error);
    if (status == DL_OK)
        status = set_text(&results->question, settings->question, error);
    return status == DL_OK
               ? set_text(&results->asked_in, dl_study_measures[settings->asked_in], error)
               : status;
}

static dl_status explain(const dl_scene *scene, char **text, dl_error *error) {
    dl_model *model = NULL;
    size_t size = 0;
    dl_status status = dl_model_create(scene, &model, error);
    if (status != DL_OK)
        return status;
    FILE *out = open_memstream(text, &size);
    if (out) {
        dl_explain(model, out);
        if (fclose(out)) {
            free(*text);
            *text = NULL;
        }
    }
    dl_model_free(model);
    return *text ? DL_OK : dl_fail_memory(error, "a description");
}

static dl_status add_scene(dl_results *results, const dl_scene *scene, dl_error *error) {
    dl_scene_record record = {.name = dl_text("%s", scene->name),
                              .source = dl_text("%s", scene->source ? scene->source : ""),
                              .text = dl_text("%s", scene->text)};
    dl_status status = record.name && record.source && record.text
                           ? explain(scene, &record.explain, error)
                           : dl_fail_memory(error, "a scene");
    if (status == DL_OK)
        status = dl_results_add_scene(results, &record, error);
    if (status != DL_OK) {
        free(record.name);
        free(record.source);
        free(record.text);
        free(record.explain);
    }
    return status;
}

static dl_status begin(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = dl_results_create(&run->results, error);
    if (status == DL_OK)
        status = set_head(study, run->results, error);
    if (status == DL_OK)
        status = dl_facts_add(run->results, run->options->command, error);
    for (size_t s = 0; s < study->scenes && status == DL_OK; s++)
        status = add_scene(run->results, study->scene[s].scene, error);
    return status == DL_OK ? read_old(run, error) : status;
}

/* --- what is kept -------------------------------------------------------------------------- */

static dl_status keep_references(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = DL_OK;
    for (size_t s = 0; s < study->scenes && study->reference && status == DL_OK; s++) {
        dl_reference kept;
        if (!keep_reference(run, study->scene[s].reference_key, &kept))
            continue;
        status = dl_results_add_reference(run->results, &kept, error);
        if (status != DL_OK)
            dl_reference_release(&kept);
    }
    return status;
}

/* --- what is missing ----------------------------------------------------------------------- */

static dl_status save(progress *run, dl_error *error) {
    return dl_results_write(run->results, run->options->results, error);
}

static dl_watch watch_of(progress *run) {
    return (dl_watch){.interrupt = run->options->interrupt, .tick = tell, .context = run};
}

static dl_status run_references(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    const dl_watch watch = watch_of(run);
    dl_status status = DL_OK;
    for (size_t s = 0; s < study->scenes && study->reference && status == DL_OK; s++) {
        const dl_study_scene *on = &study->scene[s];
        dl_reference found;
        if (dl_results_reference(run->results, on->scene->name))
            continue;
        start_part(run, dl_text("reference of %s", on->scene->name));
        status = dl_study_measure_reference(study, on, &watch, &found, error);
        if (status != DL_OK)
            break;
        status = dl_results_add_reference(run->results, &found, error);
        if (status != DL_OK)
            dl_reference_release(&found);
        else
            status = save(run, error);
        run->told.done++;
    }
    return status;
}

static bool stopped(const progress *run) {
    return run->options->interrupt && *run->options->interrupt;
}

static dl_status add_part(progress *run, dl_study_part *part, dl_error *error) {
    const dl_status status = dl_part_add(run->study, run->results, part, error);
    if (status != DL_OK)
        return status;
    run->told.done++;
    return save(run, error);
}

/* What a unit tells of itself stands behind its name in the progress line. */
static void hear(void *context, const char *text) {
    progress *run = context;
    char *at = run->current ? strstr(run->current, " | ") : NULL;
    if (at)
        *at = '\0';
    char *longer = run->current ? dl_text("%s | %s", run->current, text) : NULL;
    if (longer)
        start_part(run, longer);
}

static dl_status run_part(progress *run, size_t part, dl_error *error) {
    const dl_watch watch = watch_of(run);
    dl_study_part measured;
    start_part(run, dl_part_label(run->study, part));
    const dl_status status =
        dl_part_measure(run->study, run->results, part, &watch, hear, run, &measured, error);
    return status == DL_OK ? add_part(run, &measured, error) : status;
}

static dl_status run_in_order(progress *run, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < run->study->cases && status == DL_OK; i++)
        if (!dl_part_is_done(run->study, run->results, i))
            status = stopped(run) ? DL_INTERRUPTED : run_part(run, i, error);
    return status;
}

/* --- side by side -------------------------------------------------------------------------- */

static void work_in_lane(void *context, size_t part, int pipe) {
    const progress *run = context;
    const dl_watch nobody = {.interrupt = NULL};
    dl_part_measure_and_send(run->study, run->results, part, &nobody, pipe);
}

static void lane_begins(void *context, size_t part) {
    progress *run = context;
    start_part(run, dl_part_label(run->study, part));
}

static dl_status lane_answers(void *context, size_t part, const void *data, size_t size,
                              dl_error *error) {
    (void)part;
    progress *run = context;
    dl_study_part measured;
    const dl_status status = dl_part_receive(run->study, data, size, &measured, error);
    return status == DL_OK ? add_part(run, &measured, error) : status;
}

/* Tells of a rank that is lost, and of the part it was doing (-1: none). */
static void rank_is_lost(void *context, size_t rank, long part) {
    const progress *run = context;
    const dl_study_options *options = run->options;
    char *label = part < 0 ? NULL : dl_part_label(run->study, (size_t)part);
    char *note = dl_text(label ? "rank %zu on %s is lost; \"%s\" is handed to another"
                               : "rank %zu on %s is lost",
                         rank, options->ranks->rank[rank].host, label);
    if (note && options->on_note)
        options->on_note(options->context, note);
    free(note);
    free(label);
}

/* Hands out what is not done, in lanes that are forked or to ranks. What a lost rank has left goes
 * to the others once; a part that costs two is not for a third. */
static dl_status run_lanes(progress *run, bool *done, dl_error *error) {
    dl_ranks *ranks = run->options->ranks;
    const size_t parts = run->study->cases;
    const dl_lanes_work work = {.work = work_in_lane,
                                .begun = lane_begins,
                                .receive = lane_answers,
                                .tick = tell,
                                .lost = ranks ? rank_is_lost : NULL,
                                .context = run,
                                .socket = ranks ? ranks->socket : NULL,
                                .interrupt = run->options->interrupt};
    if (!ranks)
        return dl_lanes_run(&work, run->options->processes, parts, done, error);
    dl_status status = dl_ranks_send_references(ranks, run->results, error);
    for (int round = 0; round < 2 && status == DL_OK; round++)
        status = dl_lanes_run(&work, ranks->count, parts, done, error);
    return status;
}

static dl_status run_side_by_side(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    size_t left = 0;
    bool *done = calloc(study->cases, sizeof *done);
    if (!done)
        return dl_fail_memory(error, "a study");
    for (size_t i = 0; i < study->cases; i++) {
        done[i] = dl_part_is_done(study, run->results, i);
        left += !done[i];
    }
    const dl_status status = left > 0 ? run_lanes(run, done, error) : DL_OK;
    free(done);
    return status == DL_OK ? run_in_order(run, error) : status; /* what lost ones have left */
}

static dl_status run_parts(progress *run, dl_error *error) {
    return run->options->processes > 1 || run->options->ranks ? run_side_by_side(run, error)
                                                              : run_in_order(run, error);
}

/* --- a better reference ---------------------------------------------------------------------- */

/* Whether only the reference's own error stands in the way of a point. */
static bool needs_better(const dl_case *cased, const char *scene, double own_error) {
    return strcmp(cased->scene, scene) == 0 && cased->summary.status == DL_OK && !*cased->invalid &&
           cased->position_error < DL_REFERENCE_MARGIN * own_error;
}

static bool can_improve(const progress *run, const dl_reference *reference) {
    if (run->study->reference != DL_REFERENCE_EXTENDED ||
        run->study->precision != DL_PRECISION_AUTO || *reference->note || reference->horizon > 0 ||
        strcmp(reference->precision, "quad") == 0)
        return false;
    for (size_t i = 0; i < run->results->cases; i++)
        if (needs_better(&run->results->cased[i], reference->scene, reference->error))
            return true;
    return false;
}

/* Those that the old reference could not resolve are to be measured again. */
static void drop_cases(progress *run, const char *scene, double old_error) {
    dl_results *results = run->results;
    size_t kept = 0;
    for (size_t i = 0; i < results->cases; i++) {
        if (needs_better(&results->cased[i], scene, old_error))
            dl_case_release(&results->cased[i]);
        else
            results->cased[kept++] = results->cased[i];
    }
    run->told.done -= results->cases - kept;
    results->cases = kept;
}

static dl_status improve(progress *run, const dl_study_scene *on, dl_reference *reference,
                         dl_error *error) {
    const dl_watch watch = watch_of(run);
    const double old_error = reference->error;
    bool improved;
    start_part(run, dl_text("reference of %s in quad precision", reference->scene));
    const dl_status status =
        dl_study_improve_reference(run->study, on, &watch, reference, &improved, error);
    if (status != DL_OK)
        return status;
    if (improved)
        drop_cases(run, on->scene->name, old_error);
    return save(run, error);
}

/* Quad precision where long double does not resolve every case; then those cases once more. */
static dl_status improve_references(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = DL_OK;
    for (size_t i = 0; i < run->results->references && status == DL_OK; i++) {
        dl_reference *reference = &run->results->reference[i];
        if (!can_improve(run, reference))
            continue;
        for (size_t s = 0; s < study->scenes && status == DL_OK; s++)
            if (strcmp(study->scene[s].scene->name, reference->scene) == 0)
                status = improve(run, &study->scene[s], reference, error);
    }
    return status == DL_OK ? run_parts(run, error) : status;
}

static dl_status run_missing(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = keep_references(run, error);
    if (status == DL_OK && run->old && !run->options->force)
        status = dl_parts_keep(study, run->old, run->results, error);
    if (status != DL_OK)
        return status;
    run->told.kept = run->told.done =
        run->results->references + run->results->cases + run->results->findings;
    run->told.total = study->cases + (study->reference ? study->scenes : 0);
    status = save(run, error); /* now, so that a place that cannot be written costs no run */
    if (status == DL_OK)
        status = run_references(run, error);
    if (status == DL_OK)
        status = run_parts(run, error);
    if (status == DL_OK)
        status = improve_references(run, error);
    if (status == DL_OK)
        status = dl_parts_sort(study, run->results, error);
    if (status == DL_OK)
        status = save(run, error);
    if (status == DL_INTERRUPTED)
        status = dl_fail(error, status,
                         "interrupted: %zu of %zu cases are kept in %s; the same command goes on "
                         "from there",
                         run->results->cases + run->results->findings, study->cases,
                         run->options->results);
    return status;
}

static dl_status check_processes(const dl_study_options *options, dl_error *error) {
    const size_t most = dl_process_processors();
    if (options->ranks && options->processes > 1)
        return dl_fail(error, DL_INPUT,
                       "processes: found %zu, expected 1 under mpiexec: its -n says how many",
                       options->processes);
    return options->processes <= most
               ? DL_OK
               : dl_fail(error, DL_INPUT,
                         "processes: found %zu, expected at most %zu, one a processor: more would "
                         "spoil each other's times",
                         options->processes, most);
}

static dl_status check_ranks(progress *run, dl_error *error) {
    const dl_ranks_check check = {.study = run->study,
                                  .results = run->results,
                                  .lost = rank_is_lost,
                                  .context = run,
                                  .interrupt = run->options->interrupt};
    return dl_ranks_agree(run->options->ranks, &check, error);
}

dl_status dl_study_run(const dl_study *study, const dl_study_options *options, dl_results **results,
                       dl_error *error) {
    progress run = {.study = study, .options = options, .began = now()};
    *results = NULL;
    if (check_processes(options, error) != DL_OK)
        return DL_INPUT;
    dl_lock lock;
    dl_status status = dl_lock_take(&lock, options->results, error);
    if (status == DL_OK)
        status = begin(&run, error);
    if (status == DL_OK && options->ranks)
        status = check_ranks(&run, error);
    if (status == DL_OK) {
        status = run_missing(&run, error);
        start_part(&run, NULL);
        *results = run.results;
        run.results = NULL;
    }
    dl_lock_release(&lock);
    dl_results_free(run.results);
    free(run.current);
    /* what was moved out of the old results is empty there */
    dl_results_free(run.old);
    return status;
}
