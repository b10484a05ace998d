/* The tables of a paper's file, and its help. */
#include <float.h>
#include <math.h>
#include <stdio.h>

#include "driftlab/picture.h"
#include "study/paper_quantity.h"

#define TABLE(rows_of)                                                                             \
    { .rows = rows_of, .count = sizeof rows_of / sizeof *rows_of }
#define TEXT(type, field, key, default_, doc_)                                                     \
    {                                                                                              \
        .name = key, .kind = DL_TEXT, .offset = offsetof(type, field), .unit = "",                 \
        .fallback = default_, .doc = doc_                                                          \
    }
#define REAL(type, field, key, unit_, least, default_, doc_)                                       \
    {                                                                                              \
        .name = key, .kind = DL_REAL, .offset = offsetof(type, field), .unit = unit_,              \
        .minimum = least, .maximum = DBL_MAX, .fallback = default_, .doc = doc_                    \
    }
#define FLAG(type, field, key, doc_)                                                               \
    {                                                                                              \
        .name = key, .kind = DL_FLAG, .offset = offsetof(type, field), .unit = "",                 \
        .fallback = "false", .doc = doc_                                                           \
    }

static const dl_parameter paper_rows[] = {
    TEXT(dl_paper, name, "name", NULL, "name of the paper"),
    TEXT(dl_paper, title, "title", NULL, "heading of its page"),
    TEXT(dl_paper, source, "source", NULL, "who published it, where, when"),
};

static const dl_parameter run_rows[] = {
    TEXT(dl_paper_case, name, "name", NULL, "what claims call it; its file is NAME.h5"),
    TEXT(dl_paper_case, scene, "scene", NULL, "scene file, relative to the paper's folder"),
    TEXT(dl_paper_case, method, "method", "leapfrog", "name of a method"),
    REAL(dl_paper_case, end, "end", "time", 0, "0", "0: the scene's own"),
    REAL(dl_paper_case, sample, "sample", "time", 0, "0", "between frames; 0: the scene's own"),
    REAL(dl_paper_case, segment, "segment", "time", 0, "0",
         "a run that was stopped goes on from the last whole segment; 0: one segment"),
    FLAG(dl_paper_case, is_long, "long", "made with --long alone"),
    FLAG(dl_paper_case, chained, "chained",
         "starts from other runs: the files that its scene starts from are those of this set"),
    TEXT(dl_paper_case, note, "note", "", "for the page"),
};

static const char *const rule_words[] = {"equal", "at-least", "at-most", NULL};

#define SOURCE_ROWS(type)                                                                          \
    TEXT(type, source.scene, "scene", "",                                                          \
         "look at the initial state of this scene file (or, instead, at a run)"),                  \
        TEXT(type, source.run, "run", "", "look at this run"),                                     \
        {.name = "step",                                                                           \
         .kind = DL_INTEGER,                                                                       \
         .offset = offsetof(type, source.step),                                                    \
         .unit = "steps",                                                                          \
         .minimum = -1,                                                                            \
         .maximum = 1e12,                                                                          \
         .fallback = "-1",                                                                         \
         .doc = "at the frame of this step of the method; -1: by time"},                           \
        REAL(type, source.time, "time", "time", 0, "none",                                         \
             "at the frame of this time; none: the last")

#define PARTICLE_ROW(type)                                                                         \
    {                                                                                              \
        .name = "particle", .kind = DL_INTEGER, .offset = offsetof(type, particle), .unit = "",    \
        .minimum = 1, .maximum = 1e9, .fallback = "1",                                             \
        .doc = "its number, from 1, as papers count"                                               \
    }

static const dl_parameter claim_rows[] = {
    TEXT(dl_paper_claim, part, "part", NULL, "heading under which it stands"),
    TEXT(dl_paper_claim, what, "what", NULL, "what was published"),
    TEXT(dl_paper_claim, where, "where", NULL, "its place in the paper"),
    TEXT(dl_paper_claim, published, "published", NULL,
         "the number as it is printed, with its digits; or the paper's words, beside `criterion`"),
    TEXT(dl_paper_claim, criterion, "criterion", "",
         "number, not the paper's, that its words are judged by with `rule`: as said, or not"),
    TEXT(dl_paper_claim, unit, "unit", "", "of the number"),
    TEXT(dl_paper_claim, computed, "computed", NULL,
         "what it is compared with: OBSERVABLE.COLUMN (driftlab list observables) or a quantity"),
    TEXT(dl_paper_claim, reason, "reason", "",
         "why nothing is computed, with `computed: none` alone; `published` may be words then"),
    FLAG(dl_paper_claim, input, "input",
         "the number is the scene's own data, which cannot but agree"),
    SOURCE_ROWS(dl_paper_claim),
    {.name = "rule",
     .kind = DL_WORD,
     .offset = offsetof(dl_paper_claim, rule),
     .unit = "",
     .words = rule_words,
     .fallback = "equal",
     .doc = "the computed number agrees where it is this, compared with the published one, or the "
            "criterion"},
    REAL(dl_paper_claim, digit, "digit", "as published", 0, "0",
         "unit of the last digit, which the tolerance is half of; 0: as the number is written"),
    REAL(dl_paper_claim, about, "about", "", 0, "0",
         "relative tolerance instead, for what the paper calls approximate"),
    REAL(dl_paper_claim, within, "within", "as published", 0, "none", "absolute tolerance instead"),
    REAL(dl_paper_claim, row, "row", "mass or length", 0, "none",
         "row of the observable's table: its mass, or the low end of its bin"),
    FLAG(dl_paper_claim, total, "total", "all rows of the observable's table together"),
    {.name = "since",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_paper_claim, since),
     .unit = "steps",
     .minimum = -1,
     .maximum = 1e12,
     .fallback = "-1",
     .doc = "the number is its change from this step of the run on; -1: the number itself"},
    REAL(dl_paper_claim, bin, "bin", "length", 0, "0", "width of the bins of height"),
    PARTICLE_ROW(dl_paper_claim),
    {.name = "span",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_paper_claim, span),
     .unit = "steps",
     .minimum = 0,
     .maximum = 1e12,
     .fallback = "0",
     .doc = "over which radiation takes energy; for layer-*, particles in each"},
    REAL(dl_paper_claim, rate, "rate", "1/time", -DBL_MAX, "0", "of a rotation, TR299 (3.1)"),
    REAL(dl_paper_claim, perturbation, "perturbation", "velocity", 0, "0",
         "of mass 2000 in TR299 (3.1)"),
    REAL(dl_paper_claim, residual, "residual", "velocity", 0, "0",
         "by which a velocity may miss TR299 (3.1)"),
    TEXT(dl_paper_claim, note, "note", "", "what a reader has to know"),
};

static const char *const colour_words[] = {[DL_COLOUR_MASS] = "mass",
                                           [DL_COLOUR_SPEED] = "speed",
                                           [DL_COLOUR_STATE] = "state",
                                           [DL_COLOUR_NONE] = "none",
                                           NULL};
static const char *const window_words[] = {"all", "system", "body", NULL};

static const dl_parameter picture_rows[] = {
    TEXT(dl_paper_picture, part, "part", NULL, "heading under which it stands"),
    TEXT(dl_paper_picture, figure, "figure", NULL, "which of the paper's figures it answers"),
    TEXT(dl_paper_picture, caption, "caption", "", "what is to be seen"),
    SOURCE_ROWS(dl_paper_picture),
    {.name = "colour",
     .kind = DL_WORD,
     .offset = offsetof(dl_paper_picture, colour),
     .unit = "",
     .words = colour_words,
     .fallback = "mass",
     .doc = "shade of the circles"},
    {.name = "window",
     .kind = DL_WORD,
     .offset = offsetof(dl_paper_picture, window),
     .unit = "",
     .words = window_words,
     .fallback = "all",
     .doc =
         "all particles; the system without what has escaped; or the heaviest group of particles, "
         "with some room"},
    FLAG(dl_paper_picture, velocities, "velocities", "arrows"),
    FLAG(dl_paper_picture, equal_size, "equal_size", "circles of one size"),
    TEXT(dl_paper_picture, curve, "curve", "",
         "draw this quantity (of a state, one number) at every frame of the run instead of a "
         "state"),
    TEXT(dl_paper_picture, axis, "axis", "", "the curve's name beside its axis"),
    PARTICLE_ROW(dl_paper_picture),
    TEXT(dl_paper_picture, published, "published", "",
         "points of the curve that the paper prints: STEP VALUE, STEP VALUE, ..."),
    TEXT(dl_paper_picture, reason, "reason", "",
         "why there is no picture, without a scene or a run: stands in its place"),
};

const dl_parameter_table dl_paper_table = TABLE(paper_rows), dl_paper_run_table = TABLE(run_rows),
                         dl_paper_claim_table = TABLE(claim_rows),
                         dl_paper_picture_table = TABLE(picture_rows);

/* --- help ------------------------------------------------------------------------------------- */

static void print_table(FILE *out, dl_parameter_table table) {
    for (size_t i = 0; i < table.count; i++) {
        const dl_parameter *row = &table.rows[i];
        char range[256];
        dl_parameter_range(row, range, sizeof range);
        fprintf(out, "  %-15s %s\n  %-15s %s%s%s; %s%s\n", row->name, row->doc, "", range,
                *row->unit ? ", in " : "", row->unit, row->fallback ? "default " : "required",
                !row->fallback ? "" : (*row->fallback ? row->fallback : "none"));
    }
}

void dl_paper_help(FILE *out) {
    fputs("A paper's file (YAML) sets what it printed beside what is computed.\n\nkeys:\n", out);
    print_table(out, dl_paper_table);
    fputs("  runs            list of runs\n"
          "  claims          list of published numbers\n"
          "  pictures        list of pictures\n"
          "  not_recoverable list of texts: what the paper does not let anyone recover\n"
          "\nruns: each with\n",
          out);
    print_table(out, dl_paper_run_table);
    fputs("  set             mapping of the method's options to values\n"
          "\nclaims: each with these keys; a list of values stands for as many claims, and all\n"
          "lists of a claim are as long\n",
          out);
    print_table(out, dl_paper_claim_table);
    fputs("\npictures: each with these keys, lists as for claims\n", out);
    print_table(out, dl_paper_picture_table);
    fputs("\nquantities, besides the columns of observables:\n", out);
    for (size_t i = 0; i < dl_quantity_count(); i++)
        fprintf(out, "  %-15s %s\n", dl_quantity_at(i)->name, dl_quantity_at(i)->doc);
}
