/* What the kind `drift` is made of: the same run at several steps (or tolerances), a run forward
 * and back, and what is judged of them. Errors are in units of the scene's scales: energy scale,
 * sums of the moduli of the particles' momenta and angular momenta. */
#ifndef DL_STUDY_DRIFT_H
#define DL_STUDY_DRIFT_H

#include "observe/series.h"
#include "study/kind.h"

typedef struct dl_drift_settings {
    double allow;    /* change of the energy by its drift over the run; 0: its fluctuation */
    long levels;     /* runs, each with half the step or a tenth of the tolerance */
    double slack;    /* of the order, as a part of it */
    double reversal; /* time that is run forward and back; 0: chosen */
} dl_drift_settings;

/* What a run may set to be finer: `step` where it has one > 0, the tolerances else. */
typedef struct dl_drift_knob {
    bool adaptive;
    double size; /* the step, or rtol */
} dl_drift_knob;

dl_drift_knob dl_drift_knob_of(const dl_method_row *row, const void *options);

/* The value of a real option; NAN where the method has none of that name. */
double dl_drift_option(const dl_method_row *row, const void *options, const char *name);

/* One run. */
typedef struct dl_drift_run {
    double size; /* its step or rtol */
    dl_run_summary summary;
    size_t n, room; /* samples at whole numbers of intervals, the start with them */
    double *time, *energy, *momentum, *angular; /* [room]; momenta NAN where they do not apply */
    /* By what roundoff is larger where a scene moves fast as a whole: the unknowns' energies, each
     * rounded on its own, against the energy scale. >= 1; NAN where nothing was run. */
    double excess;
} dl_drift_run;

/* Interval of the samples: `sample` of the unit, but whole steps. */
double dl_drift_interval(const dl_study_unit *unit, const dl_drift_knob *knob);

/* A method that chooses its steps stops at samples: where they are so many that they, not the
 * tolerance, would choose the steps, the interval is made longer. Counted in a run without any. */
dl_status dl_drift_widen_interval(const dl_study_unit *unit, double *interval, dl_error *error);

/* The unit's run at level `level` (0: as given). DL_OK whatever becomes of it, see its summary;
 * also where it could not start: then its status is DL_INPUT. Release in any case. */
dl_status dl_drift_run_level(const dl_study_unit *unit, const dl_drift_knob *knob, double interval,
                             int level, dl_drift_run *run, dl_error *error);
void dl_drift_run_release(dl_drift_run *run);

/* Error that roundoff alone may have made, in units of the scale, by as many operations as the run
 * had forces, if it adds up like a random walk. Of momenta the excess of the energy counts by its
 * root. */
double dl_drift_roundoff(const dl_drift_run *run);
double dl_drift_momentum_roundoff(const dl_drift_run *run);

/* How many times coarser than roundoff a method's own solver is told to be (option `tolerance`); 1
 * where it is not, or there is none. */
double dl_drift_solved_to(const dl_method_row *row, const void *options);

/* --- forward and back --------------------------------------------------------------------------
 */

typedef struct dl_reversal {
    double time;      /* run forward, and back; NAN: it was not */
    double distance;  /* RMS of the particles' from where they started, a length */
    double explained; /* what roundoff may have made of it, by the growth of a small displacement
                         over the way back */
    char why[128];    /* why it was not, or "" */
} dl_reversal;

/* Tries shorter times where walls are hit or the motion is so chaotic that roundoff hides all. */
dl_status dl_drift_reverse(const dl_study_unit *unit, const dl_drift_knob *knob,
                           dl_reversal *reversal, dl_error *error);

/* --- judgement ---------------------------------------------------------------------------------
 */

/* A conserved quantity over a run. */
typedef struct dl_drift {
    dl_line line;         /* per sample */
    dl_interval per_time; /* its slope */
    dl_interval change;   /* over the run */
    double largest;       /* error */
    double growth;        /* of the fluctuation with time (dl_series_growth) */
} dl_drift;

typedef struct dl_drift_study {
    const dl_study_unit *unit;
    dl_drift_knob knob;
    double interval;       /* of the samples */
    size_t levels, usable; /* runs; those from the first on that ended well, above roundoff */
    dl_drift_run run[DL_MOST_LEVELS];
    dl_drift energy[DL_MOST_LEVELS], momentum, angular;
    dl_orders orders; /* of the usable ones, where there are two */
    dl_reversal reversal;
} dl_drift_study;

/* Lines and orders from the runs. */
dl_status dl_drift_fit(dl_drift_study *study, dl_error *error);

/* Verdict and reason. */
dl_status dl_drift_judge(const dl_drift_study *study, dl_finding *finding, dl_error *error);

#endif
