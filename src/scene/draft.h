/* Particles of a scene while it is read: each remembers the line it stands on. */
#ifndef DL_SCENE_DRAFT_H
#define DL_SCENE_DRAFT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include "driftlab/scene.h"
#include "driftlab/status.h"
#include "io/yaml.h"
#include "scene/tables.h"

typedef struct dl_particle {
    double position[3], velocity[3]; /* unused components are 0 */
    double inertia, coupling;
    int species; /* -1: the scene has none */
    bool pinned, gravity;
    const char *file; /* where it stands; the draft's or the YAML's */
    int line;
} dl_particle;

typedef struct dl_particles {
    const dl_scene *scene; /* its species and their names */
    int dimension;
    uint64_t seed; /* the scene's */
    size_t count, room;
    dl_particle *particle;
    size_t files;
    char **file; /* paths of the data files */
} dl_particles;

/* Adds one, of the file and line it stands on. */
dl_status dl_particles_add(dl_particles *particles, const dl_scene_row *row, const char *file,
                           int line, dl_error *error);

/* The path `file` as seen from the folder of `scene_path`; it belongs to the particles. */
dl_status dl_particles_keep_path(dl_particles *particles, const char *scene_path, const char *file,
                                 const char **path, dl_error *error);

/* Reads the list `node`: values in range, vectors of the right length, rules carried out. */
dl_status dl_particles_read(const dl_yaml *yaml, const dl_yaml_node *node, dl_particles *particles,
                            dl_error *error);

/* Refuses particles outside the walls, particles at one place (copies included), and a scene where
 * nothing moves. */
dl_status dl_particles_check(const dl_particles *particles, const dl_walls *walls,
                             const dl_periods *periods, dl_error *error);

void dl_particles_free(dl_particles *particles);

/* Allocates the arrays of scene->particles and scene->dimension. */
dl_status dl_scene_allocate(dl_scene *scene, dl_error *error);

#endif
