#include "cli/benchmark.h"

#include <math.h>
#include <string.h>

#include "cli/json.h"

/* --- targets -----------------------------------------------------------------------------------
 */

/* Of leap-frog and the splittings, on a pair: kicks and drifts are all they have to do. */
static const double most_overhead = 20; /* ns a force evaluation, and a step has one at least */
static const double most_start = 0.01;  /* seconds */

static bool has_target(const dl_bench_overhead *row) {
    const char *const family = row->row->family;
    return row->particles == 2 &&
           (strcmp(family, "leap-frog") == 0 || strcmp(family, "composition") == 0);
}

static double beyond(const dl_bench_overhead *row) {
    return row->step - row->force;
}

static double beyond_each(const dl_bench_overhead *row) {
    return beyond(row) / row->forces;
}

static bool meets(const dl_bench_overhead *row) {
    return beyond_each(row) <= most_overhead;
}

/* --- tables ------------------------------------------------------------------------------------
 */

static void print_facts(const cli_benchmark *all, FILE *out) {
    for (size_t k = 0; k < all->facts->facts; k++)
        fprintf(out, "- %s: %s\n", all->facts->fact[k].name, all->facts->fact[k].value);
    fprintf(out, "- repeats: %zu, of %g s\n", all->effort.repeats, all->effort.seconds);
}

static void print_speeds(const cli_benchmark *all, FILE *out) {
    fprintf(out, "\n### Speed\n\n"
                 "| what | scene | unit | minimum | median | us a step | iterations a step |\n"
                 "|---|---|---|---|---|---|---|\n");
    for (size_t k = 0; k < all->speeds; k++) {
        const dl_bench_speed *const row = &all->speed[k];
        fprintf(out, "| %s | %s | %s | %.3g | %.3g |", row->what, row->scene, row->unit,
                row->time.minimum, row->time.median);
        fprintf(out, isnan(row->step) ? " |" : " %.3g |", row->step / 1e3);
        fprintf(out, isnan(row->iterations) ? " |\n" : " %.3g |\n", row->iterations);
    }
}

static void print_overheads(const cli_benchmark *all, FILE *out) {
    fprintf(
        out,
        "\n### What methods cost beyond their forces\n\n"
        "ns of a step, of its forces (each kind's count times what one of it costs by itself),\n"
        "and what is left: method, solver, Jacobians, time loop. Default options. Least times:\n"
        "a difference of a few per cent of the step is noise, whatever its sign. Target:\n"
        "splittings, on the pair, at most %g ns a force.\n\n"
        "| method | scene | N | step | forces | of which forces take | beyond | share |"
        " a force | target |\n|---|---|---|---|---|---|---|---|---|---|\n",
        most_overhead);
    for (size_t k = 0; k < all->overheads; k++) {
        const dl_bench_overhead *const row = &all->overhead[k];
        fprintf(out, "| %s | %s | %zu | %.4g | %.4g | %.4g | %.3g | %.1f %% | %.3g | %s |\n",
                row->row->name, row->scene, row->particles, row->step, row->forces, row->force,
                beyond(row), 100 * beyond(row) / row->step, beyond_each(row),
                !has_target(row) ? ""
                : meets(row)     ? "yes"
                                 : "no");
    }
}

static void print_peers(const cli_benchmark *all, FILE *out) {
    fprintf(
        out,
        "\n### GSL's driver by hand, beside the methods that step by it\n\n"
        "The same right-hand side, tolerances and end; ns of one of our steps. Ratio: "
        "theirs over ours,\nrepeat by repeat; where memory lies alone makes a tenth either way.\n\n"
        "| method | scene | ours | by hand | ratio | forces, ours | by hand |\n"
        "|---|---|---|---|---|---|---|\n");
    for (size_t k = 0; k < all->peers; k++) {
        const dl_bench_peer *const row = &all->peer[k];
        fprintf(out, "| %s | %s | %.4g | %.4g | %.2f (%.2f to %.2f) | %lu | %lu |\n", row->method,
                row->scene, row->ours, row->theirs, row->ratio.median, row->ratio.minimum,
                row->ratio.maximum, row->our_evaluations, row->their_evaluations);
    }
}

static void print_starts(const cli_benchmark *all, FILE *out) {
    fprintf(out,
            "\n### A case's start\n\n"
            "`driftlab run SCENE --method leapfrog` for one step, from fork to exit: loading,\n"
            "reading, set-up, the two samples. Milliseconds; target: CPU time at most %g.\n\n"
            "| scene | N | CPU, minimum | median | wall, minimum | median | target |\n"
            "|---|---|---|---|---|---|---|\n",
            most_start * 1e3);
    for (size_t k = 0; k < all->starts; k++) {
        const dl_bench_start *const row = &all->start[k];
        fprintf(out, "| %s | %zu | %.3g | %.3g | %.3g | %.3g | %s |\n", row->scene, row->particles,
                row->cpu.minimum * 1e3, row->cpu.median * 1e3, row->wall.minimum * 1e3,
                row->wall.median * 1e3, row->cpu.minimum <= most_start ? "yes" : "no");
    }
}

void cli_benchmark_print(const cli_benchmark *all, FILE *out) {
    fprintf(out, "## The program by itself\n\n");
    print_facts(all, out);
    print_speeds(all, out);
    print_overheads(all, out);
    print_peers(all, out);
    print_starts(all, out);
}

/* --- JSON --------------------------------------------------------------------------------------
 */

static json_t *spread_json(dl_bench_spread spread) {
    return json_pack("{s:o, s:o, s:o}", "minimum", cli_json_real(spread.minimum), "median",
                     cli_json_real(spread.median), "maximum", cli_json_real(spread.maximum));
}

static json_t *speed_json(const dl_bench_speed *row) {
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:o}", "what", row->what, "scene", row->scene,
                     "unit", row->unit, "time", spread_json(row->time), "step_ns",
                     cli_json_real(row->step), "iterations_per_step",
                     cli_json_real(row->iterations));
}

static json_t *overhead_json(const dl_bench_overhead *row) {
    json_t *const object =
        json_pack("{s:s, s:s, s:I, s:o, s:o, s:o, s:o, s:o, s:o}", "method", row->row->name,
                  "scene", row->scene, "particles", (json_int_t)row->particles, "step_ns",
                  cli_json_real(row->step), "forces_per_step", cli_json_real(row->forces),
                  "forces_ns", cli_json_real(row->force), "overhead_ns", cli_json_real(beyond(row)),
                  "overhead_share", cli_json_real(beyond(row) / row->step), "overhead_ns_per_force",
                  cli_json_real(beyond_each(row)));
    if (has_target(row)) {
        json_object_set_new(object, "target_ns_per_force", json_real(most_overhead));
        json_object_set_new(object, "target_met", json_boolean(meets(row)));
    }
    return object;
}

static json_t *peer_json(const dl_bench_peer *row) {
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:I, s:I}", "method", row->method, "peer",
                     "GSL's driver by hand", "scene", row->scene, "step_ns",
                     cli_json_real(row->ours), "peer_ns", cli_json_real(row->theirs), "ratio",
                     spread_json(row->ratio), "forces", (json_int_t)row->our_evaluations,
                     "peer_forces", (json_int_t)row->their_evaluations);
}

static json_t *start_json(const dl_bench_start *row) {
    return json_pack("{s:s, s:I, s:o, s:o, s:f, s:b}", "scene", row->scene, "particles",
                     (json_int_t)row->particles, "cpu_seconds", spread_json(row->cpu),
                     "wall_seconds", spread_json(row->wall), "target", most_start, "target_met",
                     (int)(row->cpu.minimum <= most_start));
}

dl_status cli_benchmark_json(const cli_benchmark *all, FILE *out, dl_error *error) {
    json_t *const facts = json_object(), *const speeds = json_array(),
                  *const overheads = json_array(), *const peers = json_array(),
                  *const starts = json_array();
    for (size_t k = 0; k < all->facts->facts; k++)
        json_object_set_new(facts, all->facts->fact[k].name,
                            json_string(all->facts->fact[k].value));
    for (size_t k = 0; k < all->speeds; k++)
        json_array_append_new(speeds, speed_json(&all->speed[k]));
    for (size_t k = 0; k < all->overheads; k++)
        json_array_append_new(overheads, overhead_json(&all->overhead[k]));
    for (size_t k = 0; k < all->peers; k++)
        json_array_append_new(peers, peer_json(&all->peer[k]));
    for (size_t k = 0; k < all->starts; k++)
        json_array_append_new(starts, start_json(&all->start[k]));
    return cli_json_print(
        json_pack("{s:s, s:o, s:I, s:f, s:o, s:o, s:o, s:o}", "benchmark", "program", "facts",
                  facts, "repeats", (json_int_t)all->effort.repeats, "seconds", all->effort.seconds,
                  "speed", speeds, "overhead", overheads, "gsl", peers, "start", starts),
        out, error);
}
