/* Temperature: the average of (3.4) over time, TR299 (3.5), (3.6) and its program. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"

const dl_temperature_rule dl_temperature_published = {
    .name = "published",
    .unit = 1e4,
};

const dl_temperature_rule dl_temperature_program = {
    .name = "program",
    .unit = 1e3,
    .exponential = true,
};

static const size_t most_steps = 100000;

struct dl_thermometer {
    const dl_scene *scene;
    const dl_temperature_rule *rule;
    size_t steps;
    double *heat;         /* [particles]: T' of the last frame */
    double *mean;         /* [particles] of T', exponential */
    double last;          /* time */
    size_t frames;        /* added so far */
    size_t first, length; /* of the frames in the window, in rings of `room` frames */
    size_t room;
    double *time; /* [room] */
    double *past; /* [room][particles]: T' */
};

dl_status dl_thermometer_create(const dl_scene *scene, const dl_temperature_rule *rule,
                                size_t steps, dl_thermometer **thermometer, dl_error *error) {
    *thermometer = NULL;
    if (steps < 1 || steps > most_steps)
        return dl_fail(error, DL_INPUT, "steps of the temperature: found %zu, expected 1 to %zu",
                       steps, most_steps);
    dl_thermometer *created = calloc(1, sizeof *created);
    if (!created)
        return dl_fail_memory(error, "a thermometer");
    *created = (dl_thermometer){.scene = scene, .rule = rule, .steps = steps};
    created->heat = calloc(scene->particles, sizeof *created->heat);
    created->mean = calloc(scene->particles, sizeof *created->mean);
    if (!created->heat || !created->mean) {
        dl_thermometer_free(created);
        return dl_fail_memory(error, "a thermometer");
    }
    *thermometer = created;
    return DL_OK;
}

void dl_thermometer_free(dl_thermometer *thermometer) {
    if (!thermometer)
        return;
    free(thermometer->heat);
    free(thermometer->mean);
    free(thermometer->time);
    free(thermometer->past);
    free(thermometer);
}

/* --- window ----------------------------------------------------------------------------------- */

/* A ring that is full is unrolled into one twice as long. */
static dl_status make_room(dl_thermometer *t, dl_error *error) {
    if (t->length < t->room)
        return DL_OK;
    const size_t n = t->scene->particles, room = t->room ? 2 * t->room : 16;
    double *time = malloc(room * sizeof *time), *past = malloc(room * n * sizeof *past);
    if (!time || !past) {
        free(time);
        free(past);
        return dl_fail_memory(error, "the window of a temperature");
    }
    for (size_t k = 0; t->room > 0 && k < t->length; k++) {
        const size_t from = (t->first + k) % t->room;
        time[k] = t->time[from];
        memcpy(past + k * n, t->past + from * n, n * sizeof *past);
    }
    free(t->time);
    free(t->past);
    t->time = time;
    t->past = past;
    t->room = room;
    t->first = 0;
    return DL_OK;
}

static dl_status add_to_window(dl_thermometer *t, double time, dl_error *error) {
    const double roundoff = 1e-6 * t->scene->step;
    const double begin = time - (double)t->steps * t->scene->step + roundoff; /* excluded */
    while (t->length > 0 && t->time[t->first] <= begin) {
        t->first = (t->first + 1) % t->room;
        t->length--;
    }
    const dl_status status = make_room(t, error);
    if (status)
        return status;
    const size_t n = t->scene->particles, to = (t->first + t->length++) % t->room;
    t->time[to] = time;
    memcpy(t->past + to * n, t->heat, n * sizeof *t->past);
    return DL_OK;
}

/* --- exponential mean ------------------------------------------------------------------------- */

static void add_exponentially(dl_thermometer *t, double time) {
    const double elapsed = (time - t->last) / t->scene->step;
    const double kept = t->frames ? pow(1 - 1 / (double)t->steps, elapsed) : 0;
    for (size_t i = 0; i < t->scene->particles; i++)
        t->mean[i] = kept * t->mean[i] + (1 - kept) * t->heat[i];
}

dl_status dl_thermometer_add(dl_thermometer *thermometer, double time, const double *y_all,
                             dl_error *error) {
    dl_thermometer *const t = thermometer;
    if (t->frames && !(time > t->last))
        return dl_fail(error, DL_INPUT,
                       "temperature: found time %.17g after %.17g, expected a "
                       "later one",
                       time, t->last);
    dl_observe_heat(t->scene, y_all, t->heat);
    if (t->rule->exponential)
        add_exponentially(t, time);
    else {
        const dl_status status = add_to_window(t, time, error);
        if (status)
            return status;
    }
    t->last = time;
    t->frames++;
    return DL_OK;
}

void dl_thermometer_read(const dl_thermometer *thermometer, double *temperature) {
    const dl_thermometer *const t = thermometer;
    const size_t n = t->scene->particles;
    for (size_t i = 0; i < n; i++)
        temperature[i] = t->rule->exponential ? t->mean[i] / t->rule->unit : 0;
    for (size_t k = 0; k < t->length; k++) {
        const double *past = t->past + (t->first + k) % t->room * n;
        for (size_t i = 0; i < n; i++)
            temperature[i] += past[i] / ((double)t->length * t->rule->unit);
    }
}
