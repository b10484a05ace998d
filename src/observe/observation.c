/* Observables averaged over frames. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"
#include "observe/observables.h"

enum { most_batches = 10 };
static const double most_chosen_bins = 12;

/* One observable's table while it grows. */
typedef struct table {
    const dl_observable_entry *entry;
    size_t rows, columns;
    double *sum;     /* [batches][rows][columns] */
    double *present; /* [rows][columns]: of the frame */
    double *mean, *error;
    double *label; /* [rows] or NULL */
} table;

struct dl_observation {
    dl_measuring measuring;
    size_t frames, added; /* to come in all; so far */
    size_t batches;
    size_t frames_in[most_batches];
    size_t tables;
    table *table;
};

void dl_observe_options_default(dl_observe_options *options) {
    *options = (dl_observe_options){
        .temperature = &dl_temperature_published,
        .temperature_steps = 500,
    };
}

/* --- what the scene is ------------------------------------------------------------------------ */

/* 1, 2 or 5 times a power of ten, so that `extent` is at most 12 bins long (whose ends may lie in
 * 13). */
static double nice_width(double extent) {
    static const double factor[] = {1, 2, 5, 10};
    if (!(extent > 0) || !isfinite(extent))
        return 1;
    const double least = extent / most_chosen_bins, power = pow(10, floor(log10(least)));
    size_t k = 0;
    while (k < 3 && factor[k] * power < least)
        k++;
    return factor[k] * power;
}

double dl_bins_choose_width(const dl_scene *scene, double lowest, double highest) {
    const dl_walls *walls = &scene->walls;
    const double floor_height = walls->present ? walls->low[dl_height_axis(scene)] : -INFINITY;
    return nice_width(highest - (isfinite(floor_height) ? floor_height : lowest));
}

static dl_status choose(dl_measuring *m, double lowest, double highest, dl_error *error) {
    dl_observe_options *const options = &m->options;
    if (options->across == 0)
        options->across = dl_across(m->scene);
    if (options->link == 0)
        options->link = dl_escape_link(m->scene);
    if (options->bin == 0)
        options->bin = dl_bins_choose_width(m->scene, lowest, highest);
    return dl_bins_create(m->scene, options->bin, lowest, highest, &m->bins, error);
}

static int descending(const void *a, const void *b) {
    const double x = ((const dl_mass_class *)a)->mass, y = ((const dl_mass_class *)b)->mass;
    return (x < y) - (x > y);
}

static size_t class_at(const dl_measuring *m, double mass) {
    size_t k = 0;
    while (k < m->classes && m->mass_class[k].mass != mass)
        k++;
    return k;
}

static dl_status classify(dl_measuring *m, dl_error *error) {
    const size_t n = m->scene->particles;
    m->mass_class = calloc(n, sizeof *m->mass_class);
    m->class_of = calloc(n, sizeof *m->class_of);
    if (!m->mass_class || !m->class_of)
        return dl_fail_memory(error, "the masses of a scene");
    for (size_t i = 0; i < n; i++) {
        if (m->scene->pinned[i])
            continue;
        const size_t k = class_at(m, m->scene->inertia[i]);
        if (k == m->classes)
            m->mass_class[m->classes++].mass = m->scene->inertia[i];
        m->mass_class[k].particles++;
    }
    qsort(m->mass_class, m->classes, sizeof *m->mass_class, descending);
    for (size_t i = 0; i < n; i++)
        if (!m->scene->pinned[i])
            m->class_of[i] = class_at(m, m->scene->inertia[i]);
    return DL_OK;
}

/* Room for the frame's values of whatever is measured. */
static dl_status reserve(dl_measuring *m, dl_error *error) {
    const size_t n = m->scene->particles, most = n > m->bins.count ? n : m->bins.count;
    m->work = malloc(4 * most * sizeof *m->work);
    m->escaped = calloc(n, sizeof *m->escaped);
    return m->work && m->escaped ? DL_OK : dl_fail_memory(error, "an observation");
}

/* The others of the scene are pinned in the view. */
static dl_status prepare_view(dl_measuring *m, dl_error *error) {
    const size_t n = m->whole->particles;
    dl_status status = dl_groups_apply(m, "the system alone", error);
    if (status)
        return status;
    m->left_out = calloc(n, sizeof *m->left_out);
    m->system = calloc(n, sizeof *m->system);
    if (!m->left_out || !m->system)
        return dl_fail_memory(error, "an observation");
    memcpy(m->left_out, m->whole->pinned, n * sizeof *m->left_out);
    m->view = *m->whole;
    m->view.pinned = m->left_out;
    m->scene = &m->view;
    return DL_OK;
}

static dl_status prepare(dl_measuring *m, double lowest, double highest, dl_error *error) {
    dl_status status = dl_model_create(m->whole, &m->model, error);
    if (!status)
        status = choose(m, lowest, highest, error);
    if (!status)
        status = classify(m, error);
    if (!status && m->options.of_system)
        status = prepare_view(m, error);
    if (!status)
        status = reserve(m, error);
    if (!status)
        status = dl_thermometer_create(m->scene, m->options.temperature,
                                       m->options.temperature_steps, &m->measured, error);
    if (!status)
        status = dl_thermometer_create(m->scene, &dl_temperature_program,
                                       m->options.temperature_steps, &m->state, error);
    return status;
}

/* --- tables ----------------------------------------------------------------------------------- */

static size_t rows_of(const dl_measuring *m, dl_observe_rows kind) {
    return kind == DL_ROWS_BINS ? m->bins.count : kind == DL_ROWS_MASSES ? m->classes : 1;
}

static void write_labels(const dl_measuring *m, dl_observe_rows kind, size_t rows, double *label) {
    for (size_t k = 0; k < rows; k++)
        label[k] =
            kind == DL_ROWS_BINS ? m->bins.low + (double)k * m->bins.width : m->mass_class[k].mass;
}

static dl_status create_table(dl_observation *o, const dl_observable_entry *entry,
                              dl_error *error) {
    table *const t = &o->table[o->tables++];
    const dl_observe_rows kind = entry->row.rows;
    *t = (table){.entry = entry, .rows = rows_of(&o->measuring, kind)};
    while (entry->row.column[t->columns])
        t->columns++;
    const size_t values = t->rows * t->columns;
    t->sum = calloc(o->batches * values + 1, sizeof *t->sum);
    t->present = calloc(values + 1, sizeof *t->present);
    t->mean = calloc(values + 1, sizeof *t->mean);
    t->error = calloc(values + 1, sizeof *t->error);
    t->label = calloc(t->rows + 1, sizeof *t->label);
    if (!t->sum || !t->present || !t->mean || !t->error || !t->label)
        return dl_fail_memory(error, "an observation");
    if (kind != DL_ROWS_SYSTEM)
        write_labels(&o->measuring, kind, t->rows, t->label);
    return DL_OK;
}

static dl_status create_tables(dl_observation *o, const bool *wanted, dl_error *error) {
    o->table = calloc(dl_observable_count(), sizeof *o->table);
    dl_status status = o->table ? DL_OK : dl_fail_memory(error, "an observation");
    for (size_t i = 0; i < dl_observable_count() && !status; i++) {
        const dl_observable_entry *const entry = dl_observable_entry_at(i);
        if (wanted && !wanted[i])
            continue;
        const dl_status applies = entry->applies ? entry->applies(&o->measuring, error) : DL_OK;
        if (!applies)
            status = create_table(o, entry, error);
        else if (wanted)
            status = applies;
    }
    return status;
}

dl_status dl_observation_create(const dl_scene *scene, const dl_observe_options *options,
                                const bool *wanted, size_t frames, double lowest, double highest,
                                dl_observation **observation, dl_error *error) {
    *observation = NULL;
    dl_observation *o = calloc(1, sizeof *o);
    if (!o)
        return dl_fail_memory(error, "an observation");
    o->measuring.scene = o->measuring.whole = scene;
    o->measuring.options = *options;
    o->frames = frames;
    o->batches = frames < most_batches ? frames : most_batches;
    dl_status status =
        frames ? DL_OK : dl_fail(error, DL_INPUT, "found no frame to observe, expected some");
    if (!status)
        status = prepare(&o->measuring, lowest, highest, error);
    if (!status)
        status = create_tables(o, wanted, error);
    if (status)
        dl_observation_free(o);
    else
        *observation = o;
    return status;
}

void dl_observation_free(dl_observation *observation) {
    if (!observation)
        return;
    dl_measuring *const m = &observation->measuring;
    for (size_t k = 0; k < observation->tables; k++) {
        table *const t = &observation->table[k];
        free(t->sum);
        free(t->present);
        free(t->mean);
        free(t->error);
        free(t->label);
    }
    free(observation->table);
    dl_thermometer_free(m->measured);
    dl_thermometer_free(m->state);
    free(m->mass_class);
    free(m->class_of);
    free(m->work);
    free(m->left_out);
    free(m->system);
    free(m->escaped);
    dl_model_free(m->model);
    free(observation);
}

/* --- frames ----------------------------------------------------------------------------------- */

/* What the system is in this frame. */
static dl_status look_at_system(dl_measuring *m, const double *y_all, dl_error *error) {
    const dl_scene *const whole = m->whole;
    const dl_status status = dl_observe_system(whole, y_all, m->options.link, m->system, error);
    for (size_t k = 0; k < m->classes; k++)
        m->mass_class[k].particles = 0;
    for (size_t i = 0; i < whole->particles && !status; i++) {
        m->left_out[i] = whole->pinned[i] || !m->system[i];
        if (!m->left_out[i])
            m->mass_class[m->class_of[i]].particles++;
    }
    return status;
}

dl_status dl_observation_warm(dl_observation *observation, double time, const double *y_all,
                              dl_error *error) {
    dl_measuring *const m = &observation->measuring;
    dl_status status = m->system ? look_at_system(m, y_all, error) : DL_OK;
    if (!status)
        status = dl_thermometer_add(m->measured, time, y_all, error);
    return status ? status : dl_thermometer_add(m->state, time, y_all, error);
}

dl_status dl_observation_add(dl_observation *observation, double time, const double *y_all,
                             dl_error *error) {
    dl_observation *const o = observation;
    if (o->added == o->frames)
        return dl_fail(error, DL_ERROR, "an observation of %zu frames was given more", o->frames);
    const size_t batch = o->added++ * o->batches / o->frames;
    o->frames_in[batch]++;
    o->measuring.y_all = y_all;
    dl_status status = dl_observation_warm(o, time, y_all, error);
    for (size_t k = 0; k < o->tables && !status; k++) {
        table *const t = &o->table[k];
        const size_t values = t->rows * t->columns;
        status = t->entry->measure(&o->measuring, t->present, error);
        for (size_t i = 0; i < values; i++)
            t->sum[batch * values + i] += t->present[i];
    }
    return status;
}

size_t dl_observation_count(const dl_observation *observation) {
    return observation->tables;
}

double dl_observation_bin(const dl_observation *observation) {
    return observation->measuring.bins.width;
}

/* Mean over all frames; standard error of it from the spread of the batches' means. */
static void average(const dl_observation *o, const table *t, size_t value) {
    const size_t values = t->rows * t->columns;
    double sum = 0, square = 0, batches = 0;
    for (size_t b = 0; b < o->batches; b++)
        sum += t->sum[b * values + value];
    const double mean = sum / (double)o->added;
    for (size_t b = 0; b < o->batches; b++)
        if (o->frames_in[b]) {
            const double off = t->sum[b * values + value] / (double)o->frames_in[b] - mean;
            square += off * off;
            batches++;
        }
    t->mean[value] = mean;
    t->error[value] = batches > 1 ? sqrt(square / (batches * (batches - 1))) : NAN;
}

void dl_observation_get(const dl_observation *observation, size_t index, dl_observed *observed) {
    const table *const t = &observation->table[index];
    for (size_t i = 0; i < t->rows * t->columns; i++)
        average(observation, t, i);
    *observed = (dl_observed){
        .observable = &t->entry->row,
        .rows = t->rows,
        .columns = t->columns,
        .label = t->entry->row.rows == DL_ROWS_SYSTEM ? NULL : t->label,
        .mean = t->mean,
        .error = t->error,
        .present = t->present,
    };
}

const bool *dl_observation_escaped(const dl_observation *observation) {
    for (size_t k = 0; k < observation->tables; k++)
        if (strcmp(observation->table[k].entry->row.name, "escaped") == 0)
            return observation->measuring.escaped;
    return NULL;
}

const bool *dl_observation_system(const dl_observation *observation) {
    return observation->measuring.system;
}
