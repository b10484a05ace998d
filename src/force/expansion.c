#include "force/expansion.h"

#include <string.h>

typedef struct index3 {
    int n[3];
} index3;

static int find(const dl_expansion *form, const index3 *index, index3 wanted) {
    int k = 0;
    while (k < form->terms && memcmp(&index[k], &wanted, sizeof wanted) != 0)
        k++;
    return k;
}

static index3 added(index3 a, index3 b) {
    for (int c = 0; c < 3; c++)
        a.n[c] += b.n[c];
    return a;
}

static index3 along(index3 a, int axis, int by) {
    a.n[axis] += by;
    return a;
}

static void list_indices(dl_expansion *form, index3 *index) {
    for (int degree = 0; degree <= form->order; degree++) {
        for (int z = 0; z <= (form->dimension == 3 ? degree : 0); z++)
            for (int y = 0; y <= degree - z; y++) {
                form->degree[form->terms] = degree;
                index[form->terms++] = (index3){{degree - y - z, y, z}};
            }
        form->terms_to[degree] = form->terms;
    }
}

static void find_neighbours(dl_expansion *form, const index3 *index) {
    for (int k = 0; k < form->terms; k++) {
        for (int c = 0; c < form->dimension && form->degree[k] < form->order; c++)
            form->raised[c][k] = find(form, index, along(index[k], c, 1));
        if (k == 0)
            continue;
        int axis = 0;
        while (index[k].n[axis] == 0)
            axis++;
        const int count = index[k].n[axis];
        form->axis[k] = axis;
        form->count[k] = count;
        form->lower[k] = find(form, index, along(index[k], axis, -1));
        form->lower2[k] = count > 1 ? find(form, index, along(index[k], axis, -2)) : 0;
    }
}

void dl_expansion_prepare(int dimension, int order, dl_expansion *form) {
    index3 index[dl_expansion_terms];
    memset(form, 0, sizeof *form);
    form->dimension = dimension;
    form->order = order;
    list_indices(form, index);
    find_neighbours(form, index);
    int next = 0;
    for (int a = 0; a < form->terms; a++) {
        form->row[a] = next;
        for (int b = 0; b < form->terms_to[order - form->degree[a]]; b++)
            form->sum[next++] = (unsigned short)find(form, index, added(index[a], index[b]));
    }
}

/* monomial[n] = offset^n/n!, and half[d] = 2^-d. */
static void shift_factors(const dl_expansion *form, const double offset[3], double *monomial,
                          double *half) {
    monomial[0] = half[0] = 1;
    for (int k = 1; k < form->terms; k++)
        monomial[k] = monomial[form->lower[k]] * offset[form->axis[k]] / form->count[k];
    for (int d = 1; d <= form->order; d++)
        half[d] = half[d - 1] / 2;
}

void dl_expansion_raise(const dl_expansion *form, const double offset[3], const double *child,
                        double *parent) {
    double monomial[dl_expansion_terms], half[dl_expansion_orders + 1];
    shift_factors(form, offset, monomial, half);
    for (int b = 0; b < form->terms; b++) {
        const int degree = form->degree[b], count = form->terms_to[form->order - degree];
        const double m = child[b] * half[degree];
        const unsigned short *const sum = form->sum + form->row[b];
        for (int c = 0; c < count; c++)
            parent[sum[c]] += m * monomial[c];
    }
}

void dl_expansion_lower(const dl_expansion *form, const double offset[3], const double *parent,
                        double *child) {
    double monomial[dl_expansion_terms], half[dl_expansion_orders + 1];
    shift_factors(form, offset, monomial, half);
    for (int b = 0; b < form->terms; b++) {
        const int degree = form->degree[b], count = form->terms_to[form->order - degree];
        const unsigned short *const sum = form->sum + form->row[b];
        double term = 0;
        for (int c = 0; c < count; c++)
            term += parent[sum[c]] * monomial[c];
        child[b] += half[degree] * term;
    }
}
