/* SVG 1.1, written as text: shapes stay shapes and words stay words, which others can edit. */
#include <stdio.h>
#include <stdlib.h>

#include "io/replace_file.h"
#include "report/canvas.h"
#include "report/html_text.h"

struct canvas {
    FILE *out;
    char *text;
    size_t length;
    unsigned clips;
};

static const char *const anchors[] = {
    [CANVAS_START] = "start", [CANVAS_MIDDLE] = "middle", [CANVAS_END] = "end"};

static void put_text(FILE *out, const char *text) {
    char *const safe = dl_html_text(text);
    fputs(safe ? safe : "", out);
    free(safe);
}

static void put_colour(FILE *out, const char *what, int colour) {
    if (colour == CANVAS_NONE)
        fprintf(out, " %s=\"none\"", what);
    else
        fprintf(out, " %s=\"#%06x\"", what, (unsigned)colour);
}

static void put_style(FILE *out, const canvas_style *style) {
    if (style->name)
        fprintf(out, " class=\"%s\"", style->name);
    put_colour(out, "fill", style->fill);
    if (style->stroke != CANVAS_NONE) {
        put_colour(out, "stroke", style->stroke);
        fprintf(out, " stroke-width=\"%.4g\"", style->width);
        if (style->dashed)
            fputs(" stroke-dasharray=\"6 4\"", out);
    }
}

static canvas *create(double width, double height, const char *title) {
    canvas *const drawn = calloc(1, sizeof *drawn);
    if (!drawn)
        return NULL;
    drawn->out = open_memstream(&drawn->text, &drawn->length);
    if (!drawn->out) {
        free(drawn);
        return NULL;
    }
    fprintf(drawn->out,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
            "viewBox=\"0 0 %.0f %.0f\" font-family=\"'Liberation Sans', Arial, sans-serif\">\n"
            "<title>",
            width, height, width, height);
    put_text(drawn->out, title);
    fputs("</title>\n<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\"/>\n", drawn->out);
    return drawn;
}

static void circle(canvas *drawn, canvas_point centre, double radius, const canvas_style *style) {
    fprintf(drawn->out, "<circle cx=\"%.2f\" cy=\"%.2f\" r=\"%.2f\"", centre.x, centre.y, radius);
    put_style(drawn->out, style);
    fputs("/>\n", drawn->out);
}

static void lines(canvas *drawn, size_t count, const canvas_point *point,
                  const canvas_style *style) {
    fputs(style->fill == CANVAS_NONE ? "<polyline points=\"" : "<polygon points=\"", drawn->out);
    for (size_t k = 0; k < count; k++)
        fprintf(drawn->out, k ? " %.2f,%.2f" : "%.2f,%.2f", point[k].x, point[k].y);
    fputc('"', drawn->out);
    put_style(drawn->out, style);
    fputs("/>\n", drawn->out);
}

static void text(canvas *drawn, canvas_point at, const char *words, const canvas_font *font) {
    fprintf(drawn->out, "<text x=\"%.2f\" y=\"%.2f\" font-size=\"%.4g\" text-anchor=\"%s\"", at.x,
            at.y, font->size, anchors[font->anchor]);
    put_colour(drawn->out, "fill", font->colour);
    if (font->bold)
        fputs(" font-weight=\"bold\"", drawn->out);
    if (font->upwards)
        fprintf(drawn->out, " transform=\"rotate(-90 %.2f %.2f)\"", at.x, at.y);
    fputc('>', drawn->out);
    put_text(drawn->out, words);
    fputs("</text>\n", drawn->out);
}

static void clip(canvas *drawn, const char *name, canvas_point corner, double width,
                 double height) {
    const unsigned number = drawn->clips++;
    fprintf(drawn->out,
            "<clipPath id=\"clip%u\"><rect x=\"%.2f\" y=\"%.2f\" width=\"%.2f\" height=\"%.2f\"/>"
            "</clipPath>\n<g class=\"%s\" clip-path=\"url(#clip%u)\">\n",
            number, corner.x, corner.y, width, height, name, number);
}

static void unclip(canvas *drawn) {
    fputs("</g>\n", drawn->out);
}

static dl_status finish(canvas *drawn, const char *path, dl_error *error) {
    fputs("</svg>\n", drawn->out);
    const bool failed = ferror(drawn->out) != 0;
    const bool good = fclose(drawn->out) == 0 && !failed;
    const dl_status status = good ? dl_replace_file(path, drawn->text, drawn->length, error)
                                  : dl_fail_memory(error, "a picture");
    free(drawn->text);
    free(drawn);
    return status;
}

const canvas_ops dl_canvas_svg = {
    .suffix = ".svg",
    .create = create,
    .circle = circle,
    .lines = lines,
    .text = text,
    .clip = clip,
    .unclip = unclip,
    .finish = finish,
};
