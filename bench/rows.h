/* The benchmark's rows: what is timed, against what, with which target; and LAMMPS beside them. */
#ifndef BENCH_ROWS_H
#define BENCH_ROWS_H

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include "by_hand.h"
#include "driftlab/scene.h"
#include "force/vector_ops.h"
#include "lammps.h"
#include "ours.h"
#include "samples.h"

enum {
    BENCH_MAX_ROWS = 40,
    BENCH_MAX_TRIALS = 32,
    BENCH_SCENES = 5,
    BENCH_KERNEL_SCENES = 3,
    BENCH_LARGE = 5,
    BENCH_PEERS = 2 + BENCH_LARGE
};

typedef struct effort {
    size_t repeats;
    double force_seconds; /* of one measurement of a force */
    size_t fluid_steps, swirl_steps;
    size_t scan_repeats;  /* of each candidate of LAMMPS; 0: the first that is equal physics */
    double by_hand_moves; /* of a particle by a step, in one measurement */
    double large_moves;   /* the same of a large scene */
    size_t largest;       /* particles of those that are measured */
    size_t large_repeats; /* of those with more than 10^4 particles */
} effort;

static const effort effort_full = {15, 0.01, 30000, 500, 2, 1e7, 4e7, 1000000, 3};
static const effort effort_quick = {2, 0.0005, 500, 20, 0, 1e5, 1e5, 12000, 2};

/* A candidate for LAMMPS's settings and what came of it. */
typedef struct trial {
    lammps_table table;
    double skin, time; /* ns a unit, the minimum; NaN: not timed, for the physics was another */
    double force_difference;
} trial;

typedef struct peer peer;
struct peer {
    const char *what;
    const peer *like; /* whose table and skin it has; NULL: its own are looked for */
    lammps_job job;
    double units; /* in a run */
    char name[64];
    size_t trials;
    trial trial[BENCH_MAX_TRIALS];
    lammps_result result; /* of the last run */
    double our_kinetic;   /* energy per particle after the same steps; NaN: not compared */
    unsigned long our_builds;
    samples times; /* ns a unit */
};

typedef struct bench_row {
    const char *what, *unit;
    char how[64]; /* kernel, instruction set */
    bool chosen;  /* what a user gets */
    dl_scene *scene;
    dl_kernel_choice kernel;
    const char *isa;
    size_t steps; /* of `method`; 0: force evaluations */
    const char *method;
    by_hand_loop *by_hand;       /* in the place of the method; NULL: not */
    double units;                /* in a run or an evaluation */
    double target, target_ratio; /* ns a unit at most, ratio at least; 0: none */
    size_t repeats;              /* at most; 0: all */
    ours_force force;
    samples times;           /* ns a unit */
    const samples *baseline; /* of the ratio; NULL or empty: none */
    const char *baseline_name;
} bench_row;

typedef struct bench {
    effort effort;
    dl_scene *scene[BENCH_SCENES], *large[BENCH_LARGE];
    size_t rows;
    bench_row row[BENCH_MAX_ROWS];
    size_t peers;
    peer peer[BENCH_PEERS];
    size_t peer_after[BENCH_PEERS]; /* the row it is timed after */
    bool peer_found;
} bench;

/* --- rows ----------------------------------------------------------------------------------- */

static const char *const isas[] = {"plain", "avx2", "avx512"};

static const char *best_isa(void) {
    dl_vector_force(NULL);
    return dl_vector_best()->name;
}

/* Model and name of a row. DL_INPUT where the kernel cannot do the scene. */
static dl_status row_prepare(bench_row *row, dl_error *error) {
    dl_vector_force(row->isa);
    row->scene->kernel = row->kernel;
    const dl_status status = ours_force_create(row->scene, &row->force, error);
    row->scene->kernel = DL_KERNEL_AUTO;
    dl_vector_force(NULL);
    if (status)
        return status;
    const char *kernel = row->force.model->kernel->ops->name;
    const bool vectors = row->kernel != DL_KERNEL_REFERENCE;
    snprintf(row->how, sizeof row->how, "%s%s%s", kernel, vectors ? ", " : "",
             vectors ? row->isa : "");
    return DL_OK;
}

static dl_status row_measure(const bench_row *row, double *nanoseconds, dl_error *error) {
    dl_status status;
    if (row->by_hand) {
        status = by_hand_run(row->scene, row->by_hand, row->steps, nanoseconds, NULL, error);
        *nanoseconds *= 1e9 / row->units;
    } else if (row->steps) {
        dl_run_summary summary;
        dl_vector_force(row->isa);
        status = ours_run(row->scene, row->method, row->steps, &summary, NULL, error);
        dl_vector_force(NULL);
        *nanoseconds = summary.cpu_seconds * 1e9 / row->units;
    } else {
        status = ours_force_measure(&row->force, nanoseconds, error);
        *nanoseconds *= 1e9 / row->units;
    }
    return status;
}

/* What is the same for all instruction sets of one target. */
static dl_status add_target_rows(bench *all, bench_row like, const peer *against, dl_error *error) {
    dl_status status = DL_OK;
    const double target = like.target, target_ratio = like.target_ratio;
    for (size_t k = 0; k < sizeof isas / sizeof *isas && !status; k++) {
        if (!dl_vector_force(isas[k]))
            continue;
        like.isa = isas[k];
        like.chosen = strcmp(isas[k], best_isa()) == 0;
        like.target = like.chosen ? target : 0;
        like.target_ratio = like.chosen ? target_ratio : 0;
        like.baseline = &against->times;
        like.baseline_name = against->name;
        bench_row *row = &all->row[all->rows++];
        *row = like;
        status = row_prepare(row, error);
    }
    return status;
}

/* Every kernel on the scene, against the reference one. */
static dl_status add_kernel_rows(bench *all, dl_scene *scene, dl_error *error) {
    static const dl_kernel_choice kernels[] = {DL_KERNEL_REFERENCE, DL_KERNEL_ALL_PAIRS,
                                               DL_KERNEL_NEIGHBOUR_LIST};
    const bool cut = isfinite(scene->law.piece[scene->law.pieces - 1].until);
    const samples *reference = NULL;
    dl_status status = DL_OK;
    for (size_t k = 0; k < 3 && !status; k++) {
        if (kernels[k] == DL_KERNEL_NEIGHBOUR_LIST && !cut)
            continue;
        bench_row *row = &all->row[all->rows++];
        *row = (bench_row){.what = scene->name,
                           .unit = "ns/particle",
                           .scene = scene,
                           .kernel = kernels[k],
                           .isa = best_isa(),
                           .units = (double)scene->particles,
                           .baseline = reference,
                           .baseline_name = "the reference kernel"};
        status = row_prepare(row, error);
        reference = &all->row[all->rows - 1 - k].times;
    }
    return status;
}

/* --- the two targets ------------------------------------------------------------------------ */

/* The walls take energy from our fluid at each bounce; LAMMPS's reflecting walls do not, and the
 * fluid, which the jump of the force at the cutoff heats, would boil. This drag keeps it near
 * the kinetic energy it has with us. */
static const double fluid_drag = 9;

static dl_status add_fluid(bench *all, dl_scene *scene, dl_error *error) {
    const size_t steps = all->effort.fluid_steps;
    const double units = (double)(steps * scene->particles);
    peer *lammps = &all->peer[all->peers];
    *lammps =
        (peer){.what = "leap-frog", .job = {scene, {0}, 0, fluid_drag, steps}, .units = units};
    const bench_row like = {.what = "leap-frog, settled fluid",
                            .unit = "ns/particle/step",
                            .scene = scene,
                            .steps = steps,
                            .method = "leapfrog",
                            .units = units,
                            .target = 12,
                            .target_ratio = 2.4};
    const dl_status status = add_target_rows(all, like, lammps, error);
    all->peer_after[all->peers++] = all->rows - 1;
    return status;
}

static dl_status add_swirl(bench *all, dl_scene *scene, dl_error *error) {
    const size_t steps = all->effort.swirl_steps, n = scene->particles;
    const double pairs = (double)(n * (n - 1));
    peer *lammps = &all->peer[all->peers];
    *lammps = (peer){.what = "forces",
                     .job = {scene, {0}, 0, 0, steps},
                     .units = pairs * (double)steps,
                     .our_kinetic = NAN};
    const bench_row like = {.what = "forces, swirl",
                            .unit = "ns/ordered pair",
                            .scene = scene,
                            .units = pairs,
                            .target = 0.4};
    const dl_status status = add_target_rows(all, like, lammps, error);
    all->peer_after[all->peers++] = all->rows - 1;
    return status;
}

/* --- large scenes --------------------------------------------------------------------------- */

/* Scenes by rule; the peer's settings are found on the smallest of each kind. */
typedef struct large_case {
    const char *what, *file, *columns, *rows;
    size_t particles;
    double target; /* ns a particle and step */
    int like;      /* place in this table; itself: settings of its own */
} large_case;

static const large_case large_cases[BENCH_LARGE] = {
    {"leap-frog, layer, 10^4", "layer", "1429", "7", 10003, 14, 0},
    {"leap-frog, layer, 10^5", "layer", "14286", "7", 100002, 16, 0},
    {"leap-frog, crystal, 10^4", "crystal", "108", "92", 9936, 25, 2},
    {"leap-frog, crystal, 10^5", "crystal", "340", "294", 99960, 28, 2},
    {"leap-frog, crystal, 10^6", "crystal", "1075", "930", 999750, 33, 2},
};

static dl_status add_large(bench *all, size_t number, dl_error *error) {
    const large_case *one = &large_cases[number];
    const dl_let size[] = {{"columns", one->columns}, {"rows", one->rows}};
    char file[512];
    if (one->particles > all->effort.largest)
        return DL_OK;
    snprintf(file, sizeof file, "%s/scenes/%s.yaml", DL_BENCH, one->file);
    const dl_status status = dl_scene_read_let(file, 2, size, &all->large[number], error);
    if (status)
        return status;
    dl_scene *scene = all->large[number];
    const size_t steps = (size_t)(all->effort.large_moves / (double)scene->particles) + 1;
    const size_t repeats = scene->particles > 20000 ? all->effort.large_repeats : 0;
    const double units = (double)(steps * scene->particles);
    peer *lammps = &all->peer[all->peers];
    *lammps = (peer){
        .what = one->what,
        .job = {.scene = scene, .drag = scene->walls.present ? fluid_drag : 0, .steps = steps},
        .units = units,
        .our_kinetic = NAN};
    for (size_t p = 0; p < all->peers && one->like != (int)number; p++)
        if (all->peer[p].what == large_cases[one->like].what)
            lammps->like = &all->peer[p];
    bench_row *row = &all->row[all->rows];
    *row = (bench_row){.what = one->what,
                       .unit = "ns/particle/step",
                       .chosen = true,
                       .isa = best_isa(),
                       .scene = scene,
                       .steps = steps,
                       .method = "leapfrog",
                       .units = units,
                       .repeats = repeats,
                       .target = one->target,
                       .baseline = &lammps->times,
                       .baseline_name = lammps->name};
    snprintf(row->how, sizeof row->how, "neighbour-list, %s", row->isa);
    all->peer_after[all->peers++] = all->rows++;
    return DL_OK;
}

/* --- what is left out ----------------------------------------------------------------------- */

/* A loop written by hand for the scene, and methods beside it. */
typedef struct by_hand_case {
    const char *what;
    int scene; /* place in the benchmark's */
    by_hand_loop *loop;
    const char *method[3]; /* NULL-terminated */
} by_hand_case;

static const by_hand_case by_hand_cases[] = {
    {"nothing acts", 3, by_hand_free, {"leapfrog", "composition-2-verlet"}},
    {"gravity alone", 4, by_hand_falling, {"leapfrog"}},
    {"no walls, stream", 2, by_hand_stream, {"leapfrog"}},
};

static void add_by_hand(bench *all, const by_hand_case *one) {
    dl_scene *scene = all->scene[one->scene];
    const bench_row *hand = &all->row[all->rows];
    const size_t steps = (size_t)(all->effort.by_hand_moves / (double)scene->particles) + 1;
    bench_row row = {.what = one->what,
                     .unit = "ns/particle/step",
                     .how = "a loop by hand",
                     .scene = scene,
                     .steps = steps,
                     .by_hand = one->loop,
                     .units = (double)(steps * scene->particles)};
    all->row[all->rows++] = row;
    row.by_hand = NULL;
    row.baseline = &hand->times;
    row.baseline_name = hand->how;
    row.target_ratio = 1 / 1.05;
    for (int k = 0; one->method[k]; k++) {
        row.method = one->method[k];
        snprintf(row.how, sizeof row.how, "%s", row.method);
        all->row[all->rows++] = row;
    }
}

static dl_status bench_read_scenes(bench *all, dl_error *error) {
    static const char *const file[BENCH_SCENES] = {
        DL_STUDIES "/drop/settled.yaml", DL_STUDIES "/swirl/swirl.yaml",
        DL_STUDIES "/stream/stream.yaml", DL_STUDIES "/leave-outs/free.yaml",
        DL_STUDIES "/leave-outs/falling.yaml"};
    dl_status status = DL_OK;
    for (size_t k = 0; k < BENCH_SCENES && !status; k++)
        status = dl_scene_read(file[k], &all->scene[k], error);
    return status;
}

static dl_status bench_create(bench *all, effort how_long, dl_error *error) {
    memset(all, 0, sizeof *all);
    all->effort = how_long;
    all->peer_found = true;
    dl_status status = bench_read_scenes(all, error);
    if (!status)
        status = add_fluid(all, all->scene[0], error);
    if (!status)
        status = add_swirl(all, all->scene[1], error);
    for (size_t k = 0; k < BENCH_LARGE && !status; k++)
        status = add_large(all, k, error);
    for (size_t k = 0; k < BENCH_KERNEL_SCENES && !status; k++)
        status = add_kernel_rows(all, all->scene[k], error);
    for (size_t k = 0; k < sizeof by_hand_cases / sizeof *by_hand_cases && !status; k++)
        add_by_hand(all, &by_hand_cases[k]);
    return status;
}

static void bench_release(bench *all) {
    for (size_t k = 0; k < all->rows; k++)
        ours_force_release(&all->row[k].force);
    for (size_t k = 0; k < BENCH_SCENES; k++)
        dl_scene_free(all->scene[k]);
    for (size_t k = 0; k < BENCH_LARGE; k++)
        dl_scene_free(all->large[k]);
}

/* --- LAMMPS's best settings ----------------------------------------------------------------- */

/* A table that equals its file's points is taken over as it is; bitmap entries are dense where r
 * is small and are interpolated from the file. */
static const lammps_table tables[] = {{"linear", 4000, 4000},
                                      {"bitmap", 12, 16000},
                                      {"linear", 1000, 1000},
                                      {"linear", 16000, 16000},
                                      {"bitmap", 14, 16000}};

/* Parts of the cutoff. Without one the list holds all pairs whatever the skin. */
static const double skins[] = {0.24, 0.32, 0.4, 0.48, 0.64, 0.8};
static const double skins_uncut[] = {0.5};

static dl_status trial_run(const peer *lammps, size_t repeats, bool *found, trial *one,
                           dl_error *error) {
    lammps_job job = lammps->job;
    job.table = one->table;
    job.skin = one->skin;
    one->time = NAN;
    for (size_t k = 0; k < repeats; k++) {
        lammps_result result;
        const dl_status status = lammps_run(&job, found, &result, error);
        if (status || !*found)
            return status;
        one->force_difference = result.force_difference;
        if (!(result.force_difference <= lammps_force_tolerance))
            return DL_OK;
        one->time = fmin(one->time, result.seconds * 1e9 / lammps->units);
    }
    return DL_OK;
}

static dl_status peer_settle(peer *lammps, dl_error *error) {
    const trial *best = NULL;
    for (size_t k = 0; k < lammps->trials; k++)
        if (!isnan(lammps->trial[k].time) && (!best || lammps->trial[k].time < best->time))
            best = &lammps->trial[k];
    if (!best)
        return dl_fail(error, DL_ERROR,
                       "lmp: %s: no table gives our forces to %g, so nothing is compared",
                       lammps->what, lammps_force_tolerance);
    lammps->job.table = best->table;
    lammps->job.skin = best->skin;
    snprintf(lammps->name, sizeof lammps->name, "LAMMPS table/%s %d", best->table.style,
             best->table.entries);
    return DL_OK;
}

/* Tries tables and skins and keeps the fastest whose forces are ours. */
static dl_status peer_tune(peer *lammps, const effort *how_long, bool *found, dl_error *error) {
    const dl_scene *scene = lammps->job.scene;
    const double cutoff = scene->law.piece[scene->law.pieces - 1].until;
    const size_t count = isfinite(cutoff) ? sizeof skins / sizeof *skins : 1;
    const size_t repeats = how_long->scan_repeats ? how_long->scan_repeats : 1;
    if (lammps->like) {
        lammps->job.table = lammps->like->job.table;
        lammps->job.skin = lammps->like->job.skin;
        memcpy(lammps->name, lammps->like->name, sizeof lammps->name);
        return DL_OK;
    }
    for (size_t t = 0; t < sizeof tables / sizeof *tables; t++)
        for (size_t s = 0; s < count; s++) {
            trial *one = &lammps->trial[lammps->trials];
            *one = (trial){.table = tables[t],
                           .skin = isfinite(cutoff) ? skins[s] * cutoff : skins_uncut[0]};
            const dl_status status = trial_run(lammps, repeats, found, one, error);
            if (status || !*found)
                return status;
            lammps->trials++;
            if (isnan(one->time)) /* another skin has the same forces */
                break;
            if (!how_long->scan_repeats)
                return peer_settle(lammps, error);
        }
    return peer_settle(lammps, error);
}

static dl_status peer_measure(peer *lammps, dl_error *error) {
    bool found = false;
    const dl_status status = lammps_run(&lammps->job, &found, &lammps->result, error);
    if (status)
        return status;
    if (!found)
        return dl_fail(error, DL_ERROR, "lmp is no longer there");
    if (!(lammps->result.force_difference <= lammps_force_tolerance))
        return dl_fail(error, DL_ERROR, "lmp: its forces differ from ours by %.3g",
                       lammps->result.force_difference);
    samples_add(&lammps->times, lammps->result.seconds * 1e9 / lammps->units);
    return DL_OK;
}

/* The state at the end of our run, beside which LAMMPS's is shown. */
static dl_status fluid_end(peer *lammps, dl_error *error) {
    const dl_scene *scene = lammps->job.scene;
    dl_run_summary summary;
    double *y = malloc(4 * scene->particles * sizeof *y);
    if (!y)
        return dl_fail_memory(error, "a final state");
    const dl_status status = ours_run(scene, "leapfrog", lammps->job.steps, &summary, y, error);
    lammps->our_kinetic = ours_kinetic(scene, y);
    lammps->our_builds = summary.neighbour_list_builds;
    free(y);
    return status;
}

/* --- measuring ------------------------------------------------------------------------------ */

static dl_status bench_warm_up(bench *all, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t k = 0; k < all->rows && !status; k++) {
        bench_row *row = &all->row[k];
        double unused = 0;
        status = row->steps ? row_measure(row, &unused, error)
                            : ours_force_calibrate(&row->force, all->effort.force_seconds, error);
    }
    for (size_t p = 0; p < all->peers && !status && all->peer_found; p++)
        status = peer_tune(&all->peer[p], &all->effort, &all->peer_found, error);
    return status ? status : fluid_end(&all->peer[0], error);
}

/* Ours and the peer's in turn, so that both see the same machine. */
static dl_status bench_repeat(bench *all, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t k = 0; k < all->rows && !status; k++) {
        double time = 0;
        if (all->row[k].repeats && all->row[k].times.count == all->row[k].repeats)
            continue;
        status = row_measure(&all->row[k], &time, error);
        samples_add(&all->row[k].times, time);
        for (size_t p = 0; p < all->peers && !status && all->peer_found; p++)
            if (all->peer_after[p] == k)
                status = peer_measure(&all->peer[p], error);
    }
    return status;
}

static dl_status bench_measure(bench *all, dl_error *error) {
    dl_status status = bench_warm_up(all, error);
    for (size_t k = 0; k < all->effort.repeats && !status; k++)
        status = bench_repeat(all, error);
    return status;
}

#endif
