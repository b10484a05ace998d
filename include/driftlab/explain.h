/* What a scene's model contains, what it leaves out, and which kernel was chosen and why. */
#ifndef DRIFTLAB_EXPLAIN_H
#define DRIFTLAB_EXPLAIN_H

#include <stdio.h>
#include "driftlab/model.h"

void dl_explain(dl_model *model, FILE *out);

#endif
