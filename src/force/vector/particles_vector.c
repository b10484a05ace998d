/* Loops over particles: the neighbour list's displacement test and the end of the force. */
#include "force/vector/vector.h"

bool DL_VARIANT(dl_moved)(const double *const *x, const double *const *origin, int dimension,
                          size_t count, double limit) {
    double limit2 = limit * limit;
    lane_mask moved = {0};
    size_t k = 0;
    for (; k + DL_LANES <= count; k += DL_LANES) {
        vector s = splat(0);
        for (int c = 0; c < dimension; c++) {
            vector d = load(x[c] + k) - load(origin[c] + k);
            s += d * d;
        }
        moved |= ~(s <= limit2); /* true for NaN, too */
    }
    bool tail = false;
    for (; k < count; k++) {
        double s = 0;
        for (int c = 0; c < dimension; c++)
            s += (x[c][k] - origin[c][k]) * (x[c][k] - origin[c][k]);
        tail |= !(s <= limit2);
    }
    return tail || any_lane(moved);
}

DL_INLINE bool finish(const double *f, const double *scale, double g, const double *mask, double *a,
                      size_t count) {
    vector check = splat(0); /* a times 0 is NaN where a is not finite */
    size_t k = 0;
    for (; k + DL_LANES <= count; k += DL_LANES) {
        vector value = load(f + k);
        if (scale)
            value *= load(scale + k);
        value += mask ? g * load(mask + k) : splat(g);
        check += value * 0.0;
        store(a + k, value);
    }
    double tail = sum_lanes(check);
    for (; k < count; k++) {
        a[k] = (scale ? f[k] * scale[k] : f[k]) + (mask ? g * mask[k] : g);
        tail += a[k] * 0.0;
    }
    return tail == 0;
}

bool DL_VARIANT(dl_finish)(const double *f, const double *scale, double g, const double *mask,
                           double *a, size_t count) {
    if (scale && mask)
        return finish(f, scale, g, mask, a, count);
    if (scale)
        return finish(f, scale, g, NULL, a, count);
    if (mask)
        return finish(f, NULL, g, mask, a, count);
    return finish(f, NULL, g, NULL, a, count);
}

uint64_t DL_VARIANT(dl_outside)(const double *x, double low, double high, size_t count) {
    uint64_t outside = 0;
    size_t k = 0;
    for (; k + DL_LANES <= count; k += DL_LANES) {
        vector place = load(x + k);
        outside |= bits_of((place < low) | (place > high)) << k;
    }
    for (; k < count; k++)
        outside |= (uint64_t)((x[k] < low) | (x[k] > high)) << k;
    return outside;
}

void DL_VARIANT(dl_inverse_sqrt)(const double *s, double *root, size_t count) {
    for (size_t k = 0; k < count; k++)
        root[k] = inverse_sqrt(splat(s[k]))[0];
}

const dl_vector_ops DL_VARIANT(dl_vector_ops) = {
#define DL_TEXT2(name) #name
#define DL_TEXT(name)  DL_TEXT2(name)
    .name = DL_TEXT(DL_ISA),
    .loops_for = DL_VARIANT(dl_loops_for),
    .block = DL_VARIANT(dl_block),
    .block_discrete = DL_VARIANT(dl_block_discrete),
    .list = DL_VARIANT(dl_list),
    .list_discrete = DL_VARIANT(dl_list_discrete),
    .moved = DL_VARIANT(dl_moved),
    .finish = DL_VARIANT(dl_finish),
    .expansions = &DL_VARIANT(dl_expansion_ops),
    .outside = DL_VARIANT(dl_outside),
    .inverse_sqrt = DL_VARIANT(dl_inverse_sqrt),
};
