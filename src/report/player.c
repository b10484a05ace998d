/* The page that plays trajectories and nothing else. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/picture.h"
#include "report/html_text.h"
#include "report/page.h"
#include "report/player_data.h"
#include "version.h"

dl_status dl_player_blocks(const char *const *trajectory, size_t count, char **html,
                           dl_error *error) {
    char *text = NULL;
    size_t length = 0;
    *html = NULL;
    FILE *const out = open_memstream(&text, &length);
    if (!out)
        return dl_fail_memory(error, "a player");
    dl_status status = DL_OK;
    for (size_t i = 0; i < count && !status; i++) {
        char *json = NULL;
        status = dl_player_data(trajectory[i], DL_PLAYER_BYTES / count, &json, error);
        if (!status)
            fprintf(out, "<script type=\"application/json\" class=\"trajectory\">%s</script>\n",
                    json);
        free(json);
    }
    const int written = ferror(out);
    if ((fclose(out) || written) && !status)
        status = dl_fail_memory(error, "a player");
    if (status)
        free(text);
    else
        *html = text;
    return status;
}

/* The scene's name; of several trajectories that of the first. */
static dl_status read_title(const char *path, char **title, dl_error *error) {
    dl_scene *scene = NULL;
    *title = NULL;
    const dl_status status = dl_scene_read_trajectory(path, &scene, error);
    if (status)
        return status;
    *title = dl_html_text(scene->name ? scene->name : "trajectory");
    dl_scene_free(scene);
    return *title ? DL_OK : dl_fail_memory(error, "a player");
}

dl_status dl_player_write(const char *const *trajectory, size_t count, const char *path,
                          dl_error *error) {
    char *title = NULL, *blocks = NULL;
    dl_status status = count ? read_title(trajectory[0], &title, error)
                             : dl_fail(error, DL_INPUT, "player: found no trajectory");
    if (!status)
        status = dl_player_blocks(trajectory, count, &blocks, error);
    if (!status) {
        const dl_slot slots[] = {
            {"title", {title, strlen(title)}},
            {"version", {DL_VERSION, strlen(DL_VERSION)}},
            {"trajectories", {blocks, strlen(blocks)}},
            {"style", DL_ASSET(page_css)},
            {"chartjs", DL_ASSET(chartjs)},
            {"dom", DL_ASSET(dom_js)},
            {"format", DL_ASSET(format_js)},
            {"charts", DL_ASSET(charts_js)},
            {"export", DL_ASSET(export_js)},
            {"player", DL_ASSET(player_js)},
        };
        status =
            dl_page_write(path, DL_ASSET(player_html), slots, sizeof slots / sizeof *slots, error);
    }
    free(title);
    free(blocks);
    return status;
}
