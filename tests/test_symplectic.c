/* What flags say of the step map, and what their absence says: every row that keeps a fixed step is
 * held to both, by the map itself and its derivatives. */
#include "contract.h"

enum { length = 8, half = length / 2, steps_taken = 2 };

/* A pair that turns and vibrates, far from any symmetry of the scene. */
static void start(double y[length]) {
    dl_scene *const scene = fixture_oscillator();
    dl_model *model = NULL;
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    dl_model_initial_state(model, y);
    for (size_t i = 0; i < length; i++)
        y[i] += 0.1 * fixture_noise((unsigned)i);
    dl_model_free(model);
    dl_scene_free(scene);
}

static const double inertia[2] = {1, 2};

/* A few steps from y, into y. Returns whether the method could take them. */
static bool flow(const dl_method_row *row, double step, double y[length]) {
    char options[32];
    snprintf(options, sizeof options, "step=%.17g", step);
    rig r = rig_open_at(row, fixture_oscillator(), options, y);
    dl_status status = DL_OK;
    for (int k = 0; k < steps_taken && !status; k++)
        status = dl_method_advance(r.method, INFINITY, NULL);
    if (!status)
        memcpy(y, rig_state(&r), length * sizeof *y);
    rig_close(&r);
    return status == DL_OK;
}

/* How far a row's maps are from keeping something, at a step; NAN where it cannot take that. */
typedef double measure(const dl_method_row *row, double step);

/* --- the symplectic form ------------------------------------------------------------------------
 */

/* d y_end / d y_start[column], by central differences of order 4 over +-2 d. */
static bool differentiate(const dl_method_row *row, double step, size_t column, double d,
                          double derivative[length]) {
    static const double at[4] = {-2, -1, 1, 2},
                        weight[4] = {1.0 / 12, -8.0 / 12, 8.0 / 12, -1.0 / 12};
    memset(derivative, 0, length * sizeof *derivative);
    for (int k = 0; k < 4; k++) {
        double y[length];
        start(y);
        y[column] += at[k] * d;
        if (!flow(row, step, y))
            return false;
        for (size_t i = 0; i < length; i++)
            derivative[i] += weight[k] * y[i] / d;
    }
    return true;
}

/* sum over coordinates of inertia (dq a)(dv b) - (dv a)(dq b). */
static double form(const double a[length], const double b[length]) {
    double sum = 0;
    for (size_t i = 0; i < half; i++)
        sum += inertia[i % 2] * (a[i] * b[half + i] - a[half + i] * b[i]);
    return sum;
}

/* J^T Omega J - Omega, largest entry, in parts of what its entries are made of; less what the
 * differences can be wrong by, to be seen from wider ones. */
static double symplectic_defect(const dl_method_row *row, double step) {
    const double d = 2e-4;
    double jacobian[length][length], wider[length], largest = 1, wrong = 0, defect = 0;
    for (size_t c = 0; c < length; c++) {
        if (!differentiate(row, step, c, d, jacobian[c]) ||
            !differentiate(row, step, c, 2 * d, wider))
            return NAN;
        for (size_t i = 0; i < length; i++)
            largest = fmax(largest, fabs(jacobian[c][i]));
        wrong = fmax(wrong, largest_difference(jacobian[c], wider, length));
    }
    for (size_t a = 0; a < length; a++)
        for (size_t b = 0; b < length; b++) {
            double unit[2][length] = {{0}};
            unit[0][a] = unit[1][b] = 1;
            const double before = form(unit[0], unit[1]), after = form(jacobian[a], jacobian[b]);
            defect = fmax(defect, fabs(after - before));
        }
    return fmax(0, defect / (largest * largest) - 10 * wrong / largest);
}

/* --- reversal and momenta -----------------------------------------------------------------------
 */

static double reversal_defect(const dl_method_row *row, double step) {
    double y[length], first[length];
    start(y);
    memcpy(first, y, sizeof first);
    for (int way = 0; way < 2; way++) {
        if (!flow(row, step, y))
            return NAN;
        for (size_t i = half; i < length; i++)
            y[i] *= -1;
    }
    return largest_difference(y, first, length);
}

static double angular_momentum(const double y[length]) {
    double sum = 0;
    for (size_t i = 0; i < 2; i++)
        sum += inertia[i] * (y[i] * y[half + 2 + i] - y[2 + i] * y[half + i]);
    return sum;
}

static double momentum_defect(const dl_method_row *row, double step) {
    double y[length], first[length], defect = 0;
    start(y);
    memcpy(first, y, sizeof first);
    if (!flow(row, step, y))
        return NAN;
    for (size_t c = half; c < length; c += 2)
        defect = fmax(
            defect, fabs(inertia[0] * (y[c] - first[c]) + inertia[1] * (y[c + 1] - first[c + 1])));
    return fmax(defect, fabs(angular_momentum(y) - angular_momentum(first)));
}

/* --- rows ---------------------------------------------------------------------------------------
 */

/* Rows with the flag are within `kept` at every step up to `longest`; rows without it come
 * beyond `broken`, as the step grows. */
static void check(const char *what, unsigned flag, measure *defect_of, double longest, double kept,
                  double broken) {
    int with = 0, without = 0;
    FOR_EACH_ROW(row) {
        if (!(row->flags & DL_FIXED_STEP))
            continue;
        const bool promised = row->flags & flag;
        double worst = 0, at = 0;
        for (double step = 0.1; step < 4; step *= 1.5) {
            const double defect = defect_of(row, step);
            if (isnan(defect) || (promised && step > longest))
                break;
            worst = fmax(worst, defect);
            at = step;
            if (!promised && worst > broken)
                break;
        }
        print_message("%-34s %s: %-3s %.1e to step %.2g\n", row->name, what,
                      promised ? "yes" : "no", worst, at);
        assert_true(at > 0);
        if (promised && !(worst <= kept))
            fail_msg("%s: %s promised, defect %g", row->name, what, worst);
        if (!promised && !(worst > broken))
            fail_msg("%s: %s not promised, defect only %g", row->name, what, worst);
        with += promised;
        without += !promised;
    }
    assert_true(with >= 30 && without >= 4);
}

static void maps_are_symplectic_as_flags_say(void **state) {
    (void)state;
    check("symplectic", DL_SYMPLECTIC, symplectic_defect, 2, 1e-11, 1e-9);
}

static void maps_reverse_as_flags_say(void **state) {
    (void)state;
    check("reversal", DL_TIME_SYMMETRIC, reversal_defect, 0.6, 1e-12, 1e-9);
}

static void maps_keep_momenta_as_flags_say(void **state) {
    (void)state;
    check("momenta", DL_CONSERVES_MOMENTUM, momentum_defect, 0.6, 1e-13, 1e-10);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(maps_are_symplectic_as_flags_say),
        cmocka_unit_test(maps_reverse_as_flags_say),
        cmocka_unit_test(maps_keep_momenta_as_flags_say),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
