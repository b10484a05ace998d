/* The one place that knows SUNDIALS' versions and conventions: context, vectors, messages, and how
 * its return codes and the model's failures become a dl_status. */
#ifndef DL_METHODS_SUNDIALS_H
#define DL_METHODS_SUNDIALS_H

#include <stdbool.h>
#include <stddef.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sundials/sundials_types.h>
#include "driftlab/model.h"
#include "driftlab/status.h"

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

dl_status dl_sundials_create(dl_sundials *sundials, dl_model *model, dl_error *error);
/* Every solver, vector and matrix of this context must be gone before. */
void dl_sundials_destroy(dl_sundials *sundials);

/* A vector over `data` [length], which stays the caller's; NULL where memory is out. */
N_Vector dl_sundials_vector(dl_sundials *sundials, double *data, size_t length);

/* Have the solver's messages kept here instead of printed. */
int dl_sundials_listen_erk(dl_sundials *sundials, void *memory);
int dl_sundials_listen_cvode(dl_sundials *sundials, void *memory);
int dl_sundials_listen_kinsol(dl_sundials *sundials, void *memory);

/* Forget messages and failures: before each call of a solver. */
void dl_sundials_begin(dl_sundials *sundials);

/* What a callback returns to SUNDIALS after the model answered `status` with `error`, which are
 * kept: 0, 1 (a state without a finite acceleration: a shorter step may avoid it) or -1. After a -1
 * every further answer is -1, because SUNDIALS' fixed-point solver would go on (6.4.1). */
int dl_sundials_answer(dl_sundials *sundials, dl_status status, const dl_error *error);

/* y' = (v, a(q)) as SUNDIALS calls it; user_data begins with a dl_sundials. */
int dl_sundials_rhs(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data);

/* Status and message for a negative return code of `function`. */
dl_status dl_sundials_fail(const dl_sundials *sundials, const dl_sundials_meaning *meanings,
                           int flag, const char *function, dl_error *error);

#endif
