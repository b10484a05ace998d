/* The plain fixed-point iteration
 *
 *     delta <- h v + (h^2/2) a(q, q + delta)
 *
 * for steps at which it contracts strongly. What a method takes over is the last image, not the
 * displacement that the force was evaluated at last. The image's residual is the next iteration's,
 * and that is foretold from how strongly the iteration contracts: so no evaluation goes into
 * finding out that there is nothing left to do. */
#include <math.h>
#include <string.h>

#include "methods/conserving_parts.h"

/* What is foretold is not trusted to be less than this part of a residual. */
static const double least_left = 0.01;

/* What an iteration leaves of the last residual, at most, as far as is known: as the start of the
 * run promises, or the worst that has been seen. The last two residuals alone say too little: the
 * first may be that of soft modes, the second what stiff ones have left. Roundoff says nothing, and
 * where forces jump a pair can come into reach that nothing has told of. */
static double left_of_last(dl_conserving_solver *solver, double before) {
    const double telling = 1e-14 * solver->step.size + solver->step.floor;
    double *const most = &solver->settings.contraction;
    if (solver->jumps || before == 0)
        return 1;
    if (solver->last > telling)
        *most = fmax(*most, solver->last / before);
    return fmin(1, fmax(*most, least_left));
}

static dl_status fail_to_converge(const dl_conserving_solver *solver, long iterations,
                                  dl_error *error) {
    if (solver->sundials.model_status)
        return dl_fail(error, solver->sundials.model_status, "%s",
                       solver->sundials.model_error.message);
    return dl_fail(error, DL_NONLINEAR_FAILURE,
                   "the step's system did not converge in %ld iterations: residual %.3g of the "
                   "displacement",
                   iterations, solver->best / solver->step.size);
}

dl_status dl_conserving_iterate(dl_conserving_solver *solver, dl_error *error) {
    const dl_conserving_step *const step = &solver->step;
    const double enough = solver->settings.tolerance * step->size;
    bool done = false;
    long k = 0;
    dl_conserving_begin(solver);
    while (!done && k < solver->settings.iterations) {
        const double before = k > 0 ? solver->last : 0;
        if (dl_conserving_advance_map(solver, step->delta, solver->image))
            break;
        memcpy(step->delta, solver->image, step->n * sizeof *step->delta);
        k++;
        done = left_of_last(solver, before) * solver->last <= enough ||
               dl_conserving_is_at_roundoff(solver);
    }
    solver->counts.iterations += (unsigned long)k;
    return done ? DL_OK : fail_to_converge(solver, k, error);
}
