/* driftlab reference: a scene in extended precision: own error, growth of displacements, horizon.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "cli/command.h"
#include "cli/json.h"
#include "cli/outcome.h"
#include "cli/published.h"
#include "cli/terminal.h"
#include "core/quad.h"
#include "driftlab/reference.h"
#include "study/kepler.h"

typedef struct reference_values {
    double t_end, error, seconds;
    long samples, memory, relative_to;
    int precision;
    char *published;
    bool kepler, state, json;
} reference_values;

static const char *const precisions[] = {"auto", "long-double", "quad", NULL};

static const dl_parameter options[] = {
    {.name = "t-end",
     .kind = DL_REAL,
     .offset = offsetof(reference_values, t_end),
     .unit = "T",
     .minimum = 0,
     .maximum = DBL_MAX,
     .above_minimum = true,
     .doc = "end (default: the scene's)"},
    {.name = "samples",
     .kind = DL_INTEGER,
     .offset = offsetof(reference_values, samples),
     .unit = "N",
     .minimum = 1,
     .maximum = 1e6,
     .fallback = "10",
     .doc = "equal intervals between samples"},
    {.name = "precision",
     .kind = DL_WORD,
     .offset = offsetof(reference_values, precision),
     .unit = "P",
     .words = precisions,
     .fallback = "auto",
     .doc = "auto | long-double | quad; auto: quad where long double does not reach --error"},
    {.name = "error",
     .kind = DL_REAL,
     .offset = offsetof(reference_values, error),
     .unit = "X",
     .minimum = 0,
     .maximum = DBL_MAX,
     .above_minimum = true,
     .doc = "own error that is good enough (default: the rounding of double precision)"},
    {.name = "seconds",
     .kind = DL_REAL,
     .offset = offsetof(reference_values, seconds),
     .unit = "S",
     .minimum = 0,
     .maximum = 1e7,
     .above_minimum = true,
     .fallback = "300",
     .doc = "limit on the CPU time of each trajectory"},
    {.name = "memory",
     .kind = DL_INTEGER,
     .offset = offsetof(reference_values, memory),
     .unit = "MIB",
     .minimum = 64,
     .maximum = 1 << 24,
     .fallback = "4096",
     .doc = "limit on the address space"},
    {.name = "published",
     .kind = DL_TEXT,
     .offset = offsetof(reference_values, published),
     .unit = "FILE.csv",
     .doc = "compare the end with these numbers: columns particle, x, y, z, vx, vy, vz"},
    {.name = "relative-to",
     .kind = DL_INTEGER,
     .offset = offsetof(reference_values, relative_to),
     .unit = "N",
     .minimum = 0,
     .maximum = 1e6,
     .fallback = "0",
     .doc = "the published numbers are relative to this particle (from 1; 0: to the origin)"},
    {.name = "kepler",
     .kind = DL_FLAG,
     .offset = offsetof(reference_values, kepler),
     .fallback = "false",
     .doc = "compare with the exact motion of two bodies"},
    {.name = "state",
     .kind = DL_FLAG,
     .offset = offsetof(reference_values, state),
     .fallback = "false",
     .doc = "print the state at the end, with 32 digits"},
    {.name = "json",
     .kind = DL_FLAG,
     .offset = offsetof(reference_values, json),
     .fallback = "false",
     .doc = "print one JSON object instead of tables"},
};

typedef struct job {
    const reference_values *values;
    dl_scene *scene;
    dl_reference reference;
    double *final; /* [2 * length]: high, low */
    size_t length;
    double *exact_error; /* [samples]; NULL: not asked for */
    cli_comparison published;
} job;

/* --- work ------------------------------------------------------------------------------------- */

/* The rounding of a double as large as the coordinates are. */
static double rounding(const dl_scene *scene) {
    double sum = 0;
    const size_t count = (size_t)scene->dimension * scene->particles;
    for (size_t k = 0; k < count; k++)
        sum += scene->position[k] * scene->position[k];
    return DBL_EPSILON / 2 * sqrt(sum / (double)count);
}

static dl_status compute(job *work, dl_error *error) {
    const reference_values *values = work->values;
    work->length = 2 * (size_t)work->scene->dimension * work->scene->particles;
    work->final = calloc(2 * work->length, sizeof *work->final);
    if (!work->final)
        return dl_fail_memory(error, "a state");
    const dl_reference_request request = {
        .precision = (dl_precision)values->precision,
        .end = values->t_end > 0 ? values->t_end : work->scene->end,
        .intervals = (size_t)values->samples,
        .wanted = values->error > 0 ? values->error : rounding(work->scene),
        .seconds = values->seconds,
        .memory = values->memory,
        .interrupt = cli_catch_signals(),
        .final_high = work->final,
        .final_low = work->final + work->length,
    };
    return dl_reference_compute(work->scene, &request, &work->reference, error);
}

/* The distance of the reference's positions from the exact ones at every sample. */
static dl_status compare_with_kepler(job *work, dl_error *error) {
    dl_reference *reference = &work->reference;
    double high[6], low[6];
    work->exact_error = calloc(reference->samples, sizeof *work->exact_error);
    dl_status status = work->exact_error ? DL_OK : dl_fail_memory(error, "the exact motion");
    for (size_t i = 0; i < reference->samples && !status; i++) {
        const size_t block = work->length / 2;
        double sum = 0;
        status = dl_kepler_position(work->scene, reference->time[i], high, low, error);
        for (size_t k = 0; k < block; k++) {
            const double d = (reference->position[i * block + k] - high[k]) +
                             (reference->position_low[i * block + k] - low[k]);
            sum += d * d;
        }
        work->exact_error[i] = sqrt(sum / 2);
    }
    return status;
}

/* --- output ----------------------------------------------------------------------------------- */

static void print_samples(const job *work, FILE *out) {
    const dl_reference *reference = &work->reference;
    fprintf(out, "  %14s %12s %12s%s\n", "t", "own error", "growth",
            work->exact_error ? "  from exact" : "");
    for (size_t i = 0; i < reference->samples; i++) {
        fprintf(out, "  %14.8g %12.2e %9s%.1f", reference->time[i], reference->sample_error[i],
                "10^", reference->growth[i] / log(10));
        if (work->exact_error)
            fprintf(out, " %12.2e", work->exact_error[i]);
        fputc('\n', out);
    }
}

static void print_state(const job *work, FILE *out) {
    static const char axes[] = "xyz";
    const size_t n = work->scene->particles;
    for (size_t k = 0; k < work->length; k++) {
        char text[64];
        const size_t axis = k / n % (size_t)work->scene->dimension;
        quadmath_snprintf(text, sizeof text, "%+.31Qe",
                          (__float128)work->final[k] + work->final[work->length + k]);
        fprintf(out, "  %8zu  %s%c %s\n", k % n + 1, k < work->length / 2 ? "" : "v", axes[axis],
                text);
    }
}

static dl_status print_text(job *work, dl_error *error) {
    const reference_values *values = work->values;
    const dl_reference *reference = &work->reference;
    printf("%s to t = %.10g, %.3g CPU s\n", work->scene->name,
           reference->time[reference->samples - 1], reference->seconds);
    dl_reference_print(reference, "  ", stdout);
    print_samples(work, stdout);
    if (values->state)
        print_state(work, stdout);
    if (!values->published)
        return DL_OK;
    const dl_status status = cli_compare_published(
        values->published, work->scene, work->final, work->final + work->length,
        (size_t)values->relative_to, &work->published, stdout, error);
    if (!status)
        printf("  %zu of %zu published numbers agree to the last digit; largest difference %.2e, "
               "%.2g units of it\n",
               work->published.agree, work->published.numbers, work->published.largest,
               work->published.units);
    return status;
}

static json_t *reals(const double *values, size_t count) {
    json_t *list = json_array();
    for (size_t k = 0; values && k < count; k++)
        json_array_append_new(list, cli_json_real(values[k]));
    return list;
}

static json_t *published_json(const job *work) {
    if (!work->values->published)
        return json_null();
    return json_pack("{s:I, s:I, s:o, s:o}", "numbers", (json_int_t)work->published.numbers,
                     "agree", (json_int_t)work->published.agree, "largest",
                     cli_json_real(work->published.largest), "units",
                     cli_json_real(work->published.units));
}

static dl_status print_json(job *work, dl_error *error) {
    const dl_reference *r = &work->reference;
    dl_status status = DL_OK;
    if (work->values->published)
        status = cli_compare_published(
            work->values->published, work->scene, work->final, work->final + work->length,
            (size_t)work->values->relative_to, &work->published, NULL, error);
    if (status)
        return status;
    return cli_json_print(
        json_pack("{s:s, s:s, s:s, s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, "
                  "s:o, s:o}",
                  "scene", work->scene->name, "precision", r->precision, "description",
                  r->description, "note", r->note, "error", cli_json_real(r->error), "cpu_seconds",
                  cli_json_real(r->seconds), "length", cli_json_real(r->length), "lyapunov",
                  cli_json_real(r->lyapunov), "lyapunov_error", cli_json_real(r->lyapunov_error),
                  "horizon", r->horizon > 0 ? cli_json_real(r->horizon) : json_null(), "parted",
                  r->parted > 0 ? cli_json_real(r->parted) : json_null(), "time",
                  reals(r->time, r->samples), "sample_error", reals(r->sample_error, r->samples),
                  "growth", reals(r->growth, r->samples), "from_exact",
                  reals(work->exact_error, r->samples), "state", reals(work->final, work->length),
                  "published", published_json(work)),
        stdout, error);
}

static dl_status check_values(const job *work, dl_error *error) {
    const reference_values *values = work->values;
    if (values->relative_to > 0 && !values->published)
        return dl_fail(error, DL_INPUT, "--relative-to: found without --published, expected both");
    if (values->relative_to > (long)work->scene->particles)
        return dl_fail(error, DL_INPUT, "--relative-to: found %ld, expected a particle, 1 to %zu",
                       values->relative_to, work->scene->particles);
    return values->kepler ? dl_kepler_check(work->scene, error) : DL_OK;
}

static cli_exit reference_command(const cli_input *input) {
    job work = {.values = input->values};
    dl_error error = {""};
    dl_status status = dl_scene_read(input->word[0], &work.scene, &error);
    if (!status)
        status = check_values(&work, &error);
    if (!status)
        status = compute(&work, &error);
    if (!status && work.values->kepler)
        status = compare_with_kepler(&work, &error);
    if (!status)
        status = work.values->json ? print_json(&work, &error) : print_text(&work, &error);
    dl_reference_release(&work.reference);
    dl_scene_free(work.scene);
    free(work.final);
    free(work.exact_error);
    return cli_finish(status, &error);
}

const cli_command cli_command_reference = {
    .name = "reference",
    .arguments = "SCENE",
    .summary = "a scene in extended precision: own error, Lyapunov exponent, horizon",
    .details = "The scene is integrated in long double or quad precision, events included, and "
               "once more\nwith a looser tolerance and by a second method, which tell its own "
               "error.\n",
    .least_words = 1,
    .most_words = 1,
    .options = CLI_TABLE(options),
    .values_size = sizeof(reference_values),
    .run = reference_command,
};
