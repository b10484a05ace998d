/* What the benchmark measured, for people and for programs. */
#ifndef DL_CLI_BENCHMARK_H
#define DL_CLI_BENCHMARK_H

#include <stdio.h>
#include "bench/bench.h"
#include "driftlab/results.h"

typedef struct cli_benchmark {
    const dl_results *facts; /* of the machine and the build */
    dl_bench_effort effort;
    size_t speeds, peers, starts, overheads;
    dl_bench_speed speed[DL_BENCH_MOST_ROWS];
    dl_bench_peer peer[DL_BENCH_MOST_ROWS];
    dl_bench_start start[DL_BENCH_MOST_ROWS];
    dl_bench_overhead *overhead; /* [overheads]: method by method, on the pair and on the stream */
} cli_benchmark;

/* Markdown. */
void cli_benchmark_print(const cli_benchmark *all, FILE *out);
dl_status cli_benchmark_json(const cli_benchmark *all, FILE *out, dl_error *error);

#endif
