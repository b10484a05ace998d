/* Scenes with something added that changes no physics. */
#ifndef DL_STUDY_LEAVE_OUTS_H
#define DL_STUDY_LEAVE_OUTS_H

#include <stdbool.h>
#include "driftlab/explain.h"
#include "driftlab/scene.h"

/* A copy of a scene. */
dl_status dl_scene_copy(const dl_scene *scene, dl_scene **copy, dl_error *error);

/* Whether there is something neutral to add: a slow part of the force is made only when a method
 * asks for it. */
bool dl_can_add(dl_left_out what);

/* Adds it to a scene whose model leaves it out. */
dl_status dl_scene_add_neutral(dl_scene *scene, dl_left_out what, dl_error *error);

#endif
