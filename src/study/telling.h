/* A unit's runs tell how far they are. */
#ifndef DL_STUDY_TELLING_H
#define DL_STUDY_TELLING_H

#include "study/kind.h"

/* Lives as long as the run. */
typedef struct dl_telling {
    const dl_study_unit *unit;
    char label[64]; /* of the run: "step 0.01" */
    double told;    /* CPU seconds when it was told last; 0 at first */
} dl_telling;

/* Lets a run tell "LABEL: 43 %", a few times a second, where somebody listens. */
void dl_telling_set(dl_telling *telling, dl_run_options *options);

#endif
