#include "io/results_schema.h"

#include <stdint.h>
#include <stdlib.h>

#define FIELD(type, kind, name)                                                                    \
    { #name, DL_FIELD_##kind, offsetof(type, name), false }
#define OPTIONAL(type, kind, name)                                                                 \
    { #name, DL_FIELD_##kind, offsetof(type, name), true }
#define SUMMARY(kind, name)                                                                        \
    { #name, DL_FIELD_##kind, offsetof(dl_case, summary.name), false }
#define OPTIONAL_SUMMARY(kind, name)                                                               \
    { #name, DL_FIELD_##kind, offsetof(dl_case, summary.name), true }

static const dl_field head_fields[] = {
    FIELD(dl_results, TEXT, study),       FIELD(dl_results, TEXT, title),
    FIELD(dl_results, TEXT, kind),        FIELD(dl_results, TEXT, question),
    FIELD(dl_results, REAL, asked_error), FIELD(dl_results, TEXT, asked_in),
};

static const dl_field fact_fields[] = {
    FIELD(dl_fact, TEXT, name),
    FIELD(dl_fact, TEXT, value),
};

static const dl_field scene_fields[] = {
    FIELD(dl_scene_record, TEXT, name),
    FIELD(dl_scene_record, TEXT, source),
    FIELD(dl_scene_record, LONG_TEXT, explain),
    FIELD(dl_scene_record, LONG_TEXT, text),
};

static const dl_field reference_fields[] = {
    FIELD(dl_reference, TEXT, key),
    OPTIONAL(dl_reference, TEXT, digest),
    FIELD(dl_reference, TEXT, scene),
    FIELD(dl_reference, TEXT, description),
    OPTIONAL(dl_reference, TEXT, precision),
    OPTIONAL(dl_reference, TEXT, note),
    FIELD(dl_reference, REAL, error),
    OPTIONAL(dl_reference, REAL, seconds),
    OPTIONAL(dl_reference, REAL, length),
    OPTIONAL(dl_reference, REAL, lyapunov),
    OPTIONAL(dl_reference, REAL, lyapunov_error),
    OPTIONAL(dl_reference, REAL, parted),
    OPTIONAL(dl_reference, REAL, horizon),
    FIELD(dl_reference, SIZE, samples),
    FIELD(dl_reference, SIZE, particles),
    FIELD(dl_reference, INT, dimension),
    FIELD(dl_reference, SERIES, time),
    FIELD(dl_reference, SERIES, sample_error),
    OPTIONAL(dl_reference, SERIES, growth),
    FIELD(dl_reference, POSITIONS, position),
    OPTIONAL(dl_reference, POSITIONS, position_low),
};

static const dl_field case_fields[] = {
    FIELD(dl_case, TEXT, key),
    FIELD(dl_case, TEXT, scene),
    FIELD(dl_case, TEXT, method),
    FIELD(dl_case, TEXT, family),
    FIELD(dl_case, TEXT, options),
    FIELD(dl_case, TEXT, command),
    SUMMARY(STATUS, status),
    SUMMARY(MESSAGE, message),
    OPTIONAL_SUMMARY(MESSAGE, choice),
    SUMMARY(REAL, t_end_reached),
    SUMMARY(REAL, step),
    SUMMARY(ULONG, steps),
    SUMMARY(ULONG, rejected_steps),
    SUMMARY(ULONG, force_evaluations),
    SUMMARY(ULONG, jacobian_evaluations),
    SUMMARY(ULONG, jacobian_vector_products),
    SUMMARY(ULONG, nonlinear_iterations),
    SUMMARY(ULONG, linear_iterations),
    SUMMARY(ULONG, factorisations),
    OPTIONAL_SUMMARY(ULONG, inexact_steps),
    OPTIONAL_SUMMARY(ULONG, rescued_steps),
    SUMMARY(ULONG, neighbour_list_builds),
    SUMMARY(ULONG, wall_hits),
    OPTIONAL_SUMMARY(ULONG, contacts),
    OPTIONAL_SUMMARY(ULONG, releases),
    OPTIONAL_SUMMARY(ULONG, crossings),
    SUMMARY(REAL, cpu_seconds),
    SUMMARY(REAL, energy_initial),
    SUMMARY(REAL, energy_final),
    SUMMARY(REAL, energy_scale),
    SUMMARY(REAL, energy_error_max),
    SUMMARY(REAL, energy_error_final),
    SUMMARY(REAL, ledger),
    SUMMARY(REAL, momentum_error_max),
    SUMMARY(REAL, angular_momentum_error_max),
    SUMMARY(REAL, momentum_scale),
    SUMMARY(REAL, angular_momentum_scale),
    SUMMARY(REAL, kinetic_energy_per_particle),
    OPTIONAL_SUMMARY(REAL, force_error_stated),
    OPTIONAL_SUMMARY(REAL, force_error_max),
    OPTIONAL_SUMMARY(REAL, force_error_mean),
    {"summary_samples", DL_FIELD_SIZE, offsetof(dl_case, summary.samples), false},
    FIELD(dl_case, UNSIGNED, repeats),
    FIELD(dl_case, REAL, cpu_median),
    FIELD(dl_case, REAL, position_error),
    FIELD(dl_case, REAL, position_error_max),
    FIELD(dl_case, REAL, position_error_ever),
    FIELD(dl_case, SIZE, samples),
    FIELD(dl_case, SERIES, sample_time),
    FIELD(dl_case, SERIES, sample_energy_error),
    FIELD(dl_case, SERIES, sample_position_error),
    OPTIONAL(dl_case, SERIES, sample_momentum_error),
    OPTIONAL(dl_case, SERIES, sample_angular_momentum_error),
    FIELD(dl_case, TEXT, invalid),
    FIELD(dl_case, TEXT, refused),
};

static const dl_field finding_fields[] = {
    FIELD(dl_finding, TEXT, key),
    FIELD(dl_finding, TEXT, scene),
    FIELD(dl_finding, TEXT, method),
    FIELD(dl_finding, TEXT, family),
    FIELD(dl_finding, TEXT, options),
    FIELD(dl_finding, TEXT, command),
    FIELD(dl_finding, STATUS, status),
    FIELD(dl_finding, MESSAGE, message),
    FIELD(dl_finding, TEXT, verdict),
    FIELD(dl_finding, TEXT, reason),
    FIELD(dl_finding, REAL, cpu_seconds),
    FIELD(dl_finding, SIZE, quantities),
    FIELD(dl_finding, LONG_TEXT, quantity_names),
    FIELD(dl_finding, SIZE, rows),
    FIELD(dl_finding, SIZE, columns),
    FIELD(dl_finding, LONG_TEXT, column_names),
    FIELD(dl_finding, LONG_TEXT, row_words),
    FIELD(dl_finding, QUANTITIES, quantity),
    FIELD(dl_finding, TABLE, table),
};

#define RECORD(groupname, table, type, counter, pointer)                                           \
    .group = groupname, .fields = table, .field_count = sizeof table / sizeof *table,              \
    .size = sizeof(type), .count = offsetof(dl_results, counter),                                  \
    .array = offsetof(dl_results, pointer)

const dl_record dl_results_head = {
    .group = "",
    .fields = head_fields,
    .field_count = sizeof head_fields / sizeof *head_fields,
    .size = sizeof(dl_results),
};

const dl_record dl_results_records[DL_RECORDS] = {
    [DL_RECORD_FACTS] = {RECORD("facts", fact_fields, dl_fact, facts, fact)},
    [DL_RECORD_SCENES] = {RECORD("scenes", scene_fields, dl_scene_record, scenes, scene)},
    [DL_RECORD_REFERENCES] = {RECORD("references", reference_fields, dl_reference, references,
                                     reference),
                              .samples = offsetof(dl_reference, samples)},
    [DL_RECORD_CASES] = {RECORD("cases", case_fields, dl_case, cases, cased),
                         .samples = offsetof(dl_case, samples)},
    [DL_RECORD_FINDINGS] = {RECORD("findings", finding_fields, dl_finding, findings, finding)},
};

bool dl_field_is_array(dl_field_kind kind) {
    return kind == DL_FIELD_SERIES || kind == DL_FIELD_POSITIONS || kind == DL_FIELD_QUANTITIES ||
           kind == DL_FIELD_TABLE;
}

bool dl_field_is_text(dl_field_kind kind) {
    return kind == DL_FIELD_TEXT || kind == DL_FIELD_LONG_TEXT;
}

void *dl_field_at(const dl_field *field, const void *element) {
    return (char *)(uintptr_t)element + field->offset;
}

int dl_field_shape(const dl_record *record, const dl_field *field, const void *element,
                   hsize_t shape[2]) {
    if (field->kind == DL_FIELD_QUANTITIES || field->kind == DL_FIELD_TABLE) {
        const dl_finding *finding = element;
        const bool table = field->kind == DL_FIELD_TABLE;
        shape[0] = table ? finding->rows : finding->quantities;
        shape[1] = table ? finding->columns : 3;
        return 2;
    }
    shape[0] = *(const size_t *)((const char *)element + record->samples);
    shape[1] = 1;
    if (field->kind != DL_FIELD_POSITIONS)
        return 1;
    const dl_reference *reference = element;
    shape[1] = (hsize_t)reference->dimension * reference->particles;
    return 2;
}

hid_t dl_field_native(dl_field_kind kind) {
    if (kind == DL_FIELD_UNSIGNED)
        return H5T_NATIVE_UINT;
    if (kind == DL_FIELD_ULONG)
        return H5T_NATIVE_ULONG;
    if (kind == DL_FIELD_INT)
        return H5T_NATIVE_INT;
    if (kind == DL_FIELD_SIZE)
        return sizeof(size_t) == sizeof(unsigned long) ? H5T_NATIVE_ULONG : H5T_NATIVE_UINT;
    return H5T_NATIVE_DOUBLE;
}

hid_t dl_field_stored(dl_field_kind kind) {
    if (kind == DL_FIELD_INT)
        return H5T_STD_I32LE;
    if (kind == DL_FIELD_UNSIGNED || kind == DL_FIELD_ULONG || kind == DL_FIELD_SIZE)
        return H5T_STD_U64LE;
    return H5T_IEEE_F64LE;
}

void dl_record_release(const dl_record *record, void *element) {
    for (size_t i = 0; i < record->field_count; i++) {
        const dl_field *field = &record->fields[i];
        if (dl_field_is_text(field->kind) || dl_field_is_array(field->kind)) {
            void **owned = dl_field_at(field, element);
            free(*owned);
            *owned = NULL;
        }
    }
}
