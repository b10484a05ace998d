/* The inside of a model. */
#ifndef DL_MODEL_PRIVATE_H
#define DL_MODEL_PRIVATE_H

#include "driftlab/model.h"
#include "force/kernel.h"
#include "force/law.h"
#include "model/locks.h"

struct dl_model_private {
    dl_model *whole;         /* that this is a part of; NULL: of none */
    dl_part which;           /* part of it */
    dl_model *part[2];       /* NULL before dl_model_split, part.c */
    dl_law *law;             /* [species * species], or one */
    int *species_of;         /* [particles]; NULL: one law */
    dl_box box;              /* where the scene is periodic */
    dl_pair_problem problem; /* what the kernel and the walks over pairs go by */
    size_t *order;    /* [particles]: row in the scene of particle k here; moving ones first */
    double *coupling; /* [particles + pad], zeros behind; NULL: all 1 */
    double *inertia;  /* [moving] */
    double *inverse_inertia; /* [moving]; NULL: all 1 */
    double *gravity_mask;    /* [moving]: 1 or 0; NULL: all feel gravity */
    double *place;           /* [dimension * particles]: pinned ones filled in; NULL: no pins */
    double *shift;           /* the same for displacements, 0 for pinned ones; NULL: no pins */
    double *pair_force; /* [dimension * particles]; NULL: no pins, forces go to the caller's a */
    /* scratch of dl_model_energy_change; NULL until it is asked for */
    double *jump;       /* [unknowns] */
    double *jump_force; /* [dimension * particles] */
    const dl_vector_ops *vector;
    /* Jacobian's pattern, jacobian.c */
    bool has_pattern; /* sparsity is that of rows */
    dl_sparsity sparsity;
    long *column_start, *row;
    size_t row_capacity;
    unsigned long rows_generation;
    dl_pair_rows rows;
    unsigned long locks_generation; /* 0: nothing was locked */
    double *middle; /* [2 * unknowns]: scratch of the means taken at the middle, discrete.c */
    struct dl_product *product;      /* NULL before it is first prepared, product.c */
    struct dl_jump_pairs *crossings; /* NULL: there are none, crossings.c */
};

/* Where work is counted. */
static inline dl_counts *dl_model_book(dl_model *model) {
    return &(model->priv->whole ? model->priv->whole : model)->counts;
}

/* --- part.c -------------------------------------------------------------------------------------
 */

/* Those terms of the law that belong to the part; pieces that end without any are left out. */
dl_pair_law dl_pair_law_part(const dl_pair_law *law, dl_part part);
dl_status dl_model_accelerate_part(dl_model *model, dl_part part, const double *q, double *a,
                                   dl_error *error);
void dl_model_free_parts(dl_model *model);
/* model.c: dl_model_create for a part of `whole`; whole NULL: for all of the scene. */
dl_status dl_model_create_part(const dl_scene *scene, dl_model *whole, dl_part which,
                               dl_model **model, dl_error *error);

/* The positions of all particles: q itself where nothing is pinned. */
const double *dl_model_places(dl_model *model, const double *q);
/* Displacements of all particles: delta itself where nothing is pinned. */
const double *dl_model_shifts(dl_model *model, const double *delta);

/* --- model.c: the accelerations themselves, neither counted nor held -----------------------------
 */

dl_status dl_model_accelerate(dl_model *model, const double *q, double *a, dl_error *error);
dl_status dl_model_accelerate_quotient(dl_model *model, const double *q, const double *delta,
                                       double *a, dl_error *error);
/* a_i = f_i / inertia_i + g, f over all particles; a and f may be the same. */
dl_status dl_model_finish(dl_model *model, const double *q, const double *f, double *a,
                          dl_error *error);

/* --- parts that a model may have ----------------------------------------------------------------
 */

void dl_product_free(struct dl_product *product);
void dl_jump_pairs_free(struct dl_jump_pairs *crossings);
/* For the model's mean, crossings.c. */
dl_status dl_model_crossings_prepare(dl_model *model, dl_error *error);

/* --- pairs.c ------------------------------------------------------------------------------------
 */

/* Walks over the candidate pairs that act at x (and x + delta). */
typedef struct dl_pair {
    size_t i, j;
    const dl_law *law;
    dl_law_range range;       /* of its pieces: all, where the pair is not locked */
    double coupling;          /* coupling_i coupling_j */
    double d[3], s;           /* separation r_i - r_j and its square */
    double change[3], s1, ds; /* with a delta: change of d, square at the end, s1 - s */
} dl_pair;

typedef void dl_pair_visitor(const dl_model *model, const dl_pair *pair, void *context);

/* The pair in the middle of its step. */
dl_pair dl_pair_middle(const dl_model *model, const dl_pair *pair);

/* Calls `visit` for every pair i < moving, i < j among the kernel's rows. x, delta over all
 * particles; delta may be NULL. In a periodic box separations are those of the nearest copies, and
 * with delta a pair whose nearest copy changes on the way is visited twice: for the copy nearest at
 * the start and for that nearest at the end (force/kernel_reference.c says why). */
dl_status dl_model_visit_pairs(dl_model *model, const double *x, const double *delta,
                               dl_pair_visitor *visit, void *context, dl_error *error);

/* The same for one pair. */
void dl_model_visit_pair(const dl_model *model, const double *x, const double *delta, size_t i,
                         size_t j, dl_pair_visitor *visit, void *context);

/* A locked pair as the lock means it, at x; and whether there, or over its step, the lock changes
 * nothing. */
dl_pair dl_model_locked_pair(const dl_model *model, const dl_lock *lock, const double *x,
                             const double *delta);
bool dl_model_lock_agrees(const dl_model *model, const dl_lock *lock, const double *x);
bool dl_model_lock_agrees_over_step(const dl_model *model, const dl_lock *lock,
                                    const dl_pair *pair);

/* Calls `visit` for the pair as it is locked, with delta for each copy that may act. */
void dl_model_visit_lock(const dl_model *model, const dl_lock *lock, const double *x,
                         const double *delta, dl_pair_visitor *visit, void *context);

/* What locks change in a sum over pairs: for each that does, `visit` is called for the pair as
 * dl_model_visit_pairs has it, with its coupling's sign turned, and for the pair as it is locked.
 */
void dl_model_visit_locks(const dl_model *model, const double *x, const double *delta,
                          dl_pair_visitor *visit, void *context);
/* --- crossings.c: where the force jumps ----------------------------------------------------------
 */

/* Whether the pair's distance at the start, in the middle and at the end lie on different sides of
 * a jump; of models that have any (priv->crossings). */
bool dl_model_passes_jump(const dl_model *model, const dl_pair *pair);
/* As dl_model_visit_pairs, for such pairs alone. */
dl_status dl_model_visit_passing(dl_model *model, const double *q, const double *delta,
                                 dl_pair_visitor *visit, void *context, dl_error *error);

/* --- discrete.c: mean forces of one pair on its first particle -----------------------------------
 */

void dl_pair_quotient(const dl_model *model, const dl_pair *pair, double force[3]);
void dl_pair_gonzalez(const dl_model *model, const dl_pair *pair, double force[3]);

/* --- jacobian.c, discrete.c: derivatives of one pair ---------------------------------------------
 */

/* Force on the first particle, differentiated by its place; the pair's coupling is in it. */
typedef void dl_block_of(const dl_model *model, const dl_pair *pair, double block[3][3]);

dl_block_of dl_block_of_force, dl_block_of_half_force, dl_block_of_quotient, dl_block_of_average,
    dl_block_of_gonzalez;

/* What the model's mean takes its pairs' derivative from: the block, and where the pairs are
 * walked over: at places x with shifts delta, or with none (NULL). */
typedef struct dl_mean_walk {
    dl_block_of *block_of;
    const double *x, *delta; /* over all particles */
} dl_mean_walk;

dl_mean_walk dl_model_mean_walk(dl_model *model, const double *q, const double *delta);

/* out = u without the mass centre's part, where forces do not depend on its place: where nothing
 * is pinned or held. */
void dl_model_relative(const dl_model *model, const double *u, double *out);

/* The correction of DL_MEAN_GONZALEZ: a = a(middle) + c e, e the relative part of delta. Sets
 * middle_a and e [unknowns]; e may be priv->middle. */
dl_status dl_model_gonzalez(dl_model *model, const double *q, const double *delta, double *middle_a,
                            double *c, double *e, dl_error *error);

/* out += (B - B^T) delta of pairs that pass a jump, B the derivative of their mean by delta. */
dl_status dl_model_gonzalez_asymmetry(dl_model *model, const double *q, const double *delta,
                                      double *out, dl_error *error);

#endif
