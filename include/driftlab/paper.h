/* Papers: what a paper printed, beside what is computed from its scenes.
 *
 * A paper's file (YAML) names runs, claims and pictures. Runs are kept: a set that was stopped, in
 * whatever way, goes on where it was. A claim is judged by a rule that its file states. */
#ifndef DRIFTLAB_PAPER_H
#define DRIFTLAB_PAPER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "driftlab/status.h"

typedef struct dl_paper dl_paper;

/* Paths in the file are relative to its own folder. DL_INPUT names file, line, key, value and what
 * was expected, of a scene that cannot be read, an option or a segment as well; what a chained run
 * starts from is not there yet. */
dl_status dl_paper_read(const char *path, dl_paper **paper, dl_error *error);
void dl_paper_free(dl_paper *paper);
const char *dl_paper_name(const dl_paper *paper);

/* `driftlab help paper`: every key and every quantity, from the tables the reader uses. */
void dl_paper_help(FILE *out);

typedef enum dl_verdict {
    DL_AGREES,
    DL_DIFFERS,
    DL_AS_SAID, /* what the paper says in words, by a criterion that its file states */
    DL_NOT_AS_SAID,
    DL_INPUT_DATA, /* it agrees since it was put in: the scene's own data */
    DL_NOT_COMPUTABLE
} dl_verdict;

/* "agrees", "differs", "as said", "not as said", "input", "not computable". */
const char *dl_verdict_name(dl_verdict verdict);

/* What was published, a number or words. Texts without a comment belong to the paper. */
typedef struct dl_paper_row {
    const char *part, *what, *where, *published, *unit, *note;
    char rule[96];     /* how it is judged: "half a unit of the last digit (0.0005)" */
    char from[128];    /* what it is computed from: "drop1, step 229" */
    double value;      /* computed; NaN where it is not computable */
    double difference; /* computed - published; NaN as well, and where words were published */
    double tolerance;  /* of the difference, or of the criterion's */
    dl_verdict verdict;
    char *reason; /* owned: why it is not computable, or a scene was refused; "" otherwise */
} dl_paper_row;

typedef struct dl_paper_figure {
    const char *part, *figure, *caption;
    char from[128];
    char *svg;    /* owned; NULL where there is none */
    char *reason; /* owned: why there is none; "" otherwise */
} dl_paper_figure;

typedef enum dl_paper_run_fate {
    DL_RUN_MISSING,  /* not made: long, or it could not be started */
    DL_RUN_FINISHED, /* now */
    DL_RUN_KEPT,     /* from before */
} dl_paper_run_fate;

typedef struct dl_paper_run_row {
    const char *name, *scene, *method, *note;
    bool is_long;
    dl_paper_run_fate fate;
    dl_status status;
    char options[256];
    char message[DL_MESSAGE_SIZE]; /* of a run that failed, or is missing; "" otherwise */
    double end;                    /* time that was asked for */
    double reached, step;          /* time; step 0: adaptive */
    double energy_error; /* largest, absolute, what walls and radiation took being booked */
    double energy_scale;
    double cpu_seconds;
    unsigned long steps, nonlinear_iterations;
    size_t segments, segments_done;
} dl_paper_run_row;

/* What came out. It does not outlive its paper. */
typedef struct dl_paper_report {
    const char *name, *title, *source;
    size_t rows, figures, runs, lost;
    dl_paper_row *row;
    dl_paper_figure *figure;
    dl_paper_run_row *run;
    const char *const *lost_text; /* what cannot be recovered from the paper */
} dl_paper_report;

typedef struct dl_paper_progress {
    const char *run;
    size_t number, count; /* of this run, from 1, of those to be made */
    double fraction;      /* of this run */
    double seconds;       /* wall-clock, since it was started */
} dl_paper_progress;

typedef struct dl_paper_options {
    const char *folder;            /* where runs are kept; made where it is missing */
    bool long_runs;                /* make the long ones as well */
    const volatile int *interrupt; /* non-zero: stop; finished runs stay. May be NULL */
    void (*on_progress)(void *context, const dl_paper_progress *progress); /* may be NULL */
    void *context;
} dl_paper_options;

/* Makes what runs are missing, computes and judges every claim, draws every picture. A run or a
 * claim that fails is part of the report: DL_OK. DL_INTERRUPTED with how to go on; DL_IO where a
 * run cannot be kept; DL_INPUT where another process has the folder. *report is NULL then. */
dl_status dl_paper_run(const dl_paper *paper, const dl_paper_options *options,
                       dl_paper_report **report, dl_error *error);
void dl_paper_report_free(dl_paper_report *report);

/* Rows with that verdict. */
size_t dl_paper_count(const dl_paper_report *report, dl_verdict verdict);

/* One self-contained page of all of them, complete or not at all. */
dl_status dl_paper_write(const dl_paper_report *const *report, size_t count, const char *path,
                         dl_error *error);

#endif
