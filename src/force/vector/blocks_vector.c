/* Forces of all pairs of a block, for laws whose powers are known at compile time: from separation
 * to force in registers. Vectors begin at whole vectors of the arrays, so that no load or store
 * lies across two cache lines; the first of a row and the last have lanes without a pair. */
#include "force/vector/law_shape.h"
#include "force/vector/loop_form.h"

typedef struct row {
    size_t i;
    double x[3], coupling;
    vector force[3];
} row;

/* Lanes of the vector at k whose partner is of the row. */
DL_INLINE lane_mask lanes_of(size_t k, size_t first, size_t end) {
    lane_mask lane;
    for (int n = 0; n < DL_LANES; n++)
        lane[n] = (int64_t)k + n;
    return (lane >= (int64_t)first) & (lane < (int64_t)end);
}

/* Adds the forces between the row's particle and the partners at k; those not in `there` have
 * none, where there are such. */
DL_INLINE void add_partners(const dl_pair_arrays *p, const inputs *in, loop_form form, shape law,
                            size_t k, bool ragged, lane_mask there, row *r) {
    vector s = splat(0), d[3];
    for (int c = 0; c < form.dimension; c++) {
        d[c] = r->x[c] - load(in->x[c] + k);
        if (form.periodic)
            d[c] -= shifts_of(&in->box, c, d[c]);
        s += d[c] * d[c];
    }
    vector f = shape_force(p->law, law, s);
    if (form.coupled)
        f *= r->coupling * load(p->coupling + k);
    if (ragged)
        f = (vector)((lane_mask)f & there);
    for (int c = 0; c < form.dimension; c++) {
        vector force = f * d[c];
        double *partner = p->f[c] + k;
        r->force[c] += force;
        store(partner, load(partner) - force);
    }
}

DL_INLINE void shape_rows(const dl_pair_arrays *p, const dl_pair_block *block, loop_form form,
                          shape law) {
    const inputs in = inputs_of(p, form);
    const dl_law own = *p->law; /* the loops write to where the compiler cannot tell it from */
    dl_pair_arrays arrays = *p;
    arrays.law = &own;
    for (size_t i = block->begin; i < block->end; i++) {
        size_t first = i + 1 > block->partners_begin ? i + 1 : block->partners_begin;
        size_t end = block->partners_end, whole = end / DL_LANES * DL_LANES;
        row r = {.i = i, .coupling = form.coupled ? p->coupling[i] : 1};
        for (int c = 0; c < form.dimension; c++)
            r.x[c] = in.x[c][i];
        size_t k = first / DL_LANES * DL_LANES;
        if (k < first && k < end) {
            add_partners(&arrays, &in, form, law, k, true, lanes_of(k, first, end), &r);
            k += DL_LANES;
        }
        for (; k < whole; k += DL_LANES)
            add_partners(&arrays, &in, form, law, k, false, (lane_mask){0}, &r);
        if (k < end)
            add_partners(&arrays, &in, form, law, k, true, lanes_of(k, first, end), &r);
        for (int c = 0; c < form.dimension; c++)
            p->f[c][i] += sum_lanes(r.force[c]);
    }
}

/* Each law in each form, and the law's table of them. */
#define DL_MAKE(form, dimension, coupled, periodic, law, ...)                                      \
    static void law##_##form(const dl_pair_arrays *p, const dl_pair_block *block) {                \
        shape_rows(p, block, (loop_form){dimension, coupled, periodic, false},                     \
                   (shape)__VA_ARGS__);                                                            \
    }
#define DL_ENTRY(form, dimension, coupled, periodic, law, ...) law##_##form,
#define DL_SHAPE(name, ...)                                                                        \
    DL_FORMS(DL_MAKE, name, __VA_ARGS__)                                                           \
    dl_block_loop *const DL_VARIANT(dl_block_##name)[dl_loop_forms] = {                            \
        DL_FORMS(DL_ENTRY, name, __VA_ARGS__)};
#include "force/vector/law_shapes.def"
#undef DL_SHAPE
