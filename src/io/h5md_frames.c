/* Frames of an H5MD trajectory one after the other, and which of them is of a step or a time. */
#include <hdf5.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/trajectory.h"
#include "io/h5md_file.h"

struct dl_frames_file {
    char *path;
    dl_h5md_file file;
    dl_h5md_vectors position, velocity;
    double *components; /* [3 * particles] */
};

/* --- opening -------------------------------------------------------------------------------- */

/* H5MD allows the interval between frames in the place of one number each. */
static void *count_up(hid_t data, size_t count, hid_t type, size_t size) {
    const bool real = H5Tequal(type, H5T_NATIVE_DOUBLE) > 0;
    double interval = 0;
    long steps = 0;
    if (H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT,
                real ? (void *)&interval : (void *)&steps) < 0)
        return NULL;
    void *const values = calloc(count, size);
    for (size_t k = 0; k < count && values; k++)
        if (real)
            ((double *)values)[k] = (double)k * interval;
        else
            ((long *)values)[k] = (long)k * steps;
    return values;
}

/* A number a frame, of `size` bytes in memory; NULL where there is no such dataset. */
static void *read_series(hid_t parent, const char *name, size_t count, hid_t type, size_t size) {
    const hid_t data = H5Dopen2(parent, name, H5P_DEFAULT);
    if (data < 0)
        return NULL;
    const hid_t space = H5Dget_space(data);
    void *values = NULL;
    const int rank = H5Sget_simple_extent_ndims(space);
    if (rank == 0)
        values = count_up(data, count, type, size);
    else if (rank == 1 && H5Sget_simple_extent_npoints(space) == (hssize_t)count)
        values = calloc(count, size);
    if (values && rank == 1 && H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values) < 0) {
        free(values);
        values = NULL;
    }
    H5Sclose(space);
    H5Dclose(data);
    return values;
}

static double *read_observable(const dl_frames *frames, const char *name) {
    return read_series(frames->file->file.file, name, frames->count, H5T_NATIVE_DOUBLE,
                       sizeof(double));
}

static dl_status read_axis(dl_frames *frames, dl_error *error) {
    const dl_h5md_file *const file = &frames->file->file;
    frames->time =
        read_series(file->group, "position/time", frames->count, H5T_NATIVE_DOUBLE, sizeof(double));
    frames->step =
        read_series(file->group, "position/step", frames->count, H5T_NATIVE_LONG, sizeof(long));
    if (!frames->time || !frames->step)
        return dl_h5md_refuse(file, error, "no time and step of every frame",
                              "a trajectory that driftlab wrote");
    for (size_t k = 0; k < frames->count; k++)
        if (!isfinite(frames->time[k]) || (k > 0 && frames->time[k] < frames->time[k - 1]))
            return dl_h5md_refuse(file, error, "times that do not ascend",
                                  "a trajectory that driftlab wrote");
    frames->energy_error = read_observable(frames, "observables/energy_error/value");
    frames->kinetic = read_observable(frames, "observables/kinetic_energy/value");
    frames->potential = read_observable(frames, "observables/potential_energy/value");
    frames->method = dl_h5md_read_parameter(file, "method");
    frames->options = dl_h5md_read_parameter(file, "options");
    return DL_OK;
}

static dl_status open_file(dl_frames *frames, dl_error *error) {
    struct dl_frames_file *const file = frames->file;
    dl_status status = dl_h5md_open(&file->file, error);
    if (!status)
        status = dl_h5md_open_vectors(&file->file, "position/value", &file->position, error);
    if (!status)
        status = dl_h5md_open_vectors(&file->file, "velocity/value", &file->velocity, error);
    if (!status &&
        memcmp(file->position.extent, file->velocity.extent, sizeof file->position.extent) != 0)
        status = dl_h5md_refuse(&file->file, error, "positions and velocities of other extents",
                                "one velocity for every position");
    if (status)
        return status;
    frames->count = (size_t)file->position.extent[0];
    frames->particles = (size_t)file->position.extent[1];
    frames->components = (int)file->position.extent[2];
    file->components = malloc(DL_H5MD_SPATIAL * frames->particles * sizeof *file->components);
    return file->components ? read_axis(frames, error)
                            : dl_fail_memory(error, "a frame of a trajectory");
}

dl_status dl_frames_open(const char *path, dl_frames **frames, dl_error *error) {
    *frames = NULL;
    dl_frames *opened = calloc(1, sizeof *opened);
    struct dl_frames_file *file = calloc(1, sizeof *file);
    char *const copy = strdup(path);
    if (!opened || !file || !copy) {
        free(opened);
        free(file);
        free(copy);
        return dl_fail_memory(error, "a trajectory");
    }
    file->path = copy;
    file->file = (dl_h5md_file)DL_H5MD_CLOSED(copy);
    file->position.data = file->velocity.data = H5I_INVALID_HID;
    opened->file = file;
    const dl_status status = open_file(opened, error);
    if (status)
        dl_frames_close(opened);
    else
        *frames = opened;
    return status;
}

void dl_frames_close(dl_frames *frames) {
    if (!frames)
        return;
    struct dl_frames_file *const file = frames->file;
    if (file->position.data >= 0)
        H5Dclose(file->position.data);
    if (file->velocity.data >= 0)
        H5Dclose(file->velocity.data);
    dl_h5md_close(&file->file);
    free(file->components);
    free(file->path);
    free(file);
    free(frames->time);
    free(frames->step);
    free(frames->energy_error);
    free(frames->kinetic);
    free(frames->potential);
    free(frames->method);
    free(frames->options);
    free(frames);
}

bool dl_file_is_hdf5(const char *path) {
    static const unsigned char signature[8] = {0x89, 'H', 'D', 'F', '\r', '\n', 0x1a, '\n'};
    unsigned char begin[sizeof signature];
    FILE *const file = fopen(path, "rb");
    if (!file)
        return false;
    const size_t length = fread(begin, 1, sizeof begin, file);
    fclose(file);
    return length == sizeof begin && memcmp(begin, signature, sizeof begin) == 0;
}

/* --- frames --------------------------------------------------------------------------------- */

/* `flat`: third components, which a scene in two dimensions leaves out, are to be 0. */
static dl_status read_parts(dl_frames *frames, size_t number, int dimension, bool flat,
                            double *y_all, dl_error *error) {
    struct dl_frames_file *const file = frames->file;
    const size_t half = (size_t)dimension * frames->particles;
    const dl_h5md_vectors *const vectors[] = {&file->position, &file->velocity};
    static const char *const name[] = {"position/value", "velocity/value"};
    for (size_t part = 0; part < 2; part++) {
        const dl_status status = dl_h5md_read_vectors(&file->file, vectors[part], name[part],
                                                      number, file->components, error);
        if (status)
            return status;
        for (size_t k = half; flat && k < (size_t)frames->components * frames->particles; k++)
            if (file->components[k] != 0)
                return dl_fail(error, DL_INPUT,
                               "%s: %s of particle %zu, frame %zu: found a third component other "
                               "than 0, expected 0 for a scene in two dimensions",
                               file->path, name[part], k - half, number);
        memcpy(y_all + part * half, file->components, half * sizeof *y_all);
    }
    return DL_OK;
}

static dl_status check_frame(const dl_frames *frames, size_t number, int dimension,
                             dl_error *error) {
    if (number >= frames->count)
        return dl_fail(error, DL_INPUT, "%s: found no frame %zu, expected one of 0 to %zu",
                       frames->file->path, number, frames->count - 1);
    if (dimension > frames->components)
        return dl_fail(error, DL_INPUT, "%s: found vectors of %d components, expected %d",
                       frames->file->path, frames->components, dimension);
    return DL_OK;
}

dl_status dl_frames_read(dl_frames *frames, size_t number, int dimension, double *y_all,
                         dl_error *error) {
    const dl_status status = check_frame(frames, number, dimension, error);
    return status ? status : read_parts(frames, number, dimension, false, y_all, error);
}

dl_status dl_frames_read_state(dl_frames *frames, size_t number, const dl_scene *scene,
                               double *y_all, dl_error *error) {
    if (frames->particles != scene->particles)
        return dl_fail(error, DL_INPUT, "%s: found %zu particles, expected the scene's %zu",
                       frames->file->path, frames->particles, scene->particles);
    const dl_status status = check_frame(frames, number, scene->dimension, error);
    return status ? status : read_parts(frames, number, scene->dimension, true, y_all, error);
}

/* What frames there are, in few words: "0 to 1464, every 16", or the first and the last ones. */
static void list_steps(const dl_frames *frames, char *text, size_t size) {
    const long *const step = frames->step;
    const size_t last = frames->count - 1, shown = 6;
    bool regular = frames->count > 2;
    for (size_t k = 1; k < last && regular; k++)
        regular = step[k] - step[k - 1] == step[1] - step[0];
    if (regular) {
        int length = snprintf(text, size, "%ld to %ld, every %ld", step[0], step[last - 1],
                              step[1] - step[0]);
        if (step[last] - step[last - 1] == step[1] - step[0])
            snprintf(text, size, "%ld to %ld, every %ld", step[0], step[last], step[1] - step[0]);
        else
            snprintf(text + length, size - (size_t)length, ", and %ld", step[last]);
        return;
    }
    size_t used = 0;
    for (size_t k = 0; k <= last && used < size; k++) {
        if (k == shown && last > 2 * shown) {
            used += (size_t)snprintf(text + used, size - used, ", ...");
            k = last - shown;
        } else {
            used += (size_t)snprintf(text + used, size - used, k ? ", %ld" : "%ld", step[k]);
        }
    }
}

dl_status dl_frames_at_step(const dl_frames *frames, long step, size_t *number, dl_error *error) {
    for (size_t k = 0; k < frames->count; k++)
        if (frames->step[k] == step) {
            *number = k;
            return DL_OK;
        }
    char steps[256];
    list_steps(frames, steps, sizeof steps);
    return dl_fail(error, DL_INPUT, "%s: found no frame at step %ld; there are %zu, at steps %s",
                   frames->file->path, step, frames->count, steps);
}

dl_status dl_frames_at_time(const dl_frames *frames, double time, size_t *number, dl_error *error) {
    static const double part = 1e-6; /* of the interval between frames */
    const size_t last = frames->count - 1;
    const double interval = last ? (frames->time[last] - frames->time[0]) / (double)last : 0;
    size_t nearest = 0;
    for (size_t k = 1; k <= last; k++)
        if (fabs(frames->time[k] - time) < fabs(frames->time[nearest] - time))
            nearest = k;
    *number = nearest;
    const double found = frames->time[nearest];
    if (fabs(found - time) <= part * interval)
        return DL_OK;
    const size_t next = time > found && nearest < last ? nearest + 1 : nearest;
    const size_t before = time < found && nearest > 0 ? nearest - 1 : nearest;
    char other[80] = "";
    if (next != before)
        snprintf(other, sizeof other, " and %.15g (step %ld)", frames->time[next],
                 frames->step[next]);
    return dl_fail(error, DL_INPUT,
                   "%s: found no frame at time %.15g; there are %zu, from %.15g to %.15g, nearest "
                   "%.15g (step %ld)%s",
                   frames->file->path, time, frames->count, frames->time[0], frames->time[last],
                   frames->time[before], frames->step[before], other);
}
