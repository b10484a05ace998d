/* Where the iteration for a step begins: the mean acceleration, taken from the start of the step or
 * extrapolated from those of the steps before, which stand for the middles of their steps. */
#ifndef DL_METHODS_CONSERVING_PREDICTOR_H
#define DL_METHODS_CONSERVING_PREDICTOR_H

#include <stdbool.h>
#include <stddef.h>

#include "driftlab/status.h"

typedef enum dl_predictor_kind {
    DL_PREDICT_EXPLICIT, /* the acceleration at the start: a force more */
    DL_PREDICT_CONSTANT, /* the last mean */
    DL_PREDICT_LINEAR,   /* through the last two, three ... nine */
    DL_PREDICT_QUADRATIC,
    DL_PREDICT_CUBIC,
    DL_PREDICT_QUARTIC,
    DL_PREDICT_QUINTIC,
    DL_PREDICT_SEXTIC,
    DL_PREDICT_SEPTIC,
    DL_PREDICT_OCTIC,
} dl_predictor_kind;

extern const char *const dl_predictor_names[];

enum { dl_predictor_most = 9 };

typedef struct dl_predictor {
    size_t n;
    int points;                       /* used at most; 0: explicit */
    int known;                        /* <= points */
    int trusted;                      /* <= points: more would be worse than the last mean alone */
    bool has_guessed;                 /* `guess` is that of the step under way */
    double *guess;                    /* [n] */
    double *past[dl_predictor_most];  /* means, the latest first, [n] each */
    double middle[dl_predictor_most]; /* of their steps, as seen from now */
} dl_predictor;

dl_status dl_predictor_create(dl_predictor *predictor, dl_predictor_kind kind, size_t n,
                              dl_error *error);
void dl_predictor_free(dl_predictor *predictor);

/* A step of length h has been taken with that mean. Where the guess was farther from it than the
 * last mean, the next one trusts a point less. */
void dl_predictor_add(dl_predictor *predictor, double h, const double *mean);
/* The state has jumped: the last mean is still near, its changes tell nothing. */
void dl_predictor_jumped(dl_predictor *predictor);

/* The mean over the coming step of length h. False where it has to be taken from the start. */
bool dl_predictor_guess(dl_predictor *predictor, double h, double *mean);

#endif
