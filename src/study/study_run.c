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
#include "study/facts.h"
#include "study/measure.h"

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

/* Moves a case out of the old results; false where it is not there. */
static bool keep_case(progress *run, const char *key, dl_case *kept) {
    if (!run->old || run->options->force)
        return false;
    for (size_t i = 0; i < run->old->cases; i++) {
        dl_case *found = &run->old->cased[i];
        if (found->key && strcmp(found->key, key) == 0) {
            *kept = *found;
            *found = (dl_case){0};
            return true;
        }
    }
    return false;
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

static dl_status keep_cases(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = DL_OK;
    for (size_t i = 0; i < study->cases && status == DL_OK; i++) {
        dl_case kept;
        if (!keep_case(run, study->cased[i].key, &kept))
            continue;
        status = dl_results_add_case(run->results, &kept, error);
        if (status != DL_OK)
            dl_case_release(&kept);
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

static dl_status run_case(progress *run, const dl_study_case *cased, dl_error *error) {
    const dl_study *study = run->study;
    const char *scene = study->scene[cased->scene].scene->name;
    const dl_watch watch = watch_of(run);
    dl_case measured;
    start_part(run, dl_text("%s: %s %s", scene, cased->run.row->name, cased->run.text));
    dl_status status = dl_study_measure_case(
        study, cased, dl_results_reference(run->results, scene), &watch, &measured, error);
    if (status != DL_OK)
        return status;
    status = dl_results_add_case(run->results, &measured, error);
    if (status != DL_OK) {
        dl_case_release(&measured);
        return status;
    }
    run->told.done++;
    return save(run, error);
}

static bool stopped(const progress *run) {
    return run->options->interrupt && *run->options->interrupt;
}

static dl_status run_cases(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = DL_OK;
    for (size_t i = 0; i < study->cases && status == DL_OK; i++) {
        if (dl_results_find(run->results, study->cased[i].key))
            continue;
        status = stopped(run) ? DL_INTERRUPTED : run_case(run, &study->cased[i], error);
    }
    return status;
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
    return status == DL_OK ? run_cases(run, error) : status;
}

/* Cases in the order of the study, wherever they were run. */
static size_t place_of(const dl_study *study, const dl_case *cased) {
    size_t i = 0;
    while (i < study->cases && strcmp(study->cased[i].key, cased->key) != 0)
        i++;
    return i;
}

static dl_status sort_cases(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_results *results = run->results;
    dl_case *sorted = calloc(study->cases, sizeof *sorted);
    if (!sorted)
        return dl_fail_memory(error, "cases");
    for (size_t i = 0; i < results->cases; i++)
        sorted[place_of(study, &results->cased[i])] = results->cased[i];
    free(results->cased);
    results->cased = sorted;
    return DL_OK;
}

static dl_status run_missing(progress *run, dl_error *error) {
    const dl_study *study = run->study;
    dl_status status = keep_references(run, error);
    if (status == DL_OK)
        status = keep_cases(run, error);
    if (status != DL_OK)
        return status;
    run->told.kept = run->told.done = run->results->references + run->results->cases;
    run->told.total = study->cases + (study->reference ? study->scenes : 0);
    status = save(run, error); /* now, so that a place that cannot be written costs no run */
    if (status == DL_OK)
        status = run_references(run, error);
    if (status == DL_OK)
        status = run_cases(run, error);
    if (status == DL_OK)
        status = improve_references(run, error);
    if (status == DL_OK)
        status = sort_cases(run, error);
    if (status == DL_OK)
        status = save(run, error);
    if (status == DL_INTERRUPTED)
        status = dl_fail(error, status,
                         "interrupted: %zu of %zu cases are kept in %s; the same command goes on "
                         "from there",
                         run->results->cases, study->cases, run->options->results);
    return status;
}

dl_status dl_study_run(const dl_study *study, const dl_study_options *options, dl_results **results,
                       dl_error *error) {
    progress run = {.study = study, .options = options, .began = now()};
    *results = NULL;
    dl_lock lock;
    dl_status status = dl_lock_take(&lock, options->results, error);
    if (status == DL_OK)
        status = begin(&run, error);
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
