/* Two results files side by side: of two versions of the program, of two machines, of one machine
 * twice. */
#ifndef DRIFTLAB_COMPARE_H
#define DRIFTLAB_COMPARE_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/results.h"

/* The same case in both. */
typedef struct dl_case_pair {
    const dl_case *a, *b;
    bool same_key; /* false: its scene's content or its reference is another one */
    bool same;     /* status, counts of work and errors agree in every bit; or both were stopped
                      for their time */
} dl_case_pair;

typedef struct dl_finding_pair {
    const dl_finding *a, *b;
    bool same_key;
    bool same; /* verdict, quantities and table agree in every bit */
} dl_finding_pair;

typedef struct dl_comparison {
    const dl_results *a, *b;
    size_t pairs;
    dl_case_pair *pair; /* in the order of a */
    size_t finding_pairs;
    dl_finding_pair *finding_pair;
    size_t only_a, only_b; /* cases and findings that the other lacks */
    size_t same;           /* of pairs and finding pairs */
    /* CPU seconds of b over those of a, over the pairs that ran to their end in both; NaN: none */
    double ratio_median, ratio_least, ratio_most;
    /* Of two cases on one scene whose CPU seconds differ by more than a fifth in a (`ranked` of
     * them), how many are the other way round in b. */
    size_t ranked, swapped;
} dl_comparison;

/* Both results must outlive the comparison. Free with dl_comparison_release. */
dl_status dl_compare(const dl_results *a, const dl_results *b, dl_comparison *comparison,
                     dl_error *error);
void dl_comparison_release(dl_comparison *comparison);

/* Whether a case or finding of either has its like in the other. */
bool dl_comparison_has_case(const dl_comparison *comparison, const dl_case *cased);
bool dl_comparison_has_finding(const dl_comparison *comparison, const dl_finding *finding);

#endif
