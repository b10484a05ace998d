/* The report: one self-contained HTML page from results files alone. */
#ifndef DRIFTLAB_REPORT_H
#define DRIFTLAB_REPORT_H

#include <stddef.h>
#include "driftlab/results.h"

/* What is on a page. */
typedef struct dl_report {
    const dl_results *const *results; /* [studies]: of one kind, each scene in one of them */
    size_t studies;
    const char *title;             /* NULL: the only study's own, or the scenes' names */
    const char *const *trajectory; /* [trajectories]: H5MD files that driftlab wrote, to be played
                                      (picture.h) */
    size_t trajectories;
} dl_report;

/* Writes `path` (complete or not at all). DL_INPUT where the studies do not go on one page. */
dl_status dl_report_write_page(const dl_report *report, const char *path, dl_error *error);

/* The page of one study. */
dl_status dl_report_write(const dl_results *results, const char *path, dl_error *error);

#endif
