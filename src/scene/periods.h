/* Periodic boxes of scenes. */
#ifndef DL_SCENE_PERIODS_H
#define DL_SCENE_PERIODS_H

#include "driftlab/scene.h"
#include "driftlab/status.h"
#include "io/yaml.h"
#include "scene/draft.h"

/* Reads the key `periodic` of the file's top into scene->periods, after everything that it has to
 * go with: pair laws, gravity, walls, radiation. */
dl_status dl_periods_read(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                          dl_error *error);

/* Moves particles by whole periods to where low <= x < low + length. */
void dl_periods_wrap(const dl_periods *periods, dl_particles *particles);

/* A number that is the same for two positions along an axis that are copies of one another, to
 * about 1e-12 of the period; without a period the position itself. */
double dl_periods_key(const dl_periods *periods, int axis, double x);

#endif
