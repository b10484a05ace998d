/* The one time loop: the papers' program reproduced, the ledger, samples, limits and failures. */
#include <time.h>
#include "fixture_runs.h"
#include "fixture_scenes.h"

#include "observe/schedule.h"
#include "observe/stopwatch.h"

#define DROP DL_STUDIES "/drop/drop.yaml"

/* Three particles without pair forces bounce in a box under gravity. */
static const char bouncing[] = "name: bouncing\n"
                               "dimension: 2\n"
                               "particles:\n"
                               "  - {at: [1, 1], velocity: [3, 0], mass: 1}\n"
                               "  - {at: [2, 0.5], velocity: [-5, 1], mass: 2}\n"
                               "  - {at: [3.9, 2], velocity: [7, -2], mass: 0.5}\n"
                               "gravity: [0, -9.81]\n"
                               "walls: {x: [0, 4], y: [0, none], damping: 0.25}\n"
                               "time: {step: 0.001, end: 4}\n";

/* Two bodies that attract; nothing else. */
static const char pair[] = "name: pair\n"
                           "dimension: 2\n"
                           "particles:\n"
                           "  - {at: [0.5, 0], velocity: [0, 0.5], mass: 1}\n"
                           "  - {at: [-0.5, 0], velocity: [0, -0.5], mass: 1}\n"
                           "pair_law:\n"
                           "  - {terms: [{coefficient: -1, power: 2}]}\n"
                           "time: {step: 0.01, end: 1}\n";

/* --- schedule ------------------------------------------------------------------------------- */

static void schedule_of_fixed_steps(void **state) {
    (void)state;
    dl_schedule schedule;
    assert_int_equal(dl_schedule_create(0.0823, 1e-3, 1e-4, &schedule, NULL), DL_OK);
    assert_int_equal(schedule.steps, 823);
    assert_int_equal(schedule.samples, 83);
    assert_int_equal(dl_schedule_step(&schedule, 1), 10);
    assert_int_equal(dl_schedule_step(&schedule, 82), 820);
    assert_int_equal(dl_schedule_step(&schedule, 83), 823);
    assert_true(dl_schedule_time(&schedule, 83) == 0.0823);
    assert_true(dl_schedule_time(&schedule, 7) == 7 * 1e-3);
}

static void schedule_chosen_has_at_most_50_intervals(void **state) {
    (void)state;
    for (size_t steps = 1; steps < 400; steps++) {
        dl_schedule schedule;
        const double end = 0.01 * (double)steps;
        assert_int_equal(dl_schedule_create(end, 0, 0.01, &schedule, NULL), DL_OK);
        assert_int_equal(schedule.steps, steps);
        assert_in_range(schedule.samples, 1, 50);
        assert_true(steps > 50 || schedule.samples == steps);
        assert_int_equal(dl_schedule_step(&schedule, schedule.samples), steps);
        assert_true(schedule.samples < 2 ||
                    dl_schedule_step(&schedule, schedule.samples - 1) < steps);
    }
}

static void schedule_of_an_adaptive_method(void **state) {
    (void)state;
    dl_schedule schedule;
    assert_int_equal(dl_schedule_create(1.0, 0.1, 0, &schedule, NULL), DL_OK);
    assert_int_equal(schedule.samples, 10);
    assert_int_equal(dl_schedule_create(1.05, 0.1, 0, &schedule, NULL), DL_OK);
    assert_int_equal(schedule.samples, 11);
    assert_true(dl_schedule_time(&schedule, 11) == 1.05);
    assert_int_equal(dl_schedule_create(0.07, 0.01, 0, &schedule, NULL), DL_OK);
    assert_int_equal(schedule.samples, 7); /* though 0.07 / 0.01 is 7.000000000000001 */
    assert_int_equal(dl_schedule_create(3, 0, 0, &schedule, NULL), DL_OK);
    assert_int_equal(schedule.samples, 50);
}

static void schedule_refuses_parts_of_steps(void **state) {
    (void)state;
    dl_schedule schedule;
    dl_error error = {""};
    assert_int_equal(dl_schedule_create(0.1234, 0, 1e-3, &schedule, &error), DL_INPUT);
    assert_string_equal(error.message, "end: found 0.1234, expected a whole number of steps of "
                                       "0.001 (the nearest is 0.123)");
    assert_int_equal(dl_schedule_create(0.1, 2.5e-3, 1e-3, &schedule, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "sample: found 0.0025, expected a whole number"));
    assert_int_equal(dl_schedule_create(-1, 0, 1e-3, &schedule, &error), DL_INPUT);
    assert_int_equal(dl_schedule_create(1, -1, 1e-3, &schedule, &error), DL_INPUT);
    assert_int_equal(dl_schedule_create(INFINITY, 0, 0, &schedule, &error), DL_INPUT);
}

/* A count that no integer holds would be a run without a step that ends well. */
static void schedule_refuses_too_many(void **state) {
    (void)state;
    static const double ends[] = {1e19, 1e20, 1e25, 1e300};
    dl_schedule schedule;
    dl_error error = {""};
    for (size_t k = 0; k < sizeof ends / sizeof *ends; k++) {
        assert_int_equal(dl_schedule_create(ends[k], 1, 0, &schedule, &error), DL_INPUT);
        assert_non_null(strstr(error.message, "sample: found 1, expected at least "));
        assert_non_null(strstr(error.message, "9007199254740992 samples up to "));
        assert_int_equal(dl_schedule_create(ends[k], 0, 1, &schedule, &error), DL_INPUT);
        assert_non_null(strstr(error.message, "expected at most 9.0072e+15, 9007199254740992 "
                                              "steps of 1"));
        assert_int_equal(dl_schedule_create(ends[k], 0, 0, &schedule, &error), DL_OK);
        assert_int_equal(schedule.samples, 50);
    }
    assert_int_equal(dl_schedule_create(1e300, 1e-300, 0, &schedule, &error), DL_INPUT);
    assert_null(strstr(error.message, "inf"));
    assert_int_equal(dl_schedule_create(62.8, 0, 1e-320, &schedule, &error), DL_INPUT);
    assert_null(strstr(error.message, "inf"));
    assert_int_equal(dl_schedule_create(1.7e308, 0, 1.1e308, &schedule, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "(the nearest is 1.1e+308)"));
    assert_int_equal(dl_schedule_create(DL_MOST_STEPS, 1, 0, &schedule, &error), DL_OK);
    assert_true((double)schedule.samples == DL_MOST_STEPS);
}

static void expect_refusal(const dl_scene *scene, double end, double sample, double step,
                           const char *words) {
    dl_schedule schedule;
    dl_error error = {""};
    assert_int_equal(dl_schedule_of_scene(scene, end, sample, step, &schedule, &error), DL_INPUT);
    if (strncmp(error.message, words, strlen(words)) != 0)
        fail_msg("found \"%s\", expected \"%s\"", error.message, words);
}

/* The scene's times are whole numbers of its own step. */
static void schedule_blames_what_was_given(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text("name: timed\ndimension: 2\nparticles: [{at: [0, 0]}]\n"
                                    "time:\n  step: 0.1\n  end: 1.2\n  sample: 0.3\n");
    char words[300];
    expect_refusal(scene, 0, 0, 0.7, "step: found 0.7, expected one that divides the scene's end");
    snprintf(words, sizeof words,
             "step: found 0.5, expected one that divides the scene's end (%s:6: 1.2) into a whole "
             "number of steps (the nearest is 0.6)",
             scene->file);
    expect_refusal(scene, 0, 0, 0.5, words);
    snprintf(words, sizeof words,
             "step: found 0.4, expected one that divides the scene's sample (%s:7: 0.3) into a "
             "whole number of steps (the nearest is 0.3)",
             scene->file);
    expect_refusal(scene, 0, 0, 0.4, words);
    snprintf(
        words, sizeof words,
        "step: found 1e-20, expected at least 1.33227e-16: the scene's end (%s:6: 1.2) is more "
        "than 9007199254740992 such steps",
        scene->file);
    expect_refusal(scene, 0, 0, 1e-20, words);
    expect_refusal(scene, 1, 0, 0.4, "end: found 1, expected a whole number of steps of 0.4");
    expect_refusal(scene, 0, 0.25, 0.1, "sample: found 0.25, expected a whole number of steps");
    expect_refusal(scene, 0, 1e-20, 0, "sample: found 1e-20, expected at least 1.33227e-16, which");
    snprintf(words, sizeof words,
             "end: found 1e+20, expected at most 2.70216e+15, 9007199254740992 of the scene's "
             "samples (%s:7: 0.3)",
             scene->file);
    expect_refusal(scene, 1e20, 0, 0, words);
    dl_scene_free(scene);
}

static void run_refuses_parts_of_steps(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(pair);
    const dl_method_row *row = method_of("leapfrog");
    void *options = options_of(row, scene, "");
    const dl_run_options how = run_options(0.105, 0);
    dl_run_summary summary;
    dl_error error = {""};
    assert_int_equal(dl_run(scene, row, options, &how, &summary, NULL, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "end: found 0.105"));
    dl_method_options_free(row, options);
    dl_scene_free(scene);
}

/* --- TR323's program, written again --------------------------------------------------------- */

/* The motion is chaotic: from step 0 to 823 a change in a last bit grows by a factor of 1e7. The
 * order in which a double loop adds its forces alone changes the positions at step 823 by 3e-10 and
 * the velocities by 8e-8. Here forces are summed in long double, so that one of the two programs
 * that are compared adds no roundoff of its own. */
typedef struct fluid {
    size_t n;
    const double *mass;
    double *x, *y, *vx, *vy;
    long double *fx, *fy;
} fluid;

/* m_i m_j (50/r^4 - 25/r^2) within 0.25, and weight. */
static void fluid_forces(fluid *f) {
    for (size_t i = 0; i < f->n; i++) {
        f->fx[i] = 0;
        f->fy[i] = -980 * f->mass[i];
    }
    for (size_t i = 0; i + 1 < f->n; i++)
        for (size_t j = i + 1; j < f->n; j++) {
            const long double dx = (long double)f->x[i] - f->x[j];
            const long double dy = (long double)f->y[i] - f->y[j];
            const long double square = dx * dx + dy * dy;
            if (square > 0.25 * 0.25)
                continue;
            const long double force =
                f->mass[i] * f->mass[j] * (50 / (square * square) - 25 / square) / sqrtl(square);
            f->fx[i] += force * dx;
            f->fy[i] += force * dy;
            f->fx[j] -= force * dx;
            f->fy[j] -= force * dy;
        }
}

/* Side walls x = 0 and 10 first, then the floor; a hit leaves a tenth of both velocities. */
static void fluid_contain(fluid *f, size_t i) {
    const double kept = 1 - 0.9;
    const bool right = f->x[i] > 10, left = f->x[i] < 0;
    if (right || left) {
        f->x[i] = right ? 20 - f->x[i] : -f->x[i];
        f->vx[i] *= -kept;
        f->vy[i] *= kept;
        if (fabs(f->vx[i]) < 1e-10)
            f->vx[i] = 0;
    }
    if (f->y[i] < 0) {
        f->y[i] = -f->y[i];
        f->vx[i] *= kept;
        f->vy[i] *= -kept;
        if (fabs(f->vx[i]) < 1e-10)
            f->vx[i] = 0;
    }
}

static void fluid_step(fluid *f, double kick, double step) {
    fluid_forces(f);
    for (size_t i = 0; i < f->n; i++) {
        f->vx[i] += kick * (double)(f->fx[i] / f->mass[i]);
        f->vy[i] += kick * (double)(f->fy[i] / f->mass[i]);
        f->x[i] += step * f->vx[i];
        f->y[i] += step * f->vy[i];
        fluid_contain(f, i);
    }
}

/* Positions and velocities at the time of step `steps`, in `state` [4 n]. */
static void fluid_run(const dl_scene *scene, size_t steps, double *state) {
    const size_t n = scene->particles;
    long double *force = malloc(2 * n * sizeof *force);
    assert_non_null(force);
    memcpy(state, scene->position, 2 * n * sizeof *state);
    memcpy(state + 2 * n, scene->velocity, 2 * n * sizeof *state);
    fluid f = {n, scene->inertia, state, state + n, state + 2 * n, state + 3 * n, force, force + n};
    const double step = 1e-4;
    for (size_t k = 0; k < steps; k++)
        fluid_step(&f, k == 0 ? step / 2 : step, step);
    fluid_forces(&f); /* half a kick brings the velocities to the positions' time */
    for (size_t i = 0; i < n; i++) {
        f.vx[i] += step / 2 * (double)(f.fx[i] / f.mass[i]);
        f.vy[i] += step / 2 * (double)(f.fy[i] / f.mass[i]);
    }
    free(force);
}

static double largest_difference(const double *a, const double *b, size_t count) {
    double largest = 0;
    for (size_t k = 0; k < count; k++)
        largest = fmax(largest, fabs(a[k] - b[k]));
    return largest;
}

static void leapfrog_is_the_papers_program(void **state) {
    (void)state;
    static const struct {
        size_t steps;
        double position, velocity; /* differences allowed */
    } checks[] = {{229, 1e-9, 1e-9}, {823, 1e-9, 1e-6}};
    dl_scene *scene = read_scene(DROP);
    assert_int_equal(scene->particles, 279);
    const size_t n = scene->particles;
    double *expected = malloc(4 * n * sizeof *expected);
    assert_non_null(expected);
    for (size_t k = 0; k < sizeof checks / sizeof *checks; k++) {
        const size_t steps = checks[k].steps;
        const dl_run_options how = run_options((double)steps * 1e-4, 1e-4);
        finished run = run_with(scene, method_of("leapfrog"), "step=1e-4", &how);
        assert_int_equal(run.summary.status, DL_OK);
        assert_int_equal(run.summary.steps, steps);
        fluid_run(scene, steps, expected);
        const double dx = largest_difference(run.y, expected, 2 * n);
        const double dv = largest_difference(run.y + 2 * n, expected + 2 * n, 2 * n);
        print_message("step %zu: positions differ by %.3g, velocities by %.3g\n", steps, dx, dv);
        assert_true(dx <= checks[k].position);
        assert_true(dv <= checks[k].velocity);
        free(run.y);
    }
    free(expected);
    dl_scene_free(scene);
}

/* --- observation changes nothing ------------------------------------------------------------ */

static void check_unobserved(const dl_scene *scene, const dl_method_row *row, double end) {
    dl_run_options plain = run_options(end, 0), every = run_options(end, scene->step);
    plain.observe = false;
    finished without = run_with(scene, row, "", &plain), with = run_with(scene, row, "", &every);
    if (without.summary.status || with.summary.status)
        fail_msg("%s: %s", row->name, with.summary.message);
    if (memcmp(without.y, with.y, with.length * sizeof *with.y) != 0)
        fail_msg("%s on %s: the sampled run differs by %g", row->name, scene->name,
                 largest_difference(without.y, with.y, with.length));
    assert_int_equal(with.summary.samples, with.summary.steps + 1);
    assert_int_equal(without.summary.samples, 0);
    assert_int_equal(without.summary.steps, with.summary.steps);
    assert_int_equal(without.summary.force_evaluations, with.summary.force_evaluations);
    assert_int_equal(without.summary.jacobian_evaluations, with.summary.jacobian_evaluations);
    assert_int_equal(without.summary.nonlinear_iterations, with.summary.nonlinear_iterations);
    assert_int_equal(without.summary.neighbour_list_builds, with.summary.neighbour_list_builds);
    assert_int_equal(without.summary.wall_hits, with.summary.wall_hits);
    assert_true(isnan(without.summary.energy_error_max) && isnan(without.summary.ledger));
    assert_true(isnan(without.summary.energy_initial) && isnan(without.summary.energy_scale));
    free(without.y);
    free(with.y);
}

static bool keeps_the_scenes_step(const dl_method_row *row) {
    const dl_parameter *step = dl_parameter_find(row->options, "step");
    return (row->flags & DL_FIXED_STEP) && step && !step->fallback;
}

static void sampling_changes_no_bit(void **state) {
    (void)state;
    dl_scene *drop = read_scene(DROP), *stream = read_scene(DL_STUDIES "/stream/stream.yaml");
    size_t checked = 0;
    for (size_t i = 0; i < dl_method_count(); i++) {
        const dl_method_row *row = dl_method_row_at(i);
        if (!keeps_the_scenes_step(row) || row->flags & DL_SPLITS_FORCE)
            continue; /* all of the stream's force is one part */
        check_unobserved(stream, row, 0.2);
        checked++;
    }
    assert_true(checked >= 5);
    /* Walls, and a neighbour list that observation must not rebuild. */
    check_unobserved(drop, method_of("leapfrog"), 0.03);
    check_unobserved(drop, method_of("composition-2-verlet"), 0.03);
    drop->skin = 1e-3; /* a new list every few steps */
    check_unobserved(drop, method_of("leapfrog"), 0.03);
    dl_scene_free(drop);
    dl_scene_free(stream);
}

/* --- ledger --------------------------------------------------------------------------------- */

/* In uniform gravity leap-frog and Verlet are exact, so that after hundreds of damped hits nothing
 * is left of the energy and momentum errors but roundoff: the ledger is exact. */
static void ledger_is_exact(void **state) {
    (void)state;
    static const char *const names[] = {"leapfrog", "composition-2-verlet", "composition-4-suzuki"};
    dl_scene *scene = scene_of_text(bouncing);
    for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
        const dl_run_options how = run_options(0, 0);
        finished run = run_with(scene, method_of(names[i]), "", &how);
        const dl_run_summary *s = &run.summary;
        assert_int_equal(s->status, DL_OK);
        assert_true(s->wall_hits > 20);
        assert_int_equal(s->samples, 51);
        assert_true(s->ledger > 0.3 * s->energy_scale);
        assert_true(s->energy_error_max < 1e-12 * s->energy_scale);
        assert_true(s->momentum_error_max < 1e-12 * s->momentum_scale);
        assert_true(fabs(s->energy_final + s->ledger - s->energy_initial) <
                    1e-12 * s->energy_scale);
        assert_true(isnan(s->angular_momentum_error_max));
        free(run.y);
    }
    dl_scene_free(scene);
}

static void momenta_of_an_isolated_pair(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(pair);
    const dl_run_options how = run_options(0, 0);
    finished run = run_with(scene, method_of("leapfrog"), "", &how);
    const dl_run_summary *s = &run.summary;
    assert_true(fabs(s->momentum_scale - 1) < 1e-15);
    assert_true(fabs(s->angular_momentum_scale - 0.5) < 1e-15);
    assert_true(fabs(s->energy_initial - (0.25 - 1)) < 1e-15);
    assert_true(fabs(s->energy_scale - 1.25) < 1e-15);
    assert_true(s->momentum_error_max < 1e-15);
    assert_true(s->angular_momentum_error_max < 1e-14);
    assert_true(s->energy_error_max > 1e-8 && s->energy_error_max < 1e-2);
    assert_true(s->energy_error_final <= s->energy_error_max);
    assert_true(s->ledger == 0 && s->wall_hits == 0);
    free(run.y);
    dl_scene_free(scene);
}

/* --- samples -------------------------------------------------------------------------------- */

typedef struct recorded {
    size_t count;
    size_t index[64];
    unsigned long step[64];
    double time[64], energy_error[64];
    size_t fail_at; /* index at which to fail; 0: never */
} recorded;

static dl_status record(void *context, const dl_sample *sample, dl_error *error) {
    recorded *r = context;
    assert_true(r->count < 64);
    r->index[r->count] = sample->index;
    r->step[r->count] = sample->step;
    r->time[r->count] = sample->time;
    r->energy_error[r->count++] = sample->energy_error;
    assert_true(isfinite(sample->y_all[0]));
    if (r->fail_at && sample->index == r->fail_at)
        return dl_fail(error, DL_IO, "no room for sample %zu", sample->index);
    return DL_OK;
}

static void check_samples(const char *method, const char *setting) {
    dl_scene *scene = scene_of_text(pair);
    recorded samples = {0};
    dl_run_options how = run_options(0.65, 0.1);
    how.on_sample = record;
    how.context = &samples;
    finished run = run_with(scene, method_of(method), setting, &how);
    assert_int_equal(run.summary.status, DL_OK);
    assert_int_equal(samples.count, 8);
    assert_int_equal(run.summary.samples, 8);
    for (size_t i = 0; i < 8; i++) {
        assert_int_equal(samples.index[i], i);
        assert_true(samples.time[i] == (i == 7 ? 0.65 : (double)i * 0.1));
        assert_true(i == 0 || samples.step[i] > samples.step[i - 1]);
    }
    assert_true(samples.step[0] == 0 && samples.energy_error[0] == 0);
    assert_true(run.summary.energy_error_final == fabs(samples.energy_error[7]));
    assert_true(run.summary.t_end_reached == 0.65);
    assert_int_equal(run.summary.steps, samples.step[7]);
    free(run.y);
    dl_scene_free(scene);
}

static void samples_of_a_fixed_step(void **state) {
    (void)state;
    check_samples("leapfrog", "step=0.01");
}

static void samples_of_chosen_steps(void **state) {
    (void)state;
    size_t checked = 0;
    for (size_t i = 0; i < dl_method_count(); i++) {
        const dl_method_row *row = dl_method_row_at(i);
        if (!(row->flags & DL_ADAPTIVE) || row->flags & DL_SPLITS_FORCE)
            continue;
        check_samples(row->name, "");
        checked++;
    }
    assert_true(checked >= 1);
}

static void failing_sample_ends_the_run(void **state) {
    (void)state;
    dl_scene *scene = scene_of_text(pair);
    recorded samples = {.fail_at = 3};
    dl_run_options how = run_options(1, 0.1);
    how.on_sample = record;
    how.context = &samples;
    finished run = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(run.summary.status, DL_IO);
    assert_string_equal(run.summary.message, "no room for sample 3");
    assert_int_equal(samples.count, 4);
    assert_int_equal(run.summary.steps, 30);
    free(run.y);
    dl_scene_free(scene);
}

/* --- methods that misbehave ----------------------------------------------------------------- */

typedef struct odd_options {
    double step;
    long fail_at;     /* steps done before advance fails; 0: never */
    double seconds;   /* CPU time that a step takes ... */
    long slow_from;   /* ... after this many quick ones */
    long set_flag_at; /* steps done when odd_flag is raised; 0: never */
} odd_options;

typedef struct odd {
    unsigned long steps;
} odd;

static volatile int odd_flag;

static dl_status odd_create(dl_method *method, dl_error *error) {
    method->step = ((const odd_options *)method->options)->step;
    method->data = calloc(1, sizeof(odd));
    return method->data ? DL_OK : dl_fail_memory(error, "a method");
}

/* Goes straight on. */
static dl_status odd_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)t_stop;
    const odd_options *options = method->options;
    odd *data = method->data;
    if (options->fail_at && data->steps == (unsigned long)options->fail_at)
        return dl_fail(error, DL_NONLINEAR_FAILURE, "gave up at step %lu", data->steps);
    if (options->seconds > 0 && data->steps >= (unsigned long)options->slow_from)
        for (const double until = dl_cpu_clock() + options->seconds; dl_cpu_clock() < until;)
            ;
    for (size_t i = 0; i < method->n; i++)
        method->y[i] += method->step * method->y[method->n + i];
    method->t = (double)++data->steps * method->step;
    if (options->set_flag_at && data->steps == (unsigned long)options->set_flag_at)
        odd_flag = 1;
    return DL_OK;
}

static void odd_stats(const dl_method *method, dl_method_stats *stats) {
    stats->steps = ((const odd *)method->data)->steps;
}

static void odd_destroy(dl_method *method) {
    free(method->data);
}

static const dl_method_ops odd_ops = {
    .create = odd_create, .advance = odd_advance, .stats = odd_stats, .destroy = odd_destroy};

static const dl_method_row odd_row = {.name = "odd",
                                      .family = "test",
                                      .doc = "fails as asked",
                                      .flags = DL_FIXED_STEP,
                                      .options_size = sizeof(odd_options),
                                      .ops = &odd_ops};

static const char free_flight[] = "name: free-flight\n"
                                  "dimension: 2\n"
                                  "particles:\n"
                                  "  - {at: [0, 0], velocity: [1, 0], mass: 1}\n"
                                  "time: {step: 0.01, end: 1}\n";

static dl_run_summary run_odd(odd_options options, dl_run_options how) {
    dl_scene *scene = scene_of_text(free_flight);
    dl_run_summary summary;
    dl_error error = {""};
    if (dl_run(scene, &odd_row, &options, &how, &summary, NULL, &error))
        fail_msg("%s", error.message);
    dl_scene_free(scene);
    return summary;
}

static void failed_step_ends_the_run(void **state) {
    (void)state;
    recorded samples = {0};
    dl_run_options how = run_options(1, 0.1);
    how.on_sample = record;
    how.context = &samples;
    const dl_run_summary s = run_odd((odd_options){.step = 0.01, .fail_at = 37}, how);
    assert_int_equal(s.status, DL_NONLINEAR_FAILURE);
    assert_string_equal(s.message, "gave up at step 37");
    assert_int_equal(s.steps, 37);
    assert_true(s.t_end_reached == 0.37);
    /* Start, 0.1, 0.2, 0.3 and where it ended. */
    assert_int_equal(samples.count, 5);
    assert_true(samples.time[4] == 0.37);
    assert_true(s.energy_initial == 0.5 && s.energy_final == 0.5);
    assert_true(s.energy_error_max == 0);
}

static void time_limit_stops_slow_steps(void **state) {
    (void)state;
    dl_run_options how = run_options(1, 0);
    how.time_limit = 0.3;
    const dl_run_summary s = run_odd((odd_options){.step = 0.01, .seconds = 0.06}, how);
    assert_int_equal(s.status, DL_TIMEOUT);
    assert_in_range(s.steps, 1, 10); /* 5 steps fill the limit: every slow step is looked at */
    assert_non_null(strstr(s.message, "0.3 CPU seconds"));
    assert_true(s.cpu_seconds >= 0.05 * (double)s.steps);
}

static void time_limit_follows_the_speed(void **state) {
    (void)state;
    dl_run_options how = run_options(10, 0);
    how.time_limit = 1;
    const dl_run_summary s =
        run_odd((odd_options){.step = 0.01, .seconds = 0.01, .slow_from = 100}, how);
    assert_int_equal(s.status, DL_TIMEOUT);
    /* 100 slow steps fill the limit; then every fifth or so is looked at. */
    assert_in_range(s.steps, 150, 220);
}

static void time_limit_stops_fast_steps(void **state) {
    (void)state;
    dl_run_options how = run_options(1e7, 1e7);
    how.time_limit = 0.2;
    const dl_run_summary s = run_odd((odd_options){.step = 0.01}, how);
    assert_int_equal(s.status, DL_TIMEOUT);
    assert_true(s.steps > 1000 && s.t_end_reached < 1e7);
}

static void count_progress(void *context, double fraction, double seconds) {
    double *last = context;
    assert_true(fraction > *last && fraction <= 1 && seconds >= 0);
    *last = fraction;
}

static void count_calls(void *context, double fraction, double seconds) {
    (void)fraction;
    (void)seconds;
    ++*(size_t *)context;
}

/* However often a run is sampled, its limits are looked at between the samples too. */
static void samples_do_not_thin_out_the_looks(void **state) {
    (void)state;
    size_t calls = 0;
    dl_run_options how = run_options(1e4, 100); /* 100 samples, 10000 steps apart */
    how.on_progress = count_calls;
    how.progress_context = &calls;
    assert_int_equal(run_odd((odd_options){.step = 0.01}, how).status, DL_OK);
    assert_true(calls > 250);
}

static void interrupt_stops_the_run(void **state) {
    (void)state;
    double fraction = 0;
    dl_run_options how = run_options(1e7, 1e7);
    odd_flag = 0;
    how.interrupt = &odd_flag;
    how.on_progress = count_progress;
    how.progress_context = &fraction;
    const dl_run_summary s = run_odd((odd_options){.step = 0.01, .set_flag_at = 20000}, how);
    assert_int_equal(s.status, DL_INTERRUPTED);
    assert_true(s.steps >= 20000 && s.t_end_reached < 1e7);
    assert_int_equal(s.samples, 2); /* where it began and where it was stopped */
    assert_true(fraction > 0);
    assert_non_null(strstr(s.message, "interrupted at t = "));
}

/* A method that chooses its steps and takes none. */
static dl_status still_create(dl_method *method, dl_error *error) {
    const dl_status status = odd_create(method, error);
    method->step = 0;
    return status;
}

static dl_status still_advance(dl_method *method, double t_stop, dl_error *error) {
    (void)method;
    (void)t_stop;
    (void)error;
    return DL_OK;
}

static void step_of_nothing_is_a_failure(void **state) {
    (void)state;
    static const dl_method_ops ops = {.create = still_create,
                                      .advance = still_advance,
                                      .stats = odd_stats,
                                      .destroy = odd_destroy};
    dl_method_row row = odd_row;
    row.flags = DL_ADAPTIVE;
    row.ops = &ops;
    dl_scene *scene = scene_of_text(free_flight);
    const odd_options options = {.step = 0};
    const dl_run_options how = run_options(1, 0);
    dl_run_summary summary;
    assert_int_equal(dl_run(scene, &row, &options, &how, &summary, NULL, NULL), DL_OK);
    assert_int_equal(summary.status, DL_STEP_FAILURE);
    dl_scene_free(scene);
}

/* --- instability ---------------------------------------------------------------------------- */

/* Uses up CPU time at every sample. */
static dl_status dawdle(void *context, const dl_sample *sample, dl_error *error) {
    (void)sample;
    (void)error;
    const clock_t until = clock() + CLOCKS_PER_SEC / 20;
    while (clock() < until)
        ++*(volatile unsigned *)context;
    return DL_OK;
}

/* CPU time, not the clock on the wall: a hundred steps of two particles beside 0.25 s of samples.
 */
static void observation_is_not_in_the_cpu_time(void **state) {
    (void)state;
    volatile unsigned turns = 0;
    dl_scene *scene = fixture_oscillator();
    dl_run_options how = run_options(1, 0.25);
    how.on_sample = dawdle;
    how.context = (void *)&turns;
    finished run = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(run.summary.samples, 5);
    assert_true(run.summary.cpu_seconds > 0 && run.summary.cpu_seconds < 0.04);
    free(run.y);
    dl_scene_free(scene);
}

/* Without the ledger the motion is the same, and nothing is said of errors it would take. */
static void ledger_can_be_left_out(void **state) {
    (void)state;
    dl_scene *scene = read_scene(DROP);
    dl_run_options how = run_options(2e-3, 1e-3);
    finished booked = run_with(scene, method_of("leapfrog"), "", &how);
    how.ledger = false;
    finished bare = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(bare.summary.status, DL_OK);
    assert_true(bare.summary.wall_hits > 0 && isfinite(booked.summary.energy_error_max));
    assert_true(isnan(bare.summary.energy_error_max) && isnan(bare.summary.ledger));
    assert_true(bare.summary.energy_final == booked.summary.energy_final);
    assert_memory_equal(bare.y, booked.y, 4 * scene->particles * sizeof *bare.y);
    free(bare.y);
    free(booked.y);
    dl_scene_free(scene);
}

static void unbounded_energy_is_unstable(void **state) {
    (void)state;
    dl_scene *scene = read_scene(DROP);
    dl_run_options how = run_options(1, 0.1);
    finished run = run_with(scene, method_of("leapfrog"), "step=0.01", &how);
    const dl_run_summary *s = &run.summary;
    assert_int_equal(s->status, DL_UNSTABLE);
    assert_non_null(strstr(s->message, "t = 0.1"));
    assert_non_null(strstr(s->message, "times the energy scale (bound 100)"));
    assert_true(s->t_end_reached < 0.5);
    /* The error that broke the bound is told. */
    assert_true(s->energy_error_max > 100 * s->energy_scale);
    assert_true(isfinite(s->energy_final));
    assert_true(isfinite(s->kinetic_energy_per_particle));
    free(run.y);
    /* A bound that is always exceeded, and one that never is. */
    how = run_options(1e-2, 1e-3);
    how.energy_bound = 1e-12;
    run = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(run.summary.status, DL_UNSTABLE);
    free(run.y);
    how.energy_bound = 1e30;
    run = run_with(scene, method_of("leapfrog"), "", &how);
    assert_int_equal(run.summary.status, DL_OK);
    free(run.y);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(schedule_of_fixed_steps),
        cmocka_unit_test(schedule_chosen_has_at_most_50_intervals),
        cmocka_unit_test(schedule_of_an_adaptive_method),
        cmocka_unit_test(schedule_refuses_parts_of_steps),
        cmocka_unit_test(schedule_refuses_too_many),
        cmocka_unit_test(schedule_blames_what_was_given),
        cmocka_unit_test(run_refuses_parts_of_steps),
        cmocka_unit_test(leapfrog_is_the_papers_program),
        cmocka_unit_test(sampling_changes_no_bit),
        cmocka_unit_test(ledger_is_exact),
        cmocka_unit_test(momenta_of_an_isolated_pair),
        cmocka_unit_test(samples_of_a_fixed_step),
        cmocka_unit_test(samples_of_chosen_steps),
        cmocka_unit_test(failing_sample_ends_the_run),
        cmocka_unit_test(failed_step_ends_the_run),
        cmocka_unit_test(time_limit_stops_slow_steps),
        cmocka_unit_test(time_limit_follows_the_speed),
        cmocka_unit_test(time_limit_stops_fast_steps),
        cmocka_unit_test(samples_do_not_thin_out_the_looks),
        cmocka_unit_test(interrupt_stops_the_run),
        cmocka_unit_test(step_of_nothing_is_a_failure),
        cmocka_unit_test(observation_is_not_in_the_cpu_time),
        cmocka_unit_test(ledger_can_be_left_out),
        cmocka_unit_test(unbounded_energy_is_unstable),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
