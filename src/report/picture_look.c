#include "report/picture_look.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>

static const double widest = 2.5; /* ratio of the largest to the smallest radius */
static const size_t few = 8;      /* masses that shades can tell apart */

/* --- masses ----------------------------------------------------------------------------------- */

static int ascending(const void *a, const void *b) {
    const double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

dl_status dl_masses_create(const dl_scene *scene, dl_masses *masses, dl_error *error) {
    const size_t n = scene->particles;
    *masses = (dl_masses){0};
    masses->mass = calloc(n, sizeof *masses->mass);
    masses->number = calloc(n, sizeof *masses->number);
    if (!masses->mass || !masses->number) {
        dl_masses_free(masses);
        return dl_fail_memory(error, "the masses of a scene");
    }
    for (size_t i = 0; i < n; i++)
        masses->mass[i] = scene->inertia[i];
    qsort(masses->mass, n, sizeof *masses->mass, ascending);
    for (size_t i = 0; i < n; i++) {
        if (masses->count == 0 || masses->mass[i] > masses->mass[masses->count - 1])
            masses->mass[masses->count++] = masses->mass[i];
        masses->number[masses->count - 1]++;
    }
    return DL_OK;
}

void dl_masses_free(dl_masses *masses) {
    free(masses->mass);
    free(masses->number);
    *masses = (dl_masses){0};
}

double dl_size_of(const dl_masses *masses, double mass) {
    const double heaviest = masses->mass[masses->count - 1], range = heaviest / masses->mass[0];
    if (masses->count == 1)
        return 1;
    return pow(mass / heaviest, fmin(0.5, log(widest) / log(range)));
}

static size_t rank_of(const dl_masses *masses, double mass) {
    size_t rank = 0;
    while (rank + 1 < masses->count && masses->mass[rank] < mass)
        rank++;
    return rank;
}

int dl_shade_of(const dl_masses *masses, double mass) {
    static const double white = 255, dark = 84, pale = 226;
    const size_t last = masses->count - 1;
    if (last == 0)
        return (int)pale * 0x10101;
    const double part = masses->count <= few ? (double)rank_of(masses, mass) / (double)last
                                             : log(mass / masses->mass[0]) /
                                                   log(masses->mass[last] / masses->mass[0]);
    return (int)lround(white + part * (dark - white)) * 0x10101;
}

/* --- sizes ------------------------------------------------------------------------------------ */

/* Of the nearest copies, where the axis is periodic. */
static double separation(const dl_scene *scene, const double *y_all, int axis, size_t i, size_t j) {
    const double *const x = y_all + (size_t)axis * scene->particles;
    const double apart = x[j] - x[i], length = scene->periods.length[axis];
    return length > 0 ? apart - length * round(apart / length) : apart;
}

/* Smallest distance to another particle, in units of the sum of their sizes. */
static double nearest(const dl_scene *scene, const double *y_all, int across, int up,
                      const double *sizes, size_t i) {
    double best = INFINITY;
    for (size_t j = 0; j < scene->particles; j++) {
        if (j == i)
            continue;
        const double dx = separation(scene, y_all, across, i, j);
        const double dy = separation(scene, y_all, up, i, j), size = sizes[i] + sizes[j];
        best = fmin(best, (dx * dx + dy * dy) / (size * size));
    }
    return sqrt(best);
}

double dl_natural_radius(const dl_scene *scene, const double *y_all, int across, int up,
                         const double *sizes) {
    static const double tenth = 0.1, gap = 0.95;
    static const size_t most = 500; /* particles looked at */
    const size_t n = scene->particles, stride = (n + most - 1) / most;
    double *const distance = n > 1 ? malloc(n * sizeof *distance) : NULL;
    size_t count = 0;
    if (!distance)
        return 0;
    for (size_t i = 0; i < n; i += stride)
        distance[count++] = nearest(scene, y_all, across, up, sizes, i);
    qsort(distance, count, sizeof *distance, ascending);
    const double radius = gap * distance[(size_t)(tenth * (double)count)];
    free(distance);
    return radius;
}

/* --- colours ---------------------------------------------------------------------------------- */

dl_speed_range dl_speed_range_of(double *speed, size_t count) {
    qsort(speed, count, sizeof *speed, ascending);
    const double least = speed[0], most = speed[count - 1], usual = speed[(count - 1) * 98 / 100];
    dl_speed_range range = {.high = most, .has_faster = usual > 0 && most > 2 * usual};
    if (range.has_faster)
        range.high = usual;
    if (least > range.high / 2 && least < range.high)
        range.low = least;
    return range;
}

double dl_speed_part(const dl_speed_range *range, double speed) {
    return range->high > range->low ? (speed - range->low) / (range->high - range->low) : 0;
}

/* Viridis (S. van der Walt and N. Smith, public domain) at ninths, turned around: what is slow is
 * pale, as on paper. */
int dl_colour_of(double part) {
    static const int colour[] = {0xfde725, 0xaddc30, 0x5ec962, 0x28ae80, 0x21918c,
                                 0x2c728e, 0x3b528b, 0x472d7b, 0x440154};
    static const int last = sizeof colour / sizeof *colour - 1;
    const double at = fmin(fmax(part, 0), 1) * last;
    const int k = at < last ? (int)at : last - 1;
    int mixed = 0;
    for (int shift = 16; shift >= 0; shift -= 8) {
        const double from = colour[k] >> shift & 255, to = colour[k + 1] >> shift & 255;
        mixed |= (int)lround(from + (at - k) * (to - from)) << shift;
    }
    return mixed;
}

/* Okabe and Ito's blue and vermilion. */
const dl_state_look dl_state_looks[3] = {
    [DL_SOLID] = {"solid", 0xcfe3f1, 0x0072b2, 6, 0.25, 1.35},
    [DL_LIQUID] = {"liquid", 0xffffff, 0x333333, 0, 0, 1},
    [DL_GAS] = {"gas", 0xfbdcc6, 0xd55e00, 3, 0.25, 2.1},
};
