/* Fabricated studies for the report's tests: no integration behind them. */
#ifndef DL_TESTS_FIXTURE_REPORT_H
#define DL_TESTS_FIXTURE_REPORT_H

#include <math.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/results.h"

#define FIXTURE_ATTACK "</script><script>throw 1</script> <!--<script> & \"quoted\" 'single'"

/* A method that loses `order` digits a decade of its step. */
typedef struct fixture_method {
    const char *name, *family;
    int order;
    double constant; /* error at step 1 */
    double cost;     /* seconds a step */
    unsigned long forces;
    double energy_floor;
} fixture_method;

static const fixture_method fixture_methods[] = {
    {"leapfrog", "leap-frog", 2, 40, 1.2e-5, 1, 1e-13},
    {"composition-4-forest-ruth", "composition", 4, 9e3, 3.4e-5, 3, 1e-13},
    {"composition-6-yoshida", "composition", 6, 4e5, 8.1e-5, 7, 1e-14},
    {"composition-8-kahan-li", "composition", 8, 2e6, 2e-4, 17, 1e-14},
    {"arkode-erk", "ARKODE", 4, 3e3, 5.5e-5, 4, 1e-14},
    {"cvode-adams", "CVODE", 5, 2e4, 4e-5, 2, 1e-14},
    {"cvode-bdf", "CVODE", 3, 2e3, 9e-5, 2, 1e-14},
    {"gsl-rk8pd", "GSL", 8, 6e6, 1.6e-4, 13, 1e-15},
    {"gsl-msadams", "GSL", 6, 7e5, 7e-5, 2, 1e-14},
    {"conserving-newton", "conserving", 2, 25, 1.5e-4, 4, 2e-16},
};

#define FIXTURE_METHODS (sizeof fixture_methods / sizeof *fixture_methods)
#define FIXTURE_SAMPLES 51

static char *fixture_text(const char *format, ...) __attribute__((format(printf, 1, 2)));

static char *fixture_text(const char *format, ...) {
    char buffer[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(buffer, sizeof buffer, format, arguments);
    va_end(arguments);
    return strdup(buffer);
}

static double *fixture_samples(size_t count, double (*value)(double, double), double scale) {
    double *values = malloc(count * sizeof *values);
    for (size_t i = 0; values && i < count; i++)
        values[i] = value((double)i / (double)(count - 1), scale);
    return values;
}

static double fixture_time(double u, double end) {
    return u * end;
}

static double fixture_wobble(double u, double scale) {
    return scale * sin(40 * u) * (0.4 + 0.6 * u);
}

static double fixture_growth(double u, double scale) {
    return scale * u * u;
}

static void fixture_add(dl_results *results, dl_case cased) {
    if (dl_results_add_case(results, &cased, NULL) != DL_OK)
        abort();
}

/* A case that ended well. `samples` may be 0. */
static dl_case fixture_case(const char *scene, const fixture_method *method, const char *key,
                            double value, size_t samples) {
    bool adaptive = strcmp(key, "rtol") == 0;
    double step = adaptive ? 0.4 * pow(value, 1.0 / (method->order + 1)) : value;
    double error = 3e-12 + (adaptive ? 30 * method->order * value
                                     : method->constant * pow(step, method->order));
    double energy = error * 1e-2 + method->energy_floor;
    unsigned long steps = (unsigned long)ceil(1.0 / step);
    dl_case made = {
        .key = fixture_text("%s %s %s=%g", scene, method->name, key, value),
        .scene = fixture_text("%s", scene),
        .method = fixture_text("%s", method->name),
        .family = fixture_text("%s", method->family),
        .options = fixture_text("%s=%g solver=fixed-point iterations=10", key, value),
        .command = fixture_text("driftlab run scene.yaml --method %s --set %s=%g", method->name,
                                key, value),
        .refused = strdup(""),
        .invalid = strdup(""),
        .repeats = 3,
        .position_error = error,
        .position_error_max = 2.5 * error,
        .position_error_ever = error,
        .samples = samples,
        .summary = {.status = DL_OK,
                    .t_end_reached = 1,
                    .step = step,
                    .steps = steps,
                    .force_evaluations = steps * method->forces,
                    .cpu_seconds = (double)steps * method->cost,
                    .energy_initial = -3.25,
                    .energy_final = -3.25 + energy * 50,
                    .energy_scale = 50,
                    .energy_error_max = energy * 50,
                    .energy_error_final = -energy * 20,
                    .momentum_error_max = 1.7e-14,
                    .momentum_scale = 120,
                    .angular_momentum_error_max = NAN,
                    .angular_momentum_scale = NAN,
                    .samples = samples},
    };
    made.cpu_median = made.summary.cpu_seconds * 1.07;
    made.sample_time = samples ? fixture_samples(samples, fixture_time, 1) : NULL;
    made.sample_energy_error =
        samples ? fixture_samples(samples, fixture_wobble, energy * 50) : NULL;
    made.sample_position_error = samples ? fixture_samples(samples, fixture_growth, error) : NULL;
    made.sample_momentum_error = samples ? fixture_samples(samples, fixture_growth, 1.7e-14) : NULL;
    return made;
}

static void fixture_fail(dl_case *cased, dl_status status, const char *message) {
    cased->summary.status = status;
    snprintf(cased->summary.message, sizeof cased->summary.message, "%s", message);
    cased->position_error = cased->position_error_max = cased->position_error_ever = NAN;
    cased->summary.energy_error_max = INFINITY;
    cased->summary.t_end_reached = 0.3137;
}

static void fixture_refuse(dl_case *cased, const char *reason) {
    free(cased->refused);
    cased->refused = strdup(reason);
}

static dl_results *fixture_results(const char *title, double asked, const char *asked_in) {
    dl_results *results;
    if (dl_results_create(&results, NULL) != DL_OK)
        abort();
    free(results->study), free(results->title), free(results->kind), free(results->question),
        free(results->asked_in);
    results->study = strdup("fabricated");
    results->title = strdup(title);
    results->kind = strdup("work-precision");
    results->question =
        strdup("Which method reaches a position error of 1e-6 on the stream at the least cost?");
    results->asked_error = asked;
    results->asked_in = strdup(asked_in);
    const char *const facts[][2] = {
        {"command", "driftlab study studies/fabricated/study.yaml"},
        {"driftlab", "0.1.0"},
        {"compiler", "GNU 12.2.0 -O3"},
        {"machine", "x86_64, 2 cores, <Example & Sons> CPU @ 2.6 GHz"},
        {"sundials", "6.4.1"},
    };
    for (size_t i = 0; i < sizeof facts / sizeof *facts; i++)
        dl_results_add_fact(results, facts[i][0], facts[i][1], NULL);
    return results;
}

static void fixture_scene(dl_results *results, const char *name, double reference_error) {
    dl_scene_record scene = {
        .name = strdup(name),
        .source = strdup("TR171, Figs 3.2-3.5"),
        .explain = strdup("dimension 2, 34 particles, 68 unknowns\n"
                          "pair law: 1 piece, powers 7 and 10, no cutoff\n"
                          "left out: gravity, walls, pins\n"
                          "kernel: all pairs (34 < 64)\n"),
        .text = strdup("name: stream\ndimension: 2 # </script> & <b>\n"),
    };
    if (dl_results_add_scene(results, &scene, NULL) != DL_OK)
        abort();
    if (isnan(reference_error))
        return;
    dl_reference reference = {
        .key = fixture_text("%s reference", name),
        .scene = strdup(name),
        .description = strdup("gsl-rk8pd at rtol = 1e-14, checked by composition-8 at Δt = 1e-4."),
        .error = reference_error,
        .samples = FIXTURE_SAMPLES,
        .particles = 34,
        .dimension = 2,
        .time = fixture_samples(FIXTURE_SAMPLES, fixture_time, 1),
        .sample_error = fixture_samples(FIXTURE_SAMPLES, fixture_growth, reference_error),
        .position = calloc(FIXTURE_SAMPLES * 68, sizeof(double)),
    };
    if (dl_results_add_reference(results, &reference, NULL) != DL_OK)
        abort();
}

/* Ten methods at five steps on one scene, with every way of not being a point; three runs on a
 * second scene that has neither samples nor a reference. */
static inline dl_results *fixture_study(void) {
    dl_results *results = fixture_results("Stream & co: <which> method?", 1e-6, "position");
    fixture_scene(results, "stream", 2e-11);
    for (size_t m = 0; m < FIXTURE_METHODS; m++)
        for (int point = 0; point < 5; point++) {
            const fixture_method *method = &fixture_methods[m];
            bool adaptive = m >= 5 && m <= 8;
            double value = adaptive ? pow(10, -3 - 2 * point) : 0.04 / (1 << point);
            dl_case made =
                fixture_case("stream", method, adaptive ? "rtol" : "step", value, FIXTURE_SAMPLES);
            if (m == 0 && point == 0)
                fixture_fail(&made, DL_UNSTABLE,
                             "energy error 3.2e+07 of the scale at t = 0.3137 (step 8)");
            if (m == 9 && point < 2)
                fixture_fail(&made, DL_NONLINEAR_FAILURE,
                             FIXTURE_ATTACK
                             " the residual stalled at 3.1e-02 after 50 iterations, which is a "
                             "long message that has to be wrapped in a narrow table: "
                             "averyveryverylongwordwithoutanyspaceinitthatmustnotwidenthepage");
            if (m == 7 && point >= 3)
                fixture_refuse(&made, "error 3.0e-12 is below the reference's own 2.0e-11");
            if (m == 6 && point == 0)
                fixture_fail(&made, DL_TIMEOUT, "");
            if (m == 5 && point == 0)
                made.summary.energy_error_max = 0; /* exactly */
            fixture_add(results, made);
        }
    const char *second = "kepler <" FIXTURE_ATTACK ">";
    fixture_scene(results, second, NAN);
    for (size_t m = 0; m < 3; m++) {
        dl_case made = fixture_case(second, &fixture_methods[m], "step", 0.01, 0);
        made.position_error = made.position_error_max = made.position_error_ever = NAN;
        fixture_add(results, made);
    }
    return results;
}

static inline dl_results *fixture_one(void) {
    dl_results *results = fixture_results("One case", 0, "");
    fixture_scene(results, "alone", 0);
    fixture_add(results, fixture_case("alone", &fixture_methods[0], "step", 0.01, 0));
    return results;
}

static inline dl_results *fixture_all_failed(void) {
    dl_results *results = fixture_results("All failed", 1e-6, "position");
    fixture_scene(results, "stream", 2e-11);
    for (size_t m = 0; m < FIXTURE_METHODS; m++) {
        dl_case made = fixture_case("stream", &fixture_methods[m], "step", 0.1, 0);
        fixture_fail(&made, DL_STEP_FAILURE, "the step collapsed to 1e-19 at t = 0.3137");
        fixture_add(results, made);
    }
    return results;
}

/* 300 cases on lines that no two look alike. */
static inline dl_results *fixture_many(void) {
    dl_results *results = fixture_results("Three hundred cases", 1e-9, "energy");
    fixture_scene(results, "stream", 2e-11);
    for (int m = 0; m < 25; m++) {
        const fixture_method *base = &fixture_methods[(size_t)m % FIXTURE_METHODS];
        char name[64];
        snprintf(name, sizeof name, "%s-%d", base->name, m);
        fixture_method method = *base;
        method.name = name;
        method.cost *= pow(10, m / 2.0); /* more decades than an axis has room for */
        method.constant *= 1 + m;
        for (int point = 0; point < 12; point++)
            fixture_add(results, fixture_case("stream", &method, "step", 0.04 * pow(0.7, point),
                                              FIXTURE_SAMPLES));
    }
    return results;
}

static inline dl_results *fixture_empty(void) {
    return fixture_results("Nothing yet", 1e-6, "position");
}

#endif
