#include "study/passage.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "model/private.h"

/* A step may cut the corner of a collision that it resolves badly; ten times the energy is beyond
 * that. */
const double dl_passage_factor = 10;

struct dl_passage {
    dl_model *model;
    double slack;                          /* by which a wall may be missed: roundoff */
    unsigned long step;                    /* of the last sample */
    double *place, *move, *before, *speed; /* [dimension * particles], order of the model: positions
                                            * of the last sample, how far from there, velocities
                                            * then and now */
    /* while pairs are walked over */
    size_t first, second; /* the pair that went through; equal: none did */
    double nearest;
};

dl_status dl_passage_create(const dl_scene *scene, dl_passage **passage, dl_error *error) {
    *passage = NULL;
    dl_passage *const created = calloc(1, sizeof *created);
    if (!created)
        return dl_fail_memory(error, "a watch over passages");
    const dl_status status = dl_model_create(scene, &created->model, error);
    const size_t size = (size_t)scene->dimension * scene->particles;
    double *const room = status ? NULL : calloc(4 * size, sizeof *room);
    for (size_t k = 0; k < size; k++)
        created->slack = fmax(created->slack, 1e-9 * fabs(scene->position[k]));
    if (!room) {
        dl_passage_free(created);
        return status ? status : dl_fail_memory(error, "a watch over passages");
    }
    created->place = room;
    created->move = room + size;
    created->before = room + 2 * size;
    created->speed = room + 3 * size;
    *passage = created;
    return DL_OK;
}

void dl_passage_free(dl_passage *passage) {
    if (!passage)
        return;
    dl_model_free(passage->model);
    free(passage->place);
    free(passage);
}

/* --- walls ------------------------------------------------------------------------------------ */

/* Row of the first moving particle outside; `particles` where none is. */
static size_t first_outside(const dl_passage *p, const double *y_all) {
    const dl_scene *const scene = p->model->scene;
    const size_t n = scene->particles;
    for (size_t i = 0; i < n; i++)
        for (size_t axis = 0; axis < (size_t)scene->dimension && !scene->pinned[i]; axis++) {
            const double x = y_all[axis * n + i];
            if (x < scene->walls.low[axis] - p->slack || x > scene->walls.high[axis] + p->slack)
                return i;
        }
    return n;
}

/* --- pairs ------------------------------------------------------------------------------------ */

/* Square of the relative velocity of a pair. */
static double relative_square(const dl_passage *p, const double *velocity, size_t i, size_t j) {
    const size_t n = p->model->particles;
    double square = 0;
    for (size_t k = 0; k < (size_t)p->model->dimension * n; k += n) {
        const double v = velocity[k + i] - velocity[k + j];
        square += v * v;
    }
    return square;
}

static double reduced_mass(const dl_model *model, size_t i, size_t j) {
    const double *const inertia = model->priv->inertia;
    return j < model->moving ? inertia[i] * inertia[j] / (inertia[i] + inertia[j]) : inertia[i];
}

/* Square of the smallest separation on the way, where it is less than at both ends; NAN elsewhere.
 */
static double nearest_square(const dl_model *model, const dl_pair *pair) {
    double towards = 0, length = 0, square = 0;
    for (int c = 0; c < model->dimension; c++) {
        towards -= pair->d[c] * pair->change[c];
        length += pair->change[c] * pair->change[c];
    }
    const double part = towards / length;
    if (!(part > 0 && part < 1))
        return NAN;
    for (int c = 0; c < model->dimension; c++) {
        const double d = pair->d[c] + part * pair->change[c];
        square += d * d;
    }
    return square;
}

static void judge_pair(const dl_model *model, const dl_pair *pair, void *context) {
    dl_passage *const p = context;
    const double s = nearest_square(model, pair);
    if (isnan(s) || p->first != p->second)
        return;
    const double there = pair->coupling * dl_law_potential(pair->law, s);
    const double v0 = pair->coupling * dl_law_potential(pair->law, pair->s);
    const double v1 = pair->coupling * dl_law_potential(pair->law, pair->s1);
    const double square = fmax(relative_square(p, p->before, pair->i, pair->j),
                               relative_square(p, p->speed, pair->i, pair->j));
    const double kinetic = reduced_mass(model, pair->i, pair->j) * square / 2;
    /* s is 0 where one flies through the middle of the other: V is then infinite, or not a number
     */
    if (!(there <= dl_passage_factor * (kinetic + fmax(fabs(v0), fabs(v1))))) {
        p->first = pair->i;
        p->second = pair->j;
        p->nearest = sqrt(s);
    }
}

/* The state of a sample in the order of the model; false where it is not finite. */
static bool take_state(dl_passage *p, const double *y_all) {
    const dl_model *const model = p->model;
    const size_t n = model->particles, dimension = (size_t)model->dimension;
    bool finite = true;
    memcpy(p->before, p->speed, dimension * n * sizeof *p->speed);
    for (size_t c = 0; c < dimension; c++)
        for (size_t k = 0; k < n; k++) {
            const size_t from = c * n + model->priv->order[k], to = c * n + k;
            p->move[to] = y_all[from] - p->place[to];
            p->speed[to] = y_all[dimension * n + from];
            finite &= fabs(y_all[from]) < 1e100 && fabs(p->speed[to]) < 1e100;
        }
    return finite;
}

static void keep_places(dl_passage *p, const double *y_all) {
    const size_t n = p->model->particles;
    for (size_t c = 0; c < (size_t)p->model->dimension; c++)
        for (size_t k = 0; k < n; k++)
            p->place[c * n + k] = y_all[c * n + p->model->priv->order[k]];
}

dl_status dl_passage_look(dl_passage *passage, const dl_sample *sample, char *where, size_t size,
                          dl_error *error) {
    dl_model *const model = passage->model;
    const dl_scene *const scene = model->scene;
    const bool next_step = sample->index > 0 && sample->step == passage->step + 1;
    const bool finite = take_state(passage, sample->y_all);
    dl_status status = DL_OK;
    passage->first = passage->second = 0;
    if (next_step && finite && model->kernel)
        status =
            dl_model_visit_pairs(model, passage->place, passage->move, judge_pair, passage, error);
    const size_t outside =
        model->has_walls ? first_outside(passage, sample->y_all) : scene->particles;
    where[0] = '\0';
    if (outside < scene->particles)
        snprintf(where, size, "particle %zu is outside the walls", outside + 1);
    else if (passage->first != passage->second)
        snprintf(where, size, "particles %zu and %zu passed each other at a distance of %.3g",
                 model->priv->order[passage->first] + 1, model->priv->order[passage->second] + 1,
                 passage->nearest);
    keep_places(passage, sample->y_all);
    passage->step = sample->step;
    return status;
}
