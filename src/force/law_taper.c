#include "force/law_taper.h"

#include <math.h>

const double dl_gauss_zero[] = {
    0.1252334085114689154724, 0.3678314989981801937527, 0.5873179542866174472967,
    0.7699026741943046870369, 0.9041172563704748566785, 0.9815606342467192506905,
};
const double dl_gauss_weight[] = {
    0.2491470458134027850006 / 2, 0.2334925365383548087608 / 2, 0.2031674267230659217491 / 2,
    0.1600783285433462263347 / 2, 0.1069393259953184309603 / 2, 0.04717533638651182719462 / 2,
};

/* With h and c half the length and the centre of a panel, r^-p is a series in h/c whose terms grow
 * with p; the rule leaves out those beyond (h/c)^24. With h/c below this they are below roundoff
 * for every power a scene can have. */
double dl_taper_panel(double power) {
    double ratio = 1 / (3 + power / 3);
    return (1 + ratio) / (1 - ratio);
}

static double fade(const dl_law *law, int piece, double r) {
    double v = fmin(fmax((law->until[piece] - r) / law->width[piece], 0), 1);
    return v * v * v * (10 + v * (6 * v - 15));
}

static double fade_slope(const dl_law *law, int piece, double r) {
    double v = fmin(fmax((law->until[piece] - r) / law->width[piece], 0), 1);
    double product = v * (1 - v);
    return -30 * product * product / law->width[piece];
}

/* A r^-more and B r^-more. */
static double fading(const dl_law *law, int piece, double r, int more) {
    return dl_law_sum(law, piece, 0, law->terms[piece], r, more);
}

static double rising(const dl_law *law, int piece, double r, int more) {
    return dl_law_sum(law, piece, law->terms[piece], law->next_terms[piece], r, more);
}

static double blend(const dl_law *law, int piece, double r, int more) {
    double s = fade(law, piece, r);
    return s * fading(law, piece, r, more) + (1 - s) * rising(law, piece, r, more);
}

double dl_taper_force_over_r(const dl_law *law, int piece, double r) {
    return blend(law, piece, r, 1);
}

double dl_taper_force_slope(const dl_law *law, int piece, double r) {
    int terms = law->terms[piece];
    double s = fade(law, piece, r), ds = fade_slope(law, piece, r);
    return s * dl_law_sum_slope(law, piece, 0, terms, r) +
           (1 - s) * dl_law_sum_slope(law, piece, terms, law->next_terms[piece], r) +
           ds * (fading(law, piece, r, 2) - rising(law, piece, r, 2));
}

/* F'(r) = r ((1/r) d(F/r)/dr) r + F/r. */
static double force_derivative(const dl_law *law, int piece, double r) {
    return dl_taper_force_slope(law, piece, r) * r * r + blend(law, piece, r, 1);
}

static int panels_between(double r0, double r1, double panel) {
    double near = fmin(r0, r1), far = fmax(r0, r1);
    return far > near * panel ? (int)ceil(log(far / near) / log(panel)) : 1;
}

double dl_taper_mean_force(const dl_law *law, int piece, double r0, double r1, double *slope) {
    int panels = panels_between(r0, r1, law->panel[piece]);
    double step = panels > 1 ? pow(r1 / r0, 1.0 / panels) : 1;
    double length = r1 - r0, begin = 0, mean = 0, moment = 0;
    for (int k = 1; k <= panels; k++) { /* theta from begin to end: a panel */
        double end = k < panels ? r0 * (pow(step, k) - 1) / length : 1;
        double centre = (begin + end) / 2, half = (end - begin) / 2;
        for (int n = 0; n < dl_gauss_points; n++) {
            double zero = n % 2 ? dl_gauss_zero[n / 2] : -dl_gauss_zero[n / 2];
            double weight = dl_gauss_weight[n / 2] * (end - begin);
            double theta = centre + half * zero, r = r0 + theta * length;
            mean += weight * blend(law, piece, r, 0);
            if (slope)
                moment += weight * theta * force_derivative(law, piece, r);
        }
        begin = end;
    }
    if (slope)
        *slope = moment;
    return mean;
}
