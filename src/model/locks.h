/* Locked pairs: pairs that are near a breakpoint of their law and go by the pieces on one side of
 * it wherever they are, until an event says that they have crossed it (study/crossings.h). A step
 * during which a pair crosses is then as smooth as any other.
 *
 * The kernel knows nothing of them. It adds up what distances say; what locks change is added
 * afterwards, F_locked - F, for the few pairs that are beyond their breakpoint. */
#ifndef DL_MODEL_LOCKS_H
#define DL_MODEL_LOCKS_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include "driftlab/model.h"
#include "force/law.h"

typedef struct dl_lock {
    size_t i, j; /* in the order of the model; i < j, i moves */
    const dl_law *law;
    dl_law_range range;
    double above, below; /* squares of distances between which the lock changes nothing, however
                          * they are rounded */
    bool keeps_copy;     /* in a periodic box: of the pair's copies, `copy` is the one meant */
    double copy[3];      /* to be taken off x_i - x_j */
} dl_lock;

typedef struct dl_locks {
    dl_lock *lock;
    size_t count;
    unsigned long generation; /* > 0, another one whenever other pairs are locked */
} dl_locks;

/* Sets range, and what follows from it: from the breakpoint below piece `piece` whose crossings are
 * located, if any, to the first such above. */
void dl_lock_to(dl_lock *lock, const dl_law *law, int piece);

/* Squared distance at which the range ends, below and above; 0 and INFINITY where it does not. */
static inline double dl_lock_low(const dl_lock *lock) {
    return lock->range.first > 0 ? lock->law->until2[lock->range.first - 1] : 0;
}
static inline double dl_lock_high(const dl_lock *lock) {
    return lock->range.last < lock->law->pieces ? lock->law->until2[lock->range.last] : INFINITY;
}

/* a(q) += what model->locks change; the discrete acceleration over the step from q to q + delta. */
void dl_locks_add_acceleration(dl_model *model, const double *q, double *a);
void dl_locks_add_discrete(dl_model *model, const double *q, const double *delta, double *a);

#endif
