#include "methods/motion.h"

void dl_kick_and_drift(size_t n, double kick, double drift, const double *restrict a,
                       double *restrict q, double *restrict v) {
    for (size_t i = 0; i < n; i++) {
        v[i] += kick * a[i];
        q[i] += drift * v[i];
    }
}

void dl_kick_and_drift_from(size_t n, double kick, double drift, const double *restrict a,
                            const double *restrict y0, double *restrict y) {
    for (size_t i = 0; i < n; i++) {
        y[n + i] = y0[n + i] + kick * a[i];
        y[i] = y0[i] + drift * y[n + i];
    }
}

void dl_drift_from(size_t n, double drift, const double *restrict y0, double *restrict y) {
    for (size_t i = 0; i < n; i++) {
        y[n + i] = y0[n + i];
        y[i] = y0[i] + drift * y0[n + i];
    }
}

void dl_kick(size_t n, double kick, const double *restrict a, double *restrict v) {
    for (size_t i = 0; i < n; i++)
        v[i] += kick * a[i];
}

void dl_drift(size_t n, double drift, double *restrict q, const double *restrict v) {
    for (size_t i = 0; i < n; i++)
        q[i] += drift * v[i];
}

static void gain_speed(size_t n, double gain, double *restrict v) {
    for (size_t i = 0; i < n; i++)
        v[i] += gain;
}

static void fall(size_t n, double gain, double drift, double *restrict q, double *restrict v) {
    for (size_t i = 0; i < n; i++) {
        v[i] += gain;
        q[i] += drift * v[i];
    }
}

void dl_fall(const dl_model *model, double kick, double drift, double *restrict q,
             double *restrict v) {
    const size_t n = model->moving;
    for (size_t c = 0; c < (size_t)model->dimension; c++) {
        const double gain = kick * model->scene->gravity[c];
        if (gain == 0)
            dl_drift(n, drift, q + c * n, v + c * n);
        else if (drift == 0)
            gain_speed(n, gain, v + c * n);
        else
            fall(n, gain, drift, q + c * n, v + c * n);
    }
}
