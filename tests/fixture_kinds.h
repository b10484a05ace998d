/* Units of studies measured in this process, with settings as a study file would give them. */
#ifndef FIXTURE_KINDS_H
#define FIXTURE_KINDS_H

#include "fixture_runs.h"
#include "study/kind.h"

/* Noise of unit variance, the same in every run of a test: SplitMix64 (Steele, Lea and Flood,
 * doi:10.1145/2660193.2660195) and the polar method. */
typedef struct noise {
    uint64_t state;
} noise;

RUNS_FIXTURE double noise_uniform(noise *of) {
    uint64_t z = of->state += UINT64_C(0x9e3779b97f4a7c15);
    z = (z ^ (z >> 30)) * UINT64_C(0xbf58476d1ce4e5b9);
    z = (z ^ (z >> 27)) * UINT64_C(0x94d049bb133111eb);
    return ldexp((double)((z ^ (z >> 31)) >> 11), -53);
}

RUNS_FIXTURE double noise_normal(noise *of) {
    double x, y, s;
    do {
        x = 2 * noise_uniform(of) - 1;
        y = 2 * noise_uniform(of) - 1;
        s = x * x + y * y;
    } while (s >= 1 || s == 0);
    return x * sqrt(-2 * log(s) / s);
}

/* First-order autoregressive noise of unit variance: value_k+1 = memory value_k + noise. */
RUNS_FIXTURE void noise_series(noise *of, double memory, size_t n, double *value) {
    double last = noise_normal(of);
    for (size_t k = 0; k < n; k++) {
        value[k] = last;
        last = memory * last + sqrt(1 - memory * memory) * noise_normal(of);
    }
}

typedef struct asked {
    const dl_study_kind *kind;
    const dl_scene *scene;
    const dl_method_row *row;
    const char *option;   /* of the method, "step=0.01"; "" or NULL: none */
    const char *setting;  /* of the kind, "levels=1 allow=0.1"; "" or NULL: none */
    double end, sample;   /* 0: the scene's end, the kind's number of samples */
    dl_run_function *run; /* NULL: dl_run */
} asked;

RUNS_FIXTURE void set_words(dl_parameter_table table, const char *words, void *object) {
    dl_error error = {""};
    char copy[256], *rest = NULL;
    snprintf(copy, sizeof copy, "%s", words ? words : "");
    for (char *word = strtok_r(copy, " ", &rest); word; word = strtok_r(NULL, " ", &rest)) {
        char *value = strchr(word, '=');
        assert_non_null(value);
        *value++ = '\0';
        const dl_parameter *row = dl_parameter_find(table, word);
        assert_non_null(row);
        if (dl_parameter_set(row, object, value, &error))
            fail_msg("%s", error.message);
    }
}

/* Checks and, where `finding` is not NULL, measures. */
RUNS_FIXTURE dl_status try_unit(const asked *what, dl_finding *finding, dl_error *error) {
    const dl_study_kind *kind = what->kind;
    void *options = options_of(what->row, what->scene, "");
    void *settings = calloc(1, kind->settings_size);
    assert_non_null(settings);
    set_words(what->row->options, what->option, options);
    assert_int_equal(dl_parameter_defaults(kind->settings, settings, error), DL_OK);
    set_words(kind->settings, what->setting, settings);
    const double end = what->end > 0 ? what->end : what->scene->end;
    const dl_study_unit unit = {.scene = what->scene,
                                .row = what->row,
                                .options = options,
                                .end = end,
                                .sample =
                                    what->sample > 0 ? what->sample : end / (double)kind->samples,
                                .sample_chosen = !(what->sample > 0),
                                .seconds = 100,
                                .settings = settings,
                                .run = what->run ? what->run : dl_run};
    dl_status status = kind->check(&unit, error);
    if (!status && finding)
        status = kind->measure(&unit, finding, error);
    dl_parameter_release(kind->settings, settings);
    free(settings);
    dl_method_options_free(what->row, options);
    return status;
}

/* What the kind says to a unit before it is measured. */
RUNS_FIXTURE dl_status refusal(const asked *what, dl_error *error) {
    return try_unit(what, NULL, error);
}

/* Fails the test where the unit is refused or its measurement fails. */
RUNS_FIXTURE dl_finding measure(const asked *what) {
    dl_error error = {""};
    dl_finding finding;
    if (dl_finding_create(&finding, &error) || try_unit(what, &finding, &error))
        fail_msg("%s", error.message);
    return finding;
}

/* A quantity of a finding; fails the test where it has none of that name. */
RUNS_FIXTURE const double *quantity(const dl_finding *finding, const char *name) {
    const double *value = dl_finding_quantity(finding, name);
    if (!value)
        fail_msg("no quantity \"%s\" among:\n%s\n%s: %s", name, finding->quantity_names,
                 finding->verdict, finding->reason);
    return value;
}

RUNS_FIXTURE void expect_verdict(const dl_finding *finding, const char *verdict,
                                 const char *words) {
    if (strcmp(finding->verdict, verdict) != 0 || !strstr(finding->reason, words))
        fail_msg("expected \"%s ... %s\", found \"%s: %s\"", verdict, words, finding->verdict,
                 finding->reason);
}

#endif
