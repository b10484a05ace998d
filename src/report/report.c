#include "driftlab/report.h"

#include <stdlib.h>
#include <string.h>

#include "io/replace_file.h"
#include "page_data.h"
#include "version.h"

/* Embedded by assets.S. */
#define ASSETS(X)           X(chartjs) X(page_html) X(page_css) X(format_js) X(charts_js) X(page_js)
#define ASSET_SYMBOLS(name) extern const char dl_asset_##name[], dl_asset_##name##_end[];
ASSETS(ASSET_SYMBOLS)

typedef struct span {
    const char *text;
    size_t length;
} span;

#define ASSET(name) ((span){dl_asset_##name, (size_t)(dl_asset_##name##_end - dl_asset_##name)})

/* What stands for {{name}} in page.html. */
typedef struct slot {
    const char *name;
    span content;
} slot;

/* For text between tags and in quoted attributes. Owned by the caller; NULL: no memory. */
static char *html_text(const char *plain) {
    static const char *const entity[256] = {
        ['&'] = "&amp;", ['<'] = "&lt;", ['>'] = "&gt;", ['"'] = "&quot;"};
    char *html = malloc(strlen(plain) * strlen("&quot;") + 1);
    char *to = html;
    for (const char *c = plain; html && *c; c++) {
        const char *escaped = entity[(unsigned char)*c];
        if (escaped)
            to = stpcpy(to, escaped);
        else
            *to++ = *c;
    }
    if (html)
        *to = '\0';
    return html;
}

static const slot *find_slot(const slot *slots, size_t count, const char *name, size_t length) {
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

/* page.html with its slots filled, into `to`; *length is what that takes. */
static dl_status fill_page(const slot *slots, size_t count, char *to, size_t *length,
                           dl_error *error) {
    const char *at = dl_asset_page_html;
    *length = 0;
    for (const char *open; (open = strstr(at, "{{"));) {
        const char *close = strstr(open, "}}");
        const slot *found =
            close ? find_slot(slots, count, open + 2, (size_t)(close - open - 2)) : NULL;
        if (!found)
            return dl_fail(error, DL_ERROR, "page.html: nothing fills \"%.20s\"", open);
        append(to, length, at, (size_t)(open - at));
        append(to, length, found->content.text, found->content.length);
        at = close + 2;
    }
    append(to, length, at, (size_t)(dl_asset_page_html_end - at));
    return DL_OK;
}

static dl_status write_page(const char *path, const slot *slots, size_t count, dl_error *error) {
    size_t length;
    dl_status status = fill_page(slots, count, NULL, &length, error);
    if (status != DL_OK)
        return status;
    char *page = malloc(length);
    if (!page)
        return dl_fail_memory(error, "the report's page");
    status = fill_page(slots, count, page, &length, error);
    if (status == DL_OK)
        status = dl_replace_file(path, page, length, error);
    free(page);
    return status;
}

static const char *title_of(const dl_results *results) {
    if (results->title && results->title[0])
        return results->title;
    if (results->study && results->study[0])
        return results->study;
    return "driftlab report";
}

/* Another kind of file at `path`, a scene say, was named by mistake. */
static dl_status refuse_other_file(const char *path, dl_error *error) {
    static const char page[] = "<!DOCTYPE html>";
    char begin[sizeof page - 1];
    FILE *file = fopen(path, "rb");
    if (!file)
        return DL_OK;
    size_t length = fread(begin, 1, sizeof begin, file);
    fclose(file);
    if (length == 0 || (length == sizeof begin && memcmp(begin, page, sizeof begin) == 0))
        return DL_OK;
    return dl_fail(error, DL_INPUT,
                   "%s: found a file that is no page, expected a new name or a page", path);
}

dl_status dl_report_write(const dl_results *results, const char *path, dl_error *error) {
    char *json;
    dl_status status = refuse_other_file(path, error);
    if (status == DL_OK)
        status = dl_page_data(results, &json, error);
    if (status != DL_OK)
        return status;
    char *title = html_text(title_of(results));
    if (title) {
        const slot slots[] = {
            {"title", {title, strlen(title)}}, {"version", {DL_VERSION, strlen(DL_VERSION)}},
            {"data", {json, strlen(json)}},    {"style", ASSET(page_css)},
            {"chartjs", ASSET(chartjs)},       {"format", ASSET(format_js)},
            {"charts", ASSET(charts_js)},      {"page", ASSET(page_js)},
        };
        status = write_page(path, slots, sizeof slots / sizeof *slots, error);
    } else {
        status = dl_fail_memory(error, "the report's title");
    }
    free(title);
    free(json);
    return status;
}
