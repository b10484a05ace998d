/* Forward, velocities reversed, and back.
 *
 * A time-symmetric method returns to the start but for roundoff, which the motion magnifies. By how
 * much is measured: the way back is run twice, the second time from a state displaced by what
 * roundoff may add up to on the way, and how far apart the two end is what roundoff explains. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/trajectory.h"
#include "driftlab/reference.h"
#include "study/drift.h"

enum { attempts = 6, shorter = 4 };

static const double most_explained = 1e-6; /* of the largest coordinate: more hides too much */

typedef struct ways {
    const dl_study_unit *unit;
    double time;
    size_t coordinates;           /* of all particles */
    double *there, *back, *twin;  /* [2 * coordinates]: states at the end of each way */
    double length, speed;         /* largest coordinate and component of a velocity at the turn */
    double size;                  /* RMS distance from the mean position there */
    unsigned long forces, events; /* of the way there */
    dl_status status;             /* of a way that failed */
} ways;

static dl_status run_way(ways *w, const dl_scene *scene, double *y, dl_error *error) {
    dl_run_options how;
    dl_run_summary summary;
    dl_run_options_default(&how);
    how.end = how.sample = w->time;
    how.time_limit = w->unit->seconds;
    how.observe = false;
    if (w->unit->progress)
        w->unit->progress(w->unit->context, "forward and back");
    const dl_status status =
        w->unit->run(scene, w->unit->row, w->unit->options, &how, &summary, y, error);
    w->forces += summary.force_evaluations;
    w->events += summary.wall_hits + summary.contacts;
    if (status == DL_OK && summary.status != DL_OK)
        w->status = summary.status;
    return status;
}

/* Deterministic, of both signs, unlike for neighbours. */
static double jitter(size_t index) {
    return sin(1 + 2.3 * (double)index);
}

/* From the turn, displaced by that part. */
static dl_status run_back(ways *w, double part, double *y, dl_error *error) {
    const size_t n = w->coordinates;
    double *turned = malloc(2 * n * sizeof *turned);
    dl_scene *scene = NULL;
    if (!turned)
        return dl_fail_memory(error, "a state");
    for (size_t k = 0; k < n; k++) {
        turned[k] = w->there[k] + part * w->length * jitter(k);
        turned[n + k] = -w->there[n + k] + part * w->speed * jitter(n + k);
    }
    dl_status status = dl_scene_restart(w->unit->scene, turned, &scene, error);
    free(turned);
    if (status == DL_OK)
        status = run_way(w, scene, y, error);
    dl_scene_free(scene);
    return status;
}

static double largest(const double *value, size_t n) {
    double most = 0;
    for (size_t k = 0; k < n; k++)
        most = fmax(most, fabs(value[k]));
    return most;
}

static double size_of(const ways *w) {
    const size_t n = w->unit->scene->particles;
    double squares = 0;
    for (size_t first = 0; first < w->coordinates; first += n) {
        double mean = 0;
        for (size_t i = 0; i < n; i++)
            mean += w->there[first + i] / (double)n;
        for (size_t i = 0; i < n; i++)
            squares += (w->there[first + i] - mean) * (w->there[first + i] - mean);
    }
    return squares > 0 ? sqrt(squares / (double)n) : w->length;
}

/* Of a coordinate or velocity, as a part of it. */
static double roundoff(const ways *w) {
    return 16 * DBL_EPSILON * dl_drift_solved_to(w->unit->row, w->unit->options) *
           sqrt(1 + (double)w->forces);
}

static dl_status run_ways(ways *w, dl_error *error) {
    w->forces = w->events = 0;
    w->status = DL_OK;
    dl_status status = run_way(w, w->unit->scene, w->there, error);
    if (status != DL_OK || w->status != DL_OK || w->events)
        return status;
    w->length = largest(w->there, w->coordinates);
    w->speed = largest(w->there + w->coordinates, w->coordinates);
    w->size = size_of(w);
    status = run_back(w, 0, w->back, error);
    return status == DL_OK && w->status == DL_OK ? run_back(w, roundoff(w), w->twin, error)
                                                 : status;
}

/* Whether that was a measurement; if not, why. */
static bool judge(const ways *w, dl_reversal *reversal) {
    const dl_study_unit *unit = w->unit;
    if (w->status != DL_OK) {
        snprintf(reversal->why, sizeof reversal->why, "a run of it failed (%s)",
                 dl_status_name(w->status));
        return false;
    }
    if (w->events) {
        snprintf(reversal->why, sizeof reversal->why,
                 "walls are hit within t = %.3g: what they take does not come back", w->time);
        return false;
    }
    reversal->time = w->time;
    reversal->distance = dl_position_distance(unit->scene, w->back, unit->scene->position, NULL);
    reversal->explained = dl_position_distance(unit->scene, w->twin, w->back, NULL);
    if (reversal->explained <= most_explained * w->size)
        return true;
    snprintf(
        reversal->why, sizeof reversal->why,
        "roundoff, or what the solver leaves, alone may end %.2g from the start after t = %.3g",
        reversal->explained, w->time);
    reversal->time = reversal->distance = reversal->explained = NAN;
    return false;
}

/* A time of whole steps, not longer than asked; 0 where that is less than one. */
static double whole(double time, double step) {
    return floor(time / step * (1 + 1e-9)) * step;
}

static dl_status try_times(ways *w, double time, double step, dl_reversal *reversal,
                           dl_error *error) {
    for (int i = 0; i < attempts; i++) {
        w->time = whole(time / pow(shorter, i), step);
        if (!(w->time > 0))
            return DL_OK;
        dl_status status = run_ways(w, error);
        if (status == DL_INPUT) /* the turned state is none the scene can start from */
            w->status = status;
        else if (status != DL_OK)
            return status;
        if (judge(w, reversal)) {
            reversal->why[0] = '\0';
            return DL_OK;
        }
    }
    return DL_OK;
}

dl_status dl_drift_reverse(const dl_study_unit *unit, const dl_drift_knob *knob,
                           dl_reversal *reversal, dl_error *error) {
    const dl_scene *scene = unit->scene;
    const double asked = ((const dl_drift_settings *)unit->settings)->reversal;
    *reversal = (dl_reversal){.time = NAN, .distance = NAN, .explained = NAN};
    if (knob->adaptive || scene->radiation.present) {
        snprintf(reversal->why, sizeof reversal->why, "%s",
                 knob->adaptive ? "the method chooses its steps" : "radiation does not come back");
        return DL_OK;
    }
    ways w = {.unit = unit, .coordinates = (size_t)scene->dimension * scene->particles};
    const size_t length = 2 * w.coordinates;
    w.there = calloc(length, 3 * sizeof *w.there);
    if (!w.there)
        return dl_fail_memory(error, "states");
    w.back = w.there + length;
    w.twin = w.back + length;
    const double time = asked > 0 ? asked : unit->end;
    const dl_status status = try_times(&w, time, knob->size, reversal, error);
    free(w.there);
    return status;
}
