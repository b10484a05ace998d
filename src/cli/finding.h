/* A finding measured in the foreground, and as a table for people or JSON for programs. */
#ifndef DL_CLI_FINDING_H
#define DL_CLI_FINDING_H

#include <stdio.h>
#include "cli/command.h"
#include "driftlab/study.h"

/* What a command line asks; numbers are 0 and texts NULL where it does not say. */
typedef struct cli_measurement {
    const char *kind, *scene, *method, *dt, *rtol;
    double end, sample, seconds;
} cli_measurement;

/* Measures with the input's --set, with progress on a terminal, stopped by SIGINT and SIGTERM. */
dl_status cli_measure(const cli_input *input, const cli_measurement *asked, dl_finding *finding,
                      dl_error *error);

/* Verdict, reason and quantities, with their scene above them. */
void cli_finding_summary(const dl_finding *finding, FILE *out);
/* The finding's table, if it has one. */
void cli_finding_table(const dl_finding *finding, FILE *out);
/* One object; reals with 17 digits, null where they do not apply. */
dl_status cli_finding_json(const dl_finding *finding, FILE *out, dl_error *error);

#endif
