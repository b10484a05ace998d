#include "report/player_data.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/model.h"
#include "driftlab/picture.h"
#include "report/base64.h"
#include "report/page.h"
#include "report/picture_look.h"
#include "report/picture_view.h"
#include "report/state_watch.h"

/* The frames that are shown. */
typedef struct film {
    dl_scene *scene;
    dl_frames *frames;
    dl_masses masses;
    size_t n, dimension, stride, shown;
    size_t *number;       /* [shown], of the file's frames */
    double *y;            /* [shown][2 dimension n], in the box where it is periodic */
    unsigned char *state; /* [shown][n]; NULL: no thresholds */
    double *size;         /* [n] */
    double scale;         /* of energy */
} film;

/* --- reading ---------------------------------------------------------------------------------- */

static void film_free(film *f) {
    dl_masses_free(&f->masses);
    dl_scene_free(f->scene);
    dl_frames_close(f->frames);
    free(f->number);
    free(f->y);
    free(f->state);
    free(f->size);
}

/* The first, every stride-th and the last. */
static dl_status choose_frames(film *f, size_t most_bytes, dl_error *error) {
    const size_t frame_bytes = f->n * (4 * f->dimension + 1), count = f->frames->count;
    const size_t most = most_bytes / frame_bytes > 2 ? most_bytes / frame_bytes - 1 : 1;
    f->stride = (count + most - 1) / most;
    f->number = malloc((count / f->stride + 2) * sizeof *f->number);
    if (!f->number)
        return dl_fail_memory(error, "a player");
    for (size_t k = 0; k < count; k += f->stride)
        f->number[f->shown++] = k;
    if (f->number[f->shown - 1] != count - 1)
        f->number[f->shown++] = count - 1;
    f->y = malloc(f->shown * 2 * f->dimension * f->n * sizeof *f->y);
    f->state = malloc(f->shown * f->n);
    f->size = malloc(f->n * sizeof *f->size);
    return f->y && f->state && f->size ? DL_OK : dl_fail_memory(error, "a player");
}

static double *frame_at(const film *f, size_t k) {
    return f->y + k * 2 * f->dimension * f->n;
}

static void wrap(const film *f, double *y_all) {
    const dl_periods *const box = &f->scene->periods;
    for (size_t k = 0; k < f->dimension; k++)
        for (size_t i = k * f->n; i < (k + 1) * f->n && box->length[k] > 0; i++)
            y_all[i] -= box->length[k] * floor((y_all[i] - box->low[k]) / box->length[k]);
}

/* Every frame is seen by the thermometers, also those that are not shown. */
static dl_status read_frames(film *f, dl_state_watch *watch, dl_error *error) {
    const size_t length = 2 * f->dimension * f->n;
    double *const y_all = malloc(length * sizeof *y_all);
    dl_state *const state = calloc(f->n, sizeof *state);
    dl_status status = y_all && state ? DL_OK : dl_fail_memory(error, "a player");
    const double *const time = f->frames->time;
    size_t shown = 0;
    for (size_t k = 0; k < f->frames->count && !status; k++) {
        const bool is_shown = f->number[shown] == k;
        if (!is_shown && !watch)
            continue;
        status = dl_frames_read(f->frames, k, (int)f->dimension, y_all, error);
        if (!status && watch && (k == 0 || time[k] > time[k - 1]))
            status = dl_state_watch_add(watch, time[k], y_all, state, error);
        if (status || !is_shown)
            continue;
        memcpy(frame_at(f, shown), y_all, length * sizeof *y_all);
        wrap(f, frame_at(f, shown));
        for (size_t i = 0; i < f->n; i++)
            f->state[shown * f->n + i] = (unsigned char)state[i];
        shown++;
    }
    free(y_all);
    free(state);
    return status;
}

static dl_status read_states_and_frames(film *f, dl_error *error) {
    dl_state_watch watch;
    const bool has_states = dl_state_watch_create(f->scene, &watch, NULL) == DL_OK;
    const dl_status status = read_frames(f, has_states ? &watch : NULL, error);
    if (has_states) {
        dl_state_watch_free(&watch);
    } else {
        free(f->state);
        f->state = NULL;
    }
    return status;
}

static dl_status find_scale(film *f, dl_error *error) {
    dl_model *model = NULL;
    dl_status status = dl_model_create(f->scene, &model, error);
    double *const y = status ? NULL : malloc(2 * (model->unknowns + 1) * sizeof *y);
    if (!status && !y)
        status = dl_fail_memory(error, "a player");
    if (!status) {
        dl_model_initial_state(model, y);
        status = dl_model_energy_scale(model, y, &f->scale, error);
    }
    free(y);
    dl_model_free(model);
    return status;
}

static dl_status film_read(const char *path, size_t most_bytes, film *f, dl_error *error) {
    dl_status status = dl_frames_open(path, &f->frames, error);
    if (!status)
        status = dl_scene_read_trajectory(path, &f->scene, error);
    if (status)
        return status;
    f->n = f->frames->particles;
    f->dimension = (size_t)f->scene->dimension;
    status = dl_masses_create(f->scene, &f->masses, error);
    if (!status)
        status = choose_frames(f, most_bytes, error);
    if (!status)
        status = read_states_and_frames(f, error);
    if (!status)
        status = find_scale(f, error);
    for (size_t i = 0; i < f->n && !status; i++)
        f->size[i] = dl_size_of(&f->masses, f->scene->inertia[i]);
    return status;
}

/* --- numbers ---------------------------------------------------------------------------------- */

static json_t *real(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *pair(double low, double high) {
    return json_pack("[oo]", real(low), real(high));
}

/* Nine digits are more than a page can show, and keep it small. */
static double rounded(double value) {
    char text[32];
    snprintf(text, sizeof text, "%.9g", value);
    return strtod(text, NULL);
}

/* Smallest and largest of component k over all frames; part 0: positions, 1: velocities. */
static void range_of(const film *f, size_t part, size_t k, double *low, double *high) {
    *low = INFINITY;
    *high = -INFINITY;
    for (size_t frame = 0; frame < f->shown; frame++) {
        const double *const x = frame_at(f, frame) + (part * f->dimension + k) * f->n;
        for (size_t i = 0; i < f->n; i++) {
            *low = fmin(*low, x[i]);
            *high = fmax(*high, x[i]);
        }
    }
}

/* Component k of `part` as whole numbers: `zero` is 0, `unit` is 1; two bytes each. */
static void quantise(const film *f, size_t part, size_t k, double zero, double unit,
                     unsigned char *bytes) {
    for (size_t frame = 0; frame < f->shown; frame++) {
        const double *const x = frame_at(f, frame) + (part * f->dimension + k) * f->n;
        unsigned char *const to = bytes + 2 * (frame * f->dimension + k) * f->n;
        for (size_t i = 0; i < f->n; i++) {
            const long value = lround((x[i] - zero) / unit);
            to[2 * i] = (unsigned char)(value & 255);
            to[2 * i + 1] = (unsigned char)(value >> 8 & 255);
        }
    }
}

static json_t *base64_of(const unsigned char *bytes, size_t count) {
    char *const text = bytes ? dl_base64(bytes, count) : NULL;
    json_t *const string = text ? json_string_nocheck(text) : NULL;
    free(text);
    return string;
}

static bool put_positions(const film *f, json_t *object) {
    const size_t size = 2 * f->shown * f->dimension * f->n;
    unsigned char *const bytes = malloc(size + 1);
    json_t *const lows = json_array(), *const highs = json_array();
    for (size_t k = 0; k < f->dimension && bytes; k++) {
        double low, high;
        range_of(f, 0, k, &low, &high);
        quantise(f, 0, k, low, high > low ? (high - low) / 65535 : 1, bytes);
        json_array_append_new(lows, real(low));
        json_array_append_new(highs, real(high));
    }
    const bool good = json_object_set_new(object, "low", lows) == 0 &&
                      json_object_set_new(object, "high", highs) == 0 &&
                      json_object_set_new(object, "position", base64_of(bytes, size)) == 0;
    free(bytes);
    return good;
}

static bool put_velocities(const film *f, json_t *object) {
    const size_t size = 2 * f->shown * f->dimension * f->n;
    unsigned char *const bytes = malloc(size + 1);
    double fastest = 0;
    for (size_t k = 0; k < f->dimension; k++) {
        double low, high;
        range_of(f, 1, k, &low, &high);
        fastest = fmax(fastest, fmax(-low, high));
    }
    for (size_t k = 0; k < f->dimension && bytes; k++)
        quantise(f, 1, k, 0, fastest > 0 ? fastest / 32767 : 1, bytes);
    const bool good = json_object_set_new(object, "fastest", real(fastest)) == 0 &&
                      json_object_set_new(object, "velocity", base64_of(bytes, size)) == 0;
    free(bytes);
    return good;
}

/* --- what there is to see --------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

/* Median of what the first, the middle and the last frame say: one may be crowded by chance, or
 * have burst. */
static double radius_of(const film *f) {
    double radius[3];
    for (size_t k = 0; k < 3; k++)
        radius[k] = dl_natural_radius(f->scene, frame_at(f, k * (f->shown - 1) / 2), 0, 1, f->size);
    qsort(radius, 3, sizeof *radius, ascending);
    return radius[1];
}

static bool put_window(const film *f, json_t *object, double radius) {
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (size_t frame = 0; frame < f->shown; frame++)
        for (int up = 1; up < (int)f->dimension; up++) {
            const dl_picture picture = {
                .scene = f->scene, .y_all = frame_at(f, frame), .across = 0, .up = up};
            const dl_picture_window window = dl_window_of(&picture, NULL, radius);
            for (int k = 0; k < 2; k++) {
                const int axis = k ? up : 0;
                low[axis] = fmin(low[axis], window.low[k]);
                high[axis] = fmax(high[axis], window.high[k]);
            }
        }
    json_t *const window = json_array();
    for (size_t k = 0; k < f->dimension; k++)
        json_array_append_new(window, pair(low[k], high[k]));
    return json_object_set_new(object, "window", window) == 0;
}

/* From about 20000 speeds of all frames; without memory none. */
static dl_speed_range speeds_of(const film *f) {
    static const size_t most = 20000;
    const size_t all = f->shown * f->n, stride = all / most + 1;
    double *const speed = malloc((all / stride + 1) * sizeof *speed);
    size_t count = 0;
    if (!speed)
        return (dl_speed_range){0};
    for (size_t at = 0; at < all; at += stride) {
        const double *const v = frame_at(f, at / f->n) + f->dimension * f->n + at % f->n;
        double square = 0;
        for (size_t k = 0; k < f->dimension; k++)
            square += v[k * f->n] * v[k * f->n];
        speed[count++] = sqrt(square);
    }
    const dl_speed_range range = dl_speed_range_of(speed, count);
    free(speed);
    return range;
}

static json_t *walls_of(const film *f) {
    if (!f->scene->walls.present)
        return json_null();
    json_t *const walls = json_array();
    for (size_t k = 0; k < f->dimension; k++)
        json_array_append_new(walls, pair(f->scene->walls.low[k], f->scene->walls.high[k]));
    return walls;
}

static json_t *periods_of(const film *f) {
    const dl_periods *const box = &f->scene->periods;
    if (!box->present)
        return json_null();
    json_t *const periods = json_array();
    for (size_t k = 0; k < f->dimension; k++)
        json_array_append_new(periods, box->length[k] > 0
                                           ? pair(box->low[k], box->low[k] + box->length[k])
                                           : json_null());
    return periods;
}

static bool put_particles(const film *f, json_t *object) {
    json_t *const mass = json_array(), *const size = json_array(), *const shade = json_array(),
                  *const pinned = json_array();
    for (size_t i = 0; i < f->n; i++) {
        json_array_append_new(mass, json_real(rounded(f->scene->inertia[i])));
        json_array_append_new(size, json_real(rounded(f->size[i])));
        json_array_append_new(shade, json_integer(dl_shade_of(&f->masses, f->scene->inertia[i])));
        if (f->scene->pinned[i])
            json_array_append_new(pinned, json_integer((json_int_t)i));
    }
    return json_object_set_new(object, "mass", mass) == 0 &&
           json_object_set_new(object, "size", size) == 0 &&
           json_object_set_new(object, "shade", shade) == 0 &&
           json_object_set_new(object, "pinned", pinned) == 0;
}

/* null where the file has no such series. */
static json_t *shown_of(const film *f, const double *series) {
    json_t *const values = series ? json_array() : json_null();
    for (size_t k = 0; k < f->shown && series; k++)
        json_array_append_new(values, real(rounded(series[f->number[k]])));
    return values;
}

static bool put_series(const film *f, json_t *object) {
    const double *const error = f->frames->energy_error;
    json_t *const time = json_array(), *const step = json_array();
    json_t *const energy = error ? json_array() : json_null();
    for (size_t k = 0; k < f->shown; k++) {
        const size_t number = f->number[k];
        json_array_append_new(time, real(rounded(f->frames->time[number])));
        json_array_append_new(step, json_integer(f->frames->step[number]));
        if (error)
            json_array_append_new(energy, real(rounded(fabs(error[number]) / f->scale)));
    }
    return json_object_set_new(object, "time", time) == 0 &&
           json_object_set_new(object, "step", step) == 0 &&
           json_object_set_new(object, "energy", energy) == 0 &&
           json_object_set_new(object, "kinetic", shown_of(f, f->frames->kinetic)) == 0 &&
           json_object_set_new(object, "potential", shown_of(f, f->frames->potential)) == 0;
}

/* --- looks ------------------------------------------------------------------------------------ */

static bool put_looks(json_t *object) {
    enum { shown = 64 };
    json_t *const colours = json_array(), *const states = json_array();
    for (int k = 0; k < shown; k++)
        json_array_append_new(colours, json_integer(dl_colour_of((k + 0.5) / shown)));
    for (size_t k = 0; k < sizeof dl_state_looks / sizeof *dl_state_looks; k++) {
        const dl_state_look *const look = &dl_state_looks[k];
        json_array_append_new(states, json_pack("{ss si si si sf sf}", "name", look->name, "fill",
                                                look->fill, "stroke", look->stroke, "corners",
                                                look->corners, "first", look->first_corner, "reach",
                                                look->reach));
    }
    return json_object_set_new(object, "colours", colours) == 0 &&
           json_object_set_new(object, "states", states) == 0;
}

/* --- the whole -------------------------------------------------------------------------------- */

static json_t *text(const char *value) {
    json_t *const string = json_string(value ? value : "");
    return string ? string : json_string("?"); /* no UTF-8 */
}

static json_t *film_json(const film *f) {
    const double radius = radius_of(f);
    const dl_speed_range speeds = speeds_of(f);
    json_t *const object = json_pack(
        "{so so so sI sI sI sI so so so so so}", "name", text(f->scene->name), "method",
        text(f->frames->method), "options", text(f->frames->options), "particles", (json_int_t)f->n,
        "dimension", (json_int_t)f->dimension, "frames", (json_int_t)f->frames->count, "stride",
        (json_int_t)f->stride, "radius", real(radius), "speeds", pair(speeds.low, speeds.high),
        "walls", walls_of(f), "periods", periods_of(f), "state",
        f->state ? base64_of(f->state, f->shown * f->n) : json_null());
    if (object && put_series(f, object) && put_particles(f, object) && put_looks(object) &&
        put_window(f, object, radius) && put_positions(f, object) && put_velocities(f, object))
        return object;
    json_decref(object);
    return NULL;
}

dl_status dl_player_data(const char *path, size_t most_bytes, char **json, dl_error *error) {
    film f = {0};
    *json = NULL;
    dl_status status = film_read(path, most_bytes, &f, error);
    if (!status) {
        json_t *const object = film_json(&f);
        char *const dumped = object ? json_dumps(object, JSON_COMPACT) : NULL;
        *json = dumped ? dl_page_json(dumped) : NULL;
        free(dumped);
        json_decref(object);
        status = *json ? DL_OK : dl_fail_memory(error, "a player");
    }
    film_free(&f);
    return status;
}
