/* Random positions by rejection: each particle draws from a stream of its own until it is far
 * enough from all that are there. */
#include <math.h>
#include <stdio.h>
#include "scene/initial.h"
#include "scene/spacing.h"

typedef struct box {
    double low[3], high[3];
} box;

static dl_status read_box(const dl_initial *initial, const dl_yaml_node *node, box *b,
                          dl_error *error) {
    const dl_yaml *const yaml = initial->yaml;
    const size_t dimension = (size_t)initial->particles->dimension;
    const dl_yaml_node *const in = dl_yaml_get(node, "in");
    const char *const expected =
        dimension == 2 ? "[[x0, x1], [y0, y1]]" : "[[x0, x1], [y0, y1], [z0, z1]]";
    if (!in)
        return dl_yaml_missing(yaml, node, "in", expected, error);
    if (dl_yaml_kind_of(in) != DL_YAML_LIST || dl_yaml_length(in) != dimension)
        return dl_yaml_fail(yaml, in, "in", expected, error);
    for (size_t axis = 0; axis < dimension; axis++) {
        double ends[2];
        const dl_status status =
            dl_yaml_reals(yaml, dl_yaml_item(in, axis), "in", 2, NAN, ends, error);
        if (status)
            return status;
        if (!(ends[0] < ends[1]))
            return dl_fail(error, DL_INPUT, "%s:%d: in: found [%g, %g], expected low < high",
                           dl_yaml_path(yaml), dl_yaml_line(dl_yaml_item(in, axis)), ends[0],
                           ends[1]);
        b->low[axis] = ends[0];
        b->high[axis] = ends[1];
    }
    return DL_OK;
}

static dl_status too_dense(const dl_initial *initial, const dl_yaml_node *node,
                           const dl_random_values *values, long placed, dl_error *error) {
    char distance[40];
    dl_format_real(values->minimum_distance, distance, sizeof distance);
    return dl_fail(error, DL_INPUT,
                   "%s:%d: random: found no place for particle %ld of %ld in %ld tries, expected a "
                   "larger box or a minimum_distance below %s",
                   dl_yaml_path(initial->yaml), dl_yaml_line(node), placed + 1, values->count,
                   values->tries, distance);
}

static dl_status place_one(dl_initial *initial, const box *b, const dl_random_values *values,
                           dl_spacing *spacing, bool *placed, dl_error *error) {
    dl_particles *const particles = initial->particles;
    dl_random_begin(initial->random, particles->count - initial->first, DL_RANDOM_POSITION);
    for (long i = 0; i < values->tries; i++) {
        double position[3] = {0};
        for (int axis = 0; axis < particles->dimension; axis++)
            position[axis] = dl_random_uniform(initial->random, b->low[axis], b->high[axis]);
        if (!dl_spacing_allows(spacing, position))
            continue;
        *placed = true;
        const dl_status status = dl_initial_add(initial, position, error);
        if (!status)
            dl_spacing_add(spacing, particles->count - 1);
        return status;
    }
    *placed = false;
    return DL_OK;
}

static dl_status place_all(dl_initial *initial, const dl_yaml_node *node, const box *b,
                           const dl_random_values *values, dl_error *error) {
    dl_spacing spacing;
    dl_status status =
        dl_spacing_create(initial->particles, values->minimum_distance,
                          initial->particles->count + (size_t)values->count, &spacing, error);
    for (long i = 0; i < values->count && !status; i++) {
        bool placed;
        status = place_one(initial, b, values, &spacing, &placed, error);
        if (!status && !placed)
            status = too_dense(initial, node, values, i, error);
    }
    dl_spacing_free(&spacing);
    return status;
}

dl_status dl_initial_place_random(dl_initial *initial, dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(initial->node, "random");
    dl_random_values values = {0};
    box b = {0};
    dl_status status =
        dl_scene_read_section(initial->yaml, node, &dl_section_random, &values, error);
    if (!status)
        status = read_box(initial, node, &b, error);
    return status ? status : place_all(initial, node, &b, &values, error);
}
