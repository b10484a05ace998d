/* driftlab picture: a state as a picture, or a trajectory as a page that plays it. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/paths.h"
#include "driftlab/picture.h"

typedef struct picture_values {
    char *frame, *out, *title, *window;
    double step, time;
    int colour, size, plane;
    bool velocities;
} picture_values;

static const char *const colour_words[] = {"mass", "speed", "state", "none", NULL};
static const char *const size_words[] = {"mass", "equal", NULL};
static const char *const plane_words[] = {"xy", "xz", "yz", NULL};
static const int planes[][2] = {{0, 1}, {0, 2}, {1, 2}};

static const dl_parameter options[] = {
    {.name = "step",
     .kind = DL_REAL,
     .offset = offsetof(picture_values, step),
     .unit = "N",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "none",
     .doc = "the frame at this step of the method"},
    {.name = "time",
     .kind = DL_REAL,
     .offset = offsetof(picture_values, time),
     .unit = "T",
     .minimum = -INFINITY,
     .maximum = INFINITY,
     .fallback = "none",
     .doc = "the frame at this time"},
    {.name = "frame",
     .kind = DL_TEXT,
     .offset = offsetof(picture_values, frame),
     .unit = "N|last",
     .doc = "the frame of this number, from 0 (default: last)"},
    {.name = "out",
     .kind = DL_TEXT,
     .offset = offsetof(picture_values, out),
     .unit = "FILE",
     .doc = "NAME.svg, NAME.png, or NAME.html: a player (default: picture.svg beside the file)"},
    {.name = "colour",
     .kind = DL_WORD,
     .offset = offsetof(picture_values, colour),
     .unit = "BY",
     .words = colour_words,
     .fallback = "mass",
     .doc = "mass, speed, state (solid, liquid, gas by TR299's Table IV) or none"},
    {.name = "size",
     .kind = DL_WORD,
     .offset = offsetof(picture_values, size),
     .unit = "BY",
     .words = size_words,
     .fallback = "mass",
     .doc = "mass or equal: sizes of the circles"},
    {.name = "velocities",
     .kind = DL_FLAG,
     .offset = offsetof(picture_values, velocities),
     .fallback = "false",
     .doc = "draw velocities as arrows"},
    {.name = "window",
     .kind = DL_TEXT,
     .offset = offsetof(picture_values, window),
     .unit = "WHAT",
     .doc = "all (the default), system (without what has escaped) or X0,X1,Y0,Y1"},
    {.name = "plane",
     .kind = DL_WORD,
     .offset = offsetof(picture_values, plane),
     .unit = "AB",
     .words = plane_words,
     .fallback = "xy",
     .doc = "xy, xz or yz: where a scene in three dimensions is seen"},
    {.name = "title",
     .kind = DL_TEXT,
     .offset = offsetof(picture_values, title),
     .unit = "TEXT",
     .doc = "title (default: the scene's name)"},
};

/* What a picture is made from. */
typedef struct source {
    const cli_input *input;
    const char *path;
    dl_scene *scene;
    dl_frames *frames; /* NULL: a scene's initial state */
    size_t number;     /* of the frame */
    double *y_all;
    dl_state *state;
} source;

static void source_close(source *from) {
    dl_frames_close(from->frames);
    dl_scene_free(from->scene);
    free(from->y_all);
    free(from->state);
}

/* --- which frame ------------------------------------------------------------------------------ */

static dl_status frame_by_number(const dl_frames *frames, const char *text, size_t *number,
                                 dl_error *error) {
    char *end;
    errno = 0;
    const long value = strtol(text, &end, 10);
    *number = frames->count - 1;
    if (strcmp(text, "last") == 0)
        return DL_OK;
    if (end == text || *end || errno || value < 0 || (size_t)value >= frames->count)
        return dl_fail(error, DL_INPUT, "--frame: found \"%s\", expected 0 to %zu, or last", text,
                       frames->count - 1);
    *number = (size_t)value;
    return DL_OK;
}

static dl_status choose_frame(source *from, const picture_values *values, dl_error *error) {
    const bool by_step = isfinite(values->step), by_time = isfinite(values->time);
    if (by_step + by_time + (values->frame != NULL) > 1)
        return dl_fail(error, DL_INPUT,
                       "--step, --time, --frame: found more than one of them, expected one");
    if (by_step && (values->step != floor(values->step) || values->step > 9e15))
        return dl_fail(error, DL_INPUT, "--step: found %.15g, expected a whole number",
                       values->step);
    if (by_step)
        return dl_frames_at_step(from->frames, (long)values->step, &from->number, error);
    if (by_time)
        return dl_frames_at_time(from->frames, values->time, &from->number, error);
    return frame_by_number(from->frames, values->frame ? values->frame : "last", &from->number,
                           error);
}

/* A scene has one frame, at step 0 and time 0. */
static dl_status check_initial(const picture_values *values, const char *path, dl_error *error) {
    const bool first =
        (!isfinite(values->step) || values->step == 0) &&
        (!isfinite(values->time) || values->time == 0) &&
        (!values->frame || strcmp(values->frame, "0") == 0 || strcmp(values->frame, "last") == 0);
    return first ? DL_OK
                 : dl_fail(error, DL_INPUT,
                           "%s: a scene has its initial state alone, frame 0 at step 0 and time "
                           "0; driftlab run SCENE --out FILE.h5 makes more",
                           path);
}

/* --- state of the particles ------------------------------------------------------------------- */

static dl_status allocate(source *from, dl_error *error) {
    const dl_scene *const scene = from->scene;
    from->y_all = calloc(2 * (size_t)scene->dimension * scene->particles, sizeof *from->y_all);
    from->state = calloc(scene->particles, sizeof *from->state);
    return from->y_all && from->state ? DL_OK : dl_fail_memory(error, "a state of every particle");
}

static dl_status read_scene(source *from, const picture_values *values, dl_error *error) {
    dl_status status = cli_read_scene(from->input, from->path, &from->scene, error);
    if (!status)
        status = check_initial(values, from->path, error);
    if (!status)
        status = allocate(from, error);
    if (status)
        return status;
    const size_t half = (size_t)from->scene->dimension * from->scene->particles;
    memcpy(from->y_all, from->scene->position, half * sizeof *from->y_all);
    memcpy(from->y_all + half, from->scene->velocity, half * sizeof *from->y_all);
    return values->colour == DL_COLOUR_STATE
               ? dl_picture_states_now(from->scene, from->y_all, from->state, error)
               : DL_OK;
}

static dl_status read_trajectory(source *from, const picture_values *values, dl_error *error) {
    dl_status status = cli_refuse_let(from->input, from->path, error);
    if (!status)
        status = dl_frames_open(from->path, &from->frames, error);
    if (!status)
        status = choose_frame(from, values, error);
    if (!status)
        status = dl_scene_read_trajectory(from->path, &from->scene, error);
    if (!status)
        status = allocate(from, error);
    if (!status)
        status =
            dl_frames_read(from->frames, from->number, from->scene->dimension, from->y_all, error);
    if (!status && values->colour == DL_COLOUR_STATE)
        status = dl_picture_states(from->scene, from->frames, from->number, from->state, error);
    return status;
}

/* --- the picture ------------------------------------------------------------------------------ */

/* "X0,X1,Y0,Y1" and nothing behind it. */
static bool read_window(const char *text, dl_picture_window *window) {
    double *const number[4] = {&window->low[0], &window->high[0], &window->low[1],
                               &window->high[1]};
    for (int k = 0; k < 4; k++) {
        char *end;
        *number[k] = strtod(text, &end);
        if (end == text || *end != (k < 3 ? ',' : '\0'))
            return false;
        text = end + 1;
    }
    return true;
}

/* "all" and none given leave *window NULL. */
static dl_status choose_window(const char *text, dl_picture *picture, dl_picture_window *window,
                               dl_error *error) {
    if (!text || strcmp(text, "all") == 0)
        return DL_OK;
    picture->window = window;
    if (strcmp(text, "system") == 0) {
        picture->window = NULL;
        const dl_status status = dl_picture_window_of_system(picture, window, error);
        picture->window = window;
        return status;
    }
    const bool read = read_window(text, window);
    for (int k = 0; k < 2; k++)
        if (!read || !(window->high[k] - window->low[k] > 0) ||
            !isfinite(window->high[k] - window->low[k]))
            return dl_fail(error, DL_INPUT,
                           "--window: found \"%s\", expected all, system or X0,X1,Y0,Y1 with X0 < "
                           "X1 and Y0 < Y1",
                           text);
    return DL_OK;
}

static void write_caption(const source *from, const picture_values *values, char *text,
                          size_t size) {
    const char *states = values->colour == DL_COLOUR_STATE ? " · states by TR299, Table IV" : "";
    const size_t n = from->scene->particles;
    if (from->frames)
        snprintf(text, size, "t = %.6g · step %ld · %zu particles%s%s%s",
                 from->frames->time[from->number], from->frames->step[from->number], n,
                 from->frames->method ? " · " : "",
                 from->frames->method ? from->frames->method : "", states);
    else
        snprintf(text, size, "t = 0 · initial state · %zu particles%s", n, states);
}

static dl_status draw(const source *from, const picture_values *values, const char *out,
                      dl_error *error) {
    char caption[256];
    dl_picture_window window;
    dl_picture picture = {
        .scene = from->scene,
        .y_all = from->y_all,
        .title = values->title,
        .caption = caption,
        .colour = (dl_picture_colour)values->colour,
        .state = from->state,
        .velocities = values->velocities,
        .equal_size = values->size == 1,
        .across = planes[values->plane][0],
        .up = planes[values->plane][1],
    };
    if (picture.up >= from->scene->dimension)
        return dl_fail(error, DL_INPUT,
                       "--plane: found %s, expected xy for a scene in 2 dimensions",
                       plane_words[values->plane]);
    write_caption(from, values, caption, sizeof caption);
    const dl_status status = choose_window(values->window, &picture, &window, error);
    return status ? status : dl_picture_write(&picture, out, error);
}

static bool ends_in(const char *path, const char *suffix) {
    const size_t length = strlen(path);
    return length > strlen(suffix) && strcmp(path + length - strlen(suffix), suffix) == 0;
}

/* A page has its own controls. */
static dl_status write_player(const cli_input *input, const char *out, dl_error *error) {
    const char *const path = input->word[0];
    for (size_t k = 0; k < sizeof options / sizeof *options; k++)
        if (input->given[k] && strcmp(options[k].name, "out") != 0)
            return dl_fail(
                error, DL_INPUT,
                "--%s: found it beside --out %s, expected none: the page lets one choose",
                options[k].name, out);
    if (!dl_file_is_hdf5(path))
        return dl_fail(error, DL_INPUT, "%s: found no trajectory, expected one for a player", path);
    const dl_status status = cli_refuse_let(input, path, error);
    return status ? status : dl_player_write(&path, 1, out, error);
}

static dl_status write_picture(const cli_input *input, const char *out, dl_error *error) {
    const picture_values *const values = input->values;
    source from = {.input = input, .path = input->word[0]};
    dl_status status = dl_file_is_hdf5(from.path) ? read_trajectory(&from, values, error)
                                                  : read_scene(&from, values, error);
    if (!status)
        status = draw(&from, values, out, error);
    source_close(&from);
    return status;
}

static cli_exit picture(const cli_input *input) {
    const picture_values *values = input->values;
    dl_error error = {""};
    char *beside = cli_beside(input->word[0], "picture.svg");
    const char *out = values->out ? values->out : beside;
    dl_status status = DL_OK;
    if (!out)
        status = dl_fail_memory(&error, "a file name");
    else if (ends_in(out, ".html"))
        status = write_player(input, out, &error);
    else
        status = write_picture(input, out, &error);
    if (!status)
        printf("picture: %s\n", out);
    free(beside);
    return cli_finish(status, &error);
}

const cli_command cli_command_picture = {
    .name = "picture",
    .arguments = "TRAJECTORY.h5 | SCENE",
    .summary = "draw the particles (SVG, PNG), or a page that plays a trajectory",
    .details = "With --out NAME.html the page plays every frame and has controls of its own: no "
               "other option goes with it.\n",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .options = CLI_TABLE(options),
    .values_size = sizeof(picture_values),
    .run = picture,
};
