/* TR171's scheme as its FORTRAN program solves it (appendix; S.T. Jones): a relaxed nonlinear
 * iteration on places and velocities, which begins at the state of the step's start,
 *
 *     x <- (1 - omega) x + omega (x0 + (h/2)(v0 + v))        all particles, then
 *     v <- (1 - omega) v + omega (v0 + h a(x0, x))           with the new x,
 *
 * until no component of x or v changes by more than eps. It works in the scene's frame and adds
 * nothing up with compensation: for comparison.
 *
 * eps is a whole step's. A step that is cut short, as to the time of an event, is allowed the same
 * part of it, or what roundoff leaves if that is more: where all that a short step does is less
 * than eps, the first iterate would be taken for the solution, x0 + h v0 without any acceleration.
 * A ball's last flights would end above its wall, each with more energy than it began with, and
 * it would never come to rest. */
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include "methods/options.h"
#include "methods/registry.h"

typedef struct relaxed_options {
    double step, omega, eps;
    long iterations;
} relaxed_options;

static const dl_parameter options[] = {
    DL_OPTION_FIXED_STEP(relaxed_options),
    {.name = "omega",
     .kind = DL_REAL,
     .offset = offsetof(relaxed_options, omega),
     .unit = "",
     .minimum = 0,
     .maximum = 2,
     .above_minimum = true,
     .fallback = "1",
     .doc = "relaxation: 1 takes each iterate as it is, less a part of it"},
    {.name = "eps",
     .kind = DL_REAL,
     .offset = offsetof(relaxed_options, eps),
     .unit = "length and length/time",
     .minimum = 0,
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "1e-13",
     .doc = "change of a place or velocity at which an iteration is the last; as much less as a "
            "step to an event is shorter"},
    {.name = "iterations",
     .kind = DL_INTEGER,
     .offset = offsetof(relaxed_options, iterations),
     .unit = "",
     .minimum = 1,
     .maximum = 100000,
     .fallback = "1000",
     .doc = "iterations allowed in a step"},
};

typedef struct relaxed {
    double *y;     /* iterate, [2 n]: x | v */
    double *delta; /* x - x0, [n] */
    double *a;     /* [n] */
    unsigned long steps, iterations;
} relaxed;

/* What an iteration changes. */
typedef struct progress {
    double omega, eps, part; /* of the whole step that this one is */
    double change;           /* the largest of a component */
    bool done;               /* all within what they are allowed */
} progress;

static const double roundoff = 4 * DBL_EPSILON;

/* value <- (1 - omega) value + omega to */
static void relax(double *value, double to, progress *made) {
    const double before = *value;
    *value = (1 - made->omega) * before + made->omega * to;
    const double change = fabs(*value - before);
    const double allowed = fmin(made->eps, fmax(made->eps * made->part, roundoff * fabs(before)));
    made->change = fmax(made->change, change);
    made->done &= change <= allowed; /* not where it is NaN */
}

static dl_status iterate(dl_method *method, progress *made, dl_error *error) {
    relaxed *const data = method->data;
    const double h = method->step;
    const size_t n = method->n;
    const double *const x0 = method->y, *const v0 = method->y + n;
    double *const x = data->y, *const v = data->y + n;
    made->change = 0;
    made->done = true;
    for (size_t i = 0; i < n; i++) {
        relax(&x[i], x0[i] + h / 2 * (v0[i] + v[i]), made);
        data->delta[i] = x[i] - x0[i];
    }
    const dl_status status =
        dl_model_discrete_acceleration(method->model, x0, data->delta, data->a, error);
    for (size_t i = 0; i < n && !status; i++)
        relax(&v[i], v0[i] + h * data->a[i], made);
    data->iterations++;
    return status;
}

static dl_status relaxed_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    relaxed *const data = method->data;
    const relaxed_options *const chosen = method->options;
    const size_t bytes = 2 * method->n * sizeof *data->y;
    progress made = {
        .omega = chosen->omega,
        .eps = chosen->eps,
        .part = fmin(1, method->step / chosen->step),
    };
    memcpy(data->y, method->y, bytes);
    for (long k = 0; k < chosen->iterations && !made.done; k++) {
        const dl_status status = iterate(method, &made, error);
        if (status)
            return status;
    }
    if (!made.done)
        return dl_fail(error, DL_NONLINEAR_FAILURE,
                       "the step's system did not converge in %ld relaxed iterations: the last "
                       "changed a component by %.3g, eps allows %g",
                       chosen->iterations, made.change, made.eps * made.part);
    memcpy(method->y, data->y, bytes);
    data->steps++;
    dl_method_count_step(method);
    return DL_OK;
}

static dl_status relaxed_create(dl_method *method, dl_error *error) {
    relaxed *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "the relaxed iteration");
    method->step = ((const relaxed_options *)method->options)->step;
    data->y = malloc((2 * method->n + 1) * sizeof *data->y);
    data->delta = malloc((method->n + 1) * sizeof *data->delta);
    data->a = malloc((method->n + 1) * sizeof *data->a);
    return data->y && data->delta && data->a ? DL_OK
                                             : dl_fail_memory(error, "the relaxed iteration");
}

static dl_status relaxed_jumped(dl_method *method, dl_error *error) {
    (void)method;
    (void)error;
    return DL_OK;
}

static void relaxed_stats(const dl_method *method, dl_method_stats *stats) {
    const relaxed *const data = method->data;
    stats->steps = data->steps;
    stats->nonlinear_iterations = data->iterations;
}

static void relaxed_destroy(dl_method *method) {
    relaxed *const data = method->data;
    if (!data)
        return;
    free(data->y);
    free(data->delta);
    free(data->a);
    free(data);
}

static const dl_method_ops ops = {
    .create = relaxed_create,
    .advance = relaxed_advance,
    .jumped = relaxed_jumped,
    .stats = relaxed_stats,
    .destroy = relaxed_destroy,
};

const dl_method_row dl_method_conserving_relaxed = {
    .name = "conserving-relaxed",
    .family = "conserving",
    .doc = "TR171's energy-conserving scheme by the relaxed iteration of its FORTRAN appendix",
    .order = 2,
    .made_of = "implicit, one discrete force an iteration",
    .flags = DL_TIME_SYMMETRIC | DL_CONSERVES_ENERGY | DL_CONSERVES_MOMENTUM | DL_IMPLICIT |
             DL_FIXED_STEP | DL_RESTARTS_EXACTLY,
    .options = DL_OPTIONS_TABLE(options),
    .options_size = sizeof(relaxed_options),
    .ops = &ops,
};
