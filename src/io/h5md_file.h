/* H5MD files, of driftlab's own or another program's, as both readers of them open them. */
#ifndef DL_IO_H5MD_FILE_H
#define DL_IO_H5MD_FILE_H

#include <hdf5.h>
#include "driftlab/status.h"

enum { DL_H5MD_SPATIAL = 3 };

typedef struct dl_h5md_file {
    const char *path;
    hid_t file, particles, group; /* `group`: the first of /particles */
} dl_h5md_file;

#define DL_H5MD_CLOSED(path)                                                                       \
    { (path), H5I_INVALID_HID, H5I_INVALID_HID, H5I_INVALID_HID }

/* On failure, too, dl_h5md_close must follow. */
dl_status dl_h5md_open(dl_h5md_file *r, dl_error *error);
void dl_h5md_close(dl_h5md_file *r);

/* DL_INPUT: "PATH: found FOUND, expected EXPECTED". */
dl_status dl_h5md_refuse(const dl_h5md_file *r, dl_error *error, const char *found,
                         const char *expected);

/* A dataset [frame][particle][component]. */
typedef struct dl_h5md_vectors {
    hid_t data;
    hsize_t extent[3]; /* frames, particles, components */
} dl_h5md_vectors;

/* The caller closes opened->data where it is not negative. DL_INPUT where it is no such dataset,
 * or one without frames or particles, or not of 2 or 3 components. */
dl_status dl_h5md_open_vectors(const dl_h5md_file *r, const char *name, dl_h5md_vectors *opened,
                               dl_error *error);
/* Frame `number` as one component after the other, out [components * particles]. DL_INPUT where
 * one is not finite. */
dl_status dl_h5md_read_vectors(const dl_h5md_file *r, const dl_h5md_vectors *opened,
                               const char *name, hsize_t number, double *out, dl_error *error);

/* A text of driftlab's own /parameters, owned by the caller; NULL where there is none. */
char *dl_h5md_read_parameter(const dl_h5md_file *r, const char *name);

#endif
