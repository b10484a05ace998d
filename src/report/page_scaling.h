/* What a study of the kind `scaling` finds over all sizes, as JSON for its page. */
#ifndef DL_REPORT_PAGE_SCALING_H
#define DL_REPORT_PAGE_SCALING_H

#include <jansson.h>
#include "driftlab/results.h"

/* [{body, method, options, tolerance, particles: [], repeats: [], quantities: [{name, values: [],
 * deviations: [], from}], costs: [{name, values: [], exponent, low, high}]}, ...]: those of
 * driftlab/scaling.h of at least two sizes; `from` a number of particles or null; reals that are
 * not finite are null. Empty for other kinds. NULL: no memory. */
json_t *dl_page_scalings(const dl_results *results);

#endif
