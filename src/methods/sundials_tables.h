/* The tables of coefficients that this SUNDIALS has: X(word that an option gives, SUNDIALS' name
 * for it). A word ends in the order of the table. SUNDIALS' documentation of its Butcher tables
 * names the sources; the words that are no names of people are
 *
 *     ark324 436 548     ARK3(2)4L[2]SA ..., Kennedy and Carpenter 2003,
 *                        doi:10.1016/S0168-9274(02)00138-1
 *     ark437 548b        ARK4(3)7L[2]SA ..., the same 2019, doi:10.1016/j.apnum.2018.10.007
 *     esdirk, qesdirk    ESDIRK3(2)4L[2]SA ..., the same 2019, doi:10.1016/j.apnum.2019.07.008
 *     ark2               Giraldo, Kelly and Constantinescu 2013, doi:10.1137/120876034
 *     gark               MRI-GARK, Sandu 2019, doi:10.1137/18M1205492
 *     merk               Luan, Chinomona and Reynolds 2020, doi:10.1137/19M125621X
 */
#ifndef DL_METHODS_SUNDIALS_TABLES_H
#define DL_METHODS_SUNDIALS_TABLES_H

#include "methods/sundials.h"

/* --- newer than 6.4 ----------------------------------------------------------------------------
 */

#if DL_SUNDIALS_AT_LEAST(6, 6)
#define DL_ERK_TABLES_6_6(X)  X("ark2-2", ARKODE_ARK2_ERK_3_1_2)
#define DL_DIRK_TABLES_6_6(X) X("ark2-2", ARKODE_ARK2_DIRK_3_1_2)
#define DL_IMEX_TABLES_6_6(X) X("ark2-2", ARKODE_ARK2_DIRK_3_1_2, ARKODE_ARK2_ERK_3_1_2)
#else
#define DL_ERK_TABLES_6_6(X)
#define DL_DIRK_TABLES_6_6(X)
#define DL_IMEX_TABLES_6_6(X)
#endif

#if DL_SUNDIALS_AT_LEAST(6, 7)
#define DL_ERK_TABLES_6_7(X)                                                                       \
    X("shu-osher-3", ARKODE_SHU_OSHER_3_2_3)                                                       \
    X("sofroniou-spaletta-4", ARKODE_SOFRONIOU_SPALETTA_5_3_4)                                     \
    X("verner-9-stages-6", ARKODE_VERNER_9_5_6)                                                    \
    X("verner-7", ARKODE_VERNER_10_6_7)                                                            \
    X("verner-8", ARKODE_VERNER_13_7_8)                                                            \
    X("verner-9", ARKODE_VERNER_16_8_9)
#else
#define DL_ERK_TABLES_6_7(X)
#endif

#if DL_SUNDIALS_AT_LEAST(7, 1)
#define DL_ERK_TABLES_7_1(X)                                                                       \
    X("forward-euler-1", ARKODE_FORWARD_EULER_1_1)                                                 \
    X("ralston-euler-2", ARKODE_RALSTON_EULER_2_1_2)                                               \
    X("midpoint-euler-2", ARKODE_EXPLICIT_MIDPOINT_EULER_2_1_2)
#define DL_DIRK_TABLES_7_1(X)                                                                      \
    X("backward-euler-1", ARKODE_BACKWARD_EULER_1_1)                                               \
    X("midpoint-2", ARKODE_IMPLICIT_MIDPOINT_1_2)                                                  \
    X("trapezoidal-2", ARKODE_IMPLICIT_TRAPEZOIDAL_2_2)
#define DL_MRI_TABLES_7_1(X)                                                                       \
    X("gark-forward-euler-1", ARKODE_MRI_GARK_FORWARD_EULER)                                       \
    X("gark-ralston-2", ARKODE_MRI_GARK_RALSTON2)                                                  \
    X("gark-erk22a-2", ARKODE_MRI_GARK_ERK22a)                                                     \
    X("gark-erk22b-2", ARKODE_MRI_GARK_ERK22b)                                                     \
    X("gark-ralston-3", ARKODE_MRI_GARK_RALSTON3)                                                  \
    X("gark-backward-euler-1", ARKODE_MRI_GARK_BACKWARD_EULER)                                     \
    X("gark-midpoint-2", ARKODE_MRI_GARK_IMPLICIT_MIDPOINT)
#else
#define DL_ERK_TABLES_7_1(X)
#define DL_DIRK_TABLES_7_1(X)
#define DL_MRI_TABLES_7_1(X)
#endif

#if DL_SUNDIALS_AT_LEAST(7, 2)
#define DL_MRI_TABLES_7_2(X)                                                                       \
    X("merk21-2", ARKODE_MERK21)                                                                   \
    X("merk32-3", ARKODE_MERK32)                                                                   \
    X("merk43-4", ARKODE_MERK43)                                                                   \
    X("merk54-5", ARKODE_MERK54)
#else
#define DL_MRI_TABLES_7_2(X)
#endif

#if DL_SUNDIALS_AT_LEAST(7, 3)
#define DL_ERK_TABLES_7_3(X)                                                                       \
    X("ralston-2", ARKODE_RALSTON_3_1_2)                                                           \
    X("tsitouras-5", ARKODE_TSITOURAS_7_4_5)
#else
#define DL_ERK_TABLES_7_3(X)
#endif

/* --- all ---------------------------------------------------------------------------------------
 */

#define DL_ERK_TABLES(X)                                                                           \
    X("heun-euler-2", ARKODE_HEUN_EULER_2_1_2)                                                     \
    X("bogacki-shampine-3", ARKODE_BOGACKI_SHAMPINE_4_2_3)                                         \
    X("knoth-wolke-3", ARKODE_KNOTH_WOLKE_3_3)                                                     \
    X("ark324-3", ARKODE_ARK324L2SA_ERK_4_2_3)                                                     \
    X("zonneveld-4", ARKODE_ZONNEVELD_5_3_4)                                                       \
    X("sayfy-aburub-4", ARKODE_SAYFY_ABURUB_6_3_4)                                                 \
    X("ark436-4", ARKODE_ARK436L2SA_ERK_6_3_4)                                                     \
    X("ark437-4", ARKODE_ARK437L2SA_ERK_7_3_4)                                                     \
    X("cash-karp-5", ARKODE_CASH_KARP_6_4_5)                                                       \
    X("fehlberg-5", ARKODE_FEHLBERG_6_4_5)                                                         \
    X("dormand-prince-5", ARKODE_DORMAND_PRINCE_7_4_5)                                             \
    X("ark548-5", ARKODE_ARK548L2SA_ERK_8_4_5)                                                     \
    X("ark548b-5", ARKODE_ARK548L2SAb_ERK_8_4_5)                                                   \
    X("verner-6", ARKODE_VERNER_8_5_6)                                                             \
    X("fehlberg-8", ARKODE_FEHLBERG_13_7_8)                                                        \
    DL_ERK_TABLES_6_6(X) DL_ERK_TABLES_6_7(X) DL_ERK_TABLES_7_1(X) DL_ERK_TABLES_7_3(X)

/* Of those, the ones that relaxation can go by: no negative weight, and an error estimate. */
#if DL_SUNDIALS_AT_LEAST(6, 6)
#define DL_RELAXATION_TABLES_6_6(X) X("ark2-2", ARKODE_ARK2_ERK_3_1_2)
#else
#define DL_RELAXATION_TABLES_6_6(X)
#endif
#if DL_SUNDIALS_AT_LEAST(6, 7)
#define DL_RELAXATION_TABLES_6_7(X)                                                                \
    X("shu-osher-3", ARKODE_SHU_OSHER_3_2_3)                                                       \
    X("sofroniou-spaletta-4", ARKODE_SOFRONIOU_SPALETTA_5_3_4)
#else
#define DL_RELAXATION_TABLES_6_7(X)
#endif
#define DL_RELAXATION_TABLES(X)                                                                    \
    X("heun-euler-2", ARKODE_HEUN_EULER_2_1_2)                                                     \
    X("bogacki-shampine-3", ARKODE_BOGACKI_SHAMPINE_4_2_3)                                         \
    X("zonneveld-4", ARKODE_ZONNEVELD_5_3_4)                                                       \
    X("sayfy-aburub-4", ARKODE_SAYFY_ABURUB_6_3_4)                                                 \
    X("cash-karp-5", ARKODE_CASH_KARP_6_4_5)                                                       \
    X("verner-6", ARKODE_VERNER_8_5_6)                                                             \
    X("fehlberg-8", ARKODE_FEHLBERG_13_7_8)                                                        \
    DL_RELAXATION_TABLES_6_6(X) DL_RELAXATION_TABLES_6_7(X)

#define DL_DIRK_TABLES(X)                                                                          \
    X("sdirk-2", ARKODE_SDIRK_2_1_2)                                                               \
    X("billington-2", ARKODE_BILLINGTON_3_3_2)                                                     \
    X("tr-bdf2-2", ARKODE_TRBDF2_3_3_2)                                                            \
    X("kvaerno-3", ARKODE_KVAERNO_4_2_3)                                                           \
    X("ark324-3", ARKODE_ARK324L2SA_DIRK_4_2_3)                                                    \
    X("esdirk324-3", ARKODE_ESDIRK324L2SA_4_2_3)                                                   \
    X("esdirk325-3", ARKODE_ESDIRK325L2SA_5_2_3)                                                   \
    X("esdirk32i5-3", ARKODE_ESDIRK32I5L2SA_5_2_3)                                                 \
    X("cash-5-2-4", ARKODE_CASH_5_2_4)                                                             \
    X("cash-5-3-4", ARKODE_CASH_5_3_4)                                                             \
    X("sdirk-4", ARKODE_SDIRK_5_3_4)                                                               \
    X("kvaerno-4", ARKODE_KVAERNO_5_3_4)                                                           \
    X("ark436-4", ARKODE_ARK436L2SA_DIRK_6_3_4)                                                    \
    X("ark437-4", ARKODE_ARK437L2SA_DIRK_7_3_4)                                                    \
    X("esdirk436-4", ARKODE_ESDIRK436L2SA_6_3_4)                                                   \
    X("esdirk43i6-4", ARKODE_ESDIRK43I6L2SA_6_3_4)                                                 \
    X("qesdirk436-4", ARKODE_QESDIRK436L2SA_6_3_4)                                                 \
    X("esdirk437-4", ARKODE_ESDIRK437L2SA_7_3_4)                                                   \
    X("kvaerno-5", ARKODE_KVAERNO_7_4_5)                                                           \
    X("ark548-5", ARKODE_ARK548L2SA_DIRK_8_4_5)                                                    \
    X("ark548b-5", ARKODE_ARK548L2SAb_DIRK_8_4_5)                                                  \
    X("esdirk547-5", ARKODE_ESDIRK547L2SA_7_4_5)                                                   \
    X("esdirk547-2-5", ARKODE_ESDIRK547L2SA2_7_4_5)                                                \
    DL_DIRK_TABLES_6_6(X) DL_DIRK_TABLES_7_1(X)

/* X(word, implicit table, explicit table) */
#define DL_IMEX_TABLES(X)                                                                          \
    X("ark324-3", ARKODE_ARK324L2SA_DIRK_4_2_3, ARKODE_ARK324L2SA_ERK_4_2_3)                       \
    X("ark436-4", ARKODE_ARK436L2SA_DIRK_6_3_4, ARKODE_ARK436L2SA_ERK_6_3_4)                       \
    X("ark437-4", ARKODE_ARK437L2SA_DIRK_7_3_4, ARKODE_ARK437L2SA_ERK_7_3_4)                       \
    X("ark548-5", ARKODE_ARK548L2SA_DIRK_8_4_5, ARKODE_ARK548L2SA_ERK_8_4_5)                       \
    X("ark548b-5", ARKODE_ARK548L2SAb_DIRK_8_4_5, ARKODE_ARK548L2SAb_ERK_8_4_5)                    \
    DL_IMEX_TABLES_6_6(X)

/* Without those that split the force in three. */
#define DL_MRI_TABLES(X)                                                                           \
    X("mis-kw-3", ARKODE_MIS_KW3)                                                                  \
    X("gark-erk33a-3", ARKODE_MRI_GARK_ERK33a)                                                     \
    X("gark-erk45a-4", ARKODE_MRI_GARK_ERK45a)                                                     \
    X("gark-irk21a-2", ARKODE_MRI_GARK_IRK21a)                                                     \
    X("gark-esdirk34a-3", ARKODE_MRI_GARK_ESDIRK34a)                                               \
    X("gark-esdirk46a-4", ARKODE_MRI_GARK_ESDIRK46a)                                               \
    DL_MRI_TABLES_7_1(X) DL_MRI_TABLES_7_2(X)

/* Symplectic: since SUNDIALS 6.6, which has SPRKStep. */
#define DL_SPRK_TABLES(X)                                                                          \
    X("euler-1", ARKODE_SPRK_EULER_1_1)                                                            \
    X("leapfrog-2", ARKODE_SPRK_LEAPFROG_2_2)                                                      \
    X("pseudo-leapfrog-2", ARKODE_SPRK_PSEUDO_LEAPFROG_2_2)                                        \
    X("mclachlan-2", ARKODE_SPRK_MCLACHLAN_2_2)                                                    \
    X("ruth-3", ARKODE_SPRK_RUTH_3_3)                                                              \
    X("mclachlan-3", ARKODE_SPRK_MCLACHLAN_3_3)                                                    \
    X("candy-rozmus-4", ARKODE_SPRK_CANDY_ROZMUS_4_4)                                              \
    X("mclachlan-4", ARKODE_SPRK_MCLACHLAN_4_4)                                                    \
    X("mclachlan-5", ARKODE_SPRK_MCLACHLAN_5_6)                                                    \
    X("yoshida-6", ARKODE_SPRK_YOSHIDA_6_8)                                                        \
    X("suzuki-umeno-8", ARKODE_SPRK_SUZUKI_UMENO_8_16)                                             \
    X("sofroniou-10", ARKODE_SPRK_SOFRONIOU_10_36)

#endif
