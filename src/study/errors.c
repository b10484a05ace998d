/* The errors of a case by name, and what each is certainly below. */
#include "study/errors.h"

#include <math.h>
#include <string.h>
#include "driftlab/reference.h"

/* In units of its scale; NaN where the scene has none. */
static double relative(double value, double scale) {
    return scale > 0 ? value / scale : NAN;
}

static double position(const dl_case *cased) {
    return cased->position_error;
}

static double position_worst(const dl_case *cased) {
    return cased->position_error_max;
}

static double position_ever(const dl_case *cased) {
    return cased->position_error_ever;
}

static double energy(const dl_case *cased) {
    return relative(cased->summary.energy_error_max, cased->summary.energy_scale);
}

static double momentum(const dl_case *cased) {
    return relative(cased->summary.momentum_error_max, cased->summary.momentum_scale);
}

static double angular_momentum(const dl_case *cased) {
    return relative(cased->summary.angular_momentum_error_max,
                    cased->summary.angular_momentum_scale);
}

static const char no_reference[] = "there is no reference to compare it with";
static const char no_momentum[] = "the scene does not conserve it";

const dl_error_row dl_error_rows[DL_ERROR_ROWS] = {
    {"position", true, position, no_reference},
    {"position-worst", true, position_worst, no_reference},
    {"position-ever", true, position_ever, no_reference},
    {"energy", false, energy, "its energy error was not measured"},
    {"momentum", false, momentum, no_momentum},
    {"angular-momentum", false, angular_momentum, no_momentum},
};

const dl_error_row *dl_error_row_of(const char *name) {
    for (size_t i = 0; i < DL_ERROR_ROWS; i++)
        if (strcmp(name, dl_error_rows[i].name) == 0)
            return &dl_error_rows[i];
    return &dl_error_rows[0];
}

double dl_case_error(const dl_case *cased, const char *asked_in) {
    return dl_error_row_of(asked_in)->of(cased);
}

bool dl_case_is_past_horizon(const dl_case *cased, const dl_reference *reference) {
    return reference && reference->horizon > 0 &&
           reference->horizon <= cased->summary.t_end_reached;
}

/* A position error that the reference cannot tell is at most its sum with the reference's own;
 * which of these says something is known of the RMS at the end alone. */
static double unresolved(const dl_case *cased, const dl_error_row *row, double error,
                         const dl_reference *reference) {
    if (!reference || row != &dl_error_rows[0])
        return INFINITY;
    return dl_case_is_past_horizon(cased, reference) ? INFINITY : error + reference->error;
}

double dl_case_bound(const dl_case *cased, const char *asked_in, const dl_reference *reference) {
    const dl_error_row *row = dl_error_row_of(asked_in);
    const double error = row->of(cased);
    if (cased->summary.status != DL_OK || *cased->invalid || !isfinite(error))
        return INFINITY;
    return row->needs_reference && *cased->refused ? unresolved(cased, row, error, reference)
                                                   : error;
}
