/* What a player is made from: a trajectory as one JSON text, its vectors as whole numbers of 16
 * bits in base64. */
#ifndef DL_REPORT_PLAYER_DATA_H
#define DL_REPORT_PLAYER_DATA_H

#include <stddef.h>
#include "driftlab/status.h"

/* Bytes of particles, before base64, that all players of a page may take: more frames are thinned.
 */
#define DL_PLAYER_BYTES (18u << 20)

/* *json is owned by the caller and may stand inside <script>. Numbers that are not finite are null.
 *
 *     name, method, options; particles, dimension; frames (in the file), stride
 *     time, step: [shown]; energy: [shown], |error| / energy scale, or null
 *     kinetic, potential: [shown], energies, or null
 *     low, high: [dimension], what 0 and 65535 stand for in `position`, Uint16
 * [shown][dimension][n] fastest: what 32767 stands for in `velocity`, Int16 [shown][dimension][n]
 *     speeds: [2], at the ends of the colours
 *     state: Uint8 [shown][n], 0 solid, 1 liquid, 2 gas; null where the masses have no thresholds
 *     window: [dimension][2], what there is to see, walls included
 *     radius: of the heaviest, a length; size: [n], relative to it; shade: [n], 0xRRGGBB; mass: [n]
 *     pinned: [...], numbers of particles; walls: [dimension][2] or null; periods: [dimension][2]
 *     or null
 *
 *     colours: [64], from slow to fast; states: what solid, liquid and gas look like
 *
 * All arrays are little-endian. */
dl_status dl_player_data(const char *path, size_t most_bytes, char **json, dl_error *error);

/* The <script> elements of `count` trajectories, owned by the caller. */
dl_status dl_player_blocks(const char *const *trajectory, size_t count, char **html,
                           dl_error *error);

#endif
