/* H5MD files: opening, and the vectors of a frame. */
#include "io/h5md_file.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "driftlab/trajectory.h"

dl_status dl_h5md_refuse(const dl_h5md_file *r, dl_error *error, const char *found,
                         const char *expected) {
    return dl_fail(error, DL_INPUT, "%s: found %s, expected %s", r->path, found, expected);
}

/* --- opening -------------------------------------------------------------------------------- */

dl_status dl_h5md_open(dl_h5md_file *r, dl_error *error) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    FILE *readable = fopen(r->path, "rb");
    if (!readable)
        return dl_fail(error, DL_INPUT, "%s: cannot be read; expected an H5MD file", r->path);
    fclose(readable);
    r->file = H5Fopen(r->path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (r->file < 0)
        return dl_h5md_refuse(r, error,
                              dl_file_is_hdf5(r->path) ? "a damaged or truncated HDF5 file"
                                                       : "no HDF5 file",
                              "an H5MD file");
    if (H5Lexists(r->file, "h5md", H5P_DEFAULT) <= 0 ||
        H5Lexists(r->file, "particles", H5P_DEFAULT) <= 0)
        return dl_h5md_refuse(r, error, "an HDF5 file without /h5md or /particles", "an H5MD file");
    r->particles = H5Gopen2(r->file, "particles", H5P_DEFAULT);
    char name[256];
    if (r->particles < 0 || H5Lget_name_by_idx(r->particles, ".", H5_INDEX_NAME, H5_ITER_INC, 0,
                                               name, sizeof name, H5P_DEFAULT) < 0)
        return dl_h5md_refuse(r, error, "/particles without a group",
                              "an H5MD file with particles");
    r->group = H5Gopen2(r->particles, name, H5P_DEFAULT);
    return r->group >= 0
               ? DL_OK
               : dl_h5md_refuse(r, error, "/particles that cannot be read", "an H5MD file");
}

void dl_h5md_close(dl_h5md_file *r) {
    if (r->group >= 0)
        H5Gclose(r->group);
    if (r->particles >= 0)
        H5Gclose(r->particles);
    if (r->file >= 0)
        H5Fclose(r->file);
}

dl_status dl_h5md_open_vectors(const dl_h5md_file *r, const char *name, dl_h5md_vectors *opened,
                               dl_error *error) {
    bool good = false;
    opened->data = H5Dopen2(r->group, name, H5P_DEFAULT);
    if (opened->data >= 0) {
        const hid_t space = H5Dget_space(opened->data);
        good = H5Sget_simple_extent_ndims(space) == 3 &&
               H5Sget_simple_extent_dims(space, opened->extent, NULL) == 3;
        H5Sclose(space);
    }
    if (!good)
        return dl_fail(error, DL_INPUT,
                       "%s: found no %s [frame][particle][component] in the first group of "
                       "/particles",
                       r->path, name);
    if (opened->extent[0] == 0)
        return dl_h5md_refuse(r, error, "no frame", "a trajectory with at least one");
    if (opened->extent[1] == 0 || opened->extent[2] < 2 || opened->extent[2] > DL_H5MD_SPATIAL)
        return dl_fail(error, DL_INPUT,
                       "%s: found %llu particles of %llu components, expected at least one, of 2 "
                       "or 3",
                       r->path, (unsigned long long)opened->extent[1],
                       (unsigned long long)opened->extent[2]);
    return DL_OK;
}

/* --- vectors of one frame -------------------------------------------------------------------- */

static dl_status copy_components(const dl_h5md_file *r, const dl_h5md_vectors *opened,
                                 const char *name, const double *rows, double *out,
                                 dl_error *error) {
    const size_t n = (size_t)opened->extent[1], width = (size_t)opened->extent[2];
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < width; k++) {
            if (!isfinite(rows[i * width + k]))
                return dl_fail(error, DL_INPUT,
                               "%s: %s: particle %zu: component %zu is not finite, expected a "
                               "finite number",
                               r->path, name, i, k);
            out[k * n + i] = rows[i * width + k];
        }
    return DL_OK;
}

dl_status dl_h5md_read_vectors(const dl_h5md_file *r, const dl_h5md_vectors *opened,
                               const char *name, hsize_t number, double *out, dl_error *error) {
    const hsize_t start[3] = {number, 0, 0};
    const hsize_t count[3] = {1, opened->extent[1], opened->extent[2]};
    double *rows = malloc((size_t)(count[1] * count[2]) * sizeof *rows);
    if (!rows)
        return dl_fail_memory(error, "a frame of a trajectory");
    const hid_t file_space = H5Dget_space(opened->data);
    const hid_t memory_space = H5Screate_simple(3, count, NULL);
    H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, NULL, count, NULL);
    const herr_t read =
        H5Dread(opened->data, H5T_NATIVE_DOUBLE, memory_space, file_space, H5P_DEFAULT, rows);
    H5Sclose(memory_space);
    H5Sclose(file_space);
    const dl_status status = read < 0
                                 ? dl_fail(error, DL_IO, "%s: %s cannot be read", r->path, name)
                                 : copy_components(r, opened, name, rows, out, error);
    free(rows);
    return status;
}

/* --- texts ----------------------------------------------------------------------------------- */

static char *read_text(hid_t data) {
    const hid_t stored = H5Dget_type(data);
    const size_t size = H5Tget_size(stored);
    char *text = NULL;
    if (H5Tget_class(stored) == H5T_STRING && H5Tis_variable_str(stored) == 0)
        text = calloc(size + 1, 1);
    if (text && H5Dread(data, stored, H5S_ALL, H5S_ALL, H5P_DEFAULT, text) < 0) {
        free(text);
        text = NULL;
    }
    H5Tclose(stored);
    return text;
}

char *dl_h5md_read_parameter(const dl_h5md_file *r, const char *name) {
    const hid_t group = H5Lexists(r->file, "parameters", H5P_DEFAULT) > 0
                            ? H5Gopen2(r->file, "parameters", H5P_DEFAULT)
                            : H5I_INVALID_HID;
    if (group < 0)
        return NULL;
    const hid_t data = H5Dopen2(group, name, H5P_DEFAULT);
    char *const text = data >= 0 ? read_text(data) : NULL;
    if (data >= 0)
        H5Dclose(data);
    H5Gclose(group);
    return text;
}
