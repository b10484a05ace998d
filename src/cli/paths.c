#include "cli/paths.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

char *cli_beside(const char *path, const char *name) {
    const char *slash = strrchr(path, '/');
    const int folder = slash ? (int)(slash - path) + 1 : 0;
    const size_t room = (size_t)folder + strlen(name) + 1;
    char *beside = malloc(room);
    if (beside)
        snprintf(beside, room, "%.*s%s", folder, path, name);
    return beside;
}

char *cli_beside_program(const char *name) {
    char program[4096];
    const ssize_t length = readlink("/proc/self/exe", program, sizeof program - 1);
    if (length <= 0)
        return NULL;
    program[length] = '\0';
    return cli_beside(program, name);
}
