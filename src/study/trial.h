/* One run of a method, watched, in a process of its own, and in a word how it ended. */
#ifndef DL_STUDY_TRIAL_H
#define DL_STUDY_TRIAL_H

#include "study/kind.h"

/* X(symbol, the word, stable: 1, unstable: -1, nothing known: 0) */
#define DL_TRIAL_ENDS(X)                                                                           \
    X(STABLE, "stable", 1)                                                                         \
    X(BLOW_UP, "blow-up", -1)         /* no longer finite, or 100 times the energy scale */        \
    X(ENERGY_GAIN, "energy gain", -1) /* the error passed the bound */                             \
    X(ENERGY_LOSS, "energy loss", -1)                                                              \
    X(TUNNELLING, "tunnelling", -1) /* through a wall, or another particle (passage.h) */          \
    X(HEATING, "heating", -1)       /* what was to stay cold moves */                              \
    X(BENDING, "bending", -1)       /* what was to fly straight does not */                        \
    X(SOLVER, "solver failure", -1)                                                                \
    X(COLLAPSE, "step collapse", -1)                                                               \
    X(CRASH, "crash", -1)      /* its process was ended by a signal */                             \
    X(TIME_OUT, "time-out", 0) /* of the run, or of one of its steps */                            \
    X(REFUSED, "refused", 0)   /* the run could not start */

typedef enum dl_trial_end {
#define DL_TRIAL_ENUM(symbol, word, stable) DL_TRIAL_##symbol,
    DL_TRIAL_ENDS(DL_TRIAL_ENUM)
#undef DL_TRIAL_ENUM
        DL_TRIAL_END_COUNT
} dl_trial_end;

const char *dl_trial_word(dl_trial_end end);
int dl_trial_stability(dl_trial_end end);

/* What is asked of a run. Energies in units of the scene's energy scale. */
typedef struct dl_trial_rule {
    double energy;   /* most |energy error|, what walls and radiation take being booked */
    double cold;     /* most kinetic energy; INFINITY: not asked */
    double straight; /* most distance of a particle from its uniform motion, in units of its path;
                        INFINITY: not asked */
    long looks;      /* most samples of a run; one of fewer steps is looked at after each */
    unsigned long least, most; /* steps of a fixed length: a run ends at the unit's end, but has so
                                  many at least and at most */
} dl_trial_rule;

typedef struct dl_trial {
    dl_trial_end end;
    double held;               /* time up to which the rule held, at the samples */
    double energy_error;       /* largest modulus, in units of the scale; NAN where none is known */
    char why[DL_MESSAGE_SIZE]; /* where and how it ended; "" where it is stable */
    dl_run_summary summary;
} dl_trial;

/* Runs the unit's method with these options to `end`, sampled every `sample`. DL_OK whatever
 * becomes of the run; DL_INTERRUPTED, DL_MEMORY, DL_IO. */
dl_status dl_trial_run(const dl_study_unit *unit, const void *options, double end, double sample,
                       const dl_trial_rule *rule, dl_trial *trial, dl_error *error);

/* The nearest step below or at `step` that the scene's radiation allows: its period is a whole
 * number of them. Any, where there is none. */
double dl_trial_step(const dl_scene *scene, double step);

/* Steps of that length that a run has. */
unsigned long dl_trial_steps(const dl_study_unit *unit, double step, const dl_trial_rule *rule);

/* A run at a fixed step that dl_trial_step has allowed. */
dl_status dl_trial_run_at(const dl_study_unit *unit, double step, const dl_trial_rule *rule,
                          dl_trial *trial, dl_error *error);

/* The unit's options with a fixed step; free with dl_method_options_free. */
dl_status dl_trial_options(const dl_study_unit *unit, double step, void **options, dl_error *error);

#endif
