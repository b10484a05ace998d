#include "study/kepler.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>

typedef struct orbit {
    int dimension;
    long double d[3], w[3];          /* relative position and velocity at the start */
    long double centre[3], drift[3]; /* centre of mass and its velocity */
    long double share[2];            /* body i stands at centre + share[i] d */
    long double mu, r, axis, sigma;  /* semi-major axis; sigma = d.w / sqrt(mu) */
} orbit;

static orbit orbit_of(const dl_scene *scene) {
    orbit made = {.dimension = scene->dimension};
    const long double m1 = scene->inertia[0], m2 = scene->inertia[1], total = m1 + m2;
    const long double product = (long double)scene->coupling[0] * scene->coupling[1];
    long double speed2 = 0, r2 = 0, dot = 0;
    for (size_t k = 0; k < (size_t)scene->dimension; k++) {
        const double *x = scene->position + 2 * k, *v = scene->velocity + 2 * k;
        made.d[k] = (long double)x[0] - x[1];
        made.w[k] = (long double)v[0] - v[1];
        made.centre[k] = (m1 * x[0] + m2 * x[1]) / total;
        made.drift[k] = (m1 * v[0] + m2 * v[1]) / total;
        r2 += made.d[k] * made.d[k];
        speed2 += made.w[k] * made.w[k];
        dot += made.d[k] * made.w[k];
    }
    made.share[0] = m2 / total;
    made.share[1] = -m1 / total;
    made.mu = -(long double)scene->law.piece[0].term[0].coefficient * product * (1 / m1 + 1 / m2);
    made.r = sqrtl(r2);
    made.axis = 1 / (2 / made.r - speed2 / made.mu);
    made.sigma = dot / sqrtl(made.mu);
    return made;
}

static bool is_free(const dl_scene *scene) {
    bool pulled = scene->walls.present || scene->pinned[0] || scene->pinned[1];
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
                       "found walls, gravity or a pinned particle in scene %s, expected two free "
                       "bodies",
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
static dl_status anomaly(const orbit *path, long double t, long double *solution, dl_error *error) {
    const long double mean = sqrtl(path->mu / path->axis) / path->axis * t;
    const long double s = path->sigma / sqrtl(path->axis), c = 1 - path->r / path->axis;
    long double low = mean - 3, high = mean + 3, e = mean;
    for (int iteration = 0; iteration < 200; iteration++) {
        const long double value = e + s * (1 - cosl(e)) - c * sinl(e) - mean;
        const long double slope = 1 + s * sinl(e) - c * cosl(e);
        if (value > 0)
            high = e;
        else
            low = e;
        long double next = e - value / slope;
        if (!(next > low && next < high))
            next = (low + high) / 2;
        if (fabsl(next - e) <= 2 * LDBL_EPSILON * (1 + fabsl(e))) {
            *solution = next;
            return DL_OK;
        }
        e = next;
    }
    return dl_fail(error, DL_ERROR, "Kepler's equation was not solved at t = %.17Lg", t);
}

dl_status dl_kepler_position(const dl_scene *scene, double t, double *position, dl_error *error) {
    const orbit path = orbit_of(scene);
    long double e = 0;
    dl_status status = anomaly(&path, t, &e, error);
    if (status != DL_OK)
        return status;
    const long double a = path.axis, root = sqrtl(a / path.mu);
    const long double f = 1 - a / path.r * (1 - cosl(e));
    const long double g = a * path.sigma / sqrtl(path.mu) * (1 - cosl(e)) + path.r * root * sinl(e);
    for (int k = 0; k < path.dimension; k++) {
        const long double d = f * path.d[k] + g * path.w[k];
        const long double centre = path.centre[k] + path.drift[k] * t;
        for (int i = 0; i < 2; i++)
            position[2 * k + i] = (double)(centre + path.share[i] * d);
    }
    return DL_OK;
}
