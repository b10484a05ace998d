/* Loops over pairs: distances to buffers, the law over the buffers, forces back by Newton's third
 * law. Blocks of all pairs read the partners of a particle in a run; rows of a list gather the
 * pairs within reach first, for most of a list's pairs are usually not.
 *
 * In a periodic box separations are those of the nearest copies (force/box.h). A pair's discrete
 * force has a part for each copy that is within reach at the start or at the end of the step: the
 * copy nearest at the start, and, where that is another one, the copy nearest at the end. */
#include "force/vector/vector.h"

/* Pairs gathered before the law is evaluated: the buffers stay in the first-level cache. */
enum { CHUNK = 256 };

/* What a loop is compiled for: one for each combination, so that what a scene lacks is not
 * branched on. */
typedef struct loop_form {
    int dimension;
    bool coupled, periodic, discrete;
} loop_form;

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

/* What the loops read, as a local copy: they write to arrays that the compiler cannot tell from
 * where these pointers and lengths lie. */
typedef struct inputs {
    const double *x[3], *delta[3];
    dl_box box;
} inputs;

DL_INLINE inputs inputs_of(const dl_pair_arrays *p, loop_form form) {
    return (inputs){
        .x = {p->x[0], p->x[1], p->x[2]},
        .delta = {p->delta[0], p->delta[1], p->delta[2]},
        .box = form.periodic ? *p->box : (dl_box){{0}, {0}},
    };
}

/* Nearest whole number, by the digits that 1.5 * 2^52 leaves; numbers beyond 2^51 stay near. */
static const double whole_digits = 6755399441055744.0;

DL_INLINE double shift_of(const dl_box *box, int c, double d) {
    return box->length[c] * ((d * box->inverse[c] + whole_digits) - whole_digits);
}

DL_INLINE vector shifts_of(const dl_box *box, int c, vector d) {
    return box->length[c] * ((d * box->inverse[c] + whole_digits) - whole_digits);
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
    int i[CHUNK + 1], j[CHUNK + 1];
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

DL_INLINE void scatter(const dl_pair_arrays *p, buffers b, loop_form form, gathered *pairs) {
    evaluate(p, b, form, pairs->count);
    for (size_t n = 0; n < pairs->count; n++) {
        int i = pairs->i[n], j = pairs->j[n];
        double f = b.f[n];
        if (form.coupled)
            f *= p->coupling[i] * p->coupling[j];
        for (int c = 0; c < form.dimension; c++) {
            double force = f * b.d[c][n];
            p->f[c][i] += force;
            p->f[c][j] -= force;
        }
    }
    pairs->count = 0;
}

DL_INLINE double square_of_reach(const dl_law *law) {
    return law->until2[law->pieces - 1];
}

DL_INLINE void list_rows(const dl_pair_arrays *p, const dl_neighbours *list, loop_form form) {
    buffers b = lay_out(p->buffer, CHUNK);
    inputs in = inputs_of(p, form);
    gathered pairs;
    pairs.count = 0;
    double reach2 = square_of_reach(p->law);
    const int *neighbour = list->neighbour;
    for (int i = 0; i < (int)p->moving; i++)
        for (int k = list->start[i]; k < list->start[i + 1]; k++) {
            int j = neighbour[k];
            bool changes = gather(&in, b, form, false, reach2, i, j, &pairs);
            if (pairs.count == CHUNK)
                scatter(p, b, form, &pairs);
            if (form.periodic && form.discrete && changes) {
                gather(&in, b, form, true, reach2, i, j, &pairs);
                if (pairs.count == CHUNK)
                    scatter(p, b, form, &pairs);
            }
        }
    scatter(p, b, form, &pairs);
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
            scatter(p, b, form, &pairs);
    }
    scatter(p, b, form, &pairs);
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

/* make(name, dimension, coupled, periodic), in the order of index_of. */
#define DL_FORMS(make)                                                                             \
    make(flat, 2, false, false) make(solid, 3, false, false) make(flat_coupled, 2, true, false)    \
        make(solid_coupled, 3, true, false) make(flat_periodic, 2, false, true)                    \
            make(solid_periodic, 3, false, true) make(flat_coupled_periodic, 2, true, true)        \
                make(solid_coupled_periodic, 3, true, true)

static size_t index_of(const dl_pair_arrays *p) {
    return (p->box ? 4U : 0U) + (p->coupling ? 2U : 0U) + (p->dimension == 3 ? 1U : 0U);
}

typedef void block_loop(const dl_pair_arrays *p, const dl_pair_block *block);
typedef void list_loop(const dl_pair_arrays *p, const dl_neighbours *list);

/* Functions of their own: in one that held them all, each would be short of registers. */
#define DL_MAKE(name, ...)                                                                         \
    static void block_##name(const dl_pair_arrays *p, const dl_pair_block *block) {                \
        block_rows(p, block, (loop_form){__VA_ARGS__, false});                                     \
    }                                                                                              \
    static void block_discrete_##name(const dl_pair_arrays *p, const dl_pair_block *block) {       \
        block_batches(p, block, (loop_form){__VA_ARGS__, true});                                   \
    }                                                                                              \
    static void list_##name(const dl_pair_arrays *p, const dl_neighbours *list) {                  \
        list_rows(p, list, (loop_form){__VA_ARGS__, false});                                       \
    }                                                                                              \
    static void list_discrete_##name(const dl_pair_arrays *p, const dl_neighbours *list) {         \
        list_rows(p, list, (loop_form){__VA_ARGS__, true});                                        \
    }
DL_FORMS(DL_MAKE)
#undef DL_MAKE

static const struct {
    block_loop *block, *block_discrete;
    list_loop *list, *list_discrete;
} loops[] = {
#define DL_ROW(name, ...) {block_##name, block_discrete_##name, list_##name, list_discrete_##name},
    DL_FORMS(DL_ROW)
#undef DL_ROW
};

void DL_VARIANT(dl_block)(const dl_pair_arrays *p, const dl_pair_block *block) {
    loops[index_of(p)].block(p, block);
}

void DL_VARIANT(dl_block_discrete)(const dl_pair_arrays *p, const dl_pair_block *block) {
    loops[index_of(p)].block_discrete(p, block);
}

void DL_VARIANT(dl_list)(const dl_pair_arrays *p, const dl_neighbours *list) {
    loops[index_of(p)].list(p, list);
}

void DL_VARIANT(dl_list_discrete)(const dl_pair_arrays *p, const dl_neighbours *list) {
    loops[index_of(p)].list_discrete(p, list);
}
