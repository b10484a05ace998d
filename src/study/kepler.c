#include "study/kepler.h"

#include <math.h>
#include <stdbool.h>

#include "core/quad.h"

typedef struct orbit {
    int dimension;
    __float128 d[3], w[3];          /* relative position and velocity at the start */
    __float128 centre[3], drift[3]; /* centre of mass and its velocity */
    __float128 share[2];            /* body i stands at centre + share[i] d */
    __float128 mu, r, axis, sigma;  /* semi-major axis; sigma = d.w / sqrt(mu) */
} orbit;

static orbit orbit_of(const dl_scene *scene) {
    orbit made = {.dimension = scene->dimension};
    /* a pinned body is one of infinite inertia */
    const __float128 w1 = scene->pinned[0] ? 0 : 1 / (__float128)scene->inertia[0];
    const __float128 w2 = scene->pinned[1] ? 0 : 1 / (__float128)scene->inertia[1];
    const __float128 product = (__float128)scene->coupling[0] * scene->coupling[1];
    __float128 speed2 = 0, r2 = 0, dot = 0;
    for (size_t k = 0; k < (size_t)scene->dimension; k++) {
        const double *x = scene->position + 2 * k, *v = scene->velocity + 2 * k;
        const __float128 v1 = scene->pinned[0] ? 0 : v[0], v2 = scene->pinned[1] ? 0 : v[1];
        made.d[k] = (__float128)x[0] - x[1];
        made.w[k] = v1 - v2;
        made.centre[k] = x[0] - w1 / (w1 + w2) * made.d[k];
        made.drift[k] = v1 - w1 / (w1 + w2) * made.w[k];
        r2 += made.d[k] * made.d[k];
        speed2 += made.w[k] * made.w[k];
        dot += made.d[k] * made.w[k];
    }
    made.share[0] = w1 / (w1 + w2);
    made.share[1] = -w2 / (w1 + w2);
    made.mu = -(__float128)scene->law.piece[0].term[0].coefficient * product * (w1 + w2);
    made.r = sqrtq(r2);
    made.axis = 1 / (2 / made.r - speed2 / made.mu);
    made.sigma = dot / sqrtq(made.mu);
    return made;
}

static bool is_free(const dl_scene *scene) {
    bool pulled = scene->walls.present || scene->periods.present || scene->radiation.present;
    for (int k = 0; k < scene->dimension; k++)
        pulled = pulled || scene->gravity[k] != 0;
    return !pulled;
}

dl_status dl_kepler_check(const dl_scene *scene, dl_error *error) {
    const dl_pair_law *law = &scene->law;
    if (scene->particles != 2)
        return dl_fail(error, DL_INPUT, "found %zu particles in scene %s, expected two",
                       scene->particles, scene->name);
    if (law->pieces != 1 || isfinite(law->piece[0].until) || law->piece[0].terms != 1 ||
        law->piece[0].term[0].power != 2 || !(law->piece[0].term[0].coefficient < 0) ||
        !(scene->coupling[0] * scene->coupling[1] > 0))
        return dl_fail(error, DL_INPUT,
                       "found another pair law in scene %s, expected one attractive term of power "
                       "2 without a cutoff",
                       scene->name);
    if (!is_free(scene))
        return dl_fail(error, DL_INPUT,
                       "found walls, gravity, periods or radiation in scene %s, expected two "
                       "bodies that only attract each other",
                       scene->name);
    const orbit path = orbit_of(scene);
    if (!(path.axis > 0) || !isfinite((double)path.axis))
        return dl_fail(error, DL_INPUT,
                       "found an orbit that is not bound in scene %s, expected "
                       "an ellipse",
                       scene->name);
    return DL_OK;
}

/* Change E of eccentric anomaly in time t:
 *     n t = E + (sigma/sqrt(a)) (1 - cos E) - (1 - r/a) sin E,     n = sqrt(mu/a^3)
 * The right-hand side grows with E, so that Newton's step can be kept inside a bracket. */
static dl_status anomaly(const orbit *path, __float128 t, __float128 *solution, dl_error *error) {
    const __float128 mean = sqrtq(path->mu / path->axis) / path->axis * t;
    const __float128 s = path->sigma / sqrtq(path->axis), c = 1 - path->r / path->axis;
    __float128 low = mean - 3, high = mean + 3, e = mean;
    for (int iteration = 0; iteration < 200; iteration++) {
        const __float128 value = e + s * (1 - cosq(e)) - c * sinq(e) - mean;
        const __float128 slope = 1 + s * sinq(e) - c * cosq(e);
        if (value > 0)
            high = e;
        else
            low = e;
        __float128 next = e - value / slope;
        if (!(next > low && next < high))
            next = (low + high) / 2;
        if (fabsq(next - e) <= 4 * (__float128)0x1p-112 * (1 + fabsq(e))) {
            *solution = next;
            return DL_OK;
        }
        e = next;
    }
    return dl_fail(error, DL_ERROR, "Kepler's equation was not solved at t = %.17g", (double)t);
}

dl_status dl_kepler_position(const dl_scene *scene, double t, double *position, double *low,
                             dl_error *error) {
    const orbit path = orbit_of(scene);
    __float128 e = 0;
    dl_status status = anomaly(&path, t, &e, error);
    if (status != DL_OK)
        return status;
    const __float128 a = path.axis, root = sqrtq(a / path.mu);
    const __float128 f = 1 - a / path.r * (1 - cosq(e));
    const __float128 g = a * path.sigma / sqrtq(path.mu) * (1 - cosq(e)) + path.r * root * sinq(e);
    for (int k = 0; k < path.dimension; k++) {
        const __float128 d = f * path.d[k] + g * path.w[k];
        const __float128 centre = path.centre[k] + path.drift[k] * t;
        for (int i = 0; i < 2; i++) {
            const __float128 place = centre + path.share[i] * d;
            position[2 * k + i] = (double)place;
            if (low)
                low[2 * k + i] = (double)(place - position[2 * k + i]);
        }
    }
    return DL_OK;
}
