#include "model/near_jumps.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

struct dl_near_pairs {
    size_t *pair; /* [2 * capacity]: i, j */
    size_t pairs, capacity;
    double *place;            /* [dimension * particles]: where they were found */
    double within;            /* of a jump, there; negative: nowhere yet */
    unsigned long generation; /* of the kernel's rows, there */
    double reaction;          /* displacement that the largest jump makes, over h^2/2 */
    const dl_law *law;        /* the model's laws */
    dl_jumps jumps[];         /* theirs */
};

/* How many times as wide as the step needs the shell is made. */
static const double spare = 6;
/* And how many times at most, for shorter steps. */
static const double too_wide = 30;

/* --- jumps --------------------------------------------------------------------------------------
 */

static size_t laws_of(const dl_model *model) {
    const dl_pair_problem *const p = &model->priv->problem;
    return model->kernel ? p->species * p->species : 0;
}

static dl_jumps jumps_of(const dl_law *law) {
    dl_jumps jumps = {0};
    for (int piece = 0; piece < law->pieces; piece++) {
        const double size = fabs(dl_law_jump(law, piece));
        if (!(size > 0))
            continue;
        jumps.r[jumps.count] = law->until[piece];
        jumps.size[jumps.count++] = size;
    }
    return jumps;
}

bool dl_model_any_jumps(const dl_model *model) {
    for (size_t k = 0; k < laws_of(model); k++)
        if (jumps_of(&model->priv->problem.law[k]).count > 0)
            return true;
    return false;
}

/* The largest coupling_i coupling_j (1/inertia_i + 1/inertia_j) times a jump, from above. */
static double largest_reaction(const dl_model *model, const dl_near_pairs *near) {
    const double *const inverse = model->priv->inverse_inertia;
    const double *const coupling = model->priv->problem.coupling;
    double most = 0, most_coupled = 0, size = 0;
    for (size_t i = 0; i < model->particles; i++) {
        const double coupled = coupling ? fabs(coupling[i]) : 1;
        most_coupled = fmax(most_coupled, coupled);
        if (i < model->moving)
            most = fmax(most, coupled * (inverse ? inverse[i] : 1));
    }
    for (size_t k = 0; k < laws_of(model); k++)
        for (int j = 0; j < near->jumps[k].count; j++)
            size = fmax(size, near->jumps[k].size[j]);
    return 2 * most * most_coupled * size;
}

const dl_jumps *dl_near_jumps(const dl_near_pairs *near, const dl_law *law) {
    return near->jumps + (law - near->law);
}

/* --- life ---------------------------------------------------------------------------------------
 */

dl_status dl_near_pairs_create(const dl_model *model, dl_near_pairs **near, dl_error *error) {
    const size_t laws = laws_of(model);
    dl_near_pairs *const made = *near = calloc(1, sizeof *made + laws * sizeof *made->jumps);
    if (!made)
        return dl_fail_memory(error, "the pairs near a breakpoint");
    made->place = calloc((size_t)model->dimension * model->particles, sizeof *made->place);
    if (!made->place)
        return dl_fail_memory(error, "the pairs near a breakpoint");
    made->within = -1;
    made->law = model->priv->problem.law;
    for (size_t k = 0; k < laws; k++)
        made->jumps[k] = jumps_of(&made->law[k]);
    made->reaction = largest_reaction(model, made);
    return DL_OK;
}

void dl_near_pairs_free(dl_near_pairs *near) {
    if (!near)
        return;
    free(near->pair);
    free(near->place);
    free(near);
}

/* --- finding them -------------------------------------------------------------------------------
 */

/* The longest of the particles' ways from `from` (NULL: none) to `to`. */
static double longest_way(const dl_model *model, const double *from, const double *to) {
    const size_t n = model->particles;
    double most = 0;
    for (size_t i = 0; i < n; i++) {
        double square = 0;
        for (size_t c = 0; c < (size_t)model->dimension; c++) {
            const double way = to[c * n + i] - (from ? from[c * n + i] : 0);
            square += way * way;
        }
        most = square > most ? square : most;
    }
    return sqrt(most);
}

/* Whether the pair's distance is within `width` of a jump at x. */
static bool is_near(const dl_model *model, const dl_near_pairs *near, const double *x, size_t i,
                    size_t j, double width) {
    const dl_pair_problem *const p = &model->priv->problem;
    const dl_jumps *const jumps = &near->jumps[dl_pair_law_index(p, i, j)];
    double s = 0;
    for (int c = 0; c < model->dimension; c++) {
        const double *const row = x + (size_t)c * model->particles;
        double d = row[i] - row[j];
        d -= p->box ? dl_box_shift(p->box, c, d) : 0;
        s += d * d;
    }
    for (int k = 0; k < jumps->count; k++) {
        const double r = jumps->r[k], low = r > width ? r - width : 0, high = r + width;
        if (s >= low * low && s <= high * high)
            return true;
    }
    return false;
}

static bool keep(dl_near_pairs *near, size_t i, size_t j) {
    if (near->pairs == near->capacity) {
        const size_t room = near->capacity ? 2 * near->capacity : 256;
        size_t *const pair = realloc(near->pair, 2 * room * sizeof *pair);
        if (!pair)
            return false;
        near->pair = pair;
        near->capacity = room;
    }
    near->pair[2 * near->pairs] = i;
    near->pair[2 * near->pairs + 1] = j;
    near->pairs++;
    return true;
}

static dl_status find(const dl_model *model, dl_near_pairs *near, const double *x,
                      const dl_pair_rows *rows, dl_error *error) {
    near->pairs = 0;
    for (size_t i = 0; i < model->moving; i++) {
        const size_t begin = rows->neighbour ? (size_t)rows->start[i] : i + 1;
        const size_t end = rows->neighbour ? (size_t)rows->start[i + 1] : model->particles;
        for (size_t k = begin; k < end; k++) {
            const size_t j = rows->neighbour ? (size_t)rows->neighbour[k] : k;
            if (is_near(model, near, x, i, j, near->within) && !keep(near, i, j)) {
                near->within = -1;
                return dl_fail_memory(error, "the pairs near a breakpoint");
            }
        }
    }
    memcpy(near->place, x, (size_t)model->dimension * model->particles * sizeof *x);
    near->generation = rows->generation;
    return DL_OK;
}

dl_status dl_near_pairs_visit(dl_model *model, dl_near_pairs *near, const double *x,
                              const double *delta, double h, dl_pair_visitor *visit, void *context,
                              dl_error *error) {
    dl_pair_rows rows;
    dl_status status = model->kernel->ops->rows(model->kernel, x, delta, &rows, error);
    if (status)
        return status;
    /* in a box, a pair's distance to the copy it leaves for another's changes by twice as much */
    const double copies = model->priv->problem.box ? 2 : 1;
    const double width =
        copies * 2 * longest_way(model, NULL, delta) + 2 * h * h / 2 * near->reaction;
    if (near->generation != rows.generation || near->within > too_wide * width ||
        !(2 * longest_way(model, near->place, x) + width <= near->within)) {
        near->within = spare * width;
        status = find(model, near, x, &rows, error);
    }
    for (size_t k = 0; k < near->pairs && !status; k++) {
        const size_t i = near->pair[2 * k], j = near->pair[2 * k + 1];
        if (is_near(model, near, x, i, j, width))
            dl_model_visit_pair(model, x, delta, i, j, visit, context);
    }
    return status;
}
