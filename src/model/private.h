/* The inside of a model. */
#ifndef DL_MODEL_PRIVATE_H
#define DL_MODEL_PRIVATE_H

#include "driftlab/model.h"
#include "force/kernel.h"
#include "force/law.h"
#include "model/locks.h"

struct dl_model_private {
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
};

/* The positions of all particles: q itself where nothing is pinned. */
const double *dl_model_places(dl_model *model, const double *q);
/* Displacements of all particles: delta itself where nothing is pinned. */
const double *dl_model_shifts(dl_model *model, const double *delta);

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

/* Calls `visit` for every pair i < moving, i < j among the kernel's rows. x, delta over all
 * particles; delta may be NULL. In a periodic box separations are those of the nearest copies, and
 * with delta a pair whose nearest copy changes on the way is visited twice: for the copy nearest at
 * the start and for that nearest at the end (force/kernel_reference.c says why). */
dl_status dl_model_visit_pairs(dl_model *model, const double *x, const double *delta,
                               dl_pair_visitor *visit, void *context, dl_error *error);

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

#endif
