/* What a scene lacks costs nothing, and what is added to measure that changes nothing. */
#include "contract.h"

#include "../bench/by_hand.h"
#include "driftlab/leave_outs.h"
#include "driftlab/run.h"
#include "methods/splitting.h"
#include "study/leave_outs.h"

#define FOR_EACH_MOTION(row)                                                                       \
    FOR_EACH_UNSPLIT_ROW(row)                                                                      \
    if (row->ops == &dl_splitting_ops || strcmp(row->name, "leapfrog") == 0)

static const int steps = 40;

static dl_scene *scattered(int dimension) {
    dl_scene *scene = fixture_scene("scattered", dimension, 7);
    for (unsigned i = 0; i < 7; i++)
        fixture_place(
            scene, i,
            (double[3]){fixture_noise(6 * i), fixture_noise(6 * i + 1), fixture_noise(6 * i + 2)},
            (double[3]){fixture_noise(6 * i + 3), fixture_noise(6 * i + 4),
                        fixture_noise(6 * i + 5)});
    return scene;
}

static dl_scene *falling(int dimension) {
    dl_scene *scene = scattered(dimension);
    scene->gravity[1] = -10;
    scene->gravity[dimension - 1] -= 3;
    for (size_t i = 0; i < scene->particles; i++)
        scene->feels_gravity[i] = true;
    return scene;
}

/* The same scene as if its force had to be evaluated. */
static rig open_general(const dl_method_row *row, dl_scene *scene, const char *options) {
    rig r = rig_open(row, scene, options);
    dl_error error = {""};
    dl_method_destroy(r.method);
    r.method = NULL;
    r.model->has_force = true;
    r.model->is_uniform = false;
    dl_model_initial_state(r.model, r.y);
    assert_int_equal(dl_method_create(row, r.model, r.options, r.y, &r.method, &error), DL_OK);
    return r;
}

/* --- methods ---------------------------------------------------------------------------------- */

/* No force is evaluated where there is none; paths are straight and velocities stay to the bit. */
static void what_is_free_flies_straight(void **state) {
    static const char *const options[] = {"step=0.01", "step=0.01 compensated=true"};
    (void)state;
    FOR_EACH_MOTION(row)
    for (int k = 0; k < (has_option(row, "compensated") ? 2 : 1); k++) {
        rig lean = rig_open(row, scattered(3), options[k]);
        rig general = open_general(row, scattered(3), options[k]);
        const size_t n = lean.length / 2;
        double start[42];
        memcpy(start, rig_state(&lean), lean.length * sizeof *start);
        rig_steps(&lean, steps);
        rig_steps(&general, steps);
        assert_int_equal(lean.model->counts.force, 0);
        assert_true(general.model->counts.force > 0);
        const double *const y = rig_state(&lean);
        assert_memory_equal(y + n, start + n, n * sizeof *y);
        for (size_t i = 0; i < n; i++)
            assert_true(fabs(y[i] - (start[i] + 0.01 * steps * start[n + i])) < 1e-14);
        assert_true(largest_difference(y, rig_state(&general), lean.length) < 1e-13);
        rig_close(&lean);
        rig_close(&general);
    }
}

/* Gravity alone is a number: the same bits as if it were evaluated everywhere. */
static void what_falls_evaluates_nothing(void **state) {
    (void)state;
    FOR_EACH_MOTION(row) {
        rig lean = rig_open(row, falling(3), "step=0.01");
        rig general = open_general(row, falling(3), "step=0.01");
        assert_true(lean.model->is_uniform);
        rig_steps(&lean, steps);
        rig_steps(&general, steps);
        assert_int_equal(lean.model->counts.force, 0);
        assert_true(general.model->counts.force > 0);
        assert_memory_equal(lean.method->y, general.method->y, lean.length * sizeof(double));
        const double *const a = rig_state(&lean), *const b = rig_state(&general);
        assert_memory_equal(a, b, lean.length * sizeof *a);
        rig_close(&lean);
        rig_close(&general);
    }
}

/* Not so where one particle does not feel it, or where particles may come to rest on walls. */
static void what_is_not_uniform_is_evaluated(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("leapfrog", &row, NULL), DL_OK);
    for (int located = 0; located <= 1; located++) {
        dl_scene *scene = falling(2);
        scene->feels_gravity[3] = located;
        if (located) {
            scene->walls.present = true;
            scene->walls.rule = DL_LOCATED;
            scene->walls.low[1] = -5;
        }
        rig r = rig_open(row, scene, "step=0.01");
        assert_false(r.model->is_uniform);
        rig_steps(&r, 3);
        assert_true(r.model->counts.force > 0);
        rig_close(&r);
    }
}

/* --- loops written by hand ---------------------------------------------------------------------*/

/* The benchmark's loops are leap-frog: positions as ours. */
static void loops_by_hand_are_leapfrog(void **state) {
    static const struct {
        const char *scene;
        by_hand_loop *loop;
    } cases[] = {{DL_STUDIES "/leave-outs/free.yaml", by_hand_free},
                 {DL_STUDIES "/leave-outs/falling.yaml", by_hand_falling},
                 {DL_STUDIES "/stream/stream.yaml", by_hand_stream}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        dl_error error = {""};
        dl_scene *scene = NULL;
        double seconds;
        const dl_method_row *row = NULL;
        assert_int_equal(dl_scene_read(cases[k].scene, &scene, &error), DL_OK);
        double *const y = malloc(4 * scene->particles * sizeof *y);
        assert_int_equal(by_hand_run(scene, cases[k].loop, 20, &seconds, y, &error), DL_OK);
        assert_int_equal(dl_method_find("leapfrog", &row, &error), DL_OK);
        rig r = rig_open(row, scene, "");
        rig_steps(&r, 20);
        assert_true(largest_difference(rig_state(&r), y, r.length / 2) < 1e-11);
        free(y);
        rig_close(&r);
    }
}

/* --- what is added ---------------------------------------------------------------------------- */

static dl_scene *read(const char *path) {
    dl_error error = {""};
    dl_scene *scene = NULL;
    if (dl_scene_read(path, &scene, &error))
        fail_msg("%s", error.message);
    return scene;
}

static bool leaves_out(const dl_scene *scene, dl_left_out what) {
    dl_error error = {""};
    dl_model *model = NULL;
    if (dl_model_create(scene, &model, &error))
        fail_msg("%s", error.message);
    const bool out = dl_leaves_out(model, what);
    dl_model_free(model);
    return out;
}

/* Each thing alone, and all together: it is in the model then. */
static void added_things_are_in_the_model(void **state) {
    static const char *const files[] = {
        DL_STUDIES "/leave-outs/free.yaml", DL_STUDIES "/kepler/kepler.yaml",
        DL_STUDIES "/drop/settled.yaml", DL_STUDIES "/swirl/swirl.yaml"};
    dl_error error = {""};
    (void)state;
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        dl_scene *scene = read(files[f]), *all = NULL, *one = NULL;
        assert_int_equal(dl_scene_copy(scene, &all, &error), DL_OK);
        for (int k = 0; k < DL_LEFT_OUTS; k++) {
            const dl_left_out what = (dl_left_out)k;
            assert_int_equal(dl_can_add(what), what != DL_OUT_SLOW_PART);
            if (!dl_can_add(what))
                continue;
            if (leaves_out(scene, what)) {
                assert_int_equal(dl_scene_copy(scene, &one, &error), DL_OK);
                assert_int_equal(dl_scene_add_neutral(one, what, &error), DL_OK);
                if (leaves_out(one, what))
                    fail_msg("%s: still without %s", scene->name, dl_left_out_name(what));
                dl_scene_free(one);
            }
            if (leaves_out(all, what))
                assert_int_equal(dl_scene_add_neutral(all, what, &error), DL_OK);
        }
        for (int k = 0; k < DL_LEFT_OUTS; k++)
            assert_true(!leaves_out(all, (dl_left_out)k) || k == DL_OUT_SLOW_PART);
        dl_scene_free(all);
        dl_scene_free(scene);
    }
}

/* Rows for all that is left out, with the same physics and all together last. */
static void measured_models_have_the_same_physics(void **state) {
    static const char *const files[] = {
        DL_STUDIES "/leave-outs/falling.yaml", DL_STUDIES "/kepler/kepler.yaml",
        DL_STUDIES "/stream/stream.yaml", DL_STUDIES "/drop/settled.yaml"};
    dl_error error = {""};
    (void)state;
    for (size_t f = 0; f < sizeof files / sizeof *files; f++) {
        dl_scene *scene = read(files[f]);
        dl_leave_outs costs;
        if (dl_leave_outs_measure(scene, 2, 1e-4, &costs, &error))
            fail_msg("%s: %s", scene->name, error.message);
        size_t expected = 3; /* nothing, everything, that by the reference kernel */
        expected += strcmp(costs.kernel, "reference") != 0 && strcmp(costs.kernel, "none") != 0;
        for (int k = 0; k < DL_LEFT_OUTS; k++)
            expected += dl_can_add((dl_left_out)k) && leaves_out(scene, (dl_left_out)k);
        assert_int_equal(costs.rows, expected);
        assert_string_equal(costs.row[0].what, "nothing");
        assert_true(costs.row[0].ratio == 1 && costs.row[0].difference == 0);
        assert_string_equal(costs.row[costs.rows - 2].what, "everything");
        for (size_t k = 0; k < costs.rows; k++) {
            const dl_leave_out_row *row = &costs.row[k];
            assert_true(row->seconds > 0 && row->ratio_low <= row->ratio);
            assert_true(row->ratio <= row->ratio_high);
            assert_true(isnan(row->bytes) || row->bytes > 0);
            /* leap-frog that steps to crossings turns whole-step velocities round at a mirror */
            const bool turns = scene->walls.present &&
                               (strstr(row->what, "crossings") || strstr(row->what, "everything"));
            if (!(row->difference < (turns ? 1e-3 : 1e-13)))
                fail_msg("%s with %s: off by %g", scene->name, row->what, row->difference);
        }
        dl_scene_free(scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_free_flies_straight),
        cmocka_unit_test(what_falls_evaluates_nothing),
        cmocka_unit_test(what_is_not_uniform_is_evaluated),
        cmocka_unit_test(loops_by_hand_are_leapfrog),
        cmocka_unit_test(added_things_are_in_the_model),
        cmocka_unit_test(measured_models_have_the_same_physics),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
