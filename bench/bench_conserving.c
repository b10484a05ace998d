/* The conserving step by the clock: what it costs, in how many discrete forces, and how much more
 * than they do; leap-frog beside it, and PETSc's TSDISCGRAD where petsc_stream has been built. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "ours.h"

typedef struct bench_case {
    const char *scene, *method;
    size_t steps;
    double most_ratio;        /* of the step over its discrete forces; 0: no bound */
    double most_microseconds; /* a step; 0: no bound */
} bench_case;

static const char stream[] = DL_STUDIES "/stream/stream.yaml";
static const char crystal[] = DL_STUDIES "/../bench/scenes/crystal_9919.yaml";
static const char large_crystal[] = DL_STUDIES "/../bench/scenes/crystal_99919.yaml";

static const bench_case cases[] = {
    {stream, "leapfrog", 20000, 0, 0},
    {stream, "conserving", 20000, 3, 8},
    {stream, "conserving-fixed-point", 20000, 0, 0},
    {stream, "conserving-newton-klu", 5000, 0, 60},
    {stream, "conserving-newton-dense", 5000, 0, 0},
    {stream, "conserving-newton-krylov", 2000, 0, 0},
    {crystal, "leapfrog", 100, 0, 0},
    {crystal, "conserving", 50, 1.5, 0},
    {crystal, "conserving-fixed-point", 50, 1.5, 0},
    {crystal, "conserving-newton-krylov", 5, 0, 0},
    {large_crystal, "conserving", 5, 1.5, 1e6},
};

enum { repeats = 5 };

/* What a mean force and a Jacobian cost at the scene's start, over its first step; seconds. */
typedef struct unit_costs {
    double discrete, assembly;
    size_t pairs; /* that the kernel looks at */
} unit_costs;

static double shorter(double a, double b) {
    return a < b ? a : b;
}

static size_t count_pairs(const dl_model *model, const dl_pair_rows *rows) {
    return rows->start ? (size_t)rows->start[model->moving]
                       : model->moving * (2 * model->particles - model->moving - 1) / 2;
}

static dl_status time_discrete(dl_model *model, const double *q, const double *delta, double *a,
                               unit_costs *costs, dl_error *error) {
    const size_t calls = 1 + 200000 / model->unknowns;
    dl_status status = DL_OK;
    costs->discrete = costs->assembly = INFINITY;
    for (int r = 0; r < repeats && !status; r++) {
        const double began = dl_cpu_clock();
        for (size_t k = 0; k < calls && !status; k++)
            status = dl_model_discrete_acceleration(model, q, delta, a, error);
        costs->discrete = shorter(costs->discrete, (dl_cpu_clock() - began) / (double)calls);
    }
    return status;
}

static dl_status time_assembly(dl_model *model, const double *q, const double *delta,
                               unit_costs *costs, dl_error *error) {
    const dl_sparsity *sparsity;
    dl_status status = dl_model_sparsity(model, q, delta, &sparsity, error);
    double *const values = status ? NULL : malloc((sparsity->nonzeros + 1) * sizeof *values);
    if (!status && !values)
        status = dl_fail_memory(error, "a Jacobian");
    for (int r = 0; r < repeats && !status; r++) {
        const double began = dl_cpu_clock();
        status = dl_model_discrete_jacobian(model, q, delta, values, error);
        costs->assembly = shorter(costs->assembly, dl_cpu_clock() - began);
    }
    free(values);
    return status;
}

static dl_status measure_units(const dl_scene *scene, unit_costs *costs, dl_error *error) {
    ours_force force;
    dl_pair_rows rows;
    dl_status status = ours_force_create(scene, &force, error);
    if (status)
        return status;
    dl_model *const model = force.model;
    const size_t n = model->unknowns;
    double *const delta = force.q + n; /* from velocities to displacements */
    double linear[3], angular[3];
    dl_model_momentum(model, force.q, linear, angular);
    for (size_t u = 0; u < n; u++)
        delta[u] = scene->step * (delta[u] - linear[u / model->moving] / dl_model_inertia(model));
    status = time_discrete(model, force.q, delta, force.a, costs, error);
    status = status ? status : time_assembly(model, force.q, delta, costs, error);
    status =
        status ? status : model->kernel->ops->rows(model->kernel, force.q, delta, &rows, error);
    costs->pairs = status ? 0 : count_pairs(model, &rows);
    ours_force_release(&force);
    return status;
}

static const char *judge(double value, double most) {
    return most > 0 ? value <= most ? "yes" : "NO" : "-";
}

static void print_row(const dl_scene *scene, const bench_case *one, const unit_costs *costs,
                      const dl_run_summary *run) {
    const double steps = (double)run->steps, each = run->cpu_seconds / steps;
    const double forces = (double)run->force_evaluations / steps;
    const double jacobians = (double)run->jacobian_evaluations / steps;
    const double ratio = each / (forces * costs->discrete);
    const bool implicit = run->nonlinear_iterations > 0;
    printf("| %-13s | %-24s | %10.2f | %5.2f |", scene->name, one->method, each * 1e6, forces);
    if (implicit)
        printf(" %5.2f | %5.2f | %4.1f %% |", costs->discrete * 1e9 / (double)costs->pairs, ratio,
               100 * jacobians * costs->assembly / each);
    else
        printf("     - |     - |      - |");
    printf(" %7s | %7s |\n", judge(ratio, one->most_ratio),
           judge(each * 1e6, one->most_microseconds));
}

static dl_status run_case(const bench_case *one, dl_error *error) {
    dl_scene *scene = NULL;
    unit_costs costs;
    dl_run_summary run, best = {.cpu_seconds = INFINITY};
    dl_status status = dl_scene_read(one->scene, &scene, error);
    if (status)
        return status;
    status = measure_units(scene, &costs, error);
    for (int r = 0; r < repeats && !status; r++) {
        status = ours_run(scene, one->method, one->steps, &run, NULL, error);
        best = !status && run.cpu_seconds < best.cpu_seconds ? run : best;
    }
    if (!status)
        print_row(scene, one, &costs, &best);
    dl_scene_free(scene);
    return status;
}

/* PETSc's program beside ours, or nothing. */
static dl_status run_petsc(const char *program, dl_error *error) {
    dl_scene *scene = NULL;
    char command[4096];
    dl_status status = dl_scene_read(stream, &scene, error);
    if (status)
        return status;
    const size_t n = scene->particles;
    snprintf(command, sizeof command, "exec '%s' %zu %.17g 200", program, n, scene->step);
    fflush(stdout);
    FILE *const peer = popen(command, "w");
    for (size_t i = 0; peer && i < n; i++)
        fprintf(peer, "%.17g %.17g %.17g %.17g\n", scene->position[i], scene->position[n + i],
                scene->velocity[i], scene->velocity[n + i]);
    if (!peer || pclose(peer) != 0)
        status = dl_fail(error, DL_ERROR, "%s: failed", program);
    dl_scene_free(scene);
    return status;
}

int main(int argc, char **argv) {
    dl_error error = {""};
    dl_status status = DL_OK;
    if (argc > 2 || (argc == 2 && argv[1][0] == '-')) {
        fprintf(stderr, "usage: bench_conserving [PETSC_STREAM]\n");
        return 2;
    }
    printf("Minima of %d; bounds: step over its forces, microseconds\n\n"
           "| scene | method | us/step | forces/step | ns/pair | step/forces | assembly | ratio "
           "met | time met |\n|---|---|---|---|---|---|---|---|---|\n",
           repeats);
    setvbuf(stdout, NULL, _IOLBF, 0);
    for (size_t k = 0; k < sizeof cases / sizeof *cases && !status; k++)
        status = run_case(&cases[k], &error);
    if (!status && argc == 2)
        status = run_petsc(argv[1], &error);
    if (status)
        fprintf(stderr, "bench_conserving: %s\n", error.message);
    return status ? 1 : 0;
}
