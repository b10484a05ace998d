/* A recommendation: runs of growing length, each with a search for every method that is left. */
#include "driftlab/recommend.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "reference/horizon.h"
#include "study/kind.h"
#include "study/recommend.h"
#include "study/variants.h"

/* Steps of the scene's that the first runs go over; each next one is four times as long. */
static const double first_steps = 64;
/* Fewer of them tell nothing of a trajectory, and nothing is said of positions so many times
 * farther on than was measured. */
static const double least_steps = 4, farthest = 64;
enum { longer = 4, most_lengths = 14, reference_intervals = 4, most_repeats = 25 };
/* Times the cheapest's cost up to which a method's time is measured again. */
static const double close_by = 3;
/* CPU seconds of a run that are nothing: a method is not left behind for less. */
static const double nothing = 0.02;
/* Of the limit on time, what the shortest runs may take: the rest is for the whole's sake. */
static const double first_share = 0.6;
/* CPU seconds that the repeats of one case may take. */
static const double repeat_seconds = 0.2;

typedef struct work {
    const dl_recommend_request *request;
    dl_recommendation *made;
    dl_study *study;
    dl_recommend_run run;
    dl_watch watch;
    dl_reference reference;
    double began, unit; /* unit: time that every step fits in, of radiation; 0: none */
    size_t units;       /* in the whole run */
    bool *dropped;      /* [methods] */
    char current[200];
} work;

static bool asks_position(const work *w) {
    return strcmp(w->request->in, "position") == 0;
}

static void tick(void *context) {
    const work *w = context;
    char text[320];
    if (!w->request->on_progress)
        return;
    snprintf(text, sizeof text, "to t = %.4g of %.4g  %.0f of %g s  %s", w->run.end, w->made->end,
             dl_recommend_clock() - w->began, w->request->seconds, w->current);
    w->request->on_progress(w->request->context, text);
}

/* --- what is asked -----------------------------------------------------------------------------
 */

static dl_status check_request(const dl_recommend_request *request, dl_error *error) {
    if (!(request->error > 0) || !isfinite(request->error))
        return dl_fail(error, DL_INPUT, "error: found %g, expected a number > 0", request->error);
    if (!(request->seconds > 0))
        return dl_fail(error, DL_INPUT, "seconds: found %g, expected a time > 0", request->seconds);
    return DL_OK;
}

static dl_status make_study(work *w, dl_error *error) {
    const dl_recommend_request *request = w->request;
    dl_study *const study = w->study = calloc(1, sizeof *study);
    if (!study || !(study->scene = calloc(1, sizeof *study->scene)))
        return dl_fail_memory(error, "a study");
    study->scenes = 1;
    study->run = dl_run;
    study->kind = &dl_study_kind_work_precision;
    study->settings.repeats = 1;
    study->kind_changes = dl_text("%s", "");
    study->scene->path = dl_text("%s", request->scene);
    study->scene->lets = dl_let_arguments(request->lets, request->let);
    if (!study->kind_changes || !study->scene->path || !study->scene->lets)
        return dl_fail_memory(error, "a study");
    dl_status status = dl_parameter_defaults(dl_study_limits_table, &study->limits, error);
    if (status == DL_OK)
        status = dl_scene_read_let(request->scene, request->lets, request->let,
                                   &study->scene->scene, error);
    return status;
}

static size_t common_divisor(size_t a, size_t b) {
    while (b) {
        const size_t rest = a % b;
        a = b;
        b = rest;
    }
    return a;
}

/* Periods of radiation and the end are whole numbers of steps. */
static dl_status set_unit(work *w, dl_error *error) {
    const dl_scene *scene = w->study->scene->scene;
    if (!scene->radiation.present)
        return DL_OK;
    const size_t steps = dl_whole_steps(w->made->end, scene->step);
    const size_t period = dl_whole_steps(scene->radiation.period, scene->step);
    if (!steps || !period)
        return dl_fail(error, DL_INPUT,
                       "end: found %.15g, expected a whole number of the scene's steps, %.15g, in "
                       "it and in the period of radiation",
                       w->made->end, scene->step);
    const size_t unit = common_divisor(steps, period);
    w->unit = (double)unit * scene->step;
    w->units = steps / unit;
    return DL_OK;
}

static dl_status begin(work *w, dl_error *error) {
    dl_recommendation *const made = w->made;
    const dl_recommend_request *request = w->request;
    dl_status status = make_study(w, error);
    if (status)
        return status;
    const dl_scene *scene = w->study->scene->scene;
    *made = (dl_recommendation){.error = request->error, .reference_error = NAN};
    snprintf(made->scene, sizeof made->scene, "%s", scene->name);
    snprintf(made->in, sizeof made->in, "%s", request->in);
    made->end = request->end > 0 ? request->end : scene->end;
    status = dl_recommend_methods(request->methods, made, error);
    if (status == DL_OK)
        status = set_unit(w, error);
    if (status == DL_OK)
        status = dl_reference_length(scene, &made->length, error);
    if (status == DL_OK && !(w->dropped = calloc(made->methods + 1, sizeof *w->dropped)))
        status = dl_fail_memory(error, "methods");
    w->watch = (dl_watch){.interrupt = request->interrupt, .tick = tick, .context = w};
    w->run = (dl_recommend_run){.study = w->study,
                                .in = request->in,
                                .parts = 1,
                                .methods_left = 1,
                                .atol = 1e-3 * (made->length > 0 ? made->length : 1),
                                .scale = asks_position(w) && made->length > 0 ? made->length : 1,
                                .deadline = w->began + request->seconds,
                                .watch = &w->watch,
                                .current = w->current};
    return status;
}

/* --- lengths -----------------------------------------------------------------------------------
 */

/* The whole run divided by 4^k, as near as radiation allows. */
static double length_of(const work *w, int k) {
    const double share = pow(longer, -k);
    return w->unit > 0 ? w->unit * fmax(1, floor((double)w->units * share)) : w->made->end * share;
}

static void set_length(work *w, int k) {
    w->run.end = length_of(w, k);
    w->run.parts = w->unit > 0 ? (size_t)lround(w->run.end / w->unit) : 1;
}

static int first_length(const work *w) {
    const double step = w->study->scene->scene->step;
    int k = 0;
    while (k < most_lengths && step > 0 && length_of(w, k) > first_steps * step &&
           length_of(w, k + 1) < length_of(w, k))
        k++;
    return k;
}

/* The longest that should be over in time, judged by one that took `spent`, and is no longer than
 * `longest`; the same where none is. */
static int next_length(const work *w, int k, int longest, double spent) {
    const double left = w->run.deadline - dl_recommend_clock();
    for (int next = longest; next < k; next++) {
        /* Errors grow with the length, and what is not the whole is searched once more. */
        const double growth = length_of(w, next) / length_of(w, k) * (next > 0 ? 2.5 : 1.5);
        if (spent * growth < 0.9 * left)
            return next;
    }
    return k;
}

/* --- one length --------------------------------------------------------------------------------
 */

static double growth_of(const work *w, const dl_method_row *row) {
    const bool keeps = (row->flags & (DL_SYMPLECTIC | DL_CONSERVES_ENERGY)) != 0;
    return asks_position(w) ? (keeps ? 1 : 2) : (keeps ? 0 : 1);
}

static double share_of(const work *w) {
    return w->run.end / w->made->end;
}

/* That no method can reach in double precision need not be resolved. */
static double resolvable(const work *w, double wanted) {
    return fmax(wanted, DBL_EPSILON * w->made->length);
}

/* DL_TIMEOUT where it takes too long. *horizon: where it lies before this length's end. */
static dl_status make_reference(work *w, double wanted, double *horizon, dl_error *error) {
    *horizon = 0;
    if (!asks_position(w))
        return DL_OK;
    const dl_reference_request request = {
        .precision = DL_PRECISION_AUTO,
        .end = w->run.end,
        .intervals = reference_intervals,
        .wanted = resolvable(w, wanted) / DL_REFERENCE_MARGIN,
        .seconds = fmax(0.1, (w->run.deadline - dl_recommend_clock()) / 6),
        .memory = w->study->limits.memory,
        .interrupt = w->request->interrupt,
        .on_tick = tick,
        .context = w,
    };
    dl_reference fresh = {0};
    dl_error why = {""};
    snprintf(w->current, sizeof w->current, "reference in extended precision");
    const dl_status status = dl_reference_compute(w->study->scene->scene, &request, &fresh, &why);
    if (status == DL_INTERRUPTED)
        return dl_fail(error, status, "%s", why.message);
    if (status)
        return dl_fail(error, status,
                       "no position error without a reference, and that failed: "
                       "%.800s (--in energy needs none)",
                       why.message);
    *horizon = fresh.horizon;
    dl_reference_release(&w->reference);
    w->reference = fresh;
    w->run.reference = &w->reference;
    return DL_OK;
}

static double first_value(const work *w, const dl_recommended *method) {
    const dl_recommend_dial dial = dl_recommend_dial_of(method->row);
    const double step = w->study->scene->scene->step;
    if (dial.tolerance)
        return fmin(0.1, fmax(1e-12, pow(method->target, 1 / dial.order)));
    const double times = dial.order < 4 ? 1 : (dial.order < 6 ? 4 : 8);
    return step > 0 ? times * step : w->run.end / first_steps;
}

/* Every method that is left, from where it was on a shorter run. `final`: those whose error grows,
 * with what is asked of them for the whole run's sake; the others have their answer. */
static dl_status search_all(work *w, dl_recommended *method, bool final, bool *cut,
                            dl_error *error) {
    dl_status status = DL_OK;
    *cut = false;
    w->run.cheapest = INFINITY;
    for (size_t i = 0; i < w->made->methods && status == DL_OK; i++) {
        dl_recommended *const m = &method[i];
        if (w->dropped[i])
            continue;
        m->growth = growth_of(w, m->row);
        m->target = w->made->error * (final ? pow(share_of(w), m->growth) : 1);
        if (final && m->growth == 0 && m->reached)
            w->run.cheapest = fmin(w->run.cheapest, m->point.cpu_seconds);
        if (final && (m->growth == 0 || !m->reached))
            continue;
        bool ended = false;
        w->run.methods_left = w->made->methods - i;
        const double value = dl_recommend_value(&m->point);
        status =
            dl_recommend_search(&w->run, m, value > 0 ? value : first_value(w, m), &ended, error);
        *cut = *cut || ended;
    }
    return status;
}

static void drop_costly(work *w, int next) {
    const double times = length_of(w, next) / w->run.end;
    for (size_t i = 0; i < w->made->methods; i++) {
        dl_recommended *const m = &w->made->method[i];
        if (w->dropped[i] || !m->reached || times * m->point.cpu_seconds <= nothing ||
            m->point.cpu_seconds <= DL_RECOMMEND_HOPELESS * w->run.cheapest)
            continue;
        w->dropped[i] = true;
        m->reached = false;
        snprintf(m->reason, sizeof m->reason,
                 "on a run to t = %.4g it took %.2g times the cheapest's time (%s)", w->run.end,
                 m->point.cpu_seconds / w->run.cheapest, m->point.setting);
        m->point = m->coarser = m->finer = (dl_recommend_point){.error = NAN};
    }
}

static bool any_reached(const work *w) {
    for (size_t i = 0; i < w->made->methods; i++)
        if (w->made->method[i].reached)
            return true;
    return false;
}

static void say_shortened(work *w, double horizon, int next) {
    dl_recommendation *const made = w->made;
    if (horizon > 0)
        snprintf(
            made->shortened, sizeof made->shortened,
            "by t = %.4g rounding alone has spoilt every trajectory in double precision, and no "
            "position error means anything",
            horizon);
    else if (next > 0 && !any_reached(w))
        snprintf(made->shortened, sizeof made->shortened,
                 "nothing reached the error on it, so that none was made longer");
    else if (next > 0)
        snprintf(made->shortened, sizeof made->shortened,
                 "a longer run was not expected to be over within %g s", w->request->seconds);
}

/* The first length whose reference can be had before the horizon. */
static dl_status first_reference(work *w, int *k, double *horizon, dl_error *error) {
    double found;
    for (;; ++*k) {
        set_length(w, *k);
        const dl_status status = make_reference(w, w->made->error, &found, error);
        if (status == DL_OK && found == 0)
            return DL_OK;
        if (status != DL_OK && status != DL_TIMEOUT)
            return status;
        if (found > 0)
            *horizon = found;
        if (*k < most_lengths && length_of(w, *k + 1) < length_of(w, *k) &&
            length_of(w, *k + 1) >= least_steps * w->study->scene->scene->step &&
            dl_recommend_clock() < w->run.deadline)
            continue;
        return found > 0 ? dl_fail(error, DL_UNSTABLE,
                                   "the horizon, t = %.4g, is too near: no position error means "
                                   "anything (--in energy)",
                                   found)
                         : dl_fail(error, DL_TIMEOUT,
                                   "a reference for positions to t = %.4g takes longer than %g s "
                                   "allow (more --seconds, or --in energy, which needs none)",
                                   w->run.end, w->request->seconds);
    }
}

/* One more length, kept where it was finished; *k is it then. *too_long: it has no reference, or
 * one with a horizon. */
static dl_status lengthen(work *w, int *k, int next, double *horizon, bool *too_long,
                          dl_error *error) {
    const size_t size = w->made->methods * sizeof *w->made->method;
    dl_recommended *const tried = malloc(size + 1);
    bool cut = false;
    double found = 0;
    if (!tried)
        return dl_fail_memory(error, "methods");
    memcpy(tried, w->made->method, size);
    dl_reference before = w->reference;
    w->reference = (dl_reference){0};
    set_length(w, next);
    dl_status status = make_reference(w, w->made->error, &found, error);
    *too_long = status == DL_TIMEOUT || found > 0;
    if (status == DL_OK && !*too_long)
        status = search_all(w, tried, false, &cut, error);
    if (status == DL_OK && !*too_long && !cut) {
        memcpy(w->made->method, tried, size);
        *k = next;
        dl_reference_release(&before);
    } else {
        set_length(w, *k);
        dl_reference_release(&w->reference);
        w->reference = before;
    }
    if (found > 0)
        *horizon = found;
    free(tried);
    return status == DL_TIMEOUT ? DL_OK : status;
}

/* From the shortest on to the longest that can be had in time. */
static dl_status lengthen_all(work *w, int *k, double *horizon, double spent, dl_error *error) {
    dl_status status = DL_OK;
    bool too_long = false;
    for (int longest = *horizon > 0 ? *k : 0; *k > longest && any_reached(w);) {
        const int before = *k, next = next_length(w, *k, longest, spent);
        if (next == *k)
            break;
        drop_costly(w, next);
        const double began = dl_recommend_clock();
        status = lengthen(w, k, next, horizon, &too_long, error);
        if (status != DL_OK || (*k == before && !too_long))
            break;
        if (too_long)
            longest = next + 1;
        else
            spent = dl_recommend_clock() - began;
    }
    return status;
}

static dl_status measure(work *w, dl_error *error) {
    int k = first_length(w);
    const double began = dl_recommend_clock();
    double horizon = 0;
    bool cut = false;
    w->run.deadline = w->began + first_share * w->request->seconds;
    dl_status status = first_reference(w, &k, &horizon, error);
    if (status == DL_OK)
        status = search_all(w, w->made->method, false, &cut, error);
    w->run.deadline = w->began + w->request->seconds;
    if (status == DL_OK && !cut)
        status = lengthen_all(w, &k, &horizon, dl_recommend_clock() - began, error);
    say_shortened(w, horizon, k);
    w->made->measured_to = w->run.end;
    w->made->horizon = horizon;
    return status;
}

/* The shortened run's answer, for itself alone. */
static void settle_for_part(work *w, const dl_recommended *method, const char *why) {
    memcpy(w->made->method, method, w->made->methods * sizeof *method);
    w->made->part_only = why;
    for (size_t i = 0; i < w->made->methods; i++) {
        w->made->method[i].growth = 0;
        w->made->method[i].target = w->made->error;
    }
}

/* For the whole run, what is asked of the shortened one; where that is too much, or past the
 * horizon, only what is asked for. */
static dl_status aim_at_whole(work *w, dl_error *error) {
    const double aim = w->made->error * pow(share_of(w), asks_position(w) ? 2 : 0);
    const size_t size = w->made->methods * sizeof *w->made->method;
    double horizon;
    bool cut;
    if (w->run.end >= w->made->end || !any_reached(w))
        return DL_OK;
    dl_recommended *const before = malloc(size + 1);
    if (!before)
        return dl_fail_memory(error, "methods");
    memcpy(before, w->made->method, size);
    const bool far = asks_position(w) && share_of(w) * farthest < 1 - 1e-9;
    dl_status status = DL_OK;
    if (w->made->horizon > 0) {
        settle_for_part(w, before, "past the horizon its positions mean nothing");
    } else if (far) {
        settle_for_part(w, before, "it is too long to tell its error from that");
    } else {
        if (asks_position(w) && w->reference.error * DL_REFERENCE_MARGIN > resolvable(w, aim))
            status = make_reference(w, aim, &horizon, error);
        if (status == DL_OK || status == DL_TIMEOUT)
            status = search_all(w, w->made->method, true, &cut, error);
        if (status == DL_OK && !any_reached(w))
            settle_for_part(w, before, "none was small enough there for the whole");
    }
    free(before);
    return status;
}

/* --- the order ---------------------------------------------------------------------------------
 */

static int in_order(const void *a, const void *b) {
    const dl_recommended *x = a, *y = b;
    if (x->reached != y->reached)
        return x->reached ? -1 : 1;
    const double p = x->reached ? x->point.cpu_seconds : x->point.error;
    const double q = y->reached ? y->point.cpu_seconds : y->point.error;
    if (isnan(p) || isnan(q))
        return isnan(p) - isnan(q);
    return (p > q) - (p < q);
}

static void sort(work *w) {
    qsort(w->made->method, w->made->methods, sizeof *w->made->method, in_order);
    w->made->reached = 0;
    while (w->made->reached < w->made->methods && w->made->method[w->made->reached].reached)
        w->made->reached++;
}

static dl_status time_the_close(work *w, dl_error *error) {
    dl_status status = DL_OK;
    const dl_recommended *first = &w->made->method[0];
    const double cheapest = first->point.cpu_seconds;
    w->run.cheapest = cheapest;
    for (size_t i = 0; i < w->made->reached && status == DL_OK; i++) {
        dl_recommended *const m = &w->made->method[i];
        if (m->point.cpu_seconds > close_by * cheapest)
            continue;
        const double repeats = fmin(most_repeats, repeat_seconds / m->point.cpu_seconds);
        status = dl_recommend_time(&w->run, m, (long)fmax(3, repeats), error);
    }
    return status;
}

static dl_status expect_whole(work *w, dl_recommended *m, dl_error *error) {
    const double times = 1 / share_of(w);
    m->full_cpu_seconds = m->point.cpu_seconds * times;
    m->full_force_evaluations = (double)m->point.force_evaluations * times;
    m->full_error = w->made->part_only ? NAN : m->point.error * pow(times, m->growth);
    return dl_recommend_command(&w->run, m, w->made->end, error);
}

static dl_status conclude(work *w, dl_error *error) {
    dl_status status = DL_OK;
    sort(w);
    if (w->made->reached) {
        status = time_the_close(w, error);
        sort(w);
    }
    for (size_t i = 0; i < w->made->reached && status == DL_OK; i++)
        status = expect_whole(w, &w->made->method[i], error);
    if (w->run.reference)
        w->made->reference_error = w->reference.error;
    return status;
}

dl_status dl_recommend(const dl_recommend_request *request, dl_recommendation *made,
                       dl_error *error) {
    work w = {.request = request, .made = made, .began = dl_recommend_clock()};
    *made = (dl_recommendation){0};
    dl_status status = check_request(request, error);
    if (status == DL_OK)
        status = begin(&w, error);
    if (status == DL_OK)
        status = measure(&w, error);
    if (status == DL_OK)
        status = aim_at_whole(&w, error);
    if (status == DL_OK)
        status = conclude(&w, error);
    dl_reference_release(&w.reference);
    dl_study_free(w.study);
    free(w.dropped);
    if (status)
        dl_recommendation_release(made);
    return status;
}

void dl_recommendation_release(dl_recommendation *made) {
    free(made->method);
    *made = (dl_recommendation){0};
}
