#include "report/paper_figure.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driftlab/picture.h"
#include "report/paper_plot.h"
#include "study/plan.h"

/* --- an SVG file as part of a page ------------------------------------------------------------ */

static char *read_text(const char *path) {
    FILE *in = fopen(path, "rb");
    char *text = NULL;
    if (!in)
        return NULL;
    if (fseek(in, 0, SEEK_END) == 0) {
        const long size = ftell(in);
        rewind(in);
        text = size >= 0 ? calloc((size_t)size + 1, 1) : NULL;
        if (text && fread(text, 1, (size_t)size, in) != (size_t)size) {
            free(text);
            text = NULL;
        }
    }
    fclose(in);
    return text;
}

static dl_status embed(const char *path, char **svg, dl_error *error) {
    char *text = read_text(path);
    const char *element = text ? strstr(text, "<svg") : NULL;
    *svg = element ? dl_text("%s", element) : NULL;
    free(text);
    return *svg ? DL_OK : dl_fail(error, DL_IO, "%s: cannot be read again", path);
}

/* --- the picture ------------------------------------------------------------------------------ */

static void write_caption(const dl_paper_state *state, char *text, size_t size) {
    const size_t n = state->scene->particles;
    if (!state->frames) {
        snprintf(text, size, "t = 0 · initial state · %zu particles", n);
        return;
    }
    const double length = state->run->end / (double)state->run->segments;
    const double time = state->frames->time[state->number] + (double)state->segment * length;
    if (state->run->step > 0)
        snprintf(text, size, "t = %.6g · step %ld · %zu particles", time,
                 lround(time / state->run->step), n);
    else
        snprintf(text, size, "t = %.6g · %zu particles", time, n);
}

typedef dl_status window_function(const dl_picture *picture, dl_picture_window *window,
                                  dl_error *error);

static dl_status find_states(const dl_paper_state *from, dl_state *states, dl_error *error) {
    return from->frames ? dl_picture_states(from->scene, from->frames, from->number, states, error)
                        : dl_picture_states_now(from->scene, from->y_all, states, error);
}

static dl_status draw(const dl_paper_picture *asked, const dl_paper_state *from, const char *path,
                      dl_error *error) {
    static window_function *const find_window[] = {NULL, dl_picture_window_of_system,
                                                   dl_picture_window_of_body};
    char caption[128];
    dl_picture_window window;
    dl_state *states = calloc(from->scene->particles, sizeof *states);
    if (!states)
        return dl_fail_memory(error, "a picture");
    dl_picture picture = {.scene = from->scene,
                          .y_all = from->y_all,
                          .title = asked->figure,
                          .caption = caption,
                          .colour = (dl_picture_colour)asked->colour,
                          .state = states,
                          .velocities = asked->velocities,
                          .equal_size = asked->equal_size,
                          .across = 0,
                          .up = 1};
    write_caption(from, caption, sizeof caption);
    dl_status status = picture.colour == DL_COLOUR_STATE ? find_states(from, states, error) : DL_OK;
    if (!status && asked->window) {
        status = find_window[asked->window](&picture, &window, error);
        picture.window = &window;
    }
    if (!status)
        status = dl_picture_write(&picture, path, error);
    free(states);
    return status;
}

static dl_status draw_state(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                            const char *folder, const char *path, dl_error *error) {
    dl_paper_state state;
    dl_status status = dl_paper_state_open(&picture->source, runs, folder, &state, error);
    if (status)
        return status;
    status = draw(picture, &state, path, error);
    dl_paper_state_close(&state);
    return status;
}

static dl_status draw_curve(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                            const char *folder, const char *path, dl_error *error) {
    dl_paper_curve curve;
    dl_status status = dl_paper_curve_measure(picture, runs, folder, &curve, error);
    if (status)
        return status;
    status = dl_paper_plot_write(picture, &curve, path, error);
    dl_paper_curve_free(&curve);
    return status;
}

static dl_status draw_either(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                             const char *folder, const char *path, dl_error *error) {
    if (*picture->reason)
        return dl_fail(error, DL_INPUT, "%s", picture->reason);
    return *picture->curve ? draw_curve(picture, runs, folder, path, error)
                           : draw_state(picture, runs, folder, path, error);
}

dl_status dl_paper_figure_draw(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                               const char *folder, dl_paper_figure *figure, dl_error *error) {
    dl_error reason = {""};
    figure->part = picture->part;
    figure->figure = picture->figure;
    figure->caption = picture->caption;
    dl_paper_source_text(&picture->source, figure->from, sizeof figure->from);
    char *path = dl_text("%s/picture.svg", folder);
    if (!path)
        return dl_fail_memory(error, "a picture");
    dl_status status = draw_either(picture, runs, folder, path, &reason);
    if (!status)
        status = embed(path, &figure->svg, &reason);
    unlink(path);
    free(path);
    if (status == DL_IO || status == DL_MEMORY)
        return dl_fail(error, status, "%s", reason.message);
    figure->reason = dl_text("%s", status ? reason.message : "");
    return figure->reason ? DL_OK : dl_fail_memory(error, "a picture");
}
