#include "io/replace_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static int write_all(int file, const char *data, size_t size) {
    while (size > 0) {
        ssize_t written = write(file, data, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written < 0)
            return -1;
        data += written;
        size -= (size_t)written;
    }
    return 0;
}

/* A file of its own at `path`, on the disk when this returns 0. */
static int write_synced(const char *path, const void *data, size_t size) {
    int file = open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (file < 0)
        return -1;
    int failed = write_all(file, data, size) || fsync(file);
    int reason = errno;
    if (close(file) && !failed) {
        failed = 1;
        reason = errno;
    }
    errno = reason;
    return failed ? -1 : 0;
}

/* The rename itself is on the disk only when its folder is. A file system that cannot sync folders
 * is no reason to fail: the file is complete. */
static void sync_folder(char *path) {
    char *slash = strrchr(path, '/');
    const char *folder = ".";
    if (slash) {
        slash[slash == path] = '\0';
        folder = path;
    }
    int handle = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (handle >= 0) {
        fsync(handle);
        close(handle);
    }
}

dl_status dl_replace_file(const char *path, const void *data, size_t size, dl_error *error) {
    size_t room = strlen(path) + sizeof ".tmp";
    char *temporary = malloc(room);
    if (!temporary)
        return dl_fail_memory(error, "a file name");
    snprintf(temporary, room, "%s.tmp", path);
    dl_status status = DL_OK;
    struct stat existing;
    if (stat(path, &existing) == 0 && !S_ISREG(existing.st_mode))
        status =
            dl_fail(error, DL_IO, "%s: cannot be written: it is there and no regular file", path);
    else if (write_synced(temporary, data, size) || rename(temporary, path)) {
        status = dl_fail(error, DL_IO, "%s: cannot be written: %s", path, strerror(errno));
        unlink(temporary);
    } else {
        sync_folder(temporary);
    }
    free(temporary);
    return status;
}
