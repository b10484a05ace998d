/* A scene: one validated, immutable particle system as an initial-value problem.
 *
 * Units are the scene's own (CGS in TR323, dimensionless elsewhere); names below give dimensions.
 * Arrays hold one component after the other: x of every particle, then y, then z in three
 * dimensions. Particles keep the order of the file. */
#ifndef DRIFTLAB_SCENE_H
#define DRIFTLAB_SCENE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include "driftlab/status.h"

#define DL_MAX_TERMS  4
#define DL_MAX_PIECES 4

/* One power of the radial force: coefficient * r^(-power). */
typedef struct dl_term {
    double coefficient;
    double power;
} dl_term;

/* What becomes of a piece's force F at its end, where the next piece's, N, takes over (N = 0 beyond
 * the last). The potential is the integral of the force in every case. */
typedef enum dl_piece_end {
    DL_END_HARD,          /* F jumps to N, as in the papers */
    DL_END_SHIFTED_FORCE, /* F(r) - (F(until) - N(until)): continuous, with a kink */
    DL_END_TAPER, /* S F + (1 - S) N over the last `width`: twice continuously differentiable,
                   * S = 1 - 10 u^3 + 15 u^4 - 6 u^5, u = (r - until + width)/width */
} dl_piece_end;

/* What methods that split the force treat apart: the fast part implicitly or by short steps, the
 * slow part explicitly or by long ones. Uniform gravity is slow. */
typedef enum dl_part { DL_PART_FAST, DL_PART_SLOW } dl_part;

/* Force on (previous until, until]; `until` is INFINITY where the piece never ends. */
typedef struct dl_piece {
    double until;
    int terms;
    dl_term term[DL_MAX_TERMS];
    dl_part part[DL_MAX_TERMS]; /* that each term belongs to */
    dl_piece_end end;
    double width; /* of a taper, less than the piece is long */
    bool located; /* of a hard or shifted end: pairs that cross it are stopped there */
} dl_piece;

/* Radial force of the pair (i, j), positive where it repels:
 *     F(r) = coupling_i coupling_j sum_s coefficient_s r^(-power_s)
 * on the piece r lies in and zero beyond the last one: (3.5) of TR323 with its cutoff r0, (2.5) of
 * TR299 with its switch at D, the continuous limit of (2.4) of TR171. No pieces: no pair force. */
typedef struct dl_pair_law {
    int pieces;
    dl_piece piece[DL_MAX_PIECES];
} dl_pair_law;

typedef enum dl_wall_rule {
    DL_MIRROR,  /* after a step, by reflection: the papers' */
    DL_LOCATED, /* at the time of the hit, with resting contacts (study/located.h) */
} dl_wall_rule;

/* Planes normal to the axes. low/high are -INFINITY/INFINITY where there is no wall. */
typedef struct dl_walls {
    bool present;
    double low[3], high[3];
    double damping;       /* d: both velocity components are multiplied by 1 - d at a hit */
    double zero_vx_below; /* |v_x| below this becomes 0 after a hit (TR323's program: 1e-10) */
    dl_wall_rule rule;
    double rest; /* located: a flight shorter than this part of the time step is the last; 0: none
                  * is but for roundoff */
} dl_walls;

typedef enum dl_radiation_frame { DL_FRAME_LAB, DL_FRAME_CENTRE } dl_radiation_frame;

/* Radiation, TR299 (3.14): at every whole number of periods the velocities of outer particles are
 * multiplied by factor_above where y >= that of the mass centre, by factor_below elsewhere. */
typedef struct dl_radiation {
    bool present;
    double period; /* time; a whole number of steps */
    bool boundary; /* outer particles are those of the boundary, not those beyond a distance */
    double beyond; /* from the mass centre; without `boundary` */
    double reach, opening; /* with `boundary`: radius of the sector, its opening in degrees */
    double factor_above, factor_below;
    dl_radiation_frame frame; /* which velocity: as it is, or relative to the mass centre's */
} dl_radiation;

/* Periodic box: along an axis with length > 0 a particle has copies at every whole number of
 * lengths from it, and acts by the nearest one. Positions are free to leave [low, low + length): a
 * trajectory is never wrapped. */
typedef struct dl_periods {
    bool present;
    double low[3], length[3]; /* length 0: no period along this axis */
} dl_periods;

typedef enum dl_kernel_choice {
    DL_KERNEL_AUTO,
    DL_KERNEL_REFERENCE,
    DL_KERNEL_ALL_PAIRS,
    DL_KERNEL_NEIGHBOUR_LIST,
    DL_KERNEL_TREE,
} dl_kernel_choice;

/* Error of the tree's forces where the scene states none (model.h, dl_force_error). */
#define DL_TREE_ERROR 1e-6

/* Arrays that a model is to have although every number in them is neutral, and powers that it is to
 * take as real ones: what leaving them out saves is measured so (driftlab/leave_outs.h). */
enum {
    DL_KEEP_INERTIA = 1 << 0,
    DL_KEEP_COUPLING = 1 << 1,
    DL_KEEP_GRAVITY_MASK = 1 << 2,
    DL_KEEP_PINS = 1 << 3, /* the blocks of all particles beside those of the moving ones */
    DL_KEEP_REAL_POWERS = 1 << 4,
};

/* A number by name, which values of the file stand for as $NAME. */
typedef struct dl_named_number {
    char name[32];
    double value;
} dl_named_number;

typedef struct dl_scene {
    char *name, *source, *file; /* `file`: path it was read from */
    char *text;                 /* the scene file's text, for the results' metadata: with other
                                 * numbers in `let`, where these were set */
    size_t lets;
    dl_named_number *let; /* [lets]: the file's `let`, in its order */
    char *start;          /* file of the trajectory that it starts from; NULL: it does not */
    int dimension;        /* 2 or 3 */
    size_t particles;
    double *position, *velocity; /* [dimension * particles] */
    double *inertia;             /* [particles], > 0 */
    double *coupling;            /* [particles], >= 0, as declared: no law need use them */
    bool *feels_gravity;         /* [particles] */
    bool *pinned;                /* [particles] */
    dl_pair_law law;             /* of all pairs; no pieces where the species tell */
    size_t species;              /* 0: `law` is that of all pairs */
    char **species_name;         /* [species] */
    dl_pair_law *species_law;    /* [species * species], symmetric; no pieces: no force */
    int *species_of;             /* [particles]; NULL without species */
    dl_periods periods;
    double gravity[3]; /* uniform acceleration */
    dl_walls walls;
    dl_radiation radiation;
    double step;                            /* default Delta t of fixed-step methods */
    double end;                             /* integration runs from t = 0 to here */
    double sample;                          /* time between samples; 0: chosen by the run */
    int end_line, sample_line, period_line; /* of `file`: of `end`, `sample`, radiation's period */
    dl_kernel_choice kernel;
    double skin;       /* of the neighbour list, a length; 0: chosen */
    double tree_error; /* of the tree's forces; 0: DL_TREE_ERROR */
    unsigned keep;     /* DL_KEEP_*; no file says it, 0 */
} dl_scene;

/* Reads and validates a scene. Paths in it are relative to the scene's own folder. On failure
 * *scene is NULL and the message names file, line, key, value and what was expected (DL_INPUT), or
 * the rows that cause it. */
dl_status dl_scene_read(const char *path, dl_scene **scene, dl_error *error);

/* What `let` is to say in the place of what the file says: a number, as text. */
typedef struct dl_let {
    const char *name, *value;
} dl_let;

/* The same with other numbers in `let`. The scene is then called NAME(a=1,b=2). DL_INPUT names what
 * the file's `let` lacks. */
dl_status dl_scene_read_let(const char *path, size_t count, const dl_let *let, dl_scene **scene,
                            dl_error *error);

void dl_scene_free(dl_scene *scene);

/* `driftlab help scene`: every key, from the tables the reader uses. */
void dl_scene_help(FILE *out);

/* Steps of a run, and samples, at the most: doubles count them exactly. */
#define DL_MOST_STEPS 9007199254740992.0 /* 2^53 */

/* Whole number of steps in `time`, or 0 where it is not one to 1e-9 relative, or above
 * DL_MOST_STEPS. */
size_t dl_whole_steps(double time, double step);

#endif
