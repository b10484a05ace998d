/* Forces of large scenes: the tree beside all pairs, in time for each particle, and how both grow
 * with their number.
 *
 *     bench_tree [--quick]
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/model.h"
#include "force/kernel.h"
#include "observe/stopwatch.h"

enum { SIZES = 4, REPEATS = 3 };

typedef struct gas {
    dl_scene scene;
    double *block;
    bool *flags;
} gas;

static double scattered(size_t i, double step) {
    const double x = step * (double)(i + 1) + 0.13 * sin(3.7 * (double)i + step);
    return x - floor(x);
}

/* Particles of unit density that attract one another by 1/r^2. */
static dl_status gas_create(int dimension, size_t particles, double error_stated, gas *made,
                            dl_error *error) {
    static const double step[] = {0.7548776662466927, 0.5698402909980532, 0.3819660112501051};
    static char name[] = "gas", empty[] = "";
    const size_t length = (size_t)dimension * particles;
    *made = (gas){.block = calloc(2 * length + 2 * particles, sizeof(double)),
                  .flags = calloc(2 * particles, sizeof(bool))};
    if (!made->block || !made->flags)
        return dl_fail_memory(error, "a scene");
    dl_scene *const scene = &made->scene;
    scene->name = name;
    scene->source = scene->file = scene->text = empty;
    scene->dimension = dimension;
    scene->particles = particles;
    scene->position = made->block;
    scene->velocity = made->block + length;
    scene->inertia = made->block + 2 * length;
    scene->coupling = scene->inertia + particles;
    scene->pinned = made->flags;
    scene->feels_gravity = made->flags + particles;
    for (size_t i = 0; i < particles; i++) {
        scene->inertia[i] = scene->coupling[i] = 1;
        for (size_t c = 0; c < (size_t)dimension; c++)
            scene->position[c * particles + i] =
                pow((double)particles, 1.0 / dimension) * scattered(i, step[c]);
    }
    scene->law.pieces = 1;
    scene->law.piece[0] =
        (dl_piece){.until = INFINITY, .terms = 1, .term = {{.coefficient = -1, .power = 2}}};
    scene->tree_error = error_stated;
    return DL_OK;
}

static void gas_release(gas *made) {
    free(made->block);
    free(made->flags);
}

typedef struct timing {
    double nanoseconds; /* for each particle, the least */
    dl_force_error error;
    double near_pairs, far_pairs; /* for each particle */
} timing;

static dl_status measure(dl_scene *scene, dl_kernel_choice kernel, timing *result,
                         dl_error *error) {
    dl_model *model = NULL;
    scene->kernel = kernel;
    *result = (timing){.nanoseconds = INFINITY};
    dl_status status = dl_model_create(scene, &model, error);
    double *const a = malloc((size_t)scene->dimension * scene->particles * sizeof *a);
    const double each = 1 / (double)scene->particles;
    for (int k = 0; k < REPEATS && !status && a; k++) {
        model->kernel->near_pairs = model->kernel->far_pairs = 0;
        const double began = dl_cpu_clock();
        status = dl_model_acceleration(model, scene->position, a, error);
        result->nanoseconds = fmin(result->nanoseconds, (dl_cpu_clock() - began) * 1e9 * each);
    }
    if (!status && a) {
        result->near_pairs = (double)model->kernel->near_pairs * each;
        result->far_pairs = (double)model->kernel->far_pairs * each;
        status = dl_model_force_error(model, scene->position, &result->error, error);
    }
    free(a);
    dl_model_free(model);
    return status || a ? status : dl_fail_memory(error, "accelerations");
}

/* Of the total cost, from one size to the next. */
static double exponent(double before, double now, size_t ratio) {
    return 1 + log(now / before) / log((double)ratio);
}

static dl_status bench_row(int dimension, size_t particles, double error_stated,
                           bool with_all_pairs, double *before, dl_error *error) {
    gas made;
    timing tree, pairs = {.nanoseconds = NAN};
    dl_status status = gas_create(dimension, particles, error_stated, &made, error);
    if (!status)
        status = measure(&made.scene, DL_KERNEL_TREE, &tree, error);
    if (!status && with_all_pairs)
        status = measure(&made.scene, DL_KERNEL_ALL_PAIRS, &pairs, error);
    gas_release(&made);
    if (status)
        return status;
    char grows[24] = "", all[24] = "", ratio[24] = "";
    if (*before > 0)
        snprintf(grows, sizeof grows, "%.2f", exponent(*before, tree.nanoseconds, 4));
    if (with_all_pairs) {
        snprintf(all, sizeof all, "%.0f", pairs.nanoseconds);
        snprintf(ratio, sizeof ratio, "%.2f", pairs.nanoseconds / tree.nanoseconds);
    }
    printf("| %d | %zu | %.0e | %.1e | %.1e | %.0f | %.0f | %.2f | %s | %s | %s |\n", dimension,
           particles, error_stated, tree.error.largest, tree.error.mean, tree.nanoseconds,
           tree.near_pairs, tree.far_pairs, grows, all, ratio);
    fflush(stdout);
    *before = tree.nanoseconds;
    return DL_OK;
}

int main(int argc, char **argv) {
    static const double errors[] = {1e-3, 1e-6};
    const bool quick = argc == 2 && strcmp(argv[1], "--quick") == 0;
    dl_error error = {""};
    dl_status status = DL_OK;
    if (argc > 2 || (argc == 2 && !quick)) {
        fputs("usage: bench_tree [--quick]\n", stderr);
        return 2;
    }
    printf("| dimension | particles | error stated | largest | mean | ns/particle | pairs of "
           "particles | of cells | exponent | all pairs, ns/particle | ratio |\n"
           "|---|---|---|---|---|---|---|---|---|---|---|\n");
    for (int dimension = 2; dimension <= 3 && !status; dimension++)
        for (size_t e = 0; e < sizeof errors / sizeof *errors && !status; e++) {
            double before = 0;
            size_t particles = quick ? 500 : 10000;
            for (int k = 0; k < (quick ? 2 : SIZES) && !status; k++, particles *= 4)
                status =
                    bench_row(dimension, particles, errors[e], particles <= 40000, &before, &error);
        }
    if (status)
        fprintf(stderr, "bench_tree: %s\n", error.message);
    return status ? 1 : 0;
}
