/* What a claim may be computed as: a column of an observable, "density.particles", or one of the
 * quantities here. */
#ifndef DL_STUDY_PAPER_QUANTITY_H
#define DL_STUDY_PAPER_QUANTITY_H

#include "study/paper_plan.h"

/* What a quantity needs to be computed from. */
typedef enum dl_quantity_needs {
    DL_NEEDS_NOTHING,
    DL_NEEDS_FILE,  /* a scene's file, read or not */
    DL_NEEDS_STATE, /* a state, of a scene or a run */
    DL_NEEDS_RUN,   /* a run as a whole */
} dl_quantity_needs;

/* TR299, section 3: temperatures are means over so many steps. */
enum { DL_TEMPERATURE_STEPS = 500 };

/* `state` is open for DL_NEEDS_STATE and DL_NEEDS_RUN. */
typedef dl_status dl_quantity_measure_function(const dl_paper_claim *claim,
                                               const dl_paper_state *state, double *value,
                                               dl_error *error);

typedef struct dl_quantity {
    const char *name, *doc;
    dl_quantity_needs needs;
    dl_quantity_measure_function *measure;
} dl_quantity;

size_t dl_quantity_count(void);
const dl_quantity *dl_quantity_at(size_t index);

/* Index of the quantity, or dl_quantity_count() where it is an observable's column. DL_INPUT where
 * it is neither. */
dl_status dl_quantity_find(const char *name, size_t *index, dl_error *error);

/* Computes the claim's quantity. */
dl_status dl_quantity_measure(const dl_paper_claim *claim, const dl_paper_run_row *runs,
                              const char *folder, double *value, dl_error *error);

/* As dl_quantity_find, of what can be drawn as a curve: one number a state. */
dl_status dl_quantity_find_curve(const char *name, size_t *index, dl_error *error);

/* The claim's quantity, one of those, at every frame of the segment that is open,
 * value [state->frames->count]; the state is that of the last frame then. */
dl_status dl_quantity_measure_frames(const dl_paper_claim *claim, dl_paper_state *state,
                                     double *value, dl_error *error);

/* --- paper_quantity_state.c ------------------------------------------------------------------- */

extern dl_quantity_measure_function dl_measure_refused, dl_measure_particles, dl_measure_mass,
    dl_measure_mass_count, dl_measure_particle_mass, dl_measure_x, dl_measure_y, dl_measure_vx,
    dl_measure_vy, dl_measure_rest_distance, dl_measure_rotation_rows, dl_measure_dark_loss,
    dl_measure_temperature, dl_measure_gas_speed, dl_measure_liquid_speed;

/* Value `block` of the claim's particle: position, then velocity components. */
dl_status dl_component_of(const dl_paper_claim *claim, const dl_scene *scene, const double *y_all,
                          size_t block, double *value, dl_error *error);

/* --- paper_quantity_run.c --------------------------------------------------------------------- */

/* DL_INPUT where the run failed, with how. */
dl_status dl_quantity_check_ended(const dl_paper_state *state, dl_error *error);

extern dl_quantity_measure_function dl_measure_steps, dl_measure_iterations,
    dl_measure_energy_error, dl_measure_largest_vx, dl_measure_revolution, dl_measure_rotation,
    dl_measure_end, dl_measure_reached, dl_measure_subdivision;

/* --- paper_quantity_layers.c ------------------------------------------------------------------ */

extern dl_quantity_measure_function dl_measure_layer_least, dl_measure_layer_most,
    dl_measure_separation_ratio;

/* --- paper_quantity_heights.c ----------------------------------------------------------------- */

extern dl_quantity_measure_function dl_measure_density_trend, dl_measure_density_middle,
    dl_measure_pressure_misfit;

/* --- paper_threshold.c ------------------------------------------------------------------------ */

/* TR299, section 3, Table IV: smallest speed of the scene's first particle, in the direction that
 * it starts in, with which it comes farther than the pair law's first piece reaches from all others
 * (v-gas), or moves upwards until its distance from the fourth is larger than that of the second
 * from the third (v-liquid), before the scene's end. By bisection, to one part in 10000. */
dl_status dl_paper_gas_speed(const dl_scene *scene, double *speed, dl_error *error);
dl_status dl_paper_liquid_speed(const dl_scene *scene, double *speed, dl_error *error);

/* --- paper_rotation.c ------------------------------------------------------------------------- */

/* Angular velocity of the rigid body with the mass, the angular momentum and the moment of inertia
 * of the heaviest group of particles nearer to one another than the pair law's first piece reaches,
 * about its own mass centre. */
dl_status dl_paper_rotation(const dl_scene *scene, const double *y_all, double *rate,
                            dl_error *error);

#endif
