/* Which steps are stable: limits that are known exactly, scenes and runs made for one way to fail,
 * and studies that are killed. */
#include "fixture_kinds.h"

#include <dirent.h>
#include <signal.h>
#include <sys/wait.h>

#include "driftlab/map.h"
#include "study/oscillator.h"
#include "study/passage.h"
#include "study/trial.h"

/* --- the harmonic oscillator ------------------------------------------------------------------ */

static const char two[] = "name: two\ndimension: 2\nparticles: [{at: [0, 0]}, {at: [1, 0]}]\n"
                          "time: {step: 0.1, end: 1}\n";

static dl_oscillator_limit limit_of(const char *method, const char *option) {
    dl_scene *scene = scene_of_text(two);
    const dl_method_row *row = method_of(method);
    void *options = options_of(row, scene, option);
    const dl_study_unit unit = {
        .scene = scene, .row = row, .options = options, .seconds = 60, .run = dl_run};
    dl_oscillator_limit limit;
    dl_error error = {""};
    if (dl_oscillator_measure(&unit, &limit, &error))
        fail_msg("%s: %s", method, error.message);
    dl_method_options_free(row, options);
    dl_scene_free(scene);
    return limit;
}

/* h omega of a composition of leap-frogs with weights w: where the trace of its matrix leaves
 * [-2, 2] for the first time. */
static double trace(size_t stages, const double *weight, double h) {
    double m[4] = {1, 0, 0, 1};
    for (size_t k = 0; k < stages; k++) {
        const double x = weight[k] * h, a = 1 - x * x / 2, b = x, c = -x * (1 - x * x / 4);
        const double n[4] = {a * m[0] + b * m[2], a * m[1] + b * m[3], c * m[0] + a * m[2],
                             c * m[1] + a * m[3]};
        memcpy(m, n, sizeof m);
    }
    return m[0] + m[3];
}

static void limits_of_theory(void **state) {
    (void)state;
    const double w = 1 / (2 - cbrt(2)), yoshida_4[] = {w, 1 - 2 * w, w};
    double first = 1;
    while (fabs(trace(3, yoshida_4, first)) < 2)
        first += 1e-5;
    assert_true(fabs(first - 1.5734) < 1e-4);
    const struct {
        const char *method, *option;
        double limit;
    } known[] = {
        {"leapfrog", "", 2},
        {"composition-2-verlet", "", 2},
        {"composition-4-yoshida", "", first},
        {"composition-6-yoshida", "", 2.26906}, /* a window from there to 2.328 */
        {"gsl-rk4", "", 2 * sqrt(8)},           /* a step is two half ones of RK4 */
    };
    for (size_t k = 0; k < sizeof known / sizeof *known; k++) {
        const dl_oscillator_limit found = limit_of(known[k].method, known[k].option);
        if (!(fabs(found.stable / known[k].limit - 1) < 5e-4) ||
            !(fabs(found.unstable / known[k].limit - 1) < 5e-4))
            fail_msg("%s: stable to %.6g, unstable from %.6g, expected %.6g", known[k].method,
                     found.stable, found.unstable, known[k].limit);
        assert_string_equal(found.word, "blow-up");
    }
}

static void conserving_has_no_limit(void **state) {
    (void)state;
    const dl_oscillator_limit found = limit_of("conserving-newton-dense", "");
    assert_true(found.stable == dl_oscillator_largest && isnan(found.unstable));
}

/* --- the kind on real runs -------------------------------------------------------------------- */

/* Two particles a little off their equilibrium, where F' = -6: omega^2 = 6 * 2. */
static const char vibrating[] =
    "name: vibrating\ndimension: 2\nparticles:\n  - {at: [0, 0], velocity: [1.0e-3, 0]}\n"
    "  - {at: [1, 0], velocity: [-1.0e-3, 0]}\n"
    "pair_law:\n  - {terms: [{coefficient: -1, power: 7}, {coefficient: 1, power: 13}]}\n"
    "time: {step: 0.05, end: 20}\n";

static void a_pair_breaks_where_theory_says(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(vibrating);
    dl_finding finding = measure(&(asked){.kind = &dl_study_kind_stability,
                                          .scene = scene,
                                          .row = method_of("leapfrog"),
                                          .setting = "points=8"});
    const double omega = sqrt(12);
    expect_verdict(&finding, "limit", "lets expect");
    assert_true(fabs(quantity(&finding, "omega at the start")[0] / omega - 1) < 1e-12);
    assert_true(fabs(quantity(&finding, "h omega limit")[0] / 2 - 1) < 1e-3);
    const double *limit = quantity(&finding, "step limit");
    assert_true(fabs(limit[0] / (2 / omega) - 1) < 0.03);
    assert_true(limit[2] > limit[1] && limit[2] < 1.011 * limit[1]);
    assert_true(fabs(quantity(&finding, "predicted limit")[0] / limit[0] - 1) < 0.05);
    assert_true(fabs(quantity(&finding, "r0")[0] - 1) < 1e-12);
    assert_true(quantity(&finding, "largest speed")[0] >= 1e-3);
    dl_finding_release(&finding);
    finding = measure(&(asked){.kind = &dl_study_kind_stability,
                               .scene = scene,
                               .row = method_of("conserving-newton-dense"),
                               .setting = "points=4 largest=2"});
    expect_verdict(&finding, "no limit found", "no limit up to h omega = 100");
    assert_true(isnan(quantity(&finding, "predicted limit")[0]));
    dl_finding_release(&finding);
    dl_scene_free(scene);
}

static void adaptive_methods_are_refused(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(vibrating);
    dl_error error = {""};
    const asked what = {
        .kind = &dl_study_kind_stability, .scene = scene, .row = method_of("cvode-adams")};
    assert_int_equal(refusal(&what, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "keeps a fixed step"));
    dl_scene_free(scene);
}

/* Tolerances have no use at a fixed step: they are refused, and not told where nobody set them. */
static void tolerances_are_refused_and_not_told(void **state) {
    (void)state;
    static const char *const refused = "rtol", *const value = "1e-3";
    static const char *const keys[] = {"points", "width", "largest", "smallest"};
    static const char *const values[] = {"1", "1", "0.1", "0.05"};
    dl_measure_request request = {.kind = "stability",
                                  .scene = DL_STUDIES "/stream/stream.yaml",
                                  .method = "gsl-rk8pd",
                                  .settings = 1,
                                  .key = &refused,
                                  .value = &value,
                                  .seconds = 20};
    dl_finding finding;
    dl_error error = {""};
    assert_int_equal(dl_study_measure_alone(&request, &finding, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "rtol: found 1e-3, expected none: a study of kind "
                                          "stability keeps steps fixed"));
    assert_null(strstr(error.message, "step="));
    dl_finding_release(&finding);
    request.settings = 4;
    request.key = keys;
    request.value = values;
    if (dl_study_measure_alone(&request, &finding, &error))
        fail_msg("%s", error.message);
    assert_string_equal(finding.options, "");
    assert_int_equal(finding.status, DL_OK);
    dl_finding_release(&finding);
}

/* --- the kind on runs made up ----------------------------------------------------------------- */

static double step_in(const dl_method_row *row, const void *options) {
    const dl_parameter *step = dl_parameter_find(row->options, "step");
    return *(const double *)(const void *)((const char *)options + step->offset);
}

/* Stable up to 0.1, between 0.2 and 0.4; solver failures up to 1, time-outs up to 3; from there its
 * process dies. */
static dl_status made_up(const dl_scene *scene, const dl_method_row *row, const void *options,
                         const dl_run_options *how, dl_run_summary *summary, double *y_final,
                         dl_error *error) {
    (void)scene, (void)y_final, (void)error;
    const double step = step_in(row, options);
    const bool gains = step > 0.1 && step < 0.2;
    if (step > 3)
        raise(SIGKILL);
    dl_run_summary_clear(summary);
    summary->status = gains || step <= 0.4 ? DL_OK : step < 1 ? DL_NONLINEAR_FAILURE : DL_TIMEOUT;
    summary->energy_scale = 2;
    summary->energy_error_max = gains ? 0.5 : 0.01;
    summary->steps = (unsigned long)lround(how->end / step);
    summary->t_end_reached = how->end;
    return DL_OK;
}

static size_t count_lines(const char *lines, const char *word) {
    size_t count = 0;
    for (const char *at = lines; at; at = strchr(at, '\n') ? strchr(at, '\n') + 1 : NULL)
        count += strcspn(at, "\n") == strlen(word) && strncmp(at, word, strlen(word)) == 0;
    return count;
}

static void windows_of_a_made_up_method(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(two);
    const asked what = {.kind = &dl_study_kind_stability,
                        .scene = scene,
                        .row = method_of("leapfrog"),
                        .setting = "unit=time smallest=0.01 largest=4 width=0.001",
                        .run = made_up};
    dl_finding finding = measure(&what);
    expect_verdict(&finding, "limit", "ends in energy gain");
    const double *limit = quantity(&finding, "step limit");
    const double *top = quantity(&finding, "largest stable step");
    assert_true(limit[1] <= 0.1 && limit[2] > 0.1 && limit[2] < 0.1002);
    assert_true(top[1] <= 0.4 && top[2] > 0.4 && top[2] < 0.4008);
    assert_true(quantity(&finding, "unstable windows")[0] == 1);
    assert_true(count_lines(finding.row_words, "stable") > 15);
    assert_true(count_lines(finding.row_words, "energy gain") >= 4);
    assert_true(count_lines(finding.row_words, "solver failure") >= 5);
    assert_true(count_lines(finding.row_words, "time-out") >= 6);
    assert_true(count_lines(finding.row_words, "crash") >= 1);
    assert_true(finding.columns == 5);
    for (size_t row = 0; row < finding.rows; row++) /* a run ends at a whole step, not before 1 */
        if (finding.table[5 * row] < 3)
            assert_true(finding.table[5 * row] * finding.table[5 * row + 3] >= 1 - 1e-9);
    /* again: every bit the same */
    dl_finding again = measure(&what);
    assert_string_equal(again.row_words, finding.row_words);
    assert_memory_equal(again.table, finding.table, finding.rows * 5 * sizeof(double));
    dl_finding_release(&again);
    dl_finding_release(&finding);
    dl_scene_free(scene);
}

static dl_status endless(const dl_scene *scene, const dl_method_row *row, const void *options,
                         const dl_run_options *how, dl_run_summary *summary, double *y_final,
                         dl_error *error) {
    (void)scene, (void)row, (void)options, (void)how, (void)summary, (void)y_final, (void)error;
    volatile bool runs = true;
    while (runs)
        ;
    return DL_OK;
}

/* A step that does not return is an end like others. */
static void a_run_that_hangs_is_a_time_out(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(two);
    const dl_method_row *row = method_of("leapfrog");
    void *options = options_of(row, scene, "");
    const dl_study_unit unit = {.scene = scene,
                                .row = row,
                                .options = options,
                                .end = 1,
                                .sample = 1,
                                .seconds = 0.01,
                                .run = endless};
    const dl_trial_rule rule = {
        .energy = 1, .cold = INFINITY, .straight = INFINITY, .looks = 10, .least = 1, .most = 10};
    dl_trial trial;
    dl_error error = {""};
    assert_int_equal(dl_trial_run_at(&unit, 0.1, &rule, &trial, &error), DL_OK);
    assert_int_equal(trial.end, DL_TRIAL_TIME_OUT);
    assert_non_null(strstr(trial.why, "without an answer"));
    dl_method_options_free(row, options);
    dl_scene_free(scene);
}

/* --- ways to fail ----------------------------------------------------------------------------- */

static void ways_to_fail(void **state) {
    (void)state;
    static const struct {
        const char *scene, *method, *option, *setting, *verdict, *words;
    } ways[] = {
        /* a step jumps over the other particle's core, one that resolves it does not */
        {"particles: [{at: [0, 0]}, {at: [2, 0.1], velocity: [-10, 0]}]\n"
         "pair_law: [{until: 0.5, end: taper, width: 0.2, terms: [{coefficient: 1, power: 9}]}]\n"
         "time: {step: 0.4, end: 0.4}\n",
         "leapfrog", "", "", "tunnelling",
         "particles 1 and 2 passed each other at a distance of 0.1"},
        {"particles: [{at: [0, 0]}, {at: [2, 0.1], velocity: [-10, 0]}]\n"
         "pair_law: [{until: 0.5, end: taper, width: 0.2, terms: [{coefficient: 1, power: 9}]}]\n"
         "time: {step: 0.4, end: 0.4}\n",
         "leapfrog", "step=0.0004", "", "holds", "1000 steps"},
        /* a pair that is allowed to: what attracts has no core */
        {"particles: [{at: [0, 0]}, {at: [2, 0.1], velocity: [-10, 0]}]\n"
         "pair_law: [{until: 0.5, end: taper, width: 0.2, terms: [{coefficient: -1, power: 2}]}]\n"
         "time: {step: 0.4, end: 0.4}\n",
         "leapfrog", "", "", "holds", "1 steps"},
        /* several boxes' widths past the far wall: folded back */
        {"particles: [{at: [0.5, 0.5], velocity: [3.2, 0]}]\nwalls: {x: [0, 1]}\n"
         "time: {step: 1, end: 5}\n",
         "leapfrog", "", "", "holds", "5 steps"},
        {"particles: [{at: [0.5, 0.5], velocity: [3.2, 0]}]\nwalls: {x: [0, 1], rule: located}\n"
         "time: {step: 1, end: 5}\n",
         "leapfrog", "", "", "holds", "energy error 0"},
        {"particles: [{at: [0, 0], velocity: [1, 0]}]\ngravity: [0, -1]\n"
         "time: {step: 0.1, end: 1}\n",
         "leapfrog", "", "straight=1e-12", "bending", "off the line"},
        {"particles: [{at: [0, 0], velocity: [1, 2]}]\ntime: {step: 0.1, end: 100}\n", "leapfrog",
         "", "straight=1e-12", "holds", "1000 steps to t = 100"},
        {"particles: [{at: [0, 0], velocity: [1, 2]}]\ntime: {step: 0.1, end: 1}\n", "leapfrog", "",
         "cold=1e-20", "heating", "kinetic energy"},
        {"particles: [{at: [0, 0]}, {at: [0.1, 0]}]\n"
         "pair_law: [{terms: [{coefficient: 1, power: 13}]}]\ntime: {step: 0.1, end: 1}\n",
         "leapfrog", "", "", "blow-up", "times the energy scale"},
        {"particles: [{at: [0, 0]}, {at: [1.0e-3, 0]}]\n"
         "pair_law: [{terms: [{coefficient: 1, power: 13}]}]\ntime: {step: 0.1, end: 1}\n",
         "gsl-rk4", "", "", "step collapse", "too much accuracy asked"},
    };
    for (size_t i = 0; i < sizeof ways / sizeof *ways; i++) {
        char text[512];
        snprintf(text, sizeof text, "name: way\ndimension: 2\n%s", ways[i].scene);
        dl_scene *scene = scene_of_text(text);
        dl_finding finding = measure(&(asked){.kind = &dl_study_kind_extreme,
                                              .scene = scene,
                                              .row = method_of(ways[i].method),
                                              .option = ways[i].option,
                                              .setting = ways[i].setting});
        if (strcmp(finding.verdict, ways[i].verdict) != 0 || !strstr(finding.reason, ways[i].words))
            fail_msg("way %zu: expected \"%s ... %s\", found \"%s: %s\"", i, ways[i].verdict,
                     ways[i].words, finding.verdict, finding.reason);
        assert_int_equal(finding.rows, 1);
        for (size_t k = 0; k < finding.quantities; k++)
            assert_true(isfinite(finding.quantity[3 * k]));
        dl_finding_release(&finding);
        dl_scene_free(scene);
    }
}

/* What the time loop never leaves behind, a sample of no run may show. */
static void a_particle_outside_has_gone_through(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text("name: box\ndimension: 2\nparticles: [{at: [0.5, 0.5]}]\n"
                                    "walls: {x: [0, 1], y: [0, none]}\ntime: {step: 1, end: 1}\n");
    const struct {
        double x, y;
        bool outside;
    } places[] = {{0.2, 5, false}, {0, 0, false},      {1 + 1e-12, 0, false},
                  {1.1, 0, true},  {-1e-6, 0.5, true}, {0.5, -2, true}};
    dl_passage *passage = NULL;
    assert_int_equal(dl_passage_create(scene, &passage, NULL), DL_OK);
    for (size_t k = 0; k < sizeof places / sizeof *places; k++) {
        const double y_all[] = {places[k].x, places[k].y, 0, 0};
        char where[100];
        assert_int_equal(dl_passage_look(passage,
                                         &(dl_sample){.index = k, .step = k, .y_all = y_all}, where,
                                         sizeof where, NULL),
                         DL_OK);
        assert_string_equal(where, places[k].outside ? "particle 1 is outside the walls" : "");
    }
    dl_passage_free(passage);
    dl_scene_free(scene);
}

static void a_ladder_is_told_by_stretches(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(vibrating);
    dl_finding finding = measure(
        &(asked){.kind = &dl_study_kind_extreme,
                 .scene = scene,
                 .row = method_of("leapfrog"),
                 .setting = "unit=frequency smallest=0.002 largest=2000 least=50 most=500"});
    expect_verdict(&finding, "holds in part", "holds from 0.002 to 0.2; ");
    assert_int_equal(finding.rows, 7);
    assert_true(quantity(&finding, "runs that held")[0] == 3);
    for (size_t row = 0; row < finding.rows; row++) {
        const double *values = finding.table + row * finding.columns;
        assert_true(fabs(values[1] / (2 * pow(10, (double)row - 3)) - 1) < 1e-9);
        assert_true(values[5] <= 500 && values[3] >= 0 && values[3] <= 1);
    }
    dl_finding_release(&finding);
    dl_scene_free(scene);
}

/* Two particles in the steepest repulsion: the first guess of a step is 1e12 times too long, and
 * energy is kept all the same. */
static void conserving_keeps_energy_deep_in_a_core(void **state) {
    (void)state;
    static const char near[] =
        "name: near\ndimension: 2\nparticles: [{at: [0, 0]}, {at: [0.01, 0]}]\n"
        "pair_law:\n  - {terms: [{coefficient: -1, power: 7}, "
        "{coefficient: 1, power: 13}]}\ntime: {step: 0.01, end: 0.1}\n";
    static const char *const method[] = {"conserving-fixed-point", "conserving-newton-dense",
                                         "conserving-newton-klu"};
    dl_scene *scene = scene_of_text(near);
    for (size_t k = 0; k < sizeof method / sizeof *method; k++) {
        dl_finding finding = measure(&(asked){.kind = &dl_study_kind_extreme,
                                              .scene = scene,
                                              .row = method_of(method[k]),
                                              .setting = "bound=1e-13"});
        if (strcmp(finding.verdict, "holds") != 0)
            fail_msg("%s: %s: %s", method[k], finding.verdict, finding.reason);
        dl_finding_release(&finding);
    }
    dl_scene_free(scene);
}

/* Every method, on a crystal in equilibrium: a step below the limit leaves it at rest. */
static void a_cold_crystal_stays_cold(void **state) {
    (void)state;
    static const char crystal[] =
        "name: crystal\ndimension: 2\nparticles:\n"
        "  - lattice: {kind: hexagonal, spacing: 1, rows: [2, 3, 2]}\n"
        "pair_law:\n  - {until: 1.5, terms: [{coefficient: -1, power: 7}, "
        "{coefficient: 1, power: 13}]}\ntime: {step: 0.05, end: 5}\n";
    dl_scene *scene = scene_of_text(crystal);
    for (size_t k = 0; k < dl_method_count(); k++) {
        if (dl_method_row_at(k)->flags & DL_SPLITS_FORCE)
            continue; /* all of the force is one part */
        dl_finding finding = measure(&(asked){.kind = &dl_study_kind_extreme,
                                              .scene = scene,
                                              .row = dl_method_row_at(k),
                                              .setting = "cold=1e-16"});
        if (strcmp(finding.verdict, "holds") != 0)
            fail_msg("%s: %s: %s", dl_method_row_at(k)->name, finding.verdict, finding.reason);
        dl_finding_release(&finding);
    }
    dl_scene_free(scene);
}

/* --- studies ---------------------------------------------------------------------------------- */

static char folder[] = "/tmp/driftlab-stability-XXXXXX";
static char study_path[128], scene_path[128], results_path[128];

static void write_text(const char *path, const char *text) {
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fputs(text, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

static const char scene_text[] =
    "name: pair\ndimension: 2\nlet: {power: 7, v: 0.01}\nparticles:\n"
    "  - {at: [0, 0], velocity: [$v, 0]}\n  - {at: [1, 0], velocity: [-$v, 0]}\n"
    "pair_law:\n  - {terms: [{coefficient: -1, power: $power}, {coefficient: 1, power: "
    "2*$power}]}\ntime: {step: 0.05, end: 5}\n";

static const char study_text[] = "name: test\nkind: stability\nscene: scene.yaml\n"
                                 "let: {power: [4, 7]}\nwith: {points: 3, largest: 3}\n"
                                 "limits: {seconds: 20}\ncases:\n  - {method: leapfrog}\n"
                                 "  - {method: composition-4-yoshida}\n";

static dl_study *read_study(const char *text) {
    dl_study *study = NULL;
    dl_error error = {""};
    write_text(scene_path, scene_text);
    write_text(study_path, text);
    if (dl_study_read(study_path, &study, &error) != DL_OK)
        fail_msg("%s", error.message);
    return study;
}

typedef struct killer {
    size_t after;
} killer;

static void kill_self(void *context, const dl_study_progress *progress) {
    const killer *const k = context;
    if (progress->done >= k->after && strstr(progress->current, "step"))
        raise(SIGKILL); /* in the middle of a unit */
}

static void run_and_die(const dl_study *study, size_t after) {
    killer k = {after};
    const pid_t child = fork();
    if (child == 0) {
        const dl_study_options options = {
            .results = results_path, .on_progress = kill_self, .context = &k};
        dl_results *results;
        dl_study_run(study, &options, &results, NULL);
        _exit(EXIT_SUCCESS);
    }
    int ended = 0;
    assert_int_equal(waitpid(child, &ended, 0), child);
    assert_true(WIFSIGNALED(ended) && WTERMSIG(ended) == SIGKILL);
}

static dl_results *run_study(const dl_study *study) {
    const dl_study_options options = {.results = results_path};
    dl_results *results = NULL;
    dl_error error = {""};
    if (dl_study_run(study, &options, &results, &error) != DL_OK)
        fail_msg("%s", error.message);
    return results;
}

static void assert_same_findings(const dl_results *a, const dl_results *b) {
    assert_int_equal(a->findings, b->findings);
    for (size_t i = 0; i < a->findings; i++) {
        const dl_finding *first = &a->finding[i], *second = &b->finding[i];
        assert_string_equal(first->key, second->key);
        assert_int_equal(first->status, DL_OK);
        assert_string_equal(first->verdict, second->verdict);
        assert_string_equal(first->reason, second->reason);
        assert_string_equal(first->row_words, second->row_words);
        assert_int_equal(first->rows, second->rows);
        assert_memory_equal(first->table, second->table,
                            first->rows * first->columns * sizeof(double));
        assert_memory_equal(first->quantity, second->quantity,
                            3 * first->quantities * sizeof(double));
    }
}

static void a_killed_study_goes_on(void **state) {
    (void)state;
    dl_study *study = read_study(study_text);
    assert_int_equal(dl_study_cases(study), 4);
    dl_results *const whole = run_study(study);
    unlink(results_path);
    run_and_die(study, 0);
    run_and_die(study, 1);
    dl_results *left = NULL;
    assert_int_equal(dl_results_read(results_path, &left, NULL), DL_OK);
    assert_true(left->findings >= 1 && left->findings < 4);
    dl_results *const again = run_study(study);
    assert_true(again->finding[0].cpu_seconds == left->finding[0].cpu_seconds);
    assert_same_findings(whole, again);
    const double *power = dl_finding_quantity(&again->finding[3], "$power");
    assert_true(power && power[0] == 7);
    assert_non_null(strstr(again->finding[3].command, "measure stability "));
    assert_non_null(strstr(again->finding[3].command, " --let power=7 --method"));
    char answer[DL_MESSAGE_SIZE];
    dl_results_answer(again, "pair(power=7)", answer, sizeof answer);
    assert_non_null(strstr(answer, "steps are stable up to"));
    dl_results_free(left);
    dl_results_free(whole);
    dl_results_free(again);
    dl_study_free(study);
}

static size_t count_in_file(const char *path, const char *part) {
    char line[4096];
    size_t count = 0;
    FILE *in = fopen(path, "r");
    assert_non_null(in);
    while (fgets(line, sizeof line, in))
        for (const char *at = line; (at = strstr(at, part)); at++)
            count++;
    fclose(in);
    return count;
}

/* A map has a cell for every step tried of that method, and one a word in its legend. */
static void a_map_shows_every_step(void **state) {
    (void)state;
    dl_study *study = read_study(study_text);
    unlink(results_path);
    dl_results *results = run_study(study);
    char picture[160];
    dl_error error = {""};
    snprintf(picture, sizeof picture, "%s/map.svg", folder);
    if (dl_map_write(results, &(dl_map){.over = "power", .method = "leapfrog"}, picture, &error))
        fail_msg("%s", error.message);
    const size_t cells = results->finding[0].rows + results->finding[2].rows;
    const size_t drawn = count_in_file(picture, "class=\"cell\"");
    assert_true(drawn >= cells + 2 && drawn <= cells + DL_TRIAL_END_COUNT);
    assert_true(count_in_file(picture, "class=\"predicted\"") == 3);
    unlink(picture);
    const struct {
        dl_map map;
        const char *part;
    } bad[] = {
        {{.over = "power"}, "expected one of leapfrog, composition-4-yoshida"},
        {{.over = "powr", .method = "leapfrog"}, "powr"},
        {{.over = "v", .method = "leapfrog"}, "other numbers have to be set"},
        {{.over = "power", .method = "gsl-rk4"}, "no stability of gsl-rk4"},
    };
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        assert_int_equal(dl_map_write(results, &bad[k].map, picture, &error), DL_INPUT);
        if (!strstr(error.message, bad[k].part))
            fail_msg("map %zu: \"%s\" lacks \"%s\"", k, error.message, bad[k].part);
    }
    const dl_map one = {
        .over = "v", .method = "leapfrog", .lets = 1, .let = &(dl_let){"power", "4"}};
    assert_int_equal(dl_map_write(results, &one, picture, &error), DL_OK);
    unlink(picture);
    dl_results_free(results);
    dl_study_free(study);
}

/* In the place of a method, every one of a group but those that split the force; with an option,
 * those that have it. */
static void groups_are_every_method(void **state) {
    (void)state;
    static const struct {
        const char *group;
        unsigned flag;
    } groups[] = {{"all", 0}, {"all-fixed-step", DL_FIXED_STEP}, {"all-adaptive", DL_ADAPTIVE}};
    for (size_t g = 0; g < sizeof groups / sizeof *groups; g++) {
        char text[512];
        snprintf(text, sizeof text,
                 "name: test\nkind: extreme\nscene: scene.yaml\ncases:\n  - {method: %s}\n",
                 groups[g].group);
        dl_study *study = read_study(text);
        size_t expected = 0;
        for (size_t k = 0; k < dl_method_count(); k++)
            expected += (dl_method_row_at(k)->flags & groups[g].flag) == groups[g].flag &&
                        !(dl_method_row_at(k)->flags & DL_SPLITS_FORCE);
        assert_int_equal(dl_study_cases(study), expected);
        dl_study_free(study);
    }
    dl_study *study = read_study("name: test\nkind: extreme\nscene: scene.yaml\ncases:\n"
                                 "  - {method: all-adaptive, max_order: 3}\n");
    size_t expected = 0;
    for (size_t k = 0; k < dl_method_count(); k++)
        expected += dl_parameter_find(dl_method_row_at(k)->options, "max_order") != NULL;
    assert_true(expected > 1);
    assert_int_equal(dl_study_cases(study), expected);
    dl_study_free(study);
}

/* Every study file of the two folders that come with it. */
static void studies_that_come_with_it_are_valid(void **state) {
    (void)state;
    static const char *const folders[] = {DL_STUDIES "/stability", DL_STUDIES "/extreme"};
    for (size_t f = 0; f < 2; f++) {
        DIR *const directory = opendir(folders[f]);
        size_t count = 0;
        assert_non_null(directory);
        for (const struct dirent *entry; (entry = readdir(directory));) {
            const char *const suffix = strrchr(entry->d_name, '.');
            char path[512];
            dl_study *study = NULL;
            dl_error error = {""};
            if (!suffix || strcmp(suffix, ".yaml") != 0)
                continue;
            snprintf(path, sizeof path, "%s/%.200s", folders[f], entry->d_name);
            if (dl_study_read(path, &study, &error))
                fail_msg("%s", error.message);
            assert_true(study->kind == (f ? &dl_study_kind_extreme : &dl_study_kind_stability));
            assert_true(dl_study_cases(study) >= 15);
            dl_study_free(study);
            count++;
        }
        closedir(directory);
        assert_true(count >= 6);
    }
}

static void a_step_is_the_kinds_own(void **state) {
    (void)state;
    dl_study *study = NULL;
    dl_error error = {""};
    write_text(scene_path, scene_text);
    write_text(study_path, "name: test\nkind: stability\nscene: scene.yaml\ncases:\n"
                           "  - {method: leapfrog, step: 0.1}\n");
    assert_int_equal(dl_study_read(study_path, &study, &error), DL_INPUT);
    assert_non_null(strstr(error.message, ":5: "));
    assert_non_null(strstr(error.message, "expected no step"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(limits_of_theory),
        cmocka_unit_test(conserving_has_no_limit),
        cmocka_unit_test(a_pair_breaks_where_theory_says),
        cmocka_unit_test(adaptive_methods_are_refused),
        cmocka_unit_test(tolerances_are_refused_and_not_told),
        cmocka_unit_test(windows_of_a_made_up_method),
        cmocka_unit_test(a_run_that_hangs_is_a_time_out),
        cmocka_unit_test(ways_to_fail),
        cmocka_unit_test(a_particle_outside_has_gone_through),
        cmocka_unit_test(a_ladder_is_told_by_stretches),
        cmocka_unit_test(conserving_keeps_energy_deep_in_a_core),
        cmocka_unit_test(a_cold_crystal_stays_cold),
        cmocka_unit_test(a_killed_study_goes_on),
        cmocka_unit_test(a_map_shows_every_step),
        cmocka_unit_test(groups_are_every_method),
        cmocka_unit_test(a_step_is_the_kinds_own),
        cmocka_unit_test(studies_that_come_with_it_are_valid),
    };
    if (!mkdtemp(folder))
        return EXIT_FAILURE;
    snprintf(study_path, sizeof study_path, "%s/study.yaml", folder);
    snprintf(scene_path, sizeof scene_path, "%s/scene.yaml", folder);
    snprintf(results_path, sizeof results_path, "%s/results.h5", folder);
    const int failed = cmocka_run_group_tests(tests, NULL, NULL);
    unlink(study_path);
    unlink(scene_path);
    unlink(results_path);
    rmdir(folder);
    return failed;
}
