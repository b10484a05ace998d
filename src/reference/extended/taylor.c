/* Taylor series: the coefficients of all accelerations, order by order, pair by pair.
 *
 * With d = r_i - r_j and s = d.d as series, a term of F/r is c s^(-(p + 1)/2), whose coefficients
 * follow from those of s; the force is their product with d, and the next coefficients of the
 * coordinates are those of the accelerations over (n + 1)(n + 2). */
#include <stdlib.h>

#include "reference/extended/series.h"
#include "reference/extended/walk.h"

typedef struct taylor {
    int order; /* the highest */
    size_t rows, room;
    real *record; /* [room][rows][order + 1]: the series of every pair within reach */
    real *x;      /* [order + 3][unknowns] */
    real *a;      /* [order + 1][unknowns] */
    real *size;   /* [order + 1]: the largest coefficient of an acceleration that moves something */
} taylor;

/* What a taper adds to a pair's series. */
enum { ROW_R, ROW_V, ROW_V2, ROW_V3, ROW_POLYNOMIAL, ROW_FADE, ROW_DIFFERENCE, TAPER_ROWS };

static size_t most_rows(const model *of) {
    size_t most = 0;
    for (size_t k = 0; k < of->species * of->species; k++)
        for (int p = 0; p < of->law[k].pieces; p++) {
            const law_piece *piece = &of->law[k].piece[p];
            size_t rows = (size_t)piece->own.terms;
            if (piece->tapers)
                rows += (size_t)piece->next.terms + TAPER_ROWS;
            most = rows > most ? rows : most;
        }
    return of->dimension + 2 + most;
}

static dl_status create(walk *w, dl_error *error) {
    taylor *made = calloc(1, sizeof *made);
    w->data = made;
    if (!made)
        return dl_fail_memory(error, "Taylor series");
    const int wanted = (int)ceil(-log((double)w->tolerance) / 2) + 2;
    made->order = wanted < walk_degree ? wanted : walk_degree;
    made->rows = most_rows(&w->model);
    const size_t n = w->model.unknowns, orders = (size_t)made->order;
    made->x = calloc((orders + 3) * n, sizeof *made->x);
    made->a = calloc((orders + 1) * n, sizeof *made->a);
    made->size = calloc(orders + 1, sizeof *made->size);
    return made->x && made->a && made->size ? DL_OK : dl_fail_memory(error, "Taylor series");
}

static void destroy(walk *w) {
    taylor *data = w->data;
    if (!data)
        return;
    free(data->record);
    free(data->x);
    free(data->a);
    free(data->size);
    free(data);
}

static dl_status make_room(walk *w, dl_error *error) {
    taylor *data = w->data;
    if (w->pairs.active <= data->room)
        return DL_OK;
    const size_t room = w->pairs.active + w->pairs.active / 8;
    free(data->record);
    data->room = 0;
    data->record = malloc(room * data->rows * ((size_t)data->order + 1) * sizeof *data->record);
    if (!data->record)
        return dl_fail_memory(error, "Taylor series");
    data->room = room;
    return DL_OK;
}

/* --- a pair ----------------------------------------------------------------------------------- */

/* The n-th coefficient of a sum over r; the rows of its terms begin at `row`. */
static real sum_coefficient(const law_sum *sum, const real *s, real *row, size_t length, int n) {
    real value = 0, r = 0;
    if (n == 0)
        r = real_sqrt(s[0]);
    for (int k = 0; k < sum->terms; k++, row += length) {
        const law_term *term = &sum->term[k];
        row[n] = n == 0 ? law_term_over_r(term, r, 1 / r)
                        : series_power(s, row, -(term->power + 1) / 2, n);
        value += row[n];
    }
    return value;
}

static real taper_coefficient(const law_piece *piece, const real *s, real own, real *row,
                              size_t length, int n) {
    real *const r = row + ROW_R * length, *const v = row + ROW_V * length;
    real *const v2 = row + ROW_V2 * length, *const v3 = row + ROW_V3 * length;
    real *const polynomial = row + ROW_POLYNOMIAL * length;
    real *const fade = row + ROW_FADE * length, *const difference = row + ROW_DIFFERENCE * length;
    const real next = sum_coefficient(&piece->next, s, row + TAPER_ROWS * length, length, n);
    r[n] = n == 0 ? real_sqrt(s[0]) : series_power(s, r, (real)1 / 2, n);
    v[n] = (n == 0 ? piece->until - r[0] : -r[n]) / piece->width;
    v2[n] = series_square(v, n);
    v3[n] = series_product(v, v2, n);
    polynomial[n] = 6 * v2[n] - 15 * v[n] + (n == 0 ? 10 : 0);
    fade[n] = series_product(v3, polynomial, n);
    difference[n] = own - next;
    return next + series_product(fade, difference, n);
}

static real coefficient_of_place(const walk *w, size_t particle, size_t axis, int n) {
    const taylor *data = w->data;
    const model *of = &w->model;
    return particle < of->moving ? data->x[(size_t)n * of->unknowns + axis * of->moving + particle]
                                 : 0;
}

static void add_pair(walk *w, const pair *p, real *record, int n) {
    taylor *data = w->data;
    const model *of = &w->model;
    const size_t length = (size_t)data->order + 1;
    const law_piece *piece = &p->law->piece[p->piece];
    real *const s = record + of->dimension * length, *const f = s + length;
    real *const terms = f + length, *const a = data->a + (size_t)n * of->unknowns;
    s[n] = 0;
    for (size_t c = 0; c < of->dimension; c++) {
        real *const d = record + c * length;
        d[n] = n == 0 ? pair_separation(of, p, w->q, c)
                      : coefficient_of_place(w, p->i, c, n) - coefficient_of_place(w, p->j, c, n);
        s[n] += series_square(d, n);
    }
    f[n] = sum_coefficient(&piece->own, s, terms, length, n);
    if (piece->tapers)
        f[n] =
            taper_coefficient(piece, s, f[n], terms + (size_t)piece->own.terms * length, length, n);
    for (size_t c = 0; c < of->dimension; c++) {
        const real force = p->coupling * series_product(f, record + c * length, n);
        a[c * of->moving + p->i] += force;
        if (p->j < of->moving)
            a[c * of->moving + p->j] -= force;
    }
}

/* --- a step ----------------------------------------------------------------------------------- */

/* The n-th coefficients of all accelerations and, from them, the (n + 2)-th of the coordinates. */
static void add_order(walk *w, int n) {
    taylor *data = w->data;
    const model *of = &w->model;
    const size_t block = data->rows * ((size_t)data->order + 1);
    real *const a = data->a + (size_t)n * of->unknowns;
    real *const x = data->x + (size_t)(n + 2) * of->unknowns;
    for (size_t u = 0; u < of->unknowns; u++)
        a[u] = 0;
    for (size_t k = 0; k < w->pairs.active; k++)
        add_pair(w, &w->pairs.pair[w->pairs.active_one[k]], data->record + k * block, n);
    data->size[n] = 0;
    for (size_t u = 0; u < of->unknowns; u++) {
        a[u] = a[u] / of->inertia[u % of->moving] + (n == 0 ? of->gravity[u] : 0);
        x[u] = w->held[u] ? 0 : a[u] / ((real)(n + 1) * (n + 2));
        if (!w->held[u])
            data->size[n] = real_max(data->size[n], real_abs(a[u]));
    }
}

/* What the n-th coefficient adds to the state after a time h, in units of the tolerance. */
static real weight(const walk *w, int n, real h, real length, real speed) {
    const taylor *data = w->data;
    const real velocity = data->size[n] * real_pow(h, n + 1) / (n + 1);
    return real_max(velocity / speed, velocity * h / ((n + 2) * length)) / w->tolerance;
}

/* The h with which the n-th coefficient weighs 1. */
static real step_by(const walk *w, int n, real limit, real length, real speed) {
    const taylor *data = w->data;
    if (data->size[n] == 0)
        return limit;
    const real room = w->tolerance / data->size[n];
    return real_min(real_pow(room * speed * (n + 1), (real)1 / (n + 1)),
                    real_pow(room * length * (n + 1) * (n + 2), (real)1 / (n + 2)));
}

static void take_rates(walk *w, int degree, real h) {
    const taylor *data = w->data;
    const size_t n = w->model.unknowns;
    real power = 1;
    for (int k = 0; k <= degree; k++) {
        for (size_t u = 0; u < n; u++)
            w->rate[(size_t)k * n + u] = data->a[(size_t)k * n + u] * power;
        power *= h;
    }
    w->h = h;
    w->degree = degree;
}

static dl_status attempt(walk *w, real limit, dl_error *error) {
    taylor *data = w->data;
    const size_t n = w->model.unknowns;
    const dl_status status = make_room(w, error);
    if (status)
        return status;
    for (size_t u = 0; u < n; u++) {
        data->x[u] = w->q[u];
        data->x[n + u] = w->v[u];
    }
    real length = 1, speed = 1, last = 0;
    for (int k = 0; k <= data->order; k++) {
        add_order(w, k);
        if (!real_is_finite(data->size[k]))
            return dl_fail(error, DL_UNSTABLE,
                           "a force is not finite at t = %.10g: particles coincide or have blown "
                           "up",
                           (double)w->t);
        if (k == 0)
            walk_scales(w, data->size[0], &length, &speed);
        const real now = weight(w, k, limit, length, speed);
        if (k >= 3 && now <= 1 && last <= 1) {
            take_rates(w, k, limit);
            return DL_OK;
        }
        last = now;
    }
    const int top = data->order;
    const real h =
        real_min(step_by(w, top - 1, limit, length, speed), step_by(w, top, limit, length, speed));
    take_rates(w, top, real_min(limit, h));
    return DL_OK;
}

static dl_status state(walk *w, real span, real *q, real *v, dl_error *error) {
    const size_t n = w->model.unknowns;
    const real tau = span / w->h;
    (void)error;
    for (size_t u = 0; u < n; u++) {
        real velocity = 0, place = 0;
        for (int k = w->held[u] ? -1 : w->degree; k >= 0; k--) {
            const real rate = w->rate[(size_t)k * n + u];
            velocity = velocity * tau + rate / (k + 1);
            place = place * tau + rate / ((real)(k + 1) * (k + 2));
        }
        q[u] = w->q[u] + span * (w->v[u] + span * place);
        v[u] = w->v[u] + span * velocity;
    }
    return DL_OK;
}

const stepper stepper_taylor = {
    .create = create,
    .attempt = attempt,
    .state = state,
    .destroy = destroy,
};
