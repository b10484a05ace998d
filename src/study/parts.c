#include "study/parts.h"

#include <stdlib.h>
#include <string.h>
#include "io/results_schema.h"

static const dl_record *record_of(const dl_study *study) {
    return &dl_results_records[study->kind->measure ? DL_RECORD_FINDINGS : DL_RECORD_CASES];
}

static size_t *count_of(const dl_record *record, dl_results *results) {
    return (size_t *)((char *)results + record->count);
}

static char **array_of(const dl_record *record, dl_results *results) {
    return (char **)((char *)results + record->array);
}

/* The key is the first field of both records. */
static char *key_of(const dl_record *record, const void *element) {
    return *(char **)dl_field_at(&record->fields[0], element);
}

bool dl_part_is_done(const dl_study *study, const dl_results *results, size_t part) {
    const char *key = study->cased[part].key;
    return study->kind->measure ? dl_results_find_finding(results, key) != NULL
                                : dl_results_find(results, key) != NULL;
}

char *dl_part_label(const dl_study *study, size_t part) {
    const dl_study_case *cased = &study->cased[part];
    return dl_text("%s: %s %s", study->scene[cased->scene].scene->name, cased->run.row->name,
                   cased->run.text);
}

dl_status dl_part_measure(const dl_study *study, const dl_results *results, size_t part,
                          const dl_watch *watch, void (*heard)(void *context, const char *),
                          void *heard_context, dl_study_part *measured, dl_error *error) {
    const dl_study_case *cased = &study->cased[part];
    if (study->kind->measure)
        return dl_study_measure_unit(study, cased, watch, heard, heard_context, &measured->finding,
                                     error);
    const char *scene = study->scene[cased->scene].scene->name;
    return dl_study_measure_case(study, cased, dl_results_reference(results, scene), watch,
                                 &measured->cased, error);
}

void dl_part_release(const dl_study *study, dl_study_part *part) {
    dl_record_release(record_of(study), part);
}

dl_status dl_part_add(const dl_study *study, dl_results *results, dl_study_part *part,
                      dl_error *error) {
    const dl_status status = study->kind->measure
                                 ? dl_results_add_finding(results, &part->finding, error)
                                 : dl_results_add_case(results, &part->cased, error);
    if (status != DL_OK)
        dl_part_release(study, part);
    return status;
}

dl_status dl_part_pack(const dl_study *study, const dl_study_part *part, void **bytes, size_t *size,
                       dl_error *error) {
    return dl_record_pack(record_of(study), part, bytes, size, error);
}

dl_status dl_part_unpack(const dl_study *study, const void *bytes, size_t size, dl_study_part *part,
                         dl_error *error) {
    const dl_status status = dl_record_unpack(record_of(study), bytes, size, part, error);
    if (status != DL_OK)
        dl_part_release(study, part);
    return status;
}

/* The element of that key, with what it owns, into *part; false where it is not there. */
static bool take_out(const dl_study *study, dl_results *old, const char *key, dl_study_part *part) {
    const dl_record *record = record_of(study);
    char *element = *array_of(record, old);
    for (size_t i = 0; i < *count_of(record, old); i++, element += record->size) {
        const char *found = key_of(record, element);
        if (!found || strcmp(found, key) != 0)
            continue;
        memcpy(part, element, record->size);
        memset(element, 0, record->size);
        return true;
    }
    return false;
}

dl_status dl_parts_keep(const dl_study *study, dl_results *old, dl_results *results,
                        dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < study->cases && status == DL_OK; i++) {
        dl_study_part kept;
        if (take_out(study, old, study->cased[i].key, &kept))
            status = dl_part_add(study, results, &kept, error);
    }
    return status;
}

static size_t place_of(const dl_study *study, const char *key) {
    size_t i = 0;
    while (i < study->cases && strcmp(study->cased[i].key, key) != 0)
        i++;
    return i;
}

dl_status dl_parts_sort(const dl_study *study, dl_results *results, dl_error *error) {
    const dl_record *record = record_of(study);
    char **array = array_of(record, results), *sorted = calloc(study->cases, record->size);
    if (!sorted)
        return dl_fail_memory(error, record->group);
    for (size_t i = 0; i < *count_of(record, results); i++) {
        const char *element = *array + i * record->size;
        memcpy(sorted + place_of(study, key_of(record, element)) * record->size, element,
               record->size);
    }
    free(*array);
    *array = sorted;
    return DL_OK;
}
