#include "methods/second_iterate.h"

#include <stdlib.h>

typedef struct second_iterate {
    SUNNonlinSolSysFn map;
    N_Vector image;
} second_iterate;

static SUNNonlinearSolver_Type type_of(SUNNonlinearSolver solver) {
    (void)solver;
    return SUNNONLINEARSOLVER_FIXEDPOINT;
}

static int initialize(SUNNonlinearSolver solver) {
    (void)solver;
    return 0;
}

static int set_map(SUNNonlinearSolver solver, SUNNonlinSolSysFn map) {
    ((second_iterate *)solver->content)->map = map;
    return 0;
}

static int solve(SUNNonlinearSolver solver, N_Vector start, N_Vector z, N_Vector weights,
                 sunrealtype tolerance, sunbooleantype set_up, void *memory) {
    (void)start, (void)weights, (void)tolerance, (void)set_up;
    const second_iterate *const content = solver->content;
    int flag = 0;
    for (int k = 0; k < 2 && !flag; k++) {
        flag = content->map(z, content->image, memory);
        if (!flag)
            N_VScale(1, content->image, z);
    }
    return flag;
}

static int iterations(SUNNonlinearSolver solver, long *count) {
    (void)solver;
    *count = 2;
    return 0;
}

static int failures(SUNNonlinearSolver solver, long *count) {
    (void)solver;
    *count = 0;
    return 0;
}

static int destroy(SUNNonlinearSolver solver) {
    second_iterate *const content = solver->content;
    if (content && content->image)
        N_VDestroy(content->image);
    free(content);
    solver->content = NULL;
    SUNNonlinSolFreeEmpty(solver);
    return 0;
}

SUNNonlinearSolver dl_second_iterate_create(N_Vector like, SUNContext context) {
    SUNNonlinearSolver solver = SUNNonlinSolNewEmpty(context);
    second_iterate *const content = calloc(1, sizeof *content);
    if (content)
        content->image = N_VClone(like);
    if (!solver || !content || !content->image) {
        free(content);
        if (solver)
            SUNNonlinSolFreeEmpty(solver);
        return NULL;
    }
    solver->content = content;
    solver->ops->gettype = type_of;
    solver->ops->initialize = initialize;
    solver->ops->setsysfn = set_map;
    solver->ops->solve = solve;
    solver->ops->getnumiters = iterations;
    solver->ops->getnumconvfails = failures;
    solver->ops->free = destroy;
    return solver;
}
