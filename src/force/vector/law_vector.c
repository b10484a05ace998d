/* Loops over squared distances. With the powers known at compile time (law_shapes.def) a term is a
 * few multiplications; other whole powers loop; real powers call pow. */
#include "force/vector/vector.h"

typedef struct shape {
    int pieces;
    bool cut;
    int terms[2];
    int power[2][2];
} shape;

/* inverse^n with inverse = 1/r and inverse2 = 1/r^2; n known at compile time costs log2(n). */
DL_INLINE vector whole_power(vector inverse, vector inverse2, int n) {
    vector result = n & 1 ? inverse : splat(1);
    vector square = inverse2;
#pragma GCC unroll 6
    for (int m = n >> 1; m > 0; m >>= 1) {
        if (m & 1)
            result *= square;
        square *= square;
    }
    return result;
}

DL_INLINE vector piece_force(const dl_law *law, int piece, int terms, const int *power,
                             vector inverse, vector inverse2) {
    vector sum = splat(0);
#pragma GCC unroll 4
    for (int t = 0; t < terms; t++)
        sum += law->coefficient[piece][t] * whole_power(inverse, inverse2, power[t] + 1);
    return sum;
}

DL_INLINE void force_loop(const dl_law *law, shape form, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector s_k = load(s + k), inverse = inverse_sqrt(s_k), inverse2 = inverse * inverse;
        int last = form.pieces - 1;
        vector value =
            piece_force(law, last, form.terms[last], form.power[last], inverse, inverse2);
        if (form.cut)
            value = choose(s_k <= law->until2[last], value, splat(0));
        if (form.pieces == 2) {
            vector inner = piece_force(law, 0, form.terms[0], form.power[0], inverse, inverse2);
            value = choose(s_k <= law->until2[0], inner, value);
        }
        store(f + k, value);
    }
}

/* sum_{m<n} a^m b^(n-1-m), n known at compile time. */
DL_INLINE vector power_sum(vector a, vector b, int n) {
    vector sum = splat(1), b_power = splat(1);
#pragma GCC unroll 16
    for (int m = 1; m < n; m++) {
        b_power *= b;
        sum = a * sum + b_power;
    }
    return sum;
}

DL_INLINE vector piece_discrete(const dl_law *law, int piece, int terms, const int *power, vector a,
                                vector b) {
    vector sum = splat(0);
#pragma GCC unroll 4
    for (int t = 0; t < terms; t++) {
        int n = power[t] - 1;
        sum += law->coefficient[piece][t] / n * power_sum(a, b, n);
    }
    return sum;
}

/* Pairs that stay within a piece here; those that cross a breakpoint one by one after it. */
DL_INLINE void mend_crossings(const dl_law *law, const double *s0, const double *s1,
                              const double *ds, double *g, size_t count) {
    for (size_t k = 0; k < count; k++)
        if (dl_law_piece(law, s0[k]) != dl_law_piece(law, s1[k]))
            g[k] = dl_law_discrete(law, s0[k], s1[k], ds[k], NULL);
}

DL_INLINE void discrete_loop(const dl_law *law, shape form, const double *s0, const double *s1,
                             const double *ds, double *g, size_t count) {
    lane_mask crossing = {0};
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector from = load(s0 + k), to = load(s1 + k);
        vector a = inverse_sqrt(from), b = inverse_sqrt(to), ab = a * b;
        int last = form.pieces - 1;
        vector value = piece_discrete(law, last, form.terms[last], form.power[last], a, b);
        if (form.cut) {
            lane_mask out0 = from > law->until2[last], out1 = to > law->until2[last];
            crossing |= out0 ^ out1;
            value = choose(out0, splat(0), value);
        }
        if (form.pieces == 2) {
            lane_mask in0 = from <= law->until2[0], in1 = to <= law->until2[0];
            crossing |= in0 ^ in1;
            vector inner = piece_discrete(law, 0, form.terms[0], form.power[0], a, b);
            value = choose(in0, inner, value);
        }
        /* a b/(r0 + r1) = (a b)^2/(a + b) */
        store(g + k, value * ab * ab / (a + b));
    }
    if (any_lane(crossing))
        mend_crossings(law, s0, s1, ds, g, count);
}

#define DL_SHAPE(name, ...)                                                                        \
    static void name##_force(const dl_law *law, const double *s, double *f, size_t count) {        \
        force_loop(law, (shape)__VA_ARGS__, s, f, count);                                          \
    }                                                                                              \
    static void name##_discrete(const dl_law *law, const double *s0, const double *s1,             \
                                const double *ds, double *g, size_t count) {                       \
        discrete_loop(law, (shape)__VA_ARGS__, s0, s1, ds, g, count);                              \
    }
#include "force/vector/law_shapes.def"
#undef DL_SHAPE

static void whole_force(const dl_law *law, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector s_k = load(s + k), inverse = inverse_sqrt(s_k), inverse2 = inverse * inverse;
        vector value = splat(0);
        for (int piece = law->pieces - 1; piece >= 0; piece--) {
            vector here = piece_force(law, piece, law->terms[piece], law->whole_power[piece],
                                      inverse, inverse2);
            value = choose(s_k <= law->until2[piece], here, value);
        }
        store(f + k, value);
    }
}

static void real_force(const dl_law *law, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k++)
        f[k] = dl_law_force_over_r(law, s[k]);
}

static void any_discrete(const dl_law *law, const double *s0, const double *s1, const double *ds,
                         double *g, size_t count) {
    for (size_t k = 0; k < count; k++)
        g[k] = dl_law_discrete(law, s0[k], s1[k], ds[k], NULL);
}

static const struct {
    shape form;
    dl_law_loops loops;
} specialised[] = {
#define DL_SHAPE(name, ...) {__VA_ARGS__, {#name, name##_force, name##_discrete}},
#include "force/vector/law_shapes.def"
#undef DL_SHAPE
};

static bool fits(const dl_law *law, const shape *form) {
    if (!law->integer || law->pieces != form->pieces || law->cut != form->cut)
        return false;
    for (int k = 0; k < form->pieces; k++) {
        if (law->terms[k] != form->terms[k])
            return false;
        for (int t = 0; t < form->terms[k]; t++)
            if (law->whole_power[k][t] != form->power[k][t])
                return false;
    }
    return true;
}

const dl_law_loops *DL_VARIANT(dl_loops_for)(const dl_law *law) {
    static const dl_law_loops whole = {"whole powers", whole_force, any_discrete};
    static const dl_law_loops real = {"real powers", real_force, any_discrete};
    for (size_t k = 0; k < sizeof specialised / sizeof *specialised; k++)
        if (fits(law, &specialised[k].form))
            return &specialised[k].loops;
    return law->integer ? &whole : &real;
}
