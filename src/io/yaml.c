#include "io/yaml.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <yaml.h>

/* Scenes and studies are written by hand; particles by the thousand belong in a data file. */
enum { largest_file = 16 << 20 };

/* Where a node stands on the walk that looks for cycles. */
typedef enum mark { NOT_SEEN, OPEN, DONE } mark;

struct dl_yaml_node {
    dl_yaml_kind kind;
    int line;
    mark mark;
    char *text;        /* scalars */
    bool plain;        /* scalars: without quotes */
    size_t begin, end; /* in the source, in characters */
    size_t length;     /* lists and maps: items */
    struct dl_yaml_node **item;
    struct dl_yaml_node **key; /* maps: scalars, one an item */
};

/* A node of LibYAML's document, numbered from 1, becomes nodes[number - 1]: an alias is the same
 * number again. */
struct dl_yaml {
    char *path;
    char *source;
    size_t source_size;
    size_t count;
    dl_yaml_node *nodes;
};

/* --- access ----------------------------------------------------------------------------------- */

const char *dl_yaml_path(const dl_yaml *yaml) {
    return yaml->path;
}

const char *dl_yaml_source(const dl_yaml *yaml) {
    return yaml->source;
}

const dl_yaml_node *dl_yaml_root(const dl_yaml *yaml) {
    return &yaml->nodes[0];
}

dl_yaml_kind dl_yaml_kind_of(const dl_yaml_node *node) {
    return node->kind;
}

int dl_yaml_line(const dl_yaml_node *node) {
    return node->line;
}

const char *dl_yaml_text(const dl_yaml_node *node) {
    return node->text;
}

size_t dl_yaml_length(const dl_yaml_node *node) {
    return node->length;
}

const dl_yaml_node *dl_yaml_item(const dl_yaml_node *node, size_t i) {
    return node->item[i];
}

const char *dl_yaml_key(const dl_yaml_node *map, size_t i) {
    return map->key[i]->text;
}

const dl_yaml_node *dl_yaml_get(const dl_yaml_node *map, const char *key) {
    for (size_t i = 0; i < map->length; i++)
        if (strcmp(map->key[i]->text, key) == 0)
            return map->item[i];
    return NULL;
}

/* --- messages --------------------------------------------------------------------------------- */

static void describe(const dl_yaml_node *node, char *text, size_t size) {
    if (node->kind == DL_YAML_SCALAR)
        dl_quote(node->text, text, size);
    else
        snprintf(text, size, "a %s of %zu", node->kind == DL_YAML_LIST ? "list" : "mapping",
                 node->length);
}

dl_status dl_yaml_fail(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                       const char *expected, dl_error *error) {
    const char *const shown_key = key ? key : "";
    const char *const colon = key ? ": " : "";
    if (!node)
        return dl_fail(error, DL_INPUT, "%s: %s%sexpected %s", yaml->path, shown_key, colon,
                       expected);
    char found[128];
    describe(node, found, sizeof found);
    return dl_fail(error, DL_INPUT, "%s:%d: %s%sfound %s, expected %s", yaml->path, node->line,
                   shown_key, colon, found, expected);
}

dl_status dl_yaml_missing(const dl_yaml *yaml, const dl_yaml_node *map, const char *key,
                          const char *expected, dl_error *error) {
    return dl_fail(error, DL_INPUT, "%s:%d: %s: found nothing, expected %s", yaml->path, map->line,
                   key, expected);
}

/* --- reading ---------------------------------------------------------------------------------- */

static dl_status read_stream(FILE *stream, const char *path, char **text, size_t *size,
                             dl_error *error) {
    size_t used = 0, room = 4096;
    char *buffer = malloc(room);
    while (buffer) {
        used += fread(buffer + used, 1, room - used - 1, stream);
        if (used + 1 < room || used > largest_file)
            break;
        room *= 2;
        char *const larger = realloc(buffer, room);
        if (!larger)
            free(buffer);
        buffer = larger;
    }
    if (!buffer)
        return dl_fail_memory(error, path);
    buffer[used] = '\0';
    *text = buffer;
    *size = used;
    if (ferror(stream))
        return dl_fail(error, DL_INPUT, "%s: %s", path, strerror(errno));
    if (used > largest_file)
        return dl_fail(error, DL_INPUT,
                       "%s: found more than %d MiB, expected a file written by hand", path,
                       largest_file >> 20);
    return DL_OK;
}

static dl_status read_source(dl_yaml *yaml, dl_error *error) {
    FILE *const stream = fopen(yaml->path, "rb");
    if (!stream)
        return dl_fail(error, DL_INPUT, "%s: %s", yaml->path, strerror(errno));
    const dl_status status =
        read_stream(stream, yaml->path, &yaml->source, &yaml->source_size, error);
    fclose(stream);
    return status;
}

/* LibYAML gives an offset alone where it could not even read characters. */
static size_t problem_line(const dl_yaml *yaml, const yaml_parser_t *parser) {
    if (parser->error != YAML_READER_ERROR)
        return parser->problem_mark.line + 1;
    size_t line = 1;
    for (size_t i = 0; i < parser->problem_offset && i < yaml->source_size; i++)
        line += yaml->source[i] == '\n';
    return line;
}

static dl_status bad_syntax(const dl_yaml *yaml, const yaml_parser_t *parser, dl_error *error) {
    if (parser->error == YAML_MEMORY_ERROR)
        return dl_fail_memory(error, yaml->path);
    return dl_fail(error, DL_INPUT, "%s:%zu: %s%s%s, expected valid YAML", yaml->path,
                   problem_line(yaml, parser), parser->context ? parser->context : "",
                   parser->context ? ": " : "", parser->problem ? parser->problem : "bad text");
}

static dl_status copy_scalar(const dl_yaml *yaml, const yaml_node_t *from, dl_yaml_node *to,
                             dl_error *error) {
    const char *const value = (const char *)from->data.scalar.value;
    if (strlen(value) != from->data.scalar.length)
        return dl_fail(error, DL_INPUT, "%s:%d: found a zero byte in a text, expected none",
                       yaml->path, to->line);
    to->text = strdup(value);
    to->plain = from->data.scalar.style == YAML_PLAIN_SCALAR_STYLE;
    return to->text ? DL_OK : dl_fail_memory(error, yaml->path);
}

static dl_status copy_list(const dl_yaml *yaml, const yaml_node_t *from, dl_yaml_node *to,
                           dl_error *error) {
    const yaml_node_item_t *const start = from->data.sequence.items.start;
    to->length = (size_t)(from->data.sequence.items.top - start);
    to->item = calloc(to->length + 1, sizeof *to->item);
    if (!to->item)
        return dl_fail_memory(error, yaml->path);
    for (size_t i = 0; i < to->length; i++)
        to->item[i] = &yaml->nodes[start[i] - 1];
    return DL_OK;
}

static dl_status copy_map(const dl_yaml *yaml, const yaml_node_t *from, dl_yaml_node *to,
                          dl_error *error) {
    const yaml_node_pair_t *const start = from->data.mapping.pairs.start;
    to->length = (size_t)(from->data.mapping.pairs.top - start);
    to->item = calloc(to->length + 1, sizeof *to->item);
    to->key = calloc(to->length + 1, sizeof *to->key);
    if (!to->item || !to->key)
        return dl_fail_memory(error, yaml->path);
    for (size_t i = 0; i < to->length; i++) {
        to->key[i] = &yaml->nodes[start[i].key - 1];
        to->item[i] = &yaml->nodes[start[i].value - 1];
    }
    return DL_OK;
}

static dl_status copy_node(const dl_yaml *yaml, const yaml_node_t *from, dl_yaml_node *to,
                           dl_error *error) {
    to->line = (int)from->start_mark.line + 1;
    to->begin = from->start_mark.index;
    to->end = from->end_mark.index;
    if (from->type == YAML_SEQUENCE_NODE) {
        to->kind = DL_YAML_LIST;
        return copy_list(yaml, from, to, error);
    }
    if (from->type == YAML_MAPPING_NODE) {
        to->kind = DL_YAML_MAP;
        return copy_map(yaml, from, to, error);
    }
    to->kind = DL_YAML_SCALAR;
    return copy_scalar(yaml, from, to, error);
}

static dl_status refuse_second(const dl_yaml *yaml, const dl_yaml_node *first,
                               const dl_yaml_node *second, dl_error *error) {
    char shown[80];
    dl_quote(second->text, shown, sizeof shown);
    return dl_fail(error, DL_INPUT,
                   "%s:%d: found the key %s a second time, expected once (first on line %d)",
                   yaml->path, second->line, shown, first->line);
}

static dl_status check_keys(const dl_yaml *yaml, const dl_yaml_node *map, dl_error *error) {
    for (size_t i = 0; i < map->length; i++) {
        const dl_yaml_node *const key = map->key[i];
        if (key->kind != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, key, NULL, "a word as the key", error);
        for (size_t j = 0; j < i; j++)
            if (strcmp(map->key[j]->text, key->text) == 0)
                return refuse_second(yaml, map->key[j], key, error);
    }
    return DL_OK;
}

/* Walks in the order of the file. An alias stands after what it names, or within it: the walk is
 * no deeper than LibYAML's own limit on nesting. */
static dl_status check(const dl_yaml *yaml, dl_yaml_node *node, dl_error *error) {
    if (node->mark == DONE)
        return DL_OK;
    if (node->mark == OPEN)
        return dl_fail(error, DL_INPUT, "%s:%d: found a value that contains itself, expected none",
                       yaml->path, node->line);
    node->mark = OPEN;
    dl_status status = node->kind == DL_YAML_MAP ? check_keys(yaml, node, error) : DL_OK;
    for (size_t i = 0; i < node->length && !status; i++)
        status = check(yaml, node->item[i], error);
    node->mark = DONE;
    return status;
}

static dl_status copy_document(dl_yaml *yaml, const yaml_document_t *document, dl_error *error) {
    const yaml_node_t *const start = document->nodes.start;
    yaml->count = (size_t)(document->nodes.top - start);
    if (yaml->count == 0)
        return dl_fail(error, DL_INPUT, "%s:1: found an empty file, expected a mapping",
                       yaml->path);
    yaml->nodes = calloc(yaml->count, sizeof *yaml->nodes);
    if (!yaml->nodes)
        return dl_fail_memory(error, yaml->path);
    for (size_t i = 0; i < yaml->count; i++) {
        const dl_status status = copy_node(yaml, &start[i], &yaml->nodes[i], error);
        if (status)
            return status;
    }
    return check(yaml, &yaml->nodes[0], error);
}

static dl_status refuse_more(const dl_yaml *yaml, yaml_parser_t *parser, dl_error *error) {
    yaml_document_t document;
    if (!yaml_parser_load(parser, &document))
        return bad_syntax(yaml, parser, error);
    const yaml_node_t *const root = yaml_document_get_root_node(&document);
    const dl_status status =
        root ? dl_fail(error, DL_INPUT, "%s:%zu: found a second document, expected one a file",
                       yaml->path, root->start_mark.line + 1)
             : DL_OK;
    yaml_document_delete(&document);
    return status;
}

static dl_status parse(dl_yaml *yaml, dl_error *error) {
    yaml_parser_t parser;
    if (!yaml_parser_initialize(&parser))
        return dl_fail_memory(error, yaml->path);
    yaml_parser_set_input_string(&parser, (const unsigned char *)yaml->source, yaml->source_size);
    yaml_document_t document;
    dl_status status = DL_OK;
    if (!yaml_parser_load(&parser, &document)) {
        status = bad_syntax(yaml, &parser, error);
    } else {
        status = copy_document(yaml, &document, error);
        yaml_document_delete(&document);
        if (!status)
            status = refuse_more(yaml, &parser, error);
    }
    yaml_parser_delete(&parser);
    return status;
}

static dl_status copy_source(dl_yaml *yaml, const char *text, dl_error *error) {
    yaml->source = strdup(text);
    yaml->source_size = strlen(text);
    return yaml->source ? DL_OK : dl_fail_memory(error, yaml->path);
}

/* `text` NULL: that of the file. */
static dl_status read_or_parse(const char *path, const char *text, dl_yaml **yaml_out,
                               dl_error *error) {
    *yaml_out = NULL;
    dl_yaml *const yaml = calloc(1, sizeof *yaml);
    if (!yaml)
        return dl_fail_memory(error, path);
    yaml->path = strdup(path);
    dl_status status = !yaml->path ? dl_fail_memory(error, path)
                       : text      ? copy_source(yaml, text, error)
                                   : read_source(yaml, error);
    if (!status)
        status = parse(yaml, error);
    if (status)
        dl_yaml_free(yaml);
    else
        *yaml_out = yaml;
    return status;
}

dl_status dl_yaml_read(const char *path, dl_yaml **yaml, dl_error *error) {
    return read_or_parse(path, NULL, yaml, error);
}

dl_status dl_yaml_parse(const char *path, const char *text, dl_yaml **yaml, dl_error *error) {
    return read_or_parse(path, text, yaml, error);
}

void dl_yaml_free(dl_yaml *yaml) {
    if (!yaml)
        return;
    for (size_t i = 0; yaml->nodes && i < yaml->count; i++) {
        free(yaml->nodes[i].text);
        free(yaml->nodes[i].item);
        free(yaml->nodes[i].key);
    }
    free(yaml->nodes);
    free(yaml->source);
    free(yaml->path);
    free(yaml);
}

/* --- other texts ------------------------------------------------------------------------------ */

size_t dl_yaml_count(const dl_yaml *yaml) {
    return yaml->count;
}

const dl_yaml_node *dl_yaml_at(const dl_yaml *yaml, size_t i) {
    return &yaml->nodes[i];
}

bool dl_yaml_is_plain(const dl_yaml_node *node) {
    return node->kind == DL_YAML_SCALAR && node->plain;
}

dl_status dl_yaml_set_text(dl_yaml *yaml, const dl_yaml_node *node, const char *text,
                           dl_error *error) {
    char *const copy = strdup(text);
    if (!copy)
        return dl_fail_memory(error, yaml->path);
    dl_yaml_node *const own = &yaml->nodes[node - yaml->nodes];
    free(own->text);
    own->text = copy;
    return DL_OK;
}

/* Where character `index` of UTF-8 text stands; LibYAML does not count a byte order mark. */
static const char *at_character(const char *source, size_t index) {
    const char *at = strncmp(source, "\xef\xbb\xbf", 3) == 0 ? source + 3 : source;
    for (; *at && index > 0; index--)
        for (at++; ((unsigned char)*at & 0xc0) == 0x80;)
            at++;
    return at;
}

/* The edit that comes after `done` (NULL: the first); NULL where none does. */
static const dl_yaml_edit *next_edit(size_t count, const dl_yaml_edit *edit,
                                     const dl_yaml_edit *done) {
    const dl_yaml_edit *next = NULL;
    for (size_t i = 0; i < count; i++) {
        const size_t begin = edit[i].node->begin;
        if ((!done || begin > done->node->begin) && (!next || begin < next->node->begin))
            next = &edit[i];
    }
    return next;
}

dl_status dl_yaml_edited(const dl_yaml *yaml, size_t count, const dl_yaml_edit *edit, char **text,
                         dl_error *error) {
    size_t size;
    *text = NULL;
    FILE *const out = open_memstream(text, &size);
    if (!out)
        return dl_fail_memory(error, yaml->path);
    const char *copied = yaml->source;
    for (const dl_yaml_edit *at = NULL; (at = next_edit(count, edit, at));) {
        const char *const begin = at_character(yaml->source, at->node->begin);
        fwrite(copied, 1, (size_t)(begin - copied), out);
        fputs(at->text, out);
        copied = at_character(yaml->source, at->node->end);
    }
    fputs(copied, out);
    const bool failed = ferror(out);
    if (!fclose(out) && !failed)
        return DL_OK;
    free(*text);
    *text = NULL;
    return dl_fail_memory(error, yaml->path);
}

/* --- reading by a table ----------------------------------------------------------------------- */

static bool known(dl_parameter_table table, const char *const *others, const char *key) {
    if (dl_parameter_find(table, key))
        return true;
    for (; others && *others; others++)
        if (strcmp(*others, key) == 0)
            return true;
    return false;
}

static dl_status refuse_key(const dl_yaml *yaml, const dl_yaml_node *key, const char *const *words,
                            dl_error *error) {
    char list[512] = "";
    size_t used = 0;
    for (size_t i = 0; words[i] && used < sizeof list; i++)
        used += (size_t)snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", words[i]);
    char shown[80];
    dl_quote(key->text, shown, sizeof shown);
    const char *const closest = dl_closest_word(words, key->text);
    return dl_fail(error, DL_INPUT, "%s:%d: found the key %s, expected one of %s%s%s%s", yaml->path,
                   key->line, shown, list, closest ? "; did you mean \"" : "",
                   closest ? closest : "", closest ? "\"?" : "");
}

static dl_status unknown_key(const dl_yaml *yaml, const dl_yaml_node *key, dl_parameter_table table,
                             const char *const *others, dl_error *error) {
    size_t count = 0, other_count = 0;
    while (others && others[other_count])
        other_count++;
    const char **const words = calloc(table.count + other_count + 1, sizeof *words);
    if (!words)
        return dl_fail_memory(error, yaml->path);
    for (size_t i = 0; i < table.count; i++)
        words[count++] = table.rows[i].name;
    for (size_t i = 0; i < other_count; i++)
        words[count++] = others[i];
    const dl_status status = refuse_key(yaml, key, words, error);
    free(words);
    return status;
}

static dl_status set_value(const dl_yaml *yaml, const dl_yaml_node *node, const dl_parameter *row,
                           void *object, dl_error *error) {
    if (node->kind != DL_YAML_SCALAR) {
        char range[256];
        dl_parameter_range(row, range, sizeof range);
        return dl_yaml_fail(yaml, node, row->name, range, error);
    }
    dl_error reason;
    const dl_status status = dl_parameter_set(row, object, node->text, &reason);
    return status ? dl_fail(error, status, "%s:%d: %.900s", yaml->path, node->line, reason.message)
                  : DL_OK;
}

static dl_status missing_value(const dl_yaml *yaml, const dl_yaml_node *map,
                               const dl_parameter *row, dl_error *error) {
    char range[128], expected[384];
    dl_parameter_range(row, range, sizeof range);
    snprintf(expected, sizeof expected, "%s (%s)", range, row->doc);
    return dl_yaml_missing(yaml, map, row->name, expected, error);
}

dl_status dl_yaml_read_table(const dl_yaml *yaml, const dl_yaml_node *map, dl_parameter_table table,
                             const char *const *others, void *object, dl_error *error) {
    if (map->kind != DL_YAML_MAP)
        return dl_yaml_fail(yaml, map, NULL, "a mapping of keys to values", error);
    for (size_t i = 0; i < map->length; i++)
        if (!known(table, others, map->key[i]->text))
            return unknown_key(yaml, map->key[i], table, others, error);
    dl_status status = dl_parameter_defaults(table, object, error);
    for (size_t i = 0; i < table.count && !status; i++) {
        const dl_parameter *const row = &table.rows[i];
        const dl_yaml_node *const node = dl_yaml_get(map, row->name);
        if (node)
            status = set_value(yaml, node, row, object, error);
        else if (!row->fallback)
            status = missing_value(yaml, map, row, error);
    }
    return status;
}

dl_status dl_yaml_reals(const dl_yaml *yaml, const dl_yaml_node *node, const char *key,
                        size_t count, double none_value, double *values, dl_error *error) {
    const bool none_allowed = !isnan(none_value);
    if (node->kind != DL_YAML_LIST || node->length != count) {
        char expected[64];
        snprintf(expected, sizeof expected, "a list of %zu numbers", count);
        return dl_yaml_fail(yaml, node, key, expected, error);
    }
    const dl_parameter row = {
        .name = key, .kind = DL_REAL, .minimum = -INFINITY, .maximum = INFINITY};
    for (size_t i = 0; i < count; i++) {
        const dl_yaml_node *const item = node->item[i];
        const bool scalar = item->kind == DL_YAML_SCALAR;
        if (none_allowed && scalar && strcmp(item->text, "none") == 0)
            values[i] = none_value;
        else if (!scalar || dl_parameter_set(&row, &values[i], item->text, NULL))
            return dl_yaml_fail(yaml, item, key, none_allowed ? "a number or none" : "a number",
                                error);
    }
    return DL_OK;
}
