#include "cli/studies.h"

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

#include "cli/paths.h"

static bool is_folder(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* The installed studies lie at a fixed way from the program. */
static bool find_installed(char *studies, size_t size) {
    char *installed = cli_beside_program(DL_SHARE);
    const bool found =
        installed && (size_t)snprintf(studies, size, "%s", installed) < size && is_folder(studies);
    free(installed);
    return found;
}

dl_status cli_find_studies(const char *asked, char *studies, size_t size, dl_error *error) {
    snprintf(studies, size, "%s", asked ? asked : "studies");
    if (asked && !is_folder(studies))
        return dl_fail(error, DL_INPUT, "--studies: found \"%s\", expected a folder", asked);
    return is_folder(studies) || find_installed(studies, size)
               ? DL_OK
               : dl_fail(error, DL_INPUT,
                         "found no folder \"studies\" here and none installed; expected one "
                         "(--studies DIR)");
}
