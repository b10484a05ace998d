/* A vector of doubles as wide as the instruction set has it (GNU vector extension). */
#ifndef DL_FORCE_VECTOR_VECTOR_H
#define DL_FORCE_VECTOR_VECTOR_H

#include <math.h>
#include <stdint.h>
#include <string.h>
#include "force/vector_ops.h"

#if defined(DL_ISA_avx512)
#include <immintrin.h>
#define DL_LANES 8
#elif defined(DL_ISA_avx2)
#include <immintrin.h>
#define DL_LANES 4
#else
#define DL_LANES 2
#endif

typedef double vector __attribute__((vector_size(8 * DL_LANES)));
typedef int64_t lane_mask __attribute__((vector_size(8 * DL_LANES)));

/* Every name of this folder is compiled once an instruction set. */
#define DL_PASTE2(a, b)  a##_##b
#define DL_PASTE(a, b)   DL_PASTE2(a, b)
#define DL_VARIANT(name) DL_PASTE(name, DL_ISA)

#define DL_INLINE static inline __attribute__((always_inline, unused))

DL_INLINE vector load(const double *from) {
    vector v;
    memcpy(&v, from, sizeof v);
    return v;
}

DL_INLINE void store(double *to, vector v) {
    memcpy(to, &v, sizeof v);
}

DL_INLINE vector splat(double value) {
    return value - (vector){0};
}

DL_INLINE vector choose(lane_mask mask, vector yes, vector no) {
    return (vector)((mask & (lane_mask)yes) | (~mask & (lane_mask)no));
}

DL_INLINE double sum_lanes(vector v) {
#if defined(DL_ISA_avx512)
    return _mm512_reduce_add_pd((__m512d)v);
#else
    double sum = 0;
    for (int k = 0; k < DL_LANES; k++)
        sum += v[k];
    return sum;
#endif
}

DL_INLINE bool any_lane(lane_mask mask) {
    int64_t any = 0;
    for (int k = 0; k < DL_LANES; k++)
        any |= mask[k];
    return any != 0;
}

/* Bit k: lane k. */
DL_INLINE uint64_t bits_of(lane_mask mask) {
#if defined(DL_ISA_avx512)
    return _mm512_movepi64_mask((__m512i)mask);
#elif defined(DL_ISA_avx2)
    return (uint64_t)_mm256_movemask_pd((__m256d)mask);
#else
    uint64_t bits = 0;
    for (int k = 0; k < DL_LANES; k++)
        bits |= (uint64_t)(mask[k] & 1) << k;
    return bits;
#endif
}

#if !defined(DL_ISA_avx512)
DL_INLINE vector root(vector s) {
#if defined(DL_ISA_avx2)
    return (vector)_mm256_sqrt_pd((__m256d)s);
#else
    vector of;
    for (int k = 0; k < DL_LANES; k++)
        of[k] = sqrt(s[k]);
    return of;
#endif
}
#endif

/* 1/sqrt(s) to full double accuracy. AVX-512 has an estimate y with 14 bits, and with e = 1 - s y^2
 *
 *     1/sqrt(s) = y (1 - e)^(-1/2) = y (1 + e/2 + 3/8 e^2 + 5/16 e^3 + ...),
 *
 * of which the next term is below 2^-53: far cheaper than a square root and a division. */
DL_INLINE vector inverse_sqrt(vector s) {
#if defined(DL_ISA_avx512)
    vector y = (vector)_mm512_rsqrt14_pd((__m512d)s), e = 1.0 - s * y * y;
    return y + y * e * (0.5 + e * (0.375 + e * 0.3125));
#else
    return 1.0 / root(s);
#endif
}

/* A step's ends, from their squared distances: 1/r0, 1/r1 and 1/(r0 + r1). */
typedef struct inverse_ends {
    vector a, b, of_sum;
} inverse_ends;

/* Divisions are what costs: AVX-512 has estimates for all three inverses, elsewhere one division
 * serves them. */
DL_INLINE inverse_ends inverses_of(vector s0, vector s1) {
#if defined(DL_ISA_avx512)
    vector a = inverse_sqrt(s0), b = inverse_sqrt(s1), sum = a + b;
    vector y = (vector)_mm512_rcp14_pd((__m512d)sum);
    y += y * (1.0 - sum * y); /* 28 bits, */
    y += y * (1.0 - sum * y); /* all */
    return (inverse_ends){a, b, a * b * y};
#else
    vector r0 = root(s0), r1 = root(s1), sum = r0 + r1, product = r0 * r1;
    vector all = 1.0 / (product * sum), of_product = sum * all;
    return (inverse_ends){r1 * of_product, r0 * of_product, product * all};
#endif
}

/* Whole vectors that hold `count` doubles. */
DL_INLINE size_t padded(size_t count) {
    return (count + DL_LANES - 1) / DL_LANES * DL_LANES;
}

/* Parts of the family for one instruction set. */
const dl_law_loops *DL_VARIANT(dl_loops_for)(const dl_law *law);
void DL_VARIANT(dl_block)(const dl_pair_arrays *arrays, const dl_pair_block *block);
void DL_VARIANT(dl_block_discrete)(const dl_pair_arrays *arrays, const dl_pair_block *block);
void DL_VARIANT(dl_list)(const dl_pair_arrays *arrays, const dl_neighbours *neighbours);
void DL_VARIANT(dl_list_discrete)(const dl_pair_arrays *arrays, const dl_neighbours *neighbours);
bool DL_VARIANT(dl_moved)(const double *const *x, const double *const *origin, int dimension,
                          size_t count, double limit);
bool DL_VARIANT(dl_finish)(const double *f, const double *scale, double g, const double *mask,
                           double *a, size_t count);
extern const struct dl_expansion_ops DL_VARIANT(dl_expansion_ops);
uint64_t DL_VARIANT(dl_outside)(const double *x, double low, double high, size_t count);
void DL_VARIANT(dl_inverse_sqrt)(const double *s, double *root, size_t count);
extern const dl_vector_ops DL_VARIANT(dl_vector_ops);

#endif
