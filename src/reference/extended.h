/* Trajectories in extended precision: what references are made of.
 *
 * The same scene, the same model, the same events as in the double time loop, but for what follows
 * from steps: walls by the rule `mirror` act after a step, whose length the motion depends on. What
 * they tend to as steps become short is the rule `located`, resting contacts included, and that is
 * what is computed here; the difference is the mirror's error, of first order in the step.
 *
 * Radiation is at its times, with the velocities there (leap-frog's are those of half a step
 * before). */
#ifndef DL_REFERENCE_EXTENDED_H
#define DL_REFERENCE_EXTENDED_H

#include <stddef.h>
#include "driftlab/scene.h"
#include "driftlab/status.h"

typedef enum dl_extended_method {
    DL_TAYLOR, /* Taylor series by recurrences, order and step by A. Jorba and M. Zou, Exp. Math. 14
                * (2005) 99-117, doi:10.1080/10586458.2005.10128904 */
    DL_GAUSS,  /* Gauss-Legendre collocation for q'' = a(q) (E. Hairer, C. Lubich, G. Wanner,
                * Geometric Numerical Integration, II.1.3), its equations solved by iteration */
} dl_extended_method;

typedef struct dl_extended_limits {
    double seconds;                /* CPU time; 0: none -> DL_TIMEOUT */
    const volatile int *interrupt; /* non-zero: DL_INTERRUPTED. May be NULL */
    double began;                  /* dl_cpu_clock at the start */
} dl_extended_limits;

typedef struct dl_extended_setup {
    dl_extended_method method;
    double tolerance; /* of a step, relative; in units of the precision's epsilon */
    double stride;    /* longest step, in units of what usually lies between events; 0: 2 */
    dl_extended_limits limits;
} dl_extended_setup;

typedef struct dl_extended_counts {
    unsigned long steps, crossings, hits, contacts, releases;
} dl_extended_counts;

typedef struct dl_extended_walk dl_extended_walk;

/* One number type. */
typedef struct dl_extended_ops {
    const char *name; /* "long double", "quad" */
    double epsilon;
    dl_status (*create)(const dl_scene *scene, const dl_extended_setup *setup,
                        dl_extended_walk **made, dl_error *error);
    /* To time t, through the radiation that is due at or before it. DL_STEP_FAILURE where steps or
     * events accumulate, DL_UNSTABLE where a number is no longer finite. */
    dl_status (*advance)(dl_extended_walk *walk, double t, dl_error *error);
    /* Positions and velocities of all particles in scene order, [2 * dimension * particles]: the
     * number is high + low, to 106 bits. */
    void (*state)(const dl_extended_walk *walk, double *high, double *low);
    /* Puts `walk` at a distance from `base`, at the same time, in the direction in which it is, or
     * in that of `direction` [2 * unknowns of all particles, scene order] where that is not NULL.
     * Returns the distance at which it was, in units of `distance`. Lengths count in units of
     * `length`, velocities of `speed`. */
    double (*separate)(dl_extended_walk *walk, const dl_extended_walk *base,
                       const double *direction, double distance, double length, double speed);
    dl_extended_counts (*counts)(const dl_extended_walk *walk);
    void (*destroy)(dl_extended_walk *walk);
} dl_extended_ops;

extern const dl_extended_ops dl_extended_long_double, dl_extended_quad;

#endif
