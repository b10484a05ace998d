/* TR299 (3.14), as model/radiation.c has it. */
#include "reference/extended/walk.h"

typedef struct centre {
    real at[3], velocity[3];
} centre;

static centre mass_centre(const walk *w) {
    const size_t n = w->model.moving;
    centre mean = {{0}, {0}};
    real mass = 0;
    for (size_t k = 0; k < n; k++)
        mass += w->model.inertia[k];
    for (size_t c = 0; c < w->model.dimension; c++) {
        for (size_t k = 0; k < n; k++) {
            mean.at[c] += w->model.inertia[k] * w->q[c * n + k];
            mean.velocity[c] += w->model.inertia[k] * w->v[c * n + k];
        }
        mean.at[c] /= mass;
        mean.velocity[c] /= mass;
    }
    return mean;
}

static real separation(const walk *w, size_t k, const real from[3], real d[3]) {
    real square = 0;
    for (size_t c = 0; c < w->model.dimension; c++) {
        d[c] = model_place(&w->model, w->q, k, c) - from[c];
        square += d[c] * d[c];
    }
    return square;
}

/* The cosine is the double's: it is part of the scene as much as its numbers are. */
static bool is_on_boundary(const walk *w, size_t k, const real at[3]) {
    const dl_radiation *radiation = &w->model.scene->radiation;
    const double pi = 3.14159265358979323846, tiny = 1e-12;
    const real least_cosine = cos(radiation->opening * pi / 360) - tiny;
    const real reach = radiation->reach;
    real outward[3] = {0}, d[3] = {0}, place[3] = {0};
    const real r = real_sqrt(separation(w, k, at, outward));
    for (size_t c = 0; c < w->model.dimension; c++)
        place[c] = model_place(&w->model, w->q, k, c);
    for (size_t j = 0; r > 0 && j < w->model.particles; j++) {
        const real square = separation(w, j, place, d);
        if (j == k || square > reach * reach)
            continue;
        const real along = d[0] * outward[0] + d[1] * outward[1] + d[2] * outward[2];
        if (along >= least_cosine * r * real_sqrt(square))
            return false;
    }
    return r > 0;
}

static bool is_outer(const walk *w, size_t k, const real at[3]) {
    const dl_radiation *radiation = &w->model.scene->radiation;
    const real beyond = radiation->beyond;
    real d[3];
    if (radiation->boundary)
        return is_on_boundary(w, k, at);
    return separation(w, k, at, d) > beyond * beyond;
}

void walk_radiate(walk *w) {
    const dl_radiation *radiation = &w->model.scene->radiation;
    const size_t n = w->model.moving;
    const centre mean = mass_centre(w);
    for (size_t k = 0; k < n; k++) {
        if (!is_outer(w, k, mean.at))
            continue;
        const bool light = w->q[n + k] >= mean.at[1];
        const real factor = light ? radiation->factor_above : radiation->factor_below;
        for (size_t c = 0; c < w->model.dimension; c++) {
            const real base = radiation->frame == DL_FRAME_CENTRE ? mean.velocity[c] : 0;
            w->v[c * n + k] = base + factor * (w->v[c * n + k] - base);
        }
    }
}
