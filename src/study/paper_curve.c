/* A quantity over the frames of a run, and what the paper prints of it. */
#include <math.h>
#include <stdlib.h>

#include "study/paper_quantity.h"

/* --- what is asked for ------------------------------------------------------------------------ */

/* "STEP VALUE, STEP VALUE". */
static bool read_marks(const char *text, dl_paper_picture *picture) {
    while (*text && picture->marks < DL_PAPER_MARKS) {
        dl_paper_mark *const mark = &picture->mark[picture->marks++];
        char *end, *after;
        mark->at = strtod(text, &end);
        mark->value = strtod(end, &after);
        if (end == text || after == end || !isfinite(mark->at) || !isfinite(mark->value))
            return false;
        if (*after && *after != ',')
            return false;
        text = *after ? after + 1 : after;
    }
    return !*text;
}

dl_status dl_paper_curve_prepare(dl_paper_picture *picture, dl_error *error) {
    dl_error reason = {""};
    if (dl_quantity_find_curve(picture->curve, &picture->quantity, &reason))
        return dl_fail(error, DL_INPUT, "curve: %.900s", reason.message);
    if (!read_marks(picture->published, picture))
        return dl_fail(error, DL_INPUT,
                       "published: found \"%.200s\", expected at most %d points, \"STEP VALUE, "
                       "STEP VALUE\"",
                       picture->published, DL_PAPER_MARKS);
    return DL_OK;
}

/* --- what comes out --------------------------------------------------------------------------- */

void dl_paper_curve_free(dl_paper_curve *curve) {
    free(curve->at);
    free(curve->value);
    *curve = (dl_paper_curve){0};
}

static dl_status make_room(dl_paper_curve *curve, size_t more, dl_error *error) {
    const size_t count = curve->count + more;
    double *const at = realloc(curve->at, count * sizeof *at);
    curve->at = at ? at : curve->at;
    double *const value = realloc(curve->value, count * sizeof *value);
    curve->value = value ? value : curve->value;
    return at && value ? DL_OK : dl_fail_memory(error, "a curve");
}

/* The first frame of a later segment is the last one of the segment before. */
static dl_status add_segment(const dl_paper_claim *claim, dl_paper_state *state,
                             dl_paper_curve *curve, dl_error *error) {
    const dl_frames *const frames = state->frames;
    const double start = (double)state->segment * state->run->end / (double)state->run->segments;
    const double unit = curve->by_step ? state->run->step : 1;
    if (curve->count)
        curve->count--;
    dl_status status = make_room(curve, frames->count, error);
    if (!status)
        status = dl_quantity_measure_frames(claim, state, curve->value + curve->count, error);
    for (size_t k = 0; k < frames->count && !status; k++)
        curve->at[curve->count++] = (start + frames->time[k]) / unit;
    return status;
}

dl_status dl_paper_curve_measure(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                                 const char *folder, dl_paper_curve *curve, dl_error *error) {
    const dl_paper_run_row *const run = &runs[picture->source.number];
    const dl_paper_claim claim = {.source = picture->source,
                                  .computed = picture->curve,
                                  .quantity = picture->quantity,
                                  .particle = picture->particle,
                                  .row = INFINITY,
                                  .since = -1};
    dl_status status = DL_OK;
    *curve = (dl_paper_curve){.by_step = run->step > 0};
    for (size_t s = 0; s == 0 || (s < run->segments && !status); s++) {
        dl_paper_source last = picture->source; /* frame of the segment */
        dl_paper_state state;
        if (s + 1 < run->segments)
            last.time = (double)(s + 1) * run->end / (double)run->segments;
        if ((status = dl_paper_state_open(&last, runs, folder, &state, error)))
            break;
        status = dl_quantity_check_ended(&state, error);
        if (!status)
            status = add_segment(&claim, &state, curve, error);
        dl_paper_state_close(&state);
    }
    if (status)
        dl_paper_curve_free(curve);
    return status;
}
