/* CVODE's variable-order, variable-step multistep methods (SUNDIALS): Adams-Moulton of orders 1-12
 * and BDF of orders 1-5. The rows of either differ in how the implicit step is solved (implicit.h).
 */
#include <stdlib.h>
#include <string.h>
#include <cvode/cvode.h>
#include <cvode/cvode_diag.h>

#include "methods/implicit.h"
#include "methods/registry.h"

typedef struct cvode_options {
    double rtol, atol;
    long max_order;
    dl_implicit_options implicit;
} cvode_options;

typedef struct cvode {
    dl_implicit implicit; /* first: it is what callbacks get */
    void *memory;
    double *work;           /* [2 unknowns]: where CVODE writes, also when it fails */
    N_Vector y, state;      /* over work and over method->y */
    bool stale;             /* CVODE's history does not end at method->y */
    dl_method_stats before; /* of the integrations that a jump or a failure ended */
} cvode;

typedef struct cvode_variant {
    int family; /* CV_ADAMS or CV_BDF */
    dl_implicit_solver solver;
} cvode_variant;

static const dl_implicit_calls calls = {
    .set_nonlinear_solver = CVodeSetNonlinearSolver,
    .set_linear_solver = CVodeSetLinearSolver,
    .set_jacobian = CVodeSetJacFn,
    .set_jacobian_times = CVodeSetJacTimes,
    .set_preconditioner = CVodeSetPreconditioner,
    .use_diagonal = CVDiag,
    .set_most_iterations = CVodeSetMaxNonlinIters,
    .nonlinear_iterations = CVodeGetNumNonlinSolvIters,
    .linear_iterations = CVodeGetNumLinIters,
    .set_ups = CVodeGetNumLinSolvSetups,
};

static const dl_sundials_meaning meanings[] = {
    {CV_TOO_MUCH_ACC, DL_STEP_FAILURE, false},
    {CV_ERR_FAILURE, DL_STEP_FAILURE, false},
    {CV_TOO_CLOSE, DL_STEP_FAILURE, false},
    {CV_CONV_FAILURE, DL_NONLINEAR_FAILURE, true},
    {CV_LINIT_FAIL, DL_NONLINEAR_FAILURE, true},
    {CV_LSETUP_FAIL, DL_NONLINEAR_FAILURE, true},
    {CV_LSOLVE_FAIL, DL_NONLINEAR_FAILURE, true},
    {CV_NLS_FAIL, DL_NONLINEAR_FAILURE, true},
    {CV_RHSFUNC_FAIL, DL_ERROR, true},
    {CV_FIRST_RHSFUNC_ERR, DL_ERROR, true},
    {CV_REPTD_RHSFUNC_ERR, DL_ERROR, true},
    {CV_UNREC_RHSFUNC_ERR, DL_ERROR, true},
    {CV_MEM_FAIL, DL_MEMORY, false},
    {0, DL_ERROR, false},
};

enum { cvode_memory = CV_MEM_FAIL, cvode_start = CV_LINIT_FAIL };
enum { arkode_memory = ARK_MEM_FAIL, arkode_start = ARK_LINIT_FAIL };
_Static_assert((int)cvode_memory == (int)arkode_memory && (int)cvode_start == (int)arkode_start,
               "flags of dl_implicit_attach");

/* --- the method --------------------------------------------------------------------------------
 */

/* A restart just before a pair crosses a hard cutoff begins with a step for the force on this side
 * of it: 7 attempts, CVODE's default, may not bring that down far enough. */
enum { most_attempts = 20 };

static int set_up(cvode *data, const cvode_variant *variant, const cvode_options *chosen) {
    void *const memory = data->memory;
    dl_implicit_options solver = chosen->implicit;
    solver.solver = variant->solver;
    int flag = dl_sundials_listen_cvode(&data->implicit.sundials, memory);
    if (!flag)
        flag = CVodeInit(memory, dl_sundials_rhs, 0, data->state);
    if (!flag)
        flag = CVodeSetUserData(memory, data);
    if (!flag)
        flag = CVodeSStolerances(memory, chosen->rtol, chosen->atol);
    if (!flag)
        flag = CVodeSetMaxOrd(memory, (int)chosen->max_order);
    if (!flag)
        flag = CVodeSetMaxErrTestFails(memory, most_attempts);
    return flag ? flag : dl_implicit_attach(&data->implicit, &calls, memory, data->state, &solver);
}

static dl_status cvode_create(dl_method *method, dl_error *error) {
    const cvode_variant *const variant = method->row->variant;
    cvode *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "CVODE");
    dl_sundials *const sundials = &data->implicit.sundials;
    const dl_status status = dl_sundials_create(sundials, method->model, error);
    if (status)
        return status;
    const size_t length = 2 * method->n;
    data->work = malloc(length * sizeof *data->work);
    data->y = dl_sundials_vector(sundials, data->work, length);
    data->state = dl_sundials_vector(sundials, method->y, length);
    if (data->work && data->y && data->state)
        data->memory = CVodeCreate(variant->family, sundials->context);
    if (!data->memory)
        return dl_fail_memory(error, "CVODE");
    const int flag = set_up(data, variant, method->options);
    return flag ? dl_sundials_fail(sundials, meanings, flag, "CVODE", error) : DL_OK;
}

static unsigned long count(int (*get)(void *memory, long *value), void *memory) {
    long value = 0;
    return get(memory, &value) == CV_SUCCESS ? (unsigned long)value : 0;
}

/* Adds what CVODE has counted since it was last initialised. */
static void add_stats(const cvode *data, dl_method_stats *stats) {
    stats->steps += count(CVodeGetNumSteps, data->memory);
    stats->rejected += count(CVodeGetNumErrTestFails, data->memory) +
                       count(CVodeGetNumStepSolveFails, data->memory);
    dl_implicit_add_stats(&data->implicit, data->memory, stats);
}

static int restart(cvode *data, double t) {
    add_stats(data, &data->before);
    data->implicit.preconditioner.factorisations = 0;
    return CVodeReInit(data->memory, t, data->state);
}

static dl_status cvode_advance(dl_method *method, double t_stop, dl_error *error) {
    cvode *const data = method->data;
    double t = method->t;
    dl_sundials_begin(&data->implicit.sundials);
    int flag = data->stale ? restart(data, t) : CV_SUCCESS;
    data->stale = false;
    if (flag == CV_SUCCESS)
        flag = CVodeSetStopTime(data->memory, t_stop);
    if (flag == CV_SUCCESS)
        flag = CVode(data->memory, t_stop, data->y, &t, CV_ONE_STEP);
    if (flag < 0) {
        data->stale = true;
        if (flag == CV_ILL_INPUT && dl_sundials_too_near(method->t, t_stop))
            return dl_sundials_fail_near(method->row->name, method->t, t_stop, error);
        return dl_sundials_fail(&data->implicit.sundials, meanings, flag, "CVode", error);
    }
    memcpy(method->y, data->work, 2 * method->n * sizeof *method->y);
    method->t = t;
    return DL_OK;
}

static int cvode_dense_degree(const dl_method *method) {
    int degree = 1;
    CVodeGetLastOrder(((const cvode *)method->data)->memory, &degree);
    return degree;
}

static dl_status cvode_dense(dl_method *method, double t, int derivative, double *y_out,
                             dl_error *error) {
    cvode *const data = method->data;
    dl_sundials_begin(&data->implicit.sundials);
    const int flag = CVodeGetDky(data->memory, t, derivative, data->y);
    if (flag)
        return dl_sundials_fail(&data->implicit.sundials, meanings, flag, "CVodeGetDky", error);
    memcpy(y_out, data->work, 2 * method->n * sizeof *y_out);
    return DL_OK;
}

static dl_status cvode_jumped(dl_method *method, dl_error *error) {
    (void)error;
    ((cvode *)method->data)->stale = true;
    return DL_OK;
}

static void cvode_stats(const dl_method *method, dl_method_stats *stats) {
    const cvode *const data = method->data;
    *stats = data->before;
    add_stats(data, stats);
}

static void cvode_destroy(dl_method *method) {
    cvode *const data = method->data;
    if (!data)
        return;
    if (data->memory)
        CVodeFree(&data->memory);
    dl_implicit_free(&data->implicit);
    N_VDestroy(data->y);
    N_VDestroy(data->state);
    dl_sundials_destroy(&data->implicit.sundials);
    free(data->work);
    free(data);
}

static const dl_method_ops ops = {
    .create = cvode_create,
    .advance = cvode_advance,
    .jumped = cvode_jumped,
    .dense_degree = cvode_dense_degree,
    .dense = cvode_dense,
    .stats = cvode_stats,
    .destroy = cvode_destroy,
};

/* --- rows --------------------------------------------------------------------------------------
 */

#define OPTIONS_ANY(highest)                                                                       \
    DL_OPTION_RTOL(cvode_options), DL_OPTION_ATOL(cvode_options), {                                \
        .name = "max_order", .kind = DL_INTEGER, .offset = offsetof(cvode_options, max_order),     \
        .unit = "", .minimum = 1, .maximum = highest, .fallback = #highest,                        \
        .doc = "highest order used"                                                                \
    }

static const dl_parameter adams_fixed_point_options[] = {OPTIONS_ANY(12),
                                                         DL_OPTION_ANDERSON(cvode_options)};
static const dl_parameter adams_newton_options[] = {OPTIONS_ANY(12)};
static const dl_parameter adams_krylov_options[] = {OPTIONS_ANY(12),
                                                    DL_OPTIONS_KRYLOV(cvode_options)};
static const dl_parameter bdf_fixed_point_options[] = {OPTIONS_ANY(5),
                                                       DL_OPTION_ANDERSON(cvode_options)};
static const dl_parameter bdf_newton_options[] = {OPTIONS_ANY(5)};
static const dl_parameter bdf_krylov_options[] = {OPTIONS_ANY(5), DL_OPTIONS_KRYLOV(cvode_options)};

#define CVODE(symbol, name_, family_, solver_, table, flags_, doc_)                                \
    static const cvode_variant symbol = {family_, solver_};                                        \
    const dl_method_row dl_method_cvode_##symbol = {                                               \
        .name = name_,                                                                             \
        .family = "CVODE",                                                                         \
        .doc = doc_ " (CVODE)",                                                                    \
        .made_of = "multistep",                                                                    \
        .flags = DL_IMPLICIT | DL_ADAPTIVE | (flags_),                                             \
        .options = DL_OPTIONS_TABLE(table),                                                        \
        .options_size = sizeof(cvode_options),                                                     \
        .variant = &(symbol),                                                                      \
        .ops = &ops,                                                                               \
    }

#define ADAMS       "Adams-Moulton, orders 1-12, "
#define BDF         "BDF, orders 1-5, "
#define BY_ITSELF   "fixed-point iteration"
#define BY_DENSE    "Newton with an analytic Jacobian, factorised whole"
#define BY_KLU      "Newton with an analytic sparse Jacobian and KLU"
#define BY_KRYLOV   "Newton with a Krylov method and analytic Jacobian-vector products"
#define BY_DIAGONAL "Newton with difference quotients in place of the Jacobian's diagonal"

CVODE(adams, "cvode-adams", CV_ADAMS, DL_IMPLICIT_FIXED_POINT, adams_fixed_point_options, 0,
      ADAMS BY_ITSELF);
CVODE(adams_dense, "cvode-adams-dense", CV_ADAMS, DL_IMPLICIT_DENSE, adams_newton_options,
      DL_NEEDS_JACOBIAN, ADAMS BY_DENSE);
CVODE(adams_klu, "cvode-adams-klu", CV_ADAMS, DL_IMPLICIT_KLU, adams_newton_options,
      DL_NEEDS_JACOBIAN, ADAMS BY_KLU);
CVODE(adams_krylov, "cvode-adams-krylov", CV_ADAMS, DL_IMPLICIT_KRYLOV, adams_krylov_options,
      DL_NEEDS_JACOBIAN, ADAMS BY_KRYLOV);
CVODE(adams_diagonal, "cvode-adams-diagonal", CV_ADAMS, DL_IMPLICIT_DIAGONAL, adams_newton_options,
      0, ADAMS BY_DIAGONAL);
CVODE(bdf_fixed_point, "cvode-bdf-fixed-point", CV_BDF, DL_IMPLICIT_FIXED_POINT,
      bdf_fixed_point_options, 0, BDF BY_ITSELF);
CVODE(bdf_dense, "cvode-bdf-dense", CV_BDF, DL_IMPLICIT_DENSE, bdf_newton_options,
      DL_NEEDS_JACOBIAN, BDF BY_DENSE);
CVODE(bdf_klu, "cvode-bdf-klu", CV_BDF, DL_IMPLICIT_KLU, bdf_newton_options, DL_NEEDS_JACOBIAN,
      BDF BY_KLU);
CVODE(bdf_krylov, "cvode-bdf-krylov", CV_BDF, DL_IMPLICIT_KRYLOV, bdf_krylov_options,
      DL_NEEDS_JACOBIAN, BDF BY_KRYLOV);
CVODE(bdf_diagonal, "cvode-bdf-diagonal", CV_BDF, DL_IMPLICIT_DIAGONAL, bdf_newton_options, 0,
      BDF BY_DIAGONAL);
