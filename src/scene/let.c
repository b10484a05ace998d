#include "scene/let.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { most_names = 32, name_size = sizeof((dl_named_number *)NULL)->name };

/* A name, its value as the file writes it, and whether anything stands for it. */
typedef struct named {
    char name[name_size];
    char text[64];
    double value;
    bool used;
} named;

typedef struct names {
    dl_yaml *yaml;
    size_t count;
    named name[most_names];
} names;

/* Characters that are a name's; 0 where `text` does not begin with one. */
static size_t name_length(const char *text) {
    size_t length = 0;
    if (!isalpha((unsigned char)text[0]))
        return 0;
    while (isalnum((unsigned char)text[length]) || text[length] == '_')
        length++;
    return length;
}

static bool read_number(const char *text, double *value) {
    const dl_parameter row = {
        .name = "", .kind = DL_REAL, .minimum = -INFINITY, .maximum = INFINITY};
    return dl_parameter_set(&row, value, text, NULL) == DL_OK;
}

/* --- messages --------------------------------------------------------------------------------- */

/* The names there are, as "$a, $b"; "" where there are none. */
static void list_names(const names *known, const char *sign, char *text, size_t size) {
    size_t used = 0;
    text[0] = '\0';
    for (size_t i = 0; i < known->count && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s%s", i ? ", " : "", sign,
                                 known->name[i].name);
}

static const char *closest_name(const names *known, const char *name) {
    const char *words[most_names + 1] = {NULL};
    for (size_t i = 0; i < known->count; i++)
        words[i] = known->name[i].name;
    return dl_closest_word(words, name);
}

static dl_status unknown_name(const names *known, const dl_yaml_node *node, const char *name,
                              dl_error *error) {
    char list[256], expected[400];
    const char *const closest = closest_name(known, name);
    list_names(known, "$", list, sizeof list);
    snprintf(expected, sizeof expected, "a name of `let` that stands before it%s%s%s%s%s%s",
             *list ? ": " : "", list, *list ? "" : " (there is none)",
             closest ? "; did you mean \"$" : "", closest ? closest : "", closest ? "\"?" : "");
    return dl_yaml_fail(known->yaml, node, NULL, expected, error);
}

static dl_status bad_expression(const names *known, const dl_yaml_node *node, dl_error *error) {
    return dl_yaml_fail(known->yaml, node, NULL,
                        "$NAME, or a product or quotient of such and numbers (a text with $ stands "
                        "in quotes)",
                        error);
}

/* --- expressions ------------------------------------------------------------------------------ */

/* Reads one factor at *at, which moves behind it. *alone: the name, where the factor is one. */
static dl_status read_factor(names *known, const dl_yaml_node *node, const char **at, double *value,
                             const named **alone, dl_error *error) {
    const bool is_name = **at == '$';
    const char *const begin = *at + is_name;
    const size_t length = is_name ? name_length(begin) : strspn(begin, "0123456789.eE+-");
    char text[64];
    *alone = NULL;
    if (length == 0 || length >= sizeof text)
        return bad_expression(known, node, error);
    memcpy(text, begin, length);
    text[length] = '\0';
    *at = begin + length;
    if (!is_name)
        return read_number(text, value) ? DL_OK : bad_expression(known, node, error);
    for (size_t i = 0; i < known->count; i++)
        if (strcmp(known->name[i].name, text) == 0) {
            known->name[i].used = true;
            *value = known->name[i].value;
            *alone = &known->name[i];
            return DL_OK;
        }
    return unknown_name(known, node, text, error);
}

static const char *skip_blanks(const char *at) {
    return at + strspn(at, " ");
}

/* The number an expression is, as text: a name alone keeps its digits. */
static dl_status evaluate(names *known, const dl_yaml_node *node, char *text, size_t size,
                          dl_error *error) {
    const char *at = dl_yaml_text(node);
    const bool negative = *at == '-' && at[1] == '$';
    double value = 1;
    char sign = '*';
    const named *alone = NULL;
    size_t factors = 0;
    at += negative;
    do {
        double factor;
        const dl_status status = read_factor(known, node, &at, &factor, &alone, error);
        if (status)
            return status;
        value = sign == '*' ? value * factor : value / factor;
        factors++;
        at = skip_blanks(at);
        sign = *at;
        at = sign ? skip_blanks(at + 1) : at;
    } while (sign == '*' || sign == '/');
    if (sign)
        return bad_expression(known, node, error);
    value = negative ? -value : value;
    if (!isfinite(value))
        return dl_yaml_fail(known->yaml, node, NULL, "a number that is finite", error);
    if (factors == 1 && alone && !negative)
        snprintf(text, size, "%s", alone->text);
    else
        dl_format_real(value, text, size);
    return DL_OK;
}

/* --- the key `let` ---------------------------------------------------------------------------- */

/* `key` stands for nothing but the message. */
static dl_status check_name(const names *known, const dl_yaml_node *item, const char *key,
                            dl_error *error) {
    const size_t length = name_length(key);
    if (length > 0 && key[length] == '\0' && length < name_size)
        return DL_OK;
    return dl_yaml_fail(known->yaml, item, key,
                        "a name of at most 31 characters: a letter, then letters, digits and _",
                        error);
}

static dl_status add_name(names *known, const dl_yaml_node *item, const char *key,
                          dl_error *error) {
    named added = {.used = false};
    dl_status status = check_name(known, item, key, error);
    if (!status && dl_yaml_kind_of(item) != DL_YAML_SCALAR)
        status = dl_yaml_fail(known->yaml, item, key, "a number", error);
    if (status)
        return status;
    const char *const text = dl_yaml_text(item);
    if (strchr(text, '$'))
        status = evaluate(known, item, added.text, sizeof added.text, error);
    else
        snprintf(added.text, sizeof added.text, "%s", text);
    if (!status && (strlen(text) >= sizeof added.text || !read_number(added.text, &added.value)))
        status = dl_yaml_fail(known->yaml, item, key, "a number", error);
    if (status)
        return status;
    snprintf(added.name, sizeof added.name, "%s", key);
    known->name[known->count++] = added;
    return DL_OK;
}

/* The mapping, or NULL where there is none. */
static dl_status find_let(const dl_yaml *yaml, const dl_yaml_node **let, dl_error *error) {
    const dl_yaml_node *const root = dl_yaml_root(yaml);
    *let = dl_yaml_kind_of(root) == DL_YAML_MAP ? dl_yaml_get(root, "let") : NULL;
    if (*let && (dl_yaml_kind_of(*let) != DL_YAML_MAP || dl_yaml_length(*let) == 0 ||
                 dl_yaml_length(*let) > most_names))
        return dl_yaml_fail(yaml, *let, "let", "a mapping of 1 to 32 names to numbers", error);
    return DL_OK;
}

static dl_status read_names(names *known, const dl_yaml_node *let, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_length(let) && !status; i++) {
        const dl_yaml_node *const item = dl_yaml_item(let, i);
        status = add_name(known, item, dl_yaml_key(let, i), error);
        if (!status)
            status = dl_yaml_set_text(known->yaml, item, known->name[i].text, error);
    }
    return status;
}

/* Every expression of the file that is left. */
static dl_status substitute(names *known, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_count(known->yaml) && !status; i++) {
        const dl_yaml_node *const node = dl_yaml_at(known->yaml, i);
        char text[64];
        if (!dl_yaml_is_plain(node) || !strchr(dl_yaml_text(node), '$'))
            continue;
        status = evaluate(known, node, text, sizeof text, error);
        if (!status)
            status = dl_yaml_set_text(known->yaml, node, text, error);
    }
    return status;
}

static dl_status check_used(const names *known, const dl_yaml_node *let, dl_error *error) {
    char expected[80];
    for (size_t i = 0; i < known->count; i++) {
        snprintf(expected, sizeof expected, "a value of the scene that is $%s: it is not used",
                 known->name[i].name);
        if (!known->name[i].used)
            return dl_yaml_fail(known->yaml, dl_yaml_item(let, i), known->name[i].name, expected,
                                error);
    }
    return DL_OK;
}

dl_status dl_let_apply(dl_yaml *yaml, size_t *lets, dl_named_number **let, dl_error *error) {
    names known = {.yaml = yaml};
    const dl_yaml_node *node;
    *lets = 0;
    *let = NULL;
    dl_status status = find_let(yaml, &node, error);
    if (status || !node)
        return status;
    status = read_names(&known, node, error);
    if (!status)
        status = substitute(&known, error);
    if (!status)
        status = check_used(&known, node, error);
    if (status)
        return status;
    *let = calloc(known.count + 1, sizeof **let);
    if (!*let)
        return dl_fail_memory(error, "a scene");
    for (; *lets < known.count; ++*lets) {
        memcpy((*let)[*lets].name, known.name[*lets].name, name_size);
        (*let)[*lets].value = known.name[*lets].value;
    }
    return DL_OK;
}

/* --- other numbers ---------------------------------------------------------------------------- */

static dl_status no_such_name(const dl_yaml *yaml, const dl_yaml_node *node, const char *name,
                              dl_error *error) {
    const char *words[most_names + 1] = {NULL};
    char list[256] = "", shown[80];
    size_t used = 0;
    for (size_t i = 0; node && i < dl_yaml_length(node); i++) {
        words[i] = dl_yaml_key(node, i);
        if (used < sizeof list)
            used +=
                (size_t)snprintf(list + used, sizeof list - used, "%s%s", i ? ", " : "", words[i]);
    }
    const char *const closest = dl_closest_word(words, name);
    dl_quote(name, shown, sizeof shown);
    return dl_fail(error, DL_INPUT, "%s: let: found %s to be set, expected %s%s%s%s%s",
                   dl_yaml_path(yaml), shown, *list ? "one of " : "none: the scene has no `let`",
                   list, closest ? "; did you mean \"" : "", closest ? closest : "",
                   closest ? "\"?" : "");
}

/* The edit of one name's number. */
static dl_status edit_number(const dl_yaml *yaml, const dl_yaml_node *node, const dl_let *let,
                             dl_yaml_edit *edit, dl_error *error) {
    double value;
    char shown[80];
    const dl_yaml_node *const item = node ? dl_yaml_get(node, let->name) : NULL;
    if (!item)
        return no_such_name(yaml, node, let->name, error);
    for (size_t i = 0, shared = 0; i < dl_yaml_length(node); i++)
        if (dl_yaml_item(node, i) == item && ++shared > 1)
            return dl_yaml_fail(yaml, item, let->name, "a number that no alias shares", error);
    dl_quote(let->value, shown, sizeof shown);
    if (!read_number(let->value, &value))
        return dl_fail(error, DL_INPUT, "%s: let: %s: found %s, expected a number",
                       dl_yaml_path(yaml), let->name, shown);
    *edit = (dl_yaml_edit){.node = item, .text = let->value};
    return DL_OK;
}

static dl_status check_once(const dl_yaml *yaml, size_t count, const dl_let *let, dl_error *error) {
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < i; j++)
            if (strcmp(let[i].name, let[j].name) == 0)
                return dl_fail(error, DL_INPUT, "%s: let: found %.60s set twice, expected once",
                               dl_yaml_path(yaml), let[i].name);
    return DL_OK;
}

/* "NAME(a=1,b=2)" in quotes, as YAML reads it. */
static char *quoted_name(const char *name, size_t count, const dl_let *let) {
    char *text = NULL;
    size_t size;
    FILE *const out = open_memstream(&text, &size);
    if (!out)
        return NULL;
    fputc('"', out);
    for (; *name; name++)
        fprintf(out, *name == '"' || *name == '\\' ? "\\%c" : "%c", *name);
    for (size_t i = 0; i < count; i++)
        fprintf(out, "%c%s=%s", i ? ',' : '(', let[i].name, let[i].value);
    fputs(")\"", out);
    if (!fclose(out))
        return text;
    free(text);
    return NULL;
}

dl_status dl_let_replace(const dl_yaml *yaml, size_t count, const dl_let *let, char **text,
                         dl_error *error) {
    dl_yaml_edit edit[most_names + 1];
    const dl_yaml_node *node;
    *text = NULL;
    dl_status status = find_let(yaml, &node, error);
    if (!status)
        status = check_once(yaml, count, let, error);
    if (!status && count > most_names)
        status = no_such_name(yaml, node, let[most_names].name, error);
    for (size_t i = 0; i < count && !status; i++)
        status = edit_number(yaml, node, &let[i], &edit[i], error);
    if (status)
        return status;
    const dl_yaml_node *const name = dl_yaml_get(dl_yaml_root(yaml), "name");
    if (!name || dl_yaml_kind_of(name) != DL_YAML_SCALAR)
        return dl_yaml_edited(yaml, count, edit, text, error);
    char *const renamed = quoted_name(dl_yaml_text(name), count, let);
    if (!renamed)
        return dl_fail_memory(error, "a scene");
    edit[count] = (dl_yaml_edit){.node = name, .text = renamed};
    status = dl_yaml_edited(yaml, count + 1, edit, text, error);
    free(renamed);
    return status;
}
