/* How SUNDIALS' integrators solve an implicit step of y' = (v, a(q)), CVODE's and ARKODE's alike:
 *
 *     fixed-point    functional iteration, Anderson-accelerated on request
 *     dense          Newton; I - gamma J factorised whole
 *     klu            Newton; the sparse I - gamma J factorised by KLU
 *     krylov         Newton; a Krylov method with the analytic product J v, preconditioned
 *     diagonal       CVODE's alone: Newton; difference quotients in place of a diagonal of J
 *
 * with J = [0 I; A 0] and A = d a / d q. Two of SUNDIALS' linear solvers have no place here: a band
 * solver, and preconditioners by it, since J couples a position with its velocity, half the length
 * of the state away, so that its band is as wide as itself; and conjugate gradients (PCG), since
 * I - gamma J is not symmetric. */
#ifndef DL_METHODS_IMPLICIT_H
#define DL_METHODS_IMPLICIT_H

#include "methods/options.h"
#include "methods/preconditioner.h"
#include "methods/sundials.h"

typedef enum dl_implicit_solver {
    DL_IMPLICIT_FIXED_POINT,
    DL_IMPLICIT_DENSE,
    DL_IMPLICIT_KLU,
    DL_IMPLICIT_KRYLOV,
    DL_IMPLICIT_DIAGONAL,
} dl_implicit_solver;

/* In the options of a method under the name `implicit`. */
typedef struct dl_implicit_options {
    int solver; /* dl_implicit_solver: an option, or what the row is for */
    long anderson;
    int krylov; /* index into dl_krylov_words */
    long krylov_dimension;
    int preconditioner; /* dl_preconditioner_kind */
} dl_implicit_options;

/* Solvers: those that CVODE and ARKODE both have. */
extern const char *const dl_implicit_solver_words[], *const dl_krylov_words[];

typedef struct dl_implicit {
    dl_sundials sundials; /* first: SUNDIALS' callbacks get this structure, or one that begins with
                           * it, as user_data */
    const dl_implicit_calls *calls;
    bool fast_alone; /* J is that of the fast part */
    SUNNonlinearSolver nonlinear;
    SUNLinearSolver linear;
    SUNMatrix matrix;
    bool factorises;       /* each set-up of the linear solver factorises the matrix */
    unsigned long pattern; /* generation of the sparsity that KLU analysed */
    double *values;        /* of A, [values_size] */
    size_t values_size;
    dl_preconditioner preconditioner;
} dl_implicit;

/* Attaches the solver to an integrator whose state is `state`; `sundials` is set before. Returns
 * the integrator's flag, ARK_MEM_FAIL where memory is out, ARK_LINIT_FAIL where the model has
 * failed. */
int dl_implicit_attach(dl_implicit *implicit, const dl_implicit_calls *calls, void *memory,
                       N_Vector state, const dl_implicit_options *options);

/* Adds what the integrator `memory` has counted since it was initialised. */
void dl_implicit_add_stats(const dl_implicit *implicit, void *memory, dl_method_stats *stats);

/* After the integrator's memory. */
void dl_implicit_free(dl_implicit *implicit);

/* --- options -----------------------------------------------------------------------------------
 */

#define DL_OPTION_SOLVER(type, text)                                                               \
    {                                                                                              \
        .name = "solver", .kind = DL_WORD, .offset = offsetof(type, implicit.solver), .unit = "",  \
        .words = dl_implicit_solver_words, .fallback = text,                                       \
        .doc = "of an implicit stage: fixed-point iteration, or Newton with a dense or sparse "    \
               "(klu) Jacobian or none (krylov)"                                                   \
    }

#define DL_OPTION_ANDERSON(type)                                                                   \
    {                                                                                              \
        .name = "anderson", .kind = DL_INTEGER, .offset = offsetof(type, implicit.anderson),       \
        .unit = "", .minimum = 0, .maximum = 20, .fallback = "0", .when = "solver=fixed-point",    \
        .doc = "depth of Anderson acceleration; 0: plain functional iteration"                     \
    }

#define DL_OPTIONS_KRYLOV(type)                                                                    \
    {                                                                                              \
        .name = "krylov",                                                                          \
        .kind = DL_WORD,                                                                           \
        .offset = offsetof(type, implicit.krylov),                                                 \
        .unit = "",                                                                                \
        .words = dl_krylov_words,                                                                  \
        .fallback = "gmres",                                                                       \
        .when = "solver=krylov",                                                                   \
        .doc = "which method: GMRES, flexible GMRES, BiCGStab or TFQMR",                           \
    },                                                                                             \
        {                                                                                          \
            .name = "krylov_dimension",                                                            \
            .kind = DL_INTEGER,                                                                    \
            .offset = offsetof(type, implicit.krylov_dimension),                                   \
            .unit = "",                                                                            \
            .minimum = 1,                                                                          \
            .maximum = 100,                                                                        \
            .fallback = "5",                                                                       \
            .when = "solver=krylov",                                                               \
            .doc = "largest dimension of its space: the most iterations it makes",                 \
        },                                                                                         \
    {                                                                                              \
        .name = "preconditioner", .kind = DL_WORD,                                                 \
        .offset = offsetof(type, implicit.preconditioner), .unit = "",                             \
        .words = dl_preconditioner_words, .fallback = "blocks", .when = "solver=krylov",           \
        .doc = "of I - gamma^2 A, which the system reduces to: none, the particles' own blocks, "  \
               "or all of it, by KLU"                                                              \
    }

#endif
