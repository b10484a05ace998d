/* What the program measures of itself, in one process: speed on the papers' scenes, what methods
 * cost beyond their forces, GSL's driver beside the methods that step by it, and how long a case
 * takes before its first step. Times are CPU times, but for the wall time of a start.
 *
 * Repeats take turns between the things that are compared; a row has the least and the median. */
#ifndef DL_BENCH_BENCH_H
#define DL_BENCH_BENCH_H

#include <stddef.h>
#include "driftlab/method.h"
#include "driftlab/scene.h"

enum { DL_BENCH_MOST_REPEATS = 51, DL_BENCH_MOST_ROWS = 16 };

typedef struct dl_bench_effort {
    size_t repeats, starts; /* at most DL_BENCH_MOST_REPEATS */
    double seconds;         /* of one measurement */
} dl_bench_effort;

/* Of one thing, repeat by repeat. */
typedef struct dl_bench_times {
    size_t count;
    double value[DL_BENCH_MOST_REPEATS];
} dl_bench_times;

typedef struct dl_bench_spread {
    double minimum, median, maximum;
} dl_bench_spread;

void dl_bench_add(dl_bench_times *times, double value);
/* Of at least one time. */
dl_bench_spread dl_bench_spread_of(const dl_bench_times *times);
/* Of above/below, repeat by repeat. */
dl_bench_spread dl_bench_ratio(const dl_bench_times *above, const dl_bench_times *below);

/* --- scenes ----------------------------------------------------------------------------------- */

typedef struct dl_bench_scenes {
    dl_scene *stream, *swirl, *fluid;  /* of the studies */
    char file[3][4200];                /* theirs */
    dl_scene pair;                     /* two particles that oscillate by the stream's law */
    dl_scene pair_parts, stream_parts; /* the same with the law's attraction as the slow part; what
                                          they point to is that of the others */
} dl_bench_scenes;

/* studies: the folder. Released on failure, too. */
dl_status dl_bench_scenes_read(const char *studies, dl_bench_scenes *scenes, dl_error *error);
void dl_bench_scenes_release(dl_bench_scenes *scenes);

/* --- what is measured ------------------------------------------------------------------------- */

typedef struct dl_bench_speed {
    const char *what, *scene, *unit;
    dl_bench_spread time; /* ns a unit */
    double step;          /* ns of a step, the least; NaN: of a force alone */
    double iterations;    /* of a nonlinear solver, a step; NaN: there is none */
} dl_bench_speed;

dl_status dl_bench_measure_speed(const dl_bench_scenes *scenes, const dl_bench_effort *effort,
                                 dl_bench_speed rows[DL_BENCH_MOST_ROWS], size_t *count,
                                 dl_error *error);

/* A method on a scene, with its options' defaults. A step's forces are counted by their kind (whole
 * accelerations, those of a part, discrete ones) and each kind is timed at the initial state, in
 * the same repeats; what is left of the step are the method, its solver and Jacobians, and the time
 * loop. */
typedef struct dl_bench_overhead {
    const dl_method_row *row;
    const char *scene;
    size_t particles;
    double step;   /* ns, the least */
    double forces; /* evaluations a step */
    double force;  /* ns of all of these, the least */
} dl_bench_overhead;

dl_status dl_bench_measure_overhead(const dl_method_row *row, const dl_scene *scene,
                                    const dl_bench_effort *effort, dl_bench_overhead *result,
                                    dl_error *error);

/* GSL's driver called by hand on the same right-hand side, to the same time by the same tolerances.
 */
typedef struct dl_bench_peer {
    const char *method, *scene;
    double ours, theirs;   /* ns of the method's step, the least; of GSL's in as many */
    dl_bench_spread ratio; /* theirs/ours */
    unsigned long our_evaluations, their_evaluations; /* of forces, to the end */
} dl_bench_peer;

dl_status dl_bench_measure_gsl(const dl_bench_scenes *scenes, const dl_bench_effort *effort,
                               dl_bench_peer rows[DL_BENCH_MOST_ROWS], size_t *count,
                               dl_error *error);

/* This program, run on a scene for one step of leap-frog. */
typedef struct dl_bench_start {
    const char *scene;
    size_t particles;
    dl_bench_spread cpu, wall; /* seconds of the process */
} dl_bench_start;

dl_status dl_bench_measure_starts(const dl_bench_scenes *scenes, const dl_bench_effort *effort,
                                  dl_bench_start rows[DL_BENCH_MOST_ROWS], size_t *count,
                                  dl_error *error);

#endif
