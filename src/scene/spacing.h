/* Particles by cells, so that whether a place is far enough from all of them is asked of those
 * around it alone. */
#ifndef DL_SCENE_SPACING_H
#define DL_SCENE_SPACING_H

#include "scene/draft.h"

typedef struct dl_spacing {
    const dl_particles *particles;
    double distance;
    double cell;       /* width, or the least one along a period */
    double periods[3]; /* cells to a period; 0 where there is none */
    size_t slots;      /* of the table that cells are hashed into; 0: the distance is 0 */
    long *first;       /* [slots]: a particle of the slot, -1: none */
    long *next;        /* [room]: another of the same slot */
} dl_spacing;

/* Holds the particles that there are; there will be at most `room`. They must outlive it. */
dl_status dl_spacing_create(const dl_particles *particles, double distance, size_t room,
                            dl_spacing *spacing, dl_error *error);
void dl_spacing_free(dl_spacing *spacing);

/* Whether every particle, and every copy of it, is at least `distance` from there. */
bool dl_spacing_allows(const dl_spacing *spacing, const double position[3]);

/* Takes in particle `number`, which has been added. */
void dl_spacing_add(dl_spacing *spacing, size_t number);

#endif
