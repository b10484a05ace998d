/* What `driftlab observe` prints. */
#ifndef DL_CLI_OBSERVED_H
#define DL_CLI_OBSERVED_H

#include <stdio.h>
#include "driftlab/observe.h"

/* What was observed. */
typedef struct cli_observed {
    const char *file;
    const dl_scene *scene;
    size_t frames;
    double from, to; /* times of the first and the last frame */
    const dl_temperature_rule *temperature;
    const dl_observation *observation;
} cli_observed;

void cli_observed_table(const cli_observed *observed, FILE *out);
dl_status cli_observed_json(const cli_observed *observed, FILE *out, dl_error *error);

#endif
