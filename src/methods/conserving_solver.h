/* KINSOL on the system of a conserving step:
 *
 *     delta = h v + (h^2/2) a(q, q + delta)
 *
 * by fixed-point iteration with Anderson's acceleration, or by Newton's method with line search and
 * the analytic Jacobian, dense or sparse (KLU). */
#ifndef DL_METHODS_CONSERVING_SOLVER_H
#define DL_METHODS_CONSERVING_SOLVER_H

#include <kinsol/kinsol.h>
#include <stdbool.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include "methods/sundials.h"

typedef enum dl_solver_kind { DL_FIXED_POINT, DL_NEWTON_DENSE, DL_NEWTON_KLU } dl_solver_kind;

/* The step to be solved. Arrays [n] belong to the method. */
typedef struct dl_conserving_step {
    size_t n;
    double h;
    const double *q, *v;
    double *delta; /* in: a first guess; out: the solution */
    double *a;     /* out: mean acceleration at the solution */
    double size;   /* of the displacement: what residuals are measured by, > 0 */
} dl_conserving_step;

typedef struct dl_conserving_solver {
    dl_sundials sundials; /* first: KINSOL's callbacks get this structure as user_data */
    dl_solver_kind kind;
    dl_conserving_step step;
    void *kinsol;
    double tolerance; /* residual allowed, as a part of the step's size */
    N_Vector delta, scale, image;
    SUNMatrix matrix;
    SUNLinearSolver linear;
    unsigned long pattern; /* generation of the sparse matrix's */
    double *values;        /* Jacobian entries */
    size_t values_capacity;
    double last;                              /* residual at the last displacement tried */
    double best;                              /* smallest residual of this step so far */
    int since_best;                           /* evaluations without a smaller one */
    bool stalled;                             /* given up before KINSOL would have */
    unsigned long iterations, factorisations; /* totals */
} dl_conserving_solver;

/* `depth`: residuals that Anderson's acceleration combines; `tolerance`: residual allowed as a part
 * of the step's size. Free also where this fails. */
dl_status dl_conserving_solver_create(dl_conserving_solver *solver, dl_model *model,
                                      dl_solver_kind kind, const dl_conserving_step *step,
                                      double tolerance, long iterations, long depth,
                                      dl_error *error);
void dl_conserving_solver_free(dl_conserving_solver *solver);

/* Solves from the guess in step.delta. DL_NONLINEAR_FAILURE with the residual reached. */
dl_status dl_conserving_solve(dl_conserving_solver *solver, dl_error *error);

#endif
