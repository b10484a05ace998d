/* Periodic liquids built in C, and sums over pairs written down once more, independently of the
 * library's kernels. */
#ifndef FIXTURE_PERIODIC_H
#define FIXTURE_PERIODIC_H

#include "driftlab/model.h"
#include "fixture_scenes.h"

/* `axes`: bit c set where axis c is periodic, from low = -1 on. */
FIXTURE void fixture_periods(dl_scene *scene, unsigned axes, double length) {
    scene->periods.present = axes != 0;
    for (int c = 0; c < scene->dimension; c++) {
        scene->periods.low[c] = -1;
        scene->periods.length[c] = axes >> c & 1 ? length : 0;
    }
}

/* side^dimension Lennard-Jones particles with the hard cutoff 1.5 on a disturbed square lattice of
 * spacing 1.1 that fills the period; those beside the boundary lie on both sides of it. */
FIXTURE dl_scene *fixture_liquid(int dimension, size_t side, unsigned axes) {
    const size_t n = dimension == 2 ? side * side : side * side * side;
    dl_scene *scene = fixture_scene("fixture-liquid", dimension, n);
    fixture_law(scene, 1.5, 24, 7, 48, 13);
    for (size_t i = 0; i < n; i++) {
        const size_t place[3] = {i % side, i / side % side, i / side / side};
        double at[3], velocity[3];
        for (unsigned c = 0; c < 3; c++) {
            at[c] = -1 + 1.1 * (double)place[c] + 0.06 * fixture_noise(6 * (unsigned)i + c);
            velocity[c] = fixture_noise(6 * (unsigned)i + 3 + c);
        }
        fixture_place(scene, i, at, velocity);
    }
    fixture_periods(scene, axes, 1.1 * (double)side);
    scene->step = 0.002;
    scene->end = 0.2;
    return scene;
}

FIXTURE const dl_pair_law *fixture_law_of(const dl_scene *scene, size_t i, size_t j) {
    if (scene->species == 0)
        return &scene->law;
    return &scene->species_law[(size_t)scene->species_of[i] * scene->species +
                               (size_t)scene->species_of[j]];
}

/* F(r) of a law with hard ends. */
FIXTURE double fixture_force(const dl_pair_law *law, double r) {
    double sum = 0;
    int k = 0;
    while (k < law->pieces && r > law->piece[k].until)
        k++;
    for (int s = 0; k < law->pieces && s < law->piece[k].terms; s++)
        sum += law->piece[k].term[s].coefficient * pow(r, -law->piece[k].term[s].power);
    return sum;
}

/* V(r) of a law of one hard piece with powers other than 1. */
FIXTURE double fixture_potential(const dl_pair_law *law, double r) {
    double sum = 0;
    for (int s = 0; law->pieces && r <= law->piece[0].until && s < law->piece[0].terms; s++) {
        const double c = law->piece[0].term[s].coefficient, p = law->piece[0].term[s].power;
        const double end = isinf(law->piece[0].until) ? 0 : pow(law->piece[0].until, 1 - p);
        sum += c / (p - 1) * (pow(r, 1 - p) - end);
    }
    return sum;
}

/* Calls for every pair and every copy of j in the periods around, i < j: the sums that minimum
 * image stands for. x of all particles, in the scene's order. */
typedef void fixture_copy_visitor(const dl_scene *scene, size_t i, size_t j, const double d[3],
                                  double r, void *context);

FIXTURE void fixture_visit_copies(const dl_scene *scene, const double *x,
                                  fixture_copy_visitor *visit, void *context) {
    const size_t n = scene->particles;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++) {
            double base[3] = {0};
            int most[3] = {0};
            for (int c = 0; c < scene->dimension; c++) {
                const double length = scene->periods.length[c];
                base[c] = x[(size_t)c * n + i] - x[(size_t)c * n + j];
                if (length > 0) {
                    base[c] = remainder(base[c], length);
                    most[c] = 1;
                }
            }
            for (int a = -most[0]; a <= most[0]; a++)
                for (int b = -most[1]; b <= most[1]; b++)
                    for (int e = -most[2]; e <= most[2]; e++) {
                        const int copy[3] = {a, b, e};
                        double d[3], s = 0;
                        for (int c = 0; c < 3; c++) {
                            d[c] = base[c] + copy[c] * scene->periods.length[c];
                            s += d[c] * d[c];
                        }
                        visit(scene, i, j, d, sqrt(s), context);
                    }
        }
}

#endif
