/* Loops over squared distances. With the powers known at compile time (law_shapes.def) a term is a
 * few multiplications; other whole powers loop; real powers call pow. */
#include "force/law_taper.h"
#include "force/vector/law_shape.h"

DL_INLINE void force_loop(const dl_law *law, shape form, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES)
        store(f + k, shape_force(law, form, load(s + k)));
}

/* S_n = sum_{m<n} a^m b^(n-1-m) by the bits of n, the highest first:
 * S_2m = S_m (a^m + b^m), S_m+1 = a S_m + b^m. */
DL_INLINE vector power_sum(vector a, vector b, int n) {
    vector sum = splat(1), a_m = a, b_m = b;
#pragma GCC unroll 5
    for (int bit = 1 << (31 - __builtin_clz((unsigned)n)) >> 1; bit > 0; bit >>= 1) {
        sum *= a_m + b_m;
        a_m *= a_m;
        b_m *= b_m;
        if (n & bit) {
            sum = a * sum + b_m;
            a_m *= a;
            b_m *= b;
        }
    }
    return sum;
}

/* Coefficients over their n, [piece][term]: read once, for the loop writes to memory that could be
 * the law's. */
typedef struct discrete_factors {
    double of[2][2];
} discrete_factors;

DL_INLINE discrete_factors factors_of(const dl_law *law, shape form) {
    discrete_factors factors = {{{0}}};
    for (int piece = 0; piece < form.pieces; piece++)
        for (int t = 0; t < form.terms[piece]; t++)
            factors.of[piece][t] = law->coefficient[piece][t] / (form.power[piece][t] - 1);
    return factors;
}

DL_INLINE vector piece_discrete(const double *factor, int terms, const int *power, vector a,
                                vector b) {
    vector sum = splat(0);
#pragma GCC unroll 4
    for (int t = 0; t < terms; t++)
        sum += factor[t] * power_sum(a, b, power[t] - 1);
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
    const discrete_factors factors = factors_of(law, form);
    const double edge0 = law->until2[0], edge = law->until2[form.pieces - 1];
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector from = load(s0 + k), to = load(s1 + k);
        inverse_ends ends = inverses_of(from, to);
        vector a = ends.a, b = ends.b;
        int last = form.pieces - 1;
        vector value = piece_discrete(factors.of[last], form.terms[last], form.power[last], a, b);
        if (form.cut) {
            lane_mask out0 = from > edge, out1 = to > edge;
            crossing |= out0 ^ out1;
            value = choose(out0, splat(0), value);
        }
        if (form.pieces == 2) {
            lane_mask in0 = from <= edge0, in1 = to <= edge0;
            crossing |= in0 ^ in1;
            vector inner = piece_discrete(factors.of[0], form.terms[0], form.power[0], a, b);
            value = choose(in0, inner, value);
        }
        store(g + k, value * (a * b * ends.of_sum));
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

/* --- any whole powers ------------------------------------------------------------------------- */

/* sum c r^(-p - more) over the terms from `begin` to before `end`. */
DL_INLINE vector sum_of(const dl_law *law, int piece, int begin, int end, int more, vector inverse,
                        vector inverse2) {
    vector sum = splat(0);
    for (int t = begin; t < end; t++)
        sum += law->coefficient[piece][t] *
               whole_power(inverse, inverse2, law->whole_power[piece][t] + more);
    return sum;
}

/* A taper's force times r^-more, law_taper.h. */
DL_INLINE vector blend(const dl_law *law, int piece, vector r, vector inverse, int more) {
    vector v = (law->until[piece] - r) * (1 / law->width[piece]);
    v = choose(v < 0, splat(0), v);
    v = choose(v > 1, splat(1), v);
    vector s = v * v * v * (10 + v * (6 * v - 15)), inverse2 = inverse * inverse;
    int own = law->terms[piece], all = own + law->next_terms[piece];
    vector force = s * sum_of(law, piece, 0, own, more, inverse, inverse2);
    if (all > own)
        force += (1 - s) * sum_of(law, piece, own, all, more, inverse, inverse2);
    return force;
}

static void whole_force(const dl_law *law, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector s_k = load(s + k), inverse = inverse_sqrt(s_k), inverse2 = inverse * inverse;
        vector value = splat(0);
        for (int piece = law->pieces - 1; piece >= 0; piece--) {
            vector here = law->width[piece] > 0
                              ? blend(law, piece, s_k * inverse, inverse, 1)
                              : sum_of(law, piece, 0, law->terms[piece], 1, inverse, inverse2);
            value = choose(s_k <= law->until2[piece], here, value);
        }
        store(f + k, value);
    }
}

/* G r0 r1 r0 r1/(r0 + r1) of a sum, as in discrete_loop; power 0 has the force's mean, c. */
DL_INLINE vector sum_discrete(const dl_law *law, int piece, vector a, vector b) {
    vector sum = splat(0), r0_r1 = 1 / (a * b);
    for (int t = 0; t < law->terms[piece]; t++) {
        int n = law->whole_power[piece][t] - 1;
        if (n < 0)
            sum += law->coefficient[piece][t] * r0_r1;
        else
            sum += law->coefficient[piece][t] / n * power_sum(a, b, n);
    }
    return sum;
}

/* The same of a taper whose path is within a panel. */
DL_INLINE vector blend_discrete(const dl_law *law, int piece, vector a, vector b, vector length) {
    vector r0_r1 = 1 / (a * b), centre = (a + b) * r0_r1 / 2, half = length / 2, mean = splat(0);
    for (int n = 0; n < dl_gauss_points / 2; n++) {
        vector above = centre + half * dl_gauss_zero[n], below = centre - half * dl_gauss_zero[n];
        mean += dl_gauss_weight[n] *
                (blend(law, piece, above, 1 / above, 0) + blend(law, piece, below, 1 / below, 0));
    }
    return mean * r0_r1;
}

/* One vector of pairs. *alone: lanes that cross a breakpoint or, in a taper, more than a panel. */
DL_INLINE vector whole_discrete_of(const dl_law *law, vector from, vector to, vector ds,
                                   lane_mask *alone) {
    inverse_ends ends = inverses_of(from, to);
    vector a = ends.a, b = ends.b, value = splat(0);
    lane_mask done = {0};
    for (int piece = 0; piece < law->pieces; piece++) {
        lane_mask in0 = from <= law->until2[piece], in1 = to <= law->until2[piece];
        lane_mask within = in0 & ~done;
        done = in0;
        *alone |= in0 ^ in1;
        if (!any_lane(within))
            continue;
        vector here;
        if (law->width[piece] > 0) {
            double panel = law->panel[piece];
            *alone |= within & ((a > panel * b) | (b > panel * a));
            here = blend_discrete(law, piece, a, b, ds * ends.of_sum);
        } else {
            here = sum_discrete(law, piece, a, b);
        }
        value = choose(within, here, value);
    }
    return value * (a * b * ends.of_sum);
}

static void whole_discrete(const dl_law *law, const double *s0, const double *s1, const double *ds,
                           double *g, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES) {
        lane_mask alone = {0};
        store(g + k, whole_discrete_of(law, load(s0 + k), load(s1 + k), load(ds + k), &alone));
        if (any_lane(alone))
            for (size_t lane = k; lane < k + DL_LANES; lane++)
                if (alone[lane - k])
                    g[lane] = dl_law_discrete(law, s0[lane], s1[lane], ds[lane], NULL);
    }
}

/* --- real powers ------------------------------------------------------------------------------ */

static void real_force_one_by_one(const dl_law *law, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k++)
        f[k] = dl_law_force_over_r(law, s[k]);
}

#ifdef DL_HAVE_VECTOR_POW
/* The C library's, of at most 4 units in the last place. */
#if defined(DL_ISA_avx512)
#define DL_VECTOR_POW _ZGVeN8vv_pow
#elif defined(DL_ISA_avx2)
#define DL_VECTOR_POW _ZGVdN4vv_pow
#else
#define DL_VECTOR_POW _ZGVbN2vv_pow
#endif
vector DL_VECTOR_POW(vector base, vector power);

/* Lanes of a taper are done one by one: its force is a blend. */
DL_INLINE lane_mask real_force_of(const dl_law *law, vector s, vector *value) {
    lane_mask done = {0}, tapered = {0};
    *value = splat(0);
    for (int piece = 0; piece < law->pieces; piece++) {
        lane_mask in = s <= law->until2[piece], within = in & ~done;
        done = in;
        if (!any_lane(within))
            continue;
        vector sum = splat(0);
        for (int t = 0; t < law->terms[piece]; t++)
            sum += law->coefficient[piece][t] *
                   DL_VECTOR_POW(s, splat(-(law->power[piece][t] + 1) / 2));
        *value = choose(within, sum, *value);
        if (law->width[piece] > 0)
            tapered |= within;
    }
    return tapered;
}

static void real_force(const dl_law *law, const double *s, double *f, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector value;
        lane_mask tapered = real_force_of(law, load(s + k), &value);
        store(f + k, value);
        if (any_lane(tapered))
            real_force_one_by_one(law, s + k, f + k, DL_LANES);
    }
}
#else
#define real_force real_force_one_by_one
#endif

static void real_discrete(const dl_law *law, const double *s0, const double *s1, const double *ds,
                          double *g, size_t count) {
    for (size_t k = 0; k < count; k++)
        g[k] = dl_law_discrete(law, s0[k], s1[k], ds[k], NULL);
}

static const struct {
    shape form;
    dl_law_loops loops;
} specialised[] = {
#define DL_SHAPE(name, ...)                                                                        \
    {__VA_ARGS__, {#name, name##_force, name##_discrete, DL_VARIANT(dl_block_##name)}},
#include "force/vector/law_shapes.def"
#undef DL_SHAPE
};

static bool fits(const dl_law *law, const shape *form) {
    if (!law->integer || law->pieces != form->pieces || law->cut != form->cut)
        return false;
    for (int k = 0; k < form->pieces; k++) {
        if (law->width[k] > 0 || law->terms[k] != form->terms[k])
            return false;
        for (int t = 0; t < form->terms[k]; t++)
            if (law->whole_power[k][t] != form->power[k][t])
                return false;
    }
    return true;
}

const dl_law_loops *DL_VARIANT(dl_loops_for)(const dl_law *law) {
    static const dl_law_loops whole = {"whole powers", whole_force, whole_discrete, NULL};
    static const dl_law_loops real = {"real powers", real_force, real_discrete, NULL};
    for (size_t k = 0; k < sizeof specialised / sizeof *specialised; k++)
        if (fits(law, &specialised[k].form))
            return &specialised[k].loops;
    return law->integer ? &whole : &real;
}
