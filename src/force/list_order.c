#include "force/list_order.h"

#include <stdlib.h>

/* Fewer lie in the second-level cache in any order. */
enum { ORDER_FROM = 20000 };

bool dl_list_is_scattered(const dl_list *list, const dl_pair_problem *problem) {
    if (problem->particles < ORDER_FROM)
        return false;
    double sum = 0;
    for (size_t i = 0; i < problem->moving; i++)
        for (int k = list->start[i]; k < list->start[i + 1]; k++)
            sum += list->neighbour[k] - (double)i;
    /* a third of the particles lie between two that are drawn at random */
    return sum > 0.2 * (double)problem->particles * list->start[problem->moving];
}

static dl_status allocate(dl_list_order *order, const dl_pair_problem *problem, dl_error *error) {
    const size_t n = problem->particles, block = (size_t)problem->dimension * n;
    order->particle = malloc(n * sizeof *order->particle);
    order->x = malloc(block * sizeof *order->x);
    order->delta = malloc(block * sizeof *order->delta); /* untouched memory until it is used */
    order->f = malloc(block * sizeof *order->f);
    if (problem->coupling)
        order->coupling = calloc(n + DL_VECTOR_PAD, sizeof *order->coupling);
    if (problem->species_of)
        order->species_of = malloc(n * sizeof *order->species_of);
    if (!order->particle || !order->x || !order->delta || !order->f ||
        (problem->coupling && !order->coupling) || (problem->species_of && !order->species_of))
        return dl_fail_memory(error, "the neighbour list's order");
    order->problem = *problem;
    order->problem.coupling = order->coupling;
    order->problem.species_of = order->species_of;
    return DL_OK;
}

dl_status dl_list_order_set(dl_list_order *order, const dl_pair_problem *problem, dl_cells *cells,
                            const double *x, double reach, dl_error *error) {
    const size_t n = problem->particles;
    dl_status status = order->particle ? DL_OK : allocate(order, problem, error);
    if (status == DL_OK)
        status = dl_cells_fill(cells, x, problem->dimension, n, reach, problem->box, error);
    if (status != DL_OK)
        return status;
    size_t moving = 0, pinned = problem->moving;
    for (size_t m = 0; m < n; m++) {
        const int particle = cells->member[m];
        order->particle[(size_t)particle < problem->moving ? moving++ : pinned++] = particle;
    }
    for (size_t k = 0; k < n; k++) {
        if (order->coupling)
            order->coupling[k] = problem->coupling[order->particle[k]];
        if (order->species_of)
            order->species_of[k] = problem->species_of[order->particle[k]];
    }
    return DL_OK;
}

void dl_list_order_release(dl_list_order *order) {
    free(order->particle);
    free(order->x);
    free(order->delta);
    free(order->f);
    free(order->coupling);
    free(order->species_of);
}

void dl_list_order_gather(const dl_list_order *order, const double *from, double *to) {
    const size_t n = order->problem.particles;
    for (size_t c = 0; c < (size_t)order->problem.dimension; c++)
        for (size_t k = 0; k < n; k++)
            to[c * n + k] = from[c * n + (size_t)order->particle[k]];
}

void dl_list_order_scatter(const dl_list_order *order, double *f) {
    const size_t n = order->problem.particles;
    for (size_t c = 0; c < (size_t)order->problem.dimension; c++)
        for (size_t k = 0; k < n; k++)
            f[c * n + (size_t)order->particle[k]] = order->f[c * n + k];
}
