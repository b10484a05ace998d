/* The answer of studies of one kind over all their scenes, in two sentences. */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/across.h"
#include "study/kind.h"

/* How a method does over the scenes. */
typedef struct standing {
    const char *method;
    size_t good;  /* scenes on which it has the verdict, or the quantity, that is asked for */
    double least; /* its smallest share of the largest such quantity of a scene */
} standing;

typedef struct survey {
    const dl_results *const *results;
    size_t count;
    const dl_study_kind *kind;
    size_t scenes, findings;
    standing *method; /* [methods], the best first */
    size_t methods;
} survey;

/* --- how methods stand ------------------------------------------------------------------------ */

static double merit_of(const survey *of, const dl_finding *finding) {
    const double *value = of->kind->merit ? dl_finding_quantity(finding, of->kind->merit) : NULL;
    if (value)
        return value[0];
    return of->kind->good && strcmp(finding->verdict, of->kind->good) == 0 ? 1 : NAN;
}

/* The largest merit on a scene, of one method or (NULL) of all; NaN: none. */
static double largest_merit(const survey *of, const dl_results *results, const char *scene,
                            const char *method) {
    double largest = NAN;
    for (size_t i = 0; i < results->findings; i++) {
        const dl_finding *finding = &results->finding[i];
        if (strcmp(finding->scene, scene) == 0 && (!method || strcmp(finding->method, method) == 0))
            largest = fmax(largest, merit_of(of, finding));
    }
    return largest;
}

static standing stand(const survey *of, const char *method) {
    standing found = {method, 0, INFINITY};
    for (size_t k = 0; k < of->count; k++)
        for (size_t s = 0; s < of->results[k]->scenes; s++) {
            const char *scene = of->results[k]->scene[s].name;
            const double own = largest_merit(of, of->results[k], scene, method);
            if (isnan(own))
                continue;
            found.good++;
            found.least = fmin(found.least, own / largest_merit(of, of->results[k], scene, NULL));
        }
    return found;
}

static int best_first(const void *left, const void *right) {
    const standing *a = left, *b = right;
    if (a->good != b->good)
        return a->good > b->good ? -1 : 1;
    return (a->least < b->least) - (a->least > b->least);
}

static bool is_known(const survey *of, const char *method) {
    for (size_t m = 0; m < of->methods; m++)
        if (strcmp(of->method[m].method, method) == 0)
            return true;
    return false;
}

/* Merits are compared by insertion, so that equals stay in the order of the studies. */
static void insert(survey *of, const char *method) {
    const standing added = stand(of, method);
    size_t at = of->methods++;
    for (; at > 0 && best_first(&of->method[at - 1], &added) > 0; at--)
        of->method[at] = of->method[at - 1];
    of->method[at] = added;
}

static void find_methods(survey *of) {
    for (size_t k = 0; k < of->count; k++)
        for (size_t i = 0; i < of->results[k]->findings; i++)
            if (!is_known(of, of->results[k]->finding[i].method))
                insert(of, of->results[k]->finding[i].method);
}

/* --- sentences -------------------------------------------------------------------------------- */

static size_t count_verdict(const survey *of, const char *verdict) {
    size_t found = 0;
    for (size_t k = 0; k < of->count; k++)
        for (size_t i = 0; i < of->results[k]->findings; i++)
            found += strcmp(of->results[k]->finding[i].verdict, verdict) == 0;
    return found;
}

static bool is_first_of_its_verdict(const survey *of, size_t study, size_t finding) {
    const char *verdict = of->results[study]->finding[finding].verdict;
    for (size_t k = 0; k <= study; k++)
        for (size_t i = 0; i < (k < study ? of->results[k]->findings : finding); i++)
            if (strcmp(of->results[k]->finding[i].verdict, verdict) == 0)
                return false;
    return true;
}

static void tell_verdicts(const survey *of, FILE *out) {
    const char *separator = ": ";
    fprintf(out, "%zu findings on %zu scenes", of->findings, of->scenes);
    for (size_t k = 0; k < of->count; k++)
        for (size_t i = 0; i < of->results[k]->findings; i++) {
            const char *verdict = of->results[k]->finding[i].verdict;
            if (!is_first_of_its_verdict(of, k, i))
                continue;
            fprintf(out, "%s%zu %s", separator, count_verdict(of, verdict),
                    *verdict ? verdict : "not measured");
            separator = ", ";
        }
    fputs(". ", out);
}

/* Methods that stand as the best one does. */
static void tell_good(const survey *of, FILE *out) {
    enum { most = 4 };
    const size_t good = of->methods > 0 ? of->method[0].good : 0;
    size_t alike = 0;
    while (alike < of->methods && of->method[alike].good == good)
        alike++;
    if (good == 0) {
        fprintf(out, "No method has \"%s\" anywhere", of->kind->good);
        return;
    }
    if (good == of->scenes)
        fprintf(out, "On all %zu scenes \"%s\" is found with ", of->scenes, of->kind->good);
    else
        fprintf(out, "On the most scenes, %zu, \"%s\" is found with ", good, of->kind->good);
    for (size_t m = 0; m < alike && m < most; m++)
        fprintf(out, "%s%s", m > 0 ? ", " : "", of->method[m].method);
    if (alike > most)
        fprintf(out, " and %zu more", alike - most);
}

static void tell_merit(const survey *of, FILE *out) {
    const standing *best = of->methods > 0 ? &of->method[0] : NULL;
    if (!best || best->good == 0)
        fprintf(out, "No method has a %s", of->kind->merit);
    else
        fprintf(out, "The %s is the largest, or %.2g of that at the least, with %s on %zu scene%s",
                of->kind->merit, best->least, best->method, best->good, best->good == 1 ? "" : "s");
}

static void tell_findings(survey *of, char *text, size_t size) {
    FILE *out = fmemopen(text, size, "w");
    text[0] = '\0';
    of->method = calloc(of->findings + 1, sizeof *of->method);
    if (out && of->method) {
        find_methods(of);
        tell_verdicts(of, out);
        if (of->kind->merit)
            tell_merit(of, out);
        else
            tell_good(of, out);
    }
    free(of->method);
    if (out)
        fclose(out);
    text[size - 1] = '\0';
}

static void tell_cases(const survey *of, char *text, size_t size) {
    dl_across across;
    text[0] = '\0';
    if (dl_across_create(of->results, of->count, &across, NULL) == DL_OK)
        dl_across_answer(&across, text, size);
    dl_across_release(&across);
}

/* One after the other: of a kind that sets no methods side by side. */
static void tell_each(const survey *of, char *text, size_t size) {
    char answer[DL_MESSAGE_SIZE];
    size_t used = 0;
    for (size_t k = 0; k < of->count; k++)
        for (size_t s = 0; s < of->results[k]->scenes && used < size; s++) {
            dl_results_answer(of->results[k], of->results[k]->scene[s].name, answer, sizeof answer);
            if (*answer)
                used +=
                    (size_t)snprintf(text + used, size - used, "%s%s", used ? ". " : "", answer);
        }
}

void dl_results_answer_all(const dl_results *const *results, size_t count, char *text,
                           size_t size) {
    survey of = {.results = results, .count = count, .kind = dl_study_kind_of(results[0])};
    text[0] = '\0';
    for (size_t k = 0; k < count; k++) {
        of.scenes += results[k]->scenes;
        of.findings += results[k]->findings;
    }
    const bool compares = !of.kind->measure || of.kind->good || of.kind->merit;
    if (of.scenes == 1 || !compares)
        tell_each(&of, text, size);
    else if (of.kind->measure)
        tell_findings(&of, text, size);
    else
        tell_cases(&of, text, size);
}
