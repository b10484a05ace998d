#include "reference/horizon.h"

#include <float.h>
#include <math.h>

#include "driftlab/observe.h"

static const double parting = 0.01; /* of the distance between neighbours */

enum { blocks = 8 }; /* that the exponent's error is estimated from */

/* --- lengths ---------------------------------------------------------------------------------- */

/* Root mean square of the coordinates of what moves. */
static double size_of(const dl_scene *scene, const double *position) {
    double sum = 0;
    size_t count = 0;
    for (size_t k = 0; k < (size_t)scene->dimension * scene->particles; k++)
        if (!scene->pinned[k % scene->particles]) {
            sum += position[k] * position[k];
            count++;
        }
    return count > 0 ? sqrt(sum / (double)count) : 0;
}

dl_status dl_reference_length(const dl_scene *scene, double *length, dl_error *error) {
    const dl_status status = dl_observe_separation(scene, scene->position, 1, length, error);
    if (status || *length > 0)
        return status;
    *length = size_of(scene, scene->position);
    for (int c = 0; c < scene->dimension && scene->walls.present; c++) {
        const double width = scene->walls.high[c] - scene->walls.low[c];
        if (isfinite(width))
            *length = width;
    }
    if (!(*length > 0))
        *length = 1;
    return DL_OK;
}

/* RMS over what moves; a1 + b1 - (a0 + b0). */
static double distance(const dl_scene *scene, const double *a1, const double *b1, const double *a0,
                       const double *b0, double *largest) {
    const size_t n = scene->particles;
    double sum = 0, most = 0;
    size_t moving = 0;
    for (size_t i = 0; i < n; i++) {
        double square = 0;
        if (scene->pinned[i])
            continue;
        for (size_t k = i; k < (size_t)scene->dimension * n; k += n) {
            const double d = (a1[k] - a0[k]) + ((b1 ? b1[k] : 0) - (b0 ? b0[k] : 0));
            square += d * d;
        }
        sum += square;
        if (!(square <= most)) /* a NaN stays */
            most = square;
        moving++;
    }
    if (largest)
        *largest = sqrt(most);
    return moving > 0 ? sqrt(sum / (double)moving) : 0;
}

double dl_reference_distance(const dl_scene *scene, const dl_reference *reference, size_t sample,
                             const double *position, double *largest) {
    const size_t at = sample * (size_t)scene->dimension * scene->particles;
    return distance(scene, position, NULL, reference->position + at,
                    reference->position_low ? reference->position_low + at : NULL, largest);
}

double dl_position_distance(const dl_scene *scene, const double *a, const double *b,
                            double *largest) {
    return distance(scene, a, NULL, b, NULL, largest);
}

bool dl_reference_is_past(const dl_reference *reference, size_t sample) {
    return reference->horizon > 0 && reference->time[sample] >= reference->horizon;
}

bool dl_reference_shows(const dl_reference *reference, size_t sample, double error) {
    return !dl_reference_is_past(reference, sample) &&
           error >= DL_REFERENCE_MARGIN * reference->sample_error[sample];
}

double dl_reference_take_check(const dl_scene *scene, dl_reference *reference, const double *high,
                               const double *low) {
    const size_t block = (size_t)scene->dimension * scene->particles;
    double largest = 0;
    for (size_t i = 0; i < reference->samples; i++) {
        const double apart =
            distance(scene, high + 2 * i * block, low + 2 * i * block,
                     reference->position + i * block, reference->position_low + i * block, NULL);
        largest = fmax(largest, apart);
        reference->sample_error[i] = fmax(reference->sample_error[i], 2 * largest);
    }
    reference->error = reference->sample_error[reference->samples - 1];
    return largest;
}

/* A number between two powers of 2 is off by 0.14 to 0.29 epsilon times its size, RMS. */
void dl_reference_take_rounding(const dl_scene *scene, dl_reference *reference, double epsilon,
                                unsigned long steps) {
    const size_t block = (size_t)scene->dimension * scene->particles;
    const size_t last = reference->samples - 1;
    for (size_t i = 1; i <= last; i++) {
        const double size = size_of(scene, reference->position + i * block);
        const double done = (double)steps * (double)i / (double)last;
        const double rounding = 0.2 * epsilon * size * sqrt((double)scene->dimension * done);
        reference->sample_error[i] =
            fmax(reference->sample_error[i - 1], fmax(reference->sample_error[i], rounding));
    }
    reference->error = reference->sample_error[last];
}

/* --- growth ----------------------------------------------------------------------------------- */

/* Slope over the second half, where the displacement has turned to where it grows most, and what
 * that of its blocks varies by. */
static void set_exponent(dl_reference *reference, const double *growth, size_t count) {
    const double end = reference->time[reference->samples - 1];
    const size_t half = count / 2;
    double sum = 0, squares = 0;
    for (size_t b = 0; b < blocks; b++) {
        const size_t from = half + (count - half) * b / blocks;
        const size_t to = half + (count - half) * (b + 1) / blocks;
        const double slope =
            (growth[to] - growth[from]) / (end * (double)(to - from) / (double)count);
        sum += slope;
        squares += slope * slope;
    }
    reference->lyapunov = sum / blocks;
    const double variance = squares / blocks - reference->lyapunov * reference->lyapunov;
    reference->lyapunov_error = sqrt(fmax(variance, DBL_MIN) / (blocks - 1));
}

/* When a rounding error of double precision at the start has grown to a part of the length. */
static double rounding_horizon(const dl_scene *scene, const dl_reference *reference,
                               const double *growth, size_t parts) {
    const size_t block = (size_t)scene->dimension * scene->particles;
    const double end = reference->time[reference->samples - 1];
    const size_t count = parts * (reference->samples - 1);
    for (size_t k = 0; k <= count; k++) {
        const double size = size_of(scene, reference->position + k / parts * block);
        const double rounding = DBL_EPSILON / 2 * size / reference->length;
        if (log(rounding) + growth[k] > log(parting))
            return end * (double)k / (double)count;
    }
    return 0;
}

/* From when on its own error, times `factor`, is above a part of the length. */
static double error_horizon(const dl_reference *reference, double factor) {
    for (size_t i = 0; i < reference->samples; i++)
        if (!(factor * reference->sample_error[i] <= parting * reference->length))
            return reference->time[i];
    return 0;
}

/* The earlier of two, of which 0 is none. */
static double earlier(double a, double b) {
    return a > 0 && b > 0 ? fmin(a, b) : fmax(a, b);
}

void dl_reference_set_horizon(const dl_scene *scene, dl_reference *reference, const double *growth,
                              size_t parts, double epsilon) {
    reference->lyapunov = reference->lyapunov_error = 0;
    reference->parted = error_horizon(reference, 1);
    /* what errors of that kind would be in double precision, whose steps round as often */
    reference->horizon = error_horizon(reference, DBL_EPSILON / epsilon);
    if (growth) {
        for (size_t i = 0; i < reference->samples; i++)
            reference->growth[i] = growth[i * parts];
        set_exponent(reference, growth, parts * (reference->samples - 1));
        reference->horizon =
            earlier(reference->horizon, rounding_horizon(scene, reference, growth, parts));
    }
}
