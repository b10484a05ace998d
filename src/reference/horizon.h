/* What the trajectories of a reference say of its own error and of how far it holds. */
#ifndef DL_REFERENCE_HORIZON_H
#define DL_REFERENCE_HORIZON_H

#include "driftlab/reference.h"

/* Mean distance to the nearest neighbour at the start; of one particle alone the distance between
 * walls, or that from the origin, or 1. */
dl_status dl_reference_length(const dl_scene *scene, double *length, dl_error *error);

/* Raises sample_error to twice the distance of a trajectory (as dl_extended_trajectory gives it)
 * from the reference's, the largest so far: of few differences the largest may be a small one. Sets
 * error. Returns that distance at the end. */
double dl_reference_take_check(const dl_scene *scene, dl_reference *reference, const double *high,
                               const double *low);

/* Raises sample_error to what the rounding of the state at every one of `steps` steps adds up to,
 * also where the trajectories agree to the last digit, having been rounded in the same way. */
void dl_reference_take_rounding(const dl_scene *scene, dl_reference *reference, double epsilon,
                                unsigned long steps);

/* Sets growth and the exponents from `growth` [parts * (samples - 1) + 1], and parted and horizon
 * from that and sample_error. growth NULL: it was not measured. `epsilon` is that of the precision
 * in which the reference was computed. */
void dl_reference_set_horizon(const dl_scene *scene, dl_reference *reference, const double *growth,
                              size_t parts, double epsilon);

#endif
