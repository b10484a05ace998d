/* Gauss collocation for q'' = a(q): E. Hairer, C. Lubich, G. Wanner, Geometric Numerical
 * Integration, 2nd ed. (2006), doi:10.1007/3-540-30666-8, sections II.1.3 and VIII.6. With the
 * method's A, b and c,
 *
 *     D_i = h c_i v + h^2 sum_j (A^2)_ij F_j,    F_i = a(q + D_i)
 *     q  += h v + h^2 sum_i b_i (1 - c_i) F_i,   v += h sum_i b_i F_i
 *
 * s stages have order 2 s, are symplectic, time-symmetric and conserve both momenta, if the
 * equations for the D_i are solved to the last digit. They are, by fixed-point iteration until
 * nothing changes; and the sums for q and v keep what they round off: E. Hairer, R. I. McLachlan,
 * A. Razakarivony, BIT 48 (2008) 231, doi:10.1007/s10543-008-0170-3. For the same reason h is a
 * factor twice, not h^2 once, whose roundoff would be the same in every step and make a drift. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "methods/compensated.h"
#include "methods/norms.h"
#include "methods/options.h"
#include "methods/registry.h"

enum { most_stages = 3 };

typedef struct gauss_options {
    double step, tolerance;
    long iterations;
} gauss_options;

static const dl_parameter options[] = {
    DL_OPTION_FIXED_STEP(gauss_options),
    {
        .name = "tolerance",
        .kind = DL_REAL,
        .offset = offsetof(gauss_options, tolerance),
        .unit = "",
        .minimum = 0,
        .maximum = 0.1,
        .fallback = "1e-15",
        .doc = "change of a step's stages allowed in the last iteration, as a part of the largest "
               "displacement; iteration also ends where roundoff lets it fall no further",
    },
    {
        .name = "iterations",
        .kind = DL_INTEGER,
        .offset = offsetof(gauss_options, iterations),
        .unit = "",
        .minimum = 1,
        .maximum = 100000,
        .fallback = "100",
        .doc = "fixed-point iterations allowed in one attempt at a step",
    },
};

typedef struct gauss_variant {
    int stages;
    long double node[most_stages];
} gauss_variant;

/* 1/2 -+ sqrt(3)/6 */
static const gauss_variant two_stages = {
    .stages = 2,
    .node = {0.21132486540518711774542560974902L, 0.78867513459481288225457439025098L},
};

/* 1/2 -+ sqrt(15)/10 and 1/2 */
static const gauss_variant three_stages = {
    .stages = 3,
    .node = {0.11270166537925831148207346002176L, 0.5L, 0.88729833462074168851792653997824L},
};

typedef struct gauss {
    int stages;
    double c[most_stages];
    double squared[most_stages][most_stages]; /* A^2 */
    double velocity[most_stages];             /* b */
    double position[most_stages];             /* b (1 - c) */
    /* F in the next step from the F of `steps_known` steps, the last one first */
    double predictor[2][most_stages][2 * most_stages];
    int steps_known; /* 0, 1 or 2, of length known_step */
    double known_step;
    double *force; /* F_1 | F_2 ... : [stages n] */
    double *known[2];
    double *displacement; /* D_1 | D_2 ... : [stages n] */
    double *cycle;        /* places of a cycle and forces there, [4 stages n]; NULL before one */
    double *place;        /* q + D_i, [n] */
    double *lost;         /* what y has rounded off, [2 n] */
    bool inexact;         /* the step ended above the tolerance */
    unsigned long steps, iterations, inexact_steps;
} gauss;

/* --- coefficients -------------------------------------------------------------------------------
 */

/* Lagrange's polynomial over `count` nodes that is 1 at node j, at x. */
static long double lagrange(int count, const long double *node, int j, long double x) {
    long double value = 1;
    for (int k = 0; k < count; k++)
        if (k != j)
            value *= (x - node[k]) / (node[j] - node[k]);
    return value;
}

/* Its integral from 0 to x, by Simpson's rule, which is exact to degree 3. */
static long double lagrange_integral(int count, const long double *node, int j, long double x) {
    return x / 6 *
           (lagrange(count, node, j, 0) + 4 * lagrange(count, node, j, x / 2) +
            lagrange(count, node, j, x));
}

static void set_coefficients(gauss *data, const gauss_variant *variant) {
    const int s = data->stages = variant->stages;
    const long double *const c = variant->node;
    long double a[most_stages][most_stages];
    for (int i = 0; i < s; i++)
        for (int j = 0; j < s; j++)
            a[i][j] = lagrange_integral(s, c, j, c[i]);
    for (int i = 0; i < s; i++) {
        const long double b = lagrange_integral(s, c, i, 1);
        data->c[i] = (double)c[i];
        data->velocity[i] = (double)b;
        data->position[i] = (double)(b * (1 - c[i]));
        for (int j = 0; j < s; j++) {
            long double sum = 0;
            for (int k = 0; k < s; k++)
                sum += a[i][k] * a[k][j];
            data->squared[i][j] = (double)sum;
        }
    }
    long double known[2 * most_stages];
    for (int j = 0; j < s; j++) {
        known[j] = c[j];
        known[s + j] = c[j] - 1;
    }
    for (int i = 0; i < s; i++)
        for (int j = 0; j < 2 * s; j++) {
            data->predictor[0][i][j] = j < s ? (double)lagrange(s, known, j, 1 + c[i]) : 0;
            data->predictor[1][i][j] = (double)lagrange(2 * s, known, j, 1 + c[i]);
        }
}

/* --- stages ------------------------------------------------------------------------------------
 */

/* F by the polynomial through those of the last steps; without such, F = a(q). */
static dl_status predict(dl_method *method, dl_error *error) {
    gauss *const data = method->data;
    const size_t n = method->n;
    const int s = data->stages;
    if (data->steps_known == 0) {
        const dl_status status =
            dl_model_acceleration(method->model, method->y, data->force, error);
        for (int i = 1; i < s && !status; i++)
            memcpy(data->force + (size_t)i * n, data->force, n * sizeof *data->force);
        return status;
    }
    memset(data->force, 0, (size_t)s * n * sizeof *data->force);
    for (int i = 0; i < s; i++)
        for (int j = 0; j < s * data->steps_known; j++) {
            const double weight = data->predictor[data->steps_known - 1][i][j];
            const double *const from = data->known[j / s] + (size_t)(j % s) * n;
            double *const to = data->force + (size_t)i * n;
            for (size_t u = 0; u < n; u++)
                to[u] += weight * from[u];
        }
    return DL_OK;
}

/* D_i from the F, and the place q + D_i. Adds to the largest change and size of any D. */
static void move_stage(dl_method *method, int i, double *change, double *size) {
    gauss *const data = method->data;
    const size_t n = method->n;
    const double h = method->step;
    const double *const q = method->y, *const v = q + n;
    double *const displacement = data->displacement + (size_t)i * n;
    double most = *change, longest = *size;
    for (size_t u = 0; u < n; u++) {
        double sum = 0;
        for (int j = 0; j < data->stages; j++)
            sum += data->squared[i][j] * data->force[(size_t)j * n + u];
        const double to = h * (data->c[i] * v[u] + h * sum);
        most = fmax(most, fabs(to - displacement[u]));
        longest = fmax(longest, fabs(to));
        displacement[u] = to;
        data->place[u] = q[u] + (data->lost[u] + to);
    }
    *change = most;
    *size = longest;
}

static dl_status did_not_converge(const dl_method *method, double change, double size,
                                  dl_error *error) {
    return dl_fail(error, DL_NONLINEAR_FAILURE,
                   "%s: the stages of the step from t = %.10g were not found: the last iteration "
                   "changed them by %.3g of the largest displacement",
                   method->row->name, method->t, size > 0 ? change / size : change);
}

/* A trial displacement this many times the first one is nonsense, and its forces may cost much. */
static const double longest_trial = 100;

/* Iterations without progress after which the fixed point is given up, and those in which a cycle
 * must close. */
enum { patience = 12, longest_cycle = 8 };

/* One pass through the stages. */
static dl_status improve(dl_method *method, double first_size, double *change, double *size,
                         dl_error *error) {
    gauss *const data = method->data;
    const size_t n = method->n;
    *change = *size = 0;
    data->iterations++;
    for (int i = 0; i < data->stages; i++) {
        move_stage(method, i, change, size);
        if (!(*size <= longest_trial * first_size))
            return did_not_converge(method, *change, *size, error);
        const dl_status status =
            dl_model_acceleration(method->model, data->place, data->force + (size_t)i * n, error);
        if (status)
            return status;
    }
    return DL_OK;
}

/* --- accelerations that jump --------------------------------------------------------------------
 *
 * Where a stage's force jumps between two trial places the equations may have no solution. The
 * iteration then goes round in a cycle, and any place at the jump is as good as another. */

/* Forces of all stages at displacements. */
static dl_status forces_at(dl_method *method, const double *displacement, double *force,
                           dl_error *error) {
    gauss *const data = method->data;
    const size_t n = method->n;
    dl_status status = DL_OK;
    for (size_t i = 0; i < (size_t)data->stages && !status; i++) {
        for (size_t u = 0; u < n; u++)
            data->place[u] = method->y[u] + (data->lost[u] + displacement[i * n + u]);
        status = dl_model_acceleration(method->model, data->place, force + i * n, error);
    }
    return status;
}

/* Halvings of the way between two places of a cycle, over which a force that jumps changes as much
 * as over all of it, and a smooth one by a thousandth. */
enum { halvings = 10 };

/* Between the mark and the stages as they are: goes to the jump there, if there is one. */
static dl_status find_jump(dl_method *method, bool *found, dl_error *error) {
    gauss *const data = method->data;
    const size_t all = (size_t)data->stages * method->n, bytes = all * sizeof(double);
    double *const mark = data->cycle, *const mark_force = mark + all,
                  *const middle = mark + 2 * all, *const middle_force = mark + 3 * all;
    const double change = dl_largest_difference(mark_force, data->force, all);
    dl_status status = DL_OK;
    *found = true;
    for (int k = 0; k < halvings && *found && !status; k++) {
        for (size_t u = 0; u < all; u++)
            middle[u] = (mark[u] + data->displacement[u]) / 2;
        status = forces_at(method, middle, middle_force, error);
        const double before = dl_largest_difference(mark_force, middle_force, all);
        const double after = dl_largest_difference(middle_force, data->force, all);
        memcpy(before < after ? mark : data->displacement, middle, bytes);
        memcpy(before < after ? mark_force : data->force, middle_force, bytes);
        *found = fmax(before, after) > change / 2;
    }
    return status;
}

/* From where the iteration makes no progress: to the end of the step, if it is a jump that keeps it
 * from that. */
static dl_status go_round(dl_method *method, double first_size, double allowed, dl_error *error) {
    gauss *const data = method->data;
    const size_t all = (size_t)data->stages * method->n;
    double change = 0, size = 0;
    bool found = false;
    if (!data->cycle)
        data->cycle = malloc(4 * all * sizeof *data->cycle);
    if (!data->cycle)
        return dl_fail_memory(error, "Gauss collocation's stages");
    memcpy(data->cycle, data->displacement, all * sizeof *data->cycle);
    memcpy(data->cycle + all, data->force, all * sizeof *data->cycle);
    for (int k = 0; k < longest_cycle && !found; k++) {
        const dl_status status = improve(method, first_size, &change, &size, error);
        if (status)
            return status;
        found = dl_largest_difference(data->displacement, data->cycle, all) <= allowed;
    }
    if (found) {
        dl_status status = improve(method, first_size, &change, &size, error);
        status = status ? status : find_jump(method, &found, error);
        if (status)
            return status;
    }
    return found ? DL_OK : did_not_converge(method, change, size, error);
}

/* --- the whole step -----------------------------------------------------------------------------
 */

static dl_status iterate(dl_method *method, dl_error *error) {
    gauss *const data = method->data;
    const gauss_options *const chosen = method->options;
    const double grain = 4 * DBL_EPSILON * dl_largest(method->y, method->n); /* of q + D */
    double best = INFINITY, first_size = INFINITY, change = 0, size = 0;
    int since_best = 0;
    for (long k = 0; k < chosen->iterations && since_best < patience; k++) {
        const dl_status status = improve(method, first_size, &change, &size, error);
        if (status)
            return status;
        if (k == 0) {
            first_size = size; /* the change is from what the last step left there */
            continue;
        }
        since_best = change < best ? 0 : since_best + 1;
        best = fmin(best, change);
        data->inexact = change > chosen->tolerance * size;
        if (!data->inexact || (since_best >= 2 && change <= grain))
            return DL_OK;
    }
    return since_best < patience
               ? did_not_converge(method, change, size, error)
               : go_round(method, first_size, fmax(chosen->tolerance * size, grain), error);
}

static void finish(dl_method *method) {
    gauss *const data = method->data;
    const size_t n = method->n;
    const double h = method->step;
    double *const q = method->y, *const v = q + n;
    for (size_t u = 0; u < n; u++) {
        double velocity = 0, position = 0;
        for (int i = 0; i < data->stages; i++) {
            const double force = data->force[(size_t)i * n + u];
            velocity += data->velocity[i] * force;
            position += data->position[i] * force;
        }
        dl_compensated_add(&q[u], &data->lost[u], h * (v[u] + h * position));
        dl_compensated_add(&v[u], &data->lost[n + u], h * velocity);
    }
    double *const oldest = data->known[1];
    data->known[1] = data->known[0];
    data->known[0] = data->force;
    data->force = oldest;
    data->known_step = h;
    data->steps_known = data->steps_known < 2 ? data->steps_known + 1 : 2;
}

static dl_status gauss_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    gauss *const data = method->data;
    if (data->known_step != method->step)
        data->steps_known = 0;
    const int known = data->steps_known;
    dl_status status = predict(method, error);
    status = status ? status : iterate(method, error);
    if (status == DL_NONLINEAR_FAILURE && known > 0) {
        data->steps_known = 0;
        status = predict(method, error);
        status = status ? status : iterate(method, error);
    }
    if (status)
        return status;
    finish(method);
    data->steps++;
    data->inexact_steps += data->inexact;
    dl_method_count_step(method);
    return DL_OK;
}

/* --- life --------------------------------------------------------------------------------------
 */

static dl_status gauss_create(dl_method *method, dl_error *error) {
    gauss *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "Gauss collocation");
    method->step = ((const gauss_options *)method->options)->step;
    set_coefficients(data, method->row->variant);
    const size_t n = method->n, all = (size_t)data->stages * n;
    const struct {
        double **array;
        size_t length;
    } arrays[] = {{&data->force, all},        {&data->known[0], all}, {&data->known[1], all},
                  {&data->displacement, all}, {&data->place, n},      {&data->lost, 2 * n}};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++) {
        *arrays[k].array = calloc(arrays[k].length + 1, sizeof(double));
        if (!*arrays[k].array)
            return dl_fail_memory(error, "Gauss collocation's stages");
    }
    return DL_OK;
}

static dl_status gauss_jumped(dl_method *method, dl_error *error) {
    (void)error;
    gauss *const data = method->data;
    data->steps_known = 0;
    memset(data->lost, 0, 2 * method->n * sizeof *data->lost);
    return DL_OK;
}

static void gauss_stats(const dl_method *method, dl_method_stats *stats) {
    const gauss *const data = method->data;
    stats->steps = data->steps;
    stats->nonlinear_iterations = data->iterations;
    stats->inexact = data->inexact_steps;
}

static void gauss_destroy(dl_method *method) {
    gauss *const data = method->data;
    if (!data)
        return;
    double *const arrays[] = {data->force, data->known[0], data->known[1], data->displacement,
                              data->cycle, data->place,    data->lost};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
    free(data);
}

static const dl_method_ops ops = {
    .create = gauss_create,
    .advance = gauss_advance,
    .jumped = gauss_jumped,
    .stats = gauss_stats,
    .destroy = gauss_destroy,
};

#define GAUSS(symbol, its_name, its_stages, its_variant)                                           \
    const dl_method_row dl_method_##symbol = {                                                     \
        .name = its_name,                                                                          \
        .family = "Gauss",                                                                         \
        .doc = "Gauss collocation, fixed-point iteration to roundoff (Hairer, McLachlan & "        \
               "Razakarivony 2008, doi:10.1007/s10543-008-0170-3)",                                \
        .order = 2 * (its_stages),                                                                 \
        .stages = its_stages,                                                                      \
        .flags = DL_SYMPLECTIC | DL_TIME_SYMMETRIC | DL_CONSERVES_MOMENTUM | DL_IMPLICIT |         \
                 DL_FIXED_STEP,                                                                    \
        .options = DL_OPTIONS_TABLE(options),                                                      \
        .options_size = sizeof(gauss_options),                                                     \
        .variant = &(its_variant),                                                                 \
        .ops = &ops,                                                                               \
    }

GAUSS(gauss_4, "gauss-4", 2, two_stages);
GAUSS(gauss_6, "gauss-6", 3, three_stages);
