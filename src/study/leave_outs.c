/* Time and memory of a scene's model beside those of models that leave out less. */
#include "driftlab/leave_outs.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#ifdef __GLIBC__
#include <malloc.h>
#endif

#include "driftlab/run.h"
#include "force/kernel.h"
#include "study/leave_outs.h"

/* Models alive at once while memory is measured: what the heap keeps back for itself is small
 * beside so many. */
enum { copies = 16 };
static const size_t checked_steps = 10, least_steps = 10;
/* A model that is slower than the scene's own takes fewer steps where as many would take longer
 * than this many times what was asked for. */
static const double most_slices = 8;

typedef struct variant {
    const char *what;
    dl_scene *scene;
    size_t steps, runs; /* of a measurement */
    double seconds[DL_MOST_COST_REPEATS], ratio[DL_MOST_COST_REPEATS];
} variant;

typedef struct comparison {
    size_t variants;
    variant variant[DL_MOST_LEAVE_OUTS];
    double *own, *other; /* states of all, in at most three dimensions */
    dl_leave_outs *result;
} comparison;

/* --- the models ------------------------------------------------------------------------------- */

static dl_kernel_choice choice_of(const dl_model *model) {
    static const struct {
        const dl_kernel_ops *ops;
        dl_kernel_choice choice;
    } kernels[] = {{&dl_kernel_reference, DL_KERNEL_REFERENCE},
                   {&dl_kernel_all_pairs, DL_KERNEL_ALL_PAIRS},
                   {&dl_kernel_neighbour_list, DL_KERNEL_NEIGHBOUR_LIST},
                   {&dl_kernel_tree, DL_KERNEL_TREE}};
    for (size_t k = 0; model->kernel && k < sizeof kernels / sizeof *kernels; k++)
        if (kernels[k].ops == model->kernel->ops)
            return kernels[k].choice;
    return DL_KERNEL_AUTO;
}

/* A copy of a scene, by the kernel that its model has. */
static dl_status add_variant(comparison *all, const dl_scene *like, const char *what,
                             dl_kernel_choice kernel, variant **added, dl_error *error) {
    variant *const made = *added = &all->variant[all->variants];
    made->what = what;
    const dl_status status = dl_scene_copy(like, &made->scene, error);
    if (status)
        return status;
    made->scene->kernel = kernel;
    all->variants++;
    return DL_OK;
}

/* Adds what the scene's model leaves out now: with pair forces come what they leave out. */
static dl_status add_if_absent(dl_scene *scene, dl_left_out what, dl_error *error) {
    dl_model *model = NULL;
    const dl_status status = dl_model_create(scene, &model, error);
    const bool add = !status && dl_can_add(what) && dl_leaves_out(model, what);
    dl_model_free(model);
    return add ? dl_scene_add_neutral(scene, what, error) : status;
}

static dl_status make_variants(comparison *all, const dl_scene *scene, const dl_model *model,
                               dl_error *error) {
    const dl_kernel_choice kernel = choice_of(model);
    variant *made;
    dl_status status = add_variant(all, scene, "nothing", kernel, &made, error);
    for (int k = 0; k < DL_LEFT_OUTS && !status; k++) {
        const dl_left_out what = (dl_left_out)k;
        if (!dl_can_add(what) || !dl_leaves_out(model, what))
            continue;
        status = add_variant(all, scene, dl_left_out_name(what), kernel, &made, error);
        if (!status)
            status = dl_scene_add_neutral(made->scene, what, error);
    }
    if (!status && model->kernel && kernel != DL_KERNEL_REFERENCE)
        status = add_variant(all, scene, "pairs without a fast kernel (reference)",
                             DL_KERNEL_REFERENCE, &made, error);
    if (!status)
        status = add_variant(all, scene, "everything", kernel, &made, error);
    for (int k = 0; k < DL_LEFT_OUTS && !status; k++)
        status = add_if_absent(made->scene, (dl_left_out)k, error);
    const dl_scene *const general = made->scene;
    if (!status)
        status = add_variant(all, general, "everything, reference kernel", DL_KERNEL_REFERENCE,
                             &made, error);
    return status;
}

/* --- time ------------------------------------------------------------------------------------- */

/* Leap-frog for so many steps of the scene; *seconds: of the integration. */
static dl_status integrate(const dl_scene *scene, size_t steps, double *seconds, double *y_final,
                           dl_error *error) {
    const dl_method_row *row = NULL;
    void *options = NULL;
    dl_run_summary summary = {.status = DL_OK};
    dl_run_options run;
    dl_run_options_default(&run);
    run.observe = false;
    run.end = run.sample = (double)steps * scene->step;
    dl_status status = dl_method_find("leapfrog", &row, error);
    if (!status)
        status = dl_method_options_create(row, scene, &options, error);
    if (!status)
        status = dl_run(scene, row, options, &run, &summary, y_final, error);
    if (options)
        dl_method_options_free(row, options);
    *seconds = summary.cpu_seconds;
    return !status && summary.status ? dl_fail(error, summary.status, "%s", summary.message)
                                     : status;
}

static size_t smaller(size_t a, size_t b) {
    return a < b ? a : b;
}

/* As many steps as take the time, but no more than the scene has; shorter runs again and again. */
static dl_status calibrate(variant *of, size_t most, double wanted, dl_error *error) {
    double seconds = 0;
    dl_status status = DL_OK;
    of->steps = smaller(least_steps, most);
    for (;;) {
        status = integrate(of->scene, of->steps, &seconds, NULL, error);
        if (status || seconds > wanted / 4 || of->steps == most)
            break;
        of->steps = smaller(2 * of->steps, most);
    }
    const double each = fmax(seconds, 1e-9) / (double)of->steps;
    if (!status && (double)of->steps * each < wanted)
        of->steps = smaller((size_t)(wanted / each) + 1, most);
    of->runs = (size_t)(wanted / (each * (double)of->steps)) + 1;
    return status;
}

/* The same steps as the scene's own, or fewer where these take too long. */
static dl_status calibrate_beside(variant *of, const variant *own, double wanted, dl_error *error) {
    double seconds = 0;
    size_t steps = smaller(least_steps, own->steps);
    dl_status status = integrate(of->scene, steps, &seconds, NULL, error);
    const double allowed = most_slices * wanted;
    const double each = fmax(seconds, 1e-9) / (double)steps;
    if ((double)own->steps * each > allowed) /* what a first step costs more is in `each` */
        steps = smaller(own->steps, (size_t)fmax((double)steps, allowed / each));
    else
        steps = own->steps;
    of->steps = steps;
    of->runs = smaller(own->runs, (size_t)(allowed / (each * (double)steps)) + 1);
    return status;
}

static dl_status measure(variant *of, size_t repeat, dl_error *error) {
    double total = 0;
    dl_status status = DL_OK;
    for (size_t k = 0; k < of->runs && !status; k++) {
        double seconds;
        status = integrate(of->scene, of->steps, &seconds, NULL, error);
        total += seconds;
    }
    of->seconds[repeat] = total / (double)(of->runs * of->steps);
    return status;
}

static dl_status measure_all(comparison *all, size_t repeats, double wanted, dl_error *error) {
    variant *const own = &all->variant[0];
    const size_t most = dl_whole_steps(own->scene->end, own->scene->step);
    dl_status status = calibrate(own, most ? most : least_steps, wanted, error);
    for (size_t k = 1; k < all->variants && !status; k++)
        status = calibrate_beside(&all->variant[k], own, wanted, error);
    for (size_t repeat = 0; repeat < repeats && !status; repeat++)
        for (size_t k = 0; k < all->variants && !status; k++) {
            variant *const of = &all->variant[k];
            status = measure(of, repeat, error);
            of->ratio[repeat] = of->seconds[repeat] / own->seconds[repeat];
        }
    return status;
}

/* --- memory ----------------------------------------------------------------------------------- */

static double heap_in_use(void) {
#ifdef __GLIBC__
    const struct mallinfo2 info = mallinfo2();
    return (double)info.uordblks + (double)info.hblkhd;
#else
    return NAN;
#endif
}

typedef struct working {
    dl_model *model;
    dl_method *method;
} working;

/* Model and method after a first step, when lists have been built. */
static dl_status work(const dl_scene *scene, const double *y, working *made, dl_error *error) {
    const dl_method_row *row = NULL;
    void *options = NULL;
    dl_status status = dl_model_create(scene, &made->model, error);
    if (!status)
        status = dl_method_find("leapfrog", &row, error);
    if (!status)
        status = dl_method_options_create(row, scene, &options, error);
    if (!status)
        status = dl_method_create(row, made->model, options, y, &made->method, error);
    if (!status)
        status = dl_method_advance(made->method, scene->step, error);
    if (options)
        dl_method_options_free(row, options);
    return status;
}

static dl_status weigh(const dl_scene *scene, double *bytes, dl_error *error) {
    working made[copies] = {{NULL, NULL}};
    dl_model *model = NULL;
    dl_status status = dl_model_create(scene, &model, error);
    if (status)
        return status;
    double *const y = malloc((2 * model->unknowns + 1) * sizeof *y);
    if (y)
        dl_model_initial_state(model, y);
    else
        status = dl_fail_memory(error, "a state");
    const double before = heap_in_use();
    for (size_t k = 0; k < copies && !status; k++)
        status = work(scene, y, &made[k], error);
    *bytes = (heap_in_use() - before) / copies;
    if (!(*bytes > 0)) /* a heap that does not tell, as a sanitizer's */
        *bytes = NAN;
    for (size_t k = 0; k < copies; k++) {
        dl_method_destroy(made[k].method);
        dl_model_free(made[k].model);
    }
    free(y);
    dl_model_free(model);
    return status;
}

/* --- physics ---------------------------------------------------------------------------------- */

/* Of positions after some steps, as a part of the largest coordinate. */
static dl_status differ(comparison *all, const variant *of, size_t steps, double *difference,
                        dl_error *error) {
    const dl_scene *const own = all->variant[0].scene;
    double seconds, extent = 0;
    const dl_status status = integrate(of->scene, steps, &seconds, all->other, error);
    *difference = 0;
    for (size_t k = 0; k < (size_t)own->dimension * own->particles; k++) {
        *difference = fmax(*difference, fabs(all->other[k] - all->own[k]));
        extent = fmax(extent, fabs(all->own[k]));
    }
    *difference /= extent > 0 ? extent : 1;
    return status;
}

static dl_status check_physics(comparison *all, dl_error *error) {
    const dl_scene *const own = all->variant[0].scene;
    const size_t most = dl_whole_steps(own->end, own->step);
    const size_t steps = all->result->checked = smaller(checked_steps, most ? most : 1);
    double seconds;
    dl_status status = integrate(own, steps, &seconds, all->own, error);
    for (size_t k = 0; k < all->variants && !status; k++)
        status = differ(all, &all->variant[k], steps, &all->result->row[k].difference, error);
    return status;
}

/* --- the whole -------------------------------------------------------------------------------- */

static int compare(const void *a, const void *b) {
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double middle(const double *sorted, size_t count) {
    return (sorted[(count - 1) / 2] + sorted[count / 2]) / 2;
}

static void tell(variant *of, size_t repeats, dl_leave_out_row *row) {
    qsort(of->seconds, repeats, sizeof *of->seconds, compare);
    qsort(of->ratio, repeats, sizeof *of->ratio, compare);
    row->what = of->what;
    row->seconds = middle(of->seconds, repeats);
    row->ratio = middle(of->ratio, repeats);
    row->ratio_low = of->ratio[0];
    row->ratio_high = of->ratio[repeats - 1];
}

static dl_status compare_all(comparison *all, size_t repeats, double seconds, dl_error *error) {
    dl_leave_outs *const result = all->result;
    dl_status status = check_physics(all, error);
    for (size_t k = 0; k < all->variants && !status; k++)
        status = weigh(all->variant[k].scene, &result->row[k].bytes, error);
    if (!status)
        status = measure_all(all, repeats, seconds, error);
    for (size_t k = 0; k < all->variants && !status; k++)
        tell(&all->variant[k], repeats, &result->row[k]);
    result->rows = all->variants;
    return status;
}

dl_status dl_leave_outs_measure(const dl_scene *scene, size_t repeats, double seconds,
                                dl_leave_outs *result, dl_error *error) {
    dl_model *model = NULL;
    dl_status status = dl_model_create(scene, &model, error);
    if (status)
        return status;
    *result = (dl_leave_outs){.particles = scene->particles, .repeats = repeats};
    snprintf(result->kernel, sizeof result->kernel, "%s",
             model->kernel ? model->kernel->ops->name : "none");
    comparison *const all = calloc(1, sizeof *all);
    double *const states = malloc(12 * scene->particles * sizeof *states);
    if (all && states) {
        all->result = result;
        all->own = states;
        all->other = states + 6 * scene->particles;
        status = make_variants(all, scene, model, error);
        if (!status)
            status = compare_all(all, repeats, seconds, error);
        for (size_t k = 0; k < all->variants; k++)
            dl_scene_free(all->variant[k].scene);
    } else
        status = dl_fail_memory(error, "models to compare");
    dl_model_free(model);
    free(states);
    free(all);
    return status;
}
