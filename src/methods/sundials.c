#include "methods/sundials.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <arkode/arkode_arkstep.h>
#include <arkode/arkode_erkstep.h>
#if DL_SUNDIALS_AT_LEAST(6, 6)
#include <arkode/arkode_sprkstep.h>
#endif
#include <cvode/cvode.h>
#include <kinsol/kinsol.h>
#include <sundials/sundials_config.h>

/* --- messages: a handler for each solver up to 6.x, one for the context from 7.0 on ------------
 */

static void keep_message(dl_sundials *sundials, const char *function, const char *message) {
    snprintf(sundials->message, sizeof sundials->message, "%s: %s", function, message);
    for (char *c = sundials->message; *c; c++)
        if (*c == '\n')
            *c = ' ';
}

#if SUNDIALS_VERSION_MAJOR < 7

static void on_message(int flag, const char *module, const char *function, char *message,
                       void *data) {
    (void)module;
    if (flag < 0) /* positive: a warning */
        keep_message(data, function, message);
}

int dl_sundials_listen_arkode(dl_sundials *sundials, const dl_arkode_calls *calls, void *memory) {
    return calls->listen(memory, on_message, sundials);
}

int dl_sundials_listen_cvode(dl_sundials *sundials, void *memory) {
    return CVodeSetErrHandlerFn(memory, on_message, sundials);
}

int dl_sundials_listen_kinsol(dl_sundials *sundials, void *memory) {
    return KINSetErrHandlerFn(memory, on_message, sundials);
}

static int context_create(dl_sundials *sundials) {
    return SUNContext_Create(NULL, &sundials->context);
}

#else

static void on_message(int line, const char *function, const char *file, const char *message,
                       SUNErrCode flag, void *data, SUNContext context) {
    (void)line;
    (void)file;
    (void)flag;
    (void)context;
    keep_message(data, function, message ? message : "");
}

/* The context's handler hears every solver. */
int dl_sundials_listen_arkode(dl_sundials *sundials, const dl_arkode_calls *calls, void *memory) {
    (void)sundials, (void)calls, (void)memory;
    return 0;
}

int dl_sundials_listen_cvode(dl_sundials *sundials, void *memory) {
    (void)sundials, (void)memory;
    return 0;
}

int dl_sundials_listen_kinsol(dl_sundials *sundials, void *memory) {
    (void)sundials, (void)memory;
    return 0;
}

static int context_create(dl_sundials *sundials) {
    const int flag = SUNContext_Create(SUN_COMM_NULL, &sundials->context);
    if (flag)
        return flag;
    SUNContext_ClearErrHandlers(sundials->context);
    return SUNContext_PushErrHandler(sundials->context, on_message, sundials);
}

#endif

/* --- ARKODE's calls ----------------------------------------------------------------------------
 */

#if DL_SUNDIALS_AT_LEAST(7, 1)

#define IMPLICIT_CALLS                                                                             \
    .implicit = {                                                                                  \
        .set_nonlinear_solver = ARKodeSetNonlinearSolver,                                          \
        .set_linear_solver = ARKodeSetLinearSolver,                                                \
        .set_jacobian = ARKodeSetJacFn,                                                            \
        .set_jacobian_times = ARKodeSetJacTimes,                                                   \
        .set_preconditioner = ARKodeSetPreconditioner,                                             \
        .set_most_iterations = ARKodeSetMaxNonlinIters,                                            \
        .nonlinear_iterations = ARKodeGetNumNonlinSolvIters,                                       \
        .linear_iterations = ARKodeGetNumLinIters,                                                 \
        .set_ups = ARKodeGetNumLinSolvSetups,                                                      \
    }

#if DL_SUNDIALS_AT_LEAST(7, 2)
#define AS_INNER_STEPPER ARKodeCreateMRIStepInnerStepper
#else
#define AS_INNER_STEPPER ARKStepCreateMRIStepInnerStepper
#endif

#if DL_SUNDIALS_AT_LEAST(7, 4)
#define SET_COMPENSATED ARKodeSetUseCompensatedSums
#else
#define SET_COMPENSATED SPRKStepSetUseCompensatedSums
#endif

#define ANY_STEPPER                                                                                \
    .reset = ARKodeReset, .evolve = ARKodeEvolve, .set_user_data = ARKodeSetUserData,              \
    .set_tolerances = ARKodeSStolerances, .set_stop_time = ARKodeSetStopTime,                      \
    .set_fixed_step = ARKodeSetFixedStep, .set_first_step = ARKodeSetInitStep,                     \
    .set_most_steps = ARKodeSetMaxNumSteps, .set_most_attempts = ARKodeSetMaxErrTestFails,         \
    .set_interpolant_degree = ARKodeSetInterpolantDegree,                                          \
    .set_after_step = ARKodeSetPostprocessStepFn, .steps = ARKodeGetNumSteps,                      \
    .attempts = ARKodeGetNumStepAttempts, .current_step = ARKodeGetCurrentStep,                    \
    .as_inner_stepper = AS_INNER_STEPPER, .free = ARKodeFree, .set_relaxation = ARKodeSetRelaxFn,  \
    .set_relaxation_tolerance = ARKodeSetRelaxResTol,                                              \
    .set_most_relaxations = ARKodeSetRelaxMaxFails, .set_compensated = SET_COMPENSATED,            \
    IMPLICIT_CALLS

const dl_arkode_calls dl_erkstep_calls = {ANY_STEPPER};
const dl_arkode_calls dl_arkstep_calls = {ANY_STEPPER};
const dl_arkode_calls dl_mristep_calls = {ANY_STEPPER};
const dl_arkode_calls dl_sprkstep_calls = {ANY_STEPPER};

#else

/* What every stepper has. */
#define STEPPER(prefix)                                                                            \
    .reset = prefix##Reset, .evolve = prefix##Evolve, .set_user_data = prefix##SetUserData,        \
    .set_stop_time = prefix##SetStopTime, .set_fixed_step = prefix##SetFixedStep,                  \
    .set_most_steps = prefix##SetMaxNumSteps,                                                      \
    .set_interpolant_degree = prefix##SetInterpolantDegree,                                        \
    .set_after_step = prefix##SetPostprocessStepFn, .steps = prefix##GetNumSteps,                  \
    .free = prefix##Free LISTEN(prefix)

#if DL_SUNDIALS_AT_LEAST(7, 0)
#define LISTEN(prefix)
#else
#define LISTEN(prefix) , .listen = prefix##SetErrHandlerFn
#endif

#define ADAPTIVE_STEPPER(prefix)                                                                   \
    STEPPER(prefix),                                                                               \
        .set_tolerances = prefix##SStolerances, .set_first_step = prefix##SetInitStep,             \
        .set_most_attempts = prefix##SetMaxErrTestFails, .attempts = prefix##GetNumStepAttempts,   \
        .current_step = prefix##GetCurrentStep

#define IMPLICIT_STEPPER(prefix)                                                                   \
    .implicit = {                                                                                  \
        .set_nonlinear_solver = prefix##SetNonlinearSolver,                                        \
        .set_linear_solver = prefix##SetLinearSolver,                                              \
        .set_jacobian = prefix##SetJacFn,                                                          \
        .set_jacobian_times = prefix##SetJacTimes,                                                 \
        .set_preconditioner = prefix##SetPreconditioner,                                           \
        .set_most_iterations = prefix##SetMaxNonlinIters,                                          \
        .nonlinear_iterations = prefix##GetNumNonlinSolvIters,                                     \
        .linear_iterations = prefix##GetNumLinIters,                                               \
        .set_ups = prefix##GetNumLinSolvSetups,                                                    \
    }

const dl_arkode_calls dl_erkstep_calls = {
    ADAPTIVE_STEPPER(ERKStep),
#if DL_SUNDIALS_AT_LEAST(6, 6)
    .set_relaxation = ERKStepSetRelaxFn,
    .set_relaxation_tolerance = ERKStepSetRelaxResTol,
    .set_most_relaxations = ERKStepSetRelaxMaxFails,
#endif
};
const dl_arkode_calls dl_arkstep_calls = {
    ADAPTIVE_STEPPER(ARKStep),
    .as_inner_stepper = ARKStepCreateMRIStepInnerStepper,
    IMPLICIT_STEPPER(ARKStep),
};
const dl_arkode_calls dl_mristep_calls = {
    STEPPER(MRIStep),
    .set_tolerances = MRIStepSStolerances,
    IMPLICIT_STEPPER(MRIStep),
};
#if DL_SUNDIALS_AT_LEAST(6, 6)
const dl_arkode_calls dl_sprkstep_calls = {
    STEPPER(SPRKStep),
    .set_compensated = SPRKStepSetUseCompensatedSums,
};
#endif

#endif

/* --- context and vectors -----------------------------------------------------------------------
 */

dl_status dl_sundials_create(dl_sundials *sundials, dl_model *model, dl_error *error) {
    *sundials = (dl_sundials){.model = model};
    return context_create(sundials) ? dl_fail_memory(error, "a SUNDIALS context") : DL_OK;
}

void dl_sundials_destroy(dl_sundials *sundials) {
    if (sundials->context)
        SUNContext_Free(&sundials->context);
}

N_Vector dl_sundials_vector(const dl_sundials *sundials, double *data, size_t length) {
    return N_VMake_Serial((sunindextype)length, data, sundials->context);
}

/* --- failures ----------------------------------------------------------------------------------
 */

void dl_sundials_begin(dl_sundials *sundials) {
    sundials->model_status = DL_OK;
    sundials->message[0] = '\0';
}

/* A shorter step or another iterate may avoid a state without a finite acceleration, nothing else.
 */
static bool is_final(dl_status status) {
    return status != DL_OK && status != DL_UNSTABLE;
}

bool dl_sundials_has_failed(const dl_sundials *sundials) {
    return is_final(sundials->model_status);
}

int dl_sundials_answer(dl_sundials *sundials, dl_status status, const dl_error *error) {
    if (is_final(sundials->model_status))
        return -1;
    sundials->model_status = status;
    if (!status)
        return 0;
    sundials->model_error = *error;
    return is_final(status) ? -1 : 1;
}

int dl_sundials_rhs(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data) {
    (void)t;
    dl_sundials *const sundials = user_data;
    dl_error error;
    const dl_status status =
        dl_model_rhs(sundials->model, N_VGetArrayPointer(y), N_VGetArrayPointer(ydot), &error);
    return dl_sundials_answer(sundials, status, &error);
}

dl_status dl_sundials_fail(const dl_sundials *sundials, const dl_sundials_meaning *meanings,
                           int flag, const char *function, dl_error *error) {
    while (meanings->flag && meanings->flag != flag)
        meanings++;
    if (is_final(sundials->model_status) || (sundials->model_status && meanings->from_model))
        return dl_fail(error, sundials->model_status, "%s", sundials->model_error.message);
    const dl_status status = meanings->flag ? meanings->status : DL_ERROR;
    if (sundials->message[0])
        return dl_fail(error, status, "%s", sundials->message);
    return dl_fail(error, status, "%s failed with return code %d", function, flag);
}

bool dl_sundials_too_near(double t, double t_stop) {
    return fabs(t_stop - t) * fabs(t_stop - t) < DBL_MIN;
}

dl_status dl_sundials_fail_near(const char *method, double t, double t_stop, dl_error *error) {
    return dl_fail(
        error, DL_STEP_FAILURE,
        "%s cannot go from t = %.10g to %.10g: SUNDIALS multiplies times as short by one "
        "another, which leaves 0; expected %.3g or more between them",
        method, t, t_stop, sqrt(DBL_MIN));
}
