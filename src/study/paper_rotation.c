/* How fast the system turns that is left where particles have escaped: far from their common mass
 * centre, what is left does not turn about it. */
#include <math.h>
#include <stdlib.h>

#include "driftlab/observe.h"
#include "study/paper_quantity.h"

dl_status dl_paper_rotation(const dl_scene *scene, const double *y_all, double *rate,
                            dl_error *error) {
    const size_t n = scene->particles;
    dl_scene system = *scene; /* the others as if pinned */
    dl_motion motion;
    size_t count = 0;
    if (scene->dimension != 2)
        return dl_fail(error, DL_INPUT, "found 3 dimensions, expected 2");
    system.pinned = calloc(n, sizeof *system.pinned);
    if (!system.pinned)
        return dl_fail_memory(error, "groups of particles");
    const dl_status status =
        dl_observe_system(scene, y_all, dl_escape_link(scene), system.pinned, error);
    for (size_t i = 0; i < n; i++) {
        count += system.pinned[i];
        system.pinned[i] = !system.pinned[i];
    }
    if (!status)
        dl_observe_motion(&system, y_all, &motion);
    free(system.pinned);
    if (status)
        return status;
    *rate = motion.rigid_rotation;
    return count > 1 ? DL_OK : dl_fail(error, DL_INPUT, "a single particle does not turn");
}
