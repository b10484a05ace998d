#include "methods/conserving_choice.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

/* A fixed-point iteration that leaves less of an error than the first is faster without
 * acceleration and without KINSOL, and less than the second, faster than Newton's
 * method: studies/conserving/README.md.
 */
static const double contracts_well = 0.1, contracts = 0.75;
/* Residuals that the acceleration combines where it is wanted. */
enum { accelerated = 3 };
/* Unknowns up to which Newton's method is the fastest with a dense matrix. Beyond, GMRES is: in
 * three dimensions a sparse factor fills in. */
enum { dense_most = 40 };
/* Products with d a / d delta for its largest eigenvalue: a digit is enough. */
enum { power_steps = 20 };

/* --- stiffness ----------------------------------------------------------------------------------
 */

static double norm(const double *x, size_t n) {
    double sum = 0;
    for (size_t i = 0; i < n; i++)
        sum += x[i] * x[i];
    return sqrt(sum);
}

/* The largest |eigenvalue| of d a / d delta at q, from below, by the power method; NaN where it has
 * none. Not counted. x, y: scratch [n]; x is zero. */
static double largest_eigenvalue(dl_model *model, const double *q, double *x, double *y) {
    const size_t n = model->unknowns;
    const dl_counts counts = model->counts;
    double value = 0;
    if (dl_model_discrete_product_prepare(model, q, x, NULL))
        value = NAN;
    for (size_t i = 0; i < n; i++)
        x[i] = sin(12.9898 * ((double)i + 1));
    for (int k = 0; k < power_steps && !isnan(value); k++) {
        const double size = norm(x, n);
        for (size_t i = 0; size > 0 && i < n; i++)
            x[i] /= size;
        dl_model_discrete_product(model, x, y);
        value = norm(y, n);
        double *const swap = x;
        x = y;
        y = swap;
    }
    dl_model_discrete_product_forget(model);
    model->counts = counts;
    return value;
}

static double longest_part(const dl_conserving_variant *variant) {
    double most = 0;
    for (int k = 0; k < variant->stages; k++)
        most = fmax(most, fabs(variant->weight[k]));
    return most;
}

/* What the fixed-point iteration leaves of an error: h^2/2 times the largest derivative of the mean
 * acceleration, which is half of the largest squared frequency. */
static dl_status find_factor(const dl_method *method, const double *q, double *factor,
                             dl_error *error) {
    const dl_conserving_options *const options = method->options;
    const double h = options->step * longest_part(method->row->variant);
    double *const scratch = calloc(2 * method->n + 1, sizeof *scratch);
    if (!scratch)
        return dl_fail_memory(error, "the choice of a solver");
    *factor = h * h / 2 * largest_eigenvalue(method->model, q, scratch, scratch + method->n);
    free(scratch);
    return DL_OK;
}

/* --- the choice ---------------------------------------------------------------------------------
 */

static dl_solver_kind newton_for(const dl_model *model) {
    return model->unknowns <= dense_most ? DL_NEWTON_DENSE : DL_NEWTON_KRYLOV;
}

static bool uses_depth(dl_solver_kind kind) {
    return kind == DL_FIXED_POINT || kind == DL_PICARD;
}

static void give_reason(const dl_method *method, double factor, dl_conserving_choice *choice) {
    char depth[32] = "", rescue[64] = "", left[64];
    if (uses_depth(choice->solver.kind))
        snprintf(depth, sizeof depth, " of depth %ld", choice->solver.depth);
    if (choice->has_rescue)
        snprintf(rescue, sizeof rescue, "; where it fails, %s",
                 dl_solver_names[choice->rescue.kind]);
    if (isfinite(factor))
        snprintf(left, sizeof left, "a fixed point leaves %.2g of an error", factor);
    else
        snprintf(left, sizeof left, "what a fixed point leaves of an error cannot be told");
    snprintf(choice->reason, sizeof choice->reason, "%s%s: at the start %s, %zu unknowns%s",
             dl_solver_names[choice->solver.kind], depth, left, method->n, rescue);
}

dl_status dl_conserving_choose(const dl_method *method, const dl_conserving_state *state,
                               dl_conserving_choice *choice, dl_error *error) {
    const dl_conserving_options *const options = method->options;
    const dl_conserving_variant *const variant = method->row->variant;
    const bool open = variant->by_option && options->solver == 0;
    const dl_solver_kind newton = newton_for(method->model);
    double factor = 0;
    const dl_status status = find_factor(method, state->q, &factor, error);
    if (status)
        return status;
    const bool slow = !(factor <= contracts_well); /* a NaN, too */
    const dl_conserving_settings settings = {
        .kind = variant->by_option ? (dl_solver_kind)(options->solver - 1) : variant->solver,
        .tolerance = options->tolerance,
        .iterations = options->iterations,
        .depth = options->depth >= 0 ? options->depth
                 : slow              ? accelerated
                                     : 0,
        .contraction = isnan(factor) ? 1 : factor,
    };
    *choice = (dl_conserving_choice){
        .solver = settings, .rescue = settings, .has_rescue = options->rescue};
    if (open)
        choice->solver.kind = factor > contracts ? newton : slow ? DL_FIXED_POINT : DL_ITERATION;
    const bool is_fixed_point =
        choice->solver.kind == DL_FIXED_POINT || choice->solver.kind == DL_ITERATION;
    choice->rescue.kind = is_fixed_point ? newton : DL_FIXED_POINT;
    if (open || (uses_depth(settings.kind) && options->depth < 0))
        give_reason(method, factor, choice);
    return DL_OK;
}
