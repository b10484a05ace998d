/* The page of one paper or of several: published numbers beside computed ones, pictures beside the
 * figures they answer, what cannot be recovered, and the runs it all comes from. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/paper.h"
#include "driftlab/parameter.h"
#include "report/html_text.h"
#include "report/page.h"
#include "version.h"

/* --- words and numbers ------------------------------------------------------------------------ */

static void put(FILE *out, const char *text) {
    char *const html = dl_html_text(text);
    fputs(html ? html : "", out);
    free(html);
}

static void put_element(FILE *out, const char *tag, const char *style, const char *text) {
    fprintf(out, "<%s%s%s%s>", tag, *style ? " class=\"" : "", style, *style ? "\"" : "");
    put(out, text);
    fprintf(out, "</%s>", tag);
}

/* Minus signs as readers expect them. */
static void put_number(FILE *out, const char *text) {
    for (; *text; text++)
        fputs(*text == '-' ? "−" : (char[]){*text, '\0'}, out);
}

static void put_real(FILE *out, const char *format, double value) {
    char text[64];
    if (isfinite(value))
        snprintf(text, sizeof text, format, value);
    else
        snprintf(text, sizeof text, "%s", "");
    put_number(out, text);
}

/* With a digit more than the rule needs. */
static void put_computed(FILE *out, const dl_paper_row *row) {
    const double resolved = row->tolerance > 0 ? fabs(row->value) / row->tolerance : 0;
    const int digits = resolved > 1 ? (int)ceil(log10(resolved)) + 2 : 3;
    char text[64] = "";
    if (isfinite(row->value))
        snprintf(text, sizeof text, "%.*g", digits < 4 ? 4 : digits > 12 ? 12 : digits, row->value);
    put_number(out, text);
}

static bool is_number(const char *text) {
    char *end;
    strtod(text, &end);
    return end != text && !*end;
}

static const char *verdict_class(dl_verdict verdict) {
    static const char *const names[] = {
        [DL_AGREES] = "agrees",    [DL_DIFFERS] = "differs",
        [DL_AS_SAID] = "as-said",  [DL_NOT_AS_SAID] = "not-as-said",
        [DL_INPUT_DATA] = "input", [DL_NOT_COMPUTABLE] = "not-computable"};
    return names[verdict];
}

/* --- claims ----------------------------------------------------------------------------------- */

/* A note that is that of the row before as well is not said again. */
static void put_claim(FILE *out, const dl_paper_row *row, const char *said) {
    fputs("<tr><td class=\"what\">", out);
    put(out, row->what);
    if (*row->note && strcmp(row->note, said) != 0)
        put_element(out, "div", "note", row->note);
    fputs("</td>", out);
    put_element(out, "td", "", row->where);
    const bool number = is_number(row->published);
    fprintf(out, "<td class=\"%s\">", number ? "number" : "words");
    (number ? put_number : put)(out, row->published);
    if (*row->unit) {
        fputc(' ', out);
        put(out, row->unit);
    }
    fputs("</td><td class=\"number\">", out);
    put_computed(out, row);
    fputs("</td><td class=\"number\">", out);
    put_real(out, "%+.3g", row->difference);
    fprintf(out, "</td><td><span class=\"verdict %s\">%s</span></td><td class=\"judged\">",
            verdict_class(row->verdict), dl_verdict_name(row->verdict));
    put(out, row->from);
    if (*row->from)
        fputs("<br>", out);
    put(out, row->rule);
    if (*row->reason)
        put_element(out, "div", "note", row->reason);
    fputs("</td></tr>\n", out);
}

static void put_claims(FILE *out, const dl_paper_report *report, const char *part) {
    bool begun = false;
    const char *said = "";
    for (size_t i = 0; i < report->rows; i++) {
        if (strcmp(report->row[i].part, part) != 0)
            continue;
        if (!begun)
            fputs("<div class=\"scroll\"><table class=\"claims\"><thead><tr><th>What</th>"
                  "<th>Where</th><th class=\"number\">Published</th>"
                  "<th class=\"number\">Computed</th><th class=\"number\">Difference</th>"
                  "<th>Verdict</th><th>Computed from, judged by</th></tr></thead><tbody>\n",
                  out);
        begun = true;
        put_claim(out, &report->row[i], said);
        said = report->row[i].note;
    }
    if (begun)
        fputs("</tbody></table></div>\n", out);
}

/* --- pictures --------------------------------------------------------------------------------- */

/* Names of clipping paths are made the page's own. */
static void put_svg(FILE *out, const char *svg, size_t number) {
    static const char *const mark[] = {"id=\"clip", "url(#clip"};
    while (*svg) {
        size_t found = 2;
        for (size_t k = 0; k < 2; k++)
            if (strncmp(svg, mark[k], strlen(mark[k])) == 0)
                found = k;
        if (found < 2) {
            const size_t length = strlen(mark[found]) - strlen("clip");
            fprintf(out, "%.*sp%zu-clip", (int)length, svg, number);
            svg += strlen(mark[found]);
        } else {
            fputc(*svg++, out);
        }
    }
}

static void put_figure(FILE *out, const dl_paper_figure *figure, size_t number) {
    fputs("<figure>", out);
    if (figure->svg)
        put_svg(out, figure->svg, number);
    else
        put_element(out, "p", "empty", figure->reason);
    fputs("<figcaption>", out);
    put_element(out, "b", "", figure->figure);
    if (*figure->caption) {
        fputs(" · ", out);
        put(out, figure->caption);
    }
    fputs("<br>", out);
    put_element(out, "span", "quiet", figure->from);
    fputs("</figcaption></figure>\n", out);
}

static void put_figures(FILE *out, const dl_paper_report *report, const char *part,
                        size_t *number) {
    bool begun = false;
    for (size_t i = 0; i < report->figures; i++) {
        if (strcmp(report->figure[i].part, part) != 0)
            continue;
        if (!begun)
            fputs("<div class=\"pictures\">\n", out);
        begun = true;
        put_figure(out, &report->figure[i], (*number)++);
    }
    if (begun)
        fputs("</div>\n", out);
}

/* --- parts ------------------------------------------------------------------------------------ */

/* Parts in the order in which claims, then pictures, name them; false after the last. */
static bool part_at(const dl_paper_report *report, size_t index, const char **part) {
    const size_t all = report->rows + report->figures;
    size_t seen = 0;
    for (size_t i = 0; i < all; i++) {
        const char *name =
            i < report->rows ? report->row[i].part : report->figure[i - report->rows].part;
        bool is_new = true;
        for (size_t j = 0; j < i && is_new; j++)
            is_new = strcmp(name, j < report->rows ? report->row[j].part
                                                   : report->figure[j - report->rows].part) != 0;
        if (is_new && seen++ == index) {
            *part = name;
            return true;
        }
    }
    return false;
}

/* Rows of the part with that verdict. */
static size_t count_part(const dl_paper_report *report, const char *part, dl_verdict verdict) {
    size_t count = 0;
    for (size_t i = 0; i < report->rows; i++)
        count += strcmp(report->row[i].part, part) == 0 && report->row[i].verdict == verdict;
    return count;
}

/* Numbers, then words, each only where there are some. */
static void put_counts(FILE *out, const dl_paper_report *report, const char *part) {
    const size_t agree = count_part(report, part, DL_AGREES);
    const size_t differ = count_part(report, part, DL_DIFFERS);
    const size_t said = count_part(report, part, DL_AS_SAID);
    const size_t not_said = count_part(report, part, DL_NOT_AS_SAID);
    fputs(" <span class=\"quiet\">", out);
    if (agree + differ)
        fprintf(out, "%zu of %zu agree", agree, agree + differ);
    if (said + not_said)
        fprintf(out, "%s%zu of %zu as said", agree + differ ? ", " : "", said, said + not_said);
    fputs("</span>", out);
}

static void put_contents(FILE *out, const dl_paper_report *report) {
    const char *part;
    fputs("<ol class=\"contents\">\n", out);
    for (size_t k = 0; part_at(report, k, &part); k++) {
        fprintf(out, "<li><a href=\"#%s-%zu\">", report->name, k);
        put(out, part);
        fputs("</a>", out);
        put_counts(out, report, part);
        fputs("</li>\n", out);
    }
    fputs("</ol>\n", out);
}

static void put_parts(FILE *out, const dl_paper_report *report, size_t *number) {
    const char *part;
    for (size_t k = 0; part_at(report, k, &part); k++) {
        fprintf(out, "<section id=\"%s-%zu\">", report->name, k);
        put_element(out, "h2", "", part);
        fputc('\n', out);
        put_claims(out, report, part);
        put_figures(out, report, part, number);
        fputs("</section>\n", out);
    }
}

/* --- what stands after the parts -------------------------------------------------------------- */

static void put_lost(FILE *out, const dl_paper_report *report) {
    if (!report->lost)
        return;
    fputs("<section class=\"lost\"><h2>What cannot be recovered from the paper</h2>\n<ul>\n", out);
    for (size_t i = 0; i < report->lost; i++) {
        put_element(out, "li", "", report->lost_text[i]);
        fputc('\n', out);
    }
    fputs("</ul></section>\n", out);
}

static const char *fate_of(const dl_paper_run_row *run) {
    if (run->status != DL_OK)
        return dl_status_name(run->status);
    return run->fate == DL_RUN_MISSING ? "not made" : "ok";
}

static void put_run(FILE *out, const dl_paper_run_row *run) {
    fputs("<tr>", out);
    put_element(out, "td", "", run->name);
    put_element(out, "td", "", run->scene);
    fputs("<td>", out);
    put(out, run->method);
    fputc(' ', out);
    put(out, run->options);
    fputs("</td><td class=\"number\">", out);
    put_real(out, "%.6g", run->end);
    fputs("</td>", out);
    put_element(out, "td", "", fate_of(run));
    const bool made = run->fate != DL_RUN_MISSING;
    fputs("<td class=\"number\">", out);
    if (made)
        fprintf(out, "%lu", run->steps);
    fputs("</td><td class=\"number\">", out);
    put_real(out, "%.3g", made ? run->energy_error / run->energy_scale : NAN);
    fputs("</td><td class=\"number\">", out);
    put_real(out, "%.3g", made ? run->cpu_seconds : NAN);
    fputs("</td><td>", out);
    put(out, run->note);
    if (*run->message)
        put_element(out, "div", "quiet", run->message);
    fputs("</td></tr>\n", out);
}

static bool has_segments(const dl_paper_report *report) {
    for (size_t i = 0; i < report->runs; i++)
        if (report->run[i].fate != DL_RUN_MISSING && report->run[i].segments > 1)
            return true;
    return false;
}

static void put_runs(FILE *out, const dl_paper_report *report) {
    if (!report->runs)
        return;
    fputs(
        "<section><h2>Runs</h2>\n<p class=\"quiet\">The energy error is the largest at any frame, "
        "in units of the scene's energy scale; what walls and radiation took is booked. CPU "
        "seconds are those of the integration alone.</p>\n",
        out);
    if (has_segments(report))
        fputs("<p class=\"quiet\">A run of several segments starts each from the last frame of the "
              "one before: leap-frog then goes on but for roundoff, not bit by bit, and energy "
              "errors "
              "are those within a segment.</p>\n",
              out);
    fputs("<div class=\"scroll\">"
          "<table class=\"runs\"><thead><tr><th>Run</th><th>Scene</th><th>Method</th>"
          "<th class=\"number\">End</th><th>Status</th><th class=\"number\">Steps</th>"
          "<th class=\"number\">Energy error</th><th class=\"number\">CPU s</th><th>Note</th></tr>"
          "</thead><tbody>\n",
          out);
    for (size_t i = 0; i < report->runs; i++)
        put_run(out, &report->run[i]);
    fputs("</tbody></table></div></section>\n", out);
}

static void put_paper(FILE *out, const dl_paper_report *report, size_t *number) {
    static const char *const several[] = {[DL_AGREES] = "agree",
                                          [DL_DIFFERS] = "differ",
                                          [DL_AS_SAID] = "as said in words",
                                          [DL_NOT_AS_SAID] = "not as said",
                                          [DL_INPUT_DATA] = "put in",
                                          [DL_NOT_COMPUTABLE] = "not computable"};
    fprintf(out, "<article class=\"paper\" id=\"%s\">\n", report->name);
    put_element(out, "h1", "", report->title);
    put_element(out, "p", "quiet", report->source);
    fputs("\n<ul class=\"verdicts\">", out);
    for (int v = DL_AGREES; v <= DL_NOT_COMPUTABLE; v++)
        fprintf(out, "<li class=\"%s\"><b>%zu</b>%s</li>", verdict_class((dl_verdict)v),
                dl_paper_count(report, (dl_verdict)v), several[v]);
    fputs("</ul>\n", out);
    put_contents(out, report);
    put_parts(out, report, number);
    put_lost(out, report);
    put_runs(out, report);
    fputs("</article>\n", out);
}

/* --- the whole -------------------------------------------------------------------------------- */

static char *body_of(const dl_paper_report *const *report, size_t count, size_t *length) {
    char *text = NULL;
    size_t number = 0;
    FILE *out = open_memstream(&text, length);
    if (!out)
        return NULL;
    for (size_t i = 0; i < count; i++)
        put_paper(out, report[i], &number);
    const bool failed = ferror(out) != 0;
    if (fclose(out) || failed) {
        free(text);
        return NULL;
    }
    return text;
}

dl_status dl_paper_write(const dl_paper_report *const *report, size_t count, const char *path,
                         dl_error *error) {
    size_t length = 0;
    char *body = body_of(report, count, &length);
    char *title = dl_html_text(count == 1 ? report[0]->title : "The papers, number by number");
    const dl_slot slots[] = {
        {"title", {title, title ? strlen(title) : 0}},
        {"version", {DL_VERSION, strlen(DL_VERSION)}},
        {"style", DL_ASSET(page_css)},
        {"paper_style", DL_ASSET(paper_css)},
        {"body", {body, length}},
    };
    const dl_status status = body && title ? dl_page_write(path, DL_ASSET(paper_html), slots,
                                                           sizeof slots / sizeof *slots, error)
                                           : dl_fail_memory(error, "a page");
    free(body);
    free(title);
    return status;
}
