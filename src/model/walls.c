/* Wall rule `mirror`: after a step, a particle beyond a wall is put to its mirror image and loses
 * part of its velocity (TR323, section III; its program tests the high side first). */
#include <math.h>
#include "model/private.h"

bool dl_model_outside(const dl_model *model, const double *q) {
    const dl_walls *walls = &model->scene->walls;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        const double *x = q + c * model->moving;
        double low = walls->low[c], high = walls->high[c];
        bool outside = false;
        for (size_t k = 0; k < model->moving; k++)
            outside |= (x[k] < low) | (x[k] > high);
        if (outside)
            return true;
    }
    return false;
}

/* Both components lose, the normal one turns round. */
static void bounce(const dl_model *model, double *q, double *v, size_t k, size_t axis,
                   double wall) {
    const dl_walls *walls = &model->scene->walls;
    size_t n = model->moving;
    q[axis * n + k] = 2 * wall - q[axis * n + k];
    for (size_t c = 0; c < (size_t)model->dimension; c++)
        v[c * n + k] *= c == axis ? -(1 - walls->damping) : 1 - walls->damping;
    if (fabs(v[k]) < walls->zero_vx_below)
        v[k] = 0;
}

static size_t mirror_particle(const dl_model *model, double *q, double *v, size_t k) {
    const dl_walls *walls = &model->scene->walls;
    size_t hits = 0;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        double x = q[c * model->moving + k];
        if (x > walls->high[c])
            bounce(model, q, v, k, c, walls->high[c]), hits++;
        else if (x < walls->low[c])
            bounce(model, q, v, k, c, walls->low[c]), hits++;
    }
    return hits;
}

size_t dl_model_mirror(const dl_model *model, double *q, double *v) {
    size_t hits = 0;
    for (size_t k = 0; k < model->moving; k++)
        hits += mirror_particle(model, q, v, k);
    return hits;
}
