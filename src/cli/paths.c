#include "cli/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char *cli_beside(const char *path, const char *name) {
    const char *slash = strrchr(path, '/');
    const int folder = slash ? (int)(slash - path) + 1 : 0;
    const size_t room = (size_t)folder + strlen(name) + 1;
    char *beside = malloc(room);
    if (beside)
        snprintf(beside, room, "%.*s%s", folder, path, name);
    return beside;
}
