/* What happens at a hit: bounce, or rest. */
#include <string.h>

#include "study/located_parts.h"

/* Whether the flight that begins with that normal velocity, under an acceleration that presses to
 * the wall, is the last: it lasts 2 rate/press and rises to rate^2/(2 press). */
static bool is_last_flight(const dl_located *located, size_t u, dl_side side, double rate,
                           double press) {
    const dl_walls *const walls = &located->model->scene->walls;
    const double lasts = 2 * rate / press, rises = rate * lasts / 4;
    return lasts <= 2 * dl_located_resolution(fmax(located->method->t, located->step)) ||
           rises <= dl_located_roundoff(located, u, side) ||
           (walls->damping > 0 && lasts <= walls->rest * located->step);
}

static bool is_target(const dl_event *target, size_t u) {
    return target->kind == DL_HIT && target->which == u;
}

/* Whether a coordinate is on the wall, or beyond, and hits it or stays there. The target of an
 * event is where the wall is but for roundoff, on whichever side. */
static bool touches(const dl_located *located, size_t u, dl_side side, bool gone_to) {
    const double *const y = located->method->y;
    const double d = dl_located_distance(located->model, y, u, side);
    const double rate = dl_wall_away(side, y[located->method->n + u]);
    if (rate >= 0 && (d > 0 || (d == 0 && rate > 0 && !gone_to)))
        return false; /* it turns back before the wall, or has just left it */
    return d <= 0 || gone_to;
}

/* What of a coordinate's distance from its wall is booked with the hit, so that it does not add up
 * over many: roundoff, of t as well, but no more than a particle could go in a step that makes
 * sense. */
static double booked_distance(const dl_located *located, size_t u, dl_side side) {
    const dl_method *const method = located->method;
    const double roundoff = dl_located_roundoff(located, u, side);
    return fmin(dl_located_slack(located, u, side, method->y[method->n + u]), 0x1p16 * roundoff);
}

/* All of them are touched. What is farther from its wall is put on it before anything is booked:
 * that is an error of the integration, and no wall has taken it. */
static void touch_all(dl_located *located, const dl_event *target) {
    const dl_model *const model = located->model;
    double *const q = located->method->y;
    memset(located->touched, 0, model->unknowns * sizeof *located->touched);
    for (size_t u = 0; u < model->unknowns; u++)
        for (size_t s = 0; s < 2 && !dl_contacts_hold(&located->contacts, u); s++) {
            const dl_side side = dl_located_sides[s];
            if (!touches(located, u, side, is_target(target, u) && target->side == side))
                continue;
            located->touched[u] = (signed char)side;
            if (fabs(dl_located_distance(model, q, u, side)) > booked_distance(located, u, side))
                q[u] = dl_wall_place(model, u, side);
        }
}

/* All that touch are put on their walls; what is on its way out turns round, and the target also
 * where it has turned already. */
static void bounce_all(dl_located *located, const dl_event *target) {
    const dl_method *const method = located->method;
    const size_t n = method->n, moving = located->model->moving;
    double *const v = method->y + n;
    for (size_t u = 0; u < n; u++) {
        const dl_side side = (dl_side)located->touched[u];
        const double rate = dl_wall_away(side, v[u]);
        if (side != DL_NO_WALL)
            method->y[u] = dl_wall_place(located->model, u, side);
        if (side == DL_NO_WALL || rate == 0 || (rate > 0 && !is_target(target, u)))
            continue;
        if (rate > 0)
            v[u] = -v[u];
        dl_wall_rebound(located->model, v, u % moving, u / moving);
        located->counts.hits++;
    }
}

/* Rests, or flies: a0 is the acceleration there. `forced`: the path leaves at once although neither
 * velocity nor acceleration tell it to. */
static void rest_or_fly(dl_located *located, size_t u, bool forced) {
    dl_method *const method = located->method;
    const dl_side side = (dl_side)located->touched[u];
    double *const v = method->y + method->n;
    const double rate = dl_wall_away(side, v[u]);
    const double press = -dl_wall_away(side, located->a0[u]);
    if (press > 0 ? is_last_flight(located, u, side, rate, press)
                  : forced && press == 0 && rate == 0) {
        dl_contacts_add(&located->contacts, u, side, press > 0, v);
        located->counts.contacts++;
    }
}

static dl_status collide(dl_located *located, const dl_event *target, dl_error *error) {
    dl_method *const method = located->method;
    bounce_all(located, target);
    located->a0_is_current = false;
    const dl_status status =
        dl_contacts_acceleration(&located->contacts, method->y, located->a0, error);
    if (status)
        return status;
    located->a0_is_current = true;
    for (size_t u = 0; u < method->n; u++)
        if (located->touched[u] && !dl_contacts_hold(&located->contacts, u))
            rest_or_fly(located, u, is_target(target, u) && target->t == located->t0);
    return dl_method_jumped(method, error);
}

dl_status dl_located_collide(dl_located *located, const dl_event *target, dl_error *error) {
    touch_all(located, target);
    if (!located->observer)
        return collide(located, target, error);
    const unsigned long contacts = located->counts.contacts;
    dl_stopwatch_stop(located->watch);
    dl_status status = dl_observer_before_jump(located->observer, located->method, error);
    dl_stopwatch_start(located->watch);
    if (status || (status = collide(located, target, error)))
        return status;
    dl_stopwatch_stop(located->watch);
    status = dl_observer_after_jump(located->observer, located->method, error);
    if (located->counts.contacts > contacts)
        dl_observer_contact(located->observer);
    dl_stopwatch_start(located->watch);
    return status;
}

bool dl_located_any_touches(const dl_located *located) {
    const dl_model *const model = located->model;
    for (size_t u = 0; u < model->unknowns; u++)
        for (size_t s = 0; s < 2; s++)
            if (!dl_contacts_hold(&located->contacts, u) &&
                dl_located_distance(model, located->method->y, u, dl_located_sides[s]) <= 0 &&
                dl_wall_away(dl_located_sides[s], located->method->y[model->unknowns + u]) <= 0)
                return true;
    return false;
}
