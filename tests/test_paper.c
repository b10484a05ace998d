/* Papers: verdicts follow the stated rule, runs are kept and gone on with, the page has it all. */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <glob.h>
#include <jansson.h>
#include <math.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "io/lock.h"
#include "study/paper_quantity.h"

static char folder[] = "/tmp/driftlab-paper-XXXXXX";
static char paper_path[64], runs[64], page[64];

static void write_text(const char *name, const char *text) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    fputs(text, out);
    assert_int_equal(fclose(out), 0);
}

static char *read_text(const char *path) {
    FILE *in = fopen(path, "rb");
    assert_non_null(in);
    fseek(in, 0, SEEK_END);
    const size_t size = (size_t)ftell(in);
    rewind(in);
    char *text = calloc(size + 1, 1);
    assert_non_null(text);
    assert_int_equal(fread(text, 1, size, in), size);
    fclose(in);
    return text;
}

/* A particle bound to a pinned one by TR299's molecular force, and a third one far away. */
static void write_scene(const char *speed) {
    char text[1024];
    snprintf(text, sizeof text,
             "name: pair\nsource: test\ndimension: 2\nparticles:\n"
             "  - {at: [0, 1], velocity: [0, %s], mass: 1}\n"
             "  - {at: [0, 0], mass: 1, pinned: true}\n"
             "pair_law:\n"
             "  - {until: 2.3, terms: [{coefficient: -5, power: 4}, {coefficient: 5, power: 6}]}\n"
             "time: {step: 1.0e-3, end: 8, sample: 0.01}\n",
             speed);
    write_text("pair.yaml", text);
    /* Two particles at one place are no scene. */
    write_text("twice.yaml", "name: twice\nsource: test\ndimension: 2\nparticles:\n"
                             "  - {at: [0, 1], mass: 1}\n  - {at: [0, 1], mass: 1}\n"
                             "time: {step: 1.0e-3, end: 8, sample: 0.01}\n");
}

static int make_folder(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(paper_path, sizeof paper_path, "%s/paper.yaml", folder);
    snprintf(runs, sizeof runs, "%s/page.html.runs", folder);
    snprintf(page, sizeof page, "%s/page.html", folder);
    return 0;
}

static int clean(void **state) {
    static const char *const patterns[] = {"/page.html.runs/*", "/*.*"};
    (void)state;
    for (size_t k = 0; k < 2; k++) {
        char pattern[128];
        glob_t found = {0};
        snprintf(pattern, sizeof pattern, "%s%s", folder, patterns[k]);
        glob(pattern, 0, NULL, &found);
        for (size_t i = 0; i < found.gl_pathc; i++)
            remove(found.gl_pathv[i]);
        globfree(&found);
    }
    write_scene("0.5");
    return 0;
}

static int remove_folder(void **state) {
    clean(state);
    char path[128];
    snprintf(path, sizeof path, "%s/pair.yaml", folder);
    remove(path);
    snprintf(path, sizeof path, "%s/twice.yaml", folder);
    remove(path);
    rmdir(runs);
    return rmdir(folder);
}

static dl_paper *read_paper(const char *text) {
    dl_paper *paper = NULL;
    dl_error error = {""};
    write_text("paper.yaml", text);
    if (dl_paper_read(paper_path, &paper, &error))
        fail_msg("%s", error.message);
    return paper;
}

static dl_paper_report *run_paper(const dl_paper *paper, bool long_runs) {
    const dl_paper_options how = {.folder = runs, .long_runs = long_runs};
    dl_paper_report *report = NULL;
    dl_error error = {""};
    if (dl_paper_run(paper, &how, &report, &error))
        fail_msg("%s", error.message);
    return report;
}

#define HEAD "name: test\ntitle: a test\nsource: nobody\n"
#define CLAIM(what, published, rest)                                                               \
    "  - {part: one, what: " what ", where: here, published: " published ", " rest "}\n"

/* --- judging ---------------------------------------------------------------------------------- */

static void verdicts_follow_the_rule(void **state) {
    (void)state;
    static const struct {
        const char *published;
        int rule;
        double digit, within, about, value, tolerance;
        dl_verdict verdict;
    } cases[] = {
        {"20.467", DL_RULE_EQUAL, 0, INFINITY, 0, 20.46712, 0.0005, DL_AGREES},
        {"20.467", DL_RULE_EQUAL, 0, INFINITY, 0, 20.4676, 0.0005, DL_DIFFERS},
        {"20.467", DL_RULE_EQUAL, 0, INFINITY, 0, 20.4675, 0.0005, DL_AGREES},
        {".50", DL_RULE_EQUAL, 0, INFINITY, 0, 0.5024, 0.005, DL_AGREES},
        {".50", DL_RULE_EQUAL, 0, INFINITY, 0, 0.506, 0.005, DL_DIFFERS},
        {"-.05244", DL_RULE_EQUAL, 0, INFINITY, 0, -0.052424, 5e-6, DL_DIFFERS},
        {"40", DL_RULE_EQUAL, 0, INFINITY, 0, 40, 0.5, DL_AGREES},
        {"197", DL_RULE_EQUAL, 0, INFINITY, 0, 195, 0.5, DL_DIFFERS},
        {"170", DL_RULE_EQUAL, 10, INFINITY, 0, 174, 5, DL_AGREES},
        {"170", DL_RULE_EQUAL, 10, INFINITY, 0, 181, 5, DL_DIFFERS},
        {"1.5e-3", DL_RULE_EQUAL, 0, INFINITY, 0, 1.54e-3, 5e-5, DL_AGREES},
        {"0", DL_RULE_EQUAL, 0, 1e-9, 0, -1e-10, 1e-9, DL_AGREES},
        {"0", DL_RULE_EQUAL, 0, 1e-9, 0, 1e-8, 1e-9, DL_DIFFERS},
        {"15000", DL_RULE_EQUAL, 0, INFINITY, 0.1, 16400, 1500, DL_AGREES},
        {"15000", DL_RULE_EQUAL, 0, INFINITY, 0.1, 12500, 1500, DL_DIFFERS},
        {"99", DL_RULE_AT_MOST, 0, INFINITY, 0, 100, 0.5, DL_DIFFERS},
        {"99", DL_RULE_AT_MOST, 0, INFINITY, 0, 3, 0.5, DL_AGREES},
        {"98", DL_RULE_AT_LEAST, 0, INFINITY, 0, 162, 0.5, DL_AGREES},
        {"98", DL_RULE_AT_LEAST, 0, INFINITY, 0, 97, 0.5, DL_DIFFERS},
        {"98", DL_RULE_EQUAL, 0, INFINITY, 0, NAN, 0.5, DL_NOT_COMPUTABLE},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char published[32], computed[] = "mass", reason[] = "", criterion[] = "";
        snprintf(published, sizeof published, "%s", cases[i].published);
        dl_paper_claim claim = {.published = published,
                                .computed = computed,
                                .reason = reason,
                                .criterion = criterion,
                                .rule = cases[i].rule,
                                .digit = cases[i].digit,
                                .within = cases[i].within,
                                .about = cases[i].about};
        dl_paper_row row = {.value = cases[i].value};
        assert_int_equal(dl_paper_claim_prepare(&claim, NULL), DL_OK);
        dl_paper_judge(&claim, &row);
        if (row.verdict != cases[i].verdict ||
            fabs(claim.tolerance - cases[i].tolerance) > 1e-12 * (1 + cases[i].tolerance))
            fail_msg("case %zu: %s, tolerance %g", i, dl_verdict_name(row.verdict),
                     claim.tolerance);
    }
}

/* Words have verdicts of their own, by the criterion, and no difference from a number. */
static void words_are_judged_by_their_criterion(void **state) {
    (void)state;
    static const struct {
        const char *criterion;
        int rule;
        double within, value;
        dl_verdict verdict;
        const char *text;
    } cases[] = {
        {"120", DL_RULE_AT_LEAST, INFINITY, 167, DL_AS_SAID, "criterion: at least 120"},
        {"120", DL_RULE_AT_LEAST, INFINITY, 104, DL_NOT_AS_SAID, "criterion: at least 120"},
        {"19", DL_RULE_AT_MOST, INFINITY, 29, DL_NOT_AS_SAID, "criterion: at most 19"},
        {"13", DL_RULE_EQUAL, 3, 10, DL_AS_SAID, "criterion: 13 within 3"},
        {"13", DL_RULE_EQUAL, 3, 21, DL_NOT_AS_SAID, "criterion: 13 within 3"},
        {"1.14", DL_RULE_EQUAL, INFINITY, 1.1447, DL_AS_SAID, "criterion: 1.14 within 0.005"},
        {"0", DL_RULE_EQUAL, INFINITY, NAN, DL_NOT_COMPUTABLE, "criterion: 0 within 0.5"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        char published[] = "most", computed[] = "mass", reason[] = "", criterion[16];
        snprintf(criterion, sizeof criterion, "%s", cases[i].criterion);
        dl_paper_claim claim = {.published = published,
                                .computed = computed,
                                .reason = reason,
                                .criterion = criterion,
                                .rule = cases[i].rule,
                                .within = cases[i].within};
        dl_paper_row row = {.value = cases[i].value};
        assert_int_equal(dl_paper_claim_prepare(&claim, NULL), DL_OK);
        dl_paper_judge(&claim, &row);
        if (row.verdict != cases[i].verdict || strcmp(row.rule, cases[i].text) != 0)
            fail_msg("case %zu: %s, \"%s\"", i, dl_verdict_name(row.verdict), row.rule);
        assert_true(isnan(row.difference));
    }
}

/* --- the whole -------------------------------------------------------------------------------- */

static const char small[] = HEAD
    "runs:\n"
    "  - {name: swing, scene: pair.yaml, end: 0.5}\n"
    "  - {name: far, scene: pair.yaml, long: true}\n"
    "claims:\n" CLAIM("two particles", "2", "computed: particles, scene: pair.yaml") CLAIM(
        "three particles", "3",
        "computed: particles, scene: pair.yaml") CLAIM("rest <distance>", "1.00",
                                                       "computed: rest-distance, scene: pair.yaml")
        CLAIM("from the far run", "1", "computed: y, run: far, step: 5000") CLAIM(
            "steps", "500",
            "computed: steps, run: swing") CLAIM("no such mass", "1",
                                                 "particle: 9, computed: particle-mass, "
                                                 "scene: pair.yaml")
            CLAIM("refused", "1", "computed: refused, scene: twice.yaml") CLAIM(
                "not a frame", "1",
                "computed: y, run: swing, step: 7") "  - part: two\n    what: [start, a step]\n    "
                                                    "where: there\n"
                                                    "    published: [1, 1.005]\n    computed: y\n"
                                                    "    run: swing\n    step: [0, 10]\n"
                                                    "pictures:\n"
                                                    "  - {part: one, figure: Figure 7, caption: in "
                                                    "words, run: "
                                                    "swing, step: [0, 100]}\n"
                                                    "  - {part: three, figure: Figure 8, scene: "
                                                    "pair.yaml, "
                                                    "velocities: true}\n"
                                                    "  - {part: three, figure: Figure 9, run: "
                                                    "far}\n"
                                                    "not_recoverable: [the colour of the ink]\n";

static void claims_get_their_verdicts(void **state) {
    (void)state;
    static const dl_verdict expected[] = {
        DL_AGREES,         DL_DIFFERS, DL_AGREES,         DL_NOT_COMPUTABLE, DL_AGREES,
        DL_NOT_COMPUTABLE, DL_AGREES,  DL_NOT_COMPUTABLE, DL_AGREES,         DL_AGREES};
    dl_paper *paper = read_paper(small);
    dl_paper_report *report = run_paper(paper, false);
    assert_int_equal(report->rows, 10);
    for (size_t i = 0; i < report->rows; i++)
        if (report->row[i].verdict != expected[i])
            fail_msg("%s: %s, computed %g (%s)", report->row[i].what,
                     dl_verdict_name(report->row[i].verdict), report->row[i].value,
                     report->row[i].reason);
    assert_non_null(strstr(report->row[3].reason, "--long"));
    assert_non_null(strstr(report->row[5].reason, "expected at most 2"));
    assert_non_null(strstr(report->row[6].reason, "twice.yaml"));
    assert_true(isnan(report->row[3].difference));
    assert_true(report->row[1].difference == -1);
    assert_int_equal(report->run[0].fate, DL_RUN_FINISHED);
    assert_int_equal(report->run[1].fate, DL_RUN_MISSING);
    assert_int_equal(dl_paper_count(report, DL_NOT_COMPUTABLE), 3);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

static size_t occurrences(const char *text, const char *what) {
    size_t found = 0;
    for (const char *at = text; (at = strstr(at, what)); at += strlen(what))
        found++;
    return found;
}

static void the_page_holds_all_of_it(void **state) {
    (void)state;
    static const char *const parts[] = {"two particles",
                                        "three particles",
                                        "rest &lt;distance&gt;",
                                        "from the far run",
                                        "no such mass",
                                        "not a frame",
                                        "a step",
                                        "Figure 7",
                                        "in words",
                                        "Figure 8",
                                        "Figure 9",
                                        "the colour of the ink",
                                        "swing, step 100",
                                        "half a unit of the last digit"};
    dl_error error = {""};
    dl_paper *paper = read_paper(small);
    dl_paper_report *report = run_paper(paper, false);
    const dl_paper_report *const both[] = {report, report};
    assert_int_equal(dl_paper_write(both, 2, page, &error), DL_OK);
    char *text = read_text(page);
    for (size_t i = 0; i < sizeof parts / sizeof *parts; i++)
        if (!strstr(text, parts[i]))
            fail_msg("the page lacks \"%s\"", parts[i]);
    assert_int_equal(occurrences(text, "<svg "), 2 * 3);
    assert_int_equal(occurrences(text, "class=\"verdict differs\""), 2 * 1);
    assert_int_equal(occurrences(text, "class=\"verdict agrees\""), 2 * 6);
    assert_int_equal(occurrences(text, "class=\"verdict not-computable\""), 2 * 3);
    /* Clipping paths of six pictures have six names; the fourth of each paper is missing. */
    for (int k = 0; k < 7; k += k == 2 ? 2 : 1) {
        char name[32];
        snprintf(name, sizeof name, "id=\"p%d-clip0\"", k);
        assert_int_equal(occurrences(text, name), 1);
        snprintf(name, sizeof name, "url(#p%d-clip0)", k);
        assert_int_equal(occurrences(text, name), 1);
    }
    assert_null(strstr(text, "nan"));
    assert_null(strstr(text, "src=\"http"));
    free(text);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* --- runs are kept ---------------------------------------------------------------------------- */

static dl_paper_run_fate fate_of(const dl_paper *paper) {
    dl_paper_report *report = run_paper(paper, false);
    const dl_paper_run_fate fate = report->run[0].fate;
    dl_paper_report_free(report);
    return fate;
}

static void finished_runs_are_kept(void **state) {
    (void)state;
    char path[128];
    dl_paper *paper = read_paper(small);
    assert_int_equal(fate_of(paper), DL_RUN_FINISHED);
    assert_int_equal(fate_of(paper), DL_RUN_KEPT);
    write_scene("0.75"); /* another scene of the same name */
    assert_int_equal(fate_of(paper), DL_RUN_FINISHED);
    assert_int_equal(fate_of(paper), DL_RUN_KEPT);
    snprintf(path, sizeof path, "%s/swing.h5", runs);
    assert_int_equal(remove(path), 0);
    assert_int_equal(fate_of(paper), DL_RUN_FINISHED);
    snprintf(path, sizeof path, "%s/swing.json", runs);
    assert_int_equal(truncate(path, 20), 0); /* a damaged record is none */
    assert_int_equal(fate_of(paper), DL_RUN_FINISHED);
    dl_paper_free(paper);
}

/* Whatever part of its file is left, down to nothing. */
static void a_damaged_run_is_made_again(void **state) {
    (void)state;
    char path[128];
    struct stat info;
    dl_paper *paper = read_paper(small);
    snprintf(path, sizeof path, "%s/swing.h5", runs);
    assert_int_equal(fate_of(paper), DL_RUN_FINISHED);
    assert_int_equal(stat(path, &info), 0);
    const off_t whole = info.st_size, left[] = {whole - 1, whole / 2, 100, 0};
    for (size_t k = 0; k < sizeof left / sizeof *left; k++) {
        assert_int_equal(truncate(path, left[k]), 0);
        dl_paper_report *report = run_paper(paper, false);
        assert_int_equal(report->run[0].fate, DL_RUN_FINISHED);
        assert_int_equal(report->row[8].verdict, DL_AGREES); /* read from its frames */
        dl_paper_report_free(report);
        assert_int_equal(fate_of(paper), DL_RUN_KEPT);
    }
    dl_paper_free(paper);
}

/* Apart from the numbers, and not as numbers. */
static void words_stand_on_the_page(const dl_paper_report *report) {
    dl_error error = {""};
    assert_int_equal(dl_paper_write(&report, 1, page, &error), DL_OK);
    char *text = read_text(page);
    assert_non_null(strstr(text, "<td class=\"words\">a few</td>"));
    assert_int_equal(occurrences(text, "class=\"verdict as-said\""), 1);
    assert_int_equal(occurrences(text, "class=\"verdict not-as-said\""), 1);
    assert_non_null(strstr(text, "<b>1</b>as said in words"));
    assert_non_null(strstr(text, "1 of 2 as said"));
    free(text);
}

/* What was put in agrees but proves nothing; what is not computed says why; a change is between two
 * steps; a table can be added up. */
static void rows_of_other_kinds(void **state) {
    (void)state;
    dl_paper *paper = read_paper(
        HEAD
        "runs:\n  - {name: swing, scene: pair.yaml, end: 0.5}\n"
        "claims:\n" CLAIM("in", "2", "input: true, computed: particles, scene: pair.yaml")
            CLAIM("in but wrong", "3", "input: true, computed: particles, scene: pair.yaml")
                CLAIM("words", "irregular", "computed: none, reason: in words alone")
                    CLAIM("then", "1", "computed: y, run: swing, step: 500")
                        CLAIM("first", "1", "computed: y, run: swing, step: 100")
                            CLAIM("change", "1", "computed: y, run: swing, step: 500, since: 100")
                                CLAIM("end", "0.5", "computed: end, run: swing")
                                    CLAIM("reached", "0.5", "computed: reached, run: swing")
                                        CLAIM("mass of the second", "1",
                                              "computed: particle-mass, particle: 2, run: swing")
                                            CLAIM("words and judged", "a few",
                                                  "computed: particles, rule: at-most, "
                                                  "criterion: 2, scene: pair.yaml")
                                                CLAIM("words and not so", "most",
                                                      "computed: particles, rule: at-least, "
                                                      "criterion: 3, scene: pair.yaml"));
    static const dl_verdict expected[] = {DL_INPUT_DATA, DL_DIFFERS, DL_NOT_COMPUTABLE};
    dl_paper_report *report = run_paper(paper, false);
    const dl_paper_row *row = report->row;
    for (size_t i = 0; i < 3; i++)
        assert_int_equal(row[i].verdict, expected[i]);
    assert_string_equal(row[2].reason, "in words alone");
    assert_string_equal(row[2].rule, "not judged");
    assert_int_equal(dl_paper_count(report, DL_INPUT_DATA), 1);
    assert_true(fabs(row[5].value - (row[3].value - row[4].value)) < 1e-15);
    assert_true(fabs(row[5].value) > 1e-3);
    for (size_t i = 6; i < 9; i++)
        assert_int_equal(row[i].verdict, DL_AGREES);
    assert_int_equal(row[9].verdict, DL_AS_SAID);
    assert_int_equal(row[10].verdict, DL_NOT_AS_SAID);
    assert_int_equal(dl_paper_count(report, DL_AS_SAID), 1);
    assert_int_equal(dl_paper_count(report, DL_NOT_AS_SAID), 1);
    words_stand_on_the_page(report);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* --- curves ----------------------------------------------------------------------------------- */

static void close_to(double value, double expected, const char *what) {
    if (!(fabs(value - expected) <= 1e-9))
        fail_msg("%s: found %.17g, expected %.17g", what, value, expected);
}

static const char curved[] =
    HEAD "runs:\n"
         "  - {name: whole, scene: pair.yaml, end: 2}\n"
         "  - {name: parts, scene: pair.yaml, end: 2, segment: 0.5}\n"
         "claims:\n"
         "  - part: one\n"
         "    what: [a, b, c, d]\n"
         "    where: here\n"
         "    published: 1\n"
         "    computed: [vy, motion.angular_velocity, vy, motion.angular_velocity]\n"
         "    run: whole\n"
         "    step: [700, 700, 2000, 0]\n"
         "pictures:\n"
         "  - part: one\n"
         "    figure: [f, g, h, i]\n"
         "    run: [whole, parts, whole, parts]\n"
         "    curve: [vy, vy, motion.angular_velocity, motion.angular_velocity]\n";

/* A curve goes through what claims compute at its frames, of one segment or of many. */
static void curves_go_through_every_frame(void **state) {
    (void)state;
    dl_paper *paper = read_paper(curved);
    dl_paper_report *report = run_paper(paper, false);
    assert_int_equal(paper->pictures, 4);
    for (size_t i = 0; i < 4; i++) {
        dl_paper_curve curve;
        dl_error error = {""};
        if (dl_paper_curve_measure(&paper->picture[i], report->run, runs, &curve, &error))
            fail_msg("curve %zu: %s", i, error.message);
        assert_true(curve.by_step);
        assert_int_equal(curve.count, 201);
        for (size_t k = 0; k < curve.count; k++)
            close_to(curve.at[k], 10 * (double)k, "step");
        close_to(curve.value[70], report->row[i / 2].value, "value at step 700");
        if (i < 2)
            close_to(curve.value[200], report->row[2].value, "value at the end");
        else
            close_to(curve.value[0], report->row[3].value, "value at the start");
        dl_paper_curve_free(&curve);
    }
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* Curves are drawn with what is published; what is lost, or failed, is said in its place. */
static void curves_and_reasons_stand_on_the_page(void **state) {
    (void)state;
    dl_error error = {""};
    dl_paper *paper = read_paper(
        HEAD "runs:\n  - {name: swing, scene: pair.yaml, end: 0.5}\n"
             "  - {name: far, scene: pair.yaml, long: true}\n"
             "pictures:\n  - {part: one, figure: Figure 1, run: swing, curve: y, axis: height, "
             "published: \"0 1, 400 1.05\"}\n"
             "  - {part: one, figure: Figure 2, run: far, curve: y}\n"
             "  - {part: one, figure: Figure 3, reason: the drawing is lost}\n"
             "  - {part: one, figure: Figure 4, run: swing, curve: y, particle: 7}\n");
    dl_paper_report *report = run_paper(paper, false);
    const dl_paper_figure *const figure = report->figure;
    assert_non_null(figure[0].svg);
    assert_int_equal(occurrences(figure[0].svg, "class=\"computed\""), 1);
    assert_int_equal(occurrences(figure[0].svg, "class=\"published\""), 2);
    assert_non_null(strstr(figure[0].svg, ">height</text>"));
    assert_non_null(strstr(figure[0].svg, "51 frames"));
    assert_non_null(strstr(figure[1].reason, "--long"));
    assert_string_equal(figure[2].reason, "the drawing is lost");
    assert_non_null(strstr(figure[3].reason, "expected at most 2"));
    for (size_t i = 1; i < 4; i++)
        assert_null(figure[i].svg);
    const dl_paper_report *const one[] = {report};
    assert_int_equal(dl_paper_write(one, 1, page, &error), DL_OK);
    char *text = read_text(page);
    assert_non_null(strstr(text, "the drawing is lost"));
    free(text);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* Three layers of two at mean heights 0.1, 1.1 and 2.6, and one particle that fills none. */
static void layers_are_counted_from_below(void **state) {
    (void)state;
    write_text("layers.yaml",
               "name: layers\nsource: test\ndimension: 2\nparticles:\n"
               "  - {at: [0, 2.5]}\n  - {at: [1, 2.7]}\n  - {at: [0, 0]}\n  - {at: [1, 0.2]}\n"
               "  - {at: [0, 1.2]}\n  - {at: [1, 1]}\n  - {at: [0, 9]}\n"
               "pair_law:\n  - {until: 3, terms: [{coefficient: 1, power: 2}]}\n"
               "time: {step: 1.0e-3, end: 1, sample: 0.1}\n");
    dl_paper *paper = read_paper(
        HEAD "claims:\n" CLAIM("a", "1.0000", "computed: layer-least, span: 2, scene: layers.yaml")
            CLAIM("b", "1.5000", "computed: layer-most, span: 2, scene: layers.yaml")
                CLAIM("c", "1", "computed: layer-most, span: 4, scene: layers.yaml") CLAIM(
                    "d", "7",
                    "computed: density.particles, bin: 0.5, total: true, scene: layers.yaml"));
    static const dl_verdict expected[] = {DL_AGREES, DL_AGREES, DL_NOT_COMPUTABLE, DL_AGREES};
    dl_paper_report *report = run_paper(paper, false);
    for (size_t i = 0; i < 4; i++)
        if (report->row[i].verdict != expected[i])
            fail_msg("%s: computed %.6g (%s)", report->row[i].what, report->row[i].value,
                     report->row[i].reason);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

static const char segmented[] =
    HEAD "runs:\n  - {name: swing, scene: pair.yaml, end: 4, segment: 0.5}\n"
         "  - {name: whole, scene: pair.yaml, end: 4}\n"
         "claims:\n" CLAIM("a", "1", "computed: y, run: swing, step: 4000")
             CLAIM("b", "1", "computed: y, run: whole, step: 4000")
                 CLAIM("c", "1", "computed: y, run: swing, time: 1.23")
                     CLAIM("d", "1", "computed: y, run: whole, step: 1230")
                         CLAIM("e", "4000", "computed: steps, run: swing");

static void die_in_the_middle(void *context, const dl_paper_progress *progress) {
    (void)context;
    if (progress->fraction > 0.55)
        raise(SIGKILL);
}

static void a_killed_run_goes_on(void **state) {
    (void)state;
    char path[128];
    struct stat before, after;
    dl_paper *paper = read_paper(segmented);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const dl_paper_options how = {.folder = runs, .on_progress = die_in_the_middle};
        dl_paper_report *report = NULL;
        dl_paper_run(paper, &how, &report, NULL);
        _exit(0);
    }
    int status;
    assert_int_equal(waitpid(child, &status, 0), child);
    assert_true(WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    snprintf(path, sizeof path, "%s/swing.h5", runs);
    assert_int_not_equal(access(path, F_OK), 0);
    snprintf(path, sizeof path, "%s/swing.part003.h5", runs);
    assert_int_equal(stat(path, &before), 0);
    dl_paper_report *report = run_paper(paper, false);
    assert_int_equal(stat(path, &after), 0);
    assert_true(before.st_ino == after.st_ino && before.st_mtime == after.st_mtime);
    assert_int_equal(report->run[0].fate, DL_RUN_FINISHED);
    assert_int_equal(report->run[0].segments_done, 8);
    /* The same run but for roundoff, whatever segment is looked at. */
    assert_true(fabs(report->row[0].value - report->row[1].value) < 1e-9);
    assert_true(fabs(report->row[2].value - report->row[3].value) < 1e-9);
    assert_true(fabs(report->row[0].value - report->row[2].value) > 1e-3);
    assert_int_equal(report->row[4].verdict, DL_AGREES);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

static volatile int interrupt;

static void stop_in_the_middle(void *context, const dl_paper_progress *progress) {
    (void)context;
    if (progress->fraction > 0.3)
        interrupt = 1;
}

static void an_interrupt_keeps_what_is_finished(void **state) {
    (void)state;
    char path[128];
    dl_error error = {""};
    dl_paper_report *report = (dl_paper_report *)path;
    dl_paper *paper = read_paper(segmented);
    interrupt = 0;
    const dl_paper_options how = {
        .folder = runs, .interrupt = &interrupt, .on_progress = stop_in_the_middle};
    assert_int_equal(dl_paper_run(paper, &how, &report, &error), DL_INTERRUPTED);
    assert_null(report);
    assert_non_null(strstr(error.message, runs));
    snprintf(path, sizeof path, "%s/swing.part002.h5", runs);
    assert_int_equal(access(path, F_OK), 0);
    report = run_paper(paper, false);
    assert_int_equal(report->run[0].fate, DL_RUN_FINISHED);
    assert_true(fabs(report->row[0].value - report->row[1].value) < 1e-9);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

static void a_run_starts_from_another(void **state) {
    (void)state;
    write_text(
        "next.yaml",
        "name: next\nsource: test\ndimension: 2\nstart: {from: swing.h5}\n"
        "pair_law:\n"
        "  - {until: 2.3, terms: [{coefficient: -5, power: 4}, {coefficient: 5, power: 6}]}\n"
        "time: {step: 1.0e-3, end: 1, sample: 0.1}\n");
    dl_paper *paper =
        read_paper(HEAD "runs:\n  - {name: swing, scene: pair.yaml, end: 1}\n"
                        "  - {name: next, scene: next.yaml, chained: true}\n"
                        "  - {name: whole, scene: pair.yaml, end: 2}\n"
                        "claims:\n" CLAIM("a", "1", "computed: y, run: next, step: 1000")
                            CLAIM("b", "1", "computed: y, run: whole, step: 2000"));
    dl_paper_report *report = run_paper(paper, false);
    if (report->run[1].fate != DL_RUN_FINISHED)
        fail_msg("%s", report->run[1].message);
    assert_true(fabs(report->row[0].value - report->row[1].value) < 1e-9);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* --- quantities ------------------------------------------------------------------------------- */

/* From a distance of 1 to D = 2.3 from a pinned particle: v^2/2 = V(D) - V(1). */
static void the_freeing_speed_is_the_exact_one(void **state) {
    (void)state;
    dl_paper *paper =
        read_paper(HEAD "claims:\n" CLAIM("v", "1", "computed: gas-speed, scene: pair.yaml"));
    dl_paper_report *report = run_paper(paper, false);
    const double far = pow(2.3, -5) - 5.0 / 3 * pow(2.3, -3), near = 1 - 5.0 / 3;
    const double exact = sqrt(2 * (far - near));
    if (!(fabs(report->row[0].value - exact) < 2e-3 * exact))
        fail_msg("computed %.6g, exact %.6g (%s)", report->row[0].value, exact,
                 report->row[0].reason);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* A rigid body of eight particles, one of another mass, that turns at 3 about a moving centre, and
 * one particle far away that flies off: 3 again, and a revolution takes 2 pi/3. */
static void rotation_is_that_of_the_body(void **state) {
    (void)state;
    char text[4096];
    int length = snprintf(text, sizeof text,
                          "name: body\nsource: test\ndimension: 2\nparticles:\n"
                          "  - {at: [90, 0], velocity: [70, 5], mass: 1}\n");
    double centre[2] = {0}, mass = 0;
    for (int k = 0; k < 8; k++) {
        const double angle = 0.25 * 3.14159265358979 * k, m = k ? 1 : 2;
        centre[0] += m * cos(angle);
        centre[1] += m * sin(angle);
        mass += m;
    }
    for (int k = 0; k < 8; k++) {
        const double angle = 0.25 * 3.14159265358979 * k;
        const double x = cos(angle) - centre[0] / mass, y = sin(angle) - centre[1] / mass;
        length += snprintf(text + length, sizeof text - (size_t)length,
                           "  - {at: [%.15g, %.15g], velocity: [%.15g, %.15g], mass: %d}\n", x + 7,
                           y - 2, 11 - 3 * y, 4 + 3 * x, k ? 1 : 2);
    }
    snprintf(text + length, sizeof text - (size_t)length,
             "pair_law:\n  - {until: 1.5, terms: [{coefficient: 1.0e-9, power: 2}]}\n"
             "time: {step: 1.0e-4, end: 0.02, sample: 1.0e-3}\n");
    write_text("body.yaml", text);
    dl_paper *paper = read_paper(
        HEAD "runs:\n  - {name: body, scene: body.yaml}\n"
             "claims:\n" CLAIM("a", "3.00000", "computed: rotation, scene: body.yaml")
                 CLAIM("b", "20944", "about: 0.02, computed: revolution, run: body, step: 0"));
    dl_paper_report *report = run_paper(paper, false);
    for (size_t i = 0; i < 2; i++)
        if (report->row[i].verdict != DL_AGREES)
            fail_msg("computed %.6g (%s)", report->row[i].value, report->row[i].reason);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* With the step that TR171 prints for its fastest stream one iteration of Newton's method is not
 * enough: a run that failed has made no steps, and its energy says nothing. */
static void a_failed_run_is_a_result(void **state) {
    (void)state;
    dl_paper *paper = read_paper(
        HEAD "runs:\n  - {name: stream, scene: " DL_STUDIES "/stream/stream-v1000-rule.yaml, "
             "method: conserving-newton-dense, set: {step: 0.1, iterations: 1}}\n"
             "claims:\n" CLAIM("a", "0", "computed: steps, run: stream")
                 CLAIM("b", "0", "computed: energy-error, run: stream")
                     CLAIM("c", "0", "computed: y, run: stream, time: 0.2")
                         CLAIM("d", "0", "computed: y, run: stream"));
    dl_paper_report *report = run_paper(paper, false);
    assert_int_equal(report->run[0].status, DL_NONLINEAR_FAILURE);
    assert_int_equal(report->row[0].verdict, DL_AGREES);
    for (size_t i = 1; i < 4; i++) {
        assert_int_equal(report->row[i].verdict, DL_NOT_COMPUTABLE);
        assert_non_null(strstr(report->row[i].reason, "nonlinear-failure"));
    }
    dl_paper_report_free(report);
    assert_int_equal(fate_of(paper), DL_RUN_KEPT);
    dl_paper_free(paper);
}

/* Forty rows of four whose distances grow, or shrink, by a factor from one to the next. */
static char *rows_of_particles(char *text, size_t size, double growth) {
    int length = snprintf(text, size, "name: rows\nsource: test\ndimension: 2\nparticles:\n");
    double height = 0.05, apart = 0.1;
    for (int row = 0; row < 40; row++) {
        for (int k = 0; k < 4; k++)
            length += snprintf(text + length, size - (size_t)length, "  - {at: [%d.5, %.12g]}\n", k,
                               height);
        height += apart;
        apart *= growth;
    }
    snprintf(text + length, size - (size_t)length,
             "pair_law:\n  - {until: 0.04, terms: [{coefficient: 1, power: 2}]}\n"
             "gravity: [0, -10]\n"
             "walls: {x: [0, 4], y: [0, none], damping: 0, rule: mirror}\n"
             "time: {step: 1.0e-3, end: 1, sample: 0.1}\n");
    return text;
}

static void densities_go_with_the_height(void **state) {
    (void)state;
    char text[16384];
    write_text("thinning.yaml", rows_of_particles(text, sizeof text, 1.05));
    write_text("thickening.yaml", rows_of_particles(text, sizeof text, 0.95));
    write_text("even.yaml", rows_of_particles(text, sizeof text, 1));
    dl_paper *paper = read_paper(
        HEAD
        "claims:\n  - {part: a, what: [a, b, c, d], where: x, published: words, rule: at-most, "
        "criterion: [-0.6, -0.6, 0.3, 0.3], computed: [density-trend, density-trend, "
        "density-middle, density-middle], scene: [thinning.yaml, thickening.yaml, even.yaml, "
        "thinning.yaml]}\n");
    static const dl_verdict expected[] = {DL_AS_SAID, DL_NOT_AS_SAID, DL_AS_SAID, DL_NOT_AS_SAID};
    dl_paper_report *report = run_paper(paper, false);
    for (size_t i = 0; i < 4; i++)
        if (report->row[i].verdict != expected[i])
            fail_msg("row %zu: computed %.6g (%s)", i, report->row[i].value, report->row[i].reason);
    assert_true(report->row[0].value < -0.7 && report->row[1].value > 0.7);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* Particles that do not touch, one to a bin of 0.2, with the momentum flux of a given pressure. */
static char *flux_by_height(char *text, size_t size, bool exponential) {
    int length = snprintf(text, size, "name: flux\nsource: test\ndimension: 2\nparticles:\n");
    for (int k = 0; k < 20; k++) {
        const double depth = 3.9 - 0.2 * k, pressure = exponential ? exp(depth) : 1 + depth;
        length +=
            snprintf(text + length, size - (size_t)length,
                     "  - {at: [1, %.12g], velocity: [0, %.15g]}\n", 4 - depth, sqrt(pressure));
    }
    snprintf(text + length, size - (size_t)length,
             "pair_law:\n  - {until: 0.04, terms: [{coefficient: 1, power: 2}]}\n"
             "gravity: [0, -10]\n"
             "walls: {x: [0, 4], y: [0, none], damping: 0, rule: mirror}\n"
             "time: {step: 1.0e-3, end: 1, sample: 0.1}\n");
    return text;
}

static void pressures_are_fitted_by_lines(void **state) {
    (void)state;
    char text[16384];
    write_text("line.yaml", flux_by_height(text, sizeof text, false));
    write_text("exponential.yaml", flux_by_height(text, sizeof text, true));
    dl_paper *paper =
        read_paper(HEAD "claims:\n"
                        "  - {part: a, what: [a, b], where: x, published: words, rule: at-most, "
                        "criterion: 1, computed: pressure-misfit, scene: [line.yaml, "
                        "exponential.yaml]}\n");
    dl_paper_report *report = run_paper(paper, false);
    if (!(report->row[0].value < 1e-6 && report->row[1].value > 1e6))
        fail_msg("computed %.6g (%s), %.6g (%s)", report->row[0].value, report->row[0].reason,
                 report->row[1].value, report->row[1].reason);
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* Seven particles that hold together and one far away: all of it, or the body with some room. */
static void a_stray_does_not_scale_the_body(void **state) {
    (void)state;
    write_text("stray.yaml", "name: stray\nsource: test\ndimension: 2\nparticles:\n"
                             "  - {lattice: {kind: hexagonal, spacing: 1, radius: 1}, mass: 1}\n"
                             "  - {at: [90, 0], mass: 1}\n"
                             "pair_law:\n  - {until: 1.5, terms: [{coefficient: 1, power: 2}]}\n"
                             "time: {step: 1.0e-4, end: 0.02, sample: 1.0e-3}\n");
    dl_paper *paper = read_paper(
        HEAD "pictures:\n  - {part: a, figure: [all, body], scene: stray.yaml, window: [all, "
             "body]}\n");
    dl_paper_report *report = run_paper(paper, false);
    for (size_t i = 0; i < 2; i++)
        if (!report->figure[i].svg)
            fail_msg("%s", report->figure[i].reason);
    assert_null(strstr(report->figure[0].svg, "outside the picture"));
    assert_non_null(strstr(report->figure[1].svg, "1 outside the picture"));
    assert_non_null(strstr(report->figure[0].svg, ">80</text>"));
    assert_null(strstr(report->figure[1].svg, ">80</text>"));
    dl_paper_report_free(report);
    dl_paper_free(paper);
}

/* --- reading ---------------------------------------------------------------------------------- */

#define RUN         "runs:\n  - {name: swing, scene: pair.yaml}\n"
#define CURVE(rest) "  - {part: one, figure: Figure 1, run: swing, " rest "}\n"

static void bad_papers_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *text, *line, *part;
    } bad[] = {
        {"name: test\nsource: nobody\n", ":1: ", "title"},
        {HEAD "claims:\n" CLAIM("a", "one", "computed: mass, scene: pair.yaml"),
         ":5: ", "expected a number"},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: masss, scene: pair.yaml"),
         ":5: ", "did you mean \"mass\""},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: energy.kinetik, scene: pair.yaml"),
         ":5: ", "did you mean \"kinetic\""},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: enrgy.kinetic, scene: pair.yaml"),
         ":5: ", "did you mean \"energy\""},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: mass, scene: pair.yaml, noet: b"),
         ":5: ", "did you mean \"note\""},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: mass"), ":5: ", "either `scene` or `run`"},
        {HEAD RUN "claims:\n" CLAIM("a", "1", "computed: y, run: swnig"),
         ":7: ", "did you mean \"swing\""},
        {HEAD RUN "claims:\n" CLAIM("a", "1", "computed: y, run: swing, step: 1, time: 1"),
         ":7: ", "either `step` or `time`"},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: steps, scene: pair.yaml"),
         ":5: ", "expected a run"},
        {HEAD "claims:\n" CLAIM("a", "1", "digit: 1, about: 1, computed: mass, scene: pair.yaml"),
         ":5: ", "more than one"},
        {HEAD "claims:\n"
              "  - part: one\n    what: [a, b]\n    where: x\n    published: [1, 2, 3]\n"
              "    computed: mass\n    scene: pair.yaml\n",
         ":8: ", "as long as the others"},
        {HEAD "claims:\n  - {part: one, what: a, where: x, computed: mass, scene: pair.yaml}\n",
         ":5: ", "published"},
        {HEAD "claims:\n" CLAIM("a", "one", "computed: none"), ":5: ", "reason: found none"},
        {HEAD "claims:\n" CLAIM("a", "1", "reason: b, computed: mass, scene: pair.yaml"),
         ":5: ", "`computed: none` alone"},
        {HEAD "claims:\n" CLAIM("a", "1", "since: 1, computed: mass, scene: pair.yaml"),
         ":5: ", "a run beside it"},
        {HEAD "claims: 3\n", ":4: ", "a list"},
        {HEAD "runs:\n  - {name: swing, scene: pair.yaml, method: leapfrogg}\n",
         ":5: ", "did you mean \"leapfrog\""},
        {HEAD "runs:\n  - {name: swing, scene: pair.yaml, set: {stpe: 1}}\n",
         ":5: ", "did you mean \"step\""},
        {HEAD "runs:\n  - {name: ../swing, scene: pair.yaml}\n", ":5: ", "small letters"},
        {HEAD RUN "  - {name: swing, scene: pair.yaml}\n", ":6: ", "another name"},
        {HEAD "pictures:\n  - {part: a, figure: b, scene: pair.yaml, colour: mas}\n",
         ":5: ", "mass"},
        {HEAD RUN "pictures:\n" CURVE("curve: yy"), ":7: ", "did you mean \"y\""},
        {HEAD RUN "pictures:\n" CURVE("curve: steps"), ":7: ", "a quantity of a state"},
        {HEAD RUN "pictures:\n" CURVE("curve: states.solid"), ":7: ", "a single row"},
        {HEAD RUN "pictures:\n" CURVE("curve: y, step: 1"), ":7: ", "a whole run"},
        {HEAD RUN "pictures:\n" CURVE("curve: y, colour: mass"), ":7: ", "a whole run"},
        {HEAD RUN "pictures:\n" CURVE("curve: y, published: 1 2 3"), ":7: ", "STEP VALUE"},
        {HEAD RUN "pictures:\n" CURVE("curve: y, published: 1"), ":7: ", "STEP VALUE"},
        {HEAD RUN "pictures:\n" CURVE("published: 1 2"), ":7: ", "`curve` beside it"},
        {HEAD RUN "pictures:\n" CURVE("reason: lost"), ":7: ", "none beside `reason`"},
        {HEAD "clams: []\n", ":4: ", "did you mean \"claims\""},
        {HEAD "claims:\n" CLAIM("a", "1", "criterion: 1, computed: mass, scene: pair.yaml"),
         ":5: ", "beside words alone"},
        {HEAD "claims:\n" CLAIM("a", "most", "criterion: many, computed: mass, scene: pair.yaml"),
         ":5: ", "criterion: found \"many\", expected a number"},
        {HEAD "claims:\n" CLAIM("a", "most", "criterion: 1, computed: none, reason: b"),
         ":5: ", "where nothing is computed"},
        {HEAD "runs:\n  - {name: swing, scene: none.yaml}\n",
         ":5: ", "scene: found \"none.yaml\", expected a scene: "},
        {HEAD "runs:\n  - {name: swing, scene: none.yaml, chained: true}\n",
         ":5: ", "scene: found \"none.yaml\", expected a scene: "},
        {HEAD "runs:\n  - {name: swing, scene: twice.yaml, long: true}\n",
         ":5: ", "scene: found \"twice.yaml\", expected a scene: "},
        {HEAD "runs:\n  - name: swing\n    scene: pair.yaml\n    set:\n      step: -1\n",
         ":8: ", "set: step: found \"-1\""},
        {HEAD "runs:\n  - {name: swing, scene: pair.yaml, end: 1, segment: 0.3}\n",
         ":5: ", "segment: found 0.3"},
        {HEAD "runs:\n  - {name: swing, scene: pair.yaml, end: 1, sample: 0.02, segment: 0.25}\n",
         ":5: ", "segment: found 0.25"},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: mass, scene: none.yaml"),
         ":5: ", "scene: found \"none.yaml\", expected a scene: "},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: mass, scene: twice.yaml"),
         ":5: ", "scene: found \"twice.yaml\", expected a scene: "},
        {HEAD "claims:\n" CLAIM("a", "1", "computed: refused, scene: none.yaml"),
         ":5: ", "scene: found \"none.yaml\", expected a scene: "},
        {HEAD "pictures:\n  - {part: a, figure: b, scene: none.yaml}\n",
         ":5: ", "scene: found \"none.yaml\", expected a scene: "},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        dl_paper *paper = (dl_paper *)&bad;
        dl_error error = {""};
        char place[96];
        write_text("paper.yaml", bad[i].text);
        const dl_status status = dl_paper_read(paper_path, &paper, &error);
        snprintf(place, sizeof place, "%s%s", paper_path, bad[i].line);
        if (status != DL_INPUT || paper || !strstr(error.message, place) ||
            !strstr(error.message, bad[i].part))
            fail_msg("paper %zu: status %s, message \"%s\", expected \"%s\" and \"%s\"", i,
                     dl_status_name(status), error.message, place, bad[i].part);
    }
}

static void help_names_every_key(void **state) {
    (void)state;
    static const char *const keys[] = {
        "published",       "computed",      "where", "segment",      "chained", "long",
        "not_recoverable", "rest-distance", "curve", "within",       "about",   "energy-error",
        "criterion",       "as said",       "body",  "density-trend"};
    char *text = NULL;
    size_t size = 0;
    FILE *out = open_memstream(&text, &size);
    assert_non_null(out);
    dl_paper_help(out);
    fclose(out);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        assert_non_null(strstr(text, keys[i]));
    free(text);
}

/* The papers that are shipped: every scene they name is there (a refused one must be meant). */
static void shipped_papers_are_whole(void **state) {
    (void)state;
    static const char *const names[] = {"tr171", "tr299", "tr323"};
    static const size_t least_claims[] = {30, 30, 70}, least_pictures[] = {25, 25, 12};
    for (size_t k = 0; k < 3; k++) {
        char path[256];
        dl_error error = {""};
        dl_paper *paper = NULL;
        snprintf(path, sizeof path, "%s/papers/%s.yaml", DL_STUDIES, names[k]);
        if (dl_paper_read(path, &paper, &error))
            fail_msg("%s", error.message);
        assert_true(paper->claims >= least_claims[k]);
        assert_true(paper->pictures >= least_pictures[k]);
        assert_true(paper->lost > 2);
        for (size_t i = 0; i < paper->cases; i++)
            assert_int_equal(access(paper->cased[i].path, R_OK), 0);
        for (size_t i = 0; i < paper->claims; i++)
            if (paper->claim[i].source.path)
                assert_int_equal(access(paper->claim[i].source.path, R_OK), 0);
        dl_paper_free(paper);
    }
}

/* A picture, or the reason that there is none, for every figure of the reports that have many. */
static void every_figure_has_its_picture(void **state) {
    (void)state;
    static const struct {
        const char *name, *prefix;
        int figures;
    } papers[] = {{"tr171", "3.", 10}, {"tr299", "", 18}};
    for (size_t p = 0; p < 2; p++) {
        char path[256];
        dl_paper *paper = NULL;
        snprintf(path, sizeof path, "%s/papers/%s.yaml", DL_STUDIES, papers[p].name);
        assert_int_equal(dl_paper_read(path, &paper, NULL), DL_OK);
        for (int number = 1; number <= papers[p].figures; number++) {
            char figure[32];
            size_t k = 0;
            snprintf(figure, sizeof figure, "Figure %s%d", papers[p].prefix, number);
            const size_t length = strlen(figure);
            while (k < paper->pictures &&
                   (strncmp(paper->picture[k].figure, figure, length) != 0 ||
                    strspn(paper->picture[k].figure + length, "0123456789.") > 0))
                k++;
            /* "Figures 1 and 2" are one picture. */
            if (k == paper->pictures && !(p == 1 && number <= 2))
                fail_msg("%s: nothing answers %s", papers[p].name, figure);
        }
        dl_paper_free(paper);
    }
}

/* --- the command ------------------------------------------------------------------------------ */

/* What it prints, errors too; *code its exit status. */
static char *command(const char *arguments, int *code) {
    char line[512];
    char *text = calloc(1, 1 << 16);
    assert_non_null(text);
    snprintf(line, sizeof line, "cd %s && %s paper %s 2>&1", folder, DL_PROGRAM, arguments);
    FILE *from = popen(line, "r");
    assert_non_null(from);
    const size_t size = fread(text, 1, (1 << 16) - 1, from);
    text[size] = '\0';
    *code = WEXITSTATUS(pclose(from));
    return text;
}

static void the_command_tells_everything(void **state) {
    (void)state;
    int code;
    write_text("paper.yaml", small);
    char *text = command("paper.yaml --json", &code);
    assert_int_equal(code, 0);
    json_t *root = json_loads(text, 0, NULL);
    assert_non_null(root);
    const json_t *paper = json_array_get(json_object_get(root, "papers"), 0);
    const json_t *claims = json_object_get(paper, "claims");
    assert_int_equal(json_array_size(claims), 10);
    const json_t *second = json_array_get(claims, 1), *fourth = json_array_get(claims, 3);
    assert_string_equal(json_string_value(json_object_get(second, "verdict")), "differs");
    assert_true(json_number_value(json_object_get(second, "computed")) == 2);
    assert_true(json_is_null(json_object_get(fourth, "computed")));
    assert_string_equal(json_string_value(json_object_get(root, "page")), "test.html");
    json_decref(root);
    free(text);
    text = command("paper.yaml --long --out test.html", &code);
    assert_int_equal(code, 0);
    assert_non_null(
        strstr(text, "7 agree, 1 differ, 0 as said, 0 not as said, 0 put in, 2 not computable"));
    free(text);
    char path[128];
    snprintf(path, sizeof path, "rm -r %s/test.html.runs", folder);
    assert_int_equal(system(path), 0);
}

static void the_command_refuses_what_it_does_not_know(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *part;
    } bad[] = {
        {"TR172 --studies " DL_STUDIES, "tr171, tr299, tr323, all"},
        {"TR171 --studies nowhere", "--studies"},
        {"none.yaml", "none.yaml"},
        {"TR171 --lnog", "did you mean \"--long\""},
        {"TR171 --studies " DL_STUDIES " --out p.txt", "--out: found \"p.txt\""},
    };
    for (size_t i = 0; i < sizeof bad / sizeof *bad; i++) {
        int code;
        char *text = command(bad[i].arguments, &code);
        if (code != 2 || !strstr(text, bad[i].part))
            fail_msg("%s: exit %d, \"%s\"", bad[i].arguments, code, text);
        free(text);
    }
}

static void bad_input_ends_before_anything_runs(void **state) {
    (void)state;
    int code;
    write_text("paper.yaml", HEAD "runs:\n  - {name: swing, scene: pair.yaml, end: 0.5}\n"
                                  "  - {name: other, scene: pair.yaml, set: {step: -1}}\n");
    char *text = command("paper.yaml --out page.html", &code);
    if (code != 2 || !strstr(text, "paper.yaml:6: set: step: found \"-1\", expected"))
        fail_msg("exit %d, \"%s\"", code, text);
    free(text);
    assert_int_not_equal(access(page, F_OK), 0);
    char path[128];
    snprintf(path, sizeof path, "%s/swing.h5", runs);
    assert_int_not_equal(access(path, F_OK), 0);
}

static void one_page_has_one_writer(void **state) {
    (void)state;
    int code;
    dl_lock lock;
    dl_error error = {""};
    write_text("paper.yaml", small);
    assert_int_equal(dl_lock_take(&lock, runs, &error), DL_OK);
    char *text = command("paper.yaml --out page.html", &code);
    if (code != 2 || !strstr(text, "another driftlab is writing"))
        fail_msg("exit %d, \"%s\"", code, text);
    free(text);
    assert_int_not_equal(access(page, F_OK), 0);
    dl_lock_release(&lock);
    free(command("paper.yaml --out page.html", &code));
    assert_int_equal(code, 0);
    assert_int_equal(access(page, F_OK), 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(verdicts_follow_the_rule),
        cmocka_unit_test(words_are_judged_by_their_criterion),
        cmocka_unit_test_setup(claims_get_their_verdicts, clean),
        cmocka_unit_test_setup(the_page_holds_all_of_it, clean),
        cmocka_unit_test_setup(finished_runs_are_kept, clean),
        cmocka_unit_test_setup(a_damaged_run_is_made_again, clean),
        cmocka_unit_test_setup(rows_of_other_kinds, clean),
        cmocka_unit_test_setup(curves_go_through_every_frame, clean),
        cmocka_unit_test_setup(curves_and_reasons_stand_on_the_page, clean),
        cmocka_unit_test_setup(layers_are_counted_from_below, clean),
        cmocka_unit_test_setup(a_killed_run_goes_on, clean),
        cmocka_unit_test_setup(an_interrupt_keeps_what_is_finished, clean),
        cmocka_unit_test_setup(a_run_starts_from_another, clean),
        cmocka_unit_test_setup(the_freeing_speed_is_the_exact_one, clean),
        cmocka_unit_test_setup(rotation_is_that_of_the_body, clean),
        cmocka_unit_test_setup(densities_go_with_the_height, clean),
        cmocka_unit_test_setup(pressures_are_fitted_by_lines, clean),
        cmocka_unit_test_setup(a_stray_does_not_scale_the_body, clean),
        cmocka_unit_test_setup(a_failed_run_is_a_result, clean),
        cmocka_unit_test_setup(bad_papers_are_refused, clean),
        cmocka_unit_test(help_names_every_key),
        cmocka_unit_test(shipped_papers_are_whole),
        cmocka_unit_test(every_figure_has_its_picture),
        cmocka_unit_test_setup(the_command_tells_everything, clean),
        cmocka_unit_test_setup(the_command_refuses_what_it_does_not_know, clean),
        cmocka_unit_test_setup(bad_input_ends_before_anything_runs, clean),
        cmocka_unit_test_setup(one_page_has_one_writer, clean),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
