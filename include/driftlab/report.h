/* The report: one self-contained HTML page from a results file alone. */
#ifndef DRIFTLAB_REPORT_H
#define DRIFTLAB_REPORT_H

#include "driftlab/results.h"

/* Writes `path` (complete or not at all). */
dl_status dl_report_write(const dl_results *results, const char *path, dl_error *error);

#endif
