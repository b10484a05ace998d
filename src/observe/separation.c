/* Mean separation: distances to the nearest others, of those that lie near along one axis. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "observe/pairs.h"

/* Particles in the order of one coordinate. A particle's nearest are looked for in it to both
 * sides, each until the coordinate alone is farther than the farthest of those found: in a body of
 * n particles that is a layer of about n^(1/2) (n^(2/3) in three dimensions), not all of them. */
typedef struct line {
    size_t n;
    double period;      /* 0: none */
    double *coordinate; /* [n] by place, ascending; folded into the period */
    size_t *particle;   /* [n] by place */
    size_t *place;      /* [n] by particle */
} line;

typedef struct entry {
    double coordinate;
    size_t particle;
} entry;

static int ascending(const void *a, const void *b) {
    const entry *x = a, *y = b;
    if (x->coordinate != y->coordinate)
        return x->coordinate > y->coordinate ? 1 : -1;
    return (x->particle > y->particle) - (x->particle < y->particle);
}

/* Along which the particles reach farthest, so that the layers are thin. */
static size_t longest_axis(const dl_scene *scene, const double *y_all) {
    const size_t n = scene->particles;
    size_t longest = 0;
    double extent = -1;
    for (size_t c = 0; c < (size_t)scene->dimension; c++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < n; i++) {
            low = fmin(low, y_all[c * n + i]);
            high = fmax(high, y_all[c * n + i]);
        }
        const double length = scene->periods.length[c] > 0 ? scene->periods.length[c] : high - low;
        if (length > extent) {
            extent = length;
            longest = c;
        }
    }
    return longest;
}

static void line_free(line *along) {
    free(along->coordinate);
    free(along->particle);
}

static dl_status line_create(const dl_scene *scene, const double *y_all, line *along,
                             dl_error *error) {
    const size_t n = scene->particles, axis = longest_axis(scene, y_all);
    const double period = scene->periods.length[axis];
    entry *sorted = malloc((n + 1) * sizeof *sorted);
    *along = (line){.n = n, .period = period};
    along->coordinate = malloc((n + 1) * sizeof *along->coordinate);
    along->particle = calloc(2 * n + 1, sizeof *along->particle);
    if (!sorted || !along->coordinate || !along->particle) {
        free(sorted);
        line_free(along);
        return dl_fail_memory(error, "the nearest particles");
    }
    along->place = along->particle + n;
    for (size_t i = 0; i < n; i++) {
        const double x = y_all[axis * n + i];
        sorted[i] = (entry){period > 0 ? x - period * floor(x / period) : x, i};
    }
    qsort(sorted, n, sizeof *sorted, ascending);
    for (size_t k = 0; k < n; k++) {
        along->coordinate[k] = sorted[k].coordinate;
        along->particle[k] = sorted[k].particle;
        along->place[sorted[k].particle] = k;
    }
    free(sorted);
    return DL_OK;
}

/* The smallest squared distances so far, ascending. */
typedef struct smallest {
    double *square;
    size_t room, count;
} smallest;

static void keep(smallest *list, double square) {
    if (list->count == list->room && square >= list->square[list->room - 1])
        return;
    size_t k = list->count < list->room ? list->count++ : list->room - 1;
    for (; k > 0 && list->square[k - 1] > square; k--)
        list->square[k] = list->square[k - 1];
    list->square[k] = square;
}

/* Nothing so far along the line, nor farther, is among the smallest. Rounding of the folded
 * coordinate is on the safe side. */
static bool is_beyond(const smallest *list, double along) {
    const double near = along * (1 - 1e-12);
    return list->count == list->room && near * near > list->square[list->room - 1];
}

/* `step`: 1 or -1. With a period, up to half of it, once around. */
static void look(const dl_scene *scene, const double *y_all, const line *along, size_t i, int step,
                 smallest *list) {
    const double here = along->coordinate[along->place[i]], half = along->period / 2;
    size_t place = along->place[i];
    double turned = 0, d[3];
    for (size_t seen = 1; seen < along->n; seen++) {
        const bool end = step > 0 ? place + 1 == along->n : place == 0;
        if (end && !(along->period > 0))
            return;
        if (end)
            turned = along->period;
        if (step > 0)
            place = end ? 0 : place + 1;
        else
            place = end ? along->n - 1 : place - 1;
        const double away =
            turned + (step > 0 ? along->coordinate[place] - here : here - along->coordinate[place]);
        if (along->period > 0 && (step > 0 ? away > half : away >= half))
            return;
        if (is_beyond(list, away))
            return;
        keep(list, dl_observe_separation_of(scene, y_all, i, along->particle[place], d));
    }
}

static double mean_root(const smallest *list) {
    double sum = 0;
    for (size_t k = 0; k < list->count; k++)
        sum += sqrt(list->square[k]);
    return sum / (double)list->count;
}

static double mean_of_all(const dl_scene *scene, const double *y_all, const line *along,
                          smallest *list) {
    double sum = 0;
    size_t moving = 0;
    for (size_t i = 0; i < scene->particles; i++) {
        if (scene->pinned[i])
            continue;
        list->count = 0;
        look(scene, y_all, along, i, 1, list);
        look(scene, y_all, along, i, -1, list);
        sum += mean_root(list);
        moving++;
    }
    return moving > 0 ? sum / (double)moving : NAN;
}

dl_status dl_observe_separation(const dl_scene *scene, const double *y_all, size_t nearest,
                                double *mean, dl_error *error) {
    line along;
    *mean = NAN;
    if (nearest == 0 || scene->particles < 2)
        return DL_OK;
    smallest list = {.square = malloc(nearest * sizeof *list.square), .room = nearest};
    if (!list.square)
        return dl_fail_memory(error, "the nearest particles");
    const dl_status status = line_create(scene, y_all, &along, error);
    if (status == DL_OK) {
        *mean = mean_of_all(scene, y_all, &along, &list);
        line_free(&along);
    }
    free(list.square);
    return status;
}
