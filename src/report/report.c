#include "driftlab/report.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "page_data.h"
#include "report/html_text.h"
#include "report/page.h"
#include "report/player_data.h"
#include "version.h"

/* --- what goes on one page ----------------------------------------------------------------- */

static bool has_scene(const dl_results *results, const char *name) {
    for (size_t i = 0; i < results->scenes; i++)
        if (strcmp(results->scene[i].name, name) == 0)
            return true;
    return false;
}

static dl_status check_pair(const dl_results *before, const dl_results *after, dl_error *error) {
    if (strcmp(before->kind, after->kind) != 0)
        return dl_fail(error, DL_INPUT,
                       "found studies of two kinds, %s (%s) and %s (%s), expected one kind a page",
                       before->study, before->kind, after->study, after->kind);
    for (size_t i = 0; i < after->scenes; i++)
        if (has_scene(before, after->scene[i].name))
            return dl_fail(error, DL_INPUT,
                           "found the scene %s in two studies, %s and %s, expected each scene once "
                           "(driftlab compare sets two results of one scene side by side)",
                           after->scene[i].name, before->study, after->study);
    return DL_OK;
}

static dl_status check_together(const dl_report *report, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t b = 1; b < report->studies; b++)
        for (size_t a = 0; a < b && status == DL_OK; a++)
            status = check_pair(report->results[a], report->results[b], error);
    return status;
}

static void name_scenes(const dl_report *report, FILE *out) {
    fprintf(out, "%s", report->results[0]->kind);
    const char *separator = ": ";
    for (size_t k = 0; k < report->studies; k++)
        for (size_t i = 0; i < report->results[k]->scenes; i++) {
            fprintf(out, "%s%s", separator, report->results[k]->scene[i].name);
            separator = ", ";
        }
}

/* Owned by the caller; NULL: no memory. */
static char *title_of(const dl_report *report) {
    const dl_results *only = report->results[0];
    char *title = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&title, &size);
    if (!out)
        return NULL;
    if (report->title)
        fputs(report->title, out);
    else if (report->studies > 1)
        name_scenes(report, out);
    else if (only->title && only->title[0])
        fputs(only->title, out);
    else
        fputs(only->study && only->study[0] ? only->study : "driftlab report", out);
    fclose(out);
    return title;
}

/* --- the page ------------------------------------------------------------------------------ */

/* Another kind of file at `path`, a scene say, was named by mistake. */
static dl_status refuse_other_file(const char *path, dl_error *error) {
    static const char page[] = "<!DOCTYPE html>";
    char begin[sizeof page - 1];
    FILE *file = fopen(path, "rb");
    if (!file)
        return DL_OK;
    size_t length = fread(begin, 1, sizeof begin, file);
    fclose(file);
    if (length == 0 || (length == sizeof begin && memcmp(begin, page, sizeof begin) == 0))
        return DL_OK;
    return dl_fail(error, DL_INPUT,
                   "%s: found a file that is no page, expected a new name or a page", path);
}

static dl_status fill_page(const char *title, const char *json, dl_span players, const char *path,
                           dl_error *error) {
    const dl_slot slots[] = {
        {"title", {title, strlen(title)}}, {"version", {DL_VERSION, strlen(DL_VERSION)}},
        {"data", {json, strlen(json)}},    {"trajectories", players},
        {"style", DL_ASSET(page_css)},     {"chartjs", DL_ASSET(chartjs)},
        {"dom", DL_ASSET(dom_js)},         {"format", DL_ASSET(format_js)},
        {"charts", DL_ASSET(charts_js)},   {"player", DL_ASSET(player_js)},
        {"export", DL_ASSET(export_js)},   {"findings", DL_ASSET(findings_js)},
        {"across", DL_ASSET(across_js)},   {"page", DL_ASSET(page_js)},
    };
    return dl_page_write(path, DL_ASSET(page_html), slots, sizeof slots / sizeof *slots, error);
}

static dl_status write_page(const dl_report *report, dl_span players, const char *path,
                            dl_error *error) {
    char *json = NULL, *title = title_of(report), *safe = title ? dl_html_text(title) : NULL;
    dl_status status = safe ? DL_OK : dl_fail_memory(error, "the report's title");
    if (status == DL_OK)
        status = dl_page_data(report->results, report->studies, title, &json, error);
    if (status == DL_OK)
        status = fill_page(safe, json, players, path, error);
    free(safe);
    free(title);
    free(json);
    return status;
}

dl_status dl_report_write_page(const dl_report *report, const char *path, dl_error *error) {
    char *players = NULL;
    dl_status status = check_together(report, error);
    if (!status)
        status = refuse_other_file(path, error);
    if (!status)
        status = dl_player_blocks(report->trajectory, report->trajectories, &players, error);
    if (!status)
        status = write_page(report, (dl_span){players, strlen(players)}, path, error);
    free(players);
    return status;
}

dl_status dl_report_write(const dl_results *results, const char *path, dl_error *error) {
    const dl_report report = {.results = &results, .studies = 1};
    return dl_report_write_page(&report, path, error);
}
