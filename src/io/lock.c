#include "io/lock.h"

#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

/* Those that this process holds. */
static dl_lock *held;

/* A lock by flock belongs to what fork copies, too: it would outlive its process for as long as a
 * child does. */
static void let_go(void) {
    for (dl_lock *lock = held; lock; lock = lock->next)
        close(lock->file);
    held = NULL;
}

static void hold(dl_lock *lock) {
    static bool watches;
    if (!watches)
        watches = pthread_atfork(NULL, NULL, let_go) == 0;
    lock->next = held;
    held = lock;
}

static void forget(const dl_lock *lock) {
    for (dl_lock **at = &held; *at; at = &(*at)->next)
        if (*at == lock) {
            *at = lock->next;
            return;
        }
}

dl_status dl_lock_take(dl_lock *lock, const char *path, dl_error *error) {
    const size_t room = strlen(path) + sizeof ".lock";
    lock->file = -1;
    lock->path = malloc(room);
    if (!lock->path)
        return dl_fail_memory(error, "a file name");
    snprintf(lock->path, room, "%s.lock", path);
    lock->file = open(lock->path, O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (lock->file < 0)
        return dl_fail(error, DL_IO, "%s: cannot be written: %s", path, strerror(errno));
    if (flock(lock->file, LOCK_EX | LOCK_NB) == 0) {
        hold(lock);
        return DL_OK;
    }
    close(lock->file);
    lock->file = -1;
    return dl_fail(error, DL_INPUT,
                   "%s: another driftlab is writing it; wait for it, or name another", path);
}

void dl_lock_release(dl_lock *lock) {
    if (lock->file >= 0) {
        forget(lock);
        unlink(lock->path);
        close(lock->file);
    }
    free(lock->path);
}
