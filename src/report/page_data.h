/* What the page is made from: the results as one JSON text. */
#ifndef DRIFTLAB_REPORT_PAGE_DATA_H
#define DRIFTLAB_REPORT_PAGE_DATA_H

#include <stddef.h>
#include "driftlab/results.h"

/* A case with more samples than this is thinned for the page: of each group of neighbours the one
 * with the largest energy error stays. */
#define DL_PAGE_SAMPLES 500

/* Of `count` studies of one kind, on different scenes. *json is owned by the caller (free). Reals
 * that are not finite are null, energy errors are relative to the energy scale, and no `<` is left
 * in the text, so that it can stand inside <script>. */
dl_status dl_page_data(const dl_results *const *results, size_t count, const char *title,
                       char **json, dl_error *error);

#endif
