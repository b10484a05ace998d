/* driftlab paper: what a paper printed, beside what is computed. */
#include <ctype.h>
#include <glob.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "cli/command.h"
#include "cli/json.h"
#include "cli/outcome.h"
#include "cli/studies.h"
#include "cli/terminal.h"
#include "driftlab/paper.h"

typedef struct paper_values {
    char *out, *studies;
    bool long_runs, json;
} paper_values;

static const dl_parameter options[] = {
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(paper_values, out),
     .unit = "PAGE.html",
     .doc = "the page to write (default: NAME.html); runs are kept in PAGE.html.runs"},
    {.name = "long",
     .kind = DL_FLAG,
     .offset = offsetof(paper_values, long_runs),
     .fallback = "false",
     .doc = "make the long runs too; stopped, the same command goes on where they were"},
    {.name = "studies",
     .kind = DL_TEXT,
     .offset = offsetof(paper_values, studies),
     .unit = "DIR",
     .doc = "folder with papers/NAME.yaml (default: ./studies, or else the installed ones)"},
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(paper_values, json),
     .fallback = "false",
     .doc = "print one JSON object instead of tables"},
};

enum { most_papers = 16, path_size = 4096 };

typedef struct work {
    const paper_values *values;
    char out[path_size], folder[path_size + 8];
    size_t count;
    dl_paper *paper[most_papers];
    dl_paper_report *report[most_papers];
} work;

/* --- which papers ----------------------------------------------------------------------------- */

static dl_status add_paper(work *w, const char *path, dl_error *error) {
    if (w->count == most_papers)
        return dl_fail(error, DL_INPUT, "found more than %d papers, expected fewer", most_papers);
    const dl_status status = dl_paper_read(path, &w->paper[w->count], error);
    w->count += !status;
    return status;
}

/* Whether PATH/name.yaml is the paper that is asked for, in whatever case. */
static bool is_named(const char *path, const char *name) {
    const char *slash = strrchr(path, '/'), *at = slash ? slash + 1 : path;
    while (*name && tolower((unsigned char)*name) == tolower((unsigned char)*at))
        name++, at++;
    return !*name && strcmp(at, ".yaml") == 0;
}

static dl_status unknown_paper(const glob_t *found, const char *name, const char *studies,
                               dl_error *error) {
    char names[512] = "";
    size_t length = 0;
    for (size_t i = 0; i < found->gl_pathc && length < sizeof names; i++) {
        const char *at = strrchr(found->gl_pathv[i], '/') + 1;
        length += (size_t)snprintf(names + length, sizeof names - length, "%.*s, ",
                                   (int)strcspn(at, "."), at);
    }
    return dl_fail(error, DL_INPUT,
                   "found \"%s\", expected one of %sall, or a paper's FILE.yaml (papers of %s)",
                   name, names, studies);
}

static dl_status read_known(work *w, const char *name, dl_error *error) {
    char studies[path_size], pattern[path_size + 16];
    glob_t found = {0};
    dl_status status = cli_find_studies(w->values->studies, studies, sizeof studies, error);
    if (status)
        return status;
    snprintf(pattern, sizeof pattern, "%s/papers/*.yaml", studies);
    if (glob(pattern, 0, NULL, &found) == GLOB_NOSPACE)
        status = dl_fail_memory(error, "a list of papers");
    const bool all = strcmp(name, "all") == 0;
    for (size_t i = 0; i < found.gl_pathc && !status; i++)
        if (all || is_named(found.gl_pathv[i], name))
            status = add_paper(w, found.gl_pathv[i], error);
    if (!status && !w->count)
        status = unknown_paper(&found, name, studies, error);
    globfree(&found);
    return status;
}

static dl_status read_papers(work *w, const char *name, dl_error *error) {
    const char *dot = strrchr(name, '.');
    return dot && strcmp(dot, ".yaml") == 0 ? add_paper(w, name, error)
                                            : read_known(w, name, error);
}

static bool is_page(const char *path) {
    const char *dot = strrchr(path, '.'), *slash = strrchr(path, '/');
    return dot && strcmp(dot, ".html") == 0 && dot != path && dot != (slash ? slash + 1 : path);
}

static dl_status choose_out(work *w, const char *name, dl_error *error) {
    const char *out = w->values->out;
    const bool all = strcmp(name, "all") == 0;
    if (out && !is_page(out))
        return dl_fail(error, DL_INPUT,
                       "--out: found \"%s\", expected a page's name, one that ends in .html", out);
    const size_t length = (size_t)(out ? snprintf(w->out, sizeof w->out, "%s", out)
                                       : snprintf(w->out, sizeof w->out, "%s.html",
                                                  all ? "papers" : dl_paper_name(w->paper[0])));
    snprintf(w->folder, sizeof w->folder, "%s.runs", w->out);
    return length && length < sizeof w->out
               ? DL_OK
               : dl_fail(error, DL_INPUT, "--out: expected the name of a file");
}

/* --- what is printed -------------------------------------------------------------------------- */

static bool has_words(const dl_paper_row *row) {
    return row->verdict == DL_AS_SAID || row->verdict == DL_NOT_AS_SAID;
}

/* Words and what they are judged by are too long for a column of numbers. */
static void print_row(const dl_paper_row *row) {
    char value[32] = "", difference[32] = "";
    const bool words = has_words(row) || row->verdict == DL_NOT_COMPUTABLE;
    if (isfinite(row->value))
        snprintf(value, sizeof value, "%.6g", row->value);
    if (isfinite(row->difference))
        snprintf(difference, sizeof difference, "%+.3g", row->difference);
    printf("  %-52.52s %12s %12s %11s  %s", row->what, words ? "" : row->published, value,
           difference, dl_verdict_name(row->verdict));
    if (words)
        printf(": %s", row->published);
    if (has_words(row))
        printf(" (%s)", row->rule);
    printf("%s%s\n", *row->reason ? ": " : "", row->reason);
}

static void print_report(const dl_paper_report *report) {
    printf("%s: %s\n", report->name, report->title);
    printf("  %-52s %12s %12s %11s  %s\n", "", "published", "computed", "difference", "verdict");
    for (size_t i = 0; i < report->rows; i++)
        print_row(&report->row[i]);
    for (size_t i = 0; i < report->figures; i++)
        if (!report->figure[i].svg)
            printf("  no picture for %s: %s\n", report->figure[i].figure, report->figure[i].reason);
    printf("  %zu agree, %zu differ, %zu as said, %zu not as said, %zu put in, "
           "%zu not computable\n\n",
           dl_paper_count(report, DL_AGREES), dl_paper_count(report, DL_DIFFERS),
           dl_paper_count(report, DL_AS_SAID), dl_paper_count(report, DL_NOT_AS_SAID),
           dl_paper_count(report, DL_INPUT_DATA), dl_paper_count(report, DL_NOT_COMPUTABLE));
}

static json_t *row_json(const dl_paper_row *row) {
    json_t *object =
        json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:s}", "part", row->part, "what",
                  row->what, "where", row->where, "published", row->published, "unit", row->unit,
                  "from", row->from, "rule", row->rule, "verdict", dl_verdict_name(row->verdict),
                  "reason", row->reason, "note", row->note);
    json_object_set_new(object, "computed", cli_json_real(row->value));
    json_object_set_new(object, "difference", cli_json_real(row->difference));
    return object;
}

static json_t *run_json(const dl_paper_run_row *run) {
    static const char *const fates[] = {
        [DL_RUN_MISSING] = "missing", [DL_RUN_FINISHED] = "finished", [DL_RUN_KEPT] = "kept"};
    json_t *object =
        json_pack("{s:s, s:s, s:s, s:s, s:s, s:s, s:s, s:b, s:I}", "name", run->name, "scene",
                  run->scene, "method", run->method, "options", run->options, "fate",
                  fates[run->fate], "status", dl_status_name(run->status), "message", run->message,
                  "long", run->is_long, "steps", (json_int_t)run->steps);
    json_object_set_new(object, "energy_error", cli_json_real(run->energy_error));
    json_object_set_new(object, "energy_scale", cli_json_real(run->energy_scale));
    json_object_set_new(object, "cpu_seconds", cli_json_real(run->cpu_seconds));
    return object;
}

static json_t *report_json(const dl_paper_report *report) {
    json_t *object = json_pack("{s:s, s:s}", "name", report->name, "title", report->title);
    json_t *claims = json_array(), *runs = json_array(), *pictures = json_array();
    for (size_t i = 0; i < report->rows; i++)
        json_array_append_new(claims, row_json(&report->row[i]));
    for (size_t i = 0; i < report->figures; i++)
        json_array_append_new(
            pictures, json_pack("{s:s, s:s, s:b, s:s}", "figure", report->figure[i].figure, "from",
                                report->figure[i].from, "drawn", report->figure[i].svg != NULL,
                                "reason", report->figure[i].reason));
    for (size_t i = 0; i < report->runs; i++)
        json_array_append_new(runs, run_json(&report->run[i]));
    json_object_set_new(object, "claims", claims);
    json_object_set_new(object, "pictures", pictures);
    json_object_set_new(object, "runs", runs);
    return object;
}

static dl_status print_json(const work *w, dl_error *error) {
    json_t *root = json_object(), *papers = json_array();
    for (size_t i = 0; i < w->count; i++)
        json_array_append_new(papers, report_json(w->report[i]));
    json_object_set_new(root, "page", json_string(w->out));
    json_object_set_new(root, "papers", papers);
    return cli_json_print(root, stdout, error);
}

/* --- the command ------------------------------------------------------------------------------ */

static void show_progress(void *context, const dl_paper_progress *progress) {
    char left[32] = "", line[160];
    (void)context;
    if (progress->fraction > 0.01) {
        const double seconds = progress->seconds * (1 - progress->fraction) / progress->fraction;
        cli_format_seconds(seconds, left, sizeof left);
    }
    snprintf(line, sizeof line, "run %zu of %zu, %s: %3.0f %%%s%s", progress->number,
             progress->count, progress->run, 100 * progress->fraction, *left ? ", left " : "",
             left);
    cli_show_progress(line);
}

static dl_status run_papers(work *w, dl_error *error) {
    const bool progress = cli_shows_progress();
    const dl_paper_options how = {.folder = w->folder,
                                  .long_runs = w->values->long_runs,
                                  .interrupt = cli_catch_signals(),
                                  .on_progress = progress ? show_progress : NULL};
    dl_status status = DL_OK;
    for (size_t i = 0; i < w->count && !status; i++)
        status = dl_paper_run(w->paper[i], &how, &w->report[i], error);
    if (progress)
        cli_show_progress(NULL);
    return status;
}

static dl_status show(const work *w, dl_error *error) {
    const dl_status status =
        dl_paper_write((const dl_paper_report *const *)w->report, w->count, w->out, error);
    if (status)
        return status;
    if (w->values->json)
        return print_json(w, error);
    for (size_t i = 0; i < w->count; i++)
        print_report(w->report[i]);
    printf("page: %s\n", w->out);
    return DL_OK;
}

static cli_exit paper(const cli_input *input) {
    work w = {.values = input->values};
    dl_error error = {""};
    dl_status status = read_papers(&w, input->word[0], &error);
    if (!status)
        status = choose_out(&w, input->word[0], &error);
    if (!status)
        status = run_papers(&w, &error);
    if (!status)
        status = show(&w, &error);
    for (size_t i = 0; i < w.count; i++) {
        dl_paper_report_free(w.report[i]);
        dl_paper_free(w.paper[i]);
    }
    return cli_finish(status, &error);
}

const cli_command cli_command_paper = {
    .name = "paper",
    .arguments = "PAPER | all",
    .summary = "a paper's published numbers and pictures beside computed ones",
    .details = "PAPER is TR171, TR299 or TR323, or the FILE.yaml of one of your own (driftlab help "
               "paper).\nRuns are kept; started again, the command makes what is missing.\n",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .values_size = sizeof(paper_values),
    .run = paper,
};
