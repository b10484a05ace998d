/* The pair loops, compiled once for each instruction set; dl_vector_best picks at run time. */
#ifndef DL_FORCE_VECTOR_OPS_H
#define DL_FORCE_VECTOR_OPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "force/box.h"
#include "force/law.h"

/* Lanes of the widest variant: arrays that the loops may read or write past their end are longer
 * by this many doubles. */
#define DL_VECTOR_PAD 8

/* F(r)/r for `count` squared distances, rounded up to whole vectors: s and f have
 * DL_VECTOR_PAD doubles of room behind them and s has harmless values (1) in it. */
typedef void dl_law_loop(const dl_law *law, const double *s, double *f, size_t count);

/* G of dl_law_discrete for `count` pairs, in the same way. */
typedef void dl_discrete_loop(const dl_law *law, const double *s0, const double *s1,
                              const double *ds, double *g, size_t count);

typedef struct dl_law_loops dl_law_loops;

/* Positions and forces of the particles, one padded array a component. */
typedef struct dl_pair_arrays {
    int dimension;
    size_t particles;
    const double *coupling; /* [particles + pad], NULL: all 1 */
    const double *x[3];     /* positions */
    const double *delta[3]; /* displacements over a step; discrete loops only */
    double *f[3];           /* forces, added to */
    double *buffer;         /* dl_row_buffer_size(particles) doubles */
    const dl_box *box;      /* NULL: nothing is periodic */
    const dl_law *law;      /* of the pairs that the call is for */
    const dl_law_loops *loops;
} dl_pair_arrays;

/* Pairs (i, j) with begin <= i < end, partners_begin <= j < partners_end, i < j. */
typedef struct dl_pair_block {
    size_t begin, end, partners_begin, partners_end;
} dl_pair_block;

typedef void dl_block_loop(const dl_pair_arrays *arrays, const dl_pair_block *block);

enum { dl_loop_forms = 8 };

/* Of the loops compiled for what a scene has: its place among them. */
static inline size_t dl_loop_form(const dl_pair_arrays *arrays) {
    return (arrays->box ? 4U : 0U) + (arrays->coupling ? 2U : 0U) +
           (arrays->dimension == 3 ? 1U : 0U);
}

/* The law's loops: those specialised for its powers where there are such. */
struct dl_law_loops {
    const char *name;
    dl_law_loop *force;
    dl_discrete_loop *discrete;
    dl_block_loop *const *block; /* [dl_loop_forms]: the force over blocks; NULL: by `force` */
};

/* Neighbour rows begin <= i < end: j of row i in neighbour[start[i]] ... neighbour[start[i + 1] -
 * 1]. Their forces are added to both particles, or to i alone. */
typedef struct dl_neighbours {
    const int *start, *neighbour;
    int begin, end;
    bool both;
} dl_neighbours;

struct dl_expansion_ops;

typedef struct dl_vector_ops {
    const char *name; /* "plain", "avx2", "avx512" */
    const dl_law_loops *(*loops_for)(const dl_law *law);
    void (*block)(const dl_pair_arrays *arrays, const dl_pair_block *block);
    void (*block_discrete)(const dl_pair_arrays *arrays, const dl_pair_block *block);
    void (*list)(const dl_pair_arrays *arrays, const dl_neighbours *neighbours);
    void (*list_discrete)(const dl_pair_arrays *arrays, const dl_neighbours *neighbours);
    /* Whether a component of x is farther than `limit` from origin's (or not a number). */
    bool (*moved)(const double *const *x, const double *const *origin, int dimension, size_t count,
                  double limit);
    /* a = f * scale[i] (scale NULL: 1) + g * mask[i] (mask NULL: 1); false where a component is
     * not finite. f and a may be the same array. */
    bool (*finish)(const double *f, const double *scale, double g, const double *mask, double *a,
                   size_t count);
    const struct dl_expansion_ops *expansions; /* force/expansion.h */
    /* Bit k of count <= 64: x[k] < low or x[k] > high. */
    uint64_t (*outside)(const double *x, double low, double high, size_t count);
    /* 1/sqrt(s) as the loops have it, for tests. */
    void (*inverse_sqrt)(const double *s, double *root, size_t count);
} dl_vector_ops;

/* Doubles of scratch that the row loops need. */
size_t dl_row_buffer_size(size_t particles);

/* The widest variant this processor has, or the one forced by dl_vector_force. */
const dl_vector_ops *dl_vector_best(void);
/* For tests: "plain", "avx2", "avx512", or NULL for the widest. False where it cannot run here. */
bool dl_vector_force(const char *name);

#endif
