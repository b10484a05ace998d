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

/* *noise: what it is known to. */
static dl_path path_of(const dl_located *located, size_t u, dl_side side, int degree,
                       double *noise) {
    const dl_method *const method = located->method;
    const double h = method->t - located->t0;
    const dl_path_end start = path_end(located, located->y0, located->a0, u, side);
    dl_path path;
    *noise = dl_located_roundoff(located, u, side);
    if (!method->row->ops->dense) {
        dl_path_hermite(&path, h, start, path_end(located, method->y, located->a1, u, side));
        return path;
    }
    double derivative[dl_dense_degree + 1];
    for (int k = 0; k <= degree; k++)
        derivative[k] = dl_wall_away(side, located->derivatives[(size_t)k * method->n + u]);
    derivative[0] = dl_located_distance(located->model, located->derivatives, u, side);
    const double moved = dl_path_taylor(&path, h, degree, derivative, start);
    if (path.b[path.degree] >= 0) /* what ends beyond the wall has hit it, however near it stays */
        *noise = fmax(*noise, moved);
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
            double noise;
            const dl_path path = path_of(located, u, dl_located_sides[s], degree, &noise);
            const double exit = dl_path_first_exit(&path, noise);
            dl_located_take_if_earlier(
                located, exit, (dl_event){.kind = DL_HIT, .which = u, .side = dl_located_sides[s]},
                event);
        }
}

/* --- going there --------------------------------------------------------------------------------
 */

/* Where a coordinate is at one time, by the method's own state there. */
typedef struct sight {
    double t, d, rate;
    double slack; /* dl_located_slack */
} sight;

static sight look(const dl_located *located, const dl_event *hit) {
    const dl_method *const method = located->method;
    const double rate = dl_wall_away(hit->side, method->y[method->n + hit->which]);
    return (sight){
        .t = method->t,
        .d = dl_located_distance(located->model, method->y, hit->which, hit->side),
        .rate = rate,
        .slack = dl_located_slack(located, hit->which, hit->side, rate),
    };
}

/* A state that an implicit method's system does not lead to is not inside: it is there once the
 * time is near enough to the step's start. */
static dl_status look_at(dl_located *located, const dl_event *hit, double t, sight *seen,
                         dl_error *error) {
    const dl_status status = dl_located_state_at(located, t, error);
    if (!status)
        *seen = look(located, hit);
    else if (status == DL_NONLINEAR_FAILURE)
        *seen = (sight){.t = t, .d = NAN, .rate = NAN, .slack = NAN};
    return status == DL_NONLINEAR_FAILURE ? DL_OK : status;
}

/* Nor a NaN. */
static bool is_inside(const sight *seen) {
    return seen->d >= 0;
}

static bool is_on_wall(const sight *seen) {
    return fabs(seen->d) <= seen->slack;
}

/* Whether the state at t0 itself tells that the coordinate is on the wall and leaves from there. */
static bool leaves_at_once(const dl_located *located, const dl_event *hit) {
    const dl_path_end start = path_end(located, located->y0, located->a0, hit->which, hit->side);
    return start.d <= dl_located_slack(located, hit->which, hit->side, start.rate) &&
           (start.d < 0 || start.rate < 0 || (start.rate == 0 && start.curvature <= 0));
}

/* A hit of a state between the two. */
typedef struct search {
    sight low, high; /* inside; outside, or else where nothing is known to be outside before */
    double width;    /* of the last change of the time */
    bool is_bracket;
} search;

/* Newton's method, or bisection where that leaves the bracket or does not halve its changes. */
static double next_in_bracket(search *among, const sight *seen) {
    const double newton = seen->t - seen->d / seen->rate;
    const double middle = among->low.t + (among->high.t - among->low.t) / 2;
    const bool is_better = seen->rate < 0 && newton > among->low.t && newton < among->high.t &&
                           fabs(newton - seen->t) < among->width / 2;
    const double next = is_better ? newton : middle;
    among->width = fabs(next - seen->t);
    return next;
}

/* Without a state outside: along the tangent while the coordinate descends; once it has turned,
 * to where both tangents meet. NAN where those meet before the wall: it is not reached. */
static double next_in_dip(const search *among, const sight *seen) {
    const sight *const low = &among->low;
    if (seen->rate < 0) {
        const double newton = seen->t - seen->d / seen->rate;
        return newton < among->high.t ? newton : seen->t + (among->high.t - seen->t) / 2;
    }
    if (!(low->rate < 0))
        return NAN;
    const double meet =
        (seen->d - low->d + low->rate * low->t - seen->rate * seen->t) / (low->rate - seen->rate);
    return low->d + low->rate * (meet - low->t) < -seen->slack ? meet : NAN;
}

/* Takes in what is seen; the time to look at next, NAN where there is none. */
static double narrow(search *among, const sight *seen) {
    const bool inside = is_inside(seen);
    if (inside && !among->is_bracket) {
        const double next = next_in_dip(among, seen);
        *(seen->rate < 0 ? &among->low : &among->high) = *seen;
        return next;
    }
    *(inside ? &among->low : &among->high) = *seen;
    among->is_bracket = true;
    return next_in_bracket(among, seen);
}

static dl_status hit_at(dl_located *located, dl_event *hit, double t, dl_error *error) {
    hit->t = t;
    return dl_located_state_at(located, t, error);
}

/* Nothing happens there; the method starts anew. */
static dl_status pause_at(dl_located *located, dl_event *hit, double t, dl_error *error) {
    hit->kind = DL_PAUSE;
    return hit_at(located, hit, t, error);
}

/* A dense output that misses the step's start may begin beyond the wall and never have been inside.
 * As near as the method tells it, the path's time is the hit's, and the coordinate on the wall. */
static dl_status take_path(dl_located *located, dl_event *hit, double t, dl_error *error) {
    const dl_status status = hit_at(located, hit, t, error);
    if (!status)
        located->method->y[hit->which] = dl_wall_place(located->model, hit->which, hit->side);
    return status;
}

/* The bracket is as short as t resolves: at the end of it that is nearer to the wall, if that is on
 * it. Where neither is the method's states jump over the wall, and the one before stands. */
static dl_status settle(dl_located *located, const search *among, dl_event *hit, double by_path,
                        dl_error *error) {
    const sight *const low = &among->low, *const high = &among->high;
    const bool low_will_do =
        low->t == located->t0 ? leaves_at_once(located, hit) : is_on_wall(low) && low->rate <= 0;
    if (low_will_do && !(fabs(high->d) < low->d))
        return hit_at(located, hit, low->t, error);
    if (located->method->row->ops->dense && low->t == located->t0)
        return take_path(located, hit, by_path, error);
    return is_on_wall(high) ? hit_at(located, hit, high->t, error)
                            : pause_at(located, hit, low->t, error);
}

/* So many states are looked at for one outside where the end of the step is inside. */
enum { most_looks_for_dip = 16, most_looks = 200 };

dl_status dl_located_go_to_hit(dl_located *located, dl_event *hit, dl_error *error) {
    const double start = located->t0;
    const double least = fmax(dl_located_resolution(start), DBL_EPSILON * located->step);
    const dl_path_end from = path_end(located, located->y0, located->a0, hit->which, hit->side);
    search among = {.low = {.t = start, .d = from.d, .rate = from.rate},
                    .high = look(located, hit),
                    .width = INFINITY};
    among.is_bracket = !is_inside(&among.high);
    double next = hit->t;
    if (next - start <= least) {
        if (leaves_at_once(located, hit))
            return hit_at(located, hit, start, error);
        /* A flight that t hardly resolves; or a path that begins on the wall and dips by less than
         * the method's error: its own state a little later shows which way it went. */
        const double part = among.is_bracket ? 0 : (among.high.t - start) / 64;
        next = fmin(among.high.t, start + fmax(part, 2 * least));
    }
    const double by_path = next;
    sight seen = among.high;
    for (int i = 0; i < most_looks; i++) {
        const dl_status status = look_at(located, hit, fmax(next, start + least), &seen, error);
        if (status)
            return status;
        if (fabs(seen.d) <= dl_located_roundoff(located, hit->which, hit->side) / 2 &&
            seen.rate <= 0) {
            hit->t = seen.t;
            return DL_OK;
        }
        next = narrow(&among, &seen);
        if (among.is_bracket
                ? !(next > among.low.t && next < among.high.t) || among.high.t - start <= least
                : isnan(next) || i == most_looks_for_dip)
            break;
    }
    return among.is_bracket ? settle(located, &among, hit, by_path, error)
                            : pause_at(located, hit, seen.t, error);
}

bool dl_located_has_hit_before(const dl_located *located, dl_event *event) {
    const dl_model *const model = located->model;
    double first = INFINITY;
    for (size_t s = 0; model->locates_hits && s < 2; s++)
        for (size_t u = 0; u < model->unknowns; u++) {
            dl_event found = {.kind = DL_HIT, .which = u, .side = dl_located_sides[s]};
            const sight seen = look(located, &found);
            if (dl_contacts_hold(&located->contacts, u) || seen.d >= -seen.slack)
                continue;
            const double way_back = seen.d / seen.rate;
            found.t = seen.t - way_back;
            if (!(found.t > located->t0 && found.t < seen.t))
                found.t = located->t0 + (seen.t - located->t0) / 2;
            if (found.t < first) {
                first = found.t;
                *event = found;
            }
        }
    return first < INFINITY;
}
