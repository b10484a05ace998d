#include "page_data.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/across.h"
#include "driftlab/front.h"
#include "driftlab/reference.h"
#include "report/page.h"
#include "report/page_findings.h"
#include "report/page_scaling.h"
#include "study/errors.h"
#include "version.h"

/* The page under construction; `failed` once anything could not be added. */
typedef struct builder {
    const dl_results *const *all; /* [count] */
    size_t count;
    const dl_results *results; /* the one at hand */
    size_t first;              /* where its cases begin among those of all */
    bool failed;
} builder;

static void take(builder *build, size_t k) {
    build->first = 0;
    for (size_t i = 0; i < k; i++)
        build->first += build->all[i]->cases;
    build->results = build->all[k];
}

static void put(builder *build, json_t *object, const char *key, json_t *value) {
    if (!object || json_object_set_new(object, key, value) != 0)
        build->failed = true;
}

static void append(builder *build, json_t *array, json_t *value) {
    if (!array || json_array_append_new(array, value) != 0)
        build->failed = true;
}

static json_t *real(double value) {
    return isfinite(value) ? json_real(value) : json_null();
}

static json_t *reals(builder *build, const double *values, size_t count) {
    json_t *array = json_array();
    for (size_t i = 0; values && i < count; i++)
        append(build, array, real(values[i]));
    return array;
}

/* Messages are cut to a buffer's size, perhaps inside a character: what is no UTF-8 becomes `?`. */
json_t *dl_page_text(const char *value) {
    if (!value)
        return json_string("");
    json_t *string = json_string(value);
    if (string)
        return string;
    char *plain = strdup(value);
    if (!plain)
        return NULL;
    for (char *c = plain; *c; c++)
        if ((unsigned char)*c >= 0x80)
            *c = '?';
    string = json_string(plain);
    free(plain);
    return string;
}

/* Energies are shown relative to the scene's energy scale, momenta to their own. */
static double relative(double value, double scale) {
    return scale > 0 ? fabs(value) / scale : NAN;
}

/* Why the error is not drawn as a point, or "" where it is. */
static const char *reason_not_drawn(const dl_run_summary *summary, const char *refused,
                                    double shown, const char *missing) {
    if (summary->status != DL_OK)
        return summary->message[0] ? summary->message : dl_status_name(summary->status);
    if (refused[0])
        return refused;
    if (!isfinite(shown))
        return missing;
    if (shown <= 0)
        return "the error is exactly 0, which has no place on a logarithmic axis";
    if (!(summary->cpu_seconds > 0))
        return "the run was too short for the clock";
    return "";
}

typedef struct named_text {
    const char *name;
    size_t offset;
} named_text;

static void put_texts(builder *build, json_t *object, const void *source, const named_text *table,
                      size_t count) {
    for (size_t i = 0; i < count; i++) {
        char *value;
        memcpy(&value, (const char *)source + table[i].offset, sizeof value);
        put(build, object, table[i].name, dl_page_text(value));
    }
}

static void put_costs(builder *build, json_t *object, const dl_run_summary *summary) {
    const struct {
        const char *name;
        unsigned long count;
    } table[] = {
        {"steps", summary->steps},
        {"rejected_steps", summary->rejected_steps},
        {"force_evaluations", summary->force_evaluations},
        {"jacobian_evaluations", summary->jacobian_evaluations},
        {"jacobian_vector_products", summary->jacobian_vector_products},
        {"nonlinear_iterations", summary->nonlinear_iterations},
        {"linear_iterations", summary->linear_iterations},
        {"factorisations", summary->factorisations},
        {"neighbour_list_builds", summary->neighbour_list_builds},
        {"wall_hits", summary->wall_hits},
        {"crossings", summary->crossings},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        put(build, object, table[i].name, json_integer((json_int_t)table[i].count));
}

static void put_errors(builder *build, json_t *object, const dl_case *cased) {
    const dl_run_summary *summary = &cased->summary;
    const bool past =
        dl_case_is_past_horizon(cased, dl_results_reference(build->results, cased->scene));
    const struct {
        const char *name;
        double value;
    } table[] = {
        {"position_error", past ? NAN : cased->position_error},
        {"position_error_max", past ? NAN : cased->position_error_max},
        {"position_error_ever", cased->position_error_ever},
        {"energy_error", relative(summary->energy_error_max, summary->energy_scale)},
        {"energy_error_final", relative(summary->energy_error_final, summary->energy_scale)},
        {"energy_scale", summary->energy_scale},
        {"force_error_stated", summary->force_error_stated},
        {"force_error", summary->force_error_max},
        {"momentum_error", relative(summary->momentum_error_max, summary->momentum_scale)},
        {"angular_momentum_error",
         relative(summary->angular_momentum_error_max, summary->angular_momentum_scale)},
        {"cpu_seconds", summary->cpu_seconds},
        {"cpu_median", cased->cpu_median},
        {"t_end_reached", summary->t_end_reached},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++)
        put(build, object, table[i].name, real(table[i].value));
}

/* `invalid` speaks of the run, `refused` of the position errors alone: those need the reference.
 */
static json_t *reasons_not_drawn(builder *build, const dl_case *cased) {
    json_t *reasons = json_object();
    for (size_t i = 0; i < DL_ERROR_ROWS; i++) {
        const dl_error_row *row = &dl_error_rows[i];
        const char *refused =
            row->needs_reference && !*cased->invalid ? cased->refused : cased->invalid;
        put(build, reasons, row->name,
            dl_page_text(reason_not_drawn(&cased->summary, refused, row->of(cased), row->missing)));
    }
    return reasons;
}

static size_t largest_energy_error(const dl_case *cased, size_t from, size_t to) {
    size_t best = from;
    for (size_t i = from + 1; cased->sample_energy_error && i < to; i++)
        if (fabs(cased->sample_energy_error[i]) > fabs(cased->sample_energy_error[best]))
            best = i;
    return best;
}

/* NaN where it is not one: too small for the reference, or past the horizon. */
static double position_error(const builder *build, const dl_case *cased, size_t i) {
    const dl_reference *reference = dl_results_reference(build->results, cased->scene);
    if (!cased->sample_position_error)
        return NAN;
    const double error = cased->sample_position_error[i];
    return !reference || i >= reference->samples || dl_reference_shows(reference, i, error) ? error
                                                                                            : NAN;
}

/* One of a case's series over time. */
typedef struct page_series {
    const char *name;
    const double *values; /* [samples]; NULL: the case has none of it, and the page no key */
    double scale;         /* 0: in the scene's own units */
} page_series;

static json_t *one_series(builder *build, const dl_case *cased, const page_series *of,
                          size_t stride) {
    json_t *array = json_array();
    for (size_t from = 0; from < cased->samples; from += stride) {
        const size_t to = from + stride < cased->samples ? from + stride : cased->samples;
        const size_t i = largest_energy_error(cased, from, to);
        const double value = of->values == cased->sample_position_error
                                 ? position_error(build, cased, i)
                                 : of->values[i];
        append(build, array, real(of->scale != 0 ? relative(value, of->scale) : value));
    }
    return array;
}

/* {time, energy, position, momentum, angular-momentum, stride}, as far as the case has them: every
 * sample, or of `stride` neighbours the one with the largest energy error. */
static json_t *samples(builder *build, const dl_case *cased) {
    const dl_run_summary *summary = &cased->summary;
    const page_series table[] = {
        {"time", cased->sample_time, 0},
        {"energy", cased->sample_energy_error, summary->energy_scale},
        {"position", cased->sample_position_error, 0},
        {"momentum", cased->sample_momentum_error, summary->momentum_scale},
        {"angular-momentum", cased->sample_angular_momentum_error, summary->angular_momentum_scale},
    };
    json_t *object = json_object();
    const size_t stride = (cased->samples + DL_PAGE_SAMPLES - 1) / DL_PAGE_SAMPLES;
    for (size_t k = 0; k < sizeof table / sizeof *table; k++)
        if (table[k].values)
            put(build, object, table[k].name, one_series(build, cased, &table[k], stride));
    put(build, object, "stride", json_integer((json_int_t)stride));
    return object;
}

static json_t *one_case(builder *build, const dl_case *cased) {
    static const named_text texts[] = {
        {"key", offsetof(dl_case, key)},         {"scene", offsetof(dl_case, scene)},
        {"method", offsetof(dl_case, method)},   {"family", offsetof(dl_case, family)},
        {"options", offsetof(dl_case, options)}, {"command", offsetof(dl_case, command)},
        {"invalid", offsetof(dl_case, invalid)}, {"refused", offsetof(dl_case, refused)},
    };
    json_t *object = json_object();
    put_texts(build, object, cased, texts, sizeof texts / sizeof *texts);
    put(build, object, "status", dl_page_text(dl_status_name(cased->summary.status)));
    put(build, object, "message", dl_page_text(cased->summary.message));
    put(build, object, "repeats", json_integer((json_int_t)cased->repeats));
    put_errors(build, object, cased);
    put(build, object, "not_drawn", reasons_not_drawn(build, cased));
    put_costs(build, object, &cased->summary);
    put(build, object, "samples", samples(build, cased));
    return object;
}

static json_t *reference_of(builder *build, const char *scene) {
    const dl_reference *reference = dl_results_reference(build->results, scene);
    if (!reference)
        return json_null();
    json_t *object = json_object();
    put(build, object, "description", dl_page_text(reference->description));
    put(build, object, "precision", dl_page_text(reference->precision));
    put(build, object, "note", dl_page_text(reference->note));
    put(build, object, "error", real(reference->error));
    put(build, object, "margin", json_integer(DL_REFERENCE_MARGIN));
    put(build, object, "length", real(reference->length));
    put(build, object, "lyapunov", real(reference->lyapunov_error > 0 ? reference->lyapunov : NAN));
    put(build, object, "lyapunov_error", real(reference->lyapunov_error));
    put(build, object, "grows", json_boolean(dl_reference_grows(reference)));
    put(build, object, "horizon", real(reference->horizon > 0 ? reference->horizon : NAN));
    put(build, object, "parted", real(reference->parted > 0 ? reference->parted : NAN));
    put(build, object, "growth",
        real(reference->growth && reference->samples ? reference->growth[reference->samples - 1]
                                                     : NAN));
    put(build, object, "time", reals(build, reference->time, reference->samples));
    put(build, object, "sample_error", reals(build, reference->sample_error, reference->samples));
    return object;
}

/* --- what accuracy costs ------------------------------------------------------------------- */

static const char *const cost_names[DL_COSTS] = {"cpu", "force", "steps"};

typedef struct front {
    dl_front_point *point; /* [count] */
    size_t count;
} front;

static json_t *indices(builder *build, const front *of) {
    json_t *array = json_array();
    for (size_t i = 0; i < of->count; i++)
        append(build, array,
               json_integer((json_int_t)build->first + (json_int_t)of->point[i].index));
    return array;
}

/* [{error, cpu, force, steps}]: for every decade the cheapest case, by each cost. */
static json_t *accuracies(builder *build, const front fronts[DL_COSTS]) {
    json_t *array = json_array();
    int largest = 0, smallest = 0;
    bool any = false;
    for (int cost = 0; cost < DL_COSTS; cost++) {
        int first, last;
        if (!dl_front_decades(fronts[cost].point, fronts[cost].count, &first, &last))
            continue;
        largest = any && largest > first ? largest : first;
        smallest = any && smallest < last ? smallest : last;
        any = true;
    }
    for (int exponent = largest; any && exponent >= smallest; exponent--) {
        const double error = pow(10, exponent);
        json_t *row = json_object();
        put(build, row, "error", json_real(error));
        for (int cost = 0; cost < DL_COSTS; cost++) {
            const dl_front_point *best =
                dl_front_cheapest(fronts[cost].point, fronts[cost].count, error);
            put(build, row, cost_names[cost],
                best ? json_integer((json_int_t)build->first + (json_int_t)best->index)
                     : json_null());
        }
        append(build, array, row);
    }
    return array;
}

/* {front: {cpu: [case ...], force, steps}, accuracies}, for one kind of error. */
static json_t *one_tradeoff(builder *build, const char *scene, const char *error_name) {
    json_t *object = json_object(), *fronts = json_object();
    front found[DL_COSTS] = {{NULL, 0}};
    for (int cost = 0; cost < DL_COSTS; cost++) {
        front *of = &found[cost];
        of->point = calloc(build->results->cases + 1, sizeof *of->point);
        if (of->point)
            of->count =
                dl_results_front(build->results, scene, error_name, (dl_cost)cost, of->point);
        else
            build->failed = true;
        put(build, fronts, cost_names[cost], indices(build, of));
    }
    put(build, object, "front", fronts);
    put(build, object, "accuracies", accuracies(build, found));
    for (int cost = 0; cost < DL_COSTS; cost++)
        free(found[cost].point);
    return object;
}

static json_t *tradeoffs(builder *build, const char *scene) {
    json_t *object = json_object();
    for (size_t i = 0; i < DL_ERROR_ROWS; i++)
        put(build, object, dl_error_rows[i].name,
            one_tradeoff(build, scene, dl_error_rows[i].name));
    return object;
}

/* `record` may be NULL: a scene that only cases name. */
static json_t *one_scene(builder *build, const char *name, const dl_scene_record *record) {
    static const named_text texts[] = {
        {"source", offsetof(dl_scene_record, source)},
        {"explain", offsetof(dl_scene_record, explain)},
        {"text", offsetof(dl_scene_record, text)},
    };
    const dl_results *results = build->results;
    json_t *object = json_object();
    put(build, object, "name", dl_page_text(name));
    if (record)
        put_texts(build, object, record, texts, sizeof texts / sizeof *texts);
    put(build, object, "asked_error", real(results->asked_error));
    put(build, object, "asked_in", dl_page_text(results->asked_in));
    put(build, object, "reference", reference_of(build, name));
    char answer[2 * DL_MESSAGE_SIZE];
    dl_results_answer(results, name, answer, sizeof answer);
    put(build, object, "answer", dl_page_text(answer));
    const dl_case *best = NULL;
    if (results->asked_error > 0)
        best = dl_results_cheapest(results, name, results->asked_in, results->asked_error);
    put(build, object, "cheapest",
        best ? json_integer((json_int_t)build->first + (best - results->cased)) : json_null());
    put(build, object, "tradeoff", tradeoffs(build, name));
    return object;
}

static bool has_scene(const json_t *scenes, const char *name) {
    for (size_t i = 0; i < json_array_size(scenes); i++) {
        const char *known = json_string_value(json_object_get(json_array_get(scenes, i), "name"));
        if (known && strcmp(known, name) == 0)
            return true;
    }
    return false;
}

static void add_scenes(builder *build, json_t *scenes) {
    const dl_results *results = build->results;
    for (size_t i = 0; i < results->scenes; i++) {
        const dl_scene_record *record = &results->scene[i];
        append(build, scenes, one_scene(build, record->name ? record->name : "", record));
    }
    for (size_t i = 0; i < results->cases; i++) {
        const char *name = results->cased[i].scene ? results->cased[i].scene : "";
        if (!has_scene(scenes, name))
            append(build, scenes, one_scene(build, name, NULL));
    }
}

static json_t *all_facts(builder *build) {
    json_t *facts = json_array();
    for (size_t i = 0; i < build->results->facts; i++) {
        json_t *fact = json_object();
        put(build, fact, "name", dl_page_text(build->results->fact[i].name));
        put(build, fact, "value", dl_page_text(build->results->fact[i].value));
        append(build, facts, fact);
    }
    return facts;
}

/* --- across scenes ------------------------------------------------------------------------- */

static size_t index_of(const builder *build, const dl_results *results, const dl_case *cased) {
    size_t first = 0;
    for (size_t k = 0; k < build->count && build->all[k] != results; k++)
        first += build->all[k]->cases;
    return first + (size_t)(cased - results->cased);
}

/* [{method, reached, worst, cells: [{case, ratio, rank} or null]}], cells in the order of scenes.
 */
static json_t *across_rows(builder *build, const dl_across *across) {
    json_t *rows = json_array();
    for (size_t m = 0; m < across->rows; m++) {
        const dl_across_row *row = &across->row[m];
        json_t *cells = json_array();
        for (size_t s = 0; s < across->scenes; s++) {
            const dl_across_cell *cell = &row->cell[s];
            append(
                build, cells,
                cell->best
                    ? json_pack("{s:I,s:o,s:I}", "case",
                                (json_int_t)index_of(build, across->scene[s].results, cell->best),
                                "ratio", real(cell->ratio), "rank", (json_int_t)cell->rank)
                    : json_null());
        }
        append(build, rows,
               json_pack("{s:s,s:I,s:o,s:o}", "method", row->method, "reached",
                         (json_int_t)row->reached, "worst", real(row->worst), "cells", cells));
    }
    return rows;
}

/* Methods by scenes; null where there are not several scenes that cases ran on. */
static json_t *across_scenes(builder *build, dl_error *error) {
    dl_across across;
    json_t *rows = NULL;
    if (dl_across_create(build->all, build->count, &across, error) != DL_OK)
        build->failed = true;
    else
        rows = across.scenes > 1 && across.rows > 0 ? across_rows(build, &across) : json_null();
    dl_across_release(&across);
    return rows;
}

/* --- all of it ----------------------------------------------------------------------------- */

static json_t *all_studies(builder *build) {
    static const named_text texts[] = {
        {"study", offsetof(dl_results, study)},
        {"title", offsetof(dl_results, title)},
        {"question", offsetof(dl_results, question)},
    };
    json_t *studies = json_array();
    for (size_t k = 0; k < build->count; k++) {
        json_t *study = json_object();
        take(build, k);
        put_texts(build, study, build->results, texts, sizeof texts / sizeof *texts);
        put(build, study, "facts", all_facts(build));
        append(build, studies, study);
    }
    return studies;
}

/* What `of` makes of each study, one after the other. */
static void put_lists(builder *build, json_t *root, const char *key,
                      json_t *(*of)(const dl_results *results)) {
    json_t *all = json_array();
    for (size_t k = 0; k < build->count; k++) {
        json_t *added = of(build->all[k]);
        build->failed |= !added || json_array_extend(all, added) != 0;
        json_decref(added);
    }
    put(build, root, key, all);
}

static json_t *root_of(builder *build, const char *title, dl_error *error) {
    json_t *root = json_object(), *cases = json_array(), *scenes = json_array();
    char answer[4 * DL_MESSAGE_SIZE];
    put(build, root, "title", dl_page_text(title));
    put(build, root, "kind", dl_page_text(build->all[0]->kind));
    put(build, root, "version", dl_page_text(DL_VERSION));
    put(build, root, "studies", all_studies(build));
    dl_results_answer_all(build->all, build->count, answer, sizeof answer);
    put(build, root, "answer", dl_page_text(answer));
    for (size_t k = 0; k < build->count; k++) {
        take(build, k);
        add_scenes(build, scenes);
        for (size_t i = 0; i < build->results->cases; i++)
            append(build, cases, one_case(build, &build->results->cased[i]));
    }
    put(build, root, "scenes", scenes);
    put(build, root, "across", across_scenes(build, error));
    put(build, root, "cases", cases);
    put_lists(build, root, "findings", dl_page_findings);
    put_lists(build, root, "scalings", dl_page_scalings);
    return root;
}

dl_status dl_page_data(const dl_results *const *results, size_t count, const char *title,
                       char **json, dl_error *error) {
    builder build = {.all = results, .count = count};
    *json = NULL;
    json_t *root = root_of(&build, title, error);
    char *dumped = build.failed ? NULL : json_dumps(root, JSON_COMPACT);
    if (dumped)
        *json = dl_page_json(dumped);
    free(dumped);
    json_decref(root);
    return *json ? DL_OK : dl_fail_memory(error, "the report's data");
}
