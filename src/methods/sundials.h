/* The one place that knows SUNDIALS' versions and conventions: context, vectors, messages, and how
 * its return codes and the model's failures become a dl_status. */
#ifndef DL_METHODS_SUNDIALS_H
#define DL_METHODS_SUNDIALS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h> /* for arkode_butcher.h, which leaves it out */
#include <arkode/arkode.h>
#include <arkode/arkode_butcher.h>
#include <arkode/arkode_ls.h>
#include <arkode/arkode_mristep.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_types.h>
#include "driftlab/model.h"
#include "driftlab/status.h"

#define DL_SUNDIALS_AT_LEAST(major, minor)                                                         \
    (SUNDIALS_VERSION_MAJOR > (major) ||                                                           \
     (SUNDIALS_VERSION_MAJOR == (major) && SUNDIALS_VERSION_MINOR >= (minor)))

/* A link between driftlab and one SUNDIALS solver. */
typedef struct dl_sundials {
    SUNContext context;
    dl_model *model;
    dl_status model_status;        /* the model's last answer since dl_sundials_begin */
    dl_error model_error;          /* where that was a failure */
    char message[DL_MESSAGE_SIZE]; /* SUNDIALS' own last message since then, or "" */
} dl_sundials;

/* What a solver's return code means. Tables end with flag 0. */
typedef struct dl_sundials_meaning {
    int flag;
    dl_status status;
    bool from_model; /* the model's own status and message say it better */
} dl_sundials_meaning;

/* How an integrator is told to solve an implicit step, and what it counts. CVODE's and ARKODE's
 * calls differ in name alone. */
typedef struct dl_implicit_calls {
    int (*set_nonlinear_solver)(void *memory, SUNNonlinearSolver solver);
    int (*set_linear_solver)(void *memory, SUNLinearSolver solver, SUNMatrix matrix);
    int (*set_jacobian)(void *memory, ARKLsJacFn jacobian);
    int (*set_jacobian_times)(void *memory, ARKLsJacTimesSetupFn set_up, ARKLsJacTimesVecFn times);
    int (*set_preconditioner)(void *memory, ARKLsPrecSetupFn set_up, ARKLsPrecSolveFn solve);
    int (*use_diagonal)(void *memory); /* CVODE has it, ARKODE has not: NULL */
    int (*set_most_iterations)(void *memory, int iterations);
    int (*nonlinear_iterations)(void *memory, long *count);
    int (*linear_iterations)(void *memory, long *count);
    int (*set_ups)(void *memory, long *count);
} dl_implicit_calls;

/* The calls of one of ARKODE's steppers: up to 7.0 each stepper has names of its own for them, from
 * 7.1 on they are the same functions. NULL where a stepper has none. */
typedef struct dl_arkode_calls {
    int (*reset)(void *memory, sunrealtype t, N_Vector y);
    int (*evolve)(void *memory, sunrealtype t_out, N_Vector y, sunrealtype *t, int task);
    int (*set_user_data)(void *memory, void *user_data);
    int (*set_tolerances)(void *memory, sunrealtype rtol, sunrealtype atol);
    int (*set_stop_time)(void *memory, sunrealtype t_stop);
    int (*set_fixed_step)(void *memory, sunrealtype step);
    int (*set_first_step)(void *memory, sunrealtype step);
    int (*set_most_steps)(void *memory, long steps);
    int (*set_most_attempts)(void *memory, int attempts);
    int (*set_interpolant_degree)(void *memory, int degree);
    int (*set_after_step)(void *memory, ARKPostProcessFn after_step);
    int (*steps)(void *memory, long *count);
    int (*attempts)(void *memory, long *count);
    int (*current_step)(void *memory, sunrealtype *step);
    int (*as_inner_stepper)(void *memory, MRIStepInnerStepper *stepper);
    void (*free)(void **memory);
    dl_implicit_calls implicit;
#if !DL_SUNDIALS_AT_LEAST(7, 0)
    int (*listen)(void *memory, ARKErrHandlerFn handler, void *data);
#endif
#if DL_SUNDIALS_AT_LEAST(6, 6)
    int (*set_relaxation)(void *memory, ARKRelaxFn energy, ARKRelaxJacFn gradient);
    int (*set_relaxation_tolerance)(void *memory, sunrealtype residual);
    int (*set_most_relaxations)(void *memory, int attempts);
    int (*set_compensated)(void *memory, int on);
#endif
} dl_arkode_calls;

extern const dl_arkode_calls dl_erkstep_calls, dl_arkstep_calls, dl_mristep_calls;
#if DL_SUNDIALS_AT_LEAST(6, 6)
extern const dl_arkode_calls dl_sprkstep_calls;
#endif

dl_status dl_sundials_create(dl_sundials *sundials, dl_model *model, dl_error *error);
/* Every solver, vector and matrix of this context must be gone before. */
void dl_sundials_destroy(dl_sundials *sundials);

/* A vector over `data` [length], which stays the caller's; NULL where memory is out. */
N_Vector dl_sundials_vector(const dl_sundials *sundials, double *data, size_t length);

/* Have the solver's messages kept here instead of printed. */
int dl_sundials_listen_arkode(dl_sundials *sundials, const dl_arkode_calls *calls, void *memory);
int dl_sundials_listen_cvode(dl_sundials *sundials, void *memory);
int dl_sundials_listen_kinsol(dl_sundials *sundials, void *memory);

/* Forget messages and failures: before each call of a solver. */
void dl_sundials_begin(dl_sundials *sundials);

/* Whether the model has answered since then with an error that no other attempt can mend. */
bool dl_sundials_has_failed(const dl_sundials *sundials);

/* What a callback returns to SUNDIALS after the model answered `status` with `error`, which are
 * kept: 0, 1 (a state without a finite acceleration: a shorter step may avoid it) or -1. After a -1
 * every further answer is -1, because SUNDIALS' fixed-point solver would go on (6.4.1). */
int dl_sundials_answer(dl_sundials *sundials, dl_status status, const dl_error *error);

/* y' = (v, a(q)) as SUNDIALS calls it; user_data begins with a dl_sundials. */
int dl_sundials_rhs(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data);

/* Status and message for a negative return code of `function`. */
dl_status dl_sundials_fail(const dl_sundials *sundials, const dl_sundials_meaning *meanings,
                           int flag, const char *function, dl_error *error);

/* Whether SUNDIALS, which multiplies times by one another, cannot tell t from t_stop: the product
 * is lost to underflow, and it says that t_stop is behind t. */
bool dl_sundials_too_near(double t, double t_stop);
/* Why a step failed that did so because of that. */
dl_status dl_sundials_fail_near(const char *method, double t, double t_stop, dl_error *error);

#endif
