#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "io/results_schema.h"

static size_t plain_size(dl_field_kind kind) {
    switch (kind) {
    case DL_FIELD_MESSAGE:
        return DL_MESSAGE_SIZE;
    case DL_FIELD_STATUS:
        return sizeof(dl_status);
    case DL_FIELD_UNSIGNED:
        return sizeof(unsigned);
    case DL_FIELD_ULONG:
        return sizeof(unsigned long);
    case DL_FIELD_SIZE:
        return sizeof(size_t);
    case DL_FIELD_INT:
        return sizeof(int);
    default:
        return sizeof(double);
    }
}

static size_t array_size(const dl_record *record, const dl_field *field, const void *element) {
    hsize_t shape[2];
    dl_field_shape(record, field, element, shape);
    return (size_t)(shape[0] * shape[1]) * sizeof(double);
}

static void pack_field(const dl_record *record, const dl_field *field, const void *element,
                       FILE *out) {
    const void *value = dl_field_at(field, element);
    if (dl_field_is_text(field->kind)) {
        const char *text = *(char *const *)value;
        const size_t length = text ? strlen(text) : 0;
        fwrite(&length, sizeof length, 1, out);
        fwrite(text ? text : "", 1, length, out);
    } else if (dl_field_is_array(field->kind)) {
        const double *array = *(double *const *)value;
        const size_t size = array ? array_size(record, field, element) : 0;
        fwrite(&size, sizeof size, 1, out);
        fwrite(array ? array : &(const double){0}, 1, size, out);
    } else
        fwrite(value, 1, plain_size(field->kind), out);
}

dl_status dl_record_pack(const dl_record *record, const void *element, void **bytes, size_t *size,
                         dl_error *error) {
    char *packed = NULL;
    FILE *out = open_memstream(&packed, size);
    if (!out)
        return dl_fail_memory(error, record->group);
    for (size_t i = 0; i < record->field_count; i++)
        pack_field(record, &record->fields[i], element, out);
    const bool failed = ferror(out) != 0;
    if (fclose(out) || failed) {
        free(packed);
        return dl_fail_memory(error, record->group);
    }
    *bytes = packed;
    return DL_OK;
}

/* The next `size` bytes; NULL where there are fewer. */
static const char *take(const char **at, const char *end, size_t size) {
    const char *here = *at;
    if (size > (size_t)(end - here))
        return NULL;
    *at += size;
    return here;
}

/* A copy of the next `size` bytes with a 0 after them; NULL where there are fewer or no memory. */
static void *take_copy(const char **at, const char *end, size_t size) {
    const char *here = take(at, end, size);
    char *copy = here ? calloc(size + 1, 1) : NULL;
    if (copy)
        memcpy(copy, here, size);
    return copy;
}

static bool unpack_field(const dl_record *record, const dl_field *field, const char **at,
                         const char *end, void *element) {
    void *value = dl_field_at(field, element);
    const char *bytes;
    if (dl_field_is_text(field->kind)) {
        size_t length;
        if (!(bytes = take(at, end, sizeof length)))
            return false;
        memcpy(&length, bytes, sizeof length);
        return (*(char **)value = take_copy(at, end, length)) != NULL;
    }
    if (dl_field_is_array(field->kind)) {
        const size_t expected = array_size(record, field, element);
        size_t size;
        if (!(bytes = take(at, end, sizeof size)))
            return false;
        memcpy(&size, bytes, sizeof size);
        if (size == 0 && field->is_optional)
            return true;
        return size == expected && (*(double **)value = take_copy(at, end, size)) != NULL;
    }
    if (!(bytes = take(at, end, plain_size(field->kind))))
        return false;
    memcpy(value, bytes, plain_size(field->kind));
    return true;
}

dl_status dl_record_unpack(const dl_record *record, const void *bytes, size_t size, void *element,
                           dl_error *error) {
    const char *at = bytes, *end = at + size;
    memset(element, 0, record->size);
    for (size_t i = 0; i < record->field_count; i++)
        if (!unpack_field(record, &record->fields[i], &at, end, element))
            return dl_fail(error, DL_ERROR, "%s: what another process sent is damaged",
                           record->group);
    return DL_OK;
}
