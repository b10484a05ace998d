#include "reference/trajectory.h"

#include <math.h>
#include <stdlib.h>

#include "core/random_stream.h"
#include "driftlab/model.h"
#include "driftlab/reference.h"

double dl_reference_time(double end, size_t intervals, size_t sample) {
    return sample >= intervals ? end : (double)sample * (end / (double)intervals);
}

dl_status dl_extended_trajectory(const dl_extended_ops *ops, const dl_scene *scene,
                                 const dl_extended_setup *setup, double end, size_t intervals,
                                 double *high, double *low, dl_extended_counts *counts,
                                 dl_error *error) {
    const size_t length = 2 * (size_t)scene->dimension * scene->particles;
    dl_extended_walk *walk = NULL;
    dl_status status = ops->create(scene, setup, &walk, error);
    for (size_t i = 0; i <= intervals && !status; i++) {
        status = ops->advance(walk, dl_reference_time(end, intervals, i), error);
        if (!status)
            ops->state(walk, high + i * length, low + i * length);
    }
    if (!status)
        *counts = ops->counts(walk);
    ops->destroy(walk);
    return status;
}

/* --- growth ----------------------------------------------------------------------------------- */

/* Far enough above the roundoff of long double, 1e-19, and far enough below what is not linear,
 * from one part of the time to the next. */
static const double displacement = 1e-10, tolerance = 16;

static double rms(const double *values, size_t count) {
    double sum = 0;
    for (size_t k = 0; k < count; k++)
        sum += values[k] * values[k];
    return count > 0 ? sqrt(sum / (double)count) : 0;
}

/* Of the velocities relative to their mean, or else of what the accelerations at the start make of
 * a place at rest within `length`. */
static dl_status find_speed(const dl_scene *scene, double length, double end, double *speed,
                            dl_error *error) {
    dl_model *model = NULL;
    dl_status status = dl_model_create(scene, &model, error);
    if (status)
        return status;
    const size_t n = model->unknowns;
    double *y = calloc(3 * n + 1, sizeof *y);
    if (y) {
        dl_model_initial_state(model, y);
        for (size_t c = 0; c < (size_t)model->dimension; c++) {
            double *v = y + n + c * model->moving, mean = 0;
            for (size_t k = 0; k < model->moving; k++)
                mean += v[k] / (double)model->moving;
            for (size_t k = 0; k < model->moving && model->moving > 1; k++)
                v[k] -= mean;
        }
        status = dl_model_acceleration(model, y, y + 2 * n, error);
        *speed = fmax(rms(y + n, n), sqrt(length * rms(y + 2 * n, n)));
        if (!(*speed > 0))
            *speed = length / end;
    } else {
        status = dl_fail_memory(error, "a state");
    }
    free(y);
    dl_model_free(model);
    return status;
}

static dl_status fill_direction(const dl_scene *scene, double length, double speed,
                                double *direction, dl_error *error) {
    const size_t n = scene->particles, block = (size_t)scene->dimension * n;
    dl_random *random = NULL;
    const dl_status status = dl_random_create(1, 0, &random, error);
    for (size_t i = 0; i < n && !status; i++) {
        dl_random_begin(random, i, DL_RANDOM_PERTURBATION);
        for (size_t k = i; k < block; k += n) {
            direction[k] = length * dl_random_normal(random);
            direction[block + k] = speed * dl_random_normal(random);
        }
    }
    dl_random_free(random);
    return status;
}

typedef struct two {
    dl_extended_walk *base, *shadow;
    double length, speed;
} two;

static dl_status follow(const two *walks, double end, size_t intervals, double *growth,
                        dl_error *error) {
    const dl_extended_ops *ops = &dl_extended_long_double;
    dl_status status = DL_OK;
    for (size_t i = 1; i <= intervals && !status; i++) {
        const double t = dl_reference_time(end, intervals, i);
        status = ops->advance(walks->base, t, error);
        if (!status)
            status = ops->advance(walks->shadow, t, error);
        if (status)
            return status;
        const double factor = ops->separate(walks->shadow, walks->base, NULL, displacement,
                                            walks->length, walks->speed);
        growth[i] = growth[i - 1] + log(factor);
    }
    return status;
}

dl_status dl_extended_growth(const dl_scene *scene, const dl_extended_limits *limits, double length,
                             double end, size_t intervals, double *growth, dl_error *error) {
    const dl_extended_ops *ops = &dl_extended_long_double;
    const dl_extended_setup setup = {
        .method = DL_TAYLOR, .tolerance = tolerance, .limits = *limits};
    two walks = {.length = length};
    double *direction = calloc(2 * (size_t)scene->dimension * scene->particles, sizeof *direction);
    dl_status status = direction ? DL_OK : dl_fail_memory(error, "a displacement");
    if (!status)
        status = find_speed(scene, length, end, &walks.speed, error);
    if (!status)
        status = fill_direction(scene, length, walks.speed, direction, error);
    if (!status)
        status = ops->create(scene, &setup, &walks.base, error);
    if (!status)
        status = ops->create(scene, &setup, &walks.shadow, error);
    growth[0] = 0;
    if (!status) {
        ops->separate(walks.shadow, walks.base, direction, displacement, length, walks.speed);
        status = follow(&walks, end, intervals, growth, error);
    }
    ops->destroy(walks.base);
    ops->destroy(walks.shadow);
    free(direction);
    return status;
}
