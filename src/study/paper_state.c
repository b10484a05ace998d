/* The state that a claim or a picture looks at. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/paper_plan.h"

void dl_paper_source_text(const dl_paper_source *source, char *text, size_t size) {
    const bool beside = strncmp(source->scene, "../", 3) == 0;
    if (!*source->scene && !*source->run)
        snprintf(text, size, "%s", "");
    else if (*source->scene)
        snprintf(text, size, "%.100s", source->scene + (beside ? 3 : 0));
    else if (source->step >= 0)
        snprintf(text, size, "%.60s, step %ld", source->run, source->step);
    else if (isfinite(source->time))
        snprintf(text, size, "%.60s, t = %.6g", source->run, source->time);
    else
        snprintf(text, size, "%.60s", source->run);
}

static dl_status allocate(dl_paper_state *state, dl_error *error) {
    const size_t n = 2 * (size_t)state->scene->dimension * state->scene->particles;
    state->y_all = malloc(n * sizeof *state->y_all);
    return state->y_all ? DL_OK : dl_fail_memory(error, "a state of every particle");
}

static dl_status open_scene(const dl_paper_source *source, dl_paper_state *state, dl_error *error) {
    dl_status status = dl_scene_read(source->path, &state->scene, error);
    if (!status)
        status = allocate(state, error);
    if (status)
        return status;
    const size_t half = (size_t)state->scene->dimension * state->scene->particles;
    memcpy(state->y_all, state->scene->position, half * sizeof *state->y_all);
    memcpy(state->y_all + half, state->scene->velocity, half * sizeof *state->y_all);
    return DL_OK;
}

/* Which segment holds the moment, the earlier one where two do (it remembers more), and what the
 * moment is called there. */
static dl_status locate(const dl_paper_source *source, const dl_paper_run_row *run,
                        dl_paper_state *state, long *step, double *time, dl_error *error) {
    const double length = run->end / (double)run->segments;
    const bool by_step = source->step >= 0;
    if (by_step && !(run->step > 0))
        return dl_fail(error, DL_INPUT, "the method chooses its steps: a time is needed");
    double at = by_step ? (double)source->step * run->step : source->time;
    if (!by_step && !isfinite(at))
        at = run->status ? run->reached : run->end;
    if (at > run->reached * (1 + 1e-9))
        return dl_fail(error, DL_INPUT, "the run ended at t = %.6g (%s)%s%.700s", run->reached,
                       dl_status_name(run->status), *run->message ? ": " : "", run->message);
    const double segment = ceil(at / length * (1 - 1e-12)) - 1;
    state->segment = segment > 0 ? (size_t)segment : 0;
    if (state->segment >= run->segments_done)
        return dl_fail(error, DL_INPUT, "the run has not come so far");
    *time = at - (double)state->segment * length;
    *step = by_step ? lround(*time / run->step) : -1;
    return DL_OK;
}

static dl_status open_frame(const dl_paper_source *source, const char *path, dl_paper_state *state,
                            long step, double time, dl_error *error) {
    dl_status status = dl_frames_open(path, &state->frames, error);
    if (!status)
        status = dl_scene_read_trajectory(path, &state->scene, error);
    if (!status)
        status = allocate(state, error);
    if (status)
        return status;
    state->number = state->frames->count - 1;
    if (step >= 0)
        status = dl_frames_at_step(state->frames, step, &state->number, error);
    else if (isfinite(source->time))
        status = dl_frames_at_time(state->frames, time, &state->number, error);
    return status ? status
                  : dl_frames_read(state->frames, state->number, state->scene->dimension,
                                   state->y_all, error);
}

static dl_status open_run(const dl_paper_source *source, const dl_paper_run_row *runs,
                          const char *folder, dl_paper_state *state, dl_error *error) {
    const dl_paper_run_row *run = &runs[source->number];
    long step = -1;
    double time = 0;
    if (run->fate == DL_RUN_MISSING)
        return dl_fail(error, DL_INPUT, "%s", run->message);
    dl_status status = locate(source, run, state, &step, &time, error);
    if (status)
        return status;
    state->run = run;
    state->folder = folder;
    char *path = dl_paper_trajectory(folder, run, state->segment);
    status =
        path ? open_frame(source, path, state, step, time, error) : dl_fail_memory(error, "a run");
    free(path);
    return status;
}

dl_status dl_paper_state_open(const dl_paper_source *source, const dl_paper_run_row *runs,
                              const char *folder, dl_paper_state *state, dl_error *error) {
    *state = (dl_paper_state){0};
    const dl_status status = *source->scene ? open_scene(source, state, error)
                                            : open_run(source, runs, folder, state, error);
    if (status)
        dl_paper_state_close(state);
    return status;
}

void dl_paper_state_close(dl_paper_state *state) {
    dl_frames_close(state->frames);
    dl_scene_free(state->scene);
    free(state->y_all);
    *state = (dl_paper_state){0};
}
