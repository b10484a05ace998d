/* An HDF5 file whose failing writes are kept for later.
 *
 * HDF5 1.10 cannot close a file after a failed write: handles stay behind, and the library crashes
 * at the end of the program. This driver writes to a descriptor, remembers the first failure,
 * discards what comes after it, and never tells HDF5; its owner looks at `error` instead. */
#ifndef DL_IO_SINK_H
#define DL_IO_SINK_H

#include <hdf5.h>

typedef struct dl_sink {
    int descriptor; /* open for reading and writing, empty; stays open when HDF5 closes the file */
    int error;      /* errno of the first failure; 0: none */
} dl_sink;

/* A file access property list for H5Fcreate (which ignores the name given to it); negative on
 * failure. The sink must live as long as the file. */
hid_t dl_sink_access(dl_sink *sink);

#endif
