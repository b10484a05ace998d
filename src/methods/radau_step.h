/* One step of Everhart's Gauss-Radau method as a polynomial. With s = (t - t0)/h in [0, 1],
 *
 *     a(s) = a_0 + b_0 s + b_1 s^2 + ... + b_6 s^7
 *
 * agrees with the acceleration at the eight nodes s_0 = 0, s_1 ... s_7 of Radau's quadrature, whose
 * weights give the velocity at s = 1 with an error of order 15. Its integrals are the velocities
 * and the positions within the step.
 *
 * E. Everhart, in Dynamics of Comets: Their Origin and Evolution (1985) 185,
 * doi:10.1007/978-94-009-5400-7_17; H. Rein, D. S. Spiegel, Mon. Not. R. Astron. Soc. 446 (2015)
 * 1424, doi:10.1093/mnras/stu2164. */
#ifndef DL_METHODS_RADAU_STEP_H
#define DL_METHODS_RADAU_STEP_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

enum { dl_radau_terms = 7 };

/* What the nodes make. */
typedef struct dl_radau_tables {
    /* prod_{j<i} (s - s_j) by its value at s_i: coefficients of s^1 ... s^i */
    double newton[dl_radau_terms + 1][dl_radau_terms];
    /* s_i^(k+1) / ((k + 2)(k + 3)) */
    double position[dl_radau_terms + 1][dl_radau_terms];
} dl_radau_tables;

typedef struct dl_radau_step {
    size_t n;
    const dl_radau_tables *tables;
    double h;
    bool smooth;                   /* the polynomial may be continued: it tells of the next step */
    double *q, *v;                 /* at the start, [n] each */
    double *a;                     /* a_0, [n] */
    double *b[dl_radau_terms];     /* [n] each */
    double *guess[dl_radau_terms]; /* the b before the first correction, [n] each */
} dl_radau_step;

void dl_radau_tables_set(dl_radau_tables *tables);

dl_status dl_radau_step_create(dl_radau_step *step, const dl_radau_tables *tables, size_t n,
                               dl_error *error);
void dl_radau_step_free(dl_radau_step *step);

/* step->b for a step of length h that follows `last`: its polynomial, and what it was itself wrong
 * by where the steps are about as long. Nothing known (last->h = 0): 0. */
void dl_radau_predict(dl_radau_step *step, const dl_radau_step *last, double h);

/* q at node i into place [n]; `lost` [n] is what the positions at the start have rounded off. */
void dl_radau_place(const dl_radau_step *step, const double *lost, int i, double *place);

/* Makes the polynomial agree with the acceleration a [n] at node i >= 1, as it does already at the
 * nodes before. Returns the largest component it was wrong by. */
double dl_radau_correct(dl_radau_step *step, int i, const double *a);

/* v and q at the end less those at the start, of component u. */
long double dl_radau_velocity_change(const dl_radau_step *step, size_t u);
long double dl_radau_position_change(const dl_radau_step *step, double lost, size_t u);

/* k-th derivative by time of q | v at s into y [2 n]. */
void dl_radau_derivative(const dl_radau_step *step, double s, int k, double *y);

#endif
