/* Trajectories in extended precision through the samples of a reference, and the growth of small
 * displacements along one. */
#ifndef DL_REFERENCE_TRAJECTORY_H
#define DL_REFERENCE_TRAJECTORY_H

#include "reference/extended.h"

/* Time of sample 0 ... intervals, as dl_schedule_time has it. */
double dl_reference_time(double end, size_t intervals, size_t sample);

/* States at the samples, high and low [intervals + 1][2 * dimension * particles]. */
dl_status dl_extended_trajectory(const dl_extended_ops *ops, const dl_scene *scene,
                                 const dl_extended_setup *setup, double end, size_t intervals,
                                 double *high, double *low, dl_extended_counts *counts,
                                 dl_error *error);

/* Two trajectories in long double, the second put back to a small distance from the first at equal
 * times (G. Benettin, L. Galgani, J.-M. Strelcyn, Phys. Rev. A 14 (1976) 2338,
 * doi:10.1103/PhysRevA.14.2338): growth [intervals + 1] is the log of the factor by which the
 * distance would have grown. It starts in a random direction; positions count in units of `length`,
 * velocities of those they have, or would get within it. */
dl_status dl_extended_growth(const dl_scene *scene, const dl_extended_limits *limits, double length,
                             double end, size_t intervals, double *growth, dl_error *error);

#endif
