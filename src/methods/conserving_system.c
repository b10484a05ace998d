#include <math.h>

#include "methods/conserving_parts.h"
#include "methods/norms.h"

double dl_conserving_roundoff(const dl_conserving_step *step) {
    return fmax(1e-11 * step->size, step->floor);
}

/* A trial displacement this many times the step's is nonsense that would cost a neighbour list of
 * everything. */
static const double longest_trial = 100;

/* Evaluations without progress after which a fixed-point iteration is given up. */
enum { patience = 12 };

/* What a callback answers there: recoverable, a line search tries a shorter step. */
enum { trial_is_nonsense = 1 };

void dl_conserving_begin(dl_conserving_solver *solver) {
    solver->best = INFINITY;
    solver->since_best = 0;
    solver->stalled = false;
    dl_sundials_begin(&solver->sundials);
}

static bool is_nonsense(const dl_conserving_step *step, const double *delta) {
    const double limit = longest_trial * step->size;
    bool sense = true;
    for (size_t i = 0; i < step->n; i++)
        sense &= fabs(delta[i]) <= limit;
    return !sense;
}

/* image = h v + (h^2/2) a(q, q + delta); what KINSOL is to be told. */
static int apply_map(dl_conserving_solver *solver, const double *delta, double *image) {
    const dl_conserving_step *const step = &solver->step;
    if (is_nonsense(step, delta))
        return trial_is_nonsense;
    dl_error error;
    const dl_status status =
        dl_model_discrete_acceleration(solver->sundials.model, step->q, delta, step->a, &error);
    const double h = step->h, half_square = h * h / 2;
    for (size_t i = 0; i < step->n && !status; i++)
        image[i] = h * step->v[i] + half_square * step->a[i];
    return dl_sundials_answer(&solver->sundials, status, &error);
}

/* Keeps count of how the residual falls. */
static void judge(dl_conserving_solver *solver, double residual) {
    solver->last = residual;
    solver->since_best = residual < solver->best ? 0 : solver->since_best + 1;
    solver->best = fmin(solver->best, residual);
}

/* Whether the residual has come down to roundoff and stays there. */
bool dl_conserving_is_at_roundoff(const dl_conserving_solver *solver) {
    return solver->since_best >= 2 && solver->last <= dl_conserving_roundoff(&solver->step);
}

/* An iteration that KINSOL does not watch ends after an answer that is not 0 (KINSOL would go on
 * after a positive one), or where it gets nowhere. */
static int end_early(dl_conserving_solver *solver, int answer) {
    if (answer)
        solver->stalled = solver->sundials.model_status == DL_OK;
    else
        solver->stalled = solver->since_best > patience && !dl_conserving_is_at_roundoff(solver);
    return answer || solver->stalled ? -1 : 0;
}

int dl_conserving_advance_map(dl_conserving_solver *solver, const double *delta, double *image) {
    const int answer = apply_map(solver, delta, image);
    if (!answer) {
        dl_model_crossings_settle(solver->sundials.model, delta, image, solver->step.a);
        judge(solver, dl_largest_in_lanes(image, delta, solver->step.n));
    }
    return end_early(solver, answer);
}

int dl_conserving_map(N_Vector u, N_Vector image, void *user_data) {
    dl_conserving_solver *const solver = user_data;
    const int answer =
        dl_conserving_advance_map(solver, N_VGetArrayPointer(u), N_VGetArrayPointer(image));
    if (!answer && dl_conserving_is_at_roundoff(solver)) /* KINSOL stops where the map leaves u */
        N_VScale(1, u, image);
    return answer;
}

int dl_conserving_residual(N_Vector u, N_Vector f, void *user_data) {
    dl_conserving_solver *const solver = user_data;
    const double *const delta = N_VGetArrayPointer(u);
    double *const to = N_VGetArrayPointer(f);
    const int answer = apply_map(solver, delta, to);
    if (answer)
        return answer;
    judge(solver, dl_largest_in_lanes(to, delta, solver->step.n));
    const bool done = dl_conserving_is_at_roundoff(solver);
    for (size_t i = 0; i < solver->step.n; i++)
        to[i] = done ? 0 : delta[i] - to[i];
    return 0;
}

int dl_conserving_picard(N_Vector u, N_Vector f, void *user_data) {
    return end_early(user_data, dl_conserving_residual(u, f, user_data));
}
