/* First roots by Bernstein's form: the polynomial lies between its least and its largest
 * coefficient there, and has no more roots in (0, 1) than these have changes of sign. Halving
 * tightens both. */
#include "reference/extended/walk.h"

typedef struct bernstein {
    int degree;
    real b[polynomial_degree + 1];
} bernstein;

real polynomial_value(const real *c, int degree, real tau) {
    real sum = 0;
    for (int k = degree; k >= 0; k--)
        sum = sum * tau + c[k];
    return sum;
}

static real slope_at(const real *c, int degree, real tau) {
    real sum = 0;
    for (int k = degree; k >= 1; k--)
        sum = sum * tau + k * c[k];
    return sum;
}

/* b_i = sum_k C(i,k)/C(n,k) c_k: no weight is above 1. */
static void to_bernstein(const real *c, int degree, real shift, bernstein *made) {
    made->degree = degree;
    for (int i = 0; i <= degree; i++) {
        real sum = shift, ratio = 1;
        for (int k = 0; k <= i; k++) {
            sum += ratio * c[k];
            if (k < degree)
                ratio *= (real)(i - k) / (degree - k);
        }
        made->b[i] = sum;
    }
}

/* `of` becomes its own right half. */
static void halve(bernstein *of, bernstein *left) {
    left->degree = of->degree;
    for (int level = of->degree; level >= 0; level--) {
        left->b[of->degree - level] = of->b[0];
        for (int i = 0; i < level; i++)
            of->b[i] = (of->b[i] + of->b[i + 1]) / 2;
    }
}

static int sign_changes(const bernstein *of) {
    int changes = 0;
    bool last = false;
    for (int i = 0; i <= of->degree; i++) {
        if (of->b[i] == 0)
            continue;
        changes += (of->b[i] < 0) != last;
        last = of->b[i] < 0;
    }
    return changes;
}

/* c + shift goes from positive to negative in [low, high], once: where, by Newton's method kept
 * inside the bracket. */
static real only_root(const real *c, int degree, real shift, real low, real high) {
    real tau = low + (high - low) / 2;
    for (int i = 0; i < 300; i++) {
        const real value = polynomial_value(c, degree, tau) + shift;
        if (value < 0)
            high = tau;
        else
            low = tau;
        const real newton = tau - value / slope_at(c, degree, tau);
        const real next = newton > low && newton < high ? newton : low + (high - low) / 2;
        if (next <= low || next >= high || real_abs(next - tau) <= REAL_EPSILON * tau / 2)
            return next;
        tau = next;
    }
    return high;
}

/* On [low, low + width]; 2: none. Below the last level it touches 0 and no more can be told. */
static real first_root(const real *c, real shift, bernstein *of, real low, real width) {
    if (of->b[0] < 0)
        return low;
    const int changes = sign_changes(of);
    if (changes == 0 || width < 16 * REAL_EPSILON)
        return 2;
    if (changes == 1)
        return only_root(c, of->degree, shift, low, low + width);
    bernstein left;
    halve(of, &left);
    const real first = first_root(c, shift, &left, low, width / 2);
    return first <= 1 ? first : first_root(c, shift, of, low + width / 2, width / 2);
}

/* From where c is -tolerance to where it is 0, if that is near. */
static real polish(const real *c, int degree, real tau) {
    for (int i = 0; i < 2; i++) {
        const real slope = slope_at(c, degree, tau), value = polynomial_value(c, degree, tau);
        const real next = tau - value / slope;
        if (!(slope < 0) || !(next >= 0) || next > tau)
            return tau;
        tau = next;
    }
    return tau;
}

real polynomial_exit(const real *c, int degree, real tolerance, real *latest) {
    real least = c[0];
    bernstein shifted = {.degree = degree};
    *latest = 2;
    for (int k = 1; k <= degree; k++)
        least -= real_abs(c[k]);
    if (least >= -tolerance)
        return 2;
    to_bernstein(c, degree, tolerance, &shifted);
    *latest = first_root(c, tolerance, &shifted, 0, 1);
    return *latest > 1 ? 2 : polish(c, degree, *latest);
}
