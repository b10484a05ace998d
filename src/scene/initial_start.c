/* A scene that begins where another run was: what its trajectory holds, less what is removed. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "driftlab/trajectory.h"
#include "scene/initial.h"

/* While particles are chosen. */
typedef struct survivors {
    const dl_trajectory_frame *frame;
    size_t height; /* the component that says how high a particle is */
    bool *removed; /* [particles] */
} survivors;

static double height_of(const survivors *s, size_t i) {
    return s->frame->position[s->height * s->frame->particles + i];
}

static double speed_of(const survivors *s, size_t i) {
    const size_t n = s->frame->particles;
    double square = 0;
    for (size_t k = i; k < 3 * n; k += n)
        square += s->frame->velocity[k] * s->frame->velocity[k];
    return sqrt(square);
}

static size_t count_left(const survivors *s) {
    size_t left = 0;
    for (size_t i = 0; i < s->frame->particles; i++)
        left += !s->removed[i];
    return left;
}

/* --- removal ---------------------------------------------------------------------------------- */

static dl_status remove_rows(const dl_yaml *yaml, const dl_yaml_node *node, survivors *s,
                             dl_error *error) {
    if (!node)
        return DL_OK;
    size_t count;
    long *row;
    const dl_status status =
        dl_initial_read_counts(yaml, node, "rows", (long)s->frame->particles, &count, &row, error);
    for (size_t i = 0; i < count && !status; i++)
        s->removed[row[i] - 1] = true;
    free(row);
    return status;
}

/* The `wanted` particles of largest value among those left, the first of equal ones first. */
static dl_status remove_largest(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                                long wanted, double (*value)(const survivors *, size_t),
                                survivors *s, dl_error *error) {
    const size_t left = count_left(s), n = s->frame->particles;
    if ((size_t)wanted > left) {
        char expected[64];
        snprintf(expected, sizeof expected, "at most %zu, the particles that are left", left);
        return dl_yaml_fail(yaml, dl_yaml_get(node, key), key, expected, error);
    }
    for (long k = 0; k < wanted; k++) {
        size_t largest = n;
        for (size_t i = 0; i < n; i++)
            if (!s->removed[i] && (largest == n || value(s, i) > value(s, largest)))
                largest = i;
        s->removed[largest] = true;
    }
    return DL_OK;
}

static dl_status remove_particles(const dl_yaml *yaml, const dl_yaml_node *node, survivors *s,
                                  dl_error *error) {
    dl_remove_values values = {0};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_remove, &values, error);
    if (!status)
        status = remove_rows(yaml, dl_yaml_get(node, "rows"), s, error);
    for (size_t i = 0; i < s->frame->particles && !status; i++)
        s->removed[i] = s->removed[i] || height_of(s, i) > values.above;
    if (!status)
        status = remove_largest(yaml, node, "highest", values.highest, height_of, s, error);
    if (!status)
        status = remove_largest(yaml, node, "fastest", values.fastest, speed_of, s, error);
    return status;
}

/* --- what is left ----------------------------------------------------------------------------- */

static dl_status keep(const survivors *s, size_t i, const char *path, dl_particles *particles,
                      dl_error *error) {
    const dl_trajectory_frame *const frame = s->frame;
    const size_t n = frame->particles;
    dl_scene_row row = {
        .attributes = {.mass = frame->inertia[i],
                       .inertia = INFINITY,
                       .coupling = frame->coupling ? frame->coupling[i] : INFINITY,
                       .pinned = frame->pinned && frame->pinned[i],
                       .species = frame->species ? frame->species[i] : NULL,
                       .gravity = !frame->feels_gravity || frame->feels_gravity[i]}};
    for (size_t axis = 0; axis < 3; axis++) {
        row.position[axis] = frame->position[axis * n + i];
        row.velocity[axis] = frame->velocity[axis * n + i];
    }
    if (particles->dimension == 2 && (row.position[2] != 0 || row.velocity[2] != 0))
        return dl_fail(error, DL_INPUT,
                       "%s: particle %zu: found a third component other than 0, expected 0 for a "
                       "scene in two dimensions",
                       path, i + 1);
    return dl_particles_add(particles, &row, path, (int)(i + 1), error);
}

static dl_status choose(const dl_yaml *yaml, const dl_yaml_node *start,
                        const dl_trajectory_frame *frame, const char *path, dl_particles *particles,
                        dl_error *error) {
    survivors s = {.frame = frame, .height = (size_t)particles->dimension - 1};
    s.removed = calloc(frame->particles, sizeof *s.removed);
    if (!s.removed)
        return dl_fail_memory(error, path);
    const dl_yaml_node *const node = dl_yaml_get(start, "remove");
    dl_status status = node ? remove_particles(yaml, node, &s, error) : DL_OK;
    for (size_t i = 0; i < frame->particles && !status; i++)
        if (!s.removed[i])
            status = keep(&s, i, path, particles, error);
    free(s.removed);
    return status;
}

/* --- the file --------------------------------------------------------------------------------- */

static dl_status read_frame_number(const dl_yaml *yaml, const dl_yaml_node *start, const char *text,
                                   size_t *frame, dl_error *error) {
    const dl_parameter row = {.name = "frame", .kind = DL_INTEGER, .maximum = 1e15};
    long number = 0;
    *frame = SIZE_MAX;
    if (strcmp(text, "last") == 0)
        return DL_OK;
    if (dl_parameter_set(&row, &number, text, NULL))
        return dl_yaml_fail(yaml, dl_yaml_get(start, "frame"), "frame",
                            "last or a whole number >= 0", error);
    *frame = (size_t)number;
    return DL_OK;
}

/* Where the file is not there, the scene may know who makes it. */
static dl_status cannot_read(const dl_yaml *yaml, const dl_yaml_node *start, const char *path,
                             const char *made_by, const char *reason, dl_error *error) {
    const bool hint = made_by[0] && access(path, F_OK) != 0;
    return dl_fail(error, DL_INPUT, "%s:%d: from: %.500s%s%.300s", dl_yaml_path(yaml),
                   dl_yaml_line(dl_yaml_get(start, "from")), reason,
                   hint ? "; it is made by: " : "", hint ? made_by : "");
}

static dl_status read_start(const dl_yaml *yaml, const dl_yaml_node *start,
                            const dl_start_values *values, dl_particles *particles,
                            dl_error *error) {
    const char *path;
    size_t number;
    dl_trajectory_frame frame;
    dl_error reason;
    dl_status status = read_frame_number(yaml, start, values->frame, &number, error);
    if (!status)
        status = dl_particles_keep_path(particles, dl_yaml_path(yaml), values->from, &path, error);
    if (status)
        return status;
    status = dl_trajectory_read_frame(path, number, &frame, &reason);
    if (status == DL_INPUT)
        return cannot_read(yaml, start, path, values->made_by, reason.message, error);
    if (status)
        return dl_fail(error, status, "%s", reason.message);
    if (frame.inertia)
        status = choose(yaml, start, &frame, path, particles, error);
    else
        status = dl_fail(error, DL_INPUT,
                         "%s:%d: from: found no mass of the particles in %s, expected a trajectory "
                         "with masses",
                         dl_yaml_path(yaml), dl_yaml_line(dl_yaml_get(start, "from")), path);
    dl_trajectory_frame_free(&frame);
    return status;
}

dl_status dl_initial_start(const dl_yaml *yaml, const dl_yaml_node *start, dl_particles *particles,
                           dl_error *error) {
    dl_start_values values = {0};
    dl_status status = dl_scene_read_section(yaml, start, &dl_section_start, &values, error);
    if (!status)
        status = read_start(yaml, start, &values, particles, error);
    dl_parameter_release(dl_section_start.table, &values);
    return status;
}

dl_status dl_initial_resume(const char *path, dl_particles *particles, dl_error *error) {
    dl_trajectory_frame frame;
    dl_status status = dl_trajectory_read_frame(path, 0, &frame, error);
    if (status)
        return status;
    const survivors all = {.frame = &frame};
    if (!frame.inertia)
        status = dl_fail(error, DL_INPUT, "%s: found no mass of the particles, expected one", path);
    for (size_t i = 0; i < frame.particles && !status; i++)
        status = keep(&all, i, path, particles, error);
    dl_trajectory_frame_free(&frame);
    return status;
}
