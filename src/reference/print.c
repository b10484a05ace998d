#include <math.h>

#include "driftlab/reference.h"

static void print_exponent(const dl_reference *reference, const char *indent, FILE *out) {
    const double growth = reference->growth[reference->samples - 1];
    fprintf(out,
            "%slargest Lyapunov exponent: %.3g +- %.1g over the second half; a small displacement "
            "grew by 10^%.1f until t = %g\n",
            indent, reference->lyapunov, reference->lyapunov_error, growth / log(10),
            reference->time[reference->samples - 1]);
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
