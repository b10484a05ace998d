#include <math.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/scene.h"
#include "driftlab/trajectory.h"
#include "scene/draft.h"
#include "scene/initial.h"
#include "scene/let.h"
#include "scene/periods.h"
#include "scene/species.h"
#include "scene/tables.h"

/* --- pair law --------------------------------------------------------------------------------- */

static dl_status read_terms(const dl_yaml *yaml, const dl_yaml_node *piece_node, dl_piece *piece,
                            dl_error *error) {
    const dl_yaml_node *const list = dl_yaml_get(piece_node, "terms");
    if (!list)
        return dl_yaml_missing(yaml, piece_node, "terms", "a list of coefficients and powers",
                               error);
    const bool is_list = dl_yaml_kind_of(list) == DL_YAML_LIST;
    if (!is_list || dl_yaml_length(list) < 1 || dl_yaml_length(list) > DL_MAX_TERMS) {
        char expected[64];
        snprintf(expected, sizeof expected, "a list of 1 to %d terms", DL_MAX_TERMS);
        return dl_yaml_fail(yaml, list, "terms", expected, error);
    }
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_length(list) && !status; i++) {
        dl_scene_term_values values = {.part = DL_PART_FAST};
        status =
            dl_scene_read_section(yaml, dl_yaml_item(list, i), &dl_section_term, &values, error);
        piece->term[piece->terms] = values.term;
        piece->part[piece->terms++] = (dl_part)values.part;
    }
    return status;
}

/* Where the piece begins, ends and how: a width belongs to a taper alone, and what is located is an
 * end that is not smooth. */
static dl_status check_end(const dl_yaml *yaml, const dl_yaml_node *node, double begin,
                           const dl_scene_piece_values *values, dl_error *error) {
    const dl_yaml_node *const width = dl_yaml_get(node, "width");
    if (values->end != DL_END_HARD && isinf(values->until))
        return dl_yaml_fail(yaml, dl_yaml_get(node, "end"), "end",
                            "hard: the piece never ends (it has no until)", error);
    if (values->end == DL_END_TAPER && isinf(values->width))
        return dl_yaml_missing(yaml, node, "width", "the length over which the force is tapered",
                               error);
    if (values->end != DL_END_TAPER && isfinite(values->width))
        return dl_yaml_fail(yaml, width, "width", "none: only a piece with end: taper has one",
                            error);
    if (values->end == DL_END_TAPER && !(values->width < values->until - begin)) {
        char expected[96], length[40];
        dl_format_real(values->until - begin, length, sizeof length);
        snprintf(expected, sizeof expected, "less than %s, the length of the piece", length);
        return dl_yaml_fail(yaml, width, "width", expected, error);
    }
    if (values->located && (isinf(values->until) || values->end == DL_END_TAPER))
        return dl_yaml_fail(yaml, dl_yaml_get(node, "located"), "located",
                            isinf(values->until)
                                ? "false: the piece never ends (it has no until)"
                                : "false: a taper is smooth, steps pass through it",
                            error);
    return DL_OK;
}

static dl_status read_piece(const dl_yaml *yaml, const dl_yaml_node *node, double previous,
                            dl_piece *piece, dl_error *error) {
    if (isinf(previous))
        return dl_yaml_fail(yaml, node, "pair_law", "no piece after one that does not end", error);
    dl_scene_piece_values values = {0};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_piece, &values, error);
    if (status)
        return status;
    if (values.until <= previous) {
        char expected[96], end[40];
        dl_format_real(previous, end, sizeof end);
        snprintf(expected, sizeof expected, "more than %s, where the piece before ends", end);
        return dl_yaml_fail(yaml, dl_yaml_get(node, "until"), "until", expected, error);
    }
    status = check_end(yaml, node, previous, &values, error);
    if (status)
        return status;
    piece->until = values.until;
    piece->end = (dl_piece_end)values.end;
    piece->width = values.end == DL_END_TAPER ? values.width : 0;
    piece->located = values.located;
    return read_terms(yaml, node, piece, error);
}

static bool is_zero(const dl_piece *piece) {
    for (int i = 0; i < piece->terms; i++)
        if (piece->term[i].coefficient != 0)
            return false;
    return true;
}

dl_status dl_scene_read_pair_law(const dl_yaml *yaml, const dl_yaml_node *node, dl_pair_law *law,
                                 dl_error *error) {
    if (!node)
        return DL_OK;
    if (dl_yaml_kind_of(node) != DL_YAML_LIST || dl_yaml_length(node) > DL_MAX_PIECES) {
        char expected[64];
        snprintf(expected, sizeof expected, "a list of at most %d pieces", DL_MAX_PIECES);
        return dl_yaml_fail(yaml, node, "pair_law", expected, error);
    }
    dl_status status = DL_OK;
    double previous = 0;
    for (size_t i = 0; i < dl_yaml_length(node) && !status; i++) {
        dl_piece *const piece = &law->piece[law->pieces++];
        status = read_piece(yaml, dl_yaml_item(node, i), previous, piece, error);
        previous = piece->until;
    }
    /* Beyond the last piece the force is 0: one that is 0 itself is none. */
    while (law->pieces > 0 && is_zero(&law->piece[law->pieces - 1]))
        law->pieces--;
    return status;
}

/* --- gravity, walls, time --------------------------------------------------------------------- */

static dl_status read_gravity(const dl_yaml *yaml, const dl_yaml_node *node, dl_scene *scene,
                              dl_error *error) {
    return node ? dl_yaml_reals(yaml, node, "gravity", (size_t)scene->dimension, NAN,
                                scene->gravity, error)
                : DL_OK;
}

static dl_status read_axis(const dl_yaml *yaml, const dl_yaml_node *node, int axis, dl_scene *scene,
                           dl_error *error) {
    dl_walls *const walls = &scene->walls;
    const char *const name = dl_section_walls.key[axis].name;
    if (axis >= scene->dimension)
        return dl_yaml_fail(yaml, node, name, "no such walls in two dimensions", error);
    double ends[2];
    const dl_status status = dl_yaml_reals(yaml, node, name, 2, INFINITY, ends, error);
    if (status)
        return status;
    walls->low[axis] = isinf(ends[0]) ? -INFINITY : ends[0];
    walls->high[axis] = ends[1];
    if (walls->low[axis] >= walls->high[axis]) {
        char low[40], high[40];
        dl_format_real(ends[0], low, sizeof low);
        dl_format_real(ends[1], high, sizeof high);
        return dl_fail(error, DL_INPUT, "%s:%d: %s: found [%s, %s], expected low < high",
                       dl_yaml_path(yaml), dl_yaml_line(node), name, low, high);
    }
    walls->present = walls->present || isfinite(walls->low[axis]) || isfinite(walls->high[axis]);
    return DL_OK;
}

static dl_status read_walls(const dl_yaml *yaml, const dl_yaml_node *node, dl_scene *scene,
                            dl_error *error) {
    dl_walls *const walls = &scene->walls;
    for (int axis = 0; axis < 3; axis++) {
        walls->low[axis] = -INFINITY;
        walls->high[axis] = INFINITY;
    }
    if (!node)
        return DL_OK;
    dl_scene_wall_values values = {0};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_walls, &values, error);
    for (int axis = 0; axis < 3 && !status; axis++) {
        const dl_yaml_node *const ends = dl_yaml_get(node, dl_section_walls.key[axis].name);
        if (ends)
            status = read_axis(yaml, ends, axis, scene, error);
    }
    const dl_yaml_node *const rest = dl_yaml_get(node, "rest");
    if (!status && rest && values.rule != DL_LOCATED)
        status = dl_yaml_fail(yaml, rest, "rest", "none: only rule: located has contacts that rest",
                              error);
    walls->damping = values.damping;
    walls->zero_vx_below = values.zero_vx_below;
    walls->rule = (dl_wall_rule)values.rule;
    walls->rest = values.rest;
    return status;
}

static dl_status check_whole(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                             double time, double step, dl_error *error) {
    if (time == 0 || dl_whole_steps(time, step) > 0)
        return DL_OK;
    char expected[96], step_text[40];
    dl_format_real(step, step_text, sizeof step_text);
    if (time / step > DL_MOST_STEPS)
        snprintf(expected, sizeof expected, "at most %.0f steps of %s", DL_MOST_STEPS, step_text);
    else
        snprintf(expected, sizeof expected, "a whole number of steps of %s", step_text);
    return dl_yaml_fail(yaml, dl_yaml_get(node, key), key, expected, error);
}

/* 0 where the key is not given. */
static int line_of(const dl_yaml_node *map, const char *key) {
    const dl_yaml_node *const node = map ? dl_yaml_get(map, key) : NULL;
    return node ? dl_yaml_line(node) : 0;
}

static dl_status read_time(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                           dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(root, "time");
    if (!node)
        return dl_yaml_missing(yaml, root, "time", "a mapping with step and end", error);
    dl_scene_times times = {0};
    dl_status status = dl_scene_read_section(yaml, node, &dl_section_time, &times, error);
    if (!status)
        status = check_whole(yaml, node, "end", times.end, times.step, error);
    if (!status)
        status = check_whole(yaml, node, "sample", times.sample, times.step, error);
    scene->step = times.step;
    scene->end = times.end;
    scene->sample = times.sample;
    scene->end_line = line_of(node, "end");
    scene->sample_line = line_of(node, "sample");
    return status;
}

static dl_status read_radiation(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                                dl_error *error) {
    const dl_yaml_node *const node = dl_yaml_get(root, "radiation");
    dl_radiation *const radiation = &scene->radiation;
    const dl_status status = dl_scene_read_radiation(yaml, node, radiation, error);
    scene->period_line = line_of(node, "period");
    return status ? status
                  : check_whole(yaml, node, "period", radiation->period, scene->step, error);
}

/* --- particles -------------------------------------------------------------------------------- */

static dl_status copy_particles(const dl_particles *particles, dl_scene *scene, dl_error *error) {
    const size_t n = particles->count;
    scene->particles = n;
    const dl_status status = dl_scene_allocate(scene, error);
    for (size_t i = 0; i < n && !status; i++) {
        const dl_particle *const particle = &particles->particle[i];
        for (size_t axis = 0; axis < (size_t)scene->dimension; axis++) {
            scene->position[axis * n + i] = particle->position[axis];
            scene->velocity[axis * n + i] = particle->velocity[axis];
        }
        scene->inertia[i] = particle->inertia;
        scene->coupling[i] = particle->coupling;
        if (scene->species > 0)
            scene->species_of[i] = particle->species;
        scene->feels_gravity[i] = particle->gravity;
        scene->pinned[i] = particle->pinned;
    }
    return status;
}

/* `trajectory` not NULL: they are those of its first frame, whatever the file says. */
static dl_status read_particles(const dl_yaml *yaml, const dl_yaml_node *root,
                                const char *trajectory, uint64_t seed, dl_scene *scene,
                                dl_error *error) {
    const dl_yaml_node *const node = trajectory ? NULL : dl_yaml_get(root, "particles");
    const dl_yaml_node *const start = trajectory ? NULL : dl_yaml_get(root, "start");
    if (!node && !start && !trajectory)
        return dl_yaml_missing(yaml, root, "particles", "a list of at least one particle", error);
    dl_particles particles = {.scene = scene, .dimension = scene->dimension, .seed = seed};
    dl_status status = start ? dl_initial_start(yaml, start, &particles, error) : DL_OK;
    if (!status && trajectory)
        status = dl_initial_resume(trajectory, &particles, error);
    if (!status && start) {
        scene->start = strdup(particles.file[0]); /* the first that it read */
        status = scene->start ? DL_OK : dl_fail_memory(error, "a scene");
    }
    if (!status && node)
        status = dl_particles_read(yaml, node, &particles, error);
    if (!status && particles.count == 0)
        status = dl_yaml_fail(yaml, start, "start", "a particle that is left", error);
    if (!status) {
        dl_periods_wrap(&scene->periods, &particles);
        status = dl_particles_check(&particles, &scene->walls, &scene->periods, error);
    }
    if (!status)
        status = copy_particles(&particles, scene, error);
    dl_particles_free(&particles);
    return status;
}

/* --- the scene -------------------------------------------------------------------------------- */

static dl_status read_header(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                             uint64_t *seed, dl_error *error) {
    dl_scene_header header = {0};
    dl_status status = dl_scene_read_section(yaml, root, &dl_section_scene, &header, error);
    if (!status && header.name[0] == '\0')
        status = dl_yaml_fail(yaml, dl_yaml_get(root, "name"), "name", "a text", error);
    scene->name = header.name;
    scene->source = header.source;
    scene->dimension = (int)header.dimension;
    scene->kernel = (dl_kernel_choice)header.kernel;
    scene->skin = header.skin;
    scene->tree_error = header.tree_error;
    *seed = (uint64_t)header.seed;
    return status;
}

static dl_status check_kernel(const dl_yaml *yaml, const dl_yaml_node *root, const dl_scene *scene,
                              dl_error *error) {
    const double reach = dl_scene_reach(scene);
    const bool may_be_tree = scene->kernel == DL_KERNEL_TREE || scene->kernel == DL_KERNEL_AUTO;
    if (dl_yaml_get(root, "tree_error") && !may_be_tree)
        return dl_yaml_fail(yaml, dl_yaml_get(root, "tree_error"), "tree_error",
                            "none: the kernel is not a tree", error);
    const bool needs_law =
        scene->kernel == DL_KERNEL_NEIGHBOUR_LIST || scene->kernel == DL_KERNEL_TREE;
    const bool needs_end = scene->kernel == DL_KERNEL_NEIGHBOUR_LIST;
    if (!needs_law || (reach > 0 && (isfinite(reach) || !needs_end)))
        return DL_OK;
    return dl_yaml_fail(yaml, dl_yaml_get(root, "kernel"), "kernel",
                        reach > 0 ? "another one: the pair_law never ends"
                                  : "another one: there is no pair_law",
                        error);
}

static dl_status read_scene(const dl_yaml *yaml, const char *trajectory, dl_scene *scene,
                            dl_error *error) {
    const dl_yaml_node *const root = dl_yaml_root(yaml);
    uint64_t seed;
    dl_status status = read_header(yaml, root, scene, &seed, error);
    if (!status)
        status = dl_scene_read_pair_law(yaml, dl_yaml_get(root, "pair_law"), &scene->law, error);
    if (!status)
        status = dl_species_read(yaml, root, scene, error);
    if (!status)
        status = check_kernel(yaml, root, scene, error);
    if (!status)
        status = read_gravity(yaml, dl_yaml_get(root, "gravity"), scene, error);
    if (!status)
        status = read_walls(yaml, dl_yaml_get(root, "walls"), scene, error);
    if (!status)
        status = read_time(yaml, root, scene, error);
    if (!status)
        status = read_radiation(yaml, root, scene, error);
    if (!status)
        status = dl_periods_read(yaml, root, scene, error);
    if (!status)
        status = read_particles(yaml, root, trajectory, seed, scene, error);
    if (status)
        return status;
    scene->file = strdup(dl_yaml_path(yaml));
    scene->text = strdup(dl_yaml_source(yaml));
    return scene->file && scene->text ? DL_OK : dl_fail_memory(error, "a scene");
}

static dl_status scene_of(dl_yaml *yaml, const char *trajectory, dl_scene **scene_out,
                          dl_error *error) {
    dl_scene *const scene = calloc(1, sizeof *scene);
    if (!scene)
        return dl_fail_memory(error, dl_yaml_path(yaml));
    dl_status status = dl_let_apply(yaml, &scene->lets, &scene->let, error);
    if (!status)
        status = read_scene(yaml, trajectory, scene, error);
    if (status)
        dl_scene_free(scene);
    else
        *scene_out = scene;
    return status;
}

dl_status dl_scene_read(const char *path, dl_scene **scene, dl_error *error) {
    *scene = NULL;
    dl_yaml *yaml;
    dl_status status = dl_yaml_read(path, &yaml, error);
    if (status)
        return status;
    status = scene_of(yaml, NULL, scene, error);
    dl_yaml_free(yaml);
    return status;
}

dl_status dl_scene_read_let(const char *path, size_t count, const dl_let *let, dl_scene **scene,
                            dl_error *error) {
    dl_yaml *yaml;
    char *text = NULL;
    if (count == 0)
        return dl_scene_read(path, scene, error);
    *scene = NULL;
    dl_status status = dl_yaml_read(path, &yaml, error);
    if (status)
        return status;
    status = dl_let_replace(yaml, count, let, &text, error);
    dl_yaml_free(yaml);
    yaml = NULL;
    if (!status)
        status = dl_yaml_parse(path, text, &yaml, error);
    if (!status)
        status = scene_of(yaml, NULL, scene, error);
    dl_yaml_free(yaml);
    free(text);
    return status;
}

dl_status dl_scene_read_trajectory(const char *path, dl_scene **scene, dl_error *error) {
    *scene = NULL;
    char *text;
    dl_yaml *yaml = NULL;
    dl_status status = dl_trajectory_read_scene_text(path, &text, error);
    if (status)
        return status;
    status = dl_yaml_parse(path, text, &yaml, error);
    if (!status)
        status = scene_of(yaml, path, scene, error);
    dl_yaml_free(yaml);
    free(text);
    return status;
}
