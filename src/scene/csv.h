/* Data files: comma-separated cells, one row a line. Blank lines and lines that start with # are
 * passed over; blanks around a cell do not belong to it. */
#ifndef DL_SCENE_CSV_H
#define DL_SCENE_CSV_H

#include <stdbool.h>
#include <stdio.h>
#include "driftlab/status.h"

typedef struct dl_csv {
    const char *path; /* the caller's */
    FILE *stream;
    int line; /* of the row read last */
    size_t cells;
    char **cell; /* [cells], until the next row */
    char *buffer;
    size_t buffer_size, cell_room;
} dl_csv;

/* On failure there is nothing to close. */
dl_status dl_csv_open(const char *path, dl_csv *csv, dl_error *error);

/* The next row; *found is false at the end of the file. */
dl_status dl_csv_next(dl_csv *csv, bool *found, dl_error *error);

void dl_csv_close(dl_csv *csv);

#endif
