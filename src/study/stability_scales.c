#include "study/stability_scales.h"

#include <math.h>
#include <stdlib.h>

#include "force/law.h"
#include "study/trial.h"

double dl_spectrum_omega(const dl_spectrum *spectrum) {
    return sqrt(fmax(0, spectrum->largest));
}

double dl_spectrum_growth(const dl_spectrum *spectrum) {
    /* motions without any force have 0, to roundoff */
    const bool known = -spectrum->smallest > 1e-9 * fabs(spectrum->largest);
    return known ? sqrt(-spectrum->smallest) : 0;
}

/* --- along a run ------------------------------------------------------------------------------ */

typedef struct viewer {
    dl_model *model;
    double *q; /* [unknowns] */
    dl_scales *scales;
    const dl_study_unit *unit;
} viewer;

/* Positions of the moving particles, in the model's order, and the largest speed. */
static double take_positions(const viewer *v, const double *y_all) {
    const dl_scene *const scene = v->model->scene;
    const size_t n = scene->particles, dimension = (size_t)scene->dimension;
    size_t moving = 0;
    double fastest = 0;
    for (size_t i = 0; i < n; i++) {
        double square = 0;
        for (size_t c = 0; c < dimension && !scene->pinned[i]; c++) {
            const double speed = y_all[(dimension + c) * n + i];
            v->q[c * v->model->moving + moving] = y_all[c * n + i];
            square += speed * speed;
        }
        moving += !scene->pinned[i];
        fastest = fmax(fastest, square);
    }
    return sqrt(fastest);
}

static dl_status look(void *context, const dl_sample *sample, dl_error *error) {
    const viewer *const v = context;
    dl_scales *const scales = v->scales;
    dl_spectrum now;
    scales->speed = fmax(scales->speed, take_positions(v, sample->y_all));
    const dl_status status = dl_spectrum_ends(v->model, v->q, &now, error);
    if (status)
        return status;
    scales->spectrum.largest = fmax(scales->spectrum.largest, now.largest);
    scales->spectrum.smallest = fmin(scales->spectrum.smallest, now.smallest);
    if (v->unit->progress)
        v->unit->progress(v->unit->context, "the fastest motion along a run");
    return DL_OK;
}

static dl_status viewer_create(const dl_scene *scene, viewer *v, dl_error *error) {
    const dl_status status = dl_model_create(scene, &v->model, error);
    if (status)
        return status;
    v->q = calloc(2 * v->model->unknowns, sizeof *v->q);
    return v->q ? DL_OK : dl_fail_memory(error, "a state");
}

static void viewer_release(viewer *v) {
    dl_model_free(v->model);
    free(v->q);
}

dl_status dl_scales_at_start(const dl_scene *scene, dl_spectrum *spectrum, dl_error *error) {
    viewer v = {.model = NULL};
    dl_status status = viewer_create(scene, &v, error);
    if (!status) {
        dl_model_initial_state(v.model, v.q);
        status = dl_spectrum_ends(v.model, v.q, spectrum, error);
    }
    viewer_release(&v);
    return status;
}

static dl_status run(viewer *v, double step, long looks, dl_error *error) {
    const dl_study_unit *const unit = v->unit;
    dl_run_options how;
    dl_run_summary summary;
    void *options;
    const double count = ceil(unit->end / step * (1 - 1e-12));
    dl_status status = dl_trial_options(unit, step, &options, error);
    if (status)
        return status;
    dl_run_options_default(&how);
    how.end = count * step;
    how.sample = ceil(count / (double)looks) * step;
    how.time_limit = unit->seconds;
    how.on_sample = look;
    how.context = v;
    status = unit->run(unit->scene, unit->row, options, &how, &summary, NULL, error);
    dl_method_options_free(unit->row, options);
    if (!status && summary.steps > 0)
        v->scales->evaluations = (double)(summary.force_evaluations + summary.jacobian_evaluations +
                                          summary.jacobian_vector_products) /
                                 (double)summary.steps;
    return status;
}

dl_status dl_scales_along(const dl_study_unit *unit, double step, long looks, dl_scales *scales,
                          dl_error *error) {
    viewer v = {.unit = unit, .scales = scales};
    *scales = (dl_scales){.spectrum = {INFINITY, -INFINITY}, .evaluations = NAN};
    dl_status status = viewer_create(unit->scene, &v, error);
    if (!status)
        status = run(&v, step, looks, error);
    viewer_release(&v);
    return status;
}

/* --- r0 --------------------------------------------------------------------------------------- */

/* The smallest distance at which F turns from repelling to attracting; NAN: none. */
static double equilibrium(const dl_law *law) {
    enum { tries = 2800 };
    for (int k = 0; k < tries; k++) { /* from 1e-6 to 1e6 */
        double low = 1e-6 * pow(1.01, k), high = 1.01 * low;
        if (!(dl_law_force_over_r(law, low * low) > 0 && dl_law_force_over_r(law, high * high) < 0))
            continue;
        for (int halving = 0; halving < 60; halving++) {
            const double middle = (low + high) / 2;
            *(dl_law_force_over_r(law, middle * middle) > 0 ? &low : &high) = middle;
        }
        return low;
    }
    return NAN;
}

double dl_scales_r0(const dl_scene *scene, const char **what) {
    const size_t laws = scene->species > 0 ? scene->species * scene->species : 1;
    const dl_pair_law *const source = scene->species > 0 ? scene->species_law : &scene->law;
    double r0 = NAN;
    *what = "";
    for (size_t k = 0; k < laws; k++) {
        dl_law law;
        dl_law_prepare(&source[k], &law);
        const double own = law.cut ? law.until[law.pieces - 1] : equilibrium(&law);
        if (own <= r0 || isnan(r0)) {
            r0 = own;
            *what = law.cut ? "the pair law's end" : "the distance of equilibrium";
        }
    }
    if (isnan(r0))
        *what = "";
    return r0;
}
