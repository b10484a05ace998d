#include "study/kind.h"

#define NAME(symbol, name) name,
#define ROW(symbol, name)  &dl_study_kind_##symbol,

const char *const dl_study_kinds[] = {DL_STUDY_KINDS(NAME) NULL};
const dl_study_kind *const dl_study_kind_rows[] = {DL_STUDY_KINDS(ROW)};

const dl_study_kind dl_study_kind_work_precision = {.doc = "error against cost"};
