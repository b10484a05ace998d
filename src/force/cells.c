#include "force/cells.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

typedef struct grid {
    double low[3], inverse_size[3];
    double inverse_period[3]; /* 0 along an axis without a period */
    int cells[3];
    int lowest[3], highest[3]; /* neighbours' places along an axis; those outside 0 ... cells - 1
                                * stand for the cells on the other side of the period */
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
static grid lay_grid(const double *x, int dimension, size_t particles, double reach,
                     const dl_box *box) {
    grid g = {.cells = {1, 1, 1}};
    double most = 2.0 * (double)particles + 16, extent[3], total = 1;
    for (int c = 0; c < dimension; c++) {
        if (box && box->length[c] > 0) {
            g.inverse_period[c] = box->inverse[c];
            extent[c] = box->length[c];
        } else {
            double high;
            span(x + (size_t)c * particles, particles, &g.low[c], &high);
            extent[c] = high - g.low[c];
        }
        g.cells[c] = (int)fmax(1, fmin(floor(extent[c] / reach), most));
        total *= g.cells[c];
    }
    while (total > most) {
        int c = widest_axis(&g);
        total /= g.cells[c];
        g.cells[c] = (g.cells[c] + 1) / 2;
        total *= g.cells[c];
    }
    for (int c = 0; c < dimension; c++) {
        g.inverse_size[c] = extent[c] > 0 ? g.cells[c] / extent[c] : 0;
        /* of fewer than three cells the neighbours on both sides are the same ones */
        bool wraps = g.inverse_period[c] > 0 && g.cells[c] >= 3;
        g.lowest[c] = wraps ? -1 : 0;
        g.highest[c] = wraps ? g.cells[c] : g.cells[c] - 1;
    }
    g.total = (size_t)g.cells[0] * (size_t)g.cells[1] * (size_t)g.cells[2];
    return g;
}

/* cell = cell * cells along the axis + place along it, for every particle. */
static void add_axis(const grid *g, int c, const double *row, size_t particles, int *cell) {
    int cells = g->cells[c];
    double low = g->low[c], inverse_size = g->inverse_size[c];
    double inverse_period = g->inverse_period[c];
    if (inverse_period > 0)
        for (size_t i = 0; i < particles; i++) {
            double periods = row[i] * inverse_period;
            int k = (int)((periods - floor(periods)) * cells);
            cell[i] = cell[i] * cells + (k < cells ? k : cells - 1);
        }
    else
        for (size_t i = 0; i < particles; i++) {
            int k = (int)((row[i] - low) * inverse_size);
            cell[i] = cell[i] * cells + (k < cells ? k : cells - 1);
        }
}

/* Cells of more particles are taken anew at every build: several models have lists, and none
 * builds while another does. */
enum { KEEP_TO = 100000 };

static void release_cells(dl_cells *cells) {
    free(cells->cell_start);
    free(cells->member);
    free(cells->cell_of);
    *cells = (dl_cells){0};
}

static dl_status reserve(dl_cells *cells, const grid *g, size_t particles, dl_error *error) {
    if (!cells->member) {
        cells->member = malloc(particles * sizeof(int));
        cells->cell_of = malloc(particles * sizeof(int));
    }
    if (cells->cell_capacity < g->total + 1) {
        free(cells->cell_start);
        cells->cell_start = malloc((g->total + 1) * sizeof(int));
        cells->cell_capacity = cells->cell_start ? g->total + 1 : 0;
    }
    if (!cells->member || !cells->cell_of || !cells->cell_start)
        return dl_fail_memory(error, "the cells of the neighbour list");
    return DL_OK;
}

/* Counting sort of the particles by cell. */
static void fill_cells(dl_cells *cells, const grid *g, const double *x, int dimension,
                       size_t particles) {
    memset(cells->cell_start, 0, (g->total + 1) * sizeof(int));
    memset(cells->cell_of, 0, particles * sizeof(int));
    for (int c = dimension - 1; c >= 0; c--)
        add_axis(g, c, x + (size_t)c * particles, particles, cells->cell_of);
    for (size_t i = 0; i < particles; i++)
        cells->cell_start[cells->cell_of[i] + 1]++;
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

/* What the rows are built from. */
typedef struct build {
    const dl_cells *cells;
    dl_list *list;
    const grid *g;
    const double *x;
    int dimension;
    size_t particles;
    double reach2;
    int count; /* entries so far */
} build;

/* Appends the partners of i that lie in one run of cells [first, last] along the first axis. */
static inline void append_run(build *b, size_t i, int first, int last, const dl_box *box) {
    const int *member = b->cells->member;
    const double *x = b->x;
    size_t particles = b->particles;
    int dimension = b->dimension, count = b->count, *neighbour = b->list->neighbour;
    int end = b->cells->cell_start[last + 1];
    double reach2 = b->reach2;
    for (int m = b->cells->cell_start[first]; m < end; m++) {
        size_t j = (size_t)member[m];
        double s = 0;
        for (int c = 0; c < dimension; c++) {
            double d = x[(size_t)c * particles + i] - x[(size_t)c * particles + j];
            if (box)
                d -= dl_box_shift(box, c, d);
            s += d * d;
        }
        neighbour[count] = (int)j;
        count += (j > i) & (s <= reach2);
    }
    b->count = count;
}

static int wrapped(int place, int cells) {
    return place < 0 ? place + cells : place >= cells ? place - cells : place;
}

/* The cells around that of i, run after run along the first axis. */
static inline void append_row(build *b, size_t i, const dl_box *box) {
    const grid *g = b->g;
    int from[3] = {0, 0, 0}, to[3] = {0, 0, 0}, cell = b->cells->cell_of[i];
    for (int c = 0; c < b->dimension; c++) {
        int k = cell % g->cells[c];
        cell /= g->cells[c];
        from[c] = k > g->lowest[c] ? k - 1 : k;
        to[c] = k < g->highest[c] ? k + 1 : k;
    }
    int last = g->cells[0] - 1;
    for (int kz = from[2]; kz <= to[2]; kz++)
        for (int ky = from[1]; ky <= to[1]; ky++) {
            int z = box ? wrapped(kz, g->cells[2]) : kz, y = box ? wrapped(ky, g->cells[1]) : ky;
            int base = (z * g->cells[1] + y) * g->cells[0];
            append_run(b, i, base + (from[0] < 0 ? 0 : from[0]),
                       base + (to[0] > last ? last : to[0]), box);
            if (box && from[0] < 0)
                append_run(b, i, base + last, base + last, box);
            if (box && to[0] > last)
                append_run(b, i, base, base, box);
        }
}

/* *g: the grid that the cells are of. */
static dl_status lay_cells(dl_cells *cells, grid *g, const double *x, int dimension,
                           size_t particles, double reach, const dl_box *box, dl_error *error) {
    dl_status status = check_finite(x, dimension, particles, error);
    if (status != DL_OK)
        return status;
    *g = lay_grid(x, dimension, particles, reach, box);
    status = reserve(cells, g, particles, error);
    if (status == DL_OK)
        fill_cells(cells, g, x, dimension, particles);
    return status;
}

dl_status dl_cells_fill(dl_cells *cells, const double *x, int dimension, size_t particles,
                        double reach, const dl_box *box, dl_error *error) {
    grid g;
    return lay_cells(cells, &g, x, dimension, particles, reach, box, error);
}

dl_status dl_cells_build(dl_cells *cells, dl_list *list, const double *x, int dimension,
                         size_t particles, size_t moving, double reach, const dl_box *box,
                         dl_error *error) {
    grid g;
    dl_status status = lay_cells(cells, &g, x, dimension, particles, reach, box, error);
    if (status != DL_OK)
        return status;
    if (!list->start)
        list->start = malloc((moving + 1) * sizeof(int));
    if (!list->start)
        return dl_fail_memory(error, "the neighbour list");
    build b = {cells, list, &g, x, dimension, particles, reach * reach, 0};
    for (size_t i = 0; i < moving; i++) {
        list->start[i] = b.count;
        status = grow(list, (size_t)b.count + particles, error); /* a row is shorter than that */
        if (status != DL_OK)
            return status;
        if (box)
            append_row(&b, i, box);
        else
            append_row(&b, i, NULL);
    }
    list->start[moving] = b.count;
    if (particles > KEEP_TO)
        release_cells(cells);
    return DL_OK;
}

void dl_cells_release(dl_cells *cells, dl_list *list) {
    release_cells(cells);
    free(list->start);
    free(list->neighbour);
}
