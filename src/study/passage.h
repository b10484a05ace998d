/* Did particles go where they cannot? Watched from step to step.
 *
 * A particle outside the scene's walls has gone through one. A pair has gone through another's core
 * where the straight line of its separation from one step to the next passes so near 0 that the
 * potential V there is more than `dl_passage_factor` times the energy the pair had for it:
 *
 *     V(nearest) > factor (max K_rel + max |V|),   K_rel = mu |v_i - v_j|^2 / 2,
 *
 * the largest of both ends of the step, mu the reduced mass (the inertia, where one is pinned).
 * A step that resolves a collision passes no such place; one that jumps over it does, whatever it
 * does to the energy. */
#ifndef DL_STUDY_PASSAGE_H
#define DL_STUDY_PASSAGE_H

#include "driftlab/run.h"

extern const double dl_passage_factor;

typedef struct dl_passage dl_passage;

dl_status dl_passage_create(const dl_scene *scene, dl_passage **passage, dl_error *error);
void dl_passage_free(dl_passage *passage); /* NULL will do */

/* Looks at the next sample of a run, from index 0 on; pairs where it is one step after the last.
 * *where, of `size`, says what went where, "" where nothing did. */
dl_status dl_passage_look(dl_passage *passage, const dl_sample *sample, char *where, size_t size,
                          dl_error *error);

#endif
