/* Gauss-Legendre collocation with steps of its own choice.
 *
 * Where the acceleration is analytic its Legendre coefficients fall geometrically, and the end of a
 * step is off by about the square of the last: the step is chosen so that this square is the
 * tolerance. With few stages for short steps, which is what remains between events. */
#include <stdlib.h>
#include <string.h>

#include "reference/extended/gauss_table.h"
#include "reference/extended/walk.h"

typedef struct gauss {
    int most;                                 /* stages */
    gauss_table table[gauss_most_stages + 1]; /* [least_stages ... most] */
    const gauss_table *in_use;
    real *place, *a; /* [most][unknowns]: at the stages */
    real solved;     /* length of the step that they are for */
    real next;       /* step; 0: not known */
    real decay;      /* of Legendre coefficients, per time and degree; 0: not known */
} gauss;

enum { least_stages = 4, most_iterations = 100, most_attempts = 200 };

static dl_status create(walk *w, dl_error *error) {
    gauss *made = calloc(1, sizeof *made);
    w->data = made;
    if (!made)
        return dl_fail_memory(error, "a collocation method");
    const int wanted = (int)ceil(-0.6 * log10((double)w->tolerance));
    made->most = wanted < gauss_most_stages ? wanted : gauss_most_stages;
    made->most = made->most > least_stages ? made->most : least_stages;
    dl_status status = DL_OK;
    for (int s = least_stages; s <= made->most && !status; s++)
        status = gauss_table_create(s, &made->table[s], error);
    const size_t length = (size_t)made->most * w->model.unknowns;
    made->place = calloc(length, sizeof *made->place);
    made->a = calloc(length, sizeof *made->a);
    if (!status && (!made->place || !made->a))
        status = dl_fail_memory(error, "a collocation method");
    return status;
}

static void destroy(walk *w) {
    gauss *data = w->data;
    if (!data)
        return;
    for (int s = 0; s <= gauss_most_stages; s++)
        gauss_table_free(&data->table[s]);
    free(data->place);
    free(data->a);
    free(data);
}

/* --- the equations ---------------------------------------------------------------------------- */

/* Stages from their accelerations; the largest change. */
static real update_places(walk *w, real h) {
    gauss *data = w->data;
    const gauss_table *table = data->in_use;
    const size_t n = w->model.unknowns, s = (size_t)table->stages;
    real change = 0;
    for (size_t i = 0; i < s; i++)
        for (size_t u = 0; u < n; u++) {
            real sum = 0;
            for (size_t j = 0; j < s && !w->held[u]; j++)
                sum += table->place[i * s + j] * data->a[j * n + u];
            const real place = w->q[u] + h * (table->node[i] * w->v[u] + h * sum);
            change = real_max(change, real_abs(place - data->place[i * n + u]));
            data->place[i * n + u] = place;
        }
    return change;
}

static void update_accelerations(walk *w) {
    gauss *data = w->data;
    const size_t n = w->model.unknowns;
    for (size_t i = 0; i < (size_t)data->in_use->stages; i++)
        model_acceleration(&w->model, &w->pairs, data->place + i * n, data->a + i * n);
}

/* Iterates until nothing changes but for roundoff; false where that does not happen. The stages'
 * accelerations have been guessed. */
static bool solve(walk *w, real h) {
    real size = 0, last = 0;
    for (size_t u = 0; u < w->model.unknowns; u++)
        size = real_max(size, real_abs(w->q[u]) + h * real_abs(w->v[u]));
    const real roundoff = REAL_EPSILON * size;
    for (int i = 0; i < most_iterations; i++) {
        const real change = update_places(w, h);
        if (!real_is_finite(change) || (i > 3 && change > 4 * last && change > 1000 * roundoff))
            return false;
        update_accelerations(w);
        if (i > 0 && (change <= roundoff || (change >= last / 2 && change <= 64 * roundoff)))
            return true;
        last = change;
    }
    return false;
}

/* Accelerations at the stages of a step of length h that begins a time `from` after the last one
 * did, by the polynomials of that. */
static void guess_by_rates(walk *w, real from, real h) {
    gauss *data = w->data;
    const size_t n = w->model.unknowns;
    for (size_t i = 0; i < (size_t)data->in_use->stages; i++) {
        const real tau = (from + data->in_use->node[i] * h) / w->h;
        for (size_t u = 0; u < n; u++) {
            real sum = 0;
            for (int k = w->degree; k >= 0; k--)
                sum = sum * tau + w->rate[(size_t)k * n + u];
            data->a[i * n + u] = sum;
        }
    }
}

static void guess_constant(walk *w) {
    gauss *data = w->data;
    const size_t n = w->model.unknowns;
    model_acceleration(&w->model, &w->pairs, w->q, data->a);
    for (size_t i = 1; i < (size_t)data->in_use->stages; i++)
        memcpy(data->a + i * n, data->a, n * sizeof *data->a);
}

/* --- a step ----------------------------------------------------------------------------------- */

/* Largest coefficient of P_degree, of what moves. */
static real legendre_size(const walk *w, int degree) {
    const gauss *data = w->data;
    const size_t n = w->model.unknowns, s = (size_t)data->in_use->stages;
    const real *row = data->in_use->legendre + (size_t)degree * s;
    real largest = 0;
    for (size_t u = 0; u < n; u++) {
        real sum = 0;
        for (size_t i = 0; i < s && !w->held[u]; i++)
            sum += row[i] * data->a[i * n + u];
        largest = real_max(largest, real_abs(sum));
    }
    return largest;
}

static real largest_acceleration(const walk *w) {
    const gauss *data = w->data;
    const size_t n = w->model.unknowns;
    real largest = 0;
    for (size_t k = 0; k < (size_t)data->in_use->stages * n; k++)
        if (!w->held[k % n])
            largest = real_max(largest, real_abs(data->a[k]));
    return largest;
}

/* From the last coefficient that is more than roundoff. */
static void learn_decay(const walk *w, real h, real size) {
    gauss *data = w->data;
    int m = data->in_use->stages - 1;
    real found = 0;
    while (m > 0 && !(found > 64 * REAL_EPSILON))
        found = legendre_size(w, m--) / size;
    data->decay = found > 64 * REAL_EPSILON ? real_pow(found, (real)1 / (m + 1)) / h : 0;
}

/* By what the step may be multiplied. */
static real judge(const walk *w, real h) {
    gauss *data = w->data;
    const int s = data->in_use->stages;
    const real size = largest_acceleration(w);
    real length, speed;
    walk_scales(w, size, &length, &speed);
    if (size == 0)
        return 4;
    const real moved = real_max(h * h * size / length, h * size / speed);
    const real aim = real_min((real)1 / 100, real_sqrt(w->tolerance / moved));
    const real root = (real)1 / (s - 1), per_degree = real_pow(aim, root);
    const real found =
        real_max(legendre_size(w, s - 1), legendre_size(w, s - 2) * per_degree) / size;
    learn_decay(w, h, size);
    return found > 0 ? real_min(4, (real)9 / 10 * real_pow(aim / found, root)) : 4;
}

static const gauss_table *stages_for(const gauss *data, const walk *w, real h) {
    if (!(data->decay > 0))
        return &data->table[data->most];
    const double fall = log((double)(data->decay * h)), aim = log((double)w->tolerance) / 2;
    const double wanted = fall < 0 ? ceil(aim / fall) + 2 : data->most;
    return &data->table[(int)fmin(fmax(wanted, least_stages), data->most)];
}

static void take_rates(walk *w, real h) {
    const gauss *data = w->data;
    const size_t n = w->model.unknowns, s = (size_t)data->in_use->stages;
    w->h = h;
    w->degree = (int)s - 1;
    for (size_t k = 0; k < s; k++)
        for (size_t u = 0; u < n; u++) {
            real sum = 0;
            for (size_t j = 0; j < s; j++)
                sum += data->in_use->power[k * s + j] * data->a[j * n + u];
            w->rate[k * n + u] = sum;
        }
}

static real first_step(walk *w, real limit) {
    gauss *data = w->data;
    real size = 0, length, speed;
    model_acceleration(&w->model, &w->pairs, w->q, data->a);
    for (size_t u = 0; u < w->model.unknowns; u++)
        size = w->held[u] ? size : real_max(size, real_abs(data->a[u]));
    walk_scales(w, size, &length, &speed);
    return size > 0 ? real_min(limit, real_min(real_sqrt(length / size), speed / size) / 8) : limit;
}

static dl_status attempt(walk *w, real limit, dl_error *error) {
    gauss *data = w->data;
    const real wanted = data->next > 0 ? data->next : first_step(w, limit);
    real h = real_min(limit, wanted);
    for (int k = 0; k < most_attempts; k++) {
        data->in_use = stages_for(data, w, h);
        if (w->goes_on && k == 0 && h <= 3 * w->h / 2)
            guess_by_rates(w, w->h, h);
        else
            guess_constant(w);
        if (!solve(w, h)) {
            data->decay = 0;
            h /= 2;
            continue;
        }
        const real factor = judge(w, h);
        if (factor < (real)17 / 20) {
            h *= real_max(factor, (real)1 / 5);
            continue;
        }
        data->next = h < limit ? h * real_max(factor, 1) : real_max(wanted, h * factor);
        data->solved = h;
        take_rates(w, h);
        return DL_OK;
    }
    return dl_fail(error, DL_STEP_FAILURE, "the step became too small at t = %.10g", (double)w->t);
}

static void end_of_step(const walk *w, real h, real *q, real *v) {
    const gauss *data = w->data;
    const gauss_table *table = data->in_use;
    const size_t n = w->model.unknowns;
    for (size_t u = 0; u < n; u++) {
        real velocity = 0, place = 0;
        for (size_t i = 0; i < (size_t)table->stages && !w->held[u]; i++) {
            velocity += table->weight[i] * data->a[i * n + u];
            place += table->weight[i] * (1 - table->node[i]) * data->a[i * n + u];
        }
        q[u] = w->q[u] + h * (w->v[u] + h * place);
        v[u] = w->v[u] + h * velocity;
    }
}

/* Not the polynomial's value: its own state there, by a step that ends there. */
static dl_status state(walk *w, real span, real *q, real *v, dl_error *error) {
    gauss *data = w->data;
    if (span != data->solved) {
        guess_by_rates(w, 0, span);
        data->solved = span;
        if (!solve(w, span))
            return dl_fail(error, DL_STEP_FAILURE,
                           "the equations of a step to t = %.10g were not solved",
                           (double)(w->t + span));
    }
    end_of_step(w, span, q, v);
    return DL_OK;
}

const stepper stepper_gauss = {
    .create = create,
    .attempt = attempt,
    .state = state,
    .destroy = destroy,
};
