/* Every method, in the order in which they are listed. Adding one: a line here and a
 * `const dl_method_row dl_method_<symbol>` in its family's file. */
#ifndef DL_METHODS_REGISTRY_H
#define DL_METHODS_REGISTRY_H

#include "driftlab/method.h"

#define DL_METHODS(X)                                                                              \
    X(leapfrog)                                                                                    \
    X(composition_2_verlet)                                                                        \
    X(composition_4_yoshida)                                                                       \
    X(composition_4_suzuki)                                                                        \
    X(composition_6_yoshida)                                                                       \
    X(composition_6_kahan_li)                                                                      \
    X(composition_8_suzuki_umeno)                                                                  \
    X(composition_8_kahan_li)                                                                      \
    X(conserving_fixed_point)                                                                      \
    X(conserving_newton_dense)                                                                     \
    X(conserving_newton_klu)                                                                       \
    X(arkode_erk)                                                                                  \
    X(cvode_adams)                                                                                 \
    X(cvode_bdf_fixed_point)                                                                       \
    X(cvode_bdf_klu)                                                                               \
    X(cvode_bdf_krylov)                                                                            \
    X(gsl_rk4)                                                                                     \
    X(gsl_rkf45)                                                                                   \
    X(gsl_rk8pd)                                                                                   \
    X(gsl_msadams)

#define DL_METHOD_DECLARE(symbol) extern const dl_method_row dl_method_##symbol;
DL_METHODS(DL_METHOD_DECLARE)
#undef DL_METHOD_DECLARE

/* A fixed step was taken: t follows. */
void dl_method_count_step(dl_method *method);

#endif
