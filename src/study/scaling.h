/* What the kind `scaling` is made of: the bulk of a body, as one number a quantity that does not
 * grow with the number of particles the body is divided into. */
#ifndef DL_STUDY_SCALING_H
#define DL_STUDY_SCALING_H

#include "driftlab/observe.h"
#include "driftlab/scaling.h"
#include "study/kind.h"

typedef struct dl_scaling_settings {
    double from;  /* part of the run after whose end means are taken */
    long bins;    /* of the profile */
    double agree; /* relative difference of what agrees; `tolerance` is many methods' */
} dl_scaling_settings;

enum { DL_MOST_PROFILE_BINS = 32, DL_MOST_BULK = 12 + DL_MOST_PROFILE_BINS };

/* What is told of a body, from the scene's initial state on. */
typedef struct dl_bulk {
    const dl_scene *scene;
    dl_model *model;
    size_t quantities, bins;
    char name[DL_MOST_BULK][DL_SCALED_NAME]; /* "NAME [UNIT]" */
    double extent[3];                        /* of the body at the start */
    double separation;                       /* at the start */
    bool travels; /* the mass centre's speed is not small against the particles' own */
} dl_bulk;

/* Extents are those of the uniform body with the same second moments, root(12) times the standard
 * deviation. DL_INPUT where particles do not move or are fewer than two. */
dl_status dl_bulk_create(const dl_scene *scene, size_t bins, dl_bulk *bulk, dl_error *error);
void dl_bulk_free(dl_bulk *bulk);

/* value [bulk->quantities]; `pair_energy` of the whole. *pairs: those that a force
 * evaluation looks at, which are all, or those of a neighbour list with its margin. */
dl_status dl_bulk_observe(const dl_bulk *bulk, const double *y_all, double pair_energy,
                          double *value, double *pairs, dl_error *error);

/* --- names that the comparison reads again ---------------------------------------------------- */

#define DL_SCALING_PARTICLES "particles"
#define DL_SCALING_TOLERANCE "tolerance"
#define DL_SCALING_STEP      "step [of the scene's]"
#define DL_SCALING_MEASURED  "measured"

/* The costs whose exponents are fitted: of these quantities of a finding. */
extern const char *const dl_scaling_costs[DL_SCALED_COSTS];

/* Whether a quantity of a finding ("NAME [UNIT]", `length` long) is one of the bulk. */
bool dl_scaling_is_bulk(const char *name, size_t length);

#endif
