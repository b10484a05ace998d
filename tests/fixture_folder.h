/* A folder of the test's own, made before its tests and removed after them. */
#ifndef FIXTURE_FOLDER_H
#define FIXTURE_FOLDER_H

#include <stdio.h>
#include <stdlib.h>

static char folder[] = "/tmp/driftlab-test-XXXXXX"; /* mkdtemp's letters */

static int make_folder(void **state) {
    (void)state;
    return mkdtemp(folder) ? 0 : -1;
}

static int remove_folder(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

#endif
