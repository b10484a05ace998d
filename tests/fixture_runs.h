/* Scenes and runs for tests of the time loop and of trajectories. */
#ifndef FIXTURE_RUNS_H
#define FIXTURE_RUNS_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "driftlab/run.h"

#define RUNS_FIXTURE static __attribute__((unused))

RUNS_FIXTURE dl_scene *read_scene(const char *path) {
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (dl_scene_read(path, &scene, &error))
        fail_msg("%s", error.message);
    return scene;
}

RUNS_FIXTURE dl_scene *scene_of_text(const char *text) {
    char path[] = "/tmp/driftlab-scene-XXXXXX";
    const int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    assert_int_equal(write(descriptor, text, strlen(text)), (ssize_t)strlen(text));
    close(descriptor);
    dl_scene *scene = read_scene(path);
    unlink(path);
    return scene;
}

RUNS_FIXTURE const dl_method_row *method_of(const char *name) {
    const dl_method_row *row = NULL;
    dl_error error = {""};
    if (dl_method_find(name, &row, &error))
        fail_msg("%s", error.message);
    return row;
}

/* Options of `row` with one of them set ("step=0.01"; "": none). */
RUNS_FIXTURE void *options_of(const dl_method_row *row, const dl_scene *scene,
                              const char *setting) {
    void *options = NULL;
    dl_error error = {""};
    if (dl_method_options_create(row, scene, &options, &error))
        fail_msg("%s", error.message);
    char key[64];
    const size_t length = strcspn(setting, "=");
    if (setting[0]) {
        memcpy(key, setting, length);
        key[length] = '\0';
        if (dl_method_options_set(row, options, key, setting + length + 1, &error))
            fail_msg("%s", error.message);
    }
    return options;
}

typedef struct finished {
    dl_run_summary summary;
    size_t length;
    double *y; /* [length]: 2 * dimension * particles */
} finished;

/* Runs; fails the test where the run could not start. */
RUNS_FIXTURE finished run_with(const dl_scene *scene, const dl_method_row *row, const char *setting,
                               const dl_run_options *how) {
    finished run = {.length = 2 * (size_t)scene->dimension * scene->particles};
    dl_error error = {""};
    void *options = options_of(row, scene, setting);
    run.y = calloc(run.length, sizeof *run.y);
    assert_non_null(run.y);
    if (dl_run(scene, row, options, how, &run.summary, run.y, &error))
        fail_msg("%s on %s: %s", row->name, scene->name, error.message);
    dl_method_options_free(row, options);
    return run;
}

RUNS_FIXTURE dl_run_options run_options(double end, double sample) {
    dl_run_options how;
    dl_run_options_default(&how);
    how.end = end;
    how.sample = sample;
    return how;
}

#endif
