#include "io/sink.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* What HDF5 calls a file. */
typedef struct sink_file {
    H5FD_t base; /* HDF5's part: first */
    dl_sink *sink;
    haddr_t allocated, written; /* ends of both, in bytes */
} sink_file;

typedef struct sink_info {
    dl_sink *sink;
} sink_info;

static H5FD_t *sink_open(const char *name, unsigned flags, hid_t access, haddr_t most) {
    (void)name;
    (void)flags;
    (void)most;
    const sink_info *info = H5Pget_driver_info(access);
    sink_file *file = info ? calloc(1, sizeof *file) : NULL;
    if (!file)
        return NULL;
    file->sink = info->sink;
    return &file->base;
}

static herr_t sink_close(H5FD_t *base) {
    free(base);
    return 0;
}

static herr_t sink_query(const H5FD_t *base, unsigned long *flags) {
    (void)base;
    *flags = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA | H5FD_FEAT_DATA_SIEVE |
             H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

static haddr_t sink_allocated(const H5FD_t *base, H5FD_mem_t type) {
    (void)type;
    return ((const sink_file *)base)->allocated;
}

static herr_t sink_allocate(H5FD_t *base, H5FD_mem_t type, haddr_t end) {
    (void)type;
    ((sink_file *)base)->allocated = end;
    return 0;
}

static haddr_t sink_written(const H5FD_t *base, H5FD_mem_t type) {
    (void)type;
    return ((const sink_file *)base)->written;
}

static herr_t sink_read(H5FD_t *base, H5FD_mem_t type, hid_t transfer, haddr_t from, size_t size,
                        void *buffer) {
    (void)type;
    (void)transfer;
    const sink_file *file = (const sink_file *)base;
    char *to = buffer;
    while (size > 0) {
        const ssize_t got = pread(file->sink->descriptor, to, size, (off_t)from);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return -1;
        if (got == 0) { /* what was not written reads as zeros */
            memset(to, 0, size);
            break;
        }
        to += got;
        from += (haddr_t)got;
        size -= (size_t)got;
    }
    return 0;
}

static void write_bytes(dl_sink *sink, haddr_t to, size_t size, const char *from) {
    while (size > 0 && !sink->error) {
        const ssize_t put = pwrite(sink->descriptor, from, size, (off_t)to);
        if (put < 0 && errno != EINTR)
            sink->error = errno;
        if (put <= 0)
            continue;
        from += put;
        to += (haddr_t)put;
        size -= (size_t)put;
    }
}

static herr_t sink_write(H5FD_t *base, H5FD_mem_t type, hid_t transfer, haddr_t to, size_t size,
                         const void *buffer) {
    (void)type;
    (void)transfer;
    sink_file *file = (sink_file *)base;
    write_bytes(file->sink, to, size, buffer);
    if (to + size > file->written)
        file->written = to + size;
    return 0;
}

static herr_t sink_truncate(H5FD_t *base, hid_t transfer, hbool_t closing) {
    (void)transfer;
    (void)closing;
    sink_file *file = (sink_file *)base;
    if (file->written != file->allocated && !file->sink->error &&
        ftruncate(file->sink->descriptor, (off_t)file->allocated) != 0)
        file->sink->error = errno;
    file->written = file->allocated;
    return 0;
}

static const H5FD_class_t driver = {
    .name = "driftlab-sink",
    .maxaddr = (haddr_t)1 << 62,
    .fc_degree = H5F_CLOSE_STRONG,
    .fapl_size = sizeof(sink_info),
    .open = sink_open,
    .close = sink_close,
    .query = sink_query,
    .get_eoa = sink_allocated,
    .set_eoa = sink_allocate,
    .get_eof = sink_written,
    .read = sink_read,
    .write = sink_write,
    .truncate = sink_truncate,
    .fl_map = H5FD_FLMAP_DICHOTOMY,
};

hid_t dl_sink_access(dl_sink *sink) {
    const sink_info info = {sink};
    const hid_t access = H5Pcreate(H5P_FILE_ACCESS), registered = H5FDregister(&driver);
    const herr_t set = H5Pset_driver(access, registered, &info);
    H5FDunregister(registered);
    if (set >= 0)
        return access;
    H5Pclose(access);
    return H5I_INVALID_HID;
}
