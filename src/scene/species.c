#include "scene/species.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/parameter.h"
#include "scene/tables.h"

static bool is_name(const dl_yaml_node *node) {
    return dl_yaml_kind_of(node) == DL_YAML_SCALAR && dl_yaml_text(node)[0] != '\0';
}

static size_t index_of(const dl_scene *scene, const char *name) {
    size_t k = 0;
    while (k < scene->species && strcmp(scene->species_name[k], name) != 0)
        k++;
    return k;
}

/* Species in the order in which the pairs name them; room for two a pair. */
static dl_status add_names(const dl_yaml *yaml, const dl_yaml_node *pair, dl_scene *scene,
                           dl_error *error) {
    const dl_yaml_node *const between = dl_yaml_get(pair, "between");
    if (!between)
        return dl_yaml_missing(yaml, pair, "between", "a list of two species", error);
    if (dl_yaml_kind_of(between) != DL_YAML_LIST || dl_yaml_length(between) != 2 ||
        !is_name(dl_yaml_item(between, 0)) || !is_name(dl_yaml_item(between, 1)))
        return dl_yaml_fail(yaml, between, "between", "a list of two species", error);
    for (size_t k = 0; k < 2; k++) {
        const char *const name = dl_yaml_text(dl_yaml_item(between, k));
        if (index_of(scene, name) < scene->species)
            continue;
        char *const copy = strdup(name);
        if (!copy)
            return dl_fail_memory(error, "the names of the species");
        scene->species_name[scene->species++] = copy;
    }
    return DL_OK;
}

static dl_status read_names(const dl_yaml *yaml, const dl_yaml_node *list, dl_scene *scene,
                            dl_error *error) {
    const size_t pairs = dl_yaml_length(list);
    scene->species_name = calloc(2 * pairs, sizeof *scene->species_name);
    if (!scene->species_name)
        return dl_fail_memory(error, "the names of the species");
    dl_status status = DL_OK;
    for (size_t i = 0; i < pairs && !status; i++) {
        const dl_yaml_node *const pair = dl_yaml_item(list, i);
        status = dl_scene_read_section(yaml, pair, &dl_section_pair, NULL, error);
        if (!status)
            status = add_names(yaml, pair, scene, error);
    }
    return status;
}

/* "none" is said, not left out: an empty list would look like a mistake. */
static dl_status read_pieces(const dl_yaml *yaml, const dl_yaml_node *pair, dl_pair_law *law,
                             dl_error *error) {
    static const char expected[] = "a list of pieces, or none for no force";
    const dl_yaml_node *const pieces = dl_yaml_get(pair, "pieces");
    if (!pieces)
        return dl_yaml_missing(yaml, pair, "pieces", expected, error);
    if (dl_yaml_kind_of(pieces) == DL_YAML_SCALAR && strcmp(dl_yaml_text(pieces), "none") == 0)
        return DL_OK;
    if (dl_yaml_kind_of(pieces) != DL_YAML_LIST || dl_yaml_length(pieces) == 0)
        return dl_yaml_fail(yaml, pieces, "pieces", expected, error);
    return dl_scene_read_pair_law(yaml, pieces, law, error);
}

static dl_status read_pair(const dl_yaml *yaml, const dl_yaml_node *pair, bool *given,
                           dl_scene *scene, dl_error *error) {
    const dl_yaml_node *const between = dl_yaml_get(pair, "between");
    const size_t n = scene->species;
    const size_t a = index_of(scene, dl_yaml_text(dl_yaml_item(between, 0)));
    const size_t b = index_of(scene, dl_yaml_text(dl_yaml_item(between, 1)));
    if (given[a * n + b])
        return dl_fail(error, DL_INPUT,
                       "%s:%d: between: found a second law between %.80s and %.80s, expected one",
                       dl_yaml_path(yaml), dl_yaml_line(between), scene->species_name[a],
                       scene->species_name[b]);
    const dl_status status = read_pieces(yaml, pair, &scene->species_law[a * n + b], error);
    scene->species_law[b * n + a] = scene->species_law[a * n + b];
    given[a * n + b] = given[b * n + a] = true;
    return status;
}

static dl_status read_laws(const dl_yaml *yaml, const dl_yaml_node *list, bool *given,
                           dl_scene *scene, dl_error *error) {
    const size_t n = scene->species;
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_length(list) && !status; i++)
        status = read_pair(yaml, dl_yaml_item(list, i), given, scene, error);
    for (size_t k = 0; k < n * n && !status; k++)
        if (!given[k])
            status = dl_fail(error, DL_INPUT,
                             "%s:%d: pair_laws: found no law between %.80s and %.80s, expected one "
                             "(pieces: none for no force)",
                             dl_yaml_path(yaml), dl_yaml_line(list), scene->species_name[k / n],
                             scene->species_name[k % n]);
    return status;
}

dl_status dl_species_read(const dl_yaml *yaml, const dl_yaml_node *root, dl_scene *scene,
                          dl_error *error) {
    const dl_yaml_node *const list = dl_yaml_get(root, "pair_laws");
    if (!list)
        return DL_OK;
    if (dl_yaml_get(root, "pair_law"))
        return dl_yaml_fail(yaml, list, "pair_laws", "either pair_law or pair_laws", error);
    if (dl_yaml_kind_of(list) != DL_YAML_LIST || dl_yaml_length(list) == 0)
        return dl_yaml_fail(yaml, list, "pair_laws", "a list of at least one pair", error);
    dl_status status = read_names(yaml, list, scene, error);
    if (status)
        return status;
    const size_t pairs = scene->species * scene->species;
    bool *const given = calloc(pairs, sizeof *given);
    scene->species_law = calloc(pairs, sizeof *scene->species_law);
    status = given && scene->species_law ? read_laws(yaml, list, given, scene, error)
                                         : dl_fail_memory(error, "the pair laws");
    free(given);
    return status;
}

static dl_status unknown(const dl_particles *particles, const char *name, const char *file,
                         int line, dl_error *error) {
    const dl_scene *const scene = particles->scene;
    char list[256] = "", shown[80];
    size_t used = 0;
    for (size_t k = 0; k < scene->species && used < sizeof list; k++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%.60s", k ? ", " : "",
                                 scene->species_name[k]);
    if (!name || !name[0])
        return dl_fail(error, DL_INPUT,
                       "%s:%d: species: found nothing, expected one of %s, which pair_laws tells "
                       "apart",
                       file, line, list);
    const char *closest = NULL;
    const char **const words = calloc(scene->species + 1, sizeof *words);
    for (size_t k = 0; words && k < scene->species; k++)
        words[k] = scene->species_name[k];
    if (words)
        closest = dl_closest_word(words, name);
    free(words);
    dl_quote(name, shown, sizeof shown);
    return dl_fail(error, DL_INPUT, "%s:%d: species: found %s, expected one of %s%s%s%s", file,
                   line, shown, list, closest ? "; did you mean \"" : "", closest ? closest : "",
                   closest ? "\"?" : "");
}

dl_status dl_species_find(const dl_particles *particles, const char *name, const char *file,
                          int line, int *species, dl_error *error) {
    const dl_scene *const scene = particles->scene;
    const bool named = name && name[0];
    *species = -1;
    if (scene->species == 0 && named) {
        char shown[80];
        dl_quote(name, shown, sizeof shown);
        return dl_fail(error, DL_INPUT,
                       "%s:%d: species: found %s, expected none: the scene has no pair_laws", file,
                       line, shown);
    }
    if (scene->species == 0)
        return DL_OK;
    const size_t k = named ? index_of(scene, name) : scene->species;
    if (k == scene->species)
        return unknown(particles, name, file, line, error);
    *species = (int)k;
    return DL_OK;
}

static double reach_of(const dl_pair_law *law) {
    return law->pieces > 0 ? law->piece[law->pieces - 1].until : 0;
}

double dl_scene_reach(const dl_scene *scene) {
    double reach = reach_of(&scene->law);
    for (size_t k = 0; k < scene->species * scene->species; k++)
        reach = fmax(reach, reach_of(&scene->species_law[k]));
    return reach;
}
