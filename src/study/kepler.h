/* Exact motion of two bodies that attract by an inverse-square law, on a bound orbit.
 *
 * Relative vector d = r_1 - r_2, force on body 1: c_1 c_2 C d/r^3 with C < 0, inertias I_1, I_2:
 *
 *     d'' = -mu d / r^3,     mu = -C c_1 c_2 (1/I_1 + 1/I_2)
 *
 * (a pinned body's inertia is infinite), and the centre of mass moves uniformly. Kepler's equation
 * is solved for the change of eccentric anomaly since the start, and Gauss's f and g carry the
 * vector on: R. H. Battin, An Introduction to the Mathematics and Methods of Astrodynamics, AIAA
 * 1999, section 4.3. In quad precision: after a thousand orbits of eccentricity 0.99 the phase has
 * lost some seven of its 34 digits. */
#ifndef DL_STUDY_KEPLER_H
#define DL_STUDY_KEPLER_H

#include "driftlab/scene.h"

/* DL_INPUT, with the reason, where the scene is not such a motion. */
dl_status dl_kepler_check(const dl_scene *scene, dl_error *error);

/* Positions at time t, [dimension * 2] as in the scene; low: what is to be added to them, or NULL.
 * The scene has passed the check. */
dl_status dl_kepler_position(const dl_scene *scene, double t, double *position, double *low,
                             dl_error *error);

#endif
