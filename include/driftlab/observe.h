/* Observables: what a state of a scene looks like, and its average over a trajectory.
 *
 * A state is y_all [2 * dimension * particles], positions then velocities of all particles in scene
 * order (dl_model_expand, dl_sample, a trajectory's frame). Pinned particles act on the others but
 * are no part of the system that is observed: masses, means and counts are over those that move,
 * and values of pinned ones are 0. Masses are inertias. In a periodic box distances are those of
 * the nearest copies; positions are as they are, unwrapped.
 *
 * Nothing here changes a state, and nothing is counted as a method's work. */
#ifndef DRIFTLAB_OBSERVE_H
#define DRIFTLAB_OBSERVE_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/model.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

/* --- the system as a whole -------------------------------------------------------------------- */

/* TR299 (3.6)-(3.12); in three dimensions the rotation is that about the axis through the centre
 * along z, and distances and angles are those from this axis.
 *
 *     centre   rbar = sum m_i r_i / sum m_i,   velocity vbar = sum m_i v_i / sum m_i       (3.6)
 *     v_n,i = (x*_i vx*_i + y*_i vy*_i) / R_i,  v_t,i = (x*_i vy*_i - y*_i vx*_i) / R_i  (3.7-10)
 *     angular_velocity = (sum m_i v_t,i / R_i) / sum m_i                                   (3.12)
 *
 *     rigid_rotation = sum m_i (x*_i vy*_i - y*_i vx*_i) / sum m_i R_i^2
 *
 * where * is relative to the centre and R_i the distance from it (3.11). A particle at the centre
 * itself has no angle: it is left out of (3.12). One near it weighs heavily there, as published: in
 * TR299's Table I, made for an angular velocity of 4, (3.12) is 7.1 because of one particle 0.04
 * from the centre, while rigid_rotation is 5.2. In a periodic box there is no rotation about the
 * centre and both are 0: the heat below is then that of the motion relative to the centre's, and
 * the observable "motion" does not apply. TR299's program divides by 548000 where (3.12)
 * has the total mass, 618000 in its examples: its angular velocity is 618/548 = 1.128 times this
 * one. */
typedef struct dl_motion {
    double mass;
    double centre[3], velocity[3];
    double angular_velocity; /* as published */
    double rigid_rotation;   /* of the rigid body with the same angular momentum */
} dl_motion;

void dl_observe_motion(const dl_scene *scene, const double *y_all, dl_motion *motion);

/* R_i, v_n,i and v_t,i above, each [particles] or NULL. At the centre itself v_n is the speed in
 * the plane and v_t 0. */
void dl_observe_polar(const dl_scene *scene, const double *y_all, const dl_motion *motion,
                      double *radius, double *normal, double *tangential);

/* --- temperature, TR299 (3.4)-(3.6), (3.13) --------------------------------------------------- */

/* Instantaneous, not normalised, temperature [particles]:
 *     T'_i = m_i v_i^2 / 2,   v_i^2 = (v_t,i - angular_velocity R_i)^2 + v_n,i^2 (+ vz*^2 in 3-D)
 */
void dl_observe_heat(const dl_scene *scene, const double *y_all, double *heat);

/* How a temperature is made of T'.
 *
 * published: T'/1e4, mean over the last M = 500 steps (3.5), (3.6). (Printed, the sum has M + 1
 *     terms and is divided by M; here it is a mean.)
 * program: T'/1e3, exponential mean  T <- ((M - 1) T + T'/1e3) / M  at every step, M = 500.
 *
 * Table IV's temperatures are in the program's unit: a particle at its "v-liquid" has, at most,
 * T'/1e4 = 5000 (m = 10000), less than the printed 11370. */
typedef struct dl_temperature_rule {
    const char *name;
    double unit; /* T' is divided by this */
    bool exponential;
} dl_temperature_rule;

extern const dl_temperature_rule dl_temperature_published, dl_temperature_program;

/* Averages over frames that need not be one step apart: a step is scene->step of time, the window
 * (t - M step, t]; the exponential mean forgets the past by (1 - 1/M)^(elapsed time / step). The
 * first frame stands for what was before it. */
typedef struct dl_thermometer dl_thermometer;

/* `steps`: M, from 1 to 100000. */
dl_status dl_thermometer_create(const dl_scene *scene, const dl_temperature_rule *rule,
                                size_t steps, dl_thermometer **thermometer, dl_error *error);
void dl_thermometer_free(dl_thermometer *thermometer);
/* Times must ascend. */
dl_status dl_thermometer_add(dl_thermometer *thermometer, double time, const double *y_all,
                             dl_error *error);
/* [particles]; zeros before the first frame. */
void dl_thermometer_read(const dl_thermometer *thermometer, double *temperature);

/* --- solid, liquid, gas, TR299 Table IV ------------------------------------------------------- */

typedef enum dl_state { DL_SOLID, DL_LIQUID, DL_GAS } dl_state;

/* Speeds and temperatures (in the program's unit) at which a particle of a mass becomes liquid and
 * gas. */
typedef struct dl_state_threshold {
    double mass;
    double v_liquid, v_gas;
    double liquid, gas;
} dl_state_threshold;

/* Masses descending. */
typedef struct dl_state_table {
    const dl_state_threshold *row;
    size_t rows;
} dl_state_table;

extern const dl_state_table dl_tr299_table4;

/* Thresholds at `mass`; between two rows linear in the mass. DL_INPUT outside the table. */
dl_status dl_state_threshold_at(const dl_state_table *table, double mass,
                                dl_state_threshold *threshold, dl_error *error);

/* From the threshold on a particle is in the hotter state. */
dl_state dl_observe_state(const dl_state_threshold *threshold, double temperature);

/* --- escape ----------------------------------------------------------------------------------- */

/* TR299 counts particles that "have escaped" without saying how it tells; this is the definition
 * here, which knows of "escaping subsystems" (Figure 6) too:
 * particles nearer to one another than `link` belong to one group; the group of largest mass is the
 * system. Another group has escaped where it could leave for good, that is where
 *
 *     1/2 mu |V|^2 + sum over pairs of one in each  V_ij  >  0   (mu = M_1 M_2 / (M_1 + M_2)),
 *     R . V > 0   and   |R| > beyond,
 *
 * R, V being its mass centre's position and velocity relative to the system's. */
typedef struct dl_escape_rule {
    double link;   /* > 0; dl_escape_link chooses */
    double beyond; /* >= 0 */
} dl_escape_rule;

typedef struct dl_escape {
    size_t particles; /* that have escaped */
    size_t groups;    /* that hold a moving particle, with the system */
    size_t system;    /* moving particles of the system */
} dl_escape;

/* Where the first piece of the pair law ends (of several laws: the farthest): TR299's D. INFINITY
 * where it does not. */
double dl_escape_link(const dl_scene *scene);

/* Which particles are the system: the group of largest mass. system [particles]; `link` as above.
 */
dl_status dl_observe_system(const dl_scene *scene, const double *y_all, double link, bool *system,
                            dl_error *error);

/* `escaped` [particles] or NULL. */
dl_status dl_observe_escape(dl_model *model, const double *y_all, const dl_escape_rule *rule,
                            bool *escaped, dl_escape *result, dl_error *error);

/* --- heights ---------------------------------------------------------------------------------- */

/* Heights are along the axis that gravity acts along (y without gravity); with several the last. */
size_t dl_height_axis(const dl_scene *scene);

/* Bin k holds heights in [low + k width, low + (k + 1) width). */
typedef struct dl_bins {
    double low, width;
    size_t count;
} dl_bins;

/* Bins that hold heights from `lowest` to `highest`. They begin at the wall below, where there is
 * one, or at a whole number of widths. DL_INPUT where they would be more than a million. */
dl_status dl_bins_create(const dl_scene *scene, double width, double lowest, double highest,
                         dl_bins *bins, dl_error *error);

/* Lowest and highest of the moving particles. */
void dl_observe_heights(const dl_scene *scene, const double *y_all, double *lowest,
                        double *highest);

/* Particles and mass of each bin [bins->count]; either may be NULL. TR323 Table I is the first. */
void dl_observe_density(const dl_scene *scene, const double *y_all, const dl_bins *bins,
                        double *particles, double *mass);

/* Length (area in 3-D) of a level plane: from wall to wall, or a period. NaN where there is none.
 */
double dl_across(const dl_scene *scene);

/* Depth of the fluid above floor_height, in three ways, since TR323's Table II does not say which:
 *     uniform    twice the mean height: exact for a uniform density
 *     most       the height below which 95 % of the particles are
 *     highest    the highest particle */
typedef struct dl_depth {
    double uniform, most, highest;
} dl_depth;

dl_status dl_observe_depth(const dl_scene *scene, const double *y_all, double floor_height,
                           dl_depth *depth, dl_error *error);

/* Pressure at the levels in the middle of the bins (method of planes, B. D. Todd, D. J. Evans and
 * P. J. Daivis, doi:10.1103/PhysRevE.52.1627): force per length (area in 3-D) that what is below a
 * level exerts on what is above it.
 *
 *     interaction = 1/across  sum over pairs (i above, j below) of  F_ij . up
 *     kinetic     = 1/(across width)  sum over particles in the bin of  m_i (v_i . up)^2
 *     weight      = 1/across  sum over particles above the level of their weight
 *
 * In equilibrium the time average of interaction + kinetic is the weight, where the sides are free
 * of friction (walls that damp are not: they take vertical momentum too); at rest interaction is,
 * exactly. `kinetic` is smeared over the bin: in a fluid that lies in layers, a level that no
 * particle crosses has its weight in interaction alone. Each [bins->count]. DL_INPUT where the
 * scene is periodic along the height. */
dl_status dl_observe_pressure(dl_model *model, const double *y_all, const dl_bins *bins,
                              double across, double *interaction, double *kinetic, double *weight,
                              dl_error *error);

/* --- separation ------------------------------------------------------------------------------- */

/* Mean over the particles of the mean distance to the `nearest` nearest others (all of them where
 * there are fewer), pinned ones included. TR323's "mean sep." has no definition; with the 3 nearest
 * the three fluids whose particles it lists have 0.2556, 0.502 and 0.3445 where it prints 0.255,
 * 0.50 and 0.34. NaN for a single particle. */
dl_status dl_observe_separation(const dl_scene *scene, const double *y_all, size_t nearest,
                                double *mean, dl_error *error);

/* --- many observables over many frames -------------------------------------------------------- */

/* What the rows of an observable's table are: the system, its masses (descending), or bins. */
typedef enum dl_observe_rows { DL_ROWS_SYSTEM, DL_ROWS_MASSES, DL_ROWS_BINS } dl_observe_rows;

#define DL_MAX_OBSERVED 8

/* A row of the registry. */
typedef struct dl_observable {
    const char *name, *doc;
    dl_observe_rows rows;
    const char *column[DL_MAX_OBSERVED + 1]; /* ends with NULL */
} dl_observable;

size_t dl_observable_count(void);
const dl_observable *dl_observable_at(size_t index);
/* DL_INPUT with the closest name where there is none. */
dl_status dl_observable_find(const char *name, size_t *index, dl_error *error);

typedef struct dl_observe_options {
    const dl_temperature_rule *temperature;
    size_t temperature_steps; /* M */
    double bin;               /* width; 0: chosen, the first "nice" one that gives <= 13 bins */
    double across;            /* 0: dl_across */
    double link, beyond;      /* of escape; link 0: dl_escape_link */
    bool of_system; /* energy, motion, temperatures and states are those of the system alone,
                     * whatever it is in each frame; TR299's sums go over all particles */
} dl_observe_options;

void dl_observe_options_default(dl_observe_options *options);

/* Means over frames with standard errors from at most 10 batches of consecutive frames: NaN for a
 * single frame, too small where batches are shorter than the memory of the motion. */
typedef struct dl_observation dl_observation;

typedef struct dl_observed {
    const dl_observable *observable;
    size_t rows, columns;
    const double *label;        /* [rows] mass, or the bin's low end; NULL for the system */
    const double *mean, *error; /* [rows][columns] */
    const double *present;      /* [rows][columns]: of the last frame */
} dl_observed;

/* `wanted` [dl_observable_count()]; NULL: all that the scene has. `frames`: how many will be added,
 * with heights from `lowest` to `highest`. DL_INPUT where a wanted one does not apply: why. */
dl_status dl_observation_create(const dl_scene *scene, const dl_observe_options *options,
                                const bool *wanted, size_t frames, double lowest, double highest,
                                dl_observation **observation, dl_error *error);
void dl_observation_free(dl_observation *observation);
dl_status dl_observation_add(dl_observation *observation, double time, const double *y_all,
                             dl_error *error);
/* A frame before the first that is added: temperatures remember it, nothing else does. */
dl_status dl_observation_warm(dl_observation *observation, double time, const double *y_all,
                              dl_error *error);

/* What has been observed, in the order of the registry; *observed belongs to the observation and
 * holds until the next frame. */
size_t dl_observation_count(const dl_observation *observation);
void dl_observation_get(const dl_observation *observation, size_t index, dl_observed *observed);
/* Which particles have escaped, and which are observed, in the last frame: [particles], the
 * observation's. The first is NULL where "escaped" is not observed, the second where all are. */
const bool *dl_observation_escaped(const dl_observation *observation);
const bool *dl_observation_system(const dl_observation *observation);
/* Width of the bins. */
double dl_observation_bin(const dl_observation *observation);

#endif
