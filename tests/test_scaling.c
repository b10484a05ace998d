/* Bodies of several sizes: bulk quantities are those that are known, sizes are compared as they
 * should be, exponents of cost are found on both sides, and a study goes on where it was. */
#include "fixture_folder.h"
#include "fixture_kinds.h"
#include "fixture_scenes.h"

#include <sys/stat.h>

#include "driftlab/scaling.h"
#include "driftlab/study.h"
#include "report/page_scaling.h"
#include "study/scaling.h"

static asked scaling_of(const dl_scene *scene, const char *setting) {
    return (asked){.kind = &dl_study_kind_scaling,
                   .scene = scene,
                   .row = method_of("leapfrog"),
                   .setting = setting,
                   .sample = scene->end / 4};
}

static void expect_quantity(const dl_finding *finding, const char *name, double expected,
                            double tolerance) {
    const double found = quantity(finding, name)[0];
    if (!(fabs(found - expected) <= tolerance))
        fail_msg("%s: found %.17g, expected %.17g", name, found, expected);
}

/* --- bulk ------------------------------------------------------------------------------------- */

/* A square of side x side free particles 1 apart, that travels with (3, 4) and grows evenly: every
 * particle's velocity is that and `rate` times its place about the centre. Nothing acts. */
enum { side = 20 };
static const double rate = 0.5;

static dl_scene *growing(void) {
    dl_scene *scene = fixture_scene("growing", 2, side * side);
    for (size_t i = 0; i < side * side; i++) {
        const double x = (double)(i % side) - (side - 1) / 2.0;
        const double y = (double)(i / side) - (side - 1) / 2.0;
        fixture_place(scene, i, (double[3]){7 + x, y}, (double[3]){3 + rate * x, 4 + rate * y});
        scene->inertia[i] = 0.5;
    }
    scene->step = 0.25;
    scene->end = 2;
    return scene;
}

/* At time t every length is 1 + rate t times the start's; the variance of n equidistant places 1
 * apart is (n^2 - 1)/12, so that the extent is root(n^2 - 1). */
static void bulk_of_a_body_that_grows_is_exact(void **state) {
    (void)state;
    dl_scene *scene = growing();
    asked what = scaling_of(scene, "from=1 bins=4");
    dl_finding found = measure(&what);
    const double extent = sqrt(side * side - 1.0), growth = 1 + rate * scene->end;
    expect_verdict(&found, "measured", "400 particles");
    expect_quantity(&found, "particles", side * side, 0);
    expect_quantity(&found, "speed of the mass centre", 5, 1e-13);
    expect_quantity(&found, "extent along x", growth * extent, 1e-12);
    expect_quantity(&found, "extent along y", growth * extent, 1e-12);
    expect_quantity(&found, "momentum flux along x per mass", rate * rate * extent * extent / 12,
                    1e-12);
    expect_quantity(&found, "kinetic energy per mass", rate * rate * extent * extent / 12, 1e-12);
    expect_quantity(&found, "pair energy per mass", 0, 0);
    expect_quantity(&found, "mean separation", growth, 1e-13);
    /* Places 2 apart: 4 in half the initial extent, and 10 in all of it. */
    expect_quantity(&found, "density in the middle", 4 * 4 * 0.5 / (extent * extent / 4), 1e-12);
    double mass = 0;
    for (int k = 1; k <= 4; k++) {
        char name[80];
        snprintf(name, sizeof name, "density along x, slice %d of 4", k);
        mass += quantity(&found, name)[0] * extent / 4;
    }
    assert_true(fabs(mass - 10 * side * 0.5) < 1e-12);
    expect_quantity(&found, "pair forces", 0, 0);
    dl_finding_release(&found);
    dl_scene_free(scene);
}

/* `from` says which samples count: lengths grow linearly, so that their mean is that of the times.
 */
static void means_are_over_the_last_part(void **state) {
    (void)state;
    static const struct {
        const char *setting;
        double time;
    } parts[] = {{"from=0", 1}, {"from=0.5", 1.5}, {"from=0.6", 1.75}, {"from=1", 2}};
    dl_scene *scene = growing();
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        asked what = scaling_of(scene, parts[k].setting);
        dl_finding found = measure(&what);
        expect_quantity(&found, "mean separation", 1 + rate * parts[k].time, 1e-13);
        assert_int_equal(found.rows, 5);
        dl_finding_release(&found);
    }
    dl_scene_free(scene);
}

/* A body at rest as a whole has no speed to compare; all pairs of so few are looked at. */
static void a_body_at_rest_has_no_speed(void **state) {
    (void)state;
    dl_scene *scene = fixture_scene("three", 2, 3);
    fixture_law(scene, 1.5, 1, 2, 1, 5);
    fixture_place(scene, 0, (double[3]){-1}, (double[3]){0, 0.1});
    fixture_place(scene, 1, (double[3]){0}, (double[3]){0});
    fixture_place(scene, 2, (double[3]){1}, (double[3]){0, -0.1});
    scene->step = 1e-3;
    scene->end = 4e-3;
    asked what = scaling_of(scene, "from=1");
    dl_finding found = measure(&what);
    assert_null(dl_finding_quantity(&found, "speed of the mass centre"));
    expect_quantity(&found, "pairs looked at, per particle", 1, 0);
    expect_quantity(&found, "pair forces", 3 * quantity(&found, "force evaluations")[0], 0);
    dl_finding_release(&found);
    dl_scene_free(scene);
}

static void what_is_no_body_is_refused(void **state) {
    (void)state;
    dl_error error = {""};
    dl_scene *scene = growing();
    asked what = scaling_of(scene, "");
    scene->periods.present = true;
    scene->periods.length[0] = 100;
    assert_int_equal(refusal(&what, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "expected none: a body has an extent and a centre"));
    scene->periods = (dl_periods){0};
    for (size_t i = 1; i < scene->particles; i++)
        scene->pinned[i] = true;
    assert_int_equal(refusal(&what, &error), DL_INPUT);
    assert_non_null(strstr(error.message, "found 1 that move, expected at least two"));
    dl_scene_free(scene);
}

/* --- comparison ------------------------------------------------------------------------------- */

static void exponents_are_found_on_both_sides(void **state) {
    (void)state;
    static const double x[] = {10, 100, 1000, 10000};
    for (double power = -0.5; power < 3; power += 0.5) {
        double y[4], exponent, low, high;
        for (size_t i = 0; i < 4; i++)
            y[i] = 7 * pow(x[i], power);
        dl_fit_power(x, y, 4, &exponent, &low, &high);
        assert_true(fabs(exponent - power) < 1e-13 && high - low < 1e-12);
        /* Residuals (1, -1, -1, 1) e are at right angles to 1 and ln x: the slope stays, and half
         * the interval is t(0.975, 2) = 4.302653 times root(4 e^2 / 2 / sum (ln x - mean)^2). */
        const double e = 0.01, ten = log(10);
        for (size_t i = 0; i < 4; i++)
            y[i] *= exp(i == 0 || i == 3 ? e : -e);
        dl_fit_power(x, y, 4, &exponent, &low, &high);
        const double half = 4.302653 * sqrt(2 * e * e / (5 * ten * ten));
        assert_true(fabs(exponent - power) < 1e-13);
        assert_true(fabs(high - exponent - half) < 1e-7 && fabs(exponent - low - half) < 1e-7);
    }
    double exponent, low, high;
    dl_fit_power(x, x, 2, &exponent, &low, &high);
    assert_true(fabs(exponent - 1) < 1e-14 && isnan(low) && isnan(high));
    dl_fit_power(x, (double[]){1, 0, 1}, 3, &exponent, &low, &high);
    assert_true(isnan(exponent) && isnan(low) && isnan(high));
}

/* A finding as the kind makes it. */
static void add_found(dl_results *results, const char *scene, double particles, double value,
                      double step, const char *verdict) {
    dl_error error = {""};
    dl_finding finding;
    char options[64];
    snprintf(options, sizeof options, "step=%g", step);
    assert_int_equal(dl_finding_create(&finding, &error), DL_OK);
    free(finding.scene);
    free(finding.method);
    free(finding.options);
    finding.scene = strdup(scene);
    finding.method = strdup("leapfrog");
    finding.options = strdup(options);
    dl_finding_judge(&finding, &error, verdict, "made by hand");
    const struct {
        const char *name;
        double value;
    } all[] = {{"particles", particles},
               {"density [mass/area]", value},
               {"step [of the scene's]", 1},
               {"steps", 10},
               {"CPU time of a step [s]", particles},
               {"CPU time [s]", 10 * particles},
               {"force evaluations", 10},
               {"pair forces", particles * particles},
               {"tolerance", 0.05},
               {"$k", 3}};
    for (size_t k = 0; k < sizeof all / sizeof *all; k++)
        assert_int_equal(dl_finding_add(&finding, all[k].name, all[k].value, NAN, NAN, &error),
                         DL_OK);
    assert_int_equal(dl_results_add_finding(results, &finding, &error), DL_OK);
}

/* Sizes in any order; repeats of 100 whose mean agrees and who do not; a failed run; another body.
 */
static dl_results *made_by_hand(void) {
    dl_error error = {""};
    dl_results *results = NULL;
    assert_int_equal(dl_results_create(&results, &error), DL_OK);
    free(results->kind);
    results->kind = strdup("scaling");
    add_found(results, "body(k=3)", 1000, 2.08, 0.1, "measured");
    add_found(results, "body(k=9)", 10000, 2, 0.01, "measured");
    add_found(results, "body(k=1,draw=1)", 100, 2.2, 1, "measured");
    add_found(results, "body(k=1,draw=2)", 100, 1.8, 1, "measured");
    add_found(results, "body(k=9,draw=2)", 100000, 7, 0.001, "failed");
    add_found(results, "other(k=1)", 10, 5, 1, "measured");
    return results;
}

static void sizes_are_compared_with_the_largest(void **state) {
    (void)state;
    dl_results *results = made_by_hand();
    dl_scaling *of = malloc(sizeof *of);
    assert_non_null(of);
    assert_int_equal(dl_scalings_count(results), 2);
    dl_scaling_get(results, 0, of);
    assert_string_equal(of->body, "body");
    assert_string_equal(of->largest, "body(k=9)");
    assert_int_equal(of->sizes, 3);
    static const double particles[] = {100, 1000, 10000}, value[] = {2, 2.08, 2};
    static const double deviation[] = {0.1, 0.04, 0};
    static const size_t repeats[] = {2, 1, 1};
    assert_int_equal(of->quantities, 1);
    assert_string_equal(of->quantity[0].name, "density [mass/area]");
    for (size_t s = 0; s < 3; s++) {
        assert_true(of->particles[s] == particles[s] && of->repeats[s] == repeats[s]);
        assert_true(fabs(of->quantity[0].value[s] - value[s]) < 1e-14);
        assert_true(fabs(of->quantity[0].deviation[s] - deviation[s]) < 1e-14);
    }
    assert_int_equal(of->quantity[0].from, 1);
    assert_true(fabs(of->cost[0].exponent - 1) < 1e-13);
    assert_true(fabs(of->cost[2].exponent) < 1e-13);
    assert_true(fabs(of->cost[3].exponent - 2) < 1e-13);
    free(of);
    dl_results_free(results);
}

static void all_is_told_once(void **state) {
    (void)state;
    dl_results *results = made_by_hand();
    char text[DL_MESSAGE_SIZE];
    dl_results_answer(results, "body(k=1,draw=1)", text, sizeof text);
    assert_string_equal(text, "");
    dl_results_answer(results, "body(k=9)", text, sizeof text);
    if (!strstr(text, "to 5 % of 10000 particles agree from 1000 on: density") ||
        strstr(text, "slice") || !strstr(text, "pair forces of the run as N^2 (2 to 2)"))
        fail_msg("%s", text);
    dl_results_answer(results, "other(k=1)", text, sizeof text); /* of one size nothing is told */
    assert_string_equal(text, "");
    dl_results_free(results);
}

/* What the page draws is what was compared. */
static void the_page_has_the_comparison(void **state) {
    (void)state;
    dl_results *results = made_by_hand();
    json_t *all = dl_page_scalings(results);
    assert_int_equal(json_array_size(all), 1); /* one size is no comparison */
    const json_t *one = json_array_get(all, 0);
    const json_t *density = json_array_get(json_object_get(one, "quantities"), 0);
    assert_string_equal(json_string_value(json_object_get(density, "name")), "density [mass/area]");
    assert_true(json_number_value(json_object_get(density, "from")) == 1000);
    const json_t *deviations = json_object_get(density, "deviations");
    assert_true(fabs(json_number_value(json_array_get(deviations, 0)) - 0.1) < 1e-14);
    const json_t *pairs = json_array_get(json_object_get(one, "costs"), DL_SCALED_COSTS - 1);
    assert_true(fabs(json_number_value(json_object_get(pairs, "exponent")) - 2) < 1e-13);
    assert_int_equal(json_integer_value(json_array_get(json_object_get(one, "repeats"), 0)), 2);
    json_decref(all);
    free(results->kind);
    results->kind = strdup("drift"); /* whose findings are no sizes */
    all = dl_page_scalings(results);
    assert_int_equal(json_array_size(all), 0);
    json_decref(all);
    dl_results_free(results);
}

/* --- studies ---------------------------------------------------------------------------------- */

static void write_file(const char *name, const char *text, char *path, size_t size) {
    snprintf(path, size, "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    fputs(text, file);
    fclose(file);
}

#define BODY                                                                                       \
    "name: body\ndimension: 2\nseed: $draw\nlet: {k: 1, draw: 1}\n"                                \
    "particles:\n"                                                                                 \
    "  - lattice: {kind: hexagonal, spacing: 1/$k, count: [4*$k, 2*$k]}\n"                         \
    "    mass: 1/$k/$k\n    velocity: [50, 0]\n    perturb: {relative: 0.01}\n"                    \
    "pair_law:\n"                                                                                  \
    "  - {until: 2.5/$k, end: shifted-force, terms: [{coefficient: -1/$k/$k/$k/$k, power: 7},\n"   \
    "     {coefficient: 1/$k/$k/$k/$k/$k/$k/$k, power: 10}]}\n"                                    \
    "time: {step: 0.05/$k, end: 0.8}\n"

#define STUDY                                                                                      \
    "name: sizes\nkind: scaling\nscene: body.yaml\nlet: {k: [1, 2, 4], draw: [1, 2]}\n"            \
    "samples: 8\nlimits: {seconds: 50}\n"                                                          \
    "cases:\n  - {method: conserving-fixed-point}\n"

/* Parts after which a run is interrupted; 0: none. */
static int parts_wanted;
static volatile int interrupt;

static void stop_after(void *context, const dl_study_progress *progress) {
    (void)context;
    if (parts_wanted > 0 && progress->done >= (size_t)parts_wanted)
        interrupt = 1;
}

static dl_results *run_study(const dl_study *study, const char *path, dl_status expected) {
    dl_error error = {""};
    dl_results *results = NULL;
    const dl_study_options how = {
        .results = path, .interrupt = &interrupt, .on_progress = stop_after};
    const dl_status status = dl_study_run(study, &how, &results, &error);
    if (status != expected)
        fail_msg("%s: %s", dl_status_name(status), error.message);
    return results;
}

/* Pair forces of the run: k steps more, k^2 particles, so the exponent in N = 8 k^2 is about 3/2,
 * less edges, more iterations; that of force evaluations about 1/2. Energy stays at every size. */
static void a_study_goes_on_where_it_was(void **state) {
    (void)state;
    char scene[256], path[256], results_path[256];
    dl_error error = {""};
    dl_study *study = NULL;
    write_file("body.yaml", BODY, scene, sizeof scene);
    write_file("study.yaml", STUDY, path, sizeof path);
    snprintf(results_path, sizeof results_path, "%s/results.h5", folder);
    if (dl_study_read(path, &study, &error))
        fail_msg("%s", error.message);
    parts_wanted = 3;
    interrupt = 0;
    dl_results *part = run_study(study, results_path, DL_INTERRUPTED);
    assert_non_null(part);
    const size_t kept = part->findings;
    assert_true(kept >= 3 && kept < 6);
    char *command = strdup(part->finding[0].key);
    const double seconds = part->finding[0].cpu_seconds;
    dl_results_free(part);
    parts_wanted = 0;
    interrupt = 0;
    dl_results *whole = run_study(study, results_path, DL_OK);
    assert_int_equal(whole->findings, 6);
    assert_string_equal(whole->finding[0].key, command);
    assert_true(whole->finding[0].cpu_seconds == seconds); /* not measured again */
    dl_scaling *of = malloc(sizeof *of);
    assert_non_null(of);
    assert_int_equal(dl_scalings_count(whole), 1);
    dl_scaling_get(whole, 0, of);
    assert_int_equal(of->sizes, 3);
    for (size_t s = 0; s < 3; s++)
        assert_int_equal(of->repeats[s], 2);
    if (!(of->cost[2].exponent > 0.35 && of->cost[2].exponent < 0.75) ||
        !(of->cost[3].exponent > 1.4 && of->cost[3].exponent < 2.1))
        fail_msg("exponents %g, %g", of->cost[2].exponent, of->cost[3].exponent);
    for (size_t i = 0; i < whole->findings; i++)
        assert_true(quantity(&whole->finding[i], "energy error")[0] < 1e-12);
    free(of);
    free(command);
    dl_results_free(whole);
    dl_study_free(study);
}

static void refused(const char *with, const char *words) {
    char path[256], text[1024];
    dl_error error = {""};
    dl_study *study = NULL;
    snprintf(text, sizeof text, STUDY "with: {%s}\n", with);
    write_file("refused.yaml", text, path, sizeof path);
    if (dl_study_read(path, &study, &error) != DL_INPUT || !strstr(error.message, words))
        fail_msg("%s: %s", with, error.message);
}

static void settings_are_refused(void **state) {
    (void)state;
    char scene[256];
    write_file("body.yaml", BODY, scene, sizeof scene);
    refused("from: 1.5", "from");
    refused("bins: 0", "bins");
    refused("bins: 33", "bins");
    refused("agree: 0", "agree");
    refused("sizes: 3", "sizes");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(bulk_of_a_body_that_grows_is_exact),
        cmocka_unit_test(means_are_over_the_last_part),
        cmocka_unit_test(a_body_at_rest_has_no_speed),
        cmocka_unit_test(what_is_no_body_is_refused),
        cmocka_unit_test(exponents_are_found_on_both_sides),
        cmocka_unit_test(sizes_are_compared_with_the_largest),
        cmocka_unit_test(all_is_told_once),
        cmocka_unit_test(the_page_has_the_comparison),
        cmocka_unit_test(a_study_goes_on_where_it_was),
        cmocka_unit_test(settings_are_refused),
    };
    return cmocka_run_group_tests(tests, make_folder, remove_folder);
}
