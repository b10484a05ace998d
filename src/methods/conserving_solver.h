/* KINSOL, or a plain iteration, on the system of a conserving step:
 *
 *     delta = h v + (h^2/2) a(q, q + delta)
 *
 * with the mean acceleration a that the model has been given (dl_model_set_mean). */
#ifndef DL_METHODS_CONSERVING_SOLVER_H
#define DL_METHODS_CONSERVING_SOLVER_H

#include <kinsol/kinsol.h>
#include <stdbool.h>
#include <sundials/sundials_linearsolver.h>
#include <sundials/sundials_matrix.h>

#include "methods/sundials.h"

typedef enum dl_solver_kind {
    DL_ITERATION,     /* a plain fixed point, without KINSOL: conserving_iteration.c */
    DL_FIXED_POINT,   /* with Anderson's acceleration */
    DL_PICARD,        /* the same, preconditioned by I - (h^2/2) da/ddelta of the guess (KLU) */
    DL_NEWTON_DENSE,  /* analytic Jacobian, LU */
    DL_NEWTON_KLU,    /* the same, sparse */
    DL_NEWTON_KRYLOV, /* GMRES with analytic products, preconditioned by the particles' own blocks
                       */
} dl_solver_kind;

/* "fixed-point", ...: as rows and options call them. */
extern const char *const dl_solver_names[];

/* The step to be solved. Arrays [n] belong to the method. */
typedef struct dl_conserving_step {
    size_t n;
    double h;
    const double *q, *v;
    double *delta; /* in: a first guess; out: the solution, or its image under the iteration */
    double *a;     /* out: mean acceleration at the solution */
    double size;   /* of the displacement: what residuals are measured by, > 0 */
    double floor;  /* residual that is roundoff of the positions, however small the displacement */
} dl_conserving_step;

typedef struct dl_conserving_counts {
    unsigned long iterations, linear_iterations, factorisations;
    unsigned long inexact; /* steps accepted at roundoff, above the tolerance */
} dl_conserving_counts;

typedef struct dl_conserving_settings {
    dl_solver_kind kind;
    double tolerance;   /* residual allowed, as a part of the step's size */
    long iterations;    /* nonlinear, in one attempt */
    long depth;         /* residuals that Anderson's acceleration combines */
    double contraction; /* what a fixed-point iteration leaves of a residual; 1 where that is not
                           known */
} dl_conserving_settings;

typedef struct dl_conserving_solver {
    dl_sundials sundials; /* first: KINSOL's callbacks get this structure as user_data */
    dl_conserving_settings settings;
    dl_conserving_step step;
    dl_conserving_counts counts;
    void *kinsol;
    N_Vector delta, scale, guess, spare;
    SUNMatrix matrix;
    SUNLinearSolver linear;
    int (*factorise)(SUNLinearSolver linear, SUNMatrix matrix); /* its own */
    bool is_frozen;        /* the factorisation is not to be made again */
    double *image;         /* [n]: of the plain iteration */
    bool jumps;            /* the scene's force does, somewhere */
    unsigned long pattern; /* generation of the sparse matrix's */
    double *values;        /* Jacobian entries */
    size_t values_capacity;
    double *block;             /* of the preconditioner, inverted, by particle */
    bool is_factorised;        /* once, at least; for GMRES: its products are prepared */
    bool factorisation_serves; /* the last one still does for the next step */
    double last;               /* residual at the last displacement tried */
    double best;               /* smallest residual of this step so far */
    int since_best;            /* evaluations without a smaller one */
    bool stalled;              /* given up before KINSOL would have */
} dl_conserving_solver;

/* Free also where this fails. */
dl_status dl_conserving_solver_create(dl_conserving_solver *solver, dl_model *model,
                                      const dl_conserving_settings *settings,
                                      const dl_conserving_step *step, dl_error *error);
void dl_conserving_solver_free(dl_conserving_solver *solver);

/* Solves from the guess in step.delta. DL_NONLINEAR_FAILURE with the residual reached. */
dl_status dl_conserving_solve(dl_conserving_solver *solver, dl_error *error);

#endif
