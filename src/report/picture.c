/* The picture: measure what is to be drawn, lay it out, draw it. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/picture_draw.h"

static const double left_margin = 64, right_margin = 20, top_margin = 66, axis_room = 46;
static const double most_width = 860, most_height = 760;
static const double smallest = 1.5, largest = 22; /* radii of circles */
static const double state_shrink = 0.72;          /* room for the figures around them */
static const double arrow_shrink = 0.45;          /* and for arrows */

/* --- strokes ---------------------------------------------------------------------------------- */

void dl_draw_circle(const dl_drawing *drawing, canvas_point centre, double radius,
                    const canvas_style *style) {
    if (drawing->canvas)
        drawing->ops->circle(drawing->canvas, centre, radius, style);
}

void dl_draw_lines(const dl_drawing *drawing, size_t count, const canvas_point *point,
                   const canvas_style *style) {
    if (drawing->canvas)
        drawing->ops->lines(drawing->canvas, count, point, style);
}

void dl_draw_text(const dl_drawing *drawing, canvas_point at, const char *text,
                  const canvas_font *font) {
    if (drawing->canvas)
        drawing->ops->text(drawing->canvas, at, text, font);
}

void dl_draw_arrow(const dl_drawing *drawing, canvas_point tail, double dx, double dy,
                   double length) {
    const double head = fmin(7, 0.45 * length), half = 0.4 * head, neck = length - head;
    const canvas_point shaft[] = {tail, {tail.x + neck * dx, tail.y + neck * dy}};
    const canvas_point tip[] = {{tail.x + length * dx, tail.y + length * dy},
                                {shaft[1].x - half * dy, shaft[1].y + half * dx},
                                {shaft[1].x + half * dy, shaft[1].y - half * dx}};
    dl_draw_lines(
        drawing, 2, shaft,
        &(canvas_style){.name = "velocity", .fill = CANVAS_NONE, .stroke = DL_INK, .width = 1.1});
    dl_draw_lines(drawing, 3, tip,
                  &(canvas_style){.name = "head", .fill = DL_INK, .stroke = CANVAS_NONE});
}

static void draw_figure(const dl_drawing *drawing, canvas_point centre, double radius,
                        const dl_state_look *state) {
    static const double turn = 6.28318530717958647692;
    canvas_point corner[8];
    for (int k = 0; k < state->corners; k++) {
        const double angle = turn * (state->first_corner + (double)k / state->corners);
        corner[k] = (canvas_point){centre.x + radius * state->reach * cos(angle),
                                   centre.y - radius * state->reach * sin(angle)};
    }
    dl_draw_lines(
        drawing, (size_t)state->corners, corner,
        &(canvas_style){
            .name = state->name, .fill = state->fill, .stroke = state->stroke, .width = 1.2});
}

void dl_draw_particle(const dl_drawing *drawing, canvas_point centre, double radius, int fill,
                      const dl_state_look *state) {
    if (state && state->corners)
        draw_figure(drawing, centre, radius, state);
    const canvas_style style = {.name = "particle",
                                .fill = fill,
                                .stroke = DL_OUTLINE,
                                .width = fmin(0.9, 0.15 * radius + 0.3)};
    dl_draw_circle(drawing, centre, radius, &style);
}

/* --- particles -------------------------------------------------------------------------------- */

int dl_faded(int colour) {
    int mixed = 0;
    for (int shift = 16; shift >= 0; shift -= 8)
        mixed |= (255 - (255 - (colour >> shift & 255)) * 2 / 5) << shift;
    return mixed;
}

static int fill_of(const dl_drawing *drawing, size_t i) {
    const dl_picture *const picture = drawing->picture;
    int fill = 0xffffff;
    if (picture->colour == DL_COLOUR_SPEED)
        fill = dl_colour_of(dl_speed_part(&drawing->speeds, drawing->speed[i]));
    else if (picture->colour != DL_COLOUR_NONE)
        fill = dl_shade_of(&drawing->masses, picture->scene->inertia[i]);
    return picture->velocities ? dl_faded(fill) : fill;
}

static bool is_inside(const dl_drawing *drawing, const double at[2]) {
    const dl_picture_window *const window = &drawing->view.window;
    return at[0] >= window->low[0] && at[0] <= window->high[0] && at[1] >= window->low[1] &&
           at[1] <= window->high[1];
}

void dl_draw_pin(const dl_drawing *drawing, canvas_point centre, double radius) {
    const double d = 0.6 * radius;
    const canvas_style style = {
        .name = "pinned", .fill = CANVAS_NONE, .stroke = DL_INK, .width = 1.2};
    const canvas_point down[] = {{centre.x - d, centre.y - d}, {centre.x + d, centre.y + d}};
    const canvas_point up[] = {{centre.x - d, centre.y + d}, {centre.x + d, centre.y - d}};
    dl_draw_lines(drawing, 2, down, &style);
    dl_draw_lines(drawing, 2, up, &style);
}

static double shrink_of(const dl_picture *picture) {
    if (picture->velocities)
        return arrow_shrink;
    return picture->colour == DL_COLOUR_STATE ? state_shrink : 1;
}

static void draw_one(const dl_drawing *drawing, size_t i) {
    const dl_picture *const picture = drawing->picture;
    double at[2];
    dl_drawn_position(picture, i, at);
    if (!is_inside(drawing, at))
        return;
    const canvas_point centre = dl_view_at(&drawing->view, at[0], at[1]);
    const bool has_state = picture->colour == DL_COLOUR_STATE;
    const double radius = drawing->radius * drawing->size[i] * shrink_of(picture);
    dl_draw_particle(drawing, centre, radius, fill_of(drawing, i),
                     has_state ? &dl_state_looks[picture->state[i]] : NULL);
    if (picture->scene->pinned[i])
        dl_draw_pin(drawing, centre, radius);
}

static void draw_velocity(const dl_drawing *drawing, size_t i) {
    static const double least = 1.5;
    const dl_picture *const picture = drawing->picture;
    const size_t n = picture->scene->particles;
    const double *const v = picture->y_all + (size_t)picture->scene->dimension * n;
    const double across = v[(size_t)picture->across * n + i], up = v[(size_t)picture->up * n + i];
    const double speed = hypot(across, up);
    double at[2];
    dl_drawn_position(picture, i, at);
    if (is_inside(drawing, at) && speed * drawing->arrow > least)
        dl_draw_arrow(drawing, dl_view_at(&drawing->view, at[0], at[1]), across / speed,
                      -up / speed, speed * drawing->arrow);
}

/* What is drawn first: the farther in three dimensions, the larger in two. Who has the axes of the
 * picture to the right and up looks from +z at xy, from +x at yz, but from -y at xz. */
typedef struct rank {
    double key;
    size_t particle;
} rank;

static int by_key(const void *a, const void *b) {
    const rank *const left = a, *const right = b;
    const int order = (left->key > right->key) - (left->key < right->key);
    return order ? order : (left->particle > right->particle) - (left->particle < right->particle);
}

static dl_status find_order(dl_drawing *drawing, dl_error *error) {
    const dl_picture *const picture = drawing->picture;
    const size_t n = picture->scene->particles;
    const size_t depth = (size_t)(3 - picture->across - picture->up);
    const double towards = picture->across == 0 && picture->up == 2 ? -1 : 1; /* the viewer */
    rank *const ranked = malloc(n * sizeof *ranked);
    if (!ranked)
        return dl_fail_memory(error, "a picture");
    for (size_t i = 0; i < n; i++)
        ranked[i] = (rank){picture->scene->dimension == 3 ? towards * picture->y_all[depth * n + i]
                                                          : -drawing->size[i],
                           i};
    qsort(ranked, n, sizeof *ranked, by_key);
    for (size_t k = 0; k < n; k++)
        drawing->order[k] = ranked[k].particle;
    free(ranked);
    return DL_OK;
}

static void draw_particles(const dl_drawing *drawing) {
    const size_t n = drawing->picture->scene->particles;
    for (size_t k = 0; k < n; k++)
        draw_one(drawing, drawing->order[k]);
    for (size_t i = 0; i < n && drawing->picture->velocities; i++)
        draw_velocity(drawing, i);
}

/* --- walls, box, axes ------------------------------------------------------------------------- */

/* From one end of a wall to the other: as far as the walls across it, or the window. */
static void draw_wall(const dl_drawing *drawing, int k, double where) {
    const dl_picture *const picture = drawing->picture;
    const dl_walls *const walls = &picture->scene->walls;
    const int other = k == 0 ? picture->up : picture->across;
    const double from = fmax(drawing->view.window.low[1 - k], walls->low[other]);
    const double to = fmin(drawing->view.window.high[1 - k], walls->high[other]);
    const canvas_point end[] = {
        k == 0 ? dl_view_at(&drawing->view, where, from) : dl_view_at(&drawing->view, from, where),
        k == 0 ? dl_view_at(&drawing->view, where, to) : dl_view_at(&drawing->view, to, where)};
    dl_draw_lines(
        drawing, 2, end,
        &(canvas_style){.name = "wall", .fill = CANVAS_NONE, .stroke = DL_WALL, .width = 3.5});
}

static void draw_walls(const dl_drawing *drawing) {
    const dl_picture *const picture = drawing->picture;
    const dl_walls *const walls = &picture->scene->walls;
    const int axis[2] = {picture->across, picture->up};
    for (int k = 0; k < 2 && walls->present; k++) {
        if (isfinite(walls->low[axis[k]]))
            draw_wall(drawing, k, walls->low[axis[k]]);
        if (isfinite(walls->high[axis[k]]))
            draw_wall(drawing, k, walls->high[axis[k]]);
    }
}

static void draw_box(const dl_drawing *drawing) {
    const dl_picture *const picture = drawing->picture;
    const dl_periods *const box = &picture->scene->periods;
    const int axis[2] = {picture->across, picture->up};
    const canvas_style style = {
        .name = "box", .fill = CANVAS_NONE, .stroke = DL_QUIET, .width = 1, .dashed = true};
    for (int k = 0; k < 2; k++)
        for (int side = 0; side < 2 && box->length[axis[k]] > 0; side++) {
            const double at = box->low[axis[k]] + side * box->length[axis[k]];
            const double from = drawing->view.window.low[1 - k];
            const double to = drawing->view.window.high[1 - k];
            const canvas_point end[] = {k == 0 ? dl_view_at(&drawing->view, at, from)
                                               : dl_view_at(&drawing->view, from, at),
                                        k == 0 ? dl_view_at(&drawing->view, at, to)
                                               : dl_view_at(&drawing->view, to, at)};
            dl_draw_lines(drawing, 2, end, &style);
        }
}

static const canvas_font tick_font = {.size = 13, .colour = DL_INK};

static void draw_tick(const dl_drawing *drawing, int k, double value) {
    static const double length = 5;
    const dl_view *const view = &drawing->view;
    const canvas_point at = dl_view_at(view, k == 0 ? value : view->window.low[0],
                                       k == 0 ? view->window.low[1] : value);
    const canvas_point end = {at.x - (k == 0 ? 0 : length), at.y + (k == 0 ? length : 0)};
    char text[32];
    snprintf(text, sizeof text, value < 0 ? "\u2212%.6g" : "%.6g", fabs(value));
    dl_draw_lines(drawing, 2, (canvas_point[]){at, end},
                  &(canvas_style){.fill = CANVAS_NONE, .stroke = DL_QUIET, .width = 1});
    canvas_font font = tick_font;
    font.anchor = k == 0 ? CANVAS_MIDDLE : CANVAS_END;
    dl_draw_text(drawing, (canvas_point){end.x - (k == 0 ? 0 : 4), end.y + (k == 0 ? 14 : 4.5)},
                 text, &font);
}

static void draw_axis(const dl_drawing *drawing, int k) {
    static const char *const label[] = {"x [length]", "y [length]", "z [length]"};
    const dl_view *const view = &drawing->view;
    const double low = view->window.low[k], high = view->window.high[k];
    const double step = dl_nice_step(view->scale, k == 0 ? 75 : 45);
    const double first = ceil(low / step - 1e-9);
    const int ticks = (int)(floor(high / step + 1e-9) - first) + 1;
    for (int i = 0; i < ticks; i++)
        draw_tick(drawing, k, (first + i) * step);
    canvas_font font = {.size = 14, .colour = DL_INK, .anchor = CANVAS_MIDDLE, .upwards = k == 1};
    const canvas_point middle = {view->left + view->width / 2, view->top + view->height / 2};
    if (k == 0)
        dl_draw_text(drawing, (canvas_point){middle.x, view->top + view->height + 38},
                     label[drawing->picture->across], &font);
    else
        dl_draw_text(drawing, (canvas_point){17, middle.y}, label[drawing->picture->up], &font);
}

static void draw_frame(const dl_drawing *drawing) {
    const dl_view *const view = &drawing->view;
    const double left = view->left, top = view->top;
    const double right = left + view->width, bottom = top + view->height;
    const canvas_point corner[] = {
        {left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}};
    dl_draw_lines(
        drawing, 5, corner,
        &(canvas_style){.name = "frame", .fill = CANVAS_NONE, .stroke = DL_QUIET, .width = 1});
    draw_axis(drawing, 0);
    draw_axis(drawing, 1);
}

/* --- words ------------------------------------------------------------------------------------ */

static const char *title_of(const dl_picture *picture) {
    if (picture->title)
        return picture->title;
    return picture->scene->name ? picture->scene->name : "scene";
}

static void caption_of(const dl_drawing *drawing, char *text, size_t size) {
    const dl_picture *const picture = drawing->picture;
    int used = picture->caption ? snprintf(text, size, "%s", picture->caption)
                                : snprintf(text, size, "%zu particles", picture->scene->particles);
    if (drawing->outside && used > 0 && (size_t)used < size)
        snprintf(text + used, size - (size_t)used, " · %zu outside the picture", drawing->outside);
}

static double characters(const char *text) {
    double count = 0;
    for (; *text; text++)
        count += (*text & 0xc0) != 0x80; /* UTF-8's first bytes */
    return count;
}

/* Of the title and the caption, with their margins. */
static double words_width(const dl_drawing *drawing) {
    char text[512];
    caption_of(drawing, text, sizeof text);
    return 40 + fmax(10.5 * characters(title_of(drawing->picture)), 6.7 * characters(text));
}

static void draw_words(const dl_drawing *drawing) {
    const canvas_font title = {.size = 18, .colour = DL_INK, .bold = true};
    const canvas_font caption = {.size = 13, .colour = DL_QUIET};
    char text[512];
    caption_of(drawing, text, sizeof text);
    dl_draw_text(drawing, (canvas_point){20, 28}, title_of(drawing->picture), &title);
    dl_draw_text(drawing, (canvas_point){20, 50}, text, &caption);
}

/* --- measures --------------------------------------------------------------------------------- */

static dl_status measure_speeds(dl_drawing *drawing, dl_error *error) {
    const dl_scene *const scene = drawing->picture->scene;
    const size_t n = scene->particles, components = (size_t)scene->dimension;
    const double *const v = drawing->picture->y_all + components * n;
    double *const sorted = malloc(n * sizeof *sorted);
    if (!sorted)
        return dl_fail_memory(error, "a picture");
    for (size_t i = 0; i < n; i++) {
        double square = 0;
        for (size_t k = 0; k < components; k++)
            square += v[k * n + i] * v[k * n + i];
        sorted[i] = drawing->speed[i] = sqrt(square);
    }
    drawing->speeds = dl_speed_range_of(sorted, n);
    free(sorted);
    return DL_OK;
}

/* A mean arrow reaches the next particle, the longest a sixth of the picture. */
static double arrow_scale(const dl_drawing *drawing, double spacing) {
    const size_t n = drawing->picture->scene->particles;
    double square = 0, most = 0;
    for (size_t i = 0; i < n; i++) {
        square += drawing->speed[i] * drawing->speed[i];
        most = fmax(most, drawing->speed[i]);
    }
    const double longest = fmax(drawing->view.width, drawing->view.height) / 6;
    return most > 0 ? fmin(fmax(spacing, 10) / sqrt(square / (double)n), longest / most) : 0;
}

static double mean_size(const dl_drawing *drawing) {
    double sum = 0;
    for (size_t i = 0; i < drawing->picture->scene->particles; i++)
        sum += drawing->size[i];
    return sum / (double)drawing->picture->scene->particles;
}

static double least_size(const dl_drawing *drawing) {
    return drawing->picture->equal_size ? 1 : dl_size_of(&drawing->masses, drawing->masses.mass[0]);
}

static void lay_out(dl_drawing *drawing) {
    const dl_picture *const picture = drawing->picture;
    const double natural = dl_natural_radius(picture->scene, picture->y_all, picture->across,
                                             picture->up, drawing->size);
    dl_picture_window window =
        picture->window ? *picture->window : dl_window_of(picture, NULL, natural);
    /* Two bodies far apart are no giants. */
    const double reach = fmax(window.high[0] - window.low[0], window.high[1] - window.low[1]);
    const double spacing = 2 * natural * mean_size(drawing);
    const double margin =
        picture->velocities ? fmin(1.2 * spacing, 0.08 * reach) : fmin(natural, 0.03 * reach);
    if (!picture->window)
        window = dl_window_of(picture, NULL, margin);
    drawing->view = dl_view_fit(&window, left_margin, top_margin, most_width, most_height);
    const double scaled = fmin(natural * drawing->view.scale, largest);
    drawing->radius = fmax(natural > 0 ? scaled : 8, smallest / least_size(drawing));
    drawing->arrow = arrow_scale(drawing, spacing * drawing->view.scale);
    for (size_t i = 0; i < picture->scene->particles; i++) {
        double at[2];
        dl_drawn_position(picture, i, at);
        drawing->outside += !is_inside(drawing, at);
    }
    drawing->width = fmax(left_margin + drawing->view.width + right_margin, words_width(drawing));
    const double bottom = top_margin + drawing->view.height + axis_room;
    drawing->height = bottom + dl_draw_legend(drawing, bottom) + 8;
}

/* --- the whole -------------------------------------------------------------------------------- */

static dl_status draw(dl_drawing *drawing, dl_error *error) {
    const dl_view *const view = &drawing->view;
    drawing->canvas =
        drawing->ops->create(drawing->width, drawing->height, title_of(drawing->picture));
    if (!drawing->canvas)
        return dl_fail_memory(error, "a picture");
    drawing->ops->clip(drawing->canvas, "plot", (canvas_point){view->left, view->top}, view->width,
                       view->height);
    draw_box(drawing);
    draw_walls(drawing);
    draw_particles(drawing);
    drawing->ops->unclip(drawing->canvas);
    draw_frame(drawing);
    draw_words(drawing);
    dl_draw_legend(drawing, view->top + view->height + axis_room);
    return DL_OK;
}

/* Positions in a window must differ by more than their rounding. */
static dl_status check_window(const dl_picture_window *window, dl_error *error) {
    static const double narrowest = 1e-12;
    for (int k = 0; k < 2; k++) {
        const double low = window->low[k], high = window->high[k];
        if (!(high - low > narrowest * fmax(fabs(low), fabs(high))))
            return dl_fail(error, DL_INPUT,
                           "window: found %.17g to %.17g, expected one wider than %g of its "
                           "coordinates",
                           low, high, narrowest);
    }
    return DL_OK;
}

static dl_status prepare(dl_drawing *drawing, dl_error *error) {
    const dl_picture *const picture = drawing->picture;
    const size_t n = picture->scene->particles;
    drawing->size = malloc(n * sizeof *drawing->size);
    drawing->speed = malloc(n * sizeof *drawing->speed);
    drawing->order = malloc(n * sizeof *drawing->order);
    if (!drawing->size || !drawing->speed || !drawing->order)
        return dl_fail_memory(error, "a picture");
    dl_status status = dl_masses_create(picture->scene, &drawing->masses, error);
    for (size_t i = 0; i < n && !status; i++)
        drawing->size[i] =
            picture->equal_size ? 1 : dl_size_of(&drawing->masses, picture->scene->inertia[i]);
    if (!status)
        status = measure_speeds(drawing, error);
    if (!status)
        status = find_order(drawing, error);
    if (status)
        return status;
    lay_out(drawing);
    return check_window(&drawing->view.window, error);
}

dl_status dl_picture_write(const dl_picture *picture, const char *path, dl_error *error) {
    dl_drawing drawing = {.picture = picture};
    dl_status status = dl_canvas_for(path, &drawing.ops, error);
    if (status)
        return status;
    status = prepare(&drawing, error);
    if (!status)
        status = draw(&drawing, error);
    if (!status)
        status = drawing.ops->finish(drawing.canvas, path, error);
    dl_masses_free(&drawing.masses);
    free(drawing.size);
    free(drawing.speed);
    free(drawing.order);
    return status;
}
