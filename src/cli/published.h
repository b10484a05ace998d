/* Published numbers beside computed ones.
 *
 * A CSV file: a header with `particle` and any of x, y, z, vx, vy, vz, then a row a particle (1 is
 * the scene's first). Numbers are taken as they are printed: how many digits they have is how far
 * they are compared. */
#ifndef DL_CLI_PUBLISHED_H
#define DL_CLI_PUBLISHED_H

#include <stdio.h>
#include "driftlab/scene.h"

typedef struct cli_comparison {
    size_t numbers, agree; /* agree: to half a unit of the last digit printed */
    double largest, units; /* difference; in units of the last digit */
} cli_comparison;

/* Writes a line a number to `out` (NULL: none). high, low [2 * dimension * particles]: the state.
 * `origin`: 0, or the particle (from 1) that the published state is relative to. DL_INPUT names
 * file and line. */
dl_status cli_compare_published(const char *path, const dl_scene *scene, const double *high,
                                const double *low, size_t origin, cli_comparison *found, FILE *out,
                                dl_error *error);

#endif
