#include "observe/series.h"

#include <gsl/gsl_cdf.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* --- memory ------------------------------------------------------------------------------------
 */

enum { most_groups = 8192, window_times = 5 };

static double mean_of(const double *value, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += value[i];
    return sum / (double)n;
}

/* sum of (value_i - mean)(value_{i+lag} - mean) */
static double covariance(const double *value, size_t n, double mean, size_t lag) {
    double sum = 0;
    for (size_t i = 0; i + lag < n; i++)
        sum += (value[i] - mean) * (value[i + lag] - mean);
    return sum;
}

static double correlation_of(const double *value, size_t n) {
    const double mean = mean_of(value, n), variance = covariance(value, n, mean, 0);
    double time = 0.5;
    if (!(variance > 0))
        return variance == 0 ? time : NAN;
    for (size_t lag = 1; lag <= n / 2; lag++) {
        time += covariance(value, n, mean, lag) / variance;
        if ((double)lag >= window_times * time)
            return fmax(time, 0.5);
    }
    return (double)n;
}

double dl_series_correlation(const double *value, size_t n) {
    if (n < 4)
        return NAN;
    const size_t group = (n + most_groups - 1) / most_groups, groups = n / group;
    if (group == 1)
        return correlation_of(value, n);
    double *means = malloc(groups * sizeof *means);
    if (!means)
        return NAN;
    for (size_t g = 0; g < groups; g++)
        means[g] = mean_of(value + g * group, group);
    const double time = correlation_of(means, groups) * (double)group;
    free(means);
    return time;
}

/* How many batches that makes of n samples; 0: too few. */
static size_t batches_of(size_t n, double correlation) {
    const double room = floor((double)n / (DL_BATCH_CORRELATION_TIMES * correlation));
    if (!(room >= DL_LEAST_BATCHES))
        return 0;
    return room > DL_MOST_BATCHES ? DL_MOST_BATCHES : (size_t)room;
}

static double student(size_t degrees_of_freedom) {
    return gsl_cdf_tdist_Pinv(0.975, (double)degrees_of_freedom);
}

static dl_interval interval(double value, double error, size_t degrees_of_freedom) {
    const double half = error * student(degrees_of_freedom);
    return (dl_interval){value, value - half, value + half};
}

static dl_interval no_interval(double value) {
    return (dl_interval){value, NAN, NAN};
}

/* --- mean --------------------------------------------------------------------------------------
 */

dl_interval dl_series_mean(const double *value, size_t n, double *correlation) {
    const double time = dl_series_correlation(value, n);
    const size_t batches = batches_of(n, time);
    if (correlation)
        *correlation = time;
    if (n == 0)
        return no_interval(NAN);
    const double mean = mean_of(value, n);
    if (batches == 0)
        return no_interval(mean);
    /* What does not fill a batch is left out of the batches, at the start. */
    const size_t length = n / batches;
    const double *from = value + (n - batches * length);
    const double centre = mean_of(from, batches * length);
    double sum = 0;
    for (size_t b = 0; b < batches; b++) {
        const double d = mean_of(from + b * length, length) - centre;
        sum += d * d;
    }
    return interval(mean, sqrt(sum / (double)(batches * (batches - 1))), batches - 1);
}

/* --- line --------------------------------------------------------------------------------------
 */

/* What a least-squares line needs of points (x, y). */
typedef struct sums {
    double n, x, xx, y, xy, yy;
} sums;

static void add_point(sums *all, double x, double y) {
    all->n++;
    all->x += x;
    all->xx += x * x;
    all->y += y;
    all->xy += x * y;
    all->yy += y * y;
}

static sums without(const sums *all, const sums *part) {
    return (sums){all->n - part->n, all->x - part->x,   all->xx - part->xx,
                  all->y - part->y, all->xy - part->xy, all->yy - part->yy};
}

static double slope_of(const sums *s) {
    return (s->xy - s->x * s->y / s->n) / (s->xx - s->x * s->x / s->n);
}

/* Root mean square of the residuals. */
static double rms_of(const sums *s) {
    const double slope = slope_of(s);
    const double rest = (s->yy - s->y * s->y / s->n) - slope * (s->xy - s->x * s->y / s->n);
    return sqrt(fmax(rest, 0) / (s->n - 2));
}

/* Samples are counted from the middle: no cancellation in the sums. */
static double middle(size_t n) {
    return ((double)n - 1) / 2;
}

static sums centred(const double *value, size_t n, double mean) {
    sums all = {0};
    for (size_t k = 0; k < n; k++)
        add_point(&all, (double)k - middle(n), value[k] - mean);
    return all;
}

/* Slope's interval from the line through the batches' means of the residuals. */
static dl_interval slope_interval(const double *residual, size_t n, double slope, size_t batches) {
    if (batches == 0)
        return no_interval(slope);
    const size_t length = n / batches, first = n - batches * length;
    sums means = {0};
    for (size_t b = 0; b < batches; b++)
        add_point(&means, (double)length * ((double)b - middle(batches)),
                  mean_of(residual + first + b * length, length));
    return interval(slope, rms_of(&means) / sqrt(means.xx), batches - 2);
}

static void subtract_line(const double *value, size_t n, double intercept, double slope,
                          double *residual) {
    for (size_t k = 0; k < n; k++)
        residual[k] = value[k] - (intercept + slope * (double)k);
}

/* value_{k+1} - value_k, [n - 1] */
static void difference(const double *value, size_t n, double *increment) {
    for (size_t k = 0; k + 1 < n; k++)
        increment[k] = value[k + 1] - value[k];
}

dl_status dl_series_line(const double *value, size_t n, dl_line *line, double *residual,
                         dl_error *error) {
    double *own = residual ? NULL : malloc(n * sizeof *own);
    double *rest = residual ? residual : own;
    if (!rest)
        return dl_fail_memory(error, "residuals");
    const double mean = mean_of(value, n);
    const sums all = centred(value, n, mean);
    const double slope = slope_of(&all);
    line->intercept = mean - slope * middle(n);
    line->rms = rms_of(&all);
    subtract_line(value, n, line->intercept, slope, rest);
    line->correlation = dl_series_correlation(rest, n);
    line->batches = batches_of(n, line->correlation);
    line->slope = slope_interval(rest, n, slope, line->batches);
    if (line->batches == 0) {
        difference(value, n, rest);
        const dl_interval per_sample = dl_series_mean(rest, n - 1, NULL);
        if (!isnan(per_sample.low))
            line->slope = per_sample;
        subtract_line(value, n, line->intercept, slope, rest);
    }
    free(own);
    return DL_OK;
}

static double rms_about_line(const double *value, size_t n) {
    const sums all = centred(value, n, mean_of(value, n));
    return rms_of(&all);
}

double dl_series_growth(const double *value, size_t n) {
    enum { parts = 8 };
    const size_t part = n / parts;
    double square = 0;
    if (part < 4)
        return NAN;
    for (size_t p = 0; p < parts; p++) {
        const double rms = rms_about_line(value + p * part, part);
        square += rms * rms / parts;
    }
    return log(rms_about_line(value, parts * part) / sqrt(square)) / log(parts);
}

/* --- orders ------------------------------------------------------------------------------------
 */

typedef struct level {
    dl_line line;
    double *residual; /* [n] about the line, or increments of the series */
    size_t batches;   /* that it allows */
    sums all;         /* of all batches */
    sums batch[DL_MOST_BATCHES];
} level;

static void sum_batches(level *one, size_t n, size_t batches) {
    const size_t length = n / batches, first = n - batches * length;
    for (size_t b = 0; b < batches; b++)
        for (size_t i = 0; i < length; i++) {
            const size_t k = first + b * length + i;
            add_point(&one->batch[b], (double)k - middle(n), one->residual[k]);
            add_point(&one->all, (double)k - middle(n), one->residual[k]);
        }
}

/* What goes with the size to some power, of the sums of a level. */
typedef double law(const level *at, const sums *of);

static double fluctuation_of(const level *at, const sums *of) {
    (void)at;
    return rms_of(of);
}

static double drift_of(const level *at, const sums *of) {
    return at->line.slope.value + slope_of(of);
}

static double mean_increment_of(const level *at, const sums *of) {
    (void)at;
    return of->y / of->n;
}

/* The power, without the batch `left_out` (DL_MOST_BATCHES: with all). */
static double power_of(law *of, size_t levels, const level *at, const double *size,
                       size_t left_out) {
    sums points = {0};
    for (size_t l = 0; l < levels; l++) {
        const sums part =
            left_out < DL_MOST_BATCHES ? without(&at[l].all, &at[l].batch[left_out]) : at[l].all;
        add_point(&points, log(size[l]), log(fabs(of(&at[l], &part))));
    }
    return slope_of(&points);
}

static dl_interval jackknife(law *of, size_t levels, const level *at, const double *size,
                             size_t batches) {
    double replicate[DL_MOST_BATCHES];
    const double value = power_of(of, levels, at, size, DL_MOST_BATCHES), n = (double)batches;
    for (size_t b = 0; b < batches; b++)
        replicate[b] = power_of(of, levels, at, size, b);
    const double mean = mean_of(replicate, batches);
    const double variance = (n - 1) / n * covariance(replicate, batches, mean, 0);
    return interval(value, sqrt(variance), batches - 1);
}

static bool is_zero_perhaps(const dl_interval *value) {
    return !(value->low > 0 || value->high < 0);
}

/* The fewest batches of all levels. */
static size_t common_batches(size_t levels, const level *at) {
    size_t fewest = DL_MOST_BATCHES;
    for (size_t l = 0; l < levels; l++)
        if (at[l].batches < fewest)
            fewest = at[l].batches;
    return fewest;
}

static void sum_levels(size_t levels, level *at, size_t n, size_t batches) {
    for (size_t l = 0; l < levels; l++) {
        at[l].all = (sums){0};
        memset(at[l].batch, 0, sizeof at[l].batch);
        sum_batches(&at[l], n, batches);
    }
}

/* From the increments, where the residuals have too long a memory. */
static void fit_increments(size_t levels, level *at, const double *const *value, const double *size,
                           size_t n, dl_orders *orders) {
    for (size_t l = 0; l < levels; l++) {
        difference(value[l], n, at[l].residual);
        at[l].batches = batches_of(n - 1, dl_series_correlation(at[l].residual, n - 1));
    }
    const size_t batches = common_batches(levels, at);
    if (batches == 0)
        return;
    sum_levels(levels, at, n - 1, batches);
    orders->slope = jackknife(mean_increment_of, levels, at, size, batches);
}

static void fit_orders(size_t levels, level *at, const double *const *value, const double *size,
                       size_t n, dl_orders *orders) {
    const size_t batches = common_batches(levels, at);
    bool slopes = true;
    for (size_t l = 0; l < levels; l++)
        slopes &= !is_zero_perhaps(&at[l].line.slope);
    if (batches > 0) {
        sum_levels(levels, at, n, batches);
        orders->fluctuation = jackknife(fluctuation_of, levels, at, size, batches);
        if (slopes)
            orders->slope = jackknife(drift_of, levels, at, size, batches);
    } else if (slopes)
        fit_increments(levels, at, value, size, n, orders);
}

dl_status dl_series_orders(size_t levels, const double *const *value, const double *size, size_t n,
                           dl_orders *orders, dl_error *error) {
    *orders = (dl_orders){no_interval(NAN), no_interval(NAN)};
    level *at = calloc(levels, sizeof *at);
    dl_status status = at ? DL_OK : dl_fail_memory(error, "levels");
    for (size_t l = 0; l < levels && status == DL_OK; l++) {
        at[l].residual = malloc(n * sizeof *at[l].residual);
        status = at[l].residual ? dl_series_line(value[l], n, &at[l].line, at[l].residual, error)
                                : dl_fail_memory(error, "residuals");
        at[l].batches = at[l].line.batches;
    }
    if (status == DL_OK)
        fit_orders(levels, at, value, size, n, orders);
    for (size_t l = 0; at && l < levels; l++)
        free(at[l].residual);
    free(at);
    return status;
}

/* --- transient ---------------------------------------------------------------------------------
 */

size_t dl_series_truncation(const double *value, size_t n) {
    enum { batch = 5 };
    const size_t batches = n / batch;
    double sum = 0, square = 0, least = INFINITY;
    size_t best = 0;
    if (batches < 2)
        return 0;
    const double centre = mean_of(value, n);
    for (size_t b = batches; b-- > 0;) { /* from the end on: what is left if b batches go */
        const double mean = mean_of(value + b * batch, batch) - centre;
        const double left = (double)(batches - b);
        sum += mean;
        square += mean * mean;
        if (left < fmax((double)batches / 5, 2))
            continue;
        const double error = (square - sum * sum / left) / (left * left);
        if (error <= least) {
            least = error;
            best = b;
        }
    }
    return best * batch;
}

static double geweke(const double *value, size_t n) {
    const size_t first = n / 10, last = n / 2;
    const double *late = value + (n - last);
    const double time = dl_series_correlation(late, last);
    if (first == 0 || !((double)first >= 2 * time))
        return NAN;
    const double mean = mean_of(late, last);
    const double variance = covariance(late, last, mean, 0) / (double)(last - 1);
    const double error = sqrt(2 * time * variance * (1 / (double)first + 1 / (double)last));
    const double difference = mean_of(value, first) - mean;
    return difference == 0 ? 0 : difference / error;
}

double dl_series_change(const double *value, size_t n, dl_error *error) {
    dl_line line;
    if (n < 20 || dl_series_line(value, n, &line, NULL, error) != DL_OK || line.batches == 0)
        return NAN;
    const double z = geweke(value, n), half = (line.slope.high - line.slope.low) / 2;
    const double slope = line.slope.value * student(line.batches - 2) / half;
    return isnan(z) || fabs(z) > fabs(slope) ? z : slope;
}
