#include "io/lock.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

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
    if (flock(lock->file, LOCK_EX | LOCK_NB) == 0)
        return DL_OK;
    close(lock->file);
    lock->file = -1;
    return dl_fail(error, DL_INPUT, "%s: another driftlab is writing it; wait for it, or name another",
                   path);
}

void dl_lock_release(dl_lock *lock) {
    if (lock->file >= 0) {
        unlink(lock->path);
        close(lock->file);
    }
    free(lock->path);
}
