/* Kind `equilibrium`: what statistics does a settled state have with this method at this step?
 *
 * A run's transient is what MSER-5 leaves out, for all tested quantities at once; it is over where
 * that is less than half the run and what is left does not change by Geweke's test nor along a line
 * (series.h). The means of what is left have intervals from batch means. Several runs from starts a
 * little apart tell whether there is one such state: their means must agree within their own
 * intervals. */
#include <float.h>
#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "core/random_stream.h"
#include "driftlab/trajectory.h"
#include "study/drift.h"
#include "study/equilibrium.h"

enum { most_runs = 64 };

#define AT(field) .offset = offsetof(dl_equilibrium_settings, field)

static const char *const frame_words[] = {
    [DL_EQUILIBRIUM_LAB] = "lab", [DL_EQUILIBRIUM_CENTRE] = "centre", NULL};

static const dl_parameter rows[] = {
    {.name = "runs",
     .kind = DL_INTEGER,
     AT(runs),
     .unit = "",
     .minimum = 1,
     .maximum = most_runs,
     .fallback = "1",
     .doc = "runs, whose starts differ a little; one state of all is told from several"},
    {.name = "displacement",
     .kind = DL_REAL,
     AT(displacement),
     .unit = "length",
     .minimum = 0,
     .maximum = DBL_MAX,
     .above_minimum = true,
     .fallback = "1e-6",
     .doc = "root mean square of what the starts of all runs but the first differ by, in every "
            "coordinate"},
    {.name = "bin",
     .kind = DL_REAL,
     AT(bin),
     .unit = "length",
     .minimum = 0,
     .maximum = DBL_MAX,
     .fallback = "0",
     .doc = "width of the bins of height that particles are counted in; 0: chosen"},
    {.name = "frame",
     .kind = DL_WORD,
     AT(frame),
     .unit = "",
     .words = frame_words,
     .fallback = "lab",
     .doc = "of the kinetic energy. lab: that of the velocities as they are; centre: of those "
            "relative to the mass centre's"},
};

/* Samples that nobody asked for are whole steps. */
static dl_study_unit with_whole_steps(const dl_study_unit *unit) {
    dl_study_unit rounded = *unit;
    const dl_drift_knob knob = dl_drift_knob_of(unit->row, unit->options);
    if (unit->sample_chosen)
        rounded.sample = dl_drift_interval(unit, &knob);
    return rounded;
}

static dl_status check(const dl_study_unit *unit, dl_error *error) {
    const dl_equilibrium_settings *settings = unit->settings;
    const dl_study_unit rounded = with_whole_steps(unit);
    dl_channels channels;
    const dl_status status = dl_channels_create(unit->scene, settings, &channels, error);
    return status == DL_OK ? dl_study_try_start(&rounded, error) : status;
}

/* --- runs --------------------------------------------------------------------------------------
 */

typedef struct ensemble {
    const dl_study_unit *unit;
    dl_channels channels;
    size_t runs;
    dl_settling run[most_runs];
    double chance; /* of kinetic energies as far apart as the runs', if they are of one state; 1 for
                      a single run */
} ensemble;

/* The scene with every coordinate moved; not out of the walls. */
static dl_status displace(const dl_study_unit *unit, size_t run, dl_scene **displaced,
                          dl_error *error) {
    const dl_scene *scene = unit->scene;
    const double size = ((const dl_equilibrium_settings *)unit->settings)->displacement;
    const size_t n = scene->particles, length = (size_t)scene->dimension * n;
    double *y_all = malloc(2 * length * sizeof *y_all);
    dl_random *random = NULL;
    dl_status status = y_all ? dl_random_create(run, 0, &random, error)
                             : dl_fail_memory(error, "a displaced start");
    for (size_t k = 0; k < length && status == DL_OK; k++) {
        const double low = scene->walls.low[k / n], high = scene->walls.high[k / n];
        if (k % n == 0)
            dl_random_begin(random, k / n, DL_RANDOM_PERTURBATION);
        y_all[k] = scene->position[k] + size * dl_random_normal(random);
        if (scene->walls.present)
            y_all[k] = fmin(fmax(y_all[k], low), high);
        y_all[length + k] = scene->velocity[k];
    }
    if (status == DL_OK)
        status = dl_scene_restart(scene, y_all, displaced, error);
    dl_random_free(random);
    free(y_all);
    return status;
}

static dl_status run_one(ensemble *of, size_t run, dl_error *error) {
    dl_scene *displaced = NULL;
    char label[32];
    snprintf(label, sizeof label, "run %zu", run + 1);
    dl_status status = run > 0 ? displace(of->unit, run, &displaced, error) : DL_OK;
    if (status == DL_OK)
        status = dl_settling_run(of->unit, &of->channels, displaced ? displaced : of->unit->scene,
                                 label, &of->run[run], error);
    dl_scene_free(displaced);
    return status;
}

static dl_status run_all(ensemble *of, dl_error *error) {
    const dl_equilibrium_settings *settings = of->unit->settings;
    dl_status status = dl_channels_create(of->unit->scene, settings, &of->channels, error);
    for (size_t r = 0; r < (size_t)settings->runs && status == DL_OK; r++) {
        status = run_one(of, r, error);
        of->runs = r + 1; /* released even where it failed */
        if (of->run[r].summary.status != DL_OK)
            break;
    }
    return status;
}

/* --- means of all runs -------------------------------------------------------------------------
 */

static double half_width(dl_interval of) {
    return (of.high - of.low) / 2;
}

/* Mean over the runs. If they agree, the interval is that of independent means of one state; else,
 * or where a run is too short for an interval of its own, that of the runs' scatter. */
static dl_interval mean_of(const ensemble *of, size_t channel, bool agree) {
    const double n = (double)of->runs;
    double sum = 0, squares = 0, scatter = 0;
    for (size_t r = 0; r < of->runs; r++) {
        const dl_interval one = dl_settling_mean(&of->run[r], channel);
        sum += one.value;
        squares += half_width(one) * half_width(one);
    }
    const double mean = sum / n;
    for (size_t r = 0; r < of->runs; r++) {
        const double d = dl_settling_mean(&of->run[r], channel).value - mean;
        scatter += d * d;
    }
    double half = sqrt(squares) / n;
    if ((!agree || isnan(half)) && of->runs > 1)
        half = gsl_cdf_tdist_Pinv(0.975, n - 1) * sqrt(scatter / (n * (n - 1)));
    return (dl_interval){mean, mean - half, mean + half};
}

/* Chi-squared of the runs' kinetic energies about their weighted mean. */
static double chance_of_spread(const ensemble *of) {
    double weights = 0, sum = 0, squares = 0;
    if (of->runs < 2)
        return 1;
    for (size_t r = 0; r < of->runs; r++) {
        const dl_interval one = dl_settling_mean(&of->run[r], 0);
        const double error = half_width(one) / 2;
        if (!(error > 0))
            return NAN;
        weights += 1 / (error * error);
        sum += one.value / (error * error);
    }
    for (size_t r = 0; r < of->runs; r++) {
        const dl_interval one = dl_settling_mean(&of->run[r], 0);
        const double d = (one.value - sum / weights) / (half_width(one) / 2);
        squares += d * d;
    }
    return gsl_cdf_chisq_Q(squares, (double)(of->runs - 1));
}

/* --- verdict -----------------------------------------------------------------------------------
 */

static const double least_chance = 1e-3;

static dl_status judge(const ensemble *of, dl_finding *finding, dl_error *error) {
    const dl_settling *last = &of->run[of->runs - 1];
    if (last->summary.status != DL_OK)
        return dl_finding_judge(finding, error, "failed", "run %zu ended at t = %.3g (%s): %.300s",
                                of->runs, last->summary.t_end_reached,
                                dl_status_name(last->summary.status), last->summary.message);
    size_t settled = 0, unsettled = 0;
    double longest = 0;
    for (size_t r = 0; r < of->runs; r++) {
        settled += of->run[r].settled;
        if (!of->run[r].settled)
            unsettled = r;
        longest = fmax(longest, of->run[r].time[of->run[r].transient]);
    }
    if (settled < of->runs)
        return dl_finding_judge(finding, error, "not settled", "%zu of %zu run%s: %s",
                                of->runs - settled, of->runs, of->runs > 1 ? "s" : "",
                                of->run[unsettled].why);
    if (of->chance < least_chance)
        return dl_finding_judge(finding, error, "several states",
                                "every run has settled, after t = %.3g at the latest, but not to "
                                "the same kinetic energy (chance %.1g)",
                                longest, of->chance);
    return dl_finding_judge(finding, error, "settled",
                            "the transient is over after t = %.3g of %.3g", longest,
                            of->run[0].time[of->run[0].n - 1]);
}

static dl_status add_quantities(const ensemble *of, dl_finding *finding, dl_error *error) {
    const bool agree = !(of->chance < least_chance);
    double transient = 0;
    dl_status status = DL_OK;
    for (size_t c = 0; c < of->channels.count && status == DL_OK; c++) {
        const dl_interval mean = mean_of(of, c, agree);
        status = dl_finding_add(finding, of->channels.channel[c].name, mean.value, mean.low,
                                mean.high, error);
    }
    for (size_t r = 0; r < of->runs && of->runs > 1 && status == DL_OK; r++) {
        const dl_interval mean = dl_settling_mean(&of->run[r], 0);
        char name[80];
        snprintf(name, sizeof name, "kinetic energy per particle, run %zu [energy]", r + 1);
        status = dl_finding_add(finding, name, mean.value, mean.low, mean.high, error);
    }
    for (size_t r = 0; r < of->runs; r++)
        transient = fmax(transient, of->run[r].time[of->run[r].transient]);
    if (status == DL_OK)
        status = dl_finding_add(finding, "transient [time]", transient, NAN, NAN, error);
    if (status == DL_OK)
        status = dl_finding_add(finding, "change left [standard errors]", of->run[0].change, NAN,
                                NAN, error);
    return status;
}

/* --- table -------------------------------------------------------------------------------------
 */

/* Time and the tested channels of the first run, then the kinetic energies of the others. */
static dl_status name_columns(const ensemble *of, dl_finding *finding, dl_error *error) {
    char names[80 * (1 + DL_MOST_CHANNELS + most_runs)] = "time [time]";
    size_t used = strlen(names);
    for (size_t c = 0; c < of->channels.count; c++)
        if (of->channels.channel[c].tested)
            used += (size_t)snprintf(names + used, sizeof names - used, "\n%s",
                                     of->channels.channel[c].name);
    for (size_t r = 1; r < of->runs; r++)
        used += (size_t)snprintf(names + used, sizeof names - used,
                                 "\nkinetic energy per particle, run %zu [energy]", r + 1);
    return dl_finding_set_columns(finding, names, error);
}

static dl_status add_table(const ensemble *of, dl_finding *finding, dl_error *error) {
    enum { most_rows = 250 };
    const dl_settling *first = &of->run[0];
    const size_t every = (first->n + most_rows - 1) / most_rows;
    dl_status status = name_columns(of, finding, error);
    for (size_t k = 0; k < first->n && status == DL_OK; k += every) {
        double row[1 + DL_MOST_CHANNELS + most_runs];
        size_t column = 0;
        row[column++] = first->time[k];
        for (size_t c = 0; c < of->channels.count; c++)
            if (of->channels.channel[c].tested)
                row[column++] = first->value[c][k];
        for (size_t r = 1; r < of->runs; r++)
            row[column++] = k < of->run[r].n ? of->run[r].value[0][k] : NAN;
        status = dl_finding_add_row(finding, row, "", error);
    }
    return status;
}

static dl_status measure(const dl_study_unit *unit, dl_finding *finding, dl_error *error) {
    const dl_study_unit rounded = with_whole_steps(unit);
    ensemble *of = calloc(1, sizeof *of);
    if (!of)
        return dl_fail_memory(error, "runs");
    of->unit = &rounded;
    dl_status status = run_all(of, error);
    const bool complete = status == DL_OK && of->run[of->runs - 1].summary.status == DL_OK;
    if (complete)
        of->chance = chance_of_spread(of);
    if (status == DL_OK)
        status = judge(of, finding, error);
    if (complete && status == DL_OK)
        status = add_quantities(of, finding, error);
    if (status == DL_OK)
        status = add_table(of, finding, error);
    for (size_t r = 0; r < of->runs; r++)
        dl_settling_release(&of->run[r]);
    free(of);
    return status;
}

/* --- answer ------------------------------------------------------------------------------------
 */

static const char told[] = "kinetic energy per particle";

/* NaN where it has not settled. */
static double settled_value(const dl_finding *finding) {
    const double *value = dl_finding_quantity(finding, told);
    return value && strcmp(finding->verdict, "settled") == 0 ? value[0] : NAN;
}

/* Infinite for a method that chooses its steps. */
static double step_of(const dl_finding *finding) {
    static const char key[] = "step=";
    char fineness[64];
    dl_finding_fineness(finding, fineness, sizeof fineness);
    return strncmp(fineness, key, strlen(key)) == 0 ? strtod(fineness + strlen(key), NULL)
                                                    : INFINITY;
}

/* The settled cases of a scene: at the smallest step, and the ends of the range. */
typedef struct settled_cases {
    size_t all, settled;
    const dl_finding *finest, *low, *high; /* NULL: none */
} settled_cases;

static settled_cases find_settled(const dl_results *results, const char *scene) {
    settled_cases of = {0, 0, NULL, NULL, NULL};
    for (size_t i = 0; i < results->findings; i++) {
        const dl_finding *finding = &results->finding[i];
        if (strcmp(finding->scene, scene) != 0)
            continue;
        of.all++;
        const double value = settled_value(finding);
        if (isnan(value))
            continue;
        of.settled++;
        if (!of.finest || step_of(finding) < step_of(of.finest))
            of.finest = finding;
        if (!of.low || value < settled_value(of.low))
            of.low = finding;
        if (!of.high || value > settled_value(of.high))
            of.high = finding;
    }
    return of;
}

/* "18.1 (16.8 to 19.3) with leapfrog step=0.0001" */
static void tell_value(const dl_finding *finding, FILE *out) {
    const double *value = dl_finding_quantity(finding, told);
    char fineness[64];
    dl_finding_fineness(finding, fineness, sizeof fineness);
    fprintf(out, "%.4g", value[0]);
    if (!isnan(value[1]))
        fprintf(out, " (%.4g to %.4g)", value[1], value[2]);
    fprintf(out, " with %s %s", finding->method, fineness);
}

static void answer(const dl_results *results, const char *scene, char *text, size_t size) {
    const settled_cases of = find_settled(results, scene);
    FILE *out = fmemopen(text, size, "w");
    text[0] = '\0';
    if (!out)
        return;
    fprintf(out, "%s on %s: ", told, scene);
    if (!of.finest) {
        fprintf(out, "none of %zu cases has settled", of.all);
    } else {
        tell_value(of.finest, out);
        fprintf(out, "%s. ",
                of.settled > 1 && isfinite(step_of(of.finest)) ? ", the smallest step" : "");
        fprintf(out, "Of %zu case%s %zu settled", of.all, of.all == 1 ? "" : "s", of.settled);
        if (of.low != of.high) {
            fputs(", between ", out);
            tell_value(of.low, out);
            fputs(" and ", out);
            tell_value(of.high, out);
        }
    }
    fclose(out);
    text[size - 1] = '\0';
}

const dl_study_kind dl_study_kind_equilibrium = {
    .doc = "what are a settled state's statistics, with this method at this step?",
    .settings = {rows, sizeof rows / sizeof *rows},
    .settings_size = sizeof(dl_equilibrium_settings),
    .samples = 1000,
    .check = check,
    .measure = measure,
    .good = "settled",
    .answer = answer,
};
