/* The way of one coordinate over one step, as its distance from a wall, or of a pair, as the square
 * of its distance less that of a breakpoint: a polynomial in Bernstein's form,
 *
 *     d(s) = sum_i b_i C(n,i) s^i (1-s)^(n-i),    s = (t - t0)/h in [0, 1].
 *
 * It lies between the least and the largest b_i, so that a path whose b_i are all >= 0 misses
 * nothing; halving the interval tightens that bound as far as is needed. */
#ifndef DL_STUDY_PATH_H
#define DL_STUDY_PATH_H

enum {
    dl_dense_degree = 12, /* of CVODE's Adams methods */
    dl_path_degree = 2 * dl_dense_degree
};

typedef struct dl_path {
    int degree;
    double b[dl_path_degree + 1];
} dl_path;

/* A coordinate with its first two derivatives, at one time. */
typedef struct dl_path_end {
    double d, rate, curvature;
} dl_path_end;

/* Quintic Hermite: the polynomial of degree 5 through both ends of a step of length h. */
void dl_path_hermite(dl_path *path, double h, dl_path_end start, dl_path_end end);

/* The polynomial of that degree with the derivatives derivative[0 ... degree] at the end of the
 * step. A multistep method's meets the step's start but for its own error; the path is made to
 * begin at `start`, with its rate, and with its curvature (NaN: not known) where it begins on the
 * wall at rest. Returned is by how much that moves it, at most. */
double dl_path_taylor(dl_path *path, double h, int degree, const double *derivative,
                      dl_path_end start);

/* sum += path^2; `sum` has twice the degree of `path`, or has nothing yet, degree 0 and b_0. */
void dl_path_add_square(dl_path *sum, const dl_path *path);

double dl_path_value(const dl_path *path, double s);

/* Its part up to s, as a path of its own. */
void dl_path_cut(dl_path *path, double s);

/* The first s in [0, 1] from which on the path is negative, to roundoff; INFINITY where it never
 * gets below -roundoff, that of its values. A path that begins at 0, to that roundoff, leaves at
 * once, s = 0, only where it descends from there: a particle that has just bounced off the wall
 * does not hit it again. */
double dl_path_first_exit(const dl_path *path, double roundoff);

#endif
