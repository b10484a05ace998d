/* From the scene's units to the picture's: window, scale, ticks. */
#ifndef DL_REPORT_PICTURE_VIEW_H
#define DL_REPORT_PICTURE_VIEW_H

#include "driftlab/picture.h"
#include "report/canvas.h"

typedef struct dl_view {
    dl_picture_window window;
    double scale;                    /* units of the picture in one of the scene */
    double left, top, width, height; /* of the plot, in the picture */
} dl_view;

/* Position of a particle as it is drawn: periodic directions are wrapped into the box. */
void dl_drawn_position(const dl_picture *picture, size_t i, double at[2]);

/* A window of all particles with room of `margin` around them, with periodic boxes and walls that
 * are no farther from the particles than these reach. `kept` [particles] or NULL: which count. */
dl_picture_window dl_window_of(const dl_picture *picture, const bool *kept, double margin);

/* The largest plot of that window within most_width x most_height. */
dl_view dl_view_fit(const dl_picture_window *window, double left, double top, double most_width,
                    double most_height);

canvas_point dl_view_at(const dl_view *view, double x, double y);

/* The step 1, 2 or 5 times a power of ten whose ticks are at least `apart` (in the picture). */
double dl_nice_step(double scale, double apart);

#endif
