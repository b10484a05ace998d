/* The two flows that leap-frog and the splittings are made of, kicks and drifts, for as much of a
 * force as the scene has:
 *
 *     v += kick a,  q += drift v.
 *
 * Where nothing acts there is no kick, and where gravity alone does it is one number a component.
 */
#ifndef DL_METHODS_MOTION_H
#define DL_METHODS_MOTION_H

#include <stddef.h>
#include "driftlab/model.h"

/* a, q, v [n]; they must not overlap. */
void dl_kick_and_drift(size_t n, double kick, double drift, const double *restrict a,
                       double *restrict q, double *restrict v);

/* The same from the state y0 to the state y, [2 n] each, positions before velocities: what y0 holds
 * is not copied first. */
void dl_kick_and_drift_from(size_t n, double kick, double drift, const double *restrict a,
                            const double *restrict y0, double *restrict y);
void dl_drift_from(size_t n, double drift, const double *restrict y0, double *restrict y);

/* v += kick a */
void dl_kick(size_t n, double kick, const double *restrict a, double *restrict v);

/* q += drift v */
void dl_drift(size_t n, double drift, double *restrict q, const double *restrict v);

/* The same as dl_kick_and_drift, and to the same bits, for a model that is `uniform`. */
void dl_fall(const dl_model *model, double kick, double drift, double *restrict q,
             double *restrict v);

#endif
