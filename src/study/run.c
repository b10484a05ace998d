#include "driftlab/run.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "observe/initial_energy.h"
#include "observe/observer.h"
#include "observe/schedule.h"
#include "observe/stopwatch.h"
#include "study/jumps.h"
#include "study/located.h"

/* A hundred times all the energy there was: a blow-up. Less is not one where walls take energy: the
 * papers' fluid is heated by its jumping force and cooled by its walls, for ever. */
static const double default_energy_bound = 100;

/* Limits, interrupts and progress are looked at every `steps` steps, a number that follows the
 * speed of the run so that it happens about every 50 ms, but every step where steps are slow. */
typedef struct pulse {
    unsigned long steps, left;
    double last; /* CPU clock */
} pulse;

static const double pulse_seconds = 0.05;
/* A run whose steps become slow (walls are hit at every one) is seen to do so. */
static const unsigned long most_pulse_steps = 4096;

typedef struct run {
    const dl_run_options *options;
    dl_model *model;
    dl_method *method;
    dl_observer *observer; /* NULL: integrate only */
    double *y;             /* [2 * unknowns]: the state at the end */
    dl_schedule schedule;
    dl_jumps jumps;
    dl_located *located; /* NULL: no hits nor crossings are located */
    bool mirrors;        /* the walls' rule is `mirror` */
    size_t steps_done;   /* of a fixed step */
    double energy_bound;
    double began; /* CPU clock */
    dl_stopwatch watch;
    pulse pulse;
    double sampled_at; /* time of the last sample; negative: none yet */
    dl_run_summary *summary;
} run;

void dl_run_options_default(dl_run_options *options) {
    *options =
        (dl_run_options){.observe = true, .ledger = true, .energy_bound = default_energy_bound};
}

void dl_run_summary_clear(dl_run_summary *summary) {
    *summary = (dl_run_summary){.energy_initial = NAN,
                                .energy_final = NAN,
                                .energy_scale = NAN,
                                .energy_error_max = NAN,
                                .energy_error_final = NAN,
                                .ledger = NAN,
                                .momentum_error_max = NAN,
                                .angular_momentum_error_max = NAN,
                                .momentum_scale = NAN,
                                .angular_momentum_scale = NAN,
                                .kinetic_energy_per_particle = NAN,
                                .force_error_stated = NAN,
                                .force_error_max = NAN,
                                .force_error_mean = NAN};
}

static void summary_fail(dl_run_summary *summary, dl_status status, const dl_error *error) {
    summary->status = status;
    memcpy(summary->message, error->message, sizeof summary->message);
}

/* --- limits --------------------------------------------------------------------------------- */

static void pulse_adapt(pulse *beat, double now) {
    const double elapsed = now - beat->last;
    if (elapsed < 0.5 * pulse_seconds)
        beat->steps = beat->steps < most_pulse_steps ? 2 * beat->steps : most_pulse_steps;
    else if (elapsed > 2 * pulse_seconds)
        beat->steps = (unsigned long)fmax(1, (double)beat->steps * pulse_seconds / elapsed);
    beat->left = beat->steps;
    beat->last = now;
}

static dl_status check_limits(run *r, dl_error *error) {
    const double now = dl_cpu_clock(), seconds = now - r->began;
    const dl_run_options *options = r->options;
    pulse_adapt(&r->pulse, now);
    if (options->interrupt && *options->interrupt)
        return dl_fail(error, DL_INTERRUPTED, "interrupted at t = %.10g of %.10g", r->method->t,
                       r->schedule.end);
    if (options->time_limit > 0 && seconds > options->time_limit)
        return dl_fail(error, DL_TIMEOUT,
                       "the limit of %.6g CPU seconds was reached at t = %.10g of %.10g",
                       options->time_limit, r->method->t, r->schedule.end);
    if (options->on_progress)
        options->on_progress(options->progress_context, r->method->t / r->schedule.end, seconds);
    return DL_OK;
}

/* --- walls ---------------------------------------------------------------------------------- */

static dl_status mirror(run *r, dl_error *error) {
    dl_method *method = r->method;
    const size_t hits = dl_model_mirror(r->model, method->y, method->y + method->n);
    r->summary->wall_hits += hits;
    dl_status status = hits ? dl_method_jumped(method, error) : DL_OK;
    if (!status && hits && r->located)
        status = dl_located_restart(r->located, error);
    return status;
}

/* The same, booked; what the booking costs is not timed. */
static dl_status mirror_observed(run *r, dl_error *error) {
    if (!dl_model_outside(r->model, r->method->y))
        return DL_OK;
    dl_stopwatch_stop(&r->watch);
    dl_status status = dl_observer_before_jump(r->observer, r->method, error);
    dl_stopwatch_start(&r->watch);
    if (status || (status = mirror(r, error)))
        return status;
    dl_stopwatch_stop(&r->watch);
    status = dl_observer_after_jump(r->observer, r->method, error);
    dl_stopwatch_start(&r->watch);
    return status;
}

/* --- steps ---------------------------------------------------------------------------------- */

static inline dl_status one_step(run *r, double t_stop, dl_error *error) {
    return r->located ? dl_located_step(r->located, t_stop, error)
                      : dl_method_advance(r->method, t_stop, error);
}

/* What follows every step. */
static inline dl_status after_step(run *r, dl_error *error) {
    if (r->mirrors) {
        const dl_status status = r->observer ? mirror_observed(r, error) : mirror(r, error);
        if (status)
            return status;
    }
    return --r->pulse.left ? DL_OK : check_limits(r, error);
}

static dl_status advance_steps(run *r, size_t target, dl_error *error) {
    while (r->steps_done < target) {
        dl_status status = one_step(r, r->schedule.end, error);
        if (status)
            return status;
        r->steps_done++;
        status = after_step(r, error);
        if (status)
            return status;
    }
    return DL_OK;
}

static dl_status advance_until(run *r, double time, dl_error *error) {
    const double reached = time * (1 - 4 * DBL_EPSILON);
    dl_method *method = r->method;
    while (method->t < reached) {
        const double before = method->t;
        dl_status status = one_step(r, time, error);
        if (!status && !r->located && !(method->t > before))
            status = dl_fail(error, DL_STEP_FAILURE, "the step became too small to move t = %.17g",
                             before);
        if (!status)
            status = after_step(r, error);
        if (status)
            return status;
    }
    return DL_OK;
}

/* --- samples -------------------------------------------------------------------------------- */

/* Not below `largest`, which is NaN before the first. */
static double larger(double largest, double value) {
    return largest > value ? largest : value;
}

static void summary_add_sample(dl_run_summary *summary, const dl_sample *sample, size_t moving) {
    summary->energy_final = sample->energy.total;
    summary->energy_error_final = fabs(sample->energy_error);
    summary->energy_error_max = larger(summary->energy_error_max, summary->energy_error_final);
    summary->ledger = sample->ledger;
    summary->momentum_error_max = larger(summary->momentum_error_max, sample->momentum_error);
    summary->angular_momentum_error_max =
        larger(summary->angular_momentum_error_max, sample->angular_momentum_error);
    summary->kinetic_energy_per_particle = sample->energy.kinetic / (double)moving;
    summary->samples++;
}

/* Takes the sample into the summary, where it is one. */
static dl_status judge_sample(const run *r, const dl_sample *sample, dl_error *error) {
    const double relative = fabs(sample->energy_error) / r->summary->energy_scale;
    if (!isfinite(sample->energy.total)) {
        dl_run_summary *summary = r->summary;
        summary->energy_final = summary->energy_error_final = summary->energy_error_max = NAN;
        return dl_fail(error, DL_UNSTABLE, "the energy is no longer finite at t = %.10g",
                       sample->time);
    }
    summary_add_sample(r->summary, sample, r->model->moving);
    if (relative > r->energy_bound)
        return dl_fail(error, DL_UNSTABLE,
                       "the energy error at t = %.10g is %.6g times the energy scale (bound %.6g)",
                       sample->time, relative, r->energy_bound);
    return DL_OK;
}

/* Steps that were thrown away to step to an event are rejected ones. */
static dl_method_stats stats_of(const run *r) {
    dl_method_stats stats = {0};
    dl_method_stats_get(r->method, &stats);
    if (r->located) {
        const unsigned long discarded = dl_located_counts_get(r->located).discarded;
        stats.steps -= discarded;
        stats.rejected += discarded;
    }
    return stats;
}

static dl_status take_sample(run *r, double time, dl_error *error) {
    if (!r->observer)
        return DL_OK;
    const dl_method_stats stats = stats_of(r);
    dl_sample sample = {.index = r->summary->samples, .step = stats.steps};
    dl_status status = dl_observer_sample(r->observer, r->method, time, &sample, error);
    if (!status)
        status = judge_sample(r, &sample, error);
    if (status)
        return status;
    r->sampled_at = time;
    return r->options->on_sample ? r->options->on_sample(r->options->context, &sample, error)
                                 : DL_OK;
}

/* At the method's state; the larger of what it was before and now. Observation: not counted. */
static dl_status measure_force_error(run *r, dl_error *error) {
    dl_force_error now;
    if (!r->observer || !dl_model_has_force_error(r->model))
        return DL_OK;
    const dl_counts counts = r->model->counts;
    dl_status status = dl_method_state(r->method, r->y, error);
    if (!status)
        status = dl_model_force_error(r->model, r->y, &now, error);
    r->model->counts = counts;
    if (status)
        return status;
    r->summary->force_error_stated = now.stated;
    r->summary->force_error_max = fmax(r->summary->force_error_max, now.largest);
    r->summary->force_error_mean = fmax(r->summary->force_error_mean, now.mean);
    return DL_OK;
}

static dl_status begin_observing(run *r, dl_error *error) {
    if (!r->observer)
        return DL_OK;
    dl_status status = dl_observer_begin(r->observer, r->method, r->summary, error);
    if (!status)
        status = measure_force_error(r, error);
    if (status)
        return status;
    r->summary->energy_initial = dl_observer_initial_energy(r->observer);
    return take_sample(r, 0, error);
}

/* --- the loop ------------------------------------------------------------------------------- */

static dl_status advance_timed(run *r, size_t steps, double time, dl_error *error) {
    dl_stopwatch_start(&r->watch);
    const dl_status status =
        r->schedule.steps ? advance_steps(r, steps, error) : advance_until(r, time, error);
    dl_stopwatch_stop(&r->watch);
    return status;
}

static bool jump_is_due(const run *r, size_t *steps, double *time) {
    return r->schedule.steps ? dl_jumps_due_at_step(&r->jumps, *steps, steps)
                             : dl_jumps_due_at_time(&r->jumps, *time, time);
}

/* Particles whose state is not the outcome of a step may hit a wall where they are, or rest. */
static dl_status begin_anew(run *r, dl_error *error) {
    if (!r->located)
        return DL_OK;
    dl_stopwatch_start(&r->watch);
    const dl_status status = dl_located_restart(r->located, error);
    dl_stopwatch_stop(&r->watch);
    return status;
}

/* To the sample, by way of the scheduled jumps before it. */
static dl_status advance_to_sample(run *r, size_t sample, double time, dl_error *error) {
    const size_t steps = dl_schedule_step(&r->schedule, sample);
    size_t jump_steps = steps;
    double jump_time = time;
    dl_status status = DL_OK;
    while (!status && jump_is_due(r, &jump_steps, &jump_time)) {
        status = advance_timed(r, jump_steps, jump_time, error);
        if (!status)
            status = dl_jumps_make(&r->jumps, r->method, r->observer, &r->watch, error);
        if (!status)
            status = begin_anew(r, error);
        jump_steps = steps;
        jump_time = time;
    }
    return status ? status : advance_timed(r, steps, time, error);
}

static dl_status integrate(run *r, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t sample = 1; !status && sample <= r->schedule.samples; sample++) {
        const double time = dl_schedule_time(&r->schedule, sample);
        status = advance_to_sample(r, sample, time, error);
        if (!status)
            status = take_sample(r, time, error);
        r->pulse.left = 1; /* observation counts for the limit on time, too */
    }
    return status ? status : measure_force_error(r, error);
}

/* A run that ended before its time still tells its last state, where that is one. */
static dl_status sample_last_state(run *r, dl_error *error) {
    return r->sampled_at >= 0 && r->method->t > r->sampled_at * (1 + 1e-12)
               ? take_sample(r, r->method->t, error)
               : DL_OK;
}

/* A step that fails after the run has blown up, between two samples, is no fault of its own. */
static void fail(run *r, dl_status status, const dl_error *error) {
    dl_error blown_up = {""}, both;
    summary_fail(r->summary, status, error);
    if (sample_last_state(r, &blown_up) != DL_UNSTABLE || status != DL_STEP_FAILURE)
        return;
    dl_fail(&both, DL_UNSTABLE, "%s; then a step failed: %.*s", blown_up.message,
            DL_MESSAGE_SIZE / 2, error->message);
    summary_fail(r->summary, DL_UNSTABLE, &both);
}

static void summarise(run *r) {
    dl_run_summary *summary = r->summary;
    const dl_method_stats stats = stats_of(r);
    summary->t_end_reached = summary->status ? r->method->t : r->schedule.end;
    summary->step = r->method->step;
    summary->steps = stats.steps;
    summary->rejected_steps = stats.rejected;
    summary->nonlinear_iterations = stats.nonlinear_iterations;
    summary->linear_iterations = stats.linear_iterations;
    summary->factorisations = stats.factorisations;
    summary->inexact_steps = stats.inexact;
    summary->rescued_steps = stats.rescued;
    dl_method_describe(r->method, summary->choice, sizeof summary->choice);
    summary->force_evaluations = r->model->counts.force;
    summary->jacobian_evaluations = r->model->counts.jacobian;
    summary->jacobian_vector_products = r->model->counts.jacobian_vector;
    summary->neighbour_list_builds = dl_model_list_builds(r->model);
    summary->cpu_seconds = r->watch.total;
    if (!r->located)
        return;
    const dl_located_counts counts = dl_located_counts_get(r->located);
    summary->wall_hits += counts.hits;
    summary->contacts = counts.contacts;
    summary->releases = counts.releases;
    summary->crossings = counts.crossings;
}

static void run_to_end(run *r) {
    dl_error error = {""};
    r->began = dl_cpu_clock();
    r->pulse = (pulse){.steps = 1, .left = 1, .last = r->began};
    r->sampled_at = -1;
    dl_status status = begin_observing(r, &error);
    if (!status)
        status = begin_anew(r, &error);
    if (!status)
        status = integrate(r, &error);
    if (status)
        fail(r, status, &error);
    summarise(r);
}

/* NaN where the last state is none. */
static void final_state(run *r, double *y_final, dl_error *error) {
    const dl_status status = dl_method_state(r->method, r->y, error);
    if (!status) {
        dl_model_expand(r->model, r->y, y_final);
        return;
    }
    if (!r->summary->status)
        summary_fail(r->summary, status, error);
    for (size_t k = 0; k < 2 * (size_t)r->model->dimension * r->model->particles; k++)
        y_final[k] = NAN;
}

/* --- set-up --------------------------------------------------------------------------------- */

static dl_status create_parts(run *r, const dl_scene *scene, const dl_method_row *row,
                              const void *options, dl_error *error) {
    dl_status status = dl_model_create(scene, &r->model, error);
    if (status)
        return status;
    r->y = malloc(2 * r->model->unknowns * sizeof *r->y);
    if (!r->y)
        return dl_fail_memory(error, "the state of a run");
    dl_model_initial_state(r->model, r->y);
    status = dl_initial_energy_check(r->model, r->y, error);
    if (!status)
        status = dl_method_create(row, r->model, options, r->y, &r->method, error);
    if (status)
        return status;
    if (r->options->observe)
        status = dl_observer_create(scene, r->options->ledger, &r->observer, error);
    r->mirrors = r->model->has_walls && !r->model->locates_hits;
    if (!status && (r->model->locates_hits || r->model->locates_crossings))
        status = dl_located_create(r->method, r->observer, &r->watch, &r->located, error);
    if (status)
        return status;
    status = dl_schedule_of_scene(scene, r->options->end, r->options->sample, r->method->step,
                                  &r->schedule, error);
    return status ? status : dl_jumps_create(scene, r->method->step, &r->jumps, error);
}

/* A method that cannot even take the initial state (its force is not finite ...) has failed as it
 * might have later; everything else means that the run was not started. */
static bool is_method_failure(dl_status status) {
    return status == DL_UNSTABLE || status == DL_NONLINEAR_FAILURE || status == DL_STEP_FAILURE;
}

dl_status dl_run(const dl_scene *scene, const dl_method_row *row, const void *options,
                 const dl_run_options *run_options, dl_run_summary *summary, double *y_final,
                 dl_error *error) {
    run r = {.options = run_options, .summary = summary};
    dl_error own = {""};
    r.energy_bound =
        run_options->energy_bound > 0 ? run_options->energy_bound : default_energy_bound;
    dl_run_summary_clear(summary);
    dl_status status = create_parts(&r, scene, row, options, &own);
    if (!status) {
        run_to_end(&r);
        if (y_final)
            final_state(&r, y_final, &own);
    } else if (is_method_failure(status)) {
        summary_fail(summary, status, &own);
        summary->t_end_reached = 0;
        status = DL_OK;
    }
    dl_located_free(r.located);
    dl_method_destroy(r.method);
    dl_observer_free(r.observer);
    dl_model_free(r.model);
    free(r.y);
    return status ? dl_fail(error, status, "%s", own.message) : DL_OK;
}
