/* From the start of a process to its end after one step: loading, reading, set-up. */
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

#include "bench/bench.h"

static double wall_clock(void) {
    struct timespec now = {0};
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double seconds_of(struct timeval time) {
    return (double)time.tv_sec + 1e-6 * (double)time.tv_usec;
}

/* In the child: never returns. */
static void become_driftlab(const char *scene, const char *end) {
    const int nowhere = open("/dev/null", O_WRONLY);
    if (nowhere >= 0)
        dup2(nowhere, STDOUT_FILENO);
    execl("/proc/self/exe", "driftlab", "run", scene, "--method", "leapfrog", "--t-end", end,
          (char *)NULL);
    _exit(127);
}

static dl_status start_once(const char *scene, const char *end, double *cpu, double *wall,
                            dl_error *error) {
    struct rusage used;
    int result = 0;
    const double began = wall_clock();
    const pid_t child = fork();
    if (child == 0)
        become_driftlab(scene, end);
    if (child < 0 || wait4(child, &result, 0, &used) != child)
        return dl_fail(error, DL_ERROR, "no process could be started: %s", strerror(errno));
    *wall = wall_clock() - began;
    *cpu = seconds_of(used.ru_utime) + seconds_of(used.ru_stime);
    if (!WIFEXITED(result) || WEXITSTATUS(result) != 0)
        return dl_fail(error, DL_ERROR, "driftlab run %s --t-end %s did not end well", scene, end);
    return DL_OK;
}

static dl_status measure(const dl_scene *scene, const char *file, size_t repeats,
                         dl_bench_start *row, dl_error *error) {
    dl_bench_times cpu = {.count = 0}, wall = {.count = 0};
    char end[32];
    double c = 0, w = 0;
    snprintf(end, sizeof end, "%.17g", scene->step);
    dl_status status = start_once(file, end, &c, &w, error); /* its files are in memory now */
    for (size_t k = 0; k < repeats && !status; k++) {
        status = start_once(file, end, &c, &w, error);
        dl_bench_add(&cpu, c);
        dl_bench_add(&wall, w);
    }
    if (status)
        return status;
    *row = (dl_bench_start){.scene = scene->name,
                            .particles = scene->particles,
                            .cpu = dl_bench_spread_of(&cpu),
                            .wall = dl_bench_spread_of(&wall)};
    return DL_OK;
}

dl_status dl_bench_measure_starts(const dl_bench_scenes *scenes, const dl_bench_effort *effort,
                                  dl_bench_start rows[DL_BENCH_MOST_ROWS], size_t *count,
                                  dl_error *error) {
    const dl_scene *const on[] = {scenes->stream, scenes->swirl, scenes->fluid};
    dl_status status = DL_OK;
    fflush(NULL); /* or the children would write it again */
    for (*count = 0; *count < sizeof on / sizeof *on && !status; (*count)++)
        status = measure(on[*count], scenes->file[*count], effort->starts, &rows[*count], error);
    return status;
}
