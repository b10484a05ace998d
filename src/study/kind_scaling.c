/* Kind `scaling`: which bulk quantities of a body depend on how many particles it is made of?
 *
 * A unit runs the body at one size and tells the means of its bulk (scaling.h) over the last part
 * of the run, and what it cost. What agrees with the largest size, and with which power of the
 * number of particles the cost grows, is told of all findings together (driftlab/scaling.h). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/drift.h"
#include "study/scaling.h"
#include "study/telling.h"

#define AT(field) .offset = offsetof(dl_scaling_settings, field)

static const dl_parameter rows[] = {
    {.name = "from",
     .kind = DL_REAL,
     AT(from),
     .unit = "of the run",
     .minimum = 0,
     .maximum = 1,
     .fallback = "0.5",
     .doc = "means are over the samples from there on; 1: the last alone"},
    {.name = "bins",
     .kind = DL_INTEGER,
     AT(bins),
     .unit = "",
     .minimum = 1,
     .maximum = DL_MOST_PROFILE_BINS,
     .fallback = "10",
     .doc = "slices along x that the body's density is told in"},
    {.name = "agree",
     .kind = DL_REAL,
     AT(agree),
     .unit = "",
     .minimum = 0,
     .maximum = 1,
     .above_minimum = true,
     .fallback = "0.05",
     .doc = "relative difference from the largest size up to which a quantity agrees with it"},
};

static dl_study_unit with_whole_steps(const dl_study_unit *unit) {
    dl_study_unit rounded = *unit;
    const dl_drift_knob knob = dl_drift_knob_of(unit->row, unit->options);
    if (unit->sample_chosen)
        rounded.sample = dl_drift_interval(unit, &knob);
    return rounded;
}

static dl_status check(const dl_study_unit *unit, dl_error *error) {
    size_t moving = 0;
    for (size_t i = 0; i < unit->scene->particles; i++)
        moving += !unit->scene->pinned[i];
    if (moving < 2)
        return dl_fail(error, DL_INPUT,
                       "particles: found %zu that move, expected at least two, a body", moving);
    if (unit->scene->periods.present)
        return dl_fail(error, DL_INPUT,
                       "periodic: found periods, expected none: a body has an extent and a centre");
    const dl_study_unit rounded = with_whole_steps(unit);
    return dl_study_try_start(&rounded, error);
}

/* --- the run ---------------------------------------------------------------------------------- */

typedef struct recorder {
    const dl_study_unit *unit;
    dl_finding *finding; /* its table is the series */
    dl_bulk bulk;
    dl_run_summary summary;
    double since; /* time from which on samples count */
    size_t samples, counted;
    double mean[DL_MOST_BULK]; /* sums, until the run has ended */
    double pairs;              /* likewise, over all samples */
} recorder;

/* Time and every quantity but the profile. */
static size_t columns_of(const dl_bulk *bulk) {
    return 1 + bulk->quantities - bulk->bins;
}

static dl_status name_columns(recorder *to, dl_error *error) {
    char names[DL_SCALED_NAME * (DL_MOST_BULK + 1)] = "time [time]";
    size_t used = strlen(names);
    for (size_t q = 0; q + 1 < columns_of(&to->bulk); q++)
        used += (size_t)snprintf(names + used, sizeof names - used, "\n%s", to->bulk.name[q]);
    return dl_finding_set_columns(to->finding, names, error);
}

static dl_status record(void *context, const dl_sample *sample, dl_error *error) {
    recorder *to = context;
    double row[1 + DL_MOST_BULK], pairs, *value = row + 1;
    dl_status status =
        dl_bulk_observe(&to->bulk, sample->y_all, sample->energy.pair, value, &pairs, error);
    if (status != DL_OK)
        return status;
    row[0] = sample->time;
    to->pairs += pairs;
    to->samples++;
    if (sample->time >= to->since) {
        for (size_t q = 0; q < to->bulk.quantities; q++)
            to->mean[q] += value[q];
        to->counted++;
    }
    return dl_finding_add_row(to->finding, row, "", error);
}

static dl_status run(recorder *to, dl_error *error) {
    const dl_study_unit *unit = to->unit;
    const dl_scaling_settings *settings = unit->settings;
    dl_telling telling = {.unit = unit};
    dl_run_options how;
    snprintf(telling.label, sizeof telling.label, "%zu particles", unit->scene->particles);
    to->since = settings->from * unit->end * (1 - 1e-12);
    dl_run_options_default(&how);
    how.end = unit->end;
    how.sample = unit->sample;
    how.time_limit = unit->seconds;
    how.on_sample = record;
    how.context = to;
    dl_telling_set(&telling, &how);
    const dl_status status =
        unit->run(unit->scene, unit->row, unit->options, &how, &to->summary, NULL, error);
    for (size_t q = 0; q < to->bulk.quantities; q++)
        to->mean[q] = to->counted ? to->mean[q] / (double)to->counted : NAN;
    to->pairs = to->samples ? to->pairs / (double)to->samples : NAN;
    return status;
}

/* --- the finding ------------------------------------------------------------------------------ */

static dl_status judge(const recorder *of, dl_finding *finding, dl_error *error) {
    const dl_run_summary *summary = &of->summary;
    if (summary->status != DL_OK)
        return dl_finding_judge(finding, error, "failed", "the run ended at t = %.3g (%s): %.300s",
                                summary->t_end_reached, dl_status_name(summary->status),
                                summary->message);
    return dl_finding_judge(finding, error, DL_SCALING_MEASURED,
                            "%zu particles, %lu steps, %.3g CPU s a step, energy error %.2g of the "
                            "scale",
                            of->unit->scene->particles, summary->steps,
                            summary->cpu_seconds / (double)summary->steps,
                            summary->energy_error_max / summary->energy_scale);
}

static dl_status add_costs(const recorder *of, dl_finding *finding, dl_error *error) {
    const dl_run_summary *summary = &of->summary;
    const double steps = (double)summary->steps, forces = (double)summary->force_evaluations;
    const double cost[DL_SCALED_COSTS] = {
        summary->cpu_seconds / steps,
        summary->cpu_seconds,
        forces,
        forces * of->pairs,
    };
    dl_status status =
        dl_finding_add(finding, "pairs looked at, per particle",
                       of->pairs / (double)of->unit->scene->particles, NAN, NAN, error);
    if (status == DL_OK)
        status = dl_finding_add(finding, "energy error [energy scale]",
                                summary->energy_error_max / summary->energy_scale, NAN, NAN, error);
    if (status == DL_OK)
        status = dl_finding_add(finding, DL_SCALING_STEP, summary->step / of->unit->scene->step,
                                NAN, NAN, error);
    if (status == DL_OK)
        status = dl_finding_add(finding, "steps", steps, NAN, NAN, error);
    for (size_t k = 0; k < DL_SCALED_COSTS && status == DL_OK; k++)
        status = dl_finding_add(finding, dl_scaling_costs[k], cost[k], NAN, NAN, error);
    return status;
}

static dl_status add_quantities(const recorder *of, dl_finding *finding, dl_error *error) {
    const dl_scaling_settings *settings = of->unit->settings;
    dl_status status = dl_finding_add(finding, DL_SCALING_PARTICLES,
                                      (double)of->unit->scene->particles, NAN, NAN, error);
    for (size_t q = 0; q < of->bulk.quantities && status == DL_OK; q++)
        status = dl_finding_add(finding, of->bulk.name[q], of->mean[q], NAN, NAN, error);
    if (status == DL_OK)
        status = add_costs(of, finding, error);
    return status == DL_OK
               ? dl_finding_add(finding, DL_SCALING_TOLERANCE, settings->agree, NAN, NAN, error)
               : status;
}

static dl_status measure(const dl_study_unit *unit, dl_finding *finding, dl_error *error) {
    const dl_study_unit rounded = with_whole_steps(unit);
    const dl_scaling_settings *settings = unit->settings;
    recorder to = {.unit = &rounded, .finding = finding};
    dl_status status = dl_bulk_create(unit->scene, (size_t)settings->bins, &to.bulk, error);
    if (status == DL_OK)
        status = name_columns(&to, error);
    if (status == DL_OK)
        status = run(&to, error);
    if (status == DL_OK)
        status = judge(&to, finding, error);
    if (status == DL_OK && to.summary.status == DL_OK)
        status = add_quantities(&to, finding, error);
    dl_bulk_free(&to.bulk);
    return status;
}

/* --- answer ----------------------------------------------------------------------------------- */

/* The slices of the profile are one quantity here: the worst of them. */
enum { no_slices = DL_MOST_SIZES + 1 };

static bool is_slice(const dl_scaled *quantity) {
    return strstr(quantity->name, ", slice ") != NULL;
}

static size_t worst_slice(const dl_scaling *of) {
    size_t worst = no_slices;
    for (size_t q = 0; q < of->quantities; q++)
        if (is_slice(&of->quantity[q]) && (worst == no_slices || of->quantity[q].from > worst))
            worst = of->quantity[q].from;
    return worst;
}

/* Names of the quantities that agree from size `from` on, or "". */
static void list(const dl_scaling *of, size_t from, char *text, size_t size) {
    size_t used = 0;
    *text = '\0';
    for (size_t q = 0; q < of->quantities && used < size; q++) {
        const char *name = of->quantity[q].name, *unit = strstr(name, " [");
        if (of->quantity[q].from == from && !is_slice(&of->quantity[q]))
            used += (size_t)snprintf(text + used, size - used, "%s%.*s", used ? ", " : "",
                                     unit ? (int)(unit - name) : (int)strlen(name), name);
    }
    if (worst_slice(of) == from && used < size)
        snprintf(text + used, size - used, "%sdensity in every slice along x", used ? ", " : "");
}

static size_t tell_sizes(const dl_scaling *of, char *text, size_t size) {
    size_t used =
        (size_t)snprintf(text, size, "%s with %s: to %.3g %% of %.0f particles agree", of->body,
                         of->method, 100 * of->tolerance, of->particles[of->sizes - 1]);
    const char *separator = "";
    for (size_t s = 0; s <= of->sizes && used < size; s++) {
        char names[DL_MESSAGE_SIZE], from[32];
        list(of, s, names, sizeof names);
        if (!*names)
            continue;
        if (s == of->sizes)
            snprintf(from, sizeof from, "not even its own runs");
        else if (s + 1 == of->sizes)
            snprintf(from, sizeof from, "none before it");
        else
            snprintf(from, sizeof from, "from %.0f on", of->particles[s]);
        used += (size_t)snprintf(text + used, size - used, "%s %s: %s", separator, from, names);
        separator = ";";
    }
    return used;
}

static void tell_costs(const dl_scaling *of, char *text, size_t size) {
    const dl_scaled_cost *step = &of->cost[0], *pairs = &of->cost[DL_SCALED_COSTS - 1];
    snprintf(text, size,
             ". CPU time of a step grows as N^%.3g (%.3g to %.3g), pair forces of the run as "
             "N^%.3g (%.3g to %.3g)",
             step->exponent, step->low, step->high, pairs->exponent, pairs->low, pairs->high);
}

/* All sizes are told once, by the scene that the largest size was first measured on. */
static void answer(const dl_results *results, const char *scene, char *text, size_t size) {
    const size_t count = dl_scalings_count(results);
    dl_scaling *of = count ? malloc(sizeof *of) : NULL;
    size_t used = 0;
    *text = '\0';
    for (size_t k = 0; k < count && of; k++) {
        dl_scaling_get(results, k, of);
        if (of->sizes < 2 || strcmp(of->largest, scene) != 0 || used >= size)
            continue;
        used += (size_t)snprintf(text + used, size - used, "%s", used ? ". " : "");
        if (used < size)
            used += tell_sizes(of, text + used, size - used);
        if (used < size)
            tell_costs(of, text + used, size - used);
        used = strlen(text);
    }
    free(of);
}

static void print(const dl_results *results, FILE *out) {
    const size_t count = dl_scalings_count(results);
    dl_scaling *of = count ? malloc(sizeof *of) : NULL;
    for (size_t k = 0; k < count && of; k++) {
        dl_scaling_get(results, k, of);
        dl_scaling_print(of, out);
    }
    free(of);
}

const dl_study_kind dl_study_kind_scaling = {
    .doc = "which bulk quantities of a body depend on how many particles it is made of?",
    .settings = {rows, sizeof rows / sizeof *rows},
    .settings_size = sizeof(dl_scaling_settings),
    .check = check,
    .measure = measure,
    .answer = answer,
    .print = print,
};
