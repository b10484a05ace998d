/* The experiments behind the speeds of TR299's Table IV. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/observe.h"
#include "driftlab/run.h"
#include "study/paper_quantity.h"

typedef struct watch {
    const dl_scene *scene;
    double link;  /* beyond this nothing holds the particle */
    bool liquid;  /* which of the two criteria */
    bool turned;  /* it has moved downwards */
    bool reached; /* the criterion is met */
} watch;

static double distance(const watch *w, const double *y_all, size_t i, size_t j) {
    const size_t n = w->scene->particles;
    return hypot(y_all[i] - y_all[j], y_all[n + i] - y_all[n + j]);
}

static dl_status look(void *context, const dl_sample *sample, dl_error *error) {
    watch *w = context;
    const size_t n = w->scene->particles;
    const double *y = sample->y_all;
    bool met = true;
    (void)error;
    if (w->liquid) {
        w->turned = w->turned || y[3 * n] < 0;
        met = !w->turned && distance(w, y, 0, 3) > distance(w, y, 1, 2);
    }
    for (size_t j = 1; !w->liquid && j < n; j++)
        met = met && distance(w, y, 0, j) > w->link;
    w->reached = w->reached || met;
    return DL_OK;
}

/* Whether the first particle meets the criterion with its velocity `factor` times the scene's. */
static dl_status attempt(const dl_scene *scene, watch *w, double factor, dl_error *error) {
    const size_t n = scene->particles, half = (size_t)scene->dimension * n;
    const dl_method_row *method = NULL;
    void *options = NULL;
    dl_scene *changed = NULL;
    dl_run_options how;
    dl_run_summary summary;
    double *y_all = malloc(2 * half * sizeof *y_all);
    if (!y_all)
        return dl_fail_memory(error, "a state of every particle");
    memcpy(y_all, scene->position, half * sizeof *y_all);
    memcpy(y_all + half, scene->velocity, half * sizeof *y_all);
    for (size_t c = 0; c < (size_t)scene->dimension; c++)
        y_all[half + c * n] *= factor;
    w->turned = w->reached = false;
    dl_run_options_default(&how);
    how.sample = scene->step; /* a turn between two samples would not be seen */
    how.on_sample = look;
    how.context = w;
    dl_status status = dl_scene_restart(scene, y_all, &changed, error);
    if (!status)
        status = dl_method_find("leapfrog", &method, error);
    if (!status)
        status = dl_method_options_create(method, changed, &options, error);
    if (!status)
        status = dl_run(changed, method, options, &how, &summary, NULL, error);
    if (!status && summary.status)
        status = dl_fail(error, summary.status, "%s", summary.message);
    if (method)
        dl_method_options_free(method, options);
    dl_scene_free(changed);
    free(y_all);
    return status;
}

static dl_status find_speed(const dl_scene *scene, bool liquid, double *speed, dl_error *error) {
    static const double precision = 1e-4, most = 4;
    watch w = {.scene = scene, .link = dl_escape_link(scene), .liquid = liquid};
    const double start = hypot(scene->velocity[0], scene->velocity[scene->particles]);
    double low = 0, high = 0.25;
    if (scene->particles < (liquid ? 4u : 2u) || scene->dimension != 2 || !(start > 0))
        return dl_fail(error, DL_INPUT,
                       "found no experiment of Table IV, expected 3 or 4 particles in 2 "
                       "dimensions of which the first moves");
    /* The first bracket from below: at high speeds a criterion may fail again. */
    for (;;) {
        const dl_status status = attempt(scene, &w, high, error);
        if (status || w.reached) {
            if (status)
                return status;
            break;
        }
        low = high;
        high += 0.05;
        if (high > most)
            return dl_fail(error, DL_INPUT, "no speed up to %.4g times the scene's will do", most);
    }
    while (high - low > precision * high) {
        const double middle = 0.5 * (low + high);
        const dl_status status = attempt(scene, &w, middle, error);
        if (status)
            return status;
        *(w.reached ? &high : &low) = middle;
    }
    *speed = high * start;
    return DL_OK;
}

dl_status dl_paper_gas_speed(const dl_scene *scene, double *speed, dl_error *error) {
    return find_speed(scene, false, speed, error);
}

dl_status dl_paper_liquid_speed(const dl_scene *scene, double *speed, dl_error *error) {
    return find_speed(scene, true, speed, error);
}
