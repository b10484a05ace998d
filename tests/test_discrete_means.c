/* The mean accelerations of the conserving scheme and its relatives, on scenes that have everything
 * at once: hard breakpoints, species, powers that are no whole numbers, pins, walls, two and three
 * dimensions. */
#include "contract.h"
#include "fixture_runs.h"
#include "model/near_jumps.h"

static const struct {
    dl_mean mean;
    const char *row;
    bool does_the_work; /* V(q0) - V(q1), exactly */
} means[] = {
    {DL_MEAN_QUOTIENT, "conserving", true},
    {DL_MEAN_GONZALEZ, "conserving-gonzalez", true},
    {DL_MEAN_AVERAGE, "conserving-average-vector-field", true},
    {DL_MEAN_MIDPOINT, "implicit-midpoint", false},
};

enum { mean_count = sizeof means / sizeof *means, side = 3 };

static dl_pair_law two_pieces(double c, double low, double high, double switched, double until) {
    return (dl_pair_law){
        .pieces = 2,
        .piece = {{.until = switched, .terms = 2, .term = {{-c, low}, {c, high}}},
                  {.until = until, .terms = 1, .term = {{-c / 2, low}}}},
    };
}

/* Two species on a disturbed lattice of spacing 1; every law has two jumps and its own powers. */
static dl_scene *mixture(int dimension) {
    const size_t n = dimension == 2 ? side * side : side * side * side;
    dl_scene *const scene = fixture_scene("mixture", dimension, n);
    scene->species = 2;
    scene->species_name = calloc(2, sizeof *scene->species_name);
    scene->species_law = calloc(4, sizeof *scene->species_law);
    scene->species_of = calloc(n, sizeof *scene->species_of);
    assert_true(scene->species_name && scene->species_law && scene->species_of);
    scene->species_name[0] = fixture_text("A");
    scene->species_name[1] = fixture_text("B");
    scene->species_law[0] = two_pieces(1, 2.5, 5.3, 1.08, 1.6);
    scene->species_law[1] = scene->species_law[2] = two_pieces(1.5, 3, 6, 1.02, 1.45);
    scene->species_law[3] = two_pieces(0.7, 1.7, 4.4, 1.13, 1.7);
    for (unsigned i = 0; i < n; i++) {
        const unsigned place[3] = {i % side, i / side % side, i / side / side};
        double at[3], velocity[3];
        for (unsigned c = 0; c < 3; c++) {
            at[c] = place[c] + 0.1 * fixture_noise(6 * i + c);
            velocity[c] = 0.6 * fixture_noise(6 * i + 3 + c);
        }
        fixture_place(scene, i, at, velocity);
        scene->species_of[i] = i % 3 == 1;
        scene->inertia[i] = 1 + 0.5 * (i % 2);
    }
    scene->pinned[0] = scene->pinned[n - 1] = true;
    scene->gravity[1] = -0.3;
    scene->step = 0.02;
    scene->end = 6;
    return scene;
}

static void end_all(dl_scene *scene, dl_piece_end end) {
    for (int k = 0; k < 8; k++)
        scene->species_law[k / 2].piece[k % 2].end = end;
    for (int k = 0; k < 8 && end == DL_END_TAPER; k++)
        scene->species_law[k / 2].piece[k % 2].width = 0.1;
}

typedef struct subject {
    dl_scene *scene;
    dl_model *model;
    size_t n;
    double *y, *delta; /* [2 n], [n] */
    double *a, *b;     /* [n]: scratch */
} subject;

static subject open_subject(int dimension, dl_mean mean, dl_piece_end end) {
    subject s = {.scene = mixture(dimension)};
    end_all(s.scene, end);
    assert_int_equal(dl_model_create(s.scene, &s.model, NULL), DL_OK);
    assert_int_equal(dl_model_set_mean(s.model, mean, NULL), DL_OK);
    s.n = s.model->unknowns;
    s.y = calloc(2 * s.n, sizeof *s.y);
    s.delta = calloc(s.n, sizeof *s.delta);
    s.a = calloc(s.n, sizeof *s.a);
    s.b = calloc(s.n, sizeof *s.b);
    assert_true(s.y && s.delta && s.a && s.b);
    dl_model_initial_state(s.model, s.y);
    for (size_t u = 0; u < s.n; u++)
        s.delta[u] = 0.15 * fixture_noise(1000 + (unsigned)u);
    return s;
}

static void close_subject(subject *s) {
    free(s->y);
    free(s->delta);
    free(s->a);
    free(s->b);
    dl_model_free(s->model);
    dl_scene_free(s->scene);
}

static void accelerate(subject *s, double *a) {
    assert_int_equal(dl_model_discrete_acceleration(s->model, s->y, s->delta, a, NULL), DL_OK);
}

static double potential(const subject *s) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(s->model, s->y, &energy, NULL), DL_OK);
    return energy.pair + energy.gravity;
}

/* The work of the mean over the displacement, and the potential's change: what is between them. */
static double work_missing(subject *s) {
    double work = 0;
    accelerate(s, s->a);
    work = dl_model_work(s->model, s->a, s->delta);
    const double before = potential(s);
    for (size_t u = 0; u < s->n; u++)
        s->y[u] += s->delta[u];
    return fabs(work + potential(s) - before);
}

static void means_do_the_work_of_the_potential(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (size_t m = 0; m < mean_count; m++) {
            subject s = open_subject(dimension, means[m].mean, DL_END_HARD);
            const double missing = work_missing(&s);
            print_message("%s, %d dimensions: %.1e of the work is missing\n", means[m].row,
                          dimension, missing);
            assert_true(means[m].does_the_work ? missing < 1e-13 : missing > 1e-3);
            close_subject(&s);
        }
}

/* The largest difference between the prepared product and differences of the mean, over some
 * columns. */
static double product_off(subject *s) {
    double *const unit = calloc(s->n + 1, sizeof *unit);
    double *const column = calloc(s->n + 1, sizeof *column);
    double most = 0;
    assert_true(unit && column);
    assert_int_equal(dl_model_discrete_product_prepare(s->model, s->y, s->delta, NULL), DL_OK);
    for (size_t u = 0; u < s->n; u += 5) {
        const double d = 1e-6, at = s->delta[u];
        s->delta[u] = at + d;
        accelerate(s, s->a);
        s->delta[u] = at - d;
        accelerate(s, s->b);
        s->delta[u] = at;
        unit[u] = 1;
        dl_model_discrete_product(s->model, unit, column);
        unit[u] = 0;
        for (size_t k = 0; k < s->n; k++)
            s->a[k] = (s->a[k] - s->b[k]) / (2 * d);
        most = fmax(most, largest_difference(s->a, column, s->n));
    }
    dl_model_discrete_product_forget(s->model);
    free(unit);
    free(column);
    return most;
}

/* Gonzalez' is nearly that where pairs pass a jump, the more the shorter the step is. */
static void products_are_the_derivatives(void **state) {
    (void)state;
    for (dl_piece_end end = DL_END_HARD; end <= DL_END_TAPER; end++)
        for (size_t m = 0; m < mean_count; m++) {
            subject s = open_subject(3, means[m].mean, end);
            const bool nearly = means[m].mean == DL_MEAN_GONZALEZ && dl_model_any_jumps(s.model);
            for (size_t u = 0; u < s.n && nearly; u++)
                s.delta[u] /= 10;
            const double off = product_off(&s);
            print_message("%s: a product is off by %.1e\n", means[m].row, off);
            if (!(off < (nearly ? 2e-2 : 1e-6)))
                fail_msg("%s: a product is off by %g", means[m].row, off);
            close_subject(&s);
        }
}

/* --- runs --------------------------------------------------------------------------------------
 */

static dl_run_summary run_walled(const char *method, int dimension, dl_piece_end end) {
    dl_scene *const scene = mixture(dimension);
    end_all(scene, end);
    scene->walls.present = true;
    scene->walls.damping = 0.1;
    for (int c = 0; c < dimension && c < 3; c++) {
        scene->walls.low[c] = -0.4;
        scene->walls.high[c] = side - 0.6;
    }
    const dl_run_options how = run_options(0, scene->step);
    finished run = run_with(scene, method_of(method), "", &how);
    if (run.summary.status)
        fail_msg("%s: %s", method, run.summary.message);
    assert_true(run.summary.wall_hits > 5);
    free(run.y);
    dl_scene_free(scene);
    return run.summary;
}

static double walled_error(const char *method, int dimension, dl_piece_end end) {
    const dl_run_summary s = run_walled(method, dimension, end);
    const double error = s.energy_error_max / s.energy_scale;
    print_message("%s, %d dimensions: %lu hits, energy error %.1e of the scale\n", method,
                  dimension, s.wall_hits, error);
    return error;
}

static void energy_stays_through_everything(void **state) {
    (void)state;
    static const char *const names[] = {
        "conserving",
        "conserving-fixed-point",
        "conserving-newton-dense",
        "conserving-newton-klu",
        "conserving-picard",
        "conserving-newton-krylov",
        "conserving-4-suzuki",
        "conserving-gonzalez",
        "conserving-average-vector-field",
    };
    for (int dimension = 2; dimension <= 3; dimension++)
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            assert_true(walled_error(names[k], dimension, DL_END_HARD) <= 1e-13);
}

/* Where no force jumps: at a hard breakpoint its step may have no solution. */
static void the_control_does_not_keep_it(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        assert_true(walled_error("implicit-midpoint", dimension, DL_END_SHIFTED_FORCE) > 1e-6);
}

/* Two particles at rest, `apart`, that push each other with 1/r^2 up to 1: with a step h the force
 * puts them h^2/2 F farther apart in the middle. One step. */
static dl_status step_of_pair(const char *method, double apart, double h, bool located,
                              dl_error *error) {
    dl_scene *const scene = fixture_scene("pair", 2, 2);
    scene->law = (dl_pair_law){
        .pieces = 1,
        .piece = {{.until = 1, .terms = 1, .term = {{1, 2}}, .located = located}},
    };
    fixture_place(scene, 1, (double[3]){apart, 0}, (double[3]){0, 0});
    scene->step = scene->end = h;
    const dl_run_options how = run_options(0, 0);
    void *const options = options_of(method_of(method), scene, "");
    dl_run_summary summary;
    assert_int_equal(dl_run(scene, method_of(method), options, &how, &summary, NULL, error), DL_OK);
    snprintf(error->message, sizeof error->message, "%s", summary.message);
    dl_method_options_free(method_of(method), options);
    dl_scene_free(scene);
    return summary.status;
}

/* With either force the middle is on the other's side, if the step is as short as it may. */
static void a_middle_in_the_gap_is_said(void **state) {
    (void)state;
    static const struct {
        double h, apart;
        const char *inside, *outside;
    } gaps[] = {{0.1, 0.9975, " 1.0025 ", " 0.9975 "}, {1e-3, 0.99999975, " 1.00000025 ", NULL}};
    for (size_t k = 0; k < sizeof gaps / sizeof *gaps; k++) {
        dl_error error = {""};
        const double h = gaps[k].h, apart = gaps[k].apart;
        assert_int_equal(step_of_pair("implicit-midpoint", apart, h, false, &error),
                         DL_NONLINEAR_FAILURE);
        if (!strstr(error.message, "particles 0 and 1") || !strstr(error.message, gaps[k].inside) ||
            (gaps[k].outside && !strstr(error.message, gaps[k].outside)))
            fail_msg("\"%s\"", error.message);
        /* farther in, or out, there is a solution; and for other means, or where it stops */
        assert_int_equal(step_of_pair("implicit-midpoint", 1 - h * h, h, false, &error), DL_OK);
        assert_int_equal(step_of_pair("implicit-midpoint", 1 + h * h, h, false, &error), DL_OK);
        assert_int_equal(step_of_pair("implicit-midpoint", apart, h, true, &error), DL_OK);
        assert_int_equal(step_of_pair("conserving-fixed-point", apart, h, false, &error), DL_OK);
        assert_int_equal(step_of_pair("conserving-gonzalez", apart, h, false, &error), DL_OK);
    }
}

/* TR323's fluid in the small settles: pairs come to rest on the breakpoint. */
static void the_energy_stays_where_pairs_rest_on_a_breakpoint(void **state) {
    (void)state;
    for (size_t m = 0; m < mean_count; m++) {
        if (!means[m].does_the_work)
            continue;
        dl_scene *const scene = fixture_box();
        const dl_run_options how = run_options(0, scene->step);
        finished run = run_with(scene, method_of(means[m].row), "", &how);
        const double error = run.summary.energy_error_max / run.summary.energy_scale;
        print_message("%s: energy error %.1e of the scale %s\n", means[m].row, error,
                      run.summary.message);
        assert_true(run.summary.status == DL_OK && error <= 1e-13);
        free(run.y);
        dl_scene_free(scene);
    }
}

/* What the flag for both momenta does not say of these two: the linear one stays, the angular not.
 */
static void two_keep_the_linear_momentum_alone(void **state) {
    (void)state;
    static const char *const names[] = {"conserving-gonzalez", "conserving-average-vector-field"};
    for (size_t k = 0; k < 2; k++) {
        dl_scene *const scene = fixture_stream(50);
        const dl_run_options how = run_options(0, 0.02);
        finished run = run_with(scene, method_of(names[k]), "", &how);
        const dl_run_summary *const s = &run.summary;
        assert_int_equal(s->status, DL_OK);
        print_message("%s: momentum %.1e, angular momentum %.1e\n", names[k],
                      s->momentum_error_max / s->momentum_scale,
                      s->angular_momentum_error_max / s->angular_momentum_scale);
        assert_true(s->momentum_error_max <= 1e-14 * s->momentum_scale);
        assert_true(s->angular_momentum_error_max > 1e-10 * s->angular_momentum_scale);
        free(run.y);
        dl_scene_free(scene);
    }
}

/* Walls and gravity move the mass centre, and book what they do. */
static void the_linear_momentum_is_kept_where_the_centre_moves(void **state) {
    (void)state;
    static const char *const names[] = {"conserving-gonzalez", "conserving-average-vector-field"};
    dl_scene *const scene = read_scene(DL_STUDIES "/conserving/bounce.yaml");
    for (size_t k = 0; k < 2; k++) {
        const dl_run_options how = run_options(0.1, 0.01);
        finished run = run_with(scene, method_of(names[k]), "", &how);
        const dl_run_summary *const s = &run.summary;
        assert_int_equal(s->status, DL_OK);
        assert_true(s->wall_hits > 0);
        if (!(s->momentum_error_max <= 1e-13 * s->momentum_scale))
            fail_msg("%s: momentum %g of %g", names[k], s->momentum_error_max, s->momentum_scale);
        free(run.y);
    }
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(means_do_the_work_of_the_potential),
        cmocka_unit_test(products_are_the_derivatives),
        cmocka_unit_test(energy_stays_through_everything),
        cmocka_unit_test(the_control_does_not_keep_it),
        cmocka_unit_test(a_middle_in_the_gap_is_said),
        cmocka_unit_test(the_energy_stays_where_pairs_rest_on_a_breakpoint),
        cmocka_unit_test(two_keep_the_linear_momentum_alone),
        cmocka_unit_test(the_linear_momentum_is_kept_where_the_centre_moves),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
