/* Kind `drift`: does the energy error stay bounded, and is its fluctuation of the method's order?
 *
 * The energy error, what walls and radiation take being booked, is split into a straight line in
 * time (drift) and what is left about it (fluctuation), at the step h and at h/2, h/4; a method
 * that chooses its steps is run with rtol and atol as given, over 10 and over 100 instead, and no
 * order is asked of it. Momenta go the same way, and a run forward and back. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include "study/drift.h"
#include "study/verdicts.h"

#define AT(field) .offset = offsetof(dl_drift_settings, field)

static const dl_parameter rows[] = {
    {.name = "allow",
     .kind = DL_REAL,
     AT(allow),
     .unit = "energy scale",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "0",
     .doc = "change of the energy over the run by its drift that passes; 0: its fluctuation"},
    {.name = "levels",
     .kind = DL_INTEGER,
     AT(levels),
     .unit = "",
     .minimum = 1,
     .maximum = 6,
     .fallback = "3",
     .doc = "runs, each with half the step (a tenth of the tolerances) of the one before; 1: no "
            "order is asked"},
    {.name = "slack",
     .kind = DL_REAL,
     AT(slack),
     .unit = "",
     .minimum = 0,
     .maximum = 1,
     .fallback = "0.15",
     .doc = "part of the method's order by which the measured one may differ, besides its "
            "interval"},
    {.name = "reversal",
     .kind = DL_REAL,
     AT(reversal),
     .unit = "time",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "0",
     .doc = "run forward and back; 0: to the end, or as far as roundoff does not hide all"},
};

static dl_status check(const dl_study_unit *unit, dl_error *error) {
    const dl_drift_knob knob = dl_drift_knob_of(unit->row, unit->options);
    dl_study_unit rounded = *unit;
    if (!(knob.size > 0))
        return dl_fail(error, DL_INPUT, "rtol: found %g, expected one > 0, to be made smaller",
                       knob.size);
    rounded.sample = dl_drift_interval(unit, &knob);
    return dl_study_try_start(&rounded, error);
}

/* --- quantities --------------------------------------------------------------------------------
 */

typedef struct sheet {
    dl_finding *finding;
    dl_status status;
    dl_error *error;
} sheet;

static void add(sheet *on, const char *name, dl_interval value) {
    if (on->status == DL_OK)
        on->status =
            dl_finding_add(on->finding, name, value.value, value.low, value.high, on->error);
}

static void add_value(sheet *on, const char *name, double value) {
    add(on, name, (dl_interval){value, NAN, NAN});
}

static void add_drift(sheet *on, const char *what, const dl_drift *drift) {
    char name[80];
    snprintf(name, sizeof name, "%s drift [1/time]", what);
    add(on, name, drift->per_time);
    snprintf(name, sizeof name, "%s drift over the run", what);
    add(on, name, drift->change);
    snprintf(name, sizeof name, "%s fluctuation", what);
    add_value(on, name, drift->line.rms);
    snprintf(name, sizeof name, "%s error", what);
    add_value(on, name, drift->largest);
}

/* "step/2", "rtol/10". */
static void level_name(const dl_drift_knob *knob, size_t level, char *text, size_t size) {
    if (level == 0)
        snprintf(text, size, "%s", knob->adaptive ? "rtol" : "step");
    else
        snprintf(text, size, "%s/%.0f", knob->adaptive ? "rtol" : "step",
                 knob->adaptive ? pow(10, (double)level) : ldexp(1, (int)level));
}

static void add_levels(sheet *on, const dl_drift_study *study) {
    for (size_t l = 1; l < study->levels; l++) {
        char level[32], name[80];
        level_name(&study->knob, l, level, sizeof level);
        if (study->run[l].summary.status != DL_OK)
            continue;
        snprintf(name, sizeof name, "energy drift at %s [1/time]", level);
        add(on, name, study->energy[l].per_time);
        snprintf(name, sizeof name, "energy fluctuation at %s", level);
        add_value(on, name, study->energy[l].line.rms);
    }
    if (study->usable < 2)
        return;
    if (!isnan(study->orders.fluctuation.value))
        add(on, study->knob.adaptive ? "power of the fluctuation" : "order of the fluctuation",
            study->orders.fluctuation);
    if (!isnan(study->orders.slope.value))
        add(on, study->knob.adaptive ? "power of the drift" : "order of the drift",
            study->orders.slope);
}

static dl_status add_quantities(const dl_drift_study *study, dl_finding *finding, dl_error *error) {
    const dl_drift_run *run = &study->run[0];
    sheet on = {finding, DL_OK, error};
    add_value(&on, "energy scale [energy]", run->summary.energy_scale);
    add_drift(&on, "energy", &study->energy[0]);
    add_value(&on, "energy roundoff", dl_drift_roundoff(run));
    add_value(&on, "growth of the fluctuation", study->energy[0].growth);
    add_value(&on, "correlation time [time]", study->energy[0].line.correlation * study->interval);
    add_levels(&on, study);
    if (!isnan(study->momentum.largest))
        add_drift(&on, "momentum", &study->momentum);
    if (!isnan(study->angular.largest))
        add_drift(&on, "angular momentum", &study->angular);
    if (!isnan(study->reversal.distance)) {
        add_value(&on, "reversal after [time]", study->reversal.time);
        add_value(&on, "reversal distance [length]", study->reversal.distance);
        add_value(&on, "reversal roundoff [length]", study->reversal.explained);
    }
    return on.status;
}

/* --- table -------------------------------------------------------------------------------------
 */

static dl_status name_columns(const dl_drift_study *study, dl_finding *finding, dl_error *error) {
    char names[512] = "time [time]";
    for (size_t l = 0; l < study->levels; l++) {
        char level[32];
        const size_t used = strlen(names);
        level_name(&study->knob, l, level, sizeof level);
        snprintf(names + used, sizeof names - used, "\nenergy error at %s", level);
    }
    return dl_finding_set_columns(finding, names, error);
}

/* Every so many samples that a few hundred are left, and the last. */
static dl_status add_table(const dl_drift_study *study, dl_finding *finding, dl_error *error) {
    enum { most_rows = 250 };
    const dl_drift_run *first = &study->run[0];
    const size_t every = (first->n + most_rows - 1) / most_rows;
    dl_status status = name_columns(study, finding, error);
    for (size_t k = 0; k < first->n && status == DL_OK; k++) {
        double row[1 + DL_MOST_LEVELS];
        if (k % every != 0 && k + 1 != first->n)
            continue;
        row[0] = first->time[k];
        for (size_t l = 0; l < study->levels; l++)
            row[1 + l] = k < study->run[l].n ? study->run[l].energy[k] : NAN;
        status = dl_finding_add_row(finding, row, "", error);
    }
    return status;
}

/* --- measurement -------------------------------------------------------------------------------
 */

/* Finer runs only for a method whose first has an error to be made smaller. */
static dl_status run_levels(dl_drift_study *study, dl_error *error) {
    const dl_study_unit *unit = study->unit;
    const dl_drift_settings *settings = unit->settings;
    const bool exact = (unit->row->flags & DL_CONSERVES_ENERGY) != 0;
    const int levels = exact ? 1 : (int)settings->levels;
    study->interval = dl_drift_interval(unit, &study->knob);
    dl_status status =
        study->knob.adaptive ? dl_drift_widen_interval(unit, &study->interval, error) : DL_OK;
    for (int l = 0; l < levels && status == DL_OK; l++) {
        status = dl_drift_run_level(unit, &study->knob, study->interval, l, &study->run[l], error);
        study->levels = (size_t)l + 1; /* released even where it failed */
        if (study->run[0].summary.status != DL_OK)
            break;
    }
    return status;
}

static dl_status measure(const dl_study_unit *unit, dl_finding *finding, dl_error *error) {
    dl_drift_study study = {.unit = unit, .knob = dl_drift_knob_of(unit->row, unit->options)};
    study.orders = (dl_orders){{NAN, NAN, NAN}, {NAN, NAN, NAN}};
    study.reversal = (dl_reversal){.time = NAN, .distance = NAN, .explained = NAN};
    dl_status status = run_levels(&study, error);
    if (status == DL_OK)
        status = dl_drift_fit(&study, error);
    if (status == DL_OK && study.run[0].summary.status == DL_OK)
        status = dl_drift_reverse(unit, &study.knob, &study.reversal, error);
    if (status == DL_OK)
        status = dl_drift_judge(&study, finding, error);
    if (status == DL_OK)
        status = add_quantities(&study, finding, error);
    if (status == DL_OK)
        status = add_table(&study, finding, error);
    for (size_t l = 0; l < study.levels; l++)
        dl_drift_run_release(&study.run[l]);
    return status;
}

/* --- answer ------------------------------------------------------------------------------------
 */

static void answer(const dl_results *results, const char *scene, char *text, size_t size) {
    const size_t all = dl_verdict_count(results, scene, NULL),
                 stays = dl_verdict_count(results, scene, "pass");
    const size_t fails = dl_verdict_count(results, scene, "fail");
    FILE *out = fmemopen(text, size, "w");
    text[0] = '\0';
    if (!out)
        return;
    fprintf(out, "on %s the energy stays with %zu of %zu", scene, stays, all);
    dl_verdict_list(results, scene, "pass", true, out);
    if (fails > 0)
        fprintf(out, ". It does not with %zu", fails);
    else
        fputs(". It drifts with none", out);
    dl_verdict_list(results, scene, "fail", true, out);
    if (all > stays + fails) {
        fprintf(out, ", and of %zu it cannot be told", all - stays - fails);
        dl_verdict_list(results, scene, "not measurable", true, out);
    }
    fclose(out);
    text[size - 1] = '\0';
}

const dl_study_kind dl_study_kind_drift = {
    .doc = "does the energy error stay bounded, with a fluctuation of the method's order?",
    .settings = {rows, sizeof rows / sizeof *rows},
    .settings_size = sizeof(dl_drift_settings),
    .samples = 1000,
    .check = check,
    .measure = measure,
    .good = "pass",
    .answer = answer,
};
