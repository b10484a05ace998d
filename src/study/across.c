#include "driftlab/across.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "study/finding.h"

/* --- the table -------------------------------------------------------------------------------- */

static size_t row_of(const dl_across *across, const char *method) {
    size_t i = 0;
    while (i < across->rows && strcmp(across->row[i].method, method) != 0)
        i++;
    return i;
}

/* Rows in order of first appearance; there is room for one a case. */
static void find_rows(const dl_results *const *results, size_t count, dl_across *across) {
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < results[k]->cases; i++) {
            const char *method = results[k]->cased[i].method;
            if (row_of(across, method) == across->rows)
                across->row[across->rows++].method = method;
        }
}

static void find_scenes(const dl_results *const *results, size_t count, dl_across *across) {
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < results[k]->scenes; i++)
            across->scene[across->scenes++] =
                (dl_across_scene){results[k]->scene[i].name, results[k]};
}

static void find_best(dl_across *across, size_t s) {
    const dl_across_scene *scene = &across->scene[s];
    const dl_results *results = scene->results;
    for (size_t i = 0; i < results->cases; i++) {
        const dl_case *cased = &results->cased[i];
        dl_across_cell *cell = &across->row[row_of(across, cased->method)].cell[s];
        if (strcmp(cased->scene, scene->name) != 0 ||
            !(dl_case_bound(cased, results->asked_in, dl_results_reference(results, scene->name)) <=
              results->asked_error))
            continue;
        if (!cell->best || cased->summary.cpu_seconds < cell->best->summary.cpu_seconds)
            cell->best = cased;
    }
}

static double seconds_of(const dl_across_cell *cell) {
    return cell->best ? cell->best->summary.cpu_seconds : INFINITY;
}

static void rank(dl_across *across, size_t s) {
    double least = INFINITY;
    for (size_t m = 0; m < across->rows; m++)
        least = fmin(least, seconds_of(&across->row[m].cell[s]));
    for (size_t m = 0; m < across->rows; m++) {
        dl_across_row *row = &across->row[m];
        dl_across_cell *cell = &row->cell[s];
        if (!cell->best)
            continue;
        cell->ratio = seconds_of(cell) / least;
        cell->rank = 1;
        for (size_t k = 0; k < across->rows; k++)
            cell->rank += seconds_of(&across->row[k].cell[s]) < seconds_of(cell);
        row->reached++;
        row->worst = fmax(row->worst, cell->ratio);
    }
}

static int best_first(const void *left, const void *right) {
    const dl_across_row *a = left, *b = right;
    if (a->reached != b->reached)
        return a->reached > b->reached ? -1 : 1;
    if (a->worst != b->worst)
        return a->worst < b->worst ? -1 : 1;
    return strcmp(a->method, b->method);
}

dl_status dl_across_create(const dl_results *const *results, size_t count, dl_across *across,
                           dl_error *error) {
    size_t scenes = 0, cases = 0;
    for (size_t k = 0; k < count; k++) {
        scenes += results[k]->scenes;
        cases += results[k]->cases;
    }
    *across = (dl_across){.scene = calloc(scenes + 1, sizeof *across->scene),
                          .row = calloc(cases + 1, sizeof *across->row)};
    if (!across->scene || !across->row)
        return dl_fail_memory(error, "methods across scenes");
    find_scenes(results, count, across);
    find_rows(results, count, across);
    across->cells = calloc(across->rows * scenes + 1, sizeof *across->cells);
    if (!across->cells)
        return dl_fail_memory(error, "methods across scenes");
    for (size_t m = 0; m < across->rows; m++)
        across->row[m].cell = across->cells + m * scenes;
    for (size_t s = 0; s < scenes; s++) {
        find_best(across, s);
        rank(across, s);
    }
    qsort(across->row, across->rows, sizeof *across->row, best_first);
    return DL_OK;
}

void dl_across_release(dl_across *across) {
    free(across->scene);
    free(across->row);
    free(across->cells);
    *across = (dl_across){0};
}

/* --- in two sentences ------------------------------------------------------------------------- */

/* "METHOD step=0.01 on SCENE (0.0123 CPU s)", or that nothing is. */
static void name_cheapest(const dl_across *across, size_t s, FILE *out) {
    const char *scene = across->scene[s].name;
    for (size_t m = 0; m < across->rows; m++) {
        const dl_across_cell *cell = &across->row[m].cell[s];
        if (cell->rank != 1)
            continue;
        char fineness[64];
        dl_options_fineness(cell->best->options, fineness, sizeof fineness);
        fprintf(out, "%s %s on %s (%.3g CPU s)", across->row[m].method, fineness, scene,
                cell->best->summary.cpu_seconds);
        return;
    }
    fprintf(out, "nothing on %s", scene);
}

static void tell_best(const dl_across *across, FILE *out) {
    const dl_across_row *best = across->rows > 0 ? &across->row[0] : NULL;
    if (!best || best->reached == 0)
        fputs("No method reaches it on any scene", out);
    else if (best->reached == across->scenes && best->worst > 1)
        fprintf(out,
                "Best on all %zu together is %s, which takes at most %.2g times the cheapest's "
                "time",
                across->scenes, best->method, best->worst);
    else if (best->reached == across->scenes)
        fprintf(out, "On all %zu that is one method, %s", across->scenes, best->method);
    else
        fprintf(out,
                "No method reaches it on all %zu; %s does on %zu, in at most %.2g times the "
                "cheapest's time",
                across->scenes, best->method, best->reached, best->worst);
}

void dl_across_answer(const dl_across *across, char *text, size_t size) {
    FILE *out = fmemopen(text, size, "w");
    text[0] = '\0';
    if (!out)
        return;
    fputs("Cheapest for the error asked of each scene: ", out);
    for (size_t s = 0; s < across->scenes; s++) {
        name_cheapest(across, s, out);
        fputs(s + 1 < across->scenes ? ", " : ". ", out);
    }
    tell_best(across, out);
    fputc('.', out);
    fclose(out);
    text[size - 1] = '\0';
}
