/* What the methods of SUNDIALS' ARKODE share: a stepper of one of its kinds, at a fixed or an
 * adaptive step.
 *
 * Two habits of ARKODE are worked around (seen in 6.4.1). A step that ends at the stop time is
 * returned interpolated: with the linear interpolant that is the step's own value. And a table
 * whose last stage lies at the end of the step is taken for first-same-as-last even where it is
 * not, which costs it its order: a step postprocessor, even an empty one, makes ARKODE evaluate the
 * right-hand side anew. */
#ifndef DL_METHODS_ARKODE_H
#define DL_METHODS_ARKODE_H

#include "methods/implicit.h"
#include "methods/registry.h"

/* At the beginning of every kind's options, so that offsets in it are theirs. */
typedef struct dl_arkode_options {
    double step, rtol, atol;
} dl_arkode_options;

typedef struct dl_arkode {
    dl_implicit implicit; /* first: it is what callbacks get */
    const dl_arkode_calls *calls;
    void *memory;
    double *work;            /* [2 unknowns]: where ARKODE writes, also when it fails */
    N_Vector y, state;       /* over work and over method->y */
    bool stale;              /* ARKODE's state is not method->y */
    double fixed_step;       /* that ARKODE has been told; 0: none */
    void *inner;             /* the kind's own */
    unsigned long discarded; /* steps that ARKODE has counted and that were taken again */
} dl_arkode;

/* A kind of stepper: a row's variant. */
typedef struct dl_arkode_kind {
    const dl_arkode_calls *calls;
    bool splits; /* the force, in its fast and its slow part */
    /* Creates the stepper's memory; NULL: out of memory. */
    void *(*create)(dl_method *method);
    /* Sets what is the kind's own, the table first. DL_INPUT for options that do not go together.
     */
    dl_status (*set_up)(dl_method *method, dl_error *error);
    /* Tells the kind's own that method->step is another than before; NULL: it has nothing to do
     * with steps. An ARKODE flag. */
    int (*change_step)(const dl_method *method);
    /* After a step of its own choice that has ended at t: the same step again, of another length,
     * so that it ends at t_stop where it was meant to. An ARKODE flag. NULL: steps end there. */
    int (*land)(const dl_method *method, double t_stop, double *t);
    void (*destroy)(dl_arkode *data); /* of `inner`; NULL: there is none */
} dl_arkode_kind;

extern const dl_method_ops dl_arkode_ops;

/* Status and message of a flag that is not ARK_SUCCESS. */
dl_status dl_arkode_fail(const dl_arkode *data, int flag, const char *function, dl_error *error);

/* Has the right-hand side evaluated anew after each step, where ARKODE would take the last stage of
 * the table for the next step's first although it is not (NULL: no table). */
int dl_arkode_mend_last_stage(dl_arkode *data, ARKodeButcherTable explicit_part,
                              ARKodeButcherTable implicit_part);

/* DL_INPUT where the step is to be chosen (step 0) by a table that has no error estimate. */
dl_status dl_arkode_check_estimate(const dl_method *method, ARKodeButcherTable table,
                                   dl_error *error);

/* Order and stages of a table, which is freed; false for NULL. */
bool dl_arkode_describe(ARKodeButcherTable table, dl_method_table *found);

/* One call for a step of the length method->step from method->t, method->y on, or of ARKODE's own
 * choice up to t_stop. */
int dl_arkode_evolve(const dl_method *method, double t_stop, double *t);

/* y' = (v, a(q)) of the whole force is dl_sundials_rhs; of its parts (v, a_fast) and (0, a_slow).
 */
int dl_arkode_rhs_fast(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data);
int dl_arkode_rhs_slow(sunrealtype t, N_Vector y, N_Vector ydot, void *user_data);

/* --- options -----------------------------------------------------------------------------------
 */

#define DL_OPTION_TABLE(type, table_words, text, doc_)                                             \
    {                                                                                              \
        .name = "table", .kind = DL_WORD, .offset = offsetof(type, table), .unit = "",             \
        .words = (table_words), .fallback = text, .doc = doc_ "; the last number is the order"     \
    }

#endif
