#include "study/path.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

void dl_path_hermite(dl_path *path, double h, dl_path_end start, dl_path_end end) {
    path->degree = 5;
    path->b[0] = start.d;
    path->b[1] = start.d + h * start.rate / 5;
    path->b[2] = start.d + 2 * h * start.rate / 5 + h * h * start.curvature / 20;
    path->b[3] = end.d - 2 * h * end.rate / 5 + h * h * end.curvature / 20;
    path->b[4] = end.d - h * end.rate / 5;
    path->b[5] = end.d;
}

/* The same polynomial, one degree higher. */
static void elevate(dl_path *path) {
    const int n = ++path->degree;
    path->b[n] = path->b[n - 1];
    for (int i = n - 1; i > 0; i--)
        path->b[i] = ((double)i * path->b[i - 1] + (double)(n - i) * path->b[i]) / (double)n;
}

double dl_path_taylor(dl_path *path, double h, int degree, const double *derivative,
                      dl_path_end start) {
    /* Powers of u = 1 - s, then Bernstein: beta_i = sum_k C(i,k)/C(n,k) c_k, in reverse order. */
    double power[dl_path_degree + 1];
    double factor = 1;
    for (int k = 0; k <= degree; k++) {
        power[k] = factor * derivative[k];
        factor *= -h / (k + 1);
    }
    for (int i = 0; i <= degree; i++) {
        double sum = 0, ratio = 1; /* C(i,k)/C(n,k) */
        for (int k = 0; k <= i; k++) {
            sum += ratio * power[k];
            ratio *= (double)(i - k) / (double)(degree - k > 0 ? degree - k : 1);
        }
        path->b[degree - i] = sum;
    }
    path->degree = degree;
    while (path->degree < 3)
        elevate(path);
    const double n = path->degree;
    const double b[3] = {path->b[0], path->b[1], path->b[2]};
    path->b[0] = start.d;
    path->b[1] = start.d + h * start.rate / n;
    if (start.d == 0 && start.rate == 0 && !isnan(start.curvature))
        path->b[2] = h * h * start.curvature / (n * (n - 1));
    double moved = 0;
    for (int i = 0; i < 3; i++)
        moved = fmax(moved, fabs(path->b[i] - b[i]));
    return moved;
}

void dl_path_add_square(dl_path *sum, const dl_path *path) {
    /* C(n,i) C(n,k-i) / C(2n,k) b_i b_(k-i) */
    const int n = path->degree;
    double scaled[dl_dense_degree + 1], binomial = 1;
    for (int k = 1; k <= 2 * n && sum->degree == 0; k++)
        sum->b[k] = sum->b[0];
    sum->degree = 2 * n;
    for (int i = 0; i <= n; i++) {
        scaled[i] = binomial * path->b[i];
        binomial *= (double)(n - i) / (double)(i + 1);
    }
    double whole = 1; /* C(2n,k) */
    for (int k = 0; k <= 2 * n; k++) {
        double product = 0;
        for (int i = k > n ? k - n : 0; i <= (k < n ? k : n); i++)
            product += scaled[i] * scaled[k - i];
        sum->b[k] += product / whole;
        whole *= (double)(2 * n - k) / (double)(k + 1);
    }
}

/* --- de Casteljau -------------------------------------------------------------------------------
 */

double dl_path_value(const dl_path *path, double s) {
    double b[dl_path_degree + 1];
    memcpy(b, path->b, sizeof b);
    for (int level = path->degree; level > 0; level--)
        for (int i = 0; i < level; i++)
            b[i] += s * (b[i + 1] - b[i]);
    return b[0];
}

void dl_path_cut(dl_path *path, double s) {
    double b[dl_path_degree + 1];
    memcpy(b, path->b, sizeof b);
    for (int level = path->degree; level > 0; level--) {
        path->b[path->degree - level] = b[0];
        for (int i = 0; i < level; i++)
            b[i] += s * (b[i + 1] - b[i]);
    }
    path->b[path->degree] = b[0];
}

static void halve(const dl_path *path, dl_path *left, dl_path *right) {
    *right = *path;
    left->degree = path->degree;
    for (int level = path->degree; level > 0; level--) {
        left->b[path->degree - level] = right->b[0];
        for (int i = 0; i < level; i++)
            right->b[i] = (right->b[i] + right->b[i + 1]) / 2;
    }
    left->b[path->degree] = right->b[0];
}

/* --- the first root -----------------------------------------------------------------------------
 */

/* Changes of sign among the b_i, not fewer than roots in (0, 1) and of the same parity; b_0 = 0 is
 * taken for positive. */
static int sign_changes(const dl_path *path) {
    int changes = 0;
    double last = path->b[0];
    for (int i = 1; i <= path->degree; i++) {
        if (path->b[i] == 0)
            continue;
        changes += (path->b[i] < 0) != (last < 0);
        last = path->b[i];
    }
    return changes;
}

/* Of a path with b_0 >= 0 that changes its sign once: the first number beyond the root. */
static double only_root(const dl_path *path) {
    double low = 0, high = 1;
    for (int i = 0; i < 200; i++) {
        const double middle = low + (high - low) / 2;
        if (middle <= low || middle >= high)
            break;
        if (dl_path_value(path, middle) < 0)
            high = middle;
        else
            low = middle;
    }
    return high;
}

/* On [low, low + width] of the step. Below the last level the path touches the wall and no more
 * than that can be told. */
static double first_exit(const dl_path *path, double low, double width) {
    if (path->b[0] < 0)
        return low;
    const int changes = sign_changes(path);
    if (changes == 0)
        return INFINITY;
    if (changes == 1)
        return low + width * only_root(path);
    if (width < 1e-15)
        return INFINITY;
    dl_path left, right;
    halve(path, &left, &right);
    const double first = first_exit(&left, low, width / 2);
    return first <= 1 ? first : first_exit(&right, low + width / 2, width / 2);
}

double dl_path_first_exit(const dl_path *path, double roundoff) {
    dl_path shifted = *path, rest = *path;
    bool goes_below = false;
    for (int i = 0; i <= path->degree; i++) {
        shifted.b[i] += roundoff;
        goes_below |= shifted.b[i] < 0;
    }
    if (!goes_below || first_exit(&shifted, 0, 1) > 1)
        return INFINITY;
    if (rest.b[0] < 0 && shifted.b[0] >= 0)
        rest.b[0] = 0;
    return first_exit(&rest, 0, 1);
}
