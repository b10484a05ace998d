/* Pictures of a paper's page. */
#ifndef DL_REPORT_PAPER_FIGURE_H
#define DL_REPORT_PAPER_FIGURE_H

#include "study/paper_plan.h"

/* Draws it into figure->svg, an SVG element. A picture that cannot be drawn says why in
 * figure->reason: DL_OK. */
dl_status dl_paper_figure_draw(const dl_paper_picture *picture, const dl_paper_run_row *runs,
                               const char *folder, dl_paper_figure *figure, dl_error *error);

#endif
