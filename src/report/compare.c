#include "driftlab/compare.h"

#include <ctype.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* A cost that differs by less is not ranked. */
static const double ranked_from = 1.2;

/* --- which belong together ----------------------------------------------------------------- */

static size_t hex_digits(const char *text) {
    size_t count = 0;
    while (isxdigit((unsigned char)text[count]))
        count++;
    return count;
}

/* Behind a hash of content, "#0123456789abcdef" or "=0123456789abcdef", at `text`. */
static const char *skip_hash(const char *text) {
    return (*text == '#' || *text == '=') && hex_digits(text + 1) == 16 ? text + 17 : text;
}

/* The keys agree but for what their scenes and references contain. */
static bool alike(const char *a, const char *b) {
    for (;;) {
        a = skip_hash(a);
        b = skip_hash(b);
        if (*a != *b)
            return false;
        if (!*a)
            return true;
        a++;
        b++;
    }
}

static const dl_case *like_case(const dl_results *in, const dl_case *cased) {
    const dl_case *found = dl_results_find(in, cased->key);
    for (size_t i = 0; i < in->cases && !found; i++)
        if (alike(in->cased[i].key, cased->key))
            found = &in->cased[i];
    return found;
}

static const dl_finding *like_finding(const dl_results *in, const dl_finding *finding) {
    const dl_finding *found = dl_results_find_finding(in, finding->key);
    for (size_t i = 0; i < in->findings && !found; i++)
        if (alike(in->finding[i].key, finding->key))
            found = &in->finding[i];
    return found;
}

/* --- whether they agree -------------------------------------------------------------------- */

static bool equal(double a, double b) {
    return a == b || (isnan(a) && isnan(b));
}

/* How far a run gets in its time is the machine's doing: two that were stopped agree. */
static bool cases_agree(const dl_case *x, const dl_case *y) {
    const dl_run_summary *a = &x->summary, *b = &y->summary;
    if (a->status == DL_TIMEOUT && b->status == DL_TIMEOUT)
        return true;
    const unsigned long counts[][2] = {
        {a->steps, b->steps},
        {a->rejected_steps, b->rejected_steps},
        {a->force_evaluations, b->force_evaluations},
        {a->jacobian_evaluations, b->jacobian_evaluations},
        {a->jacobian_vector_products, b->jacobian_vector_products},
        {a->nonlinear_iterations, b->nonlinear_iterations},
        {a->linear_iterations, b->linear_iterations},
        {a->factorisations, b->factorisations},
        {a->wall_hits, b->wall_hits},
    };
    for (size_t i = 0; i < sizeof counts / sizeof *counts; i++)
        if (counts[i][0] != counts[i][1])
            return false;
    return a->status == b->status && equal(x->position_error, y->position_error) &&
           equal(x->position_error_ever, y->position_error_ever) &&
           equal(a->energy_error_max, b->energy_error_max) &&
           equal(a->momentum_error_max, b->momentum_error_max) &&
           equal(a->angular_momentum_error_max, b->angular_momentum_error_max);
}

static bool reals_agree(const double *a, const double *b, size_t count) {
    for (size_t i = 0; i < count; i++)
        if (!equal(a[i], b[i]))
            return false;
    return true;
}

static bool findings_agree(const dl_finding *a, const dl_finding *b) {
    return a->status == b->status && strcmp(a->verdict, b->verdict) == 0 &&
           strcmp(a->quantity_names, b->quantity_names) == 0 &&
           strcmp(a->column_names, b->column_names) == 0 &&
           strcmp(a->row_words, b->row_words) == 0 && a->quantities == b->quantities &&
           a->rows == b->rows && a->columns == b->columns &&
           reals_agree(a->quantity, b->quantity, 3 * a->quantities) &&
           reals_agree(a->table, b->table, a->rows * a->columns);
}

/* --- times --------------------------------------------------------------------------------- */

static bool timed(const dl_case *cased) {
    return cased->summary.status == DL_OK && cased->summary.cpu_seconds > 0;
}

static int ascending(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static dl_status measure_ratios(dl_comparison *made, dl_error *error) {
    double *ratio = malloc((made->pairs + 1) * sizeof *ratio);
    if (!ratio)
        return dl_fail_memory(error, "a comparison");
    size_t count = 0;
    for (size_t i = 0; i < made->pairs; i++) {
        const dl_case_pair *pair = &made->pair[i];
        if (timed(pair->a) && timed(pair->b))
            ratio[count++] = pair->b->summary.cpu_seconds / pair->a->summary.cpu_seconds;
    }
    if (count > 0) {
        qsort(ratio, count, sizeof *ratio, ascending);
        made->ratio_least = ratio[0];
        made->ratio_most = ratio[count - 1];
        made->ratio_median =
            count % 2 ? ratio[count / 2] : (ratio[count / 2 - 1] + ratio[count / 2]) / 2;
    }
    free(ratio);
    return DL_OK;
}

static void compare_order(dl_comparison *made, const dl_case_pair *x, const dl_case_pair *y) {
    if (!timed(x->a) || !timed(x->b) || !timed(y->a) || !timed(y->b) ||
        strcmp(x->a->scene, y->a->scene) != 0)
        return;
    const double a = x->a->summary.cpu_seconds / y->a->summary.cpu_seconds;
    const double b = x->b->summary.cpu_seconds / y->b->summary.cpu_seconds;
    if (!(a > ranked_from || a < 1 / ranked_from))
        return;
    made->ranked++;
    made->swapped += (a > 1) != (b > 1);
}

/* --- the whole ----------------------------------------------------------------------------- */

static void pair_cases(dl_comparison *made) {
    for (size_t i = 0; i < made->a->cases; i++) {
        const dl_case *a = &made->a->cased[i], *b = like_case(made->b, a);
        if (!b)
            continue;
        const dl_case_pair pair = {a, b, strcmp(a->key, b->key) == 0, cases_agree(a, b)};
        made->pair[made->pairs++] = pair;
        made->same += pair.same;
    }
    made->only_a += made->a->cases - made->pairs;
    made->only_b += made->b->cases - made->pairs;
}

static void pair_findings(dl_comparison *made) {
    for (size_t i = 0; i < made->a->findings; i++) {
        const dl_finding *a = &made->a->finding[i], *b = like_finding(made->b, a);
        if (!b)
            continue;
        const dl_finding_pair pair = {a, b, strcmp(a->key, b->key) == 0, findings_agree(a, b)};
        made->finding_pair[made->finding_pairs++] = pair;
        made->same += pair.same;
    }
    made->only_a += made->a->findings - made->finding_pairs;
    made->only_b += made->b->findings - made->finding_pairs;
}

dl_status dl_compare(const dl_results *a, const dl_results *b, dl_comparison *comparison,
                     dl_error *error) {
    dl_comparison made = {
        .a = a, .b = b, .ratio_median = NAN, .ratio_least = NAN, .ratio_most = NAN};
    made.pair = calloc(a->cases + 1, sizeof *made.pair);
    made.finding_pair = calloc(a->findings + 1, sizeof *made.finding_pair);
    dl_status status =
        made.pair && made.finding_pair ? DL_OK : dl_fail_memory(error, "a comparison");
    if (status == DL_OK) {
        pair_cases(&made);
        pair_findings(&made);
        status = measure_ratios(&made, error);
    }
    for (size_t i = 0; i < made.pairs; i++)
        for (size_t k = 0; k < i; k++)
            compare_order(&made, &made.pair[i], &made.pair[k]);
    *comparison = made;
    if (status != DL_OK)
        dl_comparison_release(comparison);
    return status;
}

void dl_comparison_release(dl_comparison *comparison) {
    free(comparison->pair);
    free(comparison->finding_pair);
    comparison->pair = NULL;
    comparison->finding_pair = NULL;
}

bool dl_comparison_has_case(const dl_comparison *comparison, const dl_case *cased) {
    for (size_t i = 0; i < comparison->pairs; i++)
        if (comparison->pair[i].a == cased || comparison->pair[i].b == cased)
            return true;
    return false;
}

bool dl_comparison_has_finding(const dl_comparison *comparison, const dl_finding *finding) {
    for (size_t i = 0; i < comparison->finding_pairs; i++)
        if (comparison->finding_pair[i].a == finding || comparison->finding_pair[i].b == finding)
            return true;
    return false;
}
