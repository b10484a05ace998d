#include "report/picture_view.h"

#include <math.h>

static const double flattest = 0.15; /* height to width of a window, and width to height */

void dl_drawn_position(const dl_picture *picture, size_t i, double at[2]) {
    const int axis[2] = {picture->across, picture->up};
    const dl_periods *const box = &picture->scene->periods;
    for (int k = 0; k < 2; k++) {
        const double x = picture->y_all[(size_t)axis[k] * picture->scene->particles + i];
        const double length = box->length[axis[k]], low = box->low[axis[k]];
        at[k] = length > 0 ? x - length * floor((x - low) / length) : x;
    }
}

/* --- window ----------------------------------------------------------------------------------- */

static void include(dl_picture_window *window, int k, double low, double high) {
    window->low[k] = fmin(window->low[k], low);
    window->high[k] = fmax(window->high[k], high);
}

static void include_walls(const dl_walls *walls, int axis, int k, double reach,
                          dl_picture_window *window) {
    if (!walls->present)
        return;
    const double low = walls->low[axis], high = walls->high[axis];
    const double room = 0.01 * reach; /* for the line itself */
    if (window->low[k] - low <= reach)
        include(window, k, low - room, low);
    if (high - window->high[k] <= reach)
        include(window, k, high, high + room);
}

/* Neither a point nor a line: particles in a row have room above and below. */
static void widen(dl_picture_window *window, int k, double least) {
    const double lack = least - (window->high[k] - window->low[k]);
    if (lack > 0)
        include(window, k, window->low[k] - lack / 2, window->high[k] + lack / 2);
}

dl_picture_window dl_window_of(const dl_picture *picture, const bool *kept, double margin) {
    const dl_scene *const scene = picture->scene;
    const int axis[2] = {picture->across, picture->up};
    dl_picture_window window = {{INFINITY, INFINITY}, {-INFINITY, -INFINITY}};
    for (size_t i = 0; i < scene->particles; i++) {
        double at[2];
        dl_drawn_position(picture, i, at);
        for (int k = 0; k < 2 && (!kept || kept[i]); k++)
            include(&window, k, at[k], at[k]);
    }
    const double wide = window.high[0] - window.low[0], tall = window.high[1] - window.low[1];
    const double reach = fmax(wide, tall) > 0 ? fmax(wide, tall) : 1;
    const double room = fmax(margin, 0.02 * reach);
    for (int k = 0; k < 2; k++) {
        include(&window, k, window.low[k] - room, window.high[k] + room);
        include_walls(&scene->walls, axis[k], k, reach, &window);
        if (scene->periods.length[axis[k]] > 0)
            include(&window, k, scene->periods.low[axis[k]],
                    scene->periods.low[axis[k]] + scene->periods.length[axis[k]]);
    }
    widen(&window, 0, flattest * (window.high[1] - window.low[1]));
    widen(&window, 1, flattest * (window.high[0] - window.low[0]));
    return window;
}

/* --- scale ------------------------------------------------------------------------------------ */

dl_view dl_view_fit(const dl_picture_window *window, double left, double top, double most_width,
                    double most_height) {
    const double wide = window->high[0] - window->low[0], tall = window->high[1] - window->low[1];
    const double scale = fmin(most_width / wide, most_height / tall);
    return (dl_view){*window, scale, left, top, scale * wide, scale * tall};
}

canvas_point dl_view_at(const dl_view *view, double x, double y) {
    return (canvas_point){view->left + view->scale * (x - view->window.low[0]),
                          view->top + view->scale * (view->window.high[1] - y)};
}

double dl_nice_step(double scale, double apart) {
    static const double nice[] = {1, 2, 5, 10};
    const double least = apart / scale, power = pow(10, floor(log10(least)));
    size_t k = 0;
    while (k < 3 && nice[k] * power < least * (1 - 1e-9))
        k++;
    return nice[k] * power;
}
