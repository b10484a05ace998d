#include "study/located.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/located_parts.h"

/* Within one time step; more means that they will not end. */
static const unsigned long most_events = 100000;

/* --- life ---------------------------------------------------------------------------------------
 */

static dl_status allocate(dl_located *located, dl_error *error) {
    const size_t n = located->method->n;
    located->y0 = calloc(2 * n, sizeof(double));
    located->a0 = calloc(n, sizeof(double));
    located->a1 = calloc(n, sizeof(double));
    located->a_before = calloc(n, sizeof(double));
    located->scratch = calloc(2 * n, sizeof(double));
    located->touched = calloc(n, sizeof *located->touched);
    const bool dense = located->method->row->ops->dense != NULL;
    if (dense)
        located->derivatives = calloc((dl_dense_degree + 1) * n, sizeof(double));
    if (!located->y0 || !located->a0 || !located->a1 || !located->a_before || !located->scratch ||
        !located->touched || (dense && !located->derivatives))
        return dl_fail_memory(error, "located events");
    if (located->model->locates_crossings) {
        const dl_status status = dl_crossings_create(&located->crossings, located->model, error);
        if (status)
            return status;
    }
    return dl_contacts_create(&located->contacts, located->model, error);
}

dl_status dl_located_create(dl_method *method, dl_observer *observer, dl_stopwatch *watch,
                            dl_located **located, dl_error *error) {
    *located = NULL;
    dl_located *const made = calloc(1, sizeof *made);
    if (!made)
        return dl_fail_memory(error, "located events");
    made->method = method;
    made->model = method->model;
    made->observer = observer;
    made->watch = watch;
    made->step = method->step > 0 ? method->step : method->model->scene->step;
    const dl_status status = allocate(made, error);
    if (status) {
        dl_located_free(made);
        return status;
    }
    *located = made;
    return DL_OK;
}

void dl_located_free(dl_located *located) {
    if (!located)
        return;
    dl_contacts_free(&located->contacts);
    dl_crossings_free(&located->crossings);
    double *const arrays[] = {located->y0,       located->a0,          located->a1,
                              located->a_before, located->derivatives, located->scratch};
    for (size_t k = 0; k < sizeof arrays / sizeof *arrays; k++)
        free(arrays[k]);
    free(located->touched);
    free(located);
}

dl_located_counts dl_located_counts_get(const dl_located *located) {
    return located->counts;
}

/* --- states within the step ---------------------------------------------------------------------
 */

static void begin_step(dl_located *located) {
    const dl_method *const method = located->method;
    located->t0 = method->t;
    memcpy(located->y0, method->y, 2 * method->n * sizeof *located->y0);
    located->since_start = 0;
}

static dl_status advance(dl_located *located, double t_stop, dl_error *error) {
    dl_method *const method = located->method;
    const double before = method->t;
    const dl_status status = dl_method_advance(method, t_stop, error);
    if (status)
        return status;
    if (!(method->t > before))
        return dl_fail(error, DL_STEP_FAILURE, "the step became too small to move t = %.17g",
                       before);
    located->since_start++;
    return DL_OK;
}

static dl_status step_to(dl_located *located, double t, dl_error *error) {
    const dl_status status = dl_method_step_to(located->method, t, error);
    located->since_start += status == DL_OK;
    return status;
}

static dl_status go_back(dl_located *located, dl_error *error) {
    dl_method *const method = located->method;
    method->t = located->t0;
    memcpy(method->y, located->y0, 2 * method->n * sizeof *method->y);
    located->counts.discarded += located->since_start;
    located->since_start = 0;
    return dl_method_jumped(method, error);
}

dl_status dl_located_state_at(dl_located *located, double t, dl_error *error) {
    dl_method *const method = located->method;
    if (method->row->ops->dense && t > located->t0) {
        method->t = t;
        return method->row->ops->dense(method, t, 0, method->y, error);
    }
    dl_status status = go_back(located, error);
    if (status || t <= located->t0)
        return status;
    if (method->step > 0)
        return step_to(located, t, error);
    while (!status && method->t < t)
        status = advance(located, t, error);
    return status;
}

dl_status dl_located_take_derivatives(dl_located *located, int *degree, dl_error *error) {
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

/* --- a step -------------------------------------------------------------------------------------
 */

/* How often coordinate u goes from wall to wall in a time step, at the speed that it has. */
static double crossings_of_box(const dl_located *located, size_t u) {
    const dl_model *const model = located->model;
    const double width =
        dl_wall_place(model, u, DL_HIGH_WALL) - dl_wall_place(model, u, DL_LOW_WALL);
    return located->step * fabs(located->method->y[model->unknowns + u]) / width;
}

/* Why there are so many events: particles that are that fast, bounces that become ever shorter, or
 * bounces that are short. */
static void explain_events(const dl_located *located, char *why, size_t size) {
    const dl_walls *const walls = &located->model->scene->walls;
    const double t = located->method->t;
    double all = 0;
    size_t fastest = 0;
    for (size_t u = 0; u < located->model->unknowns && located->model->locates_hits; u++) {
        all += crossings_of_box(located, u);
        if (crossings_of_box(located, u) > crossings_of_box(located, fastest))
            fastest = u;
    }
    if (!located->model->locates_hits)
        snprintf(why, size, "a pair does not leave its breakpoint");
    else if (!(all < (double)most_events / 4))
        snprintf(why, size,
                 "at a speed of %.3g a particle goes from wall to wall %.3g times in a step, which "
                 "is too long for it",
                 fabs(located->method->y[located->model->unknowns + fastest]),
                 crossings_of_box(located, fastest));
    else if (t - located->halfway < (located->halfway - located->window) / 2)
        snprintf(why, size,
                 "they accumulate without coming to rest (walls: rest is %g, damping is %g)",
                 walls->rest, walls->damping);
    else
        snprintf(why, size, "they are %.3g apart, and the step is too long for that",
                 (t - located->window) / (double)most_events);
}

static dl_status count_event(dl_located *located, dl_error *error) {
    const double t = located->method->t;
    if (!(t < located->window + located->step)) {
        located->window = t;
        located->events = 0;
    }
    if (++located->events == most_events / 2)
        located->halfway = t;
    if (located->events <= most_events)
        return DL_OK;
    char why[200];
    explain_events(located, why, sizeof why);
    return dl_fail(error, DL_STEP_FAILURE,
                   "more than %lu wall hits, contacts and crossings in one time step, from "
                   "t = %.17g to %.17g: %s",
                   most_events, located->window, t, why);
}

static dl_status current_acceleration(dl_located *located, dl_error *error) {
    if (located->a0_is_current)
        return DL_OK;
    const dl_status status =
        dl_contacts_acceleration(&located->contacts, located->y0, located->a0, error);
    located->a0_is_current = status == DL_OK;
    return status;
}

/* Where something may have happened in the step. */
typedef struct suspicion {
    bool hits, crossings;
} suspicion;

static dl_status suspect(dl_located *located, suspicion *suspected, dl_error *error) {
    const dl_model *const model = located->model;
    const double h = located->method->t - located->t0;
    dl_status status = DL_OK;
    if (model->locates_crossings)
        status = dl_located_watch_step(located, error);
    suspected->hits = model->locates_hits && dl_located_any_is_near(located, h);
    suspected->crossings = !status && model->locates_crossings && dl_located_any_may_cross(located);
    return status;
}

/* A dense output needs no accelerations, but for particles on walls. */
static dl_status accelerations(dl_located *located, suspicion suspected, dl_error *error) {
    if (located->method->row->ops->dense && !suspected.hits && located->contacts.count == 0) {
        located->a0_is_current = false;
        return DL_OK;
    }
    const dl_status status = current_acceleration(located, error);
    return status ? status
                  : dl_contacts_acceleration(&located->contacts, located->method->y, located->a1,
                                             error);
}

/* The earliest event by the step's paths. */
static dl_status find_first(dl_located *located, suspicion suspected, dl_event *event,
                            dl_error *error) {
    int degree = 0;
    if (!suspected.hits && !suspected.crossings)
        return DL_OK;
    const dl_status status = dl_located_take_derivatives(located, &degree, error);
    if (status)
        return status;
    if (suspected.hits)
        dl_located_find_hit(located, degree, event);
    if (suspected.crossings)
        dl_located_find_crossing(located, degree, event);
    return DL_OK;
}

/* Events less apart than the paths' error: of one that is found to have come before, so many times
 * in a row; and pauses without an event. Both end but in steps that are too long by far. */
enum { most_overtaken = 64, most_pauses = 100 };

static dl_status fail_to_locate(const dl_located *located, dl_error *error) {
    return dl_fail(error, DL_STEP_FAILURE,
                   "the hits of the step from t = %.17g cannot be located: the method's own states "
                   "at times within it follow no path to the wall; its steps are too long here",
                   located->t0);
}

static bool is_overtaken(const dl_located *located, dl_event *event) {
    return (located->model->locates_crossings && dl_located_has_crossed_before(located, event)) ||
           dl_located_has_hit_before(located, event);
}

static dl_status go_to(dl_located *located, dl_event *event, dl_error *error) {
    dl_status status = DL_OK;
    for (int i = 0; i < most_overtaken && !status; i++) {
        if (event->kind == DL_HIT && !(status = current_acceleration(located, error)))
            status = dl_located_go_to_hit(located, event, error);
        else if (event->kind == DL_CROSSING)
            status = dl_located_go_to_crossing(located, event, error);
        if (status || event->t == located->t0 || !is_overtaken(located, event))
            return status;
    }
    return status ? status : fail_to_locate(located, error);
}

static dl_status pause(dl_located *located, dl_error *error) {
    located->a0_is_current = false;
    return ++located->pauses > most_pauses ? fail_to_locate(located, error)
                                           : dl_method_jumped(located->method, error);
}

static dl_status happen(dl_located *located, const dl_event *event, bool released,
                        dl_error *error) {
    located->h_before = 0;
    if (event->kind == DL_PAUSE && !released)
        return pause(located, error);
    const dl_status status = count_event(located, error);
    located->pauses = 0;
    if (status)
        return status;
    if (released)
        return dl_located_release(located, error);
    return event->kind == DL_HIT ? dl_located_collide(located, event, error)
                                 : dl_located_cross(located, event, error);
}

/* Of a step in which nothing happened: its end is the next one's start. */
static void keep_accelerations(dl_located *located) {
    dl_contacts_last(&located->contacts);
    located->pauses = 0;
    located->h_before = located->a0_is_current ? located->method->t - located->t0 : 0;
    double *const swap = located->a_before;
    located->a_before = located->a0;
    located->a0 = located->a1;
    located->a1 = swap;
}

/* What hits is on its wall: a roundoff beyond it, it would seem to pull at what rests there. */
static dl_status press_at_event(dl_located *located, const dl_event *event, dl_error *error) {
    double *const q = located->method->y + (event->kind == DL_HIT ? event->which : 0);
    const double found = *q;
    if (event->kind == DL_HIT)
        *q = dl_wall_place(located->model, event->which, event->side);
    const dl_status status =
        dl_contacts_acceleration(&located->contacts, located->method->y, located->a1, error);
    *q = found;
    return status;
}

/* Looks at the step that was taken. Where something happened in it, goes there and lets it happen.
 */
static dl_status examine(dl_located *located, bool *happened, dl_error *error) {
    dl_method *const method = located->method;
    suspicion suspected;
    *happened = false;
    dl_status status = suspect(located, &suspected, error);
    if (status)
        return status;
    if (!suspected.hits && !suspected.crossings && located->contacts.count == 0) {
        located->a0_is_current = false;
        located->h_before = 0;
        located->pauses = 0;
        return DL_OK;
    }
    dl_event event = {.kind = DL_NO_EVENT, .t = method->t};
    bool released = false;
    status = accelerations(located, suspected, error);
    if (!status)
        status = find_first(located, suspected, &event, error);
    if (!status && event.kind != DL_NO_EVENT) {
        status = go_to(located, &event, error);
        if (!status && located->contacts.count)
            status = press_at_event(located, &event, error);
    }
    if (!status)
        status = dl_located_find_release(located, event.t, &released, error);
    if (!status && released && dl_located_has_hit_before(located, &event)) {
        released = false;
        status = go_to(located, &event, error);
    }
    if (status)
        return status;
    *happened = event.kind != DL_NO_EVENT || released;
    if (*happened)
        return happen(located, &event, released, error);
    keep_accelerations(located);
    return DL_OK;
}

static dl_status step_of_the_grid(dl_located *located, dl_error *error) {
    dl_method *const method = located->method;
    const double end = (double)(located->grid + 1) * method->step;
    begin_step(located);
    dl_status status = advance(located, INFINITY, error);
    bool happened = false, interrupted = false;
    while (!status && !(status = examine(located, &happened, error)) && happened) {
        interrupted = true;
        if (end - method->t <= dl_located_resolution(end))
            break;
        begin_step(located);
        status = step_to(located, end, error);
    }
    if (status)
        return status;
    located->grid++;
    if (interrupted)
        dl_method_return_to_grid(method, located->grid);
    return DL_OK;
}

/* Where a step that the method chooses ends at the latest: while something rests, in equal parts no
 * longer than the scene's step. */
static double latest_end(const dl_located *located, double t_stop) {
    const double left = t_stop - located->t0;
    const double parts = ceil(left / located->step * (1 - 1e-9));
    return located->contacts.count && parts > 1 ? located->t0 + left / parts : t_stop;
}

dl_status dl_located_step(dl_located *located, double t_stop, dl_error *error) {
    if (located->method->step > 0)
        return step_of_the_grid(located, error);
    begin_step(located);
    bool happened;
    const dl_status status = advance(located, latest_end(located, t_stop), error);
    return status ? status : examine(located, &happened, error);
}

dl_status dl_located_restart(dl_located *located, dl_error *error) {
    const size_t n = located->model->unknowns;
    const dl_event nothing = {.kind = DL_NO_EVENT};
    located->a0_is_current = false;
    located->h_before = 0;
    if (located->model->locates_crossings) {
        const dl_status status = dl_located_watch_anew(located, error);
        if (status)
            return status;
    }
    if (!located->model->locates_hits)
        return DL_OK;
    for (size_t u = 0; u < n; u++)
        if (dl_contacts_hold(&located->contacts, u) && located->method->y[n + u] != 0)
            for (size_t c = u % located->model->moving; c < n; c += located->model->moving)
                if (located->contacts.side[c] != DL_NO_WALL) {
                    located->counts.releases += !located->contacts.slides[c];
                    dl_contacts_release(&located->contacts, c);
                }
    return dl_located_any_touches(located) ? dl_located_collide(located, &nothing, error) : DL_OK;
}
