#include "study/scan.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Two steps are one where they differ by less. */
static const double same = 1e-12;

/* Where a step stands, or would stand, among those that were tried. */
static size_t place_of(const dl_scan *scan, double step) {
    size_t k = 0;
    while (k < scan->count && scan->point[k].step < step * (1 - same))
        k++;
    return k;
}

static bool was_tried(const dl_scan *scan, double step) {
    const size_t k = place_of(scan, step);
    return k < scan->count && scan->point[k].step <= step * (1 + same);
}

static dl_status insert(dl_scan *scan, const dl_scan_point *point, dl_error *error) {
    if (scan->count == scan->room) {
        const size_t room = scan->room ? 2 * scan->room : 64;
        dl_scan_point *const larger = realloc(scan->point, room * sizeof *larger);
        if (!larger)
            return dl_fail_memory(error, "a scan of steps");
        scan->point = larger;
        scan->room = room;
    }
    const size_t at = place_of(scan, point->step);
    memmove(scan->point + at + 1, scan->point + at, (scan->count - at) * sizeof *point);
    scan->point[at] = *point;
    scan->count++;
    return DL_OK;
}

/* *stable: what is known of that step; false where it was tried before. */
static dl_status try_step(dl_scan *scan, double step, int *stable, bool *tried, dl_error *error) {
    dl_scan_point point = {.step = scan->possible ? scan->possible(scan->context, step) : step};
    *tried = !was_tried(scan, point.step);
    if (!*tried)
        return DL_OK;
    dl_status status = scan->judge(scan->context, &point, error);
    *stable = point.stable;
    return status ? status : insert(scan, &point, error);
}

static dl_status scan_grid(dl_scan *scan, dl_error *error) {
    const double decades = log10(scan->largest / scan->smallest);
    const long intervals = lround(fmax(1, ceil(decades * (double)scan->per_decade - same)));
    dl_status status = DL_OK;
    int stable = 0;
    for (long k = 0; k <= intervals && !status && !(scan->first_only && stable < 0); k++) {
        bool tried;
        const double part = (double)k / (double)intervals;
        const double step = scan->smallest * pow(scan->largest / scan->smallest, part);
        status = try_step(scan, scan->largest > scan->smallest ? step : scan->smallest, &stable,
                          &tried, error);
    }
    return status;
}

/* Bisects between a stable step and an unstable one above it. Ends where a step is tried of which
 * nothing is known, or none lies between. */
static dl_status refine(dl_scan *scan, double stable_step, double unstable_step, dl_error *error) {
    while (unstable_step > stable_step * (1 + scan->width)) {
        int stable = 0;
        bool tried;
        const double middle = sqrt(stable_step * unstable_step);
        const dl_status status = try_step(scan, middle, &stable, &tried, error);
        if (status || !tried || stable == 0)
            return status;
        if (stable > 0)
            stable_step = scan->possible ? scan->possible(scan->context, middle) : middle;
        else
            unstable_step = scan->possible ? scan->possible(scan->context, middle) : middle;
    }
    return DL_OK;
}

dl_status dl_scan_run(dl_scan *scan, dl_error *error) {
    dl_status status = scan_grid(scan, error);
    if (status)
        return status;
    const dl_scan_result found = dl_scan_read(scan);
    if (isfinite(found.limit) && isfinite(found.broken))
        status = refine(scan, found.limit, found.broken, error);
    if (!status && found.top > found.limit && isfinite(found.beyond))
        status = refine(scan, found.top, found.beyond, error);
    return status;
}

dl_scan_result dl_scan_read(const dl_scan *scan) {
    dl_scan_result result = {.limit = NAN, .broken = NAN, .top = NAN, .beyond = NAN};
    bool inside = false;  /* an unstable stretch */
    size_t stretches = 0; /* that have begun */
    for (size_t k = 0; k < scan->count; k++) {
        const dl_scan_point *const point = &scan->point[k];
        result.unknown += point->stable == 0;
        if (point->stable > 0) {
            result.top = point->step;
            result.beyond = NAN;
            result.windows = stretches;
            if (isnan(result.broken))
                result.limit = point->step;
            inside = false;
        } else if (point->stable < 0) {
            stretches += !inside;
            inside = true;
            if (isnan(result.broken))
                result.broken = point->step;
            if (isnan(result.beyond))
                result.beyond = point->step;
        }
    }
    return result;
}

void dl_scan_release(dl_scan *scan) {
    free(scan->point);
    scan->point = NULL;
    scan->count = scan->room = 0;
}
