#include "driftlab/status.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

static const char *const names[] = {
#define DL_STATUS_NAME(symbol, name) [DL_##symbol] = name,
    DL_STATUSES(DL_STATUS_NAME)
#undef DL_STATUS_NAME
};

static const size_t name_count = sizeof names / sizeof *names;

const char *dl_status_name(dl_status status) {
    return (size_t)status < name_count ? names[status] : names[DL_ERROR];
}

dl_status dl_status_from_name(const char *name) {
    for (size_t i = 0; i < name_count; i++)
        if (strcmp(names[i], name) == 0)
            return (dl_status)i;
    return DL_ERROR;
}

#undef dl_fail /* the macros for the analyzer */
#undef dl_fail_memory

dl_status dl_fail(dl_error *error, dl_status status, const char *format, ...) {
    if (error) {
        va_list arguments;
        va_start(arguments, format);
        vsnprintf(error->message, sizeof error->message, format, arguments);
        va_end(arguments);
    }
    return status;
}

dl_status dl_fail_memory(dl_error *error, const char *what) {
    return dl_fail(error, DL_MEMORY, "out of memory for %s", what);
}
