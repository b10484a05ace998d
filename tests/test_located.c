/* Walls by the rule `located`: hits and resting contacts, against exact solutions, for every
 * method. */
#include "contract.h"
#include "fixture_runs.h"
#include "fixture_scenes.h"

#include "driftlab/model.h"
#include "study/located.h"
#include "study/path.h"

/* But those that split the force, of which these scenes have only one part, and that of order 1,
 * which has a test of its own. */
#define FOR_EACH_METHOD(row)                                                                       \
    FOR_EACH_UNSPLIT_ROW(row)                                                                      \
    if (row->order != 1)

/* --- rigs --------------------------------------------------------------------------------------
 */

/* Unit inertia, no pair force, walls at 0 in x and y. */
static dl_scene *walled(const char *name, size_t particles, double damping) {
    dl_scene *scene = fixture_scene(name, 2, particles);
    scene->walls.present = true;
    scene->walls.low[0] = scene->walls.low[1] = 0;
    scene->walls.damping = damping;
    scene->walls.rule = DL_LOCATED;
    scene->walls.rest = 1e-9;
    for (size_t i = 0; i < particles; i++)
        scene->feels_gravity[i] = true;
    return scene;
}

/* Multistep methods follow even a parabola to their tolerance alone. */
static bool is_exact_on_parabolas(const dl_method_row *row) {
    return strcmp(row->family, "CVODE") != 0 && strncmp(row->name, "gsl-ms", 6) != 0;
}

/* A bound for a row that is exact on parabolas, or for one that is not. What extrapolates divides
 * roundoff by differences of step sizes. */
static double bound(const dl_method_row *row, double exact, double followed) {
    if (!is_exact_on_parabolas(row))
        return followed;
    return strcmp(row->name, "gsl-bsimp") == 0 ? 100 * exact : exact;
}

/* Of order 2, and one that chooses its step: 1e-10 would take for ever. */
static const char *close_tolerance(const dl_method_row *row) {
    return row->order == 2 ? "1e-8" : "1e-10";
}

/* Options with which an adaptive method follows a scene closely; a fixed one keeps the scene's
 * step. */
static void *closely_set(const dl_method_row *row, const dl_scene *scene) {
    void *options = options_of(row, scene, "");
    dl_error error = {""};
    if (row->flags & DL_ADAPTIVE && dl_parameter_find(row->options, "rtol") &&
        (dl_method_options_set(row, options, "rtol", close_tolerance(row), &error) ||
         (has_option(row, "atol") && dl_method_options_set(row, options, "atol", "1e-13", &error))))
        fail_msg("%s", error.message);
    return options;
}

typedef struct sampled {
    dl_run_summary summary;
    size_t length, samples;
    double *time, *y; /* [samples], [samples * length] */
} sampled;

static dl_status keep_sample(void *context, const dl_sample *sample, dl_error *error) {
    (void)error;
    sampled *const kept = context;
    kept->time = realloc(kept->time, (kept->samples + 1) * sizeof *kept->time);
    kept->y = realloc(kept->y, (kept->samples + 1) * kept->length * sizeof *kept->y);
    assert_true(kept->time && kept->y);
    kept->time[kept->samples] = sample->time;
    memcpy(kept->y + kept->samples * kept->length, sample->y_all, kept->length * sizeof *kept->y);
    kept->samples++;
    return DL_OK;
}

/* Runs to the end, a sample every `interval` (0: chosen). */
static sampled run_closely(const dl_scene *scene, const dl_method_row *row, double interval) {
    sampled kept = {.length = 2 * (size_t)scene->dimension * scene->particles};
    dl_run_options how = run_options(0, interval);
    how.on_sample = keep_sample;
    how.context = &kept;
    void *const options = closely_set(row, scene);
    dl_error error = {""};
    if (dl_run(scene, row, options, &how, &kept.summary, NULL, &error))
        fail_msg("%s on %s: %s", row->name, scene->name, error.message);
    if (kept.summary.status)
        fail_msg("%s on %s: %s", row->name, scene->name, kept.summary.message);
    dl_method_options_free(row, options);
    return kept;
}

static void release_samples(sampled *kept) {
    free(kept->time);
    free(kept->y);
}

static const double *last_state(const sampled *kept) {
    return kept->y + (kept->samples - 1) * kept->length;
}

/* --- paths -------------------------------------------------------------------------------------
 */

static void paths_are_the_polynomials_they_are_made_from(void **state) {
    (void)state;
    /* d(t) = (t - 1)^5 + 2 t^2 over [0, 2] */
    dl_path path;
    dl_path_hermite(&path, 2, (dl_path_end){-1, 5, -20 + 4}, (dl_path_end){1 + 8, 5 + 8, 20 + 4});
    for (double s = 0; s <= 1; s += 0.125) {
        const double t = 2 * s;
        assert_true(fabs(dl_path_value(&path, s) - (pow(t - 1, 5) + 2 * t * t)) < 1e-13);
    }
    /* exp(-t) as its Taylor polynomial of degree 12 about the end, t = 0.5, of a step of 0.5 */
    double derivative[13];
    for (int k = 0; k <= 12; k++)
        derivative[k] = (k % 2 ? -1 : 1) * exp(-0.5);
    dl_path_taylor(&path, 0.5, 12, derivative, (dl_path_end){1, -1, 1});
    for (double s = 0; s <= 1; s += 0.125)
        assert_true(fabs(dl_path_value(&path, s) - exp(-0.5 * s)) < 1e-14);
}

static dl_path parabola(double d, double rate, double curvature) {
    dl_path path;
    dl_path_hermite(&path, 1, (dl_path_end){d, rate, curvature},
                    (dl_path_end){d + rate + curvature / 2, rate + curvature, curvature});
    return path;
}

static void exits_are_found(void **state) {
    (void)state;
    static const double tiny = 1e-15;
    const struct {
        double d, rate, curvature, exit;
    } rows[] = {
        {1, -2, 0, 0.5},
        {0, 1, -4, 0.5},     /* from the wall and back; not at 0 */
        {0, 1e-9, -1, 2e-9}, /* a short flight */
        {0, -1, 0, 0},       /* at once */
        {0, 0, -1, 0},       /* at once */
        {0, 0, 1, INFINITY}, /* lifts off */
        {1e-17, 0, 0, INFINITY},
        {-1e-17, 1, 0, INFINITY},         /* roundoff outside, on its way in */
        {0.25 - 1e-8, -1, 2, 0.5 - 1e-4}, /* dips below and comes back */
        {0.25 + 1e-8, -1, 2, INFINITY},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const dl_path path = parabola(rows[k].d, rows[k].rate, rows[k].curvature);
        const double exit = dl_path_first_exit(&path, tiny);
        if (isinf(rows[k].exit) ? !isinf(exit) : !(fabs(exit - rows[k].exit) <= 1e-11))
            fail_msg("row %zu: exit %.17g, expected %.17g", k, exit, rows[k].exit);
    }
    /* (s - 1/4)(s - 1/2)(s - 3/4) and its negative, which begins outside */
    dl_path path = {3, {-3.0 / 32, 1.0 / 6 - 13.0 / 96, -5.0 / 96 + 1.0 / 48, 3.0 / 32}};
    for (int i = 0; i <= 3; i++)
        path.b[i] = -path.b[i];
    const double first = dl_path_first_exit(&path, tiny);
    assert_true(first > 0 && first < 1 && fabs(dl_path_value(&path, first)) < 1e-15);
    assert_true(dl_path_value(&path, first / 2) > 0);
}

/* --- a ball on the floor -----------------------------------------------------------------------
 */

static const double weight = 9.81;

typedef struct flight {
    double x, y, vx, vy;
} flight;

/* A ball dropped from height 1 with velocity vx: bounce k at time t_k begins a flight with e^k
 * times the velocities before; they end at t_1 (1 + e)/(1 - e). */
static flight dropped_ball(double vx, double e, double t, double last_flight) {
    const long double g = weight, t1 = sqrtl(2 / g);
    if (t <= t1)
        return (flight){(double)(vx * (long double)t), (double)(1 - g * t * t / 2), vx,
                        -(double)(g * t)};
    long double begin = t1, v = g * t1 * e, u = vx * (long double)e, x = vx * t1;
    while (2 * v / g > last_flight && begin + 2 * v / g < t) {
        x += u * 2 * v / g;
        begin += 2 * v / g;
        v *= e;
        u *= e;
    }
    if (2 * v / g <= last_flight)
        return (flight){(double)x, 0, 0, 0};
    const long double s = t - begin;
    return (flight){(double)(x + u * s), (double)(v * s - g * s * s / 2), (double)u,
                    (double)(v - g * s)};
}

static dl_scene *ball(double damping, double vx) {
    dl_scene *scene = walled("ball", 1, damping);
    fixture_place(scene, 0, (double[3]){0.5, 1}, (double[3]){vx, 0});
    scene->gravity[1] = -weight;
    scene->step = 0.01;
    scene->end = 2;
    return scene;
}

/* Bounces until one is shorter than the scene's last flight. */
static unsigned long bounces(const dl_scene *scene) {
    const double e = 1 - scene->walls.damping;
    unsigned long count = 1;
    for (double lasts = 2 * sqrt(2 / weight) * e; lasts > scene->walls.rest * scene->step; count++)
        lasts *= e;
    return count;
}

static void check_ball(const dl_scene *scene, const dl_method_row *row, double e, double vx) {
    const bool exact = is_exact_on_parabolas(row);
    sampled run = run_closely(scene, row, 0.02);
    const double near = bound(row, 1e-12, 1e-6);
    for (size_t k = 0; k < run.samples; k++) {
        const double *const y = run.y + 4 * k;
        const flight expected = dropped_ball(vx, e, run.time[k], scene->walls.rest * scene->step);
        const double dx = fabs(y[0] - 0.5 - expected.x), dy = fabs(y[1] - expected.y);
        const double dv = fmax(fabs(y[2] - expected.vx), fabs(y[3] - expected.vy));
        if (dx > near || dy > near || dv > 100 * near)
            fail_msg("%s at t = %g: x off by %g, y by %g, v by %g", row->name, run.time[k], dx, dy,
                     dv);
    }
    const dl_run_summary *const s = &run.summary;
    const double lost = weight + vx * vx / 2, *const end = last_state(&run);
    assert_true(end[1] == 0 && end[2] == 0 && end[3] == 0);
    assert_int_equal(s->contacts, 1);
    assert_int_equal(s->releases, 0);
    /* Multistep methods follow the last flights to atol alone, and miss some. */
    if (exact)
        assert_int_equal(s->wall_hits, bounces(scene));
    else
        assert_in_range(s->wall_hits, (bounces(scene) + 1) / 2, bounces(scene));
    const double ledger_error = fabs(s->ledger - lost);
    if (s->energy_error_max > near * lost || ledger_error > near * lost)
        fail_msg("%s: energy error %g, ledger off by %g", row->name, s->energy_error_max,
                 ledger_error);
    assert_true(isnan(s->momentum_error_max)); /* the floor's steady force is not known */
    release_samples(&run);
}

static void dropped_balls_come_to_rest(void **state) {
    (void)state;
    static const double damping[] = {0.5, 0.9};
    for (size_t k = 0; k < 2; k++)
        FOR_EACH_METHOD(row) {
            dl_scene *const scene = ball(damping[k], 0.3);
            check_ball(scene, row, 1 - damping[k], 0.3);
            dl_scene_free(scene);
        }
}

/* Where no flight is the last by the scene, it is roundoff that ends them: every method, relaxed
 * iterations of any omega among them, can tell flights apart until then. */
static void without_a_last_flight_a_ball_rests_too(void **state) {
    (void)state;
    FOR_EACH_METHOD(row) {
        const bool relaxes = has_option(row, "omega");
        for (int k = 0; k < (relaxes ? 3 : 1); k++) {
            static const char *const settings[] = {"", "omega=0.7", "eps=1e-9"};
            dl_scene *const scene = ball(0.5, 0.3);
            scene->walls.rest = 0;
            const dl_run_options how = run_options(0, 0);
            finished run = run_with(scene, row, settings[k], &how);
            const dl_run_summary *const s = &run.summary;
            if (s->status)
                fail_msg("%s %s: %s", row->name, settings[k], s->message);
            assert_true(run.y[1] == 0 && run.y[2] == 0 && run.y[3] == 0);
            assert_int_equal(s->contacts, 1);
            /* 2^-48 of the first flight is roundoff of the time */
            assert_in_range(s->wall_hits, is_exact_on_parabolas(row) ? 40 : 15, 52);
            free(run.y);
            dl_scene_free(scene);
        }
    }
}

static void without_restitution_the_first_hit_is_the_last(void **state) {
    (void)state;
    FOR_EACH_METHOD(row) {
        dl_scene *const scene = ball(1, 0.3);
        check_ball(scene, row, 0, 0.3);
        dl_scene_free(scene);
    }
}

/* The method of order 1 rests in the end, too, and is wrong after a hit as its order has it. */
static void a_method_of_order_one_comes_to_rest(void **state) {
    (void)state;
    static const double at = 0.6; /* in the second flight */
    double off[2];
    for (int k = 0; k < 2; k++) {
        dl_scene *const scene = ball(0.5, 0.3);
        const dl_run_options how = run_options(0, 0), early = run_options(at, 0);
        const char *const setting = k ? "step=0.0005" : "step=0.001";
        finished flying = run_with(scene, method_of("gsl-rk1imp"), setting, &early);
        off[k] = fabs(flying.y[1] - dropped_ball(0.3, 0.5, at, 0).y);
        assert_int_equal(flying.summary.wall_hits, 1);
        finished rested = run_with(scene, method_of("gsl-rk1imp"), setting, &how);
        assert_true(rested.y[1] == 0 && rested.y[2] == 0 && rested.y[3] == 0);
        assert_int_equal(rested.summary.contacts, 1);
        free(flying.y);
        free(rested.y);
        dl_scene_free(scene);
    }
    if (!(fabs(log2(off[0] / off[1]) - 1) < 0.1))
        fail_msg("off by %g and %g: order %g", off[0], off[1], log2(off[0] / off[1]));
}

/* More than a hundred bounces back to the height it fell from. */
static void without_damping_a_ball_bounces_for_ever(void **state) {
    (void)state;
    FOR_EACH_METHOD(row) {
        dl_scene *const scene = ball(0, 0.3);
        scene->end = 100;
        sampled run = run_closely(scene, row, 0);
        const dl_run_summary *const s = &run.summary;
        assert_int_equal(s->wall_hits, 111); /* at sqrt(2/g) (2k - 1) */
        assert_int_equal(s->contacts, 0);
        const double *const y = last_state(&run), t1 = sqrt(2 / weight);
        const double phase = remainder(100 - t1, 2 * t1);
        const double into = phase < 0 ? phase + 2 * t1 : phase;
        const double dy = fabs(y[1] - (weight * t1 * into - weight * into * into / 2));
        if (!(fabs(y[0] - 0.5 - 30) < 1e-4) || !(dy < bound(row, 1e-10, 1e-4)) ||
            !(s->energy_error_max < bound(row, 1e-11, 1e-5)) ||
            !(fabs(s->ledger) < bound(row, 1e-11, 1e-5)))
            fail_msg("%s: x %.17g, y off by %g, energy by %g, ledger %g", row->name, y[0], dy,
                     s->energy_error_max, s->ledger);
        release_samples(&run);
        dl_scene_free(scene);
    }
}

/* --- contacts from the start -------------------------------------------------------------------
 */

/* One pressed to the floor, one pushed along it, one not pressed at all. */
static dl_scene *on_the_floor(double damping) {
    dl_scene *scene = walled("on-the-floor", 3, damping);
    for (size_t i = 0; i < 3; i++)
        fixture_place(scene, i, (double[3]){1 + (double)i}, (double[3]){i ? 0.5 : 0});
    scene->feels_gravity[2] = false;
    scene->gravity[1] = -weight;
    return scene;
}

static void what_is_pressed_to_a_wall_rests_or_slides(void **state) {
    (void)state;
    FOR_EACH_METHOD(row)
    for (int slides = 0; slides <= 1; slides++) {
        dl_scene *const scene = on_the_floor(slides ? 0 : 0.25);
        sampled run = run_closely(scene, row, 0);
        const double *const y = last_state(&run);
        const double expected[6] = {1, slides ? 2.5 : 2, 3.5, 0, 0, 0};
        for (size_t k = 0; k < 6; k++)
            if (!(fabs(y[k] - expected[k]) <= bound(row, 1e-12, 1e-12)))
                fail_msg("%s: coordinate %zu is %.17g, expected %g", row->name, k, y[k],
                         expected[k]);
        assert_int_equal(run.summary.contacts, 2);
        assert_int_equal(run.summary.wall_hits, 0);
        assert_true(fabs(run.summary.ledger - (slides ? 0 : 0.125)) < 1e-15);
        assert_true(run.summary.energy_error_max < 1e-12);
        release_samples(&run);
        dl_scene_free(scene);
    }
}

/* --- lifted by a passing body ------------------------------------------------------------------
 */

/* A body so inert that it flies straight on passes at height 1 from x = -3 with velocity 2. It
 * attracts the ball, at rest at the origin's floor, with 12/r^2. */
static const double pull = 12, passing = 2, begins = -3;

static dl_scene *lifted(void) {
    dl_scene *scene = walled("lifted", 2, 0.5);
    scene->walls.low[0] = -INFINITY;
    fixture_place(scene, 0, (double[3]){0, 0}, (double[3]){0, 0});
    fixture_place(scene, 1, (double[3]){begins, 1}, (double[3]){passing, 0});
    scene->inertia[1] = 1e18;
    scene->feels_gravity[1] = false;
    scene->gravity[1] = -weight;
    scene->law.pieces = 1;
    scene->law.piece[0].until = INFINITY;
    scene->law.piece[0].terms = 1;
    scene->law.piece[0].term[0] = (dl_term){.coefficient = -pull, .power = 2};
    scene->step = 1.0 / 512;
    scene->end = 1.5;
    return scene;
}

/* pull h/(h^2 + x^2)^(3/2) = g with h = 1 */
static double release_time(void) {
    const double x = -sqrt(cbrt(pull / weight * pull / weight) - 1);
    return (x - begins) / passing;
}

static void lift(double t, const double y[4], double rate[4]) {
    const double dx = begins + passing * t - y[0], dy = 1 - y[1];
    const double cube = pow(dx * dx + dy * dy, 1.5);
    rate[0] = y[2];
    rate[1] = y[3];
    rate[2] = pull * dx / cube;
    rate[3] = pull * dy / cube - weight;
}

/* The classical Runge-Kutta method with steps so short that nothing is left of its error. */
static void integrate_lift(double from, double to, double y[4]) {
    const int steps = 4000;
    const double h = (to - from) / steps;
    for (int i = 0; i < steps; i++) {
        double k[4][4], at[4];
        static const double part[4] = {0, 0.5, 0.5, 1}, share[4] = {1, 2, 2, 1};
        for (int stage = 0; stage < 4; stage++) {
            for (int c = 0; c < 4; c++)
                at[c] = y[c] + (stage ? part[stage] * h * k[stage - 1][c] : 0);
            lift(from + (i + part[stage]) * h, at, k[stage]);
        }
        for (int c = 0; c < 4; c++)
            for (int stage = 0; stage < 4; stage++)
                y[c] += h / 6 * share[stage] * k[stage][c];
    }
}

static void a_passing_body_lifts_what_rests(void **state) {
    (void)state;
    const double t_release = release_time();
    dl_scene *const scene = lifted();
    double expected[4] = {0};
    scene->end = 1.4375; /* just before the body is overhead */
    assert_true(t_release > 1 && t_release < scene->end);
    integrate_lift(t_release, scene->end, expected);
    assert_true(expected[1] > 1e-4);
    FOR_EACH_METHOD(row) {
        sampled run = run_closely(scene, row, scene->end / 16);
        for (size_t k = 0; k < run.samples && run.time[k] < t_release; k++)
            assert_true(run.y[8 * k] == 0 && run.y[8 * k + 2] == 0 && run.y[8 * k + 6] == 0);
        const double *const y = last_state(&run);
        const double off = fmax(fabs(y[0] - expected[0]), fabs(y[2] - expected[1]));
        print_message("%-28s off by %.2e\n", row->name, off);
        /* difference quotients of what rests are not those of what is lifted */
        const bool hops = strstr(row->name, "-diagonal") != NULL;
        const double near = row->order == 2 ? 4e-6 : row->order == 3 ? 1e-8 : hops ? 1e-7 : 1e-9;
        if (!(off <= near))
            fail_msg("%s: the ball is off by %g", row->name, off);
        assert_int_equal(run.summary.contacts, 1);
        assert_int_equal(run.summary.releases, 1);
        if (!hops)
            assert_int_equal(run.summary.wall_hits, 0);
        release_samples(&run);
    }
    dl_scene_free(scene);
}

/* Where a step ends at its events, its time is the release's. */
static void release_times_are_those_of_balance(void **state) {
    (void)state;
    dl_scene *const scene = lifted();
    FOR_EACH_METHOD(row) {
        void *const options = closely_set(row, scene);
        dl_model *model = NULL;
        dl_method *method = NULL;
        dl_located *located = NULL;
        dl_stopwatch watch = {0};
        double y[8];
        assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
        dl_model_initial_state(model, y);
        assert_int_equal(dl_method_create(row, model, options, y, &method, NULL), DL_OK);
        assert_int_equal(dl_located_create(method, NULL, &watch, &located, NULL), DL_OK);
        assert_int_equal(dl_located_restart(located, NULL), DL_OK);
        while (dl_located_counts_get(located).releases == 0 && method->t < scene->end)
            assert_int_equal(dl_located_step(located, scene->end, NULL), DL_OK);
        const double late = method->t - release_time();
        if (method->step > 0 ? late < 0 || late > method->step : fabs(late) > 1e-9)
            fail_msg("%s: released at %.17g, balance is at %.17g", row->name, method->t,
                     release_time());
        dl_located_free(located);
        dl_method_destroy(method);
        dl_model_free(model);
        dl_method_options_free(row, options);
    }
    dl_scene_free(scene);
}

/* It falls back when the body has gone, and rests again. */
static void what_was_lifted_comes_back_to_rest(void **state) {
    (void)state;
    dl_scene *const scene = lifted();
    scene->end = 8;
    scene->law.piece[0].term[0].coefficient = -10;
    static const char *const names[] = {"leapfrog",   "composition-4-suzuki",
                                        "arkode-erk", "cvode-adams",
                                        "gsl-rk8pd",  "conserving-fixed-point"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        sampled run = run_closely(scene, method_of(names[k]), scene->end);
        const double *const y = last_state(&run);
        assert_true(y[2] == 0 && y[4] == 0 && y[6] == 0);
        assert_true(run.summary.wall_hits > 3);
        assert_int_equal(run.summary.contacts, 2);
        assert_int_equal(run.summary.releases, 1);
        release_samples(&run);
    }
    dl_scene_free(scene);
}

/* The balance turns for 0.026 alone, in the middle of a step of 0.031: both ends are pressed. */
static void a_release_within_a_step_is_seen(void **state) {
    (void)state;
    dl_scene *const scene = lifted();
    scene->law.piece[0].term[0].coefficient = -9.82;
    scene->position[1] = -3.03125;
    scene->step = 0.03125;
    scene->end = 4;
    FOR_EACH_METHOD(row) {
        sampled run = run_closely(scene, row, 0);
        if (run.summary.releases != 1 || run.summary.contacts != 2)
            fail_msg("%s: %lu contacts, %lu releases", row->name, run.summary.contacts,
                     run.summary.releases);
        release_samples(&run);
    }
    dl_scene_free(scene);
}

static void what_is_held_has_no_acceleration(void **state) {
    (void)state;
    dl_scene *const scene = fixture_cluster();
    dl_model *model = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    const size_t n = model->unknowns;
    double *const y = malloc(2 * n * sizeof *y), *const u = malloc(n * sizeof *u),
                  *const free_a = malloc(n * sizeof *u), *const a = malloc(n * sizeof *u);
    bool *const held = calloc(n, sizeof *held);
    assert_true(y && u && free_a && a && held);
    dl_model_initial_state(model, y);
    for (size_t k = 0; k < n; k++) {
        u[k] = 1e-3 * fixture_noise((unsigned)k);
        held[k] = k % 5 == 1;
    }
    for (int what = 0; what < 3; what++) {
        for (int pass = 0; pass < 2; pass++) {
            double *const out = pass ? a : free_a;
            model->held = pass ? held : NULL;
            const dl_status status = what == 0 ? dl_model_acceleration(model, y, out, NULL)
                                     : what == 1
                                         ? dl_model_discrete_acceleration(model, y, u, out, NULL)
                                         : dl_model_jacobian_vector(model, y, u, out, NULL);
            assert_int_equal(status, DL_OK);
        }
        for (size_t k = 0; k < n; k++)
            assert_true(a[k] == (held[k] ? 0 : free_a[k]));
    }
    const dl_sparsity *pattern;
    assert_int_equal(dl_model_sparsity(model, y, NULL, &pattern, NULL), DL_OK);
    double *const values = malloc(pattern->nonzeros * sizeof *values);
    assert_non_null(values);
    assert_int_equal(dl_model_jacobian(model, y, values, NULL), DL_OK);
    size_t others = 0;
    for (size_t k = 0; k < pattern->nonzeros; k++) {
        assert_true(!held[pattern->row[k]] || values[k] == 0);
        others += values[k] != 0;
    }
    assert_true(others > 0);
    free(values);
    free(y);
    free(u);
    free(free_a);
    free(a);
    free(held);
    dl_model_free(model);
    dl_scene_free(scene);
}

/* Radiation sets what rests in motion; it slides, falls or hits from there. */
static void radiation_wakes_what_rests(void **state) {
    (void)state;
    static const char *const names[] = {"leapfrog", "composition-4-suzuki", "arkode-erk",
                                        "gsl-rk8pd", "conserving-fixed-point"};
    dl_scene *const scene = walled("radiated", 2, 0.5);
    fixture_place(scene, 0, (double[3]){1, 0}, (double[3]){0});
    fixture_place(scene, 1, (double[3]){3, 3}, (double[3]){1, 4});
    scene->gravity[1] = -weight;
    scene->radiation = (dl_radiation){.present = true,
                                      .period = 0.25,
                                      .factor_above = 0.5,
                                      .factor_below = 0.5,
                                      .frame = DL_FRAME_CENTRE};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        sampled run = run_closely(scene, method_of(names[k]), 0.25);
        assert_true(last_state(&run)[0] > 1.01);
        assert_true(run.summary.contacts >= 2 && run.summary.releases >= 1);
        if (!(run.summary.energy_error_max < 1e-12 * run.summary.energy_scale))
            fail_msg("%s: energy error %g", names[k], run.summary.energy_error_max);
        for (size_t i = 0; i < run.samples; i++)
            assert_true(run.y[8 * i + 2] >= 0 && run.y[8 * i + 3] >= 0);
        release_samples(&run);
    }
    dl_scene_free(scene);
}

/* --- grazing -----------------------------------------------------------------------------------
 */

/* y = (t - 0.35)^2 - depth, with steps that end at 0.3 and 0.4. */
static void a_dip_between_steps_is_a_hit(void **state) {
    (void)state;
    static const double depth[] = {1e-3, 1e-6, 1e-10, -1e-10, -1e-3};
    for (size_t k = 0; k < sizeof depth / sizeof *depth; k++)
        FOR_EACH_METHOD(row) {
            const bool exact = is_exact_on_parabolas(row), hits = depth[k] > 0;
            if (!exact && fabs(depth[k]) < 1e-6)
                continue; /* less than its error */
            dl_scene *const scene = walled("graze", 1, 0.25);
            scene->gravity[1] = 2;
            scene->step = 0.1;
            scene->end = 0.7;
            fixture_place(scene, 0, (double[3]){1, 0.35 * 0.35 - depth[k]}, (double[3]){0.1, -0.7});
            sampled run = run_closely(scene, row, 0);
            assert_int_equal(run.summary.wall_hits, hits ? 1 : 0);
            const double root = hits ? sqrt(depth[k]) : 0, after = 0.35 + root;
            const double y =
                hits ? 0.75 * 2 * root * after + after * after : 0.35 * 0.35 - depth[k];
            const double dy = fabs(last_state(&run)[1] - y);
            /* the hit's time is determined to a part roundoff/depth */
            const double near = bound(row, 1e-12 + 1e-14 / sqrt(fabs(depth[k])), 1e-5);
            if (!(dy <= near))
                fail_msg("%s, depth %g: y is off by %g", row->name, depth[k], dy);
            assert_true(run.summary.energy_error_max <= bound(row, 1e-13, 1e-7));
            release_samples(&run);
            dl_scene_free(scene);
        }
}

/* --- boxes -------------------------------------------------------------------------------------
 */

/* Free flight from hit to hit. Returns how many they are. */
static unsigned long fly(double damping, const double width[2], double end, long double at[2],
                         long double v[2]) {
    unsigned long hits = 0;
    for (long double t = 0;;) {
        long double wait[2];
        for (int c = 0; c < 2; c++)
            wait[c] = (v[c] > 0 ? width[c] - at[c] : -at[c]) / v[c];
        const int first = wait[1] < wait[0];
        const long double lasts = wait[first] < end - t ? wait[first] : end - t;
        for (int c = 0; c < 2; c++)
            at[c] += v[c] * lasts;
        t += lasts;
        if (t >= end)
            return hits;
        at[first] = v[first] > 0 ? width[first] : 0;
        hits++;
        for (int c = 0; c < 2; c++)
            v[c] *= c == first ? -(1 - (long double)damping) : 1 - (long double)damping;
    }
}

static void a_fast_particle_crosses_the_box_often_in_one_step(void **state) {
    (void)state;
    static const double damping[] = {0, 0.01}, width[2] = {1, 0.75};
    for (size_t k = 0; k < 2; k++)
        FOR_EACH_METHOD(row) {
            dl_scene *const scene = walled("fast", 1, damping[k]);
            for (int c = 0; c < 2; c++)
                scene->walls.high[c] = width[c];
            fixture_place(scene, 0, (double[3]){0.3, 0.2}, (double[3]){123.4, -77.7});
            scene->step = 0.125;
            scene->end = 1;
            long double at[2] = {0.3L, 0.2L}, v[2] = {123.4, -77.7};
            at[0] = scene->position[0];
            at[1] = scene->position[1];
            const unsigned long hits = fly(damping[k], width, 1, at, v);
            assert_true(hits > 90);
            sampled run = run_closely(scene, row, 0);
            const double *const y = last_state(&run);
            assert_int_equal(run.summary.wall_hits, hits);
            for (int c = 0; c < 2; c++) {
                const double off = (double)fabsl(y[c] - at[c]);
                if (!(off < 1e-11) || !(fabsl(y[2 + c] - v[c]) < 1e-10))
                    fail_msg("%s: coordinate %d is off by %g", row->name, c, off);
            }
            assert_true(run.summary.energy_error_max < 1e-13 * run.summary.energy_scale);
            assert_true(run.summary.momentum_error_max < 1e-12 * run.summary.momentum_scale);
            release_samples(&run);
            dl_scene_free(scene);
        }
}

/* Mirror: one reflection after the step for every wall that was crossed in it. */
static void mirrors_reflect_as_often_as_walls_were_crossed(void **state) {
    (void)state;
    dl_scene *const scene = walled("mirror", 1, 0);
    scene->walls.rule = DL_MIRROR;
    scene->walls.high[0] = 1;
    scene->walls.high[1] = 0.75;
    fixture_place(scene, 0, (double[3]){0.3, 0.2}, (double[3]){123.4, -77.7});
    scene->step = 0.125;
    scene->end = 1;
    const double width[2] = {1, 0.75};
    long double at[2] = {scene->position[0], scene->position[1]}, v[2] = {123.4, -77.7};
    const unsigned long hits = fly(0, width, 1, at, v);
    sampled run = run_closely(scene, method_of("leapfrog"), 0);
    assert_int_equal(run.summary.wall_hits, hits);
    for (int c = 0; c < 2; c++) {
        assert_true(fabsl(last_state(&run)[c] - at[c]) < 1e-11);
        assert_true(fabsl(last_state(&run)[2 + c] - v[c]) < 1e-12);
    }
    release_samples(&run);
    /* with damping: every crossing takes its part of both velocities */
    scene->walls.damping = 0.5;
    dl_model *model = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    double q[2] = {3.25, 0.5}, u[2] = {8, 16};
    assert_int_equal(dl_model_mirror(model, q, u), 3);
    assert_true(q[0] == 0.75 && q[1] == 0.5 && u[0] == -1 && u[1] == 2);
    q[0] = -2.25;
    assert_int_equal(dl_model_mirror(model, q, u), 3);
    assert_true(q[0] == 0.25 && u[0] == 0.125 && u[1] == 0.25);
    q[0] = -2.75;
    q[1] = INFINITY;
    assert_int_equal(dl_model_mirror(model, q, u), 4);
    assert_true(q[0] == 0.75);
    dl_model_free(model);
    dl_scene_free(scene);
}

static void a_corner_takes_from_both_velocities_twice(void **state) {
    (void)state;
    FOR_EACH_METHOD(row) {
        dl_scene *const scene = walled("corner", 2, 0.25);
        fixture_place(scene, 0, (double[3]){0.37, 0.37}, (double[3]){-1, -1});
        fixture_place(scene, 1, (double[3]){0.37, 2}, (double[3]){-1, 0}); /* at the same time */
        scene->end = 1;
        sampled run = run_closely(scene, row, 0);
        const double kept = 0.75 * 0.75, *const y = last_state(&run);
        assert_int_equal(run.summary.wall_hits, 3);
        assert_true(fabs(y[0] - kept * 0.63) < 1e-12 && fabs(y[2] - kept * 0.63) < 1e-12);
        assert_true(fabs(y[1] - 0.75 * 0.63) < 1e-12);
        assert_true(fabs(y[4] - kept) < 1e-12 && fabs(y[6] - kept) < 1e-12);
        release_samples(&run);
        dl_scene_free(scene);
    }
}

/* --- many hits with gravity and pair forces ----------------------------------------------------
 */

/* Nine soft particles under gravity in a small box; `number` changes where they begin. */
static dl_scene *crowd(double damping, unsigned number) {
    dl_scene *scene = walled("crowd", 9, damping);
    scene->walls.high[0] = scene->walls.high[1] = 3;
    fixture_law(scene, INFINITY, 0, 1, 1, 2);
    for (size_t i = 0; i < 9; i++) {
        const unsigned k = 4 * (unsigned)i + 100 * number;
        fixture_place(scene, i,
                      (double[3]){0.5 + (double)(i % 3) + 0.1 * fixture_noise(k),
                                  0.5 + (double)(i / 3) + 0.1 * fixture_noise(k + 1)},
                      (double[3]){2 * fixture_noise(k + 2), 2 * fixture_noise(k + 3)});
        scene->inertia[i] = 1 + 0.25 * (double)(i % 3);
    }
    scene->gravity[1] = -2;
    return scene;
}

static double slope(const double *step, const double *error, size_t points) {
    double mean_x = 0, mean_y = 0, xx = 0, xy = 0;
    for (size_t i = 0; i < points; i++) {
        mean_x += log(step[i]) / (double)points;
        mean_y += log(error[i]) / (double)points;
    }
    for (size_t i = 0; i < points; i++) {
        const double x = log(step[i]) - mean_x;
        xx += x * x;
        xy += x * (log(error[i]) - mean_y);
    }
    return xy / xx;
}

static finished run_crowd(const dl_scene *scene, const char *method, double step, double end) {
    char setting[40];
    snprintf(setting, sizeof setting, "step=%.17g", step);
    const dl_run_options how = run_options(end, 0.0625);
    finished run = run_with(scene, method_of(method), setting, &how);
    if (run.summary.status)
        fail_msg("%s with %s: %s", method, setting, run.summary.message);
    return run;
}

static void energy_with_the_ledger_keeps_its_order(void **state) {
    (void)state;
    static const struct {
        const char *method;
        double step, low, high; /* the first step; bounds of the fitted order */
    } rows[] = {
        {"leapfrog", 1.0 / 128, 1.85, 2.15},
        {"composition-2-verlet", 1.0 / 128, 1.85, 2.15},
        {"composition-4-suzuki", 1.0 / 64, 3.7, 4.6},
        {"composition-6-kahan-li", 1.0 / 64, 5.6, 6.4},
        {"gsl-rk4", 1.0 / 64, 3.9, 5.1},
        {"arkode-erk", 1.0 / 64, 4.7, 5.7},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        double step[4], error[4] = {0};
        unsigned long hits = 0;
        for (unsigned number = 0; number < 10; number++) {
            dl_scene *const scene = crowd(0.01, number);
            for (int i = 0; i < 4; i++) {
                step[i] = ldexp(rows[k].step, -i);
                finished run = run_crowd(scene, rows[k].method, step[i], 4);
                error[i] = hypot(error[i], run.summary.energy_error_max);
                hits += run.summary.wall_hits;
                free(run.y);
            }
            dl_scene_free(scene);
        }
        const double order = slope(step, error, 4);
        print_message("%s: energy errors %.2e %.2e %.2e %.2e, order %.2f\n", rows[k].method,
                      error[0], error[1], error[2], error[3], order);
        assert_true(hits > 1500);
        if (!(order > rows[k].low && order < rows[k].high))
            fail_msg("%s: order %g", rows[k].method, order);
    }
}

static void the_conserving_scheme_conserves_through_hits(void **state) {
    (void)state;
    static const char *const names[] = {"conserving-fixed-point", "conserving-newton-dense",
                                        "conserving-newton-klu"};
    dl_scene *const scene = crowd(0.01, 0);
    for (size_t k = 0; k < 3; k++) {
        finished run = run_crowd(scene, names[k], 1.0 / 64, 40);
        const dl_run_summary *const s = &run.summary;
        print_message("%s: %lu hits, energy error %.2e of the scale\n", names[k], s->wall_hits,
                      s->energy_error_max / s->energy_scale);
        assert_true(s->wall_hits > 300);
        assert_true(s->energy_error_max <= 1e-12 * s->energy_scale);
        free(run.y);
    }
    dl_scene_free(scene);
}

/* Before the horizon all methods tend to one trajectory. */
static void methods_agree_on_a_crowd(void **state) {
    (void)state;
    dl_scene *const scene = crowd(0.1, 0);
    const double end = 1.5;
    finished reference = run_crowd(scene, "gsl-rk8pd", 1.0 / 1024, end);
    assert_true(reference.summary.wall_hits > 12);
    scene->step = 1.0 / 1024;
    scene->end = end;
    FOR_EACH_METHOD(row) {
        sampled run = run_closely(scene, row, 0);
        double off = 0;
        for (size_t i = 0; i < 18; i++)
            off = fmax(off, fabs(last_state(&run)[i] - reference.y[i]));
        print_message("%-28s off by %.2e\n", row->name, off);
        const double near = row->order == 2 ? 2e-3 : is_exact_on_parabolas(row) ? 5e-7 : 5e-6;
        if (!(off <= near))
            fail_msg("%s: positions are off by %g", row->name, off);
        assert_int_equal(run.summary.wall_hits, reference.summary.wall_hits);
        release_samples(&run);
    }
    static const char *const second[] = {"leapfrog", "conserving-fixed-point"};
    for (size_t m = 0; m < 2; m++) {
        double step[4], error[4] = {0};
        for (int k = 0; k < 4; k++) {
            step[k] = ldexp(1.0 / 256, -k);
            finished run = run_crowd(scene, second[m], step[k], end);
            for (size_t i = 0; i < 18; i++)
                error[k] = fmax(error[k], fabs(run.y[i] - reference.y[i]));
            free(run.y);
        }
        const double order = slope(step, error, 4);
        if (!(fabs(order - 2) < 0.2))
            fail_msg("%s: positions converge with order %g", second[m], order);
    }
    free(reference.y);
    dl_scene_free(scene);
}

/* --- TR323's fluid in the small ----------------------------------------------------------------
 */

static bool settles_with_hard_cutoff(const dl_method_row *row) {
    static const char *const names[] = {"implicit-midpoint", "gsl-bsimp", "gsl-rk4imp"};
    bool settles = true;
    for (size_t k = 0; k < sizeof names / sizeof *names; k++)
        settles &= strcmp(row->name, names[k]) != 0;
    return settles;
}

static void settle(const dl_scene *scene, const dl_method_row *row) {
    const dl_run_options how = run_options(0, 0);
    /* eps is absolute, and these velocities carry roundoff above its default */
    const char *const setting = has_option(row, "eps") ? "eps=1e-11" : "";
    finished run = run_with(scene, row, setting, &how);
    const dl_run_summary *const s = &run.summary;
    if (s->status)
        fail_msg("%s: %s", row->name, s->message);
    assert_true(s->wall_hits > 10 && s->contacts > 0);
    const double error = s->energy_error_max / s->energy_scale;
    if (!(error < (row->flags & DL_CONSERVES_ENERGY ? 1e-12 : 0.2)))
        fail_msg("%s: energy error %g of the scale", row->name, error);
    for (size_t i = 0; i < 24; i++) {
        assert_true(run.y[i] >= -1e-15 && run.y[i] <= 1.1 + 1e-15);
        if (!(run.y[24 + i] >= -1e-15))
            fail_msg("%s: particle %zu is at height %g", row->name, i, run.y[24 + i]);
    }
    free(run.y);
}

static void a_fluid_settles_on_located_walls(void **state) {
    (void)state;
    dl_scene *const scene = fixture_box();
    scene->walls.rule = DL_LOCATED;
    scene->walls.rest = 1e-9;
    FOR_EACH_METHOD(row)
    if (settles_with_hard_cutoff(row))
        settle(scene, row);
    dl_scene_free(scene);
}

/* Steps in which pairs cross the cutoff may have no solution by the force in the middle
 * (model/middle_gap.h), and break Newton's method and extrapolation: with crossings located, no
 * step has any. */
static void a_fluid_settles_with_its_crossings_located(void **state) {
    (void)state;
    dl_scene *const scene = fixture_box();
    scene->walls.rule = DL_LOCATED;
    scene->walls.rest = 1e-9;
    scene->law.piece[0].located = true;
    scene->end = 0.035;
    size_t rows = 0;
    FOR_EACH_METHOD(row)
    if (!settles_with_hard_cutoff(row)) {
        settle(scene, row);
        rows++;
    }
    assert_int_equal(rows, 3);
    dl_scene_free(scene);
}

/* Three dimensions, a pinned particle, unlike inertias, read from a file. */
static void scenes_ask_for_the_rule(void **state) {
    (void)state;
    static const char text[] =
        "name: cellar\n"
        "dimension: 3\n"
        "particles:\n"
        "  - {at: [0.5, 0.5, 0.5], pinned: true}\n"
        "  - {at: [0.2, 0.3, 0.9], velocity: [3, 1, -2], inertia: 2, coupling: 1}\n"
        "  - {at: [0.7, 0.8, 0.4], velocity: [-2, 2, 1], inertia: 0.5, coupling: 1}\n"
        "pair_law: [{terms: [{coefficient: 0.05, power: 2}]}]\n"
        "gravity: [0, 0, -9.81]\n"
        "walls: {x: [0, 1], y: [0, 1], z: [0, none], damping: 0.2, rule: located, rest: 1e-6}\n"
        "time: {step: 0.0078125, end: 4}\n";
    dl_scene *const scene = scene_of_text(text);
    assert_int_equal(scene->walls.rule, DL_LOCATED);
    assert_true(scene->walls.rest == 1e-6);
    FOR_EACH_METHOD(row) {
        sampled run = run_closely(scene, row, 0);
        const dl_run_summary *const s = &run.summary;
        const double error = s->energy_error_max / s->energy_scale;
        assert_true(s->wall_hits > 20 && s->contacts > 0);
        if (!(error < (row->flags & DL_CONSERVES_ENERGY ? 1e-13 : row->order == 2 ? 1e-2 : 1e-4)))
            fail_msg("%s: energy error %g of the scale", row->name, error);
        release_samples(&run);
    }
    dl_scene_free(scene);
}

static void observation_changes_nothing(void **state) {
    (void)state;
    dl_scene *const scene = fixture_box();
    scene->walls.rule = DL_LOCATED;
    scene->walls.rest = 1e-9;
    static const char *const names[] = {"leapfrog", "composition-4-suzuki",
                                        "conserving-fixed-point"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        dl_run_options plain = run_options(0, 0), every = run_options(0, scene->step);
        plain.observe = false;
        finished without = run_with(scene, method_of(names[k]), "", &plain);
        finished with = run_with(scene, method_of(names[k]), "", &every);
        assert_memory_equal(without.y, with.y, with.length * sizeof *with.y);
        assert_int_equal(without.summary.force_evaluations, with.summary.force_evaluations);
        assert_int_equal(without.summary.steps, with.summary.steps);
        assert_int_equal(without.summary.contacts, with.summary.contacts);
        free(without.y);
        free(with.y);
    }
    dl_scene_free(scene);
}

/* --- without an end ----------------------------------------------------------------------------
 */

static void too_many_hits_in_a_step_are_a_failure(void **state) {
    (void)state;
    dl_scene *const scene = ball(1e-7, 0);
    scene->position[1] = 1e-6; /* a bounce lasts a millisecond */
    scene->step = scene->end = 1000;
    const dl_run_options how = run_options(0, 0);
    dl_run_options plain = how;
    plain.observe = false;
    finished run = run_with(scene, method_of("leapfrog"), "", &plain);
    assert_int_equal(run.summary.status, DL_STEP_FAILURE);
    assert_non_null(strstr(run.summary.message, "wall hits"));
    assert_true(run.summary.t_end_reached > 0 && run.summary.t_end_reached < 1000);
    free(run.y);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(paths_are_the_polynomials_they_are_made_from),
        cmocka_unit_test(exits_are_found),
        cmocka_unit_test(dropped_balls_come_to_rest),
        cmocka_unit_test(without_a_last_flight_a_ball_rests_too),
        cmocka_unit_test(without_restitution_the_first_hit_is_the_last),
        cmocka_unit_test(a_method_of_order_one_comes_to_rest),
        cmocka_unit_test(without_damping_a_ball_bounces_for_ever),
        cmocka_unit_test(what_is_pressed_to_a_wall_rests_or_slides),
        cmocka_unit_test(a_passing_body_lifts_what_rests),
        cmocka_unit_test(release_times_are_those_of_balance),
        cmocka_unit_test(what_was_lifted_comes_back_to_rest),
        cmocka_unit_test(a_release_within_a_step_is_seen),
        cmocka_unit_test(what_is_held_has_no_acceleration),
        cmocka_unit_test(radiation_wakes_what_rests),
        cmocka_unit_test(a_dip_between_steps_is_a_hit),
        cmocka_unit_test(a_fast_particle_crosses_the_box_often_in_one_step),
        cmocka_unit_test(mirrors_reflect_as_often_as_walls_were_crossed),
        cmocka_unit_test(a_corner_takes_from_both_velocities_twice),
        cmocka_unit_test(energy_with_the_ledger_keeps_its_order),
        cmocka_unit_test(the_conserving_scheme_conserves_through_hits),
        cmocka_unit_test(methods_agree_on_a_crowd),
        cmocka_unit_test(a_fluid_settles_on_located_walls),
        cmocka_unit_test(a_fluid_settles_with_its_crossings_located),
        cmocka_unit_test(scenes_ask_for_the_rule),
        cmocka_unit_test(observation_changes_nothing),
        cmocka_unit_test(too_many_hits_in_a_step_are_a_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
