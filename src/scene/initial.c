#include "scene/initial.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

dl_status dl_initial_add(dl_initial *initial, const double position[3], dl_error *error) {
    dl_scene_row row = {.attributes = initial->item->attributes};
    if (initial->particles->count - initial->first >= dl_most_placed)
        return dl_fail(error, DL_INPUT, "%s:%d: found an item of more than %d particles",
                       dl_yaml_path(initial->yaml), dl_yaml_line(initial->node), dl_most_placed);
    memcpy(row.position, position, sizeof row.position);
    return dl_particles_add(initial->particles, &row, dl_yaml_path(initial->yaml),
                            dl_yaml_line(initial->node), error);
}

static dl_status read_count(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                            long most, long *value, dl_error *error) {
    const dl_parameter row = {
        .name = key, .kind = DL_INTEGER, .minimum = 1, .maximum = (double)most};
    char range[96];
    if (dl_yaml_kind_of(node) == DL_YAML_SCALAR &&
        !dl_parameter_set(&row, value, dl_yaml_text(node), NULL))
        return DL_OK;
    dl_parameter_range(&row, range, sizeof range);
    return dl_yaml_fail(yaml, node, key, range, error);
}

dl_status dl_initial_read_counts(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                                 long most, size_t *count, long **values, dl_error *error) {
    *values = NULL;
    *count = 0;
    if (dl_yaml_kind_of(node) != DL_YAML_LIST || dl_yaml_length(node) == 0)
        return dl_yaml_fail(yaml, node, key, "a list of whole numbers", error);
    *values = calloc(dl_yaml_length(node), sizeof **values);
    if (!*values)
        return dl_fail_memory(error, key);
    dl_status status = DL_OK;
    for (; *count < dl_yaml_length(node) && !status; (*count)++)
        status = read_count(yaml, dl_yaml_item(node, *count), key, most, &(*values)[*count], error);
    return status;
}
