#include <math.h>
#include "force/law_taper.h"

/* x coth(x) - 1, from its series where x is small. */
static double coth_excess(double x) {
    double x2 = x * x;
    if (x2 < 0.01)
        return x2 / 3 * (1 - x2 / 15 * (1 - x2 * 2 / 21 * (1 - x2 / 10 * (1 - x2 * 10 / 99))));
    return x / tanh(x) - 1;
}

/* sinh(k u/2)/(k sinh u), whose limits are u/(2 sinh u) for k = 0 and 1/2 for u = 0. */
static double sinh_quotient(double k, double u) {
    double half = k * u / 2;
    double above = fabs(half) < 1e-4 ? 1 + half * half / 6 : sinh(half) / half;
    double below = fabs(u) < 1e-4 ? 1 + u * u / 6 : sinh(u) / u;
    return above / below / 2;
}

/* One term, any real power: G = c rho^(-k-2) sinh(k u/2)/(k sinh u), k = p - 1. */
static double discrete_real(double c, double p, double s0, double s1, double ds, double *slope) {
    double k = p - 1;
    double u = log1p(ds / s0) / 2;
    double rho2 = sqrt(s0) * sqrt(s1);
    double g = c * pow(rho2, -(k + 2) / 2) * sinh_quotient(k, u);
    if (slope) {
        double excess = fabs(u) < 1e-8 ? u * (k * k / 4 - 1) / 3
                                       : (coth_excess(k * u / 2) - coth_excess(u)) / u;
        *slope = g * (excess / (2 * s1) - (k + 2) / (4 * s1));
    }
    return g;
}

/* A constant force: G = c/(r0 + r1). */
static double discrete_constant(double c, double r0, double r1, double *slope) {
    double g = c / (r0 + r1);
    if (slope)
        *slope = -g / (2 * r1 * (r0 + r1));
    return g;
}

/* One term, whole power: with a = 1/r0, b = 1/r1, n = p - 1 and S = sum_{m<n} a^m b^(n-1-m),
 *     G = (c/n) a b S / (r0 + r1). */
static double discrete_whole(double c, int p, double s0, double s1, double *slope) {
    double r0 = sqrt(s0), r1 = sqrt(s1), a = 1 / r0, b = 1 / r1;
    if (p == 0)
        return discrete_constant(c, r0, r1, slope);
    int n = p - 1;
    double sum = 1, sum_b = 0, b_power = 1; /* S, dS/db, b^m */
    for (int m = 1; m < n; m++) {
        sum_b = a * sum_b + m * b_power;
        b_power *= b;
        sum = a * sum + b_power;
    }
    double scale = c / n * a * b / (r0 + r1);
    if (slope)
        *slope = scale * (-(sum + b * sum_b) * b * b / 2 - sum * b / (2 * (r0 + r1)));
    return scale * sum;
}

/* G = (mean of F over the path)/(r0 + r1). */
static double discrete_blend(const dl_law *law, int piece, double s0, double s1, double *slope) {
    double r0 = sqrt(s0), r1 = sqrt(s1);
    double g = dl_taper_mean_force(law, piece, r0, r1, slope) / (r0 + r1);
    if (slope)
        *slope = (*slope - g) / (2 * r1 * (r0 + r1));
    return g;
}

static double discrete_piece(const dl_law *law, int piece, double s0, double s1, double ds,
                             double *slope) {
    if (law->width[piece] > 0)
        return discrete_blend(law, piece, s0, s1, slope);
    double g = 0, one = 0;
    if (slope)
        *slope = 0;
    for (int s = 0; s < law->terms[piece]; s++) {
        double c = law->coefficient[piece][s];
        g += law->integer
                 ? discrete_whole(c, law->whole_power[piece][s], s0, s1, slope ? &one : NULL)
                 : discrete_real(c, law->power[piece][s], s0, s1, ds, slope ? &one : NULL);
        if (slope)
            *slope += one;
    }
    return g;
}

/* From s0 to s1 over pieces: each part weighs (its share of s1 - s0), in [0, 1]. The outer parts
 * may go on beyond their pieces. The last part is what the others leave of ds: measured by s1
 * itself it would have the roundoff of s1, which is large beside a short way. */
static double discrete_across(const dl_law *law, int from, int to, double s0, double s1,
                              double ds) {
    const int way = from < to ? 1 : -1;
    double begin = s0, left = fabs(ds), g = 0;
    for (int k = from;; k += way) {
        const double end = k == to ? s1 : law->until2[way > 0 ? k : k - 1];
        const double length = k == to ? fmax(left, 0) : fmin(fabs(end - begin), left);
        if (length > 0 && k < law->pieces)
            g += length / fabs(ds) * discrete_piece(law, k, begin, end, way * length, NULL);
        if (k == to)
            return g;
        left -= length;
        begin = end;
    }
}

double dl_law_discrete(const dl_law *law, double s0, double s1, double ds, double *slope) {
    return dl_law_discrete_within(law, dl_law_all(law), s0, s1, ds, slope);
}

double dl_law_discrete_within(const dl_law *law, dl_law_range range, double s0, double s1,
                              double ds, double *slope) {
    int from = dl_law_piece_within(law, range, s0), to = dl_law_piece_within(law, range, s1);
    if (from == to && from == law->pieces) {
        if (slope)
            *slope = 0;
        return 0;
    }
    if (from == to)
        return discrete_piece(law, from, s0, s1, ds, slope);
    if (ds == 0) { /* both ends on the breakpoint, to roundoff */
        if (slope)
            *slope = 0;
        return (dl_law_force_over_r_within(law, range, s0) +
                dl_law_force_over_r_within(law, range, s1)) /
               4;
    }
    double g = discrete_across(law, from, to, s0, s1, ds);
    if (slope) /* G (s1 - s0) = -(V1 - V0), differentiated by s1 */
        *slope = (dl_law_force_over_r_within(law, range, s1) / 2 - g) / ds;
    return g;
}
