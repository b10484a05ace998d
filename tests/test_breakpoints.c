/* Ends of the pair law's pieces: hard, shifted force, taper. */
#include <quadmath.h>

#include "contract.h"
#include "driftlab/explain.h"
#include "driftlab/run.h"
#include "fixture_bounce.h"
#include "fixture_derivatives.h"
#include "force/law.h"
#include "force/vector_ops.h"

#define PIECE(...)                                                                                 \
    { __VA_ARGS__ }
#define TERMS(count, ...)  .terms = count, .term = {__VA_ARGS__}
#define SHIFTED            .end = DL_END_SHIFTED_FORCE
#define TAPER(taper_width) .end = DL_END_TAPER, .width = taper_width

/* Cutoffs and switches, whole powers and real ones, of each kind and mixed; narrow and wide. */
static const dl_pair_law laws[] = {
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}))}},
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}), SHIFTED)}},
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}), TAPER(0.05))}},
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}), TAPER(0.002))}},
    {1, {PIECE(.until = 2.5, TERMS(2, {48, 13}, {-24, 7}), SHIFTED)}},
    {1, {PIECE(.until = 2.5, TERMS(2, {48, 13}, {-24, 7}), TAPER(0.5))}},
    {1, {PIECE(.until = 2.5, TERMS(2, {48, 13}, {-24, 7}), TAPER(1.6))}},
    {2,
     {PIECE(.until = 2.3, TERMS(2, {5, 6}, {-5, 4}), SHIFTED),
      PIECE(.until = INFINITY, TERMS(1, {-1e-3, 2}))}},
    {2,
     {PIECE(.until = 2.3, TERMS(2, {5, 6}, {-5, 4}), TAPER(0.3)),
      PIECE(.until = INFINITY, TERMS(1, {-1e-3, 2}))}},
    {3,
     {PIECE(.until = 0.9, TERMS(2, {3, 5.5}, {-2, 1}), TAPER(0.2)),
      PIECE(.until = 1.4, TERMS(1, {-1, 2.25}), SHIFTED),
      PIECE(.until = 2, TERMS(1, {0.5, 1.5}), SHIFTED)}},
    {3,
     {PIECE(.until = 0.9, TERMS(2, {3, 1}, {-2, 0.5}), SHIFTED),
      PIECE(.until = 1.4, TERMS(1, {-1, 3}), TAPER(0.45)),
      PIECE(.until = 2, TERMS(2, {0.5, 2}, {0.1, 40}), SHIFTED)}},
    {2,
     {PIECE(.until = 1, TERMS(2, {0.1, 3}, {1e-6, 12}), TAPER(0.9)),
      PIECE(.until = 3, TERMS(1, {-1, 2}), TAPER(1.999))}},
};

enum { law_count = sizeof laws / sizeof *laws };

/* --- the same laws in 128 bits ------------------------------------------------------------------
 * S multiplied out, everything a sum of powers of r: what the library does not do. */

enum { most_terms = 80 };

typedef struct wide_piece {
    __float128 end;
    int terms;
    __float128 coefficient[most_terms], power[most_terms];
} wide_piece;

typedef struct wide_law {
    int pieces;
    wide_piece piece[2 * DL_MAX_PIECES];
} wide_law;

static void wide_add(wide_piece *piece, __float128 coefficient, __float128 power) {
    assert_true(piece->terms < most_terms);
    piece->coefficient[piece->terms] = coefficient;
    piece->power[piece->terms++] = power;
}

static __float128 wide_power_sum(const dl_piece *piece, __float128 r) {
    __float128 sum = 0;
    for (int s = 0; s < piece->terms; s++)
        sum += piece->term[s].coefficient * powq(r, -(__float128)piece->term[s].power);
    return sum;
}

static void wide_add_sum(wide_piece *to, const dl_piece *piece, __float128 shift) {
    wide_add(to, shift, 0);
    for (int s = 0; s < piece->terms; s++)
        wide_add(to, piece->term[s].coefficient, piece->term[s].power);
}

/* sum += S(r) * (what `of` is), or (1 - S(r)) of it: S = sum_m a_m ((end - r)/width)^m. */
static void wide_add_faded(wide_piece *to, const wide_piece *of, const dl_piece *taper,
                           bool rises) {
    static const int a[6] = {0, 0, 0, 10, -15, 6};
    const __float128 end = taper->until, width = taper->width;
    for (int s = 0; s < of->terms; s++) {
        __float128 by_power[6] = {0}; /* S = sum_j by_power[j] r^j */
        for (int m = 3; m < 6; m++) {
            __float128 binomial = 1;
            for (int j = 0; j <= m; j++) {
                by_power[j] +=
                    a[m] / powq(width, m) * binomial * powq(end, m - j) * (j % 2 ? -1 : 1);
                binomial = binomial * (m - j) / (j + 1);
            }
        }
        for (int j = 0; j < 6; j++) {
            const __float128 factor = rises ? (j == 0) - by_power[j] : by_power[j];
            wide_add(to, factor * of->coefficient[s], of->power[s] - j);
        }
    }
}

static void widen(const dl_pair_law *law, wide_law *wide) {
    __float128 shift[DL_MAX_PIECES + 1] = {0};
    memset(wide, 0, sizeof *wide);
    for (int k = law->pieces - 1; k >= 0; k--)
        if (law->piece[k].end == DL_END_SHIFTED_FORCE) {
            const __float128 r = law->piece[k].until;
            shift[k] =
                k + 1 < law->pieces ? wide_power_sum(&law->piece[k + 1], r) + shift[k + 1] : 0;
            shift[k] -= wide_power_sum(&law->piece[k], r);
        }
    for (int k = 0; k < law->pieces; k++) {
        const dl_piece *const piece = &law->piece[k];
        wide_piece *const own = &wide->piece[wide->pieces++];
        wide_add_sum(own, piece, shift[k]);
        own->end = (__float128)piece->until;
        if (piece->end != DL_END_TAPER)
            continue;
        own->end -= piece->width;
        wide_piece *const blend = &wide->piece[wide->pieces++], other = {0};
        blend->end = piece->until;
        if (k + 1 < law->pieces)
            wide_add_sum(&other, piece + 1, shift[k + 1]);
        wide_add_faded(blend, own, piece, false);
        wide_add_faded(blend, &other, piece, true);
    }
}

static const wide_piece *wide_at(const wide_law *law, __float128 r) {
    for (int k = 0; k < law->pieces; k++)
        if (r <= law->piece[k].end)
            return &law->piece[k];
    return NULL;
}

static __float128 wide_force(const wide_law *law, __float128 r) {
    const wide_piece *const piece = wide_at(law, r);
    __float128 sum = 0;
    for (int s = 0; piece && s < piece->terms; s++)
        sum += piece->coefficient[s] * powq(r, -piece->power[s]);
    return sum;
}

static __float128 wide_derivative(const wide_law *law, __float128 r) {
    const wide_piece *const piece = wide_at(law, r);
    __float128 sum = 0;
    for (int s = 0; piece && s < piece->terms; s++)
        sum -= piece->coefficient[s] * piece->power[s] * powq(r, -piece->power[s] - 1);
    return sum;
}

static __float128 wide_antiderivative(const wide_piece *piece, __float128 r) {
    __float128 sum = 0;
    for (int s = 0; s < piece->terms; s++) {
        const __float128 c = piece->coefficient[s], p = piece->power[s];
        if (c != 0)
            sum += p == 1 ? -c * logq(r) : c / (p - 1) * powq(r, 1 - p);
    }
    return sum;
}

/* By integrating outwards piece after piece, from r to the last breakpoint or to infinity. */
static __float128 wide_potential(const wide_law *law, __float128 r) {
    __float128 sum = 0;
    for (int k = 0; k < law->pieces; k++) {
        const __float128 begin = k ? law->piece[k - 1].end : 0, end = law->piece[k].end;
        if (r >= end)
            continue;
        sum += wide_antiderivative(&law->piece[k], r > begin ? r : begin);
        if (!isinfq(end))
            sum -= wide_antiderivative(&law->piece[k], end);
    }
    return sum;
}

static double nearest(const dl_pair_law *law) {
    return 0.4 * law->piece[0].until;
}

static double farthest(const dl_pair_law *law) {
    const double end = law->piece[law->pieces - 1].until;
    return isfinite(end) ? 1.1 * end : 5;
}

/* The moduli that the force at r is made of: its own, and those of the pieces it blends. */
static double force_size(const dl_pair_law *law, double r) {
    double size = 0;
    for (int k = 0; k < law->pieces; k++) {
        const dl_piece *const piece = &law->piece[k];
        for (int s = 0; s < piece->terms; s++)
            if (r <= piece->until &&
                (k == 0 || r > law->piece[k - 1].until - law->piece[k - 1].width))
                size += fabs(piece->term[s].coefficient) * pow(r, -piece->term[s].power);
    }
    return size;
}

/* How much steeper than r^-p a taper is. */
static double steepness(const dl_pair_law *law) {
    double most = 1;
    for (int k = 0; k < law->pieces; k++)
        if (law->piece[k].end == DL_END_TAPER)
            most = fmax(most, law->piece[k].until / law->piece[k].width);
    return most;
}

static void force_and_its_slope_are_exact(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        wide_law wide;
        dl_law law;
        widen(&laws[k], &wide);
        dl_law_prepare(&laws[k], &law);
        for (double r = nearest(&laws[k]); r < farthest(&laws[k]); r *= 1.0037) {
            const double s = r * r, size = force_size(&laws[k], r) + 1e-3;
            const double force = (double)wide_force(&wide, r);
            const double slope =
                (double)((wide_derivative(&wide, r) - wide_force(&wide, r) / r) / s);
            assert_true(fabs(dl_law_force_over_r(&law, s) * r - force) <=
                        4e-15 * size * (1 + steepness(&laws[k]) / 100));
            assert_true(fabs(dl_law_force_slope(&law, s) - slope) * s * r <=
                        1e-14 * size * steepness(&laws[k]));
        }
    }
}

/* --- what each end promises ---------------------------------------------------------------------
 */

static double force_at(const dl_law *law, double r) {
    return dl_law_force_over_r(law, r * r) * r;
}

static double derivative_at(const dl_law *law, double r) {
    return dl_law_force_slope(law, r * r) * r * r + dl_law_force_over_r(law, r * r);
}

typedef struct jump {
    double force, first, second; /* from below to above a distance: F, its derivatives */
} jump;

static jump jump_at(const dl_law *law, double r, double h) {
    const double below = derivative_at(law, r - h), above = derivative_at(law, r + h);
    return (jump){force_at(law, r + h) - force_at(law, r - h), above - below,
                  (derivative_at(law, r + 2 * h) - above) / h -
                      (below - derivative_at(law, r - 2 * h)) / h};
}

/* At its cutoff the fluid's force is 12400 and its derivative 3200 - 204800 = -201600. */
static void ends_are_as_smooth_as_they_say(void **state) {
    (void)state;
    const double cutoff = 0.25, width = 0.05, h = 1e-7;
    dl_law law;
    dl_law_prepare(&laws[0], &law);
    assert_true(fabs(jump_at(&law, cutoff, h).force + 12400) < 0.1);
    dl_law_prepare(&laws[1], &law);
    const jump shifted = jump_at(&law, cutoff, h);
    assert_true(fabs(shifted.force) < 0.1 && fabs(shifted.first - 201600) < 10);
    assert_true(fabs(force_at(&law, cutoff)) < 1e-9);
    dl_law_prepare(&laws[2], &law);
    for (int end = 0; end < 2; end++) { /* where the taper ends, where it begins */
        const double at = end ? cutoff - width : cutoff, size = 30625;
        /* the third derivative is of the size 60 F/width^3, the second changes by h of that; a
         * smoothstep that is not C2 would have it jump by 6 F/width^2 */
        const jump wide = jump_at(&law, at, width / 1e4), close = jump_at(&law, at, h);
        assert_true(fabs(wide.second) < 0.1 * size / (width * width));
        assert_true(fabs(close.first) < 1e-4 * size / width);
        assert_true(fabs(close.force) < 1e-4 * size);
    }
    assert_true(force_at(&law, cutoff) == 0);
    assert_true(fabs(force_at(&law, 0.15) + 25 / (0.15 * 0.15) - 50 / pow(0.15, 4)) < 1e-9);
}

/* At a switch the force is that of the next piece, whatever that has itself become. */
static void switches_meet_the_next_piece(void **state) {
    (void)state;
    for (int k = 7; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(&laws[k], &law);
        for (int piece = 0; piece < laws[k].pieces; piece++) {
            const dl_piece *const own = &laws[k].piece[piece];
            if (own->end == DL_END_HARD)
                continue;
            const double size = force_size(&laws[k], own->until - own->width);
            const jump found = jump_at(&law, own->until, 1e-9 * own->until);
            assert_true(fabs(found.force) < 1e-6 * size);
            if (own->end == DL_END_TAPER)
                assert_true(fabs(found.first) < 1e-5 * size / own->width);
        }
    }
}

static void potential_is_the_integral_of_the_force(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        wide_law wide;
        dl_law law;
        widen(&laws[k], &wide);
        dl_law_prepare(&laws[k], &law);
        const double most = fabs((double)wide_potential(&wide, nearest(&laws[k])));
        for (double r = nearest(&laws[k]); r < farthest(&laws[k]); r *= 1.0037) {
            const double expected = (double)wide_potential(&wide, r);
            const double size = most + force_size(&laws[k], r) * r;
            assert_true(fabs(dl_law_potential(&law, r * r) - expected) <= 2e-15 * size);
        }
        const double end = laws[k].piece[laws[k].pieces - 1].until;
        if (isfinite(end)) {
            assert_true(fabs(dl_law_potential(&law, end * end)) <= 1e-15 * most);
            assert_true(dl_law_potential(&law, 1.01 * end * end) == 0);
        }
    }
}

/* --- the discrete gradient ----------------------------------------------------------------------
 */

/* Integral of the force in 128 bits: Simpson's rule where r hardly changes, for there the
 * difference of the potentials has too few digits, breakpoint after breakpoint. */
static __float128 wide_work(const wide_law *law, __float128 from, __float128 to) {
    if (fabsq(to - from) > 1e-7Q * from)
        return wide_potential(law, from) - wide_potential(law, to);
    const __float128 high = from < to ? to : from;
    __float128 sum = 0, begin = from < to ? from : to;
    for (int k = 0; k <= law->pieces && begin < high; k++) {
        const __float128 end =
            k < law->pieces && law->piece[k].end < high ? law->piece[k].end : high;
        if (end <= begin)
            continue;
        const __float128 h = (end - begin) / 2;
        sum += h / 3 * /* its ends just inside, in the piece that the part lies in */
               (wide_force(law, begin + h * 1e-9Q) + 4 * wide_force(law, begin + h) +
                wide_force(law, end - h * 1e-9Q));
        begin = end;
    }
    return from < to ? sum : -sum;
}

static void check_discrete(int k, const wide_law *wide, const dl_law *law, double r0, double x) {
    const double s0 = r0 * r0, ds = s0 * (x * (2 + x)), s1 = s0 + ds;
    const double least = fmin(r0, sqrt(s1));
    if (least < nearest(&laws[k]))
        return;
    const __float128 from = sqrtq(s0), to = sqrtq((__float128)s0 + ds);
    const double expected = (double)(wide_work(wide, from, to) / ds);
    const double got = dl_law_discrete(law, s0, s1, ds, NULL);
    const double size = (force_size(&laws[k], least) + 1e-3) / (2 * least);
    if (!(fabs(got - expected) <= 1e-14 * size))
        fail_msg("law %d from %.17g by %g: %.17g, expected %.17g", k, r0, x, got, expected);
}

static void discrete_gradient_keeps_its_digits(void **state) {
    (void)state;
    static const double ratios[] = {1e-14, 1e-11, 1e-8, 1e-5, 1e-3, 0.03, 0.2, 0.7, 2.5};
    for (int k = 0; k < law_count; k++) {
        wide_law wide;
        dl_law law;
        widen(&laws[k], &wide);
        dl_law_prepare(&laws[k], &law);
        for (double r0 = nearest(&laws[k]); r0 < farthest(&laws[k]); r0 *= 1.017)
            for (size_t m = 0; m < sizeof ratios / sizeof *ratios; m++) {
                check_discrete(k, &wide, &law, r0, ratios[m]);
                check_discrete(k, &wide, &law, r0, 1 / (1 + ratios[m]) - 1);
            }
    }
}

/* Small steps and leaps, out and in again, across every breakpoint. */
static void work_along_a_path_is_the_change_of_potential(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(&laws[k], &law);
        const double low = nearest(&laws[k]), high = farthest(&laws[k]);
        const double middle = (low + high) / 2, half = (high - low) / 2;
        double r = low, work = 0, largest_part = 0;
        const double before = dl_law_potential(&law, r * r);
        for (unsigned step = 0; step < 500; step++) {
            double next = r + (step % 7 ? 0.02 : 1) * half * fixture_noise(step);
            if (fabs(next - middle) > half)
                next = middle + half * fixture_noise(step + 1000);
            const double ds = (next - r) * (next + r);
            const double part = dl_law_discrete(&law, r * r, next * next, ds, NULL) * ds;
            work += part;
            largest_part = fmax(largest_part, fabs(part));
            r = next;
        }
        const double after = dl_law_potential(&law, r * r);
        assert_true(fabs(work + after - before) <= 1e-13 * (largest_part + fabs(before)));
    }
}

static void discrete_slope_is_the_derivative(void **state) {
    (void)state;
    for (int k = 0; k < law_count; k++) {
        dl_law law;
        dl_law_prepare(&laws[k], &law);
        for (double r0 = nearest(&laws[k]); r0 < farthest(&laws[k]); r0 *= 1.023)
            for (double ratio = 0.8; ratio < 1.3; ratio += 0.0701) {
                double slope;
                const double s0 = r0 * r0, s1 = s0 * ratio, h = 1e-6 * s1 / steepness(&laws[k]);
                if (dl_law_piece(&law, s1 - h) != dl_law_piece(&law, s1 + h))
                    continue;
                dl_law_discrete(&law, s0, s1, s1 - s0, &slope);
                const double up = dl_law_discrete(&law, s0, s1 + h, s1 + h - s0, NULL);
                const double down = dl_law_discrete(&law, s0, s1 - h, s1 - h - s0, NULL);
                const double size = (force_size(&laws[k], fmin(r0, sqrt(s1))) + 1e-3) / (r0 * s1);
                assert_true(fabs(slope - (up - down) / (2 * h)) <=
                            1e-8 * size * steepness(&laws[k]));
            }
    }
}

/* --- the vectorised loops ------------------------------------------------------------------------
 */

enum { pairs = 400, room = pairs + DL_VECTOR_PAD };

static void compare_loops(const dl_pair_law *source) {
    double s0[room], s1[room], ds[room], f[room], g[room];
    dl_law law;
    dl_law_prepare(source, &law);
    const double low = nearest(source), high = farthest(source);
    for (unsigned k = 0; k < room; k++) {
        const double r0 = low + (high - low) * k / room;
        /* most pairs move little, some far */
        const double way = (k % 11 ? 0.003 : 0.4) * (high - low) * fixture_noise(k);
        const double r1 = fmax(low, r0 + way);
        s0[k] = r0 * r0;
        ds[k] = (r1 - r0) * (r1 + r0);
        s1[k] = s0[k] + ds[k];
    }
    const dl_law_loops *const loops = dl_vector_best()->loops_for(&law);
    loops->force(&law, s0, f, pairs);
    loops->discrete(&law, s0, s1, ds, g, pairs);
    for (int k = 0; k < pairs; k++) {
        const double r0 = sqrt(s0[k]), least = fmin(r0, sqrt(s1[k]));
        const double size = (force_size(source, r0) + 1e-3) * (1 + steepness(source) / 10);
        assert_true(fabs(f[k] - dl_law_force_over_r(&law, s0[k])) * r0 <= 5e-15 * size);
        const double path = (force_size(source, least) + 1e-3) * (1 + steepness(source) / 10);
        assert_true(fabs(g[k] - dl_law_discrete(&law, s0[k], s1[k], ds[k], NULL)) * 2 * least <=
                    1e-14 * path);
    }
}

static void every_loop_equals_the_law(void **state) {
    (void)state;
    static const char *const sets[] = {"plain", "avx2", "avx512"};
    for (int set = 0; set < 3; set++)
        for (int k = 0; k < law_count && dl_vector_force(sets[set]); k++)
            compare_loops(&laws[k]);
    dl_vector_force(NULL);
}

/* A smooth law must not be taken for a hard one that has the same powers. */
static void hard_laws_alone_run_loops_of_their_own(void **state) {
    (void)state;
    dl_law law;
    dl_law_prepare(&laws[0], &law);
    assert_string_equal(dl_vector_best()->loops_for(&law)->name, "fluid_2_4");
    for (int k = 1; k < 3; k++) {
        dl_law_prepare(&laws[k], &law);
        assert_string_equal(dl_vector_best()->loops_for(&law)->name, "whole powers");
    }
}

/* --- in a model ----------------------------------------------------------------------------------
 */

static const dl_pair_law ends[] = {
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}))}},
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}), SHIFTED)}},
    {1, {PIECE(.until = 0.25, TERMS(2, {-25, 2}, {50, 4}), TAPER(0.1))}},
};

/* The box pressed together until its pairs are about the cutoff. */
static dl_model *pressed_box(const dl_pair_law *law, dl_scene **scene) {
    dl_model *model;
    *scene = fixture_box();
    (*scene)->law = *law;
    for (size_t i = 0; i < box_unknowns; i++)
        (*scene)->position[i] *= 0.7;
    assert_int_equal(dl_model_create(*scene, &model, NULL), DL_OK);
    assert_int_equal(model->unknowns, box_unknowns);
    return model;
}

static void jacobians_are_the_derivatives(void **state) {
    (void)state;
    for (int k = 0; k < 3; k++) {
        dl_scene *scene;
        dl_model *const model = pressed_box(&ends[k], &scene);
        double y[2 * box_unknowns], delta[box_unknowns];
        dl_model_initial_state(model, y);
        for (unsigned i = 0; i < box_unknowns; i++)
            delta[i] = 0.01 * fixture_noise(i + 100);
        fixture_check_jacobian(model, y, NULL);
        fixture_check_jacobian(model, y, delta);
        dl_model_free(model);
        dl_scene_free(scene);
    }
}

static void run(dl_scene *scene, const char *method, dl_run_summary *summary) {
    const dl_method_row *row;
    void *options;
    dl_error error = {""};
    dl_run_options run_options;
    dl_run_options_default(&run_options);
    assert_int_equal(dl_method_find(method, &row, &error), DL_OK);
    assert_int_equal(dl_method_options_create(row, scene, &options, &error), DL_OK);
    assert_int_equal(dl_run(scene, row, options, &run_options, summary, NULL, &error), DL_OK);
    dl_method_options_free(row, options);
}

/* TR323's settled fluid: the energy, what the walls take being booked, stays to roundoff. */
static void the_fluid_keeps_its_energy_at_every_end(void **state) {
    (void)state;
    static const char *const methods[] = {"conserving-fixed-point", "conserving-newton-klu"};
    for (int k = 0; k < 3; k++)
        for (int m = 0; m < 2; m++) {
            dl_scene *scene;
            dl_run_summary summary;
            assert_int_equal(dl_scene_read(DL_STUDIES "/drop/settled.yaml", &scene, NULL), DL_OK);
            scene->law = ends[k];
            scene->end = m ? 0.001 : 0.004;
            scene->sample = 0;
            run(scene, methods[m], &summary);
            assert_int_equal(summary.status, DL_OK);
            assert_true(summary.energy_error_max <= 1e-13 * summary.energy_scale);
            dl_scene_free(scene);
        }
}

/* --- orders on one pair --------------------------------------------------------------------------
 */

/* Root mean square over flights that meet the cutoff at different parts of a step, going in and,
 * by their speed, going out. */
static double bounce_error(const dl_method_row *row, const dl_pair_law *law, int steps) {
    enum { phases = 32 };
    double sum = 0;
    for (int phase = 0; phase < phases; phase++) {
        const double from = 0.6 + 0.05 * fmod(0.618034 * phase, 1);
        const double speed = 25 + 3 * fmod(0.754878 * phase, 1);
        char options[64];
        snprintf(options, sizeof options, "step=%.17g", bounce_time / steps);
        rig r = rig_open(row, fixture_bounce(law, from, speed), options);
        rig_steps(&r, steps);
        const double error = rig_state(&r)[0] - fixture_bounce_exact(law, from, speed);
        sum += error * error;
        rig_close(&r);
    }
    return sqrt(sum / phases);
}

static double bounce_order(const char *method, int end) {
    enum { points = 8 };
    const dl_method_row *row;
    double step[points], error[points];
    assert_int_equal(dl_method_find(method, &row, NULL), DL_OK);
    for (int k = 0; k < points; k++) {
        const int steps = (int)lround(100 * pow(2, k / 2.0));
        step[k] = bounce_time / steps;
        error[k] = bounce_error(row, &ends[end], steps);
    }
    const double order = fitted_order(step, error, points);
    print_message("%-26s end %d: order %.2f, error %.1e at step %.1e\n", method, end, order,
                  error[points - 1], step[points - 1]);
    return order;
}

/* Where the force's m-th derivative jumps, the velocity is wrong by h^(m+1) after the step that
 * crosses the breakpoint: order 1 for a hard end, 2 for a shifted force, 4 for a taper, or the
 * method's own where that is lower. */
static void the_order_is_that_of_the_end(void **state) {
    (void)state;
    static const struct {
        const char *method;
        int end;
        double order, tolerance;
    } rows[] = {
        {"composition-2-verlet", 0, 1, 0.25},   {"composition-4-yoshida", 0, 1, 0.25},
        {"composition-6-kahan-li", 0, 1, 0.25}, {"composition-4-yoshida", 1, 2, 0.25},
        {"composition-6-kahan-li", 1, 2, 0.25}, {"composition-2-verlet", 2, 2, 0.1},
        {"composition-4-yoshida", 2, 4, 0.15},  {"composition-6-kahan-li", 2, 4, 0.25},
        {"conserving-newton-dense", 2, 2, 0.1},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        const double order = bounce_order(rows[k].method, rows[k].end);
        if (!(fabs(order - rows[k].order) <= rows[k].tolerance))
            fail_msg("%s, end %d: order %.3f, expected %g", rows[k].method, rows[k].end, order,
                     rows[k].order);
    }
}

/* --- scenes --------------------------------------------------------------------------------------
 */

/* A scene with this pair_law, its lines 7 and on, in a file of its own. */
static dl_status read_law(const char *pieces, dl_scene **scene, dl_error *error) {
    char path[] = "/tmp/driftlab-breakpoints-XXXXXX";
    const int descriptor = mkstemp(path);
    FILE *const file = fdopen(descriptor, "w");
    assert_non_null(file);
    fprintf(file,
            "name: ends\ndimension: 2\nparticles:\n  - {at: [0, 0]}\n  - {at: [1, 0]}\n"
            "pair_law:\n%stime: {step: 0.01, end: 1}\n",
            pieces);
    fclose(file);
    const dl_status status = dl_scene_read(path, scene, error);
    remove(path);
    return status;
}

static const char three_ends[] =
    "  - {until: 1, end: taper, width: 0.25, terms: [{coefficient: 2, power: 3}]}\n"
    "  - {until: 2, end: hard, terms: [{coefficient: 1, power: 2}]}\n"
    "  - {until: 3, end: shifted-force, terms: [{coefficient: -1.5, power: 2}]}\n";

static void ends_are_read(void **state) {
    (void)state;
    dl_scene *scene;
    assert_int_equal(read_law(three_ends, &scene, NULL), DL_OK);
    const dl_piece *const piece = scene->law.piece;
    assert_int_equal(scene->law.pieces, 3);
    assert_int_equal(piece[0].end, DL_END_TAPER);
    assert_int_equal(piece[1].end, DL_END_HARD);
    assert_int_equal(piece[2].end, DL_END_SHIFTED_FORCE);
    assert_true(piece[0].width == 0.25 && piece[1].width == 0 && piece[2].width == 0);
    dl_scene_free(scene);
    static const char plain[] = "  - {until: 1, terms: [{coefficient: 2, power: 3}]}\n";
    assert_int_equal(read_law(plain, &scene, NULL), DL_OK);
    assert_int_equal(scene->law.piece[0].end, DL_END_HARD);
    dl_scene_free(scene);
}

static void impossible_ends_are_refused(void **state) {
    (void)state;
#define LAW_TERMS "terms: [{coefficient: 2, power: 3}]}\n"
    static const struct {
        const char *pieces, *fragment[4];
    } rows[] = {
        {"  - {until: 1, end: taper, " LAW_TERMS, {":7:", "width", "nothing", "tapered"}},
        {"  - {until: 1, width: 0.5, " LAW_TERMS, {":7:", "width", "\"0.5\"", "end: taper"}},
        {"  - {until: 1, end: shifted-force, width: 0.5, " LAW_TERMS,
         {":7:", "width", "\"0.5\"", "end: taper"}},
        {"  - {until: 1, end: taper, width: 1, " LAW_TERMS,
         {":7:", "width", "\"1\"", "less than 1"}},
        {"  - {until: 1, " LAW_TERMS "  - {until: 1.5, end: taper, width: 0.6, " LAW_TERMS,
         {":8:", "width", "\"0.6\"", "less than 0.5"}},
        {"  - {until: 1, end: taper, width: 0, " LAW_TERMS, {":7:", "width", "\"0\"", "> 0"}},
        {"  - {until: 1, end: taper, width: -1, " LAW_TERMS, {":7:", "width", "\"-1\"", "> 0"}},
        {"  - {until: 1, end: soft, " LAW_TERMS,
         {":7:", "end", "\"soft\"", "hard | shifted-force | taper"}},
        {"  - {end: shifted-force, " LAW_TERMS, {":7:", "end", "\"shifted-force\"", "never ends"}},
        {"  - {end: taper, width: 0.1, " LAW_TERMS, {":7:", "end", "\"taper\"", "never ends"}},
    };
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        dl_scene *scene;
        dl_error error = {""};
        assert_int_equal(read_law(rows[k].pieces, &scene, &error), DL_INPUT);
        assert_null(scene);
        for (int i = 0; i < 4; i++)
            if (!strstr(error.message, rows[k].fragment[i]))
                fail_msg("\"%s\" lacks \"%s\"", error.message, rows[k].fragment[i]);
    }
}

static void explain_names_every_end(void **state) {
    (void)state;
    static const char *const fragments[] = {
        "2 r^-3   for 0 < r <= 0.75, then its taper",
        "S ( 2 r^-3 ) + (1 - S) ( 1 r^-2 )   for 0.75 < r <= 1, end: taper",
        "1 r^-2   for 1 < r <= 2, end: hard",
        "0.16666666666666666 -1.5 r^-2   for 2 < r <= 3, end: shifted force",
    };
    dl_scene *scene;
    dl_model *model;
    char *text = NULL;
    size_t size;
    FILE *const out = open_memstream(&text, &size);
    assert_int_equal(read_law(three_ends, &scene, NULL), DL_OK);
    assert_int_equal(dl_model_create(scene, &model, NULL), DL_OK);
    dl_explain(model, out);
    fclose(out);
    for (size_t k = 0; k < sizeof fragments / sizeof *fragments; k++)
        if (!strstr(text, fragments[k]))
            fail_msg("\"%s\" lacks \"%s\"", text, fragments[k]);
    free(text);
    dl_model_free(model);
    dl_scene_free(scene);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(force_and_its_slope_are_exact),
        cmocka_unit_test(ends_are_as_smooth_as_they_say),
        cmocka_unit_test(switches_meet_the_next_piece),
        cmocka_unit_test(potential_is_the_integral_of_the_force),
        cmocka_unit_test(discrete_gradient_keeps_its_digits),
        cmocka_unit_test(work_along_a_path_is_the_change_of_potential),
        cmocka_unit_test(discrete_slope_is_the_derivative),
        cmocka_unit_test(every_loop_equals_the_law),
        cmocka_unit_test(hard_laws_alone_run_loops_of_their_own),
        cmocka_unit_test(jacobians_are_the_derivatives),
        cmocka_unit_test(the_fluid_keeps_its_energy_at_every_end),
        cmocka_unit_test(the_order_is_that_of_the_end),
        cmocka_unit_test(ends_are_read),
        cmocka_unit_test(impossible_ends_are_refused),
        cmocka_unit_test(explain_names_every_end),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
