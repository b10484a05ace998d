/* Kinds of study: one registry, one row a kind, one file a kind (kind_*.c).
 *
 * `work-precision` measures cases (measure.h). Every other kind measures units: one method with its
 * options on one scene, in a child process of its own, and leaves a finding. A unit that was
 * measured is kept whatever happens to those after it. */
#ifndef DL_STUDY_KIND_H
#define DL_STUDY_KIND_H

#include <stdio.h>

#include "study/finding.h"
#include "study/measure.h"
#include "study/plan.h"

/* What a kind measures: lives in the child. */
typedef struct dl_study_unit {
    const dl_scene *scene;
    const dl_method_row *row;
    const void *options;  /* of the row's table; a copy is the kind's to change */
    double end, sample;   /* of the study on that scene */
    bool sample_chosen;   /* nobody asked for `sample`: it may be rounded to whole steps */
    double seconds;       /* CPU time one run may take */
    const void *settings; /* of the kind's table */
    dl_run_function *run;
    /* Tells how far it is, as "step 0.013"; also what keeps the process's time limit away, which is
     * `seconds` from one call to the next. NULL where nobody listens. */
    void (*progress)(void *context, const char *text);
    void *context;
} dl_study_unit;

struct dl_study_kind {
    const char *doc;             /* one line: what is asked */
    dl_parameter_table settings; /* of the mapping `with` of a study file */
    size_t settings_size;
    long samples;      /* intervals where a study does not say; 0: 20 */
    bool chooses_step; /* sets `step` itself: a case may not, and its options are told without */
    /* Refuses, by DL_INPUT, what the kind cannot do on that scene with that method. NULL: nothing.
     */
    dl_status (*check)(const dl_study_unit *unit, dl_error *error);
    /* Fills the finding with dl_finding_*. A method that fails is a finding, not a failure. */
    dl_status (*measure)(const dl_study_unit *unit, dl_finding *finding, dl_error *error);
    const char *good;  /* the verdict that a method is to have; NULL: ... */
    const char *merit; /* ... the quantity that is to be large */
    /* The study's answer for a scene in at most two sentences, from its findings alone; "": it is
     * told for another. */
    void (*answer)(const dl_results *results, const char *scene, char *text, size_t size);
    /* What all findings say together, as tables, after them. NULL: nothing. */
    void (*print)(const dl_results *results, FILE *out);
};

/* Adding a kind: a line here and a `const dl_study_kind dl_study_kind_<symbol>` in its file. The
 * first measures cases: its `measure` is NULL. */
#define DL_STUDY_KINDS(X)                                                                          \
    X(work_precision, "work-precision")                                                            \
    X(stability, "stability")                                                                      \
    X(extreme, "extreme")                                                                          \
    X(drift, "drift")                                                                              \
    X(equilibrium, "equilibrium")                                                                  \
    X(scaling, "scaling")

#define DL_STUDY_KIND_DECLARE(symbol, name) extern const dl_study_kind dl_study_kind_##symbol;
DL_STUDY_KINDS(DL_STUDY_KIND_DECLARE)
#undef DL_STUDY_KIND_DECLARE

/* The names, in that order, NULL-terminated, and the rows. */
extern const char *const dl_study_kinds[];
extern const dl_study_kind *const dl_study_kind_rows[];

/* The row of the kind that the results say. */
const dl_study_kind *dl_study_kind_of(const dl_results *results);

/* Creates the method on the scene as a run to `end` with samples every `sample` would, so that what
 * that refuses is refused before anything runs: for kinds' `check`. */
dl_status dl_study_try_start(const dl_study_unit *unit, dl_error *error);

/* Measures a unit of the study in a child process. A unit that fails is a finding with a status:
 * DL_OK. DL_INTERRUPTED, or DL_MEMORY and DL_IO of the study itself. `heard` (may be NULL) is told
 * in the parent what the unit tells of its progress. */
dl_status dl_study_measure_unit(const dl_study *study, const dl_study_case *cased,
                                const dl_watch *watch, void (*heard)(void *context, const char *),
                                void *heard_context, dl_finding *finding, dl_error *error);

#endif
