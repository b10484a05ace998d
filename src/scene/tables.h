/* Every key of a scene file: the reader and `driftlab help scene` both go by these tables. */
#ifndef DL_SCENE_TABLES_H
#define DL_SCENE_TABLES_H

#include <stdbool.h>
#include "driftlab/parameter.h"
#include "driftlab/scene.h"
#include "driftlab/status.h"
#include "io/yaml.h"

/* What a section's table describes: scalar keys as the file gives them. */
typedef struct dl_scene_header {
    char *name, *source;
    long dimension;
    int kernel;
    double skin, tree_error;
    long seed;
} dl_scene_header;

typedef struct dl_scene_times {
    double step, end, sample;
} dl_scene_times;

typedef struct dl_scene_wall_values {
    double damping, zero_vx_below, rest;
    int rule;
} dl_scene_wall_values;

typedef struct dl_scene_piece_values {
    double until;
    int end;
    double width; /* INFINITY: not given */
    bool located;
} dl_scene_piece_values;

typedef struct dl_scene_term_values {
    dl_term term;
    int part;
} dl_scene_term_values;

/* Of one particle or of a whole file of them. */
typedef struct dl_scene_attributes {
    double mass;
    double inertia, coupling; /* INFINITY: not given, the mass */
    char *species;            /* "" or NULL: not given */
    bool pinned, gravity;
} dl_scene_attributes;

typedef struct dl_scene_item {
    char *file; /* "": none */
    dl_scene_attributes attributes;
    double speed, temperature;
    bool drift;
    long seed; /* -1: the scene's */
} dl_scene_item;

/* A row of a data file; the table is that of its columns. */
typedef struct dl_scene_row {
    double position[3], velocity[3];
    dl_scene_attributes attributes;
} dl_scene_row;

/* A key whose value is not a scalar. */
typedef struct dl_scene_key {
    const char *name;
    const char *form; /* what it looks like */
    const char *doc;
} dl_scene_key;

enum { dl_scene_section_keys = 12 };

typedef struct dl_scene_section {
    const char *title, *doc;
    const char *within; /* key of the file that it is the value, or an item, of */
    dl_parameter_table table;
    dl_scene_key key[dl_scene_section_keys + 1]; /* ends with a name that is NULL */
} dl_scene_section;

extern const dl_scene_section dl_section_scene;
extern const dl_scene_section dl_section_particle;
extern const dl_scene_section dl_section_columns;
extern const dl_scene_section dl_section_piece;
extern const dl_scene_section dl_section_term;
extern const dl_scene_section dl_section_pair;
extern const dl_scene_section dl_section_walls;
extern const dl_scene_section dl_section_periods;
extern const dl_scene_section dl_section_time;
extern const dl_scene_section dl_section_radiation;

/* The value of the key `radiation`; node NULL: there is none. */
dl_status dl_scene_read_radiation(const dl_yaml *yaml, const dl_yaml_node *node,
                                  dl_radiation *radiation, dl_error *error);

/* Appends the pieces of the list `node` (NULL: none) to the law, which is empty before. */
dl_status dl_scene_read_pair_law(const dl_yaml *yaml, const dl_yaml_node *node, dl_pair_law *law,
                                 dl_error *error);

/* dl_yaml_read_table for a section: its scalars go to `object`, its other keys are let through. */
dl_status dl_scene_read_section(const dl_yaml *yaml, const dl_yaml_node *map,
                                const dl_scene_section *section, void *object, dl_error *error);

#endif
