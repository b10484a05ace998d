#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "scene/csv.h"
#include "scene/draft.h"
#include "scene/initial.h"
#include "scene/species.h"
#include "scene/tables.h"

enum { most_columns = 16 };

static const char axis_names[] = "xyz";

/* --- one particle ----------------------------------------------------------------------------- */

dl_status dl_particles_add(dl_particles *particles, const dl_scene_row *row, const char *file,
                           int line, dl_error *error) {
    const dl_scene_attributes *const own = &row->attributes;
    int species;
    const dl_status status = dl_species_find(particles, own->species, file, line, &species, error);
    if (status)
        return status;
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
        .species = species,
        .pinned = own->pinned,
        .gravity = own->gravity,
        .file = file,
        .line = line,
    };
    memcpy(particle->position, row->position, sizeof row->position);
    memcpy(particle->velocity, row->velocity, sizeof row->velocity);
    return DL_OK;
}

static dl_status place_single(dl_initial *initial, dl_error *error) {
    const dl_yaml_node *const at = dl_yaml_get(initial->node, "at");
    double position[3] = {0};
    const dl_status status = dl_yaml_reals(
        initial->yaml, at, "at", (size_t)initial->particles->dimension, NAN, position, error);
    return status ? status : dl_initial_add(initial, position, error);
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
                       "inertia, coupling, species, pinned, gravity%s%s%s",
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
        row.attributes.species = strdup(item->attributes.species); /* a column may replace it */
        status = row.attributes.species ? read_row(csv, &columns, &row, error)
                                        : dl_fail_memory(error, "a species");
        if (!status)
            status = dl_particles_add(particles, &row, csv->path, csv->line, error);
        dl_parameter_release(dl_section_columns.table, &row);
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

dl_status dl_particles_keep_path(dl_particles *particles, const char *scene_path, const char *name,
                                 const char **path, dl_error *error) {
    char **const file = realloc(particles->file, (particles->files + 1) * sizeof *file);
    if (!file)
        return dl_fail_memory(error, "paths of data files");
    particles->file = file;
    file[particles->files] = beside(scene_path, name);
    if (!file[particles->files])
        return dl_fail_memory(error, name);
    *path = file[particles->files++];
    return DL_OK;
}

static dl_status place_file(dl_initial *initial, dl_error *error) {
    static const char *const given[] = {"at", "velocity", "lattice", "random"};
    const dl_yaml *const yaml = initial->yaml;
    const dl_yaml_node *const node = initial->node;
    const char *path;
    for (size_t i = 0; i < sizeof given / sizeof *given; i++)
        if (dl_yaml_get(node, given[i]))
            return dl_yaml_fail(yaml, dl_yaml_get(node, given[i]), given[i],
                                "none beside a file, whose columns give it", error);
    dl_status status = dl_particles_keep_path(initial->particles, dl_yaml_path(yaml),
                                              initial->item->file, &path, error);
    if (status)
        return status;
    dl_csv csv;
    dl_error reason;
    status = dl_csv_open(path, &csv, &reason);
    if (status)
        return dl_fail(error, status, "%s:%d: file: %.900s, expected a data file",
                       dl_yaml_path(yaml), dl_yaml_line(dl_yaml_get(node, "file")), reason.message);
    status = read_rows(&csv, initial->item, initial->particles, error);
    dl_csv_close(&csv);
    return status;
}

/* --- the list --------------------------------------------------------------------------------- */

typedef dl_status placement(dl_initial *initial, dl_error *error);

static const struct {
    const char *key;
    placement *place;
} placements[] = {
    {"file", place_file},
    {"at", place_single},
    {"lattice", dl_initial_place_lattice},
    {"random", dl_initial_place_random},
};

static dl_status place(dl_initial *initial, dl_error *error) {
    placement *chosen = NULL;
    for (size_t i = 0; i < sizeof placements / sizeof *placements; i++) {
        const dl_yaml_node *const node = dl_yaml_get(initial->node, placements[i].key);
        /* a file says itself what it does not go with */
        if (node && chosen && chosen != place_file)
            return dl_yaml_fail(initial->yaml, node, placements[i].key,
                                "one of at, file, lattice and random", error);
        if (node && !chosen)
            chosen = placements[i].place;
    }
    if (!chosen)
        return dl_yaml_missing(initial->yaml, initial->node, "at",
                               "a position, a file of particles, a lattice or random", error);
    return chosen(initial, error);
}

static dl_status check_pinned(const dl_particle *particle, int dimension, dl_error *error) {
    for (int axis = 0; axis < dimension && particle->pinned; axis++)
        if (particle->velocity[axis] != 0)
            return dl_fail(error, DL_INPUT,
                           "%s:%d: velocity: found %g along %c, expected 0 for a pinned particle",
                           particle->file, particle->line, particle->velocity[axis],
                           axis_names[axis]);
    return DL_OK;
}

static dl_status carry_out(dl_initial *initial, dl_error *error) {
    const dl_particles *const particles = initial->particles;
    dl_status status = place(initial, error);
    if (!status)
        status = dl_initial_set_masses(initial, error);
    if (!status)
        status = dl_initial_set_motion(initial, error);
    for (size_t i = initial->first; i < particles->count && !status; i++)
        status = check_pinned(&particles->particle[i], particles->dimension, error);
    return status;
}

/* `place_in_list` counts from 1: 0 is for items with a seed of their own. */
static dl_status read_item(const dl_yaml *yaml, const dl_yaml_node *node, size_t place_in_list,
                           dl_particles *particles, dl_error *error) {
    dl_scene_item item = {0};
    dl_initial initial = {.yaml = yaml,
                          .node = node,
                          .item = &item,
                          .particles = particles,
                          .first = particles->count};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_particle, &item, error);
    if (!status) {
        const bool own = item.seed >= 0;
        status = dl_random_create(own ? (uint64_t)item.seed : particles->seed,
                                  own ? 0 : place_in_list, &initial.random, error);
    }
    if (!status)
        status = carry_out(&initial, error);
    dl_random_free(initial.random);
    dl_parameter_release(dl_section_particle.table, &item);
    return status;
}

dl_status dl_particles_read(const dl_yaml *yaml, const dl_yaml_node *node, dl_particles *particles,
                            dl_error *error) {
    if (dl_yaml_kind_of(node) != DL_YAML_LIST || dl_yaml_length(node) == 0)
        return dl_yaml_fail(yaml, node, "particles", "a list of at least one particle", error);
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_length(node) && !status; i++)
        status = read_item(yaml, dl_yaml_item(node, i), i + 1, particles, error);
    return status;
}

void dl_particles_free(dl_particles *particles) {
    for (size_t i = 0; i < particles->files; i++)
        free(particles->file[i]);
    free(particles->file);
    free(particles->particle);
}
