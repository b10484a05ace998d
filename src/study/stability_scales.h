/* What the size of a stable step is set against: the scene's fastest motion, at its start and along
 * a run, and the papers' rule. */
#ifndef DL_STUDY_STABILITY_SCALES_H
#define DL_STUDY_STABILITY_SCALES_H

#include "observe/spectrum.h"
#include "study/kind.h"

/* Eigenvalues omega^2 as rates: 0 where there is no such direction. */
double dl_spectrum_omega(const dl_spectrum *spectrum);  /* of the fastest oscillation */
double dl_spectrum_growth(const dl_spectrum *spectrum); /* of the fastest unstable direction */

/* The spectrum's ends at the start of a scene. */
dl_status dl_scales_at_start(const dl_scene *scene, dl_spectrum *spectrum, dl_error *error);

/* Ends of the spectra and the largest speed over a run. */
typedef struct dl_scales {
    dl_spectrum spectrum;
    double speed;
    double evaluations; /* a step: forces, Jacobians and products with them */
} dl_scales;

/* Of the unit's method at a fixed step to the unit's end, looked at `looks` times and at both ends.
 * A run that fails tells what it has seen until then. */
dl_status dl_scales_along(const dl_study_unit *unit, double step, long looks, dl_scales *scales,
                          dl_error *error);

/* TR323's condition on a step is r0/|v|: r0 the distance at which the pair law ends; where it does
 * not end, that of equilibrium, at which its force turns from repelling to attracting. The smallest
 * of the species' laws; NAN where there is neither. *what says which. */
double dl_scales_r0(const dl_scene *scene, const char **what);

#endif
