/* What ends a step: the first time at which a pair leaves the piece of its law, a particle a wall's
 * inside, or the press of a contact turns. */
#include "reference/extended/walk.h"

static const real margin = 16; /* of roundoff */

void walk_make_path(walk *w) {
    const size_t n = w->model.unknowns, moving = w->model.moving;
    for (size_t k = 0; k < w->model.particles; k++)
        w->reach[k] = 0;
    for (size_t u = 0; u < n; u++) {
        w->path[u] = w->q[u];
        w->path[n + u] = w->h * w->v[u];
        real bound = real_abs(w->path[n + u]);
        for (size_t k = 0; k <= (size_t)w->degree; k++) {
            const real c =
                w->held[u] ? 0 : w->h * w->h * w->rate[k * n + u] / ((real)(k + 1) * (k + 2));
            w->path[(k + 2) * n + u] = c;
            bound += real_abs(c);
        }
        w->reach[u % moving] += bound;
    }
}

/* What has certainly been goes first. */
static void lower(event *first, const event *found) {
    if (found->latest < first->latest)
        *first = *found;
}

/* --- pairs ------------------------------------------------------------------------------------ */

typedef struct relative {
    int degree;
    real d[3][walk_degree + 3]; /* r_i - r_j of an image */
    real size;                  /* of the coordinates that it is the difference of */
} relative;

/* What roundoff may have made of r^2 - at^2: that of the coordinates counts. */
static real roundoff_of_square(real r, real at, real size) {
    return REAL_EPSILON * (r * r + at * at + 2 * r * size);
}

static real coordinate_size(const model *of, const pair *p, const real *q) {
    real size = 0;
    for (size_t c = 0; c < of->dimension; c++)
        size += real_abs(model_place(of, q, p->i, c)) + real_abs(model_place(of, q, p->j, c));
    return size;
}

static void fill_relative(const walk *w, const pair *p, relative *path) {
    const model *of = &w->model;
    const size_t n = of->unknowns, moving = of->moving;
    path->degree = w->degree + 2;
    path->size = coordinate_size(of, p, w->q);
    for (size_t c = 0; c < of->dimension; c++) {
        path->d[c][0] = pair_separation(of, p, w->q, c);
        for (int k = 1; k <= path->degree; k++) {
            const real *row = w->path + (size_t)k * n + c * moving;
            path->d[c][k] = row[p->i] - (p->j < moving ? row[p->j] : 0);
        }
    }
}

static real distance_at_start(const relative *path, size_t dimension) {
    real square = 0;
    for (size_t c = 0; c < dimension; c++)
        square += path->d[c][0] * path->d[c][0];
    return real_sqrt(square);
}

/* Bound of how far the separation moves. */
static real relative_reach(const relative *path, size_t dimension) {
    real sum = 0;
    for (size_t c = 0; c < dimension; c++)
        for (int k = 1; k <= path->degree; k++)
            sum += real_abs(path->d[c][k]);
    return sum;
}

/* sign (r^2 - at^2) as a polynomial; where it turns negative. */
static void exit_across(const relative *path, size_t dimension, real at, int sign, event *found) {
    real c[polynomial_degree + 1] = {0};
    const int top = path->degree;
    for (int k = 0; k <= 2 * top; k++) {
        for (size_t axis = 0; axis < dimension; axis++)
            for (int i = k > top ? k - top : 0; i <= k && i <= top; i++)
                c[k] += path->d[axis][i] * path->d[axis][k - i];
    }
    const real roundoff = margin * roundoff_of_square(real_sqrt(c[0]), at, path->size);
    c[0] -= at * at;
    for (int k = 0; k <= 2 * top && sign < 0; k++)
        c[k] = -c[k];
    found->tau = polynomial_exit(c, 2 * top, roundoff, &found->latest);
}

static void look_at_ends(const walk *w, size_t index, const pair *p, event *first) {
    const law_piece *piece = &p->law->piece[p->piece];
    const size_t dimension = w->model.dimension;
    relative path;
    fill_relative(w, p, &path);
    const real r = distance_at_start(&path, dimension), moves = relative_reach(&path, dimension);
    event found = {.kind = EVENT_BREAKPOINT, .pair = index};
    for (int c = 0; c < 3; c++)
        found.image[c] = p->image[c];
    if (piece->begin > 0 && r - moves <= piece->begin) {
        exit_across(&path, dimension, piece->begin, 1, &found);
        found.piece = p->piece - 1;
        lower(first, &found);
    }
    if (piece->ends && r + moves >= piece->until) {
        exit_across(&path, dimension, piece->until, -1, &found);
        found.piece = p->piece + 1;
        lower(first, &found);
    }
}

/* A pair out of reach, one of its images. */
static void look_at_approach(const walk *w, size_t index, const pair *image, event *first) {
    const real cutoff = image->law->piece[image->law->pieces - 1].until;
    const size_t dimension = w->model.dimension;
    relative path;
    fill_relative(w, image, &path);
    if (distance_at_start(&path, dimension) - relative_reach(&path, dimension) > cutoff)
        return;
    event found = {.kind = EVENT_BREAKPOINT, .pair = index, .piece = image->law->pieces - 1};
    exit_across(&path, dimension, cutoff, 1, &found);
    for (int c = 0; c < 3; c++)
        found.image[c] = image->image[c];
    lower(first, &found);
}

/* Whole periods along an axis whose image can come within the cutoff: *first ... *last. */
static void find_images(const walk *w, const pair *p, size_t axis, int *first, int *last) {
    const model *of = &w->model;
    const real cutoff = p->law->piece[p->law->pieces - 1].until;
    const real moves = w->reach[p->i] + w->reach[p->j], period = of->period[axis];
    const real d = model_place(of, w->q, p->i, axis) - model_place(of, w->q, p->j, axis);
    const int nearest = period > 0 ? (int)real_round(d / period) : 0;
    const int others = period > 0 ? 1 : 0;
    *first = nearest + others + 1;
    *last = nearest - others - 1;
    for (int image = nearest - others; image <= nearest + others; image++)
        if (real_abs(d - image * period) - moves <= cutoff) {
            *first = image < *first ? image : *first;
            *last = image;
        }
}

static void look_at_images(const walk *w, size_t index, event *found) {
    int first[3] = {0}, last[3] = {0};
    pair image = w->pairs.pair[index];
    for (size_t c = 0; c < w->model.dimension; c++)
        find_images(w, &image, c, &first[c], &last[c]);
    for (int x = first[0]; x <= last[0]; x++)
        for (int y = first[1]; y <= last[1]; y++)
            for (int z = first[2]; z <= last[2]; z++) {
                image.image[0] = x;
                image.image[1] = y;
                image.image[2] = z;
                look_at_approach(w, index, &image, found);
            }
}

static void look_at_pair(const walk *w, size_t index, event *first) {
    const pair *p = &w->pairs.pair[index];
    const real moves = w->reach[p->i] + w->reach[p->j];
    if (p->piece == p->law->pieces) {
        look_at_images(w, index, first);
        return;
    }
    const law_piece *piece = &p->law->piece[p->piece];
    if (piece->begin == 0 && !piece->ends)
        return;
    real square = 0;
    for (size_t c = 0; c < w->model.dimension; c++) {
        const real d = pair_separation(&w->model, p, w->q, c);
        square += d * d;
    }
    const real low = piece->begin + moves, high = piece->ends ? piece->until - moves : 0;
    if ((piece->begin > 0 && square <= low * low) ||
        (piece->ends && (high <= 0 || square >= high * high)))
        look_at_ends(w, index, p, first);
}

/* --- walls ------------------------------------------------------------------------------------ */

/* Below it the press of a contact may be 0: a polynomial's error, wide enough for collocation. A
 * press that turns passes it so soon that nothing has moved meanwhile: that goes with the third
 * power of the time. */
static real press_noise(const walk *w, size_t u) {
    return real_sqrt(REAL_EPSILON) * w->load[u] / 1000;
}

/* What is on the wall without normal velocity, but in no contact: the first coefficient of its
 * acceleration that is more than roundoff, or than a polynomial's error, tells whether it leaves or
 * is pressed, and rests. */
static void look_at_touch(const walk *w, size_t u, int side, event *first) {
    const size_t n = w->model.unknowns;
    const event found = {.kind = EVENT_WALL, .coordinate = u, .side = side};
    real noise = press_noise(w, u);
    for (int k = 0; k <= w->degree; k++) {
        const real rate = -side * w->rate[(size_t)k * n + u];
        if (rate < -noise)
            lower(first, &found);
        if (real_abs(rate) > noise)
            return;
        noise = real_sqrt(REAL_EPSILON) * w->load[u];
    }
}

static void look_at_wall(const walk *w, size_t u, int side, event *first) {
    const size_t n = w->model.unknowns, axis = u / w->model.moving;
    const dl_walls *walls = &w->model.scene->walls;
    const double place = side < 0 ? walls->low[axis] : walls->high[axis];
    if (!isfinite(place) || -side * (w->q[u] - place) > w->reach[u % w->model.moving])
        return;
    if (w->q[u] == place && w->v[u] == 0) {
        look_at_touch(w, u, side, first);
        return;
    }
    real c[walk_degree + 3], size = real_abs(place);
    for (int k = 0; k <= w->degree + 2; k++) {
        c[k] = -side * w->path[(size_t)k * n + u];
        size += real_abs(c[k]);
    }
    c[0] = -side * (w->q[u] - place);
    event found = {.kind = EVENT_WALL, .coordinate = u, .side = side};
    found.tau = polynomial_exit(c, w->degree + 2, margin * REAL_EPSILON * size, &found.latest);
    lower(first, &found);
}

/* Only what is pressed rests: a particle at a side wall falls when the others are out of reach. By
 * `located` a contact may begin without a press, in the moment before one. */
static bool nothing_presses(const walk *w, size_t u, const real *c) {
    bool nothing = !w->slides[u] && (w->model.scene->walls.rule == DL_MIRROR || w->pressed[u]);
    for (int k = 0; k <= w->degree; k++)
        nothing = nothing && c[k] == 0;
    return nothing;
}

static void look_at_contact(const walk *w, size_t u, event *first) {
    const size_t n = w->model.unknowns;
    real c[walk_degree + 1];
    for (int k = 0; k <= w->degree; k++)
        c[k] = w->side[u] * w->rate[(size_t)k * n + u];
    event found = {.kind = EVENT_RELEASE, .coordinate = u, .side = w->side[u]};
    if (nothing_presses(w, u, c)) {
        found.tau = found.latest = 0;
        found.idle = true;
        lower(first, &found);
        return;
    }
    found.tau = polynomial_exit(c, w->degree, press_noise(w, u), &found.latest);
    lower(first, &found);
}

/* --- all -------------------------------------------------------------------------------------- */

event walk_find_event(walk *w) {
    event first = {.kind = EVENT_NONE, .tau = 2, .latest = 2}, release = first;
    if (w->model.scene->walls.present)
        model_load(&w->model, &w->pairs, w->q, w->load);
    for (size_t k = 0; k < w->pairs.count; k++)
        look_at_pair(w, k, &first);
    for (size_t u = 0; w->model.scene->walls.present && u < w->model.unknowns; u++) {
        if (w->side[u] != 0)
            look_at_contact(w, u, &release);
        if (w->held[u])
            continue;
        look_at_wall(w, u, 1, &first);
        look_at_wall(w, u, -1, &first);
    }
    /* A press that vanishes just where something hits the wall may only seem to turn. */
    return release.latest < 2 * first.tau - first.latest ? release : first;
}

static real pair_value(const walk *w, const event *what, const real *q, const real *v, real *slope,
                       real *roundoff) {
    const model *of = &w->model;
    const size_t moving = of->moving;
    pair p = w->pairs.pair[what->pair];
    const int outwards = what->piece > p.piece;
    const real at = outwards ? p.law->piece[p.piece].until : p.law->piece[what->piece].until;
    real square = 0, rate = 0;
    for (size_t c = 0; c < of->dimension; c++) {
        p.image[c] = what->image[c];
        const real d = pair_separation(of, &p, q, c);
        square += d * d;
        rate += 2 * d * (v[c * moving + p.i] - (p.j < moving ? v[c * moving + p.j] : 0));
    }
    const int sign = outwards ? -1 : 1;
    *slope = sign * rate;
    *roundoff = roundoff_of_square(real_sqrt(square), at, coordinate_size(of, &p, q));
    return sign * (square - at * at);
}

/* The press of a contact; its slope is the step's own. */
static real press_value(walk *w, const event *what, const real *q, real *slope, real *roundoff) {
    const size_t n = w->model.unknowns, u = what->coordinate;
    real sum = 0, size = 0;
    for (int k = w->degree; k >= 0; k--) {
        const real c = w->rate[(size_t)k * n + u];
        sum = k > 0 ? sum * what->tau + k * c : sum;
        size += real_abs(c);
    }
    model_acceleration(&w->model, &w->pairs, q, w->a);
    *slope = what->side * sum / w->h;
    *roundoff = REAL_EPSILON * (size + w->load[u]);
    return what->side * w->a[u];
}

real walk_event_value(walk *w, const event *what, const real *q, const real *v, real *slope,
                      real *roundoff) {
    if (what->kind == EVENT_BREAKPOINT)
        return pair_value(w, what, q, v, slope, roundoff);
    if (what->kind == EVENT_RELEASE)
        return press_value(w, what, q, slope, roundoff);
    const size_t u = what->coordinate, axis = u / w->model.moving;
    const dl_walls *walls = &w->model.scene->walls;
    const double place = what->side < 0 ? walls->low[axis] : walls->high[axis];
    *slope = -what->side * v[u];
    *roundoff = REAL_EPSILON * (real_abs(place) + real_abs(q[u]));
    return -what->side * (q[u] - place);
}
