#include "methods/conserving_predictor.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

const char *const dl_predictor_names[] = {
    [DL_PREDICT_EXPLICIT] = "explicit",
    [DL_PREDICT_CONSTANT] = "constant",
    [DL_PREDICT_LINEAR] = "linear",
    [DL_PREDICT_QUADRATIC] = "quadratic",
    [DL_PREDICT_CUBIC] = "cubic",
    [DL_PREDICT_QUARTIC] = "quartic",
    [DL_PREDICT_QUINTIC] = "quintic",
    [DL_PREDICT_SEXTIC] = "sextic",
    [DL_PREDICT_SEPTIC] = "septic",
    [DL_PREDICT_OCTIC] = "octic",
    NULL,
};

dl_status dl_predictor_create(dl_predictor *predictor, dl_predictor_kind kind, size_t n,
                              dl_error *error) {
    *predictor = (dl_predictor){.n = n, .points = (int)kind, .trusted = (int)kind};
    predictor->guess = calloc(n + 1, sizeof(double));
    if (!predictor->guess)
        return dl_fail_memory(error, "the conserving scheme's past");
    for (int k = 0; k < predictor->points; k++) {
        predictor->past[k] = calloc(n + 1, sizeof(double));
        if (!predictor->past[k])
            return dl_fail_memory(error, "the conserving scheme's past");
    }
    return DL_OK;
}

void dl_predictor_free(dl_predictor *predictor) {
    for (int k = 0; k < dl_predictor_most; k++)
        free(predictor->past[k]);
    free(predictor->guess);
}

/* Whether the guess was nearer to the mean than the last mean is. */
static bool was_good(const dl_predictor *predictor, const double *mean) {
    const double *const last = predictor->past[0], *const guess = predictor->guess;
    double of_last = 0, of_guess = 0;
    for (size_t i = 0; i < predictor->n; i++) {
        of_last += (last[i] - mean[i]) * (last[i] - mean[i]);
        of_guess += (guess[i] - mean[i]) * (guess[i] - mean[i]);
    }
    return of_guess <= of_last;
}

void dl_predictor_add(dl_predictor *predictor, double h, const double *mean) {
    if (predictor->points == 0)
        return;
    if (predictor->has_guessed && predictor->known > 1)
        predictor->trusted += was_good(predictor, mean) ? predictor->trusted < predictor->points
                                                        : -(predictor->trusted > 1);
    predictor->has_guessed = false;
    double *const oldest = predictor->past[predictor->points - 1];
    for (int k = predictor->points - 1; k > 0; k--) {
        predictor->past[k] = predictor->past[k - 1];
        predictor->middle[k] = predictor->middle[k - 1] - h;
    }
    predictor->past[0] = oldest;
    predictor->middle[0] = -h / 2;
    memcpy(oldest, mean, predictor->n * sizeof *mean);
    predictor->known += predictor->known < predictor->points;
}

void dl_predictor_jumped(dl_predictor *predictor) {
    predictor->known = predictor->known ? 1 : 0;
}

/* Points that are far enough apart to extrapolate from: a step cut short by an event is followed by
 * one that is not. */
static int usable(const dl_predictor *predictor, double h) {
    const double apart = fabs(h) / 10;
    const int most = predictor->known < predictor->trusted ? predictor->known : predictor->trusted;
    int points = most ? 1 : 0;
    for (; points < most; points++)
        for (int m = 0; m < points; m++)
            if (!(fabs(predictor->middle[points] - predictor->middle[m]) > apart))
                return points;
    return points;
}

/* Lagrange's factor of point k at `at`. */
static double factor(const dl_predictor *predictor, int points, int k, double at) {
    double product = 1;
    for (int m = 0; m < points; m++)
        if (m != k)
            product *= (at - predictor->middle[m]) / (predictor->middle[k] - predictor->middle[m]);
    return product;
}

bool dl_predictor_guess(dl_predictor *predictor, double h, double *mean) {
    const int points = usable(predictor, h);
    for (int k = 0; k < points; k++) {
        const double weight = factor(predictor, points, k, h / 2);
        const double *const past = predictor->past[k];
        for (size_t i = 0; i < predictor->n; i++)
            mean[i] = (k ? mean[i] : 0) + weight * past[i];
    }
    predictor->has_guessed = points > 0;
    if (predictor->has_guessed)
        memcpy(predictor->guess, mean, predictor->n * sizeof *mean);
    return predictor->has_guessed;
}
