/* Mean accelerations over a step from q to q + delta, one family: with any of them
 *
 *     q1 = q0 + h (v0 + v1)/2,    v1 = v0 + h a(q0, q1 - q0)
 *
 * is a time-symmetric step of order 2.
 *
 *   quotient  a pair's force is -(V(r1) - V(r0))/(s1 - s0) (d0 + d1), TR171 (2.4)
 *   Gonzalez  a(m) + c e, m = q + delta/2, with the c that makes the work right (O. Gonzalez,
 *             J. Nonlinear Sci. 6 (1996) 449, doi:10.1007/BF02440162), in the metric of the
 *             kinetic energy:  c = (V(q0) - V(q1) - a(m).delta)/(e.delta), where e is delta less
 *             the mass centre's part of it, on which V does not depend, if nothing is pinned or
 *             held; pairs that pass a jump of the force have nearly the quotient in a(m), since a
 *             jump in the middle leaves systems without a solution: with the parts p of their way
 *             in the pieces of its ends, quotient + sum p (the piece's force in the middle - its
 *             quotient), which is continuous
 *   average   the integral of a(q + x delta) over x from 0 to 1 (G.R.W. Quispel, D.I. McLaren,
 *             J. Phys. A 41 (2008) 045206, doi:10.1088/1751-8113/41/4/045206)
 *   midpoint  a(m): the implicit midpoint rule, symplectic, for comparison; at a jump its systems
 *             may have no solution (middle_gap.h)
 *
 * The first three do the work V(q0) - V(q1) exactly, through breakpoints too; the differences of V
 * are the quotients' own work, which has no cancellation. Forces along the separation in the middle
 * (quotient, midpoint) keep both momenta; the average's pairs and Gonzalez' correction keep the
 * linear one alone. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "model/private.h"

/* --- the middle ---------------------------------------------------------------------------------
 */

static double *middle_of(dl_model *model, const double *q, const double *delta) {
    double *const middle = model->priv->middle;
    for (size_t u = 0; u < model->unknowns; u++)
        middle[u] = q[u] + delta[u] / 2;
    return middle;
}

static dl_status accelerate_midpoint(dl_model *model, const double *q, const double *delta,
                                     double *a, dl_error *error) {
    return dl_model_accelerate(model, middle_of(model, q, delta), a, error);
}

void dl_pair_quotient(const dl_model *model, const dl_pair *pair, double force[3]) {
    const double g = pair->coupling * dl_law_discrete(pair->law, pair->s, pair->s1, pair->ds, NULL);
    for (int c = 0; c < model->dimension; c++)
        force[c] = g * (2 * pair->d[c] + pair->change[c]);
}

static double middle_over_sum(const dl_model *model, const dl_pair *pair, dl_law_range range) {
    const dl_pair middle = dl_pair_middle(model, pair);
    return dl_law_force_over_r_within(pair->law, range, middle.s) / 2;
}

/* By how much the middle's force of a piece, as if it were all of the law, is more than its
 * quotient; both over the sum of the separations. */
static double excess_of(const dl_model *model, const dl_pair *pair, int piece) {
    const dl_law_range alone = {piece, piece};
    return middle_over_sum(model, pair, alone) -
           dl_law_discrete_within(pair->law, alone, pair->s, pair->s1, pair->ds, NULL);
}

/* The part of the way from r0 to r1 that lies in r0's piece. */
static double part_in(const dl_law *law, int piece, int other, double r0, double r1) {
    const double edge = law->until[piece < other ? piece : piece - 1];
    return fmin(1, fmax(0, (edge - r0) / (r1 - r0)));
}

void dl_pair_gonzalez(const dl_model *model, const dl_pair *pair, double force[3]) {
    const dl_law *const law = pair->law;
    const int first = dl_law_piece(law, pair->s), last = dl_law_piece(law, pair->s1);
    double g;
    if (first == last) {
        g = middle_over_sum(model, pair, (dl_law_range){first, first});
    } else {
        const double r0 = sqrt(pair->s), r1 = sqrt(pair->s1);
        g = dl_law_discrete(law, pair->s, pair->s1, pair->ds, NULL) +
            part_in(law, first, last, r0, r1) * excess_of(model, pair, first) +
            part_in(law, last, first, r1, r0) * excess_of(model, pair, last);
    }
    for (int c = 0; c < model->dimension; c++)
        force[c] = pair->coupling * g * (2 * pair->d[c] + pair->change[c]);
}

/* Adds to accelerations [unknowns] what a force on the pair's first particle makes. */
static void add_to(const dl_model *model, const dl_pair *pair, const double force[3], double *a) {
    const double *const inverse = model->priv->inverse_inertia;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        a[c * model->moving + pair->i] += force[c] * (inverse ? inverse[pair->i] : 1);
        if (pair->j < model->moving)
            a[c * model->moving + pair->j] -= force[c] * (inverse ? inverse[pair->j] : 1);
    }
}

/* In the place of the force in the middle. */
static void take_passing(const dl_model *model, const dl_pair *pair, void *context) {
    const double middle = middle_over_sum(model, pair, dl_law_all(pair->law));
    double force[3];
    dl_pair_gonzalez(model, pair, force);
    for (int c = 0; c < model->dimension; c++)
        force[c] -= pair->coupling * middle * (2 * pair->d[c] + pair->change[c]);
    add_to(model, pair, force, context);
}

static void take_asymmetry(const dl_model *model, const dl_pair *pair, void *context) {
    double block[3][3], force[3] = {0};
    dl_block_of_quotient(model, pair, block);
    for (int r = 0; r < model->dimension; r++)
        for (int c = 0; c < model->dimension; c++)
            force[r] += (block[r][c] - block[c][r]) * pair->change[c];
    add_to(model, pair, force, context);
}

dl_status dl_model_gonzalez_asymmetry(dl_model *model, const double *q, const double *delta,
                                      double *out, dl_error *error) {
    return dl_model_visit_passing(model, q, delta, take_asymmetry, out, error);
}

void dl_model_relative(const dl_model *model, const double *u, double *out) {
    memcpy(out, u, model->unknowns * sizeof *u);
    if (!model->has_pins && !model->held)
        dl_model_rest_centre(model, out);
}

dl_status dl_model_gonzalez(dl_model *model, const double *q, const double *delta, double *middle_a,
                            double *c, double *e, dl_error *error) {
    double *const missing = model->priv->middle + model->unknowns;
    dl_status status = accelerate_midpoint(model, q, delta, middle_a, error);
    status =
        status ? status : dl_model_visit_passing(model, q, delta, take_passing, middle_a, error);
    status = status ? status : dl_model_accelerate_quotient(model, q, delta, missing, error);
    if (status)
        return status;
    for (size_t u = 0; u < model->unknowns; u++)
        missing[u] -= middle_a[u];
    const double lacks = dl_model_work(model, missing, delta);
    dl_model_relative(model, delta, e);
    const double square = dl_model_work(model, e, e);
    *c = square > 0 ? lacks / square : 0;
    return DL_OK;
}

static dl_status accelerate_gonzalez(dl_model *model, const double *q, const double *delta,
                                     double *a, dl_error *error) {
    double c, *const e = model->priv->middle;
    const dl_status status = dl_model_gonzalez(model, q, delta, a, &c, e, error);
    for (size_t u = 0; !status && u < model->unknowns; u++)
        a[u] += c * e[u];
    return status;
}

/* --- the average --------------------------------------------------------------------------------
 */

static void add_average(const dl_model *model, const dl_pair *pair, void *context) {
    double *const f = context, force[3];
    dl_law_average(pair->law, model->dimension, pair->d, pair->change, force, NULL);
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        f[c * model->particles + pair->i] += pair->coupling * force[c];
        f[c * model->particles + pair->j] -= pair->coupling * force[c];
    }
}

static dl_status accelerate_average(dl_model *model, const double *q, const double *delta,
                                    double *a, dl_error *error) {
    double *const f = model->has_pins ? model->priv->pair_force : a;
    memset(f, 0, (size_t)model->dimension * model->particles * sizeof *f);
    const dl_status status = dl_model_visit_pairs(
        model, dl_model_places(model, q), dl_model_shifts(model, delta), add_average, f, error);
    return status ? status : dl_model_finish(model, q, f, a, error);
}

/* --- derivatives --------------------------------------------------------------------------------
 */

void dl_block_of_quotient(const dl_model *model, const dl_pair *pair, double block[3][3]) {
    double slope;
    double g = pair->coupling *
               dl_law_discrete_within(pair->law, pair->range, pair->s, pair->s1, pair->ds, &slope);
    slope *= pair->coupling;
    for (int r = 0; r < model->dimension; r++)
        for (int c = 0; c < model->dimension; c++) {
            double end = pair->d[c] + pair->change[c], sum = 2 * pair->d[r] + pair->change[r];
            block[r][c] = (r == c ? g : 0) + 2 * slope * sum * end;
        }
}

void dl_block_of_average(const dl_model *model, const dl_pair *pair, double block[3][3]) {
    double force[3];
    dl_law_average(pair->law, model->dimension, pair->d, pair->change, force, block);
    for (int r = 0; r < model->dimension; r++)
        for (int c = 0; c < model->dimension; c++)
            block[r][c] *= pair->coupling;
}

/* The middle moves by half of what the end does. */
void dl_block_of_half_force(const dl_model *model, const dl_pair *pair, double block[3][3]) {
    dl_block_of_force(model, pair, block);
    for (int r = 0; r < model->dimension; r++)
        for (int c = 0; c < model->dimension; c++)
            block[r][c] /= 2;
}

/* Of a pair that passes a jump without its excess, which is small: an iteration's derivative. */
void dl_block_of_gonzalez(const dl_model *model, const dl_pair *pair, double block[3][3]) {
    if (dl_model_passes_jump(model, pair)) {
        dl_block_of_quotient(model, pair, block);
    } else {
        const dl_pair middle = dl_pair_middle(model, pair);
        dl_block_of_half_force(model, &middle, block);
    }
}

dl_mean_walk dl_model_mean_walk(dl_model *model, const double *q, const double *delta) {
    switch (model->mean) {
    case DL_MEAN_QUOTIENT:
    case DL_MEAN_AVERAGE:
        return (dl_mean_walk){model->mean == DL_MEAN_AVERAGE ? dl_block_of_average
                                                             : dl_block_of_quotient,
                              dl_model_places(model, q), dl_model_shifts(model, delta)};
    case DL_MEAN_GONZALEZ:
        if (model->priv->crossings)
            return (dl_mean_walk){dl_block_of_gonzalez, dl_model_places(model, q),
                                  dl_model_shifts(model, delta)};
        /* fall through */
    default:
        return (dl_mean_walk){dl_block_of_half_force,
                              dl_model_places(model, middle_of(model, q, delta)), NULL};
    }
}

dl_status dl_model_set_mean(dl_model *model, dl_mean mean, dl_error *error) {
    static dl_status (*const accelerations[])(dl_model *, const double *, const double *, double *,
                                              dl_error *) = {
        [DL_MEAN_QUOTIENT] = dl_model_accelerate_quotient,
        [DL_MEAN_GONZALEZ] = accelerate_gonzalez,
        [DL_MEAN_AVERAGE] = accelerate_average,
        [DL_MEAN_MIDPOINT] = accelerate_midpoint,
    };
    if (mean != DL_MEAN_MIDPOINT && model->kernel && model->kernel->stated_error > 0)
        return dl_fail(error, DL_INPUT,
                       "%s: found kernel tree, expected kernel: all-pairs in the scene: a discrete "
                       "force that conserves energy is a sum over pairs",
                       model->scene->file);
    if (mean == DL_MEAN_AVERAGE && model->locates_crossings)
        return dl_fail(error, DL_INPUT,
                       "%s: found a pair law whose crossings are located, expected none: the "
                       "average of a force along the way already ends its parts at the breakpoints",
                       model->scene->file);
    if (!model->priv->middle)
        model->priv->middle = malloc((2 * model->unknowns + 1) * sizeof(double));
    if (!model->priv->middle)
        return dl_fail_memory(error, "a mean acceleration");
    model->mean = mean;
    model->discrete_acceleration = accelerations[mean];
    return dl_model_crossings_prepare(model, error);
}
