/* driftlab observe: what a trajectory, or a scene's initial state, looks like. */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"
#include "cli/observed.h"
#include "cli/outcome.h"
#include "driftlab/trajectory.h"

typedef struct observe_values {
    char *what, *scene;
    double from, bin, across, link, beyond;
    long window;
    int temperature;
    bool last, json;
} observe_values;

static const dl_temperature_rule *const rules[] = {&dl_temperature_published,
                                                   &dl_temperature_program};
static const char *const rule_words[] = {"published", "program", NULL};

#define LENGTH(name_, member, word, doc_)                                                          \
    {                                                                                              \
        .name = name_, .kind = DL_REAL, .offset = offsetof(observe_values, member), .unit = word,  \
        .minimum = 0, .maximum = INFINITY, .above_minimum = true, .doc = doc_                      \
    }

static const dl_parameter options[] = {
    {.name = "what",
     .kind = DL_TEXT,
     .offset = offsetof(observe_values, what),
     .unit = "A,B,...",
     .doc = "observables (driftlab list observables); default: all that the scene has"},
    {.name = "from",
     .kind = DL_REAL,
     .offset = offsetof(observe_values, from),
     .unit = "T",
     .minimum = -INFINITY,
     .maximum = INFINITY,
     .fallback = "0",
     .doc = "average from this time on"},
    {.name = "last",
     .kind = DL_FLAG,
     .offset = offsetof(observe_values, last),
     .fallback = "false",
     .doc = "the last frame alone (its temperatures remember those before)"},
    {.name = "scene",
     .kind = DL_TEXT,
     .offset = offsetof(observe_values, scene),
     .unit = "SCENE",
     .doc = "scene of the trajectory (default: the one it holds)"},
    LENGTH("bin", bin, "W", "width of the bins of height (default: at most 13 of them)"),
    LENGTH("across", across, "L",
           "length of a level plane, for densities and pressure (default: from wall to wall)"),
    LENGTH("link", link, "D",
           "escaped: distance within which particles hold together (default: the end of the pair "
           "law's first piece)"),
    LENGTH("beyond", beyond, "R",
           "escaped: distance from the system at which a group can have (default: any)"),
    {.name = "temperature",
     .kind = DL_WORD,
     .offset = offsetof(observe_values, temperature),
     .unit = "RULE",
     .words = rule_words,
     .fallback = "published",
     .doc = "published: over 1e4, mean of the window; program: over 1e3, exponential mean"},
    {.name = "window",
     .kind = DL_INTEGER,
     .offset = offsetof(observe_values, window),
     .unit = "STEPS",
     .minimum = 1,
     .maximum = 100000,
     .fallback = "500",
     .doc = "steps (of the scene) that temperatures are averaged over"},
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(observe_values, json),
     .fallback = "false",
     .doc = "print one JSON object instead of tables"},
};

/* Where frames come from. */
typedef struct source {
    const char *file;
    bool is_trajectory;
    dl_scene *scene;
    size_t frames; /* in all */
    size_t first;  /* to be observed */
    double lowest, highest;
    double from, to; /* times of the first and the last observed */
} source;

static dl_status open_source(source *s, const observe_values *values, dl_error *error) {
    s->is_trajectory = dl_file_is_hdf5(s->file);
    s->frames = 1;
    if (!s->is_trajectory && values->scene)
        return dl_fail(error, DL_INPUT, "--scene: found %s beside %s, expected a trajectory there",
                       values->scene, s->file);
    if (!s->is_trajectory)
        return dl_scene_read(s->file, &s->scene, error);
    dl_status status = values->scene ? dl_scene_read(values->scene, &s->scene, error)
                                     : dl_scene_read_trajectory(s->file, &s->scene, error);
    dl_trajectory_frame frame;
    if (!status)
        status = dl_trajectory_read_frame(s->file, 0, &frame, error);
    if (status)
        return status;
    s->frames = frame.frames;
    dl_trajectory_frame_free(&frame);
    return DL_OK;
}

/* State and time of frame `number`; *y_all is the caller's. */
static dl_status read_state(const source *s, size_t number, double **y_all, double *time,
                            dl_error *error) {
    if (s->is_trajectory)
        return dl_trajectory_read_state(s->file, number, s->scene, y_all, time, error);
    const size_t block = (size_t)s->scene->dimension * s->scene->particles;
    *time = 0;
    *y_all = malloc(2 * block * sizeof **y_all);
    if (!*y_all)
        return dl_fail_memory(error, "a state of every particle");
    memcpy(*y_all, s->scene->position, block * sizeof **y_all);
    memcpy(*y_all + block, s->scene->velocity, block * sizeof **y_all);
    return DL_OK;
}

/* Which frames are observed, and the heights in them. */
static dl_status survey(source *s, const observe_values *values, dl_error *error) {
    s->first = s->frames;
    s->lowest = INFINITY;
    s->highest = -INFINITY;
    for (size_t k = 0; k < s->frames; k++) {
        double *y_all, time, lowest, highest;
        const dl_status status = read_state(s, k, &y_all, &time, error);
        if (status)
            return status;
        const bool observed = values->last ? k + 1 == s->frames : time >= values->from;
        dl_observe_heights(s->scene, y_all, &lowest, &highest);
        free(y_all);
        if (!observed)
            continue;
        if (s->first == s->frames) {
            s->first = k;
            s->from = time;
        }
        s->to = time;
        s->lowest = fmin(s->lowest, lowest);
        s->highest = fmax(s->highest, highest);
    }
    return s->first < s->frames ? DL_OK
                                : dl_fail(error, DL_INPUT,
                                          "--from: found %.15g, expected a time not after the last "
                                          "frame's",
                                          values->from);
}

/* The names in `list` as flags. */
static dl_status read_names(const char *list, bool *wanted, dl_error *error) {
    for (const char *next = list; next; list = next) {
        char name[64];
        size_t index;
        const size_t length = strcspn(list, ",");
        next = list[length] ? list + length + 1 : NULL;
        if (length == 0)
            return dl_fail(error, DL_INPUT,
                           "--what: found no name%s, expected names with commas between them",
                           next ? " before a comma" : " at the end");
        snprintf(name, sizeof name, "%.*s", (int)(length < 63 ? length : 63), list);
        dl_error reason;
        if (dl_observable_find(name, &index, &reason))
            return dl_fail(error, DL_INPUT, "--what: %s", reason.message);
        wanted[index] = true;
    }
    return DL_OK;
}

static dl_status create(const source *s, const observe_values *values, dl_observation **observation,
                        dl_error *error) {
    bool *wanted = calloc(dl_observable_count(), sizeof *wanted);
    if (!wanted)
        return dl_fail_memory(error, "an observation");
    dl_observe_options how;
    dl_observe_options_default(&how);
    how.temperature = rules[values->temperature];
    how.temperature_steps = (size_t)values->window;
    how.bin = values->bin;
    how.across = values->across;
    how.link = values->link;
    how.beyond = values->beyond;
    dl_status status = values->what ? read_names(values->what, wanted, error) : DL_OK;
    if (!status)
        status =
            dl_observation_create(s->scene, &how, values->what ? wanted : NULL,
                                  s->frames - s->first, s->lowest, s->highest, observation, error);
    free(wanted);
    return status;
}

static dl_status observe_frames(const source *s, dl_observation *observation, dl_error *error) {
    dl_status status = DL_OK;
    for (size_t k = 0; k < s->frames && !status; k++) {
        double *y_all, time;
        status = read_state(s, k, &y_all, &time, error);
        if (status)
            return status;
        status = k < s->first ? dl_observation_warm(observation, time, y_all, error)
                              : dl_observation_add(observation, time, y_all, error);
        free(y_all);
    }
    return status;
}

static cli_exit observe(const cli_input *input) {
    const observe_values *values = input->values;
    source s = {.file = input->word[0]};
    dl_observation *observation = NULL;
    dl_error error = {""};
    dl_status status = DL_OK;
    if (values->last && cli_input_gives(&cli_command_observe, input, "from"))
        status = dl_fail(&error, DL_INPUT, "--last, --from: found both, expected one");
    if (!status)
        status = open_source(&s, values, &error);
    if (!status)
        status = survey(&s, values, &error);
    if (!status)
        status = create(&s, values, &observation, &error);
    if (!status)
        status = observe_frames(&s, observation, &error);
    const cli_observed observed = {.file = s.file,
                                   .scene = s.scene,
                                   .frames = s.frames - s.first,
                                   .from = s.from,
                                   .to = s.to,
                                   .temperature = rules[values->temperature],
                                   .observation = observation};
    if (!status && values->json)
        status = cli_observed_json(&observed, stdout, &error);
    else if (!status)
        cli_observed_table(&observed, stdout);
    dl_observation_free(observation);
    dl_scene_free(s.scene);
    return cli_finish(status, &error);
}

const cli_command cli_command_observe = {
    .name = "observe",
    .arguments = "TRAJECTORY.h5 | SCENE",
    .summary = "temperature, states, density, pressure ... of a trajectory or an initial state",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .values_size = sizeof(observe_values),
    .run = observe,
};
