/* What stands beneath a picture: masses, states, speeds, in rows as wide as the picture. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "report/picture_draw.h"

static const double font_size = 13, character = 6.6; /* mean width of one */
static const double gap = 8, between = 22, margin = 20;
static const size_t most_masses = 6;

/* Where the next entry goes. */
typedef struct flow {
    const dl_drawing *drawing;
    double x, top, row; /* row: height of this row so far */
} flow;

/* Room for a mark of that size with its text; a new row where this one is full. Returns the middle
 * of the mark's left edge. */
static canvas_point place(flow *legend, double width, double height, const char *text) {
    const double whole = width + gap + character * (double)strlen(text);
    if (legend->x > margin && legend->x + whole > legend->drawing->width - margin) {
        legend->top += legend->row;
        legend->x = margin;
        legend->row = 0;
    }
    legend->row = fmax(legend->row, height + 6);
    const canvas_point at = {legend->x, legend->top + 14};
    const canvas_font font = {.size = font_size, .colour = DL_INK, .anchor = CANVAS_START};
    dl_draw_text(legend->drawing, (canvas_point){at.x + width + gap, at.y + 4.5}, text, &font);
    legend->x += whole + between;
    return at;
}

static const double least_row = 22;

static void add_particle(flow *legend, double radius, int fill, const dl_state_look *state,
                         const char *text) {
    const double reach = state ? radius * state->reach : radius;
    const canvas_point at = place(legend, 2 * reach, fmax(2 * reach, least_row), text);
    dl_draw_particle(legend->drawing, (canvas_point){at.x + reach, at.y}, radius, fill, state);
}

/* Every mass where they are few, some of them from the lightest to the heaviest elsewhere. */
static void add_masses(flow *legend, bool shaded) {
    const dl_drawing *const drawing = legend->drawing;
    const dl_masses *const masses = &drawing->masses;
    const size_t shown = masses->count <= most_masses ? masses->count : most_masses;
    const double largest = fmin(drawing->radius, 10);
    for (size_t k = 0; k < shown; k++) {
        const size_t which = shown > 1 ? k * (masses->count - 1) / (shown - 1) : 0;
        const double mass = masses->mass[which];
        const double size = drawing->picture->equal_size ? 1 : dl_size_of(masses, mass);
        char text[80];
        if (masses->count <= most_masses)
            snprintf(text, sizeof text, "mass %.6g (%zu)", mass, masses->number[which]);
        else
            snprintf(text, sizeof text, "mass %.4g", mass);
        const int shade = shaded ? dl_shade_of(masses, mass) : 0xffffff;
        add_particle(legend, fmax(largest * size, 2.5),
                     drawing->picture->velocities ? dl_faded(shade) : shade, NULL, text);
    }
}

static void add_states(flow *legend) {
    const dl_picture *const picture = legend->drawing->picture;
    size_t number[3] = {0};
    for (size_t i = 0; i < picture->scene->particles; i++)
        number[picture->state[i]]++;
    for (size_t k = 0; k < sizeof dl_state_looks / sizeof *dl_state_looks; k++) {
        char text[80];
        snprintf(text, sizeof text, "%s (%zu)", dl_state_looks[k].name, number[k]);
        add_particle(legend, 5.5, 0xffffff, &dl_state_looks[k], text);
    }
}

static void add_speeds(flow *legend) {
    enum { cells = 45 };
    static const double cell = 4, height = 12;
    char text[80];
    const dl_speed_range *const speeds = &legend->drawing->speeds;
    snprintf(text, sizeof text, "speed %.3g to %.3g%s [length/time]", speeds->low, speeds->high,
             speeds->has_faster ? " and more" : "");
    const canvas_point at = place(legend, cells * cell, least_row, text);
    for (int k = 0; k < cells; k++) {
        const double left = at.x + k * cell, right = left + cell + (k + 1 < cells ? 0.5 : 0);
        const canvas_point corner[] = {{left, at.y - height / 2},
                                       {right, at.y - height / 2},
                                       {right, at.y + height / 2},
                                       {left, at.y + height / 2}};
        dl_draw_lines(
            legend->drawing, 4, corner,
            &(canvas_style){.fill = dl_colour_of((k + 0.5) / cells), .stroke = CANVAS_NONE});
    }
}

static void add_pins(flow *legend) {
    const dl_scene *const scene = legend->drawing->picture->scene;
    static const double radius = 7;
    size_t number = 0;
    char text[80];
    for (size_t i = 0; i < scene->particles; i++)
        number += scene->pinned[i];
    if (number == 0)
        return;
    snprintf(text, sizeof text, "pinned (%zu)", number);
    const canvas_point at = place(legend, 2 * radius, least_row, text);
    dl_draw_pin(legend->drawing, (canvas_point){at.x + radius, at.y}, radius);
}

static void add_velocity(flow *legend) {
    const dl_drawing *const drawing = legend->drawing;
    if (!(drawing->arrow > 0))
        return;
    const double speed = dl_nice_step(drawing->arrow, 18);
    char text[80];
    snprintf(text, sizeof text, "velocity %.4g [length/time]", speed);
    const canvas_point at = place(legend, speed * drawing->arrow, least_row, text);
    dl_draw_arrow(drawing, at, 1, 0, speed * drawing->arrow);
}

double dl_draw_legend(const dl_drawing *drawing, double top) {
    const dl_picture *const picture = drawing->picture;
    const bool several = drawing->masses.count > 1;
    flow legend = {drawing, margin, top, least_row};
    if (picture->colour == DL_COLOUR_SPEED)
        add_speeds(&legend);
    if (picture->colour == DL_COLOUR_STATE)
        add_states(&legend);
    if (several || picture->colour == DL_COLOUR_MASS)
        add_masses(&legend,
                   picture->colour == DL_COLOUR_MASS || picture->colour == DL_COLOUR_STATE);
    add_pins(&legend);
    if (picture->velocities)
        add_velocity(&legend);
    return legend.x > margin ? legend.top + legend.row - top : 0;
}
