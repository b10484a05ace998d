/* Where and when a step has hit a wall. */
#include <string.h>

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

/* The derivatives of the dense output at the end of the step. */
static dl_status take_derivatives(dl_located *located, int *degree, dl_error *error) {
    dl_method *const method = located->method;
    const dl_method_ops *const ops = method->row->ops;
    if (!ops->dense)
        return DL_OK;
    *degree = ops->dense_degree(method);
    dl_status status = DL_OK;
    for (int k = 0; k <= *degree && !status; k++) {
        status = ops->dense(method, method->t, k, located->scratch, error);
        memcpy(located->derivatives + (size_t)k * method->n, located->scratch,
               method->n * sizeof *located->scratch);
    }
    return status;
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
    double derivative[dl_path_degree + 1];
    for (int k = 0; k <= degree; k++)
        derivative[k] = dl_wall_away(side, located->derivatives[(size_t)k * method->n + u]);
    derivative[0] = dl_located_distance(located->model, located->derivatives, u, side);
    dl_path_taylor(&path, h, degree, derivative, start);
    return path;
}

dl_status dl_located_find_hit(dl_located *located, dl_hit *hit, dl_error *error) {
    const dl_model *const model = located->model;
    const double h = located->method->t - located->t0;
    double first = INFINITY;
    int degree = 0;
    dl_status status = take_derivatives(located, &degree, error);
    for (size_t s = 0; s < 2 && !status; s++)
        for (size_t u = 0; u < model->unknowns; u++) {
            if (isinf(dl_wall_place(model, u, dl_located_sides[s])) ||
                dl_contacts_hold(&located->contacts, u) ||
                !is_near(located, u, dl_located_sides[s], h))
                continue;
            const dl_path path = path_of(located, u, dl_located_sides[s], degree);
            const double exit =
                dl_path_first_exit(&path, dl_located_roundoff(located, u, dl_located_sides[s]));
            if (exit < first) {
                first = exit;
                *hit = (dl_hit){.found = true, .u = u, .side = dl_located_sides[s]};
            }
        }
    if (hit->found)
        hit->t = first < 1 ? located->t0 + first * h : located->method->t;
    return status;
}

/* Whether the state at t0 itself tells that the coordinate leaves from there. */
static bool leaves_at_once(const dl_located *located, const dl_hit *hit) {
    const dl_path_end start = path_end(located, located->y0, located->a0, hit->u, hit->side);
    return start.d < 0 || start.rate < 0 || (start.rate == 0 && start.curvature <= 0);
}

/* A hit that the step's start does not tell of, at a time that cannot be told from it: of a path
 * that begins on the wall and dips by less than the method's error. Its own state a little later
 * shows which way it went. */
static dl_status go_past_start(dl_located *located, dl_hit *hit, double end, dl_error *error) {
    hit->t =
        fmin(end, located->t0 + fmax((end - located->t0) / 64, 2 * dl_located_resolution(end)));
    return dl_located_state_at(located, hit->t, error);
}

dl_status dl_located_go_to_hit(dl_located *located, dl_hit *hit, dl_error *error) {
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
        const double d = dl_located_distance(located->model, method->y, hit->u, hit->side);
        const double rate = dl_wall_away(hit->side, method->y[method->n + hit->u]);
        const double change = -d / rate, next = hit->t + change;
        if (d == 0 || !(fabs(change) < last / 2) || next == hit->t || i == 7 ||
            !(next - located->t0 > dl_located_resolution(located->t0) && next <= end))
            return DL_OK;
        last = fabs(change);
        hit->t = next;
    }
    return DL_OK;
}
