/* Periodic boxes: reading them, and what a scene must be like to have one. */
#include "scene/periods.h"

#include <math.h>
#include <stdio.h>
#include "driftlab/parameter.h"
#include "scene/species.h"
#include "scene/tables.h"

static dl_status read_axis(const dl_yaml *yaml, const dl_yaml_node *node, int axis, dl_scene *scene,
                           dl_error *error) {
    const char *const name = dl_section_periods.key[axis].name;
    if (axis >= scene->dimension)
        return dl_yaml_fail(yaml, node, name, "no such period in two dimensions", error);
    double ends[2];
    const dl_status status = dl_yaml_reals(yaml, node, name, 2, NAN, ends, error);
    if (status)
        return status;
    const double length = ends[1] - ends[0];
    if (!(length > 0) || !isfinite(length)) {
        char low[40], high[40];
        dl_format_real(ends[0], low, sizeof low);
        dl_format_real(ends[1], high, sizeof high);
        return dl_fail(error, DL_INPUT, "%s:%d: %s: found [%s, %s], expected low < high",
                       dl_yaml_path(yaml), dl_yaml_line(node), name, low, high);
    }
    scene->periods.low[axis] = ends[0];
    scene->periods.length[axis] = length;
    scene->periods.present = true;
    return DL_OK;
}

/* What does not go with a period along this axis. */
static dl_status check_axis(const dl_yaml *yaml, const dl_yaml_node *node, int axis,
                            const dl_scene *scene, dl_error *error) {
    const char *const name = dl_section_periods.key[axis].name;
    const double reach = dl_scene_reach(scene), length = scene->periods.length[axis];
    const char *expected = NULL;
    if (isfinite(scene->walls.low[axis]) || isfinite(scene->walls.high[axis]))
        expected = "no period along an axis that has walls";
    else if (scene->gravity[axis] != 0)
        expected = "no period along an axis that gravity acts along: the energy of a particle "
                   "would not come back with its place";
    else if (isinf(reach))
        expected = "no period where a pair law never ends (it has no last until): a particle acts "
                   "by its nearest copy, and the others must be out of reach";
    if (expected)
        return dl_fail(error, DL_INPUT, "%s:%d: %s: found a period, expected %s",
                       dl_yaml_path(yaml), dl_yaml_line(node), name, expected);
    if (reach > length / 2) {
        char found[40], least[40], cutoff[40];
        dl_format_real(length, found, sizeof found);
        dl_format_real(2 * reach, least, sizeof least);
        dl_format_real(reach, cutoff, sizeof cutoff);
        return dl_fail(error, DL_INPUT,
                       "%s:%d: %s: found a period of %s, expected at least %s, twice the longest "
                       "cutoff %s: a particle acts by its nearest copy",
                       dl_yaml_path(yaml), dl_yaml_line(node), name, found, least, cutoff);
    }
    return DL_OK;
}

dl_status dl_periods_read(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                          dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(root, "periodic");
    if (!node)
        return DL_OK;
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_periods, NULL, error);
    for (int axis = 0; axis < 3 && !status; axis++) {
        const dl_yaml_node *const ends = dl_yaml_get(node, dl_section_periods.key[axis].name);
        if (ends)
            status = read_axis(yaml, ends, axis, scene, error);
        if (ends && !status)
            status = check_axis(yaml, ends, axis, scene, error);
    }
    if (!status && scene->periods.present && scene->radiation.present)
        status = dl_fail(error, DL_INPUT,
                         "%s:%d: periodic: found a period, expected none beside radiation, whose "
                         "outer particles a periodic box has not",
                         dl_yaml_path(yaml), dl_yaml_line(node));
    return status;
}

void dl_periods_wrap(const dl_periods *periods, dl_particles *particles) {
    for (int axis = 0; axis < particles->dimension && periods->present; axis++) {
        const double low = periods->low[axis], length = periods->length[axis];
        for (size_t i = 0; i < particles->count && length > 0; i++) {
            double *const x = &particles->particle[i].position[axis];
            *x -= length * floor((*x - low) / length);
            if (*x < low || *x >= low + length) /* by rounding */
                *x = low;
        }
    }
}

double dl_periods_key(const dl_periods *periods, int axis, double x) {
    const double places = 1099511627776.0; /* 2^40 to a period */
    const double length = periods->length[axis];
    if (!(length > 0))
        return x;
    const double share = (x - periods->low[axis]) / length;
    const double key = nearbyint((share - floor(share)) * places);
    return key < places ? key : 0;
}
