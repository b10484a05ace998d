/* Options and rows of the conserving family. */
#include <stddef.h>

#include "methods/conserving.h"
#include "methods/conserving_predictor.h"
#include "methods/options.h"
#include "methods/registry.h"

/* --- options ------------------------------------------------------------------------------------
 */

static const char *const solver_words[] = {
    "auto",         "iteration",  "fixed-point",   "picard",
    "newton-dense", "newton-klu", "newton-krylov", NULL,
};

#define COMMON_OPTIONS                                                                             \
    DL_OPTION_FIXED_STEP(dl_conserving_options),                                                   \
        {.name = "tolerance",                                                                      \
         .kind = DL_REAL,                                                                          \
         .offset = offsetof(dl_conserving_options, tolerance),                                     \
         .unit = "",                                                                               \
         .minimum = 0,                                                                             \
         .maximum = 0.1,                                                                           \
         .fallback = "1e-15",                                                                      \
         .doc = "residual of a step's system allowed, as a part of its largest displacement; "     \
                "iteration also ends where roundoff lets the residual fall no further"},           \
        {.name = "iterations",                                                                     \
         .kind = DL_INTEGER,                                                                       \
         .offset = offsetof(dl_conserving_options, iterations),                                    \
         .unit = "",                                                                               \
         .minimum = 1,                                                                             \
         .maximum = 100000,                                                                        \
         .fallback = "100",                                                                        \
         .doc = "nonlinear iterations allowed in one attempt at a step"},                          \
        {.name = "predictor",                                                                      \
         .kind = DL_WORD,                                                                          \
         .offset = offsetof(dl_conserving_options, predictor),                                     \
         .unit = "",                                                                               \
         .words = dl_predictor_names,                                                              \
         .fallback = "octic",                                                                      \
         .doc = "first guess of a step's mean acceleration: at its start, or extrapolated from "   \
                "the steps before"},                                                               \
    {                                                                                              \
        .name = "rescue", .kind = DL_FLAG, .offset = offsetof(dl_conserving_options, rescue),      \
        .unit = "", .fallback = "true",                                                            \
        .doc = "where the solver fails at a step, another one tries"                               \
    }

#define DEPTH_OPTION                                                                               \
    {                                                                                              \
        .name = "depth", .kind = DL_INTEGER, .offset = offsetof(dl_conserving_options, depth),     \
        .unit = "", .minimum = -1, .maximum = 20, .fallback = "-1",                                \
        .when = "solver=fixed-point|picard",                                                       \
        .doc = "residuals that Anderson's acceleration combines; 0: none; -1: chosen by how "      \
               "strongly the iteration contracts"                                                  \
    }

/* nothing but what all have */
static const dl_parameter plain_options[] = {COMMON_OPTIONS};
static const dl_parameter fixed_point_options[] = {COMMON_OPTIONS, DEPTH_OPTION};
static const dl_parameter chosen_options[] = {
    COMMON_OPTIONS,
    DEPTH_OPTION,
    {
        .name = "solver",
        .kind = DL_WORD,
        .offset = offsetof(dl_conserving_options, solver),
        .unit = "",
        .words = solver_words,
        .fallback = "auto",
        .doc = "of a step's system; auto: chosen by the scene's size and stiffness and the step",
    },
};

/* --- rows ---------------------------------------------------------------------------------------
 */

static const double one_step[] = {1};

/* p = 1/(4 - 4^(1/3)): M. Suzuki, Phys. Lett. A 146 (1990) 319,
 * doi:10.1016/0375-9601(90)90962-N. */
#define SUZUKI_OUTER 0.41449077179437573714
static const double suzuki[] = {SUZUKI_OUTER, SUZUKI_OUTER, 1 - 4 * SUZUKI_OUTER, SUZUKI_OUTER,
                                SUZUKI_OUTER};

#define COMMON_FLAGS (DL_TIME_SYMMETRIC | DL_IMPLICIT | DL_FIXED_STEP)

#define CONSERVING_ROW(symbol, its_name, its_doc, its_order, its_parts, its_flags, its_options,    \
                       ...)                                                                        \
    const dl_method_row dl_method_##symbol = {                                                     \
        .name = its_name,                                                                          \
        .family = "conserving",                                                                    \
        .doc = its_doc,                                                                            \
        .order = its_order,                                                                        \
        .made_of = its_parts,                                                                      \
        .flags = COMMON_FLAGS | (its_flags),                                                       \
        .options = DL_OPTIONS_TABLE(its_options),                                                  \
        .options_size = sizeof(dl_conserving_options),                                             \
        .variant = &(const dl_conserving_variant){__VA_ARGS__},                                    \
        .ops = &dl_conserving_ops,                                                                 \
    }

#define A_FORCE "implicit, one discrete force an iteration"
#define SCHEME  "TR171's energy-conserving scheme, "
#define KEEPS   (DL_CONSERVES_ENERGY | DL_CONSERVES_MOMENTUM)
#define ONE     .stages = 1, .weight = one_step

CONSERVING_ROW(conserving, "conserving", SCHEME "its system's solver chosen by the scene", 2,
               A_FORCE, KEEPS, chosen_options, .by_option = true, ONE);
CONSERVING_ROW(conserving_iteration, "conserving-iteration",
               SCHEME "a plain fixed point that foretells its last residual", 2, A_FORCE, KEEPS,
               plain_options, .solver = DL_ITERATION, ONE);
CONSERVING_ROW(conserving_fixed_point, "conserving-fixed-point",
               SCHEME "KINSOL's fixed point with Anderson acceleration", 2, A_FORCE, KEEPS,
               fixed_point_options, .solver = DL_FIXED_POINT, ONE);
CONSERVING_ROW(conserving_picard, "conserving-picard",
               SCHEME "KINSOL's Picard iteration with the guess's sparse Jacobian (KLU)", 2,
               A_FORCE, KEEPS | DL_NEEDS_JACOBIAN, fixed_point_options, .solver = DL_PICARD, ONE);
CONSERVING_ROW(conserving_newton_dense, "conserving-newton-dense",
               SCHEME "KINSOL's Newton with a dense Jacobian", 2, A_FORCE,
               KEEPS | DL_NEEDS_JACOBIAN, plain_options, .solver = DL_NEWTON_DENSE, ONE);
CONSERVING_ROW(conserving_newton_klu, "conserving-newton-klu",
               SCHEME "KINSOL's Newton with a sparse Jacobian (KLU)", 2, A_FORCE,
               KEEPS | DL_NEEDS_JACOBIAN, plain_options, .solver = DL_NEWTON_KLU, ONE);
CONSERVING_ROW(conserving_newton_krylov, "conserving-newton-krylov",
               SCHEME "KINSOL's Newton-GMRES, analytic products, preconditioned by particle", 2,
               A_FORCE, KEEPS | DL_NEEDS_JACOBIAN, plain_options, .solver = DL_NEWTON_KRYLOV, ONE);
CONSERVING_ROW(conserving_4_suzuki, "conserving-4-suzuki",
               SCHEME "five steps composed (Suzuki 1990, doi:10.1016/0375-9601(90)90962-N)", 4,
               "five implicit steps, one discrete force an iteration", KEEPS, chosen_options,
               .by_option = true, .stages = 5, .weight = suzuki);
CONSERVING_ROW(
    conserving_gonzalez, "conserving-gonzalez",
    "midpoint discrete gradient (Gonzalez 1996, doi:10.1007/BF02440162); keeps energy and "
    "linear momentum",
    2, A_FORCE, DL_CONSERVES_ENERGY, chosen_options, .mean = DL_MEAN_GONZALEZ, .by_option = true,
    ONE);
CONSERVING_ROW(conserving_average_vector_field, "conserving-average-vector-field",
               "average vector field (Quispel and McLaren 2008, "
               "doi:10.1088/1751-8113/41/4/045206), by Gauss's rule of order 24; keeps energy and "
               "linear momentum",
               2, A_FORCE, DL_CONSERVES_ENERGY, chosen_options, .mean = DL_MEAN_AVERAGE,
               .by_option = true, ONE);
CONSERVING_ROW(implicit_midpoint, "implicit-midpoint",
               "implicit midpoint rule, by the conserving scheme's solvers: symplectic, for "
               "comparison",
               2, "implicit, one force an iteration", DL_SYMPLECTIC | DL_CONSERVES_MOMENTUM,
               chosen_options, .mean = DL_MEAN_MIDPOINT, .by_option = true, ONE);
