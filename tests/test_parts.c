/* The fast and the slow part of a scene's force: what a scene says, sums and Jacobians of both
 * against the whole in every kernel, and methods that need them. */
#include "contract.h"

#include <unistd.h>

#include "driftlab/explain.h"
#include "fixture_periodic.h"
#include "model/private.h"
#include "study/plan.h"

/* --- scenes -----------------------------------------------------------------------------------
 */

/* Two pieces or, cut, three, whose ends are of one kind; every one has fast and slow terms, but for
 * the last, which is slow alone. */
static dl_pair_law law_with_ends(dl_piece_end end, bool cut) {
    dl_pair_law law = {.pieces = 2};
    law.piece[0] = (dl_piece){.until = 1.3,
                              .terms = 3,
                              .term = {{-3, 4}, {4, 9}, {0.5, 2}},
                              .part = {DL_PART_FAST, DL_PART_FAST, DL_PART_SLOW},
                              .end = end,
                              .width = end == DL_END_TAPER ? 0.3 : 0};
    law.piece[1] = (dl_piece){.until = cut ? 1.7 : INFINITY,
                              .terms = 2,
                              .term = {{-0.7, 2}, {0.3, 3.5}},
                              .part = {DL_PART_SLOW, DL_PART_FAST}};
    if (!cut)
        return law;
    law.piece[1].end = end;
    law.piece[1].width = end == DL_END_TAPER ? 0.2 : 0;
    law.piece[2] = (dl_piece){.until = 2.1, .terms = 1, .term = {{-0.4, 2}}, .end = end};
    law.piece[2].part[0] = DL_PART_SLOW;
    law.piece[2].width = end == DL_END_TAPER ? 0.1 : 0;
    law.pieces = 3;
    return law;
}

static void add_species(dl_scene *scene) {
    static const char *const names[] = {"heavy", "light"};
    scene->species = 2;
    scene->species_name = calloc(2, sizeof *scene->species_name);
    scene->species_law = calloc(4, sizeof *scene->species_law);
    scene->species_of = calloc(scene->particles, sizeof *scene->species_of);
    for (size_t k = 0; k < 2; k++)
        scene->species_name[k] = fixture_text(names[k]);
    scene->species_law[0] = scene->law;
    fixture_law(scene, 1.5, 2, 3, 3, 5); /* all fast */
    scene->species_law[1] = scene->species_law[2] = scene->law;
    fixture_split(scene);
    scene->species_law[3] = scene->law;
    scene->law.pieces = 0;
    for (size_t i = 0; i < scene->particles; i++)
        scene->species_of[i] = (int)(i % 3 % 2);
}

typedef struct variety {
    int dimension;
    dl_piece_end end;
    bool cut, species, pins, periodic;
} variety;

static dl_scene *scene_of(variety kind) {
    dl_scene *scene =
        fixture_liquid(kind.dimension, kind.dimension == 2 ? 9 : 5, kind.periodic ? 3 : 0);
    scene->law = law_with_ends(kind.end, kind.cut);
    scene->gravity[1] = -0.7;
    for (size_t i = 0; i < scene->particles; i++) {
        scene->inertia[i] = 1 + 0.5 * (double)(i % 3);
        scene->coupling[i] = 1 + 0.25 * (double)(i % 4);
        scene->feels_gravity[i] = i % 5 != 2;
        scene->pinned[i] = kind.pins && i % 7 == 3;
    }
    if (kind.species)
        add_species(scene);
    return scene;
}

static const variety varieties[] = {
    {2, DL_END_HARD, true, false, false, false},
    {2, DL_END_HARD, false, false, true, false},
    {2, DL_END_SHIFTED_FORCE, true, false, false, false},
    {2, DL_END_SHIFTED_FORCE, false, true, false, false},
    {2, DL_END_TAPER, true, false, false, true},
    {2, DL_END_TAPER, false, false, false, false},
    {3, DL_END_HARD, true, true, true, false},
    {3, DL_END_SHIFTED_FORCE, true, false, true, false},
    {3, DL_END_TAPER, true, true, false, false},
};

enum { variety_count = sizeof varieties / sizeof *varieties };

typedef struct opened {
    dl_scene *scene;
    dl_model *model;
    size_t n;
    double *q, *work; /* [2 n] and [6 n] */
} opened;

static opened open_scene(dl_scene *scene, dl_kernel_choice kernel) {
    opened o = {.scene = scene};
    dl_error error = {""};
    scene->kernel = kernel;
    if (dl_model_create(scene, &o.model, &error) || dl_model_split(o.model, &error))
        fail_msg("%s", error.message);
    o.n = o.model->unknowns;
    o.q = calloc(2 * o.n, sizeof *o.q);
    o.work = calloc(6 * o.n, sizeof *o.work);
    dl_model_initial_state(o.model, o.q);
    return o;
}

static void close_scene(opened *o) {
    dl_model_free(o->model);
    dl_scene_free(o->scene);
    free(o->q);
    free(o->work);
}

/* whole = fast + slow to roundoff of the parts. */
static void assert_sum(const double *whole, const double *fast, const double *slow, size_t n) {
    double largest = 0, wrong = 0;
    for (size_t i = 0; i < n; i++) {
        largest = fmax(largest, fabs(fast[i]) + fabs(slow[i]));
        wrong = fmax(wrong, fabs(whole[i] - fast[i] - slow[i]));
    }
    if (!(wrong <= 4e-14 * largest))
        fail_msg("parts of up to %g are wrong by %g", largest, wrong);
}

/* --- sums --------------------------------------------------------------------------------------
 */

static void check_accelerations(opened *o) {
    const size_t n = o->n;
    double *const whole = o->work, *const fast = whole + n, *const slow = fast + n;
    assert_int_equal(dl_model_acceleration(o->model, o->q, whole, NULL), DL_OK);
    assert_int_equal(dl_model_part_acceleration(o->model, DL_PART_FAST, o->q, fast, NULL), DL_OK);
    assert_int_equal(dl_model_part_acceleration(o->model, DL_PART_SLOW, o->q, slow, NULL), DL_OK);
    assert_sum(whole, fast, slow, n);
    double least[2] = {0, 0};
    for (size_t i = 0; i < n; i++) {
        least[0] = fmax(least[0], fabs(fast[i]));
        least[1] = fmax(least[1], fabs(slow[i]));
    }
    assert_true(least[0] > 0.1 && least[1] > 0.1);
}

/* Products with the Jacobian, and with the matrix of it. */
static void multiply(dl_model *model, const double *q, const double *u, double *out) {
    const dl_sparsity *pattern = NULL;
    assert_int_equal(dl_model_jacobian_vector(model, q, u, out, NULL), DL_OK);
    assert_int_equal(dl_model_sparsity(model, q, NULL, &pattern, NULL), DL_OK);
    double *const values = malloc((pattern->nonzeros + 1) * sizeof *values);
    double *const by_matrix = calloc(pattern->columns + 1, sizeof *by_matrix);
    assert_int_equal(dl_model_jacobian(model, q, values, NULL), DL_OK);
    for (size_t column = 0; column < pattern->columns; column++)
        for (long k = pattern->column_start[column]; k < pattern->column_start[column + 1]; k++)
            by_matrix[pattern->row[k]] += values[k] * u[column];
    for (size_t i = 0; i < pattern->columns; i++)
        assert_true(fabs(by_matrix[i] - out[i]) < 1e-10 * (1 + fabs(out[i])));
    free(values);
    free(by_matrix);
}

static void check_jacobians(opened *o) {
    const size_t n = o->n;
    double *const whole = o->work, *const fast = whole + n, *const slow = fast + n;
    double *const u = slow + n;
    for (size_t i = 0; i < n; i++)
        u[i] = fixture_noise((unsigned)i);
    multiply(o->model, o->q, u, whole);
    multiply(dl_model_part(o->model, DL_PART_FAST), o->q, u, fast);
    multiply(dl_model_part(o->model, DL_PART_SLOW), o->q, u, slow);
    assert_sum(whole, fast, slow, n);
}

static void parts_add_up(void **state) {
    (void)state;
    static const dl_kernel_choice kernels[] = {DL_KERNEL_REFERENCE, DL_KERNEL_ALL_PAIRS,
                                               DL_KERNEL_NEIGHBOUR_LIST, DL_KERNEL_AUTO};
    for (size_t v = 0; v < variety_count; v++)
        for (size_t k = 0; k < 4; k++) {
            if (kernels[k] == DL_KERNEL_NEIGHBOUR_LIST && !varieties[v].cut)
                continue;
            opened o = open_scene(scene_of(varieties[v]), kernels[k]);
            check_accelerations(&o);
            check_jacobians(&o);
            close_scene(&o);
        }
}

/* --- what a part is ----------------------------------------------------------------------------
 */

/* TR299's swirl: molecular within D, gravity beyond. */
static dl_scene *swirl(void) {
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (dl_scene_read(DL_STUDIES "/swirl/swirl.yaml", &scene, &error))
        fail_msg("%s", error.message);
    scene->law.piece[1].part[0] = DL_PART_SLOW;
    return scene;
}

static void each_part_has_its_own_kernel(void **state) {
    (void)state;
    opened o = open_scene(swirl(), DL_KERNEL_AUTO);
    const dl_model *const fast = dl_model_part(o.model, DL_PART_FAST);
    const dl_model *const slow = dl_model_part(o.model, DL_PART_SLOW);
    assert_string_equal(o.model->kernel->ops->name, "all-pairs");
    assert_string_equal(fast->kernel->ops->name, "neighbour-list");
    assert_string_equal(slow->kernel->ops->name, "all-pairs");
    assert_true(fast->priv->problem.reach == 2.3 && isinf(slow->priv->problem.reach));
    close_scene(&o);
    o = open_scene(fixture_box(), DL_KERNEL_AUTO);
    assert_non_null(dl_model_part(o.model, DL_PART_FAST)->kernel);
    assert_null(dl_model_part(o.model, DL_PART_SLOW)->kernel); /* gravity alone */
    assert_false(dl_model_part(o.model, DL_PART_FAST)->has_gravity);
    close_scene(&o);
}

static void work_of_parts_is_counted(void **state) {
    (void)state;
    opened o = open_scene(swirl(), DL_KERNEL_AUTO);
    check_accelerations(&o);
    check_jacobians(&o);
    assert_int_equal(o.model->counts.force, 3);
    assert_int_equal(o.model->counts.jacobian, 3);
    assert_int_equal(o.model->counts.jacobian_vector, 3);
    assert_int_equal(dl_model_list_builds(o.model), 1); /* the fast part's */
    close_scene(&o);
}

/* What rests on a wall is out of both parts. */
static void held_coordinates_stay(void **state) {
    (void)state;
    opened o = open_scene(fixture_box(), DL_KERNEL_AUTO);
    bool *const held = calloc(o.n, sizeof *held);
    held[3] = held[30] = true;
    o.model->held = held;
    for (int part = DL_PART_FAST; part <= DL_PART_SLOW; part++) {
        assert_int_equal(dl_model_part_acceleration(o.model, (dl_part)part, o.q, o.work, NULL),
                         DL_OK);
        assert_true(o.work[3] == 0 && o.work[30] == 0);
        for (size_t i = 0; i < o.n; i++)
            o.work[i] = 1;
        dl_model *const its = dl_model_part(o.model, (dl_part)part);
        double *const product = o.work + o.n;
        assert_int_equal(dl_model_jacobian_vector(its, o.q, o.work, product, NULL), DL_OK);
        assert_true(product[3] == 0 && product[30] == 0);
    }
    close_scene(&o);
    free(held);
}

/* A method that does not split leaves the parts unmade. */
static void who_does_not_ask_pays_nothing(void **state) {
    (void)state;
    const dl_method_row *row;
    assert_int_equal(dl_method_find("cvode-bdf-klu", &row, NULL), DL_OK);
    rig r = rig_open(row, swirl(), "rtol=1e-5");
    rig_step(&r, 0.01);
    assert_null(r.model->priv->part[DL_PART_FAST]);
    assert_null(r.model->priv->part[DL_PART_SLOW]);
    rig_close(&r);
}

/* --- scenes that do not say --------------------------------------------------------------------
 */

static void assert_not_split(dl_scene *scene, const char *expected) {
    int rows = 0;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_SPLITS_FORCE))
            continue;
        dl_model *model = NULL;
        dl_method *method = NULL;
        void *options = NULL;
        dl_error error = {""};
        assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
        assert_int_equal(dl_method_options_create(row, scene, &options, NULL), DL_OK);
        double *const y = calloc(2 * model->unknowns, sizeof *y);
        dl_model_initial_state(model, y);
        assert_int_equal(dl_method_create(row, model, options, y, &method, &error), DL_INPUT);
        assert_null(method);
        assert_non_null(strstr(error.message, row->name));
        assert_non_null(strstr(error.message, expected));
        free(y);
        dl_method_options_free(row, options);
        dl_model_free(model);
        rows++;
    }
    assert_int_equal(rows, 2);
    dl_scene_free(scene);
}

static void scenes_without_parts_are_refused(void **state) {
    (void)state;
    assert_not_split(fixture_cluster(), "part: slow");
    dl_scene *const slow = fixture_kepler(0.3);
    slow->law.piece[0].part[0] = DL_PART_SLOW;
    assert_not_split(slow, "part: fast");
    dl_scene *const falling = fixture_scene("falling", 2, 2); /* gravity and nothing else */
    falling->gravity[1] = -1;
    fixture_place(falling, 1, (double[3]){1, 0}, (double[3]){0});
    assert_not_split(falling, "part: fast");
}

/* --- scene files -------------------------------------------------------------------------------
 */

static dl_scene *scene_of_text(const char *far) {
    static const char text[] =
        "name: parted\ndimension: 2\n"
        "particles:\n  - {at: [0, 0]}\n  - {at: [1, 0]}\n  - {at: [3, 1]}\n"
        "pair_law:\n"
        "  - {until: 2, terms: [{coefficient: -1, power: 2%s}, {coefficient: 1, power: 4}]}\n"
        "  - {terms: [{coefficient: -0.5, power: 2, part: slow}]}\n"
        "time: {step: 0.01, end: 1}\n";
    char path[] = "/tmp/driftlab-parts-XXXXXX", whole[1024];
    const int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    const int length = snprintf(whole, sizeof whole, text, far);
    assert_int_equal(write(descriptor, whole, (size_t)length), length);
    close(descriptor);
    dl_scene *scene = NULL;
    dl_error error = {""};
    if (dl_scene_read(path, &scene, &error))
        fail_msg("%s", error.message);
    unlink(path);
    return scene;
}

static void parts_are_read(void **state) {
    (void)state;
    dl_scene *const one = scene_of_text(", part: slow"), *const other = scene_of_text("");
    const dl_piece *const piece = one->law.piece;
    assert_int_equal(piece[0].part[0], DL_PART_SLOW);
    assert_int_equal(piece[0].part[1], DL_PART_FAST);
    assert_int_equal(piece[1].part[0], DL_PART_SLOW);
    assert_int_equal(other->law.piece[0].part[0], DL_PART_FAST);
    assert_true(dl_scene_hash(one) != dl_scene_hash(other));
    dl_scene_free(one);
    dl_scene_free(other);
}

static void explain_names_the_parts(void **state) {
    (void)state;
    opened o = open_scene(swirl(), DL_KERNEL_AUTO);
    char text[8192] = "";
    FILE *const out = fmemopen(text, sizeof text, "w");
    dl_explain(o.model, out);
    fclose(out);
    const char *const fast = strstr(text, "fast part"), *const slow = strstr(text, "slow part");
    assert_true(fast && slow && fast < slow);
    assert_true(strstr(fast, "-5 r^-4") && strstr(fast, "-5 r^-4") < slow);
    assert_true(strstr(fast, "neighbour-list") && strstr(fast, "neighbour-list") < slow);
    assert_non_null(strstr(slow, "-0.001 r^-2"));
    assert_null(strstr(slow, "-5 r^-4"));
    close_scene(&o);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(parts_add_up),
        cmocka_unit_test(each_part_has_its_own_kernel),
        cmocka_unit_test(work_of_parts_is_counted),
        cmocka_unit_test(held_coordinates_stay),
        cmocka_unit_test(who_does_not_ask_pays_nothing),
        cmocka_unit_test(scenes_without_parts_are_refused),
        cmocka_unit_test(parts_are_read),
        cmocka_unit_test(explain_names_the_parts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
