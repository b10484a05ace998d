/* The findings of a study as JSON for its page. */
#ifndef DL_REPORT_PAGE_FINDINGS_H
#define DL_REPORT_PAGE_FINDINGS_H

#include <jansson.h>
#include "driftlab/results.h"

/* [{key, scene, ..., quantities: [{name, unit, value, low, high}], columns: [{name, unit}], rows:
 * [{word, values}]}, ...]; reals that are not finite are null. NULL: no memory. */
json_t *dl_page_findings(const dl_results *results);

/* A text as a JSON string: what is no UTF-8 becomes `?`. NULL: no memory. */
json_t *dl_page_text(const char *value);

#endif
