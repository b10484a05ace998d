/* What pictures are drawn on: SVG text or pixels, behind one table of operations. Lengths are in
 * units of the SVG, y downwards. A failure (memory) is kept until the end. */
#ifndef DL_REPORT_CANVAS_H
#define DL_REPORT_CANVAS_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/status.h"

enum { CANVAS_NONE = -1 }; /* no fill, no stroke */

typedef struct canvas_style {
    const char *name; /* class of an SVG element; NULL: none */
    int fill, stroke; /* 0xRRGGBB or CANVAS_NONE */
    double width;     /* of the stroke */
    bool dashed;
} canvas_style;

typedef enum canvas_anchor { CANVAS_START, CANVAS_MIDDLE, CANVAS_END } canvas_anchor;

typedef struct canvas_font {
    double size;
    int colour;
    bool bold, upwards; /* upwards: turned by a quarter, reading from below */
    canvas_anchor anchor;
} canvas_font;

typedef struct canvas_point {
    double x, y;
} canvas_point;

typedef struct canvas canvas;

typedef struct canvas_ops {
    const char *suffix; /* of the file's name */
    canvas *(*create)(double width, double height, const char *title);
    void (*circle)(canvas *drawn, canvas_point centre, double radius, const canvas_style *style);
    /* Closed where it is filled. */
    void (*lines)(canvas *drawn, size_t count, const canvas_point *point,
                  const canvas_style *style);
    void (*text)(canvas *drawn, canvas_point at, const char *text, const canvas_font *font);
    /* What follows is cut off outside the rectangle, and called `name`; until `unclip`. */
    void (*clip)(canvas *drawn, const char *name, canvas_point corner, double width, double height);
    void (*unclip)(canvas *drawn);
    /* Writes the file and frees the canvas. */
    dl_status (*finish)(canvas *drawn, const char *path, dl_error *error);
} canvas_ops;

extern const canvas_ops dl_canvas_svg, dl_canvas_png;

/* The one that writes such a file; DL_INPUT where none does. */
dl_status dl_canvas_for(const char *path, const canvas_ops **ops, dl_error *error);

#endif
