/* The contract that every row of the registry keeps. */
#include "contract.h"

/* --- registry and options ----------------------------------------------------------------------
 */

static void registry_is_complete(void **state) {
    (void)state;
    static const char *const expected[] = {
        "leapfrog",
        "composition-2-verlet",
        "composition-4-yoshida",
        "composition-4-suzuki",
        "composition-6-yoshida",
        "composition-6-kahan-li",
        "composition-8-kahan-li",
        "composition-8-suzuki-umeno",
        "conserving-fixed-point",
        "conserving-newton-dense",
        "conserving-newton-klu",
        "arkode-erk",
        "cvode-adams",
        "cvode-bdf-fixed-point",
        "cvode-bdf-klu",
        "cvode-bdf-krylov",
        "gsl-rk8pd",
        "gsl-msadams",
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        const dl_method_row *row = NULL;
        assert_int_equal(dl_method_find(expected[i], &row, NULL), DL_OK);
        assert_string_equal(row->name, expected[i]);
    }
    assert_null(dl_method_row_at(dl_method_count()));
}

static void rows_are_filled_in(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        assert_true(strlen(row->family) > 0 && strlen(row->doc) > 0);
        assert_true(row->flags & (DL_FIXED_STEP | DL_ADAPTIVE));
        assert_true(has_option(row, "step") == !!(row->flags & DL_FIXED_STEP));
        assert_true(has_option(row, "rtol") == !!(row->flags & DL_ADAPTIVE));
        assert_true(!has_option(row, "atol") || has_option(row, "rtol"));
        assert_true(row->ops->create && row->ops->advance && row->ops->jumped && row->ops->stats &&
                    row->ops->destroy);
        for (size_t i = 0; i < row->options.count; i++)
            assert_true(strlen(row->options.rows[i].doc) > 0);
        for (size_t i = 0; i < row_index; i++)
            assert_string_not_equal(dl_method_row_at(i)->name, row->name);
    }
}

static void unknown_method_is_refused(void **state) {
    (void)state;
    const dl_method_row *row;
    dl_error error = {""};
    assert_int_equal(dl_method_find("leap-forg", &row, &error), DL_INPUT);
    assert_null(row);
    assert_non_null(strstr(error.message, "leap-forg"));
    assert_non_null(strstr(error.message, "\"leapfrog\""));
    assert_int_equal(dl_method_find("zzz", &row, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "list methods"));
}

static void unknown_options_are_refused(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0);
    FOR_EACH_ROW(row) {
        void *options = NULL;
        dl_error error = {""};
        assert_int_equal(dl_method_options_create(row, scene, &options, &error), DL_OK);
        const dl_parameter *const first = row->options.rows;
        char misspelt[64], quoted[64];
        snprintf(misspelt, sizeof misspelt, "%sx", first->name);
        snprintf(quoted, sizeof quoted, "\"%s\"", first->name);
        assert_int_equal(dl_method_options_set(row, options, misspelt, "1", &error), DL_INPUT);
        assert_non_null(strstr(error.message, row->name));
        assert_non_null(strstr(error.message, quoted));
        assert_int_equal(dl_method_options_set(row, options, "qqqq", "1", &error), DL_INPUT);
        assert_non_null(strstr(error.message, first->name));
        assert_int_equal(dl_method_options_set(row, options, first->name, "much", &error),
                         DL_INPUT);
        dl_method_options_free(row, options);
    }
    dl_scene_free(scene);
}

/* What is written is what is read, and the step is the scene's unless the method chooses it. */
static void options_are_written_and_read(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0);
    scene->step = 0.0625;
    FOR_EACH_ROW(row) {
        void *options = NULL, *again = NULL;
        assert_int_equal(dl_method_options_create(row, scene, &options, NULL), DL_OK);
        char text[512], copy[512];
        dl_method_options_format(row, options, text, sizeof text);
        if (row->flags & DL_FIXED_STEP) {
            const char *const step = row->flags & DL_ADAPTIVE ? "step=0 " : "step=0.0625";
            assert_non_null(strstr(text, step));
            set_options(row, options, "step=0.3");
            dl_method_options_format(row, options, text, sizeof text);
            assert_non_null(strstr(text, "step=0.3"));
        }
        assert_int_equal(dl_method_options_create(row, scene, &again, NULL), DL_OK);
        set_options(row, again, text);
        dl_method_options_format(row, again, copy, sizeof copy);
        assert_string_equal(text, copy);
        dl_method_options_free(row, options);
        dl_method_options_free(row, again);
    }
    dl_scene_free(scene);
}

/* Where a fixed step takes no notice of tolerances, both together are refused. */
static void ignored_tolerances_are_refused(void **state) {
    (void)state;
    dl_scene *scene = fixture_kepler(0);
    dl_model *model = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    double y[8];
    dl_model_initial_state(model, y);
    int rows = 0;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_FIXED_STEP) || !(row->flags & DL_ADAPTIVE) ||
            !dl_parameter_find(row->options, "rtol")->when)
            continue;
        void *options = NULL;
        dl_method *method = NULL;
        dl_error error = {""};
        assert_int_equal(dl_method_options_create(row, scene, &options, &error), DL_OK);
        set_options(row, options, "step=0.1");
        assert_int_equal(dl_method_options_set(row, options, "rtol", "1e-3", &error), DL_OK);
        assert_int_equal(dl_method_create(row, model, options, y, &method, &error), DL_INPUT);
        assert_null(method);
        assert_non_null(strstr(error.message, "rtol"));
        dl_method_options_free(row, options);
        rows++;
    }
    assert_true(rows >= 4);
    dl_model_free(model);
    dl_scene_free(scene);
}

/* --- going on, stopping, looking ---------------------------------------------------------------
 */

static const int half_of_the_steps = 10;

/* From the middle state: exactly where the row claims it, closely elsewhere. */
static void check_restart(const dl_method_row *row, dl_scene *(*make)(void), double step) {
    char options[64];
    close_options(row, options, step, 1e-9);
    const double middle = step * half_of_the_steps, end = 2 * middle;
    rig straight = rig_open(row, make(), options);
    rig_run(&straight, middle);
    rig_run(&straight, end);
    rig first = rig_open(row, make(), options);
    rig_run(&first, middle);
    rig second = rig_open_at(row, make(), options, rig_state(&first));
    rig_run(&second, middle);
    const double *const a = rig_state(&straight), *const b = rig_state(&second);
    if (row->flags & DL_RESTARTS_EXACTLY)
        assert_memory_equal(a, b, straight.length * sizeof *a);
    else if (!(largest_difference(a, b, straight.length) < near(row, 1e-6)))
        fail_msg("%s: a restart changes the end by %g", row->name,
                 largest_difference(a, b, straight.length));
    rig_close(&straight);
    rig_close(&first);
    rig_close(&second);
}

static void restart_is_like_going_on(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        check_restart(row, fixture_cluster, 1e-3);
        check_restart(row, fixture_pinned_chain, 1e-3);
        check_restart(row, fixture_box, 1e-4);
    }
}

/* Asking for the state changes no bit of what follows and counts as no work. */
static void looking_changes_nothing(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        char options[64];
        close_options(row, options, 0.002, 1e-7);
        rig unseen = rig_open(row, fixture_cluster(), options);
        rig seen = rig_open(row, fixture_cluster(), options);
        for (int i = 0; i < 25; i++) {
            rig_step(&unseen, 10);
            rig_state(&seen);
            rig_step(&seen, 10);
            rig_state(&seen);
        }
        assert_true(unseen.method->t == seen.method->t);
        assert_memory_equal(unseen.method->y, seen.method->y, seen.length * sizeof(double));
        assert_memory_equal(&unseen.model->counts, &seen.model->counts, sizeof(dl_counts));
        rig_close(&unseen);
        rig_close(&seen);
    }
}

/* Forwards, velocities reversed from outside, and back to the start. */
static void jumps_are_noticed(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (row->ops->state)
            continue; /* y is not the state that would have to be reversed */
        char options[64];
        rig r = rig_open(row, fixture_cluster(), close_options(row, options, 0.0005, 1e-10));
        rig_state(&r);
        double start[6 * 13];
        assert_int_equal(r.length, 6 * 13);
        memcpy(start, r.y, sizeof start);
        for (int way = 0; way < 2; way++) {
            rig_run(&r, 0.1 * (way + 1));
            for (size_t i = 0; i < r.method->n; i++)
                r.method->y[r.method->n + i] *= -1;
            rig_jumped(&r);
        }
        const double difference = largest_difference(r.method->y, start, r.length);
        if (!(difference < near(row, 1e-6)))
            fail_msg("%s: comes back to %g of its start", row->name, difference);
        rig_close(&r);
    }
}

/* What a row solves its systems by, if its options are the defaults: its name or an option says. */
static bool solves_by(const rig *r, const char *solver) {
    char text[512], option[64];
    dl_method_options_format(r->row, r->options, text, sizeof text);
    snprintf(option, sizeof option, "solver=%s", solver);
    return strstr(r->row->name, solver) || strstr(text, option);
}

static void work_is_counted(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        char options[64];
        rig r = rig_open(row, fixture_cluster(), close_options(row, options, 0.002, 1e-7));
        for (int i = 0; i < 30; i++) {
            if (i == 20)
                rig_jumped(&r); /* a restart inside must not lose the counts */
            rig_step(&r, 10);
        }
        dl_method_stats stats;
        dl_method_stats_get(r.method, &stats);
        assert_int_equal(stats.steps, 30);
        assert_true(r.model->counts.force >= 30);
        const bool tells = strcmp(row->family, "GSL") != 0; /* how it solves what is implicit */
        const bool implicit = row->flags & DL_IMPLICIT;
        assert_true((stats.nonlinear_iterations >= 30) == (implicit && tells));
        const bool krylov = solves_by(&r, "krylov");
        assert_true((stats.linear_iterations > 0) == krylov);
        assert_true((r.model->counts.jacobian_vector > 0) == krylov);
        const bool direct =
            solves_by(&r, "klu") || solves_by(&r, "dense") || solves_by(&r, "picard");
        assert_true((stats.factorisations > 0) == direct);
        assert_true((r.model->counts.jacobian > 0) ==
                    (direct || (implicit && !tells) || has_option(row, "preconditioner")));
        rig_close(&r);
    }
}

static void explicit_methods_take_their_forces(void **state) {
    (void)state;
    static const struct {
        const char *name, *options;
        unsigned long a_step, once;
    } expected[] = {
        {"leapfrog", "", 1, 0},
        {"composition-2-verlet", "", 1, 1},
        {"splitting-2-position-verlet", "", 1, 0},
        {"splitting-3-ruth", "", 3, 0},
        {"composition-4-suzuki", "", 5, 1},
        {"composition-8-kahan-li", "", 17, 1},
        {"arkode-erk", "table=dormand-prince-5", 6, 1},
        {"arkode-erk", "table=verner-6", 8, 1},
    };
    for (size_t i = 0; i < sizeof expected / sizeof *expected; i++) {
        const dl_method_row *row;
        assert_int_equal(dl_method_find(expected[i].name, &row, NULL), DL_OK);
        char options[64];
        snprintf(options, sizeof options, "step=0.002 %s", expected[i].options);
        rig r = rig_open(row, fixture_cluster(), options);
        rig_steps(&r, 40);
        const unsigned long steps = 40 * expected[i].a_step;
        assert_in_range(r.model->counts.force, steps, steps + expected[i].once);
        rig_close(&r);
    }
}

/* The table by which ARKODE's rows go has the order that its word ends in, and the stages that its
 * source gives it. */
static void steps_are_of_what_rows_say(void **state) {
    (void)state;
    static const struct {
        const char *name;
        int order, stages;
    } tables[] = {
        {"arkode-erk", 5, 7},            /* Dormand and Prince 1980 */
        {"arkode-dirk", 4, 7},           /* ESDIRK4(3)7L[2]SA */
        {"arkode-imex", 4, 7},           /* ARK4(3)7L[2]SA */
        {"arkode-mri", 4, 6},            /* MRI-GARK-ERK45a: five, and the end of the step */
        {"arkode-erk-relaxation", 5, 6}, /* Cash and Karp 1990 */
        {"arkode-sprk", 4, 4},           /* McLachlan and Atela 1992 */
    };
    size_t by_table = 0;
    FOR_EACH_ROW(row) {
        dl_method_table table = {0, 0};
        const bool has_table = dl_method_default_table(row, &table);
        if ((row->stages > 0) + (row->made_of != NULL) + has_table != 1)
            fail_msg("%s: a step's stages are said %d times", row->name,
                     (row->stages > 0) + (row->made_of != NULL) + has_table);
        size_t k = 0;
        while (has_table && k < sizeof tables / sizeof *tables &&
               strcmp(tables[k].name, row->name) != 0)
            k++;
        if (!has_table)
            continue;
        assert_true(k < sizeof tables / sizeof *tables);
        assert_int_equal(table.order, tables[k].order);
        assert_int_equal(table.stages, tables[k].stages);
        by_table++;
    }
    assert_true(by_table >= 4);
}

static void words_of_tables_end_in_their_order(void **state) {
    (void)state;
    int words = 0;
    FOR_EACH_ROW(row)
    for (size_t i = 0; row->table && i < row->options.count; i++) {
        const dl_parameter *const option = &row->options.rows[i];
        dl_method_table table;
        for (size_t k = 0; option->kind == DL_WORD && option->words[k]; k++) {
            if (!row->table(option->words, k, &table))
                continue;
            const int order = atoi(strrchr(option->words[k], '-') + 1);
            if (table.order != order || table.stages < 1)
                fail_msg("%s: %s has order %d and %d stages", row->name, option->words[k],
                         table.order, table.stages);
            words++;
        }
    }
    assert_true(words > 60);
}

static void steps_take_the_forces_that_rows_say(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_ROW(row) {
        assert_true(row->stages >= 0 && row->forces >= 0);
        if (row->forces == 0)
            continue;
        rig r = rig_open(row, fixture_cluster(), "step=0.002");
        rig_steps(&r, 3);
        const unsigned long before = r.model->counts.force;
        rig_steps(&r, 20);
        if (r.model->counts.force - before != 20 * (unsigned long)row->forces)
            fail_msg("%s: %lu forces in 20 steps, not %d a step", row->name,
                     r.model->counts.force - before, row->forces);
        rig_close(&r);
        rows++;
    }
    assert_true(rows >= 30);
}

/* --- failures ----------------------------------------------------------------------------------
 */

/* A force that fails `planted.failures` times after `planted.calls_before` good calls. */
static struct {
    dl_status (*acceleration)(dl_model *model, const double *q, double *a, dl_error *error);
    dl_status (*discrete)(dl_model *model, const double *q, const double *delta, double *a,
                          dl_error *error);
    dl_status (*part)(dl_model *model, dl_part part, const double *q, double *a, dl_error *error);
    int calls_before, failures;
    dl_status status;
} planted;

static bool fails_now(void) {
    if (planted.calls_before > 0) {
        planted.calls_before--;
        return false;
    }
    return planted.failures > 0 && planted.failures-- > 0;
}

static dl_status fail_planted(dl_model *model, double *a, dl_error *error) {
    for (size_t i = 0; i < model->unknowns; i++)
        a[i] = NAN;
    return dl_fail(error, planted.status, "planted failure");
}

static dl_status failing_acceleration(dl_model *model, const double *q, double *a,
                                      dl_error *error) {
    return fails_now() ? fail_planted(model, a, error) : planted.acceleration(model, q, a, error);
}

static dl_status failing_discrete(dl_model *model, const double *q, const double *delta, double *a,
                                  dl_error *error) {
    return fails_now() ? fail_planted(model, a, error)
                       : planted.discrete(model, q, delta, a, error);
}

static dl_status failing_part(dl_model *model, dl_part part, const double *q, double *a,
                              dl_error *error) {
    return fails_now() ? fail_planted(model, a, error) : planted.part(model, part, q, a, error);
}

static void plant(rig *r, int calls_before, int failures, dl_status status) {
    planted.acceleration = r->model->acceleration;
    planted.discrete = r->model->discrete_acceleration;
    planted.part = r->model->part_acceleration;
    planted.calls_before = calls_before;
    planted.failures = failures;
    planted.status = status;
    r->model->acceleration = failing_acceleration;
    r->model->discrete_acceleration = failing_discrete;
    r->model->part_acceleration = failing_part;
}

static void unplant(rig *r) {
    r->model->acceleration = planted.acceleration;
    r->model->discrete_acceleration = planted.discrete;
    r->model->part_acceleration = planted.part;
}

static rig rig_under_way(const dl_method_row *row, int steps) {
    char options[64];
    rig r = rig_open(row, fixture_cluster(), close_options(row, options, 0.0005, 1e-9));
    for (int i = 0; i < steps; i++)
        rig_step(&r, 0.05);
    return r;
}

/* After whatever happened the method goes on and arrives where an undisturbed one does. */
static void check_recovery(rig *r) {
    static const dl_method_row *row; /* that `end` is of */
    static double end[6 * 13];
    if (row != r->row) {
        row = r->row;
        rig undisturbed = rig_under_way(row, 0);
        rig_run(&undisturbed, 0.05);
        memcpy(end, rig_state(&undisturbed), sizeof end);
        rig_close(&undisturbed);
    }
    rig_run(r, 0.05);
    const double difference = largest_difference(rig_state(r), end, r->length);
    if (!(difference < near(r->row, 1e-6)))
        fail_msg("%s: off by %g after a failure", r->row->name, difference);
}

/* One advance with the planted force: it fails, saying why and changing nothing, or it succeeds.
 * Returns whether it failed. */
static bool check_advance(rig *r) {
    double before[6 * 13];
    memcpy(before, r->method->y, sizeof before);
    const double t = r->method->t;
    dl_error error = {""};
    const dl_status status = dl_method_advance(r->method, 0.05, &error);
    if (!status) {
        assert_true(r->method->t > t);
        for (size_t i = 0; i < r->length; i++)
            if (!isfinite(r->method->y[i]))
                fail_msg("%s: a component is not finite", r->row->name);
        return false;
    }
    if (status != planted.status || !strstr(error.message, "planted"))
        fail_msg("%s: status %s, \"%s\"", r->row->name, dl_status_name(status), error.message);
    assert_true(r->method->t == t);
    assert_memory_equal(r->method->y, before, sizeof before);
    return true;
}

static void lasting_failure_is_reported(void **state) {
    (void)state;
    static const dl_status statuses[] = {DL_ERROR, DL_UNSTABLE};
    FOR_EACH_ROW(row) {
        for (int steps = 0; steps <= 6; steps += 3) {
            for (int k = 0; k < 2; k++) {
                rig r = rig_under_way(row, steps);
                plant(&r, 0, 1000000, statuses[k]);
                assert_true(check_advance(&r));
                assert_true(check_advance(&r));
                unplant(&r);
                check_recovery(&r);
                rig_close(&r);
            }
        }
    }
}

/* One failing force at each place within a step. Where there may be a shorter way round it, or
 * another iterate, the method may take it; an error that is not the state's is passed on at once.
 */
static void check_single_failures(const dl_method_row *row, int steps, dl_status status) {
    bool failed_once = false;
    for (int calls = 0; calls < 20; calls++) {
        rig r = rig_under_way(row, steps);
        plant(&r, calls, 1, status);
        const bool failed = check_advance(&r);
        failed_once |= failed;
        if (status == DL_ERROR && failed != (planted.failures == 0))
            fail_msg("%s: failure at call %d of a step: %s", row->name, calls,
                     failed ? "reported though not met" : "ignored");
        unplant(&r);
        check_recovery(&r);
        rig_close(&r);
    }
    const bool may_go_round =
        row->flags & (status == DL_ERROR ? DL_ADAPTIVE : DL_ADAPTIVE | DL_IMPLICIT);
    if (!failed_once && !may_go_round)
        fail_msg("%s: %s is never reported", row->name, dl_status_name(status));
}

static void single_failure_leaves_the_state(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        check_single_failures(row, 0, DL_ERROR);
        check_single_failures(row, 5, DL_ERROR);
        check_single_failures(row, 5, DL_UNSTABLE);
    }
}

/* A step in the middle of a run may be avoided by a shorter one: methods that choose their step try
 * that before they give up. */
static void adaptive_methods_go_round_a_failure(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_ADAPTIVE))
            continue;
        rig r = rig_under_way(row, 5);
        plant(&r, 1, 1, DL_UNSTABLE);
        while (planted.failures > 0)
            assert_false(check_advance(&r));
        unplant(&r);
        dl_method_stats stats;
        dl_method_stats_get(r.method, &stats);
        if (stats.rejected < 1 && !(row->flags & DL_IMPLICIT)) /* a solver may just try again */
            fail_msg("%s: rejected no step", row->name);
        check_recovery(&r);
        rig_close(&r);
    }
}

/* No planted failure: two particles at one place. */
static void coinciding_particles_are_reported(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        rig r = rig_under_way(row, 3);
        const size_t particles = r.model->particles;
        for (size_t axis = 0; axis < 3; axis++) {
            double *const component = r.method->y + axis * particles;
            component[1] = component[0];
            component[3 * particles + 1] = component[3 * particles];
        }
        rig_jumped(&r);
        double before[6 * 13];
        memcpy(before, r.method->y, sizeof before);
        dl_error error = {""};
        const dl_status status = dl_method_advance(r.method, 0.05, &error);
        if (status != DL_UNSTABLE || !strstr(error.message, "particle"))
            fail_msg("%s: status %s, \"%s\"", row->name, dl_status_name(status), error.message);
        assert_memory_equal(r.method->y, before, sizeof before);
        rig_close(&r);
    }
}

/* A position that is no number has no acceleration, and with such a velocity there is none soon:
 * leap-frog looks at a position in the step after. */
static void a_state_that_is_no_number_is_reported(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        for (size_t where = 0; where < 2; where++) {
            rig r = rig_under_way(row, 3);
            r.method->y[4 + where * r.method->n] = NAN;
            rig_jumped(&r);
            double before[6 * 13], t = 0;
            dl_error error = {""};
            dl_status status = DL_OK;
            for (size_t k = 0; k <= where && !status; k++) {
                t = r.method->t;
                memcpy(before, r.method->y, sizeof before);
                status = dl_method_advance(r.method, 0.05, &error);
            }
            if (status != DL_UNSTABLE && status != DL_NONLINEAR_FAILURE &&
                status != DL_STEP_FAILURE)
                fail_msg("%s: status %s, \"%s\"", row->name, dl_status_name(status), error.message);
            assert_true(strlen(error.message) > 10 && r.method->t == t);
            assert_memory_equal(r.method->y, before, sizeof before);
            rig_close(&r);
        }
    }
}

/* --- what flags promise ------------------------------------------------------------------------
 */

static void time_symmetric_methods_come_back(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_TIME_SYMMETRIC))
            continue;
        rig there = rig_open(row, fixture_cluster(), "step=0.005");
        rig_steps(&there, 40);
        rig_state(&there);
        for (size_t i = there.length / 2; i < there.length; i++)
            there.y[i] *= -1;
        rig back = rig_open_at(row, fixture_cluster(), "step=0.005", there.y);
        rig_steps(&back, 40);
        rig_state(&back);
        for (size_t i = back.length / 2; i < back.length; i++)
            back.y[i] *= -1;
        dl_model_initial_state(there.model, there.y);
        const double difference = largest_difference(there.y, back.y, back.length);
        if (!(difference < 1e-10))
            fail_msg("%s: comes back to %g of its start", row->name, difference);
        rig_close(&there);
        rig_close(&back);
        rows++;
    }
    assert_true(rows >= 8);
}

static void promised_momenta_stay(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_CONSERVES_MOMENTUM))
            continue;
        rig r = rig_open(row, fixture_stream(50), "step=0.005");
        double linear[3], angular[3], linear_end[3], angular_end[3];
        dl_model_momentum(r.model, rig_state(&r), linear, angular);
        rig_steps(&r, 100);
        dl_model_momentum(r.model, rig_state(&r), linear_end, angular_end);
        const double momentum = 34 * 50, lever = 34 * 50 * 12;
        for (int axis = 0; axis < 3; axis++) {
            assert_true(fabs(linear_end[axis] - linear[axis]) < 1e-12 * momentum);
            assert_true(fabs(angular_end[axis] - angular[axis]) < 1e-12 * lever);
        }
        rig_close(&r);
        rows++;
    }
    assert_true(rows >= 8);
}

static double energy_error(rig *r, double start) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(r->model, rig_state(r), &energy, NULL), DL_OK);
    return fabs(energy.total - start);
}

static void promised_energy_stays(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_CONSERVES_ENERGY))
            continue;
        rig r = rig_open(row, fixture_cluster(),
                         row->flags & DL_FIXED_STEP ? "step=0.01" : "rtol=1e-5 atol=1e-7");
        double scale;
        assert_int_equal(dl_model_energy_scale(r.model, rig_state(&r), &scale, NULL), DL_OK);
        dl_energy energy;
        assert_int_equal(dl_model_energy(r.model, r.y, &energy, NULL), DL_OK);
        for (int i = 0; i < 200; i++)
            rig_step(&r, 10);
        assert_true(energy_error(&r, energy.total) < 1e-12 * scale);
        rig_close(&r);
    }
}

static double largest_energy_error(rig *r, double start, int steps) {
    double largest = 0;
    for (int i = 0; i < steps; i++) {
        rig_step(r, INFINITY);
        largest = fmax(largest, energy_error(r, start));
    }
    return largest;
}

/* A run whose energy error is the method's, far above roundoff: by a step as long as that takes. */
static rig inexact_run(const dl_method_row *row, double *energy) {
    double step = 0.05;
    for (;;) {
        char options[32];
        snprintf(options, sizeof options, "step=%.17g", step);
        rig r = rig_open(row, fixture_kepler(0.4), options);
        dl_energy start;
        assert_int_equal(dl_model_energy(r.model, rig_state(&r), &start, NULL), DL_OK);
        *energy = start.total;
        if (largest_energy_error(&r, start.total, 100) > 1e-10)
            return r;
        rig_close(&r);
        step *= 1.5;
        assert_true(step < 2);
    }
}

/* A symplectic method's energy error does not grow from orbit to orbit. */
static void symplectic_methods_do_not_drift(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_SYMPLECTIC))
            continue;
        double start;
        rig r = inexact_run(row, &start);
        const double first = largest_energy_error(&r, start, 6000);
        const double second = largest_energy_error(&r, start, 6000);
        if (!(second < 1.2 * first))
            fail_msg("%s: energy error %g, later %g", row->name, first, second);
        rig_close(&r);
    }
}

/* --- particular methods ------------------------------------------------------------------------
 */

/* TR323 (3.1)-(3.3) written out for two bodies under F = -m1 m2 / r^2. */
static void leapfrog_is_the_papers(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("leapfrog", &row, NULL), DL_OK);
    rig r = rig_open(row, fixture_kepler(0.5), "step=0.01");
    double y[8];
    memcpy(y, rig_state(&r), sizeof y);
    const double mass[2] = {0.75, 0.25}, h = 0.01;
    for (int k = 0; k < 100; k++) {
        const double dx = y[0] - y[1], dy = y[2] - y[3], distance = sqrt(dx * dx + dy * dy);
        const double factor = mass[0] * mass[1] / (distance * distance * distance);
        for (int i = 0; i < 2; i++) {
            const double sign = i == 0 ? -1 : 1, share = k == 0 ? h / 2 : h;
            y[4 + i] += share * sign * factor * dx / mass[i];
            y[6 + i] += share * sign * factor * dy / mass[i];
            y[i] += h * y[4 + i];
            y[2 + i] += h * y[6 + i];
        }
        rig_step(&r, INFINITY);
        assert_true(largest_difference(r.method->y, y, 8) < 1e-12);
    }
    rig_close(&r);
}

/* Its state at whole steps is velocity Verlet's. */
static void leapfrog_state_is_synchronous(void **state) {
    (void)state;
    const dl_method_row *leapfrog, *verlet;
    assert_int_equal(dl_method_find("leapfrog", &leapfrog, NULL), DL_OK);
    assert_int_equal(dl_method_find("composition-2-verlet", &verlet, NULL), DL_OK);
    rig a = rig_open(leapfrog, fixture_cluster(), "step=0.005");
    rig b = rig_open(verlet, fixture_cluster(), "step=0.005");
    for (int k = 0; k <= 40; k++) {
        assert_true(largest_difference(rig_state(&a), rig_state(&b), a.length) < 1e-11);
        rig_steps(&a, 1);
        rig_steps(&b, 1);
    }
    rig_close(&a);
    rig_close(&b);
}

/* Stiff pairs that hardly vibrate, far from one another: only Newton's method with the right
 * Jacobian takes steps as long as the smooth motion allows. */
static dl_scene *stiff_pairs(double stretch) {
    enum { pairs = 6 };
    dl_scene *scene = fixture_scene("stiff-pairs", 2, 2 * pairs);
    fixture_law(scene, 1.5, 1e6, 2, 1e6, 5);
    for (size_t i = 0; i < pairs; i++) {
        const double way = i % 2 ? -1 : 1, x = -3 * way, y = 1.6 * (double)i;
        fixture_place(scene, 2 * i, (double[3]){x, y}, (double[3]){way});
        fixture_place(scene, 2 * i + 1, (double[3]){x + 1 + stretch, y}, (double[3]){way});
    }
    return scene;
}

static void newton_has_the_right_jacobian(void **state) {
    (void)state;
    static const struct {
        const char *name;
        double stretch; /* GMRES stops where a residual is within the tolerances: a small one */
    } cases[] = {{"cvode-bdf-klu", 5e-4}, {"cvode-bdf-krylov", 5e-7}};
    for (size_t k = 0; k < 2; k++) {
        const dl_method_row *row;
        assert_int_equal(dl_method_find(cases[k].name, &row, NULL), DL_OK);
        rig r = rig_open(row, stiff_pairs(cases[k].stretch), "rtol=1e-3 atol=1e-2 max_order=2");
        rig_run(&r, 6);
        rig_state(&r);
        for (size_t i = 0; i < 12; i++) { /* all have flown 6 */
            const double way = i / 2 % 2 ? -1 : 1;
            assert_true(fabs(r.y[i] - way * 3 - (double)(i % 2)) < 0.05);
        }
        dl_method_stats stats;
        dl_method_stats_get(r.method, &stats);
        print_message("%s: %lu steps, %lu rejected, %lu iterations\n", row->name, stats.steps,
                      stats.rejected, stats.nonlinear_iterations);
        assert_true(stats.steps < 200 && stats.nonlinear_iterations < 400);
        rig_close(&r);
    }
}

/* Light particles between heavy ones, in lanes that meet: the pattern of a stiff Jacobian changes
 * while Newton's method depends on it. The force vanishes at the cutoff R, X = R^3:
 * c (r^-2 - (1 + X) r^-5 + X r^-8). */
static dl_scene *meeting_trains(void) {
    enum { lanes = 4 };
    const double cutoff = 1.5, x3 = cutoff * cutoff * cutoff, c = 1e6;
    dl_scene *scene = fixture_scene("meeting-trains", 2, 3 * lanes);
    scene->law.pieces = 1;
    scene->law.piece[0] =
        (dl_piece){.until = cutoff, .terms = 3, .term = {{c, 2}, {-(1 + x3) * c, 5}, {x3 * c, 8}}};
    for (size_t i = 0; i < 3 * lanes; i++) {
        const size_t lane = i / 3;
        const double way = lane % 2 ? -1 : 1;
        const double at[3] = {1.05 * ((double)(i % 3) - 1) - 4 * way, 1.4 * (double)lane};
        fixture_place(scene, i, at, (double[3]){way});
        scene->inertia[i] = i % 3 == 1 ? 1 : 1e12;
    }
    scene->kernel = DL_KERNEL_NEIGHBOUR_LIST;
    scene->skin = 0.5;
    return scene;
}

static unsigned long pattern_generation(rig *r) {
    const dl_sparsity *pattern = NULL;
    assert_int_equal(dl_model_sparsity(r->model, rig_state(r), NULL, &pattern, NULL), DL_OK);
    return pattern->generation;
}

static void sparse_jacobian_follows_its_pattern(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("cvode-bdf-klu", &row, NULL), DL_OK);
    rig r = rig_open(row, meeting_trains(), "rtol=1e-3 atol=1 max_order=2");
    const unsigned long before = pattern_generation(&r);
    for (int k = 1; k <= 100; k++)
        rig_run(&r, 0.05 * k);
    assert_true(pattern_generation(&r) > before + 5);
    dl_method_stats stats;
    dl_method_stats_get(r.method, &stats);
    print_message("%lu steps, %lu rejected, %lu iterations\n", stats.steps, stats.rejected,
                  stats.nonlinear_iterations);
    assert_true(stats.rejected * 20 < stats.steps);
    assert_true(stats.nonlinear_iterations < 2 * stats.steps);
    rig_close(&r);
}

/* A step that leaves nothing to hold on to ends with a message, not with a hang or an abort. */
static void impossible_tolerance_is_a_step_failure(void **state) {
    (void)state;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_ADAPTIVE))
            continue;
        char options[64];
        rig r = rig_open(row, fixture_kepler(0.5), tolerance_options(row, options, 1e-30, 1e-30));
        double before[8];
        memcpy(before, r.method->y, sizeof before);
        dl_error error = {""};
        dl_status status = DL_OK;
        double t = 0;
        for (int i = 0; i < 50 && !status; i++) {
            t = r.method->t;
            memcpy(before, r.method->y, sizeof before);
            status = dl_method_advance(r.method, 1, &error);
        }
        if (status) {
            assert_true(status == DL_STEP_FAILURE || status == DL_NONLINEAR_FAILURE);
            assert_true(strlen(error.message) > 10);
            assert_true(r.method->t == t);
            assert_memory_equal(r.method->y, before, sizeof before);
        }
        rig_close(&r);
    }
}

/* A pair that rests where its force jumps from one sign to the other: steps within a tight
 * tolerance collapse, and GSL would go on with them for ever. */
static dl_scene *resting_on_a_jump(void) {
    dl_scene *scene = fixture_scene("resting-on-a-jump", 2, 2);
    scene->law.pieces = 2;
    scene->law.piece[0] = (dl_piece){.until = 1, .terms = 1, .term = {{1, 2}}};
    scene->law.piece[1] = (dl_piece){.until = 2, .terms = 1, .term = {{-1, 2}}};
    fixture_place(scene, 1, (double[3]){1, 0}, (double[3]){0});
    return scene;
}

static void steps_that_collapse_are_a_failure(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("gsl-rkf45", &row, NULL), DL_OK);
    rig r = rig_open(row, resting_on_a_jump(), "rtol=1e-13 atol=1e-16");
    dl_error error = {""};
    dl_status status = DL_OK;
    int steps = 0;
    for (; steps < 100000 && !status && r.method->t < 0.05; steps++)
        status = dl_method_advance(r.method, 0.05, &error);
    print_message("%d steps to t = %g: %s\n", steps, r.method->t, error.message);
    assert_int_equal(status, DL_STEP_FAILURE);
    assert_non_null(strstr(error.message, "accuracy"));
    rig_close(&r);
}

/* GSL's bsimp takes a fixed step for done though its iteration has run away. */
static void runaway_steps_are_a_failure(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("gsl-bsimp", &row, NULL), DL_OK);
    rig r = rig_open(row, fixture_kepler(0.1), "step=1.3333333333333333");
    dl_error error = {""};
    dl_status status = DL_OK;
    for (int k = 0; k < 3 && !status; k++)
        status = dl_method_advance(r.method, INFINITY, &error);
    assert_int_equal(status, DL_NONLINEAR_FAILURE);
    rig_close(&r);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(registry_is_complete),
        cmocka_unit_test(rows_are_filled_in),
        cmocka_unit_test(unknown_method_is_refused),
        cmocka_unit_test(unknown_options_are_refused),
        cmocka_unit_test(options_are_written_and_read),
        cmocka_unit_test(ignored_tolerances_are_refused),
        cmocka_unit_test(restart_is_like_going_on),
        cmocka_unit_test(looking_changes_nothing),
        cmocka_unit_test(jumps_are_noticed),
        cmocka_unit_test(work_is_counted),
        cmocka_unit_test(explicit_methods_take_their_forces),
        cmocka_unit_test(steps_are_of_what_rows_say),
        cmocka_unit_test(words_of_tables_end_in_their_order),
        cmocka_unit_test(steps_take_the_forces_that_rows_say),
        cmocka_unit_test(lasting_failure_is_reported),
        cmocka_unit_test(single_failure_leaves_the_state),
        cmocka_unit_test(adaptive_methods_go_round_a_failure),
        cmocka_unit_test(coinciding_particles_are_reported),
        cmocka_unit_test(a_state_that_is_no_number_is_reported),
        cmocka_unit_test(time_symmetric_methods_come_back),
        cmocka_unit_test(promised_momenta_stay),
        cmocka_unit_test(promised_energy_stays),
        cmocka_unit_test(symplectic_methods_do_not_drift),
        cmocka_unit_test(leapfrog_is_the_papers),
        cmocka_unit_test(leapfrog_state_is_synchronous),
        cmocka_unit_test(newton_has_the_right_jacobian),
        cmocka_unit_test(sparse_jacobian_follows_its_pattern),
        cmocka_unit_test(impossible_tolerance_is_a_step_failure),
        cmocka_unit_test(steps_that_collapse_are_a_failure),
        cmocka_unit_test(runaway_steps_are_a_failure),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
