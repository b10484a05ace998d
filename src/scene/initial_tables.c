/* Keys of initial states by rule. */
#include <math.h>
#include <stddef.h>
#include "scene/initial.h"

#define TABLE(rows)                                                                                \
    { (rows), sizeof(rows) / sizeof *(rows) }

/* --- lattice ---------------------------------------------------------------------------------- */

static const char *const lattice_words[] = {
    [dl_lattice_hexagonal] = "hexagonal",
    [dl_lattice_square] = "square",
    [dl_lattice_simple] = "simple-cubic",
    [dl_lattice_face_centred] = "face-centred-cubic",
    NULL,
};

static const dl_parameter lattice_rows[] = {
    {.name = "kind",
     .kind = DL_WORD,
     .offset = offsetof(dl_lattice_values, kind),
     .unit = "",
     .words = lattice_words,
     .doc = "the first two in two dimensions, the others in three"},
    {.name = "spacing",
     .kind = DL_REAL,
     .offset = offsetof(dl_lattice_values, spacing),
     .unit = "length",
     .maximum = INFINITY,
     .above_minimum = true,
     .doc = "distance of nearest neighbours"},
    {.name = "radius",
     .kind = DL_REAL,
     .offset = offsetof(dl_lattice_values, radius),
     .unit = "length",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "none",
     .doc = "all sites at most this far from the origin, which is one of them"},
    {.name = "angle",
     .kind = DL_REAL,
     .offset = offsetof(dl_lattice_values, angle),
     .unit = "degrees",
     .minimum = -360,
     .maximum = 360,
     .fallback = "0",
     .doc = "from the x axis to the rows, counterclockwise about the origin; two dimensions"},
};

const dl_scene_section dl_section_lattice = {
    .title = "LATTICE",
    .within = "lattice",
    .doc = "Particles on the sites of a lattice, of which one of rows, count and radius is given.\n"
           "Rows lie along x, one above the other.",
    .table = TABLE(lattice_rows),
    .key = {{"rows", "[n1, n2, ...]",
             "hexagonal: particles in each row, centred on the first, or half a spacing right of "
             "that where it is no site"},
            {"count", "[nx, ny] or [nx, ny, nz]",
             "cells along each axis (face-centred: 4 particles each); hexagonal: particles a row, "
             "rows"},
            {"origin", "[x, y] or [x, y, z]", "where the first site is; absent: 0"}},
};

/* --- random ----------------------------------------------------------------------------------- */

static const dl_parameter random_rows[] = {
    {.name = "count",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_random_values, count),
     .unit = "",
     .minimum = 1,
     .maximum = dl_most_placed,
     .doc = "number of particles"},
    {.name = "minimum_distance",
     .kind = DL_REAL,
     .offset = offsetof(dl_random_values, minimum_distance),
     .unit = "length",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "from every particle placed before, of this item or another"},
    {.name = "tries",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_random_values, tries),
     .unit = "",
     .minimum = 1,
     .maximum = 1000000000,
     .fallback = "10000",
     .doc = "positions drawn for one particle before the scene is refused"},
};

const dl_scene_section dl_section_random = {
    .title = "RANDOM",
    .within = "random",
    .doc = "Particles at random positions, one after the other: the first position drawn that is\n"
           "far enough from those before.",
    .table = TABLE(random_rows),
    .key = {{"in", "[[x0, x1], [y0, y1]]",
             "required: the box they lie in; in three dimensions "
             "with [z0, z1]"}},
};

/* --- masses, motion --------------------------------------------------------------------------- */

static const dl_parameter exchange_rows[] = {
    {.name = "pairs",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_exchange_values, pairs),
     .unit = "",
     .minimum = 1,
     .maximum = dl_most_placed,
     .doc = "number of exchanges"},
};

const dl_scene_section dl_section_exchange = {
    .title = "EXCHANGE",
    .within = "exchange",
    .doc =
        "Of the particles heavier than the item's lightest, the n-th farthest from `about` and of\n"
        "the lightest the n-th nearest to it exchange their masses (at equal distances the one\n"
        "listed first comes first). Positions and velocities stay.",
    .table = TABLE(exchange_rows),
    .key = {{"about", "[x, y] or [x, y, z]", "absent: the origin"}},
};

static const dl_parameter rotation_rows[] = {
    {.name = "rate",
     .kind = DL_REAL,
     .offset = offsetof(dl_rotation_values, rate),
     .unit = "1/time",
     .minimum = -INFINITY,
     .maximum = INFINITY,
     .doc = "angular velocity about the z axis through `about`; positive: counterclockwise"},
    {.name = "perturbation",
     .kind = DL_REAL,
     .offset = offsetof(dl_rotation_values, perturbation),
     .unit = "length/time",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "epsilon: each of vx and vy gets + or - epsilon mass/reference_mass, at random"},
    {.name = "reference_mass",
     .kind = DL_REAL,
     .offset = offsetof(dl_rotation_values, reference_mass),
     .unit = "mass",
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "1",
     .doc = "of a particle whose perturbation is epsilon; TR299: 2000"},
};

const dl_scene_section dl_section_rotation = {
    .title = "ROTATION",
    .within = "rotation",
    .doc =
        "TR299 (3.1): vx = -rate y +- epsilon m/m0, vy = rate x +- epsilon m/m0, m the inertia,\n"
        "m0 the reference_mass. The signs by quadrant of the report are those of -y and x.",
    .table = TABLE(rotation_rows),
    .key = {{"about", "[x, y]", "centre of the rotation; absent: the origin"}},
};

static const dl_parameter perturb_rows[] = {
    {.name = "relative",
     .kind = DL_REAL,
     .offset = offsetof(dl_perturb_values, relative),
     .unit = "",
     .maximum = INFINITY,
     .above_minimum = true,
     .doc = "every component gets a random number of at most this times the item's |velocity|"},
    {.name = "normalise",
     .kind = DL_FLAG,
     .offset = offsetof(dl_perturb_values, normalise),
     .unit = "",
     .fallback = "false",
     .doc = "the numbers are scaled so that the largest is the most that is allowed"},
};

const dl_scene_section dl_section_perturb = {
    .title = "PERTURB",
    .within = "perturb",
    .doc = "A perturbation of the item's velocity, in proportion to it: TR171, section 3.",
    .table = TABLE(perturb_rows),
};

/* --- another run ------------------------------------------------------------------------------ */

static const dl_parameter start_rows[] = {
    {.name = "from",
     .kind = DL_TEXT,
     .offset = offsetof(dl_start_values, from),
     .unit = "",
     .doc = "trajectory of a run (H5MD), relative to the scene's folder"},
    {.name = "frame",
     .kind = DL_TEXT,
     .offset = offsetof(dl_start_values, frame),
     .unit = "",
     .fallback = "last",
     .doc = "its last frame, or the number of one, from 0"},
    {.name = "made_by",
     .kind = DL_TEXT,
     .offset = offsetof(dl_start_values, made_by),
     .unit = "",
     .fallback = "",
     .doc = "the command that makes the file, for whoever lacks it"},
};

const dl_scene_section dl_section_start = {
    .title = "START",
    .within = "start",
    .doc = "Particles as another run left them, before those of `particles`; time begins at 0.\n"
           "Inertia, coupling, species, pins and who feels gravity come from the file.",
    .table = TABLE(start_rows),
    .key = {{"remove", "REMOVE", "particles that are taken away; absent: none"}},
};

static const dl_parameter remove_rows[] = {
    {.name = "above",
     .kind = DL_REAL,
     .offset = offsetof(dl_remove_values, above),
     .unit = "length",
     .minimum = -INFINITY,
     .maximum = INFINITY,
     .fallback = "none",
     .doc = "those whose last coordinate (y, or z in three dimensions) is larger"},
    {.name = "highest",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_remove_values, highest),
     .unit = "",
     .minimum = 0,
     .maximum = 1e9,
     .fallback = "0",
     .doc = "so many with the largest last coordinate"},
    {.name = "fastest",
     .kind = DL_INTEGER,
     .offset = offsetof(dl_remove_values, fastest),
     .unit = "",
     .minimum = 0,
     .maximum = 1e9,
     .fallback = "0",
     .doc = "so many with the largest speed"},
};

const dl_scene_section dl_section_remove = {
    .title = "REMOVE",
    .within = "remove",
    .doc = "In this order, each among those that are left: rows, above, highest, fastest.",
    .table = TABLE(remove_rows),
    .key = {{"rows", "[n1, n2, ...]", "particles by their place in the file, from 1"}},
};
