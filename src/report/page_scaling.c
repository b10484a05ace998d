#include "report/page_scaling.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/scaling.h"
#include "report/page_findings.h"

static json_t *real(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *reals(const double *value, size_t count) {
    json_t *array = json_array();
    for (size_t i = 0; i < count; i++)
        if (json_array_append_new(array, real(value[i]))) {
            json_decref(array);
            return NULL;
        }
    return array;
}

static json_t *one_quantity(const dl_scaling *of, const dl_scaled *quantity) {
    const double from = quantity->from < of->sizes ? of->particles[quantity->from] : NAN;
    return json_pack("{s:o,s:o,s:o,s:o}", "name", dl_page_text(quantity->name), "values",
                     reals(quantity->value, of->sizes), "deviations",
                     reals(quantity->deviation, of->sizes), "from", real(from));
}

static json_t *one_cost(const dl_scaling *of, const dl_scaled_cost *cost) {
    return json_pack("{s:o,s:o,s:o,s:o,s:o}", "name", dl_page_text(cost->name), "values",
                     reals(cost->value, of->sizes), "exponent", real(cost->exponent), "low",
                     real(cost->low), "high", real(cost->high));
}

static json_t *one_scaling(const dl_scaling *of) {
    json_t *quantities = json_array(), *costs = json_array(), *repeats = json_array();
    int failed = 0;
    for (size_t s = 0; s < of->sizes; s++)
        failed |= json_array_append_new(repeats, json_integer((json_int_t)of->repeats[s]));
    for (size_t q = 0; q < of->quantities; q++)
        failed |= json_array_append_new(quantities, one_quantity(of, &of->quantity[q]));
    for (size_t k = 0; k < DL_SCALED_COSTS; k++)
        failed |= json_array_append_new(costs, one_cost(of, &of->cost[k]));
    json_t *object =
        json_pack("{s:o,s:o,s:o,s:f,s:o,s:o,s:o,s:o}", "body", dl_page_text(of->body), "method",
                  dl_page_text(of->method), "options", dl_page_text(of->options), "tolerance",
                  of->tolerance, "particles", reals(of->particles, of->sizes), "repeats", repeats,
                  "quantities", quantities, "costs", costs);
    if (!failed)
        return object;
    json_decref(object);
    return NULL;
}

json_t *dl_page_scalings(const dl_results *results) {
    json_t *all = json_array();
    const bool scaled = strcmp(results->kind, "scaling") == 0;
    const size_t count = scaled ? dl_scalings_count(results) : 0;
    dl_scaling *of = malloc(sizeof *of);
    int failed = !all || !of;
    for (size_t k = 0; k < count && !failed; k++) {
        dl_scaling_get(results, k, of);
        if (of->sizes > 1)
            failed = json_array_append_new(all, one_scaling(of));
    }
    free(of);
    if (!failed)
        return all;
    json_decref(all);
    return NULL;
}
