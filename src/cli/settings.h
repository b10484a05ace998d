/* What the commands that run a method have in common: its options as the command line gives them,
 * and rows of their tables. */
#ifndef DL_CLI_SETTINGS_H
#define DL_CLI_SETTINGS_H

#include <math.h>
#include "cli/command.h"
#include "driftlab/status.h"

/* One setting and where it stands on the line: --dt X and --rtol X set "step" and "rtol". */
typedef struct cli_setting {
    const char *flag; /* "--dt", "--rtol", "--set" */
    char key[64];
    const char *value; /* in the input */
} cli_setting;

#define CLI_MAX_SETTINGS (CLI_MAX_REPEATED + 2)

/* dt, rtol: NULL where not given. DL_INPUT where --set sets again what another option sets. */
dl_status cli_settings_read(const cli_input *input, const char *dt, const char *rtol,
                            cli_setting settings[CLI_MAX_SETTINGS], size_t *count, dl_error *error);

/* A message that begins with `key`, "end: ", begins with `option`, "--t-end: ", instead: what was
 * given on the line is named as it was given. */
void cli_name_option(const char *key, const char *option, dl_error *error);

/* DL_INPUT where there is no --method. */
dl_status cli_settings_method(const char *method, dl_error *error);

/* Rows of a table for a structure `type` with members method, dt, rtol, t_end, time_limit, json. */
#define CLI_OPTION_METHOD(type)                                                                    \
    {                                                                                              \
        .name = "method", .kind = DL_TEXT, .offset = offsetof(type, method), .unit = "METHOD",     \
        .doc = "method, required (driftlab list methods)"                                          \
    }
#define CLI_OPTION_DT(type)                                                                        \
    {                                                                                              \
        .name = "dt", .kind = DL_TEXT, .offset = offsetof(type, dt), .unit = "X",                  \
        .doc = "fixed step; the same as --set step=X"                                              \
    }
#define CLI_OPTION_RTOL(type)                                                                      \
    {                                                                                              \
        .name = "rtol", .kind = DL_TEXT, .offset = offsetof(type, rtol), .unit = "X",              \
        .doc = "relative tolerance; the same as --set rtol=X"                                      \
    }
/* A real > 0, 0 where not given. */
#define CLI_OPTION_POSITIVE(type, name_, member, unit_, doc_)                                      \
    {                                                                                              \
        .name = name_, .kind = DL_REAL, .offset = offsetof(type, member), .unit = unit_,           \
        .minimum = 0, .maximum = INFINITY, .above_minimum = true, .doc = doc_                      \
    }
#define CLI_OPTION_T_END(type)                                                                     \
    CLI_OPTION_POSITIVE(type, "t-end", t_end, "T", "end of the run (default: the scene's)")
#define CLI_OPTION_TIME_LIMIT(type, doc_)                                                          \
    CLI_OPTION_POSITIVE(type, "time-limit", time_limit, "S", doc_)
#define CLI_OPTION_JSON(type)                                                                      \
    {                                                                                              \
        .name = "json", .kind = DL_FLAG, .offset = offsetof(type, json), .fallback = "false",      \
        .doc = "print one JSON object instead of a table"                                          \
    }

#endif
