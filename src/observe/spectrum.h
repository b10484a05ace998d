/* Small motions about a state: the eigenvalues omega^2 of the mass-weighted Hessian
 *
 *     K = M^(-1/2) H M^(-1/2) = - M^(1/2) (d a / d q) M^(-1/2)
 *
 * with H the second derivatives of the potential and M the inertias. A positive one is the square
 * of an angular frequency; a negative one -lambda^2 belongs to a direction in which neighbouring
 * motions part as exp(lambda t). In units of 1/time^2. A force that jumps at a breakpoint has no
 * derivative there: the jump is not in K. */
#ifndef DL_OBSERVE_SPECTRUM_H
#define DL_OBSERVE_SPECTRUM_H

#include "driftlab/model.h"

typedef struct dl_spectrum {
    double smallest, largest; /* eigenvalues; 0 where there is no pair force */
} dl_spectrum;

/* Both ends at positions q [unknowns]: from all eigenvalues where unknowns are few, by Lanczos
 * elsewhere. Counts as work of the model that is given. DL_UNSTABLE where K is not finite. */
dl_status dl_spectrum_ends(dl_model *model, const double *q, dl_spectrum *spectrum,
                           dl_error *error);

/* All eigenvalues, ascending, into value [unknowns]; costs unknowns^3. */
dl_status dl_spectrum_all(dl_model *model, const double *q, double *value, dl_error *error);

/* The ends by Lanczos' iteration with full reorthogonalisation on products with d a / d q; to about
 * 1e-10 of the larger modulus. The start vector is always the same. DL_ERROR where it does not
 * converge. */
dl_status dl_spectrum_lanczos(dl_model *model, const double *q, dl_spectrum *spectrum,
                              dl_error *error);

#endif
