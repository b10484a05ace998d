/* How far a kernel's forces lie from direct sums over all pairs. */
#include <math.h>
#include <stdlib.h>
#include "model/private.h"

/* Particles that are looked at, evenly over those that move. */
enum { SAMPLE = 128 };

/* The direct sum of one particle. */
typedef struct direct_sum {
    long double force[3];
    long double moduli; /* of the pairs' forces */
} direct_sum;

static void add_pair(const dl_model *model, const dl_pair *pair, void *context) {
    direct_sum *const sum = context;
    const double over_r = pair->coupling * dl_law_force_over_r(pair->law, pair->s);
    for (int c = 0; c < model->dimension; c++)
        sum->force[c] += (long double)over_r * pair->d[c];
    sum->moduli += fabs(over_r) * sqrt(pair->s);
}

/* In parts of the moduli; 0 for a particle on which nothing acts. */
static double error_of(const dl_model *model, const double *x, const double *f, size_t i) {
    direct_sum sum = {{0}, 0};
    long double square = 0;
    for (size_t j = 0; j < model->particles; j++)
        if (j != i)
            dl_model_visit_pair(model, x, NULL, i, j, add_pair, &sum);
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        const long double d = f[c * model->particles + i] - sum.force[c];
        square += d * d;
    }
    return sum.moduli > 0 ? (double)(sqrtl(square) / sum.moduli) : 0;
}

bool dl_model_has_force_error(const dl_model *model) {
    return model->kernel && model->kernel->stated_error > 0;
}

dl_status dl_model_force_error(dl_model *model, const double *q, dl_force_error *result,
                               dl_error *error) {
    *result = (dl_force_error){.stated = NAN, .largest = NAN, .mean = NAN};
    if (!dl_model_has_force_error(model) || model->moving == 0)
        return DL_OK;
    const size_t block = (size_t)model->dimension * model->particles;
    double *const f = malloc(block * sizeof *f);
    if (!f)
        return dl_fail_memory(error, "the measurement of a force's error");
    const double *const x = dl_model_places(model, q);
    const dl_status status = model->kernel->ops->force(model->kernel, x, f, error);
    if (!status) {
        const size_t sampled = model->moving < SAMPLE ? model->moving : SAMPLE;
        double largest = 0, sum = 0;
        for (size_t k = 0; k < sampled; k++) {
            const double own = error_of(model, x, f, k * model->moving / sampled);
            largest = own > largest || isnan(own) ? own : largest;
            sum += own;
        }
        *result = (dl_force_error){.stated = model->kernel->stated_error,
                                   .largest = largest,
                                   .mean = sum / (double)sampled,
                                   .sampled = sampled};
    }
    free(f);
    return status;
}
