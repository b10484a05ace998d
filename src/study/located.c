#include "study/located.h"

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
        located->derivatives = calloc((dl_path_degree + 1) * n, sizeof(double));
    if (!located->y0 || !located->a0 || !located->a1 || !located->a_before || !located->scratch ||
        !located->touched || (dense && !located->derivatives))
        return dl_fail_memory(error, "located walls");
    return dl_contacts_create(&located->contacts, located->model, error);
}

dl_status dl_located_create(dl_method *method, dl_observer *observer, dl_stopwatch *watch,
                            dl_located **located, dl_error *error) {
    *located = NULL;
    dl_located *const made = calloc(1, sizeof *made);
    if (!made)
        return dl_fail_memory(error, "located walls");
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

/* --- a step -------------------------------------------------------------------------------------
 */

static dl_status count_event(dl_located *located, dl_error *error) {
    const double t = located->method->t;
    if (!(t < located->window + located->step)) {
        located->window = t;
        located->events = 0;
    }
    if (++located->events <= most_events)
        return DL_OK;
    return dl_fail(
        error, DL_STEP_FAILURE,
        "more than %lu wall hits and contacts in one time step, from t = %.17g to %.17g: "
        "they accumulate without coming to rest (walls: rest is %g, damping is %g)",
        most_events, located->window, t, located->model->scene->walls.rest,
        located->model->scene->walls.damping);
}

static dl_status current_acceleration(dl_located *located, dl_error *error) {
    if (located->a0_is_current)
        return DL_OK;
    const dl_status status =
        dl_contacts_acceleration(&located->contacts, located->y0, located->a0, error);
    located->a0_is_current = status == DL_OK;
    return status;
}

/* Looks at the step that was taken. Where something happened in it, goes there and lets it happen.
 */
static dl_status examine(dl_located *located, bool *happened, dl_error *error) {
    dl_method *const method = located->method;
    const bool near = dl_located_any_is_near(located, method->t - located->t0);
    *happened = false;
    if (!near && located->contacts.count == 0) {
        located->a0_is_current = false;
        located->h_before = 0;
        return DL_OK;
    }
    dl_hit hit = {.found = false, .t = method->t};
    dl_status status = current_acceleration(located, error);
    if (!status)
        status = dl_contacts_acceleration(&located->contacts, method->y, located->a1, error);
    if (!status && near)
        status = dl_located_find_hit(located, &hit, error);
    if (!status && hit.found) {
        status = dl_located_go_to_hit(located, &hit, error);
        if (!status && located->contacts.count)
            status = dl_contacts_acceleration(&located->contacts, method->y, located->a1, error);
    }
    bool released = false;
    if (!status)
        status = dl_located_find_release(located, hit.t, &released, error);
    *happened = hit.found || released;
    if (!status && *happened)
        status = count_event(located, error);
    if (status)
        return status;
    if (*happened)
        located->h_before = 0;
    if (released)
        return dl_located_release(located, error);
    if (hit.found)
        return dl_located_collide(located, &hit, error);
    double *const swap = located->a_before;
    located->a_before = located->a0;
    located->a0 = located->a1;
    located->a1 = swap;
    located->h_before = method->t - located->t0;
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
    const dl_hit nothing = {.found = false};
    located->a0_is_current = false;
    located->h_before = 0;
    for (size_t u = 0; u < n; u++)
        if (dl_contacts_hold(&located->contacts, u) && located->method->y[n + u] != 0)
            for (size_t c = u % located->model->moving; c < n; c += located->model->moving)
                if (located->contacts.side[c] != DL_NO_WALL) {
                    dl_contacts_release(&located->contacts, c);
                    located->counts.releases++;
                }
    return dl_located_any_touches(located) ? dl_located_collide(located, &nothing, error) : DL_OK;
}
