#include "study/trial.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "study/child.h"
#include "study/passage.h"

#define WORD(symbol, word, stable)      [DL_TRIAL_##symbol] = word,
#define STABILITY(symbol, word, stable) [DL_TRIAL_##symbol] = stable,

static const char *const words[] = {DL_TRIAL_ENDS(WORD)};
static const int stability[] = {DL_TRIAL_ENDS(STABILITY)};

const char *dl_trial_word(dl_trial_end end) {
    return words[end];
}

int dl_trial_stability(dl_trial_end end) {
    return stability[end];
}

/* --- while it runs ---------------------------------------------------------------------------- */

/* Past this the energy error is a blow-up, and the run is stopped. */
static const double blow_up = 100;

typedef struct watch {
    const dl_study_unit *unit;
    const dl_trial_rule *rule;
    dl_trial *trial;
    dl_passage *passage;
    bool broken; /* the rule did not hold at the last sample, or before */
    bool stop;   /* the run was ended for that */
    char why[DL_MESSAGE_SIZE];
} watch;

static void violate(watch *w, dl_trial_end end) {
    if (!w->broken)
        w->trial->end = end;
    w->broken = true;
}

static void judge_energy(watch *w, const dl_sample *sample) {
    const double relative = sample->energy_error / w->trial->summary.energy_scale;
    if (!(fabs(relative) > w->rule->energy))
        return; /* NaN: nothing is booked, nothing is known */
    if (!w->broken)
        snprintf(w->why, sizeof w->why, "at t = %.6g the energy error is %.3g of the scale",
                 sample->time, relative);
    violate(w, relative > 0 ? DL_TRIAL_ENERGY_GAIN : DL_TRIAL_ENERGY_LOSS);
}

static void judge_warmth(watch *w, const dl_sample *sample) {
    const double warmth = sample->energy.kinetic / w->trial->summary.energy_scale;
    if (!(warmth > w->rule->cold) || w->broken)
        return;
    snprintf(w->why, sizeof w->why, "at t = %.6g the kinetic energy is %.3g of the scale",
             sample->time, warmth);
    violate(w, DL_TRIAL_HEATING);
}

/* Largest distance from uniform motion in units of the path. */
static double bend(const dl_scene *scene, const dl_sample *sample) {
    const size_t n = scene->particles, dimension = (size_t)scene->dimension;
    double largest = 0;
    for (size_t i = 0; i < n; i++) {
        double off = 0, path = 0;
        for (size_t c = 0; c < dimension; c++) {
            const double way = scene->velocity[c * n + i] * sample->time;
            const double distance = sample->y_all[c * n + i] - scene->position[c * n + i] - way;
            off += distance * distance;
            path += way * way;
        }
        if (!scene->pinned[i] && path > 0)
            largest = fmax(largest, sqrt(off / path));
    }
    return largest;
}

static void judge_straightness(watch *w, const dl_sample *sample) {
    if (isinf(w->rule->straight) || w->broken)
        return;
    const double off = bend(w->unit->scene, sample);
    if (off <= w->rule->straight)
        return;
    snprintf(w->why, sizeof w->why, "at t = %.6g a particle is %.3g of its path off the line",
             sample->time, off);
    violate(w, DL_TRIAL_BENDING);
}

static dl_status judge_passage(watch *w, const dl_sample *sample, dl_error *error) {
    char where[200];
    const dl_status status = dl_passage_look(w->passage, sample, where, sizeof where, error);
    if (status || !where[0] || w->broken)
        return status;
    snprintf(w->why, sizeof w->why, "at t = %.6g %s", sample->time, where);
    violate(w, DL_TRIAL_TUNNELLING);
    return DL_OK;
}

static dl_status look(void *context, const dl_sample *sample, dl_error *error) {
    watch *const w = context;
    judge_energy(w, sample);
    judge_warmth(w, sample);
    judge_straightness(w, sample);
    const dl_status status = judge_passage(w, sample, error);
    if (status)
        return status;
    if (!w->broken)
        w->trial->held = sample->time;
    /* An energy error may grow on to a blow-up; the rest is decided. */
    w->stop =
        w->broken && w->trial->end != DL_TRIAL_ENERGY_GAIN && w->trial->end != DL_TRIAL_ENERGY_LOSS;
    return w->stop ? dl_fail(error, DL_UNSTABLE, "%s", w->why) : DL_OK;
}

/* --- how it ended ----------------------------------------------------------------------------- */

/* Statuses that say how a run ended where the rule had held until then. */
static const struct {
    dl_status status;
    dl_trial_end end;
} ends[] = {
    {DL_OK, DL_TRIAL_STABLE},
    {DL_UNSTABLE, DL_TRIAL_BLOW_UP},
    {DL_NONLINEAR_FAILURE, DL_TRIAL_SOLVER},
    {DL_STEP_FAILURE, DL_TRIAL_COLLAPSE},
    {DL_TIMEOUT, DL_TRIAL_TIME_OUT},
    {DL_INPUT, DL_TRIAL_REFUSED},
    {DL_ERROR, DL_TRIAL_SOLVER},
};

static dl_status conclude(watch *w, dl_error *error) {
    dl_trial *const trial = w->trial;
    const dl_run_summary *const summary = &trial->summary;
    trial->energy_error = summary->energy_error_max / summary->energy_scale;
    /* The rule in a summary's words, where no samples were told. */
    if (!w->broken && summary->status == DL_OK && trial->energy_error > w->rule->energy) {
        snprintf(w->why, sizeof w->why, "the energy error is %.3g of the scale",
                 trial->energy_error);
        violate(w, DL_TRIAL_ENERGY_GAIN);
    }
    const bool blown = summary->status == DL_UNSTABLE && !w->stop;
    memcpy(trial->why, w->why, sizeof trial->why);
    if (!w->broken)
        trial->held = summary->t_end_reached;
    if (w->broken && !blown)
        return DL_OK;
    memcpy(trial->why, summary->message, sizeof trial->why);
    for (size_t k = 0; k < sizeof ends / sizeof *ends; k++)
        if (ends[k].status == summary->status) {
            trial->end = ends[k].end;
            return DL_OK;
        }
    return dl_fail(error, summary->status, "%s", summary->message);
}

/* A run as it is asked for, and what comes of it. */
typedef struct job {
    const dl_study_unit *unit;
    const void *options;
    double end, sample;
    const dl_trial_rule *rule;
    struct answer { /* goes from process to process */
        dl_status status;
        dl_error error;
        dl_trial trial;
    } answer;
    bool answered;
} job;

static dl_status run_here(const dl_study_unit *unit, const void *options, double end, double sample,
                          const dl_trial_rule *rule, dl_trial *trial, dl_error *error) {
    watch w = {.unit = unit, .rule = rule, .trial = trial};
    dl_run_options how;
    *trial = (dl_trial){.energy_error = NAN};
    dl_status status = dl_passage_create(unit->scene, &w.passage, error);
    if (status)
        return status;
    dl_run_options_default(&how);
    how.end = end;
    how.sample = sample;
    how.time_limit = unit->seconds;
    how.energy_bound = fmax(blow_up, rule->energy);
    how.on_sample = look;
    how.context = &w;
    status = unit->run(unit->scene, unit->row, options, &how, &trial->summary, NULL, error);
    if (status == DL_INPUT) { /* a scene that this method cannot take */
        trial->end = DL_TRIAL_REFUSED;
        memcpy(trial->why, error->message, sizeof trial->why);
        status = DL_OK;
    } else if (!status) {
        status = conclude(&w, error);
    }
    dl_passage_free(w.passage);
    return status;
}

static void work(void *context, int pipe) {
    job *const j = context;
    struct answer *const answer = &j->answer;
    answer->status =
        run_here(j->unit, j->options, j->end, j->sample, j->rule, &answer->trial, &answer->error);
    dl_child_send(pipe, answer, sizeof *answer);
}

static dl_status receive(void *context, const void *data, size_t size, dl_error *error) {
    job *const j = context;
    if (size != sizeof j->answer)
        return dl_fail(error, DL_ERROR, "a run's process sent what is not expected");
    memcpy(&j->answer, data, size);
    j->answered = true;
    return DL_OK;
}

/* A step that does not return, and one that crashes, are ends like others. */
dl_status dl_trial_run(const dl_study_unit *unit, const void *options, double end, double sample,
                       const dl_trial_rule *rule, dl_trial *trial, dl_error *error) {
    job j = {.unit = unit, .options = options, .end = end, .sample = sample, .rule = rule};
    const dl_child_work child = {
        .work = work, .receive = receive, .context = &j, .seconds = unit->seconds};
    dl_error why = {""};
    const dl_status ended = dl_child_run(&child, &why);
    if (ended == DL_OK && j.answered) {
        *trial = j.answer.trial;
        return j.answer.status ? dl_fail(error, j.answer.status, "%s", j.answer.error.message)
                               : DL_OK;
    }
    if (ended != DL_OK && ended != DL_TIMEOUT && ended != DL_ERROR)
        return dl_fail(error, ended, "%s", why.message);
    *trial = (dl_trial){.end = ended == DL_TIMEOUT ? DL_TRIAL_TIME_OUT : DL_TRIAL_CRASH,
                        .energy_error = NAN};
    dl_run_summary_clear(&trial->summary);
    memcpy(trial->why, why.message, sizeof trial->why);
    return DL_OK;
}

/* --- fixed steps ------------------------------------------------------------------------------ */

double dl_trial_step(const dl_scene *scene, double step) {
    return scene->radiation.present
               ? scene->radiation.period / ceil(scene->radiation.period / step * (1 - 1e-12))
               : step;
}

dl_status dl_trial_options(const dl_study_unit *unit, double step, void **options,
                           dl_error *error) {
    char text[40];
    dl_status status = dl_method_options_copy(unit->row, unit->options, options, error);
    if (status)
        return status;
    dl_format_real(step, text, sizeof text);
    status = dl_method_options_set(unit->row, *options, "step", text, error);
    if (!status)
        return DL_OK;
    dl_method_options_free(unit->row, *options);
    *options = NULL;
    return status;
}

unsigned long dl_trial_steps(const dl_study_unit *unit, double step, const dl_trial_rule *rule) {
    const double wanted = ceil(unit->end / step * (1 - 1e-12));
    return (unsigned long)fmin(fmax(wanted, (double)rule->least), (double)rule->most);
}

dl_status dl_trial_run_at(const dl_study_unit *unit, double step, const dl_trial_rule *rule,
                          dl_trial *trial, dl_error *error) {
    void *options;
    const double count = (double)dl_trial_steps(unit, step, rule);
    const double between = ceil(count / (double)rule->looks);
    const dl_status status = dl_trial_options(unit, step, &options, error);
    if (status)
        return status;
    const dl_status ran =
        dl_trial_run(unit, options, count * step, between * step, rule, trial, error);
    dl_method_options_free(unit->row, options);
    return ran;
}
