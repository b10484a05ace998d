/* A paper's set: runs, then claims, then pictures. */
#include "driftlab/paper.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "io/lock.h"
#include "report/paper_figure.h"
#include "study/paper_quantity.h"
#include "study/plan.h"

static dl_paper_report *report_create(const dl_paper *paper) {
    dl_paper_report *report = calloc(1, sizeof *report);
    if (!report)
        return NULL;
    report->name = paper->name;
    report->title = paper->title;
    report->source = paper->source;
    report->lost = paper->lost;
    report->lost_text = (const char *const *)paper->lost_text;
    report->row = calloc(paper->claims + 1, sizeof *report->row);
    report->figure = calloc(paper->pictures + 1, sizeof *report->figure);
    report->run = calloc(paper->cases + 1, sizeof *report->run);
    if (report->row && report->figure && report->run)
        return report;
    dl_paper_report_free(report);
    return NULL;
}

void dl_paper_report_free(dl_paper_report *report) {
    if (!report)
        return;
    for (size_t i = 0; report->row && i < report->rows; i++)
        free(report->row[i].reason);
    for (size_t i = 0; report->figure && i < report->figures; i++) {
        free(report->figure[i].svg);
        free(report->figure[i].reason);
    }
    free(report->row);
    free(report->figure);
    free(report->run);
    free(report);
}

size_t dl_paper_count(const dl_paper_report *report, dl_verdict verdict) {
    size_t count = 0;
    for (size_t i = 0; i < report->rows; i++)
        count += report->row[i].verdict == verdict;
    return count;
}

static dl_status make_runs(const dl_paper *paper, const dl_paper_options *options,
                           dl_paper_report *report, dl_error *error) {
    dl_paper_progress progress = {.count = 0};
    dl_status status = DL_OK;
    for (size_t i = 0; i < paper->cases; i++)
        progress.count += dl_paper_is_wanted(&paper->cased[i], options);
    for (size_t i = 0; i < paper->cases && !status; i++) {
        progress.number += dl_paper_is_wanted(&paper->cased[i], options);
        status = dl_paper_make(paper, i, options, &progress, &report->run[i], error);
        report->runs = i + 1;
    }
    if (status != DL_INTERRUPTED)
        return status;
    const dl_error reason = error ? *error : (dl_error){"interrupted"};
    return dl_fail(
        error, DL_INTERRUPTED,
        "%.600s; what is finished is kept in %s, and the same command goes on from there",
        reason.message, options->folder);
}

static dl_status judge_claim(const dl_paper_claim *claim, const dl_paper_report *report,
                             const char *folder, dl_paper_row *row, dl_error *error) {
    dl_error reason = {""};
    *row = (dl_paper_row){.part = claim->part,
                          .what = claim->what,
                          .where = claim->where,
                          .published = claim->published,
                          .unit = claim->unit,
                          .note = claim->note,
                          .value = NAN};
    dl_paper_source_text(&claim->source, row->from, sizeof row->from);
    const dl_status status = dl_quantity_measure(claim, report->run, folder, &row->value, &reason);
    if (status == DL_IO || status == DL_MEMORY)
        return dl_fail(error, status, "%s", reason.message);
    if (status)
        row->value = NAN;
    dl_paper_judge(claim, row);
    if (row->verdict == DL_NOT_COMPUTABLE && !*reason.message)
        dl_fail(&reason, DL_OK, "the number computed is not finite");
    row->reason = dl_text("%s", reason.message);
    return row->reason ? DL_OK : dl_fail_memory(error, "a claim");
}

static bool is_interrupted(const dl_paper_options *options) {
    return options->interrupt && *options->interrupt;
}

static dl_status judge_claims(const dl_paper *paper, const dl_paper_options *options,
                              dl_paper_report *report, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < paper->claims && !status; i++) {
        report->rows = i + 1;
        status = judge_claim(&paper->claim[i], report, options->folder, &report->row[i], error);
        if (!status && is_interrupted(options))
            status = dl_fail(error, DL_INTERRUPTED,
                             "interrupted; the runs are kept in %s, and the same command goes on "
                             "from there",
                             options->folder);
    }
    return status;
}

static dl_status draw_pictures(const dl_paper *paper, const dl_paper_options *options,
                               dl_paper_report *report, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < paper->pictures && !status; i++) {
        report->figures = i + 1;
        status = dl_paper_figure_draw(&paper->picture[i], report->run, options->folder,
                                      &report->figure[i], error);
    }
    return status;
}

static dl_status make_folder(const char *folder, dl_error *error) {
    return mkdir(folder, 0777) == 0 || errno == EEXIST
               ? DL_OK
               : dl_fail(error, DL_IO, "%s: cannot be made: %s", folder, strerror(errno));
}

static dl_status make_report(const dl_paper *paper, const dl_paper_options *options,
                             dl_paper_report *report, dl_error *error) {
    dl_status status = make_folder(options->folder, error);
    if (!status)
        status = make_runs(paper, options, report, error);
    if (!status)
        status = judge_claims(paper, options, report, error);
    return status ? status : draw_pictures(paper, options, report, error);
}

dl_status dl_paper_run(const dl_paper *paper, const dl_paper_options *options,
                       dl_paper_report **report, dl_error *error) {
    dl_lock lock;
    *report = NULL;
    dl_paper_report *made = report_create(paper);
    if (!made)
        return dl_fail_memory(error, "a paper's report");
    dl_status status = dl_lock_take(&lock, options->folder, error);
    if (!status)
        status = make_report(paper, options, made, error);
    dl_lock_release(&lock);
    if (status)
        dl_paper_report_free(made);
    else
        *report = made;
    return status;
}
