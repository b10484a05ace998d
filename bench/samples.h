/* Repeated times of one thing, and two things' times taken in turn. */
#ifndef BENCH_SAMPLES_H
#define BENCH_SAMPLES_H

#include <stddef.h>
#include <stdlib.h>
#include <string.h>

enum { BENCH_MAX_REPEATS = 101 };

typedef struct samples {
    size_t count;
    double value[BENCH_MAX_REPEATS]; /* in the order they were taken */
} samples;

typedef struct spread {
    double minimum, median, maximum;
} spread;

static void samples_add(samples *all, double value) {
    all->value[all->count++] = value;
}

static int samples_compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static spread samples_spread(const samples *all) {
    double sorted[BENCH_MAX_REPEATS];
    const size_t n = all->count;
    memcpy(sorted, all->value, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, samples_compare);
    return (spread){sorted[0], (sorted[(n - 1) / 2] + sorted[n / 2]) / 2, sorted[n - 1]};
}

/* Of above/below, repeat by repeat: what slows the machine down for a while slows both. */
static spread samples_ratio(const samples *above, const samples *below) {
    samples ratio = {.count = below->count};
    for (size_t k = 0; k < ratio.count; k++)
        ratio.value[k] = above->value[k] / below->value[k];
    return samples_spread(&ratio);
}

#endif
