/* A particle that flies head on at a pinned one, which repels it within the cutoff, and leaves
 * again: an exact solution for whatever the law does at its cutoff. */
#ifndef FIXTURE_BOUNCE_H
#define FIXTURE_BOUNCE_H

#include "fixture_scenes.h"
#include "force/law.h"

static const double bounce_time = 0.05; /* enough of it, from what is tested */

/* The pinned one, particle 0, is at the origin, the other on the x axis. */
FIXTURE dl_scene *fixture_bounce(const dl_pair_law *law, double from, double speed) {
    dl_scene *scene = fixture_scene("bounce", 2, 2);
    scene->law = *law;
    fixture_place(scene, 0, (double[3]){0}, (double[3]){0});
    fixture_place(scene, 1, (double[3]){from}, (double[3]){-speed});
    scene->pinned[0] = true;
    scene->end = bounce_time;
    return scene;
}

/* Where it turns: V = E. */
FIXTURE double fixture_turning_point(const dl_law *law, double energy, double cutoff) {
    double low = 0.01, high = cutoff;
    for (int i = 0; i < 100; i++) {
        const double middle = (low + high) / 2;
        *(dl_law_potential(law, middle * middle) > energy ? &low : &high) = middle;
    }
    return high;
}

/* From the turning point r* to the cutoff: the integral of dr/sqrt(2 (V(r*) - V(r))), with
 * r = r* + x^2 a smooth one, by two-point Gauss's rule on many parts. The difference is the
 * discrete gradient's, which keeps its digits. */
FIXTURE double fixture_time_inside(const dl_pair_law *source, double speed) {
    enum { parts = 2000 };
    dl_law law;
    dl_law_prepare(source, &law);
    const double energy = speed * speed / 2, cutoff = source->piece[0].until;
    const double turn = fixture_turning_point(&law, energy, cutoff);
    const double top = sqrt(cutoff - turn), node = 1 / sqrt(3);
    double inside = 0;
    for (int i = 0; i < parts; i++)
        for (int side = -1; side <= 1; side += 2) {
            const double x = top * (i + (1 + side * node) / 2) / parts, r = turn + x * x;
            const double ds = x * x * (r + turn);
            const double gained = dl_law_discrete(&law, turn * turn, r * r, ds, NULL) * ds;
            inside += top / parts * x / sqrt(2 * gained);
        }
    return inside;
}

/* The distance at the end. Outside the speed is what it was. */
FIXTURE double fixture_bounce_exact(const dl_pair_law *law, double from, double speed) {
    const double cutoff = law->piece[0].until, inside = fixture_time_inside(law, speed);
    return cutoff + speed * (bounce_time - (from - cutoff) / speed - 2 * inside);
}

#endif
