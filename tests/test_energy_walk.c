/* What is left of the conserving scheme's energy error is roundoff: over many steps it grows as a
 * random walk does, and no faster. */
#include "contract.h"
#include "fixture_runs.h"

enum { runs = 10, samples = 240, every = 20 };

typedef struct walk {
    double error[samples + 1]; /* in units of the energy's scale, once the run is over */
    size_t count;
} walk;

static dl_status add_error(void *context, const dl_sample *sample, dl_error *error) {
    walk *const of = context;
    (void)error;
    assert_true(of->count <= samples);
    of->error[of->count++] = sample->energy_error;
    return DL_OK;
}

static walk walk_of(dl_scene *scene, const char *method, const char *setting) {
    walk of = {.count = 0};
    dl_run_options how = run_options(scene->step * every * samples, scene->step * every);
    how.on_sample = add_error;
    how.context = &of;
    finished run = run_with(scene, method_of(method), setting, &how);
    if (run.summary.status)
        fail_msg("%s: %s", method, run.summary.message);
    assert_int_equal(of.count, samples + 1);
    for (size_t k = 0; k < of.count; k++)
        of.error[k] /= run.summary.energy_scale;
    free(run.y);
    dl_scene_free(scene);
    return of;
}

/* By how much errors change within `lag` samples: RMS over all runs and starts. */
static double rms_after(const walk *walks, size_t lag) {
    double sum = 0;
    size_t count = 0;
    for (size_t r = 0; r < runs; r++)
        for (size_t k = 0; k + lag <= samples; k++, count++) {
            const double change = walks[r].error[k + lag] - walks[r].error[k];
            sum += change * change;
        }
    return sqrt(sum / (double)count);
}

/* Slope of the logarithm of that over the logarithm of the number of steps, up to a quarter
 * of a run. */
static double exponent(const walk *walks, const char *of_what) {
    double steps[4], error[4];
    for (size_t k = 0; k < 4; k++) {
        const size_t lag = (size_t)10 << k;
        steps[k] = (double)(lag * every);
        error[k] = rms_after(walks, lag);
    }
    const double slope = fitted_order(steps, error, 4);
    print_message("%s: energy error %.1e of the scale after %g steps, exponent %.2f\n", of_what,
                  error[3], steps[3], slope);
    return slope;
}

static dl_scene *stream(size_t run) {
    return fixture_stream(50 + 10 * (double)run);
}

/* The fluid jumps in its box, each time from other velocities. */
static dl_scene *bouncing(size_t run) {
    dl_scene *const scene = fixture_box();
    for (unsigned u = 0; u < 2 * scene->particles; u++)
        scene->velocity[u] = 10 * fixture_noise(100 * (unsigned)run + u);
    scene->walls.damping = 0.02;
    return scene;
}

static double exponent_of(dl_scene *(*make)(size_t run), const char *method, const char *setting) {
    walk walks[runs];
    char what[96];
    snprintf(what, sizeof what, "%s %s", method, setting);
    for (size_t r = 0; r < runs; r++)
        walks[r] = walk_of(make(r), method, setting);
    return exponent(walks, what);
}

static void the_error_walks_at_random(void **state) {
    (void)state;
    assert_true(exponent_of(stream, "conserving", "") <= 0.6);
    assert_true(exponent_of(bouncing, "conserving", "") <= 0.6);
}

/* The same measure sees the drift that a solver's loose tolerance leaves. */
static void a_loose_tolerance_drifts(void **state) {
    (void)state;
    assert_true(exponent_of(stream, "conserving-relaxed", "eps=1e-8") > 0.8);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_error_walks_at_random),
        cmocka_unit_test(a_loose_tolerance_drifts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
