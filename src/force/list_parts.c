#include "force/list_parts.h"

#include <stdlib.h>
#include <string.h>

dl_status dl_list_parts_create(const dl_pair_problem *problem, dl_list_parts *parts,
                               dl_error *error) {
    if (!problem->species_of)
        return DL_OK;
    size_t count = problem->species * problem->species;
    parts->part = calloc(count, sizeof *parts->part);
    if (!parts->part)
        return dl_fail_memory(error, "the neighbour lists of the species");
    parts->count = count;
    for (size_t k = 0; k < count; k++) {
        parts->part[k].start = calloc(problem->moving + 1, sizeof(int));
        if (!parts->part[k].start)
            return dl_fail_memory(error, "the neighbour lists of the species");
    }
    return DL_OK;
}

void dl_list_parts_release(dl_list_parts *parts) {
    for (size_t k = 0; k < parts->count; k++) {
        free(parts->part[k].start);
        free(parts->part[k].neighbour);
    }
    free(parts->part);
}

static size_t part_of(const dl_pair_problem *problem, size_t i, size_t j) {
    bool ascending = problem->species_of[i] <= problem->species_of[j];
    return ascending ? dl_pair_law_index(problem, i, j) : dl_pair_law_index(problem, j, i);
}

/* start[i + 1] = entries of rows 0 ... i, in every part. */
static void count_entries(const dl_pair_problem *problem, const dl_list *whole,
                          dl_list_parts *parts) {
    for (size_t k = 0; k < parts->count; k++)
        memset(parts->part[k].start, 0, (problem->moving + 1) * sizeof(int));
    for (size_t i = 0; i < problem->moving; i++) {
        for (int n = whole->start[i]; n < whole->start[i + 1]; n++)
            parts->part[part_of(problem, i, (size_t)whole->neighbour[n])].start[i + 1]++;
        for (size_t k = 0; k < parts->count; k++)
            parts->part[k].start[i + 1] += parts->part[k].start[i];
    }
}

static dl_status reserve(dl_list *part, size_t need, dl_error *error) {
    if (need <= part->capacity)
        return DL_OK;
    free(part->neighbour);
    part->neighbour = malloc(2 * need * sizeof(int));
    part->capacity = part->neighbour ? 2 * need : 0;
    return part->neighbour ? DL_OK : dl_fail_memory(error, "the neighbour lists of the species");
}

dl_status dl_list_parts_fill(const dl_pair_problem *problem, const dl_list *whole,
                             dl_list_parts *parts, dl_error *error) {
    if (parts->count == 0)
        return DL_OK;
    count_entries(problem, whole, parts);
    for (size_t k = 0; k < parts->count; k++) {
        dl_list *part = &parts->part[k];
        dl_status status = reserve(part, (size_t)part->start[problem->moving], error);
        if (status != DL_OK)
            return status;
        memmove(part->start + 1, part->start, problem->moving * sizeof(int));
    }
    /* start[i + 1] is where the next entry of row i goes, and in the end where the row ends */
    for (size_t i = 0; i < problem->moving; i++)
        for (int n = whole->start[i]; n < whole->start[i + 1]; n++) {
            dl_list *part = &parts->part[part_of(problem, i, (size_t)whole->neighbour[n])];
            part->neighbour[part->start[i + 1]++] = whole->neighbour[n];
        }
    return DL_OK;
}
