#include "force/padded_arrays.h"

#include <stdlib.h>
#include <string.h>

static double *aligned_zeros(size_t count) {
    size_t bytes = (count * sizeof(double) + 63) / 64 * 64;
    double *memory = aligned_alloc(64, bytes);
    if (memory)
        memset(memory, 0, bytes);
    return memory;
}

static dl_status order_by_species(const dl_pair_problem *p, dl_padded_arrays *arrays,
                                  dl_error *error) {
    size_t next = 0;
    arrays->order = calloc(p->particles, sizeof *arrays->order);
    if (p->coupling)
        arrays->coupling = aligned_zeros(arrays->stride);
    if (!arrays->order || (p->coupling && !arrays->coupling))
        return dl_fail_memory(error, "the force kernel's order of particles");
    for (int pinned = 0; pinned <= 1; pinned++)
        for (int species = 0; species < (int)p->species; species++)
            for (size_t i = pinned ? p->moving : 0; i < (pinned ? p->particles : p->moving); i++)
                if (p->species_of[i] == species)
                    arrays->order[next++] = i;
    for (size_t k = 0; p->coupling && k < p->particles; k++)
        arrays->coupling[k] = p->coupling[arrays->order[k]];
    return DL_OK;
}

dl_status dl_padded_create(const dl_pair_problem *problem, dl_padded_arrays *arrays,
                           dl_error *error) {
    size_t dimension = (size_t)problem->dimension;
    arrays->stride = (problem->particles + (size_t)2 * DL_VECTOR_PAD) / 8 * 8;
    arrays->x = aligned_zeros(dimension * arrays->stride);
    arrays->f = aligned_zeros(dimension * arrays->stride);
    arrays->buffer = aligned_zeros(dl_row_buffer_size(problem->particles));
    arrays->delta = NULL;
    if (!arrays->x || !arrays->f || !arrays->buffer)
        return dl_fail_memory(error, "the force kernel's arrays");
    return problem->species_of ? order_by_species(problem, arrays, error) : DL_OK;
}

void dl_padded_destroy(dl_padded_arrays *arrays) {
    free(arrays->x);
    free(arrays->f);
    free(arrays->delta);
    free(arrays->buffer);
    free(arrays->order);
    free(arrays->coupling);
}

static void copy_in(const dl_padded_arrays *arrays, const double *from, size_t count, double *to) {
    if (!arrays->order)
        memcpy(to, from, count * sizeof *to);
    else
        for (size_t k = 0; k < count; k++)
            to[k] = from[arrays->order[k]];
}

dl_status dl_padded_load(dl_kernel *kernel, dl_padded_arrays *arrays, const double *x,
                         const double *delta, dl_pair_arrays *pairs, dl_error *error) {
    const dl_pair_problem *p = &kernel->problem;
    size_t stride = arrays->stride, dimension = (size_t)p->dimension, n = p->particles;
    if (delta && !arrays->delta) {
        arrays->delta = aligned_zeros(dimension * stride);
        if (!arrays->delta)
            return dl_fail_memory(error, "the discrete force's arrays");
    }
    *pairs = (dl_pair_arrays){
        .dimension = p->dimension,
        .particles = n,
        .coupling = arrays->coupling ? arrays->coupling : p->coupling,
        .buffer = arrays->buffer,
        .box = p->box,
        .law = p->law,
        .loops = kernel->loops[0],
    };
    for (size_t c = 0; c < dimension; c++) {
        copy_in(arrays, x + c * n, n, arrays->x + c * stride);
        pairs->x[c] = arrays->x + c * stride;
        pairs->f[c] = arrays->f + c * stride;
        if (delta) {
            copy_in(arrays, delta + c * n, n, arrays->delta + c * stride);
            pairs->delta[c] = arrays->delta + c * stride;
        }
    }
    memset(arrays->f, 0, dimension * stride * sizeof *arrays->f);
    return DL_OK;
}

void dl_padded_unload(const dl_kernel *kernel, const dl_padded_arrays *arrays, double *f) {
    size_t n = kernel->problem.particles;
    for (size_t c = 0; c < (size_t)kernel->problem.dimension; c++) {
        const double *from = arrays->f + c * arrays->stride;
        if (!arrays->order)
            memcpy(f + c * n, from, n * sizeof *f);
        else
            for (size_t k = 0; k < n; k++)
                f[c * n + arrays->order[k]] = from[k];
    }
}
