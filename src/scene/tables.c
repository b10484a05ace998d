#include "scene/tables.h"

#include <math.h>
#include <stddef.h>
#include "driftlab/scene.h"

#define TABLE(rows)                                                                                \
    { (rows), sizeof(rows) / sizeof *(rows) }

static const char *const kernel_words[] = {
    [DL_KERNEL_AUTO] = "auto",           [DL_KERNEL_REFERENCE] = "reference",
    [DL_KERNEL_ALL_PAIRS] = "all-pairs", [DL_KERNEL_NEIGHBOUR_LIST] = "neighbour-list",
    [DL_KERNEL_TREE] = "tree",           NULL,
};

static const char *const piece_end_words[] = {
    [DL_END_HARD] = "hard",
    [DL_END_SHIFTED_FORCE] = "shifted-force",
    [DL_END_TAPER] = "taper",
    NULL,
};

static const char *const part_words[] = {
    [DL_PART_FAST] = "fast",
    [DL_PART_SLOW] = "slow",
    NULL,
};

static const char *const wall_rule_words[] = {
    [DL_MIRROR] = "mirror",
    [DL_LOCATED] = "located",
    NULL,
};

static const dl_parameter scene_rows[] = {
    {.name = "name",
     .kind = DL_TEXT,
     .offset = offsetof(dl_scene_header, name),
     .unit = "",
     .doc = "short name, in results and reports"},
    {.name = "source",
     .kind = DL_TEXT,
     .offset = offsetof(dl_scene_header, source),
     .unit = "",
     .fallback = "",
     .doc = "where the scene comes from: report, section, figure"},
    {.name = "dimension",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_scene_header, dimension),
     .unit = "",
     .minimum = 2,
     .maximum = 3,
     .doc = "number of space dimensions, 2 or 3"},
    {.name = "kernel",
     .kind = DL_WORD,
     .offset = offsetof(dl_scene_header, kernel),
     .unit = "",
     .words = kernel_words,
     .fallback = "auto",
     .doc = "how pair forces are summed; auto: by the size of the scene and the reach of its law"},
    {.name = "skin",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_header, skin),
     .unit = "length",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "margin of the neighbour list beyond the reach of the law; 0: chosen"},
    {.name = "tree_error",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_header, tree_error),
     .unit = "",
     .minimum = 1e-12,
     .maximum = 0.1,
     .fallback = "1e-6",
     .doc = "stated error of the tree's forces, in parts of the sum of the moduli of a particle's "
            "pair forces"},
    {.name = "seed",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_scene_header, seed),
     .unit = "",
     .minimum = 0,
     .maximum = 4294967295,
     .fallback = "0",
     .doc = "of the random numbers of initial states, which are a stream for each particle"},
};

const dl_scene_section dl_section_scene = {
    .title = "scene",
    .within = "scene",
    .doc = "The top of the file.",
    .table = TABLE(scene_rows),
    .key = {{"let", "{NAME: NUMBER, ...}",
             "numbers by name; a value without quotes may be $NAME, or a product or quotient such "
             "as -2*$NAME/$OTHER; --let NAME=NUMBER sets another"},
            {"particles", "[PARTICLE, ...]", "particles, in the order of the results"},
            {"start", "START", "particles from another run, before those; absent: none"},
            {"pair_law", "[PIECE, ...]", "radial pieces of the pair force; absent: no pair force"},
            {"pair_laws", "[PAIR, ...]", "laws by species, in the place of pair_law"},
            {"gravity", "[gx, gy] or [gx, gy, gz]", "uniform acceleration; absent: none"},
            {"walls", "WALLS", "planes that turn particles back; absent: none"},
            {"periodic", "PERIODIC", "axes along which the scene repeats itself; absent: none"},
            {"radiation", "RADIATION", "scheduled jumps of outer velocities; absent: none"},
            {"time", "TIME", "required: step, end and sampling"}},
};

/* The attributes of a particle stand in items and in columns under the same names. */
#define ATTRIBUTE_ROWS(type)                                                                       \
    {.name = "mass",                                                                               \
     .kind = DL_REAL,                                                                              \
     .offset = offsetof(type, attributes.mass),                                                    \
     .unit = "mass",                                                                               \
     .maximum = INFINITY,                                                                          \
     .above_minimum = true,                                                                        \
     .fallback = "1",                                                                              \
     .doc = "inertia and coupling both, where they are not given apart"},                          \
        {.name = "inertia",                                                                        \
         .kind = DL_REAL,                                                                          \
         .offset = offsetof(type, attributes.inertia),                                             \
         .unit = "mass",                                                                           \
         .maximum = INFINITY,                                                                      \
         .above_minimum = true,                                                                    \
         .fallback = "none",                                                                       \
         .doc = "force divided by acceleration; none: the mass"},                                  \
        {.name = "coupling",                                                                       \
         .kind = DL_REAL,                                                                          \
         .offset = offsetof(type, attributes.coupling),                                            \
         .unit = "mass",                                                                           \
         .maximum = INFINITY,                                                                      \
         .fallback = "none",                                                                       \
         .doc = "factor of the particle in its pair forces; none: the mass"},                      \
        {.name = "species",                                                                        \
         .kind = DL_TEXT,                                                                          \
         .offset = offsetof(type, attributes.species),                                             \
         .unit = "",                                                                               \
         .fallback = "",                                                                           \
         .doc = "name by which pair_laws tells the particle's forces"},                            \
        {.name = "pinned",                                                                         \
         .kind = DL_FLAG,                                                                          \
         .offset = offsetof(type, attributes.pinned),                                              \
         .unit = "",                                                                               \
         .fallback = "false",                                                                      \
         .doc = "acts on others and never moves"},                                                 \
    {                                                                                              \
        .name = "gravity", .kind = DL_FLAG, .offset = offsetof(type, attributes.gravity),          \
        .unit = "", .fallback = "true", .doc = "feels the scene's gravity"                         \
    }

static const dl_parameter particle_rows[] = {
    {.name = "file",
     .kind = DL_TEXT,
     .offset = offsetof(dl_scene_item, file),
     .unit = "",
     .fallback = "",
     .doc = "data file (CSV), relative to the scene's folder; instead of at"},
    ATTRIBUTE_ROWS(dl_scene_item),
    {.name = "speed",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_item, speed),
     .unit = "length/time",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "a velocity of this size in a random direction"},
    {.name = "temperature",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_item, temperature),
     .unit = "energy",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "normal velocity components of variance temperature/inertia"},
    {.name = "drift",
     .kind = DL_FLAG,
     .offset = offsetof(dl_scene_item, drift),
     .unit = "",
     .fallback = "true",
     .doc = "false: the mean of those two is taken off, so that they carry no momentum"},
    {.name = "seed",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_scene_item, seed),
     .unit = "",
     .minimum = -1,
     .maximum = 4294967295,
     .fallback = "-1",
     .doc = "of the item's random numbers; -1: from the scene's and the item's place in the list"},
};

const dl_scene_section dl_section_particle = {
    .title = "PARTICLE",
    .within = "particles",
    .doc = "One particle (at), or as many as a data file has rows (file), or as a rule makes "
           "(lattice,\n"
           "random). Velocities given in several ways add up.",
    .table = TABLE(particle_rows),
    .key = {{"at", "[x, y] or [x, y, z]", "position of a single particle"},
            {"lattice", "LATTICE", "particles on a lattice"},
            {"random", "RANDOM", "particles at random positions"},
            {"masses", "[[mass, count], ...]",
             "so many of each, dealt out at random; not with a file"},
            {"exchange", "EXCHANGE", "heavy particles at the rim change places with light ones"},
            {"velocity", "[vx, vy] or [vx, vy, vz]",
             "of every particle; not with a file; absent: 0"},
            {"rotation", "ROTATION", "velocities of a rotation"},
            {"perturb", "PERTURB", "random changes of the velocity"}},
};

#define COLUMN(column, member, dimension_of_it, default_text, text)                                \
    {                                                                                              \
        .name = column, .kind = DL_REAL, .offset = offsetof(dl_scene_row, member),                 \
        .unit = dimension_of_it, .minimum = -INFINITY, .maximum = INFINITY,                        \
        .fallback = default_text, .doc = text                                                      \
    }
#define VELOCITY "velocity: a column for each dimension, or for none"

static const dl_parameter column_rows[] = {
    COLUMN("x", position[0], "length", NULL, "position"),
    COLUMN("y", position[1], "length", NULL, "position"),
    COLUMN("z", position[2], "length", NULL, "position, in three dimensions"),
    COLUMN("vx", velocity[0], "length/time", "0", VELOCITY),
    COLUMN("vy", velocity[1], "length/time", "0", VELOCITY),
    COLUMN("vz", velocity[2], "length/time", "0", VELOCITY),
    ATTRIBUTE_ROWS(dl_scene_row),
    {.name = "m",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_row, attributes.mass),
     .unit = "mass",
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "1",
     .doc = "the same as mass"},
};

const dl_scene_section dl_section_columns = {
    .title = "columns of a data file",
    .within = "file",
    .doc = "First line: names. Values of a row come before those of the item that names the file.\n"
           "Lines that start with # are comments.",
    .table = TABLE(column_rows),
};

static const dl_parameter piece_rows[] = {
    {.name = "until",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_piece_values, until),
     .unit = "length",
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "none",
     .doc = "distance at which the piece ends; none: it does not"},
    {.name = "end",
     .kind = DL_WORD,
     .offset = offsetof(dl_scene_piece_values, end),
     .unit = "",
     .words = piece_end_words,
     .fallback = "hard",
     .doc = "there the force jumps, is shifted to be continuous, or is tapered to be C2"},
    {.name = "width",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_piece_values, width),
     .unit = "length",
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "none",
     .doc = "of the taper before the piece's end, less than the piece is long"},
    {.name = "located",
     .kind = DL_FLAG,
     .offset = offsetof(dl_scene_piece_values, located),
     .unit = "",
     .fallback = "false",
     .doc =
         "true: a step in which a pair crosses the piece's end, hard or shifted, is cut short at "
         "that time, so that no step has a jump in it and methods keep their order"},
};

const dl_scene_section dl_section_piece = {
    .title = "PIECE",
    .within = "pair_law",
    .doc = "The force between two particles, positive where it repels, is the product of their\n"
           "couplings and the sum of coefficient * r^(-power); beyond the last piece it is 0.",
    .table = TABLE(piece_rows),
    .key = {{"terms", "[TERM, ...]", "powers of the distance that the piece is the sum of"}},
};

static const dl_parameter term_rows[] = {
    {.name = "coefficient",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_term_values, term.coefficient),
     .unit = "force length^power / mass^2",
     .minimum = -INFINITY,
     .maximum = INFINITY,
     .doc = "positive repels, negative attracts"},
    {.name = "power",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_term_values, term.power),
     .unit = "",
     .minimum = 0,
     .maximum = 64,
     .above_minimum = true,
     .doc = "any real one, of 1/r"},
    {.name = "part",
     .kind = DL_WORD,
     .offset = offsetof(dl_scene_term_values, part),
     .unit = "",
     .words = part_words,
     .fallback = "fast",
     .doc = "for methods that split the force (driftlab list methods); gravity is slow"},
};

const dl_scene_section dl_section_term = {
    .title = "TERM",
    .within = "terms",
    .doc = "One power of the distance.",
    .table = TABLE(term_rows),
};

const dl_scene_section dl_section_pair = {
    .title = "PAIR",
    .within = "pair_laws",
    .doc = "The law between two species, or within one. Every pair of the species that are named "
           "must\n"
           "have one.",
    .key = {{"between", "[SPECIES, SPECIES]", "which two"},
            {"pieces", "[PIECE, ...]", "as in pair_law, or none for no force"}},
};

static const dl_parameter wall_rows[] = {
    {.name = "damping",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_wall_values, damping),
     .unit = "",
     .minimum = 0,
     .maximum = 1,
     .fallback = "0",
     .doc = "d: a hit multiplies every velocity component by 1 - d"},
    {.name = "zero_vx_below",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_wall_values, zero_vx_below),
     .unit = "length/time",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "after a hit, |vx| below this becomes 0"},
    {.name = "rule",
     .kind = DL_WORD,
     .offset = offsetof(dl_scene_wall_values, rule),
     .unit = "",
     .words = wall_rule_words,
     .fallback = "mirror",
     .doc = "mirror: after a step, positions outside are reflected and the normal velocity turned; "
            "located: the hit time is found and the velocity turned there"},
    {.name = "rest",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_wall_values, rest),
     .unit = "",
     .minimum = 0,
     .maximum = 1,
     .fallback = "1e-9",
     .doc =
         "located, with damping: a bounce that would last less than this part of the time step "
         "is the last; the particle rests until the force ends or turns away from the wall. How "
         "many hits come before depends on the step and, with multistep methods, on atol. 0: not "
         "before a bounce that roundoff ends"},
};

const dl_scene_section dl_section_walls = {
    .title = "WALLS",
    .within = "walls",
    .doc =
        "Planes normal to the axes; none in the place of one that is not there. Two rules: "
        "mirror,\n"
        "the papers', and located, which finds the time of a hit and lets particles come to rest.",
    .table = TABLE(wall_rows),
    .key = {{"x", "[low, high]", "where x is kept"},
            {"y", "[low, high]", "where y is kept"},
            {"z", "[low, high]", "where z is kept, in three dimensions"}},
};

const dl_scene_section dl_section_periods = {
    .title = "PERIODIC",
    .within = "periodic",
    .doc =
        "Axes along which every particle has copies at whole numbers of periods and acts by the\n"
        "nearest one; the pair law's cutoff is at most half a period. Initial positions outside "
        "are\n"
        "moved by whole periods; trajectories are not.",
    .key = {{"x", "[low, high]", "one period of x"},
            {"y", "[low, high]", "one period of y"},
            {"z", "[low, high]", "one period of z, in three dimensions"}},
};

static const dl_parameter time_rows[] = {
    {.name = "step",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_times, step),
     .unit = "time",
     .maximum = INFINITY,
     .above_minimum = true,
     .doc = "the step of fixed-step methods where a run does not set one"},
    {.name = "end",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_times, end),
     .unit = "time",
     .maximum = INFINITY,
     .above_minimum = true,
     .doc = "end of the integration that starts at 0; a whole number of steps"},
    {.name = "sample",
     .kind = DL_REAL,
     .offset = offsetof(dl_scene_times, sample),
     .unit = "time",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "time between samples, a whole number of steps; 0: chosen"},
};

const dl_scene_section dl_section_time = {
    .title = "TIME",
    .within = "time",
    .doc = "Start and end are always sampled.",
    .table = TABLE(time_rows),
};

dl_status dl_scene_read_section(const dl_yaml *yaml, const dl_yaml_node *map,
                                const dl_scene_section *section, void *object, dl_error *error) {
    if (dl_yaml_kind_of(map) != DL_YAML_MAP)
        return dl_yaml_fail(yaml, map, section->within, "a mapping of keys to values", error);
    const char *others[dl_scene_section_keys + 1] = {NULL};
    for (size_t i = 0; section->key[i].name; i++)
        others[i] = section->key[i].name;
    return dl_yaml_read_table(yaml, map, section->table, others, object, error);
}
