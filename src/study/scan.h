/* A scan of steps for what is stable: equal ratios from the smallest to the largest, then the
 * borders of what was found, by bisection. Stable steps need not be one interval: unstable windows
 * may lie among them, and are seen where a scanned step falls into one. */
#ifndef DL_STUDY_SCAN_H
#define DL_STUDY_SCAN_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

/* One step that was tried. */
typedef struct dl_scan_point {
    double step;
    int stable;       /* 1, -1, or 0: not known */
    const char *word; /* static: how it ended */
    double value[3];  /* the judge's own */
} dl_scan_point;

typedef struct dl_scan {
    /* Tries point->step and fills the rest. May move it to the nearest step that is possible. A
     * failure ends the scan. */
    dl_status (*judge)(void *context, dl_scan_point *point, dl_error *error);
    /* Where that step would be moved to; NULL: any step is possible. */
    double (*possible)(const void *context, double step);
    void *context;
    double smallest, largest;
    long per_decade;
    double width;       /* relative, of a border that is found */
    bool first_only;    /* ends at the first unstable step, without what lies above it */
    size_t count, room; /* found: ascending, each step once; free with dl_scan_release */
    dl_scan_point *point;
} dl_scan;

/* What a scan says. Steps are NAN where there are none. */
typedef struct dl_scan_result {
    double limit;       /* every known step up to here is stable */
    double broken;      /* the smallest that is unstable */
    double top, beyond; /* the largest that is stable, the smallest known unstable one above */
    size_t windows;     /* unstable stretches below `top` */
    size_t unknown;     /* steps of which nothing is known */
} dl_scan_result;

dl_status dl_scan_run(dl_scan *scan, dl_error *error);
dl_scan_result dl_scan_read(const dl_scan *scan);
void dl_scan_release(dl_scan *scan);

#endif
