/* The report: one self-contained HTML page from a results file alone. */
#ifndef DRIFTLAB_REPORT_H
#define DRIFTLAB_REPORT_H

#include <stddef.h>
#include "driftlab/results.h"

/* Writes `path` (complete or not at all). */
dl_status dl_report_write(const dl_results *results, const char *path, dl_error *error);

/* The same with players of `count` trajectories (H5MD files that driftlab wrote; see picture.h). */
dl_status dl_report_write_with_players(const dl_results *results, const char *const *trajectory,
                                       size_t count, const char *path, dl_error *error);

#endif
