#include "scene/csv.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>

/* Some spreadsheets put it before the first name. */
static const char byte_order_mark[] = "\xef\xbb\xbf";

dl_status dl_csv_open(const char *path, dl_csv *csv, dl_error *error) {
    *csv = (dl_csv){.path = path, .stream = fopen(path, "r")};
    if (!csv->stream)
        return dl_fail(error, DL_INPUT, "%s: %s", path, strerror(errno));
    return DL_OK;
}

void dl_csv_close(dl_csv *csv) {
    fclose(csv->stream);
    free(csv->buffer);
    free(csv->cell);
}

static bool blank(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}

static char *trimmed(char *text) {
    while (blank(*text))
        text++;
    size_t length = strlen(text);
    while (length > 0 && blank(text[length - 1]))
        length--;
    text[length] = '\0';
    return text;
}

static dl_status split(dl_csv *csv, char *row, dl_error *error) {
    csv->cells = 0;
    while (row) {
        if (csv->cells == csv->cell_room) {
            const size_t room = csv->cell_room ? 2 * csv->cell_room : 16;
            char **const cell = realloc(csv->cell, room * sizeof *cell);
            if (!cell)
                return dl_fail_memory(error, csv->path);
            csv->cell = cell;
            csv->cell_room = room;
        }
        char *const comma = strchr(row, ',');
        if (comma)
            *comma = '\0';
        csv->cell[csv->cells++] = trimmed(row);
        row = comma ? comma + 1 : NULL;
    }
    return DL_OK;
}

dl_status dl_csv_next(dl_csv *csv, bool *found, dl_error *error) {
    *found = false;
    for (;;) {
        errno = 0;
        const ssize_t length = getline(&csv->buffer, &csv->buffer_size, csv->stream);
        if (length < 0)
            break;
        csv->line++;
        if (strlen(csv->buffer) != (size_t)length)
            return dl_fail(error, DL_INPUT, "%s:%d: found a zero byte, expected text", csv->path,
                           csv->line);
        const bool marked = csv->line == 1 && strncmp(csv->buffer, byte_order_mark, 3) == 0;
        char *const row = trimmed(csv->buffer + (marked ? 3 : 0));
        if (*row && *row != '#') {
            *found = true;
            return split(csv, row, error);
        }
    }
    if (!feof(csv->stream))
        return dl_fail(error, errno == ENOMEM ? DL_MEMORY : DL_INPUT, "%s: %s", csv->path,
                       strerror(errno));
    return DL_OK;
}
