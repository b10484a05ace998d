/* Resting contacts that end because nothing presses any more: the neighbour that did has gone
 * beyond the cutoff. Against exact solutions, for every method. */
#include "contract.h"
#include "fixture_runs.h"

/* A ball on a side wall, pressed to it by a body so inert that it flies straight on, away from the
 * wall with velocity 1. At t = 1/2 it is beyond the cutoff. */
static const char pressed_ball[] =
    "name: pressed-ball\n"
    "source: test\n"
    "dimension: 2\n"
    "particles:\n"
    "  - {at: [0, 0]}\n"
    "  - {at: [0.5, 0], velocity: [1, 0], inertia: 1.0e18, coupling: 1, gravity: false}\n"
    "%s" /* particles */
    "pair_law:\n"
    "  - {until: 1, terms: [{coefficient: 3, power: 2}], located: %s}\n"
    "%s" /* pieces, gravity */
    "walls: {x: [0, none], damping: 0.5, rule: located}\n"
    "time: {step: 0.03, end: %g}\n";

static dl_scene *ball_with(const char *particles, const char *located, const char *rest,
                           double end) {
    char text[2048];
    snprintf(text, sizeof text, pressed_ball, particles, located, rest, end);
    return scene_of_text(text);
}

/* With a tight tolerance where the method has one. */
static finished run_closely(const dl_scene *scene, const dl_method_row *row) {
    const dl_run_options how = run_options(0, 0);
    const char *const setting = dl_parameter_find(row->options, "rtol") ? "rtol=1e-10" : "";
    finished run = run_with(scene, row, setting, &how);
    if (run.summary.status)
        fail_msg("%s on %s: %s", row->name, scene->name, run.summary.message);
    return run;
}

static void check(const dl_method_row *row, const char *what, double value, double expected,
                  double near) {
    if (!(fabs(value - expected) <= near))
        fail_msg("%s: %s is %.17g, expected %.17g", row->name, what, value, expected);
}

/* It is held while it is pressed, and falls along the wall from then on. */
static void check_fall(const dl_method_row *row, const dl_scene *scene) {
    const double weight = 2, falls = scene->end - 0.5;
    finished run = run_closely(scene, row);
    check(row, "x", run.y[0], 0, 0);
    check(row, "y", run.y[2], -weight * falls * falls / 2, 1e-7);
    check(row, "v_x", run.y[4], 0, 0);
    check(row, "v_y", run.y[6], -weight * falls, 1e-7);
    assert_int_equal(run.summary.contacts, 1);
    assert_int_equal(run.summary.releases, 1);
    assert_int_equal(run.summary.wall_hits, 0);
    free(run.y);
}

static void what_hung_on_a_wall_falls(void **state) {
    (void)state;
    dl_scene *const scene = ball_with("", "true", "gravity: [0, -2]\n", 1.5);
    FOR_EACH_LOCATING_ROW(row)
    check_fall(row, scene);
    dl_scene_free(scene);
}

/* Where the crossing of the cutoff is not located the contact's end is, all the same. Methods with
 * stages that go back in time see the body within the cutoff once more. */
static void a_cutoff_that_is_not_located_ends_a_contact_too(void **state) {
    (void)state;
    static const char *const names[] = {"leapfrog",    "composition-2-verlet", "arkode-erk",
                                        "cvode-adams", "cvode-bdf-klu",        "gsl-rk8pd"};
    dl_scene *const scene = ball_with("", "false", "gravity: [0, -2]\n", 1.5);
    for (size_t m = 0; m < sizeof names / sizeof *names; m++)
        check_fall(method_of(names[m]), scene);
    dl_scene_free(scene);
}

/* Without other forces it stays where it is, until another body presses it again, from t = 3/2 on,
 * where that is 1 away. No hit takes anything from it: as seen from the body, which comes along the
 * wall with velocity 1, it turns round with the velocity it had, and slides away with 2. */
static void what_is_pressed_again_slides(void **state) {
    (void)state;
    static const char second[] =
        "  - {at: [0.6, 2.3], velocity: [0, -1], inertia: 1.0e18, coupling: 1, gravity: false}\n";
    dl_scene *const scene = ball_with(second, "true", "", 3.51);
    FOR_EACH_LOCATING_ROW(row) {
        finished run = run_closely(scene, row);
        check(row, "x", run.y[0], 0, 0);
        check(row, "v_x", run.y[6], 0, 0);
        check(row, "v_y", run.y[9], -2, row->order == 2 || row->order == 3 ? 5e-5 : 1e-7);
        assert_int_equal(run.summary.contacts, 1);
        assert_int_equal(run.summary.releases, 1);
        assert_int_equal(run.summary.wall_hits, 0);
        free(run.y);
    }
    dl_scene_free(scene);
}

/* It falls along the wall on a body that goes down slowly, within whose cutoff it is pressed to the
 * wall: what that were to take from it would keep it there, held, let go and held again without
 * end. As seen from the body it keeps its energy. */
static void what_slides_bounces_on_a_cutoff(void **state) {
    (void)state;
    static const char second[] = "  - {at: [0.3, -1.5], velocity: [0, -0.125], inertia: 1.0e18, "
                                 "coupling: 1, gravity: false}\n";
    const double begins = 2 * (1.5 + 0.5 * 0.125) + 0.125 * 0.125 / 2; /* where U is 0 */
    dl_scene *const scene = ball_with(second, "true", "gravity: [0, -2]\n", 6);
    FOR_EACH_LOCATING_ROW(row) {
        finished run = run_closely(scene, row);
        const double rises = run.y[3] - run.y[5], rate = run.y[9] + 0.125;
        const double r = hypot(0.3, rises), potential = r < 1 ? 3 / r - 3 : 0;
        check(row, "energy", rate * rate / 2 + 2 * rises + potential, begins,
              row->order == 2 || row->order == 3 ? 1e-4 : 1e-6);
        check(row, "x", run.y[0], 0, 0);
        assert_int_equal(run.summary.crossings, 5); /* of the first body once, twice a bounce */
        assert_int_equal(run.summary.contacts, 1);
        assert_int_equal(run.summary.releases, 1);
        free(run.y);
    }
    dl_scene_free(scene);
}

/* The same body attracts it from the distance 2, which is at t = 3/2, with c/r^2: so weakly that
 * the ball's own way does not count. */
static void what_is_pulled_away_later_leaves(void **state) {
    (void)state;
    static const char pieces[] =
        "  - {until: 2, terms: [{coefficient: 0, power: 2}], located: true}\n"
        "  - {terms: [{coefficient: -1.0e-3, power: 2}]}\n";
    const double c = 1e-3, s = 0.99;
    dl_scene *const scene = ball_with("", "true", pieces, 1.5 + s);
    FOR_EACH_LOCATING_ROW(row) {
        finished run = run_closely(scene, row);
        check(row, "x", run.y[0] / (c * (s / 2 - log1p(s / 2))), 1, 1e-3);
        check(row, "v_x", run.y[4] / (c * (0.5 - 1 / (2 + s))), 1, 1e-3);
        assert_int_equal(run.summary.contacts, 1);
        assert_int_equal(run.summary.releases, 1);
        free(run.y);
    }
    dl_scene_free(scene);
}

/* A ball rests on a side wall beside one that bounces on it, which presses it but for the moments
 * of its hits, and presses it no more when it rests, at t1 (1 + e)/(1 - e) with t1 = sqrt(2
 * 0.01/9.81): from then on the repulsion along the wall alone is left. */
static void what_bounces_beside_it_holds_a_ball(void **state) {
    (void)state;
    static const char text[] =
        "name: beside\ndimension: 2\nparticles:\n"
        "  - {at: [0, 0], gravity: false}\n  - {at: [0.01, 0.2]}\n"
        "pair_law: [{until: 1, terms: [{coefficient: 1.0e-4, power: 2}]}]\n"
        "gravity: [-9.81, 0]\nwalls: {x: [0, none], damping: 0.5, rule: located}\n"
        "time: {step: 0.01, end: 0.13}\n";
    const double rests = 3 * sqrt(0.02 / 9.81);
    dl_scene *const scene = scene_of_text(text);
    FOR_EACH_LOCATING_ROW(row) {
        scene->end = 0.13;
        finished held = run_closely(scene, row);
        check(row, "y", held.y[2], 0, 0);
        check(row, "releases", (double)held.summary.releases, 0, 0);
        scene->end = 0.33;
        finished free_again = run_closely(scene, row);
        const double after = scene->end - rests;
        check(row, "y", free_again.y[2], -1e-4 / 0.04 * after * after / 2, 2e-6);
        check(row, "x", free_again.y[0], 0, 1e-15);
        check(row, "releases", (double)free_again.summary.releases, 1, 0);
        free(held.y);
        free(free_again.y);
    }
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_hung_on_a_wall_falls),
        cmocka_unit_test(a_cutoff_that_is_not_located_ends_a_contact_too),
        cmocka_unit_test(what_is_pressed_again_slides),
        cmocka_unit_test(what_slides_bounces_on_a_cutoff),
        cmocka_unit_test(what_is_pulled_away_later_leaves),
        cmocka_unit_test(what_bounces_beside_it_holds_a_ball),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
