#include "driftlab/results.h"

#include <stdlib.h>
#include <string.h>
#include "io/results_schema.h"

dl_status dl_results_create(dl_results **results, dl_error *error) {
    *results = NULL;
    dl_results *made = calloc(1, sizeof *made);
    if (!made)
        return dl_fail_memory(error, "results");
    for (size_t i = 0; i < dl_results_head.field_count; i++) {
        const dl_field *field = &dl_results_head.fields[i];
        if (field->kind != DL_FIELD_TEXT)
            continue;
        char **text = dl_field_at(field, made);
        if (!(*text = strdup(""))) {
            dl_results_free(made);
            return dl_fail_memory(error, "results");
        }
    }
    *results = made;
    return DL_OK;
}

void dl_results_free(dl_results *results) {
    if (!results)
        return;
    for (size_t r = 0; r < DL_RECORDS; r++) {
        const dl_record *record = &dl_results_records[r];
        size_t count = *(size_t *)((char *)results + record->count);
        char *array = *(char **)((char *)results + record->array);
        for (size_t i = 0; i < count; i++)
            dl_record_release(record, array + i * record->size);
        free(array);
    }
    dl_record_release(&dl_results_head, results);
    free(results);
}

void dl_case_release(dl_case *cased) {
    dl_record_release(&dl_results_records[DL_RECORD_CASES], cased);
}

void dl_reference_release(dl_reference *reference) {
    dl_record_release(&dl_results_records[DL_RECORD_REFERENCES], reference);
}

void dl_finding_release(dl_finding *finding) {
    dl_record_release(&dl_results_records[DL_RECORD_FINDINGS], finding);
}

/* Appends a copy of the structure itself. */
static dl_status append(dl_results *results, int which, const void *added, dl_error *error) {
    const dl_record *record = &dl_results_records[which];
    size_t *count = (size_t *)((char *)results + record->count);
    char **array = (char **)((char *)results + record->array);
    char *grown = realloc(*array, (*count + 1) * record->size);
    if (!grown)
        return dl_fail_memory(error, record->group);
    memcpy(grown + *count * record->size, added, record->size);
    *array = grown;
    (*count)++;
    return DL_OK;
}

dl_status dl_results_add_case(dl_results *results, const dl_case *added, dl_error *error) {
    return append(results, DL_RECORD_CASES, added, error);
}

dl_status dl_results_add_finding(dl_results *results, const dl_finding *added, dl_error *error) {
    return append(results, DL_RECORD_FINDINGS, added, error);
}

dl_status dl_results_add_reference(dl_results *results, const dl_reference *added,
                                   dl_error *error) {
    return append(results, DL_RECORD_REFERENCES, added, error);
}

dl_status dl_results_add_scene(dl_results *results, const dl_scene_record *added, dl_error *error) {
    return append(results, DL_RECORD_SCENES, added, error);
}

static dl_fact *find_fact(const dl_results *results, const char *name) {
    for (size_t i = 0; i < results->facts; i++)
        if (strcmp(results->fact[i].name, name) == 0)
            return &results->fact[i];
    return NULL;
}

dl_status dl_results_add_fact(dl_results *results, const char *name, const char *value,
                              dl_error *error) {
    dl_fact added = {.name = strdup(name), .value = strdup(value)};
    dl_fact *known = find_fact(results, name);
    dl_status status = DL_OK;
    if (!added.name || !added.value)
        status = dl_fail_memory(error, "a fact");
    else if (known) {
        dl_fact old = *known;
        *known = added;
        added = old;
    } else
        status = append(results, DL_RECORD_FACTS, &added, error);
    if (status != DL_OK || known) {
        free(added.name);
        free(added.value);
    }
    return status;
}

const char *dl_results_fact(const dl_results *results, const char *name) {
    const dl_fact *fact = find_fact(results, name);
    return fact ? fact->value : NULL;
}

const dl_reference *dl_results_reference(const dl_results *results, const char *scene) {
    for (size_t i = 0; i < results->references; i++)
        if (strcmp(results->reference[i].scene, scene) == 0)
            return &results->reference[i];
    return NULL;
}

const dl_case *dl_results_find(const dl_results *results, const char *key) {
    for (size_t i = 0; i < results->cases; i++)
        if (strcmp(results->cased[i].key, key) == 0)
            return &results->cased[i];
    return NULL;
}

const dl_finding *dl_results_find_finding(const dl_results *results, const char *key) {
    for (size_t i = 0; i < results->findings; i++)
        if (strcmp(results->finding[i].key, key) == 0)
            return &results->finding[i];
    return NULL;
}

const double *dl_finding_quantity(const dl_finding *finding, const char *name) {
    const size_t length = strlen(name);
    const char *line = finding->quantity_names;
    for (size_t i = 0; line && i < finding->quantities; i++) {
        if (strncmp(line, name, length) == 0 &&
            (line[length] == '\n' || line[length] == '\0' || strncmp(line + length, " [", 2) == 0))
            return finding->quantity + 3 * i;
        line = strchr(line, '\n');
        line = line ? line + 1 : NULL;
    }
    return NULL;
}
