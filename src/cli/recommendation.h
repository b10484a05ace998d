/* A recommendation as text and as JSON. */
#ifndef DL_CLI_RECOMMENDATION_H
#define DL_CLI_RECOMMENDATION_H

#include <stdio.h>
#include "driftlab/recommend.h"

void cli_recommendation_print(const dl_recommendation *found, FILE *out);
dl_status cli_recommendation_json(const dl_recommendation *found, FILE *out, dl_error *error);

/* That nothing reached the error, why, and what came nearest. */
void cli_recommendation_why_not(const dl_recommendation *found, dl_error *error);

#endif
