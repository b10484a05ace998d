/* The section `radiation` of a scene file. */
#include <math.h>
#include <stddef.h>
#include <string.h>
#include "driftlab/scene.h"
#include "scene/tables.h"

static const char *const frame_words[] = {
    [DL_FRAME_LAB] = "lab",
    [DL_FRAME_CENTRE] = "centre",
    NULL,
};

typedef struct radiation_values {
    double period, reach, opening, factor_above, factor_below;
    int frame;
} radiation_values;

static const dl_parameter rows[] = {
    {.name = "period",
     .kind = DL_REAL,
     .offset = offsetof(radiation_values, period),
     .unit = "time",
     .maximum = INFINITY,
     .above_minimum = true,
     .doc = "time between jumps, a whole number of steps; the first is one period after the start"},
    {.name = "factor_above",
     .kind = DL_REAL,
     .offset = offsetof(radiation_values, factor_above),
     .unit = "",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "1",
     .doc = "of the velocities of outer particles with y >= that of the mass centre"},
    {.name = "factor_below",
     .kind = DL_REAL,
     .offset = offsetof(radiation_values, factor_below),
     .unit = "",
     .minimum = 0,
     .maximum = INFINITY,
     .fallback = "1",
     .doc = "of the velocities of the other outer particles"},
    {.name = "frame",
     .kind = DL_WORD,
     .offset = offsetof(radiation_values, frame),
     .unit = "",
     .words = frame_words,
     .fallback = "lab",
     .doc = "lab: the velocity itself is multiplied; centre: that relative to the mass centre"},
    {.name = "reach",
     .kind = DL_REAL,
     .offset = offsetof(radiation_values, reach),
     .unit = "length",
     .maximum = INFINITY,
     .above_minimum = true,
     .fallback = "none",
     .doc = "beyond: boundary: how far outward another particle hides one; none: however far"},
    {.name = "opening",
     .kind = DL_REAL,
     .offset = offsetof(radiation_values, opening),
     .unit = "degrees",
     .maximum = 180,
     .above_minimum = true,
     .fallback = "60",
     .doc = "beyond: boundary: full angle of the outward sector in which another hides one"},
};

const dl_scene_section dl_section_radiation = {
    .title = "RADIATION",
    .within = "radiation",
    .doc = "Jumps of the velocities of outer particles, TR299 (3.14), booked in the ledger.",
    .table = {rows, sizeof rows / sizeof *rows},
    .key = {{"beyond", "length or boundary",
             "outer: farther than this from the mass centre; boundary: not hidden from outside"}},
};

static const dl_parameter beyond_row = {
    .name = "beyond",
    .kind = DL_REAL,
    .offset = offsetof(dl_radiation, beyond),
    .unit = "length",
    .maximum = INFINITY,
};

static dl_status read_beyond(const dl_yaml *yaml, const dl_yaml_node *map, dl_radiation *radiation,
                             dl_error *error) {
    static const char expected[] = "a length >= 0, or boundary";
    const dl_yaml_node *const node = dl_yaml_get(map, "beyond");
    if (!node)
        return dl_yaml_missing(yaml, map, "beyond", expected, error);
    if (dl_yaml_kind_of(node) != DL_YAML_SCALAR)
        return dl_yaml_fail(yaml, node, "beyond", expected, error);
    radiation->boundary = strcmp(dl_yaml_text(node), "boundary") == 0;
    if (radiation->boundary || !dl_parameter_set(&beyond_row, radiation, dl_yaml_text(node), NULL))
        return DL_OK;
    return dl_yaml_fail(yaml, node, "beyond", expected, error);
}

/* What tells who is on the boundary has no meaning where a distance does. */
static dl_status check_boundary_keys(const dl_yaml *yaml, const dl_yaml_node *map,
                                     const dl_radiation *radiation, dl_error *error) {
    static const char *const keys[] = {"reach", "opening"};
    for (size_t k = 0; k < sizeof keys / sizeof *keys && !radiation->boundary; k++) {
        const dl_yaml_node *const node = dl_yaml_get(map, keys[k]);
        if (node)
            return dl_yaml_fail(yaml, node, keys[k], "none: only beyond: boundary has one", error);
    }
    return DL_OK;
}

dl_status dl_scene_read_radiation(const dl_yaml *yaml, const dl_yaml_node *node,
                                  dl_radiation *radiation, dl_error *error) {
    if (!node)
        return DL_OK;
    radiation_values values = {0};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_radiation, &values, error);
    if (!status)
        status = read_beyond(yaml, node, radiation, error);
    if (!status)
        status = check_boundary_keys(yaml, node, radiation, error);
    radiation->present = true;
    radiation->period = values.period;
    radiation->reach = values.reach;
    radiation->opening = values.opening;
    radiation->factor_above = values.factor_above;
    radiation->factor_below = values.factor_below;
    radiation->frame = (dl_radiation_frame)values.frame;
    return status;
}
