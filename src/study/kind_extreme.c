/* How far a method goes on an extreme scene, and how it fails, in words: at each step of a ladder
 * where it keeps a fixed one, once where it chooses its steps. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "study/scan.h"
#include "study/stability_scales.h"
#include "study/step_range.h"
#include "study/trial.h"
#include "study/verdicts.h"

typedef struct extreme_settings {
    dl_step_range range;
    long most;
    double cold, straight;
} extreme_settings;

#define AT(field) .offset = offsetof(extreme_settings, field)

static const dl_parameter settings[] = {
    DL_STEP_RANGE_ROWS(extreme_settings, "1", "1", "step", "1", "1"),
    {.name = "most",
     .kind = DL_INTEGER,
     AT(most),
     .unit = "",
     .minimum = 1,
     .maximum = 1e12,
     .fallback = "1000000",
     .doc = "steps after which a run of fixed steps ends, short of the study's end"},
    {.name = "cold",
     .kind = DL_REAL,
     AT(cold),
     .unit = "",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "none",
     .doc = "largest kinetic energy, in units of the energy scale, of a scene that must stay cold; "
            "none: it need not"},
    {.name = "straight",
     .kind = DL_REAL,
     AT(straight),
     .unit = "",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "none",
     .doc = "largest distance from uniform motion, in units of the path, where nothing acts; none: "
            "something does"},
};

typedef struct attempt {
    const dl_study_unit *unit;
    const extreme_settings *how;
    dl_trial_rule rule;
    double step_unit; /* time; 0: the method chooses its steps */
    dl_finding *finding;
    size_t runs, held;
    char reason[DL_MESSAGE_SIZE]; /* a part a stretch of runs that ended alike */
    size_t used;
    /* the stretch under way */
    dl_trial_end end;
    double from, to; /* steps in units */
    char first[DL_MESSAGE_SIZE];
} attempt;

/* The fixed step that the options say; 0 where they leave it to the method. */
static double own_step(const dl_study_unit *unit) {
    const dl_parameter *const row = dl_parameter_find(unit->row->options, "step");
    return row ? *(const double *)(const void *)((const char *)unit->options + row->offset) : 0;
}

static dl_status check(const dl_study_unit *unit, dl_error *error) {
    const extreme_settings *const how = unit->settings;
    return dl_step_range_check(&how->range, error);
}

/* --- telling ---------------------------------------------------------------------------------- */

static bool is_ladder(const attempt *a) {
    return a->step_unit > 0 && a->how->range.largest > a->how->range.smallest;
}

/* Ends the stretch under way: "energy gain from 1 to 3.2 (at t = ...)"; of a single run, which its
 * verdict names, how far it went or why not. */
static void tell_stretch(attempt *a) {
    char range[64], part[DL_MESSAGE_SIZE];
    if (a->runs == 0)
        return;
    if (a->from < a->to)
        snprintf(range, sizeof range, "from %.3g to %.3g", a->from, a->to);
    else
        snprintf(range, sizeof range, "at %.3g", a->from);
    if (is_ladder(a))
        snprintf(part, sizeof part, "%s%s %s%s%.200s%s", a->used ? "; " : "",
                 a->end == DL_TRIAL_STABLE ? "holds" : dl_trial_word(a->end), range,
                 a->first[0] ? " (" : "", a->first, a->first[0] ? ")" : "");
    else
        snprintf(part, sizeof part, "%s", a->first);
    if (a->used + strlen(part) < sizeof a->reason)
        a->used += (size_t)snprintf(a->reason + a->used, sizeof a->reason - a->used, "%s", part);
}

static void tell_run(attempt *a, double factor, const dl_trial *trial) {
    if (a->runs > 0 && trial->end == a->end) {
        a->to = factor;
    } else {
        tell_stretch(a);
        a->end = trial->end;
        a->from = a->to = factor;
        if (trial->end == DL_TRIAL_STABLE && is_ladder(a))
            a->first[0] = '\0';
        else if (trial->end == DL_TRIAL_STABLE)
            snprintf(a->first, sizeof a->first, "%lu steps to t = %.6g, energy error %.2g",
                     trial->summary.steps, trial->held, trial->energy_error);
        else
            memcpy(a->first, trial->why, sizeof a->first);
    }
    a->runs++;
    a->held += trial->end == DL_TRIAL_STABLE;
}

static dl_status add_row(attempt *a, double step, double end, const dl_trial *trial,
                         dl_error *error) {
    char word[DL_MESSAGE_SIZE + 64];
    const double values[] = {step,
                             step / a->step_unit,
                             trial->held,
                             trial->held / end,
                             trial->energy_error,
                             (double)trial->summary.steps};
    snprintf(word, sizeof word, "%s%s%s", dl_trial_word(trial->end), trial->why[0] ? ": " : "",
             trial->why);
    return dl_finding_add_row(a->finding, values, word, error);
}

/* --- runs ------------------------------------------------------------------------------------- */

/* A sample is a step's end: a method that chooses its steps is looked at seldom, so that it may. */
enum { adaptive_looks = 50 };

static dl_status run_adaptive(attempt *a, dl_error *error) {
    const dl_study_unit *const unit = a->unit;
    const double sample = fmax(unit->sample, unit->end / adaptive_looks);
    dl_trial trial;
    if (unit->progress)
        unit->progress(unit->context, "its own steps");
    dl_status status =
        dl_trial_run(unit, unit->options, unit->end, sample, &a->rule, &trial, error);
    if (status)
        return status;
    tell_run(a, NAN, &trial);
    return add_row(a, NAN, unit->end, &trial, error);
}

/* A rung of the ladder. */
static dl_status run_fixed(void *context, dl_scan_point *point, dl_error *error) {
    attempt *const a = context;
    dl_trial trial;
    char text[64];
    snprintf(text, sizeof text, "step %.4g", point->step);
    if (a->unit->progress)
        a->unit->progress(a->unit->context, text);
    const dl_status status = dl_trial_run_at(a->unit, point->step, &a->rule, &trial, error);
    if (status)
        return status;
    tell_run(a, point->step / a->step_unit, &trial);
    const double end = (double)dl_trial_steps(a->unit, point->step, &a->rule) * point->step;
    return add_row(a, point->step, end, &trial, error);
}

static double possible(const void *context, double step) {
    return dl_trial_step(((const attempt *)context)->unit->scene, step);
}

static dl_status run_ladder(attempt *a, dl_error *error) {
    dl_scan ladder = {.judge = run_fixed,
                      .possible = possible,
                      .context = a,
                      .smallest = a->how->range.smallest * a->step_unit,
                      .largest = a->how->range.largest * a->step_unit,
                      .per_decade = a->how->range.points,
                      .width = INFINITY}; /* the borders are not looked for */
    const dl_status status = dl_scan_run(&ladder, error);
    dl_scan_release(&ladder);
    return status;
}

static dl_status find_unit(attempt *a, dl_error *error) {
    dl_spectrum spectrum = {0, 0};
    const double step = own_step(a->unit);
    const bool needed = step > 0 && a->how->range.unit == DL_OF_FREQUENCY;
    const dl_status status = needed ? dl_scales_at_start(a->unit->scene, &spectrum, error) : DL_OK;
    if (step > 0)
        a->step_unit = dl_step_range_unit(&a->how->range, step, dl_spectrum_omega(&spectrum));
    return status;
}

static const char columns[] =
    "step [time]\nstep in units\ntime held [time]\nshare held\nenergy error\nsteps";

static dl_status measure(const dl_study_unit *unit, dl_finding *finding, dl_error *error) {
    const extreme_settings *const how = unit->settings;
    attempt a = {.unit = unit,
                 .how = how,
                 .finding = finding,
                 .rule = {.energy = how->range.bound,
                          .cold = how->cold,
                          .straight = how->straight,
                          .looks = lround(fmax(1, unit->end / unit->sample)),
                          .least = (unsigned long)how->range.least,
                          .most = (unsigned long)how->most}};
    dl_status status = find_unit(&a, error);
    if (!status)
        status = dl_finding_set_columns(finding, columns, error);
    if (!status)
        status = a.step_unit > 0 ? run_ladder(&a, error) : run_adaptive(&a, error);
    if (status)
        return status;
    tell_stretch(&a);
    status = dl_finding_add(finding, "runs", (double)a.runs, NAN, NAN, error);
    if (!status)
        status = dl_finding_add(finding, "runs that held", (double)a.held, NAN, NAN, error);
    return status ? status
                  : dl_finding_judge(finding, error,
                                     a.held == a.runs ? "holds"
                                     : a.runs == 1    ? dl_trial_word(a.end)
                                     : a.held > 0     ? "holds in part"
                                                      : "fails",
                                     "%s", a.reason);
}

/* --- the answer ------------------------------------------------------------------------------- */

/* Whether a finding before this one, on the same scene, has its verdict. */
static bool told_before(const dl_results *results, size_t i) {
    const dl_finding *const finding = &results->finding[i];
    for (size_t k = 0; k < i; k++)
        if (dl_verdict_is(&results->finding[k], finding->scene, finding->verdict))
            return true;
    return false;
}

/* "; blow-up: 2 (METHOD)" for every verdict that is no success. */
static void tell_ends(const dl_results *results, const char *scene, FILE *out) {
    const char *separator = ". The others: ";
    for (size_t i = 0; i < results->findings; i++) {
        const dl_finding *const finding = &results->finding[i];
        const char *const verdict = finding->verdict;
        if (!dl_verdict_is(finding, scene, NULL) || strcmp(verdict, "holds") == 0 ||
            told_before(results, i))
            continue;
        fprintf(out, "%s%s: %zu", separator, *verdict ? verdict : "could not be measured",
                dl_verdict_count(results, scene, verdict));
        dl_verdict_list(results, scene, verdict, false, out);
        separator = "; ";
    }
}

static void answer(const dl_results *results, const char *scene, char *text, size_t size) {
    FILE *out = fmemopen(text, size, "w");
    text[0] = '\0';
    if (!out)
        return;
    fprintf(out, "on %s %zu of %zu hold", scene, dl_verdict_count(results, scene, "holds"),
            dl_verdict_count(results, scene, NULL));
    dl_verdict_list(results, scene, "holds", false, out);
    tell_ends(results, scene, out);
    fclose(out);
    text[size - 1] = '\0';
}

const dl_study_kind dl_study_kind_extreme = {
    .doc = "how far a method goes on an extreme scene, and how it fails",
    .settings = {.rows = settings, .count = sizeof settings / sizeof *settings},
    .settings_size = sizeof(extreme_settings),
    .samples = 1000,
    .check = check,
    .measure = measure,
    .good = "holds",
    .answer = answer,
};
