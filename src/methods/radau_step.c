#include "methods/radau_step.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Roots of P_7(2 s - 1) + P_8(2 s - 1), P_n the polynomials of Legendre, to 60 digits. */
static const double node[dl_radau_terms + 1] = {
    0,
    0.056262560536922146465652191032311,
    0.18024069173689236498757994280918,
    0.35262471711316963737390777017124,
    0.54715362633055538300144855765235,
    0.73421017721541053152321060830661,
    0.88532094683909576809035976293249,
    0.97752061356128750189117450042915,
};

void dl_radau_tables_set(dl_radau_tables *tables) {
    long double product[dl_radau_terms + 2] = {1}; /* coefficients of prod_{j<i} (s - s_j) */
    for (int i = 0; i <= dl_radau_terms; i++) {
        const long double s = (long double)node[i];
        long double value = 1, power = 1;
        for (int j = 0; j < i; j++)
            value *= s - (long double)node[j];
        for (int k = 0; k < dl_radau_terms; k++) {
            power *= s;
            tables->newton[i][k] = k < i ? (double)(product[k + 1] / value) : 0;
            tables->position[i][k] = (double)(power / ((k + 2) * (k + 3)));
        }
        for (int k = i + 1; k > 0; k--)
            product[k] = product[k - 1] - s * product[k];
        product[0] *= -s;
    }
}

/* --- memory -------------------------------------------------------------------------------------
 */

dl_status dl_radau_step_create(dl_radau_step *step, const dl_radau_tables *tables, size_t n,
                               dl_error *error) {
    const size_t arrays = 3 + 2 * dl_radau_terms;
    double *const block = calloc(arrays * n + 1, sizeof *block);
    if (!block)
        return dl_fail_memory(error, "a Gauss-Radau step");
    step->n = n;
    step->tables = tables;
    step->h = 0;
    step->smooth = false;
    step->q = block;
    step->v = block + n;
    step->a = block + 2 * n;
    for (size_t k = 0; k < dl_radau_terms; k++) {
        step->b[k] = block + (3 + k) * n;
        step->guess[k] = block + (3 + dl_radau_terms + k) * n;
    }
    return DL_OK;
}

void dl_radau_step_free(dl_radau_step *step) {
    free(step->q);
    step->q = NULL;
}

/* --- the polynomial in its nodes ----------------------------------------------------------------
 */

/* Steps longer than this many times the last begin with nothing known: what the last terms of its
 * polynomial would become is roundoff multiplied. */
static const double longest_ratio = 10;

void dl_radau_predict(dl_radau_step *step, const dl_radau_step *last, double h) {
    const size_t n = step->n;
    step->h = h;
    if (!last->smooth || h > longest_ratio * last->h) {
        for (int k = 0; k < dl_radau_terms; k++) {
            memset(step->b[k], 0, n * sizeof(double));
            memset(step->guess[k], 0, n * sizeof(double));
        }
        return;
    }
    /* a(1 + ratio s): the coefficient of s^(k+1) is ratio^(k+1) sum_j C(j+1, k+1) b_j */
    const double ratio = h / last->h;
    const double repeated = ratio > 0.5 && ratio < 2 ? 1 : 0;
    double power = 1;
    for (int k = 0; k < dl_radau_terms; k++) {
        power *= ratio;
        double factor[dl_radau_terms] = {0};
        double binomial = 1;
        for (int j = k; j < dl_radau_terms; j++) {
            factor[j] = power * binomial;
            binomial *= (double)(j + 2) / (double)(j + 1 - k);
        }
        for (size_t u = 0; u < n; u++) {
            double sum = 0;
            for (int j = dl_radau_terms - 1; j >= k; j--)
                sum += factor[j] * last->b[j][u];
            step->guess[k][u] = sum;
            step->b[k][u] = sum + repeated * (last->b[k][u] - last->guess[k][u]);
        }
    }
}

void dl_radau_place(const dl_radau_step *step, const double *lost, int i, double *place) {
    const double h = node[i] * step->h;
    const double *const factor = step->tables->position[i];
    double *const *const b = step->b;
    for (size_t u = 0; u < step->n; u++) {
        double sum = 0;
        for (int k = dl_radau_terms - 1; k >= 0; k--)
            sum += factor[k] * b[k][u];
        place[u] = step->q[u] + (lost[u] + h * (step->v[u] + h * (step->a[u] / 2 + sum)));
    }
}

double dl_radau_correct(dl_radau_step *step, int i, const double *a) {
    const double s = node[i], *const factor = step->tables->newton[i];
    double *const *const b = step->b;
    double largest = 0;
    for (size_t u = 0; u < step->n; u++) {
        double value = 0;
        for (int k = dl_radau_terms - 1; k >= 0; k--)
            value = (value + b[k][u]) * s;
        const double wrong = (a[u] - step->a[u]) - value;
        for (int k = 0; k < i; k++)
            b[k][u] += factor[k] * wrong;
        largest = fmax(largest, fabs(wrong));
    }
    return largest;
}

/* --- its integrals ------------------------------------------------------------------------------
 */

/* Quotients rather than rounded reciprocals: their roundoff is not the same in every step. */

long double dl_radau_velocity_change(const dl_radau_step *step, size_t u) {
    long double sum = 0;
    for (int k = dl_radau_terms - 1; k >= 0; k--)
        sum += (long double)step->b[k][u] / (k + 2);
    return (long double)step->h * ((long double)step->a[u] + sum);
}

long double dl_radau_position_change(const dl_radau_step *step, double lost, size_t u) {
    const long double h = (long double)step->h;
    long double sum = 0;
    for (int k = dl_radau_terms - 1; k >= 0; k--)
        sum += (long double)step->b[k][u] / ((k + 2) * (k + 3));
    sum += (long double)step->a[u] / 2;
    return h * ((long double)step->v[u] + ((long double)lost + h * sum));
}

/* sum_j of coefficient j times the k-th derivative of s^j. */
static double derivative(const double *coefficient, int degree, double s, int k) {
    double sum = 0;
    for (int j = degree; j >= k; j--) {
        double factor = 1;
        for (int l = 0; l < k; l++)
            factor *= j - l;
        sum = sum * s + factor * coefficient[j];
    }
    return sum;
}

void dl_radau_derivative(const dl_radau_step *step, double s, int k, double *y) {
    const double h = step->h, scale = pow(h, -k);
    for (size_t u = 0; u < step->n; u++) {
        double v[dl_radau_terms + 2] = {step->v[u], h * step->a[u]};
        double q[dl_radau_terms + 3] = {step->q[u], h * step->v[u], h * (h * step->a[u]) / 2};
        for (int j = 0; j < dl_radau_terms; j++) {
            v[j + 2] = h * step->b[j][u] / (j + 2);
            q[j + 3] = h * v[j + 2] / (j + 3);
        }
        y[u] = scale * derivative(q, dl_radau_terms + 2, s, k);
        y[step->n + u] = scale * derivative(v, dl_radau_terms + 1, s, k);
    }
}
