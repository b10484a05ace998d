/* The tables of the splittings have the order they claim, and not more: by their order conditions,
 * not by an error that was fitted. */
#include "contract.h"

#include "methods/splitting.h"

#define FOR_EACH_SPLITTING(row)                                                                    \
    FOR_EACH_ROW(row)                                                                              \
    if (row->ops == &dl_splitting_ops)

static const int highest_order = 11;

/* Coefficients are rounded to double: what their sums over long words and trees may be off by. */
static const long double roundoff = 1e-14L;

/* --- any two parts: A the drift, B the kick ----------------------------------------------------
 *
 * A step is exp(b_0 B) exp(a_0 A) exp(b_1 B) ..., a power series in two letters that do not
 * commute; exp(A + B) gives every word of n letters the coefficient 1/n!. Order p: all words of at
 * most p letters agree. A word of n letters has the place 2^n - 1 + its bits, the last letter's
 * lowest. */

enum { drift_letter, kick_letter, words = (1 << 12) - 1 };

static void multiply(long double *series, int letter, long double c) {
    for (int n = highest_order; n >= 1; n--)
        for (int bits = 0; bits < 1 << n; bits++) {
            long double sum = 0, factor = 1;
            for (int k = 1; k <= n && (bits >> (k - 1) & 1) == letter; k++) {
                factor *= c / k;
                sum += factor * series[(1 << (n - k)) - 1 + (bits >> k)];
            }
            series[(1 << n) - 1 + bits] += sum;
        }
}

/* The largest error of the words of each length. */
static void word_errors(const dl_splitting *splitting, long double error[]) {
    static long double series[words];
    memset(series, 0, sizeof series);
    series[0] = 1;
    for (int i = 0; i <= splitting->drifts; i++) {
        multiply(series, kick_letter, (long double)splitting->kick[i]);
        if (i < splitting->drifts)
            multiply(series, drift_letter, (long double)splitting->drift[i]);
    }
    long double exact = 1;
    for (int n = 1; n <= highest_order; n++) {
        exact /= n;
        error[n] = 0;
        for (int bits = 0; bits < 1 << n; bits++)
            error[n] = fmaxl(error[n], fabsl(series[(1 << n) - 1 + bits] - exact));
    }
}

/* --- q'' = a(q): trees of Nystroem ---------------------------------------------------------------
 *
 * E. Hairer, S. P. Norsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed. (1993),
 * doi:10.1007/978-3-540-78862-1, section II.14. A tree is a force with `leaves` velocities and with
 * subtrees, each through one more velocity; its order is 1 + leaves + sum (1 + order of subtree).
 * With c_i the place of kick i and A_ij = b_j (c_i - c_j), j < i,
 *
 *     Phi_i = c_i^leaves prod_subtrees sum_j A_ij Phi_j,      gamma = order prod (order_j + 1)
 * gamma_j velocities: sum b_i Phi_i = 1/gamma,    positions: sum b_i (1 - c_i) Phi_i = 1/((order +
 * 1) gamma)
 */

enum { most_trees = 600, most_subtrees = 6, most_kicks = dl_most_drifts + 1 };

typedef struct tree {
    int order, leaves, subtrees;
    int subtree[most_subtrees];
    long double gamma;
    long double phi[most_kicks], below[most_kicks]; /* Phi_i and sum_j A_ij Phi_j */
} tree;

static struct {
    int count;
    tree at[most_trees];
} forest;

/* Every tree of that order whose subtrees begin with those of `part`; `left` is what is left for
 * leaves and more subtrees, none earlier in the forest than the last. */
static void grow(tree *part, int left) {
    assert_true(forest.count < most_trees);
    part->leaves = left;
    forest.at[forest.count] = *part;
    forest.at[forest.count].gamma = part->gamma * part->order;
    forest.count++;
    const int first = part->subtrees ? part->subtree[part->subtrees - 1] : 0;
    for (int k = first; k < forest.count && forest.at[k].order + 1 <= left; k++) {
        tree larger = *part;
        assert_true(larger.subtrees < most_subtrees);
        larger.subtree[larger.subtrees++] = k;
        larger.gamma *= (forest.at[k].order + 1) * forest.at[k].gamma;
        grow(&larger, left - 1 - forest.at[k].order);
    }
}

static void plant(void) {
    forest.count = 0;
    for (int order = 1; order <= highest_order; order++) {
        tree root = {.order = order, .gamma = 1};
        grow(&root, order - 1);
    }
}

static void weigh(tree *t, int kicks, const long double *b, const long double *c) {
    for (int i = 0; i < kicks; i++) {
        t->phi[i] = powl(c[i], t->leaves);
        for (int k = 0; k < t->subtrees; k++)
            t->phi[i] *= forest.at[t->subtree[k]].below[i];
        t->below[i] = 0;
        for (int j = 0; j < i; j++)
            t->below[i] += b[j] * (c[i] - c[j]) * t->phi[j];
    }
}

/* The largest error of the conditions of each order. */
static void tree_errors(const dl_splitting *splitting, long double error[]) {
    const int kicks = splitting->drifts + 1;
    long double b[most_kicks], c[most_kicks] = {0};
    for (int i = 0; i < kicks; i++) {
        b[i] = (long double)splitting->kick[i];
        if (i > 0)
            c[i] = c[i - 1] + (long double)splitting->drift[i - 1];
    }
    for (int n = 1; n <= highest_order; n++)
        error[n] = 0;
    error[1] = fabsl(c[kicks - 1] - 1);
    for (int k = 0; k < forest.count; k++) {
        tree *const t = &forest.at[k];
        weigh(t, kicks, b, c);
        long double velocity = 0, position = 0;
        for (int i = 0; i < kicks; i++) {
            velocity += b[i] * t->phi[i];
            position += b[i] * (1 - c[i]) * t->phi[i];
        }
        const int n = t->order;
        error[n] = fmaxl(error[n], fabsl(velocity - 1 / t->gamma));
        if (n < highest_order)
            error[n + 1] = fmaxl(error[n + 1], fabsl(position - 1 / ((n + 1) * t->gamma)));
    }
}

/* --- tests --------------------------------------------------------------------------------------
 */

static int order_of(const long double error[]) {
    int order = 0;
    while (order < highest_order && error[order + 1] <= roundoff)
        order++;
    return order;
}

static void check_order(const dl_method_row *row, const char *conditions, int expected,
                        const long double error[]) {
    long double kept = 0;
    for (int n = 1; n <= expected; n++)
        kept = fmaxl(kept, error[n]);
    print_message("%-34s %-6s to order %2d: %.1Le, order %2d: %.1Le\n", row->name, conditions,
                  expected, kept, expected + 1, error[expected + 1]);
    if (order_of(error) != expected)
        fail_msg("%s: order %d by its %s, expected %d", row->name, order_of(error), conditions,
                 expected);
    assert_true(error[expected + 1] > 1e4L * roundoff);
}

static void tables_have_their_order(void **state) {
    (void)state;
    plant();
    /* 1, 1, 2, 3, 6, 10, 20, 36, 72, 137, 275 trees (Hairer, Norsett, Wanner, table II.14.3) */
    assert_int_equal(forest.count, 563);
    int rows = 0;
    FOR_EACH_SPLITTING(row) {
        dl_splitting splitting;
        dl_splitting_expand(row->variant, &splitting);
        long double by_words[12], by_trees[12];
        word_errors(&splitting, by_words);
        tree_errors(&splitting, by_trees);
        check_order(row, "trees", row->order, by_trees);
        if (strncmp(row->name, "rkn-", 4) != 0)
            check_order(row, "words", row->order, by_words);
        rows++;
    }
    assert_true(rows >= 30);
}

/* Orders above 4 of these hold for q'' = a(q) alone. */
static void nystroem_conditions_are_fewer(void **state) {
    (void)state;
    int rows = 0;
    FOR_EACH_SPLITTING(row) {
        if (strncmp(row->name, "rkn-", 4) != 0 || row->order < 5)
            continue;
        dl_splitting splitting;
        dl_splitting_expand(row->variant, &splitting);
        long double error[12];
        word_errors(&splitting, error);
        assert_true(order_of(error) < row->order);
        rows++;
    }
    assert_true(rows >= 4);
}

static bool is_palindrome(const dl_splitting *splitting) {
    const int last = splitting->drifts;
    bool same = true;
    for (int i = 0; i <= last; i++)
        same &= splitting->kick[i] == splitting->kick[last - i];
    for (int i = 0; i < last; i++)
        same &= splitting->drift[i] == splitting->drift[last - 1 - i];
    return same;
}

static void rows_say_what_tables_are(void **state) {
    (void)state;
    FOR_EACH_SPLITTING(row) {
        dl_splitting splitting;
        dl_splitting_expand(row->variant, &splitting);
        assert_true(is_palindrome(&splitting) == !!(row->flags & DL_TIME_SYMMETRIC));
        assert_true(row->flags & DL_SYMPLECTIC);
        int forces = 0;
        for (int i = 1; i <= splitting.drifts; i++)
            forces += splitting.kick[i] != 0;
        forces += splitting.kick[0] != 0 && splitting.kick[splitting.drifts] == 0;
        assert_int_equal(row->forces, forces);
        assert_int_equal(row->stages, forces);
        char stages[16];
        snprintf(stages, sizeof stages, "%d Verlet", row->stages);
        if (row->stages > 1 && strncmp(row->name, "composition", 11) == 0)
            assert_true(strncmp(row->doc, stages, strlen(stages)) == 0);
        snprintf(stages, sizeof stages, "-%d-", row->order);
        assert_non_null(strstr(row->name, stages));
    }
}

/* --- compensated summation ----------------------------------------------------------------------
 */

/* Root mean square of the energy error, in parts of the energy, over the last half of a run. */
static double energy_wander(const char *options, int steps) {
    const dl_method_row *row;
    assert_int_equal(dl_method_find("composition-8-kahan-li", &row, NULL), DL_OK);
    rig r = rig_open(row, fixture_kepler(0.1), options);
    dl_energy start, now;
    assert_int_equal(dl_model_energy(r.model, rig_state(&r), &start, NULL), DL_OK);
    double sum = 0;
    for (int i = 0; i < steps; i++) {
        rig_step(&r, INFINITY);
        if (i < steps / 2)
            continue;
        assert_int_equal(dl_model_energy(r.model, rig_state(&r), &now, NULL), DL_OK);
        const double error = (now.total - start.total) / start.total;
        sum += error * error;
    }
    rig_close(&r);
    return sqrt(sum / (steps - steps / 2));
}

static void compensation_keeps_the_energy(void **state) {
    (void)state;
    const double plain = energy_wander("step=0.05", 100000);
    const double kept = energy_wander("step=0.05 compensated=true", 100000);
    print_message("energy error %.2e, compensated %.2e\n", plain, kept);
    assert_true(kept < plain / 4);
}

/* The same method but for roundoff. */
static void compensation_is_the_same_method(void **state) {
    (void)state;
    FOR_EACH_SPLITTING(row) {
        rig plain = rig_open(row, fixture_cluster(), "step=0.002");
        rig kept = rig_open(row, fixture_cluster(), "step=0.002 compensated=true");
        rig_steps(&plain, 40);
        rig_steps(&kept, 40);
        assert_true(largest_difference(rig_state(&plain), rig_state(&kept), kept.length) < 1e-12);
        assert_memory_not_equal(plain.y, kept.y, kept.length * sizeof *kept.y);
        assert_int_equal(plain.model->counts.force, kept.model->counts.force);
        rig_close(&plain);
        rig_close(&kept);
    }
}

static dl_status failing_acceleration(dl_model *model, const double *q, double *a,
                                      dl_error *error) {
    (void)model, (void)q, (void)a;
    return dl_fail(error, DL_ERROR, "planted failure");
}

/* What was rounded off belongs to the state: a failed step leaves it, a jump forgets it. */
static void compensation_is_part_of_the_state(void **state) {
    (void)state;
    static const char options[] = "step=0.002 compensated=true";
    FOR_EACH_SPLITTING(row) {
        rig failing = rig_open(row, fixture_cluster(), options);
        rig straight = rig_open(row, fixture_cluster(), options);
        rig_steps(&failing, 10);
        dl_status (*const acceleration)(dl_model *, const double *, double *, dl_error *) =
            failing.model->acceleration;
        failing.model->acceleration = failing_acceleration;
        assert_int_equal(dl_method_advance(failing.method, INFINITY, NULL), DL_ERROR);
        failing.model->acceleration = acceleration;
        rig_steps(&failing, 10);
        rig_steps(&straight, 20);
        assert_memory_equal(failing.method->y, straight.method->y, failing.length * sizeof(double));

        rig again = rig_open_at(row, fixture_cluster(), options, rig_state(&straight));
        rig_jumped(&straight);
        rig_steps(&straight, 10);
        rig_steps(&again, 10);
        rig_steps(&failing, 10);
        assert_memory_equal(straight.method->y, again.method->y, again.length * sizeof(double));
        assert_memory_not_equal(failing.method->y, again.method->y, again.length * sizeof(double));
        rig_close(&failing);
        rig_close(&straight);
        rig_close(&again);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tables_have_their_order),
        cmocka_unit_test(nystroem_conditions_are_fewer),
        cmocka_unit_test(rows_say_what_tables_are),
        cmocka_unit_test(compensation_keeps_the_energy),
        cmocka_unit_test(compensation_is_the_same_method),
        cmocka_unit_test(compensation_is_part_of_the_state),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
