#include "cli/studies.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum { path_size = 4096 };

static bool is_folder(const char *path) {
    struct stat info;
    return stat(path, &info) == 0 && S_ISDIR(info.st_mode);
}

/* The installed studies lie at a fixed way from the program. */
static bool find_installed(char *studies, size_t size) {
    char program[path_size];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length <= 0)
        return false;
    program[length] = '\0';
    char *slash = strrchr(program, '/');
    if (!slash)
        return false;
    *slash = '\0';
    return (size_t)snprintf(studies, size, "%s/%s", program, DL_SHARE) < size && is_folder(studies);
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
