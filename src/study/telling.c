#include "study/telling.h"

#include <stdio.h>

static void tell(void *context, double fraction, double seconds) {
    dl_telling *of = context;
    char text[96];
    if (seconds - of->told < 0.2)
        return;
    of->told = seconds;
    snprintf(text, sizeof text, "%s: %.0f %%", of->label, 100 * fraction);
    of->unit->progress(of->unit->context, text);
}

void dl_telling_set(dl_telling *telling, dl_run_options *options) {
    if (!telling->unit->progress)
        return;
    options->on_progress = tell;
    options->progress_context = telling;
}
