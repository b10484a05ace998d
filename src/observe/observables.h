/* The inside of an observation, for the measuring functions of the registry. */
#ifndef DL_OBSERVE_OBSERVABLES_H
#define DL_OBSERVE_OBSERVABLES_H

#include "driftlab/observe.h"

/* Particles of one mass. */
typedef struct dl_mass_class {
    double mass;
    double particles;
    dl_state_threshold threshold; /* set where the states are observed */
} dl_mass_class;

/* All that measuring one frame takes. */
typedef struct dl_measuring {
    const dl_scene *scene; /* what is observed: `whole`, or `view` */
    const dl_scene *whole;
    dl_scene view;  /* of the system alone: the others are as if pinned */
    bool *left_out; /* [particles]: what `view` pins; NULL: it is not in use */
    bool *system;   /* [particles]: of the frame; NULL likewise */
    bool *escaped;  /* [particles]: of the frame */
    dl_model *model;
    dl_observe_options options;
    dl_bins bins;
    size_t classes;
    dl_mass_class *mass_class; /* [classes], masses descending */
    size_t *class_of;          /* [particles]; not set for pinned ones */
    dl_thermometer *measured;  /* by options.temperature; NULL: not observed */
    dl_thermometer *state;     /* by the program's rule, for Table IV */
    double *work;              /* [4 * particles, or of bins] */
    const double *y_all;       /* of the frame */
} dl_measuring;

/* A width that gives at most 13 bins from the wall below, or the lowest, to the highest. */
double dl_bins_choose_width(const dl_scene *scene, double lowest, double highest);

/* One frame's values, out [rows][columns]. */
typedef dl_status dl_measure(dl_measuring *m, double *out, dl_error *error);

typedef struct dl_observable_entry {
    dl_observable row;
    dl_measure *measure;
    /* DL_INPUT, with why, where the scene has no such thing; NULL: every scene has. */
    dl_status (*applies)(dl_measuring *m, dl_error *error);
} dl_observable_entry;

const dl_observable_entry *dl_observable_entry_at(size_t index);

/* DL_INPUT where the scene has no groups that leave one another; `what` asks for them. */
dl_status dl_groups_apply(const dl_measuring *m, const char *what, dl_error *error);

#endif
