/* All pairs, vectorised over the partners of a particle, with Newton's third law. */
#include <stdlib.h>
#include "force/padded_arrays.h"
#include "force/pair_alone.h"

/* A run of particles in the arrays' order, all of one species, moving or pinned. */
typedef struct run {
    size_t begin, end;
    int species;
} run;

typedef struct all_pairs {
    dl_padded_arrays arrays;
    size_t moving_runs, runs; /* 0 where one law holds for all pairs */
    run *run;                 /* [runs], the moving ones first */
} all_pairs;

typedef void block_loop(const dl_pair_arrays *arrays, const dl_pair_block *block);

static dl_status find_runs(const dl_pair_problem *p, all_pairs *data, dl_error *error) {
    data->run = calloc(2 * p->species, sizeof *data->run);
    if (!data->run)
        return dl_fail_memory(error, "the all-pairs kernel");
    for (size_t k = 0; k < p->particles; k++) {
        int species = p->species_of[data->arrays.order[k]];
        if (k == 0 || k == p->moving || data->run[data->runs - 1].species != species)
            data->run[data->runs++] = (run){k, k, species};
        data->run[data->runs - 1].end = k + 1;
        if (k < p->moving)
            data->moving_runs = data->runs;
    }
    return DL_OK;
}

static dl_status create(dl_kernel *kernel, dl_error *error) {
    all_pairs *data = calloc(1, sizeof *data);
    kernel->data = data;
    if (!data)
        return dl_fail_memory(error, "the all-pairs kernel");
    dl_status status = dl_padded_create(&kernel->problem, &data->arrays, error);
    if (status == DL_OK && kernel->problem.species_of)
        status = find_runs(&kernel->problem, data, error);
    return status;
}

static void destroy(dl_kernel *kernel) {
    all_pairs *data = kernel->data;
    if (!data)
        return;
    dl_padded_destroy(&data->arrays);
    free(data->run);
    free(data);
}

/* Species by species, so that each block of pairs has one law. */
static void blocks_of_species(const dl_kernel *kernel, dl_pair_arrays *pairs, block_loop *loop) {
    const all_pairs *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    for (const run *a = data->run; a < data->run + data->moving_runs; a++)
        for (const run *b = a; b < data->run + data->runs; b++) {
            size_t law = (size_t)a->species * p->species + (size_t)b->species;
            pairs->law = &p->law[law];
            pairs->loops = kernel->loops[law];
            if (pairs->law->pieces > 0)
                loop(pairs, &(dl_pair_block){a->begin, a->end, b->begin, b->end});
        }
}

static dl_status sum_pairs(dl_kernel *kernel, const double *x, const double *delta, double *f,
                           dl_error *error) {
    all_pairs *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    block_loop *loop = delta ? kernel->vector->block_discrete : kernel->vector->block;
    dl_pair_arrays pairs;
    dl_status status = dl_padded_load(kernel, &data->arrays, x, delta, &pairs, error);
    if (status != DL_OK)
        return status;
    if (data->runs == 0)
        loop(&pairs, &(dl_pair_block){0, p->moving, 0, p->particles});
    else
        blocks_of_species(kernel, &pairs, loop);
    dl_padded_unload(kernel, &data->arrays, f);
    return DL_OK;
}

static dl_status force(dl_kernel *kernel, const double *x, double *f, dl_error *error) {
    return sum_pairs(kernel, x, NULL, f, error);
}

static dl_status discrete(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error) {
    return sum_pairs(kernel, x, delta, f, error);
}

static void pair(dl_kernel *kernel, const double *x, const double *delta, size_t i, size_t j,
                 double *f) {
    const all_pairs *data = kernel->data;
    block_loop *loop = delta ? kernel->vector->block_discrete : kernel->vector->block;
    dl_pair_alone alone;
    dl_pair_alone_load(kernel, x, delta, i, j, data->arrays.buffer, &alone);
    loop(&alone.arrays, &(dl_pair_block){0, 1, 1, 2});
    for (int c = 0; c < kernel->problem.dimension; c++)
        f[c] = alone.f[c][0];
}

const dl_kernel_ops dl_kernel_all_pairs = {
    .name = "all-pairs",
    .doc = "every pair once, vectorised over partners",
    .create = create,
    .force = force,
    .discrete = discrete,
    .pair = pair,
    .rows = dl_kernel_rows_of_all,
    .destroy = destroy,
};
