#include "cli/published.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/quad.h"
#include "scene/csv.h"

static const char *const names[] = {"x", "y", "z", "vx", "vy", "vz"};

enum { components = 6, most_columns = 7 };

typedef struct columns {
    size_t count;
    int component[most_columns]; /* index in names; -1: the particle */
    bool has_particle;
} columns;

typedef struct state {
    const dl_scene *scene;
    const double *high, *low;
    size_t origin; /* from 1; 0: none */
} state;

static dl_status bad(const dl_csv *csv, const char *found, const char *expected, dl_error *error) {
    return dl_fail(error, DL_INPUT, "%s:%d: found \"%.100s\", expected %s", csv->path, csv->line,
                   found, expected);
}

static dl_status read_header(const dl_csv *csv, int dimension, columns *read, dl_error *error) {
    *read = (columns){.count = csv->cells};
    if (csv->cells > most_columns)
        return bad(csv, csv->cell[most_columns], "at most seven columns", error);
    for (size_t k = 0; k < csv->cells; k++) {
        int c = components;
        if (strcmp(csv->cell[k], "particle") == 0) {
            c = -1;
            read->has_particle = true;
        }
        for (int i = 0; i < components; i++)
            if (strcmp(csv->cell[k], names[i]) == 0 && i % 3 < dimension)
                c = i;
        if (c == components)
            return bad(csv, csv->cell[k], "particle, x, y, z, vx, vy or vz of this dimension",
                       error);
        read->component[k] = c;
    }
    return read->has_particle ? DL_OK : bad(csv, csv->cell[0], "a column \"particle\"", error);
}

static __float128 computed(const state *of, size_t particle, int component) {
    const size_t n = of->scene->particles, block = (size_t)of->scene->dimension * n;
    const size_t axis = (size_t)(component % 3);
    const size_t from = (component < 3 ? 0 : block) + axis * n;
    __float128 value = (__float128)of->high[from + particle] + of->low[from + particle];
    if (of->origin > 0)
        value -= (__float128)of->high[from + of->origin - 1] + of->low[from + of->origin - 1];
    return value;
}

/* One unit of the last digit of a decimal number as it stands. */
static double last_unit(const char *text) {
    const size_t mantissa = strcspn(text, "eE");
    const char *point = memchr(text, '.', mantissa);
    const long decimals = point ? (long)mantissa - (point - text) - 1 : 0;
    const long exponent = text[mantissa] ? strtol(text + mantissa + 1, NULL, 10) : 0;
    return pow(10, (double)(exponent - decimals));
}

static dl_status compare_number(const dl_csv *csv, const state *of, size_t particle, int component,
                                const char *text, cli_comparison *found, FILE *out,
                                dl_error *error) {
    char *end, shown[64];
    const __float128 published = strtoflt128(text, &end), value = computed(of, particle, component);
    if (*text == '\0' || *end != '\0')
        return bad(csv, text, "a number", error);
    const double difference = (double)fabsq(value - published),
                 units = difference / last_unit(text);
    found->numbers++;
    found->agree += units <= 0.5;
    found->largest = fmax(found->largest, difference);
    found->units = fmax(found->units, units);
    quadmath_snprintf(shown, sizeof shown, "%.20Qg", value);
    if (out)
        fprintf(out, "  %8zu  %-3s %24s %28s %10.2e %8.2g\n", particle + 1, names[component], text,
                shown, difference, units);
    return DL_OK;
}

static dl_status compare_row(const dl_csv *csv, const columns *in, const state *of,
                             cli_comparison *found, FILE *out, dl_error *error) {
    size_t particle = 0;
    if (csv->cells != in->count)
        return bad(csv, csv->cell[0], "as many numbers as there are columns", error);
    for (size_t k = 0; k < in->count; k++)
        if (in->component[k] < 0) {
            char *end;
            particle = strtoul(csv->cell[k], &end, 10);
            if (*end != '\0' || particle < 1 || particle > of->scene->particles)
                return bad(csv, csv->cell[k], "the number of a particle", error);
        }
    dl_status status = DL_OK;
    for (size_t k = 0; k < in->count && !status; k++)
        if (in->component[k] >= 0)
            status = compare_number(csv, of, particle - 1, in->component[k], csv->cell[k], found,
                                    out, error);
    return status;
}

dl_status cli_compare_published(const char *path, const dl_scene *scene, const double *high,
                                const double *low, size_t origin, cli_comparison *found, FILE *out,
                                dl_error *error) {
    const state of = {.scene = scene, .high = high, .low = low, .origin = origin};
    columns in = {.count = 0};
    dl_csv csv;
    bool more;
    *found = (cli_comparison){0};
    dl_status status = dl_csv_open(path, &csv, error);
    if (status)
        return status;
    if (out)
        fprintf(out, "  %8s  %-3s %24s %28s %10s %8s\n", "particle", "", "published", "computed",
                "differ by", "units");
    while (!(status = dl_csv_next(&csv, &more, error)) && more) {
        status = in.count == 0 ? read_header(&csv, scene->dimension, &in, error)
                               : compare_row(&csv, &in, &of, found, out, error);
        if (status)
            break;
    }
    if (!status && found->numbers == 0)
        status = dl_fail(error, DL_INPUT, "%s: found no numbers, expected published ones", path);
    dl_csv_close(&csv);
    return status;
}
