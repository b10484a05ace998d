/* The findings of a study of the kind `scaling`, set beside one another. */
#include "driftlab/scaling.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "study/scaling.h"

const char *const dl_scaling_costs[DL_SCALED_COSTS] = {
    "CPU time of a step [s]",
    "CPU time [s]",
    "force evaluations",
    "pair forces",
};

/* --- lines of names --------------------------------------------------------------------------- */

static const char *next_line(const char **text, size_t *length) {
    const char *line = *text;
    *length = strcspn(line, "\n");
    *text = line + *length + (line[*length] == '\n');
    return line;
}

/* Without the unit. */
static size_t bare_length(const char *line, size_t length) {
    for (size_t i = 0; i + 1 < length; i++)
        if (line[i] == ' ' && line[i + 1] == '[')
            return i;
    return length;
}

/* Everything that is not of the bulk, and the scene's numbers ("$k"). */
bool dl_scaling_is_bulk(const char *name, size_t length) {
    static const char *const others[] = {DL_SCALING_PARTICLES,
                                         DL_SCALING_TOLERANCE,
                                         DL_SCALING_STEP,
                                         "pairs looked at, per particle",
                                         "energy error [energy scale]",
                                         "steps"};
    bool other = *name == '$';
    for (size_t k = 0; k < sizeof others / sizeof *others; k++)
        other |= strlen(others[k]) == length && strncmp(others[k], name, length) == 0;
    for (size_t k = 0; k < DL_SCALED_COSTS; k++)
        other |= strlen(dl_scaling_costs[k]) == length &&
                 strncmp(dl_scaling_costs[k], name, length) == 0;
    return !other;
}

/* The value of the quantity of that line, whatever its unit; NAN: none. */
static double value_of(const dl_finding *finding, const char *line) {
    char name[DL_SCALED_NAME];
    snprintf(name, sizeof name, "%.*s", (int)bare_length(line, strlen(line)), line);
    const double *value = dl_finding_quantity(finding, name);
    return value ? value[0] : NAN;
}

/* --- which belong together -------------------------------------------------------------------- */

static bool counts(const dl_finding *finding) {
    return finding->status == DL_OK && strcmp(finding->verdict, DL_SCALING_MEASURED) == 0;
}

static size_t body_length(const dl_finding *finding) {
    return strcspn(finding->scene, "(");
}

/* From behind "step=...", where the options begin with it. */
static const char *without_step(const char *options) {
    return strncmp(options, "step=", 5) == 0 ? options + strcspn(options, " ") : options;
}

/* The same step: of the scene, which may go with its size, or as it is written. */
static bool same_step(const dl_finding *a, const dl_finding *b) {
    const double step[] = {value_of(a, DL_SCALING_STEP), value_of(b, DL_SCALING_STEP)};
    return strcmp(a->options, b->options) == 0 || fabs(step[0] - step[1]) <= 1e-9 * step[0];
}

static bool belong_together(const dl_finding *a, const dl_finding *b) {
    return counts(a) && counts(b) && body_length(a) == body_length(b) &&
           strncmp(a->scene, b->scene, body_length(a)) == 0 && strcmp(a->method, b->method) == 0 &&
           strcmp(without_step(a->options), without_step(b->options)) == 0 && same_step(a, b);
}

/* The first finding of comparison `index`; *count of them there are. */
static const dl_finding *first_of(const dl_results *results, size_t index, size_t *count) {
    const dl_finding *found = NULL;
    *count = 0;
    for (size_t i = 0; i < results->findings; i++) {
        bool first = counts(&results->finding[i]);
        for (size_t j = 0; j < i && first; j++)
            first = !belong_together(&results->finding[i], &results->finding[j]);
        if (first && (*count)++ == index)
            found = &results->finding[i];
    }
    return found;
}

size_t dl_scalings_count(const dl_results *results) {
    size_t count;
    first_of(results, 0, &count);
    return count;
}

/* --- sizes ------------------------------------------------------------------------------------ */

typedef struct group {
    const dl_results *results;
    const dl_finding *first;
    dl_scaling *scaling;
} group;

static const dl_finding *member(const group *of, size_t i) {
    const dl_finding *finding = &of->results->finding[i];
    return belong_together(of->first, finding) ? finding : NULL;
}

static void add_size(dl_scaling *scaling, double particles) {
    size_t at = 0;
    while (at < scaling->sizes && scaling->particles[at] < particles)
        at++;
    if (at < scaling->sizes && scaling->particles[at] == particles) {
        scaling->repeats[at]++;
        return;
    }
    if (scaling->sizes == DL_MOST_SIZES)
        return;
    for (size_t s = scaling->sizes++; s > at; s--) {
        scaling->particles[s] = scaling->particles[s - 1];
        scaling->repeats[s] = scaling->repeats[s - 1];
    }
    scaling->particles[at] = particles;
    scaling->repeats[at] = 1;
}

static void find_sizes(const group *of) {
    dl_scaling *scaling = of->scaling;
    for (size_t i = 0; i < of->results->findings; i++)
        if (member(of, i))
            add_size(scaling, value_of(member(of, i), DL_SCALING_PARTICLES));
    const double most = scaling->particles[scaling->sizes - 1];
    for (size_t i = of->results->findings; i-- > 0;)
        if (member(of, i) && value_of(member(of, i), DL_SCALING_PARTICLES) == most) {
            scaling->largest = member(of, i)->scene;
            scaling->options = member(of, i)->options;
        }
}

/* Sum over the repeats of a size of  value, or of the squares of (value - about). */
static double sum_of(const group *of, size_t size, const char *line, bool square, double about) {
    double sum = 0;
    for (size_t i = 0; i < of->results->findings; i++) {
        const dl_finding *finding = member(of, i);
        if (!finding || value_of(finding, DL_SCALING_PARTICLES) != of->scaling->particles[size])
            continue;
        const double value = value_of(finding, line) - about;
        sum += square ? value * value : value;
    }
    return sum;
}

static void means_by_size(const group *of, const char *line, double *mean) {
    for (size_t s = 0; s < of->scaling->sizes; s++)
        mean[s] = sum_of(of, s, line, false, 0) / (double)of->scaling->repeats[s];
}

/* --- quantities ------------------------------------------------------------------------------- */

/* As a part of `scale`; of nothing nothing is 0. */
static double part_of(double difference, double scale) {
    return difference == 0 ? 0 : difference / fabs(scale);
}

static void compare(const group *of, dl_scaled *quantity) {
    const dl_scaling *scaling = of->scaling;
    means_by_size(of, quantity->name, quantity->value);
    const double limit = quantity->value[scaling->sizes - 1];
    for (size_t s = 0; s < scaling->sizes; s++) {
        const double mean =
            sum_of(of, s, quantity->name, true, limit) / (double)scaling->repeats[s];
        quantity->deviation[s] = part_of(sqrt(mean), limit);
    }
    quantity->from = scaling->sizes;
    while (quantity->from > 0 && quantity->deviation[quantity->from - 1] <= scaling->tolerance)
        quantity->from--;
}

static void compare_all(const group *of) {
    const char *names = of->first->quantity_names;
    dl_scaling *scaling = of->scaling;
    for (size_t i = 0; i < of->first->quantities; i++) {
        size_t length;
        const char *line = next_line(&names, &length);
        if (!dl_scaling_is_bulk(line, length) || scaling->quantities == DL_MOST_SCALED)
            continue;
        dl_scaled *quantity = &scaling->quantity[scaling->quantities++];
        snprintf(quantity->name, sizeof quantity->name, "%.*s", (int)length, line);
        compare(of, quantity);
    }
}

/* --- costs ------------------------------------------------------------------------------------ */

void dl_fit_power(const double *x, const double *y, size_t n, double *exponent, double *low,
                  double *high) {
    double sx = 0, sy = 0, sxx = 0, sxy = 0, residual = 0;
    const double m = (double)n;
    for (size_t i = 0; i < n; i++) {
        sx += log(x[i]) / m;
        sy += log(y[i]) / m;
    }
    for (size_t i = 0; i < n; i++) {
        sxx += (log(x[i]) - sx) * (log(x[i]) - sx);
        sxy += (log(x[i]) - sx) * (log(y[i]) - sy);
    }
    *exponent = sxx > 0 && isfinite(sxy) ? sxy / sxx : NAN;
    *low = *high = NAN;
    if (n < 3 || isnan(*exponent))
        return;
    for (size_t i = 0; i < n; i++) {
        const double off = log(y[i]) - sy - *exponent * (log(x[i]) - sx);
        residual += off * off;
    }
    const double half = gsl_cdf_tdist_Pinv(0.975, m - 2) * sqrt(residual / (m - 2) / sxx);
    *low = *exponent - half;
    *high = *exponent + half;
}

static void fit_costs(const group *of) {
    dl_scaling *scaling = of->scaling;
    for (size_t k = 0; k < DL_SCALED_COSTS; k++) {
        dl_scaled_cost *cost = &scaling->cost[k];
        snprintf(cost->name, sizeof cost->name, "%s", dl_scaling_costs[k]);
        means_by_size(of, cost->name, cost->value);
        dl_fit_power(scaling->particles, cost->value, scaling->sizes, &cost->exponent, &cost->low,
                     &cost->high);
    }
}

void dl_scaling_get(const dl_results *results, size_t index, dl_scaling *scaling) {
    size_t count;
    *scaling = (dl_scaling){.options = "", .largest = ""};
    const group of = {results, first_of(results, index, &count), scaling};
    if (!of.first)
        return;
    snprintf(scaling->body, sizeof scaling->body, "%.*s", (int)body_length(of.first),
             of.first->scene);
    snprintf(scaling->method, sizeof scaling->method, "%s", of.first->method);
    scaling->tolerance = value_of(of.first, DL_SCALING_TOLERANCE);
    find_sizes(&of);
    compare_all(&of);
    fit_costs(&of);
}

/* --- text ------------------------------------------------------------------------------------- */

enum { name_width = 46, column_width = 19 };

static void print_head(const dl_scaling *of, FILE *out) {
    fprintf(out, "%s with %s, %s\n", of->body, of->method, of->options);
    fprintf(out, "  (in brackets: root mean square difference from the mean at %.0f particles)\n",
            of->particles[of->sizes - 1]);
    fprintf(out, "  %-*s", name_width, "particles (runs)");
    for (size_t s = 0; s < of->sizes; s++) {
        char text[48];
        snprintf(text, sizeof text, "%.0f (%zu)", of->particles[s], of->repeats[s]);
        fprintf(out, " %*s", column_width, text);
    }
    fprintf(out, "  within %.3g %% from\n", 100 * of->tolerance);
}

static void print_quantity(const dl_scaling *of, const dl_scaled *quantity, FILE *out) {
    fprintf(out, "  %-*s", name_width, quantity->name);
    for (size_t s = 0; s < of->sizes; s++) {
        char text[48];
        snprintf(text, sizeof text, "%.5g (%.2g %%)", quantity->value[s],
                 100 * quantity->deviation[s]);
        fprintf(out, " %*s", column_width, isfinite(quantity->value[s]) ? text : "-");
    }
    if (quantity->from < of->sizes)
        fprintf(out, "  %.0f\n", of->particles[quantity->from]);
    else
        fprintf(out, "  -\n");
}

static void print_cost(const dl_scaling *of, const dl_scaled_cost *cost, FILE *out) {
    fprintf(out, "  %-*s", name_width, cost->name);
    for (size_t s = 0; s < of->sizes; s++)
        fprintf(out, " %*.4g", column_width, cost->value[s]);
    if (isfinite(cost->exponent))
        fprintf(out, "  N^%.3f", cost->exponent);
    if (isfinite(cost->low))
        fprintf(out, " (%.3f to %.3f)", cost->low, cost->high);
    fputc('\n', out);
}

void dl_scaling_print(const dl_scaling *scaling, FILE *out) {
    print_head(scaling, out);
    for (size_t q = 0; q < scaling->quantities; q++)
        print_quantity(scaling, &scaling->quantity[q], out);
    for (size_t k = 0; k < DL_SCALED_COSTS; k++)
        print_cost(scaling, &scaling->cost[k], out);
}
