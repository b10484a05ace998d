/* Pictures of a state, as the papers draw them: a circle a particle, sized and shaded by mass; in a
 * hexagon where it is solid, in a triangle where it is gas (TR299, Figure 17); velocities as arrows
 * (TR171, Figure 3.4); walls; equal axes in the scene's units. And players: trajectories that move,
 * in one HTML page. */
#ifndef DRIFTLAB_PICTURE_H
#define DRIFTLAB_PICTURE_H

#include <stdbool.h>
#include "driftlab/observe.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"
#include "driftlab/trajectory.h"

typedef enum dl_picture_colour {
    DL_COLOUR_MASS,
    DL_COLOUR_SPEED,
    DL_COLOUR_STATE,
    DL_COLOUR_NONE,
} dl_picture_colour;

/* low[1] <= high[1]: what is drawn, in the scene's units. */
typedef struct dl_picture_window {
    double low[2], high[2];
} dl_picture_window;

typedef struct dl_picture {
    const dl_scene *scene;
    const double *y_all; /* positions, then velocities, of all particles */
    const char *title;   /* NULL: the scene's name */
    const char *caption; /* a second line; NULL: the number of particles */
    dl_picture_colour colour;
    const dl_state *state;           /* [particles]; DL_COLOUR_STATE alone needs it */
    bool velocities;                 /* arrows */
    bool equal_size;                 /* circles of one size, whatever the masses */
    int across, up;                  /* components drawn along the axes: 0, 1 for x and y */
    const dl_picture_window *window; /* NULL: all particles, with walls that are near */
} dl_picture;

/* Writes `path`, complete or not at all: SVG where it ends in .svg, PNG (two pixels a unit of the
 * SVG) where it ends in .png, else DL_INPUT. In periodic directions particles are drawn in the
 * box. */
dl_status dl_picture_write(const dl_picture *picture, const char *path, dl_error *error);

/* A window that holds what has not escaped (dl_observe_escape with dl_escape_link). */
dl_status dl_picture_window_of_system(const dl_picture *picture, dl_picture_window *window,
                                      dl_error *error);

/* A window that holds the heaviest group (dl_observe_system with dl_escape_link), with room of that
 * link around it; DL_INPUT where the pair law has no link. */
dl_status dl_picture_window_of_body(const dl_picture *picture, dl_picture_window *window,
                                    dl_error *error);

/* States at frame `number`, state [particles]: Table IV of TR299 on the program's temperature over
 * its 500 steps up to there. DL_INPUT where there is no threshold for a mass. */
dl_status dl_picture_states(const dl_scene *scene, dl_frames *frames, size_t number,
                            dl_state *state, dl_error *error);
/* The same for a state that has no past. */
dl_status dl_picture_states_now(const dl_scene *scene, const double *y_all, dl_state *state,
                                dl_error *error);

/* A self-contained page that plays these trajectories (files that driftlab wrote). */
dl_status dl_player_write(const char *const *trajectory, size_t count, const char *path,
                          dl_error *error);

#endif
