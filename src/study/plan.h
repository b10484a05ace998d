/* A study after reading: every scene, reference and case validated, with its identity. */
#ifndef DL_STUDY_PLAN_H
#define DL_STUDY_PLAN_H

#include <stdint.h>
#include "driftlab/reference.h"
#include "driftlab/study.h"
#include "io/yaml.h"

enum { DL_MOST_SAMPLES = 1000000 }; /* of a study's run */

/* The scalars of the study file; see the table in plan_read.c. */
typedef struct dl_study_settings {
    char *name, *title, *question;
    int kind, asked_in; /* words of dl_study_kinds (kind.h) and dl_study_measures */
    char *scene;        /* file; "" where `scenes` lists several */
    double end;         /* 0: every scene's own */
    long samples;       /* intervals; read as 0: the kind's own */
    double asked_error;
    long repeats;
} dl_study_settings;

typedef struct dl_study_limits {
    double seconds; /* CPU time of one run */
    long memory;    /* MiB of address space */
} dl_study_limits;

typedef enum dl_reference_kind {
    DL_REFERENCE_NONE,
    DL_REFERENCE_RUNS,     /* a method, and a second one that measures its error */
    DL_REFERENCE_EXACT,    /* analytic two-body motion */
    DL_REFERENCE_EXTENDED, /* extended precision, driftlab/reference.h */
} dl_reference_kind;

/* A method with its options on one scene. */
typedef struct dl_study_run_of {
    const dl_method_row *row;
    void *options;
    char *text;    /* every option */
    char *changes; /* " --set key=value ..." of what the study file sets */
} dl_study_run_of;

typedef struct dl_study_scene {
    char *path;
    dl_scene *scene;
    char *lets;         /* " --let a=1": what the study sets in it; NULL or "": nothing */
    uint64_t hash;      /* of its text and data */
    double end, sample; /* what every run on it is given */
    bool sample_chosen; /* nobody asked for it: it may be rounded to whole steps */
    dl_study_run_of reference, check;
    char *reference_key;
    char *reference_text; /* in words */
} dl_study_scene;

typedef struct dl_study_case {
    size_t scene; /* index */
    dl_study_run_of run;
    char *key, *command;
    int line; /* in the study file */
} dl_study_case;

typedef struct dl_study_kind dl_study_kind;

typedef dl_status dl_run_function(const dl_scene *scene, const dl_method_row *row,
                                  const void *options, const dl_run_options *run_options,
                                  dl_run_summary *summary, double *y_final, dl_error *error);

struct dl_study {
    char *path;
    dl_study_settings settings;
    bool samples_chosen; /* the file does not say how many */
    dl_study_limits limits;
    const dl_study_kind *kind;
    void *kind_settings; /* of the kind's table; NULL where it has none */
    char *kind_text;     /* every one of them, as "window=0.5 ..." */
    char *kind_changes;  /* " --set window=0.5 ...": those that the study file sets */
    dl_reference_kind reference;
    dl_precision precision;   /* of an extended reference */
    double reference_seconds; /* CPU time of each of the reference's runs */
    size_t scenes, cases;
    dl_study_scene *scene;
    dl_study_case *cased;
    dl_run_function *run; /* dl_run; a test may put a hanging or crashing one in its place */
};

extern const char *const dl_study_measures[];
extern const char *const *const dl_precision_words; /* by dl_precision */

/* Of the mapping `limits` of a study file. */
extern const dl_parameter_table dl_study_limits_table;

/* Every setting of the kind as "window=0.5 ...", owned by the caller; NULL: no memory. */
char *dl_study_settings_text(const dl_study_kind *kind, const void *settings);

/* Intervals between samples where nobody says. */
long dl_study_samples_of(const dl_study_kind *kind);

void dl_study_run_of_release(dl_study_run_of *run);

/* Reads `cases` into study->cased; the scenes and references are set. */
dl_status dl_study_read_cases(dl_study *study, const dl_yaml *yaml, const dl_yaml_node *cases,
                              dl_error *error);

/* Options of `row` on `scene`: its defaults, then `count` settings; whether the run could start is
 * checked. `line` stands in messages, where it is not 0. */
dl_status dl_study_prepare(const dl_study *study, const dl_study_scene *on,
                           const dl_method_row *row, size_t count, const char *const *key,
                           const char *const *value, const int *line, dl_study_run_of *run,
                           dl_error *error);

/* Row of the method a node names. */
dl_status dl_study_find_method(const dl_yaml *yaml, const dl_yaml_node *map,
                               const dl_method_row **row, dl_error *error);

/* --- identity.c ---------------------------------------------------------------------------- */

uint64_t dl_scene_hash(const dl_scene *scene);
/* Of all that it measures. */
uint64_t dl_study_hash(const dl_study *study);

/* "NAME#HASH method option=value ... end=E samples=S [reference=HASH]"; NULL: no memory. */
char *dl_study_case_key(const dl_study *study, const dl_study_case *cased);
char *dl_study_reference_key(const dl_study *study, const dl_study_scene *on);
/* Hash of all that a reference says, as text; NULL: no memory. */
char *dl_reference_digest(const dl_reference *reference);
/* The `driftlab run` line. */
char *dl_study_case_command(const dl_study *study, const dl_study_case *cased);

/* A formatted text of its own; NULL: no memory. */
char *dl_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

#endif
