/* How particles look: sizes, shades and colours. */
#ifndef DL_REPORT_PICTURE_LOOK_H
#define DL_REPORT_PICTURE_LOOK_H

#include <stddef.h>
#include "driftlab/picture.h"

/* The masses of a scene. */
typedef struct dl_masses {
    size_t count;   /* of different ones */
    double *mass;   /* [count], ascending */
    size_t *number; /* [count], particles of that mass */
} dl_masses;

dl_status dl_masses_create(const dl_scene *scene, dl_masses *masses, dl_error *error);
void dl_masses_free(dl_masses *masses);

/* Size of a mass relative to that of the heaviest, in (0, 1]: areas are as the masses where radii
 * then are at most 2.5 apart, else radii as the power of the mass that makes them so. */
double dl_size_of(const dl_masses *masses, double mass);

/* White for the lightest to dark for the heaviest (TR299, Figure 2): by rank where the masses are
 * few, else by the logarithm of the mass. Pale where all are alike. 0xRRGGBB. */
int dl_shade_of(const dl_masses *masses, double mass);

/* Radius of the heaviest particle for which neighbours hardly overlap: from the distances of
 * nearest neighbours, `sizes` [particles] relative. 0 for a single particle. */
double dl_natural_radius(const dl_scene *scene, const double *y_all, int across, int up,
                         const double *sizes);

/* Speeds between which colours tell: from 0, or from the slowest where all are fast (a stream). One
 * runaway shall not make all others pale: to the 98th of a hundred where the fastest is more than
 * twice as fast. */
typedef struct dl_speed_range {
    double low, high;
    bool has_faster;
} dl_speed_range;

/* Sorts `speed`. */
dl_speed_range dl_speed_range_of(double *speed, size_t count);

double dl_speed_part(const dl_speed_range *range, double speed);

/* A part of the range, from 0 to 1, as a colour. */
int dl_colour_of(double part);

typedef struct dl_state_look {
    const char *name;
    int fill, stroke;
    int corners;         /* of the figure around the circle; 0: none */
    double first_corner; /* its direction, in turns */
    double reach;        /* of the corners, in radii of the circle */
} dl_state_look;

extern const dl_state_look dl_state_looks[3]; /* by dl_state */

#endif
