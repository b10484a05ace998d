/* The methods that a recommendation is made from. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "study/recommend.h"

/* Of every family those that the studies found cheapest somewhere, the strong ones first: what
 * costs many times the cheapest so far is stopped early. */
static const struct choice {
    const char *method, *variant;
} choices[] = {
    {"composition-8-kahan-li", ""},
    {"rkn-6-blanes-moan-14", ""},
    {"rkn-4-blanes-moan", ""},
    {"splitting-6-blanes-moan", ""},
    {"splitting-4-blanes-moan", ""},
    {"composition-6-kahan-li", ""},
    {"composition-4-suzuki", ""},
    {"composition-10-sofroniou-spaletta", ""},
    {"leapfrog", ""},
    {"gsl-rk8pd", ""},
    {"gauss-radau-15", ""},
    {"arkode-erk", "table=dormand-prince-5"},
    {"arkode-erk", "table=verner-6"},
    {"arkode-erk", "table=fehlberg-8"},
    {"cvode-adams", ""},
    {"gsl-msadams", ""},
    {"gauss-6", ""},
    {"conserving-fixed-point", ""},
    {"conserving-newton-klu", ""},
    {"conserving-4-suzuki", ""},
    {"cvode-bdf-klu", ""},
};
enum { choice_count = sizeof choices / sizeof *choices, most_methods = 64 };

static dl_status add(const char *name, const char *variant, dl_recommendation *made,
                     dl_error *error) {
    dl_recommended *const added = &made->method[made->methods];
    *added = (dl_recommended){.point = {.error = NAN}};
    snprintf(added->variant, sizeof added->variant, "%s", variant);
    const dl_status status = dl_method_find(name, &added->row, error);
    made->methods += !status;
    return status;
}

/* One that is named, in every variant of the choice. */
static dl_status add_named(const char *name, dl_recommendation *made, dl_error *error) {
    bool chosen = false;
    dl_status status = DL_OK;
    for (size_t i = 0; i < made->methods; i++)
        if (strcmp(made->method[i].row->name, name) == 0)
            return dl_fail(error, DL_INPUT, "found %s twice", name);
    if (made->methods + choice_count > most_methods)
        return dl_fail(error, DL_INPUT, "found too many, expected at most %d",
                       most_methods - choice_count);
    for (size_t i = 0; i < choice_count && !status; i++)
        if (strcmp(choices[i].method, name) == 0) {
            chosen = true;
            status = add(name, choices[i].variant, made, error);
        }
    return status || chosen ? status : add(name, "", made, error);
}

static dl_status add_list(const char *names, dl_recommendation *made, dl_error *error) {
    dl_status status = DL_OK;
    for (const char *at = names; !status; at++) {
        char name[64];
        const size_t length = strcspn(at, ",");
        snprintf(name, sizeof name, "%.*s", (int)length, at);
        dl_error reason = {""};
        status = length == 0 ? dl_fail(&reason, DL_INPUT,
                                       "found an empty name, expected names of methods with commas "
                                       "between")
                             : add_named(name, made, &reason);
        if (status)
            return dl_fail(error, status, "methods: %.900s", reason.message);
        at += length;
        if (!*at)
            break;
    }
    return status;
}

dl_status dl_recommend_methods(const char *names, dl_recommendation *made, dl_error *error) {
    made->methods = 0;
    made->method = calloc(most_methods, sizeof *made->method);
    if (!made->method)
        return dl_fail_memory(error, "methods");
    if (names)
        return add_list(names, made, error);
    dl_status status = DL_OK;
    for (size_t i = 0; i < choice_count && !status; i++)
        status = add(choices[i].method, choices[i].variant, made, error);
    return status;
}
