#include "report/paper_plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "report/picture_draw.h"

static const double plot_left = 84, plot_top = 66, plot_width = 760, plot_height = 380;
enum { ink_computed = 0x0072b2, ink_published = 0xd55e00, ink_grid = 0xe2e2e2 };

/* An axis in the curve's units. */
typedef struct plot_axis {
    double low, high, scale; /* units of the picture in one of the curve's */
} plot_axis;

typedef struct plot_sheet {
    canvas *canvas;
    plot_axis x, y;
} plot_sheet;

static void include(plot_axis *axis, double value) {
    axis->low = fmin(axis->low, value);
    axis->high = fmax(axis->high, value);
}

/* With room around, for the line and the marks; a constant has some as well. */
static void finish_axis(plot_axis *axis, double length, double room) {
    const double size = fmax(fabs(axis->low), fabs(axis->high));
    const double extent = axis->high - axis->low;
    const double pad = extent > 1e-12 * size ? room * extent : size > 0 ? 0.1 * size : 1;
    axis->low -= pad;
    axis->high += pad;
    axis->scale = length / (axis->high - axis->low);
}

static void find_axes(const dl_paper_picture *picture, const dl_paper_curve *curve,
                      plot_sheet *plot) {
    plot->x = plot->y = (plot_axis){.low = INFINITY, .high = -INFINITY};
    for (size_t k = 0; k < curve->count; k++) {
        include(&plot->x, curve->at[k]);
        include(&plot->y, curve->value[k]);
    }
    for (size_t k = 0; k < picture->marks; k++) {
        include(&plot->x, picture->mark[k].at);
        include(&plot->y, picture->mark[k].value);
    }
    finish_axis(&plot->x, plot_width, 0.02);
    finish_axis(&plot->y, plot_height, 0.06);
}

static canvas_point point_at(const plot_sheet *plot, double x, double y) {
    return (canvas_point){plot_left + plot->x.scale * (x - plot->x.low),
                          plot_top + plot->y.scale * (plot->y.high - y)};
}

/* --- axes ------------------------------------------------------------------------------------- */

static void draw_ticks(const plot_sheet *plot, bool across) {
    const canvas_style style = {
        .name = "grid", .fill = CANVAS_NONE, .stroke = ink_grid, .width = 1};
    const plot_axis *const axis = across ? &plot->x : &plot->y;
    const double step = dl_nice_step(axis->scale, across ? 90 : 45);
    const canvas_font font = {
        .size = 13, .colour = DL_INK, .anchor = across ? CANVAS_MIDDLE : CANVAS_END};
    const double first = ceil(axis->low / step);
    const int ticks = (int)(floor(axis->high / step) - first) + 1;
    for (int k = 0; k < ticks; k++) {
        const double value = (first + k) * step;
        const canvas_point from =
            across ? point_at(plot, value, plot->y.low) : point_at(plot, plot->x.low, value);
        const canvas_point to =
            across ? point_at(plot, value, plot->y.high) : point_at(plot, plot->x.high, value);
        char text[32];
        snprintf(text, sizeof text, value < 0 ? "\u2212%.6g" : "%.6g", fabs(value));
        dl_canvas_svg.lines(plot->canvas, 2, (canvas_point[]){from, to}, &style);
        dl_canvas_svg.text(plot->canvas,
                           across ? (canvas_point){from.x, from.y + 18}
                                  : (canvas_point){from.x - 8, from.y + 4.5},
                           text, &font);
    }
}

static void draw_axes(const plot_sheet *plot, const dl_paper_picture *picture, bool by_step) {
    const canvas_font font = {.size = 14, .colour = DL_INK, .anchor = CANVAS_MIDDLE};
    canvas_font upwards = font;
    upwards.upwards = true;
    draw_ticks(plot, true);
    draw_ticks(plot, false);
    dl_canvas_svg.text(plot->canvas,
                       (canvas_point){plot_left + plot_width / 2, plot_top + plot_height + 42},
                       by_step ? "step" : "t [time]", &font);
    dl_canvas_svg.text(plot->canvas, (canvas_point){20, plot_top + plot_height / 2},
                       *picture->axis ? picture->axis : picture->curve, &upwards);
}

/* --- curve and marks -------------------------------------------------------------------------- */

static dl_status draw_curve(const plot_sheet *plot, const dl_paper_curve *curve, dl_error *error) {
    const canvas_style style = {
        .name = "computed", .fill = CANVAS_NONE, .stroke = ink_computed, .width = 1.6};
    canvas_point *const point = malloc(curve->count * sizeof *point);
    if (!point)
        return dl_fail_memory(error, "a curve");
    for (size_t k = 0; k < curve->count; k++)
        point[k] = point_at(plot, curve->at[k], curve->value[k]);
    dl_canvas_svg.lines(plot->canvas, curve->count, point, &style);
    free(point);
    return DL_OK;
}

static void draw_marks(const plot_sheet *plot, const dl_paper_picture *picture) {
    const canvas_style style = {
        .name = "published", .fill = 0xffffff, .stroke = ink_published, .width = 2.2};
    for (size_t k = 0; k < picture->marks; k++)
        dl_canvas_svg.circle(
            plot->canvas, point_at(plot, picture->mark[k].at, picture->mark[k].value), 5, &style);
}

static void draw_words(const plot_sheet *plot, const dl_paper_picture *picture,
                       const dl_paper_curve *curve) {
    const canvas_font title = {.size = 18, .colour = DL_INK, .bold = true};
    canvas_font words = {.size = 13, .colour = ink_computed};
    char text[96];
    dl_canvas_svg.text(plot->canvas, (canvas_point){20, 28}, picture->figure, &title);
    snprintf(text, sizeof text, "line: computed, %zu frames", curve->count);
    dl_canvas_svg.text(plot->canvas, (canvas_point){20, 50}, text, &words);
    words.colour = ink_published;
    if (picture->marks)
        dl_canvas_svg.text(plot->canvas, (canvas_point){240, 50}, "circles: published", &words);
}

dl_status dl_paper_plot_write(const dl_paper_picture *picture, const dl_paper_curve *curve,
                              const char *path, dl_error *error) {
    plot_sheet plot = {.canvas =
                           dl_canvas_svg.create(plot_left + plot_width + 20,
                                                plot_top + plot_height + 56, picture->figure)};
    if (!plot.canvas)
        return dl_fail_memory(error, "a curve");
    find_axes(picture, curve, &plot);
    draw_axes(&plot, picture, curve->by_step);
    const dl_status status = draw_curve(&plot, curve, error);
    draw_marks(&plot, picture);
    draw_words(&plot, picture, curve);
    const dl_status finished = dl_canvas_svg.finish(plot.canvas, path, status ? NULL : error);
    return status ? status : finished;
}
