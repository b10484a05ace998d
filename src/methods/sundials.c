#include "methods/sundials.h"

#include <stdio.h>
#include <string.h>
#include <arkode/arkode_erkstep.h>
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

int dl_sundials_listen_erk(dl_sundials *sundials, void *memory) {
    return ERKStepSetErrHandlerFn(memory, on_message, sundials);
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
int dl_sundials_listen_erk(dl_sundials *sundials, void *memory) {
    (void)sundials;
    (void)memory;
    return 0;
}

int dl_sundials_listen_cvode(dl_sundials *sundials, void *memory) {
    return dl_sundials_listen_erk(sundials, memory);
}

int dl_sundials_listen_kinsol(dl_sundials *sundials, void *memory) {
    return dl_sundials_listen_erk(sundials, memory);
}

static int context_create(dl_sundials *sundials) {
    const int flag = SUNContext_Create(SUN_COMM_NULL, &sundials->context);
    if (flag)
        return flag;
    SUNContext_ClearErrHandlers(sundials->context);
    return SUNContext_PushErrHandler(sundials->context, on_message, sundials);
}

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

N_Vector dl_sundials_vector(dl_sundials *sundials, double *data, size_t length) {
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
