/* A frame of an H5MD file, of driftlab's own or another program's: the first group of /particles,
 * its position/value and velocity/value [frame][particle][component], and its mass, coupling,
 * pinned, gravity [particle] where it has them. */
#include "driftlab/trajectory.h"

#include <hdf5.h>
#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include "io/h5md_file.h"

/* --- one frame ------------------------------------------------------------------------------ */

/* H5MD allows one time a frame, or the interval between frames. */
static double time_of(const dl_h5md_file *r, hsize_t number) {
    const hid_t data = H5Dopen2(r->group, "position/time", H5P_DEFAULT);
    if (data < 0)
        return NAN;
    const hid_t space = H5Dget_space(data);
    double time = NAN;
    if (H5Sget_simple_extent_ndims(space) == 0) {
        if (H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, &time) >= 0)
            time *= (double)number;
    } else {
        const hsize_t one = 1;
        const hid_t memory_space = H5Screate(H5S_SCALAR);
        H5Sselect_hyperslab(space, H5S_SELECT_SET, &number, NULL, &one, NULL);
        if (H5Dread(data, H5T_NATIVE_DOUBLE, memory_space, space, H5P_DEFAULT, &time) < 0)
            time = NAN;
        H5Sclose(memory_space);
    }
    H5Sclose(space);
    H5Dclose(data);
    return time;
}

static dl_status read_vectors(const dl_h5md_file *r, const char *name, size_t number,
                              dl_trajectory_frame *frame, double **out, dl_error *error) {
    dl_h5md_vectors opened = {.data = H5I_INVALID_HID};
    dl_status status = dl_h5md_open_vectors(r, name, &opened, error);
    const bool first = frame->particles == 0;
    if (!status && first) {
        frame->frames = (size_t)opened.extent[0];
        frame->particles = (size_t)opened.extent[1];
        frame->components = (int)opened.extent[2];
    } else if (!status &&
               (frame->frames != opened.extent[0] || frame->particles != opened.extent[1])) {
        status = dl_h5md_refuse(r, error,
                                "other numbers of frames or particles for position and velocity",
                                "one velocity for every position");
    }
    if (!status && number != SIZE_MAX && number >= frame->frames)
        status = dl_fail(error, DL_INPUT, "%s: found no frame %zu, expected one of 0 to %zu",
                         r->path, number, frame->frames - 1);
    if (!status) {
        *out = calloc(DL_H5MD_SPATIAL * frame->particles, sizeof **out);
        status = *out ? dl_h5md_read_vectors(r, &opened, name,
                                             number == SIZE_MAX ? frame->frames - 1 : number, *out,
                                             error)
                      : dl_fail_memory(error, "a frame of a trajectory");
    }
    if (opened.data >= 0)
        H5Dclose(opened.data);
    return status;
}

/* --- what the particles are ----------------------------------------------------------------- */

/* A value a particle; *values stays NULL where the file has none. */
static dl_status read_values(const dl_h5md_file *r, const char *name, size_t count, hid_t type,
                             size_t size, void **values, dl_error *error) {
    if (H5Lexists(r->group, name, H5P_DEFAULT) <= 0)
        return DL_OK;
    const hid_t data = H5Dopen2(r->group, name, H5P_DEFAULT);
    const hid_t space = data >= 0 ? H5Dget_space(data) : H5I_INVALID_HID;
    bool good = space >= 0 && H5Sget_simple_extent_ndims(space) == 1 &&
                H5Sget_simple_extent_npoints(space) == (hssize_t)count;
    if (good) {
        *values = calloc(count, size);
        good = *values && H5Dread(data, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) >= 0;
    }
    if (space >= 0)
        H5Sclose(space);
    if (data >= 0)
        H5Dclose(data);
    return good ? DL_OK
                : dl_fail(error, DL_INPUT, "%s: %s cannot be read, expected a number a particle",
                          r->path, name);
}

static dl_status read_reals(const dl_h5md_file *r, const char *name, size_t count, double **values,
                            dl_error *error) {
    void *read = NULL;
    const dl_status status =
        read_values(r, name, count, H5T_NATIVE_DOUBLE, sizeof **values, &read, error);
    *values = read;
    return status;
}

static dl_status read_flags(const dl_h5md_file *r, const char *name, size_t count, bool **values,
                            dl_error *error) {
    void *read = NULL;
    const dl_status status = read_values(r, name, count, H5T_NATIVE_UCHAR, 1, &read, error);
    const unsigned char *const byte = read;
    *values = byte && !status ? calloc(count, sizeof **values) : NULL;
    for (size_t i = 0; *values && i < count; i++)
        (*values)[i] = byte[i] != 0;
    const bool failed = byte && !status && !*values;
    free(read);
    return failed ? dl_fail_memory(error, name) : status;
}

/* The names of the species, of `width` bytes each with their end; NULL where there are none or they
 * cannot be read. */
static char *read_species_names(const dl_h5md_file *r, size_t *count, size_t *width) {
    const hid_t attribute = H5Aexists(r->group, "species_names") > 0
                                ? H5Aopen(r->group, "species_names", H5P_DEFAULT)
                                : H5I_INVALID_HID;
    if (attribute < 0)
        return NULL;
    const hid_t stored = H5Aget_type(attribute), space = H5Aget_space(attribute);
    const hid_t type = H5Tcopy(H5T_C_S1);
    *count = (size_t)H5Sget_simple_extent_npoints(space);
    *width = H5Tget_size(stored) + 1;
    H5Tset_size(type, *width);
    char *names = H5Tget_class(stored) == H5T_STRING && H5Tis_variable_str(stored) == 0
                      ? calloc(*count, *width)
                      : NULL;
    if (names && H5Aread(attribute, type, names) < 0) {
        free(names);
        names = NULL;
    }
    H5Tclose(type);
    H5Tclose(stored);
    H5Sclose(space);
    H5Aclose(attribute);
    return names;
}

/* Species without names (of another program) are passed over. */
static dl_status read_species(const dl_h5md_file *r, dl_trajectory_frame *frame, dl_error *error) {
    size_t count, width;
    void *read = NULL;
    frame->species_text = read_species_names(r, &count, &width);
    if (!frame->species_text)
        return DL_OK;
    dl_status status =
        read_values(r, "species", frame->particles, H5T_NATIVE_INT, sizeof(int), &read, error);
    const int *const number = read;
    if (!status && number) {
        frame->species = calloc(frame->particles, sizeof *frame->species);
        status = frame->species ? DL_OK : dl_fail_memory(error, "species");
    }
    for (size_t i = 0; number && i < frame->particles && !status; i++) {
        if (number[i] < 0 || (size_t)number[i] >= count)
            status = dl_fail(error, DL_INPUT,
                             "%s: species: particle %zu: found %d, expected less "
                             "than %zu",
                             r->path, i, number[i], count);
        else
            frame->species[i] = frame->species_text + (size_t)number[i] * width;
    }
    free(read);
    return status;
}

static dl_status read_attributes(const dl_h5md_file *r, dl_trajectory_frame *frame,
                                 dl_error *error) {
    const size_t n = frame->particles;
    dl_status status = read_reals(r, "mass", n, &frame->inertia, error);
    if (!status)
        status = read_reals(r, "coupling", n, &frame->coupling, error);
    if (!status)
        status = read_flags(r, "pinned", n, &frame->pinned, error);
    if (!status)
        status = read_flags(r, "gravity", n, &frame->feels_gravity, error);
    return status ? status : read_species(r, frame, error);
}

/* --- the whole ------------------------------------------------------------------------------ */

void dl_trajectory_frame_free(dl_trajectory_frame *frame) {
    free(frame->position);
    free(frame->velocity);
    free(frame->inertia);
    free(frame->coupling);
    free(frame->pinned);
    free(frame->feels_gravity);
    free(frame->species);
    free(frame->species_text);
    *frame = (dl_trajectory_frame){0};
}

dl_status dl_trajectory_read_frame(const char *path, size_t number, dl_trajectory_frame *frame,
                                   dl_error *error) {
    dl_h5md_file r = DL_H5MD_CLOSED(path);
    *frame = (dl_trajectory_frame){0};
    dl_status status = dl_h5md_open(&r, error);
    if (!status)
        status = read_vectors(&r, "position/value", number, frame, &frame->position, error);
    if (!status)
        status = read_vectors(&r, "velocity/value", number, frame, &frame->velocity, error);
    if (!status)
        status = read_attributes(&r, frame, error);
    if (!status)
        frame->time = time_of(&r, number == SIZE_MAX ? frame->frames - 1 : number);
    dl_h5md_close(&r);
    if (status)
        dl_trajectory_frame_free(frame);
    return status;
}

static dl_status check_particles(const char *path, const dl_scene *scene,
                                 const dl_trajectory_frame *frame, dl_error *error) {
    const size_t n = frame->particles;
    if (n != scene->particles || frame->components < scene->dimension)
        return dl_fail(error, DL_INPUT,
                       "%s: found %zu particles of %d components, expected the scene's %zu of %d "
                       "(or 3)",
                       path, n, frame->components, scene->particles, scene->dimension);
    for (size_t k = (size_t)scene->dimension * n; k < DL_H5MD_SPATIAL * n; k++)
        if (frame->position[k] != 0 || frame->velocity[k] != 0)
            return dl_fail(error, DL_INPUT,
                           "%s: particle %zu: found a third component other than 0, expected 0 for "
                           "a scene in two dimensions",
                           path, k % n);
    return DL_OK;
}

dl_status dl_trajectory_read_last(const char *path, const dl_scene *scene, double **y_all,
                                  double *time, dl_error *error) {
    return dl_trajectory_read_state(path, SIZE_MAX, scene, y_all, time, error);
}

dl_status dl_trajectory_read_state(const char *path, size_t number, const dl_scene *scene,
                                   double **y_all, double *time, dl_error *error) {
    const size_t components = (size_t)scene->dimension * scene->particles;
    dl_trajectory_frame frame;
    *y_all = NULL;
    dl_status status = dl_trajectory_read_frame(path, number, &frame, error);
    if (status)
        return status;
    status = check_particles(path, scene, &frame, error);
    if (!status) {
        *y_all = malloc(2 * components * sizeof **y_all);
        status = *y_all ? DL_OK : dl_fail_memory(error, "a state of every particle");
    }
    if (!status) {
        memcpy(*y_all, frame.position, components * sizeof **y_all);
        memcpy(*y_all + components, frame.velocity, components * sizeof **y_all);
        *time = frame.time;
    }
    dl_trajectory_frame_free(&frame);
    return status;
}

/* --- the scene it is of ---------------------------------------------------------------------- */

dl_status dl_trajectory_read_scene_text(const char *path, char **text, dl_error *error) {
    dl_h5md_file r = DL_H5MD_CLOSED(path);
    *text = NULL;
    dl_status status = dl_h5md_open(&r, error);
    if (!status) {
        *text = dl_h5md_read_parameter(&r, "scene_file");
        if (!*text)
            status =
                dl_h5md_refuse(&r, error, "no text of a scene", "a trajectory that driftlab wrote");
    }
    dl_h5md_close(&r);
    return status;
}
