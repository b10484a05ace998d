/* `let` of a study file: each of its scenes once for every combination of the numbers it lists. */
#ifndef DL_STUDY_VARIANTS_H
#define DL_STUDY_VARIANTS_H

#include "driftlab/scene.h"
#include "io/yaml.h"

enum { dl_most_let_lists = 8 };

typedef struct dl_variants {
    size_t names;
    const char *name[dl_most_let_lists];           /* in the document */
    const dl_yaml_node *values[dl_most_let_lists]; /* a number or a list of numbers */
    size_t count;                                  /* of combinations; 1 where there is no `let` */
} dl_variants;

/* `node` NULL: there is none. */
dl_status dl_variants_read(const dl_yaml *yaml, const dl_yaml_node *node, dl_variants *variants,
                           dl_error *error);

/* Combination `index` < count into let [names]: the last list varies fastest. */
void dl_variants_at(const dl_variants *variants, size_t index, dl_let *let);

/* " --let a=1 --let b=2", the caller's; NULL: no memory. */
char *dl_let_arguments(size_t count, const dl_let *let);

#endif
