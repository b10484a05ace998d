/* A paper after reading. */
#ifndef DL_STUDY_PAPER_PLAN_H
#define DL_STUDY_PAPER_PLAN_H

#include "driftlab/method.h"
#include "driftlab/paper.h"
#include "driftlab/trajectory.h"

enum { DL_PAPER_SETTINGS = 16 };

/* One of `runs`. */
typedef struct dl_paper_case {
    char *name, *scene, *method, *note;
    double end, sample, segment; /* 0: the scene's, the scene's, one segment */
    bool is_long, chained;
    char *path; /* of the scene */
    size_t settings;
    char *key[DL_PAPER_SETTINGS], *value[DL_PAPER_SETTINGS];
} dl_paper_case;

/* What a claim or a picture looks at: the state of a scene at its start, or of a run. */
typedef struct dl_paper_source {
    char *scene, *run;
    char *path;    /* of the scene; NULL where it is a run */
    size_t number; /* of the run */
    long step;     /* -1: not given */
    double time;   /* INFINITY: not given; without both the last frame */
} dl_paper_source;

typedef enum dl_paper_rule { DL_RULE_EQUAL, DL_RULE_AT_LEAST, DL_RULE_AT_MOST } dl_paper_rule;

typedef struct dl_paper_claim {
    dl_paper_source source;
    char *part, *what, *where, *unit, *note, *published, *computed;
    char *criterion; /* number that words are judged by; "" where a number is published */
    char *reason;    /* why nothing is computed; "" where something is */
    int rule;
    bool input;                  /* the scene's own data */
    bool total;                  /* of an observable's table: all rows together */
    long since;                  /* step from which the change is taken; -1: none */
    double digit, within, about; /* of the tolerance; 0, INFINITY, 0: not given */
    double row, bin;             /* of an observable's table; row INFINITY: its first */
    long particle, span;
    double rate, perturbation, residual; /* of TR299 (3.1) */
    double value, tolerance;             /* of what is published, or of the criterion */
    size_t quantity;                     /* paper_quantity.h */
} dl_paper_claim;

enum { DL_PAPER_MARKS = 16 };

/* A point of a curve that the paper prints. */
typedef struct dl_paper_mark {
    double at, value; /* step, or time where the method chooses its steps */
} dl_paper_mark;

typedef struct dl_paper_picture {
    dl_paper_source source;
    char *part, *figure, *caption;
    char *reason; /* why there is none; "" where there is */
    int colour, window;
    bool velocities, equal_size;
    char *curve; /* quantity that is drawn against the step; "": a state is drawn */
    char *axis;  /* its name there; "": the quantity's */
    char *published;
    long particle;
    size_t quantity; /* of the curve, paper_quantity.h */
    size_t marks;
    dl_paper_mark mark[DL_PAPER_MARKS];
} dl_paper_picture;

struct dl_paper {
    char *path; /* of its file */
    char *name, *title, *source;
    size_t cases, claims, pictures, lost;
    dl_paper_case *cased;
    dl_paper_claim *claim;
    dl_paper_picture *picture;
    char **lost_text;
};

/* --- the tables of its file (paper_tables.c) -------------------------------------------------- */

extern const dl_parameter_table dl_paper_table, dl_paper_run_table, dl_paper_claim_table,
    dl_paper_picture_table;

/* --- a run that has been made (paper_run.c) --------------------------------------------------- */

/* Makes run `number` or finds it; *row is set in any case. `progress` has its number and count. */
dl_status dl_paper_make(const dl_paper *paper, size_t number, const dl_paper_options *options,
                        dl_paper_progress *progress, dl_paper_run_row *row, dl_error *error);

/* Whether dl_paper_make would compute (it may still find it kept). */
bool dl_paper_is_wanted(const dl_paper_case *cased, const dl_paper_options *options);

/* Reads the run's scene, sets the method's options and divides the run, and keeps nothing of it.
 * DL_INPUT with what is wrong; *key is the key that it is of, "scene", "segment" or "set". A
 * chained run's scene is not read. */
dl_status dl_paper_check(const dl_paper_case *cased, const char **key, dl_error *error);

/* File of segment `segment` from 0; owned by the caller. NULL: no memory. */
char *dl_paper_trajectory(const char *folder, const dl_paper_run_row *row, size_t segment);

/* --- a state that is looked at (paper_state.c) ------------------------------------------------ */

typedef struct dl_paper_state {
    dl_scene *scene;
    double *y_all;               /* [2 * dimension * particles] */
    dl_frames *frames;           /* NULL: a scene's initial state */
    size_t number;               /* of the frame */
    size_t segment;              /* of the run */
    const dl_paper_run_row *run; /* NULL likewise */
    const char *folder;
} dl_paper_state;

/* DL_INPUT with the reason where there is none. */
dl_status dl_paper_state_open(const dl_paper_source *source, const dl_paper_run_row *runs,
                              const char *folder, dl_paper_state *state, dl_error *error);
void dl_paper_state_close(dl_paper_state *state);
/* "drop1, step 229". */
void dl_paper_source_text(const dl_paper_source *source, char *text, size_t size);

/* --- a curve (paper_curve.c) ------------------------------------------------------------------ */

/* A quantity at every frame of a run. */
typedef struct dl_paper_curve {
    size_t count;
    double *at, *value; /* [count]; at: steps, or times where the method chooses its steps */
    bool by_step;
} dl_paper_curve;

/* Sets quantity and marks of a picture with a curve from its texts; DL_INPUT: "expected ...". */
dl_status dl_paper_curve_prepare(dl_paper_picture *picture, dl_error *error);
/* DL_INPUT with the reason where the run has not come to its end, or a frame has no such value. */
dl_status dl_paper_curve_measure(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                                 const char *folder, dl_paper_curve *curve, dl_error *error);
void dl_paper_curve_free(dl_paper_curve *curve);

/* --- judging (paper_judge.c) ------------------------------------------------------------------ */

/* Whether nothing is computed for the claim: what is published may be words then. */
bool dl_paper_has_no_number(const dl_paper_claim *claim);
/* Whether words are published, and judged by the claim's criterion. */
bool dl_paper_has_words(const dl_paper_claim *claim);
/* Sets value and tolerance of the claim from its texts; DL_INPUT: "expected ...". */
dl_status dl_paper_claim_prepare(dl_paper_claim *claim, dl_error *error);
void dl_paper_judge(const dl_paper_claim *claim, dl_paper_row *row);

#endif
