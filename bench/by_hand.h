/* Leap-frog written by hand for one scene each: what a model that leaves out everything else is to
 * cost. Each loop is as one would write it who has that scene alone, and nothing is observed. */
#ifndef BENCH_BY_HAND_H
#define BENCH_BY_HAND_H

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/scene.h"
#include "observe/stopwatch.h"

/* A step is over, and in memory for whoever looks, before the next one begins: without it GCC makes
 * two steps in one pass where nothing acts, which no time loop can that may be stopped after any.
 */
#define BY_HAND_STEP_ENDS() __asm__ volatile("" ::: "memory")

/* `steps` steps of length h; q, v, a [components]. */
typedef void by_hand_loop(const dl_scene *scene, size_t steps, double *restrict q,
                          double *restrict v, double *restrict a);

/* studies/leave-outs/free.yaml */
static void by_hand_free(const dl_scene *scene, size_t steps, double *restrict q,
                         double *restrict v, double *restrict a) {
    const size_t length = (size_t)scene->dimension * scene->particles;
    const double h = scene->step;
    (void)a;
    for (size_t k = 0; k < steps; k++) {
        for (size_t i = 0; i < length; i++)
            q[i] += h * v[i];
        BY_HAND_STEP_ENDS();
    }
}

/* studies/leave-outs/falling.yaml: gravity along y */
static void by_hand_falling(const dl_scene *scene, size_t steps, double *restrict q,
                            double *restrict v, double *restrict a) {
    const size_t n = scene->particles;
    const double h = scene->step, g = scene->gravity[1];
    (void)a;
    for (size_t k = 0; k < steps; k++) {
        const double gain = k ? h * g : h / 2 * g;
        for (size_t i = 0; i < n; i++)
            q[i] += h * v[i];
        for (size_t i = n; i < 2 * n; i++) {
            v[i] += gain;
            q[i] += h * v[i];
        }
        BY_HAND_STEP_ENDS();
    }
}

/* studies/stream/stream.yaml: F = -6 r^-7 + 9 r^-10, no walls */
static void by_hand_stream(const dl_scene *scene, size_t steps, double *restrict q,
                           double *restrict v, double *restrict a) {
    const size_t n = scene->particles;
    const double h = scene->step;
    for (size_t k = 0; k < steps; k++) {
        memset(a, 0, 2 * n * sizeof *a);
        for (size_t i = 0; i < n; i++)
            for (size_t j = i + 1; j < n; j++) {
                const double dx = q[i] - q[j], dy = q[n + i] - q[n + j];
                const double i2 = 1 / (dx * dx + dy * dy), i8 = i2 * i2 * i2 * i2;
                const double over_r = i8 * (9 * i2 * sqrt(i2) - 6);
                a[i] += over_r * dx;
                a[j] -= over_r * dx;
                a[n + i] += over_r * dy;
                a[n + j] -= over_r * dy;
            }
        const double kick = k ? h : h / 2;
        for (size_t i = 0; i < 2 * n; i++) {
            v[i] += kick * a[i];
            q[i] += h * v[i];
        }
        BY_HAND_STEP_ENDS();
    }
}

/* From the scene's initial state; *seconds: of the loop alone. y_final: as ours_leapfrog's, or
 * NULL.
 */
static dl_status by_hand_run(const dl_scene *scene, by_hand_loop *loop, size_t steps,
                             double *seconds, double *y_final, dl_error *error) {
    const size_t length = (size_t)scene->dimension * scene->particles;
    double *const y = malloc(3 * length * sizeof *y);
    if (!y)
        return dl_fail_memory(error, "a loop written by hand");
    memcpy(y, scene->position, length * sizeof *y);
    memcpy(y + length, scene->velocity, length * sizeof *y);
    const double began = dl_cpu_clock();
    loop(scene, steps, y, y + length, y + 2 * length);
    *seconds = dl_cpu_clock() - began;
    if (y_final)
        memcpy(y_final, y, 2 * length * sizeof *y);
    free(y);
    return DL_OK;
}

#endif
