/* Whole files: complete at their name, or not there. */
#ifndef DL_IO_REPLACE_FILE_H
#define DL_IO_REPLACE_FILE_H

#include <stddef.h>
#include "driftlab/status.h"

/* Writes PATH.tmp in the same folder, syncs it, renames it to `path` and syncs the folder. On
 * DL_IO the old file, if any, is untouched and PATH.tmp is gone. */
dl_status dl_replace_file(const char *path, const void *data, size_t size, dl_error *error);

#endif
