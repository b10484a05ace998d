/* Work in a child process with limits on time and memory: whatever it does, the parent goes on. */
#ifndef DL_STUDY_CHILD_H
#define DL_STUDY_CHILD_H

#include <stddef.h>
#include "driftlab/status.h"

typedef struct dl_child_work {
    /* In the child. Sends what it finds with dl_child_send(pipe, ...). It must not touch files of
     * the parent's; when it returns the child ends, without the parent's exit handlers. */
    void (*work)(void *context, int pipe);
    /* In the parent, for every message, whole and in order; `data` is aligned for doubles and holds
     * for the call. A failure kills the child. */
    dl_status (*receive)(void *context, const void *data, size_t size, dl_error *error);
    /* In the parent, about five times a second. May be NULL. */
    void (*tick)(void *context);
    void *context;
    double seconds;                /* CPU time the child may use from one message to the next */
    long memory;                   /* MiB of address space; 0: as much as the parent may use */
    const volatile int *interrupt; /* non-zero: kill. May be NULL */
} dl_child_work;

/* Sends one message; the child ends at once where the parent is gone. */
void dl_child_send(int pipe, const void *data, size_t size);

/* DL_OK: the child ended of itself. DL_TIMEOUT: killed after 2 * seconds + 1 of CPU time (or a
 * generous time by the wall clock) without a message. DL_INTERRUPTED. DL_ERROR: it was ended by a
 * signal, which the message names. DL_IO, DL_MEMORY: it could not be started. */
dl_status dl_child_run(const dl_child_work *work, dl_error *error);

#endif
