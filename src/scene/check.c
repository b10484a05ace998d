#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
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

/* Pairs that a message names, and counts: all particles may be in one place. */
enum { most_named = 8, most_counted = 1000 };

typedef struct pair {
    size_t first, second;
    double apart;
} pair;

/* Pairs nearer than this part of the mean spacing are named as well where others coincide: most
 * often they are slips of the same kind. */
static const double hardly_apart = 0.02;

/* Where the pair stands: lines alone where they are in the file that has been named. */
static size_t write_pair(const dl_particles *particles, const pair *named, const char *file,
                         char *text, size_t size) {
    const dl_particle *const a = &particles->particle[named->first];
    const dl_particle *const b = &particles->particle[named->second];
    char position[128], apart[48] = "";
    write_position(b, particles->dimension, position, sizeof position);
    if (named->apart > 0)
        snprintf(apart, sizeof apart, ", %.2g apart", named->apart);
    const bool same = strcmp(a->file, file) == 0 && strcmp(b->file, file) == 0;
    const int length =
        same ? snprintf(text, size, "lines %d and %d at %s%s", a->line, b->line, position, apart)
             : snprintf(text, size, "%s:%d and %s:%d at %s%s", a->file, a->line, b->file, b->line,
                        position, apart);
    return length < 0 ? size : (size_t)length;
}

static dl_status coincident(const dl_particles *particles, const pair *named, size_t found,
                            dl_error *error) {
    const dl_particle *const a = &particles->particle[named->first];
    const dl_particle *const b = &particles->particle[named->second];
    char position[128], others[DL_MESSAGE_SIZE] = "";
    size_t length = 0, k = 1;
    write_position(b, particles->dimension, position, sizeof position);
    for (; k < found && k < most_named && length < sizeof others; k++) {
        length += (size_t)snprintf(others + length, sizeof others - length, "; ");
        if (length < sizeof others)
            length +=
                write_pair(particles, &named[k], b->file, others + length, sizeof others - length);
    }
    if (k < found && length < sizeof others)
        snprintf(others + length, sizeof others - length, "; %zu%s more such pair%s", found - k,
                 found < most_counted ? "" : " or", found - k > 1 ? "s" : "");
    return dl_fail(error, DL_INPUT,
                   "%s:%d: position: found %s, where the particle of %s:%d already is, expected "
                   "particles at different places%s",
                   b->file, b->line, position, a->file, a->line, others);
}

/* Mean spacing in the box that just holds all. */
static double mean_spacing(const dl_particles *particles) {
    double volume = 1;
    for (int axis = 0; axis < particles->dimension; axis++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < particles->count; i++) {
            low = fmin(low, particles->particle[i].position[axis]);
            high = fmax(high, particles->particle[i].position[axis]);
        }
        volume *= high - low;
    }
    return pow(volume / (double)particles->count, 1.0 / particles->dimension);
}

static bool comes_before(const pair *a, const pair *b) {
    if ((a->apart > 0) != (b->apart > 0))
        return !(a->apart > 0);
    return a->second < b->second;
}

/* Those that come first are kept, in order. */
static void keep_pair(pair named[most_named], size_t found, const pair *next) {
    size_t at = found < most_named ? found : most_named;
    for (; at > 0 && comes_before(next, &named[at - 1]); at--)
        if (at < most_named)
            named[at] = named[at - 1];
    if (at < most_named)
        named[at] = *next;
}

static double distance(const place *a, const place *b) {
    double square = 0;
    for (int axis = 0; axis < 3; axis++)
        square += (a->position[axis] - b->position[axis]) * (a->position[axis] - b->position[axis]);
    return sqrt(square);
}

/* Pairs not farther apart than `within`, those that coincide first, in the order of their second
 * particles. Places are in the order of their first coordinates. */
static size_t find_pairs(const dl_particles *particles, const place *places, double within,
                         pair named[most_named]) {
    size_t found = 0;
    for (size_t i = 1; i < particles->count; i++)
        for (size_t j = i; j-- > 0 && found < most_counted;) {
            if (!(places[i].position[0] - places[j].position[0] <= within))
                break;
            const double apart = distance(&places[j], &places[i]);
            const size_t a = places[j].particle, b = places[i].particle;
            if (apart <= within)
                keep_pair(named, found++, &(pair){a < b ? a : b, a < b ? b : a, apart});
        }
    return found;
}

static bool any_coincide(const dl_particles *particles, const place *places) {
    for (size_t i = 1; i < particles->count; i++)
        if (compare_positions(places[i - 1].position, places[i].position) == 0)
            return true;
    return false;
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
    pair named[most_named];
    const size_t found =
        any_coincide(particles, places)
            ? find_pairs(particles, places, hardly_apart * mean_spacing(particles), named)
            : 0;
    free(places);
    return found ? coincident(particles, named, found, error) : DL_OK;
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
