/* Curves of a paper's page. */
#ifndef DL_REPORT_PAPER_PLOT_H
#define DL_REPORT_PAPER_PLOT_H

#include "study/paper_plan.h"

/* Writes the curve as SVG, with the points that the paper prints beside it. */
dl_status dl_paper_plot_write(const dl_paper_picture *picture, const dl_paper_curve *curve,
                              const char *path, dl_error *error);

#endif
