/* Verdict of the kind `drift`, after the tests of integrator convergence of P. T. Merz and M. R.
 * Shirts (doi:10.1371/journal.pone.0202764), where fluctuations of the conserved energy at two time
 * steps must be in the ratio of the steps' squares; here of any order p, with intervals of
 * confidence, and beside it the drift, the momenta and the reversal. */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include "study/drift.h"

/* --- fit ---------------------------------------------------------------------------------------
 */

static dl_interval times(dl_interval value, double factor) {
    return (dl_interval){value.value * factor, value.low * factor, value.high * factor};
}

static double largest(const double *value, size_t n) {
    double most = 0;
    for (size_t k = 0; k < n; k++)
        most = fmax(most, fabs(value[k]));
    return most;
}

static dl_status fit(const dl_drift_run *run, const double *value, double interval, dl_drift *drift,
                     dl_error *error) {
    static const dl_interval none = {NAN, NAN, NAN};
    *drift = (dl_drift){.line = {.slope = none, .rms = NAN, .correlation = NAN},
                        .per_time = none,
                        .change = none,
                        .largest = NAN,
                        .growth = NAN};
    if (run->n < 3 || isnan(value[run->n - 1]))
        return DL_OK;
    const dl_status status = dl_series_line(value, run->n, &drift->line, NULL, error);
    drift->per_time = times(drift->line.slope, 1 / interval);
    drift->change = times(drift->line.slope, (double)(run->n - 1));
    drift->largest = largest(value, run->n);
    drift->growth = dl_series_growth(value, run->n);
    return status;
}

/* Levels from the first on that ended well, with as many samples, above roundoff. */
static size_t count_usable(const dl_drift_study *study) {
    size_t count = 0;
    while (count < study->levels && study->run[count].summary.status == DL_OK &&
           study->run[count].n == study->run[0].n &&
           study->energy[count].line.rms > dl_drift_roundoff(&study->run[count]))
        count++;
    return count;
}

dl_status dl_drift_fit(dl_drift_study *study, dl_error *error) {
    const double interval = study->interval;
    const dl_drift_run *first = &study->run[0];
    const double *value[DL_MOST_LEVELS];
    double size[DL_MOST_LEVELS];
    dl_status status = fit(first, first->momentum, interval, &study->momentum, error);
    if (status == DL_OK)
        status = fit(first, first->angular, interval, &study->angular, error);
    for (size_t l = 0; l < study->levels && status == DL_OK; l++) {
        status = fit(&study->run[l], study->run[l].energy, interval, &study->energy[l], error);
        value[l] = study->run[l].energy;
        size[l] = study->run[l].size;
    }
    if (status != DL_OK)
        return status;
    study->usable = count_usable(study);
    if (study->usable >= 2)
        status = dl_series_orders(study->usable, value, size, first->n, &study->orders, error);
    return status;
}

/* --- judgement ---------------------------------------------------------------------------------
 */

typedef enum outcome { PASS, UNKNOWN, FAIL } outcome; /* the worst one is the verdict */

typedef struct judgement {
    outcome worst;
    char reason[3][DL_MESSAGE_SIZE / 2]; /* sentences by outcome */
} judgement;

static void say(judgement *of, outcome found, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

static void say(judgement *of, outcome found, const char *format, ...) {
    char *text = of->reason[found];
    size_t used = strlen(text);
    const size_t size = sizeof of->reason[found];
    if (used > 0)
        used += (size_t)snprintf(text + used, size - used, "; ");
    va_list arguments;
    va_start(arguments, format);
    if (used < size)
        vsnprintf(text + used, size - used, format, arguments);
    va_end(arguments);
    if (found > of->worst)
        of->worst = found;
}

static bool run_failed(const dl_drift_study *study, judgement *found) {
    const dl_run_summary *summary = &study->run[0].summary;
    if (summary->status == DL_OK)
        return false;
    say(found, summary->status == DL_TIMEOUT ? UNKNOWN : FAIL,
        "the run ended at t = %.3g of %.3g (%s): %.300s", summary->t_end_reached, study->unit->end,
        dl_status_name(summary->status), summary->message);
    return true;
}

static bool claims(const dl_drift_study *study, unsigned flag) {
    return (study->unit->row->flags & flag) != 0;
}

/* An error that is to be no more than a few times roundoff, or what the method's solver leaves. */
static void judge_exact(const dl_drift_study *study, const char *what, const dl_drift *drift,
                        double roundoff, judgement *found) {
    const double level = 4 * roundoff * dl_drift_solved_to(study->unit->row, study->unit->options);
    if (isnan(drift->largest))
        return;
    if (drift->largest <= level)
        say(found, PASS, "%s kept to %.2g of its scale, roundoff", what, drift->largest);
    else
        say(found, FAIL,
            "%s, which the method is to conserve, is off by %.2g of its scale "
            "(roundoff may explain %.2g)",
            what, drift->largest, level);
}

/* Drift of an energy error that roundoff does not hide: passes where its whole interval is within
 * what is allowed, fails where all of it is beyond. */
static void judge_slope(const dl_drift_study *study, judgement *found) {
    const dl_drift_settings *settings = study->unit->settings;
    const dl_drift *energy = &study->energy[0];
    const dl_interval change = energy->change;
    const double fluctuation = energy->line.rms;
    const double allowed = settings->allow > 0 ? settings->allow : fluctuation;
    const char *limit = settings->allow > 0 ? "the change allowed" : "its fluctuation";
    if (isnan(change.low))
        say(found, UNKNOWN,
            "the run is too short to tell a drift: its %zu samples remember one another over %.3g "
            "(--t-end)",
            study->run[0].n, energy->line.correlation);
    else if (fmax(fabs(change.low), fabs(change.high)) <= allowed)
        say(found, PASS,
            "the energy's drift changes it by %.2g (%.2g to %.2g) of its scale over the run, "
            "within %s, %.2g",
            change.value, change.low, change.high, limit, allowed);
    else if (change.low > allowed || change.high < -allowed)
        say(found, FAIL,
            "the energy drifts by %.3g (%.3g to %.3g) of its scale a unit of time: %.2g over the "
            "run, %.2g times %s%s",
            energy->per_time.value, energy->per_time.low, energy->per_time.high, change.value,
            fabs(change.value) / allowed, limit,
            claims(study, DL_SYMPLECTIC) ? " (a state that is itself still changing does the same)"
                                         : "");
    else
        say(found, UNKNOWN,
            "the energy's drift changes it by %.2g (%.2g to %.2g) of its scale over the run: "
            "whether within %s, %.2g, is not told apart (--t-end)",
            change.value, change.low, change.high, limit, allowed);
    if (!isnan(study->orders.slope.value) && !study->knob.adaptive)
        say(found, PASS, "the drift is of order %.2f (%.2f to %.2f)", study->orders.slope.value,
            study->orders.slope.low, study->orders.slope.high);
}

/* Why the levels do not give an order, which is no verdict where none is asked. */
static void tell_no_order(const dl_drift_study *study, outcome known, judgement *found) {
    const dl_run_summary *next = &study->run[study->usable].summary;
    const char *finer = study->knob.adaptive ? "a tenth of the tolerance" : "half the step";
    double memory = 0;
    for (size_t l = 0; l < study->usable; l++)
        memory = fmax(memory, study->energy[l].line.correlation);
    if (study->usable >= 2 && !isfinite(study->energy[0].growth))
        say(found, known,
            "the fluctuation has no order: it remembers itself over %.3g of %zu samples, too few "
            "to "
            "tell how it grows",
            memory, study->run[0].n);
    else if (study->usable >= 2)
        say(found, known,
            "the fluctuation has no order: it remembers itself over %.3g of %zu samples and grows "
            "with time to the power %.2f (a walk's 0.5; more in a run that is too short)",
            memory, study->run[0].n, study->energy[0].growth);
    else if (next->status != DL_OK)
        say(found, known, "no order: the run at %s ended (%s)", finer,
            dl_status_name(next->status));
    else
        say(found, known, "no order: at %s the fluctuation is roundoff", finer);
}

static void judge_order(const dl_drift_study *study, judgement *found) {
    const dl_interval order = study->orders.fluctuation;
    const int claimed = study->unit->row->order;
    if (study->levels < 2)
        return;
    const bool asked = !study->knob.adaptive && claimed > 0;
    if (study->usable < 2 || isnan(order.low)) {
        tell_no_order(study, asked ? UNKNOWN : PASS, found);
        return;
    }
    if (!asked) {
        say(found, PASS, "the fluctuation goes with the %s to the power %.2f (%.2f to %.2f)",
            study->knob.adaptive ? "tolerance" : "step", order.value, order.low, order.high);
        return;
    }
    const dl_drift_settings *settings = study->unit->settings;
    const double slack = settings->slack * claimed;
    if (order.high - order.low > claimed)
        say(found, UNKNOWN, "the order of the fluctuation, %.2f to %.2f, is not told apart",
            order.low, order.high);
    else if (order.low <= claimed + slack && order.high >= claimed - slack)
        say(found, PASS, "the fluctuation is %.2g of the scale and of order %.2f (%.2f to %.2f)",
            study->energy[0].line.rms, order.value, order.low, order.high);
    else
        say(found, FAIL,
            "the fluctuation, %.2g of the scale, is of order %.2f (%.2f to %.2f), not %d",
            study->energy[0].line.rms, order.value, order.low, order.high, claimed);
}

static void judge_energy(const dl_drift_study *study, judgement *found) {
    const dl_drift_run *run = &study->run[0];
    enum { least_samples = 20 };
    if (run->n < least_samples) {
        say(found, UNKNOWN, "%zu samples are too few (a smaller --sample, or a longer run)",
            run->n);
        return;
    }
    if (claims(study, DL_CONSERVES_ENERGY)) {
        judge_exact(study, "energy", &study->energy[0], dl_drift_roundoff(run), found);
        return;
    }
    if (study->usable == 0) {
        say(found, UNKNOWN, "the energy error, %.2g of its scale, is no more than roundoff",
            study->energy[0].largest);
        return;
    }
    judge_order(study, found);
    judge_slope(study, found);
}

static void judge_reversal(const dl_drift_study *study, judgement *found) {
    const dl_reversal *reversal = &study->reversal;
    if (!claims(study, DL_TIME_SYMMETRIC))
        return;
    if (isnan(reversal->distance))
        say(found, PASS, "not run back: %s", reversal->why);
    else if (reversal->distance <= reversal->explained)
        say(found, PASS, "run back from t = %.3g it returns to %.2g, roundoff", reversal->time,
            reversal->distance);
    else
        say(found, FAIL,
            "run back from t = %.3g it ends %.2g from where it began, though it is to be "
            "time-symmetric (roundoff may explain %.2g)",
            reversal->time, reversal->distance, reversal->explained);
}

dl_status dl_drift_judge(const dl_drift_study *study, dl_finding *finding, dl_error *error) {
    static const char *const verdicts[] = {"pass", "not measurable", "fail"};
    judgement found = {.worst = PASS};
    const dl_drift_run *run = &study->run[0];
    if (!run_failed(study, &found)) {
        judge_energy(study, &found);
        if (claims(study, DL_CONSERVES_MOMENTUM)) {
            const double roundoff = dl_drift_momentum_roundoff(run);
            judge_exact(study, "momentum", &study->momentum, roundoff, &found);
            judge_exact(study, "angular momentum", &study->angular, roundoff, &found);
        }
        judge_reversal(study, &found);
    }
    char reason[2 * DL_MESSAGE_SIZE] = "";
    for (int k = FAIL; k >= PASS; k--) /* what decided first */
        if (*found.reason[k])
            snprintf(reason + strlen(reason), sizeof reason - strlen(reason), "%s%s",
                     *reason ? "; " : "", found.reason[k]);
    return dl_finding_judge(finding, error, verdicts[found.worst], "%s", reason);
}
