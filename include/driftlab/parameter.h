/* Parameter tables: the one place where the name, unit, range, default and meaning of a parameter
 * stand. Scenes, studies and method options are read, checked, documented (`driftlab help`) and
 * stored in results from these tables. */
#ifndef DRIFTLAB_PARAMETER_H
#define DRIFTLAB_PARAMETER_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

typedef enum dl_kind {
    DL_REAL,    /* double; "none" reads as INFINITY where the default is "none" */
    DL_INTEGER, /* long */
    DL_FLAG,    /* bool: true or false */
    DL_WORD,    /* int: index into `words` */
    DL_TEXT,    /* char *, owned by the structure the value lies in */
} dl_kind;

typedef struct dl_parameter {
    const char *name;
    dl_kind kind;
    size_t offset;            /* of the value in its structure */
    const char *unit;         /* "time", "length/time", ...; "" for a pure number */
    double minimum, maximum;  /* inclusive; DL_REAL and DL_INTEGER only */
    bool above_minimum;       /* the minimum itself is excluded */
    const char *const *words; /* DL_WORD: the words allowed, NULL-terminated */
    const char *fallback;     /* default, as it would be written; NULL: required */
    const char *doc;          /* one line */
    const char *when;         /* used only where another parameter of its table has one of these
                               * values, "step=0" or "solver=klu|dense"; NULL: always */
} dl_parameter;

typedef struct dl_parameter_table {
    const dl_parameter *rows;
    size_t count;
} dl_parameter_table;

/* Row of that name or NULL. */
const dl_parameter *dl_parameter_find(dl_parameter_table table, const char *name);

/* Name in the table closest to `name` (edit distance), or NULL where none is near. */
const char *dl_parameter_closest(dl_parameter_table table, const char *name);

/* The same over any NULL-terminated list of words. */
const char *dl_closest_word(const char *const *words, const char *word);

/* Sets one value in `object` from its text, checked against kind and range. On failure `object` is
 * unchanged and the message says the key, the value found and what was expected (the caller puts
 * file and line before it). */
dl_status dl_parameter_set(const dl_parameter *row, void *object, const char *value,
                           dl_error *error);

/* Sets every default; required parameters are left alone. DL_TEXT values must be NULL or owned
 * before (a zeroed structure will do). */
dl_status dl_parameter_defaults(dl_parameter_table table, void *object, dl_error *error);

/* Text of a value as a file would say it (%.17g, shortest that reads back the same). Returns the
 * length it needed, as snprintf does. */
int dl_parameter_format(const dl_parameter *row, const void *object, char *text, size_t size);

/* What is allowed, as text: "> 0", ">= 0, <= 1", "fixed-point | newton", ... */
int dl_parameter_range(const dl_parameter *row, char *text, size_t size);

/* The parameter that `when` names; NULL where there is no `when`, or none of that name in the
 * table: the value is always used. */
const dl_parameter *dl_parameter_cause(dl_parameter_table table, const dl_parameter *row);

/* Whether the value is used beside the others of `object`: what its `when` asks for holds, and the
 * parameter named there is used itself. */
bool dl_parameter_applies(dl_parameter_table table, const dl_parameter *row, const void *object);

/* Frees the DL_TEXT values. */
void dl_parameter_release(dl_parameter_table table, void *object);

/* The value as messages show it: between quotes, on one line, valid UTF-8, shortened where it is
 * long. Returns the length it needed, as snprintf does. */
int dl_quote(const char *value, char *text, size_t size);

/* Shortest decimal text that reads back as the same double; always contains enough digits. */
int dl_format_real(double value, char *text, size_t size);

#endif
