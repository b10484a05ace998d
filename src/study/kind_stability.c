/* Which fixed steps are stable on a scene: a scan with its unstable windows, beside what the
 * scene's fastest motion, the method's limit on the harmonic oscillator and the papers' rule let
 * expect. */
#include <float.h>
#include <limits.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "study/oscillator.h"
#include "study/scan.h"
#include "study/stability_scales.h"
#include "study/step_range.h"
#include "study/trial.h"

typedef struct stability_settings {
    dl_step_range range;
    double width;
    long spectra;
} stability_settings;

#define AT(field) .offset = offsetof(stability_settings, field)

static const dl_parameter settings[] = {
    DL_STEP_RANGE_ROWS(stability_settings, "0.05", "10", "frequency", "16", "100"),
    {.name = "width",
     .kind = DL_REAL,
     AT(width),
     .unit = "",
     .minimum = 1e-9,
     .maximum = 1,
     .fallback = "0.01",
     .doc = "to which borders of stability are refined, relative"},
    {.name = "spectra",
     .kind = DL_INTEGER,
     AT(spectra),
     .unit = "",
     .minimum = 1,
     .maximum = 1e6,
     .fallback = "100",
     .doc = "states along a run, besides the first, whose fastest motion is looked for"},
};

/* What is measured of one method on one scene. */
typedef struct measurement {
    const dl_study_unit *unit;
    const stability_settings *how;
    dl_trial_rule rule;
    dl_spectrum at_start;
    double step_unit; /* time */
    dl_scan scan;
    dl_scan_result found;
    dl_scales along;
    dl_oscillator_limit oscillator;
} measurement;

/* Of a point of the scan, besides its step. */
enum { ENERGY_ERROR, STEPS, HELD };

static dl_status check(const dl_study_unit *unit, dl_error *error) {
    const stability_settings *const how = unit->settings;
    if (!(unit->row->flags & DL_FIXED_STEP))
        return dl_fail(error, DL_INPUT,
                       "found a method that chooses its own steps, expected one that keeps a fixed "
                       "step: what limits the others is the tolerance, and every tolerance is "
                       "stable (driftlab list methods)");
    return dl_step_range_check(&how->range, error);
}

/* --- the scan --------------------------------------------------------------------------------- */

static double possible(const void *context, double step) {
    return dl_trial_step(((const measurement *)context)->unit->scene, step);
}

static dl_status judge(void *context, dl_scan_point *point, dl_error *error) {
    const measurement *const m = context;
    dl_trial trial;
    char text[64];
    snprintf(text, sizeof text, "step %.4g", point->step);
    if (m->unit->progress)
        m->unit->progress(m->unit->context, text);
    const dl_status status = dl_trial_run_at(m->unit, point->step, &m->rule, &trial, error);
    if (status)
        return status;
    if (trial.end == DL_TRIAL_REFUSED)
        return dl_fail(error, DL_INPUT, "%s", trial.why);
    point->word = dl_trial_word(trial.end);
    point->stable = dl_trial_stability(trial.end);
    point->value[ENERGY_ERROR] = trial.energy_error;
    point->value[STEPS] = (double)trial.summary.steps;
    point->value[HELD] = trial.held;
    return DL_OK;
}

static dl_status scan_steps(measurement *m, dl_error *error) {
    const double omega = dl_spectrum_omega(&m->at_start);
    const dl_step_range *const range = &m->how->range;
    m->step_unit = dl_step_range_unit(range, m->unit->scene->step, omega);
    m->scan = (dl_scan){.judge = judge,
                        .possible = possible,
                        .context = m,
                        .smallest = range->smallest * m->step_unit,
                        .largest = range->largest * m->step_unit,
                        .per_decade = range->points,
                        .width = m->how->width};
    const dl_status status = dl_scan_run(&m->scan, error);
    m->found = dl_scan_read(&m->scan);
    return status;
}

/* --- the finding ------------------------------------------------------------------------------ */

static const char columns[] = "step [time]\nstep omega/2\nenergy error\nsteps\ntime held [time]";

static dl_status add_rows(const measurement *m, dl_finding *finding, dl_error *error) {
    const double omega = dl_spectrum_omega(&m->at_start);
    dl_status status = dl_finding_set_columns(finding, columns, error);
    for (size_t k = 0; k < m->scan.count && !status; k++) {
        const dl_scan_point *const point = &m->scan.point[k];
        const double values[] = {point->step, omega > 0 ? point->step * omega / 2 : NAN,
                                 point->value[ENERGY_ERROR], point->value[STEPS],
                                 point->value[HELD]};
        status = dl_finding_add_row(finding, values, point->word, error);
    }
    return status;
}

static double inverse(double numerator, double rate) {
    return rate > 0 ? numerator / rate : NAN;
}

/* The step at which the fastest motion of the run meets the method's own limit. */
static double predicted(const measurement *m) {
    return isnan(m->oscillator.unstable)
               ? NAN
               : inverse(m->oscillator.stable, dl_spectrum_omega(&m->along.spectrum));
}

static dl_status add_quantities(const measurement *m, dl_finding *finding, dl_error *error) {
    const double start = dl_spectrum_omega(&m->at_start);
    const double along = dl_spectrum_omega(&m->along.spectrum);
    const char *what;
    const double r0 = dl_scales_r0(m->unit->scene, &what);
    const dl_scan_result *const found = &m->found;
    const struct {
        const char *name;
        double value, low, high;
    } quantities[] = {
        {"step limit [time]", found->limit, found->limit, found->broken},
        {"largest stable step [time]", found->top, found->top, found->beyond},
        {"unstable windows", (double)found->windows, NAN, NAN},
        {"step limit an evaluation [time]", found->limit / m->along.evaluations, NAN, NAN},
        {"omega at the start [1/time]", start, NAN, NAN},
        {"omega along the run [1/time]", along, NAN, NAN},
        {"2/omega at the start [time]", inverse(2, start), NAN, NAN},
        {"2/omega along the run [time]", inverse(2, along), NAN, NAN},
        {"growth rate at the start [1/time]", dl_spectrum_growth(&m->at_start), NAN, NAN},
        {"growth rate along the run [1/time]", dl_spectrum_growth(&m->along.spectrum), NAN, NAN},
        {"h omega limit", m->oscillator.stable, m->oscillator.stable, m->oscillator.unstable},
        {"predicted limit [time]", predicted(m), NAN, NAN},
        {"r0 [length]", r0, NAN, NAN},
        {"largest speed [length/time]", m->along.speed, NAN, NAN},
        {"r0/|v| [time]", inverse(r0, m->along.speed), NAN, NAN},
    };
    dl_status status = DL_OK;
    for (size_t k = 0; k < sizeof quantities / sizeof *quantities && !status; k++)
        status = dl_finding_add(finding, quantities[k].name, quantities[k].value, quantities[k].low,
                                quantities[k].high, error);
    return status;
}

static const char *word_of(const measurement *m, double step) {
    for (size_t k = 0; k < m->scan.count; k++)
        if (m->scan.point[k].step == step)
            return m->scan.point[k].word;
    return "";
}

/* How a method that has no limit, or whose limit the scene does not show, is told. */
static void tell_prediction(const measurement *m, char *text, size_t size) {
    const dl_oscillator_limit *const own = &m->oscillator;
    const double limit = predicted(m);
    if (isfinite(limit))
        snprintf(text, size, "; its limit on the oscillator, h omega = %.4g, lets expect %.4g",
                 own->stable, limit);
    else if (isnan(own->unstable) && isfinite(own->stable))
        snprintf(text, size, "; on the oscillator it has no limit up to h omega = %g", own->stable);
    else if (isnan(own->stable) && isfinite(own->unstable))
        snprintf(text, size, "; on the oscillator it is unstable from h omega = %g on",
                 own->unstable);
    else
        text[0] = '\0';
}

static void tell_windows(const measurement *m, char *text, size_t size) {
    const dl_scan_result *const found = &m->found;
    if (found->top > found->limit)
        snprintf(text, size, "; stable again up to %.4g, with %zu unstable stretch%s below it",
                 found->top, found->windows, found->windows == 1 ? "" : "es");
    else
        text[0] = '\0';
}

static dl_status conclude(const measurement *m, dl_finding *finding, dl_error *error) {
    const dl_scan_result *const found = &m->found;
    const double low = m->scan.smallest, high = m->scan.largest;
    char prediction[160], windows[120];
    tell_prediction(m, prediction, sizeof prediction);
    tell_windows(m, windows, sizeof windows);
    if (isnan(found->limit) && isnan(found->broken))
        return dl_finding_judge(finding, error, "not known",
                                "no run from step %.4g to %.4g ended within its time", low, high);
    if (isnan(found->limit))
        return dl_finding_judge(finding, error, "no stable step below",
                                "unstable already at the smallest step scanned, %.4g (%s)%s%s",
                                found->broken, word_of(m, found->broken), windows, prediction);
    if (isnan(found->broken) && found->unknown > 0)
        return dl_finding_judge(
            finding, error, "no limit found",
            "stable from %.4g to %.4g; nothing is known of %zu steps, whose runs "
            "took too long%s",
            low, found->limit, found->unknown, prediction);
    if (isnan(found->broken))
        return dl_finding_judge(finding, error, "no limit found",
                                "stable at every step scanned, from %.4g to %.4g%s", low,
                                found->limit, prediction);
    return dl_finding_judge(finding, error, "limit",
                            "stable from %.4g up to %.4g; %.4g ends in %s%s%s", low, found->limit,
                            found->broken, word_of(m, found->broken), windows, prediction);
}

/* The smallest step that is stable, or was tried. */
static double calm_step(const measurement *m) {
    for (size_t k = 0; k < m->scan.count; k++)
        if (m->scan.point[k].stable > 0)
            return m->scan.point[k].step;
    return m->scan.point[0].step;
}

static dl_status measure(const dl_study_unit *unit, dl_finding *finding, dl_error *error) {
    const stability_settings *const how = unit->settings;
    measurement m = {.unit = unit,
                     .how = how,
                     .rule = {.energy = how->range.bound,
                              .cold = INFINITY,
                              .straight = INFINITY,
                              .looks = lround(fmax(1, unit->end / unit->sample)),
                              .least = (unsigned long)how->range.least,
                              .most = ULONG_MAX}};
    dl_status status = dl_scales_at_start(unit->scene, &m.at_start, error);
    if (!status)
        status = scan_steps(&m, error);
    if (!status)
        status = dl_scales_along(unit, calm_step(&m), how->spectra, &m.along, error);
    if (!status)
        status = dl_oscillator_measure(unit, &m.oscillator, error);
    if (!status)
        status = add_quantities(&m, finding, error);
    if (!status)
        status = add_rows(&m, finding, error);
    if (!status)
        status = conclude(&m, finding, error);
    dl_scan_release(&m.scan);
    return status;
}

/* --- the answer ------------------------------------------------------------------------------- */

static double quantity(const dl_finding *finding, const char *name) {
    const double *const value = dl_finding_quantity(finding, name);
    return value ? value[0] : NAN;
}

/* The scene's finding with the largest value, or with sign -1 the smallest; NULL: none has it. */
static const dl_finding *extreme(const dl_results *results, const char *scene, const char *name,
                                 double sign) {
    const dl_finding *best = NULL;
    for (size_t i = 0; i < results->findings; i++) {
        const dl_finding *const finding = &results->finding[i];
        const double value = sign * quantity(finding, name);
        if (strcmp(finding->scene, scene) == 0 && isfinite(value) &&
            (!best || value > sign * quantity(best, name)))
            best = finding;
    }
    return best;
}

static void answer(const dl_results *results, const char *scene, char *text, size_t size) {
    static const char limit[] = "step limit", frugal[] = "step limit an evaluation";
    const dl_finding *const most = extreme(results, scene, limit, 1);
    const dl_finding *const least = extreme(results, scene, limit, -1);
    const dl_finding *const cheapest = extreme(results, scene, frugal, 1);
    if (!most) {
        snprintf(text, size, "no method was stable at the smallest step scanned on %s", scene);
        return;
    }
    snprintf(text, size,
             "on %s steps are stable up to %.3g (%s) at the least and %.3g (%s) at the most, where "
             "2/omega is %.3g along the run. A force or Jacobian evaluation carries farthest with "
             "%s (%.3g)",
             scene, quantity(least, limit), least->method, quantity(most, limit), most->method,
             quantity(most, "2/omega along the run"), cheapest ? cheapest->method : "none",
             cheapest ? quantity(cheapest, frugal) : 0);
}

const dl_study_kind dl_study_kind_stability = {
    .doc = "which fixed steps are stable, beside the scene's fastest motion and the method's limit "
           "on the harmonic oscillator",
    .settings = {.rows = settings, .count = sizeof settings / sizeof *settings},
    .settings_size = sizeof(stability_settings),
    .samples = 1000,
    .chooses_step = true,
    .check = check,
    .measure = measure,
    .merit = "step limit an evaluation",
    .answer = answer,
};
