#include "study/oscillator.h"

#include <math.h>
#include <stdlib.h>

#include "study/scan.h"
#include "study/trial.h"

const double dl_oscillator_smallest = 0.05, dl_oscillator_largest = 100;

/* Compositions have unstable windows of 2 % (the sixth-order one of Yoshida: from 2.269 to 2.328)
 * where their stages are near limits of their own. */
static const struct {
    double from, to;
    long per_decade;
} ranges[] = {{0.05, 1, 12}, {1, 8, 120}, {8, 100, 12}};

enum { steps = 600 };
static const double width = 1e-4, growth = 2;

/* The particle goes round an ellipse, so that it never meets the pin. */
static double position[] = {1, 0, 0, 0}, velocity[] = {0, 0, 0.5, 0}, mass[] = {1, 1};
static char name[] = "oscillator", text[] = "";
static bool no_gravity[] = {false, false}, pinned[] = {false, true};

static const dl_scene oscillator = {
    .name = name,
    .text = text,
    .dimension = 2,
    .particles = 2,
    .position = position,
    .velocity = velocity,
    .inertia = mass,
    .coupling = mass,
    .feels_gravity = no_gravity,
    .pinned = pinned,
    .law = {.pieces = 1,
            .piece = {{.until = INFINITY, .terms = 1, .term = {{.coefficient = -1, .power = -1}}}}},
    .step = 1,
    .end = steps,
};

/* Largest energies of the two halves of a run. */
typedef struct halves {
    double energy[2];
} halves;

static dl_status take(void *context, const dl_sample *sample, dl_error *error) {
    (void)error;
    halves *const seen = context;
    double *const largest = &seen->energy[sample->index > steps / 2];
    *largest = fmax(*largest, sample->energy.total);
    return DL_OK;
}

typedef struct scanned {
    const dl_study_unit *unit;
    bool refused;
} scanned;

static dl_status judge(void *context, dl_scan_point *point, dl_error *error) {
    scanned *const s = context;
    const dl_study_unit *const unit = s->unit;
    halves seen = {{0, 0}};
    dl_run_options how;
    dl_run_summary summary;
    void *options;
    dl_status status = dl_trial_options(unit, point->step, &options, error);
    if (status)
        return status;
    dl_run_options_default(&how);
    how.end = steps * point->step;
    how.sample = point->step;
    how.time_limit = unit->seconds;
    how.energy_bound = 1e200;
    how.on_sample = take;
    how.context = &seen;
    status = unit->run(&oscillator, unit->row, options, &how, &summary, NULL, error);
    dl_method_options_free(unit->row, options);
    s->refused |= status == DL_INPUT;
    if (status)
        return status;
    const bool grows = !(seen.energy[1] <= growth * seen.energy[0]);
    point->stable = summary.status == DL_TIMEOUT ? 0 : !summary.status && !grows ? 1 : -1;
    point->word = summary.status == DL_NONLINEAR_FAILURE ? dl_trial_word(DL_TRIAL_SOLVER)
                  : summary.status == DL_STEP_FAILURE    ? dl_trial_word(DL_TRIAL_COLLAPSE)
                                                         : dl_trial_word(DL_TRIAL_BLOW_UP);
    if (unit->progress)
        unit->progress(unit->context, "the harmonic oscillator");
    return DL_OK;
}

dl_status dl_oscillator_measure(const dl_study_unit *unit, dl_oscillator_limit *limit,
                                dl_error *error) {
    scanned context = {.unit = unit};
    dl_scan scan = {.judge = judge, .context = &context, .width = width, .first_only = true};
    dl_status status = DL_OK;
    for (size_t k = 0; k < sizeof ranges / sizeof *ranges && !status; k++) {
        scan.smallest = ranges[k].from;
        scan.largest = ranges[k].to;
        scan.per_decade = ranges[k].per_decade;
        status = isnan(dl_scan_read(&scan).broken) ? dl_scan_run(&scan, error) : DL_OK;
    }
    const dl_scan_result found = dl_scan_read(&scan);
    *limit = (dl_oscillator_limit){found.limit, found.broken, ""};
    for (size_t k = 0; k < scan.count; k++)
        if (scan.point[k].step == found.broken)
            limit->word = scan.point[k].word;
    if (context.refused) {
        *limit = (dl_oscillator_limit){NAN, NAN, ""};
        status = DL_OK;
    }
    dl_scan_release(&scan);
    return status;
}
