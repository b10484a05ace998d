#include "driftlab/report.h"

#include <stdlib.h>
#include <string.h>

#include "page_data.h"
#include "report/html_text.h"
#include "report/page.h"
#include "report/player_data.h"
#include "version.h"

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

static dl_status write_report(const dl_results *results, dl_span players, const char *path,
                              dl_error *error) {
    char *json;
    dl_status status = refuse_other_file(path, error);
    if (status == DL_OK)
        status = dl_page_data(results, &json, error);
    if (status != DL_OK)
        return status;
    char *title = dl_html_text(title_of(results));
    if (title) {
        const dl_slot slots[] = {
            {"title", {title, strlen(title)}}, {"version", {DL_VERSION, strlen(DL_VERSION)}},
            {"data", {json, strlen(json)}},    {"trajectories", players},
            {"style", DL_ASSET(page_css)},     {"chartjs", DL_ASSET(chartjs)},
            {"dom", DL_ASSET(dom_js)},         {"format", DL_ASSET(format_js)},
            {"charts", DL_ASSET(charts_js)},   {"player", DL_ASSET(player_js)},
            {"export", DL_ASSET(export_js)},   {"findings", DL_ASSET(findings_js)},
            {"page", DL_ASSET(page_js)},
        };
        status =
            dl_page_write(path, DL_ASSET(page_html), slots, sizeof slots / sizeof *slots, error);
    } else {
        status = dl_fail_memory(error, "the report's title");
    }
    free(title);
    free(json);
    return status;
}

dl_status dl_report_write_with_players(const dl_results *results, const char *const *trajectory,
                                       size_t count, const char *path, dl_error *error) {
    char *players;
    dl_status status = dl_player_blocks(trajectory, count, &players, error);
    if (!status)
        status = write_report(results, (dl_span){players, strlen(players)}, path, error);
    free(players);
    return status;
}

dl_status dl_report_write(const dl_results *results, const char *path, dl_error *error) {
    return dl_report_write_with_players(results, NULL, 0, path, error);
}
