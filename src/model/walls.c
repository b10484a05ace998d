/* Wall rule `mirror`: after a step, a particle beyond a wall is put to its mirror image and loses
 * part of its velocity (TR323, section III; its program tests the high side first). One that has
 * crossed the box several times within a step is reflected as often. */
#include <math.h>
#include <stdint.h>
#include "model/contact.h"
#include "model/private.h"

/* Particles that are looked at in one go: as many as a word has bits. */
enum { BLOCK = 64 };

/* Bit k: particle first + k is beyond a wall. Few are, so that looking must be cheap. */
static uint64_t find_outside(const dl_model *model, const double *q, size_t first) {
    const dl_walls *walls = &model->scene->walls;
    const size_t left = model->moving - first, count = left < BLOCK ? left : BLOCK;
    uint64_t outside = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        if (isfinite(walls->low[c]) || isfinite(walls->high[c]))
            outside |= model->priv->vector->outside(q + c * model->moving + first, walls->low[c],
                                                    walls->high[c], count);
    return outside;
}

bool dl_model_outside(const dl_model *model, const double *q) {
    for (size_t first = 0; first < model->moving; first += BLOCK)
        if (find_outside(model, q, first))
            return true;
    return false;
}

/* |v_x| below the scene's limit becomes 0 after a hit. */
static void still(const dl_model *model, double *v, size_t k) {
    if (fabs(v[k]) < model->scene->walls.zero_vx_below)
        v[k] = 0;
}

/* Both components lose, the normal one turns round. */
void dl_wall_rebound(const dl_model *model, double *v, size_t k, size_t axis) {
    const dl_walls *walls = &model->scene->walls;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        v[c * model->moving + k] *= c == axis ? -(1 - walls->damping) : 1 - walls->damping;
    still(model, v, k);
}

/* Reflections until x is between the walls of a box: with period 2 (high - low) the images repeat.
 * Returns how many they are. */
static double fold(double *x, double low, double high) {
    const double width = high - low, along = *x < low ? high - *x : *x - low;
    const double hits = ceil(along / width) - 1;
    const double into = fmax(0, along - hits * width); /* the wall that was crossed last */
    const bool even = fmod(hits, 2) == 0;
    const double from_start = even ? into : width - into;
    *x = *x < low ? high - from_start : low + from_start;
    return hits;
}

/* A particle so fast that one mirror image lies beyond the opposite wall. */
static size_t mirror_often(const dl_model *model, double *q, double *v, size_t k, size_t axis) {
    const dl_walls *walls = &model->scene->walls;
    const size_t n = model->moving;
    const double hits = fold(&q[axis * n + k], walls->low[axis], walls->high[axis]);
    const double kept = pow(1 - walls->damping, hits);
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        v[c * n + k] *= c == axis && fmod(hits, 2) == 1 ? -kept : kept;
    still(model, v, k);
    return (size_t)fmin(hits, 1e9);
}

static size_t mirror_axis(const dl_model *model, double *q, double *v, size_t k, size_t axis) {
    const dl_walls *walls = &model->scene->walls;
    double *const x = &q[axis * model->moving + k];
    const double low = walls->low[axis], high = walls->high[axis];
    const double wall = *x > high ? high : *x < low ? low : NAN;
    if (isnan(wall))
        return 0;
    const double image = 2 * wall - *x;
    if ((image < low || image > high) && isfinite(image))
        return mirror_often(model, q, v, k, axis);
    *x = image;
    dl_wall_rebound(model, v, k, axis);
    return 1;
}

static size_t lowest_bit(uint64_t bits) {
    return (size_t)__builtin_ctzll(bits);
}

size_t dl_model_mirror(const dl_model *model, double *q, double *v) {
    size_t hits = 0;
    for (size_t first = 0; first < model->moving; first += BLOCK)
        for (uint64_t left = find_outside(model, q, first); left; left &= left - 1)
            for (size_t c = 0; c < (size_t)model->dimension; c++)
                hits += mirror_axis(model, q, v, first + lowest_bit(left), c);
    return hits;
}
