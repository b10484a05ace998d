/* Force kernels: pair forces of all particles, and the candidate pairs that everything slower
 * (potential, Jacobian) walks over. One kernel is chosen when the model is made. */
#ifndef DL_FORCE_KERNEL_H
#define DL_FORCE_KERNEL_H

#include <stddef.h>
#include "driftlab/model.h"
#include "force/box.h"
#include "force/law.h"
#include "force/vector_ops.h"

/* What a kernel needs to know; outlives the kernel. Moving particles come first. */
typedef struct dl_pair_problem {
    int dimension;
    size_t particles, moving;
    const double *coupling; /* [particles + DL_VECTOR_PAD], zeros behind; NULL: all 1 */
    size_t species;         /* 1 where one law holds for all pairs */
    const int *species_of;  /* [particles]; NULL where one law holds for all pairs */
    const dl_law *law;      /* [species * species], symmetric; no pieces: no force */
    double reach;           /* longest cutoff; INFINITY where a law never ends */
    const dl_box *box;      /* NULL: nothing is periodic */
    double skin;            /* 0: chosen */
    double tree_error;      /* of a tree's forces */
} dl_pair_problem;

/* Index of the law between two particles. */
static inline size_t dl_pair_law_index(const dl_pair_problem *problem, size_t i, size_t j) {
    const int *of = problem->species_of;
    return of ? (size_t)of[i] * problem->species + (size_t)of[j] : 0;
}

/* Candidate pairs (i, j), i < moving, i < j: j = neighbour[start[i]] ... of row i, or every j > i
 * where neighbour is NULL. */
typedef struct dl_pair_rows {
    const int *start, *neighbour;
    unsigned long generation; /* changes with the rows */
} dl_pair_rows;

typedef struct dl_kernel_ops {
    const char *name, *doc;
    dl_status (*create)(dl_kernel *kernel, dl_error *error);
    /* f = pair forces at x; blocks x|y|[z] of dimension * particles doubles, f overwritten. */
    dl_status (*force)(dl_kernel *kernel, const double *x, double *f, dl_error *error);
    /* Potential energy of all pairs, and the sum of its moduli; NULL: by walking over the pairs. */
    dl_status (*potential)(dl_kernel *kernel, const double *x, long double *sum,
                           long double *moduli, dl_error *error);
    /* f = pairs' discrete forces over the step from x to x + delta. */
    dl_status (*discrete)(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error);
    /* f [dimension] = the force of the pair on i as `force`, or where delta is not NULL `discrete`,
     * has summed it, to the last bit: that of a squared distance decides which piece a pair on a
     * breakpoint goes by. */
    void (*pair)(dl_kernel *kernel, const double *x, const double *delta, size_t i, size_t j,
                 double *f);
    /* Pairs that can act at x, and at x + delta where delta is not NULL. */
    dl_status (*rows)(dl_kernel *kernel, const double *x, const double *delta, dl_pair_rows *rows,
                      dl_error *error);
    void (*destroy)(dl_kernel *kernel);
} dl_kernel_ops;

struct dl_kernel {
    const dl_kernel_ops *ops;
    dl_pair_problem problem;
    const dl_vector_ops *vector;
    const dl_law_loops **loops; /* [species * species] */
    const char *reason;         /* why it was chosen */
    double stated_error;        /* of its forces, driftlab/model.h; 0: it sums all pairs that act */
    unsigned long list_builds;
    unsigned long near_pairs, far_pairs; /* of a tree: pairs of particles and of cells so far */
    void *data;
};

/* `rows` of a kernel without a list: every pair may act. */
dl_status dl_kernel_rows_of_all(dl_kernel *kernel, const double *x, const double *delta,
                                dl_pair_rows *rows, dl_error *error);

extern const dl_kernel_ops dl_kernel_reference, dl_kernel_all_pairs, dl_kernel_neighbour_list,
    dl_kernel_tree;

/* Chooses by the scene: what it asks for, or else a list where the law ends and the particles are
 * many, a tree where it does not and they are very many, all pairs otherwise. DL_INPUT for a list
 * without a cutoff, and for a tree where there are periods or located crossings. */
dl_status dl_kernel_create(const dl_pair_problem *problem, dl_kernel_choice choice,
                           dl_kernel **kernel, dl_error *error);
void dl_kernel_destroy(dl_kernel *kernel);

#endif
