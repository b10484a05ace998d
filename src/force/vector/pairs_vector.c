/* Loops over pairs: distances to buffers, the law over the buffers, forces back by Newton's third
 * law. Blocks of all pairs read the partners of a particle in a run; rows of a list gather the
 * pairs within reach first, for most of a list's pairs are usually not.
 *
 * In a periodic box separations are those of the nearest copies (force/box.h). A pair's discrete
 * force has a part for each copy that is within reach at the start or at the end of the step: the
 * copy nearest at the start, and, where that is another one, the copy nearest at the end. */
#include "force/vector/loop_form.h"

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
DL_INLINE void close_buffers(buffers b, loop_form form, size_t count) {
    store(b.s + count, splat(1));
    if (form.discrete) {
        store(b.s1 + count, splat(1));
        store(b.ds + count, splat(0));
    }
    for (int c = 0; c < form.dimension; c++)
        store(b.d[c] + count, splat(0));
}

DL_INLINE void evaluate(const dl_pair_arrays *p, buffers b, loop_form form, size_t count) {
    close_buffers(b, form, count);
    if (form.discrete)
        p->loops->discrete(p->law, b.s, b.s1, b.ds, b.f, padded(count));
    else
        p->loops->force(p->law, b.s, b.f, padded(count));
}

/* --- gathered pairs --------------------------------------------------------------------------- */

typedef struct gathered {
    int i[CHUNK + 8], j[CHUNK + 8];
    size_t count;
} gathered;

/* Appends pair (i, j) where it is within reach, without a branch. `at_end`: the copy nearest at
 * the end of the step, where that is another one than at the start. Returns whether it is. */
DL_INLINE bool gather(const inputs *in, buffers b, loop_form form, bool at_end, double reach2,
                      int i, int j, gathered *pairs) {
    size_t n = pairs->count;
    double s = 0, s1 = 0, ds = 0;
    bool changes = false;
    for (int c = 0; c < form.dimension; c++) {
        double d = in->x[c][i] - in->x[c][j];
        if (form.periodic)
            d -= shift_of(&in->box, c, d);
        if (form.discrete) {
            double change = in->delta[c][i] - in->delta[c][j];
            if (form.periodic) {
                double shift = shift_of(&in->box, c, d + change);
                changes |= shift != 0;
                if (at_end)
                    d -= shift;
            }
            double end = d + change;
            s += d * d;
            s1 += end * end;
            d += end;
            ds += change * d;
        } else {
            s += d * d;
        }
        b.d[c][n] = d;
    }
    b.s[n] = s;
    if (form.discrete) {
        b.s1[n] = s1;
        b.ds[n] = ds;
    }
    pairs->i[n] = i;
    pairs->j[n] = j;
    bool within = form.discrete ? (s <= reach2) | (s1 <= reach2) : s <= reach2;
    pairs->count = n + (at_end ? within & changes : within);
    return changes;
}

/* Forces of the gathered pairs, on both particles or on the first alone. */
DL_INLINE void scatter(const dl_pair_arrays *p, buffers b, loop_form form, bool both,
                       gathered *pairs) {
    evaluate(p, b, form, pairs->count);
    for (size_t n = 0; n < pairs->count; n++) {
        int i = pairs->i[n], j = pairs->j[n];
        double f = b.f[n];
        if (form.coupled)
            f *= p->coupling[i] * p->coupling[j];
        for (int c = 0; c < form.dimension; c++) {
            double force = f * b.d[c][n];
            p->f[c][i] += force;
            if (both)
                p->f[c][j] -= force;
        }
    }
    pairs->count = 0;
}

DL_INLINE double square_of_reach(const dl_law *law) {
    return law->until2[law->pieces - 1];
}

#if defined(DL_ISA_avx512)
DL_INLINE vector at(const double *x, __m256i index) {
    return (vector)_mm512_i32gather_pd(index, x, 8);
}

DL_INLINE void keep(double *to, __mmask8 mask, vector v) {
    _mm512_storeu_pd(to, _mm512_maskz_compress_pd(mask, (__m512d)v));
}

DL_INLINE void keep_index(int *to, __mmask8 mask, __m256i index) {
    _mm256_storeu_si256((__m256i *)to, _mm256_maskz_compress_epi32(mask, index));
}

/* As gather, for a vector of pairs and of forces alone. */
DL_INLINE void gather_lanes(const inputs *in, buffers b, loop_form form, double reach2,
                            const int *row, const int *neighbour, int count, gathered *pairs) {
    __mmask8 there = (__mmask8)(count < 8 ? (1U << count) - 1 : 0xffU);
    __m256i i = _mm256_maskz_loadu_epi32(there, row);
    __m256i j = _mm256_maskz_loadu_epi32(there, neighbour);
    size_t n = pairs->count;
    vector s = splat(0), d[3];
    for (int c = 0; c < form.dimension; c++) {
        d[c] = at(in->x[c], i) - at(in->x[c], j);
        if (form.periodic)
            d[c] -= shifts_of(&in->box, c, d[c]);
        s += d[c] * d[c];
    }
    __mmask8 within =
        _mm512_mask_cmp_pd_mask(there, (__m512d)s, _mm512_set1_pd(reach2), _CMP_LE_OQ);
    for (int c = 0; c < form.dimension; c++)
        keep(b.d[c] + n, within, d[c]);
    keep(b.s + n, within, s);
    keep_index(pairs->i + n, within, i);
    keep_index(pairs->j + n, within, j);
    pairs->count = n + (size_t)__builtin_popcount(within);
}
#endif

DL_INLINE void gather_span(const inputs *in, buffers b, loop_form form, double reach2,
                           const int *row, const int *neighbour, int count, gathered *pairs) {
#if defined(DL_ISA_avx512)
    if (!form.discrete) {
        for (int k = 0; k < count; k += 8)
            gather_lanes(in, b, form, reach2, row + k, neighbour + k, count - k, pairs);
        return;
    }
#endif
    for (int k = 0; k < count; k++) {
        bool changes = gather(in, b, form, false, reach2, row[k], neighbour[k], pairs);
        if (form.periodic && form.discrete && changes)
            gather(in, b, form, true, reach2, row[k], neighbour[k], pairs);
    }
}

/* Writes the row of every entry from `entry` on, as far as whole rows fit into `most`, or `most`
 * of one that is longer: rows are short and of any length, and a loop over each would end by
 * surprise. *i: the row of the next entry. Returns their number; row has room for 8 more. */
DL_INLINE int write_rows(const dl_neighbours *list, int entry, int most, int *i, int *row) {
    const int *start = list->start, end = list->end;
    int count = 0, at = *i;
    for (; at < end && start[at + 1] - entry <= most; at++) {
        int k = count;
        count = start[at + 1] - entry;
        do
            for (int lane = 0; lane < 8; lane++)
                row[k + lane] = at;
        while ((k += 8) < count);
    }
    if (count == 0 && at < end)
        while (count < most)
            row[count++] = at;
    *i = at;
    return count;
}

DL_INLINE void list_rows(const dl_pair_arrays *p, const dl_neighbours *list, loop_form form) {
    buffers b = lay_out(p->buffer, CHUNK);
    inputs in = inputs_of(p, form);
    const double reach2 = square_of_reach(p->law);
    /* a pair may have a part for each of two copies */
    const int most = form.periodic && form.discrete ? CHUNK / 2 : CHUNK;
    gathered pairs;
    pairs.count = 0;
    int row[CHUNK + 8];
    for (int i = list->begin, entry = list->start[i]; i < list->end;) {
        int count = write_rows(list, entry, most, &i, row);
        gather_span(&in, b, form, reach2, row, list->neighbour + entry, count, &pairs);
        scatter(p, b, form, list->both, &pairs);
        entry += count;
    }
}

/* --- runs of partners ------------------------------------------------------------------------- */

/* Separations of i and the `count` partners from `first` on. Returns whether the nearest copy of
 * any changes during the step. */
DL_INLINE bool row_distances(const inputs *in, buffers b, loop_form form, size_t i, size_t first,
                             size_t count) {
    lane_mask changes = {0};
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector s = splat(0), s1 = splat(0), ds = splat(0);
        for (int c = 0; c < form.dimension; c++) {
            vector d = in->x[c][i] - load(in->x[c] + first + k);
            if (form.periodic)
                d -= shifts_of(&in->box, c, d);
            s += d * d;
            if (form.discrete) {
                vector change = in->delta[c][i] - load(in->delta[c] + first + k);
                vector end = d + change;
                if (form.periodic)
                    changes |= shifts_of(&in->box, c, end) != 0;
                s1 += end * end;
                d += end;
                ds += change * d;
            }
            store(b.d[c] + k, d);
        }
        store(b.s + k, s);
        if (form.discrete) {
            store(b.s1 + k, s1);
            store(b.ds + k, ds);
        }
    }
    return form.periodic && form.discrete && any_lane(changes);
}

DL_INLINE void row_forces(const dl_pair_arrays *p, buffers b, loop_form form, size_t i,
                          size_t first, size_t count) {
    vector sum[3] = {splat(0), splat(0), splat(0)};
    for (size_t k = 0; k < count; k += DL_LANES) {
        vector f = load(b.f + k);
        if (form.coupled)
            f *= p->coupling[i] * load(p->coupling + first + k);
        for (int c = 0; c < form.dimension; c++) {
            vector force = f * load(b.d[c] + k);
            sum[c] += force;
            double *partner = p->f[c] + first + k;
            store(partner, load(partner) - force);
        }
    }
    for (int c = 0; c < form.dimension; c++)
        p->f[c][i] += sum_lanes(sum[c]);
}

/* Copies of a row's pairs that are the nearest at the end and not at the start: few. */
DL_INLINE void add_copies_at_end(const dl_pair_arrays *p, const inputs *in, loop_form form,
                                 size_t i, size_t first, size_t count) {
    buffers b = lay_out(p->buffer, CHUNK);
    gathered pairs;
    pairs.count = 0;
    for (size_t k = 0; k < count; k++) {
        gather(in, b, form, true, square_of_reach(p->law), (int)i, (int)(first + k), &pairs);
        if (pairs.count == CHUNK)
            scatter(p, b, form, true, &pairs);
    }
    scatter(p, b, form, true, &pairs);
}

DL_INLINE void block_rows(const dl_pair_arrays *p, const dl_pair_block *block, loop_form form) {
    buffers b = lay_out(p->buffer, p->particles);
    inputs in = inputs_of(p, form);
    for (size_t i = block->begin; i < block->end; i++) {
        size_t first = i + 1 > block->partners_begin ? i + 1 : block->partners_begin;
        if (first >= block->partners_end)
            continue;
        size_t count = block->partners_end - first;
        row_distances(&in, b, form, i, first, count);
        evaluate(p, b, form, count);
        row_forces(p, b, form, i, first, count);
    }
}

/* --- discrete forces: many rows at once ----------------------------------------------------------
 *
 * The way from distances to forces is long beside a short row. So rows stand one behind the other
 * in the buffers, as many as have room, and the law sees them all at once. Then the partners'
 * forces are gone through vector by vector, all rows for each: were they row after row, each would
 * wait for the stores of the one before, which its own loads straddle. */

/* Pairs that there is room for, or a row where that is longer (dl_row_buffer_size), and rows. */
enum { BATCH = 640, BATCH_ROWS = 64 };

typedef struct batch {
    size_t begin, rows;                         /* from particle `begin` on */
    size_t first[BATCH_ROWS], pair[BATCH_ROWS]; /* partner of each, and where it stands */
    vector sum[BATCH_ROWS][3];                  /* its force */
    bool changes;                               /* the nearest copy of any pair does */
} batch;

static const lane_mask lane_numbers =
#if DL_LANES == 8
    {0, 1, 2, 3, 4, 5, 6, 7};
#elif DL_LANES == 4
    {0, 1, 2, 3};
#else
    {0, 1};
#endif

DL_INLINE size_t first_partner(const dl_pair_block *block, size_t i) {
    return i + 1 > block->partners_begin ? i + 1 : block->partners_begin;
}

DL_INLINE buffers from_pair(buffers b, loop_form form, size_t pair) {
    buffers there = {.s = b.s + pair, .s1 = b.s1 + pair, .ds = b.ds + pair, .f = b.f + pair};
    for (int c = 0; c < form.dimension; c++)
        there.d[c] = b.d[c] + pair;
    return there;
}

/* Distances of as many rows as have room, and their law. */
DL_INLINE void fill_batch(const dl_pair_arrays *p, const dl_pair_block *block, loop_form form,
                          buffers b, size_t room, batch *of) {
    inputs in = inputs_of(p, form);
    size_t pairs = 0;
    of->rows = 0;
    of->changes = false;
    for (size_t i = of->begin; i < block->end && of->rows < BATCH_ROWS; i++) {
        size_t first = first_partner(block, i);
        if (first >= block->partners_end)
            first = block->partners_end;
        size_t count = block->partners_end - first;
        if (of->rows > 0 && pairs + count > room)
            break;
        of->changes |= row_distances(&in, from_pair(b, form, pairs), form, i, first, count);
        of->first[of->rows] = first;
        of->pair[of->rows++] = pairs;
        pairs += count;
    }
    evaluate(p, b, form, pairs);
}

/* The force of row k on the partners from `j` on, whose own is `force`. */
DL_INLINE void add_row_to(const dl_pair_arrays *p, buffers b, loop_form form, size_t end, size_t j,
                          size_t k, batch *of, vector force[3]) {
    ptrdiff_t at = (ptrdiff_t)of->pair[k] + (ptrdiff_t)j - (ptrdiff_t)of->first[k];
    vector f = load(b.f + at);
    if (of->first[k] > j || j + DL_LANES > end) { /* others' pairs stand on both sides */
        lane_mask partner = lane_numbers + (int64_t)j;
        f = choose((partner >= (int64_t)of->first[k]) & (partner < (int64_t)end), f, splat(0));
    }
    if (form.coupled)
        f *= p->coupling[of->begin + k] * load(p->coupling + j);
    for (int c = 0; c < form.dimension; c++) {
        vector own = f * load(b.d[c] + at);
        force[c] -= own;
        of->sum[k][c] += own;
    }
}

DL_INLINE void batch_forces(const dl_pair_arrays *p, buffers b, loop_form form, size_t end,
                            batch *of) {
    size_t rows = 0;
    for (size_t k = 0; k < of->rows; k++)
        for (int c = 0; c < form.dimension; c++)
            of->sum[k][c] = splat(0);
    for (size_t j = of->first[0] / DL_LANES * DL_LANES; j < end; j += DL_LANES) {
        vector force[3];
        while (rows < of->rows && of->first[rows] < j + DL_LANES)
            rows++; /* they have a partner here */
        for (int c = 0; c < form.dimension; c++)
            force[c] = load(p->f[c] + j);
        for (size_t k = 0; k < rows; k++)
            add_row_to(p, b, form, end, j, k, of, force);
        for (int c = 0; c < form.dimension; c++)
            store(p->f[c] + j, force[c]);
    }
    for (size_t k = 0; k < of->rows; k++)
        for (int c = 0; c < form.dimension; c++)
            p->f[c][of->begin + k] += sum_lanes(of->sum[k][c]);
}

DL_INLINE void block_batches(const dl_pair_arrays *p, const dl_pair_block *block, loop_form form) {
    size_t room = p->particles > BATCH ? p->particles : BATCH, end = block->partners_end;
    /* what is read before the first pair is there */
    buffers b = from_pair(lay_out(p->buffer, room + DL_VECTOR_PAD), form, DL_LANES);
    inputs in = inputs_of(p, form);
    batch of;
    for (of.begin = block->begin; of.begin < block->end; of.begin += of.rows) {
        fill_batch(p, block, form, b, room, &of);
        batch_forces(p, b, form, end, &of);
        for (size_t k = 0; form.periodic && of.changes && k < of.rows; k++)
            add_copies_at_end(p, &in, form, of.begin + k, of.first[k], end - of.first[k]);
    }
}

/* --- one compiled loop a form ----------------------------------------------------------------- */

typedef void list_loop(const dl_pair_arrays *p, const dl_neighbours *list);

/* Functions of their own: in one that held them all, each would be short of registers. */
#define DL_MAKE(name, dimension, coupled, periodic, ...)                                           \
    static void block_##name(const dl_pair_arrays *p, const dl_pair_block *block) {                \
        block_rows(p, block, (loop_form){dimension, coupled, periodic, false});                    \
    }                                                                                              \
    static void block_discrete_##name(const dl_pair_arrays *p, const dl_pair_block *block) {       \
        block_batches(p, block, (loop_form){dimension, coupled, periodic, true});                  \
    }                                                                                              \
    static void list_##name(const dl_pair_arrays *p, const dl_neighbours *list) {                  \
        list_rows(p, list, (loop_form){dimension, coupled, periodic, false});                      \
    }                                                                                              \
    static void list_discrete_##name(const dl_pair_arrays *p, const dl_neighbours *list) {         \
        list_rows(p, list, (loop_form){dimension, coupled, periodic, true});                       \
    }
DL_FORMS(DL_MAKE)
#undef DL_MAKE

static const struct {
    dl_block_loop *block, *block_discrete;
    list_loop *list, *list_discrete;
} loops[] = {
#define DL_ROW(name, ...) {block_##name, block_discrete_##name, list_##name, list_discrete_##name},
    DL_FORMS(DL_ROW)
#undef DL_ROW
};

void DL_VARIANT(dl_block)(const dl_pair_arrays *p, const dl_pair_block *block) {
    size_t form = dl_loop_form(p);
    (p->loops->block ? p->loops->block[form] : loops[form].block)(p, block);
}

void DL_VARIANT(dl_block_discrete)(const dl_pair_arrays *p, const dl_pair_block *block) {
    loops[dl_loop_form(p)].block_discrete(p, block);
}

void DL_VARIANT(dl_list)(const dl_pair_arrays *p, const dl_neighbours *list) {
    loops[dl_loop_form(p)].list(p, list);
}

void DL_VARIANT(dl_list_discrete)(const dl_pair_arrays *p, const dl_neighbours *list) {
    loops[dl_loop_form(p)].list_discrete(p, list);
}
