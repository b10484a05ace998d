/* The search for the coarsest step, or tolerance, of a method that reaches an error. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include "study/recommend.h"

enum { most_points = 16, most_samples = 64, least_samples = 4, finest_tolerance = 42 };

/* Neighbours in the search nearer than this are near enough. */
static const double near_enough = 1.25;
/* A point that confirms another is this much finer. */
static const double finer_enough = 1.5;
/* CPU seconds that a run is always given. */
static const double shortest = 0.2;

static double seconds_of(struct timeval time) {
    return (double)time.tv_sec + 1e-6 * (double)time.tv_usec;
}

static double used_by(int who) {
    struct rusage used;
    return getrusage(who, &used) == 0 ? seconds_of(used.ru_utime) + seconds_of(used.ru_stime) : 0;
}

double dl_recommend_clock(void) {
    return used_by(RUSAGE_SELF) + used_by(RUSAGE_CHILDREN);
}

dl_recommend_dial dl_recommend_dial_of(const dl_method_row *row) {
    const bool adaptive = (row->flags & DL_ADAPTIVE) != 0;
    if (adaptive && dl_parameter_find(row->options, "rtol"))
        return (dl_recommend_dial){"rtol", true, 1};
    if (adaptive && dl_parameter_find(row->options, "epsilon"))
        return (dl_recommend_dial){"epsilon", true, 2};
    if (!adaptive && dl_parameter_find(row->options, "step"))
        return (dl_recommend_dial){"step", false, row->order > 0 ? row->order : 2};
    return (dl_recommend_dial){0};
}

double dl_recommend_value(const dl_recommend_point *point) {
    const char *sign = strchr(point->setting, '=');
    return sign ? strtod(sign + 1, NULL) : NAN;
}

/* --- places on the dial: numbers that grow as it gets finer ------------------------------------
 * Of steps how many make up the run; of tolerances how many times 1, 5, 2, 1 ... has been gone
 * down. */

typedef struct search {
    dl_recommend_run *run;
    dl_recommended *method;
    dl_recommend_dial dial;
    size_t count;
    long place[most_points];
    dl_recommend_point point[most_points];
    long coarsest; /* place */
    char refused[DL_MESSAGE_SIZE];
} search;

static double fineness(const search *s, double place) {
    return s->dial.tolerance ? pow(10, place / 3) : place;
}

static long common_multiple(long a, long b) {
    long x = a, y = b;
    while (y) {
        const long rest = x % y;
        x = y;
        y = rest;
    }
    return a / x * b;
}

/* Numbers of steps are multiples of this: samples of positions are at the reference's times. */
static long quantum(const search *s) {
    return s->run->reference ? common_multiple((long)s->run->parts, least_samples)
                             : (long)s->run->parts;
}

static long place_of(const search *s, double fine) {
    if (s->dial.tolerance)
        return (long)fmin(finest_tolerance, fmax(0, round(3 * log10(fine))));
    const double of = (double)quantum(s);
    return (long)(fmin(1e15, ceil(fine / of * (1 - 1e-9))) * of);
}

static double value_at(const search *s, long place) {
    static const double mantissa[] = {1, 0.5, 0.2};
    const long decades = place / 3;
    return s->dial.tolerance ? mantissa[place % 3] * pow(10, (double)-decades)
                             : s->run->end / (double)place;
}

static long place_at(const search *s, double value) {
    return place_of(s, s->dial.tolerance ? 1 / value : s->run->end / value);
}

/* Of a point that was run. */
static long place_of_point(const search *s, const dl_recommend_point *point) {
    const double value = dl_recommend_value(point);
    return s->dial.tolerance ? place_at(s, value) : lround(s->run->end / value);
}

/* --- one run -----------------------------------------------------------------------------------
 */

typedef struct setting {
    size_t count;
    double number; /* the step or tolerance */
    char key[3][32], value[3][40];
} setting;

/* 0.07 rather than 0.06999999999999999. */
static void format_step(double step, char *text, size_t size) {
    for (int digits = 2; digits <= 17; digits++) {
        snprintf(text, size, "%.*g", digits, step);
        if (fabs(strtod(text, NULL) - step) <= 4 * DBL_EPSILON * step)
            return;
    }
}

static setting setting_of(const search *s, double value) {
    setting made = {.number = value};
    const char *variant = s->method->variant;
    if (*variant) {
        const size_t length = strcspn(variant, "=");
        snprintf(made.key[0], sizeof *made.key, "%.*s", (int)length, variant);
        snprintf(made.value[0], sizeof *made.value, "%s", variant + length + 1);
        made.count = 1;
    }
    snprintf(made.key[made.count], sizeof *made.key, "%s", s->dial.key);
    if (s->dial.tolerance)
        snprintf(made.value[made.count], sizeof *made.value, "%g", value);
    else
        format_step(value, made.value[made.count], sizeof *made.value);
    made.count++;
    if (s->dial.tolerance && dl_parameter_find(s->method->row->options, "atol")) {
        snprintf(made.key[made.count], sizeof *made.key, "atol");
        snprintf(made.value[made.count], sizeof *made.value, "%.1g", value * s->run->atol);
        made.count++;
    }
    return made;
}

/* Without the variant. */
static void say(const search *s, const setting *set, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = *s->method->variant ? 1 : 0; i < set->count && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s=%s", used ? " " : "", set->key[i],
                                 set->value[i]);
}

/* At most `samples` of a run to `end`; of energy they need not fill it, but are whole steps. */
static void set_samples(const search *s, double end, double step, long samples) {
    dl_study *const study = s->run->study;
    dl_study_scene *const on = &study->scene[0];
    on->end = end;
    on->sample = end / (double)samples;
    study->settings.samples = samples;
    if (s->run->reference || s->dial.tolerance)
        return;
    const size_t steps = dl_whole_steps(end, step), most = (size_t)samples;
    const size_t each = (steps + most - 1) / most;
    if (steps == 0)
        return;
    on->sample = (double)each * step;
    study->settings.samples = (long)((steps + each - 1) / each);
}

static dl_status prepare(const search *s, const setting *set, dl_study_run_of *made,
                         dl_error *error) {
    static const int no_lines[4] = {0};
    const char *key[3], *value[3];
    for (size_t i = 0; i < set->count; i++) {
        key[i] = set->key[i];
        value[i] = set->value[i];
    }
    return dl_study_prepare(s->run->study, &s->run->study->scene[0], s->method->row, set->count,
                            key, value, no_lines, made, error);
}

/* CPU time: of what is left a part, so that other methods have theirs, and no more than a method
 * may take that is to be the cheapest. */
static double seconds_for_one(const dl_recommend_run *run) {
    const double left = fmax(0.05, run->deadline - dl_recommend_clock());
    const double part = isfinite(run->cheapest)
                            ? fmin(DL_RECOMMEND_HOPELESS * run->cheapest, left / 4)
                            : left / (2 * (double)run->methods_left);
    return fmin(left, fmax(shortest, part));
}

static dl_status measure_with(search *s, const setting *set, long samples, dl_case *measured,
                              dl_error *error) {
    const dl_recommend_run *run = s->run;
    char key[] = "", command[] = "";
    dl_study_case cased = {.key = key, .command = command};
    set_samples(s, run->end, set->number, samples);
    dl_status status = prepare(s, set, &cased.run, error);
    if (status)
        return status;
    run->study->limits.seconds = seconds_for_one(run);
    status = dl_study_measure_case(run->study, &cased, run->reference, run->watch, measured, error);
    dl_study_run_of_release(&cased.run);
    return status;
}

static void take(const search *s, const dl_case *measured, dl_recommend_point *point) {
    const dl_run_summary *ran = &measured->summary;
    const double error = dl_case_bound(measured, s->run->in, s->run->reference);
    point->error = isfinite(error) ? error : NAN;
    point->cpu_seconds = ran->cpu_seconds;
    point->force_evaluations = ran->force_evaluations;
    point->steps = ran->steps;
    point->note[0] = '\0';
    if (ran->status)
        snprintf(point->note, sizeof point->note, "%s: %.200s", dl_status_name(ran->status),
                 ran->message);
    else if (!isfinite(error))
        snprintf(point->note, sizeof point->note, "%.250s",
                 *measured->invalid ? measured->invalid : measured->refused);
}

/* An adaptive run whose samples choose its steps is made with fewer. */
static dl_status measure(search *s, long place, dl_recommend_point *point, dl_error *error) {
    const setting set = setting_of(s, value_at(s, place));
    say(s, &set, point->setting, sizeof point->setting);
    snprintf(s->run->current, 200, "%s %s %s", s->method->row->name, s->method->variant,
             point->setting);
    for (long samples = s->run->reference ? least_samples : most_samples;; samples /= 4) {
        dl_case measured = {0};
        const dl_status status = measure_with(s, &set, samples, &measured, error);
        if (status)
            return status;
        take(s, &measured, point);
        const bool again = s->dial.tolerance && *measured.invalid && samples > least_samples;
        dl_case_release(&measured);
        if (!again)
            return DL_OK;
    }
}

/* --- the search --------------------------------------------------------------------------------
 */

static const dl_recommend_point *at(const search *s, long place) {
    for (size_t i = 0; i < s->count; i++)
        if (s->place[i] == place)
            return &s->point[i];
    return NULL;
}

static bool meets(const search *s, const dl_recommend_point *point) {
    return point->error <= s->method->target;
}

static bool timed_out(const dl_recommend_point *point) {
    return strncmp(point->note, "timeout", strlen("timeout")) == 0;
}

/* The finest that misses, the coarsest finer one that meets; 0: none, which no place of steps is,
 * and -1 of tolerances. */
typedef struct bracket {
    const dl_recommend_point *misses, *meets;
    long low, high;
} bracket;

static bracket bracket_of(const search *s) {
    bracket found = {0};
    for (size_t i = 0; i < s->count; i++)
        if (!meets(s, &s->point[i]) && !timed_out(&s->point[i]) &&
            (!found.misses || s->place[i] > found.low)) {
            found.misses = &s->point[i];
            found.low = s->place[i];
        }
    for (size_t i = 0; i < s->count; i++)
        if (meets(s, &s->point[i]) && (!found.misses || s->place[i] > found.low) &&
            (!found.meets || s->place[i] < found.high)) {
            found.meets = &s->point[i];
            found.high = s->place[i];
        }
    return found;
}

static double clamp(double value, double least, double most) {
    return value > least ? fmin(value, most) : least; /* NaN: the least */
}

/* By which to refine from an error to somewhat less than the one asked for, or to roundoff. */
static double factor(const search *s, double error) {
    const double aim = fmax(0.5 * s->method->target, DBL_EPSILON * s->run->scale);
    return pow(error / aim, 1 / s->dial.order);
}

static long finer(const search *s, long from, const dl_recommend_point *point) {
    const double by = isfinite(point->error)
                          ? clamp(factor(s, point->error), 2, s->dial.tolerance ? 1000 : 16)
                          : 4;
    const long place = place_of(s, fineness(s, (double)from) * by);
    return place > from ? place : from + 1;
}

static long coarser(const search *s, long from, const dl_recommend_point *point) {
    const double by = point->error > 0
                          ? clamp(1 / factor(s, point->error), 2, s->dial.tolerance ? 1000 : 16)
                          : 16;
    const long place = place_of(s, fineness(s, (double)from) / by);
    return place > s->coarsest ? place : s->coarsest;
}

/* Between the two, where the line through the logarithms of both errors meets what is asked. */
static long between(const search *s, const bracket *b) {
    const double low = log(fineness(s, (double)b->low)), high = log(fineness(s, (double)b->high));
    double part = 0.5;
    if (isfinite(b->misses->error) && b->meets->error > 0)
        part = log(b->misses->error / (0.8 * s->method->target)) /
               log(b->misses->error / b->meets->error);
    const long place = place_of(s, exp(low + clamp(part, 0.1, 0.9) * (high - low)));
    if (!s->dial.tolerance)
        return place;
    return place <= b->low ? b->low + 1 : (place >= b->high ? b->high - 1 : place);
}

/* Whether refining made no difference from one point to the next. */
static bool made_no_difference(const search *s, size_t from) {
    return s->point[from + 1].error > 0.7 * s->point[from].error &&
           s->place[from + 1] > s->place[from];
}

/* Of large errors, which need not follow the order yet, it must have made none twice. */
static bool is_stuck(const search *s) {
    const double small = 1e-10 * s->run->scale;
    if (s->count < 2 || !made_no_difference(s, s->count - 2))
        return false;
    return s->point[s->count - 1].error < small ||
           (s->count >= 3 && made_no_difference(s, s->count - 3));
}

/* The finer point that an answer is confirmed by: where a force jumps, an error may be small by
 * chance. */
static long confirming(const search *s, long place) {
    long found = -1;
    for (size_t i = 0; i < s->count; i++)
        if (fineness(s, (double)s->place[i]) >= finer_enough * fineness(s, (double)place) &&
            (found < 0 || s->place[i] < found))
            found = s->place[i];
    return found;
}

/* Where to run it; -1 where it was, or cannot be. */
static long confirm(const search *s, long place) {
    const long next = s->dial.tolerance ? place + 1 : 2 * place;
    const bool done = confirming(s, place) >= 0 || s->count == most_points ||
                      (s->dial.tolerance && next > finest_tolerance);
    return done ? -1 : next;
}

/* The next place; -1 at the end, with the reason where nothing has reached the error. */
static long next_place(search *s, long last) {
    const bracket b = bracket_of(s);
    char *const reason = s->method->reason;
    const size_t size = sizeof s->method->reason;
    const dl_recommend_point *point = &s->point[s->count - 1];
    if (!b.meets && (timed_out(point) || !b.misses)) {
        snprintf(reason, size, "stopped at %s, where it %s", point->setting,
                 isfinite(s->run->cheapest) ? "took many times the cheapest's time"
                                            : "took more time than there is for a run");
        return -1;
    }
    if (!b.meets) {
        if (is_stuck(s))
            snprintf(reason, size, "its error falls no further");
        else if (s->count == most_points || (s->dial.tolerance && last >= finest_tolerance))
            snprintf(reason, size, "not reached with %s", point->setting);
        return *reason ? -1 : finer(s, b.low, b.misses);
    }
    if (!b.misses)
        return b.high > s->coarsest && s->count < most_points ? coarser(s, b.high, b.meets)
                                                              : confirm(s, b.high);
    if (s->count < most_points &&
        fineness(s, (double)b.high) > near_enough * fineness(s, (double)b.low) &&
        !(s->dial.tolerance && b.high <= b.low + 1)) {
        const long place = between(s, &b);
        if (place > b.low && place < b.high)
            return place;
    }
    return confirm(s, b.high);
}

static void keep_neighbours(const search *s, const bracket *b) {
    dl_recommended *const method = s->method;
    const long fine = confirming(s, b->high);
    long coarse = -1;
    for (size_t i = 0; i < s->count; i++)
        if (s->place[i] < b->high && s->place[i] > coarse)
            coarse = s->place[i];
    method->point = *b->meets;
    method->reached = true;
    method->coarser = coarse < 0 ? (dl_recommend_point){0} : *at(s, coarse);
    method->finer = fine < 0 ? (dl_recommend_point){0} : *at(s, fine);
}

static void keep_nearest(const search *s) {
    dl_recommended *const method = s->method;
    for (size_t i = 0; i < s->count; i++)
        if (i == 0 || s->point[i].error < method->point.error || isnan(method->point.error))
            method->point = s->point[i];
    if (!*method->reason && *s->refused)
        snprintf(method->reason, sizeof method->reason, "%.500s", s->refused);
    else if (*method->point.note && !timed_out(&method->point))
        snprintf(method->reason + strlen(method->reason),
                 sizeof method->reason - strlen(method->reason), "; %.240s", method->point.note);
}

static void conclude(search *s) {
    s->method->reached = false;
    s->method->point = s->method->coarser = s->method->finer = (dl_recommend_point){.error = NAN};
    const bracket b = bracket_of(s);
    if (!b.meets) {
        keep_nearest(s);
        return;
    }
    keep_neighbours(s, &b);
    s->run->cheapest = fmin(s->run->cheapest, s->method->point.cpu_seconds);
}

static search begin(dl_recommend_run *run, dl_recommended *method) {
    search s = {.run = run, .method = method, .dial = dl_recommend_dial_of(method->row)};
    const double step = run->study->scene[0].scene->step;
    if (!s.dial.key || s.dial.tolerance)
        s.coarsest = 3; /* rtol and epsilon are at most 0.1 */
    else if (!run->reference && method->row->flags & DL_CONSERVES_ENERGY && step > 0)
        s.coarsest = place_at(&s, step); /* it conserves energy at any step */
    else
        s.coarsest = place_of(&s, 1);
    return s;
}

dl_status dl_recommend_search(dl_recommend_run *run, dl_recommended *method, double start,
                              bool *ended, dl_error *error) {
    search s = begin(run, method);
    dl_status status = DL_OK;
    *ended = false;
    method->reached = method->reached && method->point.error <= method->target;
    method->reason[0] = '\0';
    if (!s.dial.key) {
        snprintf(method->reason, sizeof method->reason, "it has neither a step nor a tolerance");
        return DL_OK;
    }
    long place = place_at(&s, start);
    for (place = place > s.coarsest ? place : s.coarsest; place >= 0 && !*ended;
         place = next_place(&s, place)) {
        *ended = dl_recommend_clock() >= run->deadline;
        if (*ended || at(&s, place))
            break;
        dl_error why = {""};
        status = measure(&s, place, &s.point[s.count], &why);
        if (status == DL_INPUT) {
            snprintf(s.refused, sizeof s.refused, "%s", why.message);
            status = DL_OK;
            break;
        }
        if (status)
            return dl_fail(error, status, "%s", why.message);
        s.place[s.count++] = place;
    }
    if (s.count > 0 || *s.refused)
        conclude(&s);
    if (!method->reached && !*method->reason)
        snprintf(method->reason, sizeof method->reason,
                 *ended ? "the time was used up" : "not reached");
    return status;
}

/* --- afterwards --------------------------------------------------------------------------------
 */

dl_status dl_recommend_time(dl_recommend_run *run, dl_recommended *method, long repeats,
                            dl_error *error) {
    search s = begin(run, method);
    dl_recommend_point again = {0};
    run->study->settings.repeats = repeats;
    const dl_status status = measure(&s, place_of_point(&s, &method->point), &again, error);
    run->study->settings.repeats = 1;
    if (!status && !*again.note && again.cpu_seconds < method->point.cpu_seconds)
        method->point.cpu_seconds = again.cpu_seconds;
    return status;
}

dl_status dl_recommend_command(dl_recommend_run *run, dl_recommended *method, double end,
                               dl_error *error) {
    search s = begin(run, method);
    dl_study_case cased = {0};
    const setting set = setting_of(&s, value_at(&s, place_of_point(&s, &method->point)));
    set_samples(&s, run->end, set.number, least_samples);
    const dl_status status = prepare(&s, &set, &cased.run, error);
    if (status)
        return status;
    set_samples(&s, end, set.number, s.run->reference ? least_samples : most_samples);
    char *command = dl_study_case_command(run->study, &cased);
    dl_study_run_of_release(&cased.run);
    if (!command)
        return dl_fail_memory(error, "a command");
    snprintf(method->command, sizeof method->command, "%s", command);
    free(command);
    return DL_OK;
}
