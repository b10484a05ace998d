/* Species of particles and the pair laws between them. */
#ifndef DL_SCENE_SPECIES_H
#define DL_SCENE_SPECIES_H

#include "driftlab/scene.h"
#include "driftlab/status.h"
#include "io/yaml.h"
#include "scene/draft.h"

/* Reads the key `pair_laws` of the file's top: scene->species, their names and laws. */
dl_status dl_species_read(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                          dl_error *error);

/* Which species `name` is (NULL or "": none was given); -1 in a scene that has none. DL_INPUT, at
 * file and line, names those there are. */
dl_status dl_species_find(const dl_particles *particles, const char *name, const char *file,
                          int line, int *species, dl_error *error);

/* Longest cutoff of a scene's pair laws; INFINITY where one never ends, 0 where there is none. */
double dl_scene_reach(const dl_scene *scene);

#endif
