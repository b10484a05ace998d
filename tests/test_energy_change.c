/* What a jump changes, of what it moves alone, against the difference of the whole. */
#include "contract.h"

#include <float.h>

#include "driftlab/run.h"
#include "fixture_periodic.h"

typedef struct pair_of_states {
    dl_scene *scene;
    dl_model *model;
    double *before, *after; /* [2 * unknowns] */
} pair_of_states;

static pair_of_states open_states(dl_scene *scene, dl_kernel_choice kernel) {
    pair_of_states s = {.scene = scene};
    dl_error error = {""};
    scene->kernel = kernel;
    if (dl_model_create(scene, &s.model, &error))
        fail_msg("%s", error.message);
    const size_t length = 2 * s.model->unknowns;
    s.before = calloc(length, sizeof *s.before);
    s.after = calloc(length, sizeof *s.after);
    assert_true(s.before && s.after);
    dl_model_initial_state(s.model, s.before);
    memcpy(s.after, s.before, length * sizeof *s.after);
    return s;
}

static void close_states(pair_of_states *s) {
    dl_model_free(s->model);
    dl_scene_free(s->scene);
    free(s->before);
    free(s->after);
}

/* --- scenes ----------------------------------------------------------------------------------- */

enum variant { PLAIN, SPECIES, SHIFTED, TAPERED, ENDLESS, VARIANTS };

static void add_two_species(dl_scene *scene) {
    scene->species = 2;
    scene->species_name = calloc(2, sizeof *scene->species_name);
    scene->species_law = calloc(4, sizeof *scene->species_law);
    scene->species_of = calloc(scene->particles, sizeof *scene->species_of);
    assert_true(scene->species_name && scene->species_law && scene->species_of);
    for (size_t k = 0; k < 2; k++)
        scene->species_name[k] = fixture_text(k ? "heavy" : "light");
    for (size_t k = 0; k < 4; k++)
        scene->species_law[k] = scene->law;
    for (size_t k = 1; k <= 2; k++)
        scene->species_law[k].piece[0].term[1] = (dl_term){.coefficient = 30, .power = 9.5};
    scene->species_law[3].pieces = 0;
    for (size_t i = 0; i < scene->particles; i++)
        scene->species_of[i] = i % 3 == 1;
    scene->law.pieces = 0;
}

/* A liquid that is periodic along all axes but the last, with walls there that some particles are
 * beyond; gravity that not all feel, pins, couplings and inertias unlike. */
static dl_scene *liquid(int dimension, enum variant variant) {
    const size_t side = dimension == 2 ? 9 : 4;
    dl_scene *const scene = fixture_liquid(dimension, side, dimension == 2 ? 1 : 3);
    const int last = dimension - 1;
    scene->walls.present = true;
    scene->walls.low[last] = -0.99;
    scene->walls.high[last] = -1 + 1.1 * (double)(side - 1) + 0.02;
    scene->walls.damping = 0.4;
    scene->gravity[last] = -3;
    for (size_t i = 0; i < scene->particles; i++) {
        scene->feels_gravity[i] = i % 4 != 2;
        scene->pinned[i] = i % 13 == 5;
        scene->coupling[i] = 1 + 0.25 * (double)(i % 3);
        scene->inertia[i] = 1 + 0.5 * (double)(i % 2);
    }
    dl_piece *const piece = &scene->law.piece[0];
    if (variant == SPECIES)
        add_two_species(scene);
    if (variant == SHIFTED)
        piece->end = DL_END_SHIFTED_FORCE;
    if (variant == TAPERED) {
        piece->end = DL_END_TAPER;
        piece->width = 0.4;
    }
    if (variant == ENDLESS) {
        piece->until = INFINITY;
        scene->periods = (dl_periods){0};
    }
    return scene;
}

/* --- energy ----------------------------------------------------------------------------------- */

static void assert_part(const char *what, double change, double before, double after,
                        double scale) {
    if (!(fabs(change - (after - before)) <= 50 * DBL_EPSILON * scale))
        fail_msg("%s changes by %.17g, whole: %.17g - %.17g = %.17g", what, change, after, before,
                 after - before);
}

static void assert_change_is_the_difference(pair_of_states *s) {
    dl_energy before, after, change;
    double scale;
    assert_int_equal(dl_model_energy(s->model, s->before, &before, NULL), DL_OK);
    assert_int_equal(dl_model_energy(s->model, s->after, &after, NULL), DL_OK);
    assert_int_equal(dl_model_energy_scale(s->model, s->before, &scale, NULL), DL_OK);
    scale += fabs(after.pair);
    assert_int_equal(dl_model_energy_change(s->model, s->before, s->after, &change, NULL), DL_OK);
    assert_part("kinetic energy", change.kinetic, before.kinetic, after.kinetic, scale);
    assert_part("pair energy", change.pair, before.pair, after.pair, scale);
    assert_part("energy in gravity", change.gravity, before.gravity, after.gravity, scale);
    assert_part("energy", change.total, before.total, after.total, scale);
    assert_true(change.kinetic < 0 && change.pair != 0);
}

static void mirrored(dl_scene *scene, dl_kernel_choice kernel, size_t least) {
    pair_of_states s = open_states(scene, kernel);
    const size_t n = s.model->unknowns;
    assert_in_range(dl_model_mirror(s.model, s.after, s.after + n), least, s.model->moving / 2);
    assert_change_is_the_difference(&s);
    close_states(&s);
}

static void change_of_a_mirror_is_the_difference_of_the_whole(void **state) {
    (void)state;
    for (int dimension = 2; dimension <= 3; dimension++)
        for (int variant = PLAIN; variant < VARIANTS; variant++)
            for (int kernel = DL_KERNEL_REFERENCE; kernel <= DL_KERNEL_NEIGHBOUR_LIST; kernel++)
                if (variant != ENDLESS || kernel != DL_KERNEL_NEIGHBOUR_LIST)
                    mirrored(liquid(dimension, (enum variant)variant), (dl_kernel_choice)kernel, 4);
}

/* However far: across the box, beyond the list's skin, and across the period. */
static void change_of_any_jump_is_the_difference_of_the_whole(void **state) {
    (void)state;
    for (int variant = PLAIN; variant < ENDLESS; variant++) {
        pair_of_states s = open_states(liquid(2, (enum variant)variant), DL_KERNEL_NEIGHBOUR_LIST);
        const size_t n = s.model->moving;
        for (size_t k = 3; k < n; k += 17) {
            s.after[k] += 7.3;
            s.after[n + k] -= 0.37;
            s.after[2 * n + k] *= 0.5;
        }
        assert_change_is_the_difference(&s);
        close_states(&s);
    }
}

/* Two particles at one place, whose energy is not finite, far from the wall. */
static void what_stays_where_it_is_has_no_part_in_it(void **state) {
    (void)state;
    dl_scene *const scene = liquid(2, PLAIN);
    for (size_t c = 0; c < 2; c++)
        scene->position[c * scene->particles + 40] = scene->position[c * scene->particles + 41];
    pair_of_states s = open_states(scene, DL_KERNEL_NEIGHBOUR_LIST);
    dl_energy whole, change;
    (void)dl_model_mirror(s.model, s.after, s.after + s.model->unknowns);
    assert_int_equal(dl_model_energy(s.model, s.before, &whole, NULL), DL_OK);
    assert_true(!isfinite(whole.total));
    assert_int_equal(dl_model_energy_change(s.model, s.before, s.after, &change, NULL), DL_OK);
    assert_true(isfinite(change.total) && change.pair != 0);
    close_states(&s);
}

/* No list is built, no pair looked at. */
static void velocities_alone_need_no_pairs(void **state) {
    (void)state;
    pair_of_states s = open_states(liquid(2, PLAIN), DL_KERNEL_NEIGHBOUR_LIST);
    dl_energy change;
    for (size_t u = 0; u < s.model->unknowns; u++)
        s.after[s.model->unknowns + u] *= 0.5;
    assert_int_equal(dl_model_energy_change(s.model, s.before, s.after, &change, NULL), DL_OK);
    assert_true(change.pair == 0 && change.gravity == 0 && change.kinetic < 0);
    assert_int_equal(dl_model_list_builds(s.model), 0);
    close_states(&s);
}

/* --- momenta ---------------------------------------------------------------------------------- */

static void assert_momenta(pair_of_states *s) {
    double linear[3], angular[3], before[2][3], after[2][3], scale[2];
    dl_model_momentum(s->model, s->before, before[0], before[1]);
    dl_model_momentum(s->model, s->after, after[0], after[1]);
    dl_model_momentum_scales(s->model, s->before, &scale[0], &scale[1]);
    dl_model_momentum_change(s->model, s->before, s->after, linear, angular);
    for (size_t c = 0; c < 3; c++) {
        assert_part("momentum", linear[c], before[0][c], after[0][c], scale[0]);
        assert_part("angular momentum", angular[c], before[1][c], after[1][c], scale[1]);
    }
    assert_true(fabs(angular[2]) > 1e-3 * scale[1]);
}

static void change_of_momenta_is_the_difference_of_the_whole(void **state) {
    (void)state;
    pair_of_states s = open_states(liquid(3, PLAIN), DL_KERNEL_ALL_PAIRS);
    (void)dl_model_mirror(s.model, s.after, s.after + s.model->unknowns);
    assert_momenta(&s);
    close_states(&s);
    dl_scene *const cluster = fixture_cluster(); /* about its mass centre, which flies */
    for (size_t i = 0; i < 13; i++)
        cluster->velocity[i] += 5;
    cluster->radiation = (dl_radiation){
        .present = true, .period = 0.02, .beyond = 0.5, .factor_above = 1.2, .factor_below = 0.85};
    s = open_states(cluster, DL_KERNEL_ALL_PAIRS);
    assert_in_range(dl_model_radiate(s.model, s.after, s.after + 39), 6, 12);
    assert_momenta(&s);
    close_states(&s);
}

/* --- the ledger ------------------------------------------------------------------------------- */

static double energy_now(rig *r) {
    dl_energy energy;
    assert_int_equal(dl_model_energy(r->model, rig_state(r), &energy, NULL), DL_OK);
    return energy.total;
}

/* Of whole energies, at every step with a hit. Leap-frog's velocities there are those of all
 * particles that the reflected ones act on. */
static void ledger_is_the_sum_of_whole_differences(void **state) {
    (void)state;
    static const char *const methods[] = {"leapfrog", "composition-4-suzuki",
                                          "conserving-newton-dense"};
    for (size_t m = 0; m < 3; m++) {
        const dl_method_row *row = NULL;
        assert_int_equal(dl_method_find(methods[m], &row, NULL), DL_OK);
        rig r = rig_open(row, fixture_box(), "");
        double taken = 0;
        size_t hits = 0;
        for (int k = 0; k < 500; k++) {
            rig_step(&r, INFINITY);
            if (!dl_model_outside(r.model, r.method->y))
                continue;
            const double before = energy_now(&r);
            hits += dl_model_mirror(r.model, r.method->y, r.method->y + r.method->n);
            rig_jumped(&r);
            taken += before - energy_now(&r);
        }
        assert_in_range(hits, 200, 10000);
        dl_run_options how;
        dl_run_options_default(&how);
        dl_run_summary summary;
        dl_error error = {""};
        if (dl_run(r.scene, row, r.options, &how, &summary, NULL, &error))
            fail_msg("%s", error.message);
        assert_int_equal(summary.wall_hits, hits);
        if (!(fabs(summary.ledger - taken) <=
              2 * DBL_EPSILON * sqrt((double)hits) * summary.energy_scale))
            fail_msg("%s: ledger %.17g, whole differences %.17g, %zu hits, scale %g", methods[m],
                     summary.ledger, taken, hits, summary.energy_scale);
        rig_close(&r);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(change_of_a_mirror_is_the_difference_of_the_whole),
        cmocka_unit_test(change_of_any_jump_is_the_difference_of_the_whole),
        cmocka_unit_test(what_stays_where_it_is_has_no_part_in_it),
        cmocka_unit_test(velocities_alone_need_no_pairs),
        cmocka_unit_test(change_of_momenta_is_the_difference_of_the_whole),
        cmocka_unit_test(ledger_is_the_sum_of_whole_differences),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
