/* driftlab bench: what the program measures of itself. */
#include <stdlib.h>

#include "cli/benchmark.h"
#include "cli/command.h"
#include "cli/outcome.h"
#include "cli/settings.h"
#include "cli/studies.h"
#include "study/facts.h"
#include "study/process.h"

typedef struct bench_values {
    char *studies;
    bool json, quick;
} bench_values;

static const dl_parameter options[] = {
    {.name = "quick",
     .kind = DL_FLAG,
     .offset = offsetof(bench_values, quick),
     .fallback = "false",
     .doc = "a run of seconds, to see that it works: its times mean little"},
    {.name = "studies",
     .kind = DL_TEXT,
     .offset = offsetof(bench_values, studies),
     .unit = "DIR",
     .doc = "folder of the scenes (default: ./studies, or else the installed ones)"},
    CLI_OPTION_JSON(bench_values),
};

static const dl_bench_effort full = {.repeats = 9, .starts = 20, .seconds = 4e-3},
                             quick = {.repeats = 2, .starts = 2, .seconds = 5e-5};

static dl_status measure_overheads(const dl_bench_scenes *scenes, cli_benchmark *all,
                                   dl_error *error) {
    const size_t methods = dl_method_count();
    all->overhead = calloc(2 * methods, sizeof *all->overhead);
    dl_status status = all->overhead ? DL_OK : dl_fail_memory(error, "a benchmark");
    for (size_t k = 0; k < methods && !status; k++) {
        const dl_method_row *const row = dl_method_row_at(k);
        const bool parts = row->flags & DL_SPLITS_FORCE;
        const dl_scene *const on[] = {parts ? &scenes->pair_parts : &scenes->pair,
                                      parts ? &scenes->stream_parts : scenes->stream};
        for (int s = 0; s < 2 && !status; s++)
            status = dl_bench_measure_overhead(row, on[s], &all->effort,
                                               &all->overhead[all->overheads++], error);
    }
    return status;
}

static dl_status measure(const dl_bench_scenes *scenes, cli_benchmark *all, dl_error *error) {
    dl_status status =
        dl_bench_measure_starts(scenes, &all->effort, all->start, &all->starts, error);
    if (!status)
        status = dl_bench_measure_speed(scenes, &all->effort, all->speed, &all->speeds, error);
    if (!status)
        status = dl_bench_measure_gsl(scenes, &all->effort, all->peer, &all->peers, error);
    return status ? status : measure_overheads(scenes, all, error);
}

static dl_status bench(const cli_input *input, cli_benchmark *all, dl_error *error) {
    const bench_values *const values = input->values;
    char studies[4096];
    dl_bench_scenes scenes;
    dl_results *facts = NULL;
    all->effort = values->quick ? quick : full;
    dl_status status = cli_find_studies(values->studies, studies, sizeof studies, error);
    if (!status)
        status = dl_bench_scenes_read(studies, &scenes, error);
    if (status)
        return status;
    dl_process_stay_here();
    status = measure(&scenes, all, error);
    if (!status)
        status = dl_results_create(&facts, error);
    if (!status)
        status = dl_facts_add(facts, input->line, error);
    all->facts = facts;
    if (!status && values->json)
        status = cli_benchmark_json(all, stdout, error);
    else if (!status)
        cli_benchmark_print(all, stdout);
    if (facts)
        dl_results_free(facts);
    dl_bench_scenes_release(&scenes);
    return status;
}

static cli_exit bench_command(const cli_input *input) {
    cli_benchmark all = {.facts = NULL};
    dl_error error = {""};
    const cli_exit outcome = cli_finish(bench(input, &all, &error), &error);
    free(all.overhead);
    return outcome;
}

const cli_command cli_command_bench = {
    .name = "bench",
    .arguments = "",
    .summary = "measure the program itself: speed, methods' own cost, GSL beside, start",
    .details = "Pinned to the processor it is on. scripts/bench sets it beside the programs of\n"
               "bench/, which have LAMMPS and PETSc as peers.\n",
    .options = CLI_TABLE(options),
    .values_size = sizeof(bench_values),
    .run = bench_command,
};
