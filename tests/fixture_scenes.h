/* Scenes built in C, for tests that need no scene file. Free with dl_scene_free. All are made of
 * closed formulas, so that every run of a test sees the same bits. */
#ifndef FIXTURE_SCENES_H
#define FIXTURE_SCENES_H

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/scene.h"

/* A test file uses some of these, not all. */
#define FIXTURE static inline __attribute__((unused))

FIXTURE char *fixture_text(const char *text) {
    char *copy = malloc(strlen(text) + 1);
    return copy ? strcpy(copy, text) : NULL;
}

/* `particles` of unit inertia and coupling at the origin, at rest, nothing acting on them. */
FIXTURE dl_scene *fixture_scene(const char *name, int dimension, size_t particles) {
    dl_scene *scene = calloc(1, sizeof *scene);
    if (!scene)
        abort();
    scene->name = fixture_text(name);
    scene->source = fixture_text("tests/fixture_scenes.h");
    scene->file = fixture_text("tests/fixture_scenes.h");
    scene->text = fixture_text("");
    scene->dimension = dimension;
    scene->particles = particles;
    const size_t length = (size_t)dimension * particles;
    scene->position = calloc(length, sizeof *scene->position);
    scene->velocity = calloc(length, sizeof *scene->velocity);
    scene->inertia = calloc(particles, sizeof *scene->inertia);
    scene->coupling = calloc(particles, sizeof *scene->coupling);
    scene->feels_gravity = calloc(particles, sizeof *scene->feels_gravity);
    scene->pinned = calloc(particles, sizeof *scene->pinned);
    if (!scene->position || !scene->velocity || !scene->inertia || !scene->coupling ||
        !scene->feels_gravity || !scene->pinned)
        abort();
    for (size_t i = 0; i < particles; i++)
        scene->inertia[i] = scene->coupling[i] = 1;
    for (int axis = 0; axis < 3; axis++) {
        scene->walls.low[axis] = -INFINITY;
        scene->walls.high[axis] = INFINITY;
    }
    scene->step = 0.01;
    scene->end = 1;
    return scene;
}

FIXTURE void fixture_place(dl_scene *scene, size_t particle, const double at[3],
                           const double velocity[3]) {
    for (int axis = 0; axis < scene->dimension; axis++) {
        const size_t k = (size_t)axis * scene->particles + particle;
        scene->position[k] = at[axis];
        scene->velocity[k] = velocity[axis];
    }
}

/* One piece: attraction r^(-a) and repulsion r^(-b), up to `until`. */
FIXTURE void fixture_law(dl_scene *scene, double until, double attraction, double a,
                         double repulsion, double b) {
    scene->law.pieces = 1;
    scene->law.piece[0].until = until;
    scene->law.piece[0].terms = 2;
    scene->law.piece[0].term[0] = (dl_term){.coefficient = -attraction, .power = a};
    scene->law.piece[0].term[1] = (dl_term){.coefficient = repulsion, .power = b};
}

/* The same forces in two parts: of each piece the first term is slow, or a half of its only one. */
FIXTURE void fixture_split(dl_scene *scene) {
    for (int k = 0; k < scene->law.pieces; k++) {
        dl_piece *piece = &scene->law.piece[k];
        piece->part[0] = DL_PART_SLOW;
        if (piece->terms > 1)
            continue;
        piece->term[0].coefficient /= 2;
        piece->term[1] = piece->term[0];
        piece->part[1] = DL_PART_FAST;
        piece->terms = 2;
    }
}

/* A fixed sequence of numbers in [-1, 1]. */
FIXTURE double fixture_noise(unsigned index) {
    const double s = sin(12.9898 * (index + 1.0)) * 43758.5453;
    return 2 * (s - floor(s)) - 1;
}

/* Two bodies of masses 0.75 and 0.25 on an ellipse of semi-major axis 1 and period 2 pi, begun at
 * pericentre, centre of mass at rest at the origin. The relative position at time t is
 * (cos E - e, sqrt(1 - e^2) sin E) with E - e sin E = t. */
FIXTURE dl_scene *fixture_kepler(double eccentricity) {
    dl_scene *scene = fixture_scene("fixture-kepler", 2, 2);
    const double mass[2] = {0.75, 0.25}, share[2] = {-0.25, 0.75};
    const double r = 1 - eccentricity, v = sqrt((1 + eccentricity) / (1 - eccentricity));
    for (size_t i = 0; i < 2; i++) {
        scene->inertia[i] = mass[i];
        scene->coupling[i] = mass[i];
        fixture_place(scene, i, (double[3]){share[i] * r}, (double[3]){0, share[i] * v});
    }
    /* F = -m1 m2 G / r^2 with m1 + m2 = 1 and G = 1 */
    scene->law.pieces = 1;
    scene->law.piece[0].until = INFINITY;
    scene->law.piece[0].terms = 1;
    scene->law.piece[0].term[0] = (dl_term){.coefficient = -1, .power = 2};
    scene->end = 2;
    return scene;
}

/* A pair that oscillates about its equilibrium distance 1, turning and drifting slowly: almost
 * harmonic (F'(1) = -3). */
FIXTURE dl_scene *fixture_oscillator(void) {
    dl_scene *scene = fixture_scene("fixture-oscillator", 2, 2);
    fixture_law(scene, INFINITY, 1, 2, 1, 5);
    scene->inertia[1] = 2;
    fixture_place(scene, 0, (double[3]){-0.7, 0.1}, (double[3]){0.05, -0.2});
    fixture_place(scene, 1, (double[3]){0.4, 0.1}, (double[3]){0.05, 0.1});
    scene->end = 2;
    return scene;
}

/* TR171's stream: rows of 11, 12 and 11 on a triangular lattice of spacing 1.5^(1/3), all flying
 * with `speed` along x, disturbed by at most 1 %. */
FIXTURE dl_scene *fixture_stream(double speed) {
    static const size_t row_length[3] = {11, 12, 11};
    dl_scene *scene = fixture_scene("fixture-stream", 2, 34);
    fixture_law(scene, INFINITY, 6, 7, 9, 10);
    const double spacing = cbrt(1.5);
    size_t particle = 0;
    for (int row = 0; row < 3; row++)
        for (size_t i = 0; i < row_length[row]; i++, particle++) {
            const double x = spacing * ((double)i + (row == 1 ? 0 : 0.5));
            const double y = spacing * sqrt(0.75) * (row - 1);
            const unsigned k = 2 * (unsigned)particle;
            fixture_place(scene, particle, (double[3]){x, y},
                          (double[3]){speed * (1 + 0.01 * fixture_noise(k)),
                                      speed * 0.01 * fixture_noise(k + 1)});
        }
    scene->step = 0.02;
    scene->end = 1.4;
    return scene;
}

/* Thirteen Lennard-Jones particles (reduced units) in three dimensions: a cuboctahedron, slightly
 * disturbed and moving, with one particle heavier than the others. */
FIXTURE dl_scene *fixture_cluster(void) {
    static const int corner[13][3] = {{0, 0, 0},  {1, 1, 0},  {1, -1, 0}, {-1, 1, 0},  {-1, -1, 0},
                                      {1, 0, 1},  {1, 0, -1}, {-1, 0, 1}, {-1, 0, -1}, {0, 1, 1},
                                      {0, 1, -1}, {0, -1, 1}, {0, -1, -1}};
    dl_scene *scene = fixture_scene("fixture-cluster", 3, 13);
    fixture_law(scene, INFINITY, 24, 7, 48, 13);
    const double scale = pow(2, 1.0 / 6) / sqrt(2);
    for (size_t i = 0; i < 13; i++) {
        double at[3], velocity[3];
        for (int axis = 0; axis < 3; axis++) {
            const unsigned k = 6 * (unsigned)i + 2 * (unsigned)axis;
            at[axis] = scale * corner[i][axis] + 0.02 * fixture_noise(k);
            velocity[axis] = 0.3 * fixture_noise(k + 1);
        }
        fixture_place(scene, i, at, velocity);
    }
    scene->inertia[12] = 3;
    scene->step = 0.002;
    scene->end = 0.2;
    return scene;
}

/* A crystal of 36 particles and stiff bonds that hardly vibrates and flies along x with velocity 1,
 * so that steps are long against its vibrations. */
FIXTURE dl_scene *fixture_stiff_crystal(double stiffness, double disturbance) {
    enum { side = 6, particles = side * side };
    dl_scene *scene = fixture_scene("fixture-stiff-crystal", 2, particles);
    fixture_law(scene, 1.4, stiffness, 2, stiffness, 5);
    for (size_t i = 0; i < particles; i++) {
        const size_t row = i / side;
        const double x = (double)(i % side) + 0.5 * (double)(row % 2);
        const unsigned k = 4 * (unsigned)i;
        fixture_place(scene, i,
                      (double[3]){x + disturbance * fixture_noise(k),
                                  sqrt(0.75) * (double)row + disturbance * fixture_noise(k + 1)},
                      (double[3]){1, 0});
    }
    return scene;
}

/* Seven particles in a row, both ends pinned, inertia unlike coupling, plucked sideways. */
FIXTURE dl_scene *fixture_pinned_chain(void) {
    dl_scene *scene = fixture_scene("fixture-pinned-chain", 2, 7);
    fixture_law(scene, INFINITY, 2, 3, 2, 5);
    for (size_t i = 0; i < 7; i++) {
        const double y = 0.1 * sin(3.14159265358979323846 * (double)i / 6);
        fixture_place(scene, i, (double[3]){(double)i, y}, (double[3]){0, 0});
        scene->inertia[i] = 1 + 0.25 * (double)(i % 3);
        scene->coupling[i] = 1 + 0.1 * (double)(i % 2);
    }
    scene->pinned[0] = scene->pinned[6] = true;
    scene->end = 0.5;
    return scene;
}

/* TR323's fluid in the small: 24 particles with the hard cutoff 0.25 settling under gravity in a
 * box of width 1.1 with damping mirror walls; one particle does not feel gravity. */
FIXTURE dl_scene *fixture_box(void) {
    dl_scene *scene = fixture_scene("fixture-box", 2, 24);
    fixture_law(scene, 0.25, 25, 2, 50, 4);
    for (size_t i = 0; i < 24; i++) {
        const unsigned k = 4 * (unsigned)i;
        const double x = 0.1 + 0.3 * (double)(i % 4) + 0.02 * fixture_noise(k);
        const double y = 0.1 + 0.3 * (double)(i / 4) + 0.02 * fixture_noise(k + 1);
        fixture_place(scene, i, (double[3]){x, y},
                      (double[3]){5 * fixture_noise(k + 2), 5 * fixture_noise(k + 3)});
        scene->feels_gravity[i] = i != 7;
    }
    scene->gravity[1] = -980;
    scene->walls.present = true;
    scene->walls.low[0] = 0;
    scene->walls.high[0] = 1.1;
    scene->walls.low[1] = 0;
    scene->walls.damping = 0.9;
    scene->walls.zero_vx_below = 1e-10;
    scene->step = 1e-4;
    scene->end = 0.05;
    return scene;
}

#endif
