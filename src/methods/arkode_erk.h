/* Explicit tables, for the methods that use them. */
#ifndef DL_METHODS_ARKODE_ERK_H
#define DL_METHODS_ARKODE_ERK_H

#include <arkode/arkode_butcher_erk.h>

#include "methods/arkode.h"

/* By the same index. */
extern const char *const dl_erk_words[];
extern const ARKODE_ERKTableID dl_erk_ids[];

typedef struct dl_erk_options {
    dl_arkode_options common;
    int table; /* index into the above */
} dl_erk_options;

/* A row's `table`, of dl_erk_words alone. */
bool dl_erk_describe(const char *const *of_words, size_t index, dl_method_table *found);

/* ERKStep's part of a dl_arkode_kind. */
void *dl_erk_create(dl_method *method);
dl_status dl_erk_set_table(dl_method *method, ARKODE_ERKTableID id, dl_error *error);

#endif
