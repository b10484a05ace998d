/* Parts of a study side by side: processes that each do one part after another, one a processor,
 * and are handed the next as soon as they are ready. */
#ifndef DL_STUDY_LANES_H
#define DL_STUDY_LANES_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

typedef struct dl_lanes_work {
    /* In a lane: does the part and sends one message with dl_child_send(pipe, ...). */
    void (*work)(void *context, size_t part, int pipe);
    /* In the parent: a lane has been handed the part. */
    void (*begun)(void *context, size_t part);
    /* In the parent: the part's message, aligned for doubles. A failure ends every lane. */
    dl_status (*receive)(void *context, size_t part, const void *data, size_t size,
                         dl_error *error);
    /* In the parent, about five times a second. */
    void (*tick)(void *context);
    /* In the parent: a lane is lost, with the part it was doing (-1: none). May be NULL. */
    void (*lost)(void *context, size_t lane, long part);
    void *context;
    /* [lanes]: connections to processes elsewhere, which serve as lanes; -1: none, or lost. NULL:
     * lanes are forked. */
    int *socket;
    const volatile int *interrupt; /* non-zero: every lane of its own is killed. NULL ok */
} dl_lanes_work;

/* Does the parts [count] that are not `done`, in their order, and marks those that were. A lane
 * that is lost costs the part it was doing, which stays undone, and no other; without any lane left
 * the rest stays undone: DL_OK in both cases. */
dl_status dl_lanes_run(const dl_lanes_work *work, size_t lanes, size_t count, bool *done,
                       dl_error *error);

#endif
