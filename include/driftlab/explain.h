/* What a scene's model contains, what it leaves out, and which kernel was chosen and why. */
#ifndef DRIFTLAB_EXPLAIN_H
#define DRIFTLAB_EXPLAIN_H

#include <stdbool.h>
#include <stdio.h>
#include "driftlab/model.h"

/* What a model may lack: not computed, not stored, not branched on. */
typedef enum dl_left_out {
    DL_OUT_PAIRS,
    DL_OUT_Z,
    DL_OUT_REAL_POWERS,
    DL_OUT_SWITCHES,
    DL_OUT_CUTOFF,
    DL_OUT_CROSSINGS,
    DL_OUT_SPECIES,
    DL_OUT_COUPLINGS,
    DL_OUT_INERTIA,
    DL_OUT_GRAVITY,
    DL_OUT_GRAVITY_MASK,
    DL_OUT_WALLS,
    DL_OUT_PERIODS,
    DL_OUT_RADIATION,
    DL_OUT_PINS,
    DL_OUT_SLOW_PART,
    DL_LEFT_OUTS
} dl_left_out;

const char *dl_left_out_name(dl_left_out what);
bool dl_leaves_out(const dl_model *model, dl_left_out what);

void dl_explain(dl_model *model, FILE *out);

#endif
