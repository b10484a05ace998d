/* Mean separation: distances to the nearest others. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "observe/pairs.h"

/* Puts `value` into the ascending list of the smallest `room`, of which there are *count. */
static void keep_smallest(double *list, size_t room, size_t *count, double value) {
    if (*count == room && value >= list[room - 1])
        return;
    size_t k = *count < room ? (*count)++ : room - 1;
    for (; k > 0 && list[k - 1] > value; k--)
        list[k] = list[k - 1];
    list[k] = value;
}

dl_status dl_observe_separation(const dl_scene *scene, const double *y_all, size_t nearest,
                                double *mean, dl_error *error) {
    const size_t n = scene->particles;
    double *list = malloc((nearest ? nearest : 1) * sizeof *list), d[3], sum = 0;
    size_t moving = 0;
    if (!list)
        return dl_fail_memory(error, "the nearest particles");
    *mean = NAN;
    for (size_t i = 0; nearest > 0 && n > 1 && i < n; i++) {
        size_t count = 0;
        double own = 0;
        if (scene->pinned[i])
            continue;
        for (size_t j = 0; j < n; j++)
            if (j != i)
                keep_smallest(list, nearest, &count,
                              dl_observe_separation_of(scene, y_all, i, j, d));
        for (size_t k = 0; k < count; k++)
            own += sqrt(list[k]);
        sum += own / (double)count;
        moving++;
    }
    if (moving > 0)
        *mean = sum / (double)moving;
    free(list);
    return DL_OK;
}
