/* Steppers of the GNU Scientific Library (ode-initval2), at a fixed step or with GSL's own control
 * of the step. msadams and msbdf choose their order by the tolerances and so have no fixed step.
 *
 * The implicit ones factorise dense matrices of the whole state, 2 unknowns long (rk4imp of both
 * its stages), whatever the pattern of
 *
 *     J = [0 I; A 0],   A = d a / d q,
 *
 * and estimate their error by doubling the step, but for bsimp and msbdf.
 *
 * bsimp gives a step up where an iterate differs by too many times a component's value from it
 * (GSL 2.7: the sum of |delta_i/y_i| beyond 100 a component, y_i = 0 counting as 1), and so could
 * not take one from near rest at which a force acts, however short. It gets y - s instead, with s_i
 * = y_i of what is small and else 0, which satisfies the same equations. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>

#include "methods/options.h"
#include "methods/registry.h"

typedef struct gsl_options {
    double step, rtol, atol;
} gsl_options;

typedef struct gsl_variant {
    const gsl_odeiv2_step_type *const *type;
    size_t matrices; /* of the state's length squared that it needs */
} gsl_variant;

typedef struct gsl {
    gsl_odeiv2_system system;
    gsl_odeiv2_driver *driver; /* couples stepper, control and evolution; msadams needs all three */
    double *work;              /* [2 unknowns]: what GSL steps, so that a failure leaves y alone */
    double *values;            /* of A, [values_size] */
    size_t values_size;
    double *small; /* [2 unknowns]: s of bsimp's step; NULL where all of y is stepped */
    double *whole; /* [2 unknowns]: y where that is not */
    dl_model *model;
    dl_status model_status; /* last failure of the model in this step */
    dl_error model_error;
    unsigned long steps, rejected;
    unsigned attempts;   /* at a step, since window_start */
    double window_start; /* a time */
} gsl;

/* Of a component, beside the largest position or velocity. */
static const double is_small = 1e-3;

static void take_small(double *y, double *small, size_t n) {
    double most = 0;
    for (size_t i = 0; i < n; i++)
        most = fmax(most, fabs(y[i]));
    for (size_t i = 0; i < n; i++) {
        small[i] = fabs(y[i]) < is_small * most ? y[i] : 0;
        y[i] -= small[i];
    }
}

static const double *whole_of(gsl *data, const double *y) {
    if (!data->small)
        return y;
    for (size_t i = 0; i < 2 * data->model->unknowns; i++)
        data->whole[i] = y[i] + data->small[i];
    return data->whole;
}

/* A state without a finite acceleration may be avoided by a shorter step; GSL tries one unless the
 * answer is GSL_EBADFUNC. */
static int rhs(double t, const double y[], double ydot[], void *parameters) {
    (void)t;
    gsl *const data = parameters;
    data->model_status = dl_model_rhs(data->model, whole_of(data, y), ydot, &data->model_error);
    if (!data->model_status)
        return GSL_SUCCESS;
    return data->model_status == DL_UNSTABLE ? GSL_EDOM : GSL_EBADFUNC;
}

/* A at q: pattern and values. */
static dl_status evaluate(gsl *data, const double *q, const dl_sparsity **pattern,
                          dl_error *error) {
    const dl_status status = dl_model_sparsity(data->model, q, NULL, pattern, error);
    if (status)
        return status;
    if ((*pattern)->nonzeros > data->values_size) {
        double *const grown = realloc(data->values, (*pattern)->nonzeros * sizeof *grown);
        if (!grown)
            return dl_fail_memory(error, "the Jacobian");
        data->values = grown;
        data->values_size = (*pattern)->nonzeros;
    }
    return dl_model_jacobian(data->model, q, data->values, error);
}

/* dfdy by rows. */
static int jacobian(double t, const double y[], double *dfdy, double dfdt[], void *parameters) {
    (void)t;
    gsl *const data = parameters;
    const size_t n = data->model->unknowns, length = 2 * n;
    const dl_sparsity *a = NULL;
    memset(dfdt, 0, length * sizeof *dfdt);
    memset(dfdy, 0, length * length * sizeof *dfdy);
    data->model_status = evaluate(data, whole_of(data, y), &a, &data->model_error);
    if (data->model_status)
        return data->model_status == DL_UNSTABLE ? GSL_EDOM : GSL_EBADFUNC;
    for (size_t row = 0; row < n; row++)
        dfdy[row * length + n + row] = 1;
    for (size_t column = 0; column < n; column++)
        for (long k = a->column_start[column]; k < a->column_start[column + 1]; k++)
            dfdy[(n + (size_t)a->row[k]) * length + column] = data->values[k];
    return GSL_SUCCESS;
}

/* Whether there is room for the matrices of a stepper, which GSL does not always ask. */
static bool has_room(size_t matrices, size_t length) {
    double *const room = malloc(matrices * length * length * sizeof *room);
    free(room);
    return room;
}

static dl_status gsl_create(dl_method *method, dl_error *error) {
    const gsl_options *const chosen = method->options;
    const gsl_variant *const variant = method->row->variant;
    method->step = method->row->flags & DL_FIXED_STEP ? chosen->step : 0;
    gsl_set_error_handler_off(); /* GSL's default is to abort */
    gsl *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "a GSL stepper");
    const size_t length = 2 * method->n;
    data->model = method->model;
    data->system = (gsl_odeiv2_system){
        .function = rhs, .jacobian = jacobian, .dimension = length, .params = data};
    data->work = malloc(length * sizeof *data->work);
    if (*variant->type == gsl_odeiv2_step_bsimp) {
        data->small = calloc(2 * length + 1, sizeof *data->small);
        if (!data->small)
            return dl_fail_memory(error, "a GSL stepper");
        data->whole = data->small + length;
    }
    if (variant->matrices > 0 && !has_room(variant->matrices, length))
        return dl_fail_memory(error, "the matrices of a GSL stepper");
    const double first_step = method->step > 0 ? method->step : method->model->scene->step / 100;
    if (data->work)
        data->driver = gsl_odeiv2_driver_alloc_y_new(&data->system, *variant->type, first_step,
                                                     chosen->atol, chosen->rtol);
    return data->driver ? DL_OK : dl_fail_memory(error, "a GSL stepper");
}

/* GSL itself goes on with steps that reach nowhere: shorter than this part of the time to be
 * reached, or so many of them that all attempts of a window are on average shorter than this part
 * of the scene's step (tolerances near roundoff where the force jumps). */
static const double least_step = 1e-15, least_mean_step = 1e-6;
enum { window = 20000 };

/* A part of the scene's step in which nothing blows up. Steps as short are tried at the start
 * alone: later they do not move the time. */
static const double vanishing_step = 1e-30;

/* Not counted; leaves nothing of use in data->work. */
static bool has_acceleration(const dl_method *method) {
    const gsl *const data = method->data;
    const dl_counts counts = data->model->counts;
    const dl_status status = dl_model_acceleration(data->model, method->y, data->work, NULL);
    data->model->counts = counts;
    return !status;
}

/* Steps that fail however short they are, from a state that is none to fail from, are GSL's own
 * numbers that overflow. */
static bool has_vanished(const dl_method *method, double step) {
    const gsl *const data = method->data;
    return method->step == 0 && (!data->model_status || data->model_status == DL_UNSTABLE) &&
           !(step > vanishing_step * data->model->scene->step) && has_acceleration(method);
}

static dl_status failed(const dl_method *method, int flag, double step, dl_error *error) {
    const gsl *const data = method->data;
    if (flag != GSL_ENOMEM && has_vanished(method, step))
        return dl_fail(error, DL_STEP_FAILURE,
                       "%s found no step at t = %.10g, however short: too much accuracy asked",
                       method->row->name, method->t);
    if (data->model_status)
        return dl_fail(error, data->model_status, "%s", data->model_error.message);
    if (flag == GSL_ENOMEM)
        return dl_fail_memory(error, "a GSL stepper");
    if (method->step > 0 && method->row->flags & DL_IMPLICIT)
        return dl_fail(error, DL_NONLINEAR_FAILURE, "%s did not solve its step at t = %.10g: %s",
                       method->row->name, method->t, gsl_strerror(flag));
    return dl_fail(error, DL_STEP_FAILURE, "%s found no step at t = %.10g (last tried: %.3g): %s",
                   method->row->name, method->t, step, gsl_strerror(flag));
}

/* Whether what GSL calls a success is one. */
static dl_status check_step(const dl_method *method, double t, double t_stop, dl_error *error) {
    const gsl *const data = method->data;
    if (method->step > 0) /* bsimp says so where its iteration has run away */
        return isinf(data->driver->e->yerr[0])
                   ? dl_fail(error, DL_NONLINEAR_FAILURE, "%s did not solve its step at t = %.10g",
                             method->row->name, method->t)
                   : DL_OK;
    if (t < t_stop && t - method->t < least_step * t_stop)
        return dl_fail(error, DL_STEP_FAILURE,
                       "%s: the step became as small as %.3g at t = %.10g: too much accuracy asked",
                       method->row->name, t - method->t, method->t);
    const double mean = (t - data->window_start) / window;
    if (data->attempts == window && mean < least_mean_step * method->model->scene->step)
        return dl_fail(error, DL_STEP_FAILURE,
                       "%s: %d attempts at a step were %.3g long on average at t = %.10g: too much "
                       "accuracy asked",
                       method->row->name, (int)window, mean, method->t);
    return DL_OK;
}

static void count_attempts(gsl *data, unsigned long rejected, double t) {
    data->rejected += rejected;
    if (data->attempts == window) {
        data->attempts = 0;
        data->window_start = t;
    }
    data->attempts = (unsigned)fmin(window, (double)(data->attempts + rejected + 1));
}

static dl_status gsl_advance(dl_method *method, double t_stop, dl_error *error) {
    gsl *const data = method->data;
    gsl_odeiv2_driver *const driver = data->driver;
    gsl_odeiv2_evolve *const evolve = driver->e;
    const size_t bytes = 2 * method->n * sizeof *method->y;
    const double step_before = driver->h;
    const unsigned long rejected_before = evolve->failed_steps;
    double t = method->t;
    memcpy(data->work, method->y, bytes);
    if (data->small) {
        take_small(data->work, data->small, method->n);
        take_small(data->work + method->n, data->small + method->n, method->n);
    }
    data->model_status = DL_OK;
    const int flag = method->step > 0
                         ? gsl_odeiv2_evolve_apply_fixed_step(
                               evolve, NULL, driver->s, &data->system, &t, method->step, data->work)
                         : gsl_odeiv2_evolve_apply(evolve, driver->c, driver->s, &data->system, &t,
                                                   t_stop, &driver->h, data->work);
    count_attempts(data, evolve->failed_steps - rejected_before, method->t);
    const dl_status status = flag == GSL_SUCCESS ? check_step(method, t, t_stop, error)
                                                 : failed(method, flag, driver->h, error);
    if (status) {
        gsl_odeiv2_driver_reset(driver);
        driver->h = step_before;
        return status;
    }
    memcpy(method->y, whole_of(data, data->work), bytes);
    data->steps++;
    method->t = t;
    if (method->step > 0)
        dl_method_count_step(method);
    return DL_OK;
}

static dl_status gsl_jumped(dl_method *method, dl_error *error) {
    (void)error;
    gsl_odeiv2_driver_reset(((gsl *)method->data)->driver);
    return DL_OK;
}

static void gsl_stats(const dl_method *method, dl_method_stats *stats) {
    const gsl *const data = method->data;
    stats->steps = data->steps;
    stats->rejected = data->rejected;
}

static void gsl_destroy(dl_method *method) {
    gsl *const data = method->data;
    if (data) {
        if (data->driver)
            gsl_odeiv2_driver_free(data->driver);
        free(data->work);
        free(data->values);
        free(data->small);
    }
    free(data);
}

static const dl_method_ops ops = {
    .create = gsl_create,
    .advance = gsl_advance,
    .jumped = gsl_jumped,
    .stats = gsl_stats,
    .destroy = gsl_destroy,
};

/* --- rows --------------------------------------------------------------------------------------
 */

static const dl_parameter explicit_options[] = {DL_OPTION_STEP_OR_ADAPTIVE(gsl_options),
                                                DL_OPTION_RTOL(gsl_options),
                                                DL_OPTION_ATOL(gsl_options)};
static const dl_parameter implicit_options[] = {DL_OPTION_STEP_OR_ADAPTIVE(gsl_options),
                                                DL_OPTIONS_TOLERANCES_OF_STAGES(gsl_options)};
static const dl_parameter multistep_options[] = {DL_OPTION_RTOL(gsl_options),
                                                 DL_OPTION_ATOL(gsl_options)};

#define GSL(stepper, name_, order_, made_, forces_, matrices_, flags_, table, doc_)                \
    static const gsl_variant stepper = {&gsl_odeiv2_step_##stepper, matrices_};                    \
    const dl_method_row dl_method_gsl_##stepper = {                                                \
        .name = name_,                                                                             \
        .family = "GSL",                                                                           \
        .doc = doc_ " (GSL)",                                                                      \
        .order = order_,                                                                           \
        made_,                                                                                     \
        .forces = forces_,                                                                         \
        .flags = DL_ADAPTIVE | (flags_),                                                           \
        .options = DL_OPTIONS_TABLE(table),                                                        \
        .options_size = sizeof(gsl_options),                                                       \
        .variant = &(stepper),                                                                     \
        .ops = &ops,                                                                               \
    }

#define STAGES(count)  .stages = (count)
#define MADE_OF(words) .made_of = (words)
#define IMPLICIT       (DL_IMPLICIT | DL_NEEDS_JACOBIAN)

GSL(rk2, "gsl-rk2", 3, STAGES(3), 4, 0, DL_FIXED_STEP, explicit_options,
    "Runge-Kutta 2(3), going on with the result of order 3");
GSL(rk4, "gsl-rk4", 4, STAGES(4), 12, 0, DL_FIXED_STEP, explicit_options,
    "the classical Runge-Kutta method, error by step doubling");
GSL(rkf45, "gsl-rkf45", 5, STAGES(6), 7, 0, DL_FIXED_STEP, explicit_options,
    "Runge-Kutta-Fehlberg 4(5)");
GSL(rkck, "gsl-rkck", 5, STAGES(6), 7, 0, DL_FIXED_STEP, explicit_options,
    "Runge-Kutta Cash-Karp 4(5)");
GSL(rk8pd, "gsl-rk8pd", 8, STAGES(13), 14, 0, DL_FIXED_STEP, explicit_options,
    "Runge-Kutta Prince-Dormand 8(9)");
GSL(rk1imp, "gsl-rk1imp", 1, STAGES(1), 0, 2, DL_FIXED_STEP | IMPLICIT, implicit_options,
    "implicit Euler method in two half steps, Newton with a dense Jacobian");
GSL(rk2imp, "gsl-rk2imp", 2, STAGES(1), 0, 2, DL_FIXED_STEP | IMPLICIT, implicit_options,
    "implicit midpoint method in two half steps, Newton with a dense Jacobian");
GSL(rk4imp, "gsl-rk4imp", 4, STAGES(2), 0, 5, DL_FIXED_STEP | IMPLICIT, implicit_options,
    "Gauss collocation of 2 stages in two half steps, Newton with a dense Jacobian");
GSL(bsimp, "gsl-bsimp", 14, MADE_OF("extrapolated from 7 rows of semi-implicit midpoint steps"),
    140, 2, DL_FIXED_STEP | IMPLICIT, explicit_options,
    "semi-implicit extrapolation of Bader and Deuflhard, 7 columns, with a dense Jacobian");
GSL(msadams, "gsl-msadams", 0, MADE_OF("multistep"), 0, 0, 0, multistep_options,
    "Adams in Nordsieck form, orders 1-12, variable step");
GSL(msbdf, "gsl-msbdf", 0, MADE_OF("multistep"), 0, 2, IMPLICIT, multistep_options,
    "BDF in Nordsieck form, orders 1-5, variable step, Newton with a dense Jacobian");
