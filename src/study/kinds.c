#include "study/kind.h"

#include <string.h>

#define NAME(symbol, name) name,
#define ROW(symbol, name)  &dl_study_kind_##symbol,

const char *const dl_study_kinds[] = {DL_STUDY_KINDS(NAME) NULL};
const dl_study_kind *const dl_study_kind_rows[] = {DL_STUDY_KINDS(ROW)};

const dl_study_kind dl_study_kind_work_precision = {.doc = "error against cost"};

const dl_study_kind *dl_study_kind_of(const dl_results *results) {
    for (size_t k = 0; dl_study_kinds[k]; k++)
        if (strcmp(results->kind, dl_study_kinds[k]) == 0)
            return dl_study_kind_rows[k];
    return &dl_study_kind_work_precision;
}
