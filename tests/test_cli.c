/* The program as its users and other programs meet it: output, exit status, files. */
#include "fixture_program.h"

#include <sys/stat.h>

#include "driftlab/trajectory.h"

#define DROP   DL_STUDIES "/drop/drop.yaml"
#define KEPLER DL_STUDIES "/kepler/kepler.yaml"

static bool in_folder(const char *name) {
    char path[128];
    struct stat found;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return stat(path, &found) == 0;
}

static size_t lines_of(const char *text) {
    size_t count = 0;
    for (; *text; text++)
        count += *text == '\n';
    return count;
}

static double real_of(const json_t *root, const char *name) {
    const json_t *value = json_object_get(root, name);
    if (!json_is_real(value))
        fail_msg("%s is no real", name);
    return json_real_value(value);
}

static json_int_t count_of(const json_t *root, const char *name) {
    const json_t *value = json_object_get(root, name);
    if (!json_is_integer(value))
        fail_msg("%s is no integer", name);
    return json_integer_value(value);
}

static const char *text_of(const json_t *root, const char *name) {
    const json_t *value = json_object_get(root, name);
    if (!json_is_string(value))
        fail_msg("%s is no string", name);
    return json_string_value(value);
}

/* --- help and lists ------------------------------------------------------------------------- */

static void expect_text(const char *arguments, const char *words) {
    const outcome *o = driftlab(arguments);
    if (o->exit != 0 || o->err[0])
        fail_msg("driftlab %s: exit %d: %s", arguments, o->exit, o->err);
    if (!strstr(o->out, words))
        fail_msg("driftlab %s does not say \"%s\" but:\n%s", arguments, words, o->out);
}

/* What a method cannot do with a scene is part of the explanation, no failure of it. */
static void explains_where_a_method_cannot_run(void **state) {
    (void)state;
    char path[128];
    snprintf(path, sizeof path, "%s/tree.yaml", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs("name: t\ndimension: 2\nkernel: tree\nparticles:\n  - {at: [0, 0]}\n  - {at: [1, 0]}\n"
          "pair_law: [{terms: [{coefficient: -1, power: 2}]}]\ntime: {step: 0.1, end: 1}\n",
          file);
    assert_int_equal(fclose(file), 0);
    expect_text("explain tree.yaml", "conserving not here: ");
}

static void help_everywhere(void **state) {
    (void)state;
    expect_text("--help", "usage: driftlab COMMAND");
    expect_text("help", "usage: driftlab COMMAND");
    static const char *const commands[] = {"run",     "study", "report", "observe",
                                           "explain", "list",  "help"};
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        char arguments[32], words[48];
        snprintf(words, sizeof words, "usage: driftlab %s", commands[i]);
        snprintf(arguments, sizeof arguments, "%s --help", commands[i]);
        expect_text(arguments, words);
        expect_text("--help", commands[i]);
    }
    expect_text("help run", "--time-limit S");
    expect_text("help scene", "pair_law");
    expect_text("help study", "cases");
    expect_text("help method leapfrog", "TR323");
    expect_text("--version", "driftlab ");
    expect_text("--version", "SUNDIALS");
    expect_text("--version", "HDF5");
    expect_text("run --version", "driftlab ");
    expect_text("explain " DROP, "neighbour");
    expect_text("explain " DL_STUDIES "/kepler/kepler.yaml --cost --repeats 1 --seconds 1e-4",
                "| everything |");
    expect_text("list kernels", "neighbour-list");
    expect_text("list statuses", "nonlinear-failure");
    assert_int_equal(driftlab("")->exit, 2);
}

/* How many stages, or what else a step consists of, in the line under which a row is listed. */
static void expect_step(const dl_method_row *row, const dl_method_table *step) {
    char words[160] = "";
    if (step->stages)
        snprintf(words, sizeof words, "%s  (%s, order %d, %d stage", row->name, row->family,
                 step->order, step->stages);
    else if (row->order)
        snprintf(words, sizeof words, "%s  (%s, order %d, %s", row->name, row->family, row->order,
                 row->made_of);
    else
        snprintf(words, sizeof words, "%s  (%s, order varies, %s", row->name, row->family,
                 row->made_of);
    expect_text("list methods", words);
}

static void lists_every_method(void **state) {
    (void)state;
    json_t *list = object_of("list methods --json", 0);
    assert_int_equal(json_array_size(list), dl_method_count());
    for (size_t i = 0; i < dl_method_count(); i++) {
        const dl_method_row *row = dl_method_row_at(i);
        const json_t *method = json_array_get(list, i);
        assert_string_equal(text_of(method, "name"), row->name);
        dl_method_table step = {.order = row->order, .stages = row->stages};
        assert_int_equal(dl_method_default_table(row, &step), row->table != NULL);
        assert_int_equal(count_of(method, "order"), step.order);
        assert_int_equal(count_of(method, "stages"), step.stages);
        expect_step(row, &step);
        assert_int_equal(count_of(method, "forces"), row->forces);
        assert_true(json_array_size(json_object_get(method, "properties")) > 0);
        const json_t *options = json_object_get(method, "options");
        assert_int_equal(json_array_size(options), row->options.count);
        expect_text("list methods", row->name);
        expect_text("list methods", row->doc);
    }
    json_decref(list);
}

/* --- bad input ------------------------------------------------------------------------------ */

static void bad_input_writes_nothing(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *words;
    } cases[] = {
        {"rnu", "did you mean \"run\"?"},
        {"run --method leapfrog", "found nothing, expected SCENE"},
        {"run nowhere.yaml --method leapfrog --out a.h5", "nowhere.yaml"},
        {"run " DROP " --out a.h5", "--method"},
        {"run " DROP " --method leapforg --out a.h5", "did you mean \"leapfrog\"?"},
        {"run " DROP " --method leapfrog --out a.h5 --dt fast", "--dt: step: found \"fast\""},
        {"run " DROP " --method leapfrog --out a.h5 --dt -1", "expected a number > 0"},
        {"run " DROP " --method leapfrog --out a.h5 --dt 7e-4",
         "--dt: step: found 0.0007, expected one that divides the scene's end (" DROP ":14: "},
        {"run " DROP " --method arkode-dirk --out a.h5 --set step=7e-4",
         "--set: step: found 0.0007, expected one that divides the scene's end (" DROP ":14: "},
        {"run " KEPLER " --method leapfrog --dt 1e300", "--dt: step: found 1e+300, expected one"},
        {"run " KEPLER " --method conserving --dt 3.141592653589793",
         "divides the scene's sample (" KEPLER ":14: 1.5707963267948966)"},
        {"run " KEPLER " --method leapfrog --dt 1e-320",
         "--dt: step: found 1e-320, expected at least 6.97574e-15: the scene's end"},
        {"run " KEPLER " --method leapfrog --dt 1e-20 --t-end 62.83185307179586",
         "--t-end: found 62.83185307179586, expected at most 9.0072e-05, 9007199254740992 steps"},
        {"run " KEPLER " --method leapfrog --t-end 1e300",
         "--t-end: found 1e+300, expected at most"},
        {"run " KEPLER " --method gsl-rk8pd --t-end 1e300",
         "--t-end: found 1e+300, expected at most 1.41485e+16, 9007199254740992 of the scene's"},
        {"run " KEPLER " --method gauss-radau-15 --t-end 1e20", "--t-end: found 1e+20"},
        {"run " KEPLER " --method cvode-adams --sample 1e-18",
         "--sample: found 1e-18, expected at least 6.97574e-15"},
        {"run " KEPLER " --method arkode-erk --t-end 1e25", "--t-end: found 1e+25"},
        {"measure drift " KEPLER " --method gsl-rk8pd --t-end 1e20 --sample 1",
         "--sample: found 1, expected at least 1e+14, which makes 1000000 samples"},
        {"measure equilibrium " DL_STUDIES "/stream/stream.yaml --method leapfrog --sample 0.03",
         "sample: found 0.03, expected a whole number of steps of 0.02"},
        {"run " DROP " --method leapfrog --out a.h5 --sample 1.5e-4", "--sample: found 0.00015"},
        {"run " DROP " --method leapfrog --t-end 1.5e-4", "--t-end: found 0.00015"},
        {"run " DROP " --method leapfrog --out a.h5 --t-end x", "--t-end: found \"x\""},
        {"run " DROP " --method leapfrog --out a.h5 --t-end", "--t-end: found nothing"},
        {"run " DROP " --method leapfrog --out a.h5 --rtol 1e-6", "--rtol: method leapfrog"},
        {"run " DROP " --method leapfrog --out a.h5 --set stp=1", "did you mean \"step\"?"},
        {"run " DROP " --method leapfrog --out a.h5 --set step", "expected KEY=VALUE"},
        {"run " DROP " --metod leapfrog --out a.h5", "did you mean \"--method\"?"},
        {"run " DROP " --method leapfrog --json=yes", "expected no value"},
        {"run " DROP " again --method leapfrog", "found \"again\" after SCENE"},
        {"run " DROP " -x --method leapfrog", "unknown option -x"},
        {"run " DROP " --method leapfrog --start none.h5 --out a.h5", "none.h5"},
        {"run " DROP " --method leapfrog --start " DROP " --out a.h5", "no HDF5 file"},
        {"list method", "did you mean \"methods\"?"},
        {"help sceen", "did you mean \"scene\"?"},
        {"help method leapforg", "did you mean \"leapfrog\"?"},
        {"explain nowhere.yaml", "nowhere.yaml"},
        {"explain " DROP " --let speed=1", "the scene has no `let`"},
        {"explain " DROP " --json", "--json: found without --cost"},
        {"explain " DROP " --cost --repeats 0", "repeats"},
        {"explain " DROP " --let speed", "expected NAME=NUMBER"},
        {"map " DROP " --over speed", "expected a results file"},
        {"map " DROP, "--over: found none"},
        {"study nowhere.yaml", "nowhere.yaml"},
    };
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        const outcome *o = driftlab(cases[i].arguments);
        if (o->exit != 2 || o->out[0] || lines_of(o->err) != 1 || !strstr(o->err, cases[i].words) ||
            strncmp(o->err, "driftlab: ", 10) != 0)
            fail_msg("driftlab %s: exit %d, stdout \"%.80s\", stderr \"%s\", expected \"%s\"",
                     cases[i].arguments, o->exit, o->out, o->err, cases[i].words);
        assert_false(in_folder("a.h5"));
    }
}

/* --- run ------------------------------------------------------------------------------------ */

static void json_is_the_summary(void **state) {
    (void)state;
    json_t *root = object_of("run " DROP " --method leapfrog --t-end 0.02 --json", 0);
    dl_scene *scene = read_scene(DROP);
    const dl_run_options how = run_options(0.02, 0);
    finished run = run_with(scene, method_of("leapfrog"), "", &how);
    const dl_run_summary *s = &run.summary;
    assert_string_equal(text_of(root, "scene"), "drop-mass-10");
    assert_string_equal(text_of(root, "method"), "leapfrog");
    assert_string_equal(text_of(root, "status"), "ok");
    assert_string_equal(text_of(root, "message"), "");
    assert_true(real_of(json_object_get(root, "options"), "step") == 1e-4);
    /* 17 digits give back every bit. */
    assert_true(real_of(root, "energy_initial") == s->energy_initial);
    assert_true(real_of(root, "energy_final") == s->energy_final);
    assert_true(real_of(root, "energy_scale") == s->energy_scale);
    assert_true(real_of(root, "energy_error_max") == s->energy_error_max);
    assert_true(real_of(root, "energy_error_final") == s->energy_error_final);
    assert_true(real_of(root, "ledger") == s->ledger && s->ledger > 0);
    assert_true(real_of(root, "momentum_error_max") == s->momentum_error_max);
    assert_true(real_of(root, "momentum_scale") == s->momentum_scale);
    assert_true(real_of(root, "kinetic_energy_per_particle") == s->kinetic_energy_per_particle);
    assert_true(real_of(root, "t_end_reached") == 0.02);
    assert_true(real_of(root, "cpu_seconds") > 0);
    /* Walls and gravity: no angular momentum to conserve, and no NaN in JSON. */
    assert_true(json_is_null(json_object_get(root, "angular_momentum_error_max")));
    assert_int_equal(count_of(root, "steps"), 200);
    assert_int_equal(count_of(root, "samples"), s->samples);
    assert_int_equal(count_of(root, "force_evaluations"), s->force_evaluations);
    assert_int_equal(count_of(root, "jacobian_evaluations"), 0);
    assert_int_equal(count_of(root, "nonlinear_iterations"), 0);
    assert_int_equal(count_of(root, "wall_hits"), s->wall_hits);
    json_decref(root);
    free(run.y);
    dl_scene_free(scene);
}

static void table_for_people(void **state) {
    (void)state;
    const outcome *o = driftlab("run " DROP " --method leapfrog --t-end 0.01 --dt=5e-5");
    assert_int_equal(o->exit, 0);
    assert_string_equal(o->err, ""); /* no progress where nobody looks */
    assert_non_null(strstr(o->out, "drop-mass-10 with leapfrog step=5e-05\n"));
    assert_non_null(strstr(o->out, "steps                      200\n"));
    assert_null(strstr(o->out, "nan"));
    assert_null(strstr(o->out, "Jacobian"));
}

static void dt_is_the_option_step(void **state) {
    (void)state;
    json_t *a = object_of("run " DROP " --method leapfrog --t-end 0.01 --dt 5e-5 --json", 0);
    json_t *b = object_of("run --set step=5e-5 --method leapfrog --t-end 0.01 --json " DROP, 0);
    assert_true(json_equal(json_object_get(a, "options"), json_object_get(b, "options")));
    assert_true(real_of(a, "energy_final") == real_of(b, "energy_final"));
    json_decref(a);
    json_decref(b);
}

/* Mirrors act at the ends of steps: a warning where a method chooses those. */
static void mirrors_and_chosen_steps_are_warned_of(void **state) {
    (void)state;
    static const char scene[] = DL_STUDIES "/drop/settled.yaml";
    static const struct {
        const char *options;
        bool warned;
    } runs[] = {{"--method gsl-rk8pd", true},
                {"--method cvode-adams", true},
                {"--method gsl-rk8pd --dt 1e-5", false},
                {"--method leapfrog", false}};
    for (size_t k = 0; k < sizeof runs / sizeof *runs; k++) {
        char line[256];
        snprintf(line, sizeof line, "run %s %s --t-end 1e-4", scene, runs[k].options);
        const outcome *o = driftlab(line);
        assert_int_equal(o->exit, 0);
        assert_int_equal(strstr(o->err, "the rule mirror act at the ends of steps") != NULL,
                         runs[k].warned);
    }
}

static void failed_run_is_told_twice(void **state) {
    (void)state;
    json_t *root =
        object_of("run " DROP " --method leapfrog --dt 0.01 --t-end 1 --sample 0.1 --json", 1);
    assert_string_equal(text_of(root, "status"), "unstable");
    assert_non_null(strstr(text_of(root, "message"), "energy"));
    char words[2000];
    read_file(".err", words, sizeof words);
    assert_non_null(strstr(words, text_of(root, "message")));
    json_decref(root);
    root = object_of("run " DROP " --method leapfrog --t-end 1e5 --time-limit 0.1 --json", 1);
    assert_string_equal(text_of(root, "status"), "timeout");
    assert_true(real_of(root, "t_end_reached") < 1e5);
    json_decref(root);
}

/* What a method cannot do is told in words of the run, without a NaN or an infinity. */
static void wild_numbers_are_told(void **state) {
    (void)state;
    static const struct {
        const char *arguments, *status, *message, *choice;
    } runs[] = {
        {"--method conserving --dt 1e300 --t-end 1e300 --sample 1e300", "unstable", "not finite",
         "what a fixed point leaves of an error cannot be told"},
        {"--method cvode-adams --t-end 1e-300", "step-failure", "cannot go from t = 0 to 1e-300",
         ""},
        {"--method arkode-erk --t-end 1e-300", "step-failure", "cannot go from t = 0 to 1e-300",
         ""},
        {"--method gsl-bsimp --rtol 0 --set atol=1e-300", "step-failure",
         "however short: too much accuracy asked", ""},
    };
    for (size_t k = 0; k < sizeof runs / sizeof *runs; k++) {
        char line[300];
        snprintf(line, sizeof line, "run " KEPLER " %s --json", runs[k].arguments);
        json_t *root = object_of(line, 1);
        assert_string_equal(text_of(root, "status"), runs[k].status);
        if (!strstr(text_of(root, "message"), runs[k].message) ||
            !strstr(text_of(root, "choice"), runs[k].choice))
            fail_msg("%s: %s; %s", line, text_of(root, "message"), text_of(root, "choice"));
        json_decref(root);
    }
}

static double *last_frame(const dl_scene *scene, const char *name) {
    char path[128];
    double *y_all = NULL, time = 0;
    dl_error error = {""};
    snprintf(path, sizeof path, "%s/%s", folder, name);
    if (dl_trajectory_read_last(path, scene, &y_all, &time, &error))
        fail_msg("%s", error.message);
    return y_all;
}

static void start_goes_on(void **state) {
    (void)state;
    static const char stream[] = DL_STUDIES "/stream/stream.yaml";
    dl_scene *scene = read_scene(stream);
    char arguments[600];
    static const char *const runs[] = {"--t-end 0.4 --out whole.h5", "--t-end 0.2 --out half.h5",
                                       "--t-end 0.2 --start half.h5 --out rest.h5"};
    for (size_t i = 0; i < 3; i++) {
        snprintf(arguments, sizeof arguments, "run %s --method composition-2-verlet %s", stream,
                 runs[i]);
        assert_int_equal(driftlab(arguments)->exit, 0);
    }
    double *whole = last_frame(scene, "whole.h5"), *half = last_frame(scene, "half.h5"),
           *rest = last_frame(scene, "rest.h5");
    const size_t size = 4 * scene->particles * sizeof *whole;
    assert_memory_equal(whole, rest, size);
    assert_memory_not_equal(whole, half, size);
    free(whole);
    free(half);
    free(rest);
    dl_scene_free(scene);
}

static void writing_that_fails(void **state) {
    (void)state;
    const outcome *o = driftlab("run " DROP " --method leapfrog --out nowhere/a.h5");
    assert_int_equal(o->exit, 3);
    assert_string_equal(o->out, "");
    assert_non_null(strstr(o->err, "nowhere/a.h5"));
    /* A limit on file size stands for a full disk. */
    char command[1000];
    snprintf(command, sizeof command,
             "cd %s && (ulimit -f 100; %s run " DROP
             " --method leapfrog --out full.h5 2>&1) | grep -q 'File too large'",
             folder, DL_PROGRAM);
    assert_int_equal(system(command), 0);
    assert_false(in_folder("full.h5"));
    snprintf(command, sizeof command,
             "%s run " DROP " --method leapfrog --t-end 1e-3 >/dev/full 2>/dev/null", DL_PROGRAM);
    assert_int_equal(WEXITSTATUS(system(command)), 3);
}

static void signal_stops_cleanly(void **state) {
    (void)state;
    static const char *const signals[] = {"INT", "TERM"};
    dl_scene *scene = read_scene(DROP);
    for (size_t i = 0; i < 2; i++) {
        char command[1000];
        snprintf(command, sizeof command,
                 "cd %s && rm -f stopped.h5 && { %s run " DROP
                 " --method leapfrog --t-end 1e5 --sample 10 --json --out stopped.h5 >.out 2>.err &"
                 " sleep 1; kill -%s $!; wait $!; }",
                 folder, DL_PROGRAM, signals[i]);
        assert_int_equal(WEXITSTATUS(system(command)), 130);
        char text[4000];
        read_file(".out", text, sizeof text);
        json_t *root = json_loads(text, 0, NULL);
        assert_non_null(root);
        assert_string_equal(text_of(root, "status"), "interrupted");
        json_decref(root);
        double *y_all = last_frame(scene, "stopped.h5"); /* the trajectory is kept */
        free(y_all);
    }
    dl_scene_free(scene);
}

/* Before there is a run: particles are sought places for, for ever. */
static void signal_ends_reading(void **state) {
    (void)state;
    static const char *const signals[] = {"INT", "TERM"};
    for (size_t i = 0; i < 2; i++) {
        char command[1000], text[4000];
        snprintf(
            command, sizeof command,
            "cd %s && printf 'name: dense\\ndimension: 2\\nparticles: [{random: {count: 1000, "
            "in: [[0, 1], [0, 1]], minimum_distance: 1, tries: 1000000000}}]\\n"
            "time: {step: 0.1, end: 1}\\n' >dense.yaml && { %s run dense.yaml --method leapfrog "
            ">.out 2>.err & sleep 0.3; kill -%s $!; wait $!; }",
            folder, DL_PROGRAM, signals[i]);
        assert_int_equal(WEXITSTATUS(system(command)), 130);
        read_file(".err", text, sizeof text);
        assert_string_equal(text, "driftlab: interrupted\n");
    }
}

/* Every command has the same words for a file that was cut off. */
static void damaged_files_are_told_alike(void **state) {
    (void)state;
    static const char *const commands[] = {"run " DROP " --method leapfrog --start cut.h5",
                                           "observe cut.h5", "report cut.h5"};
    char command[1000];
    assert_int_equal(driftlab("run " DROP " --method leapfrog --t-end 1e-3 --out whole.h5")->exit,
                     0);
    snprintf(command, sizeof command, "cd %s && head -c 3000 whole.h5 >cut.h5", folder);
    assert_int_equal(system(command), 0);
    for (size_t i = 0; i < sizeof commands / sizeof *commands; i++) {
        const outcome *o = driftlab(commands[i]);
        if (o->exit != 2 || !strstr(o->err, "cut.h5: found a damaged or truncated HDF5 file"))
            fail_msg("%s: exit %d, \"%s\"", commands[i], o->exit, o->err);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(explains_where_a_method_cannot_run),
        cmocka_unit_test(help_everywhere),
        cmocka_unit_test(lists_every_method),
        cmocka_unit_test(bad_input_writes_nothing),
        cmocka_unit_test(json_is_the_summary),
        cmocka_unit_test(table_for_people),
        cmocka_unit_test(dt_is_the_option_step),
        cmocka_unit_test(mirrors_and_chosen_steps_are_warned_of),
        cmocka_unit_test(failed_run_is_told_twice),
        cmocka_unit_test(wild_numbers_are_told),
        cmocka_unit_test(start_goes_on),
        cmocka_unit_test(writing_that_fails),
        cmocka_unit_test(signal_stops_cleanly),
        cmocka_unit_test(signal_ends_reading),
        cmocka_unit_test(damaged_files_are_told_alike),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
