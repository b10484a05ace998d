/* Hits of walls and resting contacts: model/contact.h, study/located_collision.c. */
#include <string.h>

#include "reference/extended/walk.h"

static double wall_place(const walk *w, size_t u, int side) {
    const dl_walls *walls = &w->model.scene->walls;
    const size_t axis = u / w->model.moving;
    return side < 0 ? walls->low[axis] : walls->high[axis];
}

/* Component of a vector away from the wall. */
static real away(int side, real component) {
    return -side * component;
}

/* --- contacts --------------------------------------------------------------------------------- */

static void update_particle(walk *w, size_t k) {
    const size_t moving = w->model.moving;
    const bool sticks = w->model.scene->walls.damping > 0;
    bool rests = false;
    for (size_t u = k; u < w->model.unknowns; u += moving)
        rests |= sticks && w->side[u] != 0 && !w->slides[u];
    for (size_t u = k; u < w->model.unknowns; u += moving)
        w->held[u] = rests || w->side[u] != 0;
}

void walk_update_held(walk *w) {
    for (size_t k = 0; k < w->model.moving; k++)
        update_particle(w, k);
}

static void rest(walk *w, size_t u, int side, bool pressed) {
    const size_t moving = w->model.moving;
    w->side[u] = (signed char)side;
    w->pressed[u] = pressed;
    w->slides[u] = false;
    update_particle(w, u % moving);
    for (size_t k = u % moving; k < w->model.unknowns; k += moving)
        if (w->held[k])
            w->v[k] = 0;
    w->counts.contacts++;
}

void walk_contacts_last(walk *w) {
    for (size_t u = 0; u < w->model.unknowns; u++)
        w->pressed[u] |= w->side[u] != 0;
}

void walk_let_go(walk *w, size_t coordinate) {
    w->side[coordinate] = 0;
    w->counts.releases += !w->slides[coordinate];
    update_particle(w, coordinate % w->model.moving);
}

void walk_let_slide(walk *w, size_t coordinate) {
    if (w->model.scene->walls.rule == DL_MIRROR) {
        walk_let_go(w, coordinate);
        return;
    }
    w->slides[coordinate] = true;
    w->counts.releases++;
    update_particle(w, coordinate % w->model.moving);
}

/* --- hits ------------------------------------------------------------------------------------- */

static void rebound(walk *w, size_t u) {
    const dl_walls *walls = &w->model.scene->walls;
    const size_t moving = w->model.moving, k = u % moving;
    const real kept = 1 - (real)walls->damping;
    for (size_t c = k; c < w->model.unknowns; c += moving)
        w->v[c] *= c == u ? -kept : kept;
    if (real_abs(w->v[k]) < walls->zero_vx_below)
        w->v[k] = 0;
    w->counts.hits++;
}

/* Whether a coordinate touches the wall; if so it is on it, and bounces where it is on its way
 * out. */
static bool touch(walk *w, size_t u, int side, bool is_target) {
    const double place = wall_place(w, u, side);
    const real d = away(side, w->q[u] - place), rate = away(side, w->v[u]);
    if (!isfinite(place) || (!(d <= 0) && !is_target))
        return false;
    if (rate >= 0 && (d > 0 || (d == 0 && rate > 0)))
        return false;
    w->q[u] = place;
    if (rate > 0 && is_target)
        w->v[u] = -w->v[u]; /* a grazing hit, seen after its turn */
    if (rate < 0 || (rate > 0 && is_target))
        rebound(w, u);
    return true;
}

/* Whether the flight that begins now, pressed to the wall, is the last. */
static bool is_last_flight(const walk *w, size_t u, int side, real press) {
    const dl_scene *scene = w->model.scene;
    const real rate = away(side, w->v[u]), lasts = 2 * rate / press, rises = rate * lasts / 4;
    const real resolution = 8 * REAL_EPSILON * real_max(real_abs(w->t), scene->step);
    const real roundoff = 8 * REAL_EPSILON * 2 * real_abs(wall_place(w, u, side));
    return lasts <= 2 * resolution || rises <= roundoff ||
           (scene->walls.damping > 0 && lasts <= (real)scene->walls.rest * scene->step);
}

/* w->a is the acceleration there as if nothing were held. `at_once`: the path leaves from here
 * although neither velocity nor acceleration tell it to. */
static void rest_or_fly(walk *w, size_t u, int side, bool at_once) {
    const real press = -away(side, w->a[u]), rate = away(side, w->v[u]);
    if (press > 0 ? is_last_flight(w, u, side, press) : at_once && rate == 0)
        rest(w, u, side, press > 0);
}

void walk_collide(walk *w, const event *target, bool at_once) {
    static const int sides[2] = {1, -1};
    const size_t n = w->model.unknowns;
    for (size_t u = 0; u < n; u++)
        w->touched[u] = 0;
    for (size_t u = 0; u < n; u++)
        for (int s = 0; s < 2; s++)
            if (!w->held[u] && touch(w, u, sides[s],
                                     target && target->coordinate == u && target->side == sides[s]))
                w->touched[u] = (signed char)sides[s];
    model_acceleration(&w->model, &w->pairs, w->q, w->a);
    for (size_t u = 0; u < n; u++)
        if (w->touched[u] != 0 && !w->held[u])
            rest_or_fly(w, u, w->touched[u], at_once && target && target->coordinate == u);
}

void walk_meet_walls(walk *w) {
    const size_t n = w->model.unknowns, moving = w->model.moving;
    if (!w->model.scene->walls.present)
        return;
    for (size_t u = 0; u < n; u++)
        if (w->held[u] && w->v[u] != 0)
            for (size_t c = u % moving; c < n; c += moving)
                if (w->side[c] != 0)
                    walk_let_go(w, c);
    walk_collide(w, NULL, false);
}
