/* driftlab observe: what a trajectory, or a scene's initial state, looks like. */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/command.h"
#include "cli/observe_source.h"
#include "cli/observed.h"
#include "cli/outcome.h"

typedef struct observe_values {
    char *what, *scene;
    double from, to, time, bin, across, link, beyond;
    long step, every, window;
    int temperature, over;
    bool last, json;
} observe_values;

static const dl_temperature_rule *const rules[] = {&dl_temperature_published,
                                                   &dl_temperature_program};
static const char *const rule_words[] = {"published", "program", NULL};
static const char *const over_words[] = {"all", "system", NULL};

#define TIME(name_, member, default_, doc_)                                                        \
    {                                                                                              \
        .name = name_, .kind = DL_REAL, .offset = offsetof(observe_values, member), .unit = "T",   \
        .minimum = -DBL_MAX, .maximum = INFINITY, .fallback = default_, .doc = doc_                \
    }
#define COUNT(name_, member, word, least, most, default_, doc_)                                    \
    {                                                                                              \
        .name = name_, .kind = DL_INTEGER, .offset = offsetof(observe_values, member),             \
        .unit = word, .minimum = least, .maximum = most, .fallback = default_, .doc = doc_         \
    }
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
    TIME("from", from, "0", "average from this time on"),
    TIME("to", to, NULL, "average to this time (default: the last frame's)"),
    TIME("time", time, NULL, "the frame at this time alone"),
    COUNT("step", step, "N", 0, 1e15, NULL, "the frame at this step of the method alone"),
    {.name = "last",
     .kind = DL_FLAG,
     .offset = offsetof(observe_values, last),
     .fallback = "false",
     .doc = "the last frame alone (temperatures of a frame remember those before)"},
    COUNT("every", every, "N", 1, 1e9, NULL,
          "no average: a line of CSV, or an entry of JSON, for every N-th frame"),
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
    {.name = "over",
     .kind = DL_WORD,
     .offset = offsetof(observe_values, over),
     .unit = "WHAT",
     .words = over_words,
     .fallback = "all",
     .doc = "energy, motion, temperature, states: of all particles, as TR299 has them, or of the "
            "system alone, the heaviest group that --link holds together"},
    {.name = "temperature",
     .kind = DL_WORD,
     .offset = offsetof(observe_values, temperature),
     .unit = "RULE",
     .words = rule_words,
     .fallback = "published",
     .doc = "published: over 1e4, mean of the window; program: over 1e3, exponential mean"},
    COUNT("window", window, "STEPS", 1, 100000, "500",
          "steps (of the scene) that temperatures are averaged over"),
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(observe_values, json),
     .fallback = "false",
     .doc = "print one JSON object instead of tables"},
};

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

/* Whether anything that is wanted goes by height. */
static bool wants_bins(const bool *wanted) {
    for (size_t k = 0; k < dl_observable_count(); k++)
        if ((!wanted || wanted[k]) && dl_observable_at(k)->rows == DL_ROWS_BINS)
            return true;
    return false;
}

static dl_status create(cli_source *source, const observe_values *values, const bool *wanted,
                        dl_observation **observation, dl_error *error) {
    double lowest = 0, highest = 0;
    dl_observe_options how;
    dl_observe_options_default(&how);
    how.temperature = rules[values->temperature];
    how.temperature_steps = (size_t)values->window;
    how.bin = values->bin;
    how.across = values->across;
    how.link = values->link;
    how.beyond = values->beyond;
    how.of_system = values->over == 1;
    dl_status status =
        wants_bins(wanted) ? cli_source_heights(source, &lowest, &highest, error) : DL_OK;
    return status ? status
                  : dl_observation_create(source->scene, &how, wanted, cli_source_observed(source),
                                          lowest, highest, observation, error);
}

/* Frames that are not observed count for the temperatures of later ones. `series` NULL: none. */
static dl_status observe_frames(cli_source *source, dl_observation *observation, cli_series *series,
                                dl_error *error) {
    dl_status status = DL_OK;
    for (size_t k = 0; k <= source->last && !status; k++) {
        const double time = cli_source_time(source, k);
        status = cli_source_read(source, k, error);
        if (status)
            return status;
        if (!cli_source_observes(source, k)) {
            status = dl_observation_warm(observation, time, source->y_all, error);
            continue;
        }
        status = dl_observation_add(observation, time, source->y_all, error);
        if (!status && series)
            status = cli_series_add(series, time, cli_source_step(source, k), error);
    }
    return status;
}

/* Whether states are observed, or temperatures are asked for by name: every scene has these. */
static bool wants_temperatures(const observe_values *values, const dl_observation *observation) {
    dl_observed observed;
    for (size_t k = 0; k < dl_observation_count(observation); k++) {
        dl_observation_get(observation, k, &observed);
        if (strcmp(observed.observable->name, "states") == 0 ||
            (values->what && strcmp(observed.observable->name, "temperature") == 0))
            return true;
    }
    return false;
}

/* A temperature is the mean of so many steps: from a few frames of them it is another number. A
 * moment that has no past, of a scene or the first frame, cannot have more. */
static void warn_of_few_frames(const observe_values *values, const cli_source *source,
                               const dl_observation *observation) {
    static const double fewest = 10; /* frames in a window */
    if (!source->frames || source->last == 0 || !wants_temperatures(values, observation))
        return;
    const double step = source->scene->step;
    const double apart =
        (cli_source_time(source, source->last) - cli_source_time(source, source->last - 1)) / step;
    if (apart * fewest <= (double)values->window * (1 + 1e-9))
        return;
    fprintf(stderr,
            "driftlab: %s: warning: temperatures and states are means over %ld steps, the frames "
            "lie %.4g steps apart: expected %.0f frames or more in %ld steps (driftlab run "
            "--sample %.4g)\n",
            source->file, values->window, apart, fewest, values->window,
            (double)values->window * step / fewest);
}

static dl_status show(const observe_values *values, cli_source *source, bool in_series,
                      dl_observation *observation, dl_error *error) {
    const cli_observed observed = {.file = source->file,
                                   .scene = source->scene,
                                   .frames = cli_source_observed(source),
                                   .from = cli_source_time(source, source->first),
                                   .to = cli_source_time(source, source->last),
                                   .temperature = rules[values->temperature],
                                   .observation = observation};
    cli_series series;
    warn_of_few_frames(values, source, observation);
    cli_series_begin(&series, &observed, values->json, stdout);
    const dl_status status = observe_frames(source, observation, in_series ? &series : NULL, error);
    if (in_series)
        return cli_series_end(&series, status, error);
    if (!status && values->json)
        return cli_observed_json(&observed, stdout, error);
    if (!status)
        cli_observed_table(&observed, stdout);
    return status;
}

/* Options that choose frames: one alone, or a range. */
static dl_status check_choice(const cli_input *input, dl_error *error) {
    static const char *const one[] = {"last", "time", "step"};
    static const char *const other[] = {"last", "time", "step", "from", "to", "every"};
    for (size_t a = 0; a < sizeof one / sizeof *one; a++)
        for (size_t b = a + 1; b < sizeof other / sizeof *other; b++)
            if (cli_input_gives(&cli_command_observe, input, one[a]) &&
                cli_input_gives(&cli_command_observe, input, other[b]))
                return dl_fail(error, DL_INPUT, "--%s, --%s: found both, expected one", one[a],
                               other[b]);
    return DL_OK;
}

static cli_choice choice_of(const cli_input *input) {
    const observe_values *values = input->values;
    const cli_command *const command = &cli_command_observe;
    return (cli_choice){
        .last = values->last,
        .from = values->from,
        .to = cli_input_gives(command, input, "to") ? values->to : INFINITY,
        .time = cli_input_gives(command, input, "time") ? values->time : INFINITY,
        .step = cli_input_gives(command, input, "step") ? values->step : -1,
        .every = cli_input_gives(command, input, "every") ? values->every : 1,
    };
}

static cli_exit observe(const cli_input *input) {
    const observe_values *values = input->values;
    const bool in_series = cli_input_gives(&cli_command_observe, input, "every");
    const cli_choice choice = choice_of(input);
    cli_source source = {0};
    dl_observation *observation = NULL;
    dl_error error = {""};
    bool *const wanted = calloc(dl_observable_count(), sizeof *wanted);
    dl_status status =
        wanted ? check_choice(input, &error) : dl_fail_memory(&error, "an observation");
    if (!status && values->what)
        status = read_names(values->what, wanted, &error);
    if (!status)
        status = cli_source_open(input, values->scene, &source, &error);
    if (!status)
        status = cli_source_choose(&source, &choice, &error);
    if (!status)
        status = create(&source, values, values->what ? wanted : NULL, &observation, &error);
    if (!status)
        status = show(values, &source, in_series, observation, &error);
    dl_observation_free(observation);
    cli_source_close(&source);
    free(wanted);
    return cli_finish(status, &error);
}

const cli_command cli_command_observe = {
    .name = "observe",
    .arguments = "TRAJECTORY.h5 | SCENE",
    .summary = "temperature, states, density, pressure ... of a trajectory or an initial state",
    .details =
        "Of a trajectory the mean over its frames; one of them with --time, --step or --last; "
        "all of them,\none after the other, with --every 1.\n",
    .least_words = 1,
    .most_words = 1,
    .takes_let = true,
    .options = CLI_TABLE(options),
    .values_size = sizeof(observe_values),
    .run = observe,
};
