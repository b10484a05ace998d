#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/results.h"
#include "io/replace_file.h"
#include "io/results_schema.h"

/* Calls of HDF5 fail here by running out of memory or at its own limits (an attribute ends at
 * 64 KiB): `what` says where. */
static dl_status failed(const char *what, dl_error *error) {
    return dl_fail(error, DL_IO, "results: HDF5 could not store %s", what);
}

static hid_t text_type(size_t length) {
    hid_t type = H5Tcopy(H5T_C_S1);
    if (type < 0)
        return type;
    H5Tset_size(type, length + 1);
    H5Tset_strpad(type, H5T_STR_NULLTERM);
    H5Tset_cset(type, H5T_CSET_UTF8);
    return type;
}

static int write_attribute(hid_t owner, const char *name, hid_t stored, hid_t native,
                           const void *value) {
    hid_t space = H5Screate(H5S_SCALAR);
    hid_t attribute = H5Acreate2(owner, name, stored, space, H5P_DEFAULT, H5P_DEFAULT);
    int bad = attribute < 0 || H5Awrite(attribute, native, value) < 0;
    if (attribute >= 0)
        H5Aclose(attribute);
    H5Sclose(space);
    return bad;
}

static int write_text(hid_t owner, const char *name, const char *text) {
    text = text ? text : "";
    hid_t type = text_type(strlen(text));
    int bad = write_attribute(owner, name, type, type, text);
    H5Tclose(type);
    return bad;
}

static int write_dataset(hid_t owner, const char *name, hid_t space, hid_t stored, hid_t native,
                         const void *data) {
    hid_t set = H5Dcreate2(owner, name, stored, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    int bad = set < 0 || (data && H5Dwrite(set, native, H5S_ALL, H5S_ALL, H5P_DEFAULT, data) < 0);
    if (set >= 0)
        H5Dclose(set);
    H5Sclose(space);
    return bad;
}

static int write_long_text(hid_t owner, const char *name, const char *text) {
    text = text ? text : "";
    hid_t type = text_type(strlen(text));
    int bad = write_dataset(owner, name, H5Screate(H5S_SCALAR), type, type, text);
    H5Tclose(type);
    return bad;
}

static int write_field(hid_t owner, const dl_record *record, const dl_field *field,
                       const void *element) {
    const void *value = dl_field_at(field, element);
    if (dl_field_is_array(field->kind)) {
        if (field->is_optional && !*(double *const *)value)
            return 0;
        hsize_t shape[2];
        int rank = dl_field_shape(record, field, element, shape);
        return write_dataset(owner, field->name, H5Screate_simple(rank, shape, NULL),
                             H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, *(double *const *)value);
    }
    switch (field->kind) {
    case DL_FIELD_TEXT:
        return write_text(owner, field->name, *(char *const *)value);
    case DL_FIELD_LONG_TEXT:
        return write_long_text(owner, field->name, *(char *const *)value);
    case DL_FIELD_MESSAGE:
        return write_text(owner, field->name, value);
    case DL_FIELD_STATUS:
        return write_text(owner, field->name, dl_status_name(*(const dl_status *)value));
    default:
        return write_attribute(owner, field->name, dl_field_stored(field->kind),
                               dl_field_native(field->kind), value);
    }
}

static dl_status write_element(hid_t owner, const dl_record *record, const void *element,
                               dl_error *error) {
    for (size_t i = 0; i < record->field_count; i++)
        if (write_field(owner, record, &record->fields[i], element))
            return failed(record->fields[i].name, error);
    return DL_OK;
}

static dl_status write_record(hid_t file, const dl_record *record, const dl_results *results,
                              dl_error *error) {
    size_t count = *(const size_t *)((const char *)results + record->count);
    const char *array = *(char *const *)((const char *)results + record->array);
    hid_t group = H5Gcreate2(file, record->group, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    if (group < 0)
        return failed(record->group, error);
    dl_status status = DL_OK;
    for (size_t i = 0; i < count && status == DL_OK; i++) {
        char name[32];
        snprintf(name, sizeof name, "%04zu", i);
        hid_t element = H5Gcreate2(group, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        if (element < 0) {
            status = failed(record->group, error);
            break;
        }
        status = write_element(element, record, array + i * record->size, error);
        H5Gclose(element);
    }
    H5Gclose(group);
    return status;
}

static dl_status write_contents(hid_t file, const dl_results *results, dl_error *error) {
    int version = DL_RESULTS_VERSION;
    if (write_text(file, "format", DL_RESULTS_FORMAT) ||
        write_attribute(file, "version", H5T_STD_I32LE, H5T_NATIVE_INT, &version))
        return failed("the format", error);
    dl_status status = write_element(file, &dl_results_head, results, error);
    for (size_t r = 0; r < DL_RECORDS && status == DL_OK; r++)
        status = write_record(file, &dl_results_records[r], results, error);
    return status;
}

/* The finished file as bytes, so that writing it is one plain write that can be synced. */
static dl_status file_image(hid_t file, void **image, size_t *size, dl_error *error) {
    *image = NULL;
    if (H5Fflush(file, H5F_SCOPE_GLOBAL) < 0)
        return failed("the file", error);
    ssize_t needed = H5Fget_file_image(file, NULL, 0);
    if (needed <= 0)
        return failed("the file", error);
    *size = (size_t)needed;
    *image = malloc(*size);
    if (!*image)
        return dl_fail_memory(error, "a results file");
    return H5Fget_file_image(file, *image, *size) == needed ? DL_OK : failed("the file", error);
}

dl_status dl_results_write(const dl_results *results, const char *path, dl_error *error) {
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    if (access < 0 || H5Pset_fapl_core(access, 1 << 20, 0) < 0)
        return failed("a file in memory", error);
    hid_t file = H5Fcreate("results in memory", H5F_ACC_TRUNC, H5P_DEFAULT, access);
    H5Pclose(access);
    if (file < 0)
        return failed("a file in memory", error);
    void *image = NULL;
    size_t size = 0;
    dl_status status = write_contents(file, results, error);
    if (status == DL_OK)
        status = file_image(file, &image, &size, error);
    H5Fclose(file);
    if (status == DL_OK)
        status = dl_replace_file(path, image, size, error);
    free(image);
    return status;
}
