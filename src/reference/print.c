#include <math.h>

#include "driftlab/reference.h"

bool dl_reference_grows(const dl_reference *reference) {
    if (!(reference->lyapunov_error > 0))
        return false; /* none was measured */
    const double half = reference->time[reference->samples - 1] / 2;
    return (reference->lyapunov - reference->lyapunov_error) * half > 2 * log(2);
}

static void print_exponent(const dl_reference *reference, const char *indent, FILE *out) {
    const double growth = reference->growth[reference->samples - 1];
    fprintf(
        out,
        "%slargest Lyapunov exponent: %.3g +- %.1g over the second half; a small displacement "
        "grew by 10^%.1f until t = %g%s\n",
        indent, reference->lyapunov, reference->lyapunov_error, growth / log(10),
        reference->time[reference->samples - 1],
        dl_reference_grows(reference)
            ? ""
            : "; in the second half no faster than t^2, as regular motion's can: no sign of chaos");
}

static void print_horizon(const dl_reference *reference, const char *indent, FILE *out) {
    const double end = reference->time[reference->samples - 1];
    if (reference->horizon > 0)
        fprintf(out,
                "%shorizon: t = %.4g; from then on rounding errors of double precision are above 1 "
                "%% of the length %.4g, and errors mean nothing\n",
                indent, reference->horizon, reference->length);
    else
        fprintf(out, "%shorizon: not before t = %g\n", indent, end);
    if (reference->parted > 0)
        fprintf(out, "%sthe reference's trajectories part at t = %.4g\n", indent,
                reference->parted);
}

void dl_reference_print(const dl_reference *reference, const char *indent, FILE *out) {
    fprintf(out, "%sreference: %s; own error %.2g\n", indent, reference->description,
            reference->error);
    if (reference->note && *reference->note)
        fprintf(out, "%sno better: %s\n", indent, reference->note);
    if (reference->lyapunov_error > 0)
        print_exponent(reference, indent, out);
    if (reference->length > 0)
        print_horizon(reference, indent, out);
}
