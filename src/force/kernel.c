#include "force/kernel.h"

#include <math.h>
#include <stdlib.h>

/* Below this a list costs more than it saves: measured on the settled fluid of TR323. */
enum { LIST_FROM = 64 };
/* Below this all pairs are summed, exactly; above, a tree is faster by far. */
enum { TREE_FROM = 10001 };

/* What dl_kernel_tree can do. */
static bool suits_tree(const dl_pair_problem *problem) {
    bool located = false;
    for (size_t k = 0; k < problem->species * problem->species; k++)
        for (int piece = 0; piece < problem->law[k].pieces; piece++)
            located |= problem->law[k].located[piece];
    return !problem->box && !located;
}

static const dl_kernel_ops *choose(const dl_pair_problem *problem, dl_kernel_choice choice,
                                   const char **reason) {
    static const dl_kernel_ops *const asked[] = {
        [DL_KERNEL_REFERENCE] = &dl_kernel_reference,
        [DL_KERNEL_ALL_PAIRS] = &dl_kernel_all_pairs,
        [DL_KERNEL_NEIGHBOUR_LIST] = &dl_kernel_neighbour_list,
        [DL_KERNEL_TREE] = &dl_kernel_tree,
    };
    *reason = "the scene asks for it";
    if (choice != DL_KERNEL_AUTO)
        return asked[choice];
    if (isinf(problem->reach) && problem->particles >= TREE_FROM && suits_tree(problem)) {
        *reason = "the pair law has no cutoff and the particles are more than 10000";
        return &dl_kernel_tree;
    }
    if (isinf(problem->reach)) {
        *reason = "the pair law has no cutoff";
        return &dl_kernel_all_pairs;
    }
    if (problem->particles < LIST_FROM) {
        *reason = "few particles";
        return &dl_kernel_all_pairs;
    }
    *reason = "the pair law ends at a cutoff and the particles are many";
    return &dl_kernel_neighbour_list;
}

static dl_status find_loops(dl_kernel *kernel, dl_error *error) {
    const dl_pair_problem *p = &kernel->problem;
    size_t laws = p->species * p->species;
    kernel->loops = malloc(laws * sizeof *kernel->loops);
    if (!kernel->loops)
        return dl_fail_memory(error, "a force kernel");
    for (size_t k = 0; k < laws; k++)
        kernel->loops[k] = kernel->vector->loops_for(&p->law[k]);
    return DL_OK;
}

dl_status dl_kernel_rows_of_all(dl_kernel *kernel, const double *x, const double *delta,
                                dl_pair_rows *rows, dl_error *error) {
    (void)kernel;
    (void)x;
    (void)delta;
    (void)error;
    *rows = (dl_pair_rows){NULL, NULL, 1};
    return DL_OK;
}

dl_status dl_kernel_create(const dl_pair_problem *problem, dl_kernel_choice choice,
                           dl_kernel **kernel, dl_error *error) {
    *kernel = NULL;
    if (choice == DL_KERNEL_NEIGHBOUR_LIST && isinf(problem->reach))
        return dl_fail(error, DL_INPUT,
                       "kernel: found neighbour-list, expected all-pairs, tree or reference: the "
                       "pair law has no cutoff");
    dl_kernel *made = calloc(1, sizeof *made);
    if (!made)
        return dl_fail_memory(error, "a force kernel");
    made->problem = *problem;
    if (problem->tree_error == 0)
        made->problem.tree_error = DL_TREE_ERROR;
    made->ops = choose(problem, choice, &made->reason);
    made->vector = dl_vector_best();
    dl_status status = find_loops(made, error);
    if (status == DL_OK)
        status = made->ops->create(made, error);
    if (status != DL_OK) {
        dl_kernel_destroy(made);
        return status;
    }
    *kernel = made;
    return DL_OK;
}

void dl_kernel_destroy(dl_kernel *kernel) {
    if (!kernel)
        return;
    kernel->ops->destroy(kernel);
    free(kernel->loops);
    free(kernel);
}
