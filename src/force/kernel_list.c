/* Neighbour list: pairs within cutoff + skin, valid until a particle has moved half the skin from
 * where it was when the list was built. The test runs at every call, because implicit and adaptive
 * methods move where they like. */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "force/cells.h"
#include "force/kernel.h"
#include "force/list_order.h"
#include "force/list_parts.h"
#include "force/pair_alone.h"

/* Skin as a part of the cutoff where the scene does not say: the fastest, within noise, on the
 * settled fluid of TR323 (bench/). */
static const double default_skin = 0.4;

typedef struct list_data {
    dl_cells cells;
    dl_list list;
    dl_list_parts parts; /* of the list, where species differ */
    dl_list_order order; /* of many particles that lie scattered in memory; the list is in it */
    dl_list own_rows;    /* then: the list in the particles' own order, where it is asked for */
    unsigned long own_generation; /* of own_rows: list_builds */
    double reach, half_skin;
    double built_reach; /* of the list as it is */
    bool built;
    double *origin; /* positions at the last build */
    double *end;    /* x + delta of a discrete force */
    double *buffer; /* scratch of the pair loops */
} list_data;

static dl_status create(dl_kernel *kernel, dl_error *error) {
    const dl_pair_problem *p = &kernel->problem;
    list_data *data = calloc(1, sizeof *data);
    kernel->data = data;
    if (!data)
        return dl_fail_memory(error, "the neighbour-list kernel");
    double skin = p->skin > 0 ? p->skin : default_skin * p->reach;
    data->reach = p->reach + skin;
    data->half_skin = skin / 2;
    size_t block = (size_t)p->dimension * p->particles;
    data->origin = malloc(block * sizeof(double));
    data->end = malloc(block * sizeof(double));
    data->buffer = malloc(dl_row_buffer_size(0) * sizeof(double));
    if (!data->origin || !data->end || !data->buffer)
        return dl_fail_memory(error, "the neighbour-list kernel");
    memset(data->buffer, 0, dl_row_buffer_size(0) * sizeof(double));
    return dl_list_parts_create(p, &data->parts, error);
}

static void destroy(dl_kernel *kernel) {
    list_data *data = kernel->data;
    if (!data)
        return;
    dl_cells_release(&data->cells, &data->list);
    dl_list_parts_release(&data->parts);
    dl_list_order_release(&data->order);
    dl_cells_release(&(dl_cells){0}, &data->own_rows);
    free(data->origin);
    free(data->end);
    free(data->buffer);
    free(data);
}

static void components(const dl_pair_problem *p, const double *block, const double *part[3]) {
    for (int c = 0; c < p->dimension; c++)
        part[c] = block + (size_t)c * p->particles;
}

static bool still_valid(const dl_kernel *kernel, const double *x) {
    const list_data *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    const double *now[3], *then[3];
    components(p, x, now);
    components(p, data->origin, then);
    return data->built &&
           !kernel->vector->moved(now, then, p->dimension, p->particles, data->half_skin);
}

/* The problem in the order that the list is in. */
static const dl_pair_problem *ordered(const dl_kernel *kernel) {
    const list_data *data = kernel->data;
    return data->order.particle ? &data->order.problem : &kernel->problem;
}

static dl_status build_ordered(dl_kernel *kernel, const double *x, dl_error *error) {
    list_data *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    dl_status status =
        dl_list_order_set(&data->order, p, &data->cells, x, data->built_reach, error);
    if (status != DL_OK)
        return status;
    dl_list_order_gather(&data->order, x, data->order.x);
    return dl_cells_build(&data->cells, &data->list, data->order.x, p->dimension, p->particles,
                          p->moving, data->built_reach, p->box, error);
}

/* Once an order has paid it is kept up, build by build. */
static dl_status build_list(dl_kernel *kernel, const double *x, dl_error *error) {
    list_data *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    if (data->order.particle)
        return build_ordered(kernel, x, error);
    const dl_status status =
        dl_cells_build(&data->cells, &data->list, x, p->dimension, p->particles, p->moving,
                       data->built_reach, p->box, error);
    if (status != DL_OK || !dl_list_is_scattered(&data->list, p))
        return status;
    return build_ordered(kernel, x, error);
}

/* A list around x that also holds whatever acts at `end`: the reach grows by twice the way there
 * where that is longer than half a skin. */
static dl_status build(dl_kernel *kernel, const double *x, const double *end, dl_error *error) {
    list_data *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    size_t block = (size_t)p->dimension * p->particles;
    double reach = data->reach;
    if (end) {
        double longest = 0;
        for (size_t i = 0; i < p->particles; i++) {
            double s = 0;
            for (size_t c = 0; c < (size_t)p->dimension; c++) {
                double d = end[c * p->particles + i] - x[c * p->particles + i];
                s += d * d;
            }
            if (!isfinite(s))
                return dl_fail(error, DL_UNSTABLE, "position of particle %zu is not finite", i);
            longest = fmax(longest, s);
        }
        reach += fmax(0, 2 * sqrt(longest) - data->half_skin);
    }
    data->built = false;
    data->built_reach = reach;
    dl_status status = build_list(kernel, x, error);
    if (status == DL_OK)
        status = dl_list_parts_fill(ordered(kernel), &data->list, &data->parts, error);
    if (status != DL_OK)
        return status;
    memcpy(data->origin, x, block * sizeof *x);
    data->built = true;
    kernel->list_builds++;
    return DL_OK;
}

static dl_status refresh(dl_kernel *kernel, const double *x, dl_error *error) {
    return still_valid(kernel, x) ? DL_OK : build(kernel, x, NULL, error);
}

/* The list must hold whatever acts at the start or the end of the step. */
static dl_status refresh_step(dl_kernel *kernel, const double *x, const double *delta,
                              dl_error *error) {
    list_data *data = kernel->data;
    size_t block = (size_t)kernel->problem.dimension * kernel->problem.particles;
    for (size_t k = 0; k < block; k++)
        data->end[k] = x[k] + delta[k];
    if (still_valid(kernel, x) && still_valid(kernel, data->end))
        return DL_OK;
    return build(kernel, x, data->end, error);
}

typedef void list_loop(const dl_pair_arrays *arrays, const dl_neighbours *neighbours);

/* x, delta and f in the list's order. */
static void sum_ordered(const dl_kernel *kernel, const double *x, const double *delta, double *f) {
    const dl_pair_problem *p = ordered(kernel);
    const list_data *data = kernel->data;
    list_loop *loop = delta ? kernel->vector->list_discrete : kernel->vector->list;
    const int moving = (int)p->moving;
    dl_pair_arrays pairs = {
        .dimension = p->dimension,
        .particles = p->particles,
        .coupling = p->coupling,
        .buffer = data->buffer,
        .box = p->box,
        .law = p->law,
        .loops = kernel->loops[0],
    };
    components(p, x, pairs.x);
    if (delta)
        components(p, delta, pairs.delta);
    for (int c = 0; c < p->dimension; c++)
        pairs.f[c] = f + (size_t)c * p->particles;
    memset(f, 0, (size_t)p->dimension * p->particles * sizeof *f);
    if (data->parts.count == 0)
        loop(&pairs, &(dl_neighbours){data->list.start, data->list.neighbour, 0, moving, true});
    for (size_t k = 0; k < data->parts.count; k++) {
        const dl_list *part = &data->parts.part[k];
        pairs.law = &p->law[k];
        pairs.loops = kernel->loops[k];
        if (pairs.law->pieces > 0)
            loop(&pairs, &(dl_neighbours){part->start, part->neighbour, 0, moving, true});
    }
}

static void sum_pairs(const dl_kernel *kernel, const double *x, const double *delta, double *f) {
    const list_data *data = kernel->data;
    const dl_list_order *order = &data->order;
    if (!order->particle) {
        sum_ordered(kernel, x, delta, f);
        return;
    }
    dl_list_order_gather(order, x, order->x);
    if (delta)
        dl_list_order_gather(order, delta, order->delta);
    sum_ordered(kernel, order->x, delta ? order->delta : NULL, order->f);
    dl_list_order_scatter(order, f);
}

static dl_status force(dl_kernel *kernel, const double *x, double *f, dl_error *error) {
    dl_status status = refresh(kernel, x, error);
    if (status == DL_OK)
        sum_pairs(kernel, x, NULL, f);
    return status;
}

static dl_status discrete(dl_kernel *kernel, const double *x, const double *delta, double *f,
                          dl_error *error) {
    dl_status status = refresh_step(kernel, x, delta, error);
    if (status == DL_OK)
        sum_pairs(kernel, x, delta, f);
    return status;
}

static void pair(dl_kernel *kernel, const double *x, const double *delta, size_t i, size_t j,
                 double *f) {
    static const int start[] = {0, 1}, neighbour[] = {1};
    const list_data *data = kernel->data;
    list_loop *loop = delta ? kernel->vector->list_discrete : kernel->vector->list;
    dl_pair_alone alone;
    dl_pair_alone_load(kernel, x, delta, i, j, data->buffer, &alone);
    loop(&alone.arrays, &(dl_neighbours){start, neighbour, 0, 1, true});
    for (int c = 0; c < kernel->problem.dimension; c++)
        f[c] = alone.f[c][0];
}

/* The list in the particles' own order, where it is in another. */
static dl_status find_own_rows(dl_kernel *kernel, dl_error *error) {
    list_data *data = kernel->data;
    const dl_pair_problem *p = &kernel->problem;
    if (data->own_generation == kernel->list_builds)
        return DL_OK;
    const dl_status status =
        dl_cells_build(&data->cells, &data->own_rows, data->origin, p->dimension, p->particles,
                       p->moving, data->built_reach, p->box, error);
    if (status == DL_OK)
        data->own_generation = kernel->list_builds;
    return status;
}

static dl_status rows(dl_kernel *kernel, const double *x, const double *delta, dl_pair_rows *out,
                      dl_error *error) {
    const list_data *data = kernel->data;
    dl_status status = delta ? refresh_step(kernel, x, delta, error) : refresh(kernel, x, error);
    const dl_list *list = &data->list;
    if (status == DL_OK && data->order.particle) {
        status = find_own_rows(kernel, error);
        list = &data->own_rows;
    }
    *out = (dl_pair_rows){list->start, list->neighbour, kernel->list_builds};
    return status;
}

const dl_kernel_ops dl_kernel_neighbour_list = {
    .name = "neighbour-list",
    .doc = "cells and a half list within cutoff + skin, rebuilt when a particle has moved half the "
           "skin",
    .create = create,
    .force = force,
    .discrete = discrete,
    .pair = pair,
    .rows = rows,
    .destroy = destroy,
};
