/* The model of include/driftlab/model.h in extended precision: every number of the scene is taken
 * as the double it is, everything computed from them is computed here. */
#ifndef DL_REFERENCE_MODEL_H
#define DL_REFERENCE_MODEL_H

#include "driftlab/scene.h"
#include "reference/extended/law.h"

/* Particles that move come first. Blocks x|y|[z]: coordinate u = axis * moving + particle. */
typedef struct model {
    const dl_scene *scene;
    size_t dimension, particles, moving, unknowns;
    size_t *order; /* [particles]: row in the scene */
    real *inertia; /* [moving] */
    real *gravity; /* [unknowns] */
    real *pinned;  /* [dimension * (particles - moving)]: places */
    size_t species;
    law *law; /* [species * species], or one */
    bool is_periodic;
    real period[3]; /* 0 along an axis without one */
} model;

/* A pair that has a law, i < moving, i < j. */
typedef struct pair {
    size_t i, j;
    const law *law;
    real coupling;
    int piece;    /* of the law; law->pieces: out of reach */
    int image[3]; /* whole periods that are subtracted from r_i - r_j */
} pair;

typedef struct pairs {
    size_t count, active;
    pair *pair;         /* [count] */
    size_t *active_one; /* [active]: those within reach */
} pairs;

#define model_create       DL_TYPED(dl_extended_model_create)
#define model_free         DL_TYPED(dl_extended_model_free)
#define model_state        DL_TYPED(dl_extended_model_state)
#define model_acceleration DL_TYPED(dl_extended_model_acceleration)
#define model_load         DL_TYPED(dl_extended_model_load)
#define pairs_create       DL_TYPED(dl_extended_pairs_create)
#define pairs_free         DL_TYPED(dl_extended_pairs_free)
#define pairs_assign       DL_TYPED(dl_extended_pairs_assign)
#define pairs_find_active  DL_TYPED(dl_extended_pairs_find_active)

dl_status model_create(const dl_scene *scene, model *made, dl_error *error);
void model_free(model *made);

/* The scene's initial state, q and v [unknowns]. */
void model_state(const model *of, real *q, real *v);

/* Coordinate of any particle. */
static inline real model_place(const model *of, const real *q, size_t particle, size_t axis) {
    return particle < of->moving
               ? q[axis * of->moving + particle]
               : of->pinned[axis * (of->particles - of->moving) + particle - of->moving];
}

/* r_i - r_j of the pair's image along an axis. */
static inline real pair_separation(const model *of, const pair *p, const real *q, size_t axis) {
    const real d = model_place(of, q, p->i, axis) - model_place(of, q, p->j, axis);
    return of->is_periodic ? d - p->image[axis] * of->period[axis] : d;
}

/* a [unknowns] of all particles, each pair by the piece it is in. */
void model_acceleration(const model *of, const pairs *all, const real *q, real *a);
/* The same sums of the moduli of their terms: what roundoff is measured by. */
void model_load(const model *of, const pairs *all, const real *q, real *load);

dl_status pairs_create(const model *of, pairs *all, dl_error *error);
void pairs_free(pairs *all);

/* The nearest image and the piece of every pair, from their distances alone. */
void pairs_assign(const model *of, pairs *all, const real *q);
/* Collects those within reach; to be called when a piece has changed. */
void pairs_find_active(pairs *all);

#endif
