/* What `driftlab observe` prints. */
#ifndef DL_CLI_OBSERVED_H
#define DL_CLI_OBSERVED_H

#include <jansson.h>
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

/* The same frame by frame, as lines of CSV or as one JSON object. */
typedef struct cli_series {
    const cli_observed *observed;
    bool json;
    FILE *out;
    size_t rows;
    json_t *entries;
} cli_series;

void cli_series_begin(cli_series *series, const cli_observed *observed, bool json, FILE *out);
/* The frame that was added last to the observation; step -1: it has none. */
dl_status cli_series_add(cli_series *series, double time, long step, dl_error *error);
/* `status`: of the frames; nothing more is printed where they failed. */
dl_status cli_series_end(cli_series *series, dl_status status, dl_error *error);

/* What is said of the whole: file, scene, over what. */
json_t *cli_observed_head(const cli_observed *observed);
/* Rows of the scene, from 1, that have escaped, of the last frame; NULL where that is not observed.
 */
json_t *cli_observed_escaped(const cli_observed *observed);

#endif
