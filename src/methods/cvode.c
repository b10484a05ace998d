/* CVODE's variable-order, variable-step multistep methods (SUNDIALS): Adams-Moulton of orders 1-12
 * and BDF of orders 1-5. The rows differ in how the implicit step is solved:
 *
 *     fixed point    functional iteration, Anderson-accelerated on request
 *     klu            Newton; sparse I - gamma J factorised by KLU
 *     krylov         Newton; GMRES with the analytic product J v, not preconditioned
 *
 * with J = [0 I; A 0] and A = d a / d q. */
#include <stdlib.h>
#include <string.h>
#include <cvode/cvode.h>
#include <sunlinsol/sunlinsol_klu.h>
#include <sunlinsol/sunlinsol_spgmr.h>
#include <sunmatrix/sunmatrix_sparse.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include "methods/options.h"
#include "methods/registry.h"
#include "methods/sundials.h"

typedef struct cvode_options {
    double rtol, atol;
    long max_order, anderson, krylov_dimension;
} cvode_options;

typedef struct cvode {
    dl_sundials sundials; /* first: it is what the right-hand side gets */
    void *memory;
    double *work;      /* [2 unknowns]: where CVODE writes, also when it fails */
    N_Vector y, state; /* over work and over method->y */
    bool stale;        /* CVODE's history does not end at method->y */
    SUNNonlinearSolver nonlinear;
    SUNLinearSolver linear;
    SUNMatrix matrix;
    unsigned long pattern; /* generation of the sparsity that KLU analysed */
    double *values;        /* of A, [values_size] */
    size_t values_size;
    dl_method_stats before; /* of the integrations that a jump or a failure ended */
} cvode;

typedef struct cvode_variant {
    int family; /* CV_ADAMS or CV_BDF */
    int (*attach_solver)(cvode *data, const cvode_options *chosen);
} cvode_variant;

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

/* --- fixed point -------------------------------------------------------------------------------
 */

static int attach_fixed_point(cvode *data, const cvode_options *chosen) {
    data->nonlinear =
        SUNNonlinSol_FixedPoint(data->state, (int)chosen->anderson, data->sundials.context);
    return data->nonlinear ? CVodeSetNonlinearSolver(data->memory, data->nonlinear) : CV_MEM_FAIL;
}

/* --- Newton with KLU ---------------------------------------------------------------------------
 */

/* J in compressed columns. The diagonal is stored although it is zero: I - gamma J then has the
 * pattern of J. */
static size_t jacobian_nonzeros(const dl_sparsity *a) {
    return a->nonzeros + 3 * a->columns;
}

static void fill_jacobian(SUNMatrix jacobian, const dl_sparsity *a, const double *values) {
    sunindextype *const start = SUNSparseMatrix_IndexPointers(jacobian);
    sunindextype *const row = SUNSparseMatrix_IndexValues(jacobian);
    sunrealtype *const entry = SUNSparseMatrix_Data(jacobian);
    const sunindextype n = (sunindextype)a->columns;
    sunindextype k = 0;
    for (sunindextype column = 0; column < n; column++) {
        start[column] = k;
        row[k] = column;
        entry[k++] = 0;
        for (long i = a->column_start[column]; i < a->column_start[column + 1]; i++, k++) {
            row[k] = n + a->row[i];
            entry[k] = values[i];
        }
    }
    for (sunindextype column = 0; column < n; column++) {
        start[n + column] = k;
        row[k] = column;
        entry[k++] = 1;
        row[k] = n + column;
        entry[k++] = 0;
    }
    start[2 * n] = k;
}

static bool reserve_values(cvode *data, size_t needed) {
    if (needed <= data->values_size)
        return true;
    double *const grown = realloc(data->values, needed * sizeof *grown);
    if (!grown)
        return false;
    data->values = grown;
    data->values_size = needed;
    return true;
}

/* Room for the pattern in the matrix, and a fresh analysis where the pattern is a new one. */
static int adopt_pattern(cvode *data, SUNMatrix matrix, const dl_sparsity *a) {
    const sunindextype needed = (sunindextype)jacobian_nonzeros(a);
    if (needed > SUNSparseMatrix_NNZ(matrix) && SUNSparseMatrix_Reallocate(matrix, needed))
        return -1;
    if (a->generation == data->pattern)
        return 0;
    data->pattern = a->generation;
    return SUNLinSol_KLUReInit(data->linear, matrix, needed, SUNKLU_REINIT_PARTIAL);
}

/* The pattern is adopted last: where A fails, CVODE goes on with the J it has saved. */
static dl_status update_jacobian(cvode *data, const double *q, SUNMatrix matrix, dl_error *error) {
    dl_model *const model = data->sundials.model;
    const dl_sparsity *a = NULL;
    dl_status status = dl_model_sparsity(model, q, NULL, &a, error);
    if (!status && !reserve_values(data, a->nonzeros))
        status = dl_fail_memory(error, "the Jacobian");
    if (!status)
        status = dl_model_jacobian(model, q, data->values, error);
    if (!status && adopt_pattern(data, matrix, a))
        status = dl_fail_memory(error, "the Jacobian");
    if (!status)
        fill_jacobian(matrix, a, data->values);
    return status;
}

static int jacobian(sunrealtype t, N_Vector y, N_Vector ydot, SUNMatrix matrix, void *user_data,
                    N_Vector work1, N_Vector work2, N_Vector work3) {
    (void)t, (void)ydot, (void)work1, (void)work2, (void)work3;
    cvode *const data = user_data;
    dl_error error = {""};
    const dl_status status = update_jacobian(data, N_VGetArrayPointer(y), matrix, &error);
    return dl_sundials_answer(&data->sundials, status, &error);
}

static int attach_klu(cvode *data, const cvode_options *chosen) {
    (void)chosen;
    dl_model *const model = data->sundials.model;
    const dl_sparsity *a = NULL;
    dl_error error = {""};
    const dl_status status =
        dl_model_sparsity(model, N_VGetArrayPointer(data->state), NULL, &a, &error);
    if (status) {
        dl_sundials_answer(&data->sundials, status, &error);
        return CV_LINIT_FAIL;
    }
    const sunindextype size = (sunindextype)(2 * a->columns);
    data->pattern = a->generation;
    data->matrix = SUNSparseMatrix(size, size, (sunindextype)jacobian_nonzeros(a), CSC_MAT,
                                   data->sundials.context);
    if (data->matrix)
        data->linear = SUNLinSol_KLU(data->state, data->matrix, data->sundials.context);
    if (!data->linear)
        return CV_MEM_FAIL;
    const int flag = CVodeSetLinearSolver(data->memory, data->linear, data->matrix);
    return flag ? flag : CVodeSetJacFn(data->memory, jacobian);
}

/* --- Newton with GMRES -------------------------------------------------------------------------
 */

static int jacobian_times(N_Vector u, N_Vector product, sunrealtype t, N_Vector y, N_Vector ydot,
                          void *user_data, N_Vector work) {
    (void)t, (void)ydot, (void)work;
    cvode *const data = user_data;
    const size_t n = data->sundials.model->unknowns;
    const double *const in = N_VGetArrayPointer(u);
    double *const out = N_VGetArrayPointer(product);
    memcpy(out, in + n, n * sizeof *out);
    dl_error error = {""};
    const dl_status status =
        dl_model_jacobian_vector(data->sundials.model, N_VGetArrayPointer(y), in, out + n, &error);
    return dl_sundials_answer(&data->sundials, status, &error);
}

static int attach_krylov(cvode *data, const cvode_options *chosen) {
    data->linear = SUNLinSol_SPGMR(data->state, SUN_PREC_NONE, (int)chosen->krylov_dimension,
                                   data->sundials.context);
    if (!data->linear)
        return CV_MEM_FAIL;
    const int flag = CVodeSetLinearSolver(data->memory, data->linear, NULL);
    return flag ? flag : CVodeSetJacTimes(data->memory, NULL, jacobian_times);
}

/* --- the method --------------------------------------------------------------------------------
 */

static int set_up(cvode *data, const cvode_variant *variant, const cvode_options *chosen) {
    void *const memory = data->memory;
    int flag = dl_sundials_listen_cvode(&data->sundials, memory);
    if (!flag)
        flag = CVodeInit(memory, dl_sundials_rhs, 0, data->state);
    if (!flag)
        flag = CVodeSetUserData(memory, data);
    if (!flag)
        flag = CVodeSStolerances(memory, chosen->rtol, chosen->atol);
    if (!flag)
        flag = CVodeSetMaxOrd(memory, (int)chosen->max_order);
    return flag ? flag : variant->attach_solver(data, chosen);
}

static dl_status cvode_create(dl_method *method, dl_error *error) {
    const cvode_variant *const variant = method->row->variant;
    cvode *const data = method->data = calloc(1, sizeof *data);
    if (!data)
        return dl_fail_memory(error, "CVODE");
    const dl_status status = dl_sundials_create(&data->sundials, method->model, error);
    if (status)
        return status;
    const size_t length = 2 * method->n;
    data->work = malloc(length * sizeof *data->work);
    data->y = dl_sundials_vector(&data->sundials, data->work, length);
    data->state = dl_sundials_vector(&data->sundials, method->y, length);
    if (data->work && data->y && data->state)
        data->memory = CVodeCreate(variant->family, data->sundials.context);
    if (!data->memory)
        return dl_fail_memory(error, "CVODE");
    const int flag = set_up(data, variant, method->options);
    return flag ? dl_sundials_fail(&data->sundials, meanings, flag, "CVODE", error) : DL_OK;
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
    stats->nonlinear_iterations += count(CVodeGetNumNonlinSolvIters, data->memory);
    if (!data->linear)
        return;
    stats->linear_iterations += count(CVodeGetNumLinIters, data->memory);
    if (data->matrix)
        stats->factorisations += count(CVodeGetNumLinSolvSetups, data->memory);
}

static dl_status cvode_advance(dl_method *method, double t_stop, dl_error *error) {
    cvode *const data = method->data;
    double t = method->t;
    dl_sundials_begin(&data->sundials);
    int flag = CV_SUCCESS;
    if (data->stale) {
        add_stats(data, &data->before);
        flag = CVodeReInit(data->memory, method->t, data->state);
    }
    data->stale = false;
    if (flag == CV_SUCCESS)
        flag = CVodeSetStopTime(data->memory, t_stop);
    if (flag == CV_SUCCESS)
        flag = CVode(data->memory, t_stop, data->y, &t, CV_ONE_STEP);
    if (flag < 0) {
        data->stale = true;
        return dl_sundials_fail(&data->sundials, meanings, flag, "CVode", error);
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
    dl_sundials_begin(&data->sundials);
    const int flag = CVodeGetDky(data->memory, t, derivative, data->y);
    if (flag)
        return dl_sundials_fail(&data->sundials, meanings, flag, "CVodeGetDky", error);
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
    if (data->nonlinear)
        SUNNonlinSolFree(data->nonlinear);
    if (data->linear)
        SUNLinSolFree(data->linear);
    if (data->matrix)
        SUNMatDestroy(data->matrix);
    N_VDestroy(data->y);
    N_VDestroy(data->state);
    dl_sundials_destroy(&data->sundials);
    free(data->values);
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

#define OPTION_MAX_ORDER(largest, text)                                                            \
    {                                                                                              \
        .name = "max_order", .kind = DL_INTEGER, .offset = offsetof(cvode_options, max_order),     \
        .unit = "", .minimum = 1, .maximum = largest, .fallback = text,                            \
        .doc = "highest order used"                                                                \
    }

#define OPTION_ANDERSON                                                                            \
    {                                                                                              \
        .name = "anderson", .kind = DL_INTEGER, .offset = offsetof(cvode_options, anderson),       \
        .unit = "", .minimum = 0, .maximum = 20, .fallback = "0",                                  \
        .doc = "depth of Anderson acceleration; 0: plain functional iteration"                     \
    }

#define OPTIONS_TOLERANCES DL_OPTION_RTOL(cvode_options), DL_OPTION_ATOL(cvode_options)

static const dl_parameter adams_options[] = {OPTIONS_TOLERANCES, OPTION_MAX_ORDER(12, "12"),
                                             OPTION_ANDERSON};
static const dl_parameter bdf_fixed_point_options[] = {OPTIONS_TOLERANCES, OPTION_MAX_ORDER(5, "5"),
                                                       OPTION_ANDERSON};
static const dl_parameter bdf_klu_options[] = {OPTIONS_TOLERANCES, OPTION_MAX_ORDER(5, "5")};
static const dl_parameter bdf_krylov_options[] = {
    OPTIONS_TOLERANCES,
    OPTION_MAX_ORDER(5, "5"),
    {
        .name = "krylov_dimension",
        .kind = DL_INTEGER,
        .offset = offsetof(cvode_options, krylov_dimension),
        .unit = "",
        .minimum = 1,
        .maximum = 100,
        .fallback = "5",
        .doc = "largest dimension of GMRES' space",
    },
};

static const cvode_variant adams = {CV_ADAMS, attach_fixed_point};
static const cvode_variant bdf_fixed_point = {CV_BDF, attach_fixed_point};
static const cvode_variant bdf_klu = {CV_BDF, attach_klu};
static const cvode_variant bdf_krylov = {CV_BDF, attach_krylov};

#define CVODE(symbol, name_, flags_, doc_)                                                         \
    const dl_method_row dl_method_cvode_##symbol = {                                               \
        .name = name_,                                                                             \
        .family = "CVODE",                                                                         \
        .doc = doc_,                                                                               \
        .order = 0,                                                                                \
        .flags = DL_IMPLICIT | DL_ADAPTIVE | (flags_),                                             \
        .options = DL_OPTIONS_TABLE(symbol##_options),                                             \
        .options_size = sizeof(cvode_options),                                                     \
        .variant = &(symbol),                                                                      \
        .ops = &ops,                                                                               \
    }

CVODE(adams, "cvode-adams", 0, "Adams-Moulton, orders 1-12, fixed-point iteration (CVODE)");
CVODE(bdf_fixed_point, "cvode-bdf-fixed-point", 0,
      "BDF, orders 1-5, fixed-point iteration (CVODE)");
CVODE(bdf_klu, "cvode-bdf-klu", DL_NEEDS_JACOBIAN,
      "BDF, orders 1-5, Newton with an analytic sparse Jacobian and KLU (CVODE)");
CVODE(bdf_krylov, "cvode-bdf-krylov", DL_NEEDS_JACOBIAN,
      "BDF, orders 1-5, Newton with GMRES and analytic Jacobian-vector products (CVODE)");
