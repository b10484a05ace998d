/* Initial states by rule. An item of `particles` is placed (at, file, lattice, random), then its
 * masses are dealt out or exchanged, then it is set in motion; a scene can begin with what is left
 * of another run. Every function reads the keys it stands for and adds to `particles`. */
#ifndef DL_SCENE_INITIAL_H
#define DL_SCENE_INITIAL_H

#include "core/random_stream.h"
#include "scene/draft.h"
#include "scene/tables.h"

/* Values of the sections' tables (initial_tables.c). */
typedef struct dl_lattice_values {
    int kind;
    double spacing, angle;
    double radius; /* INFINITY: not given */
} dl_lattice_values;

typedef struct dl_random_values {
    long count, tries;
    double minimum_distance;
} dl_random_values;

typedef struct dl_rotation_values {
    double rate, perturbation, reference_mass;
} dl_rotation_values;

typedef struct dl_perturb_values {
    double relative;
    bool normalise;
} dl_perturb_values;

typedef struct dl_exchange_values {
    long pairs;
} dl_exchange_values;

typedef struct dl_start_values {
    char *from, *frame, *made_by;
} dl_start_values;

typedef struct dl_remove_values {
    double above; /* INFINITY: nowhere */
    long highest, fastest;
} dl_remove_values;

extern const dl_scene_section dl_section_lattice;
extern const dl_scene_section dl_section_random;
extern const dl_scene_section dl_section_exchange;
extern const dl_scene_section dl_section_rotation;
extern const dl_scene_section dl_section_perturb;
extern const dl_scene_section dl_section_start;
extern const dl_scene_section dl_section_remove;

enum { dl_lattice_hexagonal, dl_lattice_square, dl_lattice_simple, dl_lattice_face_centred };

enum { dl_most_placed = 1000000 }; /* particles of one lattice or random item */

/* An item while its rules are carried out. */
typedef struct dl_initial {
    const dl_yaml *yaml;
    const dl_yaml_node *node; /* the item's mapping */
    const dl_scene_item *item;
    dl_random *random;
    dl_particles *particles;
    size_t first; /* of the item's particles */
} dl_initial;

/* DL_INPUT where the item would have more than dl_most_placed. */
dl_status dl_initial_add(dl_initial *initial, const double position[3], dl_error *error);

dl_status dl_initial_place_lattice(dl_initial *initial, dl_error *error);
dl_status dl_initial_place_random(dl_initial *initial, dl_error *error);

/* `masses` and `exchange`, where the item has them. */
dl_status dl_initial_set_masses(dl_initial *initial, dl_error *error);

/* `velocity`, `rotation`, `perturb`, `speed` and `temperature`, added up. */
dl_status dl_initial_set_motion(dl_initial *initial, dl_error *error);

/* The scene's `start`. */
dl_status dl_initial_start(const dl_yaml *yaml, const dl_yaml_node *start, dl_particles *particles,
                           dl_error *error);

/* Every particle of the first frame of the trajectory `path`. */
dl_status dl_initial_resume(const char *path, dl_particles *particles, dl_error *error);

/* The list of whole numbers >= 1 (at most `most`) that `node` is; *values is the caller's. */
dl_status dl_initial_read_counts(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                                 long most, size_t *count, long **values, dl_error *error);

#endif
