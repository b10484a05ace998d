/* Pairs that cross a breakpoint where the force jumps: all of them are found, few others are looked
 * at, and the force of those that rest on it is found, too. */
#include "contract.h"
#include "fixture_periodic.h"

#include "force/law.h"
#include "model/near_jumps.h"

/* --- finding them ------------------------------------------------------------------------------
 */

/* Particles in a box, with unlike couplings and one pinned, whose law has two jumps. */
static dl_scene *crowd(int dimension, dl_kernel_choice kernel, bool periodic) {
    enum { particles = 60 };
    dl_scene *const scene = fixture_scene("crowd", dimension, particles);
    scene->law.pieces = 2;
    scene->law.piece[0] = (dl_piece){.until = 0.3, .terms = 1, .term = {{1, 2}}};
    scene->law.piece[1] = (dl_piece){.until = 0.45, .terms = 1, .term = {{-0.1, 3}}};
    for (unsigned i = 0; i < particles; i++) {
        double at[3], velocity[3];
        for (unsigned c = 0; c < 3; c++) {
            at[c] = fixture_noise(6 * i + 2 * c);
            velocity[c] = fixture_noise(6 * i + 2 * c + 1);
        }
        fixture_place(scene, i, at, velocity);
        scene->coupling[i] = 1 + i % 3;
    }
    scene->pinned[7] = !periodic;
    scene->kernel = kernel;
    if (periodic)
        fixture_periods(scene, dimension == 2 ? 3 : 5, 2);
    return scene;
}

typedef struct found {
    bool crosses[60][60];
    size_t looked_at;
} found;

static void note(const dl_model *model, const dl_pair *pair, void *context) {
    found *const all = context;
    const double low = sqrt(fmin(pair->s, pair->s1)), high = sqrt(fmax(pair->s, pair->s1));
    (void)model;
    all->looked_at++;
    for (int k = 0; k < pair->law->pieces; k++)
        all->crosses[pair->i][pair->j] |= low <= pair->law->until[k] && high >= pair->law->until[k];
}

/* In `steps` steps of length h, that of the pairs which the walk over all finds none is missed.
 * Returns which part of the candidate pairs was looked at. */
static double looked_at(dl_scene *scene, double h, int steps) {
    dl_model *model;
    dl_near_pairs *near;
    size_t of_all = 0, of_near = 0, crossings = 0;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    assert_int_equal(dl_near_pairs_create(model, &near, NULL), DL_OK);
    const size_t n = model->unknowns;
    double *const y = malloc(2 * n * sizeof *y), *const delta = malloc(n * sizeof *delta);
    assert_true(y && delta);
    dl_model_initial_state(model, y);
    for (int k = 0; k < steps; k++) {
        found all = {0}, by_near = {0};
        for (size_t u = 0; u < n; u++)
            delta[u] = h * y[n + u] * (1 + 0.5 * sin(k + (double)u));
        const double *const x = dl_model_places(model, y), *const d = dl_model_shifts(model, delta);
        assert_int_equal(dl_model_visit_pairs(model, x, d, note, &all, NULL), DL_OK);
        assert_int_equal(dl_near_pairs_visit(model, near, x, d, h, note, &by_near, NULL), DL_OK);
        assert_memory_equal(all.crosses, by_near.crosses, sizeof all.crosses);
        of_all += all.looked_at;
        of_near += by_near.looked_at;
        for (size_t p = 0; p < 3600; p++)
            crossings += all.crosses[p / 60][p % 60];
        for (size_t u = 0; u < n; u++)
            y[u] += delta[u];
    }
    assert_true(crossings > 50);
    free(y);
    free(delta);
    dl_near_pairs_free(near);
    dl_model_free(model);
    dl_scene_free(scene);
    return (double)of_near / (double)of_all;
}

static void no_crossing_is_missed(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int periodic = 0; periodic < 2; periodic++) {
            const double of_all =
                looked_at(crowd(dimension, DL_KERNEL_ALL_PAIRS, periodic), 1e-3, 400);
            print_message("%d dimensions: %.4f of the pairs looked at\n", dimension, of_all);
            assert_true(of_all < 0.05);
            looked_at(crowd(dimension, DL_KERNEL_NEIGHBOUR_LIST, periodic), 1e-3, 400);
            looked_at(crowd(dimension, DL_KERNEL_ALL_PAIRS, periodic), 0.05, 20);
        }
}

/* --- on a breakpoint ---------------------------------------------------------------------------
 */

static const double cutoff = 0.25, h = 1e-4;

/* Two particles that press on one another across the cutoff, in some direction, or three in a row.
 */
static dl_scene *pressed(unsigned seed, size_t particles, double off) {
    dl_scene *const scene = fixture_scene("pressed", 2, particles);
    fixture_law(scene, cutoff, 25, 2, 50, 4);
    for (size_t i = 0; i < particles; i++) {
        const double angle = 3 * fixture_noise(seed) + 0.5 * (double)i;
        const double r = i == 0 ? 0 : cutoff * (1 + off);
        const double *const x = scene->position;
        const double from[2] = {i ? x[i - 1] : 0, i ? x[particles + i - 1] : 0};
        const double at[3] = {from[0] + r * cos(angle), from[1] + r * sin(angle)};
        const double inwards = 0.2 * (1 - (double)i); /* what half of the jump can stop */
        fixture_place(
            scene, i, at,
            (double[3]){inwards * cos(angle) + 3 * fixture_noise(seed + 1),
                        inwards * sin(angle) + 3 * fixture_noise(seed + 2 + (unsigned)i)});
    }
    return scene;
}

/* What is left of the step's system after `iterations`, as a part of the displacement. */
static double left_after(int iterations, dl_mean mean, dl_scene *scene, double *force_off) {
    enum { most = 8 };
    dl_model *model;
    double y[2 * most], delta[most], image[most], a[most], residual = 0, size = 0;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    assert_int_equal(dl_model_set_mean(model, mean, NULL), DL_OK);
    dl_model_initial_state(model, y);
    const size_t n = model->unknowns;
    for (size_t u = 0; u < n; u++)
        delta[u] = h * y[n + u];
    assert_int_equal(dl_model_crossings_begin(model, y, delta, h, NULL), DL_OK);
    for (int k = 0; k < iterations; k++) {
        assert_int_equal(dl_model_discrete_acceleration(model, y, delta, a, NULL), DL_OK);
        for (size_t u = 0; u < n; u++)
            image[u] = h * y[n + u] + h * h / 2 * a[u];
        dl_model_crossings_settle(model, delta, image, a);
        residual = largest_difference(image, delta, n);
        memcpy(delta, image, sizeof delta);
    }
    for (size_t u = 0; u < n; u++)
        size = fmax(size, fabs(delta[u]));
    /* of two particles: the force across their mean separation */
    const double middle[2] = {2 * (y[0] - y[1]) + delta[0] - delta[1],
                              2 * (y[n / 2] - y[n / 2 + 1]) + delta[n / 2] - delta[n / 2 + 1]};
    *force_off = fabs(a[0] * middle[1] - a[n / 2] * middle[0]) / (1e4 * cutoff);
    dl_model_free(model);
    dl_scene_free(scene);
    return residual / size;
}

static void check_resting(dl_mean mean, size_t particles, unsigned seed) {
    const double off = (double)((int)(seed % 7) - 3) * 1e-16;
    const bool along_the_middle = mean == DL_MEAN_QUOTIENT && particles == 2;
    double across;
    const double left = left_after(12, mean, pressed(5 * seed, particles, off), &across);
    if (!(left < 1e-11) || (along_the_middle && !(across < 1e-12)))
        fail_msg("mean %d, %zu particles, seed %u: %g left, %g of the force across", (int)mean,
                 particles, seed, left, across);
}

static void pairs_that_rest_on_a_breakpoint_are_solved(void **state) {
    (void)state;
    for (dl_mean mean = DL_MEAN_QUOTIENT; mean < DL_MEAN_MIDPOINT; mean++)
        for (size_t particles = 2; particles <= 3; particles++)
            for (unsigned seed = 0; seed < 300; seed++)
                check_resting(mean, particles, seed);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_crossing_is_missed),
        cmocka_unit_test(pairs_that_rest_on_a_breakpoint_are_solved),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
