/* YAML files as trees with line numbers, over LibYAML; and reading a mapping by a parameter table.
 * Every message has the form  FILE:LINE: KEY: found VALUE, expected WHAT[; did you mean "X"?] */
#ifndef DL_IO_YAML_H
#define DL_IO_YAML_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/parameter.h"
#include "driftlab/status.h"

typedef struct dl_yaml dl_yaml;           /* a document and the path it came from */
typedef struct dl_yaml_node dl_yaml_node; /* belongs to its document */

typedef enum dl_yaml_kind { DL_YAML_SCALAR, DL_YAML_LIST, DL_YAML_MAP } dl_yaml_kind;

/* A missing, unreadable or empty file, bad YAML (with line), several documents, a key given twice:
 * DL_INPUT. Anchors and aliases work; a document that contains itself is refused. */
dl_status dl_yaml_read(const char *path, dl_yaml **yaml, dl_error *error);
/* The same of a text; `path` is what messages call it. */
dl_status dl_yaml_parse(const char *path, const char *text, dl_yaml **yaml, dl_error *error);
void dl_yaml_free(dl_yaml *yaml);

const char *dl_yaml_path(const dl_yaml *yaml);
const char *dl_yaml_source(const dl_yaml *yaml); /* the file's text */
const dl_yaml_node *dl_yaml_root(const dl_yaml *yaml);

dl_yaml_kind dl_yaml_kind_of(const dl_yaml_node *node);
int dl_yaml_line(const dl_yaml_node *node);
const char *dl_yaml_text(const dl_yaml_node *node);                   /* scalars */
size_t dl_yaml_length(const dl_yaml_node *node);                      /* lists and maps */
const dl_yaml_node *dl_yaml_item(const dl_yaml_node *node, size_t i); /* list item, map value */
const char *dl_yaml_key(const dl_yaml_node *map, size_t i);           /* map key */
const dl_yaml_node *dl_yaml_get(const dl_yaml_node *map, const char *key); /* NULL: absent */

/* Every node of the document, keys too, in the order of the file. */
size_t dl_yaml_count(const dl_yaml *yaml);
const dl_yaml_node *dl_yaml_at(const dl_yaml *yaml, size_t i);

/* Whether a scalar stands there without quotes. */
bool dl_yaml_is_plain(const dl_yaml_node *node);
/* Gives a scalar another text; the source stays. */
dl_status dl_yaml_set_text(dl_yaml *yaml, const dl_yaml_node *node, const char *text,
                           dl_error *error);

/* One scalar's place in the source and what is to stand there. */
typedef struct dl_yaml_edit {
    const dl_yaml_node *node;
    const char *text;
} dl_yaml_edit;

/* The source with `count` different scalars replaced, the caller's. */
dl_status dl_yaml_edited(const dl_yaml *yaml, size_t count, const dl_yaml_edit *edit, char **text,
                         dl_error *error);

/* DL_INPUT: "PATH:LINE: KEY: found VALUE, expected EXPECTED". node NULL: the file as a whole. */
dl_status dl_yaml_fail(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                       const char *expected, dl_error *error);

/* DL_INPUT: "PATH:LINE: KEY: found nothing, expected EXPECTED", for a key that `map` lacks. */
dl_status dl_yaml_missing(const dl_yaml *yaml, const dl_yaml_node *map, const char *key,
                          const char *expected, dl_error *error);

/* Every key of `map` must stand in the table or in `others` (NULL-terminated, may be NULL); a
 * misspelt one is reported with the closest of both. Sets defaults, then every value of the table;
 * a required one that is absent is reported at the map's line. `object` must be zeroed before; its
 * texts are the caller's to release, also on failure. */
dl_status dl_yaml_read_table(const dl_yaml *yaml, const dl_yaml_node *map, dl_parameter_table table,
                             const char *const *others, void *object, dl_error *error);

/* A list of `count` reals; "none" is allowed where none_value is not NaN and becomes none_value. */
dl_status dl_yaml_reals(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                        size_t count, double none_value, double *values, dl_error *error);

#endif
