#include "force/law.h"

#include <math.h>
#include <string.h>
#include "force/law_taper.h"

/* The way d + x change, 0 <= x <= 1. */
typedef struct way {
    const dl_law *law;
    int dimension;
    const double *d, *change;
    double start2, along, length2; /* d.d, d.change, change.change */
    double *force;                 /* [dimension], added to */
    double (*block)[3];            /* added to; NULL: not wanted */
} way;

static void place(const way *w, double x, double at[3]) {
    for (int c = 0; c < w->dimension; c++)
        at[c] = w->d[c] + x * w->change[c];
}

static double square_at(const way *w, double x) {
    return w->start2 + x * (2 * w->along + x * w->length2);
}

/* --- a part without a breakpoint ----------------------------------------------------------------
 */

static void add_point(const way *w, double x, double weight) {
    double at[3];
    place(w, x, at);
    const double s = square_at(w, x), over_r = dl_law_force_over_r(w->law, s);
    for (int c = 0; c < w->dimension; c++)
        w->force[c] += weight * over_r * at[c];
    if (!w->block)
        return;
    const double slope = dl_law_force_slope(w->law, s);
    for (int r = 0; r < w->dimension; r++)
        for (int c = 0; c < w->dimension; c++)
            w->block[r][c] += weight * x * ((r == c ? over_r : 0) + slope * at[r] * at[c]);
}

static void add_panel(const way *w, double begin, double end) {
    const double centre = (begin + end) / 2, half = (end - begin) / 2;
    for (int n = 0; n < dl_gauss_points; n++) {
        const double zero = n % 2 ? dl_gauss_zero[n / 2] : -dl_gauss_zero[n / 2];
        add_point(w, centre + half * zero, dl_gauss_weight[n / 2] * (end - begin));
    }
}

static double largest_power(const dl_law *law, int piece) {
    double largest = 0;
    for (int s = 0; s < law->terms[piece] + law->next_terms[piece]; s++)
        largest = fmax(largest, law->power[piece][s]);
    return largest;
}

/* The integrand is singular where r = 0, at complex x whose distance from the real one x is
 * r(x)/|change|: the panels are short beside that. */
static void add_part(const way *w, double begin, double end) {
    const int piece = dl_law_piece(w->law, square_at(w, (begin + end) / 2));
    if (piece == w->law->pieces)
        return;
    const double panel = dl_taper_panel(largest_power(w->law, piece));
    const double ratio = (panel - 1) / (panel + 1), length = sqrt(w->length2);
    const double shortest = 1e-6 * (end - begin); /* where particles meet nothing is exact */
    for (double x = begin; x < end;) {
        double width = end - x;
        while (width > shortest && width / 2 * length > ratio * sqrt(square_at(w, x + width / 2)))
            width /= 2;
        const double to = width < end - x ? x + width : end;
        add_panel(w, x, to);
        x = to;
    }
}

/* --- breakpoints --------------------------------------------------------------------------------
 */

enum { most_cuts = 2 * dl_law_pieces };

/* Where the way is at that squared distance: none, one or two x in (0, 1). */
static int find_cuts(const way *w, double square, double *x) {
    const double gap = w->start2 - square;
    const double under = w->along * w->along - w->length2 * gap;
    int count = 0;
    if (!(under > 0))
        return 0;
    const double sum = -(w->along + copysign(sqrt(under), w->along)); /* without cancellation */
    const double root[2] = {sum / w->length2, gap / sum};
    for (int k = 0; k < 2; k++)
        if (root[k] > 0 && root[k] < 1)
            x[count++] = root[k];
    return count;
}

/* What the cut at x moves by when the end does: the force before it less that after it. */
static void add_motion(const way *w, double x, double before, double after) {
    double at[3], towards = 0;
    if (!w->block || before == after)
        return;
    place(w, x, at);
    for (int c = 0; c < w->dimension; c++)
        towards += at[c] * w->change[c];
    for (int r = 0; r < w->dimension; r++)
        for (int c = 0; c < w->dimension; c++)
            w->block[r][c] -= (before - after) * x * at[r] * at[c] / towards;
}

static void sort(double *x, int count) {
    for (int i = 1; i < count; i++)
        for (int j = i; j > 0 && x[j] < x[j - 1]; j--) {
            const double swap = x[j];
            x[j] = x[j - 1];
            x[j - 1] = swap;
        }
}

static double over_r_in_part(const way *w, double begin, double end, double at) {
    const int piece = dl_law_piece(w->law, square_at(w, (begin + end) / 2));
    return dl_law_force_over_r_in(w->law, piece, sqrt(square_at(w, at)));
}

static void add_parts(const way *w, const double *cut, int cuts) {
    for (int k = 0; k <= cuts; k++) {
        const double begin = k ? cut[k - 1] : 0, end = k < cuts ? cut[k] : 1;
        add_part(w, begin, end);
        if (k < cuts)
            add_motion(w, end, over_r_in_part(w, begin, end, end),
                       over_r_in_part(w, end, k + 1 < cuts ? cut[k + 1] : 1, end));
    }
}

void dl_law_average(const dl_law *law, int dimension, const double *d, const double *change,
                    double *force, double (*block)[3]) {
    way w = {law, dimension, d, change, 0, 0, 0, force, block};
    double cut[most_cuts];
    int cuts = 0;
    for (int c = 0; c < dimension; c++) {
        w.start2 += d[c] * d[c];
        w.along += d[c] * change[c];
        w.length2 += change[c] * change[c];
    }
    memset(force, 0, (size_t)dimension * sizeof *force);
    if (block)
        memset(block, 0, 3 * sizeof *block);
    for (int k = 0; k < law->pieces; k++)
        if (isfinite(law->until2[k]))
            cuts += find_cuts(&w, law->until2[k], cut + cuts);
    sort(cut, cuts);
    add_parts(&w, cut, cuts);
}
