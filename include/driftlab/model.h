/* The model: a scene posed as the second-order system  q'' = a(q)  for the particles that move.
 *
 * State: one block  y = q | v  of 2 * unknowns doubles; q = x|y|[z] of the moving particles, in
 * the order of the scene (a pinned particle is a parameter, not an unknown). Only the terms that
 * the scene has exist in the model: kernel, gravity and walls are chosen once, at creation.
 *
 *     a_i = (1/inertia_i) sum_j F_ij + g_i,     F_ij = coupling_i coupling_j F(r_ij) (r_i-r_j)/r_ij
 *
 * A model is used by one thread at a time and does not outlive its scene. */
#ifndef DRIFTLAB_MODEL_H
#define DRIFTLAB_MODEL_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/scene.h"
#include "driftlab/status.h"

/* Work done, counted where it is done: leap-frog and the splittings have no force to evaluate where
 * none acts or gravity alone does. */
typedef struct dl_counts {
    unsigned long force;           /* accelerations, discrete ones included */
    unsigned long jacobian;        /* matrices of d a / d q, discrete ones included */
    unsigned long jacobian_vector; /* products with d a / d q */
} dl_counts;

typedef struct dl_energy {
    double kinetic, pair, gravity, total;
} dl_energy;

/* Compressed sparse columns of an unknowns x unknowns matrix with a symmetric pattern. */
typedef struct dl_sparsity {
    size_t columns, nonzeros;
    const long *column_start; /* [columns + 1] */
    const long *row;          /* [nonzeros], ascending within a column */
    unsigned long generation; /* changes whenever the pattern does */
} dl_sparsity;

/* What the mean acceleration over a step from q to q + delta is: the choice that tells the schemes
 * of one family apart (model/discrete.c). */
typedef enum dl_mean {
    DL_MEAN_QUOTIENT, /* difference quotients of the pairs' potentials, TR171 (2.4) */
    DL_MEAN_GONZALEZ, /* at the middle, corrected along delta: doi:10.1007/BF02440162 */
    DL_MEAN_AVERAGE,  /* average along delta: doi:10.1088/1751-8113/41/4/045206 */
    DL_MEAN_MIDPOINT, /* at the middle */
} dl_mean;

typedef struct dl_kernel dl_kernel;
typedef struct dl_model dl_model;

struct dl_model {
    const dl_scene *scene;
    int dimension;
    size_t particles; /* all */
    size_t moving;    /* without the pinned ones */
    size_t unknowns;  /* dimension * moving */
    bool has_walls;
    bool has_periods;
    bool has_radiation;
    bool has_gravity;
    bool has_pins;
    bool has_force;  /* pair forces or gravity; without, accelerations are 0 wherever particles are:
                      * methods may leave them out, and what is not evaluated is not counted */
    bool is_uniform; /* gravity alone, on all that move, and nothing rests on walls: accelerations
                      * are scene->gravity; the same holds */
    bool locates_hits;      /* on walls, and */
    bool locates_crossings; /* of breakpoints: steps begin and end at any time */
    dl_mean mean;
    dl_counts counts;
    dl_kernel *kernel;
    struct dl_model_private *priv;
    /* [unknowns] of the caller: coordinates that rest on a wall; their accelerations, discrete ones
     * and rows of Jacobians are 0. NULL: nothing does, and nothing is looked at. */
    const bool *held;
    /* Of the caller: pairs that go by given pieces of their law wherever they are (model/locks.h),
     * in accelerations, discrete ones and Jacobians. NULL: none do, and nothing is looked at. */
    const struct dl_locks *locks;
    /* The accelerations in use. Set at creation; a test may put failing ones in their place. */
    dl_status (*acceleration)(dl_model *model, const double *q, double *a, dl_error *error);
    dl_status (*discrete_acceleration)(dl_model *model, const double *q, const double *delta,
                                       double *a, dl_error *error);
    dl_status (*part_acceleration)(dl_model *model, dl_part part, const double *q, double *a,
                                   dl_error *error);
};

dl_status dl_model_create(const dl_scene *scene, dl_model **model, dl_error *error);
void dl_model_free(dl_model *model);

/* The scene's initial state, y [2 * unknowns]. */
void dl_model_initial_state(const dl_model *model, double *y);

/* Positions and velocities of all particles in scene order, y_all [2 * dimension * particles];
 * pinned particles at their place with velocity 0. */
void dl_model_expand(const dl_model *model, const double *y, double *y_all);

/* a(q). DL_UNSTABLE, with the first particle's row, where a component is not finite (positions
 * coincide or have blown up). Counted. */
dl_status dl_model_acceleration(dl_model *model, const double *q, double *a, dl_error *error);

/* y' = (v, a(q)); y and ydot [2 * unknowns] must not overlap. */
dl_status dl_model_rhs(dl_model *model, const double *y, double *ydot, dl_error *error);

/* Makes the two parts of the force ready, each with a kernel of its own reach; what has been made
 * is kept. DL_INPUT, telling what a scene would have to say, where one of them is empty. */
dl_status dl_model_split(dl_model *model, dl_error *error);

/* The acceleration of one part, once dl_model_split has succeeded; those of both add up to the
 * whole but for roundoff. Counted as a force, whichever part it is. */
dl_status dl_model_part_acceleration(dl_model *model, dl_part part, const double *q, double *a,
                                     dl_error *error);

/* The part as a model, for its Jacobian; it belongs to `model`, where its work is counted. To be
 * asked for before each use: what is held on walls may have changed. */
dl_model *dl_model_part(dl_model *model, dl_part part);

/* Pattern of d a / d q that is valid at q (and, for the discrete gradient, from q to q + delta
 * where delta is not NULL). It belongs to the model and holds until the next call; `generation`
 * tells whether it has changed. */
dl_status dl_model_sparsity(dl_model *model, const double *q, const double *delta,
                            const dl_sparsity **sparsity, dl_error *error);

/* values[k] = (d a_row / d q_column) for the pattern that dl_model_sparsity gave last. */
dl_status dl_model_jacobian(dl_model *model, const double *q, double *values, dl_error *error);

/* out = (d a / d q)(q) u. */
dl_status dl_model_jacobian_vector(dl_model *model, const double *q, const double *u, double *out,
                                   dl_error *error);

/* Which mean the discrete functions below stand for; DL_MEAN_QUOTIENT before. DL_INPUT for a mean
 * whose work is the change of potential where a tree sums the forces. */
dl_status dl_model_set_mean(dl_model *model, dl_mean mean, dl_error *error);

/* Mean acceleration over the step from q to q + delta. Its work  sum inertia_i a_i . delta_i  is
 * exactly minus the change of potential energy, but for DL_MEAN_MIDPOINT. Counted as the forces it
 * takes: 2 for DL_MEAN_GONZALEZ, else 1. */
dl_status dl_model_discrete_acceleration(dl_model *model, const double *q, const double *delta,
                                         double *a, dl_error *error);

/* values[k] = d (discrete acceleration)_row / d delta_column, pattern as for the Jacobian. Left out
 * for DL_MEAN_GONZALEZ: its correction, which couples everything with everything. */
dl_status dl_model_discrete_jacobian(dl_model *model, const double *q, const double *delta,
                                     double *values, dl_error *error);

/* Products with that derivative, the whole of it, without a matrix: prepared at q and delta, then
 * out = (d a / d delta) u; u and out must not overlap. Nearly the derivative for DL_MEAN_GONZALEZ
 * where a pair passes a jump of its force. */
dl_status dl_model_discrete_product_prepare(dl_model *model, const double *q, const double *delta,
                                            dl_error *error);
void dl_model_discrete_product(dl_model *model, const double *u, double *out);
/* Frees what was prepared. */
void dl_model_discrete_product_forget(dl_model *model);
/* The prepared derivative's blocks on the diagonal: by particle, row and column,
 * block [moving * dimension * dimension]. */
void dl_model_discrete_diagonal(const dl_model *model, double *block);

/* Whether the force of any pair that can act jumps at a breakpoint. */
bool dl_model_any_jumps(const dl_model *model);

/* Pairs that cross a breakpoint where the force jumps (model/crossings.c). dl_model_crossings_begin
 * finds those of the step from q to about q + delta, of length h: none where no force jumps, or
 * where the mean is not one of pairs. dl_model_crossings_settle takes an iterate delta and its
 * image h v + (h^2/2) a, a that of q + delta, and makes image and a those in which these pairs have
 * the force of the image itself. */
dl_status dl_model_crossings_begin(dl_model *model, const double *q, const double *delta, double h,
                                   dl_error *error);
bool dl_model_crossings_any(const dl_model *model);
void dl_model_crossings_settle(dl_model *model, const double *delta, double *image, double *a);

/* Neighbour lists built so far, by observation too; 0 where the kernel has none. */
unsigned long dl_model_list_builds(const dl_model *model);

/* How far a kernel's forces lie from direct sums over all pairs that act, in parts of the sum of
 * the moduli of a particle's pair forces: largest and mean over a sample spread evenly over the
 * particles that move. NaN where the kernel sums all pairs, exactly but for roundoff. */
typedef struct dl_force_error {
    double stated, largest, mean;
    size_t sampled;
} dl_force_error;

/* Whether the kernel states an error: a tree does. */
bool dl_model_has_force_error(const dl_model *model);

/* At q. Costs a force and the pairs of the sample; not counted. */
dl_status dl_model_force_error(dl_model *model, const double *q, dl_force_error *result,
                               dl_error *error);

/* Observation: not counted as work of a method. */
dl_status dl_model_energy(dl_model *model, const double *y, dl_energy *energy, dl_error *error);

/* Energies at y1 minus those at y0, without the cancellation of the totals: of what differs alone.
 * Costs a discrete force where positions differ, and nothing of pairs where velocities alone do. A
 * tree's potentials are subtracted, with its error. */
dl_status dl_model_energy_change(dl_model *model, const double *y0, const double *y1,
                                 dl_energy *change, dl_error *error);
/* The total energy's derivative, (-inertia a(q), inertia v) [2 * unknowns]. Counted as a force. */
dl_status dl_model_energy_gradient(dl_model *model, const double *y, double *gradient,
                                   dl_error *error);

/* Kinetic energy (in the centre-of-mass frame where the scene is Galilean-invariant) plus the sum
 * of the moduli of the potential terms. > 0; 1 where everything vanishes. */
dl_status dl_model_energy_scale(dl_model *model, const double *y, double *scale, dl_error *error);

/* Linear momentum [3] and angular momentum [3] (z alone in two dimensions), about the centre of
 * mass and relative to its motion where the scene is Galilean-invariant, about the origin
 * elsewhere. */
void dl_model_momentum(const dl_model *model, const double *y, double linear[3], double angular[3]);

/* Momenta at y1 minus those at y0, of what differs alone. angular [3] or NULL; where the scene is
 * Galilean-invariant it is for states of the same positions. */
void dl_model_momentum_change(const dl_model *model, const double *y0, const double *y1,
                              double linear[3], double *angular);

/* Sums of the moduli of the particles' momenta and angular momenta: what errors are measured by. */
void dl_model_momentum_scales(const dl_model *model, const double *y, double *linear,
                              double *angular);

/* Sum of the inertias of the moving particles. */
double dl_model_inertia(const dl_model *model);

/* Sum over the moving particles of  inertia_i a_i . b_i;  a, b [unknowns]. */
double dl_model_work(const dl_model *model, const double *a, const double *b);

/* Takes from accelerations [unknowns] what they give to the mass centre: the roundoff of their sum
 * where only pairs act. */
void dl_model_rest_centre(const dl_model *model, double *a);

/* Rate at which gravity changes the linear momentum, [3]. */
void dl_model_gravity_force(const dl_model *model, double force[3]);

/* Which momenta the exact flow conserves, walls and gravity's known impulse booked. */
bool dl_model_conserves_linear_momentum(const dl_model *model);
bool dl_model_conserves_angular_momentum(const dl_model *model);

/* No walls, no pins: the solution looks the same from a frame in uniform motion. */
bool dl_model_is_galilean_invariant(const dl_model *model);

/* Wall rule `mirror` (TR323, section III, in the order of its program: high x, low x, then the
 * next axis): reflects the position, multiplies every velocity component by 1 - damping and
 * reverses the normal one. Returns the number of hits. Cheap where nothing is outside. */
size_t dl_model_mirror(const dl_model *model, double *q, double *v);

/* Radiation, TR299 (3.14), at positions q: multiplies the velocities of the outer particles
 * (model/radiation.c says which those are) and returns how many they are. For leap-frog v are the
 * half-step velocities, as in TR299's program, which radiates after it has moved the particles. */
size_t dl_model_radiate(dl_model *model, const double *q, double *v);

/* Whether any particle is outside the walls (so that dl_model_mirror would change the state). */
bool dl_model_outside(const dl_model *model, const double *q);

#endif
