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
    return DL_OK;
}

void dl_padded_destroy(dl_padded_arrays *arrays) {
    free(arrays->x);
    free(arrays->f);
    free(arrays->delta);
    free(arrays->buffer);
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
        .moving = p->moving,
        .coupling = p->coupling,
        .buffer = arrays->buffer,
        .law = p->law,
        .loops = kernel->loops,
    };
    for (size_t c = 0; c < dimension; c++) {
        memcpy(arrays->x + c * stride, x + c * n, n * sizeof *x);
        pairs->x[c] = arrays->x + c * stride;
        pairs->f[c] = arrays->f + c * stride;
        if (delta) {
            memcpy(arrays->delta + c * stride, delta + c * n, n * sizeof *x);
            pairs->delta[c] = arrays->delta + c * stride;
        }
    }
    memset(arrays->f, 0, dimension * stride * sizeof *arrays->f);
    return DL_OK;
}

void dl_padded_unload(const dl_kernel *kernel, const dl_padded_arrays *arrays, double *f) {
    size_t n = kernel->problem.particles;
    for (size_t c = 0; c < (size_t)kernel->problem.dimension; c++)
        memcpy(f + c * n, arrays->f + c * arrays->stride, n * sizeof *f);
}
