/* What a model leaves out, added with values that change nothing but its cost. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "driftlab/trajectory.h"
#include "study/leave_outs.h"

/* Lost in every sum of accelerations, and far above the numbers that processors are slow with. */
static const double no_gravity = 1e-200;
/* Distances in parts of the scene's: nearer than any pair comes, farther than any goes. */
static const double innermost = 1e-2, outermost = 1e6;
static const double steps_between_jumps = 100;

dl_status dl_scene_copy(const dl_scene *scene, dl_scene **copy, dl_error *error) {
    const size_t length = (size_t)scene->dimension * scene->particles;
    *copy = NULL;
    double *const y_all = malloc(2 * length * sizeof *y_all);
    if (!y_all)
        return dl_fail_memory(error, "a scene");
    memcpy(y_all, scene->position, length * sizeof *y_all);
    memcpy(y_all + length, scene->velocity, length * sizeof *y_all);
    const dl_status status = dl_scene_restart(scene, y_all, copy, error);
    free(y_all);
    return status;
}

/* --- laws ------------------------------------------------------------------------------------- */

static dl_pair_law *laws_of(dl_scene *scene, size_t *count) {
    *count = scene->species ? scene->species * scene->species : 1;
    return scene->species ? scene->species_law : &scene->law;
}

/* Of every pair, at the start; 1 where there is none. */
static double smallest_distance(const dl_scene *scene) {
    const size_t n = scene->particles;
    double smallest = INFINITY;
    for (size_t i = 0; i < n; i++)
        for (size_t j = i + 1; j < n; j++) {
            double s = 0;
            for (size_t c = 0; c < (size_t)scene->dimension; c++) {
                const double d = scene->position[c * n + i] - scene->position[c * n + j];
                s += d * d;
            }
            smallest = fmin(smallest, s);
        }
    return isfinite(smallest) ? sqrt(smallest) : 1;
}

static double largest_coordinate(const dl_scene *scene) {
    double largest = 1;
    for (size_t k = 0; k < (size_t)scene->dimension * scene->particles; k++)
        largest = fmax(largest, fabs(scene->position[k]));
    return largest;
}

/* The first piece twice: up to a distance that no pair comes to, and from there on. */
static void split_first_piece(dl_pair_law *law, double until) {
    if (law->pieces == 0 || law->pieces == DL_MAX_PIECES || law->piece[0].until <= until)
        return;
    memmove(&law->piece[1], &law->piece[0], (size_t)law->pieces * sizeof *law->piece);
    law->pieces++;
    dl_piece *const first = &law->piece[0];
    first->until = until;
    first->width = 0;
    first->located = false;
    if (first->end == DL_END_TAPER)
        first->end = DL_END_HARD; /* the formula goes on: no jump */
}

static dl_status add_switches(dl_scene *scene, dl_error *error) {
    size_t count;
    dl_pair_law *const law = laws_of(scene, &count);
    const double until = innermost * smallest_distance(scene);
    (void)error;
    for (size_t k = 0; k < count; k++)
        split_first_piece(&law[k], until);
    return DL_OK;
}

static dl_status add_crossings(dl_scene *scene, dl_error *error) {
    size_t count;
    dl_pair_law *const law = laws_of(scene, &count);
    const dl_status status = add_switches(scene, error);
    for (size_t k = 0; k < count; k++)
        if (law[k].pieces > 1 && law[k].piece[0].end != DL_END_TAPER)
            law[k].piece[0].located = true;
    return status;
}

static dl_status add_cutoff(dl_scene *scene, dl_error *error) {
    size_t count;
    dl_pair_law *const law = laws_of(scene, &count);
    (void)error;
    for (size_t k = 0; k < count; k++)
        if (law[k].pieces > 0 && isinf(law[k].piece[law[k].pieces - 1].until))
            law[k].piece[law[k].pieces - 1].until = outermost * largest_coordinate(scene);
    return DL_OK;
}

/* A force of strength 0, of every pair however far. */
static dl_status add_pairs(dl_scene *scene, dl_error *error) {
    size_t count;
    dl_pair_law *const law = laws_of(scene, &count);
    (void)error;
    for (size_t k = 0; k < count; k++)
        law[k] = (dl_pair_law){.pieces = 1,
                               .piece = {{.until = INFINITY, .terms = 1, .term = {{0, 2}}}}};
    return DL_OK;
}

static void free_species(dl_scene *scene) {
    for (size_t k = 0; k < scene->species; k++)
        free(scene->species_name[k]);
    free(scene->species_name);
    free(scene->species_law);
    free(scene->species_of);
}

/* Two species, by turns, whose pairs all have the one law. */
static dl_status add_species(dl_scene *scene, dl_error *error) {
    const dl_pair_law law = scene->species ? scene->species_law[0] : scene->law;
    free_species(scene);
    scene->species = 2;
    scene->law.pieces = 0;
    scene->species_law = malloc(4 * sizeof *scene->species_law);
    scene->species_of = malloc(scene->particles * sizeof *scene->species_of);
    scene->species_name = calloc(2, sizeof *scene->species_name);
    if (scene->species_name) {
        scene->species_name[0] = strdup("even");
        scene->species_name[1] = strdup("odd");
    }
    if (!scene->species_law || !scene->species_of || !scene->species_name ||
        !scene->species_name[0] || !scene->species_name[1])
        return dl_fail_memory(error, "species");
    for (size_t k = 0; k < 4; k++)
        scene->species_law[k] = law;
    for (size_t i = 0; i < scene->particles; i++)
        scene->species_of[i] = (int)(i % 2);
    return DL_OK;
}

/* --- particles -------------------------------------------------------------------------------- */

static bool lengthen(double **values, size_t from, size_t to) {
    double *const longer = realloc(*values, to * sizeof *longer);
    if (!longer)
        return false;
    memset(longer + from, 0, (to - from) * sizeof *longer);
    *values = longer;
    return true;
}

static dl_status add_z(dl_scene *scene, dl_error *error) {
    const size_t n = scene->particles;
    if (!lengthen(&scene->position, 2 * n, 3 * n) || !lengthen(&scene->velocity, 2 * n, 3 * n))
        return dl_fail_memory(error, "a third dimension");
    scene->dimension = 3;
    scene->gravity[2] = 0;
    scene->walls.low[2] = -INFINITY;
    scene->walls.high[2] = INFINITY;
    return DL_OK;
}

static dl_status add_gravity(dl_scene *scene, dl_error *error) {
    (void)error;
    for (int c = 0; c < scene->dimension; c++)
        scene->gravity[c] = -no_gravity;
    for (size_t i = 0; i < scene->particles; i++)
        scene->feels_gravity[i] = true;
    return DL_OK;
}

/* --- what surrounds them ---------------------------------------------------------------------- */

static dl_status add_walls(dl_scene *scene, dl_error *error) {
    (void)error;
    scene->walls = (dl_walls){.present = true, .rule = DL_MIRROR};
    for (int c = 0; c < 3; c++) {
        scene->walls.low[c] = -INFINITY;
        scene->walls.high[c] = INFINITY;
    }
    return DL_OK;
}

/* Along no axis. */
static dl_status add_periods(dl_scene *scene, dl_error *error) {
    (void)error;
    scene->periods = (dl_periods){.present = true};
    return DL_OK;
}

static dl_status add_radiation(dl_scene *scene, dl_error *error) {
    (void)error;
    scene->radiation = (dl_radiation){.present = true,
                                      .period = steps_between_jumps * scene->step,
                                      .factor_above = 1,
                                      .factor_below = 1,
                                      .frame = DL_FRAME_LAB};
    return DL_OK;
}

static dl_status (*const additions[DL_LEFT_OUTS])(dl_scene *scene, dl_error *error) = {
    [DL_OUT_PAIRS] = add_pairs,         [DL_OUT_Z] = add_z,
    [DL_OUT_SWITCHES] = add_switches,   [DL_OUT_CUTOFF] = add_cutoff,
    [DL_OUT_CROSSINGS] = add_crossings, [DL_OUT_SPECIES] = add_species,
    [DL_OUT_GRAVITY] = add_gravity,     [DL_OUT_WALLS] = add_walls,
    [DL_OUT_PERIODS] = add_periods,     [DL_OUT_RADIATION] = add_radiation,
};

/* What the model itself keeps when it is told to. */
static const unsigned kept[DL_LEFT_OUTS] = {
    [DL_OUT_REAL_POWERS] = DL_KEEP_REAL_POWERS,
    [DL_OUT_COUPLINGS] = DL_KEEP_COUPLING,
    [DL_OUT_INERTIA] = DL_KEEP_INERTIA,
    [DL_OUT_GRAVITY_MASK] = DL_KEEP_GRAVITY_MASK,
    [DL_OUT_PINS] = DL_KEEP_PINS,
};

bool dl_can_add(dl_left_out what) {
    return additions[what] || kept[what];
}

dl_status dl_scene_add_neutral(dl_scene *scene, dl_left_out what, dl_error *error) {
    scene->keep |= kept[what];
    return additions[what] ? additions[what](scene, error) : DL_OK;
}
