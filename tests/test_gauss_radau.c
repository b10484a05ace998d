/* The Gauss-Radau method at the end of double precision: orbits, encounters, its own interpolant,
 * and what is not smooth. */
#include "contract.h"

#include <float.h>

#include "methods/radau_step.h"

static const dl_method_row *gauss_radau(void) {
    const dl_method_row *row = NULL;
    assert_int_equal(dl_method_find("gauss-radau-15", &row, NULL), DL_OK);
    return row;
}

/* --- its quadrature -----------------------------------------------------------------------------
 */

/* Velocity and position at the end of a step of length 1 under a = s^degree. */
static void integrate_power(int degree, double *velocity, double *position) {
    dl_radau_tables tables;
    dl_radau_tables_set(&tables);
    dl_radau_step step;
    assert_int_equal(dl_radau_step_create(&step, &tables, 1, NULL), DL_OK);
    double node[dl_radau_terms + 1];
    step.h = 1;
    step.v[0] = 1;
    for (int i = 1; i <= dl_radau_terms; i++)
        dl_radau_place(&step, (double[1]){0}, i, &node[i]); /* q = s */
    step.v[0] = 0;
    for (int pass = 0; pass < 2; pass++)
        for (int i = 1; i <= dl_radau_terms; i++)
            dl_radau_correct(&step, i, (double[1]){pow(node[i], degree)});
    *velocity = (double)dl_radau_velocity_change(&step, 0);
    *position = (double)dl_radau_position_change(&step, 0, 0);
    dl_radau_step_free(&step);
}

/* What makes the order 15: powers to the 14th, and no more. */
static void nodes_integrate_powers(void **state) {
    (void)state;
    for (int degree = 1; degree <= 15; degree++) {
        double velocity, position;
        integrate_power(degree, &velocity, &position);
        const double off[2] = {fabs(velocity - 1.0 / (degree + 1)),
                               fabs(position - 1.0 / ((degree + 1) * (degree + 2)))};
        for (int k = 0; k < 2; k++)
            assert_true(degree + k < 15 ? off[k] < 1e-14 : off[k] > 1e-9);
    }
}

/* --- Kepler's problem ---------------------------------------------------------------------------
 */

typedef struct orbit {
    long double radius, rate, eccentricity; /* semi-major axis, 2 pi / period */
    long double at[2], velocity[2];         /* of the centre of mass, at the start */
} orbit;

static const long double share[2] = {-0.25L, 0.75L}, mass[2] = {0.75L, 0.25L};

/* Of fixture_kepler's state y as it is in double precision, begun at pericentre. */
static orbit orbit_of(const double y[8]) {
    const long double r = (long double)y[1] - (long double)y[0];
    const long double v = (long double)y[7] - (long double)y[6];
    orbit o = {.radius = 1 / (2 / r - v * v)};
    o.rate = sqrtl(1 / (o.radius * o.radius * o.radius));
    o.eccentricity = 1 - r / o.radius;
    for (int c = 0; c < 2; c++)
        for (int i = 0; i < 2; i++) {
            o.at[c] += mass[i] * (long double)y[2 * c + i];
            o.velocity[c] += mass[i] * (long double)y[4 + 2 * c + i];
        }
    return o;
}

static void state_on(const orbit *o, double t, double y[8]) {
    const long double turn = 2 * acosl(-1), e = o->eccentricity, b = sqrtl(1 - e * e);
    const long double mean = fmodl(o->rate * (long double)t, turn);
    long double low = 0, high = turn; /* of the eccentric anomaly */
    for (int i = 0; i < 80; i++) {
        const long double middle = (low + high) / 2;
        if (middle - e * sinl(middle) < mean)
            low = middle;
        else
            high = middle;
    }
    const long double rate = o->rate / (1 - e * cosl(low));
    const long double relative[4] = {o->radius * (cosl(low) - e), o->radius * b * sinl(low),
                                     -o->radius * rate * sinl(low),
                                     o->radius * b * rate * cosl(low)};
    for (int k = 0; k < 4; k++)
        for (int i = 0; i < 2; i++) {
            const long double centre =
                k < 2 ? o->at[k] + o->velocity[k] * (long double)t : o->velocity[k - 2];
            y[2 * k + i] = (double)(centre + share[i] * relative[k]);
        }
}

static long double energy_of(const double y[8]) {
    long double kinetic = 0;
    for (int i = 0; i < 2; i++)
        kinetic += mass[i] / 2 *
                   ((long double)y[4 + i] * (long double)y[4 + i] +
                    (long double)y[6 + i] * (long double)y[6 + i]);
    const long double dx = (long double)y[0] - (long double)y[1];
    const long double dy = (long double)y[2] - (long double)y[3];
    return kinetic - mass[0] * mass[1] / sqrtl(dx * dx + dy * dy);
}

static const double period = 6.283185307179586;

/* The largest position error on the way, by samples, in parts of the semi-major axis. */
static double orbit_error(const char *options, double eccentricity, double end, int samples) {
    rig r = rig_open(gauss_radau(), fixture_kepler(eccentricity), options);
    const orbit o = orbit_of(rig_state(&r));
    double error = 0, exact[8];
    for (int k = 1; k <= samples; k++) {
        rig_run(&r, end * k / samples);
        state_on(&o, r.method->t, exact);
        error = fmax(error, largest_difference(rig_state(&r), exact, 4));
    }
    rig_close(&r);
    return error;
}

static void has_order_fifteen(void **state) {
    (void)state;
    enum { runs = 4 };
    static const int steps[runs] = {3, 4, 5, 6};
    double step[runs], error[runs];
    for (int k = 0; k < runs; k++) {
        char options[32];
        step[k] = 2.0 / steps[k];
        snprintf(options, sizeof options, "step=%.17g", step[k]);
        error[k] = orbit_error(options, 0.3, 2, 1);
    }
    const double order = fitted_order(step, error, runs);
    print_message("errors %.2e ... %.2e, order %.2f\n", error[0], error[runs - 1], order);
    assert_true(fabs(order - 15) < 1.5);
}

/* A thousand orbits at e = 0.6: the energy within 1e-14, as roundoff alone would have it. */
static void energy_is_kept_to_roundoff(void **state) {
    (void)state;
    rig r = rig_open(gauss_radau(), fixture_kepler(0.6), "");
    const long double start = energy_of(rig_state(&r));
    double largest = 0;
    while (r.method->t < 1000 * period) {
        rig_step(&r, 1000 * period);
        largest = fmax(largest, fabs((double)((energy_of(rig_state(&r)) - start) / start)));
    }
    dl_method_stats stats;
    dl_method_stats_get(r.method, &stats);
    print_message("energy error %.2e of the energy in %lu steps, %lu forces\n", largest,
                  stats.steps, r.model->counts.force);
    assert_true(largest <= 1e-14);
    assert_true(stats.steps < 150000 && r.model->counts.force < 16 * stats.steps);
    rig_close(&r);
}

static void encounters_are_followed(void **state) {
    (void)state;
    static const struct {
        double eccentricity, orbits, allowed;
    } cases[] = {{0.6, 3.3, 2e-14}, {0.9, 3.3, 2e-13}, {0.99, 1.5, 1e-12}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const double e = cases[k].eccentricity;
        const double error = orbit_error("", e, cases[k].orbits * period, 33);
        const double end = orbit_error("", e, (floor(cases[k].orbits) + 0.5) * period, 1);
        print_message("e = %g: %.2e, at apocentre %.2e\n", e, error, end);
        assert_true(error <= cases[k].allowed && end <= 2e-13);
    }
}

/* --- seven bodies -------------------------------------------------------------------------------
 *
 * The Pleiades problem of E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential
 * Equations I, 2nd ed. (1993), doi:10.1007/978-3-540-78862-1, section II.10, whose bodies pass one
 * another closely; the solution at t = 3 is that of the Test Set for IVP Solvers (F. Mazzia,
 * C. Magherini, release 2.4, 2008). */

static dl_scene *pleiades(void) {
    static const double x[7] = {3, 3, -1, -3, 2, -2, 2}, y[7] = {3, -3, 2, 0, 0, -4, 4};
    static const double vx[7] = {0, 0, 0, 0, 0, 1.75, -1.5}, vy[7] = {0, 0, 0, -1.25, 1, 0, 0};
    dl_scene *scene = fixture_scene("pleiades", 2, 7);
    scene->law.pieces = 1;
    scene->law.piece[0] = (dl_piece){.until = INFINITY, .terms = 1, .term = {{-1, 2}}};
    for (size_t i = 0; i < 7; i++) {
        scene->inertia[i] = scene->coupling[i] = (double)(i + 1);
        fixture_place(scene, i, (double[3]){x[i], y[i]}, (double[3]){vx[i], vy[i]});
    }
    scene->end = 3;
    return scene;
}

static const double pleiades_at_3[14] = {
    0.3706139143970502,  3.237284092057233, -3.222559032418324,  0.6597091455775310,
    0.3425581707156584,  1.562172101400631, -0.7003092922212495, -3.943437585517392,
    -3.271380973972550,  5.225081843456543, -2.590612434977470,  1.198213693392275,
    -0.2429682344935824, 1.091449240428980,
};

/* Rounding of the forces alone, grown through the encounters, leaves some 1e-13. */
static void seven_bodies_arrive(void **state) {
    (void)state;
    static const char *const options[] = {"rtol=1e-12", "", "rtol=1e-6"};
    double best = INFINITY;
    for (size_t k = 0; k < 3; k++) {
        rig r = rig_open(gauss_radau(), pleiades(), options[k]);
        rig_run(&r, 3);
        double relative = 0;
        for (size_t i = 0; i < 14; i++)
            relative = fmax(relative, fabs(rig_state(&r)[i] / pleiades_at_3[i] - 1));
        print_message("%s: %.2e in %lu forces\n", options[k], relative, r.model->counts.force);
        assert_true(relative <= 1e-12);
        best = fmin(best, relative);
        rig_close(&r);
    }
    assert_true(best <= 2e-13);
}

/* --- within a step ------------------------------------------------------------------------------
 */

static void interpolant_is_as_good_as_the_steps(void **state) {
    (void)state;
    rig r = rig_open(gauss_radau(), fixture_kepler(0.6), "");
    const dl_method_ops *const ops = r.row->ops;
    const orbit o = orbit_of(rig_state(&r));
    double at[8], exact[8], around[2][8], error = 0, jump = 0;
    assert_int_equal(ops->dense_degree(r.method), 9);
    while (r.method->t < period) {
        const double t0 = r.method->t;
        double y0[8];
        memcpy(y0, r.method->y, sizeof y0);
        rig_step(&r, INFINITY);
        const double h = r.method->t - t0, d = h / 64;
        for (int k = 0; k <= 16; k++) {
            const double t = k < 16 ? t0 + h * k / 16 : r.method->t;
            assert_int_equal(ops->dense(r.method, t, 0, at, NULL), DL_OK);
            state_on(&o, t, exact);
            error = fmax(error, largest_difference(at, exact, 8));
        }
        jump = fmax(jump, largest_difference(at, r.method->y, 8));
        ops->dense(r.method, t0, 0, at, NULL);
        assert_memory_equal(at, y0, sizeof y0);
        for (int k = 0; k < 9; k++) {
            ops->dense(r.method, t0 + h / 2, k + 1, at, NULL);
            ops->dense(r.method, t0 + h / 2 - d, k, around[0], NULL);
            ops->dense(r.method, t0 + h / 2 + d, k, around[1], NULL);
            for (int i = 0; i < 8; i++) {
                const double quotient = (around[1][i] - around[0][i]) / (2 * d);
                const double size = fabs(at[i]) + fabs(around[0][i]) / h;
                assert_true(fabs(quotient - at[i]) < 1e-2 * size);
            }
        }
    }
    print_message("error within steps %.2e, at their ends %.2e\n", error, jump);
    assert_true(error < 1e-13 && jump < 4 * DBL_EPSILON);
    rig_close(&r);
}

static void short_samples_keep_the_step(void **state) {
    (void)state;
    rig r = rig_open(gauss_radau(), fixture_kepler(0.6), "");
    rig_run(&r, 1);
    dl_method_stats before, after;
    dl_method_stats_get(r.method, &before);
    for (int k = 1; k <= 10; k++)
        rig_run(&r, 1 + 1e-9 * k);
    rig_run(&r, 2);
    dl_method_stats_get(r.method, &after);
    assert_true(after.steps - before.steps < 50);
    assert_int_equal(after.rejected, before.rejected);
    rig_close(&r);
}

/* --- steps that are too long, or cannot be ------------------------------------------------------
 */

static void a_step_beyond_convergence_fails(void **state) {
    (void)state;
    rig r = rig_open(gauss_radau(), fixture_kepler(0.6), "step=6");
    double before[8];
    memcpy(before, rig_state(&r), sizeof before);
    dl_error error = {""};
    const dl_status status = dl_method_advance(r.method, INFINITY, &error);
    assert_int_equal(status, DL_NONLINEAR_FAILURE);
    assert_non_null(strstr(error.message, "gauss-radau-15"));
    assert_memory_equal(r.method->y, before, sizeof before);
    assert_true(r.method->t == 0);
    rig_close(&r);
}

static void an_epsilon_beyond_time_itself_fails(void **state) {
    (void)state;
    rig r = rig_open(gauss_radau(), fixture_kepler(0.6), "rtol=1e-300");
    dl_error error = {""};
    dl_status status = DL_OK;
    for (int k = 0; k < 1000 && !status; k++)
        status = dl_method_advance(r.method, 1, &error);
    assert_int_equal(status, DL_STEP_FAILURE);
    assert_non_null(strstr(error.message, "small"));
    rig_close(&r);
}

static unsigned long steps_to(dl_scene *scene, const char *options, double end, double *energy) {
    rig r = rig_open(gauss_radau(), scene, options);
    dl_energy start, now;
    double scale;
    assert_int_equal(dl_model_energy(r.model, rig_state(&r), &start, NULL), DL_OK);
    assert_int_equal(dl_model_energy_scale(r.model, rig_state(&r), &scale, NULL), DL_OK);
    rig_run(&r, end);
    assert_int_equal(dl_model_energy(r.model, rig_state(&r), &now, NULL), DL_OK);
    *energy = fabs(now.total - start.total) / scale;
    dl_method_stats stats;
    dl_method_stats_get(r.method, &stats);
    rig_close(&r);
    return stats.steps + stats.rejected;
}

/* An acceleration that passes through zero, as a pair's at its equilibrium distance, is no reason
 * for a short step. */
static void equilibrium_is_passed_at_full_step(void **state) {
    (void)state;
    double energy;
    const unsigned long steps = steps_to(fixture_oscillator(), "", 20, &energy);
    print_message("oscillator: %lu steps, energy error %.2e\n", steps, energy);
    assert_true(steps < 600 && energy < 1e-14);
}

/* Roundoff of positions far from the origin is not followed. */
static void far_away_is_like_here(void **state) {
    (void)state;
    double energy;
    const unsigned long here = steps_to(fixture_cluster(), "", 2, &energy);
    assert_true(energy < 1e-13);
    dl_scene *const scene = fixture_cluster();
    for (size_t i = 0; i < 39; i++)
        scene->position[i] += 1e4;
    const unsigned long there = steps_to(scene, "", 2, &energy);
    print_message("cluster: %lu steps, far away %lu, energy error %.2e\n", here, there, energy);
    assert_true(there < 2 * here && energy < 1e-11);
}

static void nothing_but_gravity_takes_few_steps(void **state) {
    (void)state;
    dl_scene *const scene = fixture_scene("thrown", 2, 1);
    scene->gravity[1] = -980;
    scene->feels_gravity[0] = true;
    fixture_place(scene, 0, (double[3]){0.3, 7}, (double[3]){3, 5});
    double energy;
    const unsigned long steps = steps_to(scene, "", 100, &energy);
    assert_true(steps < 40 && energy < 1e-14);
}

static dl_scene *crossing(double lag) {
    dl_scene *const scene = fixture_scene("crossing", 2, 2);
    fixture_law(scene, 0.25, 25, 2, 50, 4);
    fixture_place(scene, 0, (double[3]){-0.2 - lag, 0.01}, (double[3]){60, 0});
    fixture_place(scene, 1, (double[3]){0.2, 0}, (double[3]){-60, 0});
    return scene;
}

/* A force that jumps: the step goes down to the jump and up again, and the energy error is about
 * epsilon a jump. */
static void jumps_are_passed(void **state) {
    (void)state;
    static const double epsilon[] = {1e-6, 1e-9, 1e-12};
    for (int k = 0; k < 3; k++) {
        char options[32];
        snprintf(options, sizeof options, "rtol=%g", epsilon[k]);
        double energy;
        const unsigned long steps = steps_to(crossing(0), options, 0.02, &energy);
        print_message("%s: %lu steps, energy error %.2e\n", options, steps, energy);
        assert_true(energy < 30 * epsilon[k] && steps < 300);
    }
}

/* Wherever it lies in a step, behind the last node too. */
static void no_jump_is_overlooked(void **state) {
    (void)state;
    double worst = 0;
    for (int k = 0; k < 100; k++) {
        double energy;
        steps_to(crossing(0.0007 * k), "", 0.02, &energy);
        worst = fmax(worst, energy);
    }
    print_message("energy error %.2e\n", worst);
    assert_true(worst < 1e-8);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(nodes_integrate_powers),
        cmocka_unit_test(has_order_fifteen),
        cmocka_unit_test(energy_is_kept_to_roundoff),
        cmocka_unit_test(encounters_are_followed),
        cmocka_unit_test(seven_bodies_arrive),
        cmocka_unit_test(interpolant_is_as_good_as_the_steps),
        cmocka_unit_test(short_samples_keep_the_step),
        cmocka_unit_test(a_step_beyond_convergence_fails),
        cmocka_unit_test(an_epsilon_beyond_time_itself_fails),
        cmocka_unit_test(equilibrium_is_passed_at_full_step),
        cmocka_unit_test(far_away_is_like_here),
        cmocka_unit_test(nothing_but_gravity_takes_few_steps),
        cmocka_unit_test(jumps_are_passed),
        cmocka_unit_test(no_jump_is_overlooked),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
