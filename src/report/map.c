/* A map of stability: a column for each value of a number, in it a cell for every step that was
 * tried, coloured by what became of it; lines for the limit that the fastest motion lets expect and
 * for the papers' rule. */
#include "driftlab/map.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "report/canvas.h"
#include "report/picture_draw.h"
#include "study/trial.h"

/* Okabe and Ito's colours, which colour-blind eyes tell apart (https://jfly.uni-koeln.de/color/).
 */
static const int colours[] = {
    [DL_TRIAL_STABLE] = 0x009e73,      [DL_TRIAL_BLOW_UP] = 0xd55e00,
    [DL_TRIAL_ENERGY_GAIN] = 0xe69f00, [DL_TRIAL_ENERGY_LOSS] = 0xf0e442,
    [DL_TRIAL_TUNNELLING] = 0xcc79a7,  [DL_TRIAL_HEATING] = 0xb35900,
    [DL_TRIAL_BENDING] = 0x8c5a2b,     [DL_TRIAL_SOLVER] = 0x0072b2,
    [DL_TRIAL_COLLAPSE] = 0x56b4e9,    [DL_TRIAL_TIME_OUT] = 0x999999,
    [DL_TRIAL_CRASH] = 0x000000,       [DL_TRIAL_REFUSED] = 0xdddddd,
};

/* Lines across the columns. */
static const struct {
    const char *quantity, *text;
    canvas_style style;
} marks[] = {
    {"predicted limit",
     "limit on the oscillator / omega",
     {"predicted", CANVAS_NONE, DL_INK, 3, false}},
    {"r0/|v|", "r0/|v|, the papers' rule", {"rule", CANVAS_NONE, DL_INK, 2, true}},
};

enum { mark_count = sizeof marks / sizeof *marks };

typedef struct column {
    double value;
    const dl_finding *finding;
} column;

typedef struct drawing {
    const dl_map *map;
    const canvas_ops *ops;
    canvas *canvas;
    size_t columns;
    column *column;   /* ascending */
    double low, high; /* steps at the lower and upper edge */
    bool occurs[DL_TRIAL_END_COUNT], marked[mark_count];
} drawing;

static const double left = 84, top = 64, plot_width = 720, plot_height = 430;
static const double right_margin = 24, axis_room = 52, legend_row = 22;
enum { legend_rows = 3 };

/* --- what is drawn ---------------------------------------------------------------------------- */

/* The number `name` of a finding's scene; NAN: it has none. */
static double number_of(const dl_finding *finding, const char *name) {
    char quantity[80];
    snprintf(quantity, sizeof quantity, "$%s", name);
    const double *const value = dl_finding_quantity(finding, quantity);
    return value ? value[0] : NAN;
}

static bool is_asked(const dl_map *map, const dl_finding *finding) {
    if (finding->status != DL_OK || finding->rows == 0 ||
        (map->method && strcmp(map->method, finding->method) != 0))
        return false;
    for (size_t i = 0; i < map->lets; i++) {
        const double wanted = strtod(map->let[i].value, NULL);
        const double value = number_of(finding, map->let[i].name);
        if (!(fabs(value - wanted) <= 1e-12 * fabs(wanted)))
            return false;
    }
    return isfinite(number_of(finding, map->over));
}

static int by_value(const void *a, const void *b) {
    const column *const first = a, *const second = b;
    return (first->value > second->value) - (first->value < second->value);
}

static dl_status check_columns(const drawing *d, dl_error *error) {
    const dl_map *const map = d->map;
    if (d->columns == 0)
        return dl_fail(error, DL_INPUT,
                       "the results have no stability of %s%sover a number called %s, expected one "
                       "that a study's `let` lists",
                       map->method ? map->method : "a method", " ", map->over);
    for (size_t k = 0; k < d->columns; k++)
        if (strcmp(d->column[k].finding->method, d->column[0].finding->method) != 0)
            return dl_fail(error, DL_INPUT, "method: found none, expected one of %s, %s ...",
                           d->column[0].finding->method, d->column[k].finding->method);
    for (size_t k = 1; k < d->columns; k++)
        if (d->column[k].value == d->column[k - 1].value)
            return dl_fail(
                error, DL_INPUT,
                "found several scenes with %s = %g (%s, %s), expected one: other numbers "
                "have to be set",
                map->over, d->column[k].value, d->column[k - 1].finding->scene,
                d->column[k].finding->scene);
    return DL_OK;
}

static dl_status find_columns(const dl_results *results, drawing *d, dl_error *error) {
    d->column = calloc(results->findings + 1, sizeof *d->column);
    if (!d->column)
        return dl_fail_memory(error, "a map");
    if (strcmp(results->kind, "stability") != 0)
        return dl_fail(error, DL_INPUT,
                       "found the results of a study of kind %s, expected stability",
                       results->kind);
    for (size_t i = 0; i < results->findings; i++)
        if (is_asked(d->map, &results->finding[i]))
            d->column[d->columns++] =
                (column){number_of(&results->finding[i], d->map->over), &results->finding[i]};
    qsort(d->column, d->columns, sizeof *d->column, by_value);
    return check_columns(d, error);
}

static double step_of(const dl_finding *finding, size_t row) {
    return finding->table[row * finding->columns];
}

/* Where the cell of a row begins (side 0) or ends (side 1): halfway to the next, in ratio. */
static double edge_of(const dl_finding *finding, size_t row, int side) {
    const double step = step_of(finding, row);
    const bool last = side ? row + 1 == finding->rows : row == 0;
    if (finding->rows == 1)
        return side ? 1.1 * step : step / 1.1;
    if (last) /* as far as on the other side */
        return step * step / edge_of(finding, row, 1 - side);
    return sqrt(step * step_of(finding, side ? row + 1 : row - 1));
}

static void find_range(drawing *d) {
    d->low = INFINITY;
    d->high = 0;
    for (size_t k = 0; k < d->columns; k++) {
        const dl_finding *const finding = d->column[k].finding;
        d->low = fmin(d->low, edge_of(finding, 0, 0));
        d->high = fmax(d->high, edge_of(finding, finding->rows - 1, 1));
    }
}

/* --- drawing ---------------------------------------------------------------------------------- */

static double height_of(const drawing *d, double step) {
    return top + plot_height * log(d->high / step) / log(d->high / d->low);
}

static double side_of(const drawing *d, size_t k) {
    return left + plot_width * (double)k / (double)d->columns;
}

static void rectangle(const drawing *d, double x0, double x1, double y0, double y1, int fill) {
    const canvas_point corner[] = {{x0, y0}, {x1, y0}, {x1, y1}, {x0, y1}};
    d->ops->lines(d->canvas, 4, corner,
                  &(canvas_style){.name = "cell", .fill = fill, .stroke = fill, .width = 0.4});
}

/* The end whose word begins the line at *at, which moves on to the next line. */
static dl_trial_end next_word(const char **at) {
    const size_t length = strcspn(*at, "\n");
    dl_trial_end found = DL_TRIAL_REFUSED;
    for (int end = 0; end < DL_TRIAL_END_COUNT; end++) {
        const char *const word = dl_trial_word((dl_trial_end)end);
        if (strlen(word) <= length && strncmp(*at, word, strlen(word)) == 0)
            found = (dl_trial_end)end;
    }
    *at += length + ((*at)[length] == '\n');
    return found;
}

static void draw_column(drawing *d, size_t k) {
    const dl_finding *const finding = d->column[k].finding;
    const char *words = finding->row_words;
    for (size_t row = 0; row < finding->rows; row++) {
        const dl_trial_end end = next_word(&words);
        d->occurs[end] = true;
        rectangle(d, side_of(d, k), side_of(d, k + 1), height_of(d, edge_of(finding, row, 1)),
                  height_of(d, edge_of(finding, row, 0)), colours[end]);
    }
}

static const canvas_style frame_style = {.fill = CANVAS_NONE, .stroke = DL_QUIET, .width = 1};

static void draw_marks(drawing *d, size_t k) {
    for (size_t m = 0; m < mark_count; m++) {
        const double *const value = dl_finding_quantity(d->column[k].finding, marks[m].quantity);
        if (!value || !(value[0] > d->low && value[0] < d->high))
            continue;
        const double y = height_of(d, value[0]);
        d->marked[m] = true;
        d->ops->lines(d->canvas, 2, (canvas_point[]){{side_of(d, k), y}, {side_of(d, k + 1), y}},
                      &marks[m].style);
    }
}

static void draw_values(const drawing *d) {
    const canvas_font tick = {.size = 13, .colour = DL_INK, .anchor = CANVAS_MIDDLE};
    const canvas_font label = {.size = 14, .colour = DL_INK, .anchor = CANVAS_MIDDLE};
    for (size_t k = 0; k < d->columns; k++) {
        char text[40];
        snprintf(text, sizeof text, "%.4g", d->column[k].value);
        d->ops->text(
            d->canvas,
            (canvas_point){(side_of(d, k) + side_of(d, k + 1)) / 2, top + plot_height + 18}, text,
            &tick);
    }
    d->ops->text(d->canvas, (canvas_point){left + plot_width / 2, top + plot_height + 40},
                 d->map->over, &label);
}

/* 1, 2 and 5 times powers of ten. */
static void draw_steps(const drawing *d) {
    static const double parts[] = {1, 2, 5};
    const canvas_font tick = {.size = 13, .colour = DL_INK, .anchor = CANVAS_END};
    const canvas_font label = {
        .size = 14, .colour = DL_INK, .anchor = CANVAS_MIDDLE, .upwards = true};
    const bool all = d->high / d->low < 1e3;
    for (int power = (int)floor(log10(d->low)); power <= (int)ceil(log10(d->high)); power++)
        for (int part = 0; part < (all ? 3 : 1); part++) {
            const double step = parts[part] * pow(10, power), y = height_of(d, step);
            char text[40];
            if (step < d->low || step > d->high)
                continue;
            snprintf(text, sizeof text, "%.3g", step);
            d->ops->lines(d->canvas, 2, (canvas_point[]){{left - 5, y}, {left, y}}, &frame_style);
            d->ops->text(d->canvas, (canvas_point){left - 9, y + 4.5}, text, &tick);
        }
    d->ops->text(d->canvas, (canvas_point){18, top + plot_height / 2}, "step [time]", &label);
}

static void draw_legend(const drawing *d) {
    const canvas_font font = {.size = 13, .colour = DL_INK};
    double x = left, y = top + plot_height + axis_room + 16;
    for (int end = 0; end < DL_TRIAL_END_COUNT; end++) {
        const char *const word = dl_trial_word((dl_trial_end)end);
        if (!d->occurs[end])
            continue;
        rectangle(d, x, x + 16, y - 11, y + 1, colours[end]);
        d->ops->text(d->canvas, (canvas_point){x + 22, y}, word, &font);
        x += 46 + 7 * (double)strlen(word);
        if (x > left + plot_width - 100) {
            x = left;
            y += legend_row;
        }
    }
    x = left;
    y += legend_row;
    for (size_t m = 0; m < mark_count; m++) {
        if (!d->marked[m])
            continue;
        d->ops->lines(d->canvas, 2, (canvas_point[]){{x, y - 5}, {x + 26, y - 5}}, &marks[m].style);
        d->ops->text(d->canvas, (canvas_point){x + 32, y}, marks[m].text, &font);
        x += 60 + 7 * (double)strlen(marks[m].text);
    }
}

static void draw_frame(const drawing *d) {
    const double right = left + plot_width, bottom = top + plot_height;
    const canvas_point corner[] = {
        {left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}};
    d->ops->lines(d->canvas, 5, corner, &frame_style);
}

static dl_status draw(drawing *d, const dl_results *results, dl_error *error) {
    char caption[256];
    snprintf(caption, sizeof caption, "%s: what becomes of a fixed step, over %s",
             d->column[0].finding->method, d->map->over);
    d->canvas =
        d->ops->create(left + plot_width + right_margin,
                       top + plot_height + axis_room + legend_rows * legend_row, results->title);
    if (!d->canvas)
        return dl_fail_memory(error, "a map");
    d->ops->text(d->canvas, (canvas_point){20, 28}, results->title,
                 &(canvas_font){.size = 18, .colour = DL_INK, .bold = true});
    d->ops->text(d->canvas, (canvas_point){20, 50}, caption,
                 &(canvas_font){.size = 13, .colour = DL_QUIET});
    for (size_t k = 0; k < d->columns; k++)
        draw_column(d, k);
    for (size_t k = 0; k < d->columns; k++)
        draw_marks(d, k);
    draw_frame(d);
    draw_values(d);
    draw_steps(d);
    draw_legend(d);
    return DL_OK;
}

dl_status dl_map_write(const dl_results *results, const dl_map *map, const char *path,
                       dl_error *error) {
    drawing d = {.map = map};
    dl_status status = dl_canvas_for(path, &d.ops, error);
    if (!status)
        status = find_columns(results, &d, error);
    if (!status) {
        find_range(&d);
        status = draw(&d, results, error);
    }
    if (!status)
        status = d.ops->finish(d.canvas, path, error);
    free(d.column);
    return status;
}
