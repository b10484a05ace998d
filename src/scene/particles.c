#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "scene/csv.h"
#include "scene/draft.h"
#include "scene/tables.h"

enum { most_columns = 16 };

static const char axis_names[] = "xyz";

/* --- one particle ----------------------------------------------------------------------------- */

static dl_status add(dl_particles *particles, const dl_scene_row *row, const char *file, int line,
                     dl_error *error) {
    const dl_scene_attributes *const own = &row->attributes;
    for (int axis = 0; axis < particles->dimension && own->pinned; axis++)
        if (row->velocity[axis] != 0)
            return dl_fail(error, DL_INPUT,
                           "%s:%d: velocity: found %g along %c, expected 0 for a "
                           "pinned particle",
                           file, line, row->velocity[axis], axis_names[axis]);
    if (particles->count == particles->room) {
        const size_t room = particles->room ? 2 * particles->room : 64;
        dl_particle *const larger = realloc(particles->particle, room * sizeof *larger);
        if (!larger)
            return dl_fail_memory(error, "particles");
        particles->particle = larger;
        particles->room = room;
    }
    dl_particle *const particle = &particles->particle[particles->count++];
    *particle = (dl_particle){
        .inertia = isinf(own->inertia) ? own->mass : own->inertia,
        .coupling = isinf(own->coupling) ? own->mass : own->coupling,
        .pinned = own->pinned,
        .gravity = own->gravity,
        .file = file,
        .line = line,
    };
    memcpy(particle->position, row->position, sizeof row->position);
    memcpy(particle->velocity, row->velocity, sizeof row->velocity);
    return DL_OK;
}

static dl_status read_single(const dl_yaml *yaml, const dl_yaml_node *node,
                             const dl_scene_item *item, dl_particles *particles, dl_error *error) {
    dl_scene_row row = {.attributes = item->attributes};
    const size_t dimension = (size_t)particles->dimension;
    const dl_yaml_node *const at = dl_yaml_get(node, "at");
    const dl_yaml_node *const velocity = dl_yaml_get(node, "velocity");
    if (!at)
        return dl_yaml_missing(yaml, node, "at", "a position, or a file of particles", error);
    dl_status status = dl_yaml_reals(yaml, at, "at", dimension, NAN, row.position, error);
    if (!status && velocity)
        status = dl_yaml_reals(yaml, velocity, "velocity", dimension, NAN, row.velocity, error);
    return status ? status : add(particles, &row, dl_yaml_path(yaml), dl_yaml_line(node), error);
}

/* --- a data file ------------------------------------------------------------------------------ */

/* Which parameter each column holds. */
typedef struct column_list {
    size_t count;
    const dl_parameter *row[most_columns];
} column_list;

static dl_status add_column(const dl_csv *csv, const char *name, column_list *columns,
                            dl_error *error) {
    const dl_parameter *const row = dl_parameter_find(dl_section_columns.table, name);
    char shown[80];
    dl_quote(name, shown, sizeof shown);
    if (!row) {
        const char *const closest = dl_parameter_closest(dl_section_columns.table, name);
        return dl_fail(error, DL_INPUT,
                       "%s:%d: found the column %s, expected x, y, z, vx, vy, vz, mass or m, "
                       "inertia, coupling, pinned, gravity%s%s%s",
                       csv->path, csv->line, shown, closest ? "; did you mean \"" : "",
                       closest ? closest : "", closest ? "\"?" : "");
    }
    for (size_t i = 0; i < columns->count; i++)
        if (columns->row[i]->offset == row->offset)
            return dl_fail(error, DL_INPUT, "%s:%d: found the column %s a second time%s", csv->path,
                           csv->line, shown,
                           columns->row[i] == row ? "" : " (m and mass are the same)");
    columns->row[columns->count++] = row;
    return DL_OK;
}

static bool has_column(const column_list *columns, const char *name) {
    for (size_t i = 0; i < columns->count; i++)
        if (strcmp(columns->row[i]->name, name) == 0)
            return true;
    return false;
}

/* A position whole, a velocity whole or not at all, nothing of a third dimension in two. */
static dl_status check_columns(const dl_csv *csv, const column_list *columns, int dimension,
                               dl_error *error) {
    const bool moves =
        has_column(columns, "vx") || has_column(columns, "vy") || has_column(columns, "vz");
    for (int axis = 0; axis < 3; axis++) {
        const char position[] = {axis_names[axis], '\0'};
        const char velocity[] = {'v', axis_names[axis], '\0'};
        const char *const names[] = {position, velocity};
        for (int i = 0; i < 2; i++) {
            const bool found = has_column(columns, names[i]);
            if (found && axis >= dimension)
                return dl_fail(error, DL_INPUT,
                               "%s:%d: found the column \"%s\", expected none in %d dimensions",
                               csv->path, csv->line, names[i], dimension);
            if (!found && axis < dimension && (i == 0 || moves))
                return dl_fail(error, DL_INPUT, "%s:%d: found no column \"%s\", expected one",
                               csv->path, csv->line, names[i]);
        }
    }
    return DL_OK;
}

static dl_status read_columns(dl_csv *csv, int dimension, column_list *columns, dl_error *error) {
    bool found;
    dl_status status = dl_csv_next(csv, &found, error);
    if (!status && !found)
        status = dl_fail(error, DL_INPUT, "%s:%d: found an empty file, expected names of columns",
                         csv->path, csv->line + 1);
    for (size_t i = 0; !status && i < csv->cells; i++)
        status = add_column(csv, csv->cell[i], columns, error);
    return status ? status : check_columns(csv, columns, dimension, error);
}

static dl_status read_row(const dl_csv *csv, const column_list *columns, dl_scene_row *row,
                          dl_error *error) {
    if (csv->cells != columns->count)
        return dl_fail(error, DL_INPUT, "%s:%d: found %zu values, expected %zu, one a column",
                       csv->path, csv->line, csv->cells, columns->count);
    for (size_t i = 0; i < csv->cells; i++) {
        dl_error reason;
        const dl_status status = dl_parameter_set(columns->row[i], row, csv->cell[i], &reason);
        if (status)
            return dl_fail(error, status, "%s:%d: %.900s", csv->path, csv->line, reason.message);
    }
    return DL_OK;
}

static dl_status read_rows(dl_csv *csv, const dl_scene_item *item, dl_particles *particles,
                           dl_error *error) {
    column_list columns = {0};
    dl_status status = read_columns(csv, particles->dimension, &columns, error);
    const size_t before = particles->count;
    while (!status) {
        bool found;
        dl_scene_row row = {.attributes = item->attributes};
        status = dl_csv_next(csv, &found, error);
        if (status || !found)
            break;
        status = read_row(csv, &columns, &row, error);
        if (!status)
            status = add(particles, &row, csv->path, csv->line, error);
    }
    if (!status && particles->count == before)
        status = dl_fail(error, DL_INPUT, "%s:%d: found no rows, expected one a particle",
                         csv->path, csv->line + 1);
    return status;
}

/* `file` as seen from the folder of `scene_path`; NULL where memory is short. */
static char *beside(const char *scene_path, const char *file) {
    const char *const slash = strrchr(scene_path, '/');
    const size_t folder = slash && file[0] != '/' ? (size_t)(slash - scene_path) + 1 : 0;
    char *const path = malloc(folder + strlen(file) + 1);
    if (path) {
        memcpy(path, scene_path, folder);
        strcpy(path + folder, file);
    }
    return path;
}

static dl_status keep_path(dl_particles *particles, char *path, dl_error *error) {
    char **const file = realloc(particles->file, (particles->files + 1) * sizeof *file);
    if (!file) {
        free(path);
        return dl_fail_memory(error, "paths of data files");
    }
    particles->file = file;
    file[particles->files++] = path;
    return DL_OK;
}

static dl_status read_file(const dl_yaml *yaml, const dl_yaml_node *node, const dl_scene_item *item,
                           dl_particles *particles, dl_error *error) {
    static const char *const single[] = {"at", "velocity"};
    for (size_t i = 0; i < 2; i++)
        if (dl_yaml_get(node, single[i]))
            return dl_yaml_fail(yaml, dl_yaml_get(node, single[i]), single[i],
                                "none beside a file, whose columns give it", error);
    char *const path = beside(dl_yaml_path(yaml), item->file);
    if (!path)
        return dl_fail_memory(error, item->file);
    dl_status status = keep_path(particles, path, error);
    if (status)
        return status;
    dl_csv csv;
    dl_error reason;
    status = dl_csv_open(path, &csv, &reason);
    if (status)
        return dl_fail(error, status, "%s:%d: file: %.900s, expected a data file",
                       dl_yaml_path(yaml), dl_yaml_line(dl_yaml_get(node, "file")), reason.message);
    status = read_rows(&csv, item, particles, error);
    dl_csv_close(&csv);
    return status;
}

/* --- the list --------------------------------------------------------------------------------- */

static dl_status read_item(const dl_yaml *yaml, const dl_yaml_node *node, dl_particles *particles,
                           dl_error *error) {
    dl_scene_item item = {0};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_particle, &item, error);
    if (!status)
        status = (item.file[0] ? read_file : read_single)(yaml, node, &item, particles, error);
    dl_parameter_release(dl_section_particle.table, &item);
    return status;
}

dl_status dl_particles_read(const dl_yaml *yaml, const dl_yaml_node *node, dl_particles *particles,
                            dl_error *error) {
    if (dl_yaml_kind_of(node) != DL_YAML_LIST || dl_yaml_length(node) == 0)
        return dl_yaml_fail(yaml, node, "particles", "a list of at least one particle", error);
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_length(node) && !status; i++)
        status = read_item(yaml, dl_yaml_item(node, i), particles, error);
    return status;
}

void dl_particles_free(dl_particles *particles) {
    for (size_t i = 0; i < particles->files; i++)
        free(particles->file[i]);
    free(particles->file);
    free(particles->particle);
}
