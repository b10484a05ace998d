/* Every method, in the order in which they are listed. Adding one: a line here and a
 * `const dl_method_row dl_method_<symbol>` in its family's file. */
#ifndef DL_METHODS_REGISTRY_H
#define DL_METHODS_REGISTRY_H

#include "driftlab/method.h"

/* What SUNDIALS has since 6.6; CMake tells. */
#ifdef DL_HAVE_SUNDIALS_6_6
#define DL_METHODS_SUNDIALS_6_6(X) X(arkode_erk_relaxation) X(arkode_sprk)
#else
#define DL_METHODS_SUNDIALS_6_6(X)
#endif

#define DL_METHODS(X)                                                                              \
    X(leapfrog)                                                                                    \
    X(composition_2_verlet)                                                                        \
    X(composition_4_yoshida)                                                                       \
    X(composition_4_suzuki)                                                                        \
    X(composition_6_yoshida)                                                                       \
    X(composition_6_kahan_li)                                                                      \
    X(composition_6_sofroniou_spaletta)                                                            \
    X(composition_8_suzuki_umeno)                                                                  \
    X(composition_8_yoshida)                                                                       \
    X(composition_8_kahan_li)                                                                      \
    X(composition_8_sofroniou_spaletta)                                                            \
    X(composition_10_sofroniou_spaletta)                                                           \
    X(splitting_2_position_verlet)                                                                 \
    X(splitting_2_mclachlan)                                                                       \
    X(splitting_2_mclachlan_atela)                                                                 \
    X(splitting_3_ruth)                                                                            \
    X(splitting_3_mclachlan_atela)                                                                 \
    X(splitting_4_candy_rozmus)                                                                    \
    X(splitting_4_mclachlan)                                                                       \
    X(splitting_4_vefrl)                                                                           \
    X(splitting_4_pefrl)                                                                           \
    X(splitting_4_blanes_moan)                                                                     \
    X(splitting_6_blanes_moan)                                                                     \
    X(rkn_4_mclachlan_atela)                                                                       \
    X(rkn_4_calvo_sanz_serna)                                                                      \
    X(rkn_4_mclachlan)                                                                             \
    X(rkn_4_blanes_moan)                                                                           \
    X(rkn_5_mclachlan_atela)                                                                       \
    X(rkn_6_okunbor_skeel)                                                                         \
    X(rkn_6_blanes_moan_11)                                                                        \
    X(rkn_6_blanes_moan_14)                                                                        \
    X(gauss_4)                                                                                     \
    X(gauss_6)                                                                                     \
    X(gauss_radau_15)                                                                              \
    X(conserving)                                                                                  \
    X(conserving_iteration)                                                                        \
    X(conserving_fixed_point)                                                                      \
    X(conserving_picard)                                                                           \
    X(conserving_newton_dense)                                                                     \
    X(conserving_newton_klu)                                                                       \
    X(conserving_newton_krylov)                                                                    \
    X(conserving_relaxed)                                                                          \
    X(conserving_4_suzuki)                                                                         \
    X(conserving_gonzalez)                                                                         \
    X(conserving_average_vector_field)                                                             \
    X(implicit_midpoint)                                                                           \
    X(arkode_erk)                                                                                  \
    X(arkode_dirk)                                                                                 \
    X(arkode_imex)                                                                                 \
    X(arkode_mri)                                                                                  \
    DL_METHODS_SUNDIALS_6_6(X)                                                                     \
    X(cvode_adams)                                                                                 \
    X(cvode_adams_dense)                                                                           \
    X(cvode_adams_klu)                                                                             \
    X(cvode_adams_krylov)                                                                          \
    X(cvode_adams_diagonal)                                                                        \
    X(cvode_bdf_fixed_point)                                                                       \
    X(cvode_bdf_dense)                                                                             \
    X(cvode_bdf_klu)                                                                               \
    X(cvode_bdf_krylov)                                                                            \
    X(cvode_bdf_diagonal)                                                                          \
    X(gsl_rk2)                                                                                     \
    X(gsl_rk4)                                                                                     \
    X(gsl_rkf45)                                                                                   \
    X(gsl_rkck)                                                                                    \
    X(gsl_rk8pd)                                                                                   \
    X(gsl_rk1imp)                                                                                  \
    X(gsl_rk2imp)                                                                                  \
    X(gsl_rk4imp)                                                                                  \
    X(gsl_bsimp)                                                                                   \
    X(gsl_msadams)                                                                                 \
    X(gsl_msbdf)

#define DL_METHOD_DECLARE(symbol) extern const dl_method_row dl_method_##symbol;
DL_METHODS(DL_METHOD_DECLARE)
#undef DL_METHOD_DECLARE

/* A fixed step was taken: t follows. */
void dl_method_count_step(dl_method *method);

#endif
