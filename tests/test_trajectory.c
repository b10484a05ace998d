/* H5MD trajectories: what is in them, what readers demand, restarting from them, failing writes. */
#include "fixture_runs.h"

#include <hdf5.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "driftlab/trajectory.h"

static const char three[] = "name: three\n"
                            "source: a test\n"
                            "dimension: 2\n"
                            "particles:\n"
                            "  - {at: [0.1, 0.2], velocity: [0.3, -0.4], mass: 1}\n"
                            "  - {at: [1.1, -0.3], velocity: [-0.1, 0.7], mass: 2}\n"
                            "  - {at: [-0.9, 0.8], velocity: [0.2, 0.1], mass: 3}\n"
                            "pair_law:\n"
                            "  - {terms: [{coefficient: -1, power: 2}]}\n"
                            "time: {step: 0.01, end: 1, sample: 0.1}\n";

static char folder[] = "/tmp/driftlab-trajectory-XXXXXX";

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    return rmdir(folder); /* fails where a test left a file */
}

static void path_in_folder(const char *name, char path[128]) {
    snprintf(path, 128, "%s/%s", folder, name);
}

static bool exists(const char *path) {
    struct stat found;
    return stat(path, &found) == 0;
}

/* --- writing -------------------------------------------------------------------------------- */

typedef struct kept {
    size_t count;
    double *y; /* [count][length]: what was sampled */
    size_t length;
    double time[128], error[128];
    dl_trajectory *trajectory;
} kept;

static dl_status keep_and_append(void *context, const dl_sample *sample, dl_error *error) {
    kept *k = context;
    k->y = realloc(k->y, (k->count + 1) * k->length * sizeof *k->y);
    assert_non_null(k->y);
    memcpy(k->y + k->count * k->length, sample->y_all, k->length * sizeof *k->y);
    k->time[k->count] = sample->time;
    k->error[k->count++] = sample->energy_error;
    return dl_trajectory_append(k->trajectory, sample, error);
}

/* Runs the scene and writes its trajectory; free what is returned with kept_free. */
static kept write_trajectory(const dl_scene *scene, const char *method, const char *path,
                             double end, finished *run) {
    kept k = {.length = 2 * (size_t)scene->dimension * scene->particles};
    dl_error error = {""};
    if (dl_trajectory_create(path, scene, method, "step=0.01", &k.trajectory, &error))
        fail_msg("%s", error.message);
    dl_run_options how = run_options(end, 0);
    how.on_sample = keep_and_append;
    how.context = &k;
    *run = run_with(scene, method_of(method), "", &how);
    assert_int_equal(run->summary.status, DL_OK);
    assert_false(exists(path)); /* not before it is complete */
    if (dl_trajectory_close(k.trajectory, &error))
        fail_msg("%s", error.message);
    assert_true(exists(path));
    return k;
}

/* --- reading with HDF5 ---------------------------------------------------------------------- */

static void read_reals(hid_t file, const char *name, int rank, const hsize_t *extent,
                       double *values) {
    const hid_t data = H5Dopen2(file, name, H5P_DEFAULT);
    if (data < 0)
        fail_msg("no %s", name);
    const hid_t space = H5Dget_space(data);
    hsize_t found[3] = {0};
    assert_int_equal(H5Sget_simple_extent_ndims(space), rank);
    H5Sget_simple_extent_dims(space, found, NULL);
    for (int k = 0; k < rank; k++)
        assert_int_equal(found[k], extent[k]);
    assert_true(H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) >= 0);
    H5Sclose(space);
    H5Dclose(data);
}

static void read_fixed_text(hid_t file, const char *name, char *text, size_t size) {
    const hid_t data = H5Dopen2(file, name, H5P_DEFAULT), type = H5Dget_type(data);
    assert_true(H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0);
    assert_true(H5Tget_size(type) < size);
    memset(text, 0, size);
    assert_true(H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) >= 0);
    H5Tclose(type);
    H5Dclose(data);
}

static void check_identity(hid_t file) {
    int version[2] = {0, 0}, dimension = 0;
    hid_t attribute = H5Aopen_by_name(file, "h5md", "version", H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Aread(attribute, H5T_NATIVE_INT, version) >= 0);
    H5Aclose(attribute);
    assert_true(version[0] == 1 && version[1] == 1);
    attribute = H5Aopen_by_name(file, "particles/all/box", "dimension", H5P_DEFAULT, H5P_DEFAULT);
    assert_true(H5Aread(attribute, H5T_NATIVE_INT, &dimension) >= 0);
    H5Aclose(attribute);
    assert_int_equal(dimension, 3);
    attribute = H5Aopen_by_name(file, "particles/all/box", "boundary", H5P_DEFAULT, H5P_DEFAULT);
    const hid_t type = H5Aget_type(attribute), space = H5Aget_space(attribute);
    assert_true(H5Tget_class(type) == H5T_STRING && H5Tis_variable_str(type) == 0);
    assert_int_equal(H5Sget_simple_extent_npoints(space), 3);
    H5Sclose(space);
    H5Tclose(type);
    H5Aclose(attribute);
    static const char *const names[] = {"h5md/author", "h5md/creator"};
    for (size_t i = 0; i < 2; i++)
        assert_true(H5Aexists_by_name(file, names[i], "name", H5P_DEFAULT) > 0);
    assert_true(H5Aexists_by_name(file, "h5md/creator", "version", H5P_DEFAULT) > 0);
}

static void check_positions(hid_t file, const kept *k, const dl_scene *scene) {
    const size_t n = scene->particles;
    const hsize_t extent[3] = {k->count, n, 3};
    static const char *const names[] = {"particles/all/position/value",
                                        "particles/all/velocity/value"};
    double *values = malloc(k->count * n * 3 * sizeof *values);
    assert_non_null(values);
    for (size_t part = 0; part < 2; part++) {
        read_reals(file, names[part], 3, extent, values);
        for (size_t frame = 0; frame < k->count; frame++)
            for (size_t i = 0; i < n; i++) {
                const double *y = k->y + frame * k->length + part * 2 * n;
                const double *row = values + (frame * n + i) * 3;
                /* Every bit. */
                assert_true(row[0] == y[i] && row[1] == y[n + i] && row[2] == 0);
            }
    }
    free(values);
}

static void file_says_what_was_sampled(void **state) {
    (void)state;
    char path[128], text[2048];
    path_in_folder("a.h5", path);
    dl_scene *scene = scene_of_text(three);
    finished run;
    kept k = write_trajectory(scene, "leapfrog", path, 0.95, &run);
    assert_int_equal(k.count, 11);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    check_identity(file);
    check_positions(file, &k, scene);
    static const char *const series[] = {
        "particles/all/position",     "particles/all/velocity",       "particles/all/box/edges",
        "observables/kinetic_energy", "observables/potential_energy", "observables/total_energy",
        "observables/ledger",         "observables/energy_error"};
    const hsize_t frames = k.count, three_masses = 3;
    double values[11];
    for (size_t i = 0; i < sizeof series / sizeof *series; i++) {
        char name[64];
        snprintf(name, sizeof name, "%s/time", series[i]);
        read_reals(file, name, 1, &frames, values);
        assert_memory_equal(values, k.time, sizeof values);
        snprintf(name, sizeof name, "%s/step", series[i]);
        read_reals(file, name, 1, &frames, values);
        assert_true(values[0] == 0 && values[9] == 90 && values[10] == 95);
    }
    read_reals(file, "observables/energy_error/value", 1, &frames, values);
    assert_memory_equal(values, k.error, sizeof values);
    double kinetic[11], potential[11], total[11];
    read_reals(file, "observables/kinetic_energy/value", 1, &frames, kinetic);
    read_reals(file, "observables/potential_energy/value", 1, &frames, potential);
    read_reals(file, "observables/total_energy/value", 1, &frames, total);
    for (size_t i = 0; i < frames; i++)
        assert_true(fabs(kinetic[i] + potential[i] - total[i]) < 1e-14);
    assert_true(total[0] == run.summary.energy_initial && total[10] == run.summary.energy_final);
    read_reals(file, "particles/all/mass", 1, &three_masses, values);
    assert_true(values[0] == 1 && values[1] == 2 && values[2] == 3);
    read_fixed_text(file, "parameters/method", text, sizeof text);
    assert_string_equal(text, "leapfrog");
    read_fixed_text(file, "parameters/options", text, sizeof text);
    assert_string_equal(text, "step=0.01");
    read_fixed_text(file, "parameters/scene", text, sizeof text);
    assert_string_equal(text, "three");
    read_fixed_text(file, "parameters/scene_file", text, sizeof text);
    assert_string_equal(text, three);
    H5Fclose(file);
    unlink(path);
    free(k.y);
    free(run.y);
    dl_scene_free(scene);
}

/* --- restarting ----------------------------------------------------------------------------- */

static void last_frame_comes_back(void **state) {
    (void)state;
    char path[128];
    path_in_folder("last.h5", path);
    dl_scene *scene = scene_of_text(three);
    finished run;
    kept k = write_trajectory(scene, "leapfrog", path, 0.5, &run);
    double *y_all = NULL, time = 0;
    assert_int_equal(dl_trajectory_read_last(path, scene, &y_all, &time, NULL), DL_OK);
    assert_true(time == 0.5);
    assert_memory_equal(y_all, run.y, run.length * sizeof *run.y);
    free(y_all);
    unlink(path);
    free(k.y);
    free(run.y);
    dl_scene_free(scene);
}

/* --- many particles ------------------------------------------------------------------------- */

/* Frames of more than a chunk are compressed by driftlab itself: HDF5 reads every bit of them. */
static void check_large(const char *text, const char *method) {
    char path[128];
    path_in_folder("large.h5", path);
    dl_scene *scene = scene_of_text(text);
    const size_t n = scene->particles, d = (size_t)scene->dimension;
    finished run;
    kept k = write_trajectory(scene, method, path, 0.3, &run);
    assert_int_equal(k.count, 4);
    for (size_t frame = 0; frame < k.count; frame++) {
        double *y_all = NULL, time = 0;
        assert_int_equal(dl_trajectory_read_state(path, frame, scene, &y_all, &time, NULL), DL_OK);
        assert_memory_equal(y_all, k.y + frame * k.length, k.length * sizeof *y_all);
        free(y_all);
    }
    const hsize_t extent[3] = {k.count, n, 3};
    double *rows = malloc(k.count * n * 3 * sizeof *rows);
    const hid_t file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    assert_true(file >= 0);
    assert_non_null(rows);
    read_reals(file, "/particles/all/velocity/value", 3, extent, rows);
    for (size_t i = 0; i < k.count * n; i++) {
        const double *velocity = k.y + i / n * k.length + d * n;
        for (size_t c = 0; c < 3; c++)
            assert_true(rows[3 * i + c] == (c < d ? velocity[c * n + i % n] : 0));
    }
    const hid_t data = H5Dopen2(file, "/particles/all/velocity/value", H5P_DEFAULT);
    assert_true(H5Dget_storage_size(data) < 0.95 * (double)(k.count * d * n * sizeof *rows));
    H5Dclose(data);
    H5Fclose(file);
    unlink(path);
    free(rows);
    free(k.y);
    free(run.y);
    dl_scene_free(scene);
}

static void frames_of_many_particles_come_back(void **state) {
    (void)state;
    check_large("name: flat\ndimension: 2\nparticles:\n"
                "  - {at: [0, -1], pinned: true}\n"
                "  - {lattice: {kind: square, spacing: 1, count: [70, 50]},\n"
                "     velocity: [1, 2], perturb: {relative: 0.5}}\n"
                "gravity: [0, -1]\ntime: {step: 0.01, end: 1, sample: 0.1}\n",
                "leapfrog");
    check_large("name: deep\ndimension: 3\nparticles:\n"
                "  - {lattice: {kind: simple-cubic, spacing: 1, count: [20, 20, 10]},\n"
                "     velocity: [1, 2, 3], perturb: {relative: 0.5}}\n"
                "gravity: [0, 0, -1]\ntime: {step: 0.01, end: 1, sample: 0.1}\n",
                "leapfrog");
}

static void check_restart(const dl_scene *scene, const dl_method_row *row) {
    char path[128];
    path_in_folder("half.h5", path);
    const dl_run_options whole = run_options(1, 0.25), rest = run_options(0.5, 0.25);
    finished straight = run_with(scene, row, "", &whole), first;
    kept k = write_trajectory(scene, row->name, path, 0.5, &first);
    double *y_all = NULL, time = 0;
    dl_scene *restarted = NULL;
    assert_int_equal(dl_trajectory_read_last(path, scene, &y_all, &time, NULL), DL_OK);
    assert_int_equal(dl_scene_restart(scene, y_all, &restarted, NULL), DL_OK);
    finished second = run_with(restarted, row, "", &rest);
    if (memcmp(straight.y, second.y, straight.length * sizeof *straight.y) != 0)
        fail_msg("%s: a restart is not the straight run", row->name);
    dl_scene_free(restarted);
    free(y_all);
    unlink(path);
    free(k.y);
    free(straight.y);
    free(first.y);
    free(second.y);
}

static void restart_is_the_straight_run(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(three);
    size_t checked = 0;
    for (size_t i = 0; i < dl_method_count(); i++) {
        const dl_method_row *row = dl_method_row_at(i);
        if (!(row->flags & DL_RESTARTS_EXACTLY))
            continue;
        check_restart(scene, row);
        checked++;
    }
    assert_true(checked >= 3);
    dl_scene_free(scene);
}

static void expect_refusal(const char *path, const dl_scene *scene, const char *words) {
    double *y_all = NULL, time = 0;
    dl_error error = {""};
    assert_int_equal(dl_trajectory_read_last(path, scene, &y_all, &time, &error), DL_INPUT);
    assert_null(y_all);
    if (!strstr(error.message, words) || !strstr(error.message, path))
        fail_msg("\"%s\" does not say \"%s\"", error.message, words);
}

static void other_files_are_refused(void **state) {
    (void)state;
    char path[128];
    path_in_folder("other.h5", path);
    dl_scene *scene = scene_of_text(three), *drop = read_scene(DL_STUDIES "/drop/drop.yaml");
    finished run;
    expect_refusal(path, scene, "cannot be read");
    expect_refusal(DL_STUDIES "/drop/drop.yaml", scene, "no HDF5 file");
    kept k = write_trajectory(scene, "leapfrog", path, 0.1, &run);
    expect_refusal(path, drop, "found 3 particles");
    hid_t file = H5Fopen(path, H5F_ACC_RDWR, H5P_DEFAULT);
    H5Ldelete(file, "particles/all/velocity", H5P_DEFAULT);
    H5Fclose(file);
    expect_refusal(path, scene, "velocity");
    file = H5Fcreate(path, H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    H5Fclose(file);
    expect_refusal(path, scene, "without /h5md");
    unlink(path);
    free(k.y);
    free(run.y);
    dl_scene_free(scene);
    dl_scene_free(drop);
}

/* --- writing that fails --------------------------------------------------------------------- */

static size_t files_in_folder(void) {
    char command[160];
    snprintf(command, sizeof command, "ls -A %s | wc -l", folder);
    FILE *pipe = popen(command, "r");
    assert_non_null(pipe);
    size_t count = 99;
    assert_int_equal(fscanf(pipe, "%zu", &count), 1);
    pclose(pipe);
    return count;
}

static dl_status append_only(void *context, const dl_sample *sample, dl_error *error) {
    return dl_trajectory_append(context, sample, error);
}

/* Status of a trajectory that may only be `bytes` long. */
static dl_status write_limited(const dl_scene *scene, const char *path, size_t bytes,
                               dl_error *error) {
    struct rlimit before, limit;
    getrlimit(RLIMIT_FSIZE, &before);
    limit = (struct rlimit){bytes, before.rlim_max};
    signal(SIGXFSZ, SIG_IGN);
    setrlimit(RLIMIT_FSIZE, &limit);
    dl_trajectory *trajectory = NULL;
    dl_status status = dl_trajectory_create(path, scene, "leapfrog", "", &trajectory, error);
    if (!status) {
        dl_run_options how = run_options(0.05, 0.001);
        how.on_sample = append_only;
        how.context = trajectory;
        finished run = run_with(scene, method_of("leapfrog"), "", &how);
        free(run.y);
        status = dl_trajectory_close(trajectory, error);
    }
    setrlimit(RLIMIT_FSIZE, &before);
    return status;
}

static void full_disk_leaves_nothing(void **state) {
    (void)state;
    char path[128];
    path_in_folder("full.h5", path);
    dl_scene *scene = read_scene(DL_STUDIES "/drop/drop.yaml");
    static const size_t limits[] = {0, 100, 5000, 30000, 100000, 300000};
    for (size_t i = 0; i < sizeof limits / sizeof *limits; i++) {
        dl_error error = {""};
        assert_int_equal(write_limited(scene, path, limits[i], &error), DL_IO);
        assert_non_null(strstr(error.message, path));
        assert_non_null(strstr(error.message, "File too large"));
        assert_int_equal(files_in_folder(), 0);
    }
    /* The same without the limit is a file. */
    assert_int_equal(write_limited(scene, path, 10000000, NULL), DL_OK);
    struct stat found;
    assert_int_equal(stat(path, &found), 0);
    assert_true(found.st_size > 300000);
    /* A failure leaves an earlier file alone. */
    assert_int_equal(write_limited(scene, path, 5000, NULL), DL_IO);
    struct stat after;
    assert_int_equal(stat(path, &after), 0);
    assert_true(after.st_ino == found.st_ino && after.st_size == found.st_size);
    unlink(path);
    dl_scene_free(scene);
}

static void places_that_cannot_be_written(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(three);
    dl_trajectory *trajectory = NULL;
    dl_error error = {""};
    assert_int_equal(
        dl_trajectory_create("/nonexistent/a.h5", scene, "leapfrog", "", &trajectory, &error),
        DL_IO);
    assert_non_null(strstr(error.message, "/nonexistent/a.h5"));
    assert_non_null(strstr(error.message, "No such file"));
    assert_null(trajectory);
    /* A device must not be replaced by a file. */
    assert_int_equal(dl_trajectory_create("/dev/full", scene, "leapfrog", "", &trajectory, &error),
                     DL_IO);
    assert_non_null(strstr(error.message, "no regular file"));
    assert_int_equal(dl_trajectory_create(folder, scene, "leapfrog", "", &trajectory, &error),
                     DL_IO);
    dl_scene_free(scene);
}

/* --- another reader ------------------------------------------------------------------------- */

static void mdanalysis_reads_it(void **state) {
    (void)state;
    if (system("/usr/bin/python3 -W ignore -c 'import MDAnalysis, h5py' >/dev/null 2>&1") != 0)
        skip();
    char path[128], command[2048];
    path_in_folder("reader.h5", path);
    dl_scene *scene = scene_of_text(three);
    finished run;
    kept k = write_trajectory(scene, "leapfrog", path, 1, &run);
    const double *y = k.y + 10 * k.length;
    /* MDAnalysis keeps positions in single precision. */
    snprintf(command, sizeof command,
             "/usr/bin/python3 -W ignore -c '\n"
             "import MDAnalysis\n"
             "u = MDAnalysis.Universe.empty(3)\n"
             "u.load_new(\"%s\", format=\"H5MD\", convert_units=False)\n"
             "assert len(u.trajectory) == 11\n"
             "frame = u.trajectory[10]\n"
             "assert frame.time == %.17g and frame.data[\"step\"] == 100\n"
             "assert abs(frame.positions[1][0] - %.17g) < 1e-6\n"
             "assert abs(frame.positions[2][1] - %.17g) < 1e-6\n"
             "assert abs(frame.velocities[0][1] - %.17g) < 1e-6\n"
             "assert frame.positions[1][2] == 0\n"
             "assert frame.data[\"energy_error\"] == %.17g\n"
             "assert frame.dimensions[2] == 1 and frame.dimensions[3] == 90\n"
             "'",
             path, k.time[10], y[1], y[3 + 2], y[6 + 3 + 0], k.error[10]);
    assert_int_equal(system(command), 0);
    unlink(path);
    free(k.y);
    free(run.y);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(file_says_what_was_sampled),
        cmocka_unit_test(last_frame_comes_back),
        cmocka_unit_test(frames_of_many_particles_come_back),
        cmocka_unit_test(restart_is_the_straight_run),
        cmocka_unit_test(other_files_are_refused),
        cmocka_unit_test(full_disk_leaves_nothing),
        cmocka_unit_test(places_that_cannot_be_written),
        cmocka_unit_test(mdanalysis_reads_it),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
