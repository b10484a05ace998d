/* The system as a whole, and what each particle does besides: TR299 (3.4), (3.6)-(3.13). */
#include <math.h>

#include "driftlab/observe.h"

void dl_observe_motion(const dl_scene *scene, const double *y_all, dl_motion *motion) {
    const size_t n = scene->particles, components = (size_t)scene->dimension;
    *motion = (dl_motion){0};
    for (size_t i = 0; i < n; i++) {
        const double mass = scene->pinned[i] ? 0 : scene->inertia[i];
        motion->mass += mass;
        for (size_t c = 0; c < components; c++) {
            motion->centre[c] += mass * y_all[c * n + i];
            motion->velocity[c] += mass * y_all[(components + c) * n + i];
        }
    }
    for (size_t c = 0; c < components; c++) {
        motion->centre[c] /= motion->mass;
        motion->velocity[c] /= motion->mass;
    }
    if (scene->periods.present) /* nothing turns about a centre that has copies */
        return;
    double sum = 0, mass = 0, momentum = 0, inertia = 0;
    for (size_t i = 0; i < n; i++) {
        const double x = y_all[i] - motion->centre[0], y = y_all[n + i] - motion->centre[1];
        const double vx = y_all[components * n + i] - motion->velocity[0];
        const double vy = y_all[(components + 1) * n + i] - motion->velocity[1];
        const double square = x * x + y * y;
        if (scene->pinned[i] || square == 0)
            continue;
        sum += scene->inertia[i] * (x * vy - y * vx) / square; /* v_t / R */
        mass += scene->inertia[i];
        momentum += scene->inertia[i] * (x * vy - y * vx);
        inertia += scene->inertia[i] * square;
    }
    motion->angular_velocity = mass > 0 ? sum / mass : 0;
    motion->rigid_rotation = inertia > 0 ? momentum / inertia : 0;
}

/* R, v_n and v_t of one particle. */
static void polar(const dl_scene *scene, const double *y_all, const dl_motion *motion, size_t i,
                  double out[3]) {
    const size_t n = scene->particles, components = (size_t)scene->dimension;
    const double x = y_all[i] - motion->centre[0], y = y_all[n + i] - motion->centre[1];
    const double vx = y_all[components * n + i] - motion->velocity[0];
    const double vy = y_all[(components + 1) * n + i] - motion->velocity[1];
    const double r = sqrt(x * x + y * y);
    out[0] = r;
    out[1] = r > 0 ? (x * vx + y * vy) / r : sqrt(vx * vx + vy * vy);
    out[2] = r > 0 ? (x * vy - y * vx) / r : 0;
}

void dl_observe_polar(const dl_scene *scene, const double *y_all, const dl_motion *motion,
                      double *radius, double *normal, double *tangential) {
    double *const to[3] = {radius, normal, tangential};
    for (size_t i = 0; i < scene->particles; i++) {
        double values[3] = {0};
        if (!scene->pinned[i])
            polar(scene, y_all, motion, i, values);
        for (size_t k = 0; k < 3; k++)
            if (to[k])
                to[k][i] = values[k];
    }
}

void dl_observe_heat(const dl_scene *scene, const double *y_all, double *heat) {
    const size_t n = scene->particles;
    dl_motion motion;
    dl_observe_motion(scene, y_all, &motion);
    for (size_t i = 0; i < n; i++) {
        double values[3] = {0}, along = 0;
        if (!scene->pinned[i]) {
            polar(scene, y_all, &motion, i, values);
            along = scene->dimension == 3 ? y_all[5 * n + i] - motion.velocity[2] : 0;
        }
        const double across = values[2] - motion.angular_velocity * values[0];
        heat[i] = scene->inertia[i] / 2 * (across * across + values[1] * values[1] + along * along);
        if (scene->pinned[i])
            heat[i] = 0;
    }
}
