/* Self-contained pages: a template whose {{slots}} are filled with texts and embedded assets. */
#ifndef DL_REPORT_PAGE_H
#define DL_REPORT_PAGE_H

#include <stddef.h>
#include "driftlab/status.h"

typedef struct dl_span {
    const char *text;
    size_t length;
} dl_span;

/* What stands for {{name}}. */
typedef struct dl_slot {
    const char *name;
    dl_span content;
} dl_slot;

/* Embedded by assets.S. */
#define DL_ASSETS(X)                                                                               \
    X(chartjs)                                                                                     \
    X(page_html)                                                                                   \
    X(paper_html)                                                                                  \
    X(paper_css)                                                                                   \
    X(player_html)                                                                                 \
    X(page_css)                                                                                    \
    X(dom_js)                                                                                      \
    X(format_js) X(charts_js) X(export_js) X(findings_js) X(across_js) X(page_js) X(player_js)
#define DL_ASSET_SYMBOLS(name) extern const char dl_asset_##name[], dl_asset_##name##_end[];
DL_ASSETS(DL_ASSET_SYMBOLS)
#undef DL_ASSET_SYMBOLS

#define DL_ASSET(name)                                                                             \
    ((dl_span){dl_asset_##name, (size_t)(dl_asset_##name##_end - dl_asset_##name)})

/* Writes `path`, complete or not at all. DL_ERROR where a slot of the template has no content. */
dl_status dl_page_write(const char *path, dl_span template, const dl_slot *slots, size_t count,
                        dl_error *error);

/* JSON that may stand inside <script>; owned by the caller. NULL: no memory. */
char *dl_page_json(const char *json);

#endif
