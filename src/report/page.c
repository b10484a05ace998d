#include "report/page.h"

#include <stdlib.h>
#include <string.h>

#include "io/replace_file.h"

static const dl_slot *find_slot(const dl_slot *slots, size_t count, const char *name,
                                size_t length) {
    for (size_t i = 0; i < count; i++)
        if (strlen(slots[i].name) == length && memcmp(slots[i].name, name, length) == 0)
            return &slots[i];
    return NULL;
}

/* A piece of the page: `text` at the end of what is there, or only counted where `to` is NULL. */
static void append(char *to, size_t *length, const char *text, size_t added) {
    if (to)
        memcpy(to + *length, text, added);
    *length += added;
}

/* The template with its slots filled, into `to`; *length is what that takes. */
static dl_status fill(dl_span template, const dl_slot *slots, size_t count, char *to,
                      size_t *length, dl_error *error) {
    const char *at = template.text;
    *length = 0;
    for (const char *open; (open = strstr(at, "{{"));) {
        const char *close = strstr(open, "}}");
        const dl_slot *found =
            close ? find_slot(slots, count, open + 2, (size_t)(close - open - 2)) : NULL;
        if (!found)
            return dl_fail(error, DL_ERROR, "page: nothing fills \"%.20s\"", open);
        append(to, length, at, (size_t)(open - at));
        append(to, length, found->content.text, found->content.length);
        at = close + 2;
    }
    append(to, length, at, (size_t)(template.text + template.length - at));
    return DL_OK;
}

dl_status dl_page_write(const char *path, dl_span template, const dl_slot *slots, size_t count,
                        dl_error *error) {
    size_t length;
    dl_status status = fill(template, slots, count, NULL, &length, error);
    if (status != DL_OK)
        return status;
    char *page = malloc(length);
    if (!page)
        return dl_fail_memory(error, "a page");
    status = fill(template, slots, count, page, &length, error);
    if (status == DL_OK)
        status = dl_replace_file(path, page, length, error);
    free(page);
    return status;
}

/* `<` stands only inside JSON's strings, where \u003c means the same: no </script>, no <!--. */
char *dl_page_json(const char *json) {
    static const char escape[] = "\\u003c";
    size_t angles = 0;
    for (const char *c = json; *c; c++)
        angles += *c == '<';
    char *safe = malloc(strlen(json) + angles * (sizeof escape - 2) + 1);
    if (!safe)
        return NULL;
    char *to = safe;
    for (const char *c = json; *c; c++) {
        if (*c == '<') {
            memcpy(to, escape, sizeof escape - 1);
            to += sizeof escape - 1;
        } else {
            *to++ = *c;
        }
    }
    *to = '\0';
    return safe;
}
