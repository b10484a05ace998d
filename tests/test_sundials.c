/* What SUNDIALS' methods promise beyond the contract of every row: solvers, preconditioners, stops,
 * splittings, options. */
#include "contract.h"

#include <arkode/arkode_butcher_dirk.h>
#include <arkode/arkode_butcher_erk.h>
#include <arkode/arkode_mristep.h>

#include "driftlab/version.h"

static const dl_method_row *row_of(const char *name) {
    const dl_method_row *row = NULL;
    dl_error error = {""};
    if (dl_method_find(name, &row, &error))
        fail_msg("%s", error.message);
    return row;
}

static dl_method_stats stats_of(const rig *r) {
    dl_method_stats stats;
    dl_method_stats_get(r->method, &stats);
    return stats;
}

/* --- tables ------------------------------------------------------------------------------------
 */

static int tables_of(const char *method) {
    const dl_parameter *const table = dl_parameter_find(row_of(method)->options, "table");
    int tables = 0;
    while (table->words[tables])
        tables++;
    return tables;
}

/* Those for a force in two parts; others take the slow one in a part implicit, a part explicit. */
static int tables_for_two_parts(void) {
    int tables = 0;
    for (int id = ARKODE_MIN_MRI_NUM; id <= ARKODE_MAX_MRI_NUM; id++) {
        MRIStepCoupling table = MRIStepCoupling_LoadTable((ARKODE_MRITableID)id);
        assert_non_null(table);
        tables += !(table->W && table->G);
        MRIStepCoupling_Free(table);
    }
    return tables;
}

/* As many as SUNDIALS numbers, whichever release of it this is. */
static void every_table_is_offered(void **state) {
    (void)state;
    assert_int_equal(tables_of("arkode-erk"), ARKODE_MAX_ERK_NUM - ARKODE_MIN_ERK_NUM + 1);
    assert_int_equal(tables_of("arkode-dirk"), ARKODE_MAX_DIRK_NUM - ARKODE_MIN_DIRK_NUM + 1);
    assert_int_equal(tables_of("arkode-mri"), tables_for_two_parts());
}

/* --- linear solvers ----------------------------------------------------------------------------
 */

/* Flies the stiff crystal until `end`; its particles are where they belong. */
static dl_method_stats fly_until(double end, const char *name, const char *solver) {
    char options[160];
    const char *const loose = has_option(row_of(name), "step") ? "" : "rtol=1e-3 atol=1e-2";
    snprintf(options, sizeof options, "%s %s", loose, solver);
    rig r = rig_open(row_of(name), fixture_stiff_crystal(1e5, 1e-4), options);
    double start[4 * 36];
    memcpy(start, rig_state(&r), sizeof start);
    rig_run(&r, end);
    rig_state(&r);
    for (size_t i = 0; i < 72; i++)
        if (!(fabs(r.y[i] - start[i] - (i < 36 ? end : 0)) < 0.05))
            fail_msg("%s %s: coordinate %zu is off by %g", name, solver, i,
                     r.y[i] - start[i] - (i < 36 ? end : 0));
    const dl_method_stats stats = stats_of(&r);
    print_message("%-18s %-78s %5lu steps %6lu linear iterations\n", name, solver, stats.steps,
                  stats.linear_iterations);
    rig_close(&r);
    return stats;
}

static dl_method_stats fly(const char *name, const char *solver) {
    return fly_until(6, name, solver);
}

/* A particle's own block is worth something, the whole of I - gamma^2 A nearly all. */
static void preconditioners_save_iterations(void **state) {
    (void)state;
    static const struct {
        double end;
        const char *name, *options;
    } cases[] = {
        {6, "cvode-bdf-krylov", "max_order=2"},
        {0.4, "arkode-imex", "step=0.002 rtol=1e-3 atol=1e-3 solver=krylov krylov_dimension=40"},
        {3, "arkode-dirk", "step=0.01 rtol=1e-3 atol=1e-3 solver=krylov krylov_dimension=40"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        static const char *const words[] = {"none", "blocks", "klu"};
        unsigned long iterations[3];
        for (size_t p = 0; p < 3; p++) {
            char options[128];
            snprintf(options, sizeof options, "%s preconditioner=%s", cases[k].options, words[p]);
            const dl_method_stats stats = fly_until(cases[k].end, cases[k].name, options);
            iterations[p] = stats.linear_iterations;
            assert_true((stats.factorisations > 0) == (p == 2));
        }
        assert_true(iterations[1] < iterations[0]);
        assert_true(3 * iterations[2] < iterations[0] && 2 * iterations[2] < iterations[1]);
    }
}

static void every_krylov_method_solves(void **state) {
    (void)state;
    static const char *const words[] = {"gmres", "fgmres", "bicgstab", "tfqmr"};
    for (size_t k = 0; k < 4; k++)
        for (int whole = 0; whole < 2; whole++) {
            char options[96];
            snprintf(options, sizeof options, "max_order=2 krylov=%s preconditioner=%s", words[k],
                     whole ? "klu" : "blocks");
            const dl_method_stats stats = fly("cvode-bdf-krylov", options);
            assert_true(stats.steps < 300 && stats.linear_iterations > 0);
        }
}

/* With five dimensions an unpreconditioned space is too small for long steps. */
static void krylov_dimension_counts(void **state) {
    (void)state;
    const dl_method_stats few =
        fly("cvode-bdf-krylov", "max_order=2 preconditioner=none krylov_dimension=5");
    const dl_method_stats many =
        fly("cvode-bdf-krylov", "max_order=2 preconditioner=none krylov_dimension=30");
    assert_true(many.steps * 10 < few.steps);
    assert_true(many.linear_iterations > 3 * many.nonlinear_iterations);
}

/* Iterations that a depth of Anderson's acceleration takes to fly a little way. */
static unsigned long iterations_of(const char *name, const char *options, int depth) {
    char whole[96];
    snprintf(whole, sizeof whole, "rtol=1e-3 atol=1e-3 %s anderson=%d", options, depth);
    rig r = rig_open(row_of(name), fixture_stiff_crystal(1e3, 1e-3), whole);
    rig_run(&r, 1);
    const dl_method_stats stats = stats_of(&r);
    print_message("%-22s anderson=%d %4lu steps %5lu iterations\n", name, depth, stats.steps,
                  stats.nonlinear_iterations);
    rig_close(&r);
    return stats.nonlinear_iterations;
}

static void anderson_counts(void **state) {
    (void)state;
    assert_true(iterations_of("cvode-adams", "", 0) != iterations_of("cvode-adams", "", 3));
    assert_true(iterations_of("cvode-bdf-fixed-point", "", 0) !=
                iterations_of("cvode-bdf-fixed-point", "", 3));
    static const char *const option = "solver=fixed-point";
    const unsigned long plain = iterations_of("arkode-dirk", option, 0);
    const unsigned long two = iterations_of("arkode-dirk", option, 2);
    const unsigned long four = iterations_of("arkode-dirk", option, 4);
    assert_true(two < plain && four < two);
}

/* Whatever solves the stages, the trajectory is the same. */
static void solvers_agree(void **state) {
    (void)state;
    static const char *const names[] = {"arkode-dirk", "arkode-imex"};
    for (size_t m = 0; m < 2; m++) {
        const dl_method_row *const row = row_of(names[m]);
        const dl_parameter *const solver = dl_parameter_find(row->options, "solver");
        double first[6 * 13];
        for (size_t k = 0; solver->words[k]; k++) {
            char options[96];
            snprintf(options, sizeof options, "step=0.002 rtol=1e-11 atol=1e-13 solver=%s",
                     solver->words[k]);
            rig r = rig_open(row, fixture_cluster(), options);
            rig_run(&r, 0.2);
            if (k == 0)
                memcpy(first, rig_state(&r), sizeof first);
            const double difference = largest_difference(rig_state(&r), first, r.length);
            if (!(difference < 1e-9))
                fail_msg("%s with solver=%s differs by %g", names[m], solver->words[k], difference);
            rig_close(&r);
        }
    }
}

/* --- stops -------------------------------------------------------------------------------------
 */

/* What ARKODE returns at a stop is the step's own value, not one interpolated: the same as that of
 * one fixed step of the same length, energy and all. */
static void values_at_stops_are_the_steps_own(void **state) {
    (void)state;
    static const char *const names[] = {"arkode-erk", "arkode-dirk", "arkode-imex"};
    for (size_t m = 0; m < 3; m++) {
        const dl_method_row *const row = row_of(names[m]);
        rig r = rig_open(row, fixture_cluster(), "rtol=1e-9 atol=1e-11");
        double before[6 * 13], t = 0;
        const double stop = 0.1234;
        while (r.method->t < stop) {
            memcpy(before, r.method->y, sizeof before);
            t = r.method->t;
            rig_step(&r, stop);
        }
        assert_true(r.method->t == stop);
        char options[96];
        snprintf(options, sizeof options, "step=%.17g %s", stop - t, solved_options(row));
        rig once = rig_open_at(row, fixture_cluster(), options, before);
        rig_steps(&once, 1);
        const double difference = largest_difference(r.method->y, once.method->y, r.length);
        const double moved = largest_difference(r.method->y, before, r.length);
        if (!(difference < 1e-9 * moved + 1e-12))
            fail_msg("%s: differs by %g at the stop, %g after the step before", names[m],
                     difference, moved);
        dl_energy here, there;
        assert_int_equal(dl_model_energy(r.model, r.method->y, &here, NULL), DL_OK);
        assert_int_equal(dl_model_energy(once.model, once.method->y, &there, NULL), DL_OK);
        assert_true(fabs(here.total - there.total) < 1e-9 * fabs(there.pair));
        rig_close(&r);
        rig_close(&once);
    }
}

/* --- splittings --------------------------------------------------------------------------------
 */

/* TR299's swirl with its jump at D tapered, so that orders can be seen: molecular forces fast,
 * gravitation slow. */
static dl_scene *swirl(void) {
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (dl_scene_read(DL_STUDIES "/swirl/swirl.yaml", &scene, &error))
        fail_msg("%s", error.message);
    scene->law.piece[0].end = DL_END_TAPER;
    scene->law.piece[0].width = 1;
    scene->law.piece[1].part[0] = DL_PART_SLOW;
    return scene;
}

/* TR323's law on a block of fluid that falls; gravity is slow. */
static dl_scene *falling_fluid(void) {
    enum { side = 6, particles = side * side };
    dl_scene *scene = fixture_scene("falling-fluid", 2, particles);
    fixture_law(scene, 0.5, 25, 2, 5, 4);
    scene->law.piece[0].end = DL_END_TAPER;
    scene->law.piece[0].width = 0.2;
    for (size_t i = 0; i < particles; i++) {
        const unsigned k = 4 * (unsigned)i;
        const size_t row = i / side;
        const double x = 0.42 * (double)(i % side) + 0.03 * fixture_noise(k);
        const double y = 0.42 * (double)row + 0.03 * fixture_noise(k + 1);
        fixture_place(scene, i, (double[3]){x, y},
                      (double[3]){fixture_noise(k + 2), fixture_noise(k + 3)});
    }
    scene->gravity[1] = -980;
    return scene;
}

static const struct split_case {
    dl_scene *(*make)(void);
    double end, coarsest; /* time, step */
    const char *name, *options;
    int order;
} split_cases[] = {
    {swirl, 8e-3, 5e-4, "arkode-imex", "rtol=1e-13 atol=1e-11 table=ark324-3", 3},
    {swirl, 8e-3, 2e-3, "arkode-imex", "rtol=1e-13 atol=1e-11 table=ark437-4", 4},
    {swirl, 8e-3, 2e-3, "arkode-mri",
     "substeps=4 table=gark-erk33a-3 fast_table=bogacki-shampine-3", 3},
    {swirl, 8e-3, 1e-3, "arkode-mri", "substeps=4 table=gark-irk21a-2 fast_table=heun-euler-2", 2},
    {swirl, 8e-3, 2e-3, "arkode-mri", "substeps=4 table=gark-erk45a-4 fast_table=zonneveld-4", 4},
    {falling_fluid, 4e-2, 1e-2, "arkode-imex", "rtol=1e-13 atol=1e-13 table=ark324-3", 3},
    {falling_fluid, 4e-2, 1e-2, "arkode-imex", "rtol=1e-13 atol=1e-13 table=ark437-4", 4},
    {falling_fluid, 4e-2, 1e-2, "arkode-mri",
     "substeps=4 table=gark-erk33a-3 fast_table=bogacki-shampine-3", 3},
    {falling_fluid, 4e-2, 1e-2, "arkode-mri",
     "substeps=4 table=gark-esdirk34a-3 fast_table=bogacki-shampine-3", 3},
    {falling_fluid, 4e-2, 1e-2, "arkode-mri",
     "substeps=4 table=gark-erk45a-4 fast_table=zonneveld-4", 4},
};

enum { points = 4 };

static double error_at(const struct split_case *on, double step, const double *exact) {
    char options[160];
    snprintf(options, sizeof options, "step=%.17g %s", step, on->options);
    dl_scene *scene = on->make();
    rig r = rig_open(row_of(on->name), scene, options);
    rig_run(&r, on->end);
    const double error = largest_difference(rig_state(&r), exact, r.length);
    rig_close(&r);
    return error;
}

static void check_split_order(const struct split_case *on, const double *exact) {
    double step[points], error[points];
    for (int i = 0; i < points; i++) {
        step[i] = on->coarsest / (1 << i);
        error[i] = error_at(on, step[i], exact);
    }
    const double found = fitted_order(step, error, points);
    print_message("%-12s %-70s order %.2f (%.1e ... %.1e)\n", on->name, on->options, found,
                  error[0], error[points - 1]);
    if (!(fabs(found - on->order) < 0.3))
        fail_msg("%s %s: order %g, expected %d", on->name, on->options, found, on->order);
}

static void split_methods_converge_on_scenes(void **state) {
    (void)state;
    const size_t count = sizeof split_cases / sizeof *split_cases;
    for (size_t k = 0; k < count;) {
        dl_scene *(*const make)(void) = split_cases[k].make;
        char options[64];
        snprintf(options, sizeof options, "step=%.17g", split_cases[k].end / 100);
        rig exact = rig_open(row_of("composition-8-kahan-li"), make(), options);
        rig_run(&exact, split_cases[k].end);
        for (; k < count && split_cases[k].make == make; k++)
            check_split_order(&split_cases[k], exact.method->y);
        rig_close(&exact);
    }
}

/* The slow part is looked at as seldom as that allows. */
static unsigned long evaluations[2];
static dl_status (*part_acceleration)(dl_model *model, dl_part part, const double *q, double *a,
                                      dl_error *error);

static dl_status counted_part(dl_model *model, dl_part part, const double *q, double *a,
                              dl_error *error) {
    evaluations[part]++;
    return part_acceleration(model, part, q, a, error);
}

static void substeps_are_of_the_fast_part(void **state) {
    (void)state;
    unsigned long slow[2], fast[2];
    for (int k = 0; k < 2; k++) {
        char options[64];
        snprintf(options, sizeof options, "step=0.01 substeps=%d", k ? 40 : 10);
        rig r = rig_open(row_of("arkode-mri"), fixture_cluster(), options);
        part_acceleration = r.model->part_acceleration;
        r.model->part_acceleration = counted_part;
        evaluations[DL_PART_FAST] = evaluations[DL_PART_SLOW] = 0;
        rig_steps(&r, 20);
        slow[k] = evaluations[DL_PART_SLOW];
        fast[k] = evaluations[DL_PART_FAST];
        rig_close(&r);
    }
    assert_true(slow[0] == slow[1] && slow[0] < 160);
    assert_true(fast[1] > 2 * fast[0] && fast[0] > 5 * slow[0]);
}

/* --- options -----------------------------------------------------------------------------------
 */

static dl_status try_options(const char *name, const char *text, dl_error *error) {
    const dl_method_row *const row = row_of(name);
    dl_scene *scene = fixture_cluster();
    fixture_split(scene);
    dl_model *model = NULL;
    dl_method *method = NULL;
    void *options = NULL;
    double y[6 * 13];
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    dl_model_initial_state(model, y);
    assert_int_equal(dl_method_options_create(row, scene, &options, NULL), DL_OK);
    set_options(row, options, text);
    const dl_status status = dl_method_create(row, model, options, y, &method, error);
    dl_method_destroy(method);
    dl_method_options_free(row, options);
    dl_model_free(model);
    dl_scene_free(scene);
    return status;
}

/* An option that the others leave unused is refused even where it is the default. */
static void unused_options_are_refused(void **state) {
    (void)state;
    static const struct {
        const char *name, *options, *says; /* NULL: accepted */
    } cases[] = {
        {"arkode-erk", "step=0.01 rtol=1e-6", "rtol"},
        {"arkode-erk", "atol=1e-10 step=0.01", "atol"},
        {"arkode-erk", "step=0 rtol=1e-6", NULL},
        {"gsl-rk8pd", "step=0.01 rtol=1e-6", "step=0"},
        {"gsl-bsimp", "step=0.01 atol=1e-6", "atol"},
        {"gsl-rk4imp", "step=0.01 rtol=1e-8", NULL},
        {"arkode-dirk", "step=0.01 rtol=1e-8", NULL},
        {"arkode-dirk", "krylov=gmres", "solver=krylov"},
        {"arkode-dirk", "solver=krylov krylov=tfqmr preconditioner=none", NULL},
        {"arkode-dirk", "solver=krylov anderson=0", "anderson"},
        {"arkode-dirk", "solver=fixed-point anderson=2", NULL},
        {"arkode-imex", "solver=dense preconditioner=blocks", "preconditioner"},
        {"arkode-imex", "solver=dense", NULL},
        {"arkode-mri", "fast_rtol=1e-6", "substeps=10"},
        {"arkode-mri", "substeps=0 fast_rtol=1e-8", NULL},
        {"cvode-bdf-krylov", "rtol=1e-5 krylov_dimension=9", NULL},
        {"arkode-erk", "table=knoth-wolke-3", "no error estimate"},
        {"arkode-erk", "table=knoth-wolke-3 step=0.01", NULL},
        {"arkode-mri", "fast_table=knoth-wolke-3 substeps=0", "no error estimate"},
        {"arkode-mri", "fast_table=knoth-wolke-3", NULL},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        dl_error error = {""};
        const dl_status status = try_options(cases[k].name, cases[k].options, &error);
        if (status != (cases[k].says ? DL_INPUT : DL_OK))
            fail_msg("%s %s: %s \"%s\"", cases[k].name, cases[k].options, dl_status_name(status),
                     error.message);
        if (cases[k].says && !strstr(error.message, cases[k].says))
            fail_msg("%s %s: \"%s\"", cases[k].name, cases[k].options, error.message);
    }
}

/* What is written is what is used. */
static void unused_options_are_not_written(void **state) {
    (void)state;
    static const struct {
        const char *name, *options, *written;
    } cases[] = {
        {"arkode-erk", "step=0.25", "step=0.25 table=dormand-prince-5"},
        {"arkode-erk", "", "step=0 rtol=1e-06 atol=1e-10 table=dormand-prince-5"},
        {"gsl-rk4", "step=0.5", "step=0.5"},
        {"cvode-bdf-klu", "", "rtol=1e-06 atol=1e-10 max_order=5"},
        {"arkode-dirk", "", "step=0 rtol=1e-06 atol=1e-10 table=esdirk437-4 solver=klu"},
        {"arkode-dirk", "solver=fixed-point",
         "step=0 rtol=1e-06 atol=1e-10 table=esdirk437-4 solver=fixed-point anderson=0"},
    };
    dl_scene *scene = fixture_cluster();
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        const dl_method_row *const row = row_of(cases[k].name);
        void *options = NULL;
        char text[512];
        assert_int_equal(dl_method_options_create(row, scene, &options, NULL), DL_OK);
        set_options(row, options, cases[k].options);
        dl_method_options_format(row, options, text, sizeof text);
        assert_string_equal(text, cases[k].written);
        dl_method_options_free(row, options);
    }
    dl_scene_free(scene);
}

/* --- SUNDIALS 6.6 and later --------------------------------------------------------------------
 */

static bool sundials_has_more(void) {
    dl_component components[DL_MAX_COMPONENTS];
    const size_t count = dl_components(components);
    long major = 0, minor = 0;
    for (size_t k = 0; k < count; k++)
        if (strcmp(components[k].name, "SUNDIALS") == 0) {
            char *point = NULL;
            major = strtol(components[k].version, &point, 10);
            assert_true(*point == '.');
            minor = strtol(point + 1, NULL, 10);
        }
    assert_true(major >= 6);
    return major > 6 || minor >= 6;
}

static void further_rows_are_where_sundials_has_them(void **state) {
    (void)state;
    static const char *const names[] = {"arkode-sprk", "arkode-erk-relaxation"};
    for (size_t k = 0; k < 2; k++) {
        const dl_method_row *row = NULL;
        assert_int_equal(dl_method_find(names[k], &row, NULL),
                         sundials_has_more() ? DL_OK : DL_INPUT);
    }
}

/* Relaxed steps keep the energy, those that are cut short by a stop as well. */
static void relaxed_energy_stays_at_stops(void **state) {
    (void)state;
    if (!sundials_has_more())
        skip();
    const dl_method_row *const row = row_of("arkode-erk-relaxation");
    const dl_parameter *const table = dl_parameter_find(row->options, "table");
    for (size_t k = 0; table->words[k]; k++) {
        char options[96];
        snprintf(options, sizeof options, "rtol=1e-4 atol=1e-6 table=%s", table->words[k]);
        rig r = rig_open(row, fixture_cluster(), options);
        dl_energy energy;
        double scale;
        assert_int_equal(dl_model_energy(r.model, rig_state(&r), &energy, NULL), DL_OK);
        assert_int_equal(dl_model_energy_scale(r.model, r.y, &scale, NULL), DL_OK);
        const double start = energy.total;
        for (int stop = 1; stop <= 20; stop++) {
            rig_run(&r, 0.0371 * stop);
            assert_true(r.method->t == 0.0371 * stop);
            assert_int_equal(dl_model_energy(r.model, rig_state(&r), &energy, NULL), DL_OK);
            if (!(fabs(energy.total - start) < 2e-13 * scale))
                fail_msg("%s: energy off by %g of its scale", table->words[k],
                         fabs(energy.total - start) / scale);
        }
        rig_close(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_table_is_offered),
        cmocka_unit_test(preconditioners_save_iterations),
        cmocka_unit_test(every_krylov_method_solves),
        cmocka_unit_test(krylov_dimension_counts),
        cmocka_unit_test(anderson_counts),
        cmocka_unit_test(solvers_agree),
        cmocka_unit_test(values_at_stops_are_the_steps_own),
        cmocka_unit_test(split_methods_converge_on_scenes),
        cmocka_unit_test(substeps_are_of_the_fast_part),
        cmocka_unit_test(unused_options_are_refused),
        cmocka_unit_test(unused_options_are_not_written),
        cmocka_unit_test(further_rows_are_where_sundials_has_them),
        cmocka_unit_test(relaxed_energy_stays_at_stops),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
