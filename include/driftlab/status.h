/* Status codes and messages: the one way a driftlab function fails.
 *
 * Every function that can fail returns a dl_status and takes a `dl_error *` (NULL: the caller does
 * not want the message). Nothing in the library prints, exits or aborts. */
#ifndef DRIFTLAB_STATUS_H
#define DRIFTLAB_STATUS_H

/* X(symbol, name as printed and stored) */
#define DL_STATUSES(X)                                                                             \
    X(OK, "ok")             /* it did what was asked */                                            \
    X(UNSTABLE, "unstable") /* force, state or energy no longer finite/bounded */                  \
    X(NONLINEAR_FAILURE, "nonlinear-failure") /* an implicit step's system was not solved */       \
    X(STEP_FAILURE, "step-failure")           /* the method cannot take a step (step collapsed) */ \
    X(TIMEOUT, "timeout")                     /* the limit on time was reached */                  \
    X(INTERRUPTED, "interrupted")             /* SIGINT or SIGTERM */                              \
    X(INPUT, "input")                         /* a file, option or value given by the user */      \
    X(IO, "io")                               /* reading or writing failed */                      \
    X(MEMORY, "memory")                       /* an allocation failed */                           \
    X(ERROR, "error")                         /* anything else */

typedef enum dl_status {
#define DL_STATUS_ENUM(symbol, name) DL_##symbol,
    DL_STATUSES(DL_STATUS_ENUM)
#undef DL_STATUS_ENUM
} dl_status;

#define DL_MESSAGE_SIZE 1024

typedef struct dl_error {
    char message[DL_MESSAGE_SIZE]; /* one line, no newline at the end; "" where nothing failed */
} dl_error;

/* Name of a status ("ok", "nonlinear-failure", ...); never NULL. */
const char *dl_status_name(dl_status status);

/* Status of that name; DL_ERROR for a name that is none. */
dl_status dl_status_from_name(const char *name);

/* Writes the message (if error is not NULL) and returns `status`, so that a failure is one line:
 *     return dl_fail(error, DL_INPUT, "%s:%d: ...", file, line); */
dl_status dl_fail(dl_error *error, dl_status status, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* The same, for DL_MEMORY: names what was to be allocated. */
dl_status dl_fail_memory(dl_error *error, const char *what);

#ifdef __clang_analyzer__ /* sees one file at a time: what they return */
#define dl_fail(error, status, ...) (dl_fail((error), (status), __VA_ARGS__), (status))
#define dl_fail_memory(error, what) (dl_fail_memory((error), (what)), DL_MEMORY)
#endif

#endif
