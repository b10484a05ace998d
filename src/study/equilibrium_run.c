/* Channels, and one run of the kind `equilibrium`. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "observe/observables.h"
#include "study/equilibrium.h"
#include "study/telling.h"

/* --- channels ----------------------------------------------------------------------------------
 */

enum { KINETIC, PAIR, SEPARATION, UNIFORM, MOST, HIGHEST, FIRST_BIN };
enum { nearest = 3 }; /* others: the mean separation of TR323 (driftlab/observe.h) */

static void add(dl_channels *channels, bool tested, const char *name) {
    dl_channel *added = &channels->channel[channels->count++];
    snprintf(added->name, sizeof added->name, "%s", name);
    added->tested = tested;
}

static bool has_heights(const dl_scene *scene) {
    const size_t axis = dl_height_axis(scene);
    return scene->gravity[axis] != 0 || (scene->walls.present && isfinite(scene->walls.low[axis]));
}

static dl_status add_bins(const dl_scene *scene, double width, dl_channels *channels,
                          dl_error *error) {
    double lowest, highest;
    dl_observe_heights(scene, scene->position, &lowest, &highest);
    if (width == 0)
        width = dl_bins_choose_width(scene, lowest, highest);
    const dl_status status = dl_bins_create(scene, width, lowest, highest, &channels->bin, error);
    if (status != DL_OK)
        return status;
    channels->bins = channels->bin.count;
    if (channels->count + channels->bins + 1 > DL_MOST_CHANNELS)
        return dl_fail(error, DL_INPUT, "bin: found %g, which makes %zu bins, expected at most %d",
                       width, channels->bins, DL_MOST_CHANNELS - FIRST_BIN - 1);
    for (size_t k = 0; k <= channels->bins; k++) {
        const double low = channels->bin.low + (double)k * width;
        char name[DL_CHANNEL_NAME];
        if (k < channels->bins)
            snprintf(name, sizeof name, "particles from %.6g to %.6g", low, low + width);
        else
            snprintf(name, sizeof name, "particles above %.6g", low);
        add(channels, false, name);
    }
    return DL_OK;
}

dl_status dl_channels_create(const dl_scene *scene, const dl_equilibrium_settings *settings,
                             dl_channels *channels, dl_error *error) {
    *channels = (dl_channels){.heights = has_heights(scene),
                              .centre = settings->frame == DL_EQUILIBRIUM_CENTRE};
    for (size_t i = 0; i < scene->particles; i++)
        channels->moving += !scene->pinned[i];
    const size_t axis = dl_height_axis(scene);
    const double wall = scene->walls.present ? scene->walls.low[axis] : -INFINITY;
    channels->floor = isfinite(wall) ? wall : 0;
    add(channels, true, "kinetic energy per particle [energy]");
    add(channels, true, "pair energy per particle [energy]");
    add(channels, true, "mean separation [length]");
    if (!channels->heights)
        return DL_OK;
    add(channels, true, "depth, twice the mean height [length]");
    add(channels, false, "depth of 95 % [length]");
    add(channels, false, "depth, highest [length]");
    return add_bins(scene, settings->bin, channels, error);
}

/* --- one run -----------------------------------------------------------------------------------
 */

typedef struct recorder {
    dl_settling *settling;
    const dl_channels *channels;
    const dl_scene *scene;
} recorder;

/* Summed of velocities relative to the centre's: the difference of two energies of a fast stream
 * would have few digits. */
static double kinetic_about_centre(const dl_scene *scene, const double *y_all) {
    const size_t n = scene->particles, axes = (size_t)scene->dimension;
    dl_motion motion;
    dl_observe_motion(scene, y_all, &motion);
    double sum = 0;
    for (size_t k = 0; k < axes * n; k++) {
        const double v = y_all[axes * n + k] - motion.velocity[k / n];
        sum += scene->pinned[k % n] ? 0 : scene->inertia[k % n] * v * v / 2;
    }
    return sum;
}

static dl_status observe(const recorder *to, const dl_sample *sample, double *row,
                         dl_error *error) {
    const dl_channels *channels = to->channels;
    const double moving = (double)channels->moving;
    row[KINETIC] = (channels->centre ? kinetic_about_centre(to->scene, sample->y_all)
                                     : sample->energy.kinetic) /
                   moving;
    row[PAIR] = sample->energy.pair / moving;
    dl_status status =
        dl_observe_separation(to->scene, sample->y_all, nearest, &row[SEPARATION], error);
    if (status != DL_OK || !channels->heights)
        return status;
    dl_depth depth;
    status = dl_observe_depth(to->scene, sample->y_all, channels->floor, &depth, error);
    row[UNIFORM] = depth.uniform;
    row[MOST] = depth.most;
    row[HIGHEST] = depth.highest;
    double *bin = row + FIRST_BIN, above = moving;
    dl_observe_density(to->scene, sample->y_all, &channels->bin, bin, NULL);
    for (size_t k = 0; k < channels->bins; k++)
        above -= bin[k];
    bin[channels->bins] = above;
    return status;
}

static dl_status record(void *context, const dl_sample *sample, dl_error *error) {
    const recorder *to = context;
    dl_settling *settling = to->settling;
    double row[DL_MOST_CHANNELS];
    if (settling->n == settling->room)
        return dl_fail(error, DL_ERROR, "more samples than the %zu expected", settling->room);
    const dl_status status = observe(to, sample, row, error);
    if (status != DL_OK)
        return status;
    settling->time[settling->n] = sample->time;
    for (size_t c = 0; c < to->channels->count; c++)
        settling->value[c][settling->n] = row[c];
    settling->n++;
    return DL_OK;
}

static dl_status make_room(dl_settling *settling, const dl_study_unit *unit, size_t channels,
                           dl_error *error) {
    settling->room = (size_t)ceil(unit->end / unit->sample) + 3;
    settling->time = calloc(settling->room, (1 + channels) * sizeof *settling->time);
    if (!settling->time)
        return dl_fail_memory(error, "series");
    for (size_t c = 0; c < channels; c++)
        settling->value[c] = settling->time + (c + 1) * settling->room;
    return DL_OK;
}

static void not_settled(dl_settling *settling, const char *why) {
    settling->settled = false;
    snprintf(settling->why, sizeof settling->why, "%s", why);
}

/* Does not change but for roundoff, whose walk would be taken for a memory. */
static bool is_constant(const double *value, size_t n) {
    double low = INFINITY, high = -INFINITY;
    for (size_t k = 0; k < n; k++) {
        low = fmin(low, value[k]);
        high = fmax(high, value[k]);
    }
    return high - low <= 1e-10 * fmax(fabs(low), fabs(high));
}

/* What of a channel still changes after the transient, in standard errors. */
static double change_of(const dl_settling *settling, size_t channel, dl_error *error) {
    const double *left = settling->value[channel] + settling->transient;
    const size_t n = settling->n - settling->transient;
    if (is_constant(left, n))
        return 0;
    return isnan(dl_settling_mean(settling, channel).low) ? NAN : dl_series_change(left, n, error);
}

/* Transient and what is left: of all channels that are tested the longest and the worst. */
static void judge(dl_settling *settling, const dl_channels *channels, dl_error *error) {
    const size_t n = settling->n;
    settling->settled = true;
    for (size_t c = 0; c < channels->count; c++) {
        const size_t cut = dl_series_truncation(settling->value[c], n);
        if (channels->channel[c].tested && cut > settling->transient)
            settling->transient = cut;
    }
    if (settling->transient > n / 2)
        not_settled(settling, "more than half of the run belongs to the transient");
    for (size_t c = 0; c < channels->count; c++) {
        if (!channels->channel[c].tested)
            continue;
        const double change = change_of(settling, c, error);
        if (isnan(change)) {
            not_settled(settling, "the run is too short: its samples remember one another");
            settling->change = NAN;
        }
        if (fabs(change) > fabs(settling->change)) {
            settling->change = change;
            settling->worst = c;
        }
    }
    if (fabs(settling->change) > DL_SETTLED_BOUND) {
        const char *name = channels->channel[settling->worst].name;
        snprintf(settling->why, sizeof settling->why,
                 "after the transient the %.*s still changes, by %.2g standard errors",
                 (int)(strstr(name, " [") - name), name, settling->change);
        settling->settled = false;
    }
}

dl_status dl_settling_run(const dl_study_unit *unit, const dl_channels *channels,
                          const dl_scene *start, const char *label, dl_settling *settling,
                          dl_error *error) {
    *settling = (dl_settling){0};
    recorder to = {.settling = settling, .channels = channels, .scene = start};
    dl_telling telling = {.unit = unit};
    snprintf(telling.label, sizeof telling.label, "%s", label);
    dl_run_options how;
    dl_run_options_default(&how);
    how.end = unit->end;
    how.sample = unit->sample;
    how.time_limit = unit->seconds;
    how.ledger = false; /* where walls are hit at every step booking costs more than the motion */
    how.on_sample = record;
    how.context = &to;
    dl_telling_set(&telling, &how);
    dl_status status = make_room(settling, unit, channels->count, error);
    if (status == DL_OK)
        status = unit->run(start, unit->row, unit->options, &how, &settling->summary, NULL, error);
    if (status == DL_OK && settling->summary.status == DL_OK)
        judge(settling, channels, error);
    return status;
}

void dl_settling_release(dl_settling *settling) {
    free(settling->time);
    *settling = (dl_settling){0};
}

dl_interval dl_settling_mean(const dl_settling *settling, size_t channel) {
    const double *left = settling->value[channel] + settling->transient;
    const size_t n = settling->n - settling->transient;
    return is_constant(left, n) ? (dl_interval){left[n - 1], left[n - 1], left[n - 1]}
                                : dl_series_mean(left, n, NULL);
}
