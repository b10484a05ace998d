/* A run's summary as a table for people and as JSON for programs, from one table of its fields. */
#ifndef DL_CLI_SUMMARY_H
#define DL_CLI_SUMMARY_H

#include <stdio.h>
#include "driftlab/run.h"

void cli_summary_table(const dl_scene *scene, const dl_method_row *row, const char *options,
                       const dl_run_summary *summary, FILE *out);

/* One object; reals with 17 digits, null where they do not apply. */
dl_status cli_summary_json(const dl_scene *scene, const dl_method_row *row, const void *options,
                           const dl_run_summary *summary, FILE *out, dl_error *error);

#endif
