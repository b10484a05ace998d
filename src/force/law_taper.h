/* A taper: over the width w before a breakpoint b the force A of a piece fades into the force B of
 * the next, so that F has two continuous derivatives,
 *
 *     F = S A + (1 - S) B,   S = v^3 (10 - 15 v + 6 v^2),   v = (b - r)/w,
 *
 * which is 1 - 10 u^3 + 15 u^4 - 6 u^5 with u = 1 - v. Expanded about r = 0, F would be a sum of
 * powers too, but one that loses a factor (b/w)^5 by cancellation. So S is evaluated as it stands,
 * and work is the integral of F by Gauss's rule of dl_gauss_points points, which is exact for S and
 * exact to roundoff for S times a power over a panel, a range of r whose ends are not farther apart
 * than a factor that falls with the power. */
#ifndef DL_FORCE_LAW_TAPER_H
#define DL_FORCE_LAW_TAPER_H

#include "force/law.h"

enum { dl_gauss_points = 12 };

/* Zeros of Legendre's polynomial of that degree on the positive half of [-1, 1], and the weights of
 * both halves, which add up to 1. */
extern const double dl_gauss_zero[dl_gauss_points / 2];
extern const double dl_gauss_weight[dl_gauss_points / 2];

/* Largest ratio of a panel's ends where `power` is the largest. */
double dl_taper_panel(double power);

/* F(r)/r and (1/r) d(F/r)/dr within the blend. */
double dl_taper_force_over_r(const dl_law *law, int piece, double r);
double dl_taper_force_slope(const dl_law *law, int piece, double r);

/* Mean of F over [r0, r1], both within the blend and in any order: with r = r0 + theta (r1 - r0),
 * the integral of F over theta from 0 to 1. *slope (NULL: not wanted) is its derivative by r1, the
 * integral of theta F'. */
double dl_taper_mean_force(const dl_law *law, int piece, double r0, double r1, double *slope);

#endif
