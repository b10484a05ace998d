#include "report/canvas.h"

#include <string.h>

dl_status dl_canvas_for(const char *path, const canvas_ops **ops, dl_error *error) {
    static const canvas_ops *const canvases[] = {&dl_canvas_svg, &dl_canvas_png};
    const size_t length = strlen(path);
    for (size_t k = 0; k < sizeof canvases / sizeof *canvases; k++) {
        const size_t suffix = strlen(canvases[k]->suffix);
        if (length > suffix && strcmp(path + length - suffix, canvases[k]->suffix) == 0) {
            *ops = canvases[k];
            return DL_OK;
        }
    }
    return dl_fail(error, DL_INPUT,
                   "%s: found no picture's name, expected one that ends in .svg or .png", path);
}
