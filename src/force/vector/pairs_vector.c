/* Loops over pairs: distances to buffers, the law over the buffers, forces back by Newton's third
 * law. Rows of all pairs read their partners in a run; rows of a list gather the pairs within
 * reach first, for most of a list's pairs are usually not. */
#include "force/vector/vector.h"

/* Pairs gathered before the law is evaluated: the buffers stay in the first-level cache. */
enum { CHUNK = 256 };

typedef struct buffers {
    double *d[3]; /* separation r_i - r_j; for discrete loops d0 + d1 */
    double *s, *s1, *ds;
    double *f;
} buffers;

DL_INLINE buffers lay_out(double *memory, size_t length) {
    size_t stride = length + DL_VECTOR_PAD;
    return (buffers){{memory, memory + stride, memory + 2 * stride},
                     memory + 3 * stride,
                     memory + 4 * stride,
                     memory + 5 * stride,
                     memory + 6 * stride};
}

/* Lanes behind the last pair: distance 1, separation 0, so that they add nothing. */
DL_INLINE void close_buffers(buffers b, int dimension, bool discrete, size_t count) {
    store(b.s + count, splat(1));
    if (discrete) {
        store(b.s1 + count, splat(1));
        store(b.ds + count, splat(0));
    }
    for (int c = 0; c < dimension; c++)
        store(b.d[c] + count, splat(0));
}

DL_INLINE void row_distances(const dl_pair_arrays *p, buffers b, int dimension, bool discrete,
                             size_t i, size_t count) {
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector s = splat(0), s1 = splat(0), ds = splat(0);
        for (int c = 0; c < dimension; c++) {
            vector d = p->x[c][i] - load(p->x[c] + i + 1 + k);
            s += d * d;
            if (discrete) {
                vector change = p->delta[c][i] - load(p->delta[c] + i + 1 + k);
                vector end = d + change;
                s1 += end * end;
                d += end;
                ds += change * d;
            }
            store(b.d[c] + k, d);
        }
        store(b.s + k, s);
        if (discrete) {
            store(b.s1 + k, s1);
            store(b.ds + k, ds);
        }
    }
}

DL_INLINE void row_forces(const dl_pair_arrays *p, buffers b, int dimension, bool coupled, size_t i,
                          size_t count) {
    vector sum[3] = {splat(0), splat(0), splat(0)};
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector f = load(b.f + k);
        if (coupled)
            f *= p->coupling[i] * load(p->coupling + i + 1 + k);
        for (int c = 0; c < dimension; c++) {
            vector force = f * load(b.d[c] + k);
            sum[c] += force;
            double *partner = p->f[c] + i + 1 + k;
            store(partner, load(partner) - force);
        }
    }
    for (int c = 0; c < dimension; c++)
        p->f[c][i] += sum_lanes(sum[c]);
}

DL_INLINE void rows(const dl_pair_arrays *p, int dimension, bool discrete, bool coupled) {
    buffers b = lay_out(p->buffer, p->particles);
    for (size_t i = 0; i < p->moving; i++) {
        size_t count = p->particles - i - 1;
        if (count == 0)
            continue;
        row_distances(p, b, dimension, discrete, i, count);
        close_buffers(b, dimension, discrete, count);
        if (discrete)
            p->loops->discrete(p->law, b.s, b.s1, b.ds, b.f, padded(count));
        else
            p->loops->force(p->law, b.s, b.f, padded(count));
        row_forces(p, b, dimension, coupled, i, count);
    }
}

/* One compiled loop for each combination: what a scene lacks is not branched on. */
#define DL_FOR_EACH_FORM(call)                                                                     \
    do {                                                                                           \
        if (p->dimension == 2 && !p->coupling)                                                     \
            call(2, false);                                                                        \
        else if (p->dimension == 2)                                                                \
            call(2, true);                                                                         \
        else if (!p->coupling)                                                                     \
            call(3, false);                                                                        \
        else                                                                                       \
            call(3, true);                                                                         \
    } while (0)

void DL_VARIANT(dl_all_pairs)(const dl_pair_arrays *p) {
#define DL_CALL(dimension, coupled) rows(p, dimension, false, coupled)
    DL_FOR_EACH_FORM(DL_CALL);
#undef DL_CALL
}

void DL_VARIANT(dl_all_pairs_discrete)(const dl_pair_arrays *p) {
#define DL_CALL(dimension, coupled) rows(p, dimension, true, coupled)
    DL_FOR_EACH_FORM(DL_CALL);
#undef DL_CALL
}

typedef struct gathered {
    int i[CHUNK + 1], j[CHUNK + 1];
    size_t count;
} gathered;

/* Appends pair (i, j) where it is within reach, without a branch. */
DL_INLINE void gather(const dl_pair_arrays *p, buffers b, int dimension, bool discrete,
                      double reach2, int i, int j, gathered *pairs) {
    size_t n = pairs->count;
    double s = 0, s1 = 0, ds = 0;
    for (int c = 0; c < dimension; c++) {
        double d = p->x[c][i] - p->x[c][j];
        s += d * d;
        if (discrete) {
            double change = p->delta[c][i] - p->delta[c][j], end = d + change;
            s1 += end * end;
            d += end;
            ds += change * d;
        }
        b.d[c][n] = d;
    }
    b.s[n] = s;
    if (discrete) {
        b.s1[n] = s1;
        b.ds[n] = ds;
    }
    pairs->i[n] = i;
    pairs->j[n] = j;
    pairs->count = n + (discrete ? (s <= reach2) | (s1 <= reach2) : s <= reach2);
}

DL_INLINE void scatter(const dl_pair_arrays *p, buffers b, int dimension, bool discrete,
                       bool coupled, gathered *pairs) {
    close_buffers(b, dimension, discrete, pairs->count);
    if (discrete)
        p->loops->discrete(p->law, b.s, b.s1, b.ds, b.f, padded(pairs->count));
    else
        p->loops->force(p->law, b.s, b.f, padded(pairs->count));
    for (size_t n = 0; n < pairs->count; n++) {
        int i = pairs->i[n], j = pairs->j[n];
        double f = b.f[n];
        if (coupled)
            f *= p->coupling[i] * p->coupling[j];
        for (int c = 0; c < dimension; c++) {
            double force = f * b.d[c][n];
            p->f[c][i] += force;
            p->f[c][j] -= force;
        }
    }
    pairs->count = 0;
}

DL_INLINE void list_rows(const dl_pair_arrays *p, const dl_neighbours *list, int dimension,
                         bool discrete, bool coupled) {
    buffers b = lay_out(p->buffer, CHUNK);
    gathered pairs;
    pairs.count = 0;
    double reach2 = p->law->until2[p->law->pieces - 1];
    for (int i = 0; i < (int)p->moving; i++)
        for (int k = list->start[i]; k < list->start[i + 1]; k++) {
            gather(p, b, dimension, discrete, reach2, i, list->neighbour[k], &pairs);
            if (pairs.count == CHUNK)
                scatter(p, b, dimension, discrete, coupled, &pairs);
        }
    scatter(p, b, dimension, discrete, coupled, &pairs);
}

void DL_VARIANT(dl_list)(const dl_pair_arrays *p, const dl_neighbours *list) {
#define DL_CALL(dimension, coupled) list_rows(p, list, dimension, false, coupled)
    DL_FOR_EACH_FORM(DL_CALL);
#undef DL_CALL
}

void DL_VARIANT(dl_list_discrete)(const dl_pair_arrays *p, const dl_neighbours *list) {
#define DL_CALL(dimension, coupled) list_rows(p, list, dimension, true, coupled)
    DL_FOR_EACH_FORM(DL_CALL);
#undef DL_CALL
}
