/* Cartesian expansions of a radial potential about the centres of cells, in two or three
 * dimensions: what a tree replaces far pairs by.
 *
 * Sources x_j = c_A + eta with weights w_j, targets x = c_B + xi, R = c_B - c_A:
 *
 *     sum_j w_j V(|x - x_j|) = sum_b xi^b/b! L_b,     L_b = sum_a D_(a+b)(R) (-1)^|a| M_a,
 *     M_a = sum_j w_j eta^a/a!,                       D_n = the derivative of V(|R|) by n,
 *
 * a, b, n multi-indices. Left out are a, b with |a| + |b| > order: the same on both sides, so that
 * the two cells' forces on each other are opposite but for roundoff, and the force is the exact
 * gradient of the truncated potential as long as the cells stay.
 *
 * Moments and local terms are kept in units of the cell's side h, M_a / h^|a| and L_b h^|b|, so
 * that neither overflows. W. Dehnen, J. Comput. Phys. 179 (2002) 27, doi:10.1006/jcph.2002.7026,
 * has the mutual form. */
#ifndef DL_FORCE_EXPANSION_H
#define DL_FORCE_EXPANSION_H

#include "driftlab/status.h"
#include "force/law.h"

enum {
    dl_expansion_orders = 16,       /* highest in two dimensions; lower in three */
    dl_expansion_orders_solid = 12, /* in three */
    dl_expansion_terms = 455,       /* at most */
    dl_expansion_sums = 18564,      /* at most */
    dl_far_pairs = 8,               /* that are worked on at once */
};

/* Multi-indices n of one dimension and highest order, by ascending degree, and what goes from one
 * to the next. Terms to degree d are the first terms_to[d]. */
typedef struct dl_expansion {
    int dimension, order, terms;
    int terms_to[dl_expansion_orders + 1];
    int degree[dl_expansion_terms];
    /* n = lower + e_axis = lower2 + 2 e_axis; count = n_axis (lower2 is 0 where count is 1) */
    int axis[dl_expansion_terms], lower[dl_expansion_terms], lower2[dl_expansion_terms];
    double count[dl_expansion_terms];
    int raised[3][dl_expansion_terms]; /* n + e, for n below the order */
    /* n + m for |n| + |m| <= order: sum[row[n] + m] */
    int row[dl_expansion_terms];
    unsigned short sum[dl_expansion_sums];
} dl_expansion;

void dl_expansion_prepare(int dimension, int order, dl_expansion *form);

/* parent += child's moments, where the child's centre lies at `offset` from the parent's in units
 * of the parent's side, and has half its side. */
void dl_expansion_raise(const dl_expansion *form, const double offset[3], const double *child,
                        double *parent);
/* child += the parent's local terms. */
void dl_expansion_lower(const dl_expansion *form, const double offset[3], const double *parent,
                        double *child);

/* Pairs of cells that see each other by expansions of one order, all their particles' distances in
 * one piece of one law. */
typedef struct dl_far_batch {
    const dl_law *law;
    int piece, order, count;
    int cell[2][dl_far_pairs];
    double side[2][dl_far_pairs];
    double d[3][dl_far_pairs]; /* centre of the second minus centre of the first */
} dl_far_batch;

/* Particles of a cell: `count` of them, from each pointer on. */
typedef struct dl_cell_particles {
    size_t count;
    const double *x[3];
    const double *weight; /* NULL: all 1 */
    double *f[3];         /* forces, added to */
} dl_cell_particles;

/* Compiled once for each instruction set. */
typedef struct dl_expansion_ops {
    /* moment [terms] = the particles' */
    void (*moments)(const dl_expansion *form, const dl_cell_particles *particles,
                    const double centre[3], double side, double *moment);
    /* local [cells * terms] += what each pair's cells make at each other, from moment
     * [cells * terms]. */
    void (*far)(const dl_expansion *form, const dl_far_batch *batch, const double *moment,
                double *local);
    /* forces += minus the gradient of the local terms [terms], times the weights. */
    void (*forces)(const dl_expansion *form, const dl_cell_particles *particles,
                   const double centre[3], double side, const double *local);
} dl_expansion_ops;

#endif
