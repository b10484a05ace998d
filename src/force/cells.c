#include "force/cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct grid {
    double low[3], inverse_size[3];
    int cells[3];
    size_t total;
} grid;

static dl_status check_finite(const double *x, int dimension, size_t particles, dl_error *error) {
    for (size_t i = 0; i < particles; i++)
        for (size_t c = 0; c < (size_t)dimension; c++)
            if (!isfinite(x[c * particles + i]))
                return dl_fail(error, DL_UNSTABLE, "position of particle %zu is not finite", i);
    return DL_OK;
}

/* Range of the positions along an axis. */
static void span(const double *row, size_t particles, double *low, double *high) {
    *low = *high = row[0];
    for (size_t i = 1; i < particles; i++) {
        *low = row[i] < *low ? row[i] : *low;
        *high = row[i] > *high ? row[i] : *high;
    }
}

static int widest_axis(const grid *g) {
    int widest = 0;
    for (int c = 1; c < 3; c++)
        if (g->cells[c] > g->cells[widest])
            widest = c;
    return widest;
}

/* Cells at least `reach` wide, and no more than about two a particle: runaway particles must not
 * ask for memory. */
static grid lay_grid(const double *x, int dimension, size_t particles, double reach) {
    grid g = {.cells = {1, 1, 1}};
    double most = 2.0 * (double)particles + 16, extent[3], total = 1;
    for (int c = 0; c < dimension; c++) {
        double high;
        span(x + (size_t)c * particles, particles, &g.low[c], &high);
        extent[c] = high - g.low[c];
        g.cells[c] = (int)fmax(1, fmin(floor(extent[c] / reach), most));
        total *= g.cells[c];
    }
    while (total > most) {
        int c = widest_axis(&g);
        total /= g.cells[c];
        g.cells[c] = (g.cells[c] + 1) / 2;
        total *= g.cells[c];
    }
    for (int c = 0; c < dimension; c++)
        g.inverse_size[c] = extent[c] > 0 ? g.cells[c] / extent[c] : 0;
    g.total = (size_t)g.cells[0] * (size_t)g.cells[1] * (size_t)g.cells[2];
    return g;
}

static int cell_along(const grid *g, int c, double position) {
    int k = (int)((position - g->low[c]) * g->inverse_size[c]);
    return k < g->cells[c] ? k : g->cells[c] - 1;
}

static dl_status reserve(dl_cells *cells, dl_list *list, const grid *g, size_t particles,
                         size_t moving, dl_error *error) {
    if (!cells->member) {
        cells->member = malloc(particles * sizeof(int));
        cells->cell_of = malloc(particles * sizeof(int));
        list->start = malloc((moving + 1) * sizeof(int));
    }
    if (cells->cell_capacity < g->total + 1) {
        free(cells->cell_start);
        cells->cell_start = malloc((g->total + 1) * sizeof(int));
        cells->cell_capacity = cells->cell_start ? g->total + 1 : 0;
    }
    if (!cells->member || !cells->cell_of || !list->start || !cells->cell_start)
        return dl_fail_memory(error, "the cells of the neighbour list");
    return DL_OK;
}

/* Counting sort of the particles by cell. */
static void fill_cells(dl_cells *cells, const grid *g, const double *x, int dimension,
                       size_t particles) {
    memset(cells->cell_start, 0, (g->total + 1) * sizeof(int));
    for (size_t i = 0; i < particles; i++) {
        int cell = 0;
        for (int c = dimension - 1; c >= 0; c--)
            cell = cell * g->cells[c] + cell_along(g, c, x[(size_t)c * particles + i]);
        cells->cell_of[i] = cell;
        cells->cell_start[cell + 1]++;
    }
    for (size_t k = 0; k < g->total; k++)
        cells->cell_start[k + 1] += cells->cell_start[k];
    for (size_t i = particles; i-- > 0;)
        cells->member[--cells->cell_start[cells->cell_of[i] + 1]] = (int)i;
    /* cell_start[k + 1] now holds the start of cell k */
    memmove(cells->cell_start, cells->cell_start + 1, g->total * sizeof(int));
    cells->cell_start[g->total] = (int)particles;
}

static dl_status grow(dl_list *list, size_t need, dl_error *error) {
    if (need <= list->capacity)
        return DL_OK;
    size_t capacity = need * 2;
    int *larger = realloc(list->neighbour, capacity * sizeof(int));
    if (!larger)
        return dl_fail_memory(error, "the neighbour list");
    list->neighbour = larger;
    list->capacity = capacity;
    return DL_OK;
}

/* Appends the partners of i that lie in one run of cells [first, last] along the first axis. */
static dl_status append_run(const dl_cells *cells, dl_list *list, const double *x, int dimension,
                            size_t particles, size_t i, int first, int last, double reach2,
                            int *count, dl_error *error) {
    int begin = cells->cell_start[first], end = cells->cell_start[last + 1];
    dl_status status = grow(list, (size_t)*count + (size_t)(end - begin), error);
    if (status != DL_OK)
        return status;
    for (int m = begin; m < end; m++) {
        size_t j = (size_t)cells->member[m];
        double s = 0;
        for (int c = 0; c < dimension; c++) {
            double d = x[(size_t)c * particles + i] - x[(size_t)c * particles + j];
            s += d * d;
        }
        list->neighbour[*count] = (int)j;
        *count += (j > i) & (s <= reach2);
    }
    return DL_OK;
}

static dl_status append_row(const dl_cells *cells, dl_list *list, const grid *g, const double *x,
                            int dimension, size_t particles, size_t i, double reach2, int *count,
                            dl_error *error) {
    int from[3] = {0, 0, 0}, to[3] = {0, 0, 0}, cell = cells->cell_of[i];
    for (int c = 0; c < dimension; c++) {
        int k = cell % g->cells[c];
        cell /= g->cells[c];
        from[c] = k > 0 ? k - 1 : 0;
        to[c] = k + 1 < g->cells[c] ? k + 1 : k;
    }
    for (int kz = from[2]; kz <= to[2]; kz++)
        for (int ky = from[1]; ky <= to[1]; ky++) {
            int base = (kz * g->cells[1] + ky) * g->cells[0];
            dl_status status = append_run(cells, list, x, dimension, particles, i, base + from[0],
                                          base + to[0], reach2, count, error);
            if (status != DL_OK)
                return status;
        }
    return DL_OK;
}

dl_status dl_cells_build(dl_cells *cells, dl_list *list, const double *x, int dimension,
                         size_t particles, size_t moving, double reach, dl_error *error) {
    dl_status status = check_finite(x, dimension, particles, error);
    if (status != DL_OK)
        return status;
    grid g = lay_grid(x, dimension, particles, reach);
    status = reserve(cells, list, &g, particles, moving, error);
    if (status != DL_OK)
        return status;
    fill_cells(cells, &g, x, dimension, particles);
    int count = 0;
    for (size_t i = 0; i < moving; i++) {
        list->start[i] = count;
        status =
            append_row(cells, list, &g, x, dimension, particles, i, reach * reach, &count, error);
        if (status != DL_OK)
            return status;
    }
    list->start[moving] = count;
    return DL_OK;
}

void dl_cells_release(dl_cells *cells, dl_list *list) {
    free(cells->cell_start);
    free(cells->member);
    free(cells->cell_of);
    free(list->start);
    free(list->neighbour);
}
