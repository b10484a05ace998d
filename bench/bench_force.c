/* Leap-frog on the settled fluid of TR323 and the swirl forces of TR299 by the clock, for every
 * instruction set and kernel, and LAMMPS beside them where it is installed; and scenes that lack
 * something beside loops written by hand for them. */
#define _GNU_SOURCE /* sched_setaffinity */
#include <errno.h>
#include <getopt.h>
#include <sched.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/version.h"
#include "present.h"
#include "rows.h"
#include "study/facts.h"

static const char usage[] =
    "usage: bench_force [--quick] [--json] [--readme FILE]\n"
    "       bench_force --loop NAME [--isa plain|avx2|avx512] [--count N]\n"
    "\n"
    "  --quick        a smoke run of seconds; its times mean nothing\n"
    "  --json         one JSON object instead of the table\n"
    "  --readme FILE  writes what was measured to FILE as well\n"
    "  --loop NAME    only runs the loop N times, for an instruction counter: steps of fluid, "
    "free,\n"
    "                 free-verlet, falling or stream, or of the loops by hand beside them\n"
    "                 (free-by-hand, falling-by-hand, stream-by-hand), or of layer-1e4, "
    "layer-1e5,\n"
    "                 crystal-1e4, crystal-1e5 or crystal-1e6, or swirl's forces; prints its "
    "units\n"
    "                 and the build\n";

typedef struct settings {
    bool quick, json, help;
    const char *readme, *loop, *isa;
    size_t count;
} settings;

static bool read_count(const char *text, size_t *count) {
    char *end = NULL;
    errno = 0;
    const unsigned long value = strtoul(text, &end, 10);
    *count = value;
    return end != text && *end == '\0' && errno == 0 && value > 0;
}

static bool read_settings(int argc, char **argv, settings *set) {
    static const struct option options[] = {
        {"quick", no_argument, NULL, 'q'},       {"json", no_argument, NULL, 'j'},
        {"help", no_argument, NULL, 'h'},        {"readme", required_argument, NULL, 'r'},
        {"loop", required_argument, NULL, 'l'},  {"isa", required_argument, NULL, 'i'},
        {"count", required_argument, NULL, 'c'}, {NULL, 0, NULL, 0}};
    bool good = true;
    int option;
    *set = (settings){.count = 100};
    while (good && (option = getopt_long(argc, argv, "", options, NULL)) != -1) {
        set->quick |= option == 'q';
        set->json |= option == 'j';
        set->help |= option == 'h';
        if (option == 'r')
            set->readme = optarg;
        else if (option == 'l')
            set->loop = optarg;
        else if (option == 'i')
            set->isa = optarg;
        else if (option == 'c')
            good = read_count(optarg, &set->count);
        else if (option == '?')
            good = false;
    }
    return good && optind == argc;
}

/* To the processor it is on: the one that the kernel thought free. LAMMPS inherits it. */
static void pin(void) {
    const int processor = sched_getcpu();
    if (processor < 0)
        return;
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET((size_t)processor, &set);
    if (sched_setaffinity(0, sizeof set, &set) != 0)
        fprintf(stderr, "bench_force: not pinned: %s\n", strerror(errno));
}

static const char *build_type(void) {
    dl_component component[DL_MAX_COMPONENTS];
    const size_t count = dl_components(component);
    for (size_t k = 0; k < count; k++)
        if (strcmp(component[k].name, "build") == 0)
            return component[k].version;
    return "unknown";
}

static bool sanitised(void) {
#ifdef DL_SANITIZED
    return true;
#else
    return false;
#endif
}

/* --- one loop, for an instruction counter ---------------------------------------------------- */

/* Steps of a scene by a method, or by a loop that is written for it. */
typedef struct counted_loop {
    const char *name, *scene, *method;
    by_hand_loop *by_hand;
    dl_let let[2]; /* of the scene's numbers; the others as its file says */
    size_t lets;
} counted_loop;

#define DROP       DL_STUDIES "/drop/settled.yaml"
#define FREE       DL_STUDIES "/leave-outs/free.yaml"
#define FALLING    DL_STUDIES "/leave-outs/falling.yaml"
#define STREAM     DL_STUDIES "/stream/stream.yaml"
#define SWIRL      DL_STUDIES "/swirl/swirl.yaml"
#define LAYER      DL_BENCH "/scenes/layer.yaml"
#define CRYSTAL    DL_BENCH "/scenes/crystal.yaml"
#define SIZE(a, b) .let = {{"columns", a}, {"rows", b}}, .lets = 2

static const counted_loop loops[] = {
    {.name = "fluid", .scene = DROP, .method = "leapfrog"},
    {.name = "free", .scene = FREE, .method = "leapfrog"},
    {.name = "free-verlet", .scene = FREE, .method = "composition-2-verlet"},
    {.name = "free-by-hand", .scene = FREE, .by_hand = by_hand_free},
    {.name = "falling", .scene = FALLING, .method = "leapfrog"},
    {.name = "falling-by-hand", .scene = FALLING, .by_hand = by_hand_falling},
    {.name = "stream", .scene = STREAM, .method = "leapfrog"},
    {.name = "stream-by-hand", .scene = STREAM, .by_hand = by_hand_stream},
    {.name = "swirl", .scene = SWIRL}, /* forces */
    {.name = "layer-1e4", .scene = LAYER, .method = "leapfrog", SIZE("1429", "7")},
    {.name = "layer-1e5", .scene = LAYER, .method = "leapfrog", SIZE("14286", "7")},
    {.name = "crystal-1e4", .scene = CRYSTAL, .method = "leapfrog", SIZE("108", "92")},
    {.name = "crystal-1e5", .scene = CRYSTAL, .method = "leapfrog", SIZE("340", "294")},
    {.name = "crystal-1e6", .scene = CRYSTAL, .method = "leapfrog", SIZE("1075", "930")},
};

static dl_status loop_forces(const dl_scene *scene, size_t count, dl_error *error) {
    ours_force force = {NULL, NULL, NULL, 0};
    double seconds = 0;
    dl_status status = ours_force_create(scene, &force, error);
    force.calls = count;
    if (!status)
        status = ours_force_measure(&force, &seconds, error);
    ours_force_release(&force);
    return status;
}

static dl_status loop_run(const counted_loop *loop, size_t count, double *units, dl_error *error) {
    dl_scene *scene = NULL;
    dl_run_summary summary;
    double seconds;
    dl_status status = dl_scene_read_let(loop->scene, loop->lets, loop->let, &scene, error);
    if (status)
        return status;
    const size_t n = scene->particles;
    *units = (double)(n * count);
    if (loop->by_hand)
        status = by_hand_run(scene, loop->by_hand, count, &seconds, NULL, error);
    else if (loop->method)

        status = ours_run(scene, loop->method, count, &summary, NULL, error);
    else {
        status = loop_forces(scene, count, error);
        *units *= (double)(n - 1); /* ordered pairs */
    }
    dl_scene_free(scene);
    return status;
}

static int run_loop(const settings *set) {
    dl_error error = {""};
    double units = 0;
    const counted_loop *loop = NULL;
    for (size_t k = 0; k < sizeof loops / sizeof *loops; k++)
        if (strcmp(set->loop, loops[k].name) == 0)
            loop = &loops[k];
    if (!loop) {
        fprintf(stderr, "bench_force: --loop: found \"%s\", expected one of", set->loop);
        for (size_t k = 0; k < sizeof loops / sizeof *loops; k++)
            fprintf(stderr, " %s", loops[k].name);
        fprintf(stderr, "\n");
        return 2;
    }
    if (!dl_vector_force(set->isa)) {
        fprintf(stderr, "bench_force: --isa: \"%s\" cannot run here\n", set->isa);
        return 2;
    }
    if (loop_run(loop, set->count, &units, &error)) {
        fprintf(stderr, "bench_force: %s\n", error.message);
        return 1;
    }
    printf("loop %s isa %s units %.0f build %s sanitised %s\n", set->loop, dl_vector_best()->name,
           units, build_type(), sanitised() ? "yes" : "no");
    return 0;
}

/* --- the benchmark --------------------------------------------------------------------------- */

static dl_status write_readme(const char *path, const bench *all, const dl_results *provenance,
                              dl_error *error) {
    FILE *out = fopen(path, "w");
    if (!out)
        return dl_fail(error, DL_IO, "%s: %s", path, strerror(errno));
    present_readme(out, all, provenance);
    return fclose(out) == 0 ? DL_OK : dl_fail(error, DL_IO, "%s: %s", path, strerror(errno));
}

static dl_status present(const settings *set, const bench *all, dl_error *error) {
    dl_results *provenance = NULL;
    dl_status status = dl_results_create(&provenance, error);
    if (!status)
        status =
            dl_facts_add(provenance, set->quick ? "bench_force --quick" : "bench_force", error);
    if (!status && set->json) {
        if (present_json(stdout, all, provenance))
            status = dl_fail(error, DL_IO, "the JSON could not be written");
    } else if (!status) {
        present_table(stdout, all);
        printf("\n");
        present_peer(stdout, all);
    }
    if (!status && set->readme)
        status = write_readme(set->readme, all, provenance, error);
    dl_results_free(provenance);
    return status;
}

static int run_benchmark(const settings *set) {
    static bench all;
    dl_error error = {""};
    if (sanitised() || strcmp(build_type(), "Release") != 0)
        fprintf(stderr, "bench_force: not a plain Release build: its times mean nothing\n");
    pin();
    dl_status status = bench_create(&all, set->quick ? effort_quick : effort_full, &error);
    if (!status)
        status = bench_measure(&all, &error);
    if (!status)
        status = present(set, &all, &error);
    if (status)
        fprintf(stderr, "bench_force: %s\n", error.message);
    bench_release(&all);
    return status ? 1 : 0;
}

int main(int argc, char **argv) {
    settings set;
    if (!read_settings(argc, argv, &set)) {
        fputs(usage, stderr);
        return 2;
    }
    if (set.help) {
        fputs(usage, stdout);
        return 0;
    }
    return set.loop ? run_loop(&set) : run_benchmark(&set);
}
