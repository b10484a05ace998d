/* One writer at a time: a lock beside a file, gone with the process that holds it. Processes that
 * this one forks do not hold it, so that it is free at once where this one is killed. */
#ifndef DL_IO_LOCK_H
#define DL_IO_LOCK_H

#include "driftlab/status.h"

typedef struct dl_lock {
    char *path; /* of the lock */
    int file;
    struct dl_lock *next; /* of those that are held */
} dl_lock;

/* DL_INPUT where another process holds it, DL_IO where the lock cannot be made. Release also after
 * a failure. */
dl_status dl_lock_take(dl_lock *lock, const char *path, dl_error *error);
void dl_lock_release(dl_lock *lock);

#endif
