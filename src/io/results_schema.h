/* The schema of a results file as tables, used by its writer, its reader and what frees it. */
#ifndef DL_IO_RESULTS_SCHEMA_H
#define DL_IO_RESULTS_SCHEMA_H

#include <hdf5.h>
#include <stdbool.h>
#include <stddef.h>
#include "driftlab/results.h"

#define DL_RESULTS_FORMAT  "driftlab results"
#define DL_RESULTS_VERSION 2 /* raised with every field that is added; 1 is read, too */

typedef enum dl_field_kind {
    DL_FIELD_TEXT,       /* char *, attribute */
    DL_FIELD_LONG_TEXT,  /* char *, scalar dataset: attributes end at 64 KiB */
    DL_FIELD_MESSAGE,    /* char [DL_MESSAGE_SIZE], attribute */
    DL_FIELD_STATUS,     /* dl_status, its name as attribute */
    DL_FIELD_REAL,       /* double, attribute */
    DL_FIELD_UNSIGNED,   /* unsigned, attribute */
    DL_FIELD_ULONG,      /* unsigned long, attribute */
    DL_FIELD_SIZE,       /* size_t, attribute */
    DL_FIELD_INT,        /* int, attribute */
    DL_FIELD_SERIES,     /* double *[samples], dataset */
    DL_FIELD_POSITIONS,  /* double *[samples][dimension * particles] of a reference, dataset */
    DL_FIELD_QUANTITIES, /* double *[quantities][3] of a finding, dataset */
    DL_FIELD_TABLE,      /* double *[rows][columns] of a finding, dataset */
} dl_field_kind;

typedef struct dl_field {
    const char *name;
    dl_field_kind kind;
    size_t offset;
    bool is_optional; /* read as 0, "" or NULL where a file lacks it: it is of an earlier program,
                         or there was nothing to store */
} dl_field;

/* Where the elements of one array of dl_results live, in the file and in memory. */
typedef struct dl_record {
    const char *group; /* "cases"; "" for the file's own attributes */
    const dl_field *fields;
    size_t field_count;
    size_t size;    /* of an element */
    size_t count;   /* offset in dl_results of the number of elements */
    size_t array;   /* offset in dl_results of the pointer to them */
    size_t samples; /* offset in an element of its number of samples, where it has series */
} dl_record;

enum {
    DL_RECORD_FACTS,
    DL_RECORD_SCENES,
    DL_RECORD_REFERENCES,
    DL_RECORD_CASES,
    DL_RECORD_FINDINGS,
    DL_RECORDS
};

extern const dl_record dl_results_head; /* fields of dl_results itself */
extern const dl_record dl_results_records[DL_RECORDS];

/* Whether a field is an array of reals, a dataset. */
bool dl_field_is_array(dl_field_kind kind);

bool dl_field_is_text(dl_field_kind kind);

/* Value of a field in its element. */
void *dl_field_at(const dl_field *field, const void *element);

/* Elements and columns of a dataset field: rank 1 or 2. */
int dl_field_shape(const dl_record *record, const dl_field *field, const void *element,
                   hsize_t shape[2]);

/* HDF5 types of a numeric field in memory and in the file. */
hid_t dl_field_native(dl_field_kind kind);
hid_t dl_field_stored(dl_field_kind kind);

/* Frees what an element owns. */
void dl_record_release(const dl_record *record, void *element);

/* An element as bytes, for another process of the same program, and back: every field in the order
 * of the record, texts and arrays after their length. *bytes is the caller's; on failure of unpack,
 * too, the element is to be released. */
dl_status dl_record_pack(const dl_record *record, const void *element, void **bytes, size_t *size,
                         dl_error *error);
dl_status dl_record_unpack(const dl_record *record, const void *bytes, size_t size, void *element,
                           dl_error *error);

#endif
