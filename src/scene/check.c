#include <stdio.h>
#include <stdlib.h>
#include "driftlab/parameter.h"
#include "scene/draft.h"
#include "scene/periods.h"

static const char axis_names[] = "xyz";

/* --- walls ------------------------------------------------------------------------------------ */

static dl_status outside(const dl_particle *particle, int axis, const dl_walls *walls,
                         dl_error *error) {
    const bool below = particle->position[axis] < walls->low[axis];
    char found[40], wall[40];
    dl_format_real(particle->position[axis], found, sizeof found);
    dl_format_real(below ? walls->low[axis] : walls->high[axis], wall, sizeof wall);
    return dl_fail(error, DL_INPUT, "%s:%d: %c: found %s, expected %s %s, where a wall is",
                   particle->file, particle->line, axis_names[axis], found,
                   below ? ">=" : "<=", wall);
}

static dl_status check_walls(const dl_particles *particles, const dl_walls *walls,
                             dl_error *error) {
    for (size_t i = 0; i < particles->count; i++) {
        const dl_particle *const particle = &particles->particle[i];
        for (int axis = 0; axis < particles->dimension; axis++)
            if (particle->position[axis] < walls->low[axis] ||
                particle->position[axis] > walls->high[axis])
                return outside(particle, axis, walls, error);
    }
    return DL_OK;
}

/* --- coincident particles --------------------------------------------------------------------- */

typedef struct place {
    double position[3];
    size_t particle;
} place;

static int compare_positions(const double *a, const double *b) {
    for (int axis = 0; axis < 3; axis++)
        if (a[axis] != b[axis])
            return a[axis] < b[axis] ? -1 : 1;
    return 0;
}

static int compare_places(const void *a, const void *b) {
    const place *const p = a, *const q = b;
    const int order = compare_positions(p->position, q->position);
    return order ? order : (p->particle > q->particle) - (p->particle < q->particle);
}

static void write_position(const dl_particle *particle, int dimension, char *text, size_t size) {
    char number[3][40] = {""};
    for (int axis = 0; axis < dimension; axis++)
        dl_format_real(particle->position[axis], number[axis], sizeof number[axis]);
    snprintf(text, size, "(%s, %s%s%s)", number[0], number[1], dimension == 3 ? ", " : "",
             number[2]);
}

static dl_status coincident(const dl_particles *particles, size_t first, size_t second,
                            size_t others, dl_error *error) {
    const dl_particle *const a = &particles->particle[first];
    const dl_particle *const b = &particles->particle[second];
    char position[128], more[64] = "";
    write_position(b, particles->dimension, position, sizeof position);
    if (others)
        snprintf(more, sizeof more, " (and %zu more such pair%s)", others, others > 1 ? "s" : "");
    return dl_fail(error, DL_INPUT,
                   "%s:%d: position: found %s, where the particle of %s:%d already is, expected "
                   "particles at different places%s",
                   b->file, b->line, position, a->file, a->line, more);
}

/* The pair whose second particle comes first in the scene. */
static dl_status find_coincident(const dl_particles *particles, const place *places,
                                 dl_error *error) {
    size_t first = 0, second = particles->count, found = 0;
    for (size_t i = 1; i < particles->count; i++) {
        if (compare_positions(places[i - 1].position, places[i].position) != 0)
            continue;
        found++;
        if (places[i].particle < second) {
            first = places[i - 1].particle;
            second = places[i].particle;
        }
    }
    return found ? coincident(particles, first, second, found - 1, error) : DL_OK;
}

static dl_status check_coincidence(const dl_particles *particles, const dl_periods *periods,
                                   dl_error *error) {
    place *const places = malloc(particles->count * sizeof *places);
    if (!places)
        return dl_fail_memory(error, "the search for coincident particles");
    for (size_t i = 0; i < particles->count; i++) {
        const double *const x = particles->particle[i].position;
        places[i] = (place){{x[0], x[1], x[2]}, i};
        for (int axis = 0; axis < 3 && periods->present; axis++)
            places[i].position[axis] = dl_periods_key(periods, axis, x[axis]);
    }
    qsort(places, particles->count, sizeof *places, compare_places);
    const dl_status status = find_coincident(particles, places, error);
    free(places);
    return status;
}

/* --- all -------------------------------------------------------------------------------------- */

static dl_status check_motion(const dl_particles *particles, dl_error *error) {
    for (size_t i = 0; i < particles->count; i++)
        if (!particles->particle[i].pinned)
            return DL_OK;
    const dl_particle *const last = &particles->particle[particles->count - 1];
    return dl_fail(error, DL_INPUT,
                   "%s:%d: pinned: found true for all %zu particles, expected one "
                   "that moves",
                   last->file, last->line, particles->count);
}

dl_status dl_particles_check(const dl_particles *particles, const dl_walls *walls,
                             const dl_periods *periods, dl_error *error) {
    dl_status status = check_motion(particles, error);
    if (!status && walls->present)
        status = check_walls(particles, walls, error);
    return status ? status : check_coincidence(particles, periods, error);
}
