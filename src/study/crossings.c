#include "study/crossings.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "model/private.h"

/* --- life ---------------------------------------------------------------------------------------
 */

static void find_breakpoints(dl_crossings *crossings) {
    const dl_pair_problem *p = &crossings->model->priv->problem;
    crossings->nearest = INFINITY;
    for (size_t k = 0; k < p->species * p->species; k++)
        for (int piece = 0; piece < p->law[k].pieces; piece++)
            if (p->law[k].located[piece]) {
                crossings->nearest = fmin(crossings->nearest, p->law[k].until[piece]);
                crossings->farthest = fmax(crossings->farthest, p->law[k].until[piece]);
            }
}

dl_status dl_crossings_create(dl_crossings *crossings, dl_model *model, dl_error *error) {
    *crossings = (dl_crossings){.model = model};
    find_breakpoints(crossings);
    crossings->origin = calloc(model->unknowns, sizeof *crossings->origin);
    return crossings->origin ? DL_OK : dl_fail_memory(error, "located crossings");
}

static void release(dl_watch_list *list) {
    free(list->lock);
    free(list->watched);
}

void dl_crossings_free(dl_crossings *crossings) {
    if (crossings->model)
        crossings->model->locks = NULL;
    release(&crossings->now);
    release(&crossings->before);
    dl_cells_release(&crossings->cells, &crossings->list);
    free(crossings->origin);
    *crossings = (dl_crossings){.model = NULL};
}

/* --- one pair -----------------------------------------------------------------------------------
 */

dl_separation dl_separation_at(const dl_model *model, const dl_lock *lock, const double *y) {
    const size_t n = model->moving;
    dl_separation between = {{0}, {0}};
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        between.d[c] = y[c * n + lock->i];
        between.rate[c] = y[model->unknowns + c * n + lock->i];
        if (lock->j < n) {
            between.d[c] -= y[c * n + lock->j];
            between.rate[c] -= y[model->unknowns + c * n + lock->j];
        } else {
            between.d[c] -= model->priv->place[c * model->particles + lock->j];
        }
    }
    return between;
}

void dl_nearest_copy(const dl_model *model, const double d[3], double copy[3]) {
    const dl_box *box = model->priv->problem.box;
    for (int c = 0; c < 3; c++)
        copy[c] = box ? dl_box_shift(box, c, d[c]) : 0;
}

static double square(const double d[3], const double copy[3]) {
    double s = 0;
    for (int c = 0; c < 3; c++)
        s += (d[c] - copy[c]) * (d[c] - copy[c]);
    return s;
}

double dl_separation_roundoff(const dl_model *model, const dl_lock *lock, const double *y) {
    const size_t n = model->moving;
    const double r = sqrt(isfinite(dl_lock_high(lock)) ? dl_lock_high(lock) : dl_lock_low(lock));
    double coordinates = r;
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        coordinates += fabs(y[c * n + lock->i]) +
                       fabs(lock->j < n ? y[c * n + lock->j]
                                        : model->priv->place[c * model->particles + lock->j]);
    return 4 * DBL_EPSILON * r * coordinates;
}

void dl_crossings_pass(dl_crossings *crossings, size_t which, dl_side side, const double copy[3]) {
    dl_lock *const lock = &crossings->now.lock[which];
    const bool inwards = side == DL_LOW_WALL;
    memcpy(lock->copy, copy, sizeof lock->copy);
    dl_lock_to(lock, lock->law, inwards ? lock->range.first - 1 : lock->range.last + 1);
    crossings->now.watched[which].came = inwards ? DL_HIGH_WALL : DL_LOW_WALL;
}

/* --- the list -----------------------------------------------------------------------------------
 */

static dl_status reserve(dl_watch_list *list, dl_error *error) {
    if (list->count < list->capacity)
        return DL_OK;
    const size_t capacity = 2 * list->capacity + 16;
    dl_lock *const lock = realloc(list->lock, capacity * sizeof *lock);
    if (lock)
        list->lock = lock;
    dl_watched *const watched = realloc(list->watched, capacity * sizeof *watched);
    if (watched)
        list->watched = watched;
    if (!lock || !watched)
        return dl_fail_memory(error, "located crossings");
    list->capacity = capacity;
    return DL_OK;
}

static bool is_near_a_breakpoint(const dl_law *law, double r, double margin) {
    for (int piece = 0; piece < law->pieces; piece++)
        if (law->located[piece] && fabs(r - law->until[piece]) <= margin)
            return true;
    return false;
}

/* Index in the list before of the pair, or its count. Both lists have i ascending: *from is the
 * first one that has this i or a larger one. */
static size_t find_before(const dl_watch_list *before, size_t *from, size_t i, size_t j) {
    while (*from < before->count && before->lock[*from].i < i)
        ++*from;
    size_t k = *from;
    while (k < before->count && before->lock[k].i == i && before->lock[k].j != j)
        k++;
    return k < before->count && before->lock[k].i == i ? k : before->count;
}

static bool is_on_a_breakpoint(const dl_law *law, double s, double roundoff) {
    for (int piece = 0; piece < law->pieces; piece++)
        if (law->located[piece] && fabs(s - law->until2[piece]) <= roundoff)
            return true;
    return false;
}

/* Adds the pair where it is near enough; y holds positions alone. */
static dl_status consider(dl_crossings *crossings, dl_lock lock, const double d[3], double roundoff,
                          size_t old, bool anew, dl_error *error) {
    const dl_watch_list *const before = &crossings->before;
    dl_watch_list *const now = &crossings->now;
    double copy[3];
    dl_nearest_copy(crossings->model, d, copy);
    const double s = square(d, copy);
    if (!is_near_a_breakpoint(lock.law, sqrt(s), crossings->margin))
        return DL_OK;
    const dl_status status = reserve(now, error);
    if (status)
        return status;
    const bool stays = old < before->count && (!anew || is_on_a_breakpoint(lock.law, s, roundoff));
    if (stays) {
        lock = before->lock[old];
    } else {
        memcpy(lock.copy, copy, sizeof copy);
        dl_lock_to(&lock, lock.law, dl_law_piece(lock.law, s));
    }
    now->lock[now->count] = lock;
    now->watched[now->count++] = stays ? before->watched[old] : (dl_watched){.came = DL_NO_WALL};
    return DL_OK;
}

static double separation(const dl_model *model, const double *x, size_t i, size_t j, double d[3]) {
    double coordinates = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        const double *const row = x + c * model->particles;
        d[c] = row[i] - row[j];
        coordinates += fabs(row[i]) + fabs(row[j]);
    }
    return coordinates;
}

static dl_status fill(dl_crossings *crossings, const double *x, bool anew, dl_error *error) {
    const dl_model *const model = crossings->model;
    const dl_pair_problem *const p = &model->priv->problem;
    size_t from = 0;
    dl_status status = DL_OK;
    for (size_t i = 0; i < model->moving; i++)
        for (int n = crossings->list.start[i]; n < crossings->list.start[i + 1] && !status; n++) {
            const size_t j = (size_t)crossings->list.neighbour[n];
            const dl_lock lock = {.i = i, .j = j, .law = &p->law[dl_pair_law_index(p, i, j)]};
            double d[3] = {0};
            const double coordinates = separation(model, x, i, j, d);
            const double r = crossings->farthest;
            status = consider(crossings, lock, d, 4 * DBL_EPSILON * r * (r + coordinates),
                              find_before(&crossings->before, &from, i, j), anew, error);
        }
    return status;
}

dl_status dl_crossings_watch(dl_crossings *crossings, const double *q, double margin, bool anew,
                             dl_error *error) {
    dl_model *const model = crossings->model;
    const dl_watch_list before = crossings->now;
    crossings->now = crossings->before;
    crossings->before = before;
    crossings->now.count = 0;
    crossings->margin = margin;
    const double *const x = dl_model_places(model, q);
    dl_status status = dl_cells_build(&crossings->cells, &crossings->list, x, model->dimension,
                                      model->particles, model->moving, crossings->farthest + margin,
                                      model->priv->problem.box, error);
    if (!status)
        status = fill(crossings, x, anew, error);
    if (status)
        return status;
    memcpy(crossings->origin, q, model->unknowns * sizeof *q);
    crossings->locks.lock = crossings->now.lock;
    crossings->locks.count = crossings->now.count;
    crossings->locks.generation++;
    model->locks = crossings->now.count ? &crossings->locks : NULL;
    return DL_OK;
}

double dl_crossings_margin(const dl_crossings *crossings, const double *origin, const double *y0,
                           const double *y1, double h) {
    const dl_model *const model = crossings->model;
    const size_t n = model->moving;
    double longest = 0;
    for (size_t k = 0; k < n; k++) {
        double away = 0, start = 0, end = 0;
        for (size_t u = k; u < model->unknowns; u += n) {
            away += (y0[u] - origin[u]) * (y0[u] - origin[u]);
            start += y0[model->unknowns + u] * y0[model->unknowns + u];
            end += y1[model->unknowns + u] * y1[model->unknowns + u];
        }
        longest = fmax(longest, sqrt(away) + h * (sqrt(start) + sqrt(end)));
    }
    return 2 * longest;
}
