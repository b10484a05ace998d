/* Steppers of the GNU Scientific Library (ode-initval2), at a fixed step or with GSL's own control
 * of the step. msadams chooses its order by the tolerances and so has no fixed step. */
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
} gsl_variant;

typedef struct gsl {
    gsl_odeiv2_system system;
    gsl_odeiv2_driver *driver; /* couples stepper, control and evolution; msadams needs all three */
    double *work;              /* [2 unknowns]: what GSL steps, so that a failure leaves y alone */
    dl_model *model;
    dl_status model_status; /* last failure of the model in this step */
    dl_error model_error;
    unsigned long steps, rejected;
} gsl;

/* A state without a finite acceleration may be avoided by a shorter step; GSL tries one unless the
 * answer is GSL_EBADFUNC. */
static int rhs(double t, const double y[], double ydot[], void *parameters) {
    (void)t;
    gsl *const data = parameters;
    data->model_status = dl_model_rhs(data->model, y, ydot, &data->model_error);
    if (!data->model_status)
        return GSL_SUCCESS;
    return data->model_status == DL_UNSTABLE ? GSL_EDOM : GSL_EBADFUNC;
}

static dl_status gsl_create(dl_method *method, dl_error *error) {
    const gsl_options *const chosen = method->options;
    const gsl_variant *const variant = method->row->variant;
    method->step = method->row->flags & DL_FIXED_STEP ? chosen->step : 0;
    const dl_status status = dl_method_refuse_unused_tolerances(method, method->step, error);
    if (status)
        return status;
    gsl_set_error_handler_off(); /* GSL's default is to abort */
    gsl *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "a GSL stepper");
    const size_t length = 2 * method->n;
    data->model = method->model;
    data->system =
        (gsl_odeiv2_system){.function = rhs, .dimension = length, .params = data, .jacobian = NULL};
    data->work = malloc(length * sizeof *data->work);
    const double first_step = method->step > 0 ? method->step : method->model->scene->step / 100;
    if (data->work)
        data->driver = gsl_odeiv2_driver_alloc_y_new(&data->system, *variant->type, first_step,
                                                     chosen->atol, chosen->rtol);
    return data->driver ? DL_OK : dl_fail_memory(error, "a GSL stepper");
}

/* GSL itself goes on with steps that reach nowhere. A part of the time to be reached. */
static const double least_step = 1e-15;

static dl_status failed(const dl_method *method, int flag, double step, dl_error *error) {
    const gsl *const data = method->data;
    if (data->model_status)
        return dl_fail(error, data->model_status, "%s", data->model_error.message);
    if (flag == GSL_ENOMEM)
        return dl_fail_memory(error, "a GSL stepper");
    return dl_fail(error, DL_STEP_FAILURE, "%s found no step at t = %.10g (last tried: %.3g): %s",
                   method->row->name, method->t, step, gsl_strerror(flag));
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
    data->model_status = DL_OK;
    const int flag = method->step > 0
                         ? gsl_odeiv2_evolve_apply_fixed_step(
                               evolve, NULL, driver->s, &data->system, &t, method->step, data->work)
                         : gsl_odeiv2_evolve_apply(evolve, driver->c, driver->s, &data->system, &t,
                                                   t_stop, &driver->h, data->work);
    data->rejected += evolve->failed_steps - rejected_before;
    if (flag != GSL_SUCCESS) {
        const dl_status status = failed(method, flag, driver->h, error);
        gsl_odeiv2_driver_reset(driver);
        driver->h = step_before;
        return status;
    }
    if (method->step == 0 && t < t_stop && t - method->t < least_step * t_stop) {
        const double step = t - method->t;
        gsl_odeiv2_driver_reset(driver);
        driver->h = step_before;
        return dl_fail(error, DL_STEP_FAILURE,
                       "%s: the step became as small as %.3g at t = %.10g: too much accuracy asked",
                       method->row->name, step, method->t);
    }
    memcpy(method->y, data->work, bytes);
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

static const dl_parameter runge_kutta_options[] = {DL_OPTION_STEP_OR_ADAPTIVE(gsl_options),
                                                   DL_OPTION_RTOL(gsl_options),
                                                   DL_OPTION_ATOL(gsl_options)};
static const dl_parameter multistep_options[] = {DL_OPTION_RTOL(gsl_options),
                                                 DL_OPTION_ATOL(gsl_options)};

#define GSL(stepper, name_, order_, flags_, table, doc_)                                           \
    static const gsl_variant stepper = {&gsl_odeiv2_step_##stepper};                               \
    const dl_method_row dl_method_gsl_##stepper = {                                                \
        .name = name_,                                                                             \
        .family = "GSL",                                                                           \
        .doc = doc_,                                                                               \
        .order = order_,                                                                           \
        .flags = DL_ADAPTIVE | (flags_),                                                           \
        .options = DL_OPTIONS_TABLE(table),                                                        \
        .options_size = sizeof(gsl_options),                                                       \
        .variant = &(stepper),                                                                     \
        .ops = &ops,                                                                               \
    }

GSL(rk4, "gsl-rk4", 4, DL_FIXED_STEP, runge_kutta_options,
    "the classical Runge-Kutta method, error by step doubling (GSL)");
GSL(rkf45, "gsl-rkf45", 5, DL_FIXED_STEP, runge_kutta_options, "Runge-Kutta-Fehlberg 4(5) (GSL)");
GSL(rk8pd, "gsl-rk8pd", 8, DL_FIXED_STEP, runge_kutta_options,
    "Runge-Kutta Prince-Dormand 8(9) (GSL)");
GSL(msadams, "gsl-msadams", 0, 0, multistep_options,
    "Adams in Nordsieck form, orders 1-12, variable step (GSL)");
