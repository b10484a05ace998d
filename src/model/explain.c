/* What a model contains and what it leaves out, in words. */
#include "driftlab/explain.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include "driftlab/parameter.h"
#include "model/private.h"

static void line(FILE *out, const char *what, const char *text) {
    fprintf(out, "  %-10s %s\n", what, text);
}

static void explain_numbers(const dl_model *model, FILE *out) {
    const dl_scene *scene = model->scene;
    for (size_t i = 0; i < scene->lets; i++) {
        char text[80], value[40];
        dl_format_real(scene->let[i].value, value, sizeof value);
        snprintf(text, sizeof text, "%s = %s", scene->let[i].name, value);
        line(out, i ? "" : "let", text);
    }
}

static void explain_particles(const dl_model *model, FILE *out) {
    char text[160];
    size_t pinned = model->particles - model->moving;
    snprintf(text, sizeof text, "%zu in %d dimensions%s; unknowns: %zu positions, %zu velocities",
             model->particles, model->dimension, model->dimension == 2 ? ", no z" : "",
             model->unknowns, model->unknowns);
    line(out, "particles", text);
    if (model->scene->start)
        line(out, "start", model->scene->start);
    if (pinned > 0) {
        snprintf(text, sizeof text, "%zu pinned: parameters, not unknowns", pinned);
        line(out, "pins", text);
    }
    if (model->priv->inverse_inertia)
        line(out, "inertia", "differs from 1: forces are divided by it");
    if (model->priv->coupling)
        line(out, "coupling", "differs from 1: pair forces are multiplied by c_i c_j");
}

static void explain_sum(const dl_law *law, int k, int first, int terms, FILE *out) {
    char coefficient[40], power[40];
    for (int s = first; s < first + terms; s++) {
        dl_format_real(fabs(law->coefficient[k][s]), coefficient, sizeof coefficient);
        dl_format_real(law->power[k][s], power, sizeof power);
        const char *sign = law->coefficient[k][s] < 0 ? "-" : s > first ? "+" : "";
        if (law->power[k][s] == 0) /* what shifts the force */
            fprintf(out, " %s%s", sign, coefficient);
        else
            fprintf(out, " %s%s r^-%s", sign, coefficient, power);
    }
}

/* A taper's S falls from 1 to 0, force/law_taper.h. */
static void explain_blend(const dl_law *law, int k, FILE *out) {
    if (law->terms[k] > 0) {
        fprintf(out, " S (");
        explain_sum(law, k, 0, law->terms[k], out);
        fprintf(out, " )");
    }
    if (law->next_terms[k] == 0)
        return;
    fprintf(out, "%s (1 - S) (", law->terms[k] > 0 ? " +" : "");
    explain_sum(law, k, law->terms[k], law->next_terms[k], out);
    fprintf(out, " )");
}

static void explain_piece(const dl_law *law, int k, const char *label, FILE *out) {
    static const char *const ends[] = {
        [DL_END_HARD] = "hard",
        [DL_END_SHIFTED_FORCE] = "shifted force",
        [DL_END_TAPER] = "taper",
    };
    char from[40], until[40];
    dl_format_real(k ? law->until[k - 1] : 0, from, sizeof from);
    dl_format_real(law->until[k], until, sizeof until);
    fprintf(out, "  %-10s F(r) =", label);
    if (law->width[k] > 0)
        explain_blend(law, k, out);
    else
        explain_sum(law, k, 0, law->terms[k], out);
    if (law->end[k] == DL_END_TAPER && law->width[k] == 0)
        fprintf(out, "   for %s < r <= %s, then its taper\n", from, until);
    else if (isfinite(law->until[k]))
        fprintf(out, "   for %s < r <= %s, end: %s%s\n", from, until, ends[law->end[k]],
                law->located[k] ? ", located" : "");
    else
        fprintf(out, "   for r > %s\n", from);
}

static void explain_law(const dl_law *law, const char *label, FILE *out) {
    for (int k = 0; k < law->pieces; k++) {
        if (law->terms[k] + law->next_terms[k] == 0)
            continue; /* of a part of the force: nothing acts there */
        explain_piece(law, k, label, out);
        label = "";
    }
}

/* One law a pair of species, each under their names. */
static void explain_species(const dl_model *model, FILE *out) {
    const dl_scene *scene = model->scene;
    char text[200];
    for (size_t a = 0; a < scene->species; a++) {
        size_t count = 0;
        for (size_t i = 0; i < scene->particles; i++)
            count += scene->species_of[i] == (int)a;
        snprintf(text, sizeof text, "%.60s: %zu particles", scene->species_name[a], count);
        line(out, a ? "" : "species", text);
    }
    for (size_t a = 0; a < scene->species; a++)
        for (size_t b = a; b < scene->species; b++) {
            const dl_law *law = &model->priv->law[a * scene->species + b];
            snprintf(text, sizeof text, "%.60s with %.60s%s", scene->species_name[a],
                     scene->species_name[b], law->pieces ? "" : ": no force");
            line(out, "pairs", text);
            explain_law(law, "pair law", out);
        }
}

/* The name of the loops, where all laws have the same. */
static const char *loops_name(const dl_model *model) {
    const dl_pair_problem *p = &model->priv->problem;
    const char *name = NULL;
    for (size_t k = 0; k < p->species * p->species; k++) {
        if (p->law[k].pieces == 0)
            continue;
        if (name && strcmp(name, model->kernel->loops[k]->name) != 0)
            return "one for each law";
        name = model->kernel->loops[k]->name;
    }
    return name;
}

static void explain_kernel(const dl_model *model, FILE *out) {
    char text[200];
    if (!model->kernel)
        return;
    snprintf(text, sizeof text, "%s, because %s", model->kernel->ops->name, model->kernel->reason);
    line(out, "kernel", text);
    snprintf(text, sizeof text, "%s, instructions: %s", loops_name(model),
             model->kernel->vector->name);
    line(out, "pair loop", text);
}

/* What a kernel that is not exact states, and what it does at the initial state. */
static void explain_force_error(dl_model *model, FILE *out) {
    dl_kernel *const kernel = model->kernel;
    if (!kernel || kernel->stated_error == 0)
        return;
    dl_force_error measured;
    dl_error error = {""};
    char text[DL_MESSAGE_SIZE + 40];
    double *const y = malloc((2 * model->unknowns + 1) * sizeof *y);
    if (!y)
        return;
    dl_model_initial_state(model, y);
    kernel->near_pairs = kernel->far_pairs = 0;
    if (dl_model_force_error(model, y, &measured, &error)) {
        snprintf(text, sizeof text, "stated: %g; not measured: %s", kernel->stated_error,
                 error.message);
        line(out, "error", text);
    } else {
        snprintf(text, sizeof text,
                 "of a force, in parts of the moduli of its pairs: stated %g; measured %.1e at "
                 "most, %.1e in the mean of %zu",
                 measured.stated, measured.largest, measured.mean, measured.sampled);
        line(out, "error", text);
        snprintf(text, sizeof text, "%.4g pairs of particles and %.3g of cells for each particle",
                 (double)kernel->near_pairs / (double)model->particles,
                 (double)kernel->far_pairs / (double)model->particles);
        line(out, "", text);
    }
    free(y);
}

static void explain_crossings(const dl_model *model, FILE *out) {
    if (model->locates_crossings)
        line(out, "crossings",
             "located: a step ends where a pair passes a breakpoint, the method starts anew");
}

static void explain_pairs(dl_model *model, FILE *out) {
    if (model->scene->species > 0)
        explain_species(model, out);
    else
        explain_law(model->priv->law, "pair law", out);
    explain_kernel(model, out);
    explain_force_error(model, out);
}

/* What is in one part of the force. */
static void explain_part(const dl_model *part, const char *label, FILE *out) {
    const dl_scene *scene = part->scene;
    char text[200];
    if (scene->species == 0)
        explain_law(part->priv->law, label, out);
    for (size_t k = 0; k < scene->species * scene->species; k++) {
        const dl_law *law = &part->priv->law[k];
        const size_t a = k / scene->species, b = k % scene->species;
        if (a > b || law->pieces == 0)
            continue;
        snprintf(text, sizeof text, "%.60s with %.60s", scene->species_name[a],
                 scene->species_name[b]);
        line(out, label, text);
        explain_law(law, "", out);
        label = "";
    }
    if (part->has_gravity)
        line(out, part->kernel ? "" : label, "gravity");
    explain_kernel(part, out);
}

/* Where methods that split the force have something to split. */
static void explain_parts(dl_model *model, FILE *out) {
    if (dl_model_split(model, NULL))
        return;
    explain_part(dl_model_part(model, DL_PART_FAST), "fast part", out);
    explain_part(dl_model_part(model, DL_PART_SLOW), "slow part", out);
}

static void explain_gravity(const dl_model *model, FILE *out) {
    if (!model->has_gravity)
        return;
    char text[200], g[3][40];
    for (int c = 0; c < 3; c++)
        dl_format_real(model->scene->gravity[c], g[c], sizeof g[c]);
    snprintf(text, sizeof text, "(%s, %s%s%s)%s", g[0], g[1], model->dimension == 3 ? ", " : "",
             model->dimension == 3 ? g[2] : "",
             model->priv->gravity_mask ? ", on the particles that feel it" : "");
    line(out, "gravity", text);
}

static void explain_periods(const dl_model *model, FILE *out) {
    bool first = true;
    for (int c = 0; model->has_periods && c < model->dimension; c++) {
        const dl_periods *periods = &model->scene->periods;
        if (periods->length[c] == 0)
            continue;
        char low[40], length[40], text[200];
        dl_format_real(periods->low[c], low, sizeof low);
        dl_format_real(periods->length[c], length, sizeof length);
        snprintf(text, sizeof text, "%c by %s from %s; separations to the nearest copy", "xyz"[c],
                 length, low);
        line(out, first ? "periods" : "", text);
        first = false;
    }
}

static void explain_wall_limits(const dl_walls *walls, FILE *out) {
    char value[40], text[200];
    if (walls->rule == DL_LOCATED && walls->damping > 0) {
        dl_format_real(walls->rest, value, sizeof value);
        snprintf(text, sizeof text, "a bounce shorter than %s of the time step is the last", value);
        line(out, "", text);
    }
    if (walls->zero_vx_below > 0) {
        dl_format_real(walls->zero_vx_below, value, sizeof value);
        snprintf(text, sizeof text, "after a hit |vx| below %s becomes 0", value);
        line(out, "", text);
    }
}

static void explain_walls(const dl_model *model, FILE *out) {
    if (!model->has_walls)
        return;
    const dl_walls *walls = &model->scene->walls;
    for (int c = 0; c < model->dimension; c++) {
        char low[40] = "none", high[40] = "none", text[200];
        if (isfinite(walls->low[c]))
            dl_format_real(walls->low[c], low, sizeof low);
        if (isfinite(walls->high[c]))
            dl_format_real(walls->high[c], high, sizeof high);
        snprintf(text, sizeof text, "%c from %s to %s", "xyz"[c], low, high);
        line(out, c ? "" : "walls", text);
    }
    char damping[40], text[200];
    dl_format_real(walls->damping, damping, sizeof damping);
    const char *rule =
        walls->rule == DL_LOCATED ? "located hits and resting contacts" : "mirror after a step";
    snprintf(text, sizeof text, "%s; velocity times 1 - %s, booked in the ledger", rule, damping);
    line(out, "", text);
    explain_wall_limits(walls, out);
}

/* Who is on it. */
static void explain_boundary(const dl_radiation *radiation, FILE *out) {
    char opening[40], reach[40], text[200];
    dl_format_real(radiation->opening, opening, sizeof opening);
    dl_format_real(radiation->reach, reach, sizeof reach);
    snprintf(text, sizeof text, "that no other hides, outward within %s degrees and %s%s", opening,
             isfinite(radiation->reach) ? "a distance of " : "however far",
             isfinite(radiation->reach) ? reach : "");
    line(out, "", text);
}

static void explain_radiation(const dl_model *model, FILE *out) {
    if (!model->has_radiation)
        return;
    const dl_radiation *radiation = &model->scene->radiation;
    char period[40], beyond[40], above[40], below[40], text[200];
    dl_format_real(radiation->period, period, sizeof period);
    dl_format_real(radiation->beyond, beyond, sizeof beyond);
    dl_format_real(radiation->factor_above, above, sizeof above);
    dl_format_real(radiation->factor_below, below, sizeof below);
    snprintf(text, sizeof text, "every %s, particles %s%s, booked in the ledger", period,
             radiation->boundary ? "on the boundary" : "farther from the mass centre than ",
             radiation->boundary ? "" : beyond);
    line(out, "radiation", text);
    if (radiation->boundary)
        explain_boundary(radiation, out);
    snprintf(text, sizeof text, "velocity%s times %s above the centre, %s below it",
             radiation->frame == DL_FRAME_CENTRE ? " relative to the centre's" : "", above, below);
    line(out, "", text);
}

static int most_pieces(const dl_model *model) {
    const dl_pair_problem *p = &model->priv->problem;
    int most = 0;
    for (size_t k = 0; k < p->species * p->species; k++)
        most = p->law[k].pieces > most ? p->law[k].pieces : most;
    return most;
}

static const char *const left_out_names[] = {
    [DL_OUT_PAIRS] = "pair forces",
    [DL_OUT_Z] = "z components",
    [DL_OUT_REAL_POWERS] = "real powers (all whole)",
    [DL_OUT_SWITCHES] = "switches of the pair law",
    [DL_OUT_CUTOFF] = "cutoff",
    [DL_OUT_CROSSINGS] = "location of crossings",
    [DL_OUT_SPECIES] = "laws by species",
    [DL_OUT_COUPLINGS] = "couplings (all 1)",
    [DL_OUT_INERTIA] = "division by inertia (all 1)",
    [DL_OUT_GRAVITY] = "gravity",
    [DL_OUT_GRAVITY_MASK] = "gravity mask (all feel it)",
    [DL_OUT_WALLS] = "walls and their test after each step",
    [DL_OUT_PERIODS] = "periods",
    [DL_OUT_RADIATION] = "radiation",
    [DL_OUT_PINS] = "pinned particles",
    [DL_OUT_SLOW_PART] = "a slow part of the force",
};

const char *dl_left_out_name(dl_left_out what) {
    return left_out_names[what];
}

static bool all_whole(const dl_model *model) {
    const dl_pair_problem *p = &model->priv->problem;
    bool whole = true;
    for (size_t k = 0; k < p->species * p->species; k++)
        whole &= p->law[k].integer;
    return whole;
}

bool dl_leaves_out(const dl_model *model, dl_left_out what) {
    const struct dl_model_private *priv = model->priv;
    const bool pairs = model->kernel;
    const bool absent[] = {
        [DL_OUT_PAIRS] = !pairs,
        [DL_OUT_Z] = model->dimension == 2,
        [DL_OUT_REAL_POWERS] = pairs && all_whole(model),
        [DL_OUT_SWITCHES] = pairs && most_pieces(model) == 1,
        [DL_OUT_CUTOFF] = pairs && isinf(priv->problem.reach),
        [DL_OUT_CROSSINGS] = pairs && !model->locates_crossings,
        [DL_OUT_SPECIES] = pairs && !priv->species_of,
        [DL_OUT_COUPLINGS] = pairs && !priv->coupling,
        [DL_OUT_INERTIA] = !priv->inverse_inertia,
        [DL_OUT_GRAVITY] = !model->has_gravity,
        [DL_OUT_GRAVITY_MASK] = model->has_gravity && !priv->gravity_mask,
        [DL_OUT_WALLS] = !model->has_walls,
        [DL_OUT_PERIODS] = !model->has_periods,
        [DL_OUT_RADIATION] = !model->has_radiation,
        [DL_OUT_PINS] = !model->has_pins,
        [DL_OUT_SLOW_PART] = !priv->part[DL_PART_SLOW],
    };
    return absent[what];
}

static void explain_absent(const dl_model *model, FILE *out) {
    const char *separator = "";
    fprintf(out, "  %-10s ", "left out");
    for (int k = 0; k < DL_LEFT_OUTS; k++)
        if (dl_leaves_out(model, (dl_left_out)k)) {
            fprintf(out, "%s%s", separator, left_out_names[k]);
            separator = ", ";
        }
    fprintf(out, "%s\n", *separator ? "" : "nothing");
}

static void explain_conserved(const dl_model *model, FILE *out) {
    char text[200];
    const bool jumps = model->has_walls || model->has_radiation;
    snprintf(text, sizeof text, "energy%s%s%s", jumps ? " with the jumps' ledger" : "",
             dl_model_conserves_linear_momentum(model)
                 ? model->has_gravity || jumps ? ", linear momentum with the known impulses"
                                               : ", linear momentum"
                 : "",
             !dl_model_conserves_angular_momentum(model) ? ""
             : jumps ? ", angular momentum with the jumps' impulses"
                     : ", angular momentum");
    line(out, "conserved", text);
    if (dl_model_is_galilean_invariant(model))
        line(out, "frame",
             "Galilean-invariant: energies are measured against the motion about the "
             "centre of mass");
}

static void explain_time(const dl_model *model, FILE *out) {
    char text[200], step[40], end[40];
    dl_format_real(model->scene->step, step, sizeof step);
    dl_format_real(model->scene->end, end, sizeof end);
    snprintf(text, sizeof text, "to %s, fixed-step methods by %s: %zu steps", end, step,
             dl_whole_steps(model->scene->end, model->scene->step));
    line(out, "time", text);
}

void dl_explain(dl_model *model, FILE *out) {
    fprintf(out, "%s", model->scene->name);
    if (model->scene->source && *model->scene->source)
        fprintf(out, " (%s)", model->scene->source);
    fprintf(out, "\n");
    explain_numbers(model, out);
    explain_particles(model, out);
    explain_pairs(model, out);
    explain_crossings(model, out);
    explain_gravity(model, out);
    explain_parts(model, out);
    explain_walls(model, out);
    explain_periods(model, out);
    explain_radiation(model, out);
    explain_time(model, out);
    explain_conserved(model, out);
    explain_absent(model, out);
}
