/* Runs of one method on one scene, and evaluations of one force, as often as a measurement is to
 * take. */
#ifndef DL_BENCH_RUNS_H
#define DL_BENCH_RUNS_H

#include "bench/bench.h"
#include "driftlab/run.h"

typedef struct dl_bench_runs {
    const dl_scene *scene;
    const dl_method_row *row;
    void *options;
    double end;             /* of a run */
    size_t runs;            /* a measurement */
    dl_run_summary summary; /* of the last */
} dl_bench_runs;

/* Chooses end and runs so that a measurement takes about `seconds`, and does one. A run has no more
 * steps than the scene; released on failure, too. */
dl_status dl_bench_runs_create(const dl_method_row *row, const dl_scene *scene, double seconds,
                               dl_bench_runs *runs, dl_error *error);
void dl_bench_runs_release(dl_bench_runs *runs);
/* *nanoseconds: of one step. */
dl_status dl_bench_runs_measure(dl_bench_runs *runs, double *nanoseconds, dl_error *error);

/* One force, at the scene's initial state. */
typedef enum dl_bench_force {
    DL_BENCH_WHOLE,
    DL_BENCH_DISCRETE, /* to the state that one step of the scene's length leads to */
    DL_BENCH_FAST,
    DL_BENCH_SLOW,
    DL_BENCH_FORCES,
} dl_bench_force;

typedef struct dl_bench_forces {
    dl_model *model; /* of the caller */
    dl_bench_force which;
    double *q, *delta, *a; /* [2 unknowns], [unknowns], [unknowns] */
    size_t calls;          /* a measurement */
} dl_bench_forces;

/* As above. The model's mean and parts must be ready. */
dl_status dl_bench_forces_create(dl_model *model, dl_bench_force which, double seconds,
                                 dl_bench_forces *forces, dl_error *error);
void dl_bench_forces_release(dl_bench_forces *forces);
/* *nanoseconds: of one evaluation. */
dl_status dl_bench_forces_measure(dl_bench_forces *forces, double *nanoseconds, dl_error *error);

#endif
