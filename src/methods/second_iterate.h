/* A nonlinear solver of SUNDIALS' kind for z = G(z) where the second iterate is the solution, since
 * G reads parts of z that it does not change from what it finds: two evaluations of G, whatever is
 * given for a first guess, and no test of convergence, which has nothing to go by. */
#ifndef DL_METHODS_SECOND_ITERATE_H
#define DL_METHODS_SECOND_ITERATE_H

#include <sundials/sundials_nonlinearsolver.h>

/* `like`: a vector of the length of z. NULL where memory is out. Free with SUNNonlinSolFree. */
SUNNonlinearSolver dl_second_iterate_create(N_Vector like, SUNContext context);

#endif
