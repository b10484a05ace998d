/* Summation that keeps what it rounds off: N. J. Higham, Accuracy and Stability of Numerical
 * Algorithms, 2nd ed. (2002), doi:10.1137/1.9780898718027, section 4.3; for integrators E. Hairer,
 * C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed. (2006),
 * doi:10.1007/3-540-30666-8, section VIII.5. */
#ifndef DL_METHODS_COMPENSATED_H
#define DL_METHODS_COMPENSATED_H

/* sum + lost grows by `term`; `lost` is what does not fit into `sum`. */
static inline void dl_compensated_add(double *sum, double *lost, double term) {
    const double before = *sum;
    *lost += term;
    *sum = before + *lost;
    *lost += before - *sum;
}

#endif
