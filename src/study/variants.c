#include "study/variants.h"

#include <stdlib.h>

#include "study/plan.h"

enum { most_variants = 10000 };

static size_t length_of(const dl_yaml_node *values) {
    return dl_yaml_kind_of(values) == DL_YAML_LIST ? dl_yaml_length(values) : 1;
}

static const dl_yaml_node *value_at(const dl_yaml_node *values, size_t i) {
    return dl_yaml_kind_of(values) == DL_YAML_LIST ? dl_yaml_item(values, i) : values;
}

static dl_status add_list(const dl_yaml *yaml, const char *name, const dl_yaml_node *values,
                          dl_variants *variants, dl_error *error) {
    static const char expected[] = "a number or a list of numbers";
    if (dl_yaml_kind_of(values) == DL_YAML_MAP || length_of(values) == 0)
        return dl_yaml_fail(yaml, values, name, expected, error);
    for (size_t i = 0; i < length_of(values); i++)
        if (dl_yaml_kind_of(value_at(values, i)) != DL_YAML_SCALAR)
            return dl_yaml_fail(yaml, value_at(values, i), name, expected, error);
    if (length_of(values) > most_variants / variants->count)
        return dl_yaml_fail(yaml, values, name, "at most 10000 combinations", error);
    variants->name[variants->names] = name;
    variants->values[variants->names++] = values;
    variants->count *= length_of(values);
    return DL_OK;
}

dl_status dl_variants_read(const dl_yaml *yaml, const dl_yaml_node *node, dl_variants *variants,
                           dl_error *error) {
    *variants = (dl_variants){.count = 1};
    if (!node)
        return DL_OK;
    if (dl_yaml_kind_of(node) != DL_YAML_MAP || dl_yaml_length(node) == 0 ||
        dl_yaml_length(node) > dl_most_let_lists)
        return dl_yaml_fail(yaml, node, "let",
                            "a mapping of 1 to 8 names of the scenes' `let` to lists of numbers",
                            error);
    dl_status status = DL_OK;
    for (size_t i = 0; i < dl_yaml_length(node) && !status; i++)
        status = add_list(yaml, dl_yaml_key(node, i), dl_yaml_item(node, i), variants, error);
    return status;
}

void dl_variants_at(const dl_variants *variants, size_t index, dl_let *let) {
    for (size_t i = variants->names; i-- > 0;) {
        const size_t length = length_of(variants->values[i]);
        let[i] = (dl_let){.name = variants->name[i],
                          .value = dl_yaml_text(value_at(variants->values[i], index % length))};
        index /= length;
    }
}

char *dl_let_arguments(size_t count, const dl_let *let) {
    char *text = dl_text("%s", "");
    for (size_t i = 0; i < count && text; i++) {
        char *const longer = dl_text("%s --let %s=%s", text, let[i].name, let[i].value);
        free(text);
        text = longer;
    }
    return text;
}
