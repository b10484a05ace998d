#include <dirent.h>
#include <float.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "driftlab/parameter.h"
#include "driftlab/scene.h"
#include "driftlab/trajectory.h"
#include "scene/tables.h"

static void assert_near(double value, double expected, double tolerance) {
    if (!(fabs(value - expected) <= tolerance))
        fail_msg("%.17g is not within %g of %.17g", value, tolerance, expected);
}

/* --- files that must be refused --------------------------------------------------------------- */

/* A file of tests/scenes/bad and what its message must say: the place first, then key, value and
 * what was expected. */
typedef struct refusal {
    const char *file;
    const char *fragment[4];
} refusal;

static const refusal refusals[] = {
    {"all-pinned", {"all-pinned.yaml:5:", "pinned", "all 2 particles"}},
    {"coincident",
     {"coincident.yaml:7:", "(1, 0)", "coincident.yaml:5 ", "; lines 4 and 8 at (0, "}},
    {"coincident-across", {"coincident-across.yaml:5:", "(3, 3)", "coincident-across.csv:3 "}},
    {"coincident-rows",
     {"coincident-rows.csv:6:", "(1, 0)", "coincident-rows.csv:4 ", "; lines 3 and 7 at (0, 0)"}},
    {"cycle", {"cycle.yaml:3:", "contains itself"}},
    {"damping-range", {"damping-range.yaml:9:", "damping", "\"1.5\"", ">= 0, <= 1"}},
    {"dimension-4", {"dimension-4.yaml:2:", "dimension", "\"4\"", ">= 2, <= 3"}},
    {"dimension-word", {"dimension-word.yaml:2:", "dimension", "\"2d\"", "whole number"}},
    {"double-column", {"double-column.csv:1:", "\"x\"", "second time"}},
    {"double-mass", {"double-mass.csv:1:", "\"mass\"", "second time", "the same"}},
    {"duplicate-key", {"duplicate-key.yaml:11:", "gravity", "second time", "line 8"}},
    {"empty", {"empty.yaml:1:", "empty"}},
    {"empty-cell", {"empty-cell.csv:2:", "vx", "\"\"", "a number"}},
    {"empty-data", {"empty-data.csv:1:", "empty", "names of columns"}},
    {"empty-name", {"empty-name.yaml:1:", "name", "\"\"", "text"}},
    {"empty-particles", {"empty-particles.yaml:3:", "particles", "list of 0", "at least one"}},
    {"empty-terms", {"empty-terms.yaml:7:", "terms", "list of 0", "1 to 4"}},
    {"end-not-whole", {"end-not-whole.yaml:10:", "end", "\"1\"", "steps of 0.03"}},
    {"file-and-at", {"file-and-at.yaml:4:", "at", "list of 2", "none beside a file"}},
    {"gravity-length", {"gravity-length.yaml:8:", "gravity", "list of 3", "2 numbers"}},
    {"gravity-scalar", {"gravity-scalar.yaml:8:", "gravity", "\"-1\"", "2 numbers"}},
    {"half-velocity", {"half-velocity.csv:1:", "\"vy\""}},
    {"hexadecimal-step", {"hexadecimal-step.yaml:10:", "step", "\"0x1p-4\"", "> 0"}},
    {"infinite-mass", {"infinite-mass.yaml:5:", "mass", "\"inf\"", "> 0"}},
    {"item-without-place", {"item-without-place.yaml:4:", "at", "nothing", "file"}},
    {"large-power", {"large-power.yaml:7:", "power", "\"200\"", "<= 64"}},
    {"let-later", {"let-later.yaml:3:", "\"2*$mass\"", "stands before it"}},
    {"let-list", {"let-list.yaml:3:", "let", "list of 2", "names to numbers"}},
    {"let-name", {"let-name.yaml:3:", "9speed", "a letter, then letters"}},
    {"let-nested", {"let-nested.yaml:3:", "speed", "list of 2", "a number"}},
    {"let-sum", {"let-sum.yaml:6:", "\"$speed+1\"", "product or quotient"}},
    {"let-text", {"let-text.yaml:6:", "\"the $speed\"", "in quotes"}},
    {"let-unknown", {"let-unknown.yaml:6:", "\"$sped\"", "did you mean \"$speed\"?"}},
    {"let-unused", {"let-unused.yaml:3:", "mass", "not used"}},
    {"let-word", {"let-word.yaml:3:", "speed", "\"fast\"", "a number"}},
    {"let-zero", {"let-zero.yaml:6:", "\"1/$speed\"", "finite"}},
    {"list", {"list.yaml:1:", "list of 1", "mapping"}},
    {"list-needs-cutoff", {"list-needs-cutoff.yaml:11:", "kernel", "neighbour-list", "never ends"}},
    {"many-pieces", {"many-pieces.yaml:7:", "pair_law", "list of 5", "at most 4"}},
    {"many-terms", {"many-terms.yaml:9:", "terms", "list of 5", "1 to 4"}},
    {"missing-file", {"missing-file.yaml:4:", "file", "bad/no-such-file.csv", "No such file"}},
    {"misspelt-column", {"misspelt-column.csv:1:", "\"coupilng\"", "did you mean \"coupling\"?"}},
    {"misspelt-key", {"misspelt-key.yaml:6:", "\"pair_lw\"", "did you mean \"pair_law\"?"}},
    {"misspelt-nested", {"misspelt-nested.yaml:10:", "\"stepp\"", "did you mean \"step\"?"}},
    {"misspelt-part", {"misspelt-part.yaml:10:", "part", "\"slwo\"", "did you mean \"slow\"?"}},
    {"misspelt-word",
     {"misspelt-word.yaml:11:", "kernel", "\"neighbor-list\"", "did you mean \"neighbour-list\"?"}},
    {"nan-cell", {"nan-cell.csv:4:", "vx", "\"nan\"", "a number"}},
    {"nan-position", {"nan-position.yaml:5:", "at", "\".nan\"", "a number"}},
    {"nan-velocity", {"nan-velocity.yaml:5:", "velocity", "\"nan\"", "a number"}},
    {"negative-coupling", {"negative-coupling.yaml:5:", "coupling", "\"-1e-3\"", ">= 0"}},
    {"negative-mass", {"negative-mass.yaml:5:", "mass", "\"-2\"", "> 0"}},
    {"no-dimension", {"no-dimension.yaml:1:", "dimension", "nothing", ">= 2, <= 3"}},
    {"no-end", {"no-end.yaml:10:", "end", "nothing", "> 0"}},
    {"no-name", {"no-name.yaml:1:", "name", "nothing", "text"}},
    {"no-particles", {"no-particles.yaml:1:", "particles", "nothing", "at least one"}},
    {"no-power", {"no-power.yaml:7:", "power", "nothing", "> 0"}},
    {"no-rows", {"no-rows.csv:4:", "no rows"}},
    {"no-terms", {"no-terms.yaml:7:", "terms", "nothing"}},
    {"no-time", {"no-time.yaml:1:", "time", "nothing", "step and end"}},
    {"no-y-column", {"no-y-column.csv:1:", "\"y\""}},
    {"outside-high", {"outside-high.yaml:5:", "x", "5.5", "<= 5"}},
    {"outside-low", {"outside-low.yaml:5:", "y", "-5.25", ">= -5"}},
    {"outside-row", {"outside-row.csv:3:", "x", "-5.001", ">= -5"}},
    {"overflowing-coefficient", {"overflowing-coefficient.yaml:7:", "coefficient", "\"1e999\""}},
    {"particles-mapping", {"particles-mapping.yaml:3:", "particles", "mapping", "list"}},
    {"pinned-velocity", {"pinned-velocity.yaml:5:", "velocity", "1 along y", "pinned"}},
    {"pinned-word", {"pinned-word.yaml:5:", "pinned", "\"yes\"", "true | false"}},
    {"position-3d", {"position-3d.yaml:5:", "at", "list of 3", "2 numbers"}},
    {"ragged", {"ragged.csv:4:", "3 values", "expected 4"}},
    {"sample-below-step", {"sample-below-step.yaml:10:", "sample", "\"0.001\"", "steps of 0.01"}},
    {"sample-not-whole", {"sample-not-whole.yaml:10:", "sample", "\"0.015\"", "steps of 0.01"}},
    {"section-scalar", {"section-scalar.yaml:9:", "walls", "\"5\"", "mapping"}},
    {"syntax", {"syntax.yaml:3:", "valid YAML"}},
    {"too-many-cells", {"too-many-cells.csv:2:", "5 values", "expected 4"}},
    {"trailing-text", {"trailing-text.yaml:10:", "step", "\"0.01s\"", "> 0"}},
    {"tree-error-unused", {"tree-error-unused.yaml:12:", "tree_error", "not a tree"}},
    {"tree-without-law", {"tree-without-law.yaml:9:", "kernel", "tree", "no pair_law"}},
    {"two-documents", {"two-documents.yaml:12:", "second document"}},
    {"until-after-none", {"until-after-none.yaml:8:", "pair_law", "does not end"}},
    {"until-descends", {"until-descends.yaml:8:", "until", "\"1.5\"", "more than 2"}},
    {"until-twice-none", {"until-twice-none.yaml:8:", "pair_law", "does not end"}},
    {"velocity-length", {"velocity-length.yaml:5:", "velocity", "list of 1", "2 numbers"}},
    {"wall-rule", {"wall-rule.yaml:9:", "rule", "\"miror\"", "did you mean \"mirror\"?"}},
    {"walls-crossed", {"walls-crossed.yaml:9:", "x", "[5, -5]", "low < high"}},
    {"walls-equal", {"walls-equal.yaml:9:", "x", "[5, 5]", "low < high"}},
    {"walls-length", {"walls-length.yaml:9:", "x", "list of 1", "2 numbers"}},
    {"walls-rest", {"walls-rest.yaml:9:", "rest", "\"1e-6\"", "only rule: located"}},
    {"walls-word", {"walls-word.yaml:9:", "x", "\"non\"", "or none"}},
    {"walls-z", {"walls-z.yaml:9:", "z", "two dimensions"}},
    {"word-cell", {"word-cell.csv:3:", "y", "\"zero\"", "a number"}},
    {"z-column", {"z-column.csv:1:", "\"z\"", "2 dimensions"}},
    {"zero-inertia", {"zero-inertia.yaml:5:", "inertia", "\"0\"", "> 0"}},
    {"zero-mass-row", {"zero-mass-row.csv:3:", "m:", "\"0\"", "> 0"}},
    {"zero-power", {"zero-power.yaml:7:", "power", "\"0\"", "> 0"}},
    {"zero-step", {"zero-step.yaml:10:", "step", "\"0\"", "> 0"}},
};

enum { refusal_count = sizeof refusals / sizeof *refusals };

static void assert_refused(const char *path, const char *const *fragment, size_t count) {
    dl_scene *scene = NULL;
    dl_error error = {{0}};
    assert_int_equal(dl_scene_read(path, &scene, &error), DL_INPUT);
    assert_null(scene);
    assert_null(strchr(error.message, '\n'));
    for (size_t i = 0; i < count && fragment[i]; i++)
        if (!strstr(error.message, fragment[i]))
            fail_msg("%s: \"%s\" lacks \"%s\"", path, error.message, fragment[i]);
}

static void refuses_every_bad_file(void **state) {
    (void)state;
    for (size_t i = 0; i < refusal_count; i++) {
        char path[512];
        snprintf(path, sizeof path, DL_TESTS "/scenes/bad/%s.yaml", refusals[i].file);
        assert_refused(path, refusals[i].fragment, 4);
        assert_int_equal(dl_scene_read(path, &(dl_scene *){NULL}, NULL), DL_INPUT);
    }
}

static void every_bad_file_is_in_the_table(void **state) {
    (void)state;
    DIR *const folder = opendir(DL_TESTS "/scenes/bad");
    assert_non_null(folder);
    size_t found = 0;
    for (const struct dirent *entry; (entry = readdir(folder));) {
        const char *const suffix = strrchr(entry->d_name, '.');
        found += suffix && strcmp(suffix, ".yaml") == 0;
    }
    closedir(folder);
    assert_int_equal(found, refusal_count);
}

static void refuses_what_is_no_file(void **state) {
    (void)state;
    assert_refused(DL_TESTS "/scenes/bad", (const char *[]){"scenes/bad: "}, 1);
    assert_refused(DL_TESTS "/no-such.yaml", (const char *[]){"no-such.yaml: No such file"}, 1);
}

static void swirl_as_printed_names_its_coincident_rows(void **state) {
    (void)state;
    assert_refused(DL_STUDIES "/swirl/swirl-as-printed.yaml",
                   (const char *[]){"table1_as_printed.csv:116:", "(-5.008, 5.192)",
                                    "table1_as_printed.csv:81 ", "; lines 42 and 98 at (4.498, ",
                                    "; lines 68 and 99 at (-1.502, ",
                                    "; lines 69 and 103 at (0.498, 0.868), 0.004 apart",
                                    "; lines 63 and 143 at (3.502, "},
                   7);
}

/* --- files that must be read ------------------------------------------------------------------ */

static dl_scene *read_scene(const char *path) {
    dl_scene *scene;
    dl_error error = {{0}};
    if (dl_scene_read(path, &scene, &error))
        fail_msg("%s", error.message);
    return scene;
}

static void everything_is_read(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_TESTS "/scenes/good/everything-3d.yaml");
    assert_string_equal(s->name, "everything");
    assert_string_equal(s->source, "made for the tests");
    assert_non_null(strstr(s->file, "good/everything-3d.yaml"));
    assert_int_equal(strncmp(s->text, "# Every key", 11), 0);
    assert_int_equal(s->dimension, 3);
    assert_int_equal(s->particles, 4);
    const double position[] = {0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 2, 3};
    const double velocity[] = {1, 0, 0.5, 0, 2, 0, -0.5, 0, 3, 0, 0, 0};
    const double inertia[] = {4, 5, 2, 3}, coupling[] = {4, 6, 2, 0};
    assert_memory_equal(s->position, position, sizeof position);
    assert_memory_equal(s->velocity, velocity, sizeof velocity);
    assert_memory_equal(s->inertia, inertia, sizeof inertia);
    assert_memory_equal(s->coupling, coupling, sizeof coupling);
    const bool pinned[] = {false, true, false, false}, gravity[] = {true, false, true, false};
    assert_memory_equal(s->pinned, pinned, sizeof pinned);
    assert_memory_equal(s->feels_gravity, gravity, sizeof gravity);
    dl_scene_free(s);
}

static void everything_acts(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_TESTS "/scenes/good/everything-3d.yaml");
    assert_int_equal(s->law.pieces, 2);
    assert_true(s->law.piece[0].until == 0.5 && s->law.piece[0].terms == 2);
    assert_true(s->law.piece[0].term[0].coefficient == 1.5 && s->law.piece[0].term[0].power == 2.5);
    assert_true(s->law.piece[0].term[1].coefficient == -1 && s->law.piece[0].term[1].power == 1);
    assert_true(s->law.piece[1].until == 4 && s->law.piece[1].terms == 1);
    assert_true(s->gravity[0] == 0 && s->gravity[1] == 0 && s->gravity[2] == 2);
    assert_true(s->walls.present);
    assert_true(s->walls.low[0] == -INFINITY && s->walls.high[0] == 10);
    assert_true(s->walls.low[1] == -INFINITY && s->walls.high[1] == INFINITY);
    assert_true(s->walls.low[2] == -1 && s->walls.high[2] == INFINITY);
    assert_true(s->walls.damping == 0.25 && s->walls.zero_vx_below == 1e-10);
    assert_int_equal(s->walls.rule, DL_MIRROR);
    assert_true(s->step == 0.001 && s->end == 0.3 && s->sample == 0.003);
    assert_int_equal(s->kernel, DL_KERNEL_NEIGHBOUR_LIST);
    assert_true(s->skin == 0.125);
    dl_scene_free(s);
}

static void what_a_scene_lacks_is_absent(void **state) {
    (void)state;
    static const char *const paths[] = {DL_TESTS "/scenes/good/least.yaml",
                                        DL_TESTS "/scenes/good/nothing-acts.yaml"};
    for (size_t i = 0; i < 2; i++) {
        dl_scene *const s = read_scene(paths[i]);
        assert_int_equal(s->law.pieces, 0);
        assert_false(s->walls.present);
        assert_true(s->gravity[0] == 0 && s->gravity[1] == 0 && s->gravity[2] == 0);
        assert_true(s->inertia[0] == 3 && s->coupling[0] == 3);
        assert_true(s->velocity[0] == 0 && s->velocity[1] == 0);
        assert_true(s->sample == 0 && s->skin == 0);
        assert_int_equal(s->kernel, DL_KERNEL_AUTO);
        assert_string_equal(s->source, "");
        dl_scene_free(s);
    }
}

/* --- the scenes of the studies ---------------------------------------------------------------- */

static double kinetic_energy(const dl_scene *s) {
    double sum = 0;
    for (size_t k = 0; k < (size_t)s->dimension * s->particles; k++)
        sum += 0.5 * s->inertia[k % s->particles] * s->velocity[k] * s->velocity[k];
    return sum;
}

static double total_mass(const dl_scene *s) {
    double sum = 0;
    for (size_t i = 0; i < s->particles; i++)
        sum += s->inertia[i];
    return sum;
}

/* TR323: average kinetic energy 20.467, and 40 40 40 40 39 40 particles in layers of 0.2 (one or
 * two evaporated). */
static void settled_fluid_is_the_published_one(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/drop/settled.yaml");
    assert_int_equal(s->particles, 278);
    assert_near(kinetic_energy(s) / 278, 20.4671, 1e-3);
    const int published[6] = {40, 40, 40, 40, 39, 40};
    int layer[16] = {0};
    for (size_t i = 0; i < 278; i++)
        layer[(int)(s->position[278 + i] / 0.2)]++;
    for (int i = 0; i < 6; i++)
        assert_int_equal(layer[i], published[i]);
    dl_scene_free(s);
}

static void drop_is_the_settled_fluid_and_one_more(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/drop/drop.yaml");
    dl_scene *const settled = read_scene(DL_STUDIES "/drop/settled.yaml");
    assert_int_equal(s->particles, 279);
    for (size_t axis = 0; axis < 2; axis++) {
        assert_memory_equal(s->position + 279 * axis, settled->position + 278 * axis,
                            278 * sizeof(double));
        assert_memory_equal(s->velocity + 279 * axis, settled->velocity + 278 * axis,
                            278 * sizeof(double));
    }
    assert_true(s->position[278] == 5 && s->position[279 + 278] == 1.7);
    assert_true(s->inertia[278] == 10 && s->coupling[278] == 10 && s->inertia[277] == 1);
    assert_true(s->gravity[1] == -980 && s->walls.high[0] == 10 && s->walls.damping == 0.9);
    assert_int_equal(dl_whole_steps(s->end, s->step), 823);
    dl_scene_free(settled);
    dl_scene_free(s);
}

/* TR299: the program's total mass; the lattice of spacing 1 leaves no two particles close. */
static void swirl_has_the_published_mass(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/swirl/swirl.yaml");
    const size_t n = s->particles;
    assert_int_equal(n, 239);
    assert_true(total_mass(s) == 618000);
    assert_int_equal(s->law.pieces, 2);
    double nearest = INFINITY;
    for (size_t i = 0; i < n; i++)
        for (size_t j = 0; j < i; j++)
            nearest = fmin(nearest, hypot(s->position[i] - s->position[j],
                                          s->position[n + i] - s->position[n + j]));
    assert_near(nearest, 1, 0.05);
    dl_scene_free(s);
}

/* TR171: six neighbours of each centre at 1.5^(1/3), where the pair force vanishes; the largest
 * perturbation of the velocity is 1 % of V. */
static void stream_is_hexagons_at_equilibrium(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/stream/stream.yaml");
    assert_int_equal(s->particles, 34);
    const double radius = cbrt(1.5);
    for (size_t centre = 12; centre < 22; centre++) {
        int neighbours = 0;
        for (size_t j = 0; j < 34; j++) {
            const double r = hypot(s->position[j] - s->position[centre],
                                   s->position[34 + j] - s->position[34 + centre]);
            assert_true(j == centre || r > radius - 1e-14);
            neighbours += fabs(r - radius) < 1e-14;
        }
        assert_int_equal(neighbours, 6);
    }
    const dl_term *const term = s->law.piece[0].term;
    assert_near(term[0].coefficient * pow(radius, -term[0].power) +
                    term[1].coefficient * pow(radius, -term[1].power),
                0, 1e-15);
    double largest = 0;
    for (size_t i = 0; i < 34; i++)
        largest = fmax(largest, fmax(fabs(s->velocity[i] - 50), fabs(s->velocity[34 + i])));
    assert_near(largest, 0.5, 1e-12);
    dl_scene_free(s);
}

static void quickstart_is_the_stream(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/quickstart/scene.yaml");
    dl_scene *const stream = read_scene(DL_STUDIES "/stream/stream.yaml");
    assert_int_equal(s->particles, 34);
    assert_memory_equal(s->position, stream->position, 68 * sizeof(double));
    assert_memory_equal(s->velocity, stream->velocity, 68 * sizeof(double));
    dl_scene_free(stream);
    dl_scene_free(s);
}

/* Energy -G M mu / (2 a), angular momentum mu sqrt(G M a (1 - e^2)), centre of mass at rest. */
static void kepler_is_an_ellipse_of_eccentricity_0_6(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_STUDIES "/kepler/kepler.yaml");
    assert_int_equal(s->particles, 2);
    const double m0 = s->inertia[0], m1 = s->inertia[1], reduced = m0 * m1 / (m0 + m1);
    const double x = s->position[1] - s->position[0], y = s->position[3] - s->position[2];
    const double vx = s->velocity[1] - s->velocity[0], vy = s->velocity[3] - s->velocity[2];
    const double energy = kinetic_energy(s) - m0 * m1 / hypot(x, y);
    assert_near(m0 + m1, 1, 1e-15);
    assert_near(energy, -reduced / 2, 1e-15);
    assert_near(reduced * (x * vy - y * vx), reduced * sqrt(1 - 0.36), 1e-15);
    assert_near(m0 * s->velocity[2] + m1 * s->velocity[3], 0, 1e-16);
    assert_near(m0 * s->position[0] + m1 * s->position[1], 0, 1e-16);
    const double period = 2 * acos(-1.0), periods = s->end / period;
    assert_near(periods, nearbyint(periods), 1e-14);
    assert_true(dl_whole_steps(s->end, s->step) > 0);
    dl_scene_free(s);
}

/* --- steps, restart --------------------------------------------------------------------------- */

static void whole_steps(void **state) {
    (void)state;
    assert_int_equal(dl_whole_steps(1, 0.1), 10);
    assert_int_equal(dl_whole_steps(0.3, 0.1), 3);
    assert_int_equal(dl_whole_steps(0.0823, 1e-4), 823);
    assert_int_equal(dl_whole_steps(1e6, 1e-4), 10000000000);
    assert_int_equal(dl_whole_steps(1 + 1e-10, 1), 1);
    assert_int_equal(dl_whole_steps(1 + 1e-8, 1), 0);
    assert_int_equal(dl_whole_steps(0.05, 0.1), 0);
    assert_int_equal(dl_whole_steps(1, 0.3), 0);
    assert_int_equal(dl_whole_steps(0, 0.1), 0);
    assert_int_equal(dl_whole_steps(-1, 0.1), 0);
    assert_int_equal(dl_whole_steps(1, 0), 0);
    assert_int_equal(dl_whole_steps(NAN, 0.1), 0);
    assert_int_equal(dl_whole_steps(DBL_MAX, 0.1), 0);
}

static void restart_moves_all_but_the_pinned(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_TESTS "/scenes/good/everything-3d.yaml");
    double y_all[24];
    for (int i = 0; i < 24; i++)
        y_all[i] = 100 + i;
    dl_scene *copy;
    assert_int_equal(dl_scene_restart(s, y_all, &copy, NULL), DL_OK);
    for (size_t k = 0; k < 12; k++) {
        const bool pinned = k % 4 == 1;
        assert_true(copy->position[k] == (pinned ? s->position[k] : y_all[k]));
        assert_true(copy->velocity[k] == (pinned ? 0 : y_all[12 + k]));
    }
    assert_memory_equal(copy->inertia, s->inertia, 4 * sizeof(double));
    assert_memory_equal(copy->pinned, s->pinned, 4 * sizeof(bool));
    assert_memory_equal(&copy->law, &s->law, sizeof s->law);
    assert_true(copy->end == s->end && copy->step == s->step);
    dl_scene_free(s); /* the copy stands alone */
    assert_string_equal(copy->name, "everything");
    dl_scene_free(copy);
}

static void restart_refuses_what_is_not_finite(void **state) {
    (void)state;
    dl_scene *const s = read_scene(DL_TESTS "/scenes/good/everything-3d.yaml");
    double y_all[24] = {0};
    y_all[12 + 6] = NAN; /* vy of the third particle */
    dl_scene *copy;
    dl_error error;
    assert_int_equal(dl_scene_restart(s, y_all, &copy, &error), DL_INPUT);
    assert_null(copy);
    assert_non_null(strstr(error.message, "particle 3"));
    dl_scene_free(s);
}

/* --- help, and files that are cut off --------------------------------------------------------- */

enum { help_room = 32768 };

/* What dl_scene_help prints; the caller frees it. */
static char *help_text(void) {
    char *const text = calloc(1, help_room);
    FILE *const stream = tmpfile();
    assert_true(text && stream);
    dl_scene_help(stream);
    rewind(stream);
    assert_in_range(fread(text, 1, help_room - 1, stream), 1000, help_room - 2);
    fclose(stream);
    return text;
}

static void help_names_every_key(void **state) {
    (void)state;
    static const dl_scene_section *const sections[] = {
        &dl_section_scene, &dl_section_particle, &dl_section_columns, &dl_section_piece,
        &dl_section_term,  &dl_section_walls,    &dl_section_time,    &dl_section_radiation};
    char *const text = help_text();
    for (size_t i = 0; i < sizeof sections / sizeof *sections; i++) {
        const char *const section = strstr(text, sections[i]->title);
        assert_non_null(section);
        for (size_t row = 0; row < sections[i]->table.count; row++) {
            assert_non_null(strstr(section, sections[i]->table.rows[row].name));
            assert_non_null(strstr(section, sections[i]->table.rows[row].doc));
        }
        for (size_t key = 0; sections[i]->key[key].name; key++)
            assert_non_null(strstr(section, sections[i]->key[key].doc));
    }
    free(text);
}

static void write_file(const char *path, const char *text, size_t length) {
    FILE *const stream = fopen(path, "w");
    assert_non_null(stream);
    assert_int_equal(fwrite(text, 1, length, stream), length);
    assert_int_equal(fclose(stream), 0);
}

static void example_of_help_is_a_scene(void **state) {
    (void)state;
    char folder[] = "/tmp/driftlab-scene-XXXXXX", path[64], data[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/example.yaml", folder);
    snprintf(data, sizeof data, "%s/settled.csv", folder);
    char *const text = help_text();
    const char *const example = strstr(text, "example\n");
    assert_non_null(example);
    write_file(path, example + strlen("example\n"), strlen(example) - strlen("example\n"));
    write_file(data, "x,y\n1,1\n", 8);
    dl_scene *const scene = read_scene(path);
    assert_int_equal(scene->particles, 2);
    dl_scene_free(scene);
    free(text);
    unlink(path);
    unlink(data);
    rmdir(folder);
}

/* A file cut off at any byte is read or refused with a message: it never crashes or leaks. */
static void truncated_files_are_refused_cleanly(void **state) {
    (void)state;
    dl_scene *const whole = read_scene(DL_TESTS "/scenes/good/everything-3d.yaml");
    char path[] = "/tmp/driftlab-cut-XXXXXX";
    const int descriptor = mkstemp(path);
    assert_true(descriptor >= 0);
    close(descriptor);
    for (size_t length = 0; length < strlen(whole->text); length++) {
        write_file(path, whole->text, length);
        dl_scene *scene = NULL;
        dl_error error = {{0}};
        const dl_status status = dl_scene_read(path, &scene, &error);
        assert_true(status == DL_INPUT && !scene && error.message[0]);
    }
    unlink(path);
    dl_scene_free(whole);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(refuses_every_bad_file),
        cmocka_unit_test(every_bad_file_is_in_the_table),
        cmocka_unit_test(refuses_what_is_no_file),
        cmocka_unit_test(swirl_as_printed_names_its_coincident_rows),
        cmocka_unit_test(everything_is_read),
        cmocka_unit_test(everything_acts),
        cmocka_unit_test(what_a_scene_lacks_is_absent),
        cmocka_unit_test(settled_fluid_is_the_published_one),
        cmocka_unit_test(drop_is_the_settled_fluid_and_one_more),
        cmocka_unit_test(swirl_has_the_published_mass),
        cmocka_unit_test(stream_is_hexagons_at_equilibrium),
        cmocka_unit_test(quickstart_is_the_stream),
        cmocka_unit_test(kepler_is_an_ellipse_of_eccentricity_0_6),
        cmocka_unit_test(whole_steps),
        cmocka_unit_test(restart_moves_all_but_the_pinned),
        cmocka_unit_test(restart_refuses_what_is_not_finite),
        cmocka_unit_test(help_names_every_key),
        cmocka_unit_test(example_of_help_is_a_scene),
        cmocka_unit_test(truncated_files_are_refused_cleanly),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
