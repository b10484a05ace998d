#include <stdlib.h>
#include <string.h>

#include "bench/bench.h"

void dl_bench_add(dl_bench_times *times, double value) {
    times->value[times->count++] = value;
}

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

dl_bench_spread dl_bench_spread_of(const dl_bench_times *times) {
    const size_t n = times->count;
    double sorted[DL_BENCH_MOST_REPEATS];
    memcpy(sorted, times->value, n * sizeof *sorted);
    qsort(sorted, n, sizeof *sorted, compare);
    return (dl_bench_spread){sorted[0], (sorted[(n - 1) / 2] + sorted[n / 2]) / 2, sorted[n - 1]};
}

dl_bench_spread dl_bench_ratio(const dl_bench_times *above, const dl_bench_times *below) {
    dl_bench_times ratio = {.count = below->count};
    for (size_t k = 0; k < ratio.count; k++)
        ratio.value[k] = above->value[k] / below->value[k];
    return dl_bench_spread_of(&ratio);
}
