#include "cli/observe_source.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"

dl_status cli_source_open(const cli_input *input, const char *scene, cli_source *source,
                          dl_error *error) {
    const char *const file = input->word[0];
    *source = (cli_source){.file = file, .count = 1, .every = 1};
    const bool is_trajectory = dl_file_is_hdf5(file);
    dl_status status = DL_OK;
    if (!is_trajectory && scene)
        return dl_fail(error, DL_INPUT, "--scene: found %s beside %s, expected a trajectory there",
                       scene, file);
    if (is_trajectory && !scene)
        status = cli_refuse_let(input, file, error);
    if (!status)
        status = is_trajectory && !scene
                     ? dl_scene_read_trajectory(file, &source->scene, error)
                     : cli_read_scene(input, scene ? scene : file, &source->scene, error);
    if (!status && is_trajectory)
        status = dl_frames_open(file, &source->frames, error);
    if (status)
        return status;
    source->count = source->frames ? source->frames->count : 1;
    source->last = source->count - 1;
    const size_t block = (size_t)source->scene->dimension * source->scene->particles;
    source->y_all = malloc(2 * block * sizeof *source->y_all);
    return source->y_all ? DL_OK : dl_fail_memory(error, "a state of every particle");
}

void cli_source_close(cli_source *source) {
    dl_frames_close(source->frames);
    dl_scene_free(source->scene);
    free(source->y_all);
    *source = (cli_source){0};
}

double cli_source_time(const cli_source *source, size_t number) {
    return source->frames ? source->frames->time[number] : 0;
}

long cli_source_step(const cli_source *source, size_t number) {
    return source->frames ? source->frames->step[number] : -1;
}

dl_status cli_source_read(cli_source *source, size_t number, dl_error *error) {
    const dl_scene *const scene = source->scene;
    if (source->frames)
        return dl_frames_read_state(source->frames, number, scene, source->y_all, error);
    const size_t block = (size_t)scene->dimension * scene->particles;
    memcpy(source->y_all, scene->position, block * sizeof *source->y_all);
    memcpy(source->y_all + block, scene->velocity, block * sizeof *source->y_all);
    return DL_OK;
}

/* --- which frames ----------------------------------------------------------------------------- */

static dl_status choose_one(cli_source *source, const cli_choice *choice, dl_error *error) {
    size_t number = source->count - 1;
    dl_status status = DL_OK;
    if (!choice->last && !source->frames)
        return dl_fail(error, DL_INPUT, "--%s: found the scene %s, expected a trajectory",
                       choice->step >= 0 ? "step" : "time", source->file);
    if (!choice->last)
        status = choice->step >= 0
                     ? dl_frames_at_step(source->frames, choice->step, &number, error)
                     : dl_frames_at_time(source->frames, choice->time, &number, error);
    source->first = source->last = number;
    return status;
}

/* A time is a frame's to a millionth of the interval between frames. */
static dl_status choose_range(cli_source *source, const cli_choice *choice, dl_error *error) {
    const double begin = cli_source_time(source, 0), end = cli_source_time(source, source->last);
    const double near = source->last > 0 ? 1e-6 * (end - begin) / (double)source->last : 0;
    while (source->first < source->count &&
           cli_source_time(source, source->first) < choice->from - near)
        source->first++;
    if (source->first == source->count)
        return dl_fail(error, DL_INPUT,
                       "--from: found %.15g, expected a time not after the last frame's, %.15g",
                       choice->from, end);
    if (cli_source_time(source, source->first) > choice->to + near)
        return dl_fail(
            error, DL_INPUT,
            "--to: found %.15g, expected a time not before that of the first frame to be "
            "observed, %.15g",
            choice->to, cli_source_time(source, source->first));
    while (cli_source_time(source, source->last) > choice->to + near)
        source->last--;
    return DL_OK;
}

dl_status cli_source_choose(cli_source *source, const cli_choice *choice, dl_error *error) {
    source->every = (size_t)choice->every;
    return choice->last || choice->step >= 0 || isfinite(choice->time)
               ? choose_one(source, choice, error)
               : choose_range(source, choice, error);
}

dl_status cli_source_heights(cli_source *source, double *lowest, double *highest, dl_error *error) {
    dl_status status = DL_OK;
    *lowest = INFINITY;
    *highest = -INFINITY;
    for (size_t k = source->first; k <= source->last && !status; k += source->every) {
        double low, high;
        if ((status = cli_source_read(source, k, error)))
            break;
        dl_observe_heights(source->scene, source->y_all, &low, &high);
        *lowest = fmin(*lowest, low);
        *highest = fmax(*highest, high);
    }
    return status;
}
