/* Studies: scenes x methods x options from one YAML file, each case in a child process of its own
 * with limits on time and memory, against a reference whose own error is measured.
 *
 * A results file is complete after every case: a study that was stopped, in whatever way, goes on
 * where it was when it is run again. */
#ifndef DRIFTLAB_STUDY_H
#define DRIFTLAB_STUDY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "driftlab/results.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

typedef struct dl_study dl_study;

/* Reads and validates a study, its scenes and every case. Paths in it are relative to the study's
 * own folder. DL_INPUT names file, line, key, value and what was expected. */
dl_status dl_study_read(const char *path, dl_study **study, dl_error *error);
void dl_study_free(dl_study *study);

const char *dl_study_name(const dl_study *study);
size_t dl_study_cases(const dl_study *study);

/* `driftlab help study`: every key, from the tables the reader uses. */
void dl_study_help(FILE *out);

typedef struct dl_study_progress {
    size_t done, total;  /* references and cases, those kept from before included */
    size_t kept;         /* of `done`: kept from an earlier run */
    double seconds;      /* wall-clock, since the study was started */
    double remaining;    /* estimated wall-clock seconds; NaN until one case has been run */
    const char *current; /* "stream leapfrog step=0.01", or "" at the end */
} dl_study_progress;

typedef struct dl_study_options {
    const char *results;           /* path of the results file; required */
    const char *command;           /* command line, for the results' facts; NULL: none */
    bool force;                    /* run every case, kept ones too */
    size_t processes;              /* cases side by side, each on a processor; 0: 1 */
    const volatile int *interrupt; /* non-zero: kill the running case, keep the others. NULL ok */
    struct dl_ranks *ranks;        /* ranks.h: they do the cases. NULL: this process does */
    /* Told what is not in the results: a rank that was lost. May be NULL. */
    void (*on_note)(void *context, const char *text);
    /* Called at the start of each case and about five times a second. May be NULL. */
    void (*on_progress)(void *context, const dl_study_progress *progress);
    void *context;
} dl_study_options;

/* Runs what is missing and writes the results file after every case. A failing case is a result:
 * DL_OK. DL_INTERRUPTED with how to go on; DL_INPUT where the results file belongs to another
 * study, or was timed on another machine or by another build; DL_IO where it cannot be written.
 * *results, owned by the caller, is what the file holds (NULL where there is none). */
dl_status dl_study_run(const dl_study *study, const dl_study_options *options, dl_results **results,
                       dl_error *error);

/* --- one unit alone --------------------------------------------------------------------------- */

/* A method with its options on one scene, asked what a study of some kind asks. */
typedef struct dl_measure_request {
    const char *kind, *scene, *method; /* names, and the scene's file */
    size_t settings;
    const char *const *key, *const *value; /* [settings]: of the method and of the kind */
    size_t lets;
    const dl_let *let;             /* [lets]: numbers of the scene (scene.h) */
    double end;                    /* 0: the scene's */
    double sample;                 /* 0: as many samples as the kind's studies have */
    double seconds;                /* CPU time of one run; 0: no limit */
    const volatile int *interrupt; /* as in a study */
    /* Told what the unit tells of its progress. May be NULL. */
    void (*on_progress)(void *context, const char *text);
    void *context;
} dl_measure_request;

/* Measures it in a child process, with a study's limit on memory. A unit that fails is a finding
 * with a status: DL_OK. DL_INPUT for what is refused, and for the kind work-precision, which
 * measures cases against a reference; DL_INTERRUPTED, DL_MEMORY, DL_IO. Free the finding with
 * dl_finding_release. */
dl_status dl_study_measure_alone(const dl_measure_request *request, dl_finding *finding,
                                 dl_error *error);

#endif
