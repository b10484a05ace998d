/* Trajectories as H5MD 1.1 files (https://www.nongnu.org/h5md/): read by MDAnalysis and others.
 *
 * Positions and velocities are 64-bit reals and always three-dimensional (z = 0 in 2-D scenes), so
 * that a run can start from the last frame of another with every bit. */
#ifndef DRIFTLAB_TRAJECTORY_H
#define DRIFTLAB_TRAJECTORY_H

#include <stddef.h>
#include "driftlab/run.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"

typedef struct dl_trajectory dl_trajectory;

/* Creates the file (beside `path`, renamed onto it when closed). `method` and `options` go to its
 * metadata. */
dl_status dl_trajectory_create(const char *path, const dl_scene *scene, const char *method,
                               const char *options, dl_trajectory **trajectory, dl_error *error);
/* Adds a frame: positions, velocities, energies, errors. */
dl_status dl_trajectory_append(dl_trajectory *trajectory, const dl_sample *sample, dl_error *error);
/* Completes the file and moves it to its name. Frees the trajectory, also on failure. */
dl_status dl_trajectory_close(dl_trajectory *trajectory, dl_error *error);

/* Last frame: *y_all [2 * dimension * particles] as dl_model_expand orders it, owned by the
 * caller. DL_INPUT where the file is no H5MD file or has other particles than the scene. */
dl_status dl_trajectory_read_last(const char *path, const dl_scene *scene, double **y_all,
                                  double *time, dl_error *error);

/* A copy of `scene` that starts at y_all. */
dl_status dl_scene_restart(const dl_scene *scene, const double *y_all, dl_scene **restarted,
                           dl_error *error);

#endif
