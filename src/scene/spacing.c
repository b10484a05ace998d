#include "scene/spacing.h"

#include <math.h>
#include <stdlib.h>

/* Cells are a little wider than the distance, so that roundoff cannot put two particles that are
 * too near two cells apart; farther out than this they are not told apart. */
static const double wider = 1.001, farthest = 1e12;

/* Squared distance from the nearest copy. */
static double squared_distance(const dl_periods *periods, const double a[3], const double b[3]) {
    double sum = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double length = periods->length[axis];
        double d = a[axis] - b[axis];
        if (length > 0)
            d -= length * nearbyint(d / length);
        sum += d * d;
    }
    return sum;
}

dl_status dl_spacing_create(const dl_particles *particles, double distance, size_t room,
                            dl_spacing *spacing, dl_error *error) {
    const dl_periods *const periods = &particles->scene->periods;
    *spacing = (dl_spacing){
        .particles = particles, .distance = distance, .cell = wider * distance, .slots = 1};
    if (!(distance > 0)) {
        spacing->slots = 0;
        return DL_OK;
    }
    for (int axis = 0; axis < particles->dimension; axis++)
        if (periods->length[axis] > 0)
            spacing->periods[axis] =
                fmin(1e5, fmax(1, floor(periods->length[axis] / spacing->cell)));
    while (spacing->slots < 2 * room)
        spacing->slots *= 2;
    spacing->first = malloc(spacing->slots * sizeof *spacing->first);
    spacing->next = malloc((room + 1) * sizeof *spacing->next);
    if (!spacing->first || !spacing->next)
        return dl_fail_memory(error, "the cells of random particles");
    for (size_t slot = 0; slot < spacing->slots; slot++)
        spacing->first[slot] = -1;
    for (size_t i = 0; i < particles->count; i++)
        dl_spacing_add(spacing, i);
    return DL_OK;
}

void dl_spacing_free(dl_spacing *spacing) {
    free(spacing->first);
    free(spacing->next);
    *spacing = (dl_spacing){0};
}

static double cell_of(const dl_spacing *spacing, int axis, double x) {
    const double cells = spacing->periods[axis];
    if (!(cells > 0))
        return floor(fmax(-farthest, fmin(farthest, x / spacing->cell)));
    const double part = x / spacing->particles->scene->periods.length[axis];
    return fmin(cells - 1, floor((part - floor(part)) * cells));
}

/* `cell` may be one beyond the period's cells. */
static size_t slot_of(const dl_spacing *spacing, const double cell[3]) {
    uint64_t key = 0;
    for (int axis = 0; axis < 3; axis++) {
        const double cells = spacing->periods[axis];
        const double wrapped =
            cells > 0 ? cell[axis] - cells * floor(cell[axis] / cells) : cell[axis];
        key = (key ^ (uint64_t)(int64_t)wrapped) * UINT64_C(0x9e3779b97f4a7c15);
        key ^= key >> 29;
    }
    return (size_t)key & (spacing->slots - 1);
}

static bool is_too_near(const dl_spacing *spacing, size_t slot, const double position[3]) {
    const dl_periods *const periods = &spacing->particles->scene->periods;
    for (long i = spacing->first[slot]; i >= 0; i = spacing->next[i])
        if (squared_distance(periods, position, spacing->particles->particle[i].position) <
            spacing->distance * spacing->distance)
            return true;
    return false;
}

bool dl_spacing_allows(const dl_spacing *spacing, const double position[3]) {
    double middle[3] = {0}, cell[3];
    int most[3] = {0};
    if (spacing->slots == 0)
        return true;
    for (int axis = 0; axis < spacing->particles->dimension; axis++) {
        middle[axis] = cell_of(spacing, axis, position[axis]);
        most[axis] = 1;
    }
    for (int a = -most[0]; a <= most[0]; a++)
        for (int b = -most[1]; b <= most[1]; b++)
            for (int c = -most[2]; c <= most[2]; c++) {
                cell[0] = middle[0] + a;
                cell[1] = middle[1] + b;
                cell[2] = middle[2] + c;
                if (is_too_near(spacing, slot_of(spacing, cell), position))
                    return false;
            }
    return true;
}

void dl_spacing_add(dl_spacing *spacing, size_t number) {
    double cell[3] = {0};
    if (spacing->slots == 0)
        return;
    for (int axis = 0; axis < spacing->particles->dimension; axis++)
        cell[axis] = cell_of(spacing, axis, spacing->particles->particle[number].position[axis]);
    const size_t slot = slot_of(spacing, cell);
    spacing->next[number] = spacing->first[slot];
    spacing->first[slot] = (long)number;
}
