/* What a model contains and what it leaves out, in words. */
#include "driftlab/explain.h"

#include <math.h>
#include <stdio.h>
#include "driftlab/parameter.h"
#include "model/private.h"

static void line(FILE *out, const char *what, const char *text) {
    fprintf(out, "  %-10s %s\n", what, text);
}

static void explain_particles(const dl_model *model, FILE *out) {
    char text[160];
    size_t pinned = model->particles - model->moving;
    snprintf(text, sizeof text, "%zu in %d dimensions%s; unknowns: %zu positions, %zu velocities",
             model->particles, model->dimension, model->dimension == 2 ? ", no z" : "",
             model->unknowns, model->unknowns);
    line(out, "particles", text);
    if (pinned > 0) {
        snprintf(text, sizeof text, "%zu pinned: parameters, not unknowns", pinned);
        line(out, "pins", text);
    }
    if (model->priv->inverse_inertia)
        line(out, "inertia", "differs from 1: forces are divided by it");
    if (model->priv->coupling)
        line(out, "coupling", "differs from 1: pair forces are multiplied by c_i c_j");
}

static void explain_piece(const dl_law *law, int k, FILE *out) {
    char from[40], until[40], coefficient[40], power[40];
    dl_format_real(k ? law->until[k - 1] : 0, from, sizeof from);
    dl_format_real(law->until[k], until, sizeof until);
    fprintf(out, "  %-10s F(r) =", k ? "" : "pair law");
    for (int s = 0; s < law->terms[k]; s++) {
        dl_format_real(fabs(law->coefficient[k][s]), coefficient, sizeof coefficient);
        dl_format_real(law->power[k][s], power, sizeof power);
        const char *sign = law->coefficient[k][s] < 0 ? "-" : s ? "+" : "";
        fprintf(out, " %s%s r^-%s", sign, coefficient, power);
    }
    if (isfinite(law->until[k]))
        fprintf(out, "   for %s < r <= %s\n", from, until);
    else
        fprintf(out, "   for r > %s\n", from);
}

static void explain_pairs(const dl_model *model, FILE *out) {
    const dl_law *law = &model->priv->law;
    char text[200];
    for (int k = 0; k < law->pieces; k++)
        explain_piece(law, k, out);
    if (!model->kernel)
        return;
    snprintf(text, sizeof text, "%s, because %s", model->kernel->ops->name, model->kernel->reason);
    line(out, "kernel", text);
    snprintf(text, sizeof text, "%s, instructions: %s", model->kernel->loops->name,
             model->kernel->vector->name);
    line(out, "pair loop", text);
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
    snprintf(text, sizeof text, "mirror after a step; velocity times 1 - %s, booked in the ledger",
             damping);
    line(out, "", text);
}

/* The things that are not there: not computed, not stored, not branched on. */
static void explain_absent(const dl_model *model, FILE *out) {
    const struct {
        bool absent;
        const char *what;
    } terms[] = {
        {!model->kernel, "pair forces"},
        {model->dimension == 2, "z components"},
        {model->kernel && model->priv->law.pieces == 1, "switches of the pair law"},
        {model->kernel && !model->priv->law.cut, "cutoff"},
        {model->kernel && !model->priv->coupling, "couplings (all 1)"},
        {!model->priv->inverse_inertia, "division by inertia (all 1)"},
        {!model->has_gravity, "gravity"},
        {model->has_gravity && !model->priv->gravity_mask, "gravity mask (all feel it)"},
        {!model->has_walls, "walls and their test after each step"},
        {!model->has_pins, "pinned particles"},
    };
    const char *separator = "";
    fprintf(out, "  %-10s ", "left out");
    for (size_t k = 0; k < sizeof terms / sizeof *terms; k++)
        if (terms[k].absent) {
            fprintf(out, "%s%s", separator, terms[k].what);
            separator = ", ";
        }
    fprintf(out, "%s\n", *separator ? "" : "nothing");
}

static void explain_conserved(const dl_model *model, FILE *out) {
    char text[200];
    snprintf(text, sizeof text, "energy%s%s%s", model->has_walls ? " with the walls' ledger" : "",
             dl_model_conserves_linear_momentum(model)
                 ? model->has_gravity || model->has_walls
                       ? ", linear momentum with the known impulses"
                       : ", linear momentum"
                 : "",
             !dl_model_conserves_angular_momentum(model) ? ""
             : model->has_walls ? ", angular momentum with the walls' impulses"
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

void dl_explain(const dl_model *model, FILE *out) {
    fprintf(out, "%s", model->scene->name);
    if (model->scene->source && *model->scene->source)
        fprintf(out, " (%s)", model->scene->source);
    fprintf(out, "\n");
    explain_particles(model, out);
    explain_pairs(model, out);
    explain_gravity(model, out);
    explain_walls(model, out);
    explain_time(model, out);
    explain_conserved(model, out);
    explain_absent(model, out);
}
