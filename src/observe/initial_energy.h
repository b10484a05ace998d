/* Whether a scene's initial state has an energy, and momenta, that can be told. */
#ifndef DL_OBSERVE_INITIAL_ENERGY_H
#define DL_OBSERVE_INITIAL_ENERGY_H

#include "driftlab/model.h"

/* y [2 * unknowns]. DL_INPUT where the energy, or a scale that errors are compared with, is beyond
 * the range of numbers: names the scene's file and, where one particle or pair alone makes it so,
 * which. */
dl_status dl_initial_energy_check(dl_model *model, const double *y, dl_error *error);

#endif
