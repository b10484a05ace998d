/* Maps of stability: what became of every step that a study of kind `stability` tried, over a
 * number by name that its scenes differ in. */
#ifndef DRIFTLAB_MAP_H
#define DRIFTLAB_MAP_H

#include "driftlab/results.h"
#include "driftlab/scene.h"

typedef struct dl_map {
    const char *over;   /* the number's name: one column a value */
    const char *method; /* NULL: the only one there is */
    size_t lets;
    const dl_let *let; /* [lets]: values of other numbers, where the scenes differ in these too */
} dl_map;

/* Writes `path`, complete or not at all: SVG or PNG by its end, else DL_INPUT. DL_INPUT, too, where
 * the results have no such number or method, or several scenes for one of its values. */
dl_status dl_map_write(const dl_results *results, const dl_map *map, const char *path,
                       dl_error *error);

#endif
