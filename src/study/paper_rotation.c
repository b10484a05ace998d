/* How fast the system turns that is left where particles have escaped: far from their common mass
 * centre, what is left does not turn about it. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "study/paper_quantity.h"

static size_t find_root(size_t *root, size_t i) {
    while (root[i] != i)
        i = root[i] = root[root[i]];
    return i;
}

/* Particles nearer to one another than `link` have one root; mass[root] is their group's. */
static void find_groups(const dl_scene *scene, const double *y_all, double link, size_t *root,
                        double *mass) {
    const size_t n = scene->particles;
    for (size_t i = 0; i < n; i++) {
        root[i] = i;
        mass[i] = 0;
    }
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++) {
            const double dx = y_all[i] - y_all[j], dy = y_all[n + i] - y_all[n + j];
            if (dx * dx + dy * dy < link * link)
                root[find_root(root, i)] = find_root(root, j);
        }
    for (size_t i = 0; i < n; i++)
        mass[find_root(root, i)] += scene->inertia[i];
}

/* Angular momentum over moment of inertia of the particles of one root, about their centre. */
static double rotation_of(const dl_scene *scene, const double *y_all, size_t *root, size_t system) {
    const size_t n = scene->particles;
    double mass = 0, mean[4] = {0}, momentum = 0, inertia = 0;
    for (size_t i = 0; i < n; i++)
        if (find_root(root, i) == system) {
            mass += scene->inertia[i];
            for (size_t c = 0; c < 4; c++)
                mean[c] += scene->inertia[i] * y_all[c * n + i];
        }
    for (size_t i = 0; i < n; i++)
        if (find_root(root, i) == system) {
            double z[4];
            for (size_t c = 0; c < 4; c++)
                z[c] = y_all[c * n + i] - mean[c] / mass;
            momentum += scene->inertia[i] * (z[0] * z[3] - z[1] * z[2]);
            inertia += scene->inertia[i] * (z[0] * z[0] + z[1] * z[1]);
        }
    return momentum / inertia;
}

dl_status dl_paper_rotation(const dl_scene *scene, const double *y_all, double *rate,
                            dl_error *error) {
    const size_t n = scene->particles;
    if (scene->dimension != 2)
        return dl_fail(error, DL_INPUT, "found 3 dimensions, expected 2");
    size_t *root = calloc(n, sizeof *root), system = 0;
    double *mass = calloc(n, sizeof *mass);
    if (!root || !mass) {
        free(root);
        free(mass);
        return dl_fail_memory(error, "groups of particles");
    }
    find_groups(scene, y_all, dl_escape_link(scene), root, mass);
    for (size_t i = 1; i < n; i++)
        if (mass[i] > mass[system])
            system = i;
    *rate = rotation_of(scene, y_all, root, system);
    free(root);
    free(mass);
    return isfinite(*rate) ? DL_OK : dl_fail(error, DL_INPUT, "a single particle does not turn");
}
