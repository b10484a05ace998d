/* The one time loop: scene x method x options -> a summary and samples. */
#ifndef DRIFTLAB_RUN_H
#define DRIFTLAB_RUN_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/method.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

/* A sample: taken at a step of the method's own, at a time that is a whole number of sample
 * intervals (and at the start and the end). */
typedef struct dl_sample {
    size_t index;       /* 0 at the start */
    unsigned long step; /* steps the method has taken */
    double time;
    dl_energy energy;
    double ledger;         /* energy that walls and radiation have taken so far */
    double energy_error;   /* total + ledger - total at the start */
    double momentum_error; /* |P - P0 - the impulses of gravity, walls, radiation|; NaN: n/a */
    double angular_momentum_error; /* NaN where the scene does not conserve it */
    const double *y_all;           /* [2 * dimension * particles], scene order; for this call */
} dl_sample;

typedef struct dl_run_options {
    double end;          /* 0: the scene's */
    double sample;       /* 0: the scene's, or else chosen: at most 50 intervals of whole steps */
    double time_limit;   /* CPU seconds, observation included; 0: none -> DL_TIMEOUT */
    bool observe;        /* false: integrate only; no samples, ledger or errors (for timing) */
    bool ledger;         /* false: jumps are not booked; errors are NaN after the first */
    double energy_bound; /* |energy_error| / scale above which the run is DL_UNSTABLE; 0: 100 */
    /* Called at each sample; a failure ends the run with it. May be NULL. */
    dl_status (*on_sample)(void *context, const dl_sample *sample, dl_error *error);
    void *context;
    /* Called now and then with the fraction done and CPU seconds. May be NULL. */
    void (*on_progress)(void *context, double fraction, double seconds);
    void *progress_context;
    const volatile int *interrupt; /* non-zero: stop, DL_INTERRUPTED. May be NULL */
} dl_run_options;

/* What `driftlab run --json` prints and a study stores. Reals that do not apply are NaN and are
 * printed as null. */
typedef struct dl_run_summary {
    dl_status status;
    char message[DL_MESSAGE_SIZE];
    char choice[DL_MESSAGE_SIZE]; /* what the method has chosen by itself, and why; "": nothing */
    double t_end_reached;
    double step; /* fixed step; 0 for an adaptive run */
    unsigned long steps, rejected_steps;
    unsigned long force_evaluations, jacobian_evaluations, jacobian_vector_products;
    unsigned long nonlinear_iterations, linear_iterations, factorisations;
    unsigned long inexact_steps, rescued_steps; /* dl_method_stats says which these are */
    unsigned long neighbour_list_builds, wall_hits;
    unsigned long contacts, releases; /* of particles that rest on located walls */
    unsigned long crossings;          /* of breakpoints, that were located */
    double cpu_seconds;               /* of the integration alone: observation is not in it */
    double energy_initial, energy_final, energy_scale;
    double energy_error_max, energy_error_final; /* absolute, ledger included; over the samples */
    double ledger;
    double momentum_error_max, angular_momentum_error_max;
    double momentum_scale, angular_momentum_scale; /* sum of the moduli of the terms at the start */
    double kinetic_energy_per_particle;            /* at the end */
    /* of a kernel that is not exact, driftlab/model.h: the larger of those at the start and at the
     * end; NaN where it is exact or nothing is observed */
    double force_error_stated, force_error_max, force_error_mean;
    size_t samples;
} dl_run_summary;

/* Nothing done yet: counts 0, reals NaN. */
void dl_run_summary_clear(dl_run_summary *summary);

void dl_run_options_default(dl_run_options *options);

/* Runs. Returns DL_OK whenever the integration was started and the summary tells its story (which
 * may be a failure of the method); another status where it could not start (DL_INPUT: a sample time
 * or an end that is not a whole number of steps ...). `y_final` [2 * dimension * particles] or
 * NULL. */
dl_status dl_run(const dl_scene *scene, const dl_method_row *row, const void *options,
                 const dl_run_options *run_options, dl_run_summary *summary, double *y_final,
                 dl_error *error);

#endif
