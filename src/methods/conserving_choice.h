/* Which solver a conserving method takes, and why. */
#ifndef DL_METHODS_CONSERVING_CHOICE_H
#define DL_METHODS_CONSERVING_CHOICE_H

#include "methods/conserving.h"
#include "methods/conserving_state.h"

typedef struct dl_conserving_choice {
    dl_conserving_settings solver;
    bool has_rescue;
    dl_conserving_settings rescue;
    char reason[200]; /* in words, the solver's name first; "" where row and options say it all */
} dl_conserving_choice;

/* By the row and the options or, where these leave it open, by how strongly the fixed-point
 * iteration contracts at the method's state, by the number of unknowns and by the force kernel. */
dl_status dl_conserving_choose(const dl_method *method, const dl_conserving_state *state,
                               dl_conserving_choice *choice, dl_error *error);

#endif
