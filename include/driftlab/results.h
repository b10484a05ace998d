/* A results file (HDF5): everything a report needs and nothing else is read by it.
 *
 * In memory the whole file is this structure. It is written by replacing the file: a complete new
 * file beside it, synced, then renamed over the old one, so that a crash, a signal or a full disk
 * leaves the last complete version.
 *
 * In the file (h5dump shows it), names are those of the structures' fields:
 *
 *     /                  attributes: format "driftlab results", version 2, study, title, kind,
 *                        question, asked_error, asked_in
 *     /facts/0000 ...    attributes: name, value
 *     /scenes/0000 ...   attributes: name, source; scalar text datasets: explain, text
 *     /references/0000   attributes: key, digest, scene, description, precision, note, error,
 *                        seconds, length, lyapunov, lyapunov_error, parted, horizon, samples,
 *                        particles, dimension; datasets: time, sample_error, growth [samples],
 *                        position, position_low [samples][dimension * particles]
 *     /cases/0000 ...    attributes: the fields of dl_case and, under the same names, of its
 *                        summary (status as its name); datasets: sample_time,
 *                        sample_energy_error, sample_position_error [samples] and, where
 *                        the scene conserves it, sample_momentum_error,
 *                        sample_angular_momentum_error [samples]
 *     /findings/0000 ... attributes: the fields of dl_finding; datasets: quantity [quantities][3],
 *                        table [rows][columns]
 *
 * Groups stand in the order of the arrays. Text is UTF-8 of fixed length, reals are IEEE doubles
 * (NaN: does not apply), counts 64-bit unsigned integers. What was added later is read as "", 0
 * or nothing from a file of an earlier program that lacks it (src/io/results_schema.c says what).
 * Lengths, times and energies are in the scene's units; cpu_* in seconds. */
#ifndef DRIFTLAB_RESULTS_H
#define DRIFTLAB_RESULTS_H

#include <stddef.h>
#include <stdio.h>
#include "driftlab/run.h"
#include "driftlab/status.h"

typedef struct dl_case {
    char *key;    /* the identity of the case: scene and hash of its content, method, every option,
                     end, samples and hash of the reference */
    char *scene;  /* name */
    char *method; /* name of the registry's row */
    char *family;
    char *options; /* "step=0.01 ...": every option */
    char *command; /* the `driftlab run` line that repeats it */
    dl_run_summary summary;
    unsigned repeats;
    double cpu_median;         /* of the repeats; summary.cpu_seconds is the minimum */
    double position_error;     /* RMS over particles at the end, against the reference; NaN: none */
    double position_error_max; /* largest particle's at the end */
    double position_error_ever; /* largest RMS at any sample up to the horizon */
    size_t samples;
    double *sample_time, *sample_energy_error, *sample_position_error; /* [samples] */
    /* [samples]; NULL where the scene does not conserve it; NaN from where a particle first rests
     * on a wall, whose force is not known */
    double *sample_momentum_error, *sample_angular_momentum_error;
    char *invalid; /* why the run is not what it claims, so that none of its errors counts ("" where
                      it is): it ended early, or its steps are not those asked for */
    char *refused; /* why the position error alone is not to be trusted ("" where it is): a run that
                      failed, an error below the reference's own */
} dl_case;

typedef struct dl_reference {
    char *key;    /* its identity, as a case's */
    char *digest; /* of the key and all that follows: what is kept from before is checked by it */
    char *scene;
    char *description; /* methods and tolerances, in words */
    char *precision;   /* "long double", "quad"; "" for the methods' double, "exact" */
    char *note;        /* why it is no better, or "" */
    double error;      /* RMS position error of its own at the end; 0: exact */
    double seconds;    /* CPU time of the trajectory itself */
    double length;     /* mean distance to the nearest neighbour at the start; 0: not known */
    double lyapunov, lyapunov_error; /* largest exponent and its standard error; 0: not measured */
    double parted;  /* from when on its own error is above 1 % of `length`; 0: never */
    double horizon; /* from when on errors against it mean nothing; 0: not before the end */
    size_t samples, particles;
    int dimension;
    double *time;         /* [samples] */
    double *sample_error; /* [samples]: its own error, the largest so far */
    double *growth;       /* [samples]: log of the factor by which small displacements have grown */
    double *position;     /* [samples][dimension * particles] */
    double *position_low; /* what is to be added to it */
} dl_reference;

/* What a study of another kind than work-precision finds for one method on one scene: named
 * quantities, a table and a verdict. Which these are is the kind's own (src/study/kind_*.c). Names
 * stand in one text, a line each. */
typedef struct dl_finding {
    char *key; /* its identity, as a case's */
    char *scene, *method, *family, *options, *command;
    dl_status status; /* DL_OK: it was measured, whatever the verdict */
    char message[DL_MESSAGE_SIZE];
    char *verdict; /* "pass", "fail", "stable", "not measurable" ...: the kind's words */
    char *reason;  /* the verdict in a sentence, with its figures */
    double cpu_seconds;
    size_t quantities;
    char *quantity_names; /* lines: "NAME" or "NAME [UNIT]" */
    double *quantity;     /* [quantities][3]: value and interval of confidence (NaN: none) */
    size_t rows, columns;
    char *column_names; /* lines, as above */
    char *row_words;    /* lines: a word or sentence for each row, "" where it needs none */
    double *table;      /* [rows][columns] */
} dl_finding;

/* One named text of the provenance: "compiler", "machine", "sundials", "command" ... */
typedef struct dl_fact {
    char *name, *value;
} dl_fact;

typedef struct dl_scene_record {
    char *name, *source, *explain; /* `explain`: what driftlab explain prints */
    char *text;                    /* the scene file */
} dl_scene_record;

typedef struct dl_results {
    char *study, *title, *kind, *question;
    double asked_error; /* of `asked_in` */
    char *asked_in;     /* "position" or "energy" */
    size_t facts;
    dl_fact *fact;
    size_t scenes;
    dl_scene_record *scene;
    size_t references;
    dl_reference *reference;
    size_t cases;
    dl_case *cased;
    size_t findings;
    dl_finding *finding;
} dl_results;

/* *results is freshly allocated (empty strings, no arrays). */
dl_status dl_results_create(dl_results **results, dl_error *error);
/* DL_IO where the file cannot be opened; DL_INPUT where it is no HDF5 file, damaged, or of
 * another program's format: the message names both programs and formats. *results is NULL then. */
dl_status dl_results_read(const char *path, dl_results **results, dl_error *error);
/* DL_IO where it cannot be written: the file at `path` is then as it was before. */
dl_status dl_results_write(const dl_results *results, const char *path, dl_error *error);
void dl_results_free(dl_results *results);

/* The case with that key or NULL. */
const dl_case *dl_results_find(const dl_results *results, const char *key);
/* Appends; takes over what *added owns (on failure the caller keeps it). */
dl_status dl_results_add_case(dl_results *results, const dl_case *added, dl_error *error);
dl_status dl_results_add_reference(dl_results *results, const dl_reference *added, dl_error *error);
dl_status dl_results_add_finding(dl_results *results, const dl_finding *added, dl_error *error);
dl_status dl_results_add_scene(dl_results *results, const dl_scene_record *added, dl_error *error);
/* Sets the fact of that name, or appends it. */
dl_status dl_results_add_fact(dl_results *results, const char *name, const char *value,
                              dl_error *error);
/* Its value, or NULL. */
const char *dl_results_fact(const dl_results *results, const char *name);
/* The reference of that scene, or NULL. */
const dl_reference *dl_results_reference(const dl_results *results, const char *scene);

/* The finding with that key or NULL. */
const dl_finding *dl_results_find_finding(const dl_results *results, const char *key);
/* A finding's quantity by its name, without the unit; NULL where it has none of it, otherwise
 * [3]: value, low, high. */
const double *dl_finding_quantity(const dl_finding *finding, const char *name);

/* Free what the structure owns, not the structure. */
void dl_case_release(dl_case *cased);
void dl_finding_release(dl_finding *finding);
void dl_reference_release(dl_reference *reference);

/* The cheapest case (by CPU seconds) of that scene whose error in `asked_in` is at most `error`;
 * NULL where none reaches it. Energy errors are relative to the scene's energy scale. Runs that
 * failed do not count; where a position error is too small for the reference, the reference's own
 * error is added to it. */
const dl_case *dl_results_cheapest(const dl_results *results, const char *scene,
                                   const char *asked_in, double error);

/* The error of a case in "position" (RMS at the end), "position-worst" (largest particle's at the
 * end), "position-ever" (largest RMS at any sample up to the horizon), "energy", "momentum" or
 * "angular-momentum" (largest over the samples, in units of its scale); NaN where it has none. */
double dl_case_error(const dl_case *cased, const char *asked_in);

/* Whether the run ended past the horizon of the reference (NULL: there is none): its positions at
 * the end are then no error of the method, and are not shown as one. */
bool dl_case_is_past_horizon(const dl_case *cased, const dl_reference *reference);

/* What that error is certainly below: a position error that is smaller than the reference (NULL:
 * there is none) can tell is at most that much larger. Infinite for a run that does not count, and
 * for positions past the horizon. */
double dl_case_bound(const dl_case *cased, const char *asked_in, const dl_reference *reference);

/* "cheapest for a position error of 1e-06 on stream: METHOD with OPTIONS (0.012 CPU s, 1400 force
 * evaluations)", or that nothing reached it and which came closest. */
void dl_results_answer(const dl_results *results, const char *scene, char *text, size_t size);

/* The answer of studies of one kind in two sentences: of their only scene, or of all their scenes
 * together. */
void dl_results_answer_all(const dl_results *const *results, size_t count, char *text, size_t size);

/* Verdict, reason and quantities of a finding, or why it could not be measured, as text. */
void dl_finding_print(const dl_finding *finding, FILE *out);

/* The table of all cases and the answer for every scene, as text. */
void dl_results_print(const dl_results *results, FILE *out);

#endif
