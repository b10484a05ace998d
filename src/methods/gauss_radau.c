/* Everhart's Gauss-Radau method of order 15, as adaptive and as careful with roundoff as IAS15
 * (methods/radau_step.h): the polynomial of a step is found by iteration, each time through its
 * seven later nodes, until only roundoff changes; the sums for positions and velocities keep what
 * they round off.
 *
 * The step. Rein and Spiegel bound the last term, |b_6| <= epsilon |a|, largest components of all
 * particles; Pham, Rein and Spiegel (Open J. Astrophys. 7 (2024), doi:10.33232/001c.115860) give
 * every particle a timescale of its own and set  h = tau (5040 epsilon)^(1/7). Both bounds hold
 * here. Of the timescales made of derivatives,
 *
 *     tau^2 = (|a| |a''| + |a'|^2)/(|a'| |a'''| + |a''|^2)
 *
 * (S. J. Aarseth, in Multiple Time Scales (1985) 377, doi:10.1016/B978-0-12-123420-1.50017-3) is
 * taken, which does not vanish with the acceleration, as that of a pair at its equilibrium distance
 * does.
 *
 * An acceleration that jumps within a step has no last term that is small at any h. There the
 * velocity is allowed to be wrong by epsilon. */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "methods/compensated.h"
#include "methods/norms.h"
#include "methods/options.h"
#include "methods/radau_step.h"
#include "methods/registry.h"

typedef struct gauss_radau_options {
    double step, epsilon;
} gauss_radau_options;

static const dl_parameter options[] = {
    {
        .name = "step",
        .kind = DL_REAL,
        .offset = offsetof(gauss_radau_options, step),
        .unit = "time",
        .minimum = 0,
        .maximum = INFINITY,
        .fallback = "0",
        .doc = "fixed time step; 0: chosen by rtol",
    },
    {
        .name = "rtol",
        .kind = DL_REAL,
        .offset = offsetof(gauss_radau_options, epsilon),
        .unit = "",
        .minimum = 0,
        .maximum = 0.1,
        .above_minimum = true,
        .fallback = "1e-9",
        .doc = "Rein and Spiegel's epsilon: last term of a step's accelerations, in parts of them; "
               "the "
               "step's error is about its square, roundoff with the default; where a force jumps, "
               "that "
               "part of the velocity",
        .when = "step=0",
    },
};

typedef struct gauss_radau {
    dl_radau_tables tables;
    dl_radau_step last, now; /* the last step that was accepted, the one that is tried */
    double *at_node;         /* accelerations there, [n] */
    double *place;           /* positions there, [n] */
    double *lost;            /* what y has rounded off, [2 n] */
    double *end, *end_lost;  /* y and the same at the end of the step that is tried, [2 n] */
    double reach;            /* largest coordinate and velocity at its start */
    double start_speed;
    double scale;      /* largest acceleration in it */
    double spread;     /* largest change of an acceleration from its start to a node */
    bool a_is_current; /* now.a is the acceleration at y */
    double start;      /* time of the last step's */
    double next;       /* the step to be tried */
    unsigned long steps, rejected, iterations;
} gauss_radau;

/* --- finding the polynomial ---------------------------------------------------------------------
 */

/* Iterations, each of seven forces. Smooth steps take 2 or 3; one that takes more than a dozen is
 * better made shorter, if it may be. */
enum { most_iterations = 12, most_iterations_fixed = 100 };

static double epsilon_of(const dl_method *method) {
    return ((const gauss_radau_options *)method->options)->epsilon;
}

/* Whether an acceleration moves nothing by more than that part of the largest coordinate. */
static bool moves_less(const gauss_radau *data, double a, double part) {
    const double h = data->now.h;
    return h * h * a <= part * data->reach;
}

static double speed(const gauss_radau *data) {
    return data->start_speed + data->now.h * data->scale;
}

/* Whether it changes no velocity by more than that part of the largest. */
static bool speeds_less(const gauss_radau *data, double a, double part) {
    return data->now.h * a <= part * speed(data);
}

/* Positions are known to roundoff, accelerations to what that makes of it, and terms of theirs to
 * some thousands of that: what moves things less than this tells nothing. */
static const double grain = 1024 * DBL_EPSILON;

/* One pass through the nodes, and the largest correction. */
static dl_status improve(dl_method *method, double *correction, dl_error *error) {
    gauss_radau *const data = method->data;
    const size_t n = method->n;
    *correction = 0;
    data->scale = dl_largest(data->now.a, n);
    data->spread = 0;
    data->iterations++;
    for (int i = 1; i <= dl_radau_terms; i++) {
        dl_radau_place(&data->now, data->lost, i, data->place);
        const dl_status status =
            dl_model_acceleration(method->model, data->place, data->at_node, error);
        if (status)
            return status;
        *correction = fmax(*correction, dl_radau_correct(&data->now, i, data->at_node));
        data->scale = fmax(data->scale, dl_largest(data->at_node, n));
        data->spread = fmax(data->spread, dl_largest_difference(data->at_node, data->now.a, n));
    }
    return DL_OK;
}

/* Whether the next correction would be roundoff, or corrections no longer fall and are. */
static bool is_found(const dl_method *method, int iteration, double correction, double before) {
    const gauss_radau *const data = method->data;
    const double small = DBL_EPSILON / 16;
    const double next = iteration > 0 ? correction * (correction / before) : correction;
    if (next <= small * data->scale)
        return true;
    if (moves_less(data, correction, small) && speeds_less(data, correction, small))
        return true;
    return iteration > 1 && correction > before / 2 && moves_less(data, correction, grain) &&
           speeds_less(data, correction, epsilon_of(method));
}

/* `left`: 0, or the last correction in parts of the accelerations where that is not roundoff. */
static dl_status iterate(dl_method *method, double *left, dl_error *error) {
    const gauss_radau *const data = method->data;
    const int most = method->step > 0 ? most_iterations_fixed : most_iterations;
    double before = INFINITY, correction = INFINITY;
    *left = 0;
    for (int k = 0; k < most; k++) {
        const dl_status status = improve(method, &correction, error);
        if (status || is_found(method, k, correction, before))
            return status;
        if (k > 1 && !(correction <= 10 * data->scale))
            break;
        before = correction;
    }
    *left = correction > 0 ? correction / data->scale : INFINITY; /* not NaN */
    return DL_OK;
}

/* --- the next step ------------------------------------------------------------------------------
 */

/* A step's derivatives of one particle's acceleration at its end, |a|^2 |a'|^2 |a''|^2 |a'''|^2 in
 * units of h. */
static void derivatives(const dl_radau_step *step, const dl_model *model, size_t particle,
                        double square[4]) {
    for (int k = 0; k < 4; k++)
        square[k] = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        const size_t u = c * model->moving + particle;
        double d[4] = {step->a[u], 0, 0, 0};
        for (int k = 0; k < dl_radau_terms; k++) {
            const double b = step->b[k][u];
            d[0] += b;
            d[1] += (k + 1) * b;
            d[2] += (k + 1) * k * b;
            d[3] += (k + 1) * k * (k - 1) * b;
        }
        for (int k = 0; k < 4; k++)
            square[k] += d[k] * d[k];
    }
}

/* The shortest timescale of any particle, in units of h. */
static double timescale(const dl_method *method) {
    const gauss_radau *const data = method->data;
    const dl_radau_step *const step = &data->now;
    double shortest = INFINITY;
    for (size_t i = 0; i < method->model->moving; i++) {
        double square[4];
        derivatives(step, method->model, i, square);
        if (moves_less(data, sqrt(square[2]), grain))
            continue;
        const double above = sqrt(square[0] * square[2]) + square[1];
        const double below = sqrt(square[1] * square[3]) + square[2];
        shortest = fmin(shortest, sqrt(above / below));
    }
    return shortest;
}

/* Last terms that are at least this part of the first ones do not belong to a smooth step. */
static const double rough = 0.01;

/* The step that epsilon allows, by what this one has found; `left` is the correction it has ended
 * with where that is not roundoff. */
static double allowed_step(dl_method *method, double left) {
    gauss_radau *const data = method->data;
    dl_radau_step *const step = &data->now;
    const double h = step->h, epsilon = epsilon_of(method);
    const double last_term = dl_largest(step->b[dl_radau_terms - 1], method->n);
    const bool tells = !moves_less(data, last_term, grain);
    step->smooth = last_term <= rough * dl_largest(step->b[0], method->n) ||
                   (!tells && speeds_less(data, data->spread, epsilon));
    if (!step->smooth)
        return epsilon * speed(data) / data->spread;
    if (left > 0)
        return 0;
    const double by_last_term = tells ? pow(epsilon * data->scale / last_term, 1.0 / 7) : INFINITY;
    return h * fmin(by_last_term, timescale(method) * pow(5040 * epsilon, 1.0 / 7));
}

/* --- a step ------------------------------------------------------------------------------------
 */

static dl_status begin(dl_method *method, dl_error *error) {
    gauss_radau *const data = method->data;
    const size_t bytes = method->n * sizeof(double);
    memcpy(data->now.q, method->y, bytes);
    memcpy(data->now.v, method->y + method->n, bytes);
    data->reach = dl_largest(data->now.q, method->n);
    data->start_speed = dl_largest(data->now.v, method->n);
    if (data->a_is_current)
        return DL_OK;
    const dl_status status = dl_model_acceleration(method->model, data->now.q, data->now.a, error);
    data->a_is_current = status == DL_OK;
    return status;
}

static void add(double *sum, double *lost, long double term) {
    const double high = (double)term;
    *lost += (double)(term - (long double)high);
    dl_compensated_add(sum, lost, high);
}

/* The polynomial's end, into data->end. */
static void finish(dl_method *method) {
    gauss_radau *const data = method->data;
    const size_t n = method->n;
    double *const end = data->end, *const lost = data->end_lost;
    memcpy(end, method->y, 2 * n * sizeof *end);
    memcpy(lost, data->lost, 2 * n * sizeof *lost);
    for (size_t u = 0; u < n; u++) {
        add(&end[u], &lost[u], dl_radau_position_change(&data->now, data->lost[n + u], u));
        add(&end[n + u], &lost[n + u], dl_radau_velocity_change(&data->now, u));
    }
}

/* Takes it as the new state. */
static void accept(dl_method *method) {
    gauss_radau *const data = method->data;
    const size_t bytes = 2 * method->n * sizeof(double);
    memcpy(method->y, data->end, bytes);
    memcpy(data->lost, data->end_lost, bytes);
    const dl_radau_step older = data->last;
    data->last = data->now;
    data->now = older;
    data->a_is_current = false;
    data->start = method->t;
    data->steps++;
}

static dl_status advance_fixed(dl_method *method, dl_error *error) {
    gauss_radau *const data = method->data;
    double left = 0;
    dl_radau_predict(&data->now, &data->last, method->step);
    const dl_status status = iterate(method, &left, error);
    if (status)
        return status;
    if (left > 0)
        return dl_fail(error, DL_NONLINEAR_FAILURE,
                       "%s: the accelerations of the step from t = %.10g were not found: the last "
                       "iteration changed them by %.3g of the largest",
                       method->row->name, method->t, left);
    data->now.smooth = true;
    finish(method);
    accept(method);
    dl_method_count_step(method);
    return DL_OK;
}

/* A step is repeated where a quarter of it, or less, is allowed, and the next is not longer than
 * four times this one (Rein, Spiegel, section 2.3). */
static const double most_change = 0.25;

/* The step that is allowed, by its end too, where the acceleration is known for the next step: 0
 * where it has jumped behind the last node. */
static dl_status examine(dl_method *method, double *allowed, dl_error *error) {
    gauss_radau *const data = method->data;
    const size_t n = method->n;
    double left = 0;
    dl_status status = iterate(method, &left, error);
    if (status)
        return status;
    *allowed = allowed_step(method, left);
    if (*allowed < most_change * data->now.h)
        return DL_OK;
    finish(method);
    status = dl_model_acceleration(method->model, data->end, data->at_node, error);
    if (status)
        return status;
    double wrong = 0;
    for (size_t u = 0; u < n; u++) {
        double a = data->now.a[u];
        for (int k = 0; k < dl_radau_terms; k++)
            a += data->now.b[k][u];
        wrong = fmax(wrong, fabs(data->at_node[u] - a));
    }
    const double epsilon = epsilon_of(method);
    if (!speeds_less(data, wrong, epsilon))
        *allowed = fmin(*allowed, epsilon * speed(data) / wrong);
    return DL_OK;
}

/* The next attempt: what is left to t_stop, in two parts where it is too long. */
static double attempt_length(const gauss_radau *data, double left) {
    if (left <= data->next)
        return left;
    return left < 2 * data->next ? left / 2 : data->next;
}

/* Attempts at one step. */
enum { most_attempts = 60 };

static dl_status advance_adaptive(dl_method *method, double t_stop, dl_error *error) {
    gauss_radau *const data = method->data;
    const double next = data->next;
    dl_error found = {""};
    dl_status status = DL_OK;
    for (int k = 0; k < most_attempts; k++) {
        const double left = t_stop - method->t, wanted = attempt_length(data, left);
        const double t = wanted < left ? method->t + wanted : t_stop;
        const double h = t - method->t; /* which t can tell */
        if (t < t_stop && !(h > 4 * DBL_EPSILON * fabs(method->t)))
            break;
        double allowed = 0;
        dl_radau_predict(&data->now, &data->last, h);
        status = examine(method, &allowed, &found);
        if (status && status != DL_UNSTABLE)
            return dl_fail(error, status, "%s", found.message);
        if (!status && allowed >= most_change * h) {
            if (h > data->next / 2) /* else cut short by t_stop */
                data->next = fmin(allowed, h / most_change);
            accept(method);
            memcpy(data->now.a, data->at_node, method->n * sizeof *data->at_node);
            data->a_is_current = true;
            method->t = t;
            return DL_OK;
        }
        data->rejected++;
        data->next = h * fmax(allowed / h, most_change / 8);
    }
    const double reached = data->next;
    data->next = next;
    if (status)
        return dl_fail(error, status, "%s", found.message);
    return dl_fail(error, DL_STEP_FAILURE, "%s: the step became as small as %.3g at t = %.10g",
                   method->row->name, reached, method->t);
}

static dl_status gauss_radau_advance(dl_method *method, double t_stop, dl_error *error) {
    const dl_status status = begin(method, error);
    if (status)
        return status;
    return method->step > 0 ? advance_fixed(method, error)
                            : advance_adaptive(method, t_stop, error);
}

/* --- life --------------------------------------------------------------------------------------
 */

static dl_status gauss_radau_create(dl_method *method, dl_error *error) {
    gauss_radau *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "Gauss-Radau");
    method->step = ((const gauss_radau_options *)method->options)->step;
    const size_t n = method->n;
    dl_radau_tables_set(&data->tables);
    dl_status status = dl_radau_step_create(&data->last, &data->tables, n, error);
    status = status ? status : dl_radau_step_create(&data->now, &data->tables, n, error);
    if (status)
        return status;
    data->next = method->model->scene->step;
    data->at_node = calloc(n + 1, sizeof *data->at_node);
    data->place = calloc(n + 1, sizeof *data->place);
    data->lost = calloc(2 * n + 1, sizeof *data->lost);
    data->end = calloc(2 * n + 1, sizeof *data->end);
    data->end_lost = calloc(2 * n + 1, sizeof *data->end_lost);
    return data->at_node && data->place && data->lost && data->end && data->end_lost
               ? DL_OK
               : dl_fail_memory(error, "a Gauss-Radau step");
}

static dl_status gauss_radau_jumped(dl_method *method, dl_error *error) {
    (void)error;
    gauss_radau *const data = method->data;
    data->a_is_current = false;
    data->last.smooth = false;
    memset(data->lost, 0, 2 * method->n * sizeof *data->lost);
    return DL_OK;
}

static int gauss_radau_dense_degree(const dl_method *method) {
    (void)method;
    return dl_radau_terms + 2;
}

static dl_status gauss_radau_dense(dl_method *method, double t, int derivative, double *y_out,
                                   dl_error *error) {
    (void)error;
    const gauss_radau *const data = method->data;
    dl_radau_derivative(&data->last, (t - data->start) / data->last.h, derivative, y_out);
    return DL_OK;
}

static void gauss_radau_stats(const dl_method *method, dl_method_stats *stats) {
    const gauss_radau *const data = method->data;
    stats->steps = data->steps;
    stats->rejected = data->rejected;
    stats->nonlinear_iterations = data->iterations;
}

static void gauss_radau_destroy(dl_method *method) {
    gauss_radau *const data = method->data;
    if (!data)
        return;
    dl_radau_step_free(&data->last);
    dl_radau_step_free(&data->now);
    free(data->at_node);
    free(data->place);
    free(data->lost);
    free(data->end);
    free(data->end_lost);
    free(data);
}

static const dl_method_ops ops = {
    .create = gauss_radau_create,
    .advance = gauss_radau_advance,
    .jumped = gauss_radau_jumped,
    .dense_degree = gauss_radau_dense_degree,
    .dense = gauss_radau_dense,
    .stats = gauss_radau_stats,
    .destroy = gauss_radau_destroy,
};

const dl_method_row dl_method_gauss_radau_15 = {
    .name = "gauss-radau-15",
    .family = "Gauss-Radau",
    .doc = "Everhart's RADAU with IAS15's care for step and roundoff (Everhart 1985; Rein & "
           "Spiegel 2015, doi:10.1093/mnras/stu2164)",
    .order = 15,
    .stages = dl_radau_terms + 1,
    .flags = DL_ADAPTIVE | DL_FIXED_STEP | DL_IMPLICIT,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(gauss_radau_options),
    .ops = &ops,
};
