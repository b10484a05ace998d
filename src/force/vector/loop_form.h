/* What the loops over pairs share. */
#ifndef DL_FORCE_VECTOR_LOOP_FORM_H
#define DL_FORCE_VECTOR_LOOP_FORM_H

#include "force/vector/vector.h"

/* What a loop is compiled for: one for each combination, so that what a scene lacks is not
 * branched on. */
typedef struct loop_form {
    int dimension;
    bool coupled, periodic, discrete;
} loop_form;

/* What the loops read, as a local copy: they write to arrays that the compiler cannot tell from
 * where these pointers and lengths lie. */
typedef struct inputs {
    const double *x[3], *delta[3];
    dl_box box;
} inputs;

DL_INLINE inputs inputs_of(const dl_pair_arrays *p, loop_form form) {
    return (inputs){
        .x = {p->x[0], p->x[1], p->x[2]},
        .delta = {p->delta[0], p->delta[1], p->delta[2]},
        .box = form.periodic ? *p->box : (dl_box){{0}, {0}},
    };
}

/* Nearest whole number, by the digits that 1.5 * 2^52 leaves; numbers beyond 2^51 stay near. */
static const double whole_digits = 6755399441055744.0;

DL_INLINE double shift_of(const dl_box *box, int c, double d) {
    return box->length[c] * ((d * box->inverse[c] + whole_digits) - whole_digits);
}

DL_INLINE vector shifts_of(const dl_box *box, int c, vector d) {
    return box->length[c] * ((d * box->inverse[c] + whole_digits) - whole_digits);
}

/* make(name, dimension, coupled, periodic, ...), in the order of dl_loop_form. */
#define DL_FORMS(make, ...)                                                                        \
    make(flat, 2, false, false, __VA_ARGS__) make(solid, 3, false, false, __VA_ARGS__)             \
        make(flat_coupled, 2, true, false, __VA_ARGS__)                                            \
            make(solid_coupled, 3, true, false, __VA_ARGS__)                                       \
                make(flat_periodic, 2, false, true, __VA_ARGS__)                                   \
                    make(solid_periodic, 3, false, true, __VA_ARGS__)                              \
                        make(flat_coupled_periodic, 2, true, true, __VA_ARGS__)                    \
                            make(solid_coupled_periodic, 3, true, true, __VA_ARGS__)

#endif
