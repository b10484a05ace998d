/* Findings of a scene by their verdict, for answers. */
#ifndef DL_STUDY_VERDICTS_H
#define DL_STUDY_VERDICTS_H

#include <stdbool.h>
#include <stdio.h>
#include "driftlab/results.h"

/* Whether the finding is of that scene and has that verdict (NULL: whichever). */
bool dl_verdict_is(const dl_finding *finding, const char *scene, const char *verdict);

size_t dl_verdict_count(const dl_results *results, const char *scene, const char *verdict);

/* Writes " (METHOD step=X, ... and 3 more)", the first few of them; nothing where there is none.
 * Without `fineness` methods alone, neighbours that are the same once. */
void dl_verdict_list(const dl_results *results, const char *scene, const char *verdict,
                     bool fineness, FILE *out);

#endif
