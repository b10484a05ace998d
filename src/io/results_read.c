#include <errno.h>
#include <fcntl.h>
#include <hdf5.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "driftlab/results.h"
#include "io/results_origin.h"
#include "io/results_schema.h"

/* Where the reader is, for messages: "study.h5: cases/0003/steps". */
typedef struct place {
    const char *path, *group, *element;
    hid_t file;
    int version;
    dl_error *error;
} place;

static const char *slash(const char *before) {
    return *before ? "/" : "";
}

static dl_status is_damaged(const place *at, const char *name, const char *expected) {
    return dl_fail(at->error, DL_INPUT, "%s: %s%s%s%s%s: damaged, expected %s", at->path, at->group,
                   slash(at->group), at->element, slash(at->element), name, expected);
}

/* Files are complete or not there at all: one that lacks something is another program's, or
 * damaged. */
static dl_status lacks(const place *at, const char *name) {
    char lacking[256];
    snprintf(lacking, sizeof lacking, "%s%s%s%s%s", at->group, slash(at->group), at->element,
             slash(at->element), name);
    return dl_results_fail_other_program(at->path, at->file, at->version, lacking, at->error);
}

static dl_status adopt_text(const place *at, const char *name, hid_t type, char **text) {
    free(*text);
    *text = NULL;
    if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) > 0)
        return is_damaged(at, name, "a text of fixed length");
    *text = calloc(H5Tget_size(type) + 1, 1);
    return *text ? DL_OK : dl_fail_memory(at->error, "a text");
}

static dl_status read_text(const place *at, hid_t owner, const char *name, char **text) {
    hid_t attribute = H5Aopen(owner, name, H5P_DEFAULT);
    if (attribute < 0)
        return lacks(at, name);
    hid_t type = H5Aget_type(attribute);
    dl_status status = adopt_text(at, name, type, text);
    if (status == DL_OK && H5Aread(attribute, type, *text) < 0)
        status = is_damaged(at, name, "a text attribute");
    H5Tclose(type);
    H5Aclose(attribute);
    return status;
}

static dl_status read_long_text(const place *at, hid_t owner, const char *name, char **text) {
    hid_t set = H5Dopen2(owner, name, H5P_DEFAULT);
    if (set < 0)
        return lacks(at, name);
    hid_t type = H5Dget_type(set);
    dl_status status = adopt_text(at, name, type, text);
    if (status == DL_OK && H5Dread(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, *text) < 0)
        status = is_damaged(at, name, "a text dataset");
    H5Tclose(type);
    H5Dclose(set);
    return status;
}

static dl_status read_message(const place *at, hid_t owner, const char *name, char *message) {
    char *text = NULL;
    dl_status status = read_text(at, owner, name, &text);
    if (status == DL_OK)
        snprintf(message, DL_MESSAGE_SIZE, "%s", text);
    free(text);
    return status;
}

static dl_status read_status(const place *at, hid_t owner, const char *name, dl_status *value) {
    char *text = NULL;
    dl_status status = read_text(at, owner, name, &text);
    if (status == DL_OK)
        *value = dl_status_from_name(text);
    free(text);
    return status;
}

static dl_status read_number(const place *at, hid_t owner, const dl_field *field, void *value) {
    hid_t attribute = H5Aopen(owner, field->name, H5P_DEFAULT);
    if (attribute < 0)
        return lacks(at, field->name);
    hid_t space = H5Aget_space(attribute);
    int bad = H5Sget_simple_extent_npoints(space) != 1 ||
              H5Aread(attribute, dl_field_native(field->kind), value) < 0;
    H5Sclose(space);
    H5Aclose(attribute);
    return bad ? is_damaged(at, field->name, "a number") : DL_OK;
}

/* The shape must be what `samples` and `particles`, read before, say. */
static dl_status read_series(const place *at, hid_t owner, const dl_record *record,
                             const dl_field *field, const void *element, double **values) {
    hsize_t shape[2], found[2] = {0, 1};
    int rank = dl_field_shape(record, field, element, shape);
    hid_t set = H5Dopen2(owner, field->name, H5P_DEFAULT);
    if (set < 0)
        return lacks(at, field->name);
    hid_t space = H5Dget_space(set);
    dl_status status = DL_OK;
    if (H5Sget_simple_extent_ndims(space) != rank ||
        H5Sget_simple_extent_dims(space, found, NULL) < 0 || found[0] != shape[0] ||
        found[1] != shape[1]) {
        status = is_damaged(at, field->name, "one row a sample");
    } else {
        *values = calloc((size_t)(shape[0] * shape[1]) + 1, sizeof **values);
        if (!*values)
            status = dl_fail_memory(at->error, field->name);
        else if (H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, *values) < 0)
            status = is_damaged(at, field->name, "one row a sample");
    }
    H5Sclose(space);
    H5Dclose(set);
    return status;
}

static bool is_dataset(const dl_field *field) {
    return field->kind == DL_FIELD_LONG_TEXT || field->kind == DL_FIELD_SERIES ||
           field->kind == DL_FIELD_POSITIONS;
}

static bool is_missing(hid_t owner, const dl_field *field) {
    if (!field->is_optional)
        return false;
    return (is_dataset(field) ? H5Lexists(owner, field->name, H5P_DEFAULT)
                              : H5Aexists(owner, field->name)) == 0;
}

static dl_status set_missing(const place *at, const dl_field *field, void *value) {
    if (field->kind != DL_FIELD_TEXT)
        return DL_OK;
    char **text = value;
    *text = strdup("");
    return *text ? DL_OK : dl_fail_memory(at->error, "a text");
}

static dl_status read_field(const place *at, hid_t owner, const dl_record *record,
                            const dl_field *field, void *element) {
    void *value = dl_field_at(field, element);
    if (is_missing(owner, field))
        return set_missing(at, field, value);
    if (dl_field_is_array(field->kind))
        return read_series(at, owner, record, field, element, value);
    switch (field->kind) {
    case DL_FIELD_TEXT:
        return read_text(at, owner, field->name, value);
    case DL_FIELD_LONG_TEXT:
        return read_long_text(at, owner, field->name, value);
    case DL_FIELD_MESSAGE:
        return read_message(at, owner, field->name, value);
    case DL_FIELD_STATUS:
        return read_status(at, owner, field->name, value);
    default:
        return read_number(at, owner, field, value);
    }
}

static dl_status read_element(const place *at, hid_t owner, const dl_record *record,
                              void *element) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < record->field_count && status == DL_OK; i++)
        status = read_field(at, owner, record, &record->fields[i], element);
    return status;
}

static dl_status read_elements(place *at, hid_t group, const dl_record *record, char *array,
                               size_t *count, size_t found) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < found && status == DL_OK; i++) {
        char name[32];
        snprintf(name, sizeof name, "%04zu", i);
        at->element = name;
        hid_t element = H5Gopen2(group, name, H5P_DEFAULT);
        if (element < 0) {
            status = is_damaged(at, "", "a group");
        } else {
            (*count)++; /* before it is read: what a half-read one owns is freed with the others */
            status = read_element(at, element, record, array + i * record->size);
            H5Gclose(element);
        }
        at->element = "";
    }
    return status;
}

static dl_status read_record(place *at, hid_t file, const dl_record *record, dl_results *results) {
    size_t *count = (size_t *)((char *)results + record->count);
    char **array = (char **)((char *)results + record->array);
    if (record == &dl_results_records[DL_RECORD_FINDINGS] &&
        H5Lexists(file, record->group, H5P_DEFAULT) == 0)
        return DL_OK; /* a file from before there were any */
    hid_t group = H5Gopen2(file, record->group, H5P_DEFAULT);
    if (group < 0)
        return lacks(at, record->group);
    H5G_info_t info;
    dl_status status = DL_OK;
    at->group = record->group;
    if (H5Gget_info(group, &info) < 0)
        status = is_damaged(at, "", "a group");
    else if (info.nlinks && !(*array = calloc((size_t)info.nlinks, record->size)))
        status = dl_fail_memory(at->error, record->group);
    else
        status = read_elements(at, group, record, *array, count, (size_t)info.nlinks);
    at->group = "";
    H5Gclose(group);
    return status;
}

static dl_status check_format(place *at, hid_t file) {
    char *format = NULL;
    dl_status status = read_text(at, file, "format", &format);
    if (status != DL_OK || !format || strcmp(format, DL_RESULTS_FORMAT) != 0)
        status = dl_fail(at->error, DL_INPUT,
                         "%s: found an HDF5 file without format \"%s\", expected a results file "
                         "of driftlab study",
                         at->path, DL_RESULTS_FORMAT);
    free(format);
    if (status != DL_OK)
        return status;
    const dl_field field = {"version", DL_FIELD_INT, 0, false};
    status = read_number(at, file, &field, &at->version);
    return status == DL_OK && (at->version < 1 || at->version > DL_RESULTS_VERSION)
               ? dl_results_fail_other_program(at->path, file, at->version, "", at->error)
               : status;
}

static dl_status open_file(const char *path, hid_t *file, dl_error *error) {
    int plain = open(path, O_RDONLY | O_CLOEXEC);
    if (plain < 0)
        return dl_fail(error, DL_IO, "%s: cannot be read: %s", path, strerror(errno));
    close(plain);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
    if (H5Fis_hdf5(path) <= 0)
        return dl_fail(error, DL_INPUT,
                       "%s: found no HDF5 file, expected a results file of driftlab study", path);
    *file = H5Fopen(path, H5F_ACC_RDONLY, H5P_DEFAULT);
    if (*file < 0)
        return dl_fail(error, DL_INPUT,
                       "%s: found a damaged or truncated HDF5 file, expected a results file of "
                       "driftlab study",
                       path);
    return DL_OK;
}

dl_status dl_results_read(const char *path, dl_results **results, dl_error *error) {
    *results = NULL;
    hid_t file = -1;
    dl_status status = open_file(path, &file, error);
    if (status != DL_OK)
        return status;
    place at = {.path = path, .group = "", .element = "", .file = file, .error = error};
    dl_results *made = NULL;
    status = check_format(&at, file);
    if (status == DL_OK)
        status = dl_results_create(&made, error);
    if (status == DL_OK)
        status = read_element(&at, file, &dl_results_head, made);
    for (size_t r = 0; r < DL_RECORDS && status == DL_OK; r++)
        status = read_record(&at, file, &dl_results_records[r], made);
    H5Fclose(file);
    if (status != DL_OK) {
        dl_results_free(made);
        made = NULL;
    }
    *results = made;
    return status;
}
