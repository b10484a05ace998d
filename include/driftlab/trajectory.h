/* Trajectories as H5MD 1.1 files (https://www.nongnu.org/h5md/): read by MDAnalysis and others.
 *
 * Positions and velocities are 64-bit reals and always three-dimensional (z = 0 in 2-D scenes), so
 * that a run can start from the last frame of another with every bit. */
#ifndef DRIFTLAB_TRAJECTORY_H
#define DRIFTLAB_TRAJECTORY_H

#include <stdbool.h>
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

/* One frame and what its particles are. Components as in a scene, always three. What a file of
 * another program lacks is NULL. */
typedef struct dl_trajectory_frame {
    size_t particles;
    int components;              /* of the file's vectors, 2 or 3 */
    size_t frames;               /* of the trajectory */
    double time;                 /* NaN where the file does not say */
    double *position, *velocity; /* [3 * particles] */
    double *inertia, *coupling;  /* [particles] */
    bool *pinned, *feels_gravity;
    char **species; /* [particles], names in species_text */
    char *species_text;
} dl_trajectory_frame;

/* Frame `number`, from 0; SIZE_MAX: the last. On failure there is nothing to free. DL_INPUT where
 * the file is no H5MD file or has no such frame. */
dl_status dl_trajectory_read_frame(const char *path, size_t number, dl_trajectory_frame *frame,
                                   dl_error *error);
void dl_trajectory_frame_free(dl_trajectory_frame *frame);

/* The text of the scene file that the run was of, owned by the caller. DL_INPUT where there is
 * none: the file of another program. */
dl_status dl_trajectory_read_scene_text(const char *path, char **text, dl_error *error);

/* The scene that the run was of, from the trajectory alone, as it was at the first frame. */
dl_status dl_scene_read_trajectory(const char *path, dl_scene **scene, dl_error *error);

/* A frame as a state of `scene`; numbers and failures as for dl_trajectory_read_frame, and DL_INPUT
 * where it has other particles than the scene. *y_all as for the last frame below. */
dl_status dl_trajectory_read_state(const char *path, size_t number, const dl_scene *scene,
                                   double **y_all, double *time, dl_error *error);

/* Last frame: *y_all [2 * dimension * particles] as dl_model_expand orders it, owned by the
 * caller. DL_INPUT where the file is no H5MD file or has other particles than the scene. */
dl_status dl_trajectory_read_last(const char *path, const dl_scene *scene, double **y_all,
                                  double *time, dl_error *error);

/* A copy of `scene` that starts at y_all. */
dl_status dl_scene_restart(const dl_scene *scene, const double *y_all, dl_scene **restarted,
                           dl_error *error);

/* --- every frame of a trajectory ------------------------------------------------------------- */

/* A file kept open, for reading frame after frame. */
typedef struct dl_frames {
    size_t count, particles;
    int components;         /* of the file's vectors, 2 or 3 */
    double *time;           /* [count], not descending */
    long *step;             /* [count], of the method */
    double *energy_error;   /* [count], absolute, the ledger's losses booked; NULL: there is none */
    double *kinetic;        /* [count], energy; NULL: the file does not say */
    double *potential;      /* [count], energy of pairs and gravity; NULL: the file does not say */
    char *method, *options; /* of the run; NULL: the file does not say */
    struct dl_frames_file *file;
} dl_frames;

/* DL_INPUT where the file is no H5MD file, has no frames, or does not say their times and steps. */
dl_status dl_frames_open(const char *path, dl_frames **frames, dl_error *error);
/* Frame `number` < count as a state of a scene in `dimension` dimensions (components beyond are
 * left out), y_all [2 * dimension * particles]. */
dl_status dl_frames_read(dl_frames *frames, size_t number, int dimension, double *y_all,
                         dl_error *error);
/* The same as a state of `scene`: DL_INPUT where it has other particles, or another dimension. */
dl_status dl_frames_read_state(dl_frames *frames, size_t number, const dl_scene *scene,
                               double *y_all, dl_error *error);
void dl_frames_close(dl_frames *frames);

/* The frame of a step of the method, or of a time (to a millionth of the frames' interval).
 * DL_INPUT names those that there are. */
dl_status dl_frames_at_step(const dl_frames *frames, long step, size_t *number, dl_error *error);
dl_status dl_frames_at_time(const dl_frames *frames, double time, size_t *number, dl_error *error);

/* Whether a file is HDF5, as trajectories and results are; false where it cannot be read. */
bool dl_file_is_hdf5(const char *path);

#endif
