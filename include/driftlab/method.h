/* Methods: one registry, one row a method, one file a method family.
 *
 * A method owns its state and advances it by steps of its own. The time loop reads `t` and `y`,
 * may change `y` (a wall did) and then says so with dl_method_jumped. */
#ifndef DRIFTLAB_METHOD_H
#define DRIFTLAB_METHOD_H

#include <stdbool.h>
#include <stddef.h>
#include "driftlab/model.h"
#include "driftlab/parameter.h"
#include "driftlab/status.h"

enum {
    DL_SYMPLECTIC = 1 << 0,
    DL_TIME_SYMMETRIC = 1 << 1,
    DL_CONSERVES_ENERGY = 1 << 2,
    DL_CONSERVES_MOMENTUM = 1 << 3, /* linear and angular, to roundoff */
    DL_IMPLICIT = 1 << 4,
    DL_ADAPTIVE = 1 << 5,         /* can choose its own step */
    DL_FIXED_STEP = 1 << 6,       /* can keep a given step */
    DL_NEEDS_JACOBIAN = 1 << 7,   /* with the options' defaults */
    DL_RESTARTS_EXACTLY = 1 << 8, /* stop and restart from y gives the same bits as going on,
                                     with the options' defaults */
    DL_SPLITS_FORCE = 1 << 9,     /* needs a scene with a fast and a slow part (dl_model_split) */
};

typedef struct dl_method_stats {
    unsigned long steps;                /* accepted */
    unsigned long rejected;             /* attempts that were thrown away */
    unsigned long nonlinear_iterations; /* of implicit methods */
    unsigned long linear_iterations;    /* of Krylov solvers */
    unsigned long factorisations;       /* of direct ones */
    unsigned long inexact;              /* steps accepted at roundoff, above the tolerance */
    unsigned long rescued; /* steps that a second solver found where the first failed */
} dl_method_stats;

typedef struct dl_method dl_method;

typedef struct dl_method_ops {
    /* Sets method->data. The fields of `method` below are set. */
    dl_status (*create)(dl_method *method, dl_error *error);
    /* One accepted step of its own, from t to a time at or before t_stop; sets t and y to the
     * method's own values there (never interpolated). On failure t and y are as before. A
     * fixed-step method takes exactly one step, whatever t_stop, of length `step`: the time loop
     * may have changed that (dl_method_step_to). */
    dl_status (*advance)(dl_method *method, double t_stop, dl_error *error);
    /* Copies the state at t into y_out where `method->y` is not already it (leap-frog holds its
     * velocities half a step behind). NULL: y is the state. Changes nothing, counts nothing. */
    dl_status (*state)(dl_method *method, double *y_out, dl_error *error);
    /* y, or y and t, were changed from outside: forget what depends on the past. */
    dl_status (*jumped)(dl_method *method, dl_error *error);
    /* The method's own interpolant over its last step, a polynomial: its degree, and its k-th
     * derivative at a time within that step into y_out [2 n]. Until the next call of advance or
     * jumped, whatever is written to t and y. NULL: it has none as accurate as its steps. */
    int (*dense_degree)(const dl_method *method);
    dl_status (*dense)(dl_method *method, double t, int derivative, double *y_out, dl_error *error);
    /* The state at t in a frame in uniform motion that the method keeps it in, y_out [2 n], but for
     * that frame's place, and its velocity in the scene's frame; for scenes that look the same
     * there. Far from the scene's origin y has lost digits that this state has. NULL: none. */
    void (*own_frame)(const dl_method *method, double *y_out, double velocity[3]);
    /* What the method has chosen by itself, and why, in a few words; "" where nothing. NULL: the
     * same. */
    void (*describe)(const dl_method *method, char *text, size_t size);
    void (*stats)(const dl_method *method, dl_method_stats *stats);
    void (*destroy)(dl_method *method); /* frees data; data may be NULL or half built */
} dl_method_ops;

/* What one word of an option that chooses coefficients stands for. */
typedef struct dl_method_table {
    int order, stages;
} dl_method_table;

/* A row of the registry. */
typedef struct dl_method_row {
    const char *name;    /* "leapfrog", "composition-6-yoshida", "cvode-bdf" ... */
    const char *family;  /* "leap-frog", "composition", "Gauss", "ARKODE", "conserving" ... */
    const char *doc;     /* one line, with the source */
    int order;           /* of convergence at fixed step; 0 where it varies */
    int stages;          /* of a step; 0: `made_of` or `table` says it */
    const char *made_of; /* what a step consists of, where it is no number of stages that is always
                            the same: "multistep" ...; NULL elsewhere */
    /* Order and stages of the index-th of `words`, the words of one of the row's options; false
     * where they are no coefficients, or memory is out. NULL: the row has no such option. */
    bool (*table)(const char *const *words, size_t index, dl_method_table *found);
    int forces; /* accelerations a step takes, but for a first one; 0: they vary */
    unsigned flags;
    dl_parameter_table options;
    size_t options_size; /* of the structure the table describes; its objects are longer: only
                          * dl_method_options_create and _copy make them */
    const void *variant; /* the family's own: a coefficient table, a solver choice ... */
    const dl_method_ops *ops;
} dl_method_row;

struct dl_method {
    const dl_method_row *row;
    dl_model *model;
    void *options; /* of row->options_size bytes */
    size_t n;      /* unknowns: y holds 2 n */
    double step;   /* fixed step, or 0 where the method chooses; set by create */
    double t;
    double origin; /* of fixed steps: t is origin + since * step, without accumulated roundoff */
    unsigned long since;
    double *y; /* of its own: where it lies may change with a step */
    void *data;
};

size_t dl_method_count(void);
const dl_method_row *dl_method_row_at(size_t index);

/* The table of coefficients that a row goes by with its options' defaults: that of its first option
 * which chooses one. False where it has none. */
bool dl_method_default_table(const dl_method_row *row, dl_method_table *table);

/* Row of that name; DL_INPUT with the closest match where there is none. */
dl_status dl_method_find(const char *name, const dl_method_row **row, dl_error *error);

/* A fresh options structure with defaults; `step` and `end` come from the scene: an option named
 * "step" defaults to scene->step where the row's fallback is NULL. Free with
 * dl_method_options_free. */
dl_status dl_method_options_create(const dl_method_row *row, const dl_scene *scene, void **options,
                                   dl_error *error);
/* Sets option `key`; DL_INPUT names the closest option where the method has no such one. */
dl_status dl_method_options_set(const dl_method_row *row, void *options, const char *key,
                                const char *value, dl_error *error);
/* "step=0.01 order=4": every option that is used as the others are set, in table order. */
void dl_method_options_format(const dl_method_row *row, const void *options, char *text,
                              size_t size);
dl_status dl_method_options_copy(const dl_method_row *row, const void *options, void **copy,
                                 dl_error *error);
void dl_method_options_free(const dl_method_row *row, void *options);

/* `options` is copied; one that was set although it is not used as the others are set is refused
 * (dl_parameter.when). y0 [2 * unknowns]. */
dl_status dl_method_create(const dl_method_row *row, dl_model *model, const void *options,
                           const double *y0, dl_method **method, dl_error *error);
dl_status dl_method_advance(dl_method *method, double t_stop, dl_error *error);
/* Fixed-step methods: one step that ends at t, of another length than the method's own. */
dl_status dl_method_step_to(dl_method *method, double t, dl_error *error);
/* Afterwards: t is that of `steps` steps of the method's own from 0, and so are later ones. */
void dl_method_return_to_grid(dl_method *method, unsigned long steps);
dl_status dl_method_state(dl_method *method, double *y_out, dl_error *error);
dl_status dl_method_jumped(dl_method *method, dl_error *error);
void dl_method_describe(const dl_method *method, char *text, size_t size);
void dl_method_stats_get(const dl_method *method, dl_method_stats *stats);
void dl_method_destroy(dl_method *method);

#endif
