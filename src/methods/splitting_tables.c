/* The splittings, a table and a row each. Their names begin with what they are made of:
 *
 *     composition   S_{w_1 h} o S_{w_2 h} o ... of Verlet steps; holds for any symmetric S
 *     splitting     kicks and drifts of their own; holds for any two parts
 *     rkn           the same where the kick's part depends on q alone and the drift's is
 *                   quadratic in the momenta: fewer conditions make the order, or less is its error
 *
 * Digits: where no formula is given, the published ones were improved by Newton's method on the
 * order conditions, in 60 digits, towards the nearest solution; so that the order holds to the
 * roundoff of double precision, which some printed digits do not allow. */
#include "methods/options.h"
#include "methods/registry.h"
#include "methods/splitting.h"

#define SPLITTING(symbol, its_name, its_order, its_stages, its_table, its_symmetry, its_doc)       \
    const dl_method_row dl_method_##symbol = {                                                     \
        .name = its_name,                                                                          \
        .family = "composition",                                                                   \
        .doc = its_doc,                                                                            \
        .order = its_order,                                                                        \
        .stages = its_stages,                                                                      \
        .forces = its_stages,                                                                      \
        .flags = DL_SYMPLECTIC | DL_CONSERVES_MOMENTUM | DL_FIXED_STEP | DL_RESTARTS_EXACTLY |     \
                 (its_symmetry),                                                                   \
        .options = DL_OPTIONS_TABLE(dl_splitting_parameters),                                      \
        .options_size = sizeof(dl_splitting_options),                                              \
        .variant = &(its_table),                                                                   \
        .ops = &dl_splitting_ops,                                                                  \
    }

/* --- compositions of Verlet steps ---------------------------------------------------------------
 */

static const dl_splitting_table verlet_2 = {
    .form = DL_OF_VERLET,
    .count = 1,
    .symmetric = true,
    .coefficient = {1},
};

SPLITTING(composition_2_verlet, "composition-2-verlet", 2, 1, verlet_2, DL_TIME_SYMMETRIC,
          "velocity Verlet (Verlet 1967, doi:10.1103/PhysRev.159.98)");

/* 1/(2 - 2^(1/3)) and 1 - 2 w_1. H. Yoshida, Phys. Lett. A 150 (1990) 262,
 * doi:10.1016/0375-9601(90)90092-3; also E. Forest, R. D. Ruth, Physica D 43 (1990) 105,
 * doi:10.1016/0167-2789(90)90019-L. */
static const dl_splitting_table yoshida_4 = {
    .form = DL_OF_VERLET,
    .count = 3,
    .symmetric = true,
    .coefficient = {1.3512071919596576340476878, -1.7024143839193152680953756},
};

SPLITTING(composition_4_yoshida, "composition-4-yoshida", 4, 3, yoshida_4, DL_TIME_SYMMETRIC,
          "3 Verlet steps (Forest & Ruth 1990; Yoshida 1990, doi:10.1016/0375-9601(90)90092-3)");

/* 1/(4 - 4^(1/3)), twice, and 1 - 4 w_1. M. Suzuki, Phys. Lett. A 146 (1990) 319,
 * doi:10.1016/0375-9601(90)90962-N. */
static const dl_splitting_table suzuki_4 = {
    .form = DL_OF_VERLET,
    .count = 5,
    .symmetric = true,
    .coefficient = {0.41449077179437573714235406, 0.41449077179437573714235406,
                    -0.65796308717750294856941625},
};

SPLITTING(composition_4_suzuki, "composition-4-suzuki", 4, 5, suzuki_4, DL_TIME_SYMMETRIC,
          "5 Verlet steps (Suzuki 1990, doi:10.1016/0375-9601(90)90962-N)");

/* Solution A of H. Yoshida (as above). */
static const dl_splitting_table yoshida_6 = {
    .form = DL_OF_VERLET,
    .count = 7,
    .symmetric = true,
    .coefficient = {0.78451361047755726381949763, 0.23557321335935813368479318,
                    -1.1776799841788710069464157, 1.3151863206839112188842497},
};

SPLITTING(composition_6_yoshida, "composition-6-yoshida", 6, 7, yoshida_6, DL_TIME_SYMMETRIC,
          "7 Verlet steps, solution A (Yoshida 1990, doi:10.1016/0375-9601(90)90092-3)");

/* W. Kahan, R.-C. Li, Math. Comp. 66 (1997) 1089, doi:10.1090/S0025-5718-97-00873-9, s9odr6a. */
static const dl_splitting_table kahan_li_6 = {
    .form = DL_OF_VERLET,
    .count = 9,
    .symmetric = true,
    .coefficient = {0.39216144400731413927925056, 0.33259913678935943859974864,
                    -0.70624617255763935980996482, 0.082213596293550800231490448,
                    0.79854399093482996339895035},
};

SPLITTING(composition_6_kahan_li, "composition-6-kahan-li", 6, 9, kahan_li_6, DL_TIME_SYMMETRIC,
          "9 Verlet steps (Kahan & Li 1997, doi:10.1090/S0025-5718-97-00873-9)");

/* M. Sofroniou, G. Spaletta, Optim. Methods Softw. 20 (2005) 597, doi:10.1080/10556780500140664. */
static const dl_splitting_table sofroniou_spaletta_6 = {
    .form = DL_OF_VERLET,
    .count = 11,
    .symmetric = true,
    .coefficient = {0.21375583945878254555518067, 0.18329381407425713911385974,
                    0.17692819473098943794898812, -0.44329082681170215849622830,
                    0.11728560432865935385403586, 0.50405474843802736404832782},
};

SPLITTING(composition_6_sofroniou_spaletta, "composition-6-sofroniou-spaletta", 6, 11,
          sofroniou_spaletta_6, DL_TIME_SYMMETRIC,
          "11 Verlet steps (Sofroniou & Spaletta 2005, doi:10.1080/10556780500140664)");

/* M. Suzuki, K. Umeno, in Computer Simulation Studies in Condensed-Matter Physics VI (1993) 74; R.
 * I. McLachlan, SIAM J. Sci. Comput. 16 (1995) 151, doi:10.1137/0916010. */
static const dl_splitting_table suzuki_umeno_8 = {
    .form = DL_OF_VERLET,
    .count = 15,
    .symmetric = true,
    .coefficient = {0.74167036435061295344822780, -0.40910082580003159399730010,
                    0.19075471029623837995387626, -0.57386247111608226665638773,
                    0.29906418130365592384446354, 0.33462491824529818378495798,
                    0.31529309239676659663205666, -0.79688793935291635401978884},
};

SPLITTING(composition_8_suzuki_umeno, "composition-8-suzuki-umeno", 8, 15, suzuki_umeno_8,
          DL_TIME_SYMMETRIC,
          "15 Verlet steps (Suzuki & Umeno 1993; McLachlan 1995, doi:10.1137/0916010)");

/* Solution D of H. Yoshida (as above), whose printed digits hold to 1e-12. */
static const dl_splitting_table yoshida_8 = {
    .form = DL_OF_VERLET,
    .count = 15,
    .symmetric = true,
    .coefficient = {0.91484424622979156674879349, 0.25369333656621135414614602,
                    -1.4448522368606051576947307, -0.15824063536805017520406678,
                    1.9381391376225259865791865, -1.9606102329753108076076334,
                    0.10279984939179644069811513, 1.7084530707872815846683794},
};

SPLITTING(composition_8_yoshida, "composition-8-yoshida", 8, 15, yoshida_8, DL_TIME_SYMMETRIC,
          "15 Verlet steps, solution D (Yoshida 1990, doi:10.1016/0375-9601(90)90092-3)");

/* Kahan, Li (as above), s17odr8a. */
static const dl_splitting_table kahan_li_8 = {
    .form = DL_OF_VERLET,
    .count = 17,
    .symmetric = true,
    .coefficient = {0.13020248308889008087881763, 0.56116298177510838456196441,
                    -0.38947496264484728640807860, 0.15884190655515560089621075,
                    -0.39590389413323757733623154, 0.18453964097831570709183254,
                    0.25837438768632204729397911, 0.29501172360931029887096624,
                    -0.60550853383003451169892108},
};

SPLITTING(composition_8_kahan_li, "composition-8-kahan-li", 8, 17, kahan_li_8, DL_TIME_SYMMETRIC,
          "17 Verlet steps (Kahan & Li 1997, doi:10.1090/S0025-5718-97-00873-9)");

/* Sofroniou, Spaletta (as above). */
static const dl_splitting_table sofroniou_spaletta_8 = {
    .form = DL_OF_VERLET,
    .count = 21,
    .symmetric = true,
    .coefficient = {0.10647728984550031823931968, 0.10837408645835726397433411,
                    0.35337821052654342419534541, -0.23341414023165082198780281,
                    -0.24445266791528841269462171, 0.11317848435755633314700953,
                    0.11892905625000350062692972, 0.12603912321825988140305670,
                    0.12581718736176041804392392, 0.11699135019217642180722881,
                    -0.38263596012643665350944671},
};

SPLITTING(composition_8_sofroniou_spaletta, "composition-8-sofroniou-spaletta", 8, 21,
          sofroniou_spaletta_8, DL_TIME_SYMMETRIC,
          "21 Verlet steps (Sofroniou & Spaletta 2005, doi:10.1080/10556780500140664)");

/* Sofroniou, Spaletta (as above). */
static const dl_splitting_table sofroniou_spaletta_10 = {
    .form = DL_OF_VERLET,
    .count = 35,
    .symmetric = true,
    .coefficient = {0.078795722521686419263907679, 0.31309610341510852776481247,
                    0.027918383235078066109520273, -0.22959284159390709415121340,
                    0.13096206107716486317465686, -0.26973340565451071434460973,
                    0.074973343155891435666137106, 0.11199342399981020488957508,
                    0.36613344954622675119314812, -0.39910563013603589787862981,
                    0.10308739852747107731580277, 0.41143087395589023782070412,
                    -0.0048663605831352617621956593, -0.39203335370863990644808194,
                    0.051942502962449647037182904, 0.050665090759924496335874344,
                    0.049674370639729879054568800, 0.049317735759594537917680008},
};

SPLITTING(composition_10_sofroniou_spaletta, "composition-10-sofroniou-spaletta", 10, 35,
          sofroniou_spaletta_10, DL_TIME_SYMMETRIC,
          "35 Verlet steps (Sofroniou & Spaletta 2005, doi:10.1080/10556780500140664)");

/* --- splittings ---------------------------------------------------------------------------------
 */

static const dl_splitting_table position_verlet_2 = {
    .form = DL_FROM_DRIFT,
    .count = 3,
    .symmetric = true,
    .coefficient = {0.5, 1},
};

SPLITTING(splitting_2_position_verlet, "splitting-2-position-verlet", 2, 1, position_verlet_2,
          DL_TIME_SYMMETRIC,
          "position Verlet (Tuckerman, Berne & Martyna 1992, doi:10.1063/1.463137)");

/* The first is (y^2 + 6 y - 2)/(12 y), y = (2 sqrt(326) - 36)^(1/3). R. I. McLachlan (as above). */
static const dl_splitting_table mclachlan_2 = {
    .form = DL_FROM_KICK,
    .count = 5,
    .symmetric = true,
    .coefficient = {0.19318332750378357396289977, 0.5, 0.61363334499243285207420047},
};

SPLITTING(splitting_2_mclachlan, "splitting-2-mclachlan", 2, 2, mclachlan_2, DL_TIME_SYMMETRIC,
          "smallest error of two stages (McLachlan 1995, doi:10.1137/0916010)");

/* 1 - 1/sqrt(2) and 1/sqrt(2). R. I. McLachlan, P. Atela, Nonlinearity 5 (1992) 541,
 * doi:10.1088/0951-7715/5/2/011. */
static const dl_splitting_table mclachlan_atela_2 = {
    .form = DL_FROM_KICK,
    .count = 4,
    .coefficient = {0.29289321881345247559915564, 0.70710678118654752440084436,
                    0.70710678118654752440084436, 0.29289321881345247559915564},
};

SPLITTING(splitting_2_mclachlan_atela, "splitting-2-mclachlan-atela", 2, 2, mclachlan_atela_2, 0,
          "smallest error of two stages, unsymmetric (McLachlan & Atela 1992, "
          "doi:10.1088/0951-7715/5/2/011)");

/* R. D. Ruth, IEEE Trans. Nucl. Sci. 30 (1983) 2669, doi:10.1109/TNS.1983.4332919. */
static const dl_splitting_table ruth_3 = {
    .form = DL_FROM_KICK,
    .count = 6,
    .coefficient = {7.0 / 24, 2.0 / 3, 3.0 / 4, -2.0 / 3, -1.0 / 24, 1},
};

SPLITTING(splitting_3_ruth, "splitting-3-ruth", 3, 3, ruth_3, 0,
          "splitting (Ruth 1983, doi:10.1109/TNS.1983.4332919)");

/* McLachlan, Atela (as above). */
static const dl_splitting_table mclachlan_atela_3 = {
    .form = DL_FROM_KICK,
    .count = 6,
    .coefficient = {0.26833009578175992495695523, 0.91966152301739985705089764,
                    -0.18799161879915978200785287, -0.18799161879915978200785287,
                    0.91966152301739985705089764, 0.26833009578175992495695523},
};

SPLITTING(splitting_3_mclachlan_atela, "splitting-3-mclachlan-atela", 3, 3, mclachlan_atela_3, 0,
          "smallest error of three stages (McLachlan & Atela 1992, doi:10.1088/0951-7715/5/2/011)");

/* The weights of yoshida_4 on position Verlet, which is another method than theirs on velocity
 * Verlet. J. Candy, W. Rozmus, J. Comput. Phys. 92 (1991) 230, doi:10.1016/0021-9991(91)90299-Z;
 * also Forest, Ruth (as above). */
static const dl_splitting_table candy_rozmus_4 = {
    .form = DL_FROM_DRIFT,
    .count = 7,
    .symmetric = true,
    .coefficient = {0.67560359597982881702384390, 1.3512071919596576340476878,
                    -0.17560359597982881702384390, -1.7024143839193152680953756},
};

SPLITTING(
    splitting_4_candy_rozmus, "splitting-4-candy-rozmus", 4, 3, candy_rozmus_4, DL_TIME_SYMMETRIC,
    "composition-4-yoshida from the drift (Candy & Rozmus 1991, doi:10.1016/0021-9991(91)90299-Z)");

/* (14 - sqrt(19))/108, 2/5, (20 - 7 sqrt(19))/108, -1/10. R. I. McLachlan (as above). */
static const dl_splitting_table mclachlan_4 = {
    .form = DL_FROM_KICK,
    .count = 11,
    .symmetric = true,
    .coefficient = {0.089269454226475244886694611, 0.4, -0.097336042636895508015359943, -0.1,
                    0.50806658841042026312866533, 0.4},
};

SPLITTING(splitting_4_mclachlan, "splitting-4-mclachlan", 4, 5, mclachlan_4, DL_TIME_SYMMETRIC,
          "splitting (McLachlan 1995, doi:10.1137/0916010)");

/* I. P. Omelyan, I. M. Mryglod, R. Folk, Comput. Phys. Commun. 146 (2002) 188,
 * doi:10.1016/S0010-4655(02)00451-4. */
static const dl_splitting_table vefrl = {
    .form = DL_FROM_KICK,
    .count = 9,
    .symmetric = true,
    .coefficient = {0.16449865155757597225920745, 0.52094333910398987973075632,
                    1.2356926511389170220539875, -0.020943339103989879730756322,
                    -1.8003826053929859886263899},
};

SPLITTING(splitting_4_vefrl, "splitting-4-vefrl", 4, 4, vefrl, DL_TIME_SYMMETRIC,
          "velocity version (Omelyan, Mryglod & Folk 2002, doi:10.1016/S0010-4655(02)00451-4)");

/* Omelyan, Mryglod, Folk (as above). */
static const dl_splitting_table pefrl = {
    .form = DL_FROM_DRIFT,
    .count = 9,
    .symmetric = true,
    .coefficient = {0.17861789584480906806090425, 0.71234183106260542548034291,
                    -0.066264582669818488316670940, -0.21234183106260542548034291,
                    0.77529337365001884051153339},
};

SPLITTING(splitting_4_pefrl, "splitting-4-pefrl", 4, 4, pefrl, DL_TIME_SYMMETRIC,
          "position version (Omelyan, Mryglod & Folk 2002, doi:10.1016/S0010-4655(02)00451-4)");

/* S_6 of S. Blanes, P. C. Moan, J. Comput. Appl. Math. 142 (2002) 313,
 * doi:10.1016/S0377-0427(01)00492-7. */
static const dl_splitting_table blanes_moan_4 = {
    .form = DL_FROM_KICK,
    .count = 13,
    .symmetric = true,
    .coefficient = {0.079203696431195674197649624, 0.20951510661336205297244999,
                    0.35317290604977403681866556, -0.14385177317981803796409630,
                    -0.042065080357719529215171581, 0.43433666656645598499164631,
                    0.21937695575349963639771280},
};

SPLITTING(splitting_4_blanes_moan, "splitting-4-blanes-moan", 4, 6, blanes_moan_4,
          DL_TIME_SYMMETRIC, "S_6 (Blanes & Moan 2002, doi:10.1016/S0377-0427(01)00492-7)");

/* S_10 of Blanes, Moan (as above). */
static const dl_splitting_table blanes_moan_6 = {
    .form = DL_FROM_KICK,
    .count = 21,
    .symmetric = true,
    .coefficient = {0.050262764400392722764635017, 0.14881644790104328045733825,
                    0.41351430042834347745413672, -0.13238586576778375614934697,
                    0.045079889794398111489861084, 0.067307604692184399240771486,
                    -0.18805485381956861849042528, 0.43266640257817371163358331,
                    0.54196067845078001236689219, -0.016404589403617635182346084,
                    -0.72552555850869141117019945},
};

SPLITTING(splitting_6_blanes_moan, "splitting-6-blanes-moan", 6, 10, blanes_moan_6,
          DL_TIME_SYMMETRIC, "S_10 (Blanes & Moan 2002, doi:10.1016/S0377-0427(01)00492-7)");

/* --- Runge-Kutta-Nystroem splittings ------------------------------------------------------------
 */

/* McLachlan, Atela (as above). */
static const dl_splitting_table rkn_mclachlan_atela_4 = {
    .form = DL_FROM_KICK,
    .count = 8,
    .coefficient = {0.13449619927743108920550646, 0.51535283743112293640017506,
                    -0.22481980307942080581718095, -0.085782019412973646070003407,
                    0.75632000051566829111249754, 0.44158302361646652425306128,
                    0.33400360328632142549917694, 0.12884615836538418541676707},
};

SPLITTING(rkn_4_mclachlan_atela, "rkn-4-mclachlan-atela", 4, 4, rkn_mclachlan_atela_4, 0,
          "Nystroem splitting (McLachlan & Atela 1992, doi:10.1088/0951-7715/5/2/011)");

/* M. P. Calvo, J. M. Sanz-Serna, SIAM J. Sci. Comput. 14 (1993) 936, doi:10.1137/0914057. */
static const dl_splitting_table rkn_calvo_4 = {
    .form = DL_FROM_KICK,
    .count = 9,
    .coefficient = {0.061758858135626324741038167, 0.20517766154228638658122071,
                    0.33897802655364335528732592, 0.40302128160421458734420228,
                    0.61479130717557756621428757, -0.12092087633891400847126503,
                    -0.14054801465937338003101589, 0.51272193319241303454584203,
                    0.12501982279452613378836422},
};

SPLITTING(rkn_4_calvo_sanz_serna, "rkn-4-calvo-sanz-serna", 4, 4, rkn_calvo_4, 0,
          "Nystroem splitting (Calvo & Sanz-Serna 1993, doi:10.1137/0914057)");

/* The kicks are -3/73, 17/59 and 1 - 2 (17/59 - 3/73). R. I. McLachlan (as above). */
static const dl_splitting_table rkn_mclachlan_4 = {
    .form = DL_FROM_DRIFT,
    .count = 11,
    .symmetric = true,
    .coefficient = {0.40518861839525227722055320, -0.041095890410958904109589041,
                    -0.28714404081652408899662779, 0.28813559322033898305084746,
                    0.38195542242127181177607459, 0.50592059438123984211748317},
};

SPLITTING(rkn_4_mclachlan, "rkn-4-mclachlan", 4, 5, rkn_mclachlan_4, DL_TIME_SYMMETRIC,
          "Nystroem splitting (McLachlan 1995, doi:10.1137/0916010)");

/* SRKN_6^b of Blanes, Moan (as above). */
static const dl_splitting_table rkn_blanes_moan_4 = {
    .form = DL_FROM_KICK,
    .count = 13,
    .symmetric = true,
    .coefficient = {0.082984406417404982334898567, 0.24529895718427112344865446,
                    0.39630980149836806185395464, 0.60487266571107992362618433,
                    -0.039056304922348437334305653, -0.35017162289535104707483879,
                    0.11952419401315078629090488},
};

SPLITTING(rkn_4_blanes_moan, "rkn-4-blanes-moan", 4, 6, rkn_blanes_moan_4, DL_TIME_SYMMETRIC,
          "SRKN_6^b (Blanes & Moan 2002, doi:10.1016/S0377-0427(01)00492-7)");

/* McLachlan, Atela (as above). */
static const dl_splitting_table rkn_mclachlan_atela_5 = {
    .form = DL_FROM_KICK,
    .count = 12,
    .coefficient = {0.11939002928756727579463618, 0.33983962583911000000025941,
                    0.69892737038247523083464904, -0.088601336903027328652540336,
                    -0.17131235827160077540753644, 0.58585647682596211881008744,
                    0.40126950225135344799582879, -0.60303935653649188819860700,
                    0.010705081848235983987381164, 0.32358079655469763932570494,
                    -0.058979625498031163204958733, 0.44236379421974945871509555},
};

SPLITTING(rkn_5_mclachlan_atela, "rkn-5-mclachlan-atela", 5, 6, rkn_mclachlan_atela_5, 0,
          "Nystroem splitting (McLachlan & Atela 1992, doi:10.1088/0951-7715/5/2/011)");

/* Method 13 of D. I. Okunbor, R. D. Skeel, J. Comput. Appl. Math. 51 (1994) 375,
 * doi:10.1016/0377-0427(92)00119-T, from the digits of McLachlan 1995 (as above). */
static const dl_splitting_table rkn_okunbor_skeel_6 = {
    .form = DL_FROM_DRIFT,
    .count = 15,
    .symmetric = true,
    .coefficient = {-1.0130879789171747298149046, 0.00016600692650009894217470724,
                    1.1874295737325427070242933, -0.37962421426377360608194691,
                    -0.018335852096460590344387488, 0.68913741185181063674080166,
                    0.34399425728109261313499875, 0.38064159097092574079794107},
};

SPLITTING(rkn_6_okunbor_skeel, "rkn-6-okunbor-skeel", 6, 7, rkn_okunbor_skeel_6, DL_TIME_SYMMETRIC,
          "method 13 (Okunbor & Skeel 1994, doi:10.1016/0377-0427(92)00119-T)");

/* SRKN_11^b of Blanes, Moan (as above). */
static const dl_splitting_table rkn_blanes_moan_6b = {
    .form = DL_FROM_KICK,
    .count = 23,
    .symmetric = true,
    .coefficient = {0.041464998518262842282544827, 0.12322977594627115016010760,
                    0.19812867191806652588900716, 0.29055379779955829115240994,
                    -0.040006192104152692780899303, -0.12704921262541699725688781,
                    0.075253984301580309449752124, -0.24633176106207543571270645,
                    -0.011511387420687756043808850, 0.35720887279592786333577008,
                    0.23666992478693077120340404, 0.20477705429147025664261331},
};

SPLITTING(rkn_6_blanes_moan_11, "rkn-6-blanes-moan-11", 6, 11, rkn_blanes_moan_6b,
          DL_TIME_SYMMETRIC, "SRKN_11^b (Blanes & Moan 2002, doi:10.1016/S0377-0427(01)00492-7)");

/* SRKN_14^a of Blanes, Moan (as above), whose printed digits hold to 4e-15. */
static const dl_splitting_table rkn_blanes_moan_6a = {
    .form = DL_FROM_DRIFT,
    .count = 29,
    .symmetric = true,
    .coefficient = {0.037859319840611016286515981, 0.091719152624462175415229451,
                    0.10263563310243660560858469, 0.18398317000500488227862434,
                    -0.025867888266558350325440152, -0.056534365832889169261431765,
                    0.31424140307144640930866779, 0.0049146887747118131180839830,
                    -0.13014445951741519701579109, 0.14376112716836184196926824,
                    0.10641770036954182948779949, 0.32856769374680345735665232,
                    -0.0087942431285101746326385126, -0.19641146648645500087642657,
                    0.20730506905689572256460361},
};

SPLITTING(rkn_6_blanes_moan_14, "rkn-6-blanes-moan-14", 6, 14, rkn_blanes_moan_6a,
          DL_TIME_SYMMETRIC, "SRKN_14^a (Blanes & Moan 2002, doi:10.1016/S0377-0427(01)00492-7)");
