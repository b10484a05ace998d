/* --let: other numbers in a scene's `let`. */
#include "cli/command.h"

const cli_repeated cli_let = {"let", "NAME=NUMBER", "another number in the scene's `let`", true};

dl_status cli_read_scene(const cli_input *input, const char *path, dl_scene **scene,
                         dl_error *error) {
    return dl_scene_read_let(path, input->lets, input->let, scene, error);
}

dl_status cli_refuse_let(const cli_input *input, const char *path, dl_error *error) {
    return input->lets == 0
               ? DL_OK
               : dl_fail(error, DL_INPUT, "--let: found %s, expected a scene whose numbers it sets",
                         path);
}
