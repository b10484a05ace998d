/* Where and when in a step a pair has crossed a breakpoint of its law. */
#include <string.h>

#include "model/private.h"
#include "study/located_parts.h"

static const dl_side range_ends[2] = {DL_LOW_WALL, DL_HIGH_WALL};

/* --- one pair -----------------------------------------------------------------------------------
 */

/* How far inside an end of its range a pair is, as a difference of squares, and at which rate. */
typedef struct clearance {
    double d, rate;
} clearance;

static bool has_end(const dl_lock *lock, dl_side side) {
    return side == DL_LOW_WALL ? lock->range.first > 0 : lock->range.last < lock->law->pieces;
}

static double clear_of(const dl_lock *lock, dl_side side, double s) {
    return side == DL_LOW_WALL ? s - dl_lock_low(lock) : dl_lock_high(lock) - s;
}

static clearance clearance_of(const dl_lock *lock, dl_side side, const dl_separation *between,
                              const double copy[3]) {
    double s = 0, rate = 0;
    for (int c = 0; c < 3; c++) {
        const double d = between->d[c] - copy[c];
        s += d * d;
        rate += 2 * d * between->rate[c];
    }
    return (clearance){clear_of(lock, side, s), dl_wall_away(side, rate)};
}

/* The pair at a state y, and which of its copies is meant there. */
static dl_separation look_at(const dl_located *located, const dl_lock *lock, const double *y,
                             double copy[3]) {
    const dl_separation between = dl_separation_at(located->model, lock, y);
    if (lock->keeps_copy)
        memcpy(copy, lock->copy, sizeof lock->copy);
    else
        dl_nearest_copy(located->model, between.d, copy);
    return between;
}

static bool is_another(const double copy[3], const double other[3]) {
    return copy[0] != other[0] || copy[1] != other[1] || copy[2] != other[2];
}

static double roundoff(const dl_located *located, size_t which, const double *y) {
    return dl_separation_roundoff(located->model, &located->crossings.now.lock[which], y);
}

/* --- what is watched ----------------------------------------------------------------------------
 */

/* A list for less than this part of the nearest breakpoint would be built too often. */
static const double least_margin = 0.02;
/* How many times the way of the step at hand a list is built for. */
static const double ways_ahead = 3;

static double margin_for(const dl_crossings *crossings, double way) {
    return fmax(least_margin * crossings->nearest, ways_ahead * way);
}

dl_status dl_located_watch_anew(dl_located *located, dl_error *error) {
    dl_crossings *const crossings = &located->crossings;
    const double *const y = located->method->y;
    const double way = dl_crossings_margin(crossings, y, y, y, located->step);
    return dl_crossings_watch(crossings, y, margin_for(crossings, way), true, error);
}

dl_status dl_located_watch_step(dl_located *located, dl_error *error) {
    dl_crossings *const crossings = &located->crossings;
    const double *const y0 = located->y0, *const y1 = located->method->y;
    const double h = located->method->t - located->t0;
    if (dl_crossings_margin(crossings, crossings->origin, y0, y1, h) <= crossings->margin)
        return DL_OK;
    const double way = dl_crossings_margin(crossings, y0, y0, y1, h);
    return dl_crossings_watch(crossings, y0, margin_for(crossings, way), false, error);
}

/* --- the step -----------------------------------------------------------------------------------
 */

/* A wide margin, since looking again is cheap. */
static bool may_cross(const dl_lock *lock, const dl_separation *start, const dl_separation *end,
                      const double copy[3], double h) {
    for (size_t s = 0; s < 2; s++) {
        if (!has_end(lock, range_ends[s]))
            continue;
        const clearance from = clearance_of(lock, range_ends[s], start, copy);
        const clearance to = clearance_of(lock, range_ends[s], end, copy);
        const double reach = 2 * h * (fabs(from.rate) + fabs(to.rate));
        if (!(fmin(from.d, to.d) > reach)) /* nor a NaN */
            return true;
    }
    return false;
}

bool dl_located_any_may_cross(dl_located *located) {
    dl_watch_list *const list = &located->crossings.now;
    const double h = located->method->t - located->t0;
    bool any = false;
    for (size_t k = 0; k < list->count; k++) {
        const dl_lock *const lock = &list->lock[k];
        double copy[3], at_end[3];
        const dl_separation start = look_at(located, lock, located->y0, copy);
        const dl_separation end = look_at(located, lock, located->method->y, at_end);
        list->watched[k].is_near =
            may_cross(lock, &start, &end, copy, h) || is_another(copy, at_end);
        any |= list->watched[k].is_near;
    }
    return any;
}

/* Of a particle along an axis; what is held has no acceleration. */
static dl_path_end path_end(const dl_located *located, const double *y, const double *a, size_t u) {
    return (dl_path_end){y[u], y[located->method->n + u],
                         dl_contacts_hold(&located->contacts, u) ? 0 : a[u]};
}

static dl_path_end difference(dl_path_end a, dl_path_end b) {
    return (dl_path_end){a.d - b.d, a.rate - b.rate, a.curvature - b.curvature};
}

/* Separation along axis c, without what is taken off for its copy. */
static dl_path separation_path(const dl_located *located, const dl_lock *lock,
                               const dl_separation *start, size_t c, double copy, int degree) {
    const dl_method *const method = located->method;
    const size_t n = located->model->moving, i = c * n + lock->i, j = c * n + lock->j;
    const double h = method->t - located->t0;
    const bool partner_moves = lock->j < n;
    dl_path path;
    if (!method->row->ops->dense) {
        const double *const a0 = located->a0, *const a1 = located->a1;
        dl_path_end from = path_end(located, located->y0, a0, i);
        dl_path_end to = path_end(located, method->y, a1, i);
        const double way = to.d - from.d;
        if (partner_moves) {
            from = difference(from, path_end(located, located->y0, a0, j));
            to = difference(to, path_end(located, method->y, a1, j));
        }
        from.d = start->d[c] - copy;
        to.d = partner_moves ? to.d - copy : from.d + way;
        dl_path_hermite(&path, h, from, to);
        return path;
    }
    double derivative[dl_dense_degree + 1];
    for (int k = 0; k <= degree; k++) {
        const double *const of_all = located->derivatives + (size_t)k * method->n;
        derivative[k] = of_all[i] - (partner_moves ? of_all[j] : 0);
    }
    derivative[0] -= copy;
    if (!partner_moves)
        derivative[0] += start->d[c] - located->y0[i];
    dl_path_taylor(&path, h, degree, derivative,
                   (dl_path_end){start->d[c] - copy, start->rate[c], NAN});
    return path;
}

/* Square of the distance, less what is on its breakpoint, towards the inside of the range. */
static dl_path clearance_path(const dl_path *squared, const dl_lock *lock, dl_side side) {
    dl_path path = *squared;
    for (int i = 0; i <= path.degree; i++)
        path.b[i] = clear_of(lock, side, path.b[i]);
    return path;
}

/* It has just come through there: whatever roundoff says, it is not outside, nor on its way out. */
static void begin_inside(dl_path *path) {
    path->b[0] = fmax(path->b[0], 0);
    path->b[1] = fmax(path->b[1], path->b[0]);
}

static void find_of(dl_located *located, size_t which, const dl_separation *start,
                    const double copy[3], int degree, dl_event *event) {
    const dl_lock *const lock = &located->crossings.now.lock[which];
    const dl_watched *const watched = &located->crossings.now.watched[which];
    const double noise = roundoff(located, which, located->y0);
    /* after what was found nothing is the first */
    const double until = (event->t - located->t0) / (located->method->t - located->t0);
    dl_path squared = {.degree = 0};
    for (size_t c = 0; c < (size_t)located->model->dimension; c++) {
        const dl_path path = separation_path(located, lock, start, c, copy[c], degree);
        dl_path_add_square(&squared, &path);
    }
    for (size_t s = 0; s < 2; s++) {
        if (!has_end(lock, range_ends[s]))
            continue;
        dl_path path = clearance_path(&squared, lock, range_ends[s]);
        if (watched->came == range_ends[s] && path.b[0] <= noise)
            begin_inside(&path);
        if (until < 1)
            dl_path_cut(&path, until);
        const double exit = fmin(until, 1) * dl_path_first_exit(&path, noise);
        dl_event found = {.kind = DL_CROSSING, .which = which, .side = range_ends[s]};
        memcpy(found.copy, copy, sizeof found.copy);
        dl_located_take_if_earlier(located, exit, found, event);
    }
}

/* In a periodic box the copy that is the nearest at the end may come near, too. */
void dl_located_find_crossing(dl_located *located, int degree, dl_event *event) {
    const dl_watch_list *const list = &located->crossings.now;
    for (size_t k = 0; k < list->count; k++) {
        if (!list->watched[k].is_near)
            continue;
        double copy[3], at_end[3];
        const dl_separation start = look_at(located, &list->lock[k], located->y0, copy);
        look_at(located, &list->lock[k], located->method->y, at_end);
        find_of(located, k, &start, copy, degree, event);
        if (is_another(copy, at_end))
            find_of(located, k, &start, at_end, degree, event);
    }
}

/* --- going there --------------------------------------------------------------------------------
 */

static clearance clearance_of_event(const dl_located *located, const dl_event *crossing) {
    const dl_lock *const lock = &located->crossings.now.lock[crossing->which];
    const dl_separation between = dl_separation_at(located->model, lock, located->method->y);
    return clearance_of(lock, crossing->side, &between, crossing->copy);
}

/* The time that Newton's method tries next, or the middle of where the crossing is known to be,
 * where the pair has turned; `last` where nothing more can be told. */
static double next_time(clearance at, double last, double low, double high, bool is_bracket,
                        double *change) {
    const double newton = last - at.d / at.rate, before = *change;
    *change = fabs(at.d / at.rate);
    if (at.rate < 0 && newton > low && newton < high)
        return *change < before / 2 ? newton : last;
    *change = INFINITY;
    return is_bracket ? low + (high - low) / 2 : last;
}

dl_status dl_located_go_to_crossing(dl_located *located, dl_event *crossing, dl_error *error) {
    const dl_method *const method = located->method;
    /* near t = 0 the representation tells apart what no solver can step */
    const double start = located->t0;
    const double least = fmax(dl_located_resolution(start), DBL_EPSILON * located->step);
    double low = start, high = method->t, change = INFINITY;
    bool is_bracket = clearance_of_event(located, crossing).d < 0;
    for (int i = 0; i < 60; i++) {
        if (crossing->t - start <= least) {
            crossing->t = start;
            return dl_located_state_at(located, start, error);
        }
        const dl_status status = dl_located_state_at(located, crossing->t, error);
        if (status)
            return status;
        const clearance at = clearance_of_event(located, crossing);
        if (fabs(at.d) <= roundoff(located, crossing->which, method->y) / 2)
            return DL_OK;
        *(at.d < 0 ? &high : &low) = crossing->t;
        is_bracket |= at.d < 0;
        const double next = next_time(at, crossing->t, low, high, is_bracket, &change);
        if (fabs(next - crossing->t) <= dl_located_resolution(next) / 8)
            return DL_OK;
        crossing->t = next;
    }
    return DL_OK;
}

/* Whether at the method's state the pair is on its way out of its range, and less than `within`
 * times its roundoff inside the *end where. */
static bool is_leaving(const dl_located *located, size_t which, double within, dl_event *end,
                       clearance *at) {
    const double *const y = located->method->y;
    const dl_lock *const lock = &located->crossings.now.lock[which];
    *end = (dl_event){.kind = DL_CROSSING, .t = located->method->t, .which = which};
    const dl_separation between = look_at(located, lock, y, end->copy);
    for (size_t s = 0; s < 2; s++) {
        if (!has_end(lock, range_ends[s]))
            continue;
        end->side = range_ends[s];
        *at = clearance_of(lock, end->side, &between, end->copy);
        if (at->rate < 0 && at->d < within * roundoff(located, which, y))
            return true;
    }
    return false;
}

bool dl_located_has_crossed_before(const dl_located *located, dl_event *event) {
    const double now = located->method->t;
    const size_t target = event->kind == DL_CROSSING ? event->which : located->crossings.now.count;
    double first = now;
    for (size_t k = 0; k < located->crossings.now.count; k++) {
        dl_event found;
        clearance at;
        if (k == target || !is_leaving(located, k, -1, &found, &at) ||
            now - at.d / at.rate >= first)
            continue;
        first = found.t = now - at.d / at.rate;
        *event = found;
    }
    return first < now;
}

/* --- what happens there -------------------------------------------------------------------------
 */

/* A return after less than this part of the time step is one at once. */
static const double at_once = 1e-12;

static void pass(dl_located *located, size_t which, dl_side side, const double copy[3]) {
    dl_watched *const watched = &located->crossings.now.watched[which];
    const double now = located->method->t;
    const bool returns = watched->came == side && now - watched->since <= at_once * located->step;
    watched->returns = returns ? watched->returns + 1 : 0;
    watched->since = now;
    dl_crossings_pass(&located->crossings, which, side, copy);
    located->counts.crossings++;
}

/* So many of them, and time does not go on. */
enum { most_returns = 10 };

static dl_status fail_on_edge(const dl_located *located, const dl_event *crossing,
                              dl_error *error) {
    const dl_lock *const lock = &located->crossings.now.lock[crossing->which];
    const size_t *const order = located->model->priv->order;
    const size_t i = order[lock->i], j = order[lock->j];
    return dl_fail(error, DL_STEP_FAILURE,
                   "particles %zu and %zu are stuck on the breakpoint %.10g of their pair law at "
                   "t = %.17g: the force drives them to it from both sides",
                   i < j ? i : j, i < j ? j : i,
                   sqrt(crossing->side == DL_LOW_WALL ? dl_lock_high(lock) : dl_lock_low(lock)),
                   crossing->t);
}

dl_status dl_located_cross(dl_located *located, const dl_event *crossing, dl_error *error) {
    /* one that has turned back before the breakpoint, or on it, does not pass */
    if (clearance_of_event(located, crossing).rate < 0 || crossing->t == located->t0)
        pass(located, crossing->which, crossing->side, crossing->copy);
    for (size_t k = 0; k < located->crossings.now.count; k++) {
        dl_event found;
        clearance at;
        if (k != crossing->which && is_leaving(located, k, 1, &found, &at))
            pass(located, k, found.side, found.copy);
    }
    if (located->crossings.now.watched[crossing->which].returns > most_returns)
        return fail_on_edge(located, crossing, error);
    located->a0_is_current = false;
    return dl_method_jumped(located->method, error);
}
