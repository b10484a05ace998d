/* The last frame of an H5MD file, of driftlab's own or another program's: the first group of
 * /particles, its position/value and velocity/value [frame][particle][component]. */
#include "driftlab/trajectory.h"

#include <hdf5.h>
#include <math.h>
#include <stdlib.h>

typedef struct frames {
    hid_t data;
    hsize_t extent[3]; /* frames, particles, components */
} frames;

typedef struct reader {
    const char *path;
    const dl_scene *scene;
    hid_t file, particles, group;
} reader;

static dl_status refuse(const reader *r, dl_error *error, const char *found, const char *expected) {
    return dl_fail(error, DL_INPUT, "%s: found %s, expected %s", r->path, found, expected);
}

/* --- opening -------------------------------------------------------------------------------- */

static dl_status open_file(reader *r, dl_error *error) {
    FILE *readable = fopen(r->path, "rb");
    if (!readable)
        return dl_fail(error, DL_INPUT, "%s: cannot be read; expected an H5MD file", r->path);
    fclose(readable);
    r->file = H5Fopen(r->path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (r->file < 0)
        return refuse(r, error, "no HDF5 file", "an H5MD file");
    if (H5Lexists(r->file, "h5md", H5P_DEFAULT) <= 0 ||
        H5Lexists(r->file, "particles", H5P_DEFAULT) <= 0)
        return refuse(r, error, "an HDF5 file without /h5md or /particles", "an H5MD file");
    r->particles = H5Gopen2(r->file, "particles", H5P_DEFAULT);
    char name[256];
    if (r->particles < 0 || H5Lget_name_by_idx(r->particles, ".", H5_INDEX_NAME, H5_ITER_INC, 0,
                                               name, sizeof name, H5P_DEFAULT) < 0)
        return refuse(r, error, "/particles without a group", "an H5MD file with particles");
    r->group = H5Gopen2(r->particles, name, H5P_DEFAULT);
    return r->group >= 0 ? DL_OK
                         : refuse(r, error, "/particles that cannot be read", "an H5MD file");
}

static void close_file(reader *r) {
    if (r->group >= 0)
        H5Gclose(r->group);
    if (r->particles >= 0)
        H5Gclose(r->particles);
    if (r->file >= 0)
        H5Fclose(r->file);
}

static bool open_frames(const reader *r, const char *name, frames *opened) {
    opened->data = H5Dopen2(r->group, name, H5P_DEFAULT);
    if (opened->data < 0)
        return false;
    const hid_t space = H5Dget_space(opened->data);
    const bool good = H5Sget_simple_extent_ndims(space) == 3 &&
                      H5Sget_simple_extent_dims(space, opened->extent, NULL) == 3;
    H5Sclose(space);
    return good;
}

static dl_status check_extent(const reader *r, const frames *opened, dl_error *error) {
    const dl_scene *scene = r->scene;
    const hsize_t *extent = opened->extent;
    if (extent[0] == 0)
        return refuse(r, error, "no frame", "a trajectory with at least one");
    if (extent[1] == scene->particles && (extent[2] == 3 || extent[2] == (hsize_t)scene->dimension))
        return DL_OK;
    return dl_fail(error, DL_INPUT,
                   "%s: found %llu particles of %llu components, expected the scene's %zu of %d "
                   "(or 3)",
                   r->path, (unsigned long long)extent[1], (unsigned long long)extent[2],
                   scene->particles, scene->dimension);
}

/* --- reading -------------------------------------------------------------------------------- */

/* The last frame as one component after the other, out [dimension * particles]. */
static dl_status read_frame(const reader *r, const frames *opened, const char *name, double *out,
                            dl_error *error) {
    const size_t n = (size_t)opened->extent[1], width = (size_t)opened->extent[2];
    const hsize_t start[3] = {opened->extent[0] - 1, 0, 0};
    const hsize_t count[3] = {1, opened->extent[1], opened->extent[2]};
    double *rows = malloc(n * width * sizeof *rows);
    if (!rows)
        return dl_fail_memory(error, "a frame of a trajectory");
    const hid_t file_space = H5Dget_space(opened->data);
    const hid_t memory_space = H5Screate_simple(3, count, NULL);
    H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, count, NULL);
    const herr_t read =
        H5Dread(opened->data, H5T_NATIVE_DOUBLE, memory_space, file_space, H5P_DEFAULT, rows);
    H5Sclose(memory_space);
    H5Sclose(file_space);
    dl_status status = DL_OK;
    if (read < 0)
        status = dl_fail(error, DL_IO, "%s: %s cannot be read", r->path, name);
    for (size_t i = 0; !status && i < n; i++)
        for (size_t k = 0; !status && k < width; k++) {
            const double value = rows[i * width + k];
            const bool fits = k < (size_t)r->scene->dimension ? isfinite(value) : value == 0;
            if (!fits)
                status = dl_fail(error, DL_INPUT,
                                 "%s: %s: particle %zu: found %.17g as component %zu, expected %s",
                                 r->path, name, i, value, k,
                                 isfinite(value) ? "0 for a scene in two dimensions"
                                                 : "a finite number");
            else if (k < (size_t)r->scene->dimension)
                out[k * n + i] = value;
        }
    free(rows);
    return status;
}

/* H5MD allows one time a frame, or the interval between frames. */
static double last_time(const reader *r, hsize_t count) {
    const hid_t data = H5Dopen2(r->group, "position/time", H5P_DEFAULT);
    if (data < 0)
        return NAN;
    const hid_t space = H5Dget_space(data);
    double time = NAN;
    if (H5Sget_simple_extent_ndims(space) == 0) {
        if (H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &time) >= 0)
            time *= (double)(count - 1);
    } else {
        const hsize_t start = count - 1, one = 1;
        const hid_t memory_space = H5Screate(H5S_SCALAR);
        H5Sselect_hyperslab(space, H5S_SELECT_SET, &start, NULL, &one, NULL);
        if (H5Dread(data, H5T_NATIVE_DOUBLE, memory_space, space, H5P_DEFAULT, &time) < 0)
            time = NAN;
        H5Sclose(memory_space);
    }
    H5Sclose(space);
    H5Dclose(data);
    return time;
}

static dl_status read_state(const reader *r, double *y_all, double *time, dl_error *error) {
    static const char *const names[] = {"position/value", "velocity/value"};
    const size_t components = (size_t)r->scene->dimension * r->scene->particles;
    hsize_t count = 0;
    for (size_t part = 0; part < 2; part++) {
        frames opened = {.data = H5I_INVALID_HID};
        dl_status status = DL_OK;
        if (!open_frames(r, names[part], &opened))
            status = dl_fail(error, DL_INPUT,
                             "%s: found no %s [frame][particle][component] in the first group of "
                             "/particles",
                             r->path, names[part]);
        if (!status)
            status = check_extent(r, &opened, error);
        if (!status && part == 1 && opened.extent[0] != count)
            status = refuse(r, error, "other numbers of frames for position and velocity",
                            "one velocity for every position");
        if (!status)
            status = read_frame(r, &opened, names[part], y_all + part * components, error);
        count = opened.extent[0];
        if (opened.data >= 0)
            H5Dclose(opened.data);
        if (status)
            return status;
    }
    *time = last_time(r, count);
    return DL_OK;
}

dl_status dl_trajectory_read_last(const char *path, const dl_scene *scene, double **y_all,
                                  double *time, dl_error *error) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    reader r = {path, scene, H5I_INVALID_HID, H5I_INVALID_HID, H5I_INVALID_HID};
    *y_all = malloc(2 * (size_t)scene->dimension * scene->particles * sizeof **y_all);
    if (!*y_all)
        return dl_fail_memory(error, "a state of every particle");
    dl_status status = open_file(&r, error);
    if (!status)
        status = read_state(&r, *y_all, time, error);
    close_file(&r);
    if (status) {
        free(*y_all);
        *y_all = NULL;
    }
    return status;
}
