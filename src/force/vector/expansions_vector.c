/* The expansions' loops: particles of a cell, or pairs of cells, side by side in the lanes. */
#include "force/expansion.h"
#include "force/vector/vector.h"
#include "force/whole_power.h"

typedef double lanes[DL_LANES];

/* monomial[n] = u^n/n! for the first `terms` terms. */
DL_INLINE void find_monomials(const dl_expansion *form, int terms, const vector u[3],
                              vector *monomial) {
    monomial[0] = splat(1);
    for (int k = 1; k < terms; k++)
        monomial[k] = monomial[form->lower[k]] * u[form->axis[k]] * (1 / form->count[k]);
}

/* Places of particles from `first` on in units of the side, and their weights; lanes behind the
 * last particle are at the centre and weigh nothing. */
DL_INLINE vector load_particles(const dl_expansion *form, const dl_cell_particles *p, size_t first,
                                const double centre[3], double side, vector u[3]) {
    lanes weight = {0}, place[3] = {{0}};
    for (size_t k = 0; k < DL_LANES && first + k < p->count; k++) {
        weight[k] = p->weight ? p->weight[first + k] : 1;
        for (int c = 0; c < form->dimension; c++)
            place[c][k] = (p->x[c][first + k] - centre[c]) / side;
    }
    for (int c = 0; c < 3; c++)
        u[c] = load(place[c]);
    return load(weight);
}

static void moments(const dl_expansion *form, const dl_cell_particles *p, const double centre[3],
                    double side, double *moment) {
    vector monomial[dl_expansion_terms], sum[dl_expansion_terms];
    for (int k = 0; k < form->terms; k++)
        sum[k] = splat(0);
    for (size_t first = 0; first < p->count; first += DL_LANES) {
        vector u[3];
        const vector weight = load_particles(form, p, first, centre, side, u);
        find_monomials(form, form->terms, u, monomial);
        for (int k = 0; k < form->terms; k++)
            sum[k] += weight * monomial[k];
    }
    for (int k = 0; k < form->terms; k++)
        moment[k] = sum_lanes(sum[k]);
}

static void forces(const dl_expansion *form, const dl_cell_particles *p, const double centre[3],
                   double side, const double *local) {
    const int terms = form->order > 0 ? form->terms_to[form->order - 1] : 0;
    vector monomial[dl_expansion_terms];
    for (size_t first = 0; first < p->count; first += DL_LANES) {
        vector u[3];
        const vector weight = load_particles(form, p, first, centre, side, u);
        find_monomials(form, terms, u, monomial);
        for (int c = 0; c < form->dimension; c++) {
            vector slope = splat(0);
            for (int k = 0; k < terms; k++)
                slope += local[form->raised[c][k]] * monomial[k];
            slope *= weight / side;
            for (size_t k = 0; k < DL_LANES && first + k < p->count; k++)
                p->f[c][first + k] -= slope[k];
        }
    }
}

/* --- pairs of cells --------------------------------------------------------------------------- */

/* radial[m] = r^(2m) ((1/r) d/dr)^m V, m = 0 ... order, of a piece that is a sum of powers:
 *     -c r^(1-p), times -(p + 2m - 1) from m to m + 1, for m > 0. */
static void find_radial(const dl_far_batch *batch, double r, size_t lane, lanes *radial) {
    const dl_law *const law = batch->law;
    const int piece = batch->piece;
    for (int m = 0; m <= batch->order; m++)
        radial[m][lane] = 0;
    radial[0][lane] = law->constant[piece];
    for (int s = 0; s < law->terms[piece]; s++) {
        const double c = law->coefficient[piece][s], p = law->power[piece][s];
        const int whole = law->whole_power[piece][s];
        double term = c * (!law->integer ? pow(r, 1 - p)
                           : whole > 0   ? dl_whole_power(1 / r, whole - 1)
                                         : r);
        radial[0][lane] += p == 1 ? -c * log(r) : term / (p - 1);
        term = -term;
        for (int m = 1; m <= batch->order; m++) {
            radial[m][lane] += term;
            term *= -(p + 2 * m - 1);
        }
    }
}

/* derivative[n] = |R|^|n| D_n(R), from u = R/|R|: of ((1/r) d/dr)^m V all derivatives to degree
 * order - m, from those of m + 1 to degree order - m - 1, by
 *     D(m)_n = u_e D(m+1)_(n-e) + (n_e - 1) D(m+1)_(n-2e). */
DL_INLINE void find_derivatives(const dl_expansion *form, int order, const vector u[3],
                                const lanes *radial, vector *derivative) {
    derivative[0] = load(radial[order]);
    for (int m = order - 1; m >= 0; m--) {
        for (int k = form->terms_to[order - m] - 1; k > 0; k--)
            derivative[k] = u[form->axis[k]] * derivative[form->lower[k]] +
                            (form->count[k] - 1) * derivative[form->lower2[k]];
        derivative[0] = load(radial[m]);
    }
}

/* Up to DL_LANES pairs, from `first` on. `ratio` is side / |R| of each side's cells. */
typedef struct far_lanes {
    size_t first, count;
    lanes ratio[2];
    vector u[3];
    lanes radial[dl_expansion_orders + 1];
    vector derivative[dl_expansion_terms];
    vector moment[2][dl_expansion_terms], local[2][dl_expansion_terms];
} far_lanes;

static void load_pairs(const dl_expansion *form, const dl_far_batch *batch, far_lanes *pairs) {
    lanes u[3] = {{0}};
    for (size_t k = 0; k < DL_LANES; k++) {
        const size_t at = pairs->first + (k < pairs->count ? k : 0); /* idle lanes: the first's */
        double s = 0;
        for (int c = 0; c < form->dimension; c++)
            s += batch->d[c][at] * batch->d[c][at];
        const double r = sqrt(s);
        for (int c = 0; c < form->dimension; c++)
            u[c][k] = batch->d[c][at] / r;
        for (int side = 0; side < 2; side++)
            pairs->ratio[side][k] = batch->side[side][at] / r;
        find_radial(batch, r, k, pairs->radial);
    }
    for (int c = 0; c < 3; c++)
        pairs->u[c] = load(u[c]);
}

/* The first cell's moments get the sign (-1)^|a|, and so do its local terms. */
static void load_moments(const dl_expansion *form, const dl_far_batch *batch, const double *moment,
                         far_lanes *pairs) {
    for (int side = 0; side < 2; side++)
        for (size_t k = 0; k < DL_LANES; k++) {
            const size_t at = pairs->first + (k < pairs->count ? k : 0);
            const double *from = moment + (size_t)batch->cell[side][at] * (size_t)form->terms;
            const double ratio = side ? pairs->ratio[1][k] : -pairs->ratio[0][k];
            double *const to = (double *)pairs->moment[side] + k;
            double factor = 1;
            size_t n = 0;
            for (int degree = 0; degree <= batch->order; degree++) {
                for (; n < (size_t)form->terms_to[degree]; n++)
                    to[n * DL_LANES] = factor * from[n];
                factor *= ratio;
            }
        }
}

static void add_local(const dl_expansion *form, const dl_far_batch *batch, const far_lanes *pairs,
                      double *local) {
    for (int side = 0; side < 2; side++)
        for (size_t k = 0; k < pairs->count; k++) {
            const size_t at = pairs->first + k;
            double *to = local + (size_t)batch->cell[side][at] * (size_t)form->terms;
            const double ratio = side ? pairs->ratio[1][k] : -pairs->ratio[0][k];
            const double *const from = (const double *)pairs->local[side] + k;
            double factor = 1;
            size_t n = 0;
            for (int degree = 0; degree <= batch->order; degree++) {
                for (; n < (size_t)form->terms_to[degree]; n++)
                    to[n] += factor * from[n * DL_LANES];
                factor *= ratio;
            }
        }
}

static void multiply(const dl_expansion *form, int order, far_lanes *pairs) {
    const vector *const derivative = pairs->derivative, *const moment = pairs->moment[1];
    vector *const local = pairs->local[1];
    const int terms = form->terms_to[order];
    for (int b = 0; b < terms; b++)
        local[b] = splat(0);
    for (int a = 0; a < terms; a++) {
        const unsigned short *const sum = form->sum + form->row[a];
        const int count = form->terms_to[order - form->degree[a]];
        const vector m = pairs->moment[0][a];
        vector other = splat(0);
        for (int b = 0; b < count; b++) {
            const vector d = derivative[sum[b]];
            local[b] += m * d;
            other += moment[b] * d;
        }
        pairs->local[0][a] = other;
    }
}

static void far(const dl_expansion *form, const dl_far_batch *batch, const double *moment,
                double *local) {
    far_lanes pairs;
    for (size_t first = 0; first < (size_t)batch->count; first += DL_LANES) {
        const size_t left = (size_t)batch->count - first;
        pairs.first = first;
        pairs.count = left < DL_LANES ? left : DL_LANES;
        load_pairs(form, batch, &pairs);
        find_derivatives(form, batch->order, pairs.u, pairs.radial, pairs.derivative);
        load_moments(form, batch, moment, &pairs);
        multiply(form, batch->order, &pairs);
        add_local(form, batch, &pairs, local);
    }
}

const dl_expansion_ops DL_VARIANT(dl_expansion_ops) = {
    .moments = moments,
    .far = far,
    .forces = forces,
};
