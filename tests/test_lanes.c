/* Parts of a study side by side: the same results as one after the other, and a process that is
 * lost costs nothing but its part's time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>
#include "study/child.h"
#include "study/lanes.h"
#include "study/plan.h"
#include "study/process.h"

enum { parts = 12 };

typedef struct told {
    size_t begun, ticks, order[parts], answers;
    pid_t by[parts];
    volatile int interrupt;
    long lost_part; /* whose lane kills itself, or -1 */
} told;

typedef struct answer {
    size_t part;
    pid_t by;
} answer;

static void say_who(void *context, size_t part, int pipe) {
    const told *seen = context;
    if (seen->lost_part == (long)part)
        raise(SIGKILL);
    const answer sent = {part, getpid()};
    usleep(2000);
    dl_child_send(pipe, &sent, sizeof sent);
}

static void begun(void *context, size_t part) {
    ((told *)context)->begun += part < parts;
}

static dl_status answered(void *context, size_t part, const void *data, size_t size,
                          dl_error *error) {
    (void)error;
    told *seen = context;
    answer got;
    assert_int_equal(size, sizeof got);
    memcpy(&got, data, sizeof got);
    assert_int_equal(got.part, part);
    seen->by[part] = got.by;
    seen->order[seen->answers++] = part;
    return DL_OK;
}

static void tick(void *context) {
    ((told *)context)->ticks++;
}

static dl_lanes_work work_of(told *seen) {
    return (dl_lanes_work){.work = say_who,
                           .begun = begun,
                           .receive = answered,
                           .tick = tick,
                           .context = seen,
                           .interrupt = &seen->interrupt};
}

static void every_part_is_done_once_by_several(void **state) {
    (void)state;
    told seen = {.lost_part = -1};
    const dl_lanes_work work = work_of(&seen);
    bool done[parts] = {[3] = true, [4] = true};
    assert_int_equal(dl_lanes_run(&work, 3, parts, done, NULL), DL_OK);
    assert_int_equal(seen.answers, parts - 2);
    assert_int_equal(seen.begun, parts - 2);
    pid_t others = 0;
    for (size_t i = 0; i < parts; i++) {
        assert_true(done[i]);
        assert_int_equal(seen.by[i] == 0, i == 3 || i == 4);
        assert_int_not_equal(seen.by[i], getpid());
        others += seen.by[i] && seen.by[i] != seen.by[0];
    }
    assert_true(others > 0);
}

static void a_lost_lane_costs_its_part(void **state) {
    (void)state;
    told seen = {.lost_part = 2};
    const dl_lanes_work work = work_of(&seen);
    bool done[parts] = {false};
    assert_int_equal(dl_lanes_run(&work, 2, parts, done, NULL), DL_OK);
    for (size_t i = 0; i < parts; i++)
        assert_int_equal(done[i], i != 2);
    bool again[parts] = {false};
    seen.answers = 0;
    assert_int_equal(dl_lanes_run(&work, 1, parts, again, NULL), DL_OK);
    for (size_t i = 0; i < parts; i++)
        assert_int_equal(again[i], i < 2); /* the only one is gone */
}

static void an_interrupt_ends_all(void **state) {
    (void)state;
    told seen = {.lost_part = -1, .interrupt = 1};
    const dl_lanes_work work = work_of(&seen);
    bool done[parts] = {false};
    dl_error error = {""};
    assert_int_equal(dl_lanes_run(&work, 2, parts, done, &error), DL_INTERRUPTED);
    assert_true(seen.answers < parts);
}

/* --- a study ------------------------------------------------------------------------------- */

static char folder[] = "/tmp/driftlab-lanes-XXXXXX";
static char study_path[128], results_path[128];

static void write_text(const char *name, const char *text) {
    char path[160];
    snprintf(path, sizeof path, "%s/%s", folder, name);
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fputs(text, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

static dl_study *read_study(void) {
    dl_study *study = NULL;
    dl_error error = {""};
    write_text("scene.yaml", "name: pair\ndimension: 2\nparticles:\n"
                             "  - {at: [-0.1, 0], velocity: [0, -0.5], mass: 0.75}\n"
                             "  - {at: [0.3, 0], velocity: [0, 1.5], mass: 0.25}\n"
                             "pair_law:\n  - {terms: [{coefficient: -1, power: 2}]}\n"
                             "time: {step: 0.01, end: 2}\n");
    write_text("study.yaml", "name: test\nscene: scene.yaml\nsamples: 4\nerror: 1e-4\nrepeats: 2\n"
                             "limits: {seconds: 5}\nreference: {exact: kepler}\ncases:\n"
                             "  - {method: leapfrog, step: [0.01, 0.005, 0.0025]}\n"
                             "  - {method: gsl-rk8pd, rtol: [1e-8, 1e-10, 1e-12], atol: 1e-13}\n");
    if (dl_study_read(study_path, &study, &error) != DL_OK)
        fail_msg("%s", error.message);
    return study;
}

static dl_results *run_study(const dl_study *study, size_t processes) {
    const dl_study_options options = {
        .results = results_path, .force = true, .processes = processes};
    dl_results *results = NULL;
    dl_error error = {""};
    if (dl_study_run(study, &options, &results, &error) != DL_OK)
        fail_msg("%s", error.message);
    return results;
}

static void assert_same(const dl_results *a, const dl_results *b) {
    assert_int_equal(a->cases, b->cases);
    for (size_t i = 0; i < a->cases; i++) {
        const dl_case *x = &a->cased[i], *y = &b->cased[i];
        assert_string_equal(x->key, y->key);
        assert_int_equal(x->summary.status, DL_OK);
        assert_int_equal(x->summary.force_evaluations, y->summary.force_evaluations);
        assert_memory_equal(&x->position_error, &y->position_error, sizeof x->position_error);
        assert_int_equal(x->samples, y->samples);
        assert_memory_equal(x->sample_energy_error, y->sample_energy_error,
                            x->samples * sizeof *x->sample_energy_error);
        assert_memory_equal(x->sample_momentum_error, y->sample_momentum_error,
                            x->samples * sizeof *x->sample_momentum_error);
        assert_string_equal(x->command, y->command);
        assert_int_equal(x->repeats, y->repeats);
    }
}

static void a_study_side_by_side_finds_the_same(void **state) {
    (void)state;
    if (dl_process_processors() < 2)
        skip();
    dl_study *study = read_study();
    dl_results *one = run_study(study, 1), *two = run_study(study, 2);
    assert_same(one, two);
    dl_results_free(one);
    dl_results_free(two);
    dl_study_free(study);
}

/* Kills the lane above the case's process, once. */
static dl_status kill_the_lane(const dl_scene *scene, const dl_method_row *row, const void *options,
                               const dl_run_options *run_options, dl_run_summary *summary,
                               double *y_final, dl_error *error) {
    char mark[160];
    snprintf(mark, sizeof mark, "%s/killed", folder);
    if (access(mark, F_OK) != 0 && strcmp(row->name, "gsl-rk8pd") == 0) {
        write_text("killed", "");
        kill(getppid(), SIGKILL);
    }
    return dl_run(scene, row, options, run_options, summary, y_final, error);
}

static void a_study_survives_a_lost_lane(void **state) {
    (void)state;
    if (dl_process_processors() < 2)
        skip();
    dl_study *study = read_study();
    dl_results *one = run_study(study, 1);
    study->run = kill_the_lane;
    dl_results *two = run_study(study, 2);
    char mark[160];
    snprintf(mark, sizeof mark, "%s/killed", folder);
    assert_int_equal(unlink(mark), 0);
    assert_same(one, two);
    dl_results_free(one);
    dl_results_free(two);
    dl_study_free(study);
}

static void more_than_processors_is_refused(void **state) {
    (void)state;
    dl_study *study = read_study();
    const dl_study_options options = {.results = results_path,
                                      .processes = dl_process_processors() + 1};
    dl_results *results = NULL;
    dl_error error = {""};
    assert_int_equal(dl_study_run(study, &options, &results, &error), DL_INPUT);
    assert_null(results);
    assert_non_null(strstr(error.message, "processes"));
    dl_study_free(study);
}

static int set_up(void **state) {
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(study_path, sizeof study_path, "%s/study.yaml", folder);
    snprintf(results_path, sizeof results_path, "%s/results.h5", folder);
    return 0;
}

static int tear_down(void **state) {
    (void)state;
    char command[128];
    snprintf(command, sizeof command, "rm -r %s", folder);
    return system(command);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_part_is_done_once_by_several),
        cmocka_unit_test(a_lost_lane_costs_its_part),
        cmocka_unit_test(an_interrupt_ends_all),
        cmocka_unit_test(a_study_side_by_side_finds_the_same),
        cmocka_unit_test(a_study_survives_a_lost_lane),
        cmocka_unit_test(more_than_processors_is_refused),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}
