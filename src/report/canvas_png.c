/* Pixels, by cairo. */
#include <cairo.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/replace_file.h"
#include "report/canvas.h"

static const double pixels = 2; /* a unit */
static const double pi = 3.14159265358979323846;

#ifdef DL_SANITIZED
/* Fontconfig keeps its fonts behind pointers that the leak sanitizer cannot follow. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void) {
    return "leak:libfontconfig\n";
}
#endif

struct canvas {
    cairo_surface_t *surface;
    cairo_t *pen;
};

static canvas *create(double width, double height, const char *title) {
    (void)title;
    canvas *const drawn = calloc(1, sizeof *drawn);
    if (!drawn)
        return NULL;
    drawn->surface = cairo_image_surface_create(CAIRO_FORMAT_RGB24, (int)ceil(pixels * width),
                                                (int)ceil(pixels * height));
    drawn->pen = cairo_create(drawn->surface);
    cairo_set_source_rgb(drawn->pen, 1, 1, 1);
    cairo_paint(drawn->pen);
    cairo_scale(drawn->pen, pixels, pixels);
    return drawn;
}

static void set_colour(canvas *drawn, int colour) {
    cairo_set_source_rgb(drawn->pen, (colour >> 16 & 255) / 255.0, (colour >> 8 & 255) / 255.0,
                         (colour & 255) / 255.0);
}

static void paint(canvas *drawn, const canvas_style *style) {
    static const double dashes[] = {6, 4};
    if (style->fill != CANVAS_NONE) {
        set_colour(drawn, style->fill);
        cairo_fill_preserve(drawn->pen);
    }
    if (style->stroke != CANVAS_NONE) {
        set_colour(drawn, style->stroke);
        cairo_set_line_width(drawn->pen, style->width);
        cairo_set_dash(drawn->pen, dashes, style->dashed ? 2 : 0, 0);
        cairo_stroke_preserve(drawn->pen);
    }
    cairo_new_path(drawn->pen);
}

static void circle(canvas *drawn, canvas_point centre, double radius, const canvas_style *style) {
    cairo_arc(drawn->pen, centre.x, centre.y, radius, 0, 2 * pi);
    paint(drawn, style);
}

static void lines(canvas *drawn, size_t count, const canvas_point *point,
                  const canvas_style *style) {
    for (size_t k = 0; k < count; k++)
        cairo_line_to(drawn->pen, point[k].x, point[k].y);
    if (style->fill != CANVAS_NONE)
        cairo_close_path(drawn->pen);
    paint(drawn, style);
}

static void text(canvas *drawn, canvas_point at, const char *words, const canvas_font *font) {
    static const double shares[] = {[CANVAS_START] = 0, [CANVAS_MIDDLE] = 0.5, [CANVAS_END] = 1};
    cairo_text_extents_t extents;
    cairo_select_font_face(drawn->pen, "Liberation Sans", CAIRO_FONT_SLANT_NORMAL,
                           font->bold ? CAIRO_FONT_WEIGHT_BOLD : CAIRO_FONT_WEIGHT_NORMAL);
    cairo_set_font_size(drawn->pen, font->size);
    cairo_text_extents(drawn->pen, words, &extents);
    set_colour(drawn, font->colour);
    cairo_save(drawn->pen);
    cairo_translate(drawn->pen, at.x, at.y);
    if (font->upwards)
        cairo_rotate(drawn->pen, -pi / 2);
    cairo_move_to(drawn->pen, -shares[font->anchor] * extents.x_advance, 0);
    cairo_show_text(drawn->pen, words);
    cairo_restore(drawn->pen);
    cairo_new_path(drawn->pen);
}

static void clip(canvas *drawn, const char *name, canvas_point corner, double width,
                 double height) {
    (void)name;
    cairo_save(drawn->pen);
    cairo_rectangle(drawn->pen, corner.x, corner.y, width, height);
    cairo_clip(drawn->pen);
}

static void unclip(canvas *drawn) {
    cairo_restore(drawn->pen);
}

/* The bytes of the file as they come. */
typedef struct bytes {
    unsigned char *data;
    size_t length, room;
} bytes;

static cairo_status_t collect(void *context, const unsigned char *data, unsigned length) {
    bytes *const file = context;
    if (file->length + length > file->room) {
        const size_t room = 2 * (file->length + length);
        unsigned char *const more = realloc(file->data, room);
        if (!more)
            return CAIRO_STATUS_NO_MEMORY;
        file->data = more;
        file->room = room;
    }
    memcpy(file->data + file->length, data, length);
    file->length += length;
    return CAIRO_STATUS_SUCCESS;
}

static dl_status finish(canvas *drawn, const char *path, dl_error *error) {
    bytes file = {0};
    cairo_status_t failure = cairo_status(drawn->pen);
    if (!failure)
        failure = cairo_surface_write_to_png_stream(drawn->surface, collect, &file);
    cairo_destroy(drawn->pen);
    cairo_surface_destroy(drawn->surface);
    free(drawn);
    const dl_status status = failure ? dl_fail(error, DL_ERROR, "%s: cannot be drawn: %s", path,
                                               cairo_status_to_string(failure))
                                     : dl_replace_file(path, file.data, file.length, error);
    free(file.data);
    return status;
}

const canvas_ops dl_canvas_png = {
    .suffix = ".png",
    .create = create,
    .circle = circle,
    .lines = lines,
    .text = text,
    .clip = clip,
    .unclip = unclip,
    .finish = finish,
};
