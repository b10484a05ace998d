/* The parts of the conserving step's solver (conserving_solver.h) and what they share. */
#ifndef DL_METHODS_CONSERVING_PARTS_H
#define DL_METHODS_CONSERVING_PARTS_H

#include "methods/conserving_solver.h"

/* --- conserving_system.c: the equations as KINSOL calls them -------------------------------------
 */

/* Residuals up to this that no longer fall are roundoff: a part of the displacement, or of the
 * positions where that is more. */
double dl_conserving_roundoff(const dl_conserving_step *step);

/* Forgets the residuals of an earlier attempt. */
void dl_conserving_begin(dl_conserving_solver *solver);

/* Whether the residual has come down to roundoff and stays there. */
bool dl_conserving_is_at_roundoff(const dl_conserving_solver *solver);

/* image = h v + (h^2/2) a(q, q + delta), pairs that cross a jump solved (model/crossings.c), and
 * a as it is there; counts how the residual falls. Not 0 where the iteration is to end without a
 * solution. */
int dl_conserving_advance_map(dl_conserving_solver *solver, const double *delta, double *image);

/* The same as KINSOL calls it. */
int dl_conserving_map(N_Vector u, N_Vector image, void *user_data);

/* delta - h v - (h^2/2) a(q, q + delta). */
int dl_conserving_residual(N_Vector u, N_Vector f, void *user_data);

/* The same for Picard's iteration, which is given up where it gets nowhere. */
int dl_conserving_picard(N_Vector u, N_Vector f, void *user_data);

/* --- conserving_iteration.c ----------------------------------------------------------------------
 */

/* Solves from the guess in step.delta, without KINSOL. */
dl_status dl_conserving_iterate(dl_conserving_solver *solver, dl_error *error);

/* --- conserving_linear.c ------------------------------------------------------------------------
 */

/* The linear solver that the kind needs, made and attached to KINSOL; false where it cannot be. */
bool dl_conserving_attach(dl_conserving_solver *solver);
void dl_conserving_detach(dl_conserving_solver *solver);

#endif
