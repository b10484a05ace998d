/* A picture while it is drawn. */
#ifndef DL_REPORT_PICTURE_DRAW_H
#define DL_REPORT_PICTURE_DRAW_H

#include "report/canvas.h"
#include "report/picture_look.h"
#include "report/picture_view.h"

typedef struct dl_drawing {
    const dl_picture *picture;
    const canvas_ops *ops;
    canvas *canvas; /* NULL: measure only */
    dl_masses masses;
    double *size;          /* [particles], of the heaviest's */
    double *speed;         /* [particles] */
    size_t *order;         /* [particles], as they are drawn */
    double radius;         /* of the heaviest, in the picture */
    dl_speed_range speeds; /* that colours tell */
    double arrow;          /* length in the picture of a unit of speed */
    size_t outside;        /* particles that the window leaves out */
    dl_view view;
    double width, height; /* of the picture */
} dl_drawing;

enum { DL_INK = 0x1b1b1b, DL_QUIET = 0x5a5a5a, DL_OUTLINE = 0x333333, DL_WALL = 0x222222 };

void dl_draw_circle(const dl_drawing *drawing, canvas_point centre, double radius,
                    const canvas_style *style);
void dl_draw_lines(const dl_drawing *drawing, size_t count, const canvas_point *point,
                   const canvas_style *style);
void dl_draw_text(const dl_drawing *drawing, canvas_point at, const char *text,
                  const canvas_font *font);

/* An arrow with its head; `length` along (dx, dy), a unit vector in the picture. */
void dl_draw_arrow(const dl_drawing *drawing, canvas_point tail, double dx, double dy,
                   double length);

/* A particle, with the figure of its state where `state` is not NULL. */
void dl_draw_particle(const dl_drawing *drawing, canvas_point centre, double radius, int fill,
                      const dl_state_look *state);

/* Towards white: arrows are read over it. */
int dl_faded(int colour);

/* The mark of a particle that does not move. */
void dl_draw_pin(const dl_drawing *drawing, canvas_point centre, double radius);

/* Beneath the plot, its top at `top`; returns its height. */
double dl_draw_legend(const dl_drawing *drawing, double top);

#endif
