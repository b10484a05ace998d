#include "force/pair_alone.h"

void dl_pair_alone_load(const dl_kernel *kernel, const double *x, const double *delta, size_t i,
                        size_t j, double *buffer, dl_pair_alone *alone) {
    const dl_pair_problem *p = &kernel->problem;
    const size_t law = dl_pair_law_index(p, i, j);
    *alone = (dl_pair_alone){
        .arrays = {.dimension = p->dimension,
                   .particles = 2,
                   .buffer = buffer,
                   .box = p->box,
                   .law = &p->law[law],
                   .loops = kernel->loops[law]},
    };
    if (p->coupling) {
        alone->coupling[0] = p->coupling[i];
        alone->coupling[1] = p->coupling[j];
        alone->arrays.coupling = alone->coupling;
    }
    for (size_t c = 0; c < (size_t)p->dimension; c++) {
        alone->x[c][0] = x[c * p->particles + i];
        alone->x[c][1] = x[c * p->particles + j];
        alone->arrays.x[c] = alone->x[c];
        alone->arrays.f[c] = alone->f[c];
        if (!delta)
            continue;
        alone->delta[c][0] = delta[c * p->particles + i];
        alone->delta[c][1] = delta[c * p->particles + j];
        alone->arrays.delta[c] = alone->delta[c];
    }
}
