/* F(r)/r of laws whose powers are known at compile time (law_shapes.def). */
#ifndef DL_FORCE_VECTOR_LAW_SHAPE_H
#define DL_FORCE_VECTOR_LAW_SHAPE_H

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

DL_INLINE vector shape_force(const dl_law *law, shape form, vector s) {
    vector inverse = inverse_sqrt(s), inverse2 = inverse * inverse;
    int last = form.pieces - 1;
    vector value = piece_force(law, last, form.terms[last], form.power[last], inverse, inverse2);
    if (form.cut)
        value = choose(s <= law->until2[last], value, splat(0));
    if (form.pieces == 2) {
        vector inner = piece_force(law, 0, form.terms[0], form.power[0], inverse, inverse2);
        value = choose(s <= law->until2[0], inner, value);
    }
    return value;
}

/* blocks_vector.c: the force over blocks, a law. */
#define DL_SHAPE(name, ...) extern dl_block_loop *const DL_VARIANT(dl_block_##name)[dl_loop_forms];
#include "force/vector/law_shapes.def"
#undef DL_SHAPE

#endif
