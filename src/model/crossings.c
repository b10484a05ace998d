/* Pairs that cross a breakpoint where the force jumps.
 *
 * The mean force of such a pair is the jump times the part of its way that lies beyond the
 * breakpoint. On a short way w that part changes by all of it within w, so that the iteration
 *
 *     delta  ->  h v + (h^2/2) a(q, q + delta)
 *
 * gets steeper than any bound as w shrinks, and has a kink where the pair just does not reach the
 * breakpoint. Neither a fixed point nor Newton's method copes: the one diverges, the other goes to
 * and fro between the sides of the kink. But each pair for itself is a scalar equation, monotone
 * where the force repels, along the line from its displacement to the one its force would lead to.
 * So those pairs are solved one after the other, what the others do being given (nonlinear
 * Gauss-Seidel: J.M. Ortega, W.C. Rheinboldt, Iterative Solution of Nonlinear Equations in Several
 * Variables (1970), doi:10.1016/C2013-0-11263-9, section 7.4), with the modified regula falsi
 * called Illinois (M. Dowell, P. Jarratt, BIT 11 (1971) 168, doi:10.1007/BF01934364). */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "model/near_jumps.h"
#include "model/private.h"

typedef struct crossing {
    size_t i, j;
    const dl_law *law;
    double coupling, d[3]; /* separation at the start */
    bool rests;            /* on a breakpoint: rounding decides which piece it is in */
    double gain_i[3];      /* displacement of i for a unit force: h^2/2 over its inertia, or 0 */
    double gain_j[3];      /* the other's, the opposite way */
    bool is_twin;          /* another copy of one of them is in another crossing */
    bool crosses;          /* with the force below */
    double force[3];       /* that the image has been made with */
    bool fresh;            /* not settled since */
    double settled_at[3];  /* displacement that it was last settled at */
} crossing;

struct dl_jump_pairs {
    crossing *pair; /* [capacity] */
    size_t pairs, capacity;
    dl_near_pairs *near; /* that may become crossings */
    const double *x;     /* places at the start of the step */
    double half_square;  /* h^2/2 */
    double last;         /* by how far image and iterate were apart; at first the image's size */
    bool out_of_memory;
};

/* Sweeps over the pairs, at most: a row of particles that all cross slowly takes many, in which
 * most pairs are left alone. */
enum { most_sweeps = 200 };
/* What may be left of the distance between iterate and image, which the next iterate has less of
 * anyway; of that, what may be left of one pair's. */
static const double settled = 1e-6, solved = 0.1;
enum { most_secants = 150 };
/* More than kernels differ by in a distance. */
static const double rounding = 1e-12;

void dl_jump_pairs_free(struct dl_jump_pairs *crossings) {
    if (!crossings)
        return;
    dl_near_pairs_free(crossings->near);
    free(crossings->pair);
    free(crossings);
}

/* --- finding them -------------------------------------------------------------------------------
 */

static void set_gains(const dl_model *model, double half_square, size_t k, double gain[3]) {
    const double *const inverse = model->priv->inverse_inertia;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        const bool moves =
            k < model->moving && !(model->held && model->held[c * model->moving + k]);
        gain[c] = moves ? half_square * (inverse ? inverse[k] : 1) : 0;
    }
}

static double largest(const double values[3], int dimension) {
    double most = 0;
    for (int c = 0; c < dimension; c++)
        most = fmax(most, fabs(values[c]));
    return most;
}

/* The square of the distance that a mean looks at between the step's ends: the least one on the
 * way, that in the middle, or none. */
static double inner_square(const dl_model *model, const dl_pair *pair) {
    double along = 0, square = 0;
    if (model->mean == DL_MEAN_QUOTIENT)
        return pair->s;
    if (model->mean == DL_MEAN_GONZALEZ)
        return dl_pair_middle(model, pair).s;
    for (int c = 0; c < model->dimension; c++) {
        along -= pair->d[c] * pair->change[c];
        square += pair->change[c] * pair->change[c];
    }
    const double nearest = pair->s - along * along / square;
    return along > 0 && along < square ? nearest : fmin(pair->s, pair->s1);
}

/* Whether the pair may cross a jump: its way is known but for what the jump itself may do, twice.
 */
static bool may_cross(const dl_model *model, const dl_pair *pair, const crossing *found,
                      const dl_jumps *jumps) {
    const double gain =
        largest(found->gain_i, model->dimension) + largest(found->gain_j, model->dimension);
    const double r0 = sqrt(pair->s), r1 = sqrt(pair->s1), inner = sqrt(inner_square(model, pair));
    for (int k = 0; k < jumps->count; k++) {
        const double margin = 2 * gain * fabs(pair->coupling) * jumps->size[k];
        if (margin > 0 && fmin(fmin(r0, r1), inner) - margin <= jumps->r[k] &&
            fmax(r0, r1) + margin >= jumps->r[k])
            return true;
    }
    return false;
}

static bool is_on_jump(double r, const dl_jumps *jumps) {
    bool is_on = false;
    for (int k = 0; k < jumps->count; k++)
        is_on |= fabs(r - jumps->r[k]) <= rounding * r;
    return is_on;
}

/* Room for one more, or NULL. */
static crossing *next(struct dl_jump_pairs *crossings) {
    if (crossings->pairs == crossings->capacity) {
        const size_t room = crossings->capacity ? 2 * crossings->capacity : 64;
        crossing *const pair = realloc(crossings->pair, room * sizeof *pair);
        if (!pair)
            return NULL;
        crossings->pair = pair;
        crossings->capacity = room;
    }
    return crossings->pair ? &crossings->pair[crossings->pairs++] : NULL;
}

static void consider(const dl_model *model, const dl_pair *pair, void *context) {
    struct dl_jump_pairs *const crossings = context;
    crossing found = {.i = pair->i, .j = pair->j, .law = pair->law, .coupling = pair->coupling};
    set_gains(model, crossings->half_square, pair->i, found.gain_i);
    set_gains(model, crossings->half_square, pair->j, found.gain_j);
    const dl_jumps *const jumps = dl_near_jumps(crossings->near, pair->law);
    if (!may_cross(model, pair, &found, jumps))
        return;
    crossing *const kept = crossings->out_of_memory ? NULL : next(crossings);
    if (!kept) {
        crossings->out_of_memory = true;
        return;
    }
    memcpy(found.d, pair->d, sizeof found.d);
    found.rests = is_on_jump(sqrt(pair->s), jumps);
    if (kept > crossings->pair && kept[-1].i == found.i && kept[-1].j == found.j)
        kept[-1].is_twin = found.is_twin = true;
    *kept = found;
}

dl_status dl_model_crossings_prepare(dl_model *model, dl_error *error) {
    struct dl_model_private *const priv = model->priv;
    dl_jump_pairs_free(priv->crossings);
    priv->crossings = NULL;
    if (model->locates_crossings || !dl_model_any_jumps(model) || /* locked: nothing jumps */
        model->mean == DL_MEAN_MIDPOINT)
        return DL_OK;
    priv->crossings = calloc(1, sizeof *priv->crossings);
    if (!priv->crossings)
        return dl_fail_memory(error, "the pairs that cross a breakpoint");
    return dl_near_pairs_create(model, &priv->crossings->near, error);
}

dl_status dl_model_crossings_begin(dl_model *model, const double *q, const double *delta, double h,
                                   dl_error *error) {
    struct dl_jump_pairs *const crossings = model->priv->crossings;
    if (!crossings)
        return DL_OK;
    crossings->pairs = 0;
    crossings->x = dl_model_places(model, q);
    crossings->half_square = h * h / 2;
    crossings->last = INFINITY;
    crossings->out_of_memory = false;
    const dl_status status =
        dl_near_pairs_visit(model, crossings->near, crossings->x, dl_model_shifts(model, delta), h,
                            consider, crossings, error);
    return !status && crossings->out_of_memory
               ? dl_fail_memory(error, "the pairs that cross a breakpoint")
               : status;
}

bool dl_model_passes_jump(const dl_model *model, const dl_pair *pair) {
    const dl_jumps *const jumps = dl_near_jumps(model->priv->crossings->near, pair->law);
    const double inner = inner_square(model, pair);
    for (int k = 0; k < jumps->count; k++) {
        const double r2 = jumps->r[k] * jumps->r[k];
        const bool inside = pair->s <= r2;
        if ((pair->s1 <= r2) != inside || (inner <= r2) != inside)
            return true;
    }
    return false;
}

/* A visitor of those pairs alone. */
typedef struct passing {
    dl_pair_visitor *visit;
    void *context;
} passing;

static void visit_passing(const dl_model *model, const dl_pair *pair, void *context) {
    const passing *const those = context;
    if (dl_model_passes_jump(model, pair))
        those->visit(model, pair, those->context);
}

dl_status dl_model_visit_passing(dl_model *model, const double *q, const double *delta,
                                 dl_pair_visitor *visit, void *context, dl_error *error) {
    passing those = {visit, context};
    if (!model->priv->crossings)
        return DL_OK;
    return dl_near_pairs_visit(model, model->priv->crossings->near, dl_model_places(model, q),
                               dl_model_shifts(model, delta), 0, visit_passing, &those, error);
}

bool dl_model_crossings_any(const dl_model *model) {
    return model->priv->crossings && model->priv->crossings->pairs > 0;
}

/* --- solving them -------------------------------------------------------------------------------
 */

/* The pair with the displacement `change`. */
static dl_pair with_change(const dl_model *model, const crossing *from, const double change[3]) {
    dl_pair pair = {.i = from->i, .j = from->j, .law = from->law, .coupling = from->coupling};
    pair.range = dl_law_all(pair.law);
    for (int c = 0; c < model->dimension; c++) {
        const double end = from->d[c] + change[c];
        pair.d[c] = from->d[c];
        pair.change[c] = change[c];
        pair.s += from->d[c] * from->d[c];
        pair.s1 += end * end;
        pair.ds += change[c] * (from->d[c] + end);
    }
    return pair;
}

/* The mean force of the pair on its first particle, with the displacement `change`. */
static void force_with(const dl_model *model, const crossing *from, const double change[3],
                       double force[3]) {
    const dl_pair pair = with_change(model, from, change);
    if (model->mean == DL_MEAN_AVERAGE) {
        dl_law_average(pair.law, model->dimension, pair.d, change, force, NULL);
        for (int c = 0; c < model->dimension; c++)
            force[c] *= pair.coupling;
    } else if (model->mean == DL_MEAN_GONZALEZ) {
        dl_pair_gonzalez(model, &pair, force);
    } else {
        dl_pair_quotient(model, &pair, force);
    }
}

static void displacement(const dl_model *model, const crossing *pair, const double *delta,
                         double change[3]) {
    const size_t n = model->moving;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        change[c] = delta[c * n + pair->i] - (pair->j < n ? delta[c * n + pair->j] : 0);
}

/* A pair's line: change = start + t way; way is what its force at the start would add. */
typedef struct line {
    double start[3], way[3], force[3]; /* the force at the start */
    double square;                     /* of the way */
    double resolution;                 /* of t: less does not change the image's digits */
} line;

static void set_line(const dl_model *model, const crossing *pair, const double *image, line *of) {
    double size = 0;
    force_with(model, pair, of->start, of->force);
    of->square = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        size = fmax(size, fabs(image[c * model->moving + pair->i]));
        of->way[c] = (pair->gain_i[c] + pair->gain_j[c]) * (of->force[c] - pair->force[c]);
        of->square += of->way[c] * of->way[c];
    }
    of->resolution = DBL_EPSILON / 2 * size / sqrt(of->square);
}

/* What the force at t would still add, along the way: its square at t = 0, and 0 at the solution.
 */
static double left_at(const dl_model *model, const crossing *pair, const line *of, double t) {
    double change[3], force[3], left = 0;
    for (int c = 0; c < model->dimension; c++)
        change[c] = of->start[c] + t * of->way[c];
    force_with(model, pair, change, force);
    for (int c = 0; c < model->dimension; c++) {
        const double gain = pair->gain_i[c] + pair->gain_j[c];
        left += ((1 - t) * of->way[c] + gain * (force[c] - of->force[c])) * of->way[c];
    }
    return left;
}

/* A root between low and high, where what is left is positive and negative. */
typedef struct bracket {
    double low, high, left_low, left_high;
    bool was_high; /* the last point has become `high` */
} bracket;

static void narrow(bracket *of, double t, double left) {
    const bool is_high = left < 0;
    if (is_high) {
        of->high = t;
        of->left_high = left;
        of->left_low /= of->was_high ? 2 : 1; /* Illinois: the end that stays counts half */
    } else {
        of->low = t;
        of->left_low = left;
        of->left_high /= of->was_high ? 1 : 2;
    }
    of->was_high = is_high;
}

/* Where on the line the solution is: between 0 and 1 where the iteration is monotone, else 1, which
 * is what a plain iteration takes. It is looked for near where the pair was last settled, to a part
 * of the length `least`. */
static double solve_line(const dl_model *model, const crossing *pair, const line *of,
                         double least) {
    const double enough = solved * least * sqrt(of->square);
    bracket b = {0, 1, of->square, left_at(model, pair, of, 1), true};
    double t = 1, along = 0;
    for (int c = 0; c < model->dimension; c++)
        along += (pair->settled_at[c] - of->start[c]) * of->way[c];
    for (int k = 0; k < most_secants && b.left_high < -enough && b.high - b.low > of->resolution;
         k++) {
        t = (b.low * b.left_high - b.high * b.left_low) / (b.left_high - b.left_low);
        if (k == 0)
            t = along / of->square;
        if (k % 3 == 2 || !(t > b.low && t < b.high)) /* secants are slow where the force steps */
            t = (b.low + b.high) / 2;
        const double left = left_at(model, pair, of, t);
        if (fabs(left) <= enough)
            return t;
        narrow(&b, t, left);
    }
    return t;
}

/* Gives the pair more force in the image and the accelerations it was made with. */
static void add_force(const dl_model *model, crossing *pair, double half_square,
                      const double more[3], double *image, double *a) {
    const size_t n = model->moving;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        image[c * n + pair->i] += pair->gain_i[c] * more[c];
        a[c * n + pair->i] += pair->gain_i[c] / half_square * more[c];
        if (pair->j >= n)
            continue;
        image[c * n + pair->j] -= pair->gain_j[c] * more[c];
        a[c * n + pair->j] -= pair->gain_j[c] / half_square * more[c];
    }
}

/* Turns the force that the pair has in the image into the line of its mean separation. Of a pair
 * that rests on the breakpoint rounding decides how large a force it has, and the line's own
 * solution would leave it askew. */
static void turn(const dl_model *model, crossing *pair, double half_square, const double change[3],
                 double *image, double *a) {
    double along = 0, square = 0, more[3];
    for (int c = 0; c < model->dimension; c++) {
        const double sum = 2 * pair->d[c] + change[c];
        along += pair->force[c] * sum;
        square += sum * sum;
    }
    for (int c = 0; c < model->dimension; c++) {
        more[c] = along / square * (2 * pair->d[c] + change[c]) - pair->force[c];
        pair->force[c] += more[c];
    }
    add_force(model, pair, half_square, more, image, a);
}

static bool crosses_with(const dl_model *model, const crossing *from, const double change[3]) {
    const dl_pair pair = with_change(model, from, change);
    return dl_model_passes_jump(model, &pair);
}

static double farthest(const double a[3], const double b[3], int dimension) {
    double most = 0;
    for (int c = 0; c < dimension; c++)
        most = fmax(most, fabs(a[c] - b[c]));
    return most;
}

/* Solves for one pair, unless its particles have moved less than `least` since it was; returns how
 * far it moves. */
static double settle_pair(const dl_model *model, crossing *pair, double half_square, double least,
                          double *image, double *a) {
    line of;
    displacement(model, pair, image, of.start);
    const bool crosses = crosses_with(model, pair, of.start);
    if ((!crosses && !pair->crosses) ||
        (!pair->fresh && farthest(of.start, pair->settled_at, model->dimension) <= least))
        return 0;
    pair->fresh = false;
    if (model->mean != DL_MEAN_AVERAGE) { /* whose force turns with the part of the way inside */
        turn(model, pair, half_square, of.start, image, a);
        displacement(model, pair, image, of.start);
    }
    set_line(model, pair, image, &of);
    const bool moves = of.resolution < 1; /* else there is nothing to add, or not a number */
    const double t = moves ? solve_line(model, pair, &of, least) : 0;
    double more[3] = {0};
    for (int c = 0; c < model->dimension && moves; c++) {
        more[c] = t * (of.force[c] - pair->force[c]);
        pair->force[c] += more[c];
    }
    for (int c = 0; c < model->dimension; c++)
        pair->settled_at[c] = of.start[c] + t * of.way[c];
    if (!moves)
        return 0;
    pair->crosses = true;
    add_force(model, pair, half_square, more, image, a);
    return t * sqrt(of.square);
}

/* What the image has been made with. On a breakpoint the force depends on the last bit of a squared
 * distance, and the loops of the kernel round theirs in their own way. */
static void take_force(dl_model *model, const double *shifts, crossing *pair) {
    if (model->mean == DL_MEAN_QUOTIENT && !pair->is_twin)
        model->kernel->ops->pair(model->kernel, model->priv->crossings->x, shifts, pair->i, pair->j,
                                 pair->force);
    else
        force_with(model, pair, pair->settled_at, pair->force);
}

static void forget(dl_model *model, const double *delta, const double *shifts, crossing *pair) {
    displacement(model, pair, delta, pair->settled_at);
    take_force(model, shifts, pair);
    pair->crosses = pair->rests || crosses_with(model, pair, pair->settled_at);
    pair->fresh = true;
}

/* The pairs' largest component of `image`, or of its distance from `from`. */
static double largest_among(const dl_model *model, const struct dl_jump_pairs *crossings,
                            const double *image, const double *from) {
    double most = 0;
    for (size_t k = 0; k < crossings->pairs; k++)
        for (size_t c = 0; c < (size_t)model->dimension; c++) {
            const size_t u = c * model->moving + crossings->pair[k].i;
            const double size = fabs(image[u] - (from ? from[u] : 0));
            most = size > most ? size : most;
        }
    return most;
}

static double sweep(const dl_model *model, struct dl_jump_pairs *crossings, double least,
                    double *image, double *a) {
    double most = 0;
    for (size_t k = 0; k < crossings->pairs; k++) {
        const double moved =
            settle_pair(model, &crossings->pair[k], crossings->half_square, least, image, a);
        most = moved > most ? moved : most;
    }
    return most;
}

void dl_model_crossings_settle(dl_model *model, const double *delta, double *image, double *a) {
    struct dl_jump_pairs *const crossings = model->priv->crossings;
    if (!dl_model_crossings_any(model))
        return;
    const double *const shifts = dl_model_shifts(model, delta);
    for (size_t k = 0; k < crossings->pairs; k++)
        forget(model, delta, shifts, &crossings->pair[k]);
    const double size = largest_among(model, crossings, image, NULL);
    const double least = fmax(settled * fmin(crossings->last, size), DBL_EPSILON / 2 * size);
    double most = INFINITY;
    for (int k = 0; k < most_sweeps && most > least; k++)
        most = sweep(model, crossings, least, image, a);
    crossings->last = largest_among(model, crossings, image, delta);
}
