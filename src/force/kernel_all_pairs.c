/* All pairs, vectorised over the partners of a particle, with Newton's third law. */
#include <stdlib.h>
#include "force/padded_arrays.h"

static dl_status create(dl_kernel *kernel, dl_error *error) {
    dl_padded_arrays *arrays = calloc(1, sizeof *arrays);
    kernel->data = arrays;
    if (!arrays)
        return dl_fail_memory(error, "the all-pairs kernel");
    return dl_padded_create(&kernel->problem, arrays, error);
}

static void destroy(dl_kernel *kernel) {
    if (kernel->data)
        dl_padded_destroy(kernel->data);
    free(kernel->data);
}

static dl_status force(dl_kernel *kernel, const double *x, double *f, dl_error *error) {
    dl_pair_arrays pairs;
    dl_status status = dl_padded_load(kernel, kernel->data, x, NULL, &pairs, error);
    if (status != DL_OK)
        return status;
    kernel->vector->all_pairs(&pairs);
    dl_padded_unload(kernel, kernel->data, f);
    return DL_OK;
}

static dl_status discrete(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error) {
    dl_pair_arrays pairs;
    dl_status status = dl_padded_load(kernel, kernel->data, x, delta, &pairs, error);
    if (status != DL_OK)
        return status;
    kernel->vector->all_pairs_discrete(&pairs);
    dl_padded_unload(kernel, kernel->data, f);
    return DL_OK;
}

static dl_status rows(dl_kernel *kernel, const double *x, const double *delta, dl_pair_rows *out,
                      dl_error *error) {
    (void)kernel;
    (void)x;
    (void)delta;
    (void)error;
    *out = (dl_pair_rows){NULL, NULL, 1};
    return DL_OK;
}

const dl_kernel_ops dl_kernel_all_pairs = {
    .name = "all-pairs",
    .doc = "every pair once, vectorised over partners",
    .create = create,
    .force = force,
    .discrete = discrete,
    .rows = rows,
    .destroy = destroy,
};
