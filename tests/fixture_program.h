/* The program as a test runs it, in a folder of the test's own. */
#ifndef FIXTURE_PROGRAM_H
#define FIXTURE_PROGRAM_H

#include "fixture_folder.h"
#include "fixture_runs.h"

#include <jansson.h>
#include <sys/wait.h>

typedef struct outcome {
    int exit;
    char out[200000], err[4000];
} outcome;

static void read_file(const char *name, char *text, size_t size) {
    char path[128];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    text[fread(text, 1, size - 1, file)] = '\0';
    fclose(file);
}

/* `BEFORE driftlab ARGUMENTS` in the folder of this test. */
static outcome *driftlab_after(const char *before, const char *arguments) {
    static outcome last;
    char command[2000];
    snprintf(command, sizeof command, "cd %s && %s %s %s >.out 2>.err", folder, before, DL_PROGRAM,
             arguments);
    const int status = system(command);
    assert_true(WIFEXITED(status));
    last.exit = WEXITSTATUS(status);
    read_file(".out", last.out, sizeof last.out);
    read_file(".err", last.err, sizeof last.err);
    return &last;
}

static outcome *driftlab(const char *arguments) {
    return driftlab_after("", arguments);
}

static json_t *object_of(const char *arguments, int exit) {
    const outcome *o = driftlab(arguments);
    if (o->exit != exit)
        fail_msg("%s: exit %d: %s", arguments, o->exit, o->err);
    json_error_t where;
    json_t *root = json_loads(o->out, 0, &where);
    if (!root)
        fail_msg("%s: %s", arguments, where.text);
    return root;
}

#endif
