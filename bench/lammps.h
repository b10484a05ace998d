/* LAMMPS on a scene of ours: the same particles, the same pair law as a table, gravity and walls.
 *
 * Everything happens in a temporary folder. What LAMMPS computed at step 0 is compared with our
 * forces, so that only equal physics is ever timed. */
#ifndef BENCH_LAMMPS_H
#define BENCH_LAMMPS_H

#include <errno.h>
#include <ftw.h>
#include <limits.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include "driftlab/model.h"
#include "force/cells.h"
#include "force/law.h"

enum { LAMMPS_MAX_KINDS = 8, LAMMPS_TIME_LIMIT = 300 /* s */, LAMMPS_NOT_FOUND = 127 };

/* Forces that differ by more are not the same physics (relative, L2 over the particles). */
static const double lammps_force_tolerance = 1e-4;

/* A way to tabulate: pair_style table STYLE ENTRIES, from a file of `points` values equally spaced
 * in r^2. Entries that equal the points are taken over as they are. */
typedef struct lammps_table {
    const char *style;
    int entries, points;
} lammps_table;

/* A run to make. */
typedef struct lammps_job {
    const dl_scene *scene; /* two-dimensional, no pins */
    lammps_table table;
    double skin;
    double drag; /* coefficient of fix viscous; 0: none */
    size_t steps;
} lammps_job;

typedef struct lammps_result {
    char version[64];
    double seconds;          /* CPU time of the steps (see lammps_read_clock) */
    double force_difference; /* at step 0, relative */
    double kinetic;          /* energy per particle at the end */
    unsigned long builds;    /* of the neighbour list */
    unsigned long pairs;     /* in the list at the end */
} lammps_result;

/* Particles of one inertia and coupling are a LAMMPS type. */
typedef struct lammps_kinds {
    int count;
    double inertia[LAMMPS_MAX_KINDS], coupling[LAMMPS_MAX_KINDS];
} lammps_kinds;

static int lammps_kind_of(const dl_scene *scene, const lammps_kinds *kinds, size_t i) {
    int k = 0;
    while (k < kinds->count &&
           (kinds->inertia[k] != scene->inertia[i] || kinds->coupling[k] != scene->coupling[i]))
        k++;
    return k;
}

static dl_status lammps_find_kinds(const dl_scene *scene, lammps_kinds *kinds, dl_error *error) {
    kinds->count = 0;
    for (size_t i = 0; i < scene->particles; i++) {
        const int k = lammps_kind_of(scene, kinds, i);
        if (k < kinds->count)
            continue;
        if (k == LAMMPS_MAX_KINDS)
            return dl_fail(error, DL_ERROR, "%s: more than %d kinds of particles", scene->name,
                           LAMMPS_MAX_KINDS);
        kinds->inertia[k] = scene->inertia[i];
        kinds->coupling[k] = scene->coupling[i];
        kinds->count++;
    }
    return DL_OK;
}

/* --- input files ---------------------------------------------------------------------------- */

static void lammps_write_particles(FILE *out, const dl_scene *scene, const lammps_kinds *kinds) {
    const size_t n = scene->particles;
    const double *x = scene->position, *v = scene->velocity;
    fprintf(out, "driftlab %s\n\n%zu atoms\n%d atom types\n", scene->name, n, kinds->count);
    for (size_t c = 0; c < 2; c++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < n; i++) {
            low = fmin(low, x[c * n + i]);
            high = fmax(high, x[c * n + i]);
        }
        const double period = scene->periods.length[c];
        if (period > 0) {
            low = scene->periods.low[c] + 1;
            high = low + period - 2;
        }
        fprintf(out, "%.17g %.17g %clo %chi\n", low - 1, high + 1, "xy"[c], "xy"[c]);
    }
    fprintf(out, "-0.25 0.25 zlo zhi\n\nMasses\n\n");
    for (int k = 0; k < kinds->count; k++)
        fprintf(out, "%d %.17g\n", k + 1, kinds->inertia[k]);
    fprintf(out, "\nAtoms # atomic\n\n");
    for (size_t i = 0; i < n; i++)
        fprintf(out, "%zu %d %.17g %.17g 0\n", i + 1, lammps_kind_of(scene, kinds, i) + 1, x[i],
                x[n + i]);
    fprintf(out, "\nVelocities\n\n");
    for (size_t i = 0; i < n; i++)
        fprintf(out, "%zu %.17g %.17g 0\n", i + 1, v[i], v[n + i]);
}

typedef struct lammps_range {
    double inner, outer;
} lammps_range;

static double lammps_distance(const dl_scene *scene, size_t i, size_t j) {
    double d[2];
    for (size_t c = 0; c < 2; c++) {
        const double period = scene->periods.length[c];
        d[c] =
            scene->position[c * scene->particles + i] - scene->position[c * scene->particles + j];
        if (period > 0)
            d[c] -= period * nearbyint(d[c] / period);
    }
    return hypot(d[0], d[1]);
}

/* The smallest distance, of the pairs that a list has: all may be too many. */
static dl_status lammps_find_nearest(const dl_scene *scene, double reach, double *nearest,
                                     dl_error *error) {
    dl_cells cells = {0};
    dl_list list = {0};
    dl_box box = {0};
    for (int c = 0; c < 2; c++) {
        box.length[c] = scene->periods.length[c];
        box.inverse[c] = box.length[c] > 0 ? 1 / box.length[c] : 0;
    }
    const size_t n = scene->particles;
    const dl_status status = dl_cells_build(&cells, &list, scene->position, 2, n, n, reach,
                                            scene->periods.present ? &box : NULL, error);
    *nearest = reach;
    for (size_t i = 0; i < n && !status; i++)
        for (int k = list.start[i]; k < list.start[i + 1]; k++)
            *nearest = fmin(*nearest, lammps_distance(scene, i, (size_t)list.neighbour[k]));
    dl_cells_release(&cells, &list);
    return status;
}

/* From half the smallest distance to the cutoff, or so far that all pairs act throughout. */
static dl_status lammps_find_range(const dl_scene *scene, const dl_law *law, lammps_range *range,
                                   dl_error *error) {
    const size_t n = scene->particles;
    double farthest = 0;
    for (size_t i = 0; i < n && !law->cut; i++)
        for (size_t j = i + 1; j < n; j++)
            farthest = fmax(farthest, lammps_distance(scene, i, j));
    range->outer = law->cut ? law->until[law->pieces - 1] : 1.5 * farthest;
    const dl_status status = lammps_find_nearest(scene, range->outer, &range->inner, error);
    range->inner /= 2;
    return status;
}

static void lammps_write_law(FILE *out, const dl_law *law, const lammps_kinds *kinds,
                             const lammps_table *table, lammps_range range) {
    const double low = range.inner * range.inner, high = range.outer * range.outer;
    fprintf(out, "# the scene's pair law\n\n");
    for (int a = 0; a < kinds->count; a++)
        for (int b = a; b < kinds->count; b++) {
            const double coupling = kinds->coupling[a] * kinds->coupling[b];
            fprintf(out, "PAIR_%d_%d\nN %d RSQ %.17g %.17g\n\n", a + 1, b + 1, table->points,
                    range.inner, range.outer);
            for (int k = 0; k < table->points; k++) {
                const double s =
                    k == table->points - 1 ? high : low + k * (high - low) / (table->points - 1);
                fprintf(out, "%d %.17g %.17g %.17g\n", k + 1, sqrt(s),
                        coupling * dl_law_potential(law, s),
                        coupling * dl_law_force_over_r(law, s) * sqrt(s));
            }
            fprintf(out, "\n");
        }
}

/* A side with a wall keeps its place, another follows the particles. */
static void lammps_write_walls(FILE *out, const dl_walls *walls) {
    static const char axis[] = "xy";
    fprintf(out, "fix walls all wall/reflect");
    for (int c = 0; c < 2; c++) {
        if (isfinite(walls->low[c]))
            fprintf(out, " %clo %.17g", axis[c], walls->low[c]);
        if (isfinite(walls->high[c]))
            fprintf(out, " %chi %.17g", axis[c], walls->high[c]);
    }
    fprintf(out, "\n");
}

static void lammps_write_forces(FILE *out, const lammps_job *job, const lammps_kinds *kinds,
                                lammps_range range) {
    const dl_scene *scene = job->scene;
    fprintf(out, "pair_style table %s %d\n", job->table.style, job->table.entries);
    for (int a = 1; a <= kinds->count; a++)
        for (int b = a; b <= kinds->count; b++)
            fprintf(out, "pair_coeff %d %d law PAIR_%d_%d %.17g\n", a, b, a, b, range.outer);
    const double gx = scene->gravity[0], gy = scene->gravity[1];
    if (gx != 0 || gy != 0)
        fprintf(out, "fix gravity all gravity %.17g vector %.17g %.17g 0\n", hypot(gx, gy), gx, gy);
    if (job->drag > 0)
        fprintf(out, "fix drag all viscous %.17g\n", job->drag);
    if (scene->walls.present)
        lammps_write_walls(out, &scene->walls);
}

static void lammps_write_input(FILE *out, const lammps_job *job, const lammps_kinds *kinds,
                               lammps_range range) {
    const dl_walls *walls = &job->scene->walls;
    fprintf(out, "units lj\ndimension 2\nboundary");
    for (int c = 0; c < 2; c++)
        if (job->scene->periods.length[c] > 0)
            fprintf(out, " p");
        else
            fprintf(out, " %c%c", walls->present && isfinite(walls->low[c]) ? 'f' : 's',
                    walls->present && isfinite(walls->high[c]) ? 'f' : 's');
    fprintf(out, " p\nnewton on\natom_style atomic\nread_data particles\n");
    lammps_write_forces(out, job, kinds, range);
    fprintf(out,
            "neighbor %.17g bin\nneigh_modify every 1 delay 0 check yes\nfix motion all nve\n"
            "timestep %.17g\nthermo 0\nthermo_style custom step ke\nthermo_modify norm no\n"
            "dump forces all custom 1 forces id fx fy\n"
            "dump_modify forces sort id format float %%.17g\n"
            "run 0\nundump forces\nshell sh read_clock\nrun %zu\nshell sh read_clock\nprint "
            "\"kinetic $(ke:%%.17g)\"\n",
            job->skin, job->scene->step, job->steps);
}

static const char *const lammps_files[] = {"particles", "law", "input", "read_clock"};

static dl_status lammps_write_files(const lammps_job *job, const char *folder, dl_error *error) {
    lammps_kinds kinds;
    dl_law law;
    dl_status status = lammps_find_kinds(job->scene, &kinds, error);
    dl_law_prepare(&job->scene->law, &law);
    lammps_range range = {0, 0};
    if (!status)
        status = lammps_find_range(job->scene, &law, &range, error);
    for (int k = 0; k < 4 && !status; k++) {
        char path[PATH_MAX];
        snprintf(path, sizeof path, "%s/%s", folder, lammps_files[k]);
        FILE *out = fopen(path, "w");
        if (!out)
            return dl_fail(error, DL_IO, "%s: %s", path, strerror(errno));
        if (k == 0)
            lammps_write_particles(out, job->scene, &kinds);
        else if (k == 1)
            lammps_write_law(out, &law, &kinds, &job->table, range);
        else if (k == 2)
            lammps_write_input(out, job, &kinds, range);
        else
            fprintf(out, "cut -d' ' -f1 /proc/$LAMMPS_PID/schedstat >> clock\n");
        if (fclose(out) != 0)
            status = dl_fail(error, DL_IO, "%s: %s", path, strerror(errno));
    }
    return status;
}

/* --- the program ---------------------------------------------------------------------------- */

/* In the child: never returns. */
static void lammps_become(const char *folder) {
    if (chdir(folder) != 0 || !freopen("output", "w", stdout) || dup2(1, 2) < 0)
        _exit(1);
    char process[32];
    snprintf(process, sizeof process, "%ld", (long)getpid());
    setenv("LAMMPS_PID", process, 1);
    /* Open MPI: no daemon that outlives the program and its files, which go with ours. */
    setenv("OMPI_MCA_ess_singleton_isolated", "1", 1);
    setenv("TMPDIR", folder, 1);
    setenv("OMP_NUM_THREADS", "1", 1);
    alarm(LAMMPS_TIME_LIMIT);
    execlp("lmp", "lmp", "-in", "input", "-log", "none", (char *)NULL);
    _exit(errno == ENOENT ? LAMMPS_NOT_FOUND : 1);
}

/* *state: as waitpid tells it. */
static dl_status lammps_execute(const char *folder, int *state, dl_error *error) {
    fflush(NULL);
    const pid_t child = fork();
    if (child < 0)
        return dl_fail(error, DL_ERROR, "fork: %s", strerror(errno));
    if (child == 0)
        lammps_become(folder);
    while (waitpid(child, state, 0) < 0)
        if (errno != EINTR)
            return dl_fail(error, DL_ERROR, "waitpid: %s", strerror(errno));
    return DL_OK;
}

/* --- what it says --------------------------------------------------------------------------- */

static void lammps_read_line(const char *line, lammps_result *result) {
    double value = 0;
    unsigned long count = 0;
    if (sscanf(line, "LAMMPS (%63[^)])", result->version) == 1)
        return;
    if (sscanf(line, "Loop time of %lf", &value) == 1)
        result->seconds = value;
    else if (sscanf(line, "kinetic %lf", &value) == 1)
        result->kinetic = value;
    else if (sscanf(line, "Neighbor list builds = %lu", &count) == 1)
        result->builds = count;
    else if (sscanf(line, "Total # of neighbors = %lu", &count) == 1)
        result->pairs = count;
}

/* An error that it reports is the message, also where it came to a loop time before. */
static dl_status lammps_read_output(const char *folder, lammps_result *result, dl_error *error) {
    char path[PATH_MAX], line[512], trouble[512] = "";
    snprintf(path, sizeof path, "%s/output", folder);
    FILE *in = fopen(path, "r");
    if (!in)
        return dl_fail(error, DL_IO, "%s: %s", path, strerror(errno));
    while (fgets(line, sizeof line, in)) {
        lammps_read_line(line, result);
        if (strncmp(line, "ERROR", 5) == 0)
            snprintf(trouble, sizeof trouble, "%.*s", (int)strcspn(line, "\n"), line);
    }
    fclose(in);
    if (result->seconds > 0 && !*trouble)
        return DL_OK;
    return dl_fail(error, DL_ERROR, "lmp: %s", *trouble ? trouble : "no loop time in its output");
}

/* LAMMPS's loop time is by the clock on the wall, and another process may have run meanwhile; its
 * CPU time, read before and after the run, has the run's set-up in it. Neither is too small. */
static void lammps_read_clock(const char *folder, lammps_result *result) {
    char path[PATH_MAX];
    double before = 0, after = 0;
    snprintf(path, sizeof path, "%s/clock", folder);
    FILE *in = fopen(path, "r");
    if (in && fscanf(in, "%lf %lf", &before, &after) == 2)
        result->seconds = fmin(result->seconds, (after - before) * 1e-9);
    if (in)
        fclose(in);
}

/* The dump against f = inertia * a, x|y, and the drag. */
static dl_status lammps_read_forces(const char *folder, const lammps_job *job, const double *a,
                                    double *difference, dl_error *error) {
    const dl_scene *scene = job->scene;
    char path[PATH_MAX], line[512];
    const size_t n = scene->particles;
    size_t rows = 0;
    double sum = 0, scale = 0;
    snprintf(path, sizeof path, "%s/forces", folder);
    FILE *in = fopen(path, "r");
    if (!in)
        return dl_fail(error, DL_IO, "%s: %s", path, strerror(errno));
    while (fgets(line, sizeof line, in) && strncmp(line, "ITEM: ATOMS", 11) != 0)
        continue;
    while (rows < n && fgets(line, sizeof line, in)) {
        size_t id = 0;
        double f[2];
        if (sscanf(line, "%zu %lf %lf", &id, &f[0], &f[1]) != 3 || id != rows + 1)
            break;
        for (size_t c = 0; c < 2; c++) {
            const double pair = scene->inertia[rows] * (a[c * n + rows] - scene->gravity[c]);
            const double ours =
                scene->inertia[rows] * a[c * n + rows] - job->drag * scene->velocity[c * n + rows];
            sum += (f[c] - ours) * (f[c] - ours);
            scale += pair * pair;
        }
        rows++;
    }
    fclose(in);
    if (rows < n)
        return dl_fail(error, DL_ERROR, "lmp: forces of %zu particles, expected %zu", rows, n);
    *difference = sqrt(sum / scale);
    return DL_OK;
}

static dl_status lammps_compare_forces(const char *folder, const lammps_job *job,
                                       double *difference, dl_error *error) {
    const dl_scene *scene = job->scene;
    dl_model *model = NULL;
    dl_status status = dl_model_create(scene, &model, error);
    double *a = status ? NULL : malloc(model->unknowns * sizeof *a);
    if (!status && !a)
        status = dl_fail_memory(error, "the forces to compare");
    if (!status)
        status = dl_model_acceleration(model, scene->position, a, error);
    if (!status)
        status = lammps_read_forces(folder, job, a, difference, error);
    free(a);
    dl_model_free(model);
    return status;
}

/* Without a cutoff every pair must have been in LAMMPS's list to the end. */
static dl_status lammps_check_pairs(const dl_scene *scene, const lammps_result *result,
                                    dl_error *error) {
    const size_t all = scene->particles * (scene->particles - 1) / 2;
    if (isfinite(scene->law.piece[scene->law.pieces - 1].until) || result->pairs == all)
        return DL_OK;
    return dl_fail(error, DL_ERROR, "lmp: %lu pairs in its list, expected %zu", result->pairs, all);
}

/* --- the whole ------------------------------------------------------------------------------ */

static int lammps_remove(const char *path, const struct stat *info, int kind, struct FTW *where) {
    (void)info;
    (void)kind;
    (void)where;
    (void)remove(path);
    return 0; /* the rest goes all the same */
}

static dl_status lammps_run_in(const char *folder, const lammps_job *job, bool *found,
                               lammps_result *result, dl_error *error) {
    int state = 0;
    dl_status status = lammps_write_files(job, folder, error);
    if (!status)
        status = lammps_execute(folder, &state, error);
    *found = !(WIFEXITED(state) && WEXITSTATUS(state) == LAMMPS_NOT_FOUND);
    if (status || !*found)
        return status;
    status = lammps_read_output(folder, result, error);
    if (!status && state != 0)
        status = dl_fail(error, DL_ERROR, "lmp ended with status %d", state);
    if (!status)
        lammps_read_clock(folder, result);
    if (!status)
        status = lammps_compare_forces(folder, job, &result->force_difference, error);
    return status ? status : lammps_check_pairs(job->scene, result, error);
}

/* Runs the job. DL_OK with *found false where LAMMPS is not installed. */
static dl_status lammps_run(const lammps_job *job, bool *found, lammps_result *result,
                            dl_error *error) {
    const char *parent = getenv("TMPDIR");
    char folder[PATH_MAX - 64]; /* room for the names in it */
    *result = (lammps_result){.seconds = 0};
    snprintf(folder, sizeof folder, "%s/driftlab-bench-XXXXXX",
             parent && *parent ? parent : "/tmp");
    if (!mkdtemp(folder))
        return dl_fail(error, DL_IO, "%s: %s", folder, strerror(errno));
    const dl_status status = lammps_run_in(folder, job, found, result, error);
    nftw(folder, lammps_remove, 8, FTW_DEPTH | FTW_PHYS);
    if (!status && *found)
        result->kinetic /= (double)job->scene->particles;
    return status;
}

#endif
