/* Where and when a step has hit a wall. */
#include "study/located_parts.h"

/* Whether coordinate u may have been beyond a wall: a wide margin, since looking again is cheap. */
static bool is_near(const dl_located *located, size_t u, dl_side side, double h) {
    const dl_method *const method = located->method;
    const double *const q0 = located->y0, *const q1 = method->y;
    const double reach = 2 * h * (fabs(q0[method->n + u]) + fabs(q1[method->n + u]));
    const double nearest = fmin(dl_located_distance(located->model, q0, u, side),
                                dl_located_distance(located->model, q1, u, side));
    return !(nearest > reach); /* nor a NaN */
}

bool dl_located_any_is_near(const dl_located *located, double h) {
    const dl_model *const model = located->model;
    for (size_t s = 0; s < 2; s++)
        for (size_t u = 0; u < model->unknowns; u++) {
            if (isinf(dl_wall_place(model, u, dl_located_sides[s]))) {
                u += model->moving - 1; /* none across this axis */
                continue;
            }
            if (!dl_contacts_hold(&located->contacts, u) &&
                is_near(located, u, dl_located_sides[s], h))
                return true;
        }
    return false;
}

static dl_path_end path_end(const dl_located *located, const double *y, const double *a, size_t u,
                            dl_side side) {
    return (dl_path_end){
        .d = dl_located_distance(located->model, y, u, side),
        .rate = dl_wall_away(side, y[located->method->n + u]),
        .curvature = dl_wall_away(side, a[u]),
    };
}

static dl_path path_of(const dl_located *located, size_t u, dl_side side, int degree) {
    const dl_method *const method = located->method;
    const double h = method->t - located->t0;
    const dl_path_end start = path_end(located, located->y0, located->a0, u, side);
    dl_path path;
    if (!method->row->ops->dense) {
        dl_path_hermite(&path, h, start, path_end(located, method->y, located->a1, u, side));
        return path;
    }
    double derivative[dl_dense_degree + 1];
    for (int k = 0; k <= degree; k++)
        derivative[k] = dl_wall_away(side, located->derivatives[(size_t)k * method->n + u]);
    derivative[0] = dl_located_distance(located->model, located->derivatives, u, side);
    dl_path_taylor(&path, h, degree, derivative, start);
    return path;
}

void dl_located_find_hit(dl_located *located, int degree, dl_event *event) {
    const dl_model *const model = located->model;
    const double end = located->method->t, h = end - located->t0;
    for (size_t s = 0; s < 2; s++)
        for (size_t u = 0; u < model->unknowns; u++) {
            if (isinf(dl_wall_place(model, u, dl_located_sides[s])) ||
                dl_contacts_hold(&located->contacts, u) ||
                !is_near(located, u, dl_located_sides[s], h))
                continue;
            const dl_path path = path_of(located, u, dl_located_sides[s], degree);
            const double exit =
                dl_path_first_exit(&path, dl_located_roundoff(located, u, dl_located_sides[s]));
            dl_located_take_if_earlier(
                located, exit, (dl_event){.kind = DL_HIT, .which = u, .side = dl_located_sides[s]},
                event);
        }
}

/* Whether the state at t0 itself tells that the coordinate leaves from there. */
static bool leaves_at_once(const dl_located *located, const dl_event *hit) {
    const dl_path_end start = path_end(located, located->y0, located->a0, hit->which, hit->side);
    return start.d < 0 || start.rate < 0 || (start.rate == 0 && start.curvature <= 0);
}

/* A hit that the step's start does not tell of, at a time that cannot be told from it: of a path
 * that begins on the wall and dips by less than the method's error. Its own state a little later
 * shows which way it went. */
static dl_status go_past_start(dl_located *located, dl_event *hit, double end, dl_error *error) {
    hit->t =
        fmin(end, located->t0 + fmax((end - located->t0) / 64, 2 * dl_located_resolution(end)));
    return dl_located_state_at(located, hit->t, error);
}

dl_status dl_located_go_to_hit(dl_located *located, dl_event *hit, dl_error *error) {
    const dl_method *const method = located->method;
    const double end = method->t;
    double last = end - located->t0;
    if (hit->t - located->t0 <= dl_located_resolution(located->t0)) {
        if (!leaves_at_once(located, hit))
            return go_past_start(located, hit, end, error);
        hit->t = located->t0;
    }
    for (int i = 0; i < 8; i++) {
        const dl_status status = dl_located_state_at(located, hit->t, error);
        if (status || hit->t == located->t0)
            return status;
        const double d = dl_located_distance(located->model, method->y, hit->which, hit->side);
        const double rate = dl_wall_away(hit->side, method->y[method->n + hit->which]);
        const double change = -d / rate, next = hit->t + change;
        if (d == 0 || !(fabs(change) < last / 2) || next == hit->t || i == 7 ||
            !(next - located->t0 > dl_located_resolution(located->t0) && next <= end))
            return DL_OK;
        last = fabs(change);
        hit->t = next;
    }
    return DL_OK;
}

bool dl_located_has_hit_before(const dl_located *located, dl_event *event) {
    const dl_model *const model = located->model;
    const dl_method *const method = located->method;
    double first = method->t;
    for (size_t s = 0; model->locates_hits && s < 2; s++)
        for (size_t u = 0; u < model->unknowns; u++) {
            const dl_side side = dl_located_sides[s];
            const double d = dl_located_distance(model, method->y, u, side);
            const double rate = dl_wall_away(side, method->y[method->n + u]);
            if (dl_contacts_hold(&located->contacts, u) ||
                !(d < -dl_located_roundoff(located, u, side) && rate < 0))
                continue;
            if (method->t - d / rate < first) {
                first = method->t - d / rate;
                *event = (dl_event){.kind = DL_HIT, .t = first, .which = u, .side = side};
            }
        }
    return first < method->t;
}
