#include "reference/extended/walk.h"

#include <stdlib.h>
#include <string.h>

#include "observe/stopwatch.h"

/* Within one time step of the scene; more means that they will not end. */
static const unsigned long most_events = 20000;

/* --- life ------------------------------------------------------------------------------------- */

static void destroy(dl_extended_walk *handle) {
    walk *w = (walk *)handle;
    if (!w)
        return;
    if (w->method)
        w->method->destroy(w);
    model_free(&w->model);
    pairs_free(&w->pairs);
    real *const arrays[] = {w->q, w->v, w->rate, w->path, w->reach, w->load, w->a, w->q1, w->v1};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
    free(w->side);
    free(w->pressed);
    free(w->slides);
    free(w->touched);
    free(w->held);
    free(w);
}

static dl_status allocate(walk *w, dl_error *error) {
    const size_t n = w->model.unknowns + 1;
    w->q = calloc(n, sizeof *w->q);
    w->v = calloc(n, sizeof *w->v);
    w->q1 = calloc(n, sizeof *w->q1);
    w->v1 = calloc(n, sizeof *w->v1);
    w->a = calloc(n, sizeof *w->a);
    w->load = calloc(n, sizeof *w->load);
    w->rate = calloc(n * (walk_degree + 1), sizeof *w->rate);
    w->path = calloc(n * (walk_degree + 3), sizeof *w->path);
    w->reach = calloc(w->model.particles, sizeof *w->reach);
    w->side = calloc(n, sizeof *w->side);
    w->pressed = calloc(n, sizeof *w->pressed);
    w->slides = calloc(n, sizeof *w->slides);
    w->touched = calloc(n, sizeof *w->touched);
    w->held = calloc(n, sizeof *w->held);
    return w->q && w->v && w->q1 && w->v1 && w->a && w->load && w->rate && w->path && w->reach &&
                   w->side && w->pressed && w->slides && w->touched && w->held
               ? DL_OK
               : dl_fail_memory(error, "a reference");
}

static dl_status build(walk *w, const dl_scene *scene, const dl_extended_setup *setup,
                       dl_error *error) {
    dl_status status = model_create(scene, &w->model, error);
    if (!status)
        status = pairs_create(&w->model, &w->pairs, error);
    if (!status)
        status = allocate(w, error);
    if (status)
        return status;
    w->limits = setup->limits;
    w->tolerance = (real)setup->tolerance * REAL_EPSILON;
    w->stride = setup->stride > 0 ? setup->stride : 2;
    w->method = setup->method == DL_TAYLOR ? &stepper_taylor : &stepper_gauss;
    model_state(&w->model, w->q, w->v);
    pairs_assign(&w->model, &w->pairs, w->q);
    walk_meet_walls(w);
    return w->method->create(w, error);
}

static dl_status create(const dl_scene *scene, const dl_extended_setup *setup,
                        dl_extended_walk **made, dl_error *error) {
    *made = NULL;
    walk *w = calloc(1, sizeof *w);
    if (!w)
        return dl_fail_memory(error, "a reference");
    const dl_status status = build(w, scene, setup, error);
    if (status)
        destroy((dl_extended_walk *)w);
    else
        *made = (dl_extended_walk *)w;
    return status;
}

/* --- a step ----------------------------------------------------------------------------------- */

static real spread(const walk *w, const real *x, bool is_place) {
    const model *of = &w->model;
    real largest = 0;
    for (size_t c = 0; c < of->dimension; c++) {
        const size_t count = is_place ? of->particles : of->moving;
        real mean = 0;
        for (size_t k = 0; k < count; k++)
            mean += model_place(of, x, k, c) / count;
        for (size_t k = 0; k < count; k++)
            largest = real_max(largest, real_abs(model_place(of, x, k, c) - mean));
    }
    return largest;
}

void walk_scales(const walk *w, real acceleration, real *length, real *speed) {
    *length = spread(w, w->q, true);
    if (*length == 0) /* one particle alone: nothing but its own place is there to go by */
        for (size_t u = 0; u < w->model.unknowns; u++)
            *length = real_max(*length, real_abs(w->q[u]));
    if (*length == 0)
        *length = 1;
    *speed = real_max(spread(w, w->v, false), real_sqrt(*length * acceleration));
    if (*speed == 0)
        *speed = 1;
}

static dl_status count_event(walk *w, dl_error *error) {
    const double step = w->model.scene->step;
    if (!(w->t < w->window + step)) {
        w->window = w->t;
        w->events = 0;
    }
    if (++w->events <= most_events)
        return DL_OK;
    return dl_fail(error, DL_STEP_FAILURE,
                   "more than %lu events in a time of %.6g, from t = %.17g: wall hits, contacts or "
                   "breakpoints accumulate",
                   most_events, step, (double)w->window);
}

/* The state at the event, into w->q1 and w->v1, and its time after t0: the polynomial's, improved
 * until the method's own state is there, or gets no nearer. */
static dl_status go_to_event(walk *w, const event *what, real *span, dl_error *error) {
    real last = w->h;
    *span = what->tau * w->h;
    for (int i = 0; i < 6; i++) {
        const dl_status status = w->method->state(w, *span, w->q1, w->v1, error);
        real slope, roundoff;
        if (status)
            return status;
        const real value = walk_event_value(w, what, w->q1, w->v1, &slope, &roundoff);
        const real change = slope < 0 ? -value / slope : 0;
        if (real_abs(value) <= 2 * roundoff || !(real_abs(change) < last / 2) ||
            !(*span + change > 0 && *span + change <= w->h))
            return DL_OK;
        last = real_abs(change);
        *span += change;
    }
    return DL_OK;
}

static void cross(walk *w, const event *what) {
    pair *p = &w->pairs.pair[what->pair];
    p->piece = what->piece;
    memcpy(p->image, what->image, sizeof p->image);
    pairs_find_active(&w->pairs);
    w->counts.crossings++;
}

static void happen(walk *w, const event *what) {
    if (what->kind == EVENT_BREAKPOINT)
        cross(w, what);
    else if (what->kind == EVENT_RELEASE)
        (what->idle ? walk_let_slide : walk_let_go)(w, what->coordinate);
    else
        walk_collide(w, what, what->tau == 0);
}

/* One step, or a part of it up to its first event; *reached where it has come to `limit`. */
static dl_status step(walk *w, real limit, bool *reached, dl_error *error) {
    const real longest = w->gap > 0 ? real_min(limit, w->stride * w->gap) : limit;
    dl_status status = w->method->attempt(w, longest, error);
    if (status)
        return status;
    walk_make_path(w);
    const event what = walk_find_event(w);
    real span = w->h;
    if (what.kind == EVENT_NONE)
        status = w->method->state(w, span, w->q1, w->v1, error);
    else
        status = go_to_event(w, &what, &span, error);
    if (status)
        return status;
    memcpy(w->q, w->q1, w->model.unknowns * sizeof *w->q);
    memcpy(w->v, w->v1, w->model.unknowns * sizeof *w->v);
    w->counts.steps++;
    w->t += span;
    *reached = span == limit && what.kind == EVENT_NONE;
    w->goes_on = what.kind == EVENT_NONE;
    if (what.kind == EVENT_NONE) {
        walk_contacts_last(w);
        w->gap = 3 * w->gap / 2;
        return DL_OK;
    }
    w->gap = w->gap > 0 ? (3 * w->gap + span) / 4 : w->h;
    happen(w, &what);
    return count_event(w, error);
}

/* --- the way to a time ------------------------------------------------------------------------ */

static dl_status check(const walk *w, dl_error *error) {
    const dl_extended_limits *limits = &w->limits;
    if (limits->interrupt && *limits->interrupt)
        return dl_fail(error, DL_INTERRUPTED, "interrupted at t = %.10g", (double)w->t);
    if (limits->seconds > 0 && dl_cpu_clock() - limits->began > limits->seconds)
        return dl_fail(error, DL_TIMEOUT, "the limit of %.6g CPU seconds was reached at t = %.10g",
                       limits->seconds, (double)w->t);
    for (size_t u = 0; u < w->model.unknowns; u++)
        if (!real_is_finite(w->q[u]) || !real_is_finite(w->v[u]))
            return dl_fail(error, DL_UNSTABLE, "the state is not finite at t = %.10g",
                           (double)w->t);
    return DL_OK;
}

static dl_status go_to(walk *w, real target, dl_error *error) {
    bool reached = false;
    while (!reached && w->t < target) {
        const real before = w->t;
        dl_status status = step(w, target - w->t, &reached, error);
        if (!status)
            status = check(w, error);
        if (!status && w->goes_on && !reached &&
            w->t - before <= 64 * REAL_EPSILON * real_abs(before))
            status = dl_fail(error, DL_STEP_FAILURE, "the step became too small to move t = %.17g",
                             (double)before);
        if (status)
            return status;
    }
    w->t = target;
    return DL_OK;
}

/* As dl_jumps_due_at_time has it. */
static bool jump_is_due(const walk *w, double t, double *at) {
    const dl_radiation *radiation = &w->model.scene->radiation;
    if (!radiation->present)
        return false;
    *at = (double)(w->jumps + 1) * radiation->period;
    if (fabs(*at - t) <= 1e-9 * radiation->period)
        *at = t;
    return *at <= t;
}

static dl_status advance(dl_extended_walk *handle, double t, dl_error *error) {
    walk *w = (walk *)handle;
    dl_status status = DL_OK;
    double at;
    while (!status && jump_is_due(w, t, &at)) {
        status = go_to(w, at, error);
        if (status)
            return status;
        w->jumps++;
        w->goes_on = false;
        walk_radiate(w);
        walk_meet_walls(w);
    }
    return go_to(w, t, error);
}

/* --- states ----------------------------------------------------------------------------------- */

static void split(real x, double *high, double *low) {
    *high = (double)x;
    *low = (double)(x - *high);
}

static void state(const dl_extended_walk *handle, double *high, double *low) {
    const walk *w = (const walk *)handle;
    const model *of = &w->model;
    const size_t block = of->dimension * of->particles;
    for (size_t c = 0; c < of->dimension; c++)
        for (size_t k = 0; k < of->particles; k++) {
            const size_t at = c * of->particles + of->order[k];
            split(model_place(of, w->q, k, c), &high[at], &low[at]);
            split(k < of->moving ? w->v[c * of->moving + k] : 0, &high[block + at],
                  &low[block + at]);
        }
}

static dl_extended_counts counts(const dl_extended_walk *handle) {
    return ((const walk *)handle)->counts;
}

/* --- a neighbouring trajectory ---------------------------------------------------------------- */

/* The displacement of `direction` or, without one, that between the two, into w->q1 and w->v1. */
static void find_displacement(walk *w, const walk *base, const double *direction) {
    const model *of = &w->model;
    const size_t block = of->dimension * of->particles;
    for (size_t u = 0; u < of->unknowns; u++) {
        const size_t at = u / of->moving * of->particles + of->order[u % of->moving];
        w->q1[u] = direction ? direction[at] : w->q[u] - base->q[u];
        w->v1[u] = direction ? direction[block + at] : w->v[u] - base->v[u];
    }
}

/* What would be beyond a wall is on it; what rests there in both goes on to rest. */
static void keep_inside(walk *w, const walk *base) {
    const dl_walls *walls = &w->model.scene->walls;
    if (!walls->present)
        return;
    for (size_t u = 0; u < w->model.unknowns; u++) {
        const size_t axis = u / w->model.moving;
        w->q[u] = real_min(real_max(w->q[u], walls->low[axis]), walls->high[axis]);
        if (w->side[u] != base->side[u])
            w->side[u] = 0;
    }
    walk_update_held(w);
    walk_meet_walls(w);
}

static double separate(dl_extended_walk *handle, const dl_extended_walk *base_handle,
                       const double *direction, double distance, double length, double speed) {
    walk *w = (walk *)handle;
    const walk *base = (const walk *)base_handle;
    const size_t n = w->model.unknowns;
    real square = 0;
    find_displacement(w, base, direction);
    for (size_t u = 0; u < n; u++) {
        const real q = w->q1[u] / length, v = w->v1[u] / speed;
        square += q * q + v * v;
    }
    const real before = real_sqrt(square);
    const real factor = before > 0 ? distance / before : 0;
    for (size_t u = 0; u < n; u++) {
        w->q[u] = base->q[u] + factor * w->q1[u];
        w->v[u] = base->v[u] + factor * w->v1[u];
    }
    w->goes_on = false;
    pairs_assign(&w->model, &w->pairs, w->q);
    keep_inside(w, base);
    return (double)(before / distance);
}

const dl_extended_ops DL_TYPED(dl_extended) = {
    .name = REAL_NAME,
    .epsilon = (double)REAL_EPSILON,
    .create = create,
    .advance = advance,
    .state = state,
    .separate = separate,
    .counts = counts,
    .destroy = destroy,
};
