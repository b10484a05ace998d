/* What was measured, as a table for people, as JSON, and as the folder's README. */
#ifndef BENCH_PRESENT_H
#define BENCH_PRESENT_H

#include <jansson.h>
#include <stdarg.h>
#include <stdio.h>
#include "driftlab/results.h"
#include "rows.h"

enum { COLUMNS = 10, CELL = 64 };

typedef char table_row[COLUMNS][CELL];

static bool has_baseline(const bench_row *row) {
    return row->baseline && row->baseline->count > 0;
}

/* Noise only ever makes things slower: a target that the median misses and the best repeat meets
 * is told apart from one that is missed. */
static const char *verdict(bool median_meets, bool best_meets) {
    return median_meets ? "yes" : best_meets ? "best repeat only" : "no";
}

static const char *time_verdict(const bench_row *row) {
    const spread time = samples_spread(&row->times);
    return verdict(time.median <= row->target, time.minimum <= row->target);
}

static const char *ratio_verdict(const bench_row *row) {
    const spread ratio = samples_ratio(row->baseline, &row->times);
    return verdict(ratio.median >= row->target_ratio, ratio.maximum >= row->target_ratio);
}

/* --- table ---------------------------------------------------------------------------------- */

static const table_row heading = {"case",    "with",    "unit",       "minimum", "median",
                                  "against", "its min", "its median", "ratio",   "target"};

static void fill_baseline(const bench_row *row, table_row cell) {
    const spread its = samples_spread(row->baseline);
    const spread ratio = samples_ratio(row->baseline, &row->times);
    snprintf(cell[5], CELL, "%s", row->baseline_name);
    snprintf(cell[6], CELL, "%.3g", its.minimum);
    snprintf(cell[7], CELL, "%.3g", its.median);
    snprintf(cell[8], CELL, "%.2f (%.2f to %.2f)", ratio.median, ratio.minimum, ratio.maximum);
}

static void fill_row(const bench_row *row, table_row cell) {
    const spread time = samples_spread(&row->times);
    memset(cell, 0, sizeof(table_row));
    snprintf(cell[0], CELL, "%s", row->what);
    snprintf(cell[1], CELL, "%s%s", row->how, row->chosen ? " (chosen)" : "");
    snprintf(cell[2], CELL, "%s", row->unit);
    snprintf(cell[3], CELL, "%.3g", time.minimum);
    snprintf(cell[4], CELL, "%.3g", time.median);
    if (has_baseline(row))
        fill_baseline(row, cell);
    int used = 0;
    if (row->target > 0)
        used = snprintf(cell[9], CELL, "<= %.3g: %s", row->target, time_verdict(row));
    if (row->target_ratio > 0 && has_baseline(row))
        snprintf(cell[9] + used, CELL - (size_t)used, "; ratio >= %.2f: %s", row->target_ratio,
                 ratio_verdict(row));
}

static void print_cells(FILE *out, const table_row cell, const size_t width[COLUMNS]) {
    for (int c = 0; c < COLUMNS; c++)
        fprintf(out, "| %-*s ", (int)width[c], cell[c]);
    fprintf(out, "|\n");
}

/* A Markdown table that is aligned for a terminal as well. */
static void present_table(FILE *out, const bench *all) {
    static table_row cells[BENCH_MAX_ROWS];
    size_t width[COLUMNS];
    for (int c = 0; c < COLUMNS; c++)
        width[c] = strlen(heading[c]);
    for (size_t k = 0; k < all->rows; k++) {
        fill_row(&all->row[k], cells[k]);
        for (int c = 0; c < COLUMNS; c++)
            width[c] = strlen(cells[k][c]) > width[c] ? strlen(cells[k][c]) : width[c];
    }
    print_cells(out, heading, width);
    for (int c = 0; c < COLUMNS; c++) {
        fprintf(out, "|");
        for (size_t k = 0; k < width[c] + 2; k++)
            fprintf(out, "-");
    }
    fprintf(out, "|\n");
    for (size_t k = 0; k < all->rows; k++)
        print_cells(out, cells[k], width);
}

/* What LAMMPS ran, and that it was the same physics. */
static void present_peer(FILE *out, const bench *all) {
    if (!all->peer_found) {
        fprintf(out, "LAMMPS: skipped, for there is no program `lmp` (Debian's package lammps).\n");
        return;
    }
    fprintf(out, "LAMMPS (%s):\n\n", all->peer[0].result.version);
    for (size_t p = 0; p < all->peers; p++) {
        const peer *lammps = &all->peer[p];
        fprintf(out,
                "- %s: pair_style table %s %d, skin %.3g, %zu steps; its forces at step 0 differ "
                "from ours by %.1e (relative, L2; more than %.0e is refused)",
                lammps->what, lammps->job.table.style, lammps->job.table.entries, lammps->job.skin,
                lammps->job.steps, lammps->result.force_difference, lammps_force_tolerance);
        if (!isnan(lammps->our_kinetic))
            fprintf(out,
                    "; at the end its kinetic energy per particle is %.3g (ours %.3g), it built "
                    "its list %lu times (ours %lu)",
                    lammps->result.kinetic, lammps->our_kinetic, lammps->result.builds,
                    lammps->our_builds);
        fprintf(out, ".\n");
    }
}

static void present_trials(FILE *out, const peer *lammps) {
    fprintf(out, "\n| %s: table | skin | force difference | minimum, ns |\n|---|---|---|---|\n",
            lammps->what);
    for (size_t k = 0; k < lammps->trials; k++) {
        const trial *one = &lammps->trial[k];
        fprintf(out, "| %s %d | %.3g | %.1e | ", one->table.style, one->table.entries, one->skin,
                one->force_difference);
        if (isnan(one->time))
            fprintf(out, "refused |\n");
        else
            fprintf(out, "%.3g |\n", one->time);
    }
}

/* --- JSON ----------------------------------------------------------------------------------- */

static json_t *json_spread(const samples *times) {
    const spread s = samples_spread(times);
    return json_pack("{s:f, s:f, s:f}", "minimum", s.minimum, "median", s.median, "maximum",
                     s.maximum);
}

static json_t *json_row(const bench_row *row) {
    json_t *object =
        json_pack("{s:s, s:s, s:s, s:b, s:s, s:i, s:o}", "case", row->what, "scene",
                  row->scene->name, "with", row->how, "chosen", (int)row->chosen, "unit", row->unit,
                  "repeats", (int)row->times.count, "time", json_spread(&row->times));
    if (has_baseline(row)) {
        const spread ratio = samples_ratio(row->baseline, &row->times);
        json_object_set_new(object, "baseline", json_string(row->baseline_name));
        json_object_set_new(object, "baseline_time", json_spread(row->baseline));
        json_object_set_new(object, "ratio",
                            json_pack("{s:f, s:f, s:f}", "minimum", ratio.minimum, "median",
                                      ratio.median, "maximum", ratio.maximum));
    }
    if (row->target > 0) {
        json_object_set_new(object, "target", json_real(row->target));
        json_object_set_new(object, "target_met", json_string(time_verdict(row)));
    }
    if (row->target_ratio > 0 && has_baseline(row)) {
        json_object_set_new(object, "target_ratio", json_real(row->target_ratio));
        json_object_set_new(object, "target_ratio_met", json_string(ratio_verdict(row)));
    }
    return object;
}

static json_t *json_peer(const peer *lammps) {
    json_t *object =
        json_pack("{s:s, s:s, s:s, s:i, s:f, s:i, s:f, s:i}", "case", lammps->what, "version",
                  lammps->result.version, "table", lammps->job.table.style, "entries",
                  lammps->job.table.entries, "skin", lammps->job.skin, "steps",
                  (int)lammps->job.steps, "force_difference", lammps->result.force_difference,
                  "list_builds", (int)lammps->result.builds);
    json_object_set_new(object, "kinetic_energy_per_particle", json_real(lammps->result.kinetic));
    return object;
}

static int present_json(FILE *out, const bench *all, const dl_results *provenance) {
    json_t *facts = json_object(), *rows = json_array(), *peers = json_array();
    for (size_t k = 0; k < provenance->facts; k++)
        json_object_set_new(facts, provenance->fact[k].name,
                            json_string(provenance->fact[k].value));
    for (size_t k = 0; k < all->rows; k++)
        json_array_append_new(rows, json_row(&all->row[k]));
    for (size_t p = 0; p < all->peers && all->peer_found; p++)
        json_array_append_new(peers, json_peer(&all->peer[p]));
    json_t *whole = json_pack("{s:s, s:o, s:s, s:o, s:o}", "benchmark", "force", "facts", facts,
                              "lammps", all->peer_found ? "measured" : "skipped: no program lmp",
                              "lammps_runs", peers, "rows", rows);
    const int failed = !whole || json_dumpf(whole, out, JSON_INDENT(2)) != 0;
    fprintf(out, "\n");
    json_decref(whole);
    return failed;
}

/* --- README --------------------------------------------------------------------------------- */

static const char readme_method[] =
    "Times are CPU times of one pinned process, of the integration or the forces alone: ours by\n"
    "the process's clock, LAMMPS's the smaller of its own loop time and the CPU time it used from\n"
    "before to after the run, set-up included. Our runs and LAMMPS's take turns; a ratio is the\n"
    "other's time over ours within one repeat, shown as the median and the range over the\n"
    "repeats.\n"
    "\n"
    "LAMMPS runs the same particles, velocities, step, gravity and walls with the same pair law "
    "as\n"
    "a table, on one process, list checked at every step, thermodynamic output off. Its time is\n"
    "that of whole steps; our swirl time is that of the forces (which are 98 % of LAMMPS's "
    "there).\n"
    "Its reflecting walls take no energy as ours do; a viscous drag keeps its fluid near our\n"
    "kinetic energy instead. Without it the fluid heats up fivefold and its lists are built more\n"
    "often, in about the same time.\n"
    "\n"
    "Loops by hand (`bench/by_hand.h`) do one scene each and are compiled as ours are, plainly;\n"
    "what a scene lacks costs nothing where ours take at most a twentieth more.\n";

static void present_readme(FILE *out, const bench *all, const dl_results *provenance) {
    fprintf(out, "# Forces and leap-frog against the clock\n\nWritten by the benchmark itself; do "
                 "not edit, run it again:\n\n    build/bench_force --readme bench/README.md\n\n");
    for (size_t k = 0; k < provenance->facts; k++)
        if (strcmp(provenance->fact[k].name, "command") != 0)
            fprintf(out, "- %s: %s\n", provenance->fact[k].name, provenance->fact[k].value);
    fprintf(out, "- repeats: %zu\n\n## How it is measured\n\n%s\n## What came out\n\n",
            all->effort.repeats, readme_method);
    present_table(out, all);
    fprintf(out, "\n");
    present_peer(out, all);
    if (!all->peer_found)
        return;
    fprintf(out, "\n## How LAMMPS's settings were found\n\nThe fastest whose forces are ours.\n");
    for (size_t p = 0; p < all->peers; p++)
        if (!all->peer[p].like)
            present_trials(out, &all->peer[p]);
    fprintf(
        out,
        "\n## Instructions\n\n`bench/callgrind.sh` counts the instructions of these loops under "
        "valgrind, where noise\ndoes not reach; the test `test_instructions` holds them to "
        "bounds, and to the loops by hand.\n");
}

#endif
