/* d a / d q, analytic and sparse: for a pair with d = r_i - r_j the force F on i has
 *     dF/dr_i = -dF/dr_j = coupling ((F/r) I + ((F/r)'/r) d d^T)
 * and a mean force over a step another block (discrete.c): for the quotients' G (d0 + d1), by the
 * end d1,
 *     coupling (G I + 2 (dG/ds1) (d0 + d1) d1^T).
 * A row of the acceleration is the force's divided by its inertia. */
#include <stdlib.h>
#include <string.h>
#include "model/private.h"

void dl_block_of_force(const dl_model *model, const dl_pair *pair, double block[3][3]) {
    double f = pair->coupling * dl_law_force_over_r_within(pair->law, pair->range, pair->s);
    double g = pair->coupling * dl_law_force_slope_within(pair->law, pair->range, pair->s);
    for (int r = 0; r < model->dimension; r++)
        for (int c = 0; c < model->dimension; c++)
            block[r][c] = (r == c ? f : 0) + g * pair->d[r] * pair->d[c];
}

/* --- pattern ----------------------------------------------------------------------------------
 * Unknown (c, i) is c * moving + i. Column (c, i) holds rows (r, j) for j = i and every moving
 * partner j, r-major, ascending. */

static size_t partner(const dl_pair_rows *rows, size_t k) {
    return rows->start ? (size_t)rows->neighbour[k] : k;
}

static void row_range(const dl_model *model, size_t i, size_t *begin, size_t *end) {
    const dl_pair_rows *rows = &model->priv->rows;
    if (!model->kernel) { /* no pair law: no partners */
        *begin = *end = 0;
        return;
    }
    *begin = rows->start ? (size_t)rows->start[i] : i + 1;
    *end = rows->start ? (size_t)rows->start[i + 1] : model->particles;
}

/* Particles coupled to each moving one, itself included, as ascending lists. */
typedef struct adjacency {
    size_t *start; /* [moving + 1] */
    size_t *with;
} adjacency;

static int ascending(const void *a, const void *b) {
    size_t x = *(const size_t *)a, y = *(const size_t *)b;
    return (x > y) - (x < y);
}

/* A locked pair may act where its distance says that it does not, and so be in no row. */
static size_t locks_of(const dl_model *model) {
    return model->locks ? model->locks->count : 0;
}

static void count_partners(const dl_model *model, size_t *start) {
    for (size_t i = 0; i < model->moving; i++) {
        size_t begin, end;
        row_range(model, i, &begin, &end);
        start[i + 1]++;
        for (size_t k = begin; k < end; k++) {
            size_t j = partner(&model->priv->rows, k);
            if (j < model->moving) {
                start[i + 1]++;
                start[j + 1]++;
            }
        }
    }
    for (size_t k = 0; k < locks_of(model); k++) {
        const dl_lock *lock = &model->locks->lock[k];
        start[lock->i + 1]++;
        if (lock->j < model->moving)
            start[lock->j + 1]++;
    }
    for (size_t i = 0; i < model->moving; i++)
        start[i + 1] += start[i];
}

static void fill_partners(const dl_model *model, const adjacency *graph, size_t *next) {
    for (size_t i = 0; i < model->moving; i++) {
        size_t begin, end;
        row_range(model, i, &begin, &end);
        graph->with[next[i]++] = i;
        for (size_t k = begin; k < end; k++) {
            size_t j = partner(&model->priv->rows, k);
            if (j < model->moving) {
                graph->with[next[i]++] = j;
                graph->with[next[j]++] = i;
            }
        }
    }
    for (size_t k = 0; k < locks_of(model); k++) {
        const dl_lock *lock = &model->locks->lock[k];
        graph->with[next[lock->i]++] = lock->j < model->moving ? lock->j : lock->i;
        if (lock->j < model->moving)
            graph->with[next[lock->j]++] = lock->i;
    }
    for (size_t i = 0; i < model->moving; i++)
        qsort(graph->with + graph->start[i], graph->start[i + 1] - graph->start[i],
              sizeof *graph->with, ascending);
}

/* Each partner once: locked pairs are in the rows, too, as a rule. */
static void drop_repeated(const dl_model *model, adjacency *graph) {
    size_t to = 0, begin = 0;
    for (size_t i = 0; i < model->moving; i++) {
        size_t end = graph->start[i + 1], first = to;
        for (size_t k = begin; k < end; k++)
            if (to == first || graph->with[to - 1] != graph->with[k])
                graph->with[to++] = graph->with[k];
        begin = end;
        graph->start[i + 1] = to;
    }
}

static dl_status connect(const dl_model *model, adjacency *graph, dl_error *error) {
    size_t moving = model->moving;
    graph->start = calloc(moving + 1, sizeof *graph->start);
    size_t *next = calloc(moving + 1, sizeof *next);
    if (graph->start && next) {
        count_partners(model, graph->start);
        graph->with = malloc((graph->start[moving] + 1) * sizeof *graph->with);
    }
    if (!graph->with) {
        free(next);
        return dl_fail_memory(error, "the Jacobian's pattern");
    }
    memcpy(next, graph->start, moving * sizeof *next);
    fill_partners(model, graph, next);
    if (locks_of(model) > 0)
        drop_repeated(model, graph);
    free(next);
    return DL_OK;
}

static dl_status reserve_pattern(dl_model *model, size_t nonzeros, dl_error *error) {
    struct dl_model_private *priv = model->priv;
    if (!priv->column_start)
        priv->column_start = malloc((model->unknowns + 1) * sizeof *priv->column_start);
    if (priv->row_capacity < nonzeros) {
        free(priv->row);
        priv->row = malloc((nonzeros + 1) * sizeof *priv->row);
        priv->row_capacity = priv->row ? nonzeros : 0;
    }
    if (!priv->column_start || !priv->row)
        return dl_fail_memory(error, "the Jacobian's pattern");
    return DL_OK;
}

static void write_pattern(dl_model *model, const adjacency *graph) {
    struct dl_model_private *priv = model->priv;
    size_t next = 0, dimension = (size_t)model->dimension;
    for (size_t c = 0; c < dimension; c++)
        for (size_t i = 0; i < model->moving; i++) {
            priv->column_start[c * model->moving + i] = (long)next;
            for (size_t r = 0; r < dimension; r++)
                for (size_t k = graph->start[i]; k < graph->start[i + 1]; k++)
                    priv->row[next++] = (long)(r * model->moving + graph->with[k]);
        }
    priv->column_start[model->unknowns] = (long)next;
    priv->sparsity = (dl_sparsity){
        .columns = model->unknowns,
        .nonzeros = next,
        .column_start = priv->column_start,
        .row = priv->row,
        .generation = priv->sparsity.generation + 1,
    };
}

dl_status dl_model_sparsity(dl_model *model, const double *q, const double *delta,
                            const dl_sparsity **sparsity, dl_error *error) {
    struct dl_model_private *priv = model->priv;
    dl_status status = DL_OK;
    dl_pair_rows rows = {.generation = 1};
    if (model->kernel)
        status =
            model->kernel->ops->rows(model->kernel, dl_model_places(model, q),
                                     delta ? dl_model_shifts(model, delta) : NULL, &rows, error);
    if (status != DL_OK)
        return status;
    unsigned long locks = model->locks ? model->locks->generation : 0;
    bool stale = !priv->has_pattern || rows.generation != priv->rows.generation ||
                 locks != priv->locks_generation;
    priv->rows = rows;
    priv->locks_generation = locks;
    if (stale) {
        priv->has_pattern = false;
        adjacency graph = {NULL, NULL};
        status = connect(model, &graph, error);
        size_t dimension = (size_t)model->dimension;
        if (status == DL_OK)
            status =
                reserve_pattern(model, dimension * dimension * graph.start[model->moving], error);
        if (status == DL_OK)
            write_pattern(model, &graph);
        free(graph.start);
        free(graph.with);
        if (status != DL_OK)
            return status;
        priv->has_pattern = true;
    }
    *sparsity = &priv->sparsity;
    return DL_OK;
}

/* --- values -----------------------------------------------------------------------------------*/

typedef struct assembly {
    double *values;
    dl_block_of *block_of;
} assembly;

/* values of (row particle i, column particle j): += sign * block / inertia_i. */
static void add_block(const dl_model *model, double *values, size_t i, size_t j, double sign,
                      double block[3][3]) {
    const struct dl_model_private *priv = model->priv;
    if (i >= model->moving || j >= model->moving)
        return;
    double scale = priv->inverse_inertia ? sign * priv->inverse_inertia[i] : sign;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        size_t column = c * model->moving + j;
        const long *begin = priv->row + priv->column_start[column];
        size_t length = (size_t)(priv->column_start[column + 1] - priv->column_start[column]);
        size_t each = length / (size_t)model->dimension; /* rows a component */
        size_t low = 0, high = each;                     /* find i among the first component's */
        while (low + 1 < high) {
            size_t middle = (low + high) / 2;
            if ((size_t)begin[middle] <= i)
                low = middle;
            else
                high = middle;
        }
        double *to = values + priv->column_start[column] + low;
        for (size_t r = 0; r < (size_t)model->dimension; r++)
            to[r * each] += scale * block[r][c];
    }
}

static void assemble_pair(const dl_model *model, const dl_pair *pair, void *context) {
    assembly *job = context;
    double block[3][3];
    job->block_of(model, pair, block);
    add_block(model, job->values, pair->i, pair->i, 1, block);
    add_block(model, job->values, pair->j, pair->j, 1, block);
    add_block(model, job->values, pair->i, pair->j, -1, block);
    add_block(model, job->values, pair->j, pair->i, -1, block);
}

/* Into the pattern that dl_model_sparsity has just given. */
static dl_status assemble(dl_model *model, const dl_mean_walk *walk, double *values,
                          dl_error *error) {
    const dl_sparsity *const sparsity = &model->priv->sparsity;
    dl_model_book(model)->jacobian++;
    memset(values, 0, sparsity->nonzeros * sizeof *values);
    assembly job = {values, walk->block_of};
    const dl_status status =
        dl_model_visit_pairs(model, walk->x, walk->delta, assemble_pair, &job, error);
    if (status == DL_OK && model->locks)
        dl_model_visit_locks(model, walk->x, walk->delta, assemble_pair, &job);
    for (size_t k = 0; model->held && k < sparsity->nonzeros; k++)
        if (model->held[sparsity->row[k]])
            values[k] = 0;
    return status;
}

dl_status dl_model_jacobian(dl_model *model, const double *q, double *values, dl_error *error) {
    const dl_sparsity *sparsity;
    dl_status status = dl_model_sparsity(model, q, NULL, &sparsity, error);
    const dl_mean_walk walk = {dl_block_of_force, dl_model_places(model, q), NULL};
    return status ? status : assemble(model, &walk, values, error);
}

dl_status dl_model_discrete_jacobian(dl_model *model, const double *q, const double *delta,
                                     double *values, dl_error *error) {
    const dl_sparsity *sparsity;
    dl_status status = dl_model_sparsity(model, q, delta, &sparsity, error);
    if (status)
        return status;
    const dl_mean_walk walk = dl_model_mean_walk(model, q, delta);
    return assemble(model, &walk, values, error);
}

/* --- product ----------------------------------------------------------------------------------*/

typedef struct product {
    const double *u;
    double *out;
} product;

static void multiply_pair(const dl_model *model, const dl_pair *pair, void *context) {
    product *job = context;
    size_t n = model->moving;
    double block[3][3], change[3];
    bool partner_moves = pair->j < n;
    dl_block_of_force(model, pair, block);
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        change[c] = job->u[c * n + pair->i] - (partner_moves ? job->u[c * n + pair->j] : 0);
    for (size_t r = 0; r < (size_t)model->dimension; r++) {
        double force = 0;
        for (size_t c = 0; c < (size_t)model->dimension; c++)
            force += block[r][c] * change[c];
        job->out[r * n + pair->i] += force;
        if (partner_moves)
            job->out[r * n + pair->j] -= force;
    }
}

dl_status dl_model_jacobian_vector(dl_model *model, const double *q, const double *u, double *out,
                                   dl_error *error) {
    dl_model_book(model)->jacobian_vector++;
    memset(out, 0, model->unknowns * sizeof *out);
    product job = {u, out};
    const double *x = dl_model_places(model, q);
    dl_status status = dl_model_visit_pairs(model, x, NULL, multiply_pair, &job, error);
    if (status == DL_OK && model->locks)
        dl_model_visit_locks(model, x, NULL, multiply_pair, &job);
    const double *inverse = model->priv->inverse_inertia;
    for (size_t c = 0; inverse && c < (size_t)model->dimension; c++)
        for (size_t k = 0; k < model->moving; k++)
            out[c * model->moving + k] *= inverse[k];
    for (size_t k = 0; model->held && k < model->unknowns; k++)
        if (model->held[k])
            out[k] = 0;
    return status;
}
